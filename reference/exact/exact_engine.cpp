#include "reference/exact/exact_engine.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engines/lattice_options.h"
#include <viewpeel/error.h>
#include "reference/exact/exact_pair_areas.h"

namespace viewpeel::reference {
namespace {

__extension__ using Wide = unsigned __int128;
constexpr double kUnit = 0x1p-40;
constexpr Wide kMostCounts = UINT64_MAX;
constexpr size_t kDirectionsAtOnce = 64;  // bounds the memory for results

class ExactEngine : public Engine {
 public:
  ExactEngine(const Scene& scene, const Ids& ids, const ExactOptions& options) : scene_(scene), ids_(ids) {
    requireDisjoint(scene);
    options_.two_sided = ids.two_sided;
    options_.thread_count = options.thread_count;
    options_.on_direction = options.on_direction;
    options_.blocked = options.blocked;
  }

  PairCounts count(std::span<const Direction> directions) override {
    Sums sums;
    for (size_t done = 0; done < directions.size(); done += kDirectionsAtOnce) {
      std::vector<glm::dvec3> along;
      for (size_t k = done; k < std::min(directions.size(), done + kDirectionsAtOnce); ++k)
        along.push_back(directions[k].u);
      const std::vector<ExactPairAreas> results = computeExactPairAreas(scene_, along, options_);
      for (size_t k = 0; k < results.size(); ++k) {
        const uint32_t weight = directions[done + k].weight;
        for (const PairArea& pair : results[k].pairs) add(pair, weight, sums, &Sum::facing);
        for (const PairArea& pair : results[k].blocked) add(pair, weight, sums, &Sum::blocked);
      }
    }
    PairCounts counts;
    for (const auto& [key, sum] : sums)
      if (std::max(sum.facing, sum.blocked) > kMostCounts)
        throw Error(
            ErrorCode::limit,
            "areas of so many weighted directions pass 64 bits; ask for fewer --directions and more --replicates");
      else if (sum.facing || sum.blocked)
        counts.push_back(
            {key.first, key.second, static_cast<uint64_t>(sum.facing), static_cast<uint64_t>(sum.blocked)});
    return counts;
  }

  double unitArea() const override { return kUnit; }

 private:
  struct Sum {
    Wide facing = 0, blocked = 0;
  };
  using Sums = std::map<std::pair<uint32_t, uint32_t>, Sum>;

  void add(const PairArea& pair, uint32_t weight, Sums& sums, Wide Sum::*kind) const {
    if (!isCounted(pair)) return;
    const uint32_t i = ids_.of_polygon[pair.a], j = pair.b < kEnvironment ? ids_.of_polygon[pair.b] : pair.b;
    sums[{std::min(i, j), std::max(i, j)}].*kind += Wide(std::llround(pair.area / kUnit)) * weight;
  }

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

EngineFactory exactEngines() {
  return [](const Scene& scene, const Ids& ids, const LatticeOptions& options) {
    return makeExactEngine(
        scene, ids,
        {.blocked = options.count_blocked, .thread_count = options.thread_count, .on_direction = options.stop});
  };
}

}  // namespace viewpeel::reference
