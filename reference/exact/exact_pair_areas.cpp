#include "reference/exact/exact_pair_areas.h"

#include <algorithm>
#include <cmath>

#include "reference/exact/edge_cuts.h"
#include "reference/exact/height_order.h"
#include "reference/exact/layers.h"
#include "reference/exact/outline_grid.h"
#include "reference/exact/pair_sums.h"
#include "reference/exact/projection.h"
#include "threads.h"

namespace viewpeel::reference {
namespace {

// An Edge is an edge of an outline, from its lower vertex to its higher one.
struct Edge {
  uint32_t a, b;
  uint32_t outline;
  int side;  // 1: the outline lies to the left of a -> b, -1: to the right

  auto operator<=>(const Edge&) const = default;
};

std::vector<Edge> listEdges(const Projection& projection) {
  std::vector<Edge> edges;
  for (uint32_t k = 0; k < projection.outlines().size(); ++k) {
    const std::vector<uint32_t>& vertices = projection.outlines()[k].vertices;
    for (size_t v = 0; v < vertices.size(); ++v) {
      const uint32_t a = vertices[v], b = vertices[(v + 1) % vertices.size()];
      edges.push_back({std::min(a, b), std::max(a, b), k, a < b ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

// A Walk is the state of one direction while all its edges are walked.
class Walk {
 public:
  Walk(const Projection& projection, const ExactOptions& options)
      : projection_(projection),
        options_(options),
        grid_(projection),
        order_(projection),
        layers_(order_, options.blocked),
        sums_(projection, options) {}

  ExactPairAreas run() {
    const std::vector<Edge> edges = listEdges(projection_);
    for (auto edge = edges.begin(); edge != edges.end();) {
      const EdgeCuts cuts(projection_, edge->a, edge->b);
      sortEvents(cuts, *edge);
      const Edge first = *edge;
      for (; edge != edges.end() && edge->a == first.a && edge->b == first.b; ++edge) walkEdge(cuts, *edge);
      if (options_.perimeters) sums_.closeEdge(projection_.lengthInProjection(first.a, first.b));
    }
    ExactPairAreas areas = sums_.finish();
    areas.cut_count = cut_count_;
    return areas;
  }

 private:
  struct Event {
    Cut cut;
    uint32_t span;
    bool enters;
  };

  void sortEvents(const EdgeCuts& cuts, const Edge& edge) {
    grid_.findNear(edge.a, edge.b, near_);
    spans_.clear();
    for (const uint32_t outline : near_) cuts.appendSpan(outline, spans_);
    events_.clear();
    for (uint32_t k = 0; k < spans_.size(); ++k) {
      events_.push_back({spans_[k].enter, k, true});
      events_.push_back({spans_[k].leave, k, false});
    }
    cut_count_ += events_.size();
    // Outlines that only touch in a point have no order there: one leaves before the other enters.
    std::sort(events_.begin(), events_.end(), [&](const Event& p, const Event& q) {
      const int order = cuts.compare(p.cut, q.cut);
      return order != 0 ? order < 0 : !p.enters && q.enters;
    });
    const Vertex &a = projection_.vertices()[edge.a], &b = projection_.vertices()[edge.b];
    exact_cross_ = a.x * b.y - a.y * b.x;
    long binary_exponent = 0;
    const double mantissa = mpz_get_d_2exp(&binary_exponent, exact_cross_.get_mpz_t());
    const double cross = std::ldexp(mantissa, static_cast<int>(binary_exponent + 2 * projection_.exponent()));
    cross_ = {cross, Ball::kUnit * std::abs(cross)};
  }

  // Follows the layers along an edge, on the inner side of an outline that has this edge.
  void walkEdge(const EdgeCuts& cuts, const Edge& edge) {
    layers_.assign(edge.outline);
    Cut from = cuts.begin();
    for (const Event& event : events_) {
      const Span& span = spans_[event.span];
      const bool counts = span.side == 0 || (span.side == edge.side && span.outline < edge.outline);
      if (!counts) continue;
      const LayerChange before = layers_.change();
      if (event.enters) layers_.insert(span.outline);
      else layers_.erase(span.outline);
      if (layers_.change() == before) continue;
      addPiece(cuts, edge, before, from, event.cut);
      from = event.cut;
    }
    addPiece(cuts, edge, layers_.change(), from, cuts.end());
  }

  void addPiece(const EdgeCuts& cuts, const Edge& edge, const LayerChange& change, const Cut& from, const Cut& to) {
    if (cuts.compare(from, to) == 0) return;
    Piece piece;
    piece.twice_area = (to.t - from.t) * cross_;
    piece.from = from.t.value;
    piece.to = to.t.value;
    if (options_.arithmetic == Arithmetic::exact) {
      const Vertex &a = projection_.vertices()[edge.a], &b = projection_.vertices()[edge.b];
      const mpq_class length = cuts.exactParameter(to) - cuts.exactParameter(from);
      piece.exact = {length * exact_cross_, length * mpz_class(b.x - a.x), length * mpz_class(b.y - a.y)};
    }
    const Piece opposite = -piece;
    const Piece &inside = edge.side > 0 ? piece : opposite, &outside = edge.side > 0 ? opposite : piece;
    if (change.is_cyclic) {
      addAll(change.inside, inside);
      addAll(change.outside, outside);
      return;
    }
    sums_.addGap(change.lower, change.outline, inside);
    sums_.addGap(change.outline, change.upper, inside);
    sums_.addGap(change.lower, change.upper, outside);
    if (!options_.blocked) return;
    sums_.addBlocked(change.lower, change.upper, inside);
    const std::vector<uint32_t>& layers = change.inside;
    const size_t place = static_cast<size_t>(std::find(layers.begin(), layers.end(), change.outline) - layers.begin());
    for (size_t k = 0; k + 1 < place; ++k) sums_.addBlocked(layers[k], change.outline, inside);
    for (size_t k = place + 2; k < layers.size(); ++k) sums_.addBlocked(change.outline, layers[k], inside);
  }

  void addAll(const std::vector<uint32_t>& layers, const Piece& piece) {
    for (size_t k = 1; k < layers.size(); ++k) {
      sums_.addGap(layers[k - 1], layers[k], piece);
      for (size_t m = 0; options_.blocked && m + 1 < k; ++m) sums_.addBlocked(layers[m], layers[k], piece);
    }
  }

  const Projection& projection_;
  const ExactOptions& options_;
  OutlineGrid grid_;
  HeightOrder order_;
  Layers layers_;
  PairSums sums_;
  std::vector<uint32_t> near_;
  std::vector<Span> spans_;
  std::vector<Event> events_;
  uint64_t cut_count_ = 0;
  mpz_class exact_cross_;
  Ball cross_;
};

}  // namespace

ExactPairAreas computeExactPairAreas(const Scene& scene, const glm::dvec3& u, const ExactOptions& options) {
  return std::move(computeExactPairAreas(scene, std::span(&u, 1), options).front());
}

std::vector<ExactPairAreas> computeExactPairAreas(const Scene& scene, std::span<const glm::dvec3> directions,
                                                  const ExactOptions& options) {
  requireDisjoint(scene, options.touching_depth);
  const IntegerCorners corners(scene);
  std::vector<ExactPairAreas> results(directions.size());
  shareOut(options.thread_count ? options.thread_count : threadCount(), directions.size(), 1, [&](size_t, size_t k) {
    if (options.on_direction) options.on_direction();
    const Projection projection(scene, corners, directions[k]);
    results[k] = Walk(projection, options).run();
  });
  return results;
}

}  // namespace viewpeel::reference
