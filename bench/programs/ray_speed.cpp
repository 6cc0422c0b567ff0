// This bench measures how fast rays of each polygon's own are cast. It prints CSV on stdout.
//   ray_speed FILE... [--rays N] [--replicates N] [--threads N]
//
// A row has CPU seconds of all replicates, which are counted at once, and microseconds of a ray. The last column is a
// hash of all counts, equal for equal results.
#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "bench/support/measure.h"
#include "bench/support/run_time.h"
#include <viewpeel/ids.h>
#include "directions/sampler.h"
#include "hash.h"
#include "rays/ray_engine.h"
#include "threads.h"

namespace viewpeel::bench {
namespace {

void measure(const std::string& file, uint32_t threads, uint32_t rays, uint32_t replicates) {
  const Scene scene = loadScene(file);
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto engine = makeRayEngine(scene, ids, {.thread_count = threads});
  Hash hash;
  const std::vector<Direction> directions = sampleReplicates(Sampler::iid, rays, 1, 0, replicates);
  std::vector<PairCounts> counts;
  const RunTime casting = timeOf([&] { counts = engine->countBlocks(directions, rays); });
  for (const PairCounts& of_replicate : counts)
    for (const PairCount& pair : of_replicate)
      hash.add(uint64_t(pair.i)), hash.add(uint64_t(pair.j)), hash.add(pair.count);
  const double all = double(rays) * replicates * double(scene.polygons.size());
  fmt::print("{},{},{},{},{:.3f},{:.4f},{:016x}\n", file, scene.polygons.size(), rays, replicates, casting.cpu_seconds,
             1e6 * casting.cpu_seconds / all, hash.value());
}

}  // namespace
}  // namespace viewpeel::bench

int main(int argc, char** argv) {
  using namespace viewpeel;
  std::vector<std::string> files;
  auto threads = static_cast<uint32_t>(threadCount());
  uint32_t rays = 256, replicates = 8;
  CLI::App app("Speed of rays: CSV on stdout");
  app.add_option("files", files)->required();
  app.add_option("--rays", rays, "of each polygon in a replicate")->check(CLI::PositiveNumber);
  app.add_option("--replicates", replicates)->check(CLI::PositiveNumber);
  app.add_option("--threads", threads)->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print("# commit {}\n", bench::commitOf(VIEWPEEL_SOURCE));
    fmt::print("file,polygons,rays,replicates,cpu_s,us_a_ray,hash\n");
    for (const std::string& file : files) bench::measure(file, threads, rays, replicates);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
