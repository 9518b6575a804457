#pragma once

// Members of the difference of two cores where it is farthest out along a direction, taken apart
// into what is round and what is straight: what curved_depth.cc chooses from.

#include "collision/convex/gjk/support.h"

namespace leeway::collision {

/// A box has three parameters, a cone one.
inline constexpr int kMostCurvedParameters = 4;
/// Vertices of a hull that stand for it in one direction [count].
inline constexpr int kMostMixed = 4;

/// How much of each piece stands for the cores: parameters of segments, boxes and cylinders are
/// from -1 to 1, those of cones from 0 (apex) to 1 (rim). A hull's weights are multiples of 2^-52,
/// so that their sum is 1 exactly.
struct CurvedChoice {
  double parameter[kMostCurvedParameters];
  int mixed = 0;
  int vertex[kMostMixed];
  double weight[kMostMixed];
};

/// The members of the face in a direction, and what is beside it: base + sum parameter[k] way[k],
/// and what a hull adds.
struct CurvedFace {
  Vector e;  ///< the direction, of length 1
  Vector base;
  Vector way[kMostCurvedParameters];
  Vector arm[2];              ///< of the round parts, of a share of 1
  double length[2] = {0, 0};  ///< |M e|, M the semi-axes
};

/// A straight way along an edge between two pieces: of a parameter, or between vertices of a hull.
struct CurvedEdge {
  int parameter = -1;
  int from = 0, to = 0;
};

/// The cores of a difference B - A, of which one is round, and their pieces. In B's frame.
class CurvedFaces {
 public:
  /// Where pieces are parallel the same member is made in many ways: departing from parameters that
  /// are kept, at first the middles, costs the share `evenly` of what being beside the direction
  /// does, so that directions next to each other do not choose different ones. More costs width.
  CurvedFaces(const Difference<false>& difference, double evenly);
  /// Parameters to stay near.
  void keepNear(const CurvedChoice& choice);

  CurvedFace along(const Vector& direction) const;
  /// How far the difference reaches along face.e, and the pieces that do.
  double support(const CurvedFace& face, CurvedChoice& choice) const;
  /// The member y with the largest e . y - |y - (e . y) e|^2 / (2 stiffness), all pieces together;
  /// with the round parts' bend the stiffness is that of what pieces do alone, and of both it is so
  /// many times as much. For choosing it round parts may be taken in part, which reach to all sides
  /// about the pole of a cap and would have the other pieces lean away from them; the choice has
  /// all of them, which is farther out.
  Vector blend(const CurvedFace& face, double stiffness, double times, CurvedChoice& choice) const;
  /// How much the round parts' farthest points move along v when the direction moves along w.
  double bend(const CurvedFace& face, const CurvedChoice& choice, const Vector& v,
              const Vector& w) const;
  /// Edges that the direction belongs to: what may still be moved between two pieces, two at most.
  int edges(const CurvedChoice& choice, CurvedEdge edge[2]) const;
  Vector wayOf(const CurvedFace& face, const CurvedEdge& edge) const;

  /// The centre of what is chosen of a core, in the core's frame, within 8 units of roundoff of the
  /// core's extent.
  Vector center(int part, const CurvedChoice& choice) const;
  /// How much of the core's ellipsoid or rim.
  double share(int part, const CurvedChoice& choice) const;
  const Vector& semiAxes(int part) const { return part_[part].semi_axes; }
  const ConvexView& view(int part) const { return *part_[part].view; }
  bool hasHull() const { return hull_ >= 0; }
  /// The third axis of the core's frame.
  Vector axis(int part) const { return turned(part, Vector::UnitZ()); }

 private:
  /// One core; A is turned about.
  struct Part {
    const ConvexView* view = nullptr;
    Vector semi_axes = Vector::Zero();
    int first = 0, count = 0;  // parameters
    int axis = 2;              // of a single one
  };
  double low(int k) const { return k == cone_[0] || k == cone_[1] ? 0 : -1; }
  Vector turned(int part, const Vector& v) const {
    return part == 0 ? rotated(pose_.rotation, v) : v;
  }
  Vector turnedBack(int part, const Vector& v) const {
    return part == 0 ? rotatedBack(pose_.rotation, v) : v;
  }
  /// A vertex of the hull, or a way between two of them, as the difference has it.
  Vector ofHull(const Vector& v) const { return hull_ == 0 ? Vector(-turned(0, v)) : v; }
  const Vector& vertex(int i) const { return part_[hull_].view->points[i]; }
  int farthestOfHull(const Vector& direction, int hint) const;
  double bend(const CurvedFace& face, const double (&shares)[2], const Vector& v,
              const Vector& w) const;
  void mix(const CurvedFace& face, double stiffness, double times, double (&round)[2],
           CurvedChoice& choice) const;

  const Pose& pose_;
  const double evenly_;
  Part part_[2];
  int cone_[2] = {-1, -1};  // the parameter that is a cone's
  int hull_ = -1;           // the part that is one
  int parameters_ = 0;
  double kept_[kMostCurvedParameters];
};

}  // namespace leeway::collision
