#include "rays/ray_bundle.h"

namespace viewpeel {
namespace {

constexpr uint32_t kMostBits = 5;  // of a cell's place along each of its two numbers

// Returns a number's five lowest bits with a 0 after each, counted from the lowest.
constexpr uint32_t spread(uint32_t bits) {
  uint32_t places = 0;
  for (uint32_t k = 0; k < kMostBits; ++k) places |= (bits >> k & 1) << 2 * k;
  return places;
}
constexpr auto kSpread = [] {
  std::array<uint32_t, 1 << kMostBits> table{};
  for (uint32_t k = 0; k < table.size(); ++k) table[k] = spread(k);
  return table;
}();

}  // namespace

void RayBundle::Drawn::fit(uint32_t rays) {
  const size_t whole = size_t{rays} + kLineLanes;
  if (blocks.size() >= whole) return;
  for (std::vector<float>& of_rays : numbers) of_rays.resize(2 * whole);
  blocks.resize(2 * whole);
}

// Sorts by cell, along a Z curve of the first two numbers, which give the direction. There are some one to four rays in
// a cell, or more where there are the most cells.
void RayBundle::sort() {
  uint32_t bits = 0;
  while (bits < kMostBits && 4u << 2 * bits <= size_) ++bits;
  const auto side = static_cast<float>(1u << bits);
  ends_.assign((size_t{1} << 2 * bits) + 1, 0);
  cells_.resize(size_);
  for (uint32_t ray = 0; ray < size_; ++ray) {
    const auto height = static_cast<uint32_t>(side * drawn_.numbers[0][ray]),
               turn = static_cast<uint32_t>(side * drawn_.numbers[1][ray]);
    cells_[ray] = kSpread[height] | kSpread[turn] << 1;
    ++ends_[cells_[ray] + 1];
  }
  for (size_t cell = 1; cell < ends_.size(); ++cell) ends_[cell] += ends_[cell - 1];
  sorted_.fit(size_);
  for (uint32_t ray = 0; ray < size_; ++ray) {
    const uint32_t at = ends_[cells_[ray]]++;
    for (int d = 0; d < kNumbers; ++d) sorted_.numbers[d][at] = drawn_.numbers[d][ray];
    sorted_.blocks[at] = drawn_.blocks[ray];
  }
}

void RayBundle::clear() { size_ = 0; }

}  // namespace viewpeel
