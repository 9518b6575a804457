#pragma once

#include "collision/convex/epa/polytope_surface.h"
#include "collision/convex/epa/support_planes.h"
#include "collision/convex/round_depth/curved_facet.h"

namespace leeway::collision {

/// Proves that the curved surface over a facet is farther out than its triangle (CurvedFacets), so
/// that a polytope need not approximate it. All covered facets are at least depth() out. depth()
/// only decreases, so a covered facet stays covered.
class FacetCover {
 public:
  explicit FacetCover(SupportPlanes& planes);

  /// False while the polytope is likely to end without covers.
  bool worthTrying() const;
  /// True if the curved surface over the facet is proven to be at least depth() out. Queries planes
  /// where it is not.
  bool covers(const PolytopeSurface& surface, const PolytopeFacet& f);
  /// Whether any facet has been covered.
  bool any() const { return any_; }
  /// The depth that covers prove: close enough to the nearest plane, and far enough from it for
  /// rounding.
  double depth() const;
  const CurvedFacets& facets() const { return curved_; }

 private:
  double tolerance() const;
  double rounding() const;
  void descend(Vector outward);

  SupportPlanes& planes_;
  const double roundoff_;
  CurvedFacets curved_;
  bool any_ = false;
  // Back-off: the number of successive descents that found nothing closer, and of covers left to
  // try without a descent.
  int idle_ = 0, rest_ = 0;
};

}  // namespace leeway::collision
