#include "scene/polygon_tree.h"

#include <algorithm>
#include <cmath>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/geometries/segment.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <glm/glm.hpp>

namespace viewpeel {
namespace {

namespace bg = boost::geometry;
using Point = bg::model::point<double, 3, bg::cs::cartesian>;
using Box = bg::model::box<Point>;
using Segment = bg::model::segment<Point>;
using Entry = std::pair<Box, uint32_t>;

constexpr double kBeyondScene = 4;  // a ray's length: the scene lies in the unit ball

Point pointAt(const glm::dvec3& x) { return {x.x, x.y, x.z}; }

Box boxOf(const Scene& scene, const Polygon& polygon, double reach) {
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (uint32_t k = 0; k < polygon.corner_count; ++k) {
    low = glm::min(low, scene.corners[polygon.first_corner + k]);
    high = glm::max(high, scene.corners[polygon.first_corner + k]);
  }
  return {pointAt(low - reach), pointAt(high + reach)};
}

}  // namespace

struct PolygonTree::Boxes {
  bg::index::rtree<Entry, bg::index::linear<16>> tree;
};

PolygonTree::PolygonTree(const Scene& scene) : scene_(scene), boxes_(std::make_unique<Boxes>()) {
  std::vector<Entry> entries;
  entries.reserve(scene.polygons.size());
  for (const Polygon& polygon : scene.polygons)
    entries.emplace_back(boxOf(scene, polygon, 0), static_cast<uint32_t>(entries.size()));
  boxes_->tree = decltype(boxes_->tree)(entries);
}

PolygonTree::~PolygonTree() = default;

void PolygonTree::forEachNear(uint32_t polygon, double reach, const std::function<void(uint32_t)>& use) const {
  const Box box = boxOf(scene_, scene_.polygons[polygon], reach);
  for (auto at = boxes_->tree.qbegin(bg::index::intersects(box)); at != boxes_->tree.qend(); ++at) use(at->second);
}

std::vector<PolygonTree::Hit> PolygonTree::cast(const glm::dvec3& origin, const glm::dvec3& direction,
                                                double least_distance) const {
  std::vector<Hit> hits;
  const Segment ray(pointAt(origin), pointAt(origin + kBeyondScene * direction));
  for (auto at = boxes_->tree.qbegin(bg::index::intersects(ray)); at != boxes_->tree.qend(); ++at) {
    const Polygon& polygon = scene_.polygons[at->second];
    const glm::dvec3* corners = &scene_.corners[polygon.first_corner];
    const glm::dvec3 normal = frontNormal(scene_, polygon);
    const double along = glm::dot(normal, direction);
    if (along == 0) continue;
    const double distance = glm::dot(normal, corners[0] - origin) / along;
    if (!(distance > least_distance)) continue;
    const glm::dvec3 point = origin + distance * direction;
    bool is_inside = true;
    for (uint32_t k = 0; k < polygon.corner_count && is_inside; ++k) {
      const glm::dvec3 edge = corners[(k + 1) % polygon.corner_count] - corners[k];
      is_inside = glm::dot(normal, glm::cross(edge, point - corners[k])) >= -1e-14 * glm::length(edge);
    }
    if (is_inside) hits.push_back({distance, at->second, point, along < 0});
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.polygon < b.polygon;
  });
  return hits;
}

}  // namespace viewpeel
