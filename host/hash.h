// Hash is a 64-bit hash for fingerprints of scenes and for tables of corners.
#pragma once
#include <bit>
#include <concepts>
#include <cstdint>
#include <string>

namespace viewpeel {

// Hash depends on all added values and their order. Two inputs that differ by accident have equal hashes with
// probability 2^-64, and never if they differ in a single number. It does not withstand attacks.
class Hash {
 public:
  template <std::unsigned_integral T>
  void add(T number) {
    value_ = (value_ ^ number) *
             0x9E3779B97F4A7C15u;  // odd, so every step is invertible and different numbers stay different
    value_ ^= value_ >> 32;
  }
  void add(double number) { add(std::bit_cast<uint64_t>(number)); }
  void add(const std::string& text) {
    add(text.size());
    for (char c : text) add(static_cast<unsigned char>(c));
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0x243F6A8885A308D3u;  // the first bits of pi - 3
};

}  // namespace viewpeel
