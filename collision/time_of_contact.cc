#include "leeway/collision/time_of_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/convex.h"
#include "leeway/collision/time_to_impact.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where nothing turns, even what reaches infinitely far does not move faster.
double times(double rate, double reach) { return rate == 0 ? 0 : rate * reach; }

/// What is known at one moment of the motion.
struct Moment {
  DistanceResult distance;  // widened by rounding
  double closing = 0;       ///< no faster along the separating direction now; may be negative
  double acceleration = 0;  ///< of that, to the end of the motion
  double predicted = 0;     ///< closing speed of the witness points, for guesses only
};

/// The way that is certainly free from a moment on: gap - closing * s - acceleration * s^2 / 2 > 0
/// for s below.
double certainStep(double gap, const Moment& m) {
  if (!(gap > 0) || !(m.acceleration >= 0) || std::isnan(m.closing)) return 0;
  if (m.closing >= 0) return timeToImpact(gap, {m.closing, m.acceleration});
  if (m.acceleration == 0) return kInfinity;
  // Moving apart: first back to where it is, then on.
  const double apart = -m.closing;
  const double step =
      (apart + std::sqrt(apart * apart + 2 * m.acceleration * gap)) / m.acceleration;
  return step * (1 - 32 * kUnitRoundoff);
}

/// Follows a motion. Problem has: Moment look(t, tolerance), bool free(t, step): is it certified
/// over [t, t + step].
template <typename Problem>
ContactResult follow(Problem& problem, const ContactRequest& request) {
  ContactResult result;
  const double end = request.end;
  if (!(request.time_tolerance > 0) || !(request.tolerance > 0) || !(end >= 0 && end <= 1) ||
      !std::isfinite(request.margin))
    return result;
  double t = 0, tolerance = request.tolerance;
  // Open: everything before t is certified. At t itself nothing is known yet.
  const auto answer = [&](ContactStatus status, double upper, const Moment& m) {
    result.status = status;
    result.time = {t, upper};
    result.distance = m.distance;
    return result;
  };
  const auto touches = [&](const Moment& m) { return m.distance.distance.upper <= request.margin; };
  while (result.queries < request.query_limit) {
    const Moment now = problem.look(t, tolerance);
    ++result.queries;
    if (now.distance.status == DistanceStatus::kInvalid) {
      result.distance = now.distance;
      return result;
    }
    if (touches(now)) return answer(ContactStatus::kContact, t, now);
    const double gap = now.distance.distance.lower - request.margin;
    const double coming = now.predicted > 0 ? gap / now.predicted : kInfinity;
    if (!(coming > request.time_tolerance / 2) || !(gap > 0)) {
      // About to touch, as far as can be seen: is it proven a little later?
      const double later = std::min(t + request.time_tolerance, end);
      if (later > t) {
        const Moment then = problem.look(later, request.tolerance);
        ++result.queries;
        if (touches(then)) return answer(ContactStatus::kContact, later, then);
      }
      if (!(gap > 0)) {
        // The last look may have been a coarse one.
        if (tolerance > request.tolerance) {
          tolerance = request.tolerance;
          continue;
        }
        return answer(ContactStatus::kUndecided, kInfinity, now);
      }
    }
    double step = certainStep(gap, now);
    const double left = end - t;
    if (step < kContactStepShare * std::min(coming, left)) {
      for (double sweep = std::min(kContactSweepShare * coming, left);
           sweep > 2 * step && result.queries < request.query_limit; sweep /= 2) {
        ++result.queries;
        if (problem.free(t, sweep)) {
          step = sweep;
          break;
        }
      }
    }
    // Strictly: contact at the very end of the motion counts.
    if (step > left || left == 0) {
      result.status = ContactStatus::kFree;
      result.time = {kInfinity, kInfinity};
      result.distance = now.distance;
      return result;
    }
    const double next = t + step * (1 - 4 * kUnitRoundoff);
    if (!(next > t)) return answer(ContactStatus::kUndecided, kInfinity, now);
    t = std::min(next, end);
    tolerance = std::max(request.tolerance, kContactDistanceShare * gap *
                                                std::max(0.0, 1 - step / std::max(coming, step)));
    result.distance = now.distance;
  }
  result.status = ContactStatus::kUndecided;
  result.time = {t, kInfinity};
  return result;
}

DistanceRequest lookRequest(const ContactRequest& request, double tolerance) {
  DistanceRequest r;
  r.tolerance = tolerance;
  r.depth = request.margin < 0;
  return r;
}

DistanceRequest sweepRequest(const ContactRequest& request) {
  DistanceRequest r;
  r.threshold = request.margin;
  r.depth = false;
  return r;
}

void widen(DistanceResult& result, double slack) {
  result.distance.lower -= slack;
  result.distance.upper += slack;
}

/// Two rigid bodies.
struct RigidPair {
  const Shape& a;
  const RigidMotion& motion_a;
  const Shape& b;
  const RigidMotion& motion_b;
  const ContactRequest& request;
  Scratch& scratch;
  PairCache* cache;

  /// Of both poses, where the bodies are near each other; of a half-space only what A can meet.
  double rounding(const Pose& X_WA, const Pose& X_WB) const {
    const double between = (X_WA.translation - X_WB.translation).norm() + a.extent();
    return motion_a.rounding(a.extent()) + motion_b.rounding(std::min(b.extent(), between));
  }

  /// Speed of the body's bounding centre along n, and what turning adds to that at most.
  static double along(const Shape& shape, const RigidMotion& motion, const Pose& X, double t,
                      const Eigen::Vector3d& n, double sign) {
    const FrameVelocity v = motion.velocity(t);
    const Eigen::Vector3d arm = X.rotation * shape.boundingCenter();
    const double middle = n.dot(v.linear + v.angular.cross(arm));
    const double turning = times(n.cross(v.angular).norm(), shape.boundingRadius());
    const double slack =
        kMotionRounding * (v.linear.norm() + v.angular.norm() * arm.norm() + turning);
    return sign * middle + turning + slack;
  }

  /// Acceleration of any point of a body, in the world.
  static double acceleration(const Shape& shape, const FrameMotionBound& m) {
    return m.acceleration +
           times(m.angular_acceleration + m.angular_speed * m.angular_speed, shape.extent());
  }
  static double speed(const Shape& shape, const FrameMotionBound& m) {
    return m.speed + times(m.angular_speed, shape.extent());
  }

  Moment look(double t, double tolerance) {
    const Pose X_WA = motion_a.pose(t), X_WB = motion_b.pose(t);
    Moment m;
    m.distance = distance(a, X_WA, b, X_WB, lookRequest(request, tolerance), scratch, cache);
    widen(m.distance, rounding(X_WA, X_WB));
    const FrameMotionBound bound_a = motion_a.bound(t, request.end);
    const FrameMotionBound bound_b = motion_b.bound(t, request.end);
    const Eigen::Vector3d& n = m.distance.normal;
    const FrameVelocity va = motion_a.velocity(t), vb = motion_b.velocity(t);
    const auto at = [](const FrameVelocity& v, const Pose& X, const Eigen::Vector3d& p) {
      return Eigen::Vector3d(v.linear + v.angular.cross(p - X.translation));
    };
    m.predicted = n.dot(at(va, X_WA, m.distance.point_a) - at(vb, X_WB, m.distance.point_b));
    if (a.isConvex() && b.isConvex()) {
      // A plane with this normal keeps the bodies apart; what crosses it has to move along it.
      m.closing = along(a, motion_a, X_WA, t, n, 1) + along(b, motion_b, X_WB, t, n, -1);
      m.acceleration = acceleration(a, bound_a) + acceleration(b, bound_b);
    } else {
      m.closing = speed(a, bound_a) + speed(b, bound_b);
    }
    return m;
  }

  bool free(double t, double step) {
    const Pose X_WB0 = motion_b.pose(t), X_WB1 = motion_b.pose(t + step);
    const Pose X_WA0 = motion_a.pose(t), X_WA1 = motion_a.pose(t + step);
    const Pose X_BA0 = X_WB0.inverse() * X_WA0, X_BA1 = X_WB1.inverse() * X_WA1;
    const FrameMotionBound ma = motion_a.bound(t, t + step), mb = motion_b.bound(t, t + step);
    // A point of A seen from B's frame: p_B = R^T u with u = p_A - o_B, so that |p_B''| <= |u''| +
    // 2 w |u'| + (alpha + w^2) |u| with w and alpha of B.
    const double u_speed = speed(a, ma) + mb.speed;
    const double u = X_BA0.translation.norm() + times(1, a.extent()) + step * u_speed;
    double second = acceleration(a, ma) + mb.acceleration + times(2 * mb.angular_speed, u_speed) +
                    times(mb.angular_acceleration + mb.angular_speed * mb.angular_speed, u);
    const double coordinates = X_WB0.translation.norm() + X_WB1.translation.norm() +
                               X_BA0.translation.norm() + X_BA1.translation.norm() + a.extent();
    const double growth = step * step * second / 8 * (1 + 1e-12) +
                          std::max(rounding(X_WA0, X_WB0), rounding(X_WA1, X_WB1)) +
                          kTransferRounding * 2 * coordinates;
    if (!(growth < kInfinity)) return false;
    return sweptDistance(a, X_BA0, X_BA1, growth, b, sweepRequest(request), scratch, cache)
               .distance.lower > request.margin;
  }
};

/// Coordinates of the corners at t, and how far rounding may move them.
using Corners = std::array<Eigen::Vector3d, 3>;
Corners cornersAt(const MovingTriangle& m, double t) {
  Corners p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = (1 - t) * m.from[i] + t * m.to[i];
  return p;
}
double sizeOf(const MovingTriangle& m) {
  double size = 0;
  for (std::size_t i = 0; i < 3; ++i) size = std::max({size, m.from[i].norm(), m.to[i].norm()});
  return size;
}
bool finite(const MovingTriangle& m) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!m.from[i].allFinite() || !m.to[i].allFinite()) return false;
  return true;
}

/// A triangle whose corners move, against `b`: points that move or a shape that stands.
struct TrianglePair {
  const MovingTriangle& a;
  const MovingTriangle* b;    // or
  const ConvexView* b_shape;  // in its own frame, in which a is given, too
  const ContactRequest& request;
  Scratch& scratch;
  double rounding;
  PairCache cache;

  Moment look(double t, double tolerance) {
    const Corners pa = cornersAt(a, t);
    const ConvexView view_a = viewOfPoints(pa.data(), 3, 0);
    Corners pb;
    ConvexView view_b;
    if (b != nullptr) {
      pb = cornersAt(*b, t);
      view_b = viewOfPoints(pb.data(), 3, 0);
    } else {
      view_b = *b_shape;
    }
    Moment m;
    m.distance = convexDistance(view_a, Pose{}, view_b, lookRequest(request, tolerance), scratch,
                                &cache, rounding);
    const Eigen::Vector3d& n = m.distance.normal;
    // Velocities are constant, and those of the corners bound those of all points.
    double fastest = -kInfinity, slowest = b != nullptr ? kInfinity : 0;
    for (std::size_t i = 0; i < 3; ++i) {
      fastest = std::max(fastest, n.dot(a.to[i] - a.from[i]));
      if (b != nullptr) slowest = std::min(slowest, n.dot(b->to[i] - b->from[i]));
    }
    m.closing = fastest - slowest + rounding;
    m.predicted = m.closing;
    return m;
  }

  bool free(double t, double step) {
    const Corners a0 = cornersAt(a, t), a1 = cornersAt(a, t + step);
    const DistanceRequest sweep = sweepRequest(request);
    if (b == nullptr) {
      std::array<Eigen::Vector3d, 6> hull;
      for (std::size_t i = 0; i < 3; ++i) {
        hull[i] = a0[i];
        hull[3 + i] = a1[i];
      }
      const ConvexView view = viewOfPoints(hull.data(), 6, 0);
      return convexDistance(view, Pose{}, *b_shape, sweep, scratch, nullptr, rounding)
                 .distance.lower > request.margin;
    }
    // At every instant the differences of points are in the hull of the corners' differences, and
    // each of those travels on a straight line.
    const Corners b0 = cornersAt(*b, t), b1 = cornersAt(*b, t + step);
    std::array<Eigen::Vector3d, 18> differences;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        differences[6 * i + 2 * j] = a0[i] - b0[j];
        differences[6 * i + 2 * j + 1] = a1[i] - b1[j];
      }
    const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    return convexDistance(viewOfPoints(differences.data(), 18, 0), Pose{},
                          viewOfPoints(&origin, 1, 0), sweep, scratch, nullptr, rounding)
               .distance.lower > request.margin;
  }
};

}  // namespace

ContactResult timeOfContact(const Shape& a, const RigidMotion& motion_a, const Shape& b,
                            const RigidMotion& motion_b, const ContactRequest& request,
                            Scratch& scratch, PairCache* cache) {
  // What reaches infinitely far is swept against, never sweeps.
  if (a.type() == ShapeType::kHalfSpace && b.type() != ShapeType::kHalfSpace) {
    ContactResult result = timeOfContact(b, motion_b, a, motion_a, request, scratch, cache);
    std::swap(result.distance.point_a, result.distance.point_b);
    std::swap(result.distance.triangle_a, result.distance.triangle_b);
    result.distance.normal = -result.distance.normal;
    return result;
  }
  RigidPair pair{a, motion_a, b, motion_b, request, scratch, cache};
  return follow(pair, request);
}

ContactResult timeOfContact(const MovingTriangle& a, const MovingTriangle& b,
                            const ContactRequest& request, Scratch& scratch) {
  if (!finite(a) || !finite(b)) return {};
  const double rounding = kMotionRounding * (sizeOf(a) + sizeOf(b));
  TrianglePair pair{a, &b, nullptr, request, scratch, rounding, {}};
  return follow(pair, request);
}

ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const Pose& X_WB,
                            const ContactRequest& request, Scratch& scratch) {
  const RelativePose X = relativePose(Pose{}, X_WB);
  if (!finite(a) || !X.valid || !b.isConvex()) return {};
  MovingTriangle a_B = a;
  for (std::size_t i = 0; i < 3; ++i) {
    a_B.from[i] = X.X_BA * a.from[i];
    a_B.to[i] = X.X_BA * a.to[i];
  }
  const double size = sizeOf(a) + X.X_BA.translation.norm();
  const ConvexView view = viewOf(b);
  const double extent = b.extent() == kInfinity ? 0 : b.extent();
  const double rounding = kMotionRounding * (size + sizeOf(a_B)) + X.slack * (size + extent);
  TrianglePair pair{a_B, nullptr, &view, request, scratch, rounding, {}};
  ContactResult result = follow(pair, request);
  result.distance.point_a = X_WB * result.distance.point_a;
  result.distance.point_b = X_WB * result.distance.point_b;
  result.distance.normal = X_WB.rotation * result.distance.normal;
  return result;
}

ContactResult timeOfContact(const Scene& scene, std::span<const RigidMotion* const> motions,
                            const ContactRequest& request, Workspace& workspace) {
  ContactResult first;
  if (motions.size() != scene.bodies().size()) return first;
  first.status = ContactStatus::kFree;
  first.time = {kInfinity, kInfinity};
  double undecided = kInfinity;  // the earliest moment from which on something is open
  int undecided_pair = -1, queries = 0;
  for (std::size_t p = 0; p < scene.pairs().size(); ++p) {
    const ScenePair& pair = scene.pairs()[p];
    const auto body = [&](std::int32_t i) -> const Body& {
      return scene.bodies()[static_cast<std::size_t>(i)];
    };
    const Still still_a(body(pair.body_a).X_WB), still_b(body(pair.body_b).X_WB);
    const RigidMotion* told_a = motions[static_cast<std::size_t>(pair.body_a)];
    const RigidMotion* told_b = motions[static_cast<std::size_t>(pair.body_b)];
    const Geometry& a = body(pair.body_a).geometries[static_cast<std::size_t>(pair.geometry_a)];
    const Geometry& b = body(pair.body_b).geometries[static_cast<std::size_t>(pair.geometry_b)];
    const MountedMotion motion_a(told_a != nullptr ? *told_a : still_a, a.X_BG);
    const MountedMotion motion_b(told_b != nullptr ? *told_b : still_b, b.X_BG);
    ContactRequest one = request;
    one.margin += pair.margin;
    one.end = std::min(one.end, first.time.upper);
    one.query_limit = std::max(0, request.query_limit - queries);
    ContactResult result =
        timeOfContact(a.shape, motion_a, b.shape, motion_b, one, workspace.scratch(),
                      &workspace.cache(static_cast<int>(p)));
    queries += result.queries;
    result.pair = static_cast<int>(p);
    if (result.status == ContactStatus::kInvalid) {
      result.queries = queries;
      return result;
    }
    if (result.status == ContactStatus::kUndecided && result.time.lower < undecided) {
      undecided = result.time.lower;
      undecided_pair = result.pair;
    }
    if (result.status == ContactStatus::kContact) {
      // An earlier pair's contact was proven no earlier than this one's end.
      const double lower = std::min(first.time.lower, result.time.lower);
      first = result;
      first.time.lower = lower;
    }
  }
  first.queries = queries;
  if (undecided < first.time.lower) {
    if (first.status != ContactStatus::kContact) {
      first.status = ContactStatus::kUndecided;
      first.pair = undecided_pair;
    }
    first.time.lower = undecided;
  }
  return first;
}

}  // namespace leeway::collision
