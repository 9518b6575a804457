#pragma once

// The first contact of bodies of any shape, by steps that are certified free.

#include <algorithm>
#include <limits>

#include "collision/time/contact_sample.h"
#include "leeway/collision/time_to_impact.h"

namespace leeway::collision {

/// The next step from a sample at t with this gap, certified free: by the bound on the closing
/// speed or, if that is short of the predicted contact, by a sweep. Counts sweeps in `queries`.
template <typename Problem>
double certifiedStep(Problem& problem, const ContactRequest& request, const ContactSample& now,
                     double gap, int& queries) {
  const double left = request.end - now.t, coming = timeToClose(gap, now);
  const double step = timeToImpact(gap, {now.speed, 0}) * (1 - 4 * kUnitRoundoff);
  if (!(step < kContactStepShare * std::min(coming, left))) return step;
  for (double sweep = std::min(kContactSweepShare * coming, left);
       sweep > 2 * step && queries < request.query_limit; sweep /= 2) {
    ++queries;
    if (problem.isFreeOver(now.t, sweep)) return sweep;
  }
  return step;
}

/// Conservative advancement with a bound on the closing speed (B. Mirtich 1996) and with sweeps.
/// Problem has sample() and hasDepth() as for SeparatingPlaneTracker, and isFreeOver(t, step):
/// whether [t, t + step] is certified free.
template <typename Problem>
ContactResult advanceConservatively(Problem& problem, const ContactRequest& request) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ContactResult result;
  const double end = request.end;
  if (!isInRange(request)) return result;
  double t = 0;  // certified free before t; open at t itself
  double tolerance = request.tolerance;
  ContactSample before;  // the last sample that is not in contact
  const auto answer = [&](ContactStatus status, double upper, const ContactSample& s) {
    result.status = status;
    result.time = {t, upper};
    result.distance = s.distance;
    settleNormal(problem, request, before, result);
    return result;
  };
  while (result.queries < request.query_limit) {
    const ContactSample now = problem.sample(t, tolerance, false);
    ++result.queries;
    if (now.distance.status == DistanceStatus::kInvalid) {
      result.distance = now.distance;
      return result;
    }
    if (isInContact(now, request)) return answer(ContactStatus::kContact, t, now);
    before = now;
    const double gap = now.distance.distance.lower - request.margin;
    const double coming = timeToClose(gap, now);
    if (!(coming > request.time_tolerance / 2) || !(gap > 0)) {
      // The bodies are about to touch, as far as the query can tell, so a contact may be provable
      // slightly later.
      const double later = std::min(t + request.time_tolerance, end);
      if (later > t) {
        const ContactSample then = problem.sample(later, request.tolerance, false);
        ++result.queries;
        if (isInContact(then, request)) return answer(ContactStatus::kContact, later, then);
      }
      if (!(gap > 0)) {
        if (!(tolerance > request.tolerance))
          return answer(ContactStatus::kUndecided, kInfinity, now);
        tolerance = request.tolerance;  // the last sample was a coarse one
        continue;
      }
    }
    const double step = certifiedStep(problem, request, now, gap, result.queries);
    if (step >= end - t) {
      t = kInfinity;
      return answer(ContactStatus::kFree, kInfinity, now);
    }
    const double next = t + step * (1 - 4 * kUnitRoundoff);
    if (!(next > t)) return answer(ContactStatus::kUndecided, kInfinity, now);
    t = std::min(next, end);
    // An interval of a small share of the predicted gap is sufficient.
    tolerance = std::max(request.tolerance, kContactDistanceShare * gap *
                                                std::max(0.0, 1 - step / std::max(coming, step)));
  }
  return answer(ContactStatus::kUndecided, kInfinity, before);
}

}  // namespace leeway::collision
