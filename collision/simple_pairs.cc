#include "collision/simple_pairs.h"

#include "collision/box_pairs.h"
#include "collision/closed_form.h"
#include "collision/cylinder_pairs.h"
#include "collision/pose_check.h"
#include "collision/status.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {

// Rounding, in units of u L with u = kUnitRoundoff and L >= extent A + extent B + |t|, of points
// and planes given the frames that they are made in: a box's frame, made with what kPoseRounding
// covers, or the world's axes. Points: halves 1 or 2 units, the translation 1, sums 3, their
// difference 1, its norm 3: less than 10. Planes of segments: dot products 3, with a unit vector's
// own length 4 and three sums 3: less than 16; of boxes less than 22 (see box_overlap.cc).
// kClosedFormRounding covers all of them.

namespace {

// What a query knows of its pair besides the cores' nearest points.
struct Frame {
  const Pose& X_WA;
  const Pose& X_WB;
  double extent_a, extent_b;  // of the cores
  double radius_a, radius_b;
};

// False when this does not do.
inline __attribute__((always_inline)) bool answer(const Frame& frame, const Nearest& nearest,
                                                  const DistanceRequest& request, PairCache* cache,
                                                  DistanceResult& result) {
  const PoseCheck check = checkRotations(frame.X_WA.rotation, frame.X_WB.rotation);
  const double radii = frame.radius_a + frame.radius_b;
  // |t| <= apart + both extents. (What waits for the root of `apart` is kept short.)
  const double share = check.departure + (kClosedFormRounding + kPoseRounding) * kUnitRoundoff;
  const double extents = 2 * (frame.extent_a + frame.extent_b);
  const double size = nearest.apart + extents;
  const double rounding = share * nearest.apart + (share * extents + 4 * kUnitRoundoff * radii);
  const Interval found = {(nearest.plane - radii) - rounding, (nearest.apart - radii) + rounding};
  const bool enough =
      (found.width() <= request.tolerance && isSignKnown(found)) || isDecided(found, request);
  // Written so that NaN fails; a translation that is not finite gives no finite size.
  if (!(enough && check.rotations && nearest.apart > 64 * kUnitRoundoff * size &&
        size + radii >= kSmallestScale && size + radii <= kLargestScale)) {
    return false;
  }
  result.distance = found;
  result.status = statusOf(found, request);
  const Triple& n = nearest.normal;
  const Triple core = tripleOf(frame.X_WB.translation) + nearest.point_a;
  const Triple along = nearest.early ? (1 / nearest.apart) * nearest.way : n;
  write(core + frame.radius_a * along, result.point_a);
  write(core + (nearest.apart - frame.radius_b) * along, result.point_b);
  write(n, result.normal);
  result.iterations = 1;
  if (cache != nullptr) write(rotatedBack(frame.X_WB.rotation, n), cache->direction_B);
  return true;
}

// With room for rounding that a threshold near the distance leaves; where the slack of poses takes
// more, answer() sees that it did not do.
Goal goalOf(const Frame& frame, const DistanceRequest& request) {
  const double core = request.threshold + (frame.radius_a + frame.radius_b);
  const double room = 256 * kUnitRoundoff * (std::abs(core) + frame.extent_a + frame.extent_b);
  return {core + room, core - room};
}

// How far a core reaches from its centre along a unit vector, and where a ray along it leaves the
// core (or before that).
struct Ray {
  double reach = 0, exit = 0;
};
Ray rayOf(const Shape& shape, const Eigen::Matrix3d& R, const Triple& n) {
  const double z = std::abs(dot(n, column(R, 2)));
  switch (shape.type()) {
    case ShapeType::kCapsule:
      return {shape.halfLength() * z, 0};
    case ShapeType::kBox: {
      const double x = std::abs(dot(n, column(R, 0))), y = std::abs(dot(n, column(R, 1)));
      const Eigen::Vector3d& half = shape.halfExtents();
      return {half.x() * x + half.y() * y + half.z() * z,
              std::min(half.x() / std::max(x, kInsteadOfZero),
                       std::min(half.y() / std::max(y, kInsteadOfZero),
                                half.z() / std::max(z, kInsteadOfZero)))};
    }
    case ShapeType::kCylinder: {
      const Triple u = column(R, 2);
      const double across = std::sqrt(squared(n - dot(n, u) * u));
      return {shape.halfLength() * z + shape.radius() * across,
              std::min(shape.halfLength() / std::max(z, kInsteadOfZero),
                       shape.radius() / std::max(across, kInsteadOfZero))};
    }
    default:
      return {};
  }
}

// Along the line of the centres: the plane across it and the points where it leaves the bodies
// decide most thresholds.
bool settleAlongCenters(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const Goal& goal, Nearest& nearest) {
  const Triple d = tripleOf(X_WA.translation) - tripleOf(X_WB.translation);
  const double length = std::sqrt(squared(d));
  const Triple n = (-1 / length) * d;
  const Ray ray_a = rayOf(a, X_WA.rotation, n), ray_b = rayOf(b, X_WB.rotation, n);
  const double plane = length - (ray_a.reach + ray_b.reach);
  const double apart = length - (ray_a.exit + ray_b.exit);
  if (!(plane > goal.above || apart < goal.below) || !(apart > 0)) return false;
  nearest.point_a = d + ray_a.exit * n;
  nearest.apart = apart;
  nearest.normal = n;
  nearest.plane = plane;
  return true;
}

// Two segments or points, along the world's axes: neither frame is needed. After Lumelsky (1985);
// near parallel the points can be poor, which the plane tells.
template <bool kSegmentA, bool kSegmentB>
inline __attribute__((always_inline)) bool answerSegments(const Shape& a, const Pose& X_WA,
                                                          const Shape& b, const Pose& X_WB,
                                                          const DistanceRequest& request,
                                                          PairCache* cache,
                                                          DistanceResult& result) {
  const double extent_a = kSegmentA ? a.halfLength() : 0, extent_b = kSegmentB ? b.halfLength() : 0;
  const Eigen::Matrix3d &R = X_WA.rotation, &S = X_WB.rotation;
  const Triple d = tripleOf(X_WA.translation) - tripleOf(X_WB.translation);
  Nearest nearest;
  nearest.point_a = d;
  if constexpr (kSegmentA && kSegmentB) {
    // Both axes, side by side.
    const BodyLanes x = {R(0, 2), S(0, 2)}, y = {R(1, 2), S(1, 2)}, z = {R(2, 2), S(2, 2)};
    const auto along = [&](const Triple& v) __attribute__((always_inline)) {
      return x * BodyLanes{v.x, v.x} + y * BodyLanes{v.y, v.y} + z * BodyLanes{v.z, v.z};
    };
    const BodyLanes along_d = along(d);
    double s_a = 0, s_b = 0;
    nearestOnAxes(x[0] * x[1] + y[0] * y[1] + z[0] * z[1], along_d[0], along_d[1], extent_a,
                  extent_b, s_a, s_b);
    nearest.point_a = {d.x + s_a * x[0], d.y + s_a * y[0], d.z + s_a * z[0]};
    const Triple w = Triple{s_b * x[1], s_b * y[1], s_b * z[1]} - nearest.point_a;
    nearest.apart = std::sqrt(squared(w));
    const double per = 1 / nearest.apart;
    nearest.normal = per * w;
    // (Divided last, it need not wait for the root.)
    const BodyLanes reach = along(w);
    nearest.plane =
        per * (-dot(w, d) - (std::abs(reach[0]) * extent_a + std::abs(reach[1]) * extent_b));
  } else {
    Triple w = -d, half = {0, 0, 0};
    if constexpr (kSegmentA) {
      half = extent_a * column(R, 2);
      nearest.point_a = d - nearestOnSegment(d, half) * half;
      w = -nearest.point_a;
    } else if constexpr (kSegmentB) {
      half = extent_b * column(S, 2);
      w = nearestOnSegment(d, half) * half - d;
    }
    nearest.apart = nearest.plane = std::sqrt(squared(w));
    const double per = 1 / nearest.apart;
    nearest.normal = per * w;
    // From a point the distance itself errs by little; but the normal of a short way is not at a
    // right angle to the segment, and callers rely on the plane.
    if constexpr (kSegmentA || kSegmentB)
      nearest.plane = per * (-dot(w, d) - std::abs(dot(w, half)));
  }
  return answer({X_WA, X_WB, extent_a, extent_b, a.radius(), b.radius()}, nearest, request, cache,
                result);
}

// Exchanges A and B, and with them the origin.
bool exchanged(const Pose& X_WA, const Pose& X_WB, Nearest& nearest) {
  nearest.point_a = nearest.point_a + nearest.wayToB() +
                    (tripleOf(X_WA.translation) - tripleOf(X_WB.translation));
  if (nearest.early) nearest.way = -nearest.way;
  nearest.normal = -nearest.normal;
  return true;
}

constexpr unsigned kTypes = 4;  // sphere, capsule, box, cylinder: the first of ShapeType
constexpr unsigned pairOf(ShapeType a, ShapeType b) {
  return static_cast<unsigned>(a) * kTypes + static_cast<unsigned>(b);
}

double coreExtent(const Shape& shape) {
  return shape.type() >= ShapeType::kBox ? shape.extent() : shape.halfLength();
}
double coreRadius(const Shape& shape) {
  return shape.type() <= ShapeType::kCapsule ? shape.radius() : 0;
}

// Pairs with a box or cylinder; on its own so that the others need not save what it uses.
__attribute__((noinline)) bool answerBoxPair(const Shape& a, const Pose& X_WA, const Shape& b,
                                             const Pose& X_WB, const DistanceRequest& request,
                                             PairCache* cache, DistanceResult& result) {
  using enum ShapeType;
  const Frame frame = {X_WA, X_WB, coreExtent(a), coreExtent(b), coreRadius(a), coreRadius(b)};
  const Goal goal = goalOf(frame, request);
  Nearest nearest;
  if (goal.asked() && settleAlongCenters(a, X_WA, b, X_WB, goal, nearest) &&
      answer(frame, nearest, request, cache, result)) {
    return true;
  }
  bool found = false;
  switch (pairOf(a.type(), b.type())) {
    case pairOf(kSphere, kBox):
      found = nearestOfSphereAndBox(X_WA, b, X_WB, nearest);
      break;
    case pairOf(kCapsule, kBox):
      found = nearestOfCapsuleAndBox(a, X_WA, b, X_WB, nearest);
      break;
    case pairOf(kBox, kSphere):
      found = nearestOfSphereAndBox(X_WB, a, X_WA, nearest) && exchanged(X_WA, X_WB, nearest);
      break;
    case pairOf(kBox, kCapsule):
      found = nearestOfCapsuleAndBox(b, X_WB, a, X_WA, nearest) && exchanged(X_WA, X_WB, nearest);
      break;
    case pairOf(kCylinder, kSphere):
      found = nearestOfCylinderAndPoint(a, X_WA, X_WB, nearest);
      break;
    case pairOf(kCylinder, kCapsule):
      found = nearestOfCylinderAndCapsule(a, X_WA, b, X_WB, nearest);
      break;
    case pairOf(kCylinder, kBox):
      found = nearestOfCylinderAndBox(a, X_WA, b, X_WB, goal, nearest);
      break;
    case pairOf(kSphere, kCylinder):
      found = nearestOfCylinderAndPoint(b, X_WB, X_WA, nearest) && exchanged(X_WA, X_WB, nearest);
      break;
    case pairOf(kCapsule, kCylinder):
      found =
          nearestOfCylinderAndCapsule(b, X_WB, a, X_WA, nearest) && exchanged(X_WA, X_WB, nearest);
      break;
    case pairOf(kBox, kCylinder):
      found = nearestOfCylinderAndBox(b, X_WB, a, X_WA, goal, nearest) &&
              exchanged(X_WA, X_WB, nearest);
      break;
    case pairOf(kCylinder, kCylinder):
      found = nearestOfCylinders(a, X_WA, b, X_WB, goal, nearest);
      break;
    case pairOf(kBox, kBox):
      found = nearestOfBoxes(a, X_WA, b, X_WB, goal, cache, nearest);
      break;
    default:
      return false;
  }
  return found && answer(frame, nearest, request, cache, result);
}

}  // namespace

bool answerSimplePair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      const DistanceRequest& request, PairCache* cache, DistanceResult& result) {
  using enum ShapeType;
  if (a.type() > kCylinder || b.type() > kCylinder || request.iteration_limit <= 0) return false;
  switch (pairOf(a.type(), b.type())) {
    case pairOf(kSphere, kSphere):
      return answerSegments<false, false>(a, X_WA, b, X_WB, request, cache, result);
    case pairOf(kSphere, kCapsule):
      return answerSegments<false, true>(a, X_WA, b, X_WB, request, cache, result);
    case pairOf(kCapsule, kSphere):
      return answerSegments<true, false>(a, X_WA, b, X_WB, request, cache, result);
    case pairOf(kCapsule, kCapsule):
      return answerSegments<true, true>(a, X_WA, b, X_WB, request, cache, result);
    default:
      return answerBoxPair(a, X_WA, b, X_WB, request, cache, result);
  }
}

}  // namespace leeway::collision
