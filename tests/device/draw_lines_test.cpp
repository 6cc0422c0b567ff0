// Lines drawn on the device equal the processor's lines to the last bit.
#include <set>

#include <gtest/gtest.h>

#include "pair_lines/device_lines.h"
#include "pair_lines/pair_lines.h"
#include "scenes/named_scenes.h"
#include "scenes/stress.h"
#include "shaders/pair_lines_draw.comp.h"
#include "shaders/pair_lines_place.comp.h"
#include "shaders/pair_lines_prepare.comp.h"
#include "shaders/unoccluded_line.comp.h"
#include "tests/support/test_device.h"

namespace viewpeel {
namespace {

// Found holds the pairs of a scene, and tasks for about `most_tasks` of them. A pair of one plane has a task by
// contact, another pair one by points and one by angles. of_way counts the tasks of each way.
struct Found {
  Scene scene;
  PairFinder finder;
  PatchPairs pairs;
  std::vector<LineTask> tasks;
  size_t of_way[3] = {}, with_many = 0;

  explicit Found(Scene all, bool two_sided = false, size_t most_tasks = 400)
      : scene(std::move(all)), finder(scene, makeIds(scene, By::polygon, two_sided)), pairs(finder.find(1)) {
    const size_t step = pairs.pairs.size() / most_tasks + 1;
    for (size_t k = 0; k < pairs.pairs.size(); k += step) {
      const PatchPair& pair = pairs.pairs[k];
      const auto number = static_cast<uint32_t>(k);
      LineTask task{pair.a, pair.b, LineWay::points, pair.exchange, {}, {}, 0, 1 + number % 3};
      task.between = {pairs.between.data() + pair.first_blocker, pair.blocker_count};
      task.scrambles = {77 * number + 1, 1234567 * number + 5, 999983 * number + 7, 31337 * number + 11};
      if (k % 7 == 3) task.first = 5, task.end = 71;
      const bool is_contact = finder.patches()[pair.a].plane == finder.patches()[pair.b].plane;
      for (const LineWay way : {LineWay::points, LineWay::angles, LineWay::contact}) {
        if (is_contact != (way == LineWay::contact)) continue;
        task.way = way;
        tasks.push_back(task);
        ++of_way[int(way)], with_many += pair.blocker_count > 8;
      }
    }
  }

  std::vector<DrawnLines> onHost() const {
    std::vector<DrawnLines> drawn;
    for (const LineTask& task : tasks)
      drawn.push_back(drawOnHost(task, finder.patches(), finder.blockers(), widestVectors()));
    return drawn;
  }
};

// Returns the number of tasks in which device and host differ. `first` gets a description of the first one.
size_t countDifferences(const std::vector<DrawnLines>& device, const std::vector<DrawnLines>& host, const Found& found,
                        std::string* first = nullptr) {
  size_t count = 0;
  for (size_t k = 0; k < host.size(); ++k) {
    if (device[k] == host[k]) continue;
    const LineTask& task = found.tasks[k];
    if (count++ || !first) continue;
    *first = testing::PrintToString(std::vector<double>{device[k].facing, device[k].all, device[k].squares}) +
             " on the device, " +
             testing::PrintToString(std::vector<double>{host[k].facing, host[k].all, host[k].squares}) +
             " on the host, task " + std::to_string(k) + ", way " + std::to_string(int(task.way)) + ", patches " +
             std::to_string(task.a) + " and " + std::to_string(task.b);
  }
  return count;
}

// The kinds of scenes include near and touching pairs, thin plates, slivers, coincident faces and huge offsets.
TEST(DrawLines, DeviceDrawsTheLinesOfTheProcessor) {
  size_t of_way[3] = {}, with_many = 0, in_part = 0;
  const auto compare = [&](const Found& found, const std::string& name) {
    DeviceLines device(testDevice(), found.finder.patches(), found.finder.blockers());
    const std::vector<DrawnLines> host = found.onHost();
    std::string first;
    EXPECT_EQ(countDifferences(device.draw(found.tasks), host, found, &first), 0u) << name << ": " << first;
    for (int way = 0; way < 3; ++way) of_way[way] += found.of_way[way];
    with_many += found.with_many;
    for (const DrawnLines& lines : host) in_part += lines.facing > 0 && lines.facing < lines.all;
  };
  for (const stress::Kind kind : stress::kKinds)
    for (const bool two_sided : {false, true})
      compare(Found(buildScene(stress::makeScene(kind, 4)), two_sided),
              std::string(stress::nameOf(kind)) + (two_sided ? ", two-sided" : ""));
  compare(Found(loadScene(VIEWPEEL_SCENES "/office.obj")), "office");
  EXPECT_GT(of_way[0], 1000u);
  EXPECT_GT(of_way[1], 1000u);
  EXPECT_GT(of_way[2], 10u);
  EXPECT_GT(with_many, 50u);
  EXPECT_GT(in_part, 300u);
}

// Negative controls: blockers moved by 1e-4 of the radius, and a random number with another seed, change lines.
TEST(DrawLines, PlantedFaultsAreFound) {
  const Found found(loadScene(VIEWPEEL_SCENES "/office.obj"));
  std::vector<Blocker> moved = found.finder.blockers();
  for (Blocker& blocker : moved) {
    blocker.offset += 1e-4;
    for (double& offset : blocker.edge_offsets) offset += 1e-4;
  }
  DeviceLines faulty(testDevice(), found.finder.patches(), moved);
  EXPECT_GT(countDifferences(faulty.draw(found.tasks), found.onHost(), found), 20u);
  DeviceLines device(testDevice(), found.finder.patches(), found.finder.blockers());
  std::vector<LineTask> reseeded = found.tasks;
  for (LineTask& task : reseeded) task.scrambles[3] ^= 1;
  EXPECT_GT(countDifferences(device.draw(reseeded), found.onHost(), found), found.tasks.size() / 2);
  EXPECT_TRUE(agree(device, found.tasks, found.finder.patches(), found.finder.blockers()));
  std::vector<Patch> elsewhere = found.finder.patches();
  for (Patch& patch : elsewhere) patch.middle.x += 1e-6;
  DeviceLines rounding(testDevice(), elsewhere, found.finder.blockers());
  EXPECT_FALSE(agree(rounding, found.tasks, found.finder.patches(), found.finder.blockers()));
}

TEST(DrawLines, BatchesDoNotMatter) {
  Found found(loadScene(VIEWPEEL_SCENES "/office.obj"), false, 60);
  found.tasks[7].end = 1000;
  DeviceLines whole(testDevice(), found.finder.patches(), found.finder.blockers());
  const std::vector<DrawnLines> host = found.onHost();
  std::string first;
  EXPECT_EQ(countDifferences(whole.draw(found.tasks), host, found, &first), 0u) << first;
  for (const DeviceLinesOptions& options : {DeviceLinesOptions{8'000, 1 << 20}, DeviceLinesOptions{1 << 26, 4000}}) {
    DeviceLines parts(testDevice(), found.finder.patches(), found.finder.blockers(), options);
    size_t batch_count = 0;
    EXPECT_EQ(countDifferences(parts.draw(found.tasks, [&] { ++batch_count; }), host, found, &first), 0u) << first;
    EXPECT_GT(batch_count, 10u);
    EXPECT_THROW(parts.draw(found.tasks, [] { throw std::runtime_error("stopped"); }), std::runtime_error);
    EXPECT_EQ(countDifferences(parts.draw(found.tasks), host, found, &first), 0u) << "after a stop: " << first;
  }
}

// --- which instructions a device may round as it likes --------------------------------------------------------------

// Returns the operations in a shader whose rounding Vulkan leaves to the device: arithmetic that may be contracted,
// quotients, and floating-point functions.
std::set<uint32_t> freelyRounded(std::span<const uint32_t> spirv) {
  constexpr uint32_t kExtInst = 12, kDecorate = 71, kNoContraction = 42, kFAdd = 129, kFSub = 131, kFMul = 133,
                     kFDiv = 136, kFRem = 140, kFMod = 141, kVectorTimesScalar = 142, kMatrixFirst = 143, kDot = 148;
  constexpr uint32_t kUMin = 38, kUMax = 41, kFindILsb = 73;
  std::set<uint32_t> uncontracted, found;
  for (const bool reads_decorations : {true, false})
    for (size_t at = 5; at < spirv.size(); at += spirv[at] >> 16) {
      const uint32_t operation = spirv[at] & 0xFFFF;
      if (reads_decorations) {
        if (operation == kDecorate && spirv[at + 2] == kNoContraction) uncontracted.insert(spirv[at + 1]);
        continue;
      }
      const bool is_rounded =
          operation == kFAdd || operation == kFSub || operation == kFMul || operation == kVectorTimesScalar;
      const bool is_free = operation == kFDiv || operation == kFRem || operation == kFMod ||
                           (operation >= kMatrixFirst && operation <= kDot);
      const bool is_function =
          operation == kExtInst && spirv[at + 4] != kUMin && spirv[at + 4] != kUMax && spirv[at + 4] != kFindILsb;
      if (is_free || is_function || (is_rounded && !uncontracted.contains(spirv[at + 2]))) found.insert(operation);
    }
  return found;
}

TEST(DrawLines, ShadersHaveOnlyOperationsThatAllDevicesRoundAlike) {
  EXPECT_EQ(freelyRounded(pair_lines_prepare_comp), std::set<uint32_t>{});
  EXPECT_EQ(freelyRounded(pair_lines_place_comp), std::set<uint32_t>{});
  EXPECT_EQ(freelyRounded(pair_lines_draw_comp), std::set<uint32_t>{});
  EXPECT_FALSE(freelyRounded(unoccluded_line_comp).empty());
}

// --- all lines of a run ---------------------------------------------------------------------------------------------

TEST(PairLines, CountsOnDeviceAndProcessorAreTheSame) {
  const Scene scene = loadScene(VIEWPEEL_SCENES "/street.obj");
  const Ids ids = makeIds(scene, By::polygon, false);
  const LeakingFaces all{std::vector<bool>(ids.count(), true)};
  PairLines host(scene, ids, all, 5, 2), device(scene, ids, all, 5, 2, {}, &testDevice());
  std::vector<LinePair> pairs = host.find();
  ASSERT_EQ(device.find(), pairs);
  const auto plan = [&](PairLines& lines) {
    lines.plan(
        pairs, [&](const LinePair& pair) { return 1e-3 * ids.areas[pair.i]; }, 8);
  };
  plan(device);
  const std::vector<LinePair> planned = pairs;
  plan(host);
  ASSERT_EQ(pairs, planned);
  for (const uint64_t replicate : {0, 3}) EXPECT_EQ(host.count(pairs, replicate), device.count(pairs, replicate));
  // A third of the pairs get further lines: the planned number, or four times this number.
  std::vector<uint32_t> once(pairs.size()), four_times(pairs.size());
  for (size_t k = 0; k < pairs.size(); k += 3) {
    once[k] = 1;
    four_times[k] = 4;
  }
  EXPECT_EQ(host.count(pairs, 9, four_times), device.count(pairs, 9, four_times));
  EXPECT_FALSE(host.count(pairs, 9, four_times) == device.count(pairs, 9, once));
}

}  // namespace
}  // namespace viewpeel
