#pragma once

#include <stdexcept>

namespace leeway::collision {

/// Thrown by the factories of Shape, ConvexHull and TriangleMesh, never by a query: a size is
/// negative or not finite, the largest size is below 1e-9 or above 1e9 m, or a hull or mesh has no
/// points. The message names the size, its value and the accepted values.
class InvalidShape : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace leeway::collision
