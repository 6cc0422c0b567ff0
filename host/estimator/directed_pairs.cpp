#include "estimator/directed_pairs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <set>
#include <utility>

#include "engines/lattice.h"
#include "engines/size_groups.h"
#include "hash.h"

namespace viewpeel {
namespace {

using Key = std::pair<uint32_t, uint32_t>;

}  // namespace

PairSampler::PairSampler(const Scene& scene, const Ids& face_ids, uint64_t seed, EngineFactory make_engine,
                         LatticeOptions lattice, int finest)
    : scene_(scene),
      face_ids_(face_ids),
      seed_(seed),
      make_engine_(std::move(make_engine)),
      lattice_(std::move(lattice)),
      finest_(std::min(finest, maxWindowResolution(lattice_.sampling))),
      polygons_(face_ids.count()) {
  for (uint32_t k = 0; k < face_ids.of_polygon.size(); ++k) polygons_[face_ids.of_polygon[k]].push_back(k);
}

const DirectionRegion& PairSampler::regionOf(Key pair) {
  const auto [at, is_new] = regions_.try_emplace(pair);
  if (is_new) at->second = findPairRegion(scene_, polygons_[pair.first], polygons_[pair.second], face_ids_.two_sided);
  return at->second;
}

DirectedPair PairSampler::direct(uint32_t i, uint32_t j, uint32_t directions) {
  if (scene_.coincidences.alike_unordered > 0 || regionOf({i, j}).isEmpty()) return {i, j};
  const std::vector<uint32_t>& emitter = polygons_[emitterOf(i, j)];
  double area = 0;
  for (uint32_t k : emitter) area += scene_.polygons[k].area;
  const double finest = std::min<double>(kMostWindowPoints / windowAround(scene_, emitter).radius, finest_);
  return {i, j, directions, static_cast<uint32_t>(std::clamp(2 * kEmitterSpacings / std::sqrt(area), 1.0, finest))};
}

size_t PairSampler::countEngines(std::span<const DirectedPair> pairs) const {
  std::set<Key> keys;
  for (const DirectedPair& pair : pairs) keys.insert(partKey(pair));
  return keys.size();
}

void PairSampler::prepare(std::span<DirectedPair> pairs) {
  std::map<Key, std::vector<uint32_t>> partners;
  for (const DirectedPair& pair : pairs)
    partners[partKey(pair)].push_back(emitterOf(pair.i, pair.j) == pair.i ? pair.j : pair.i);
  for (auto& [key, others] : partners) {
    std::sort(others.begin(), others.end());
    Part& part = parts_[key];
    std::vector<uint32_t> all;
    std::set_union(part.partners.begin(), part.partners.end(), others.begin(), others.end(), std::back_inserter(all));
    if (part.engine && all == part.partners) continue;
    part.engine.reset();
    part.partners = std::move(all);
    part.ids = idsOf(key.first, part.partners);
    LatticeOptions pair_lattice = lattice_;
    pair_lattice.resolution = static_cast<int>(key.second);
    pair_lattice.window = windowAround(scene_, polygons_[key.first]);
    pair_lattice.count_blocked = true;
    part.engine = make_engine_(scene_, part.ids, pair_lattice);
  }
  for (DirectedPair& pair : pairs) {
    const Engine& engine = *parts_.at(partKey(pair)).engine;
    pair.line = std::max(
        1u, static_cast<uint32_t>(std::lround(pointArea(static_cast<int>(pair.resolution)) / engine.unitArea())));
    pair.count_area = engine.unitArea() * scene_.scale * scene_.scale;
    pair.measure_area =
        pair.count_area * regionOf({pair.i, pair.j}).solidAngle() / (2 * std::numbers::pi) / pair.directions;
  }
}

// Returns an id for each face: 0 for the emitter, numbers from 1 on for its partners, and a last one for all obstacles
// together.
Ids PairSampler::idsOf(uint32_t emitter, const std::vector<uint32_t>& partners) const {
  Ids ids;
  ids.two_sided = face_ids_.two_sided;
  ids.counts_environment = false;
  const auto rest = static_cast<uint32_t>(partners.size() + 1);
  ids.of_polygon.assign(scene_.polygons.size(), rest);
  ids.roles.assign(scene_.polygons.size(), 0);
  ids.requested.assign(rest + 1, true);
  ids.requested.back() = false;
  const auto give = [&](uint32_t face, uint32_t id, uint32_t role) {
    for (uint32_t k : polygons_[face]) ids.of_polygon[k] = id, ids.roles[k] = role;
    ids.names.push_back(face_ids_.names[face]);
    ids.areas.push_back(face_ids_.areas[face]);
    ids.surface.push_back(id);
  };
  give(emitter, 0, kEmits);
  for (uint32_t id = 1; id < rest; ++id) give(partners[id - 1], id, kReceives);
  ids.names.push_back("rest");
  ids.areas.push_back(1);
  ids.surface.push_back(rest);
  return ids;
}

PairCount PairSampler::count(const DirectedPair& pair, uint64_t replicate) {
  const Part& part = parts_.at(partKey(pair));
  const uint32_t partner = emitterOf(pair.i, pair.j) == pair.i ? pair.j : pair.i;
  const auto id = static_cast<uint32_t>(std::lower_bound(part.partners.begin(), part.partners.end(), partner) -
                                        part.partners.begin() + 1);
  Hash stream;
  stream.add(seed_);
  stream.add(pair.i);
  stream.add(pair.j);
  PairCount sum{pair.i, pair.j, 0, 0};
  for (const PairCount& count : part.engine->count(
           sampleRegion(regionOf({pair.i, pair.j}), pair.directions, stream.value(), replicate).directions))
    if (count.i == 0 && count.j == id) sum.add(count);
  return sum;
}

PairCounts PairSampler::count(std::span<const DirectedPair> pairs, uint64_t replicate) {
  PairCounts counts;
  for (const DirectedPair& pair : pairs) {
    counts.push_back(count(pair, replicate));
    if (counts.back().count == 0 && counts.back().blocked == 0) counts.pop_back();
  }
  return counts;
}

}  // namespace viewpeel
