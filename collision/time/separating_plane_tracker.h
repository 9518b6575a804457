#pragma once

// The first contact of convex bodies, certified by separating planes.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "collision/time/contact_sample.h"

namespace leeway::collision {

// clang-format off
/// A lower bound of
///   g(x) = (1 - x) gap0 + x gap1 - bend x (1 - x) / 2,  x in [0, 1].
/// With k = bend / 2
///   g(x) = gap0 - (k + gap0 - gap1) x + k x^2,
/// least at x = (k + gap0 - gap1) / 2k, where g = gap0 - (k + gap0 - gap1)^2 / 4k; outside of
/// [0, 1] at an end.
// clang-format on
inline double leastBetween(double gap0, double gap1, double bend) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!(bend < kInfinity)) return -kInfinity;  // an unbounded motion; NaN, too
  const double k = bend / 2 * (1 + 16 * kUnitRoundoff);
  const double slope = k + gap0 - gap1;  // -g'(0)
  if (!(k > 0) || !(slope > 0) || !(slope < 2 * k)) return std::min(gap0, gap1);
  const double sag = slope * slope / (4 * k);
  return gap0 - sag * (1 + 16 * kUnitRoundoff);
}

// clang-format off
/// Follows a motion from separating plane to separating plane. Problem has
///   ContactSample sample(t, tolerance, depth)   a distance query
///   bool hasDepth()                      such a query may request a depth
///   ContactSample startPlane()           some plane at t = 0 that costs less than a query
///   double separationAlong(n, t)         a lower bound of the separation along n
///   double accelerationAlong(n, t)       from t on no two points of the bodies accelerate faster
///                                        against each other along n
///
/// Samples are taken where Newton's method or a secant predicts the contact. Between two samples
/// with normals n0, n1, `step` apart, the motion is certified as follows. For two points of the
/// bodies let d(x) be the vector between them, x from 0 to 1, and
///   n(x) = (1 - x) n0 + x n1,   f(x) = n(x) . d(x).
/// At the ends f is at least the separation along n0, n1. In between
///   f'' = 2 n' . d' + n . d'',   |f''| <= 2 |n1 - n0| step speed + step^2 acceleration,
/// so f is at least its chord less |f''| x (1 - x) / 2 (leastBetween()). The points are at least f
/// apart, because |n(x)| <= 1. Where that fails, n0 or n1 alone is tried for the whole step, then a
/// sample in the middle is taken.
///
/// Compare E. Catto, "Continuous collision", 2013 (a root of the separation along a feature's
/// axis), and the certified steps of B. Mirtich 1996, section 2.3.2, and of X. Zhang, M. Lee,
/// Y. J. Kim, "Interactive continuous collision detection for non-convex polyhedra", 2006.
// clang-format on
template <typename Problem>
class SeparatingPlaneTracker {
 public:
  SeparatingPlaneTracker(Problem& problem, const ContactRequest& request)
      : problem_(problem), request_(request) {}

  ContactResult run() {
    if (!isInRange(request_)) return result_;
    if (request_.query_limit <= 0) return answer(ContactStatus::kUndecided, kInfinity, now_);
    if (isFreeByStartPlane()) return result_;
    now_ = sample(0, request_.tolerance);
    if (now_.distance.status == DistanceStatus::kInvalid) return result_;
    if (isInContact(now_, request_)) {
      contact_ = 0;
      touch_ = now_;
    } else if (!(gapOf(now_) > 0)) {
      proveContactAfter(0);
    }
    for (;;) {
      if (contact_ - now_.t <= request_.time_tolerance)
        return answer(ContactStatus::kContact, contact_, touch_);
      if (!(gapOf(now_) > 0) || result_.queries >= request_.query_limit) break;
      if (doubt_ - now_.t <= request_.time_tolerance / 8 && !isProvenLast()) break;
      if (now_.t >= request_.end) return answer(ContactStatus::kFree, kInfinity, now_);
      if (count_ == 0) {
        if (!sampleAhead()) break;
      } else if (isFreeBetween(now_, ahead_[count_ - 1])) {
        now_ = ahead_[--count_];
      } else if (!sampleBetween()) {
        break;
      }
    }
    return answer(ContactStatus::kUndecided, kInfinity, now_);
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr std::size_t kMostAhead = 6;

  double gapOf(const ContactSample& s) const { return s.plane - request_.margin; }

  ContactResult answer(ContactStatus status, double upper, const ContactSample& s) {
    result_.status = status;
    result_.time = {status == ContactStatus::kFree ? kInfinity : now_.t, upper};
    result_.distance = s.distance;
    settleNormal(problem_, request_, now_, result_);
    return result_;
  }

  ContactSample sample(double t, double tolerance) {
    ++result_.queries;
    return problem_.sample(t, tolerance, false);
  }

  bool isFreeByStartPlane() {
    ++result_.queries;
    const ContactSample start = problem_.startPlane();
    const Eigen::Vector3d& n = start.distance.normal;
    const double gap = gapOf(start);
    if (!(gap > 0)) return false;
    const double later = problem_.separationAlong(n, request_.end) - request_.margin;
    const double bend = problem_.accelerationAlong(n, 0) * request_.end * request_.end;
    if (!(leastBetween(gap, later, bend) > 0)) return false;
    answer(ContactStatus::kFree, kInfinity, start);
    return true;
  }

  /// Samples t > now_.t and classifies the sample: contact, apart, or in doubt. False: give up.
  bool take(double t, double tolerance) {
    ContactSample s = sample(t, tolerance);
    if (!isInContact(s, request_) && !(gapOf(s) > 0) && tolerance > request_.tolerance)
      s = sample(t, request_.tolerance);
    if (s.distance.status == DistanceStatus::kInvalid) return false;
    if (isInContact(s, request_)) {
      contact_ = t;
      touch_ = s;
      count_ = 0;
      return true;
    }
    if (gapOf(s) > 0) {
      if (count_ == kMostAhead) count_ = 0;  // drops the farthest ones; they can be sampled again
      ahead_[count_++] = s;
      return true;
    }
    doubt_ = t;
    count_ = 0;
    proveContactAfter(t);
    return true;
  }

  /// At t the bodies touch as far as the query can tell, so a contact may be provable slightly
  /// later.
  void proveContactAfter(double t) {
    proveContactAt(std::min(t + request_.time_tolerance / 2, request_.end), t);
  }

  /// Called if the motion is certified up to a time that stays in doubt: tries the last time at
  /// which a contact is close enough.
  bool isProvenLast() {
    proveContactAt(std::min(now_.t + 0.999 * request_.time_tolerance, request_.end), doubt_);
    return contact_ - now_.t <= request_.time_tolerance;
  }

  /// Tries to prove a contact at a time after t.
  void proveContactAt(double later, double t) {
    if (!(later > t) || later >= contact_) return;
    const ContactSample s = sample(later, request_.tolerance);
    if (!isInContact(s, request_)) return;
    contact_ = later;
    touch_ = s;
  }

  bool sampleAhead() {
    const double gap = gapOf(now_), small = request_.time_tolerance / 4;
    const double coming = timeToClose(gap, now_);
    // Close enough to step past the contact, which proves it; if that has failed, half as far.
    if (coming <= 2 * small) {
      const double past = std::min(now_.t + 3.999 * small, request_.end);
      const double t = past < doubt_ ? past : now_.t + (doubt_ - now_.t) / 2;
      return t > now_.t && take(t, request_.tolerance);
    }
    const double step = stepTowardsContact(gap, coming);
    const double t = now_.t + step;
    if (!(t > now_.t)) return false;
    // The predicted gap at t; an interval of a small share of it is sufficient.
    const double expected = gap * std::max(0.0, 1 - step / coming);
    const bool last = t >= request_.end;
    return take(last ? request_.end : t,
                std::max(request_.tolerance, last ? 0 : kContactDistanceShare * expected));
  }

  /// Newton's step to just before the predicted contact. If it would pass a time at which the
  /// bodies are known not to be apart, it is a secant step to that time, or half the way if the
  /// last secant step did not halve it.
  double stepTowardsContact(double gap, double coming) {
    const double small = request_.time_tolerance / 4;
    double step = std::max(coming - small, coming / 2);
    const double bad = std::min(contact_, doubt_), most = bad - now_.t;
    if (!(bad < kInfinity && now_.t + step >= bad)) return step;
    const bool slow = most > span_ / 2;
    span_ = most;
    step = most / 2;
    if (contact_ <= doubt_ && !slow) {
      const double along = problem_.separationAlong(now_.distance.normal, bad) - request_.margin;
      const double depth = std::min(request_.margin - touch_.distance.distance.lower, -along);
      if (depth >= 0)
        step = std::clamp(most * gap / (gap + depth) - small, most / 16, most - small / 2);
    }
    return step;
  }

  /// Samples where Newton's method expects the bodies to touch before the next sample, and every
  /// other time in the middle. Bodies without a volume pass through each other, and are apart on
  /// both sides; sampling only in the middle would approach the contact by halves.
  bool sampleBetween() {
    const double most = ahead_[count_ - 1].t - now_.t;
    const double coming = timeToClose(std::max(gapOf(now_), now_.plane), now_);
    halves_ = !halves_ || !(coming < most);
    const double t = now_.t + (halves_ ? most / 2 : coming);
    if (!(t > now_.t) || !(t < ahead_[count_ - 1].t)) return false;
    return take(t, std::max(request_.tolerance, kContactDistanceShare * gapOf(now_)));
  }

  bool isFreeBetween(const ContactSample& s0, const ContactSample& s1) {
    const double step = s1.t - s0.t, gap0 = gapOf(s0), gap1 = gapOf(s1);
    const Eigen::Vector3d &n0 = s0.distance.normal, &n1 = s1.distance.normal;
    const double bend0 = problem_.accelerationAlong(n0, s0.t) * step * step;
    const double bend1 = problem_.accelerationAlong(n1, s0.t) * step * step;
    const double turn = (n1 - n0).norm();
    // |n(x)| >= 1 - turn^2 / 4. Where overlap is allowed (margin < 0), f must exceed
    // margin |n(x)|, which may be above the margin by |margin| turn^2 / 4.
    const double shorter = std::max(0.0, -request_.margin) * turn * turn / 4;
    const double bend = std::max(bend0, bend1) + 2 * step * turn * s0.speed;
    if (leastBetween(gap0 - shorter, gap1 - shorter, bend) > 0) return true;
    return leastBetween(gap0, problem_.separationAlong(n0, s1.t) - request_.margin, bend0) > 0 ||
           leastBetween(problem_.separationAlong(n1, s0.t) - request_.margin, gap1, bend1) > 0;
  }

  Problem& problem_;
  const ContactRequest& request_;
  ContactResult result_;
  ContactSample now_;                            // the motion is certified up to here
  ContactSample touch_;                          // of the contact at contact_
  double contact_ = kInfinity;                   // the earliest time of a proven contact
  double doubt_ = kInfinity;                     // the earliest time that stays in doubt
  bool halves_ = true;                           // the last sampleBetween() took the middle
  double span_ = kInfinity;                      // time to min(contact_, doubt_) at the last secant
  std::array<ContactSample, kMostAhead> ahead_;  // apart, the next one last
  std::size_t count_ = 0;
};

}  // namespace leeway::collision
