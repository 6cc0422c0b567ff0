// The functions here predict the work of a direction on a lattice, and the variance of its counts, from the sizes of
// the polygons alone.
#include <numbers>

#include "engines/lattice.h"
#include "estimator/planner.h"
#include "scene/perimeter.h"
#include "scene/rank_by_place.h"
#include "sums/pair_count.h"

namespace viewpeel {
namespace {

// Every id is to get kLatticePoints lattice points, or scanlines, in kUsualReplicates replicates.
constexpr double kLatticePoints = 100, kUsualReplicates = 8;
// A plan expects at most this share of the largest count that fits, because some directions count more than the mean.
constexpr double kAllowed = 0.8;

}  // namespace

double latticeVariance(Sampling sampling, double perimeter_per_area_squared, double area, double h) {
  if (sampling == Sampling::scanline)
    return std::min(0.061 * h * h * h * perimeter_per_area_squared, std::numbers::sqrt2 * h / std::sqrt(area));
  return std::min(0.229 * h * h * h * perimeter_per_area_squared, 2 * h * h / area);
}

std::vector<double> perimetersPerAreaSquared(const Scene& scene, const Ids& ids) {
  std::vector<double> ratios(ids.count(), 0);
  for (size_t k = 0; k < scene.polygons.size(); ++k) ratios[ids.of_polygon[k]] += perimeterOf(scene, scene.polygons[k]);
  for (uint32_t id = 0; id < ids.count(); ++id) ratios[id] /= std::pow(ids.areas[id] / (scene.scale * scene.scale), 2);
  return ratios;
}

std::vector<double> finenessOf(const std::vector<double>& perimeters_per_area_squared) {
  const double most = *std::max_element(perimeters_per_area_squared.begin(), perimeters_per_area_squared.end());
  std::vector<double> fineness;
  for (double ratio : perimeters_per_area_squared) fineness.push_back(std::cbrt(ratio / most));
  return fineness;
}

double neededResolution(Sampling sampling, double fineness, double area, int finest, double directions) {
  // This is the number of points that all directions give the id on a lattice of resolution 1, where h is 2.
  const double times = expectedPoints(sampling, area, 2) * kUsualReplicates * directions;
  return std::max(fineness * finest,
                  sampling == Sampling::scanline ? kLatticePoints / times : std::sqrt(kLatticePoints / times));
}

Planner::Planner(const Scene& scene, const Ids& ids, const EstimateOptions& options, const Lattices& lattices)
    : scene_(scene), ids_(ids), options_(options), lattices_(lattices), ratios_(perimetersPerAreaSquared(scene, ids)) {
  const std::vector<double> fineness = finenessOf(ratios_);
  for (double area : ids.areas) {
    areas_.push_back(area / (scene.scale * scene.scale));
    whole_area_ += areas_.back();
  }
  std::map<int, SizeClass> classes;
  for (size_t k = 0; k < scene.polygons.size(); ++k) {
    const uint32_t id = ids.of_polygon[k];
    SizeClass& size = classes[static_cast<int>(std::ceil(4 * std::log2(fineness[id])))];
    size.fineness = std::max(size.fineness, fineness[id]);
    size.perimeter_per_area_squared = std::max(size.perimeter_per_area_squared, ratios_[id]);
    size.area += scene.polygons[k].area / whole_area_;
    size.least_area = std::min(size.least_area, areas_[id]);
    size.radius = std::max(size.radius, boxRadius(scene, static_cast<uint32_t>(k)));
    size.polygons.push_back(static_cast<uint32_t>(k));
  }
  std::vector<double> faces(scene.faces.size(), 0);
  for (const Polygon& polygon : scene.polygons)
    largest_face_ = std::max(largest_face_, faces[polygon.face] += polygon.area);
  for (const auto& [key, size] : classes) classes_.push_back(size);
  if (lattices.face_ids) {
    id_of_face_.resize(lattices.face_ids->count());
    for (uint32_t k = 0; k < scene.polygons.size(); ++k)
      id_of_face_[lattices.face_ids->of_polygon[k]] = ids.of_polygon[k];
  }
  if (lattices.face_ids && options.by == By::polygon && !options.relative && pairCount(ids.count()) <= kMostRowPairs)
    ranks_ = rankByPlace(scene, ids.of_polygon, ids.count());
}

double Planner::neededBy(const SizeClass& size, const Shape& shape, double directions) const {
  return neededResolution(lattices_.lattice.sampling, size.fineness, size.least_area, shape.finest, directions);
}

std::vector<SizeGroup> Planner::groupsOf(const Shape& shape, double directions) const {
  if (lattices_.may_group)
    return planGroups(scene_, ids_, lattices_.lattice.sampling, shape.base, shape.finest, directions);
  return groupAsOne(scene_, shape.base);
}

Load Planner::loadOf(const Shape& shape, double directions) const {
  const bool is_scanline = lattices_.lattice.sampling == Sampling::scanline;
  Load load{1, is_scanline ? double(shape.base) : double(shape.base) * shape.base};
  std::map<double, double> fine;  // share of the area by resolution
  const std::vector<int> resolutions = resolutionsOf(shape, directions);
  load.finest = *std::max_element(resolutions.begin(), resolutions.end());
  for (size_t k = 0; k < classes_.size(); ++k) {
    const SizeClass& size = classes_[k];
    const double resolution = resolutions[k];
    if (resolution > shape.base) fine[resolution] += size.area;
    load.variance = std::max(load.variance, latticeVariance(lattices_.lattice.sampling, size.perimeter_per_area_squared,
                                                            size.least_area, 2 / resolution));
    // This is D_0 of docs/method.md, eq. (12), as a form factor: one line, and the lines that come with it on the
    // average.
    if (ranks_.empty()) load.line = std::max(load.line, 8 / (resolution * resolution * size.least_area) + 8 / 27.0);
  }
  // A window is larger than its polygons: it is taken for twice their share of the area.
  for (const auto& [resolution, share] : fine)
    load.points += (is_scanline ? resolution : resolution * resolution) * std::min(1.0, 2 * share);
  load.groups += double(windowsOf(resolutions, shape.base));
  return load;
}

// Returns the resolution that groupBySize() gives each size class: int[class]. No resolution is beyond the finest
// window, and there are no more windows than kMostWindows.
std::vector<int> Planner::resolutionsOf(const Shape& shape, double directions) const {
  std::vector<int> resolutions(classes_.size(), shape.base);
  for (int finest = maxWindowResolution(lattices_.lattice.sampling); lattices_.may_group; finest /= kGroupStep) {
    bool is_fine = false;
    for (size_t k = 0; k < classes_.size(); ++k) {
      int& resolution = resolutions[k] = shape.base;
      const double needed = neededBy(classes_[k], shape, directions) * kEnough;
      while (resolution < needed && resolution <= finest / kGroupStep &&
             classes_[k].radius * resolution * kGroupStep <= kMostWindowPoints)
        resolution *= kGroupStep;
      is_fine = is_fine || resolution > shape.base;
    }
    if (!is_fine || windowsOf(resolutions, shape.base) <= kMostWindows) break;
  }
  return resolutions;
}

// Returns the number of windows beside the whole scene's lattice. The size classes are sorted, so classes of one
// resolution follow each other.
size_t Planner::windowsOf(const std::vector<int>& resolutions, int base) const {
  size_t windows = 0;
  for (size_t first = 0, end = 0; first < resolutions.size(); first = end) {
    for (end = first; end < resolutions.size() && resolutions[end] == resolutions[first];) ++end;
    if (resolutions[first] == base) continue;
    size_t& count = windows_[{static_cast<int>(first), static_cast<int>(end), resolutions[first]}];
    if (count == 0) {
      std::vector<uint32_t> polygons;
      for (size_t k = first; k < end; ++k)
        polygons.insert(polygons.end(), classes_[k].polygons.begin(), classes_[k].polygons.end());
      count = countWindows(scene_, std::move(polygons), resolutions[first]);
    }
    windows += count;
  }
  return windows;
}

// Returns whether sums with unoccluded form factors would overflow (control_variate_sums.h). Three sums may overflow:
// the counts of a row in one replicate, the counts of all faces of a surface, and the squares over all replicates. The
// mean projection of a face is half of its area.
bool Planner::areCountsTooLarge(const Load& load, double directions, double replicates) const {
  if (id_of_face_.empty()) return false;
  const double count_area =
      pointArea(load.finest) / (lattices_.lattice.sampling == Sampling::scanline ? 1 << kScanlineBits : 1);
  const double of_row = directions * largest_face_ / 2 / count_area, of_all = directions * whole_area_ / 2 / count_area,
               most = kAllowed * double(kMostCounts);
  return of_row > most || of_all > 2 * most || replicates * of_row * of_row > 8 * most * most;
}

// Returns the predicted seconds of a direction. The model is one cost per group and one cost per lattice point. Where
// the timed lattices do not separate the two costs, each gets half of the time.
double Planner::secondsOf(const Load& load) const {
  if (lattices_.costs) return load.groups * lattices_.costs->of_group + load.points * lattices_.costs->of_point;
  const Timing& last = timings_.back();
  double per_group = 0.5 * last.seconds / last.load.groups, per_point = 0.5 * last.seconds / last.load.points;
  for (const Timing& timing : timings_) {
    const double determinant = timing.load.groups * last.load.points - last.load.groups * timing.load.points;
    if (std::abs(determinant) < 0.5 * timing.load.groups * last.load.points) continue;
    per_point = std::clamp((timing.load.groups * last.seconds - last.load.groups * timing.seconds) / determinant, 0.0,
                           last.seconds / last.load.points);
    per_group = (last.seconds - per_point * last.load.points) / last.load.groups;
  }
  return per_group * load.groups + per_point * load.points;
}

// Returns the seconds that all pilots took, or should have taken by the costs that are given.
double Planner::secondsOfPilots() const {
  if (!lattices_.costs) return pilot_seconds_;
  double seconds = 0;
  for (const Pilot& pilot : pilots_) seconds += 2 * kPilotReplicates * double(pilot.directions) * secondsOf(pilot.load);
  return seconds;
}

std::vector<SizeGroup> planGroups(const Scene& scene, const Ids& ids, Sampling sampling, int base, int finest,
                                  double directions) {
  const std::vector<double> fineness = finenessOf(perimetersPerAreaSquared(scene, ids));
  std::vector<double> needed;
  for (uint32_t id : ids.of_polygon)
    needed.push_back(
        neededResolution(sampling, fineness[id], ids.areas[id] / (scene.scale * scene.scale), finest, directions));
  return groupBySize(scene, needed, base, maxWindowResolution(sampling));
}

}  // namespace viewpeel
