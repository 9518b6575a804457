#include "collision/mesh_distance.h"

#include "leeway/collision/containment.h"

namespace leeway::collision {
namespace {

DistanceResult undecided() {
  DistanceResult result;
  result.status = DistanceStatus::kLimit;
  return result;
}

}  // namespace

DistanceResult meshDistance(const Shape&, const Pose&, const Shape&, const Pose&,
                            const DistanceRequest&, Scratch&, PairCache*) {
  return undecided();
}

DistanceResult meshSweptDistance(const Shape&, const Pose&, const Pose&, double, const Shape&,
                                 const DistanceRequest&, Scratch&, PairCache*) {
  return undecided();
}

Containment contains(const Shape&, const Pose&, const Shape&, const Pose&, Scratch&) {
  return Containment::kUndecided;
}

}  // namespace leeway::collision
