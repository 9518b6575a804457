#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/convex/gjk/progress.h"

namespace leeway::collision {

/// The supporting planes that a polytope's search queries, each offered to `progress`.
struct SupportPlanes {
  Difference<false>& difference;
  Progress& progress;
  /// The least -n . w of all planes: an upper bound on the depth of the origin in the difference
  /// [m].
  double reach = std::numeric_limits<double>::infinity();

  /// Finds the support point along a unit vector n. True if its plane meets the request. (The
  /// normal of a tiny facet may be 0 or NaN, which gives no plane.)
  bool ask(const Vector& n, SupportPoint& found) {
    ++progress.iterations;
    difference.support(n, found);
    clean(found.w);
    const double value = n.dot(found.w);
    if (!(n.squaredNorm() > 0.5)) return false;
    reach = std::min(reach, -value);
    progress.offerLower(value, n);
    return progress.enough();
  }

  /// Sets coordinates too small for exact arithmetic to 0: the change is far below the rounding of
  /// vertices (see kLeastSum).
  static void clean(Vector& w) {
    for (int i = 0; i < 3; ++i) {
      if (std::abs(w[i]) < kSmallestExact) w[i] = 0;
    }
  }
};

}  // namespace leeway::collision
