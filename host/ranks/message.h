// Messages between ranks are plain bytes: numbers as they are in memory, lists after their length. All ranks run the
// same build on machines of one kind.
#pragma once
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <viewpeel/error.h>

namespace viewpeel {

class MessageWriter {
 public:
  template <class T>
  MessageWriter& put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  template <class T>
  MessageWriter& putAll(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(uint64_t(values.size()));
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    return *this;
  }
  template <class T>
  MessageWriter& putAll(const std::vector<T>& values) {
    return putAll(std::span<const T>(values));
  }
  MessageWriter& putAll(const std::string& text) { return putAll(std::span<const char>(text)); }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Reads what a MessageWriter has put, in the same order.    Throws: Error limit where the message ends too early.
class MessageReader {
 public:
  explicit MessageReader(const std::string& bytes, size_t at = 0) : bytes_(bytes), at_(at) {}

  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, take(sizeof value), sizeof value);
    return value;
  }
  template <class T>
  std::vector<T> getAll() {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto count = get<uint64_t>();
    if (count > (bytes_.size() - at_) / sizeof(T)) fail();
    std::vector<T> values(count);
    const char* from = take(count * sizeof(T));
    if (count) std::memcpy(values.data(), from, count * sizeof(T));
    return values;
  }
  std::string getText() {
    const std::vector<char> text = getAll<char>();
    return {text.begin(), text.end()};
  }

 private:
  [[noreturn]] static void fail() {
    throw Error(ErrorCode::limit, "a message between ranks is too short; do all ranks run the same build of viewpeel?");
  }
  const char* take(size_t size) {
    if (size > bytes_.size() - at_) fail();
    const char* from = bytes_.data() + at_;
    at_ += size;
    return from;
  }

  const std::string& bytes_;
  size_t at_;
};

}  // namespace viewpeel
