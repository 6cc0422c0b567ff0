#include "reference/exact_pair_areas.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include <CGAL/Arr_consolidated_curve_data_traits_2.h>
#include <CGAL/Arr_segment_traits_2.h>
#include <CGAL/Arrangement_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <glm/glm.hpp>

#include "facing.h"

namespace viewpeel::reference {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using Rational = Kernel::Exact_kernel::FT;
using Point = Kernel::Point_2;
using Traits = CGAL::Arr_consolidated_curve_data_traits_2<CGAL::Arr_segment_traits_2<Kernel>, uint32_t>;
using Arrangement = CGAL::Arrangement_2<Traits>;
using FaceHandle = Arrangement::Face_const_handle;
using HalfedgeHandle = Arrangement::Halfedge_const_handle;

// The shear along u onto the plane of axes a and b, everything scaled by u[w]: p goes to (p[a] u[w] - p[w] u[a], p[b] u[w] - p[w] u[b]).
struct Shear {
  glm::dvec3 u;
  int w, a, b;

  explicit Shear(const glm::dvec3& along) : u(along) {
    w = 0;
    for (int axis = 1; axis < 3; ++axis)
      if (std::abs(u[axis]) > std::abs(u[w])) w = axis;
    a = (w + 1) % 3;
    b = (w + 2) % 3;
  }
  Point operator()(const glm::dvec3& p) const {
    const Number uw(u[w]), pw(p[w]);
    return {Number(p[a]) * uw - pw * Number(u[a]), Number(p[b]) * uw - pw * Number(u[b])};
  }
  // From areas of the sheared plane to areas of P(u).
  double areaScale() const { return 1 / (std::abs(u[w]) * glm::length(u)); }
  // Length in P(u) of a step of the sheared plane.
  double lengthInProjection(double x, double y) const {
    glm::dvec3 step(0);
    step[a] = x / u[w];
    step[b] = y / u[w];
    const glm::dvec3 along = glm::normalize(u);
    return glm::length(step - glm::dot(step, along) * along);
  }
};

// Height along u over the sheared plane: t = (offset u_w - n_a X - n_b Y) / (u_w n.u), as a double with its error and as a rational.
struct HeightPlane {
  double c0 = 0, cx = 0, cy = 0, error = 0;
  glm::dvec3 normal{0};
  double offset = 0;

  HeightPlane(const Plane& plane, const Shear& shear) : normal(plane.normal), offset(plane.offset) {
    const double nu = glm::dot(normal, shear.u);
    c0 = offset / nu;
    cx = -normal[shear.a] / (shear.u[shear.w] * nu);
    cy = -normal[shear.b] / (shear.u[shear.w] * nu);
    // nu carries 2^-51 |n| |u|; X and Y are below 2 |u|; a few roundings each.
    const double relative = 32 * 0x1p-53 * (1 + glm::length(shear.u) / std::abs(nu));
    error = relative * (std::abs(c0) + 2 * glm::length(shear.u) * (std::abs(cx) + std::abs(cy)));
  }
  double at(double x, double y) const { return c0 + cx * x + cy * y; }
  Rational exactAt(const Shear& shear, const Rational& x, const Rational& y) const {
    const auto q = [](double value) { return Rational(value); };
    const glm::dvec3& u = shear.u;
    const Rational nu = q(normal.x) * q(u.x) + q(normal.y) * q(u.y) + q(normal.z) * q(u.z);
    return (q(offset) * q(u[shear.w]) - q(normal[shear.a]) * x - q(normal[shear.b]) * y) / (q(u[shear.w]) * nu);
  }
};

double approximate(const Number& x) { return CGAL::to_double(x); }

class PairAreaBuilder {
 public:
  PairAreaBuilder(const Scene& scene, const glm::dvec3& u, const ExactOptions& options) : scene_(scene), shear_(u), options_(options) {}

  PairAreas build() {
    insertEdges();
    visitFaces();
    PairAreas result;
    for (const auto& [key, sum] : sums_)
      if (sum.area > 0)
        result.pairs.push_back({uint32_t(key >> 32), uint32_t(key), sum.area * shear_.areaScale(), sum.perimeter});
    std::sort(result.pairs.begin(), result.pairs.end(),
              [](const PairArea& p, const PairArea& q) { return std::pair(p.a, p.b) < std::pair(q.a, q.b); });
    result.edge_count = arrangement_.number_of_edges();
    if (options_.check_sums) result.largest_sum_defect = findLargestDefect();
    return result;
  }

 private:
  struct Sum {
    double area = 0, perimeter = 0;  // area in the sheared plane, perimeter in P(u)
  };
  using Stack = std::vector<uint32_t>;    // polygons over a face, in the order of the line
  using Pairs = std::vector<uint64_t>;    // keys of what a face contributes to, sorted
  struct FaceData {
    Stack stack;
    Pairs pairs;
    bool seen = false;
  };

  // Polygons that share an edge in space share it in the projection: it is inserted once. What overlaps otherwise, the traits merge.
  void insertEdges() {
    using Key = std::array<double, 6>;
    std::map<Key, uint32_t> index_of;
    std::vector<Traits::Curve_2> curves;
    front_up_.assign(scene_.polygons.size(), false);
    for (uint32_t p = 0; p < scene_.polygons.size(); ++p) {
      const Polygon& polygon = scene_.polygons[p];
      heights_.emplace_back(scene_.planes[polygon.plane], shear_);
      std::vector<Point> points;
      for (uint32_t k = 0; k < polygon.corner_count; ++k) points.push_back(shear_(scene_.corners[polygon.first_corner + k]));
      Number twice_area = 0;
      for (uint32_t k = 1; k + 1 < polygon.corner_count; ++k)
        twice_area += CGAL::determinant(points[k] - points[0], points[k + 1] - points[0]);
      const bool edge_on = std::abs(glm::dot(scene_.planes[polygon.plane].normal, shear_.u)) < 1e-12 * glm::length(shear_.u);
      if (options_.check_sums) projected_.push_back(edge_on ? Rational(0) : Rational(abs(twice_area).exact()));
      if (edge_on || twice_area == 0) continue;
      front_up_[p] = (twice_area > 0) == (shear_.u[shear_.w] > 0);
      for (uint32_t k = 0; k < polygon.corner_count; ++k) {
        const uint32_t next = (k + 1) % polygon.corner_count;
        if (points[k] == points[next]) continue;
        const glm::dvec3 &c = scene_.corners[polygon.first_corner + k], &d = scene_.corners[polygon.first_corner + next];
        Key key{c.x, c.y, c.z, d.x, d.y, d.z};
        if (Key swapped{d.x, d.y, d.z, c.x, c.y, c.z}; swapped < key) key = swapped;
        const auto [at, is_new] = index_of.try_emplace(key, uint32_t(polygons_of_edge_.size()));
        if (is_new) {
          polygons_of_edge_.emplace_back();
          curves.emplace_back(Traits::Curve_2(CGAL::Arr_segment_traits_2<Kernel>::Curve_2(points[k], points[next]), at->second));
        }
        polygons_of_edge_[at->second].push_back(p);
      }
    }
    if (options_.check_sums) exact_sums_.assign(scene_.polygons.size(), Rational(0));
    CGAL::insert(arrangement_, curves.begin(), curves.end());
  }

  // From the unbounded face outward in, across edges: each edge is the end of the polygons it bounds on one side and their start on the other.
  void visitFaces() {
    std::vector<HalfedgeHandle> to_cross;
    faces_[&*arrangement_.unbounded_face()].seen = true;
    pushBoundary(arrangement_.unbounded_face(), to_cross);
    while (!to_cross.empty()) {
      const HalfedgeHandle edge = to_cross.back();
      to_cross.pop_back();
      const FaceHandle to = edge->twin()->face();
      FaceData& data = faces_[&*to];
      if (data.seen) continue;
      data.seen = true;
      data.stack = faces_[&*edge->face()].stack;
      crossEdge(edge, to, data.stack);
      addFace(to, data);
      pushBoundary(to, to_cross);
    }
    for (auto edge = arrangement_.edges_begin(); edge != arrangement_.edges_end(); ++edge) addPerimeters(edge);
  }

  template <class Use>
  static void forEachHalfedge(const FaceHandle& face, Use use) {
    const auto walk = [&](Arrangement::Ccb_halfedge_const_circulator start) {
      auto at = start;
      do use(HalfedgeHandle(at));
      while (++at != start);
    };
    if (!face->is_unbounded()) walk(face->outer_ccb());
    for (auto hole = face->holes_begin(); hole != face->holes_end(); ++hole) walk(*hole);
  }

  void pushBoundary(const FaceHandle& face, std::vector<HalfedgeHandle>& to_cross) {
    forEachHalfedge(face, [&](const HalfedgeHandle& edge) {
      if (!faces_[&*edge->twin()->face()].seen) to_cross.push_back(edge);
    });
  }

  void crossEdge(const HalfedgeHandle& edge, const FaceHandle& to, Stack& stack) {
    Stack entering;
    for (uint32_t index : edge->curve().data())
      for (uint32_t polygon : polygons_of_edge_[index]) {
        const auto at = std::find(stack.begin(), stack.end(), polygon);
        if (at != stack.end()) stack.erase(at);
        else entering.push_back(polygon);
      }
    if (entering.empty()) return;
    const Point inside = findInteriorPoint(to);
    const double x = approximate(inside.x()), y = approximate(inside.y());
    for (uint32_t polygon : entering) {
      const auto at = std::upper_bound(stack.begin(), stack.end(), polygon,
                                       [&](uint32_t p, uint32_t q) { return comesBefore(p, q, inside, x, y); });
      stack.insert(at, polygon);
    }
  }

  // Strict order along the line: height, then fronts that face +u, then index.
  bool comesBefore(uint32_t p, uint32_t q, const Point& inside, double x, double y) const {
    if (scene_.polygons[p].plane != scene_.polygons[q].plane) {
      const HeightPlane &hp = heights_[p], &hq = heights_[q];
      const double difference = hp.at(x, y) - hq.at(x, y);
      if (std::abs(difference) > hp.error + hq.error) return difference < 0;
      const Rational ex = inside.x().exact(), ey = inside.y().exact();
      const Rational exact_p = hp.exactAt(shear_, ex, ey), exact_q = hq.exactAt(shear_, ex, ey);
      if (exact_p != exact_q) return exact_p < exact_q;
    }
    if (front_up_[p] != front_up_[q]) return front_up_[p];
    return p < q;
  }

  // A point strictly inside a bounded face: at its least corner v, between v and the corner of the face inside the triangle of v and its
  // neighbours that is farthest from the line of the neighbours; in the triangle itself when there is none.
  Point findInteriorPoint(const FaceHandle& face) const {
    Arrangement::Ccb_halfedge_const_circulator start = face->outer_ccb(), at = start, least = start;
    do
      if (isLess(at->target()->point(), least->target()->point()) || isSpike(least)) least = at;
    while (++at != start);
    const Point &a = least->source()->point(), &v = least->target()->point(), &b = least->next()->target()->point();
    const Point* farthest = nullptr;
    Number largest = 0;
    forEachHalfedge(face, [&](const HalfedgeHandle& edge) {
      const Point& q = edge->target()->point();
      if (q == a || q == v || q == b) return;
      if (CGAL::orientation(a, v, q) == CGAL::RIGHT_TURN || CGAL::orientation(v, b, q) == CGAL::RIGHT_TURN ||
          CGAL::orientation(b, a, q) != CGAL::LEFT_TURN)
        return;
      const Number distance = CGAL::determinant(a - b, q - b);
      if (!farthest || distance > largest) {
        farthest = &q;
        largest = distance;
      }
    });
    return farthest ? CGAL::midpoint(v, *farthest) : CGAL::centroid(a, v, b);
  }

  static bool isLess(const Point& p, const Point& q) { return CGAL::compare_xy(p, q) == CGAL::SMALLER; }
  static bool isSpike(const HalfedgeHandle& edge) { return edge->next() == edge->twin(); }

  uint64_t keyOf(uint32_t a, uint32_t b) const { return uint64_t(std::min(a, b)) << 32 | std::max(a, b); }

  void addFace(const FaceHandle& face, FaceData& data) {
    const Stack& stack = data.stack;
    for (size_t k = 0; k <= stack.size() && !stack.empty(); ++k) {
      const bool has_lower = k > 0, has_upper = k < stack.size();
      const uint32_t lower = has_lower ? stack[k - 1] : 0, upper = has_upper ? stack[k] : 0;
      const uint lower_side = has_lower ? sideTowardsGap(front_up_[lower], options_.two_sided, true) : kSideNone;
      const uint upper_side = has_upper ? sideTowardsGap(front_up_[upper], options_.two_sided, false) : kSideNone;
      switch (classifyGap(lower_side, upper_side)) {
        case kGapFacingPair: data.pairs.push_back(keyOf(lower, upper)); break;
        case kGapLowerEnvironment: data.pairs.push_back(keyOf(lower, kEnvironment)); break;
        case kGapUpperEnvironment: data.pairs.push_back(keyOf(upper, kEnvironment)); break;
        case kGapLowerLeak: data.pairs.push_back(keyOf(lower, kLeak)); break;
        case kGapUpperLeak: data.pairs.push_back(keyOf(upper, kLeak)); break;
        default: break;
      }
    }
    std::sort(data.pairs.begin(), data.pairs.end());
    if (data.pairs.empty()) return;
    const double area = faceArea<double>(face, [](const Number& x) { return approximate(x); });
    for (uint64_t key : data.pairs) sums_[key].area += std::max(area, 0.0);
    if (!options_.check_sums) return;
    const auto exact = faceArea<Rational>(face, [](const Number& x) { return Rational(x.exact()); });
    for (uint64_t key : data.pairs) {
      exact_sums_[key >> 32] += exact;
      if (uint32_t(key) < kEnvironment) exact_sums_[uint32_t(key)] += exact;
    }
  }

  // Shoelace formula about a corner; holes run the other way round and subtract themselves.
  template <class Value, class Convert>
  static Value faceArea(const FaceHandle& face, Convert convert) {
    const Point& origin = face->outer_ccb()->target()->point();
    const Value ox = convert(origin.x()), oy = convert(origin.y());
    Value twice(0);
    forEachHalfedge(face, [&](const HalfedgeHandle& edge) {
      const Point &p = edge->source()->point(), &q = edge->target()->point();
      const Value px = convert(p.x()) - ox, py = convert(p.y()) - oy, qx = convert(q.x()) - ox, qy = convert(q.y()) - oy;
      twice += px * qy - py * qx;
    });
    return twice / Value(2);
  }

  // An edge bounds the regions of the pairs that only one of its sides contributes to.
  void addPerimeters(const HalfedgeHandle& edge) {
    const Pairs &left = faces_[&*edge->face()].pairs, &right = faces_[&*edge->twin()->face()].pairs;
    Pairs only_one;
    std::set_symmetric_difference(left.begin(), left.end(), right.begin(), right.end(), std::back_inserter(only_one));
    if (only_one.empty()) return;
    const Point &p = edge->source()->point(), &q = edge->target()->point();
    const double length = shear_.lengthInProjection(approximate(q.x()) - approximate(p.x()), approximate(q.y()) - approximate(p.y()));
    for (uint64_t key : only_one) sums_[key].perimeter += length;
  }

  double findLargestDefect() const {
    Rational largest(0);
    for (size_t p = 0; p < exact_sums_.size(); ++p) {
      const Rational expected = options_.two_sided ? Rational(projected_[p]) : Rational(projected_[p] / Rational(2));
      const Rational defect = exact_sums_[p] - expected;
      if (CGAL::abs(defect) > largest) largest = CGAL::abs(defect);
    }
    // A defect too small for a double is one all the same.
    const double rounded = CGAL::to_double(largest);
    return largest != Rational(0) && rounded == 0 ? 5e-324 : rounded;
  }

  const Scene& scene_;
  Shear shear_;
  ExactOptions options_;
  std::vector<HeightPlane> heights_;  // of each polygon
  std::vector<bool> front_up_;
  std::vector<std::vector<uint32_t>> polygons_of_edge_;
  Arrangement arrangement_;
  std::unordered_map<const void*, FaceData> faces_;
  std::unordered_map<uint64_t, Sum> sums_;
  std::vector<Rational> projected_, exact_sums_;  // twice the area; the sum of pairs, in the sheared plane
};

}  // namespace

PairAreas computePairAreas(const Scene& scene, const glm::dvec3& u, const ExactOptions& options) {
  return PairAreaBuilder(scene, u, options).build();
}

}  // namespace viewpeel::reference
