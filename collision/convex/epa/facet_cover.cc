#include "collision/convex/epa/facet_cover.h"

#include <algorithm>

#include "collision/base/tolerances.h"
#include "collision/convex/gjk/tangents.h"

namespace leeway::collision {

namespace {

// Covers are tried from this iteration on, because most polytopes have ended by then [count].
constexpr int kCoverFrom = 48;
// Depths tried for one facet, Newton steps towards each, and the longest back-off [count]. A few of
// each gain most.
constexpr int kCoverTries = 4;
constexpr int kDescentSteps = 10;
constexpr int kLongestRest = 63;

}  // namespace

FacetCover::FacetCover(SupportPlanes& planes)
    : planes_(planes),
      roundoff_(planes.progress.query().roundoff),
      curved_(planes.difference, roundoff_, planes.progress.query().request.iteration_limit) {}

// The part of the requested width that rounding leaves to the search.
double FacetCover::tolerance() const {
  const CoreQuery& query = planes_.progress.query();
  return query.request.tolerance - (query.lower_offset - query.upper_offset);
}

// Four times the rounding of a bound of CurvedFacets where the surface is nearest.
double FacetCover::rounding() const {
  return 1024 * roundoff_ * (roundoff_ / kUnitRoundoff) / planes_.reach;
}

// A tolerance below the rounding of covers is left to the polytope, except for its last iterations.
bool FacetCover::worthTrying() const {
  const int limit = planes_.progress.query().request.iteration_limit;
  return curved_.any() && planes_.progress.iterations >=
                              (0.75 * tolerance() > rounding() ? kCoverFrom : limit - limit / 8);
}

// A quarter of the width is reserved for the plane and the subtracted rounding.
double FacetCover::depth() const {
  const double reach = planes_.reach;
  return reach - std::min(std::max(0.75 * tolerance(), rounding()), 0.25 * reach);
}

bool FacetCover::covers(const PolytopeSurface& surface, const PolytopeFacet& f) {
  if (!(f.distance > 0) || f.distance >= depth()) return false;
  const SupportPoint &a = surface.vertex(f.vertex[0]), &b = surface.vertex(f.vertex[1]),
                     &c = surface.vertex(f.vertex[2]);
  for (int i = 0; i < kCoverTries; ++i) {
    if (curved_.covers(a, b, c, depth())) {
      any_ = true;
      return true;
    }
    if (rest_ > 0) {
      --rest_;
      return false;
    }
    const double reach = planes_.reach;
    descend(curved_.leastDirection());
    if (planes_.progress.decided()) return false;
    if (!(planes_.reach < reach)) {
      idle_ = std::min(2 * idle_ + 1, kLongestRest);
      rest_ = idle_;
      return false;
    }
    idle_ = 0;
  }
  return false;
}

// Newton steps on the sphere for a plane closer to the origin. The gradient of the support h is w
// minus its part along n, and its Hessian is K - h, where K is the sum of the curvatures.
void FacetCover::descend(Vector outward) {
  const Progress& progress = planes_.progress;
  outward /= outward.norm();
  double before = planes_.reach;
  for (int i = 0;
       i < kDescentSteps && progress.iterations < progress.query().request.iteration_limit; ++i) {
    SupportPoint s;
    if (planes_.ask(-outward, s) || !(planes_.reach < before)) return;
    before = planes_.reach;
    const Tangents at = tangentsAt(outward);
    const TangentForm hessian = planes_.difference.curvature(-outward, at, -before);
    if (!(hessian.uu > 0 && hessian.determinant() > 0)) return;
    outward += newtonStep(at, hessian, s.w.dot(at.u), s.w.dot(at.v));
    const double length = outward.norm();
    if (!(length > 0 && length < 4)) return;
    outward /= length;
  }
}

}  // namespace leeway::collision
