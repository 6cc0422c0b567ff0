#include "pair_lines/ranked_lines.h"

#include <utility>

#include <fmt/format.h>

#include "hash.h"
#include "ranks/put_ids.h"

namespace viewpeel {
namespace {

// A PairPlan is the part of a LinePair that a plan sets. Ranks exchange it in place of whole pairs.
struct PairPlan {
  uint32_t blocks, cuts, parts;
  uint16_t period;
  bool by_angles;
};

PairPlan planOf(const LinePair& pair) {
  return {pair.blocks, pair.cuts, pair.parts, static_cast<uint16_t>(pair.period), pair.by_angles};
}

void adopt(const PairPlan& plan, LinePair& pair) {
  pair.blocks = plan.blocks, pair.cuts = plan.cuts, pair.parts = plan.parts;
  pair.period = plan.period, pair.by_angles = plan.by_angles;
}

std::vector<PairPlan> plansOf(std::span<const LinePair> pairs) {
  std::vector<PairPlan> plans;
  plans.reserve(pairs.size());
  for (const LinePair& pair : pairs) plans.push_back(planOf(pair));
  return plans;
}

template <class T>
std::span<T> partOf(std::span<T> all, const std::vector<size_t>& cuts, uint32_t rank) {
  return all.subspan(cuts[rank], cuts[rank + 1] - cuts[rank]);
}

// Draws each rank's part of the tasks on that rank, and puts the drawn tasks back in place.
//   In: costs: of each task, relative to one another; draw_here: draws a span of tasks on rank 0
template <class Task>
void drawOnRanks(Crew& crew, RankWork work, std::span<Task> tasks, const std::vector<double>& costs,
                 const auto& draw_here) {
  const std::vector<size_t> cuts = crew.cut(costs);
  const std::vector<std::string> answers = crew.share(
      [&](uint32_t rank) {
        return MessageWriter().put(work).putAll(std::span<const Task>(partOf(tasks, cuts, rank))).take();
      },
      [&] { draw_here(partOf(tasks, cuts, 0)); });
  for (uint32_t rank = 1; rank < crew.size(); ++rank)
    std::ranges::copy(MessageReader(answers[rank - 1]).getAll<Task>(), partOf(tasks, cuts, rank).begin());
}

}  // namespace

// Returns the cost of one line in each part of a pair that something may block, all parts together. The unit is a line
// without blockers; a test against one blocker costs as much.
double PairLines::costOf(const Group& group) const {
  double cost = 0;
  for (uint32_t part = group.first; part < group.first + group.count; ++part)
    if (parts_.pairs[part].blocker_count) cost += 1 + parts_.pairs[part].blocker_count;
  return cost;
}

uint64_t PairLines::hashOfParts() const {
  Hash hash;
  for (const PatchPair& part : parts_.pairs) {
    hash.add(part.a), hash.add(part.b), hash.add(part.exchange), hash.add(part.blocker_count);
  }
  return hash.value();
}

std::vector<LinePair> PairLines::findOnRanks(double least_form_factor) {
  MessageWriter out;
  out.put(RankWork::find_pairs).put(seed_).put(device_ != nullptr).put(least_form_factor).put(ends_on_blockers_);
  for (const std::vector<bool>* of : {&leaking_.of_face, &leaking_.backs})
    out.putAll(std::vector<char>(of->begin(), of->end()));
  putIds(out, ids_);
  const std::string question = out.take();
  std::vector<LinePair> pairs;
  const std::vector<std::string> answers =
      crew_->share([&](uint32_t) { return question; }, [&] { pairs = findHere(least_form_factor); });
  requireSameParts(answers);
  pairs_sent_ = 0;
  return pairs;
}

// Throws unless the other ranks have answered with the hash of rank 0's parts.
void PairLines::requireSameParts(const std::vector<std::string>& answers) const {
  const uint64_t hash = hashOfParts();
  for (uint32_t rank = 1; rank < crew_->size(); ++rank)
    if (MessageReader(answers[rank - 1]).get<uint64_t>() != hash)
      throw Error(ErrorCode::limit, fmt::format("rank {} has found other pairs than rank 0; take machines of one kind, "
                                                "or say --pair-lines off",
                                                rank));
}

void PairLines::cutOnRanks(std::span<LinePair> pairs) {
  const std::string plans = MessageWriter().put(RankWork::take_pairs).putAll(plansOf(pairs)).take();
  requireSameParts(crew_->share([&](uint32_t) { return plans; }, [&] { cutHere(pairs); }));
}

void PairLines::planOnRanks(std::span<LinePair> pairs, std::span<const double> goals, uint32_t replicates) const {
  std::vector<double> costs;
  for (const Group& group : groups_) costs.push_back(costOf(group));
  const std::vector<size_t> cuts = crew_->cut(costs);
  const std::vector<std::string> answers = crew_->share(
      [&](uint32_t rank) {
        MessageWriter out;
        out.put(RankWork::plan_lines).put(replicates).put(uint64_t(cuts[rank]));
        return out.putAll(partOf(goals, cuts, rank)).putAll(plansOf(partOf(pairs, cuts, rank))).take();
      },
      [&] { planHere(partOf(pairs, cuts, 0), 0, partOf(goals, cuts, 0), replicates); });
  for (uint32_t rank = 1; rank < crew_->size(); ++rank) {
    const std::vector<PairPlan> plans = MessageReader(answers[rank - 1]).getAll<PairPlan>();
    for (size_t k = 0; k < plans.size(); ++k) adopt(plans[k], pairs[cuts[rank] + k]);
  }
}

LineCounts PairLines::countOnRanks(std::span<const LinePair> pairs, uint64_t replicate,
                                   std::span<const uint32_t> times) {
  Hash hash;
  std::vector<double> costs(pairs.size(), 0);
  for (size_t k = 0; k < pairs.size(); ++k) {
    hash.add(pairs[k].blocks), hash.add(pairs[k].cuts), hash.add(pairs[k].period),
        hash.add(uint32_t(pairs[k].by_angles));
    if (times.empty() ? pairs[k].hasLines(replicate) : pairs[k].blocks && times[k])
      costs[k] = costOf(groups_[k]) * double(pairs[k].blocks) * (times.empty() ? 1 : times[k]);
  }
  if (std::exchange(pairs_sent_, hash.value()) != hash.value()) {
    const std::string plans = MessageWriter().put(RankWork::take_pairs).putAll(plansOf(pairs)).take();
    requireSameParts(crew_->share([&](uint32_t) { return plans; }, [] {}));
  }
  const std::vector<size_t> cuts = crew_->cut(costs, device_ == nullptr);
  LineCounts counts;
  const std::vector<std::string> answers = crew_->share(
      [&](uint32_t rank) {
        MessageWriter out;
        out.put(RankWork::count_lines).put(replicate).put(uint64_t(cuts[rank])).put(uint64_t(cuts[rank + 1]));
        return out.putAll(times.empty() ? times : partOf(times, cuts, rank)).take();
      },
      [&] {
        counts = countHere(pairs, {0, cuts[1]}, replicate, times);
      });
  for (const std::string& answer : answers) {
    const LineCounts others = MessageReader(answer).getAll<LineCount>();
    counts.insert(counts.end(), others.begin(), others.end());
  }
  return counts;
}

void PairLines::drawUniformOnRanks(std::span<UniformTask> tasks) const {
  std::vector<double> costs;
  for (const UniformTask& task : tasks)
    costs.push_back((double(task.lines) + 1) * (1 + parts_.pairs[task.part].blocker_count));
  drawOnRanks(*crew_, RankWork::draw_uniform, tasks, costs, [&](auto part) { drawUniformHere(part); });
}

void PairLines::drawStrataOnRanks(std::span<StrataTask> tasks) const {
  std::vector<double> costs;
  for (const StrataTask& task : tasks)
    costs.push_back((double(task.cells) + 1) * (1 + parts_.pairs[task.part].blocker_count));
  drawOnRanks(*crew_, RankWork::draw_strata, tasks, costs, [&](auto part) { drawStrataHere(part); });
}

LineServer::LineServer(const Scene& scene, size_t threads, std::function<void()> stop,
                       std::function<const Device*()> device)
    : scene_(scene), threads_(threads), stop_(std::move(stop)), device_(std::move(device)) {}

std::string LineServer::answer(RankWork work, MessageReader& in) {
  if (work == RankWork::find_pairs) return find(in);
  if (!lines_) throw Error(ErrorCode::limit, "rank 0 asked for lines of pairs that were not found");
  if (work == RankWork::plan_lines) return plan(in);
  if (work == RankWork::take_pairs) return takePairs(in);
  if (work == RankWork::draw_strata) return drawStrata(in);
  return work == RankWork::count_lines ? count(in) : drawUniform(in);
}

std::string LineServer::find(MessageReader& in) {
  const auto seed = in.get<uint64_t>();
  const auto on_device = in.get<bool>();
  const auto least = in.get<double>();
  const auto ends_on_blockers = in.get<bool>();
  const std::vector<char> leaking = in.getAll<char>(), backs = in.getAll<char>();
  lines_.reset();
  face_ids_ = std::make_unique<const Ids>(getIds(in));
  lines_.emplace(scene_, *face_ids_, LeakingFaces{{leaking.begin(), leaking.end()}, 0, {backs.begin(), backs.end()}},
                 seed, threads_, stop_, on_device ? device_() : nullptr, nullptr, ends_on_blockers);
  pairs_ = lines_->find(least);
  return MessageWriter().put(lines_->hashOfParts()).take();
}

std::string LineServer::plan(MessageReader& in) {
  const auto replicates = in.get<uint32_t>();
  const auto first = in.get<uint64_t>();
  const std::vector<double> goals = in.getAll<double>();
  const std::vector<PairPlan> plans = in.getAll<PairPlan>();
  const std::span<LinePair> pairs = std::span(pairs_).subspan(first, goals.size());
  for (size_t k = 0; k < plans.size(); ++k) adopt(plans[k], pairs[k]);
  lines_->planHere(pairs, first, goals, replicates);
  return MessageWriter().putAll(plansOf(pairs)).take();
}

std::string LineServer::takePairs(MessageReader& in) {
  const std::vector<PairPlan> plans = in.getAll<PairPlan>();
  for (size_t k = 0; k < plans.size(); ++k) adopt(plans[k], pairs_.at(k));
  lines_->cutHere(pairs_);
  return MessageWriter().put(lines_->hashOfParts()).take();
}

std::string LineServer::count(MessageReader& in) {
  const auto replicate = in.get<uint64_t>();
  const auto first = in.get<uint64_t>(), end = in.get<uint64_t>();
  const std::vector<uint32_t> times_of_range = in.getAll<uint32_t>();
  std::vector<uint32_t> times;
  if (!times_of_range.empty()) {
    times.resize(pairs_.size());
    std::ranges::copy(times_of_range, times.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return MessageWriter().putAll(lines_->countHere(pairs_, {first, end}, replicate, times)).take();
}

std::string LineServer::drawUniform(MessageReader& in) {
  std::vector<UniformTask> tasks = in.getAll<UniformTask>();
  lines_->drawUniformHere(tasks);
  return MessageWriter().putAll(tasks).take();
}

std::string LineServer::drawStrata(MessageReader& in) {
  std::vector<StrataTask> tasks = in.getAll<StrataTask>();
  lines_->drawStrataHere(tasks);
  return MessageWriter().putAll(tasks).take();
}

}  // namespace viewpeel
