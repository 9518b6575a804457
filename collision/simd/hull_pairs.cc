#include "collision/simd/hull_pairs.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/simd/hull_pairs.cc"
#include "collision/simd/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/pose_check.h"
#include "collision/simd/vertex_gjk.h"
#include "collision/simd/vertex_search-inl.h"
#include "collision/status.h"
#include "collision/support.h"
#include "leeway/collision/tolerances.h"

// Rounding, in units of u L with u = kUnitRoundoff and L = extent A + extent B + |t|, of the two
// ends (see gjk.cc). Along the world's axes, with the origin at B's:
//   the translation 1 |t|; a vertex 3 sqrt(3) of its extent, A's one more of its and of |t|
//   a choice among placed vertices 6 of extents and |t|; after a direction was turned back 2 * 5.2
//   of the extent more, and without |t|
//   b - a 1 L, the dot product 3 L, the direction's length 3 L
// in sum 30 of an extent and 15 |t|; and a rotation's departure errs by 9, which the caller may
// have meant to move the body by half of that: less than kSupportRounding + kPoseRounding = 56.

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {
namespace {

// A hull at its pose: R v + t.
class WorldHull {
 public:
  HWY_INLINE WorldHull(const Shape& shape, const Eigen::Matrix3d& R, const Triple& t, bool place)
      : hull_(*shape.hull()), support_(hull_.support()), R_(R), t_(t), extent_(shape.extent()) {
    if (place) vertices_.place(support_, R_, t_);
  }

  HWY_INLINE Triple farthest(const Triple& n, std::int32_t& name) const {
    if (!vertices_.empty()) return vertices_.farthest(n, name);
    const Triple d = rotatedBack(R_, n);
    const int found = scannedSupport(support_, d, name);
    name = HWY_LIKELY(found >= 0) ? found : climbed(d, name);
    return vertex(name);
  }
  HWY_INLINE Triple vertex(int name) const {
    return placed(hull_.vertices()[static_cast<std::size_t>(name)]);
  }
  HWY_INLINE Triple placed(const Vector& v) const { return rotated(R_, tripleOf(v)) + t_; }

 private:
  // As farthestPoint().
  HWY_NOINLINE std::int32_t climbed(const Triple& d, std::int32_t hint) const {
    const double length = std::sqrt(squared(d));
    return climbFarthest(hull_, support_.points(), static_cast<int>(hull_.vertices().size()),
                         Vector(d.x / length, d.y / length, d.z / length), hint,
                         8 * kUnitRoundoff * extent_);
  }

  const ConvexHull& hull_;
  const HullSupport& support_;
  const Eigen::Matrix3d& R_;
  const Triple t_;
  const double extent_;
  PlacedVertices vertices_;
};

struct WorldCores {
  const WorldHull &a, &b;
  HWY_INLINE Triple support(const Triple& n, VertexNames& names) const {
    return b.farthest(-n, names.b) - a.farthest(n, names.a);
  }
  HWY_INLINE Triple member(const VertexNames& names) const {
    return b.vertex(names.b) - a.vertex(names.a);
  }
};

// The cached direction if it is one, else from A's middle to B's.
HWY_INLINE Triple firstDirection(const Shape& a, const WorldHull& hull_a, const Shape& b,
                                 const WorldHull& hull_b, const Eigen::Matrix3d& R_WB,
                                 const PairCache* cache) {
  if (cache != nullptr) {
    const Triple n = tripleOf(cache->direction_B);
    const double length_squared = squared(n);
    if (length_squared > 0.25 && length_squared < 4) {  // NaN fails
      return (1 / std::sqrt(length_squared)) * rotated(R_WB, n);
    }
  }
  const Triple middle = hull_b.placed(b.boundingCenter()) - hull_a.placed(a.boundingCenter());
  const double length = std::sqrt(squared(middle));
  return length > 0 ? (1 / length) * middle : Triple{1, 0, 0};
}

// Without a table or columns only general code knows the farthest vertex.
HWY_INLINE bool isQuick(const HullSupport& support) {
  return support.length() > 0 || support.sides() > 0;
}

}  // namespace

bool hullSteps(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
               const DistanceRequest& request, PairCache* cache, DistanceResult& result,
               VertexStart& start) {
  const ConvexHull &points_a = *a.hull(), &points_b = *b.hull();
  if (!(isQuick(points_a.support()) && isQuick(points_b.support()))) return false;
  const bool threshold = !std::isnan(request.threshold);
  const int count_a = static_cast<int>(points_a.vertices().size());
  const int count_b = static_cast<int>(points_b.vertices().size());
  const bool carried = cache != nullptr && !threshold && fits(*cache, count_a, count_b);
  // Many steps on large hulls turn one direction less each in B's frame.
  const bool place = !carried && !threshold;
  if (place &&
      !(PlacedVertices::takes(points_a.support()) && PlacedVertices::takes(points_b.support()))) {
    return false;
  }
  const PoseCheck check = checkRotations(X_WA.rotation, X_WB.rotation);
  const Triple t_b = tripleOf(X_WB.translation), t = tripleOf(X_WA.translation) - t_b;
  const double extents = a.extent() + b.extent();
  const double size = extents + std::sqrt(squared(t));
  // Written so that NaN fails.
  if (!(check.rotations && size >= kSmallestScale && size <= kLargestScale) ||
      request.iteration_limit <= 0) {
    return false;
  }
  const double rounding =
      (kSupportRounding + kPoseRounding) * kUnitRoundoff * size + check.departure * size;
  const double lower_offset = points_a.excess() + points_b.excess() + rounding;

  const WorldHull hull_a(a, X_WA.rotation, t, place);
  const WorldHull hull_b(b, X_WB.rotation, {0, 0, 0}, place);
  const WorldCores cores = {hull_a, hull_b};
  VertexNames hints = {0, 0};
  if (cache != nullptr) {
    if (cache->vertex_a > 0 && cache->vertex_a < count_a) hints.a = cache->vertex_a;
    if (cache->vertex_b > 0 && cache->vertex_b < count_b) hints.b = cache->vertex_b;
  }
  Search<WorldCores> search(cores, request, lower_offset, -rounding, 0);
  const Triple first =
      carried ? Triple{1, 0, 0} : firstDirection(a, hull_a, b, hull_b, X_WB.rotation, cache);
  const GjkEnd end = search.run(first, carried ? cache : nullptr, hints);

  Carriers found;
  search.carriers(end, found);
  Triple w = {0, 0, 0}, p = {0, 0, 0};
  for (int i = 0; i < found.count; ++i) {
    start.vertex_a[i] = found.names[i].a;
    start.vertex_b[i] = found.names[i].b;
    w = w + found.weight[i] * found.w[i];
    p = p + found.weight[i] * hull_a.vertex(found.names[i].a);
  }
  start.count = end == GjkEnd::kLimit ? 0 : found.count;
  start.end = end;
  start.iterations = search.iterations();
  if (found.count == 0 || end == GjkEnd::kInside) return false;
  // As Progress has it.
  const Interval separation = {search.best().value() - lower_offset,
                               std::sqrt(squared(w)) + rounding};
  const bool enough = (separation.width() <= request.tolerance && isSignKnown(separation)) ||
                      isDecided(separation, request);
  const Triple point_a = t_b + p, point_b = point_a + w;
  const Triple& plane = search.best().direction();
  const Triple n = (1 / std::sqrt(squared(plane))) * plane;
  // Coordinates beyond 1e308 overflow.
  const double sum = std::abs(point_a.x + point_a.y + point_a.z) + std::abs(n.x + n.y + n.z);
  if (!enough || !(sum <= 1e300)) return false;
  result.distance = separation;
  result.status = statusOf(separation, request);
  result.iterations = search.iterations();
  write(point_a, result.point_a);
  write(point_b, result.point_b);
  write(n, result.normal);
  if (cache != nullptr) {
    write(rotatedBack(X_WB.rotation, n), cache->direction_B);
    cache->vertex_a = search.lastNames().a;
    cache->vertex_b = search.lastNames().b;
    cache->simplex_count = found.count;
    for (int i = 0; i < found.count; ++i) {
      cache->simplex_a[i] = found.names[i].a;
      cache->simplex_b[i] = found.names[i].b;
    }
  }
  return true;
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(hullSteps);

bool answerHullPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const DistanceRequest& request, PairCache* cache, DistanceResult& result,
                    VertexStart& start) {
  return HWY_DYNAMIC_DISPATCH(hullSteps)(a, X_WA, b, X_WB, request, cache, result, start);
}

}  // namespace leeway::collision
#endif
