// The search decides many pairs at once, by clusters. These tests compare it with separate decisions for single pairs.
// The scenes have thin walls, boxes on a floor, slivers, and triangles in single precision.
#include <array>
#include <map>
#include <set>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include "pair_lines/corners.h"
#include "pair_lines/pair_lines.h"
#include "scenes/coincident_scenes.h"
#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "scenes/stress.h"
#include "scenes/triangulated_city.h"

namespace viewpeel {
namespace {

namespace ts = test_scenes;

struct NamedScene {
  std::string name;
  Scene scene;
};

// Returns houses on plots of the shape L, whose roofs are cut into parts, further and further apart.
InputScene housesOfManyParts() {
  InputScene input;
  const std::array<glm::dvec2, 6> plot{glm::dvec2(0, 0), {10, 0}, {10, 4}, {4, 4}, {4, 9}, {0, 9}};
  for (int house = 0; house < 4; ++house) {
    const double x = 20.0 * house * house, height = 5.0 + house;
    ts::Corners roof;
    for (size_t k = 0; k < plot.size(); ++k) {
      const glm::dvec2 from = plot[k], to = plot[(k + 1) % plot.size()];
      roof.push_back({x + from.x, from.y, height});
      ts::addFace(input, "house " + std::to_string(house),
                  ts::parallelogram({x + from.x, from.y, 0}, {to.x - from.x, to.y - from.y, 0}, {0, 0, height}));
    }
    ts::addFace(input, "house " + std::to_string(house), roof);
  }
  // The ground beside the houses has the shape L, too.
  ts::addFace(input, "ground", {{-5, -5, 0}, {400, -5, 0}, {400, -20, 0}, {420, -20, 0}, {420, -1, 0}, {-5, -1, 0}});
  return input;
}

std::vector<NamedScene> awkwardScenes() {
  std::vector<NamedScene> scenes;
  for (const ts::CoincidentScene& coincident : ts::coincidentScenes()) {
    scenes.push_back({coincident.name, buildScene(coincident.make(0))});
    scenes.push_back({coincident.name + ", turned, single precision",
                      buildScene(ts::roundedToSingle(ts::turnedAndMoved(coincident.make(0))))});
  }
  for (uint64_t seed = 0; seed < 3; ++seed)
    scenes.push_back({"slivers " + std::to_string(seed), buildScene(stress::makeScene(stress::Kind::slivers, seed))});
  scenes.push_back({"room with touching boxes", buildScene(ts::roomWithTouchingBoxes())});
  scenes.push_back({"room with boxes", buildScene(bench::roomWithBoxes(1))});
  scenes.push_back({"houses of many parts", buildScene(housesOfManyParts())});
  scenes.push_back({"city", buildScene(bench::triangulatedCity(1000, 3).scene)});
  return scenes;
}

constexpr double kStrip = 1e-8;  // ten times kTouchingShaft

bool isInFront(const Patch& a, const Patch& b) {
  for (uint32_t k = 0; k < b.corner_count; ++k)
    if (glm::dot(a.normal, b.corners[k]) > a.offset) return true;
  return false;
}

// Returns the lines from 9 points of one patch to 9 of the other. Both ends of a line lie in front of the other patch.
std::vector<std::pair<glm::dvec3, glm::dvec3>> linesBetween(const Patch& a, const Patch& b) {
  const auto pointOf = [](const Patch& patch, int k) {
    const double s = (k % 3) / 2.0, t = (k / 3) / 2.0;
    const glm::dvec3 one = glm::mix(patch.corners[0], patch.corners[1], s),
                     other = glm::mix(patch.corners[3], patch.corners[2], s);
    return glm::mix(one, other, t);
  };
  std::vector<std::pair<glm::dvec3, glm::dvec3>> lines;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 9; ++j) {
      const glm::dvec3 p = pointOf(a, i), q = pointOf(b, j);
      if (glm::dot(a.normal, q) > a.offset + kStrip && glm::dot(b.normal, p) > b.offset + kStrip)
        lines.push_back({p, q});
    }
  return lines;
}

// Returns how far inside a blocker a line passes through it, negative where it does not.
double depthThrough(const Blocker& blocker, const std::pair<glm::dvec3, glm::dvec3>& line) {
  const auto& [p, q] = line;
  const double from = glm::dot(blocker.normal, p) - blocker.offset, to = glm::dot(blocker.normal, q) - blocker.offset;
  double depth = std::min(std::abs(from), std::abs(to));
  if (!(from * to < 0)) return -depth;
  const glm::dvec3 x = glm::mix(p, q, from / (from - to));
  for (uint32_t e = 0; e < blocker.corner_count; ++e)
    depth = std::min(depth, blocker.edge_offsets[e] - glm::dot(blocker.edge_normals[e], x));
  return depth;
}

// Returns how many of these lines pass through the blocker, more than kStrip from its edges.
int linesThrough(const Blocker& blocker, const Patch& a, const Patch& b) {
  int count = 0;
  for (const auto& line : linesBetween(a, b)) count += depthThrough(blocker, line) > kStrip;
  return count;
}

// Returns how many of these lines pass all blockers, more than kStrip from their edges.
int freeLines(const std::vector<Blocker>& blockers, std::span<const uint32_t> between, const Patch& a, const Patch& b) {
  int count = 0;
  for (const auto& line : linesBetween(a, b))
    count += std::ranges::all_of(between, [&](uint32_t k) { return depthThrough(blockers[k], line) < -kStrip; });
  return count;
}

// Where the search leaves out a pair, one blocker hides it, or several that share edges do and no line gets past them.
// Where the search leaves out a blocker, it stops no line of the pair.
TEST(PairFinder, ClustersDecideAsSinglePairs) {
  uint64_t found_count = 0, hidden_count = 0, left_out_count = 0, stopped_count = 0, curtain_count = 0, free_count = 0;
  for (const auto& [name, scene] : awkwardScenes()) {
    SCOPED_TRACE(name);
    const Ids ids = makeIds(scene, By::polygon, false);
    const PairFinder finder(scene, ids);
    if (finder.hasUnordered()) continue;
    const PatchPairs found = finder.find(2);
    std::map<std::pair<uint32_t, uint32_t>, const PatchPair*> by_patches;
    for (const PatchPair& pair : found.pairs) by_patches[{pair.a, pair.b}] = &pair;
    BlockerList all;
    all.clear(finder.blockers().size());
    for (uint32_t k = 0; k < finder.blockers().size(); ++k) all.add(k, finder.blockers()[k]);
    all.close();
    const HostUnoccluded unoccluded(scene);
    UnoccludedWork work;
    std::vector<uint32_t> between;
    // Every pair of a small scene is compared, and some pairs of a large one.
    const auto count = static_cast<uint32_t>(finder.patches().size()), step = 1 + count / 60;
    for (uint32_t p = 0; p < count; p += step)
      for (uint32_t q = p + 1; q < count; ++q) {
        const Patch &a = finder.patches()[p], &b = finder.patches()[q];
        if (a.plane == b.plane || !isInFront(a, b) || !isInFront(b, a)) continue;
        if (!(unoccluded.find({a.side, b.side}, work).area > 0)) continue;
        between.clear();
        const bool is_hidden = PatchShaft(a, b).isHidden(finder.blockers(), all, between, widestVectors());
        const auto at = by_patches.find({p, q});
        if (at == by_patches.end()) {
          ++hidden_count;
          // A patch may be covered by a face right in front of it. Then no pair has it.
          const auto isSeen = [&](uint32_t patch) {
            return std::ranges::any_of(found.pairs, [&](const PatchPair& pair) {
              const Patch &one = finder.patches()[pair.a], &other = finder.patches()[pair.b];
              return (pair.a == patch || pair.b == patch) && one.plane != other.plane;
            });
          };
          if (is_hidden || !isSeen(p) || !isSeen(q)) continue;
          ++curtain_count;
          EXPECT_GE(between.size(), 2u);
          EXPECT_EQ(freeLines(finder.blockers(), between, a, b), 0) << p << " " << q;
          continue;
        }
        ++found_count;
        EXPECT_FALSE(is_hidden) << p << " " << q;
        free_count += freeLines(finder.blockers(), between, a, b) > 0;
        std::set<uint32_t> kept;
        for (uint32_t k = 0; k < at->second->blocker_count; ++k)
          if (const PlacedBlocker& placed = found.between[at->second->first_blocker + k];
              placed.place == BlockerPlace::between)
            kept.insert(placed.blocker);
        for (const uint32_t k : between) {
          const int stopped = linesThrough(finder.blockers()[k], a, b);
          stopped_count += stopped > 0;
          if (kept.contains(k)) continue;
          ++left_out_count;
          EXPECT_EQ(stopped, 0) << "blocker " << k << " between " << p << " and " << q;
        }
        for (const uint32_t k : kept) EXPECT_TRUE(std::ranges::find(between, k) != between.end()) << k;
      }
  }
  EXPECT_GT(found_count, 10'000u);
  EXPECT_GT(hidden_count, 1'000u);
  EXPECT_GT(left_out_count, 100u);  // clusters may leave out more blockers than single pairs do
  EXPECT_GT(curtain_count, 500u);
  EXPECT_GT(stopped_count, 1'000u);  // the lines find pairs that blockers stop,
  EXPECT_GT(free_count, 1'000u);     // and pairs with free lines
}

// Two walls that meet at a corner hide together a square that neither hides alone. With a gap between them they do not.
TEST(PairFinder, WallsThatMeetHideTogether) {
  const auto isFound = [](double gap) {
    InputScene input{"walls", {}, {}};
    // A bent wall of two halves stands between two squares that face each other.
    ts::addFace(input, "left", ts::parallelogram({0, 0, 0}, {0, 1, 0}, {0, 0, 1}));
    ts::addFace(input, "right", ts::parallelogram({4, 0, 0}, {0, 0, 1}, {0, 1, 0}));
    ts::addFace(input, "first", ts::parallelogram({2.5, -3, -2}, {-0.5, 3.5 - gap, 0}, {0, 0, 5}));
    ts::addFace(input, "second", ts::parallelogram({2, 0.5, -2}, {0.5, 3.5, 0}, {0, 0, 5}));
    const Scene scene = buildScene(input);
    const PairFinder finder(scene, makeIds(scene, By::polygon, false));
    return std::ranges::any_of(finder.find(1).pairs, [](const PatchPair& pair) { return pair.a == 0 && pair.b == 1; });
  };
  EXPECT_FALSE(isFound(0));
  EXPECT_TRUE(isFound(1e-3));
  EXPECT_TRUE(isFound(1e-6));
}

bool areAlike(const PatchPairs& x, const PatchPairs& y) {
  const auto isSame = [](const PatchPair& p, const PatchPair& q) {
    return p.a == q.a && p.b == q.b && p.exchange == q.exchange && p.first_blocker == q.first_blocker &&
           p.blocker_count == q.blocker_count;
  };
  const auto isSameBlocker = [](const PlacedBlocker& p, const PlacedBlocker& q) {
    return p.blocker == q.blocker && p.place == q.place;
  };
  return std::ranges::equal(x.pairs, y.pairs, isSame) && std::ranges::equal(x.between, y.between, isSameBlocker);
}

// Two walls that meet at a corner hide a box from a square, unless there is a gap between them, the box is so large
// that a line past the ends of the walls reaches it, or it touches a wall.
TEST(PairFinder, WallsThatMeetHideABox) {
  const auto isHidden = [](double gap, const Box& box) {
    InputScene input{"walls", {}, {}};
    ts::addFace(input, "left", ts::parallelogram({0, 0, 0}, {0, 1, 0}, {0, 0, 1}));
    ts::addFace(input, "first", ts::parallelogram({2.5, -3, -2}, {-0.5, 3.5 - gap, 0}, {0, 0, 5}));
    ts::addFace(input, "second", ts::parallelogram({2, 0.5, -2}, {0.5, 3.5, 0}, {0, 0, 5}));
    const Scene scene = buildScene(input);
    const PairFinder finder(scene, makeIds(scene, By::polygon, false));
    const auto inBall = [&](const glm::dvec3& corner) { return (corner - scene.centre) / scene.scale; };
    const Box placed{inBall(box.low), inBall(box.high)};
    const Patch& left = finder.patches()[0];
    const Shaft shaft(left, placed);
    BlockerList all, inside;
    all.clear(finder.blockers().size());
    for (uint32_t k = 0; k < finder.blockers().size(); ++k) all.add(k, finder.blockers()[k]);
    all.close();
    shaft.keepInside(all, inside, widestVectors());
    EXPECT_EQ(inside.size(), 2u);
    Curtain curtain(finder.blockers(), finder.mesh());
    return curtain.hides(left, placed, shaft, inside, widestVectors());
  };
  EXPECT_TRUE(isHidden(0, {{4, 0, 0}, {5, 1, 1}}));
  EXPECT_FALSE(isHidden(0, {{-1, 0, 0}, {9, 1, 1}}));
  EXPECT_TRUE(isHidden(0, {{2.6, 0, 0}, {5, 1, 1}}));
  EXPECT_FALSE(isHidden(0, {{2, 0, 0}, {5, 1, 1}}));
  EXPECT_FALSE(isHidden(0, {{4, 0, 0}, {5, 12, 1}}));
  EXPECT_FALSE(isHidden(1e-3, {{4, 0, 0}, {5, 1, 1}}));
  EXPECT_FALSE(isHidden(1e-6, {{4, 0, 0}, {5, 1, 1}}));
}

// The wall that a patch is a part of hides nothing from the patch. Corners in single precision may lie behind their own
// wall, by more than kTouchingShaft.
TEST(PairFinder, APatchIsNotBehindItsOwnWall) {
  uint64_t behind_count = 0;
  for (const uint64_t seed : {1u, 2u, 3u}) {
    const Scene scene = buildScene(ts::roundedToSingle(bench::triangulatedCity(1000, seed).scene));
    const PairFinder finder(scene, makeIds(scene, By::polygon, false));
    for (const Patch& patch : finder.patches()) {
      const Box own{patch.low, patch.high},
          other{patch.middle + 0.5 * patch.normal - 1e-3, patch.middle + 0.5 * patch.normal + 1e-3};
      for (const Blocker& blocker : finder.blockers()) {
        if (blocker.plane != patch.plane) continue;
        behind_count += std::ranges::all_of(patch.corners, [&](const glm::dvec3& corner) {
          const double height = glm::dot(blocker.normal, corner) - blocker.offset;
          return (glm::dot(blocker.normal, patch.normal) > 0 ? height : -height) < -kTouchingShaft;
        });
        EXPECT_FALSE(Corners(patch, other).areHidden(blocker, widestVectors()));
        EXPECT_FALSE(Corners(own, other).areHidden(blocker, widestVectors()));
        EXPECT_FALSE(areApart(own, blocker) && covers(blocker, patch));
      }
    }
  }
  EXPECT_GT(behind_count, 10u);
}

// The sample of samplePairs() has 4,096 pairs of any two of n patches, so that its standard error is below
// n^2 / 4 / 64. Five standard errors are allowed. A curtain may hide a row of patches, though it is not found for each
// of its pairs.
TEST(PairFinder, SinglePairsAreCounted) {
  for (const InputScene& input : {bench::roomWithBoxes(1), bench::triangulatedCity(1000).scene, bench::city(1000)}) {
    SCOPED_TRACE(input.file);
    const Scene scene = buildScene(input);
    const Ids ids = makeIds(scene, By::polygon, false);
    const PairFinder finder(scene, ids);
    std::vector<std::pair<uint32_t, uint32_t>> all;
    const auto patch_count = static_cast<uint32_t>(finder.patches().size());
    for (uint32_t p = 0; p < patch_count; ++p)
      for (uint32_t q = 0; q < p; ++q) all.emplace_back(p, q);
    const size_t found = finder.find(2).pairs.size();
    const auto countAmong = [&](std::span<const std::pair<uint32_t, uint32_t>> pairs) {
      return finder.findAmong(pairs, 2).found.size();
    };
    const size_t each = countAmong(all);
    EXPECT_GE(each, found);
    EXPECT_LT(double(each), 1.02 * double(found));
    EXPECT_EQ(countAmong(std::span(all).first(all.size() / 2)) + countAmong(std::span(all).subspan(all.size() / 2)),
              each);
    constexpr double kLeast = 1e-3;
    const PairNumbers numbers = PairLines(scene, ids, {}, 1).samplePairs().numbersFor(kLeast);
    const double allowed = 5 * patch_count / 16.0 * patch_count / 16.0;
    EXPECT_NEAR(numbers.found, double(found), allowed);
    const PatchPairs large = finder.find(2, {}, kLeast);
    EXPECT_NEAR(numbers.large, double(large.pairs.size()), allowed);
    EXPECT_LT(numbers.large, numbers.found);
    EXPECT_GT(numbers.blocked, 0);
    EXPECT_LT(numbers.blocked, numbers.found);
    EXPECT_LE(numbers.found, numbers.decided);
    EXPECT_LE(numbers.decided, numbers.facing);
    EXPECT_LT(numbers.found, numbers.facing);
    EXPECT_GT(numbers.facing, 1.2 * double(found));
  }
}

TEST(PairFinder, ThreadsDoNotMatter) {
  const Scene scene = buildScene(bench::triangulatedCity(1000, 2).scene);
  const Ids ids = makeIds(scene, By::polygon, false);
  const PairFinder finder(scene, ids);
  const PatchPairs one = finder.find(1);
  EXPECT_GT(one.pairs.size(), 10'000u);
  EXPECT_TRUE(areAlike(one, finder.find(3)));
  EXPECT_FALSE(areAlike(one, finder.find(3, {}, 1e-3)));
}

// A least form factor leaves out the pairs below it, and no others. The parts of two rows are left out together, and
// only where all of them are below it.
TEST(PairFinder, ALeastFormFactorLeavesOutSmallPairs) {
  size_t kept_parts = 0, parts_left_out = 0;
  for (const auto& [name, scene] : awkwardScenes()) {
    SCOPED_TRACE(name);
    const Ids ids = makeIds(scene, By::polygon, false);
    const PairFinder finder(scene, ids);
    if (finder.hasUnordered()) continue;
    const PatchPairs all = finder.find(1);
    for (const double least : {1e-4, 1e-3, 1e-2, 0.1}) {
      std::vector<std::array<double, 4>> expected, found;
      const auto entryOf = [](const PatchPair& pair) {
        return std::array{double(pair.a), double(pair.b), pair.exchange, double(pair.blocker_count)};
      };
      const auto rowsOf = [&](const PatchPair& pair) {
        return std::minmax(finder.patches()[pair.a].id, finder.patches()[pair.b].id);
      };
      std::map<std::pair<uint32_t, uint32_t>, std::pair<double, size_t>> exchanges, kept;  // of rows, with their parts
      for (const PatchPair& pair : all.pairs) {
        const Patch &a = finder.patches()[pair.a], &b = finder.patches()[pair.b];
        if (a.is_part || b.is_part) {
          auto& [exchange, count] = exchanges[rowsOf(pair)];
          exchange += pair.exchange, ++count;
        } else if (!(pair.exchange < least * std::min(a.area, b.area))) {
          expected.push_back(entryOf(pair));
        }
      }
      for (const PatchPair& pair : finder.find(1, {}, least).pairs) {
        const bool is_of_parts = finder.patches()[pair.a].is_part || finder.patches()[pair.b].is_part;
        if (is_of_parts) ++kept[rowsOf(pair)].second;
        else found.push_back(entryOf(pair));
      }
      EXPECT_EQ(found, expected) << least;
      const double unit = 1 / (scene.scale * scene.scale);
      for (const auto& [rows, of_all] : exchanges) {
        const size_t count = kept[rows].second;
        kept_parts += count, parts_left_out += of_all.second - count;
        if (of_all.first >= least * std::min(ids.areas[rows.first], ids.areas[rows.second]) * unit)
          EXPECT_EQ(count, of_all.second) << ids.names[rows.first] << " " << ids.names[rows.second];
        else EXPECT_TRUE(count == 0 || count == of_all.second);
      }
    }
  }
  EXPECT_GT(kept_parts, 0u);
  EXPECT_GT(parts_left_out, 0u);
}

// All sides of two polygons stay, or none: the sum over their sides decides.
TEST(PairFinder, SidesOfTwoSidedPolygonsAreLeftOutTogether) {
  const Scene scene = buildScene(ts::triangleSoup(80, 0.5, 2));
  const Ids ids = makeIds(scene, By::polygon, true);
  const PairFinder finder(scene, ids);
  ASSERT_FALSE(finder.hasUnordered());
  const HostUnoccluded unoccluded(scene);
  UnoccludedWork work;
  const PatchPairs all = finder.find(1);
  for (const double least : {1e-4, 1e-3, 1e-2, 0.03}) {
    SCOPED_TRACE(least);
    std::vector<std::pair<uint32_t, uint32_t>> expected, found;
    size_t large_together = 0;
    for (const PatchPair& pair : all.pairs) {
      const Patch &a = finder.patches()[pair.a], &b = finder.patches()[pair.b];
      const uint32_t p = a.side / 2, q = b.side / 2;
      double exchange = 0;
      for (const uint32_t side_p : {frontSide(p), backSide(p)})
        for (const uint32_t side_q : {frontSide(q), backSide(q)})
          exchange += unoccluded.findClosely({side_p, side_q}, work).area;
      const double smaller = 2 * std::min(scene.polygons[p].area, scene.polygons[q].area);
      if (!(exchange < least * smaller)) expected.emplace_back(pair.a, pair.b);
      large_together += exchange >= least * smaller && pair.exchange < least * smaller;
    }
    for (const PatchPair& pair : finder.find(1, {}, least).pairs) found.emplace_back(pair.a, pair.b);
    EXPECT_EQ(found, expected);
    EXPECT_LT(found.size(), all.pairs.size());
    EXPECT_GT(large_together, 5u);
  }
}

// The sum over the parts of a face decides: a pair of faces stays even if each pair of their parts is below the least
// form factor.
TEST(PairFinder, PartsOfAFaceAreKept) {
  // The star over the square is cut into several convex parts.
  InputScene input{"star", {}, {}};
  ts::addFace(input, "square", ts::parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  ts::Corners star;
  for (int k = 0; k < 10; ++k) {
    const double angle = -0.628318530717958648 * k, radius = k % 2 ? 0.3 : 1;
    star.push_back({radius * std::cos(angle), radius * std::sin(angle), 1});
  }
  ts::addFace(input, "star", star);
  const Scene scene = buildScene(input);
  ASSERT_GT(scene.polygons.size(), 3u);
  const Ids ids = makeIds(scene, By::polygon, false);
  PairLines lines(scene, ids, {}, 1, 1);
  const std::vector<LinePair> whole = lines.find();
  ASSERT_EQ(whole.size(), 1u);
  const double form_factor = whole[0].exchange / std::min(ids.areas[0], ids.areas[1]);
  EXPECT_EQ(lines.find(0.9 * form_factor), whole);
  EXPECT_TRUE(lines.find(1.1 * form_factor).empty());
}

}  // namespace
}  // namespace viewpeel
