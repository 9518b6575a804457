#include "collision/shapes/size_limits.h"

#include <cmath>
#include <sstream>
#include <string>

#include "collision/base/tolerances.h"
#include "leeway/collision/invalid_shape.h"

namespace leeway::collision {

using Eigen::Vector3d;

void requireExtent(double largest, const char* what) {
  if (largest == 0 || (largest >= kSmallestSize && largest <= kLargestSize)) return;
  std::ostringstream message;
  message.precision(17);
  message << what << " is " << largest << "; the largest size must be 0 or from ";
  message.precision(6);
  message << kSmallestSize << " to " << kLargestSize << " [m]";
  throw InvalidShape(message.str());
}

void requireSizes(std::span<const Vector3d> points, const char* shape, const char* point) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    // A NaN fails this comparison.
    if ((points[i].array().abs() <= kLargestSize).all()) continue;
    int k = 0;
    while (std::abs(points[i][k]) <= kLargestSize) ++k;
    std::ostringstream message;
    message.precision(17);
    message << shape << ": " << point << ' ' << i << " has the coordinate " << points[i][k];
    message.precision(6);
    message << "; finite numbers up to " << kLargestSize << " are accepted [m]";
    throw InvalidShape(message.str());
  }
  if (points.empty()) return;
  Vector3d low = points[0], high = low;
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double longest = (high - low).maxCoeff();
  // The diagonal may be up to 2 kLargestSize; its ends are checked above.
  if (longest < kSmallestSize)
    requireExtent(longest, (std::string(shape) + ": the longest side of its box").c_str());
}

}  // namespace leeway::collision
