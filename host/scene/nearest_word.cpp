#include "scene/nearest_word.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace viewpeel {
namespace {

// Returns how many letters have to be inserted, deleted or changed (V. Levenshtein, Binary codes capable of correcting
// deletions, insertions, and reversals, 1966). The letters - and _ count as equal.
size_t distanceOf(const std::string& a, const std::string& b) {
  const auto areSame = [](char x, char y) { return x == y || (x == '-' && y == '_') || (x == '_' && y == '-'); };
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i + 1);
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t changed = diagonal + (areSame(a[i], b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearestWord(const std::string& given, const std::vector<std::string>& words) {
  std::optional<std::string> nearest;
  size_t least = given.size() / 3 + 1;
  for (const std::string& word : words) {
    const size_t distance = given.size() > 3 && word.starts_with(given) ? 1 : distanceOf(given, word);
    if (distance >= least) continue;
    least = distance;
    nearest = word;
  }
  return nearest;
}

}  // namespace viewpeel
