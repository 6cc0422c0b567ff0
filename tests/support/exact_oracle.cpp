#include "tests/support/exact_oracle.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <gmpxx.h>

#include "facing.h"
#include "sums/pair_count.h"

namespace viewpeel::tests {
namespace {

struct Layer {
  mpq_class height;
  uint32_t polygon;
  bool front_up;
};

// Calls add(a, b) for every gap of a line that counts, and block(a, b) for every blocked pair.
template <class Layers, class Add, class Block>
void classifyLine(const Layers& layers, bool two_sided, const Add& add, const Block& block) {
  for (size_t k = 0; k <= layers.size(); ++k) {
    const uint lower = k == 0 ? kSideNone : sideTowardsGap(layers[k - 1].front_up, two_sided, true);
    const uint upper = k == layers.size() ? kSideNone : sideTowardsGap(layers[k].front_up, two_sided, false);
    const uint32_t low = k == 0 ? 0 : layers[k - 1].polygon, high = k == layers.size() ? 0 : layers[k].polygon;
    switch (classifyGap(lower, upper)) {
      case kGapFacingPair:
        add(std::min(low, high), std::max(low, high));
        break;
      case kGapLowerEnvironment:
        add(low, kEnvironment);
        break;
      case kGapUpperEnvironment:
        add(high, kEnvironment);
        break;
      case kGapLowerLeak:
        add(low, kLeak);
        break;
      case kGapUpperLeak:
        add(high, kLeak);
        break;
      default:
        break;
    }
  }
  for (size_t far = 0; far < layers.size(); ++far)
    for (size_t near = 0; near + 1 < far; ++near)
      if (two_sided || (layers[near].front_up && !layers[far].front_up))
        block(std::min(layers[near].polygon, layers[far].polygon), std::max(layers[near].polygon, layers[far].polygon));
}

struct Point {
  mpq_class x, y;
};

mpq_class cross(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

struct Outline {
  uint32_t polygon;
  bool front_up;
  std::vector<Point> corners;
};

struct Frame {  // u has components u_i, u_j, u_k along axes i, j, k; k has the largest
  int i, j, k;
  explicit Frame(const glm::dvec3& u) {
    k = std::abs(u.x) > std::abs(u.y) ? 0 : 1;
    if (std::abs(u.z) >= std::abs(u[k])) k = 2;
    i = k == 0 ? 1 : 0;
    j = k == 2 ? 1 : 2;
  }
};

mpq_class exactDot(const glm::dvec3& a, const glm::dvec3& b) {
  mpq_class sum = 0;
  for (int k = 0; k < 3; ++k) sum += mpq_class(a[k]) * mpq_class(b[k]);
  return sum;
}

bool contains(const Outline& outline, const Point& p) {
  bool inside = false;
  for (size_t k = 0; k < outline.corners.size(); ++k) {
    const Point &a = outline.corners[k], &b = outline.corners[(k + 1) % outline.corners.size()];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if ((sgn(cross(a, b, p)) > 0) == (b.y > a.y)) inside = !inside;
  }
  return inside;
}

}  // namespace

SlabAreas cutIntoSlabs(const Scene& scene, const glm::dvec3& u, bool two_sided) {
  const Frame frame(u);
  std::vector<Outline> outlines;
  std::vector<std::pair<Point, Point>> edges;
  std::vector<mpq_class> cuts;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const Polygon& polygon = scene.polygons[p];
    const int sign = sgn(exactDot(scene.planes[polygon.plane].normal, u));
    if (sign == 0) continue;
    Outline outline{p, polygon.front_along_plane_normal == (sign > 0), {}};
    for (uint32_t c = 0; c < polygon.corner_count; ++c) {
      const glm::dvec3& corner = scene.corners[polygon.first_corner + c];
      const mpq_class z = mpq_class(corner[frame.k]) / mpq_class(u[frame.k]);
      outline.corners.push_back({corner[frame.i] - z * u[frame.i], corner[frame.j] - z * u[frame.j]});
    }
    for (size_t c = 0; c < outline.corners.size(); ++c) {
      Point a = outline.corners[c], b = outline.corners[(c + 1) % outline.corners.size()];
      cuts.push_back(a.x);
      if (a.x == b.x) continue;
      edges.push_back(a.x < b.x ? std::pair(a, b) : std::pair(b, a));
    }
    outlines.push_back(std::move(outline));
  }
  for (size_t e = 0; e < edges.size(); ++e)
    for (size_t f = 0; f < e; ++f) {
      const auto& [a, b] = edges[e];
      const auto& [c, d] = edges[f];
      const mpq_class c_side = cross(a, b, c), d_side = cross(a, b, d);
      if (sgn(c_side) * sgn(d_side) >= 0 || sgn(cross(c, d, a)) * sgn(cross(c, d, b)) >= 0) continue;
      cuts.push_back(c.x + (d.x - c.x) * c_side / (c_side - d_side));
    }
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());

  SlabAreas areas;
  const double factor = std::abs(u[frame.k]) / glm::length(u);
  for (size_t s = 0; s + 1 < cuts.size(); ++s) {
    const mpq_class middle = (cuts[s] + cuts[s + 1]) / 2, width = cuts[s + 1] - cuts[s];
    std::vector<mpq_class> heights;
    for (const auto& [a, b] : edges)
      if (a.x < middle && b.x > middle) heights.push_back(a.y + (b.y - a.y) * (middle - a.x) / (b.x - a.x));
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    for (size_t h = 0; h + 1 < heights.size(); ++h) {
      const Point point{middle, (heights[h] + heights[h + 1]) / 2};
      std::vector<Layer> layers;
      for (const Outline& outline : outlines) {
        if (!contains(outline, point)) continue;
        const Plane& plane = scene.planes[scene.polygons[outline.polygon].plane];
        const mpq_class base = plane.normal[frame.i] * point.x + plane.normal[frame.j] * point.y;
        layers.push_back({(plane.offset - base) / exactDot(plane.normal, u), outline.polygon, outline.front_up});
      }
      std::sort(layers.begin(), layers.end(), [](const Layer& p, const Layer& q) {
        if (const int order = cmp(p.height, q.height)) return order < 0;
        return p.front_up != q.front_up ? p.front_up : p.polygon < q.polygon;
      });
      const double area = factor * mpq_class(width * (heights[h + 1] - heights[h])).get_d();
      classifyLine(
          layers, two_sided,
          [&](uint32_t a, uint32_t b) {
            areas.pairs[{a, b}] += area;
          },
          [&](uint32_t a, uint32_t b) {
            areas.blocked[{a, b}] += area;
          });
    }
  }
  return areas;
}

namespace {

// Returns two unit vectors that are orthogonal to u and right-handed with it.
std::pair<glm::dvec3, glm::dvec3> axesAcross(const glm::dvec3& u) {
  const glm::dvec3 other = std::abs(u.x) < 0.7 * glm::length(u) ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(other, u));
  return {x, glm::normalize(glm::cross(u, x))};
}

std::vector<glm::dvec2> project(const Scene& scene, const Polygon& polygon, const glm::dvec3& x, const glm::dvec3& y) {
  std::vector<glm::dvec2> result;
  for (uint32_t c = 0; c < polygon.corner_count; ++c) {
    const glm::dvec3& corner = scene.corners[polygon.first_corner + c];
    result.emplace_back(glm::dot(corner, x), glm::dot(corner, y));
  }
  return result;
}

double cross2(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

double area2(const std::vector<glm::dvec2>& p) {
  double sum = 0;
  for (size_t k = 2; k < p.size(); ++k) sum += cross2(p[k - 1] - p[0], p[k] - p[0]);
  return sum;
}

}  // namespace

Samples sampleLines(const Scene& scene, const glm::dvec3& u, uint32_t sample_count, uint32_t seed) {
  struct Hit {
    double height;
    uint32_t polygon;
    bool front_up;
  };
  const auto [x, y] = axesAcross(u);
  std::vector<std::vector<glm::dvec2>> outlines;
  for (const Polygon& polygon : scene.polygons) outlines.push_back(project(scene, polygon, x, y));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Samples samples;
  samples.square = 4;
  for (uint32_t s = 0; s < sample_count; ++s) {
    const glm::dvec2 point(uniform(random), uniform(random));
    const glm::dvec3 base = point.x * x + point.y * y;
    std::vector<Hit> hits;
    for (uint32_t p = 0; p < outlines.size(); ++p) {
      bool left = true, right = true;
      for (size_t k = 0; k < outlines[p].size(); ++k) {
        const glm::dvec2 &a = outlines[p][k], &b = outlines[p][(k + 1) % outlines[p].size()];
        (cross2(b - a, point - a) > 0 ? right : left) = false;
      }
      if (!left && !right) continue;
      const Plane& plane = scene.planes[scene.polygons[p].plane];
      hits.push_back({(plane.offset - glm::dot(plane.normal, base)) / glm::dot(plane.normal, u), p, left});
    }
    std::sort(hits.begin(), hits.end(), [](const Hit& p, const Hit& q) {
      if (p.height != q.height) return p.height < q.height;
      return p.front_up != q.front_up ? p.front_up : p.polygon < q.polygon;
    });
    classifyLine(
        hits, false,
        [&](uint32_t a, uint32_t b) {
          samples.areas[{a, b}] += samples.square / sample_count;
        },
        [](uint32_t, uint32_t) {});
  }
  return samples;
}

Overlap overlap(const Scene& scene, const glm::dvec3& u, uint32_t a, uint32_t b) {
  const auto [x, y] = axesAcross(u);
  std::vector<glm::dvec2> part = project(scene, scene.polygons[a], x, y);
  const std::vector<glm::dvec2> frame = project(scene, scene.polygons[b], x, y);
  const double turn = area2(frame) > 0 ? 1 : -1;
  for (size_t k = 0; k < frame.size(); ++k) {
    const glm::dvec2 begin = frame[k], along = frame[(k + 1) % frame.size()] - begin;
    std::vector<glm::dvec2> clipped;
    for (size_t m = 0; m < part.size(); ++m) {
      const glm::dvec2 p = part[m], q = part[(m + 1) % part.size()];
      const double p_side = turn * cross2(along, p - begin), q_side = turn * cross2(along, q - begin);
      if (p_side >= 0) clipped.push_back(p);
      if ((p_side >= 0) != (q_side >= 0)) clipped.push_back(p + (q - p) * (p_side / (p_side - q_side)));
    }
    part.swap(clipped);
  }
  if (part.empty()) return {};
  glm::dvec2 middle(0);
  for (const glm::dvec2& p : part) middle += p / double(part.size());
  const glm::dvec3 at = middle.x * x + middle.y * y;
  const auto height = [&](uint32_t p) {
    const Plane& plane = scene.planes[scene.polygons[p].plane];
    return (plane.offset - glm::dot(plane.normal, at)) / glm::dot(plane.normal, u);
  };
  return {std::abs(area2(part)) / 2, (height(b) - height(a)) * glm::length(u)};
}

}  // namespace viewpeel::tests
