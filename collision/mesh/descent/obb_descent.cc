#include "collision/mesh/descent/obb_descent.h"

#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "collision/convex/gjk/support.h"
#include "collision/mesh/descent/box_gaps.h"
#include "collision/mesh/descent/branch_and_bound.h"
#include "collision/mesh/descent/mesh_body.h"
#include "collision/mesh/descent/touching_triangles.h"
#include "collision/mesh/descent/triangle_pair.h"

namespace leeway::collision {
namespace {

using Kind = Part::Kind;

// Two boxes, in the numbering of MeshBody.
struct BoxPair {
  std::int32_t a, b;
  double lower;  // proven for all contents of the boxes; below 0 it only orders visits
  bool open;     // convex pieces were not enough: visit their triangles
};

class PairDescent : public DescentBounds {
 public:
  PairDescent(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement,
              const DistanceRequest& asked, Scratch& scratch, PairCache& cache)
      : DescentBounds(
            asked, scratch,
            {.depth = deepensPair(a, b) && asked.depth, .near = scratch.impl().touching.near()}),
        a_(a),
        b_(b),
        X_BA_(placement.X_BA0),
        slack_(placement.slack),
        hull_excess_(a.hull_excess + b.hull_excess),
        scratch_(scratch),
        work_(*scratch.impl().work),
        touching_(scratch.impl().touching),
        cache_(cache) {
    boxes_BA_ = boxPlacement(X_BA_, a_, b_);
    boxes_AB_ = boxPlacement(X_BA_.inverse(), b_, a_);
    box_slack_ = slack_ + boxRounding(a_, b_, X_BA_.translation.norm());
    // The same as for support points (derived in gjk.cc), because corners are placed, and
    // multiplied with a unit vector, by the same operations.
    rounding_ =
        kSupportRounding * kUnitRoundoff * (a_.extent() + b_.extent() + X_BA_.translation.norm()) +
        slack_;
    parts_ = deepensPair(a, b);
    opens_touching_ = a_.isMesh() && b_.isMesh() && !(a.has_solid_pieces && b.has_solid_pieces);
    deepens_ = request.depth && parts_;
  }

  DescentResult run() {
    float gap[BoxNode::kWidth];
    if (b_.isMesh()) {
      boxGaps(b_.node(0), placedBox(a_.box(a_.root()), boxes_BA_), {}, gap);
    } else {
      boxGaps(a_.node(0), placedBox(b_.box(-1), boxes_AB_), {}, gap);
    }
    result.hull_lower = static_cast<double>(gap[0]) - box_slack_;
    if (isPruned(result.hull_lower) || hullsDecide()) {
      settle(result.hull_lower);
      return result;
    }
    warmStart();
    open_.push({a_.root(), b_.root(), result.hull_lower, !parts_});
    for (BoxPair pair; open_.next(*this, pair);) expand(pair);
    open_.settleRest(*this);
    hulls();
    remember();
    return result;
  }

 private:
  // Queries a convex body and the hull of a mesh. True if that decides, which is usual.
  bool hullsDecide() {
    if (a_.isMesh() && b_.isMesh()) return false;
    DistanceRequest own;
    const double bar_now = bar();
    if (bar_now < kInfinity) own.threshold = bar_now;
    own.tolerance = std::max(request.tolerance, 0.1 * hull_excess_);
    own.depth = false;
    own.iteration_limit = request.iteration_limit;
    visit();
    const DistanceResult r =
        convexDistance(a_.hull(), X_BA_, b_.hull(), own, scratch_, &cache_, slack_);
    result.iterations += r.iterations;
    result.hull_lower = std::max(result.hull_lower, r.distance.lower);
    hulls_known_ = true;
    // If hulls are apart, their nearest points are on their surfaces, and the meshes are within the
    // excess of those points.
    if (r.distance.lower >= 0) offer(r, r.distance.upper + hull_excess_, {}, {});
    return isPruned(result.hull_lower) || isDone();
  }

  void warmStart() {
    Part a, b;
    if (!a_.partOf(cache_.triangle_a, a) || !b_.partOf(cache_.triangle_b, b)) return;
    if ((a.kind == Kind::kPiece || b.kind == Kind::kPiece) && !parts_) return;
    compareFirst([&] {
      if (a.kind == Kind::kTriangle && b.kind == Kind::kTriangle) {
        triangles(a.number, b.number);
        return;
      }
      warm_ = hullPair(a, b, &cache_);
      warm_a_ = a;
      warm_b_ = b;
      has_warm_ = true;
    });
  }

  void expand(const BoxPair& pair) {
    const Part part_a = a_.part(pair.a, pair.open), part_b = b_.part(pair.b, pair.open);
    if (part_a.kind != Kind::kNode && part_b.kind != Kind::kNode) {
      leaves(pair, part_a, part_b);
      return;
    }
    // Descends into the larger one.
    const bool split_a = part_b.kind != Kind::kNode ||
                         (part_a.kind == Kind::kNode && a_.radius(pair.a) >= b_.radius(pair.b));
    const std::int32_t child = split_a ? part_a.number : part_b.number;
    const BoxNode& split = (split_a ? a_ : b_).tree().boxes().node(child);
    const OrientedBox other =
        split_a ? placedBox(b_.box(pair.b), boxes_AB_) : placedBox(a_.box(pair.a), boxes_BA_);
    float gap[BoxNode::kWidth];
    boxGaps(split, other, split_a ? direction_a_ : direction_b_, gap);
    result.visited += split.count;
    work_.add(split.count * kBoxWork);
    const double bar_now = bar();
    const std::size_t first = open_.size();
    for (int i = split.count; i-- > 0;) {
      // A bound that is proven for the parent also holds for its parts.
      const double found = static_cast<double>(gap[i]) - box_slack_;
      if (found > bar_now) {
        settle(std::max(found, pair.lower));
        continue;
      }
      BoxPair part = pair;
      (split_a ? part.a : part.b) = child * BoxNode::kWidth + i;
      part.lower = found > 0 ? std::max(found, pair.lower) : found;
      open_.pushSibling(first, part);
    }
  }

  void leaves(const BoxPair& pair, const Part& a, const Part& b) {
    if (a.kind == Kind::kTriangle && b.kind == Kind::kTriangle) {
      triangles(a.number, b.number);
      return;
    }
    const double along = gapAlongPlane(a, b);
    if (along > 0 && along > bar()) {
      visit();
      settle(std::max(along, pair.lower));
      return;
    }
    PairCache local;
    const bool known = has_warm_ && a == warm_a_ && b == warm_b_;
    const Interval d = known ? warm_ : hullPair(a, b, &local);
    const double lower = std::max(d.lower, pair.lower);
    const bool pieces = a.kind == Kind::kPiece || b.kind == Kind::kPiece;
    // Where patches touch, their triangles show whether the solids continue behind them.
    const bool touch = lower <= touching_.near() && opens_touching_;
    const bool close = d.upper - d.lower <= request.tolerance && !touch;
    // (For exact shapes, rounding may also leave the request open, but triangles would not help.)
    if (!pieces || lower > bar() || close || d.upper <= 0) {
      settle(lower);
      return;
    }
    open_.push({pair.a, pair.b, lower, true});
  }

  // Queries two convex parts: returns a lower bound on their distance and an upper bound on that of
  // the bodies.
  Interval hullPair(const Part& a, const Part& b, PairCache* cache) {
    visit();
    const double excess = a_.excess(a) + b_.excess(b);
    const ConvexView view_a = a_.view(a), view_b = b_.view(b);
    const double bar_now = bar();
    DistanceRequest own;
    own.iteration_limit = request.iteration_limit;
    // A tolerance much finer than the excess gains nothing.
    own.tolerance = std::max(request.tolerance - excess, 0.5 * request.tolerance);
    if (excess > request.tolerance) own.tolerance = 0.25 * excess;
    own.depth = deepens_;
    if (bar_now < kInfinity) own.threshold = bar_now;
    DistanceResult r = convexDistance(view_a, X_BA_, view_b, own, scratch_, cache, slack_);
    result.iterations += r.iterations;
    // (Normals of closed forms may err by more than rounding_ covers.)
    if (r.distance.lower > 0) keepPlane(r.normal.normalized());
    if (r.distance.lower > bar_now) return {r.distance.lower, r.distance.upper + excess};
    if (r.status != DistanceStatus::kConverged && !(r.distance.upper + excess <= 0 && !deepens_)) {
      // The pair is closer than the best known pair, so its distance is queried. If the hulls
      // overlap, the query is whether the overlap exceeds their excess.
      const double lower = r.distance.lower;
      own.threshold = request.threshold - excess;
      if (r.distance.upper <= 0 && !deepens_) {
        own.threshold = -excess;
        own.depth = excess > 0;
      }
      r = convexDistance(view_a, X_BA_, view_b, own, scratch_, cache, slack_);
      result.iterations += r.iterations;
      r.distance.lower = std::max(r.distance.lower, lower);
    }
    if (r.distance.upper + excess < result.upper) best_ = *cache;
    offer(r, r.distance.upper + excess, a, b);
    return {r.distance.lower, r.distance.upper + excess};
  }

  void triangles(int slot_a, int slot_b) {
    visit();
    work_.add(kBoxWork);
    const Vector* corners_a = a_.tree().corners(slot_a);
    const Vector* q = b_.tree().corners(slot_b);
    const double along = gapAlongPlane(corners_a, q);
    if (along > 0 && along > bar()) {
      settle(along);
      return;
    }
    const Vector p[3] = {placed(X_BA_, corners_a[0]), placed(X_BA_, corners_a[1]),
                         placed(X_BA_, corners_a[2])};
    const TrianglePair pair = trianglePair(p, q);
    ++result.iterations;
    const double lower = pair.below - rounding_, upper = pair.above + rounding_;
    if (lower > 0) keepPlane(pair.normal);
    const Part a{Kind::kTriangle, slot_a}, b{Kind::kTriangle, slot_b};
    if (lower > 0 && (lower > bar() || upper - lower <= request.tolerance)) {
      settle(lower);
      if (lower <= touching_.near()) touching_.add(p, q);
      if (!(upper < result.upper)) return;
      DistanceResult r;
      r.normal = pair.normal;
      r.point_a = pair.p;
      r.point_b = pair.q;
      offer(r, upper, a, b);
      return;
    }
    // They cross or touch, or one is a sliver.
    DistanceRequest own;
    own.threshold = request.threshold;
    own.tolerance = request.tolerance;
    own.depth = false;
    own.iteration_limit = request.iteration_limit;
    PairCache* none = nullptr;
    DistanceResult r = convexDistance(a_.view(a), X_BA_, b_.view(b), own, scratch_, none, slack_);
    result.iterations += r.iterations;
    settle(std::max(lower, r.distance.lower));
    if (r.distance.upper > 0 && r.distance.lower <= touching_.near()) touching_.add(p, q);
    if (upper < r.distance.upper) {  // the query may have stopped early
      r.point_a = pair.p;
      r.point_b = pair.q;
      if (lower > 0) r.normal = pair.normal;
      r.distance.upper = upper;
    }
    offer(r, r.distance.upper, a, b);
  }

  void keepPlane(const Vector& normal) {
    if (!(normal.squaredNorm() > 0.5)) return;  // none, or NaN
    has_plane_ = true;
    plane_b_ = normal;
    plane_a_ = rotatedBack(X_BA_.rotation, normal);
    plane_offset_ = normal.dot(X_BA_.translation);
    direction_a_ = boxDirection(plane_a_);
    direction_b_ = boxDirection(plane_b_);
  }

  // The gap that the plane which separated two previous triangles proves for these two. It is
  // sufficient for most of the remaining pairs.
  double gapAlongPlane(const Vector* a, const Vector* b) const {
    if (!has_plane_) return -kInfinity;
    const Vector &m = plane_a_, &n = plane_b_;
    const double top = std::max({m.dot(a[0]), m.dot(a[1]), m.dot(a[2])}) + plane_offset_;
    return std::min({n.dot(b[0]), n.dot(b[1]), n.dot(b[2])}) - top - rounding_;
  }

  double gapAlongPlane(const Part& a, const Part& b) const {
    if (!has_plane_) return -kInfinity;
    const ConvexView view_a = a_.view(a), view_b = b_.view(b);
    int hint = 0;
    const double top = plane_a_.dot(farthest(view_a, plane_a_, hint)) + plane_offset_;
    hint = 0;
    return plane_b_.dot(farthest(view_b, -plane_b_, hint)) - top - rounding_ -
           (view_a.radius + view_a.excess) - (view_b.radius + view_b.excess);
  }

  void offer(const DistanceResult& r, double upper, const Part& a, const Part& b) {
    if (!DescentBounds::offer(r, upper, a_.triangleOf(a), b_.triangleOf(b))) return;
    best_a_ = a;
    best_b_ = b;
  }

  // Bodies with separate surfaces may still contain each other, unless the plane between the
  // witnesses separates their hulls.
  void hulls() {
    if (hulls_known_ || result.hull_lower > 0 || !(result.lower > 0) ||
        best_a_.kind == Kind::kNode) {
      return;
    }
    const Vector& n = result.witness.normal;
    int hint_a = 0, hint_b = 0;
    const ConvexView hull_a = a_.hull(), hull_b = b_.hull();
    const Vector p = placed(X_BA_, farthest(hull_a, rotatedBack(X_BA_.rotation, n), hint_a));
    const Vector q = farthest(hull_b, -n, hint_b);
    result.hull_lower =
        std::max(result.hull_lower, n.dot(q - p) - rounding_ - hull_a.excess - hull_b.excess);
  }

  // Stores pieces in the cache like triangles, with higher numbers.
  void remember() {
    if (best_a_.kind != Kind::kPiece && best_b_.kind != Kind::kPiece) return;
    cache_ = best_;
    cache_.triangle_a = a_.numberOf(best_a_);
    cache_.triangle_b = b_.numberOf(best_b_);
  }

  const MeshBody a_, b_;
  const Pose& X_BA_;
  Pose boxes_BA_, boxes_AB_;  // between the coordinates of boxes
  const double slack_, hull_excess_;
  Scratch& scratch_;
  Work& work_;
  TouchingTriangles& touching_;
  PairCache& cache_;
  double rounding_ = 0;   // of a pair of triangles, including the poses' slack [m]
  double box_slack_ = 0;  // the same of a pair of boxes
  bool parts_ = false;    // both bodies consist of convex parts; against triangles, parts are not
                          // worthwhile
  bool opens_touching_ = false;  // two meshes, unless all pieces are solids
  bool deepens_ = false, hulls_known_ = false;
  bool has_plane_ = false;
  Vector plane_a_, plane_b_;  // unit, from A to B, in either frame; for B also its offset [m]
  double plane_offset_ = 0;
  BoxDirection direction_a_{}, direction_b_{};
  Part best_a_{Kind::kNode, 0}, best_b_{Kind::kNode, 0};  // these determine the upper end
  PairCache best_;                                        // cache of these, if they are hulls
  bool has_warm_ = false;
  Part warm_a_{Kind::kNode, 0}, warm_b_{Kind::kNode, 0};
  Interval warm_;
  // Each popped pair pushes at most kWidth, one level lower on one side; or itself, opened.
  BranchAndBound<BoxPair, 2 * (BoxTree::kMaxDepth + 1) * (BoxNode::kWidth - 1) + 1> open_;
};

}  // namespace

bool takesPair(const DescentSide& a, const DescentSide& b, const DescentPlacement& placement) {
  if (placement.swept) return false;
  const auto hasBoxes = [](const DescentSide& side) {
    return side.tree != nullptr ? side.tree->boxes().usable() : isBounded(side);
  };
  return (a.tree != nullptr || b.tree != nullptr) && hasBoxes(a) && hasBoxes(b);
}

bool deepensPair(const DescentSide& a, const DescentSide& b) {
  return (a.tree == nullptr || hasPieces(a)) && (b.tree == nullptr || hasPieces(b));
}

DescentResult descendPair(const DescentSide& a, const DescentSide& b,
                          const DescentPlacement& placement, const DistanceRequest& request,
                          Scratch& scratch, PairCache* cache) {
  return PairDescent(a, b, placement, request, scratch, *cache).run();
}

}  // namespace leeway::collision
