#pragma once

// Support mappings: the point of a convex core, or of the difference of two placed cores, that lies
// farthest along a direction. All are inline, with one switch for each call and no dynamic
// dispatch. The switches have no default, so that the compiler lists the cases that a new core must
// add.

#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/base/vector.h"
#include "collision/convex/gjk/convex_view.h"
#include "collision/convex/gjk/tangents.h"
#include "collision/shapes/hull_climb.h"
#include "collision/shapes/hull_scan.h"
#include "collision/shapes/hull_support.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

/// farthest() of a cylinder, cone or ellipsoid; `piece` becomes the smooth piece of the surface
/// that holds the point: the rim below (0) or above (1), the apex (1), the ellipsoid (0).
Vector farthestOfRound(const ConvexView& view, const Vector& direction, int& piece);

/// The point of a given piece that is farthest along `direction`: the result of farthestOfRound()
/// where that piece is farthest, or the vertex for cores with vertices. False if there is no such
/// point.
bool farthestOfPiece(const ConvexView& view, const Vector& direction, int piece, Vector& p);

/// The motion of farthest() of a round core when its unit direction turns:
///   dp = sum over i of strength[i] axis[i] (axis[i] . d direction).
/// Zero for cores and places without curvature.
struct Curvature {
  Vector axis[2] = {Vector::Zero(), Vector::Zero()};
  double strength[2] = {0, 0};
};
Curvature curvatureAt(const ConvexView& view, const Vector& direction);

/// True for cores with finitely many extreme points, which vertex() enumerates.
inline bool hasVertices(Core core) {
  switch (core) {
    case Core::kPoint:
    case Core::kSegment:
    case Core::kPoints:
    case Core::kBox:
      return true;
    case Core::kCylinder:
    case Core::kCone:
    case Core::kEllipsoid:
    case Core::kHalfSpace:
      break;
  }
  return false;
}

inline bool isRound(Core core) { return !hasVertices(core) && core != Core::kHalfSpace; }

inline bool climbs(const ConvexView& view) {
  return view.core == Core::kPoints && view.hull != nullptr && view.count >= kClimbFrom &&
         view.hull->hasNeighbours();
}

/// True if both are hulls that look up their farthest vertices in a table of directions.
inline bool haveTables(const ConvexView& a, const ConvexView& b) {
  return a.support != nullptr && b.support != nullptr && a.support->sides() > 0 &&
         b.support->sides() > 0;
}

/// Index of the farthest point of a kPoints core along a direction of about unit length.
inline int farthestPoint(const ConvexView& view, const Vector& direction, int hint) {
  if (view.support != nullptr) {
    const int found = scanFarthest(*view.support, direction, hint);
    if (found >= 0) return found;
  }
  return climbs(view) ? climbFarthest(*view.hull, view.points, view.count, direction, hint,
                                      8 * kUnitRoundoff * view.extent)
                      : scanFarthest(view.points, view.count, direction);
}

/// The farthest point of the core along `direction` (a unit vector, or nearly one), in the core's
/// frame. `hint` is the vertex to start from and becomes the vertex found.
///
/// Rounding, in units of roundoff times extent: the point's value along `direction` is within 6 of
/// the maximum, and the point lies in the core grown by 3. Points, segment and box give exact
/// members, whose dot products err by 3. A rim point r (x, y)/rho has a relative error of 2.5; its
/// value errs by no more, because the error of its direction only has a second-order effect.
inline Vector farthest(const ConvexView& view, const Vector& direction, int& hint) {
  switch (view.core) {
    case Core::kPoint:
      return Vector::Zero();
    case Core::kSegment:
      hint = direction.z() >= 0 ? 1 : 0;
      return {0, 0, hint != 0 ? view.size.z() : -view.size.z()};
    case Core::kPoints:
      hint = farthestPoint(view, direction, hint);
      return view.points[hint];
    case Core::kBox:
      hint = (std::signbit(direction.x()) ? 0 : 1) | (std::signbit(direction.y()) ? 0 : 2) |
             (std::signbit(direction.z()) ? 0 : 4);
      return {std::copysign(view.size.x(), direction.x()),
              std::copysign(view.size.y(), direction.y()),
              std::copysign(view.size.z(), direction.z())};
    case Core::kCylinder:
    case Core::kCone:
    case Core::kEllipsoid:
    case Core::kHalfSpace:  // has none: queries handle it separately
      break;
  }
  return farthestOfRound(view, direction, hint);
}

/// A point of the difference {b - a} of two placed cores, and the two points that form it.
struct SupportPoint {
  Vector w;                      ///< b - a, in B
  Vector a;                      ///< the point of A, in B
  int index_a = 0, index_b = 0;  ///< their vertices, or pieces of round cores
  int placement = 0;             ///< of a sweep: 0 at its start, 1 at its end
};

/// The number of a core's vertices; 0 if hasVertices() is false.
inline int vertexCount(const ConvexView& view) {
  switch (view.core) {
    case Core::kPoint:
      return 1;
    case Core::kSegment:
      return 2;
    case Core::kPoints:
      return view.count;
    case Core::kBox:
      return 8;
    case Core::kCylinder:
    case Core::kCone:
    case Core::kEllipsoid:
    case Core::kHalfSpace:
      break;
  }
  return 0;
}

/// The vertex for which farthest() sets its hint to `index`; false if there is none. Valid for any
/// core and any index.
inline bool vertex(const ConvexView& view, int index, Vector& p) {
  switch (view.core) {
    case Core::kPoint:
      p.setZero();
      return index == 0;
    case Core::kSegment:
      p = Vector(0, 0, index == 1 ? view.size.z() : -view.size.z());
      return index == 0 || index == 1;
    case Core::kPoints:
      if (index < 0 || index >= view.count) return false;
      p = view.points[index];
      return true;
    case Core::kBox:
      p = Vector((index & 1) != 0 ? view.size.x() : -view.size.x(),
                 (index & 2) != 0 ? view.size.y() : -view.size.y(),
                 (index & 4) != 0 ? view.size.z() : -view.size.z());
      return index >= 0 && index < 8;
    case Core::kCylinder:
    case Core::kCone:
    case Core::kEllipsoid:
    case Core::kHalfSpace:
      break;
  }
  return false;
}

/// The set {b - a : a in A, b in B} of two cores in B's frame; when kSwept, A is the hull of two
/// placements.
template <bool kSwept>
class Difference {
 public:
  Difference(const ConvexView& a, const ConvexView& b, const Pose& X_BA0, const Pose& X_BA1)
      : a_(a), b_(b), X_BA0_(X_BA0), X_BA1_(X_BA1) {}

  /// The member with the smallest w . n.
  void support(const Vector& n, SupportPoint& s) {
    s.a = farthestOfA(X_BA0_, n, hint_a_[0]);
    s.index_a = hint_a_[0];
    if constexpr (kSwept) {
      s.placement = 0;
      const Vector other = farthestOfA(X_BA1_, n, hint_a_[1]);
      if (n.dot(other) > n.dot(s.a)) {
        s.a = other;
        s.index_a = hint_a_[1];
        s.placement = 1;
      }
    }
    s.w = farthest(b_, -n, hint_b_) - s.a;
    s.index_b = hint_b_;
  }

  /// The member made of two vertices; false if an index is out of range. One placement only.
  bool member(int index_a, int index_b, SupportPoint& s) const {
    Vector a, b;
    if (!vertex(a_, index_a, a) || !vertex(b_, index_b, b)) return false;
    s.a = placed(X_BA0_, a);
    s.w = b - s.a;
    s.index_a = index_a;
    s.index_b = index_b;
    s.placement = 0;
    return true;
  }
  /// True if some part of the cores' surfaces is curved.
  bool isRound() const { return collision::isRound(a_.core) || collision::isRound(b_.core); }

  /// The curvature of A (first placement) plus that of B at n, and `more` times the identity.
  TangentForm curvature(const Vector& n, const Tangents& at, double more) const {
    TangentForm form = {more, 0, more};
    const Curvature a = curvatureAt(a_, rotatedBack(X_BA0_.rotation, n));
    for (int i = 0; i < 2; ++i) form.add(a.strength[i], rotated(X_BA0_.rotation, a.axis[i]), at);
    const Curvature b = curvatureAt(b_, -n);
    for (int i = 0; i < 2; ++i) form.add(b.strength[i], b.axis[i], at);
    return form;
  }

  /// Moves a member to where its two pieces are farthest along n. One placement only.
  bool follow(const Vector& n, SupportPoint& s) const {
    Vector a, b;
    if (!farthestOfPiece(a_, rotatedBack(X_BA0_.rotation, n), s.index_a, a) ||
        !farthestOfPiece(b_, -n, s.index_b, b)) {
      return false;
    }
    s.a = placed(X_BA0_, a);
    s.w = b - s.a;
    return true;
  }

  bool countsVertices() const { return hasVertices(a_.core) && hasVertices(b_.core); }

  /// Vertices to start from; those out of range are ignored.
  void setHints(int vertex_a, int vertex_b) {
    if (vertex_a > 0 && vertex_a < a_.count) hint_a_[0] = hint_a_[1] = vertex_a;
    if (vertex_b > 0 && vertex_b < b_.count) hint_b_ = vertex_b;
  }
  const ConvexView& viewA() const { return a_; }
  const ConvexView& viewB() const { return b_; }
  const Pose& pose() const { return X_BA0_; }
  const Pose& endPose() const { return X_BA1_; }
  int hintA() const { return hint_a_[0]; }
  int hintB() const { return hint_b_; }

 private:
  Vector farthestOfA(const Pose& X_BA, const Vector& n, int& hint) const {
    return placed(X_BA, farthest(a_, rotatedBack(X_BA.rotation, n), hint));
  }

  const ConvexView& a_;
  const ConvexView& b_;
  const Pose& X_BA0_;
  const Pose& X_BA1_;
  int hint_a_[2] = {0, 0};
  int hint_b_ = 0;
};

}  // namespace leeway::collision
