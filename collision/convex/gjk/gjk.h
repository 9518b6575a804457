#pragma once

#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

enum class GjkEnd : unsigned char {
  kEnough,     ///< the request is met
  kLimit,      ///< out of iterations
  kStagnated,  ///< rounding hides any point of the difference beyond the simplex
  kInside,     ///< the origin is in the simplex (a tetrahedron), or on it up to rounding
};

/// Finds the distance of the origin from a difference of two cores, starting along `direction` (a
/// unit vector). Offers both ends to `progress`; `simplex` is the last one.
///
/// Gilbert, Johnson and Keerthi (1988), with both bounds kept. The nearest point of the simplex
/// belongs to the difference, so its distance is an upper end. The supporting plane of each step is
/// a lower end, whatever its direction. On round cores the last steps are Newton steps
/// (newton_step.h).
GjkEnd runGjk(Difference<false>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex);
GjkEnd runGjk(Difference<true>& difference, const Vector& direction, Progress& progress,
              Simplex& simplex);

}  // namespace leeway::collision
