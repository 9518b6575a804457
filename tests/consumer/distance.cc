// A program that only wants distances.

#include "leeway/collision/distance.h"

#include <Eigen/Geometry>
#include <cstdio>

int main() {
  using namespace leeway::collision;
  const Shape box = Shape::box({0.5, 0.5, 0.5}), sphere = Shape::sphere(0.25);
  const Eigen::Isometry3d isometry(Eigen::Translation3d(2, 0, 0));
  const Pose X_WA, X_WB = Pose::fromIsometry(isometry);

  const DistanceResult once = distance(box, X_WA, sphere, X_WB);  // allocates

  Scratch scratch;  // reuse: queries then allocate nothing
  const DistanceResult result = distance(box, X_WA, sphere, X_WB, {}, scratch);
  std::printf("%.17g %.17g\n", result.distance.lower, result.distance.upper);
  return result.distance.lower <= 1.25 && result.distance.upper >= 1.25 &&
                 result.distance.width() < 1e-6 && once.distance.lower == result.distance.lower &&
                 X_WB.toIsometry().isApprox(isometry)
             ? 0
             : 1;
}
