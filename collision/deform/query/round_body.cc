#include "collision/deform/query/round_body.h"

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/deform/query/probe.h"

namespace leeway::collision {

using Eigen::Vector3d;

RoundBody roundBody(double radius, double half_length, const Pose& X_BA) {
  return {
      X_BA.translation,
      half_length > 0 ? Vector3d(X_BA.rotation.col(2) * half_length) : Vector3d(Vector3d::Zero()),
      radius};
}

bool hasNearest(bool is_segment, double half_length, const DeformableSnapshotImpl& mesh) {
  return (!is_segment || half_length > kNearestLeastHalf) && mesh.demand != Demand::kNoTree &&
         !(mesh.bounds != nullptr && mesh.bounds->hasVolumes());
}

NearestSearch nearestSearch(const RoundBody& body, const DeformableSnapshotImpl& mesh, double slack,
                            const DistanceRequest& request) {
  NearestSearch search;
  search.middle = body.middle;
  search.half = body.half;
  search.slack = slack;
  search.size = magnitude(mesh.low) + magnitude(mesh.high) + body.radius + body.middle.lpNorm<1>() +
                body.half.lpNorm<1>();
  search.enough = body.radius;
  if (request.threshold == request.threshold) {
    const double floor = std::max(request.threshold, 0.0);
    search.reach = (floor + body.radius) * (1 + kRelativeRounding);
    search.enough = floor + body.radius;
  }
  search.tolerance = 0.5 * request.tolerance;
  return search;
}

double boxLower(const RoundBody& body, const DeformableSnapshotImpl& mesh,
                const NearestSearch& search) {
  const Vector3d outside =
      ((mesh.low - body.middle).cwiseMax(body.middle - mesh.high) - body.half.cwiseAbs())
          .cwiseMax(0.0);
  return outside.norm() - body.radius - (search.slack + kRelativeRounding * search.size);
}

bool answerNearest(const RoundBody& body, const NearestFound& found, const DeformTree& tree,
                   const DistanceRequest& request, DistanceResult& result) {
  const double squared = found.way.squaredNorm();
  const Interval distance{found.own_lower - body.radius, found.upper - body.radius};
  if (!(squared > static_cast<double>(kLeastWaySquared)) || !(distance.upper > 0) ||
      !(distance.width() <= request.tolerance))
    return false;
  const Vector3d from = body.middle + found.from;
  result.distance = distance;
  result.normal = found.way / std::sqrt(squared);
  result.point_a = from + body.radius * result.normal;
  result.point_b = from + found.way;
  result.triangle_b = tree.triangleOf(found.slot);
  return true;
}

}  // namespace leeway::collision
