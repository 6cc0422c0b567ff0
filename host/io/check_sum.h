// A CheckSum stands at the end of each HDF5 file that viewpeel writes, for all bytes before it. HDF5 may crash on
// damaged files, so readers verify the check sum first.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <istream>

#include "hash.h"

namespace viewpeel {

constexpr size_t kCheckSumBytes = sizeof(uint64_t);

// CheckSum computes the check sum of bytes: a Hash of words of 8 bytes, the last word filled up with zeros.
class CheckSum {
 public:
  // Adds bytes.    In: count: a multiple of 8 in all calls but the last
  void add(const char* bytes, size_t count);
  // Returns the check sum, as it stands at the end of a file.
  std::array<char, kCheckSumBytes> bytes() const;

 private:
  Hash hash_;
};

// Returns whether the next `size` bytes of a file end in the check sum of the bytes before it.
bool endsInCheckSum(std::istream& file, uint64_t size);

}  // namespace viewpeel
