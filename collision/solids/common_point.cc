#include "collision/solids/common_point.h"

#include <algorithm>
#include <span>

#include "collision/base/numbers.h"
#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/mesh/descent/touching_triangles.h"
#include "collision/solids/point_inside.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {
namespace {

using Candidate = TouchingTriangles::Candidate;

// Fractions of a candidate's way at which points are tried; there are several because solids may be
// thin.
constexpr double kFlushShares[] = {0x1p-1, 0x1p-4, 0x1p-8, 0x1p-12};
constexpr double kEnteringShares[] = {0x1p-2, 0x1p-8};

// A point of a convex shape, inside it if it has an inside, to within `off` [m].
Vector middleOf(const Shape& convex, double& off) {
  off = 0;
  if (convex.type() != ShapeType::kConvexHull) return Vector::Zero();
  Vector sum = Vector::Zero();
  for (const Vector& v : convex.hull()->vertices()) sum += v;
  const auto count = static_cast<double>(convex.hull()->vertices().size());
  off = 4 * kUnitRoundoff * count * convex.extent();
  return sum / count;
}

class Search {
 public:
  Search(const Shape& a, const Shape& b, const RelativePose& relative, Scratch& scratch)
      : a_(a), b_(b), X_BA_(relative.X_BA), scratch_(scratch) {
    const auto finite = [](double x) { return x < kInfinity ? x : 0; };
    error_ = (relative.slack + kRelativeRounding) *
             (finite(a.extent()) + finite(b.extent()) + X_BA_.translation.norm());
  }

  CommonPoint run() {
    if (a_.isConvex()) {
      const Vector middle = middleOf(a_, off_);
      lookAt(X_BA_ * middle, 0, In::kB);
    } else if (b_.isConvex()) {
      const Vector middle = middleOf(b_, off_);
      lookAt(middle, 0, In::kA);
    } else {
      const TouchingTriangles& touching = scratch_.impl().touching;
      off_ = touching.near();
      for (const double share : kFlushShares) lookAlong(touching.flush(), share, In::kBoth);
      for (const double share : kEnteringShares) {
        lookAlong(touching.onB(), share, In::kA);
        lookAlong(touching.onA(), share, In::kB);
      }
    }
    return found_;
  }

 private:
  // The bodies that a point must be inside of; if it is one, the point is on the other body.
  enum class In : unsigned char { kA, kB, kBoth };

  void lookAlong(std::span<const Candidate> candidates, double share, In in) {
    for (const Candidate& c : candidates) {
      if (found_.depth > 0) return;
      lookAt(c.point + share * c.way, share * c.room, in);
    }
  }

  // If each of two bodies contains a ball around the same point, one must be moved by the sum of
  // the radii to separate them. For a body that has the point on its surface, the point is a ball
  // of radius 0.
  void lookAt(const Vector& point, double room, In in) {
    const double error = in == In::kBoth ? error_ : error_ + off_;
    const double wanted = std::max(0.25 * room, 4 * error);
    double radius_a = 0, radius_b = 0;
    if (in != In::kA) {
      radius_b = ballInside(b_, point, wanted, scratch_);
      if (!(radius_b > error)) return;
    }
    if (in != In::kB) {
      radius_a = ballInside(a_, X_BA_.inverse() * point, wanted, scratch_);
      if (!(radius_a > error)) return;
    }
    found_ = {(radius_a + radius_b - error) * (1 - 4 * kUnitRoundoff), point};
  }

  const Shape &a_, &b_;
  const Pose& X_BA_;
  Scratch& scratch_;
  double error_;    // of a point that is transformed to the other frame [m]
  double off_ = 0;  // upper bound on a point's distance from the body that it is on [m]
  CommonPoint found_;
};

}  // namespace

CommonPoint commonPoint(const Shape& a, const Shape& b, const RelativePose& relative,
                        Scratch& scratch) {
  return Search(a, b, relative, scratch).run();
}

void offerCommonPoint(const Shape& a, const Shape& b, const RelativePose& relative,
                      const Pose& X_WB, const DistanceRequest& request, Scratch& scratch,
                      DistanceResult& result) {
  if (result.distance.upper <= 0 || result.distance.upper <= request.threshold) return;
  const CommonPoint common = commonPoint(a, b, relative, scratch);
  if (!(common.depth > 0)) return;
  result.distance.upper = -common.depth;
  result.point_a = result.point_b = placed(X_WB, common.point);
}

}  // namespace leeway::collision
