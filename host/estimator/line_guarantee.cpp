#include "estimator/line_guarantee.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "estimator/chernoff.h"
#include "threads.h"

namespace viewpeel {
namespace {

constexpr size_t kEntriesAtOnce = 16;  // entries that a thread takes at once
// Lines of this number of entries are drawn in one call, so that tasks take few megabytes.
constexpr size_t kEntriesOfCall = 1 << 16;

double linesOfPart(double exchange, double weight) { return std::max(1.0, std::ceil(exchange / weight)); }

}  // namespace

void LineGuarantee::forEach(size_t count, const std::function<void(size_t)>& work) const {
  shareOut(
      lines_.threads(), count, kEntriesAtOnce, [&](size_t, size_t k) { work(k); },
      [&](size_t) { lines_.stopIfRequested(); });
}

double LineGuarantee::weightAt(const Entry& entry, uint32_t look) const {
  return look == 0 ? entry.first_weight : std::ldexp(entry.weight, static_cast<int>(entry.looks - 1 - look));
}

double LineGuarantee::linesOf(const Entry& entry, uint32_t look) const {
  double lines = 0;
  for (uint32_t k = 0; k < entry.part_count; ++k)
    lines += linesOfPart(parts_[entry.first_part + k].exchange, weightAt(entry, look));
  return lines;
}

// Returns how many candidates a line of a part may take. Lines of small parts of a sum may be left open sooner.
double LineGuarantee::mostCandidates(const Entry& entry, const Part& part) const {
  const bool is_little = part.exchange * entry.part_count <= kShareOfOpen * entry.allowed;
  return is_little ? std::min(entry.most_candidates, kMostCandidates) : entry.most_candidates;
}

// Returns the lines that all parts of the entries need for their next looks.
LineGuarantee::Tasks LineGuarantee::tasksOf(std::span<const uint32_t> entries) const {
  Tasks tasks;
  for (const uint32_t index : entries) {
    const Entry& entry = entries_[index];
    tasks.first.push_back(entry.strata_looks ? tasks.strata.size() : tasks.uniform.size());
    if (entry.strata_looks) {
      addStrataTasks(entry, tasks.strata);
      continue;
    }
    for (uint32_t k = 0; k < entry.part_count; ++k) {
      const Part& part = parts_[entry.first_part + k];
      const auto wanted = static_cast<uint64_t>(linesOfPart(part.exchange, weightAt(entry, entry.look)));
      const uint64_t missing = wanted > part.count.lines ? wanted - part.count.lines : 0;
      tasks.uniform.push_back({part.index, part.guess, entry.look, missing, mostCandidates(entry, part), part.count});
    }
  }
  return tasks;
}

// Takes over the uniform lines that were drawn for an entry's parts.    In: tasks: of these parts, drawn
void LineGuarantee::take(Entry& entry, std::span<const UniformTask> tasks) {
  for (uint32_t k = 0; k < entry.part_count; ++k) {
    Part& part = parts_[entry.first_part + k];
    part.count = tasks[k].count, part.guess = tasks[k].guess;
    if (entry.look > 0) continue;
    const double each = part.exchange / double(part.count.lines);
    entry.first_facing += each * double(part.count.facing), entry.first_open += each * double(part.count.open);
    entry.first_variance += each * part.exchange * (part.count.open < part.count.lines);
  }
}

// Intersects the interval of an entry with a new one: both hold, unless a bound fails.
//   Out: whether the interval is narrow enough for the guarantee
bool LineGuarantee::narrow(Entry& entry, const Interval& interval, double value, double standard_error) const {
  if (entry.look > 0 && interval.lower <= entry.interval.upper && interval.upper >= entry.interval.lower)
    entry.interval = {std::max(entry.interval.lower, interval.lower), std::min(entry.interval.upper, interval.upper)};
  else entry.interval = interval;
  entry.value = std::clamp(value, entry.interval.lower, entry.interval.upper);
  entry.standard_error = standard_error + entry.error;
  const double off = std::max(entry.interval.upper - entry.value, entry.value - entry.interval.lower);
  return off <= options_.epsilon * ids_.smallerArea(entry.i, entry.j);
}

double LineGuarantee::chanceError(double visibility, double lines) {
  const double likely = (lines * visibility + 0.5) / (lines + 1);
  return std::sqrt(likely * (1 - likely) / (lines + 1) + 0.25 / ((lines + 1) * (lines + 1)));
}

// Sets interval, value and standard error after a look at uniform lines.    Out: whether the entry is finished
bool LineGuarantee::settle(Entry& entry, uint32_t look) const {
  const double blockable = entry.blockable, rounding = entry.rounding();
  double facing = 0, open = 0, guess = 0, lines = 0;
  double effective_lines = 0;  // of the estimate: open lines count as the lines of their guess
  for (uint32_t k = 0; k < entry.part_count; ++k) {
    const Part& part = parts_[entry.first_part + k];
    facing += part.exchange * double(part.count.facing) / double(part.count.lines);
    const double open_here = part.exchange * double(part.count.open) / double(part.count.lines);
    open += open_here, guess += open_here * double(part.guess.visibility);
    lines += double(part.count.lines);
    effective_lines += part.isLeftOpen() ? double(part.guess.lines) : double(part.count.lines);
  }
  Interval seen{0, blockable};
  const bool is_proved = options_.delta == 0 || entry.isBounded();
  if (!is_proved) {
    // Chernoff's variables are the contributions of single lines, divided by the largest possible contribution.
    const double most = weightAt(entry, look) * lines;
    const MeanBounds mean = chernoffBounds(facing / most, (facing + open) / most, lines, entry.log_chance);
    seen = {std::min(blockable, most * mean.lower), std::min(blockable, most * mean.upper)};
  }
  const double share = blockable > 0 ? (facing + guess) / blockable : 0,
               standard_error = entry.part_count ? blockable * chanceError(share, effective_lines) : 0;
  const bool is_narrow =
      narrow(entry, {std::max(0.0, entry.clear + seen.lower - rounding), entry.clear + seen.upper + rounding},
             entry.clear + facing + guess, standard_error);
  return is_proved || is_narrow;
}

// Looks at an entry's lines, and chooses its next look.
//   In: tasks: drawn; first: index of the task of the entry's first part    Out: whether the entry is finished
bool LineGuarantee::look(Entry& entry, const Tasks& tasks, size_t first) {
  if (entry.strata_looks > 0) {
    const bool is_done = lookAtStrata(entry, std::span(tasks.strata).subspan(first, entry.part_count));
    if (entry.strata_looks == 0) entry.look = entry.looks - 1;
    return is_done;
  }
  take(entry, std::span(tasks.uniform).subspan(first, entry.part_count));
  const bool is_done = settle(entry, entry.look);
  if (++entry.look == 1 && !is_done) chooseStrata(entry);
  return is_done;
}

void LineGuarantee::step() {
  std::vector<char> is_done(open_.size(), false);
  for (size_t first = 0; first < open_.size(); first += kEntriesOfCall) {
    const std::span<const uint32_t> together =
        std::span(open_).subspan(first, std::min(kEntriesOfCall, open_.size() - first));
    Tasks tasks = tasksOf(together);
    lines_.drawUniform(tasks.uniform);
    lines_.drawStrata(tasks.strata);
    forEach(together.size(),
            [&](size_t k) { is_done[first + k] = look(entries_[together[k]], tasks, tasks.first[k]); });
  }
  std::vector<uint32_t> still_open;
  for (size_t k = 0; k < open_.size(); ++k) {
    if (is_done[k]) continue;
    still_open.push_back(open_[k]);
    if (const Entry& entry = entries_[open_[k]]; entry.look == entry.looks)
      throw Error(
          ErrorCode::limit,
          fmt::format("the form factor of {} and {} cannot be guaranteed, for rounding errors may decide it; ask for "
                      "a larger --epsilon, or an estimate by --tolerance",
                      ids_.names[entry.i], nameOf(entry.j)));
  }
  open_ = std::move(still_open);
  if (++look_ == 1 && options_.rows) requireRows();
}

}  // namespace viewpeel
