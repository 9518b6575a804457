#pragma once

#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

enum class GjkEnd : unsigned char {
  kEnough,     ///< the request is met
  kLimit,      ///< out of iterations
  kStagnated,  ///< rounding: no point of the difference is seen beyond the simplex
  kInside,     ///< the origin is in the simplex (a tetrahedron), or on it to within rounding
};

/// Distance of the origin from a difference of two cores, first along `direction` (a unit vector).
/// Fills `progress` with both ends; `simplex` is what it ended on.
///
/// Gilbert, Johnson and Keerthi (1988), with both bounds kept: the nearest point of the simplex is
/// a point of the difference, so its distance is an upper end; the supporting plane found at each
/// step is a lower one, whatever direction was asked.
GjkEnd runGjk(Difference<false>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex);
GjkEnd runGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex);

}  // namespace leeway::collision
