#pragma once

// The members of a difference of two cores that are farthest out along a direction, split into
// round and straight parts, and blends of them.

#include "collision/convex/gjk/support.h"

namespace leeway::collision {

/// Three of a box and one of a cone.
inline constexpr int kMostCurvedParameters = 4;
/// Limit on the vertices of a hull that are blended in one direction [count].
inline constexpr int kMostBlendedVertices = 4;

/// The weight of each piece of the cores. Parameters of segments, boxes and cylinders are from -1
/// to 1, those of cones from 0 (apex) to 1 (rim). A hull's weights are multiples of 2^-52, so that
/// their sum is exactly 1.
struct CurvedChoice {
  double parameter[kMostCurvedParameters];
  int vertices = 0;  // of the hull, blended [count]
  int vertex[kMostBlendedVertices];
  double weight[kMostBlendedVertices];
};

/// The pieces next to the face in a direction. Their members are base + sum parameter[k] way[k],
/// plus a point of the hull.
struct CurvedFace {
  Vector e;  ///< the direction, of length 1
  Vector base;
  Vector way[kMostCurvedParameters];
  Vector arm[2];              ///< of the round parts, for a share of 1
  double length[2] = {0, 0};  ///< |M e|, M the semi-axes
};

/// A straight edge of the difference between two pieces, either of a parameter or between two
/// vertices of a hull.
struct CurvedEdge {
  int parameter = -1;
  int from = 0, to = 0;
};

/// The pieces of the cores of a difference B - A, one of which is round, in B's frame.
class CurvedFaces {
 public:
  /// Parallel pieces give a member in many ways. So that neighbouring directions choose alike,
  /// departing from the kept parameters (at first the middles) is penalised: by the share `evenly`
  /// of the penalty for the distance from the direction. A larger share costs width.
  CurvedFaces(const Difference<false>& difference, double evenly);
  /// Sets the parameters to stay close to.
  void keepNear(const CurvedChoice& choice);

  CurvedFace along(const Vector& direction) const;
  /// The reach of the difference along face.e, and the pieces that attain it.
  double support(const CurvedFace& face, CurvedChoice& choice) const;
  /// The member y, over all pieces, with the largest e . y - |y - (e . y) e|^2 / (2 s). Across the
  /// direction, s includes the bend of the round parts in addition to `stiffness`, with the sum
  /// multiplied by `scale`. While choosing, round parts may count in part: around the pole of a cap
  /// their arms reach to all sides, and other pieces would be chosen to balance them. The final
  /// choice has all of them, which is farther out.
  Vector blend(const CurvedFace& face, double stiffness, double scale, CurvedChoice& choice) const;
  /// How far the farthest points of the round parts move along v when the direction moves along w.
  double bend(const CurvedFace& face, const CurvedChoice& choice, const Vector& v,
              const Vector& w) const;
  /// The edges that a choice lies on, at most two: pieces between which weight can be moved.
  int edges(const CurvedChoice& choice, CurvedEdge edge[2]) const;
  Vector wayOf(const CurvedFace& face, const CurvedEdge& edge) const;

  /// The centre of a core's choice, in the core's frame, within 8 units of roundoff of its extent.
  Vector center(int part, const CurvedChoice& choice) const;
  /// The share of the core's ellipsoid or rim.
  double share(int part, const CurvedChoice& choice) const;
  const Vector& semiAxes(int part) const { return part_[part].semi_axes; }
  const ConvexView& view(int part) const { return *part_[part].view; }
  bool hasHull() const { return hull_ >= 0; }
  /// The third axis of the core's frame.
  Vector axis(int part) const { return turned(part, Vector::UnitZ()); }

 private:
  /// One core; A is mirrored.
  struct Part {
    const ConvexView* view = nullptr;
    Vector semi_axes = Vector::Zero();
    int first = 0, count = 0;  // parameters
    int axis = 2;              // of a single parameter
  };
  double low(int k) const { return k == cone_[0] || k == cone_[1] ? 0 : -1; }
  Vector turned(int part, const Vector& v) const {
    return part == 0 ? rotated(pose_.rotation, v) : v;
  }
  Vector turnedBack(int part, const Vector& v) const {
    return part == 0 ? rotatedBack(pose_.rotation, v) : v;
  }
  /// A vertex of the hull, or a vector between two, as it appears in the difference.
  Vector ofHull(const Vector& v) const { return hull_ == 0 ? Vector(-turned(0, v)) : v; }
  const Vector& vertex(int i) const { return part_[hull_].view->points[i]; }
  int farthestOfHull(const Vector& direction, int hint) const;
  double bend(const CurvedFace& face, const double (&shares)[2], const Vector& v,
              const Vector& w) const;
  class Blend;  // curved_blend.cc

  const Pose& pose_;
  const double evenly_;
  Part part_[2];
  int cone_[2] = {-1, -1};  // the parameter that belongs to a cone
  int hull_ = -1;           // the part that is a hull
  int parameters_ = 0;
  double kept_[kMostCurvedParameters];
};

}  // namespace leeway::collision
