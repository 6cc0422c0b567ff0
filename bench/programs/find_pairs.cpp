// This bench measures the search for the pairs that see each other and for the blockers between them. It prints CSV on
// stdout.
//   find_pairs FILE... [--threads N] [--repeats N] [--least F]
//
// A row has CPU seconds of three steps: join blockers, find pairs, and integrate the unoccluded form factors of the
// pairs found. The second step contains the third, which is repeated alone. `between` is the mean number of blockers of
// a pair that something may block. The last column is a hash of all pairs and blockers, equal for equal results.
#include <algorithm>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "bench/support/measure.h"
#include "bench/support/run_time.h"
#include <viewpeel/ids.h>
#include "hash.h"
#include "pair_lines/find_pairs.h"
#include "threads.h"

namespace viewpeel::bench {
namespace {

uint64_t hashOf(const PatchPairs& found) {
  Hash hash;
  for (const PatchPair& pair : found.pairs) {
    hash.add(uint64_t(pair.a)), hash.add(uint64_t(pair.b)), hash.add(pair.exchange);
    std::vector<uint64_t> between;
    for (uint32_t k = 0; k < pair.blocker_count; ++k) {
      const PlacedBlocker& blocker = found.between[pair.first_blocker + k];
      between.push_back(uint64_t(blocker.blocker) * 4 + uint64_t(blocker.place));
    }
    std::ranges::sort(between);
    for (const uint64_t number : between) hash.add(number);
  }
  return hash.value();
}

void measure(const std::string& file, size_t threads, int repeats, double least_form_factor) {
  const Scene scene = loadScene(file);
  const Ids ids = makeIds(scene, By::polygon, false);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    std::optional<PairFinder> finder;
    const RunTime joining = timeOf([&] { finder.emplace(scene, ids); });
    PatchPairs found;
    const RunTime finding = timeOf([&] { found = finder->find(threads, {}, least_form_factor); });
    const HostUnoccluded unoccluded(scene);
    UnoccludedWork work;
    const RunTime integrating = timeOf([&] {
      for (const PatchPair& pair : found.pairs)
        unoccluded.find({finder->patches()[pair.a].side, finder->patches()[pair.b].side}, work);
    });
    size_t partial = 0, between = 0;
    for (const PatchPair& pair : found.pairs) partial += pair.blocker_count > 0, between += pair.blocker_count;
    fmt::print("{},{},{},{},{},{:.2f},{:.3f},{:.3f},{:.3f},{:.3f},{:016x}\n", file, scene.polygons.size(),
               finder->blockers().size(), found.pairs.size() - partial, partial,
               double(between) / double(std::max<size_t>(partial, 1)), joining.cpu_seconds, finding.cpu_seconds,
               finding.seconds, integrating.cpu_seconds, hashOf(found));
  }
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  std::vector<std::string> files;
  size_t threads = threadCount();
  int repeats = 1;
  double least_form_factor = 0;
  CLI::App app("Finding pairs and what is between them: CSV on stdout");
  app.add_option("files", files)->required();
  app.add_option("--threads", threads)->check(CLI::PositiveNumber);
  app.add_option("--repeats", repeats)->check(CLI::PositiveNumber);
  app.add_option("--least", least_form_factor, "unoccluded form factor of a pair")->check(CLI::NonNegativeNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print("# commit {}\n", bench::commitOf(VIEWPEEL_SOURCE));
    fmt::print(
        "file,polygons,blockers,clear,partial,between,joining_cpu_s,finding_cpu_s,finding_s,unoccluded_cpu_s,"
        "hash\n");
    for (const std::string& file : files) bench::measure(file, threads, repeats, least_form_factor);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
