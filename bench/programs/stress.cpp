// This bench checks thousands of random hard scenes against exact areas, as scenes/stress.h says. It prints CSV on
// stdout, and its exit status is 1 if a check fails.
#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include "scenes/stress.h"

int main(int argc, char** argv) {
  uint64_t scenes = 1000, first = 1;
  std::string only;
  CLI::App app("Counts random scenes of every kind with both engines and compares every region with its exact area.");
  app.add_option("--scenes", scenes, "of each kind")->capture_default_str();
  app.add_option("--first-seed", first, "seeds go on from here")->capture_default_str();
  app.add_option("--only", only, "one kind");
  CLI11_PARSE(app, argc, argv);
  using namespace viewpeel;
  try {
    const Device device;
    fmt::print(
        "# {}, "
        "{}\nkind,scenes,first_seed,polygons,directions,regions,largest_error_of_allowed,engines_differ,lines_in_"
        "closed_scenes,lost_lines,worst_case\n",
        device.description().name, device.description().driver);
    bool holds = true;
    for (stress::Kind kind : stress::kKinds) {
      if (!only.empty() && only != stress::nameOf(kind)) continue;
      stress::Tally all;
      for (uint64_t seed = first; seed < first + scenes; ++seed) {
        const stress::Tally tally = stress::judge(device, kind, seed);
        if (tally.worst > 1 || tally.unequal)
          fmt::print(stderr, "off by {:.3g} of what is allowed, {} counts differ: {}\n", tally.worst, tally.unequal,
                     tally.worst_case);
        all.add(tally);
      }
      holds = holds && all.worst <= 1 && all.unequal == 0;
      fmt::print("{},{},{},{},{},{},{:.3f},{},{},{},\"{}\"\n", stress::nameOf(kind), all.scenes, first, all.polygons,
                 all.directions, all.regions, all.worst, all.unequal, all.lines, all.lost_lines, all.worst_case);
      std::fflush(stdout);
    }
    return holds ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
