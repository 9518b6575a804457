#include "collision/convex/pairs/simple_answer.h"

#include "collision/base/tolerances.h"
#include "collision/convex/pairs/box_pairs.h"
#include "collision/convex/pairs/cylinder_pairs.h"
#include "collision/convex/pairs/simple_pairs.h"

namespace leeway::collision {

namespace {

// The goal has room for rounding. If the poses' slack needs more, answer() finds that the request
// is not met.
Goal goalOf(const PairFrame& frame, const DistanceRequest& request) {
  const double core = request.threshold + (frame.radius_a + frame.radius_b);
  const double room = 256 * kUnitRoundoff * (std::abs(core) + frame.extent_a + frame.extent_b);
  return {core + room, core - room};
}

// The reach of a core from its centre along a unit vector, and a lower bound on the distance at
// which a ray along that vector leaves the core.
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

// Along the line of the centres: the plane across the line and the points where it leaves the
// bodies decide most thresholds.
bool settleAlongCenters(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                        const Goal& goal, Nearest& nearest) {
  const Triple d = tripleOf(X_WA.translation) - tripleOf(X_WB.translation);
  const double length = std::sqrt(squared(d));
  const Triple n = (-1 / length) * d;
  const Ray ray_a = rayOf(a, X_WA.rotation, n), ray_b = rayOf(b, X_WB.rotation, n);
  const double plane = length - (ray_a.reach + ray_b.reach);
  const double apart = length - (ray_a.exit + ray_b.exit);
  if (!eitherIsGreater(BodyLanes{plane, goal.below}, BodyLanes{goal.above, apart}) || !(apart > 0))
    return false;
  nearest.point_a = d + ray_a.exit * n;
  nearest.apart = apart;
  nearest.normal = n;
  nearest.plane = plane;
  return true;
}

// Two boxes, by alternating projections: B's point nearest to A's centre, A's point nearest to
// that, and B's point nearest to that one. The vector between the last two and the plane across it
// decide nine thresholds out of ten, most of them before the last projection.
bool settleBoxes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                 const Goal& goal, Nearest& nearest) {
  const Eigen::Matrix3d &R = X_WA.rotation, &S = X_WB.rotation;
  const Triple half_a = tripleOf(a.halfExtents()), half_b = tripleOf(b.halfExtents());
  const Triple d = tripleOf(X_WA.translation) - tripleOf(X_WB.translation);
  Triple q = rotated(S, within(rotatedBack(S, d), half_b));
  const Triple p = d + rotated(R, within(rotatedBack(R, q - d), half_a));
  for (bool last = false;; last = true) {
    const Triple w = q - p;
    const double apart = std::sqrt(squared(w));
    // The reach of both along w, one lane each. (Divided last, so that it need not wait for the
    // root.)
    const auto along = [&](int k) __attribute__((always_inline)) {
      const BodyLanes x = {R(0, k), S(0, k)}, y = {R(1, k), S(1, k)}, z = {R(2, k), S(2, k)};
      return magnitude(x * BodyLanes{w.x, w.x} + y * BodyLanes{w.y, w.y} + z * BodyLanes{w.z, w.z});
    };
    const BodyLanes reach = along(0) * BodyLanes{half_a.x, half_b.x} +
                            along(1) * BodyLanes{half_a.y, half_b.y} +
                            along(2) * BodyLanes{half_a.z, half_b.z};
    const double per = 1 / apart;
    const double plane = per * (-dot(w, d) - (reach[0] + reach[1]));
    // (NaN, where the points coincide, decides nothing.)
    if (eitherIsGreater(BodyLanes{plane, goal.below}, BodyLanes{goal.above, apart})) {
      nearest.point_a = p;
      nearest.apart = apart;
      nearest.normal = per * w;
      nearest.plane = plane;
      return true;
    }
    if (last) return false;
    q = rotated(S, within(rotatedBack(S, p), half_b));
  }
}

// Swaps A and B, and with them the origin.
bool exchanged(const Pose& X_WA, const Pose& X_WB, Nearest& nearest) {
  nearest.point_a = nearest.point_a + nearest.wayToB() +
                    (tripleOf(X_WA.translation) - tripleOf(X_WB.translation));
  if (nearest.early) nearest.way = -nearest.way;
  nearest.normal = -nearest.normal;
  return true;
}

double coreExtent(const Shape& shape) {
  return shape.type() >= ShapeType::kBox ? shape.extent() : shape.halfLength();
}
double coreRadius(const Shape& shape) {
  return shape.type() <= ShapeType::kCapsule ? shape.radius() : 0;
}

constexpr unsigned kTypes = 4;  // sphere, capsule, box, cylinder: the first of ShapeType
constexpr unsigned pairOf(ShapeType a, ShapeType b) {
  return static_cast<unsigned>(a) * kTypes + static_cast<unsigned>(b);
}

bool nearestOfBoxPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                      const Goal& goal, const PairCache* cache, Nearest& nearest) {
  using enum ShapeType;
  switch (pairOf(a.type(), b.type())) {
    case pairOf(kSphere, kBox):
      return nearestOfSphereAndBox(X_WA, b, X_WB, nearest);
    case pairOf(kCapsule, kBox):
      return nearestOfCapsuleAndBox(a, X_WA, b, X_WB, nearest);
    case pairOf(kBox, kSphere):
      return nearestOfSphereAndBox(X_WB, a, X_WA, nearest) && exchanged(X_WA, X_WB, nearest);
    case pairOf(kBox, kCapsule):
      return nearestOfCapsuleAndBox(b, X_WB, a, X_WA, nearest) && exchanged(X_WA, X_WB, nearest);
    case pairOf(kCylinder, kSphere):
      return nearestOfCylinderAndPoint(a, X_WA, X_WB, nearest);
    case pairOf(kCylinder, kCapsule):
      return nearestOfCylinderAndCapsule(a, X_WA, b, X_WB, nearest);
    case pairOf(kCylinder, kBox):
      return nearestOfCylinderAndBox(a, X_WA, b, X_WB, goal, nearest);
    case pairOf(kSphere, kCylinder):
      return nearestOfCylinderAndPoint(b, X_WB, X_WA, nearest) && exchanged(X_WA, X_WB, nearest);
    case pairOf(kCapsule, kCylinder):
      return nearestOfCylinderAndCapsule(b, X_WB, a, X_WA, nearest) &&
             exchanged(X_WA, X_WB, nearest);
    case pairOf(kBox, kCylinder):
      return nearestOfCylinderAndBox(b, X_WB, a, X_WA, goal, nearest) &&
             exchanged(X_WA, X_WB, nearest);
    case pairOf(kCylinder, kCylinder):
      return nearestOfCylinders(a, X_WA, b, X_WB, goal, nearest);
    case pairOf(kBox, kBox):
      return nearestOfBoxes(a, X_WA, b, X_WB, goal, cache, nearest);
    default:
      return false;
  }
}

}  // namespace

bool answerBoxPair(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                   const DistanceRequest& request, PairCache* cache, DistanceResult& result) {
  if (a.type() > ShapeType::kCylinder || b.type() > ShapeType::kCylinder ||
      request.iteration_limit <= 0) {
    return false;
  }
  const PairFrame frame = {X_WA, X_WB, coreExtent(a), coreExtent(b), coreRadius(a), coreRadius(b)};
  const Goal goal = goalOf(frame, request);
  Nearest nearest;
  PairAnswer found;
  const bool boxes = a.type() == ShapeType::kBox && b.type() == ShapeType::kBox;
  if (!((goal.asked() && (boxes ? settleBoxes(a, X_WA, b, X_WB, goal, nearest)
                                : settleAlongCenters(a, X_WA, b, X_WB, goal, nearest))) ||
        nearestOfBoxPair(a, X_WA, b, X_WB, goal, cache, nearest)) ||
      !answer(frame, nearest, request, cache, found)) {
    return false;
  }
  found.writeTo(result);
  return true;
}

}  // namespace leeway::collision
