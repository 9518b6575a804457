#pragma once

#include <cstdint>
#include <limits>

#include "collision/base/triple.h"
#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

/// growPolytope() for cores with vertices, from four points of the difference that hold the origin:
/// facets side by side in vector lanes, in plain arithmetic. True where the request is met by what
/// was found; false where there is need of robust steps, from `start` on, or of more than a few
/// tens of vertices. No more than `progress` says is known then; its iterations are those before,
/// unless the limit was reached.
bool growVertexPolytope(Difference<false>& difference, const Simplex& start, Progress& progress);

/// What such a polytope says, of the difference without radii, excess or rounding.
struct VertexPolytopeAnswer {
  enum class End : unsigned char {
    kOpen,     ///< a plane, and a depth where there are near facets
    kDecided,  ///< a threshold or the overlap itself
    kMet,      ///< the depth, to within the tolerance
  };
  /// The facets that may be about as near to the origin as the nearest [count].
  static constexpr int kMostNear = 8;

  End end = End::kOpen;
  Triple outward = {1, 0, 0};                              ///< of a supporting plane, a unit vector
  double reach = std::numeric_limits<double>::infinity();  ///< how far out the plane is
  double depth = 0;  ///< nothing of the surface is nearer; 0 without near facets
  /// Names of the corners of facets, one of which has the nearest point.
  int near_count = 0;
  std::int32_t near_a[kMostNear][3], near_b[kMostNear][3];
};

}  // namespace leeway::collision
