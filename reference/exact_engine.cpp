#include "reference/exact_engine.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "error.h"
#include "reference/exact_pair_areas.h"

namespace viewpeel::reference {
namespace {

__extension__ using Wide = unsigned __int128;
constexpr double kUnit = 0x1p-40;
constexpr Wide kMostCounts = UINT64_MAX;
constexpr size_t kDirectionsAtOnce = 64;  // bounds the memory of their results

class ExactEngine : public Engine {
 public:
  ExactEngine(const Scene& scene, const Ids& ids, const ExactOptions& options)
      : scene_(scene), ids_(ids) {
    requireDisjoint(scene);
    options_.two_sided = ids.two_sided;
    options_.thread_count = options.thread_count;
    options_.on_direction = options.on_direction;
  }

  PairCounts count(std::span<const Direction> directions) override {
    std::map<std::pair<uint32_t, uint32_t>, Wide> sums;
    for (size_t done = 0; done < directions.size(); done += kDirectionsAtOnce) {
      std::vector<glm::dvec3> along;
      for (size_t k = done; k < std::min(directions.size(), done + kDirectionsAtOnce); ++k) along.push_back(directions[k].u);
      const std::vector<ExactPairAreas> results = computeExactPairAreas(scene_, along, options_);
      for (size_t k = 0; k < results.size(); ++k)
        for (const PairArea& pair : results[k].pairs) {
          if (!isCounted(pair)) continue;
          const uint32_t i = ids_.of_polygon[pair.a], j = pair.b < kEnvironment ? ids_.of_polygon[pair.b] : pair.b;
          sums[{std::min(i, j), std::max(i, j)}] += Wide(std::llround(pair.area / kUnit)) * directions[done + k].weight;
        }
    }
    PairCounts counts;
    for (const auto& [key, sum] : sums)
      if (sum > kMostCounts) throw Error(ErrorCode::limit, "areas of so many weighted directions pass 64 bits; ask for fewer --directions and more --replicates");
      else if (sum) counts.push_back({key.first, key.second, static_cast<uint64_t>(sum)});
    return counts;
  }

  double unitArea() const override { return kUnit; }

 private:
  bool isCounted(const PairArea& pair) const {
    const uint32_t a = ids_.rolesOf(pair.a);
    if (pair.b >= kEnvironment) return (a & kEmits) && ids_.counts_environment;
    const uint32_t b = ids_.rolesOf(pair.b);
    return ((a & kEmits) && (b & kReceives)) || ((b & kEmits) && (a & kReceives));
  }

  const Scene& scene_;
  const Ids& ids_;
  ExactOptions options_;
};

}  // namespace

std::unique_ptr<Engine> makeExactEngine(const Scene& scene, const Ids& ids, const ExactOptions& options) {
  return std::make_unique<ExactEngine>(scene, ids, options);
}

}  // namespace viewpeel::reference
