// This file chooses the pairs that get directions of their own, because the run then ends sooner. Pilots of each pair
// say how many directions it needs.
#include "estimator/directed_pairs.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "directions/replicates.h"
#include "estimator/estimate.h"
#include "estimator/find_prior.h"
#include "sums/add_pairs.h"
#include "sums/pair_count.h"
#include "sums/pair_walk.h"

namespace viewpeel {
namespace {

constexpr uint32_t kPilots = 8, kPilotDirections = 16, kUsualDirections = 32;
// The unit of work is the time that one polygon takes at one lattice point, some 10 ns. Costs were measured on lavapipe
// and are used on every device, so that parts of a run on different devices choose alike.
// The costs are of projecting a polygon along a common direction, and along a direction of a directed pair.
constexpr double kPolygonCost = 100, kDirectedPolygonCost = 30;
constexpr double kPointCost = 4;  // of a lattice point, where blocked pairs are counted, too
constexpr double kDirectionCost = 2000, kEngineCost = 2e7;
constexpr double kDearest = 8;  // most directions of a pair, as a multiple of the common ones
// A pair's visibility counts as unsure where fewer directions than this are expected to hit the pair. Where three are
// expected, none hits it in e^-3 = 5 % of cases.
constexpr double kFewDirections = 3;
constexpr int64_t kMostOnTrust = 8;                       // with more pairs on trust (Need), none of them is directed
constexpr size_t kMostDirected = 256, kMostEngines = 32;  // each engine takes memory and compiles its kernels
constexpr double kWorthIt = 0.8;                          // directed pairs must bring the work down to this share
constexpr double kManyReplicates = 1e12;

using Key = std::pair<uint32_t, uint32_t>;

double smallerArea(const Ids& ids, Key pair) {
  return std::min(ids.areas[pair.first], pair.second < kEnvironment ? ids.areas[pair.second] : INFINITY);
}

// Returns the standard error that the goals allow a pair's exchange area; infinite where no goal concerns the pair.
double allowedError(const EstimateOptions& options, double area, double exchange) {
  double allowed = options.tolerance ? *options.tolerance * area : INFINITY;
  if (options.relative && exchange >= options.relative_floor * area)
    allowed = std::min(allowed, *options.relative * exchange);
  return allowed;
}

// A Need is a pair that does not reach the goal in the request's replicates.
struct Need {
  Key pair;
  double replicates = 0;  // number that the pair needs
  double allowed = 0, most = INFINITY;
  bool may_direct = false;
  // Few lines hit the pair, and none was blocked at either face.
  bool on_trust = false;
};

struct PredictedError {
  double variance = 0;  // of the exchange area in one replicate
  double line = 0;      // error of one line in one replicate
  double most = INFINITY, area = 0, directions = 0;
  bool has_variance = false;  // whether a line counted

  double after(double replicates) const {
    double floor = line / replicates;
    if (!has_variance && most < INFINITY)
      floor = std::max(floor, most * std::exp(-replicates * directions * most / (2 * area)));
    return std::min(most, std::sqrt(variance / replicates + floor * floor));
  }
};

// PairPilotVariances holds the variance of each pair's exchange area over the pilots. Pairs are looked up in rising
// order.
class PairPilotVariances {
 public:
  // Each half of the pilots uses the visibilities of the other half. With visibilities from the same half, a pair of
  // few lines would seem better known than it is.
  PairPilotVariances(const Ids& ids, const Prior& prior, const CommonPilots& pilots) {
    const size_t half = pilots.counts.size() / 2;
    for (const bool second : {false, true}) {
      PairCounts others;
      for (size_t k = 0; k < half; ++k) others = addCounts(others, pilots.counts[second ? k : half + k]);
      const std::vector<PairVisibility> fitted = fitVisibilities(others);
      std::vector<PairVisibility> visibilities;
      PairWalk walk(fitted);
      for (const PairPrior& pair : prior.pairs) {
        const PairVisibility* const of_pair = walk.find(pair);
        if (pair.visibility == kVisibilityOne) visibilities.push_back({pair.i, pair.j, kVisibilityOne});
        else if (pair.visibility && of_pair) visibilities.push_back(*of_pair);
      }
      ControlVariateSums sums(ids);
      for (size_t k = 0; k < half; ++k)
        sums.add(takeControlVariates(pilots.counts[second ? half + k : k], visibilities, prior.lines));
      sums.forEachVariance(pilots.count_area / pilots.directions, [&](uint32_t i, uint32_t j, double variance) {
        of_half_[second].push_back({{i, j}, variance});
      });
    }
  }
  // Returns a pair's variance; nothing where no line hit the pair. Pairs must come in rising order.
  std::optional<double> of(Key pair) {
    double sum = 0;
    bool has_variance = false;
    for (int half = 0; half < 2; ++half) {
      size_t& at = at_[half];
      while (at < of_half_[half].size() && of_half_[half][at].first < pair) ++at;
      if (at == of_half_[half].size() || of_half_[half][at].first != pair) continue;
      has_variance = true;
      sum += of_half_[half][at].second / 2;
    }
    return has_variance ? std::optional(sum) : std::nullopt;
  }

 private:
  std::vector<std::pair<Key, double>> of_half_[2];
  size_t at_[2] = {0, 0};
};

// Returns the needs in order: the pair that needs the most replicates comes first.
std::vector<Need> findNeeds(const Ids& ids, const Prior& prior, const CommonPilots& pilots,
                            const EstimateOptions& options) {
  PairCounts all;
  for (const PairCounts& counts : pilots.counts) all = addCounts(all, counts);
  std::vector<bool> is_blocked(ids.count(), false);
  for (const PairCount& count : all)
    if (count.j < kEnvironment && count.blocked) is_blocked[count.i] = is_blocked[count.j] = true;
  PairPilotVariances variances(ids, prior, pilots);
  const double pilot_count = double(pilots.counts.size()), directions = options.directions,
               line = 2 * pilots.count_area / directions;
  std::vector<Need> needs;
  const auto look = [&](Key pair, const PairPrior* pair_prior, uint64_t count) {
    const double area = smallerArea(ids, pair);
    PredictedError error{0, line, INFINITY, area, directions};
    const bool is_pair = pair.second < kEnvironment;
    error.line *=
        double(is_pair ? std::min(prior.lines[pair.first], prior.lines[pair.second]) : prior.lines[pair.first]);
    if (pair_prior && is_pair && pair_prior->exchange < INFINITY) error.most = std::min(pair_prior->exchange, area);
    const std::optional<double> variance = variances.of(pair);
    // The pilots' variance becomes the variance of one replicate, which has another number of directions.
    error.variance = variance.value_or(0) * pilots.directions / directions;
    error.has_variance = variance.has_value();
    const bool may_direct = is_pair && error.most < INFINITY;
    double exchange = 2 * double(count) * pilots.count_area / (pilots.directions * pilot_count);
    if (may_direct) exchange = std::max(exchange, error.most * pair_prior->visibility / kVisibilityOne);
    PredictedError unsure = error;
    // It proves little if a few directions agree that nothing blocks the pair. About `expected_directions` hit it, and
    // its true visibility may be one half.
    if (const double expected_directions = directions * error.most / (2 * area);
        may_direct && expected_directions < kFewDirections &&
        error.most * error.most / (4 * expected_directions) > error.variance) {
      unsure.variance = error.most * error.most / (4 * expected_directions);
      exchange = std::max(exchange, error.most / 2);
    }
    const double allowed = allowedError(options, area, exchange);
    if (unsure.after(options.replicates) <= allowed) return;
    const bool on_trust =
        is_pair && !is_blocked[pair.first] && !is_blocked[pair.second] && error.after(options.replicates) <= allowed;
    double replicates = options.replicates;
    while (unsure.after(replicates) > allowed && replicates < kManyReplicates) replicates *= std::sqrt(std::sqrt(2.0));
    needs.push_back({pair, replicates, allowed, error.most, may_direct, on_trust});
  };
  auto count = all.begin();
  auto at = prior.pairs.begin();
  while (count != all.end() || at != prior.pairs.end()) {
    const Key key = count == all.end()        ? keyOf(*at)
                    : at == prior.pairs.end() ? keyOf(*count)
                                              : std::min(keyOf(*at), keyOf(*count));
    const bool is_counted = count != all.end() && keyOf(*count) == key,
               has_prior = at != prior.pairs.end() && keyOf(*at) == key;
    if (key.first != key.second) look(key, has_prior ? &*at : nullptr, is_counted ? count->count : 0);
    if (is_counted) ++count;
    if (has_prior) ++at;
  }
  // A pair is on trust where few lines hit it, and none was blocked at either face. It most likely reaches the goal, so
  // such pairs are needs only where they are few.
  if (std::count_if(needs.begin(), needs.end(), [](const Need& need) { return need.on_trust; }) > kMostOnTrust)
    std::erase_if(needs, [](const Need& need) { return need.on_trust; });
  std::sort(needs.begin(), needs.end(), [](const Need& a, const Need& b) {
    return std::pair(-a.replicates, a.pair) < std::pair(-b.replicates, b.pair);
  });
  return needs;
}

// RunWork predicts the work of runs in which the first pairs of `needs` are directed pairs.
class RunWork {
 public:
  RunWork(const PairSampler& sampler, const std::vector<Need>& needs, const Ids& ids, const Prior& prior,
          const CommonPilots& pilots, const EstimateOptions& options)
      : sampler_(sampler), needs_(needs), options_(options) {
    const double polygons = double(ids.of_polygon.size());
    // The number of lattice points on all faces along one direction. A face's mean projection is half its area.
    double points = 0;
    for (uint32_t k = 0; k < ids.count(); ++k)
      points += ids.areas[k] / (2 * pilots.count_area * double(prior.lines[k]));
    common_ = kDirectionCost + kPolygonCost * polygons + kPointCost * points;
    directed_ = kDirectionCost + kDirectedPolygonCost * polygons + kPointCost * kEmitterSpacings * kEmitterSpacings;
  }

  // Returns the first pairs of `directed` that give the least work, in the order of needs. It returns none where this
  // saves too little.
  std::vector<DirectedPair> keepLeast(const std::vector<DirectedPair>& directed) const {
    std::vector<DirectedPair> tried, best;
    const double without = of({});
    double least = kWorthIt * without;
    for (const DirectedPair& pair : directed) {
      tried.push_back(pair);
      if (const double work = of(tried); work < least) best = tried, least = work;
    }
    return best;
  }

 private:
  double of(const std::vector<DirectedPair>& directed) const {
    double directions = 0;
    for (const DirectedPair& pair : directed) directions += pair.directions;
    const double replicates =
        directed.size() < needs_.size() ? needs_[directed.size()].replicates : options_.replicates;
    return replicates * (options_.directions * common_ + directions * directed_) +
           kEngineCost * double(sampler_.countEngines(directed)) +
           kPilots * kPilotDirections * directed_ * double(directed.size());
  }

  const PairSampler& sampler_;
  const std::vector<Need>& needs_;
  const EstimateOptions& options_;
  double common_ = 0, directed_ = 0;  // of one direction
};

// Returns the pair with its visibility and as many directions as it needs; with 0 directions where directions of its
// own gain nothing.
DirectedPair fit(PairSampler& sampler, const Ids& ids, const Need& need, DirectedPair pair,
                 const EstimateOptions& options) {
  pair.directions = kPilotDirections;
  sampler.prepare({&pair, 1});
  std::vector<PairCounts> counts;
  PairCounts halves[2];
  for (uint32_t k = 0; k < kPilots; ++k) {
    const PairCount count = sampler.count(pair, kDirectedReplicates.first + k);
    counts.push_back(count.count || count.blocked ? PairCounts{count} : PairCounts{});
    PairCounts& half = halves[2 * k / kPilots];
    half = addCounts(half, counts.back());
  }
  const auto visibilityOf = [](const PairCounts& fitted) {
    const std::vector<PairVisibility> visibilities = fitVisibilities(fitted);
    return visibilities.empty() ? 0 : visibilities[0].visibility;
  };
  // Each half of the pilots uses the visibility of the other half, or none.
  const auto errorWith = [&](bool has_visibility) {
    double squares = 0;
    for (const bool second : {false, true}) {
      pair.visibility = has_visibility ? visibilityOf(halves[!second]) : 0;
      ControlVariateSums sums(ids);
      for (uint32_t k = 0; k < kPilots / 2; ++k)
        sums.add(takeDirectedControlVariates(counts[(second ? kPilots / 2 : 0) + k], std::vector{pair}));
      const PriorExchange prior{pair.i, pair.j, need.most * pair.visibility / kVisibilityOne, need.most, pair.line};
      squares += std::pow(sums.exchangeArea(pair.measure_area, prior, pair.count_area).standard_error / 2, 2);
    }
    return std::sqrt(squares);
  };
  const double without = errorWith(false), with = errorWith(true);
  pair.visibility = with <= without ? visibilityOf(addCounts(halves[0], halves[1])) : 0;
  // The pair gets directions for half of the allowed error, because pilots' errors differ from the run's. It also gets
  // so many that a single direction adds no more than this error.
  const double goal = need.allowed / 2;
  const double directions =
      std::max(kPilots * kPilotDirections * std::pow(std::min(with, without) / goal, 2), need.most / goal) /
      options.replicates;
  pair.directions = directions > options.directions * kDearest
                        ? 0
                        : std::max(kPilotDirections, static_cast<uint32_t>(std::ceil(directions)));
  return pair;
}

}  // namespace

std::vector<DirectedPair> chooseDirectedPairs(PairSampler& sampler, const Ids& face_ids, const Prior& prior,
                                              const CommonPilots& pilots, const EstimateOptions& options) {
  if (!options.tolerance && !options.relative) return {};
  const std::vector<Need> needs = findNeeds(face_ids, prior, pilots, options);
  std::vector<DirectedPair> tried;
  for (const Need& need : needs) {
    if (!need.may_direct || tried.size() == kMostDirected) break;
    const DirectedPair pair = sampler.direct(need.pair.first, need.pair.second, kUsualDirections);
    if (pair.directions == 0) break;
    tried.push_back(pair);
    if (sampler.countEngines(tried) <= kMostEngines) continue;
    tried.pop_back();
    break;
  }
  const RunWork work(sampler, needs, face_ids, prior, pilots, options);
  tried = work.keepLeast(tried);
  sampler.prepare(tried);
  for (size_t k = 0; k < tried.size(); ++k) {
    tried[k] = fit(sampler, face_ids, needs[k], tried[k], options);
    if (tried[k].directions == 0) tried.resize(k);
  }
  tried = work.keepLeast(tried);
  std::sort(tried.begin(), tried.end(),
            [](const DirectedPair& a, const DirectedPair& b) { return keyOf(a) < keyOf(b); });
  sampler.prepare(tried);
  return tried;
}

}  // namespace viewpeel
