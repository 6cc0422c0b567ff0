// The arrays of a page are blocks of text that the page decodes when it needs them.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace viewpeel {

// PageBlocks packs arrays. The bytes of an array are shuffled (all first bytes, then all second bytes), deflated as
// zlib does, and written in base64. zlib's check sum tells the page of damage.
class PageBlocks {
 public:
  // Adds an array of uint8_t, int32_t, float or double.
  template <class T>
  void add(const std::string& name, const std::vector<T>& values);
  // Adds an array of texts, one after the other, each ended by a byte 0. A byte 0 within a text is left out.
  void addTexts(const std::string& name, const std::vector<std::string>& texts);

  // Returns the list of arrays as JSON: [{"name", "type", "count"}, ...], block k being the k-th.
  std::string list() const;
  // Returns elements of HTML that hold the blocks, without any text of a file.
  std::string elements() const;
  size_t sizeBytes() const { return size_bytes_; }

 private:
  void addBytes(const std::string& name, const char* type, size_t count, size_t width, const uint8_t* bytes);

  std::string list_;
  std::vector<std::string> blocks_;
  size_t size_bytes_ = 0;
};

}  // namespace viewpeel
