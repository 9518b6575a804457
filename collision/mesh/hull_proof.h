#pragma once

#include <cstdint>
#include <vector>

#include "collision/mesh/patch_hull.h"
#include "collision/mesh/surface_patch.h"
#include "leeway/collision/query.h"

namespace leeway::collision {

/// The proof that the hull of a patch protrudes little from the solid: no triangle of the component
/// reaches deeper than some length into the hull, and a point inside the hull is inside the solid.
/// Shrinking the hull around that point by the required share gives a convex part of the solid (K
/// of ConvexPiece), at a proven distance.
class HullProof {
 public:
  /// Hulls may protrude from the solid by `largest_excess` [m]. Work is subtracted from `work_left`
  /// [units of about 0.2 us]. All arguments must outlive this object.
  HullProof(const Surface& surface, double largest_excess, double& work_left);

  /// Whether the hull of the patch is proven to protrude from the solid of its component by no more
  /// than allowed; if so, hull() returns it. For a flat patch, a point inside the solid, below the
  /// patch, is added.
  bool accept(const SurfacePatch& patch, int component);

  /// The last accepted hull.
  const PatchHull& hull() const { return hull_; }
  /// Proven limit on how far it protrudes from the solid [m].
  double excess() const { return excess_; }
  /// The depth of a triangle in it that requires the largest allowed excess [m].
  double allowedDepth() const { return hull_allowed_; }
  /// A triangle outside the patch for which the last hull failed; -1 if there was another reason.
  std::int32_t culprit() const { return culprit_; }

  /// The depth of a triangle in a hull: at most -lower, along -normal. Ends early if that is at
  /// most `allowed` [m].
  DistanceResult depthIn(std::int32_t t, const ConvexView& hull, double allowed);

 private:
  bool prove(const SurfacePatch& patch, int component, const Vector* apex);
  void collectPoints(const SurfacePatch& patch, const Vector* apex);
  double inradius(const ConvexView& view);
  bool isShallow(std::int32_t t, const ConvexView& view);
  bool depthBelowFacets(std::int32_t t, double& depth);
  double depthAlongNormal(std::int32_t t);
  bool areOthersShallow(const SurfacePatch& patch, int component, const ConvexView& view);

  const Surface& surface_;
  const double largest_excess_;
  double& work_left_;
  Scratch scratch_;
  PatchHull hull_;  // the last accepted hull
  double excess_ = 0, hull_allowed_ = 0;
  // The hull that is being tested.
  PatchHull trial_;
  std::vector<Vector> trial_points_;
  Marks in_trial_;                          // vertices of the mesh
  std::vector<std::int32_t> trial_number_;  // their numbers in trial_points_
  double allowed_ = 0, deepest_ = 0;        // of a triangle in the trial hull [m]
  std::int32_t best_facet_ = 0;             // the facet above the last triangle
  std::int32_t culprit_ = -1;
  bool thin_ = false;
};

}  // namespace leeway::collision
