#include "io/check_sum.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

namespace viewpeel {
namespace {

static_assert(std::endian::native == std::endian::little, "check sums are of little-endian words");
constexpr size_t kBytesAtOnce = 1 << 20;  // bytes read at a time, a multiple of 8

}  // namespace

void CheckSum::add(const char* bytes, size_t count) {
  for (size_t at = 0; at < count; at += kCheckSumBytes) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + at, std::min(kCheckSumBytes, count - at));
    hash_.add(word);
  }
}

std::array<char, kCheckSumBytes> CheckSum::bytes() const {
  return std::bit_cast<std::array<char, kCheckSumBytes>>(hash_.value());
}

bool endsInCheckSum(std::istream& file, uint64_t size) {
  if (size < kCheckSumBytes) return false;
  CheckSum sum;
  std::vector<char> block(kBytesAtOnce);
  for (uint64_t left = size - kCheckSumBytes; left > 0;) {
    const size_t count = std::min<uint64_t>(left, block.size());
    if (!file.read(block.data(), static_cast<std::streamsize>(count))) return false;
    sum.add(block.data(), count);
    left -= count;
  }
  std::array<char, kCheckSumBytes> found;
  return file.read(found.data(), found.size()) && found == sum.bytes();
}

}  // namespace viewpeel
