#include "leeway/collision/time_of_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/convex_distance.h"
#include "collision/convex/gjk/support.h"
#include "leeway/collision/time_to_impact.h"

namespace leeway::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Where nothing turns, even what reaches infinitely far does not move faster.
double times(double rate, double reach) { return rate == 0 ? 0 : rate * reach; }

/// What is known at one moment of the motion.
struct Moment {
  double t = 0;
  DistanceResult distance;  // widened by rounding
  double predicted = 0;     ///< closing speed of the witness points, for guesses only
  /// Separation along distance.normal, as Problem::along() would tell it; NaN where no plane of
  /// that direction says anything about what comes later.
  double plane = std::numeric_limits<double>::quiet_NaN();
  double speed = kInfinity;  ///< no two points of the bodies close faster from then on
};

/// Is (1 - x) gap0 + x gap1 - bend x (1 - x) / 2 positive for all x in [0, 1]? What it is at least.
double leastBetween(double gap0, double gap1, double bend) {
  if (!(bend < kInfinity)) return -kInfinity;  // a motion that promises nothing; NaN fails, too
  const double k = bend / 2 * (1 + 16 * kUnitRoundoff);
  const double twice = k + gap0 - gap1;  // 2 k times the x where it is least
  if (!(k > 0) || !(twice > 0) || !(twice < 2 * k)) return std::min(gap0, gap1);
  const double sag = twice * twice / (4 * k);
  return gap0 - sag * (1 + 16 * kUnitRoundoff);
}

bool isSensible(const ContactRequest& request) {
  return request.time_tolerance > 0 && request.tolerance > 0 && request.end >= 0 &&
         request.end <= 1 && std::isfinite(request.margin);
}

bool touches(const Moment& m, const ContactRequest& request) {
  return m.distance.distance.upper <= request.margin;
}

/// Time that a gap takes to close at present velocities, a guess.
double comingIn(double gap, const Moment& m) {
  return m.predicted > 0 ? gap / m.predicted : kInfinity;
}

/// Follows a motion of bodies that planes keep apart. Problem has: Moment look(t, tolerance);
/// Moment start(), something known at 0 that costs less than a look; along(n, t): the separation
/// along n, a lower bound; bending(n, t): no two points of the bodies accelerate faster against
/// each other along n from t on.
///
/// Looks are taken where Newton's method or a secant expects the contact, and what lies between two
/// of them is certified from their planes: for two points of the bodies that are d(x) apart, x from
/// 0 to 1 between the looks, f(x) = ((1 - x) n0 + x n1) . d(x) is at least the separations at its
/// ends, and |f''| <= step^2 bending + 2 step |n1 - n0| speed, so that f stays above its chord less
/// |f''| x (1 - x) / 2; and the points are at least f apart, because the blend is not longer than
/// 1. Where that does not suffice, one direction for both looks is tried, then a look in the middle
/// is taken. (Compare E. Catto, "Continuous collision", 2013: a root of the separation along a
/// feature's axis; and the certified steps of B. Mirtich 1996, section 2.3.2, and X. Zhang, M. Lee,
/// Y. J. Kim, "Interactive continuous collision detection for non-convex polyhedra", 2006.)
template <typename Problem>
class PlaneFollower {
 public:
  PlaneFollower(Problem& problem, const ContactRequest& request)
      : problem_(problem), request_(request) {}

  ContactResult run() {
    if (!isSensible(request_)) return result_;
    if (request_.query_limit <= 0) return answer(ContactStatus::kUndecided, kInfinity, now_);
    if (isFreeFromStart()) return result_;
    now_ = look(0, request_.tolerance);
    if (now_.distance.status == DistanceStatus::kInvalid) return result_;
    if (touches(now_, request_)) {
      contact_ = 0;
      touch_ = now_;
    } else if (!(gapOf(now_) > 0)) {
      proveLater(0);
    }
    for (;;) {
      if (contact_ - now_.t <= request_.time_tolerance)
        return answer(ContactStatus::kContact, contact_, touch_);
      if (!(gapOf(now_) > 0) || result_.queries >= request_.query_limit) break;
      if (now_.t >= request_.end) return answer(ContactStatus::kFree, kInfinity, now_);
      if (count_ == 0) {
        if (!lookAhead()) break;
      } else if (isFreeBetween(now_, ahead_[count_ - 1])) {
        now_ = ahead_[--count_];
      } else if (!lookBetween()) {
        break;
      }
    }
    return answer(ContactStatus::kUndecided, kInfinity, now_);
  }

 private:
  static constexpr std::size_t kMost = 6;

  double gapOf(const Moment& m) const { return m.plane - request_.margin; }

  ContactResult answer(ContactStatus status, double upper, const Moment& m) {
    result_.status = status;
    result_.time = {status == ContactStatus::kFree ? kInfinity : now_.t, upper};
    result_.distance = m.distance;
    return result_;
  }

  Moment look(double t, double tolerance) {
    ++result_.queries;
    return problem_.look(t, tolerance);
  }

  bool isFreeFromStart() {
    ++result_.queries;
    const Moment start = problem_.start();
    const Eigen::Vector3d& n = start.distance.normal;
    const double gap = gapOf(start);
    if (!(gap > 0)) return false;
    const double later = problem_.along(n, request_.end) - request_.margin;
    if (!(leastBetween(gap, later, problem_.bending(n, 0) * request_.end * request_.end) > 0))
      return false;
    answer(ContactStatus::kFree, kInfinity, start);
    return true;
  }

  /// Looks at t > now_.t and keeps what it is: contact, apart, or in doubt. False: give up.
  bool take(double t, double tolerance) {
    Moment m = look(t, tolerance);
    if (!touches(m, request_) && !(gapOf(m) > 0) && tolerance > request_.tolerance)
      m = look(t, request_.tolerance);
    if (m.distance.status == DistanceStatus::kInvalid) return false;
    if (touches(m, request_)) {
      contact_ = t;
      touch_ = m;
      count_ = 0;
      return true;
    }
    if (gapOf(m) > 0) {
      if (count_ == kMost) count_ = 0;  // what is far ahead can be looked at again
      ahead_[count_++] = m;
      return true;
    }
    doubt_ = t;
    count_ = 0;
    proveLater(t);
    return t - now_.t > request_.time_tolerance / 8 || contact_ - now_.t <= request_.time_tolerance;
  }

  /// About to touch at t, as far as can be seen: is it proven a little later?
  void proveLater(double t) {
    const double later = std::min(t + request_.time_tolerance / 2, request_.end);
    if (!(later > t) || later >= contact_) return;
    const Moment m = look(later, request_.tolerance);
    if (!touches(m, request_)) return;
    contact_ = later;
    touch_ = m;
  }

  bool lookAhead() {
    const double gap = gapOf(now_), small = request_.time_tolerance / 4;
    const double coming = comingIn(gap, now_);
    // Near enough: behind the contact, so that this proves it.
    if (coming <= 2 * small)
      return take(std::min(now_.t + 3.999 * small, request_.end), request_.tolerance);
    double step = std::max(coming - small, coming / 2);
    const double bad = std::min(contact_, doubt_), most = bad - now_.t;
    if (bad < kInfinity && now_.t + step >= bad) {
      // Newton's step leads where it is known not to be: a secant, or half the way where the last
      // one left more than that.
      const bool slow = most > span_ / 2;
      span_ = most;
      step = most / 2;
      if (contact_ <= doubt_ && !slow) {
        const double depth =
            std::min(request_.margin - touch_.distance.distance.lower,
                     -(problem_.along(now_.distance.normal, bad) - request_.margin));
        if (depth >= 0)
          step = std::clamp(most * gap / (gap + depth) - small, most / 16, most - small / 2);
      }
    }
    const double t = now_.t + step;
    if (!(t > now_.t)) return false;
    // Apart by this, if the guess is right; rounding the distance to a share of it costs nothing.
    const double expected = gap * std::max(0.0, 1 - step / coming);
    const bool last = t >= request_.end;
    return take(last ? request_.end : t,
                std::max(request_.tolerance, last ? 0 : kContactDistanceShare * expected));
  }

  bool lookBetween() {
    const double t = now_.t + (ahead_[count_ - 1].t - now_.t) / 2;
    if (!(t > now_.t) || !(t < ahead_[count_ - 1].t)) return false;
    return take(t, std::max(request_.tolerance, kContactDistanceShare * gapOf(now_)));
  }

  bool isFreeBetween(const Moment& m0, const Moment& m1) {
    const double step = m1.t - m0.t, gap0 = gapOf(m0), gap1 = gapOf(m1);
    const Eigen::Vector3d &n0 = m0.distance.normal, &n1 = m1.distance.normal;
    const double bend0 = problem_.bending(n0, m0.t) * step * step;
    const double bend1 = problem_.bending(n1, m0.t) * step * step;
    const double turn = (n1 - n0).norm();
    // A blend is shorter than 1: what may overlap by a margin may then by less.
    const double shorter = std::max(0.0, -request_.margin) * turn * turn / 4;
    const double bend = std::max(bend0, bend1) + 2 * step * turn * m0.speed;
    if (leastBetween(gap0 - shorter, gap1 - shorter, bend) > 0) return true;
    return leastBetween(gap0, problem_.along(n0, m1.t) - request_.margin, bend0) > 0 ||
           leastBetween(problem_.along(n1, m0.t) - request_.margin, gap1, bend1) > 0;
  }

  Problem& problem_;
  const ContactRequest& request_;
  ContactResult result_;
  Moment now_, touch_;  // certified until now_; in contact
  double contact_ = kInfinity,
         doubt_ = kInfinity;         // earliest moments of proven contact, of neither
  double span_ = kInfinity;          // what the last secant had before it
  std::array<Moment, kMost> ahead_;  // apart, the next one last
  std::size_t count_ = 0;
};

/// Follows a motion by conservative advancement with a bound on closing (B. Mirtich 1996) and by
/// sweeps. Problem has look() and free(t, step): is it certified over [t, t + step].
template <typename Problem>
ContactResult advance(Problem& problem, const ContactRequest& request) {
  ContactResult result;
  const double end = request.end;
  if (!isSensible(request)) return result;
  double t = 0, tolerance = request.tolerance;
  // Open: everything before t is certified. At t itself nothing is known yet.
  const auto answer = [&](ContactStatus status, double upper, const Moment& m) {
    result.status = status;
    result.time = {t, upper};
    result.distance = m.distance;
    return result;
  };
  while (result.queries < request.query_limit) {
    const Moment now = problem.look(t, tolerance);
    ++result.queries;
    if (now.distance.status == DistanceStatus::kInvalid) {
      result.distance = now.distance;
      return result;
    }
    if (touches(now, request)) return answer(ContactStatus::kContact, t, now);
    const double gap = now.distance.distance.lower - request.margin;
    const double coming = comingIn(gap, now);
    if (!(coming > request.time_tolerance / 2) || !(gap > 0)) {
      // About to touch, as far as can be seen: is it proven a little later?
      const double later = std::min(t + request.time_tolerance, end);
      if (later > t) {
        const Moment then = problem.look(later, request.tolerance);
        ++result.queries;
        if (touches(then, request)) return answer(ContactStatus::kContact, later, then);
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
    const double left = end - t;
    double step = timeToImpact(gap, {now.speed, 0}) * (1 - 4 * kUnitRoundoff);
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
    if (step >= left) {
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
  r.tolerance = kDefaultTolerance;
  r.threshold = request.margin;
  r.depth = false;
  return r;
}

void widen(DistanceResult& result, double slack) {
  result.distance.lower -= slack;
  result.distance.upper += slack;
}

/// Acceleration of points of a body along n: of its origin, and of turning about it.
double bendingOf(const Shape& shape, const RigidMotion& motion, const Eigen::Vector3d& n, double t,
                 double end) {
  const FrameMotionBound m = motion.bound(t, end);
  double turning = m.angular_acceleration + m.angular_speed * m.angular_speed;
  // About an axis that stays, only the part of n across it counts.
  if (m.angular_acceleration == 0 && m.angular_speed > 0)
    turning = std::min(
        turning, (n.cross(motion.velocity(t).angular).norm() + kMotionRounding * m.angular_speed) *
                     m.angular_speed);
  return m.acceleration + times(turning, shape.extent());
}

/// Acceleration of a point seen from the frame of a body B that moves within `m`: p_B = R^T u with
/// u = p - o_B, so that |p_B''| <= |u''| + 2 w |u'| + (alpha + w^2) |u|.
double acceleratingSeen(double acceleration, double speed, double reach,
                        const FrameMotionBound& m) {
  return acceleration + times(2 * m.angular_speed, speed) +
         times(m.angular_acceleration + m.angular_speed * m.angular_speed, reach);
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
  ConvexView view_a, view_b;
  bool planes;  ///< planes of one direction bound what comes: convex, and no half-space turns
  bool flat;    ///< b is a half-space
  Pose X_WA_start, X_WB_start;  ///< at 0
  bool valid;                   ///< they are
  double departure;             ///< of the rotations from orthogonality, as RelativePose::slack
  int hint_a = 0, hint_b = 0;

  RigidPair(const Shape& a_, const RigidMotion& motion_a_, const Shape& b_,
            const RigidMotion& motion_b_, const ContactRequest& request_, Scratch& scratch_,
            PairCache* cache_)
      : a(a_),
        motion_a(motion_a_),
        b(b_),
        motion_b(motion_b_),
        request(request_),
        scratch(scratch_),
        cache(cache_),
        flat(b_.type() == ShapeType::kHalfSpace) {
    planes = a.isConvex() && b.isConvex() && a.type() != ShapeType::kHalfSpace &&
             !(flat && motion_b.bound(0, request.end).angular_speed > 0);
    if (a.isConvex()) view_a = viewOf(a);
    if (b.isConvex()) view_b = viewOf(b);
    X_WA_start = motion_a.pose(0);
    X_WB_start = motion_b.pose(0);
    const RelativePose X = relativePose(X_WA_start, X_WB_start);
    valid = X.valid;
    departure = X.slack;
  }

  /// Of both poses, where the bodies are near each other; of a half-space only what A can meet.
  double rounding(const Pose& X_WA, const Pose& X_WB) const {
    const double between = (X_WA.translation - X_WB.translation).norm() + a.extent();
    return motion_a.rounding(a.extent()) + motion_b.rounding(std::min(b.extent(), between));
  }

  /// Acceleration of any point of a body, in the world.
  static double acceleration(const Shape& shape, const FrameMotionBound& m) {
    return m.acceleration +
           times(m.angular_acceleration + m.angular_speed * m.angular_speed, shape.extent());
  }
  static double speed(const Shape& shape, const FrameMotionBound& m) {
    return m.speed + times(m.angular_speed, shape.extent());
  }

  double bending(const Eigen::Vector3d& n, double t) const {
    return (bendingOf(a, motion_a, n, t, request.end) + bendingOf(b, motion_b, n, t, request.end)) *
           (1 + 16 * kUnitRoundoff);
  }

  /// What along() and the plane of a look may be off by; rotations are as orthogonal as at first.
  double planeRounding(const Pose& X_WA, const Pose& X_WB) const {
    const double between = (X_WB.translation - X_WA.translation).norm();
    const double size = a.extent() + (flat ? 0 : b.extent()) + between;
    return kSupportRounding * kUnitRoundoff * (size + view_a.radius + view_b.radius) +
           departure * size + rounding(X_WA, X_WB);
  }

  double along(const Eigen::Vector3d& n, double t) {
    return along(n, motion_a.pose(t), motion_b.pose(t));
  }
  double along(const Eigen::Vector3d& n, const Pose& X_WA, const Pose& X_WB) {
    const Eigen::Vector3d m = flat ? Eigen::Vector3d(-X_WB.rotation.col(2)) : n;
    const Eigen::Vector3d down_a = rotatedBack(X_WA.rotation, m);
    double apart =
        m.dot(X_WB.translation - X_WA.translation) - down_a.dot(farthest(view_a, down_a, hint_a));
    if (!flat) {
      const Eigen::Vector3d up_b = -rotatedBack(X_WB.rotation, m);
      apart -= up_b.dot(farthest(view_b, up_b, hint_b));
    }
    return apart - view_a.radius - view_b.radius - view_a.excess - view_b.excess -
           planeRounding(X_WA, X_WB);
  }

  Moment look(double t, double tolerance) {
    const Pose X_WA = motion_a.pose(t), X_WB = motion_b.pose(t);
    Moment m;
    m.t = t;
    m.distance = distance(a, X_WA, b, X_WB, lookRequest(request, tolerance), scratch, cache);
    widen(m.distance, rounding(X_WA, X_WB));
    const Eigen::Vector3d& n = m.distance.normal;
    const FrameVelocity va = motion_a.velocity(t), vb = motion_b.velocity(t);
    const auto at = [](const FrameVelocity& v, const Pose& X, const Eigen::Vector3d& p) {
      return Eigen::Vector3d(v.linear + v.angular.cross(p - X.translation));
    };
    m.predicted = n.dot(at(va, X_WA, m.distance.point_a) - at(vb, X_WB, m.distance.point_b));
    m.speed = speed(a, motion_a.bound(t, request.end)) + speed(b, motion_b.bound(t, request.end));
    m.plane = m.distance.distance.lower - planeRounding(X_WA, X_WB);
    return m;
  }

  /// Along the way between the middles of the bounding spheres, where those are apart.
  Moment start() {
    Moment m;
    if (!valid) return m;
    const Eigen::Vector3d from = X_WA_start * a.boundingCenter(),
                          to = X_WB_start * b.boundingCenter();
    const double apart = (to - from).norm();
    if (!(apart - a.boundingRadius() - b.boundingRadius() > request.margin) || !(apart < kInfinity))
      return m;
    m.distance.normal = (to - from) / apart;
    m.distance.point_a = from;
    m.distance.point_b = to;
    m.plane = along(m.distance.normal, X_WA_start, X_WB_start);
    m.distance.distance = {m.plane, kInfinity};
    m.distance.status = DistanceStatus::kAboveThreshold;
    return m;
  }

  bool free(double t, double step) {
    const Pose X_WB0 = motion_b.pose(t), X_WB1 = motion_b.pose(t + step);
    const Pose X_WA0 = motion_a.pose(t), X_WA1 = motion_a.pose(t + step);
    const Pose X_BA0 = X_WB0.inverse() * X_WA0, X_BA1 = X_WB1.inverse() * X_WA1;
    const FrameMotionBound ma = motion_a.bound(t, t + step), mb = motion_b.bound(t, t + step);
    const double u_speed = speed(a, ma) + mb.speed;
    const double u = X_BA0.translation.norm() + times(1, a.extent()) + step * u_speed;
    const double second = acceleratingSeen(acceleration(a, ma) + mb.acceleration, u_speed, u, mb);
    const double coordinates = X_WB0.translation.norm() + X_WB1.translation.norm() +
                               X_BA0.translation.norm() + X_BA1.translation.norm() + a.extent();
    const double growth = step * step * second / 8 * kGrowthOutwards +
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
/// No corner is faster.
double speedOf(const MovingTriangle& m) {
  double most = 0;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, (m.to[i] - m.from[i]).norm());
  return most * (1 + 16 * kUnitRoundoff);
}
/// Speed of the corner that is fastest along n.
double fastest(const MovingTriangle& m, const Eigen::Vector3d& n) {
  double most = -kInfinity;
  for (std::size_t i = 0; i < 3; ++i) most = std::max(most, n.dot(m.to[i] - m.from[i]));
  return most;
}
/// How far the triangle reaches along n at t.
double farthestCorner(const MovingTriangle& m, const Eigen::Vector3d& n, double t) {
  double most = -kInfinity;
  for (const Eigen::Vector3d& p : cornersAt(m, t)) most = std::max(most, n.dot(p));
  return most;
}
bool finite(const MovingTriangle& m) {
  for (std::size_t i = 0; i < 3; ++i)
    if (!m.from[i].allFinite() || !m.to[i].allFinite()) return false;
  return true;
}

/// Two triangles whose corners move.
struct TrianglePair {
  const MovingTriangle& a;
  const MovingTriangle& b;
  const ContactRequest& request;
  Scratch& scratch;
  double rounding;
  double speed;  ///< of any point against any other
  PairCache cache;

  Moment look(double t, double tolerance) {
    const Corners pa = cornersAt(a, t), pb = cornersAt(b, t);
    Moment m;
    m.t = t;
    m.distance =
        convexDistance(viewOfPoints(pa.data(), 3, 0), Pose{}, viewOfPoints(pb.data(), 3, 0),
                       lookRequest(request, tolerance), scratch, &cache, rounding);
    const Eigen::Vector3d& n = m.distance.normal;
    // Velocities are constant, and those of the corners bound those of all points.
    m.predicted = fastest(a, n) + fastest(b, -n);
    m.speed = speed;
    m.plane = m.distance.distance.lower - rounding;
    return m;
  }

  /// Nothing that costs less than a look.
  static Moment start() { return {}; }

  double along(const Eigen::Vector3d& n, double t) const {
    return -farthestCorner(a, n, t) - farthestCorner(b, -n, t) - rounding;
  }

  /// Nothing accelerates.
  static double bending(const Eigen::Vector3d&, double) { return 0; }
};

/// A triangle whose corners move, and a convex body.
struct TriangleBody {
  const MovingTriangle& a;
  const Shape& b;
  const RigidMotion& motion;
  const ContactRequest& request;
  Scratch& scratch;
  ConvexView view;
  bool flat;    ///< b is a half-space
  bool planes;  ///< that does not turn, or none
  double size;  ///< of the triangle's coordinates
  double departure = 0;
  PairCache cache;
  int hint = 0;

  TriangleBody(const MovingTriangle& a_, const Shape& b_, const RigidMotion& motion_,
               const ContactRequest& request_, Scratch& scratch_)
      : a(a_),
        b(b_),
        motion(motion_),
        request(request_),
        scratch(scratch_),
        view(viewOf(b_)),
        flat(b_.type() == ShapeType::kHalfSpace),
        planes(!flat || !(motion_.bound(0, request_.end).angular_speed > 0)),
        size(sizeOf(a_)),
        departure(relativePose(Pose{}, motion_.pose(0)).slack) {}

  /// Of the corners and of the pose, of a half-space where the triangle can meet it.
  double rounding(const Pose& X_WB) const {
    const double between = X_WB.translation.norm() + size;
    const double reach = std::min(b.extent(), between);
    return kMotionRounding * size + motion.rounding(reach) +
           kSupportRounding * kUnitRoundoff * (between + reach + view.radius) +
           departure * (between + reach);
  }

  Moment look(double t, double tolerance) {
    const Pose X_WB = motion.pose(t);
    const RelativePose X = relativePose(Pose{}, X_WB);
    const Corners pa = cornersAt(a, t);
    const double slack = rounding(X_WB);
    Moment m;
    m.t = t;
    if (!X.valid) return m;
    m.distance = convexDistance(viewOfPoints(pa.data(), 3, 0), X.X_BA, view,
                                lookRequest(request, tolerance), scratch, &cache, slack);
    m.distance.point_a = X_WB * m.distance.point_a;
    m.distance.point_b = X_WB * m.distance.point_b;
    m.distance.normal = X_WB.rotation * m.distance.normal;
    const Eigen::Vector3d& n = m.distance.normal;
    const FrameVelocity v = motion.velocity(t);
    const Eigen::Vector3d arm = m.distance.point_b - X_WB.translation;
    m.predicted = fastest(a, n) - n.dot(v.linear + v.angular.cross(arm));
    m.plane = m.distance.distance.lower - slack;
    const FrameMotionBound bound = motion.bound(t, request.end);
    m.speed = bound.speed + times(bound.angular_speed, b.extent()) + speedOf(a);
    return m;
  }

  /// Nothing that costs less than a look.
  static Moment start() { return {}; }

  double along(const Eigen::Vector3d& n, double t) {
    const Pose X_WB = motion.pose(t);
    const Eigen::Vector3d m = flat ? Eigen::Vector3d(-X_WB.rotation.col(2)) : n;
    double lowest = m.dot(X_WB.translation);
    if (!flat) {
      const Eigen::Vector3d up = -rotatedBack(X_WB.rotation, m);
      lowest -= up.dot(farthest(view, up, hint));
    }
    return lowest - view.radius - view.excess - farthestCorner(a, m, t) - rounding(X_WB);
  }

  double bending(const Eigen::Vector3d& n, double t) const {
    return bendingOf(b, motion, n, t, request.end) * (1 + 16 * kUnitRoundoff);
  }

  /// In B's frame, from which a half-space that turns is seen to stand still.
  bool free(double t, double step) {
    const Pose X_WB0 = motion.pose(t), X_WB1 = motion.pose(t + step);
    const Corners a0 = cornersAt(a, t), a1 = cornersAt(a, t + step);
    const FrameMotionBound m = motion.bound(t, t + step);
    std::array<Eigen::Vector3d, 6> hull;
    const double speed = speedOf(a) + m.speed;
    double reach = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      hull[i] = rotatedBack(X_WB0.rotation, a0[i] - X_WB0.translation);
      hull[3 + i] = rotatedBack(X_WB1.rotation, a1[i] - X_WB1.translation);
      reach = std::max(reach, hull[i].norm());
    }
    const double bent =
        acceleratingSeen(m.acceleration, speed, reach + step * speed, m) * step * step / 8;
    const double slack =
        bent * kGrowthOutwards + std::max(rounding(X_WB0), rounding(X_WB1)) +
        kTransferRounding * (size + X_WB0.translation.norm() + X_WB1.translation.norm());
    if (!(slack < kInfinity)) return false;
    return convexDistance(viewOfPoints(hull.data(), 6, 0), Pose{}, view, sweepRequest(request),
                          scratch, nullptr, slack)
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
  PairCache own;
  RigidPair pair(a, motion_a, b, motion_b, request, scratch, cache != nullptr ? cache : &own);
  return pair.planes ? PlaneFollower(pair, request).run() : advance(pair, request);
}

ContactResult timeOfContact(const MovingTriangle& a, const MovingTriangle& b,
                            const ContactRequest& request, Scratch& scratch) {
  if (!finite(a) || !finite(b)) return {};
  const double rounding = kMotionRounding * (sizeOf(a) + sizeOf(b));
  TrianglePair pair{a, b, request, scratch, rounding, speedOf(a) + speedOf(b), {}};
  return PlaneFollower(pair, request).run();
}

ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const RigidMotion& motion_b,
                            const ContactRequest& request, Scratch& scratch) {
  if (!finite(a) || !b.isConvex()) return {};
  TriangleBody pair(a, b, motion_b, request, scratch);
  return pair.planes ? PlaneFollower(pair, request).run() : advance(pair, request);
}

ContactResult timeOfContact(const MovingTriangle& a, const Shape& b, const Pose& X_WB,
                            const ContactRequest& request, Scratch& scratch) {
  return timeOfContact(a, b, Still(X_WB), request, scratch);
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
