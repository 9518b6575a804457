#pragma once

#include <cstdint>
#include <limits>

#include "collision/base/triple.h"
#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

/// growPolytope() for cores with vertices, from four points of the difference that contain the
/// origin: facets are processed in vector lanes, in plain arithmetic. True if the request is met;
/// false if robust steps, from `start`, or more than a few tens of vertices are needed. In that
/// case the offered ends stay, and the iterations are not counted unless the limit was reached.
bool growVertexPolytope(Difference<false>& difference, const Simplex& start, Progress& progress);

/// The result of such a polytope, for the difference without radii, excess or rounding.
struct VertexPolytopeAnswer {
  enum class End : unsigned char {
    kOpen,     ///< there is a plane, and also a depth if there are near facets
    kDecided,  ///< the threshold, or the overlap, is decided
    kMet,      ///< the depth is known to within the tolerance
  };
  /// Limit on the reported facets that are about as close to the origin as the nearest one [count].
  static constexpr int kMostNear = 8;

  End end = End::kOpen;
  Triple outward = {1, 0, 0};                              ///< of a supporting plane, a unit vector
  double reach = std::numeric_limits<double>::infinity();  ///< how far out the plane is
  double depth = 0;  ///< no point of the surface is nearer; 0 without near facets
  /// The corners of the near facets, by their vertices; one of these facets holds the nearest
  /// point.
  int near_count = 0;
  std::int32_t near_a[kMostNear][3], near_b[kMostNear][3];
};

}  // namespace leeway::collision
