#include <algorithm>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/convex/round_depth/curved_depth.h"
#include "collision/convex/round_depth/curved_planes.h"

namespace leeway::collision {

namespace {

constexpr int kNearestSteps = 32;
// Smallest stiffnesses, tried in turn [of the sizes involved]. If the bodies' distance were the
// stiffness, bodies that nearly touch would hold pieces loosely, and also far vertices of a hull
// along the direction.
constexpr double kNearestStiffnesses[] = {0, 1e-4, 1};

// The member of a choice is a point of the difference; returns its distance. A centre errs by 8
// units of roundoff of its body's extent, turning by 6, an arm by 11, and sums and the norm by 6 of
// all: less than kSupportRounding.
double offerMember(const CurvedPlanes& planes, const CurvedFace& face, const CurvedChoice& choice,
                   Progress& progress) {
  Vector point_a;
  const Vector y = planes.memberOf(face, choice, 0, point_a);
  const double apart = y.norm();
  progress.offerWitness(apart, y, point_a);
  return apart;
}

// Offers the blended member along e and, next to a cap, the farthest one.
double offerNearest(const CurvedPlanes& planes, const Vector& e, Progress& progress) {
  const CurvedFace face = planes.faces().along(e);
  CurvedChoice choice;
  planes.faces().blend(face, planes.stiffness(), 1, choice);
  const double apart = offerMember(planes, face, choice, progress);
  if (!planes.meetsCap(face, 0, 0) && !planes.meetsCap(face, 1, 0)) return apart;
  planes.faces().support(face, choice);
  return std::min(apart, offerMember(planes, face, choice, progress));
}

// Newton steps while the plane or the member comes closer: a plane known up to rounding gives its
// direction only up to the square root of that.
void stepNearer(CurvedPlanes& planes, Progress& progress) {
  Vector e = -progress.normal();
  double least = offerNearest(planes, e, progress);
  for (int i = 0; i < kNearestSteps && !progress.enough(); ++i) {
    CurvedStep step;
    if (!planes.stepFrom(e, step)) break;
    bool nearer = false;
    for (int k = 0; k < CurvedPlanes::kHalves && !nearer && !progress.enough();
         ++k, step.way *= 0.5) {
      const Vector next = planes.after(e, step);
      const double reach = planes.reach();
      planes.ask(next);
      const double apart = offerNearest(planes, next, progress);
      nearer = planes.reach() < reach || apart < least;
      least = std::min(least, apart);
      if (nearer) e = next;
    }
    if (!nearer) break;
  }
}

}  // namespace

void offerCurvedNearest(Difference<false>& difference, Progress& progress) {
  CurvedPlanes planes(difference, progress, 0);
  planes.forgetReach();
  planes.ask(-progress.normal());
  const double size = progress.query().roundoff / kUnitRoundoff;
  for (const double share : kNearestStiffnesses) {
    if (progress.enough()) break;
    planes.setStiffness(share * size);
    stepNearer(planes, progress);
  }
  progress.iterations += static_cast<int>(planes.work());
}

}  // namespace leeway::collision
