// A program that only wants distances.

#include "leeway/collision/distance.h"

#include <cmath>
#include <cstdio>

int main() {
  using namespace leeway::collision;
  Scratch scratch;
  const Pose X_WA;
  const Pose X_WB{Eigen::Matrix3d::Identity(), Eigen::Vector3d(2, 0, 0)};
  const DistanceResult result =
      distance(Shape::box({0.5, 0.5, 0.5}), X_WA, Shape::sphere(0.25), X_WB, {}, scratch);
  std::printf("%.17g %.17g\n", result.distance.lower, result.distance.upper);
  return result.distance.lower <= 1.25 && result.distance.upper >= 1.25 &&
                 result.distance.width() < 1e-6
             ? 0
             : 1;
}
