#include "bench/support/truth.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "scenes/generate.h"
#include "scenes/named_scenes.h"
#include "scenes/triangulated_city.h"

namespace viewpeel::bench {
namespace {

constexpr uint64_t kReferenceSeed = 1'000'000;
constexpr size_t kMostFaces = 8'000, kRows = 48;  // scenes of more faces have a truth of kRows rows, others of all

Scene office() { return loadScene(VIEWPEEL_SOURCE "/scenes/office.obj"); }

const std::vector<std::pair<std::string, std::function<Scene()>>>& makers() {
  static const std::vector<std::pair<std::string, std::function<Scene()>>> all{
      {"office", office},
      {"room", [] { return buildScene(roomWithBoxes(1)); }},
      {"street", [] { return loadScene(VIEWPEEL_SOURCE "/scenes/street.obj"); }},
      {"city1000", [] { return buildScene(triangulatedCity(1000).scene); }},
      {"two_sided", [] { return buildScene(randomTriangles(200)); }},
      {"touching", [] { return buildScene(test_scenes::roomWithTouchingBoxes()); }},
      {"room2496", [] { return buildScene(roomWithBoxes(2)); }},
      {"city2900", [] { return buildScene(triangulatedCity(2900).scene); }},
      {"city2900_two_sided", [] { return buildScene(triangulatedCity(2900).scene); }},
      {"office9280", [] { return buildScene(refined(office(), 4)); }},
      {"city10000", [] { return buildScene(triangulatedCity(10'000).scene); }},
      {"city19572", [] { return buildScene(city(19'760)); }},
      {"room39936", [] { return buildScene(roomWithBoxes(8)); }},
  };
  return all;
}

// Returns the names of the rows that the truth has. The list is empty if it has all rows.
std::vector<std::string> rowsOf(const Scene& scene) {
  std::vector<std::string> rows;
  if (scene.faces.size() <= kMostFaces) return rows;
  const Ids ids = makeIds(scene, By::polygon, false);
  for (size_t k = 0; k < kRows; ++k) rows.push_back(ids.names[(2 * k + 1) * ids.count() / (2 * kRows)]);
  return rows;
}

}  // namespace

const std::vector<std::string>& judgedScenes() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const auto& [name, make] : makers()) all.push_back(name);
    return all;
  }();
  return names;
}

Scene makeJudgedScene(const std::string& name) {
  return std::ranges::find(makers(), name, [](const auto& maker) { return maker.first; })->second();
}

Request requestFor(const std::string& scene, double tolerance, uint64_t seed) {
  Request request;
  request.goal = Tolerance{tolerance};
  request.promise = false;
  request.seed = seed;
  request.two_sided = scene.ends_with("two_sided");
  return request;
}

FormFactors computeTruth(const Scene& scene, const std::string& name, double tolerance) {
  Request request = requestFor(name, tolerance, kReferenceSeed);
  request.question.from = rowsOf(scene);
  return computeFormFactors(scene, request).form_factors;
}

double largestErrorOf(const FormFactors& truth) {
  double largest = 0;
  for (const FormFactors::Entry& entry : truth.entries())
    largest = std::max(largest, entry.exchange_area.standard_error / truth.ids().smallerArea(entry.i, entry.j));
  return largest;
}

Comparison compare(const FormFactors& found, const FormFactors& truth) {
  const Ids& ids = truth.ids();
  std::map<std::pair<uint32_t, uint32_t>, std::pair<Measured, Measured>> both;
  for (const FormFactors::Entry& entry : truth.entries()) both[{entry.i, entry.j}].second = entry.exchange_area;
  for (const FormFactors::Entry& entry : found.entries())
    if (ids.isRequested(entry.i) || (entry.j < kEnvironment && ids.isRequested(entry.j)))
      both[{entry.i, entry.j}].first = entry.exchange_area;
  Comparison all;
  std::vector<double> sums(ids.count());
  for (const auto& [pair, measured] : both) {
    const auto& [here, there] = measured;
    const double difference = std::abs(here.value - there.value);
    all.largest = std::max(all.largest, difference / ids.smallerArea(pair.first, pair.second));
    if (pair.second < kEnvironment)
      for (const uint32_t id : {pair.first, pair.second}) sums[id] += (here.value - there.value) / ids.areas[id];
    if (!(here.standard_error > 0)) continue;  // exact, or missing in the run that is judged
    ++all.entries;
    all.beyond += difference > 5 * std::hypot(here.standard_error, there.standard_error);
  }
  for (uint32_t id = 0; id < ids.count(); ++id)
    if (ids.isRequested(id)) all.largest_of_sums = std::max(all.largest_of_sums, std::abs(sums[id]));
  return all;
}

}  // namespace viewpeel::bench
