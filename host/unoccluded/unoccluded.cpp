// A chunk of pairs goes through these passes, in order:
//   classify   finds the pairs that can see each other, and the rule of each
//   far        integrates far pairs by product Gauss rules, in one dispatch for each number of points
// Then the near pairs go through these passes, some of them at a time:
//   edges      finds the edges of the two parts that see each other, and a rule for each pair of edges
//   line       integrates over pairs of edges, in one dispatch for each rule
//   sum        adds the integrals up
// Near pairs whose bound on the error is too large go through the last three again, with more points.
#include "unoccluded/unoccluded.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include <fmt/format.h>
#include <glm/vec2.hpp>

#include "unoccluded/far_rules.h"
#include "unoccluded/host_unoccluded.h"
#include "unoccluded/line_rules.h"
#include "unoccluded/shapes.h"
#include "unoccluded/shared.h"
#include <viewpeel/error.h>
#include "shaders/unoccluded_classify.comp.h"
#include "shaders/unoccluded_edges.comp.h"
#include "shaders/unoccluded_far.comp.h"
#include "shaders/unoccluded_line.comp.h"
#include "shaders/unoccluded_sum.comp.h"
#include "vulkan/commands.h"
#include "vulkan/timestamps.h"

namespace viewpeel {
namespace {

using namespace unoccluded_data;

const std::array<const char*, 1 + kFarRules> kChunkPasses = {"classify", "far 2", "far 3", "far 4", "far 5", "far 6"};
const std::array<const char*, 3> kNearPasses = {"edges", "line", "sum"};

constexpr uint32_t groupsFor(uint64_t invocations) {
  return static_cast<uint32_t>((invocations + kUnoccludedGroupSize - 1) / kUnoccludedGroupSize);
}

// Makes a device buffer of these values that shaders read as texels of 16 bytes.
template <class T>
void upload(Commands& commands, const Device& device, const std::vector<T>& values, Buffer& buffer) {
  buffer = Buffer(device, values.size() * sizeof(T), MemoryUse::device, VK_FORMAT_R32G32B32A32_UINT);
  Buffer staging(device, values.size() * sizeof(T), MemoryUse::upload);
  staging.write(std::span<const T>(values));
  commands.begin();
  commands.copy(staging, buffer, values.size() * sizeof(T));
  commands.submitAndWait();
}

}  // namespace

struct UnoccludedExchange::State {
  State(const Device& device, const Scene& scene, const UnoccludedOptions& options);
  void computeChunk(std::span<const SidePair> requested, std::span<double> found);
  void integrateNear(VkDeviceAddress list, uint32_t near_count);
  void recordRound(size_t round, VkDeviceAddress near, uint32_t count);
  void bindTexels(const Kernel& kernel, const Buffer& texels);
  void endPass();
  void addSeconds(std::span<const char* const> passes);
  VkDeviceAddress listOf(uint32_t list, uint32_t pair_count) const {
    return pair_lists.address() + uint64_t(list) * pair_count * sizeof(uint32_t);
  }
  UnoccludedStatus readStatus() const { return status_read.mapped<UnoccludedStatus>()[0]; }

  UnoccludedOptions options;
  uint64_t side_count;
  Kernel classify, edges, plain_line, graded_line, sum;
  std::vector<Kernel> far;
  std::vector<std::vector<GaussPoint>> far_points;
  std::vector<FarBound> bounds;
  Commands commands;
  Timestamps timestamps;
  Buffer shapes, line_points;
  std::array<std::array<uint32_t, kLineRules>, kLineRounds.size()> first_points{};
  Buffer pairs_written, pairs, areas, areas_read, pair_lists, status, status_read, unreached, unreached_read;
  std::array<Buffer, 2> again_lists;  // near pairs that go on to the second, and to the third round
  Buffer edge_parts, values, line_lists;
  UnoccludedWork work;
};

UnoccludedExchange::State::State(const Device& device, const Scene& scene, const UnoccludedOptions& requested)
    : options(requested),
      side_count(2 * scene.polygons.size()),
      classify(device, unoccluded_classify_comp, sizeof(ClassifyArgs), {}, 1),
      edges(device, unoccluded_edges_comp, sizeof(EdgesArgs), {}, 1),
      plain_line(device, unoccluded_line_comp, sizeof(LineArgs), {false}, 1),
      graded_line(device, unoccluded_line_comp, sizeof(LineArgs), {true}, 1),
      sum(device, unoccluded_sum_comp, sizeof(SumArgs), {}, 1),
      commands(device),
      timestamps(device, kChunkPasses.size() + 1) {
  if (side_count > 0xFFFFFFFFu)
    throw Error(ErrorCode::limit, fmt::format("{} polygons are more than 2^31", scene.polygons.size()));
  const uint64_t most_groups = device.properties().limits.maxComputeWorkGroupCount[0];
  options.near_pairs = static_cast<uint32_t>(
      std::clamp<uint64_t>(options.near_pairs, 1, most_groups * kUnoccludedGroupSize / kEdgePairs));
  options.chunk_pairs =
      static_cast<uint32_t>(std::clamp<uint64_t>(options.chunk_pairs, 1, most_groups * kUnoccludedGroupSize));
  for (uint32_t k = 0; k < kFarRules; ++k) {
    const uint32_t n = kFewestFarPoints + k;
    far.emplace_back(device, unoccluded_far_comp, sizeof(FarArgs), std::vector<uint32_t>{n}, 1);
    far_points.push_back(gaussPoints(static_cast<int>(n)));
    bounds.push_back(farBound(static_cast<int>(n)));
  }

  upload(commands, device, makeShapes(scene), shapes);
  std::vector<glm::dvec2> points;
  for (size_t round = 0; round < kLineRounds.size(); ++round)
    for (uint32_t rule = 0; rule < kLineRules; ++rule) {
      first_points[round][rule] = static_cast<uint32_t>(points.size());
      const auto n = static_cast<int>(kLineRounds[round].points[rule]);
      for (const GaussPoint& point : rule == kGradedRule ? gradedPoints(n) : unitPoints(n))
        points.emplace_back(double(point.node), double(point.weight));
    }
  upload(commands, device, points, line_points);

  const uint64_t n = options.chunk_pairs, near = options.near_pairs;
  pairs_written = Buffer(device, n * sizeof(SidePair), MemoryUse::upload);
  pairs = Buffer(device, n * sizeof(SidePair), MemoryUse::device);
  areas = Buffer(device, n * sizeof(double), MemoryUse::device);
  areas_read = Buffer(device, n * sizeof(double), MemoryUse::readback);
  pair_lists = Buffer(device, n * kPairLists * sizeof(uint32_t), MemoryUse::device);
  for (Buffer& list : again_lists) list = Buffer(device, n * sizeof(uint32_t), MemoryUse::device);
  unreached = Buffer(device, n * sizeof(UnreachedData), MemoryUse::device);
  unreached_read = Buffer(device, n * sizeof(UnreachedData), MemoryUse::readback);
  status = Buffer(device, sizeof(UnoccludedStatus), MemoryUse::device);
  status_read = Buffer(device, sizeof(UnoccludedStatus), MemoryUse::readback);
  edge_parts = Buffer(device, near * 2 * kMostEdges * sizeof(EdgeData), MemoryUse::device);
  values = Buffer(device, near * kEdgePairs * sizeof(LineValue), MemoryUse::device);
  line_lists = Buffer(device, near * kEdgePairs * kLineRules * sizeof(uint32_t), MemoryUse::device);
}

void UnoccludedExchange::State::bindTexels(const Kernel& kernel, const Buffer& texels) {
  commands.bind(kernel, VK_PIPELINE_BIND_POINT_COMPUTE);
  commands.bindTexels(kernel, std::array{texels.texels()});
}

void UnoccludedExchange::State::endPass() {
  commands.barrier();
  timestamps.mark(commands.handle());
}

void UnoccludedExchange::State::addSeconds(std::span<const char* const> passes) {
  const std::vector<double> seconds = timestamps.seconds();
  if (seconds.empty()) return;  // the device has no timestamps
  for (size_t k = 0; k < passes.size(); ++k) {
    const auto entry = std::find_if(work.pass_seconds.begin(), work.pass_seconds.end(),
                                    [&](const auto& one) { return one.first == passes[k]; });
    if (entry == work.pass_seconds.end()) work.pass_seconds.emplace_back(passes[k], seconds[k]);
    else entry->second += seconds[k];
  }
}

// Records the passes edges, line and sum over some near pairs.
//   In: round: 0, 1 or 2; near: device address of the first of these pairs in the round's list; count: number of pairs
void UnoccludedExchange::State::recordRound(size_t round, VkDeviceAddress near, uint32_t count) {
  std::array<WorkList, kLineRules> none{};
  none.fill({0, 1, 1, 0});
  commands.barrier();
  vkCmdUpdateBuffer(commands.handle(), status.handle(), offsetof(UnoccludedStatus, lines), sizeof none, &none);
  endPass();
  const VkDeviceAddress lines = status.address() + offsetof(UnoccludedStatus, lines);
  const EdgesArgs cut{pairs.address(),
                      near,
                      edge_parts.address(),
                      values.address(),
                      line_lists.address(),
                      lines,
                      kLineRounds[round].graded_error,
                      count,
                      {kLineRounds[round].points[0], kLineRounds[round].points[1], kLineRounds[round].points[2]}};
  bindTexels(edges, shapes);
  commands.dispatch(edges, cut, groupsFor(uint64_t(count) * kMostEdges), 1);
  endPass();
  for (uint32_t rule = 0; rule < kLineRules; ++rule) {
    const LineArgs integrate{
        edge_parts.address(),      line_lists.address() + uint64_t(rule) * count * kEdgePairs * sizeof(uint32_t),
        values.address(),          lines + rule * sizeof(WorkList),
        first_points[round][rule], kLineRounds[round].points[rule]};
    const Kernel& line = rule == kGradedRule ? graded_line : plain_line;
    bindTexels(line, line_points);
    commands.dispatchIndirect(line, integrate, status, offsetof(UnoccludedStatus, lines) + rule * sizeof(WorkList));
  }
  endPass();
  const SumArgs add{pairs.address(),
                    near,
                    values.address(),
                    areas.address(),
                    again_lists[round % 2].address(),
                    unreached.address(),
                    status.address(),
                    count,
                    round + 1 == kLineRounds.size()};
  bindTexels(sum, shapes);
  commands.dispatch(sum, add, groupsFor(count), 1);
  endPass();
}

void UnoccludedExchange::State::integrateNear(VkDeviceAddress list, uint32_t near_count) {
  work.near_pairs += near_count;
  for (size_t round = 0; near_count > 0 && round < kLineRounds.size(); ++round) {
    if (round > 0) work.again_pairs += near_count;
    const uint32_t none = 0;
    commands.begin();
    vkCmdUpdateBuffer(commands.handle(), status.handle(), offsetof(UnoccludedStatus, again), sizeof none, &none);
    commands.submitAndWait();
    for (uint32_t first = 0; first < near_count; first += options.near_pairs) {
      commands.begin();
      timestamps.reset(commands.handle());
      recordRound(round, list + first * sizeof(uint32_t), std::min(options.near_pairs, near_count - first));
      commands.copy(status, status_read, sizeof(UnoccludedStatus));
      commands.submitAndWait();
      for (const WorkList& integrals : readStatus().lines) work.line_integrals += integrals.count;
      addSeconds(kNearPasses);
    }
    near_count = readStatus().again;
    list = again_lists[round % 2].address();
  }
}

void UnoccludedExchange::State::computeChunk(std::span<const SidePair> requested, std::span<double> found) {
  const auto count = static_cast<uint32_t>(requested.size());
  pairs_written.write(requested);
  UnoccludedStatus none{};
  for (WorkList& list : none.pairs) list = {0, 1, 1, 0};
  commands.begin();
  timestamps.reset(commands.handle());
  vkCmdUpdateBuffer(commands.handle(), status.handle(), 0, sizeof none, &none);
  commands.fill(areas, 0, found.size_bytes());
  commands.copy(pairs_written, pairs, requested.size_bytes());
  endPass();
  constexpr VkDeviceSize kWork = offsetof(UnoccludedStatus, pairs);
  ClassifyArgs sort{pairs.address(), pair_lists.address(), status.address() + kWork, {}, count};
  std::copy(bounds.begin(), bounds.end(), sort.bounds);
  bindTexels(classify, shapes);
  commands.dispatch(classify, sort, groupsFor(count), 1);
  endPass();
  for (uint32_t rule = 0; rule < kFarRules; ++rule) {
    FarArgs integrate{pairs.address(),
                      areas.address(),
                      listOf(rule, count),
                      status.address() + kWork + rule * sizeof(WorkList),
                      {},
                      {}};
    for (size_t k = 0; k < far_points[rule].size(); ++k) {
      integrate.nodes[k] = double(far_points[rule][k].node);
      integrate.weights[k] = double(far_points[rule][k].weight);
    }
    bindTexels(far[rule], shapes);
    commands.dispatchIndirect(far[rule], integrate, status, kWork + rule * sizeof(WorkList));
    endPass();
  }
  commands.copy(status, status_read, sizeof(UnoccludedStatus));
  commands.submitAndWait();
  addSeconds(kChunkPasses);

  const UnoccludedStatus sorted = readStatus();
  const uint32_t near_count = sorted.pairs[kNearList].count;
  work.pairs += count;
  work.unseen_pairs += count - near_count;
  for (uint32_t rule = 0; rule < kFarRules; ++rule) {
    work.far_pairs[rule] += sorted.pairs[rule].count;
    work.unseen_pairs -= sorted.pairs[rule].count;
  }
  integrateNear(listOf(kNearList, count), near_count);
  commands.begin();
  commands.copy(areas, areas_read, found.size_bytes());
  if (const uint32_t many = readStatus().unreached)
    commands.copy(unreached, unreached_read, many * sizeof(UnreachedData));
  commands.submitAndWait();
  std::copy_n(areas_read.mapped<double>().begin(), found.size(), found.begin());
}

UnoccludedExchange::UnoccludedExchange(const Device& device, const Scene& scene, const UnoccludedOptions& options)
    : state_(std::make_unique<State>(device, scene, options)) {}

UnoccludedExchange::UnoccludedExchange(const Scene& scene, const UnoccludedOptions& options)
    : host_(std::make_unique<HostUnoccluded>(scene, options.thread_count)) {}

UnoccludedExchange::~UnoccludedExchange() = default;

std::vector<UnreachedPair> UnoccludedExchange::compute(std::span<const SidePair> pairs, std::span<double> areas) {
  if (pairs.size() != areas.size())
    throw Error(ErrorCode::bad_usage, fmt::format("{} pairs but room for {} areas", pairs.size(), areas.size()));
  const uint64_t side_count = host_ ? host_->sideCount() : state_->side_count;
  for (const SidePair& pair : pairs)
    if (std::max(pair.i, pair.j) >= side_count)
      throw Error(ErrorCode::bad_usage,
                  fmt::format("sides {} and {} of a scene that has {}", pair.i, pair.j, side_count));
  if (host_) return host_->compute(pairs, areas);
  std::vector<UnreachedPair> unreached;
  for (size_t first = 0; first < pairs.size(); first += state_->options.chunk_pairs) {
    const size_t count = std::min<size_t>(state_->options.chunk_pairs, pairs.size() - first),
                 unreached_before = unreached.size();
    state_->computeChunk(pairs.subspan(first, count), areas.subspan(first, count));
    for (const UnreachedData& one :
         state_->unreached_read.mapped<UnreachedData>().first(state_->readStatus().unreached))
      unreached.push_back({first + one.pair, one.error});
    std::sort(unreached.begin() + static_cast<std::ptrdiff_t>(unreached_before), unreached.end(),
              [](const auto& a, const auto& b) { return a.pair < b.pair; });
  }
  return unreached;
}

const UnoccludedWork& UnoccludedExchange::work() const { return host_ ? host_->work() : state_->work; }

}  // namespace viewpeel
