#include "collision/mesh/convex_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/mesh/hull_proof.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/mesh/point_in_solid.h"
#include "collision/mesh/surface_patch.h"
#include "collision/mesh/topology/components.h"
#include "collision/shapes/hull_of_part.h"

namespace leeway::collision {
namespace {

// Meshes with fewer triangles are not searched for pieces, because their hierarchy is only one or
// two nodes deep.
constexpr std::size_t kLeastDecomposed = 24;
// Components with at most this many triangles are tested for convexity, in quadratic time.
constexpr std::size_t kMostTested = 64;
// A patch stops growing after this many rejected batches. A larger limit finds better pieces.
constexpr int kMostFailures = 32;
// Limit on the work of a whole decomposition [units of about 0.2 us].
constexpr double kMostWork = 5e6;
// The decomposition of a large mesh is given up once this share of the work is done, if the whole
// mesh would take more than kHopeless times the allowed work at this rate. (The most promising
// seeds come first.)
constexpr double kFirstLook = 1.0 / 32, kHopeless = 2;
// A decomposition is given up once its pieces and loose triangles exceed by this many the number
// that is worthwhile for the triangles done so far. (The most promising seeds come first.)
constexpr double kHeadStart = 64;
// Smaller patches are kept as triangles.
constexpr std::size_t kLeastPatch = 4;

// For each triangle of a closed component, the triangles across its edges, where edge k is from
// corner k to corner k + 1. -1 if the component is open, if the number of its triangles at the edge
// is not two, or if the triangle uses a vertex twice.
std::vector<std::array<std::int32_t, 3>> neighboursOf(const TriangleMesh& mesh) {
  std::vector<EdgeUse> edges = sortedEdges(mesh.triangles(), mesh.vertices().size());
  std::erase_if(edges,
                [&](const EdgeUse& e) { return !mesh.isClosed(mesh.component(e.triangle)); });
  std::vector<std::array<std::int32_t, 3>> neighbours(mesh.triangles().size(), {-1, -1, -1});
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    for (end = i;
         end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high;)
      ++end;
    if (end - i != 2) continue;
    const EdgeUse &e = edges[i], &f = edges[i + 1];
    neighbours[at(e.triangle)][at(e.side)] = f.triangle;
    neighbours[at(f.triangle)][at(f.side)] = e.triangle;
  }
  return neighbours;
}

ConvexView viewOf(const std::vector<Vector>& points) {
  return viewOfPoints(points.data(), static_cast<int>(points.size()), 0);
}

// Triangles outside a patch that must stay outside its hull, each with a plane that separates it
// from the points that the hull is to span.
class Obstacles {
 public:
  Obstacles(const Surface& surface, HullProof& proof) : surface_(surface), proof_(proof) {}

  void clear() { obstacles_.clear(); }

  // Adds a triangle with a plane above the accepted hull. False if it is already an obstacle.
  bool add(std::int32_t t) {
    for (const Obstacle& o : obstacles_) {
      if (o.triangle == t) return false;
    }
    obstacles_.push_back({t, Vector::Zero(), 0});
    separate(obstacles_.back(), viewOf(proof_.hull().corners()));
    return true;
  }

  // Starts again with the points of the accepted hull.
  void startSpanning() { spanned_ = proof_.hull().corners(); }

  // Whether the hull of the spanned points and triangle t would intersect an obstacle. If not, t is
  // also spanned.
  bool meets(std::int32_t t) {
    const std::size_t before = spanned_.size();
    for (const std::int32_t v : surface_.corners(t)) spanned_.push_back(surface_.vertex(v));
    for (Obstacle& o : obstacles_) {
      bool clear = true;
      for (const std::int32_t v : surface_.corners(t))
        clear = clear && o.normal.dot(surface_.vertex(v)) <= o.limit;
      if (clear || separate(o, viewOf(spanned_))) continue;
      spanned_.resize(before);
      return true;
    }
    return false;
  }

 private:
  // All spanned points have normal . x <= limit.
  struct Obstacle {
    std::int32_t triangle;
    Vector normal;
    double limit;
  };

  // Finds a plane between an obstacle and a hull. False if there is none.
  bool separate(Obstacle& o, const ConvexView& hull) {
    const double allowed = proof_.allowedDepth();
    const DistanceResult r = proof_.depthIn(o.triangle, hull, allowed);
    if (!(r.distance.lower > -allowed)) return false;
    o.normal = -r.normal;
    o.limit = kInfinity;
    for (const std::int32_t v : surface_.corners(o.triangle)) {
      o.limit = std::min(o.limit, o.normal.dot(surface_.vertex(v)) + allowed);
    }
    return true;
  }

  const Surface& surface_;
  HullProof& proof_;
  std::vector<Obstacle> obstacles_;
  std::vector<Vector> spanned_;
};

// Whether a triangle uses a vertex twice. Such a triangle is not part of the surface around a
// solid, see components.h.
bool isCollapsed(const TriangleMesh::Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

// Returns a closed component as a piece if it is convex up to rounding; otherwise a piece without a
// hull.
//
// In the direction n of a triangle's normal, let no vertex be farther than h above the triangle,
// and let the middle c of all vertices be at least r below it. If c is inside and r > 0 for all
// triangles, a ball around c with the least r is in the solid, and so in the hull. The hull shrunk
// around c by the share h / r, for the largest h, intersects no triangle and is in the solid. No
// point of the hull is farther from it than that share of the farthest vertex' distance from c.
// O(triangles^2).
ConvexPiece convexComponent(const TriangleMesh& mesh, std::span<const std::int32_t> triangles) {
  std::vector<std::int32_t> numbers;
  for (const std::int32_t t : triangles) {
    const TriangleMesh::Triangle& corners = mesh.triangles()[at(t)];
    numbers.insert(numbers.end(), corners.begin(), corners.end());
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  std::vector<Vector> vertices;
  Vector middle = Vector::Zero();
  for (const std::int32_t v : numbers) {
    vertices.push_back(mesh.vertices()[at(v)]);
    middle += vertices.back() / static_cast<double>(numbers.size());
  }
  double reach = 0;
  for (const Vector& v : vertices) reach = std::max(reach, (v - middle).norm());
  const double rounding = 32 * kUnitRoundoff * reach;
  double above = 0, below = kInfinity;
  for (const std::int32_t t : triangles) {
    const TriangleMesh::Triangle& corners = mesh.triangles()[at(t)];
    if (isCollapsed(corners)) continue;
    const Vector &p = mesh.vertices()[at(corners[0])], &q = mesh.vertices()[at(corners[1])],
                 &r = mesh.vertices()[at(corners[2])];
    const Vector across = cross(q - p, r - p);
    if (!(across.squaredNorm() > kLeastSquare)) return {};
    const Vector n = across.normalized();
    const double lowest = std::min({n.dot(p - middle), n.dot(q - middle), n.dot(r - middle)});
    below = std::min(below, lowest);
    for (const Vector& v : vertices) above = std::max(above, n.dot(v - middle) - lowest);
    if (!(below > 2 * rounding && above <= kConvexRounding * mesh.tree().extent())) return {};
  }
  if (sideOf(mesh, mesh.component(triangles.front()), middle) != Side::kInside) return {};
  const double excess = (above + rounding) / (below - rounding) * reach;
  return {{triangles.begin(), triangles.end()}, hullOfPart(vertices), excess * kOutwards};
}

// The triangles of each component, ascending.
class ComponentTriangles {
 public:
  explicit ComponentTriangles(const TriangleMesh& mesh)
      : end_(at(mesh.componentCount()) + 1, 0), triangles_(mesh.triangles().size()) {
    const auto count = static_cast<std::int32_t>(triangles_.size());
    for (std::int32_t t = 0; t < count; ++t) ++end_[at(mesh.component(t)) + 1];
    std::partial_sum(end_.begin(), end_.end(), end_.begin());
    std::vector<std::size_t> next(end_.begin(), end_.end() - 1);
    for (std::int32_t t = 0; t < count; ++t) triangles_[next[at(mesh.component(t))]++] = t;
  }
  std::span<const std::int32_t> of(int component) const {
    const std::size_t c = at(component);
    return std::span(triangles_).subspan(end_[c], end_[c + 1] - end_[c]);
  }

 private:
  std::vector<std::size_t> end_;  // of the previous component
  std::vector<std::int32_t> triangles_;
};

ConvexPieces unused(PieceSummary::Use why) {
  ConvexPieces none;
  none.summary.use = why;
  return none;
}

ConvexPieces piecesOf(const TriangleMesh& mesh, std::vector<ConvexPiece> pieces) {
  ConvexPieces result;
  result.summary.use = PieceSummary::Use::kUsed;
  result.summary.pieces = static_cast<int>(pieces.size());
  std::size_t held = 0;
  for (const ConvexPiece& piece : pieces) {
    held += piece.triangles.size();
    result.summary.excess = std::max(result.summary.excess, piece.excess);
  }
  result.summary.loose_triangles = static_cast<int>(mesh.triangles().size() - held);
  result.pieces = std::move(pieces);
  return result;
}

// The convex components, as pieces; these are always worthwhile, however few they are. Without any,
// the result has no pieces and the reason `why`.
ConvexPieces convexComponents(const TriangleMesh& mesh, PieceSummary::Use why) {
  std::vector<ConvexPiece> pieces;
  const ComponentTriangles components(mesh);
  for (int c = 0; c < mesh.componentCount(); ++c) {
    if (!mesh.isClosed(c) || components.of(c).size() > kMostTested) continue;
    ConvexPiece piece = convexComponent(mesh, components.of(c));
    if (piece.hull != nullptr) pieces.push_back(std::move(piece));
  }
  return pieces.empty() ? unused(why) : piecesOf(mesh, std::move(pieces));
}

class Decomposition {
 public:
  explicit Decomposition(const TriangleMesh& mesh)
      : surface_(mesh),
        neighbours_(neighboursOf(mesh)),
        largest_excess_(kPieceTolerance *
                        (mesh.tree().node(0).high - mesh.tree().node(0).low).norm()),
        work_left_(std::min(kPieceWork * static_cast<double>(mesh.triangles().size()), kMostWork)),
        patch_(surface_),
        proof_(surface_, largest_excess_, work_left_),
        obstacles_(surface_, proof_),
        components_(mesh),
        tested_(at(mesh.componentCount()), 0),
        rejected_(mesh.triangles().size()),
        queued_(mesh.triangles().size()),
        taken_(mesh.triangles().size(), 0) {}

  ConvexPieces run() {
    std::vector<ConvexPiece> pieces;
    const double count = surface_.triangleCount();
    const std::vector<std::int32_t> order = seeds();
    const auto closed = static_cast<double>(order.size());
    double units = count - closed, done = units;
    for (const std::int32_t seed : order) {
      if (taken_[at(seed)] != 0) continue;
      if (work_left_ < 0 || isHopeless(done / count))
        return convexComponents(surface_.mesh(), PieceSummary::Use::kLaborious);
      ConvexPiece piece = wholeComponent(seed);
      const bool is_whole = piece.hull != nullptr;
      if (!is_whole) grow(seed, piece);
      const auto& triangles = is_whole ? piece.triangles : patch_.triangles();
      for (const std::int32_t t : triangles) taken_[at(t)] = 1;
      const auto size = static_cast<double>(triangles.size());
      done += size;
      // Whole components are always worthwhile, however few triangles they have.
      units += piece.hull == nullptr ? size : is_whole ? std::min(1.0, size / kPieceTriangles) : 1;
      if (kPieceTriangles * units > std::min(done + kPieceTriangles * kHeadStart, count))
        return convexComponents(surface_.mesh(), PieceSummary::Use::kConcave);
      if (piece.hull != nullptr) pieces.push_back(std::move(piece));
    }
    return piecesOf(surface_.mesh(), std::move(pieces));
  }

 private:
  // The seed's component, if it is small and convex; each component is tested once.
  ConvexPiece wholeComponent(std::int32_t seed) {
    const int component = surface_.mesh().component(seed);
    const std::span<const std::int32_t> triangles = components_.of(component);
    if (triangles.size() > kMostTested || std::exchange(tested_[at(component)], 1) != 0) return {};
    work_left_ -= 0.02 * static_cast<double>(triangles.size() * triangles.size());
    return convexComponent(surface_.mesh(), triangles);
  }

  // Whether the decomposition would take too much work, given the share of the mesh that is done. A
  // mesh may always spend kPieceWork.
  bool isHopeless(double share) const {
    const double count = surface_.triangleCount();
    if (kPieceWork * count <= kMostWork) return false;
    const double spent = kMostWork - work_left_;
    return spent > kFirstLook * kMostWork && spent > kHopeless * kMostWork * share;
  }

  // The height of the highest corner of `other` above the plane of `t`.
  double above(std::int32_t t, std::int32_t other) const {
    double most = -kInfinity;
    for (const std::int32_t v : surface_.corners(other)) {
      most = std::max(most, surface_.normal(t).dot(surface_.vertex(v)) - surface_.offset(t));
    }
    return most;
  }
  bool isReflex(std::int32_t t, std::int32_t other) const {
    return above(t, other) > largest_excess_ || above(other, t) > largest_excess_;
  }

  // Triangles of closed components, ordered by their distance from reflex edges (in steps across
  // edges), farthest first.
  std::vector<std::int32_t> seeds() const {
    const std::int32_t count = surface_.triangleCount();
    std::vector<std::int32_t> depth(at(count), -1), queue;
    for (std::int32_t t = 0; t < count; ++t) {
      if (!surface_.isInClosedComponent(t)) continue;
      for (const std::int32_t other : neighbours_[at(t)]) {
        if (other < 0 || depth[at(t)] >= 0 || !isReflex(t, other)) continue;
        depth[at(t)] = 0;
        queue.push_back(t);
      }
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
      for (const std::int32_t other : neighbours_[at(queue[head])]) {
        if (other < 0 || depth[at(other)] >= 0) continue;
        depth[at(other)] = depth[at(queue[head])] + 1;
        queue.push_back(other);
      }
    }
    std::vector<std::int32_t> order;
    for (std::int32_t t = 0; t < count; ++t) {
      if (surface_.isInClosedComponent(t)) order.push_back(t);
    }
    // (Convex components have no reflex edge, so they come first.)
    std::stable_sort(order.begin(), order.end(), [&](std::int32_t l, std::int32_t r) {
      const auto key = [&](std::int32_t t) { return depth[at(t)] < 0 ? count : depth[at(t)]; };
      return key(l) > key(r);
    });
    return order;
  }

  // Finds the largest patch around a seed, and its hull if it is large enough.
  void grow(std::int32_t seed, ConvexPiece& piece) {
    patch_.clear();
    rejected_.clear();
    obstacles_.clear();
    const int component = surface_.mesh().component(seed);
    patch_.add(seed);
    if (!proof_.accept(patch_, component)) return;
    std::size_t step = 1;
    int failures = 0;
    bool filtered = false;
    while (work_left_ > 0) {
      const std::size_t before = patch_.size();
      gather(step, filtered);
      const std::size_t size = patch_.size() - before;
      if (size == 0) break;
      if (proof_.accept(patch_, component)) {
        step = std::max(2 * step, filtered ? 0 : before / 2);
        continue;
      }
      if (size == 1) rejected_.add(patch_.triangles().back());
      while (patch_.size() > before) patch_.removeLast();
      if (++failures >= kMostFailures) break;
      // A new obstacle excludes the triangles that would intersect it; without one, a smaller batch
      // is tried.
      const bool learnt = proof_.culprit() >= 0 && obstacles_.add(proof_.culprit());
      if (filtered && !learnt) step = std::max<std::size_t>(size / 2, 1);
      filtered = true;
    }
    if (patch_.size() < kLeastPatch) return;
    piece.hull = hullOfPart(proof_.hull().corners());
    piece.excess = proof_.excess();
    piece.triangles = patch_.triangles();
    std::sort(piece.triangles.begin(), piece.triangles.end());
  }

  // Adds up to `limit` triangles to the patch, breadth first across edges that are not reflex. With
  // `filtered`, triangles that certainly do not fit are omitted.
  void gather(std::size_t limit, bool filtered) {
    queue_.clear();
    queued_.clear();
    const std::size_t before = patch_.size();
    work_left_ -= 0.05 * static_cast<double>(before);
    for (std::size_t i = 0; i < before; ++i) enqueueNeighbours(patch_.triangles()[i]);
    obstacles_.startSpanning();
    for (std::size_t head = 0; head < queue_.size() && patch_.size() < before + limit; ++head) {
      const std::int32_t t = queue_[head];
      if ((filtered && conflicts(t)) || obstacles_.meets(t)) {
        rejected_.add(t);
        continue;
      }
      patch_.add(t);
      enqueueNeighbours(t);
    }
  }

  void enqueueNeighbours(std::int32_t from) {
    for (const std::int32_t t : neighbours_[at(from)]) {
      if (t < 0 || taken_[at(t)] != 0 || patch_.has(t) || queued_.has(t) || rejected_.has(t))
        continue;
      if (isReflex(from, t)) continue;
      queued_.add(t);
      queue_.push_back(t);
    }
  }

  // Whether a triangle does not fit those in the patch: one of its corners is above the plane of
  // one of them, or one of their corners is above its plane.
  bool conflicts(std::int32_t t) {
    const double allowed = proof_.allowedDepth();
    work_left_ -= 0.01 * static_cast<double>(patch_.planes().size() + patch_.points().size());
    for (const std::int32_t v : surface_.corners(t)) {
      if (patch_.planes().above(surface_.vertex(v), allowed)) return true;
    }
    return patch_.points().above(surface_.normal(t), surface_.offset(t) + allowed);
  }

  const Surface surface_;
  const std::vector<std::array<std::int32_t, 3>> neighbours_;
  const double largest_excess_;  // allowed [m]
  double work_left_;
  SurfacePatch patch_;
  HullProof proof_;
  Obstacles obstacles_;
  const ComponentTriangles components_;
  std::vector<std::uint8_t> tested_;  // components, by wholeComponent()
  Marks rejected_, queued_;
  std::vector<std::uint8_t> taken_;  // in a finished patch
  std::vector<std::int32_t> queue_;
};

}  // namespace

ConvexPieces convexPieces(const TriangleMesh& mesh) {
  if (mesh.closedComponentCount() == 0) return unused(PieceSummary::Use::kOpen);
  if (mesh.triangles().size() < kLeastDecomposed)
    return convexComponents(mesh, PieceSummary::Use::kSmall);
  return Decomposition(mesh).run();
}

}  // namespace leeway::collision
