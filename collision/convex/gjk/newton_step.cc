#include "collision/convex/gjk/newton_step.h"

#include <cmath>
#include <utility>

#include "collision/convex/gjk/tangents.h"

namespace leeway::collision {

bool newtonScaling(const Difference<false>& difference, const Vector& n, double phi,
                   Vector rows[3]) {
  if (!(phi > 0)) return false;
  const Tangents at = tangentsAt(n);
  TangentForm form = difference.curvature(n, at, phi);
  // K + phi = L L^T (Cholesky); T = sqrt(phi) L^-1.
  const double l00 = std::sqrt(form.uu), l10 = form.uv / l00, rest = form.vv - l10 * l10;
  if (!(rest > 0)) return false;
  const double l11 = std::sqrt(rest), root = std::sqrt(phi);
  rows[0] = (root / l00) * at.u;
  rows[1] = (root / l11) * (at.v - (l10 / l00) * at.u);
  rows[2] = n;
  return true;
}

void followPieces(const Difference<false>& difference, const Vector& n, Simplex& simplex) {
  const int newest = simplex.slot[simplex.count];
  int kept = 0;
  for (int i = 0; i < simplex.count; ++i) {
    SupportPoint& s = simplex.points[simplex.slot[i]];
    const bool moved = difference.follow(n, s);
    const SupportPoint& last = simplex.points[newest];
    if (moved && s.index_a == last.index_a && s.index_b == last.index_b) continue;
    std::swap(simplex.slot[i], simplex.slot[kept]);
    ++kept;
  }
  for (int i = kept; i < 4; ++i) {
    if (simplex.slot[i] == newest) std::swap(simplex.slot[i], simplex.slot[kept]);
  }
  simplex.count = kept;
}

}  // namespace leeway::collision
