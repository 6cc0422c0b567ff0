// putBytes() writes numbers as other programs store them in memory: their bytes, little-endian.
#pragma once
#include <bit>
#include <ostream>
#include <type_traits>

namespace viewpeel {

static_assert(std::endian::native == std::endian::little, "records are little-endian");

// Writes the bytes of a number.
template <class T>
requires std::is_arithmetic_v<T>
void putBytes(std::ostream& out, T value) { out.write(reinterpret_cast<const char*>(&value), sizeof value); }

}  // namespace viewpeel
