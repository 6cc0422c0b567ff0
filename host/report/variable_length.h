// A whole number takes one byte for each 7 bits, the lowest first. A byte's highest bit says that another byte follows.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace viewpeel {

inline size_t variableLength(uint32_t number) {
  size_t bytes = 1;
  for (; number >= 128; number >>= 7) ++bytes;
  return bytes;
}

inline void addVariableLength(uint32_t number, std::vector<uint8_t>& bytes) {
  for (; number >= 128; number >>= 7) bytes.push_back(static_cast<uint8_t>(number | 128));
  bytes.push_back(static_cast<uint8_t>(number));
}

}  // namespace viewpeel
