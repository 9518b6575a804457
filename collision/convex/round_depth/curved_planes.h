#pragma once

#include <cstdint>
#include <limits>

#include "collision/convex/gjk/progress.h"
#include "collision/convex/round_depth/curved_face.h"

namespace leeway::collision {

/// A step from a direction, and the edges of the difference that it follows.
struct CurvedStep {
  Vector way;  ///< no longer than 1
  CurvedEdge edge[2];
  int edges = 0;
};

/// Newton steps over directions towards the nearest supporting plane of a difference with round
/// parts. Planes and members are offered to `progress`.
class CurvedPlanes {
 public:
  /// Number of halved steps that are also tried [count].
  static constexpr int kHalves = 4;

  /// evenly: see CurvedFaces.
  CurvedPlanes(Difference<false>& difference, Progress& progress, double evenly);

  CurvedFaces& faces() { return faces_; }
  const CurvedFaces& faces() const { return faces_; }
  const Pose& pose() const { return difference_.pose(); }
  /// The distance of the nearest plane so far [m].
  double reach() const { return reach_; }
  void forgetReach() { reach_ = std::numeric_limits<double>::infinity(); }
  /// Smallest stiffness of blending [m].
  void setStiffness(double stiffness) { stiff_ = stiffness; }
  double stiffness() const;
  /// Work spent on planes, plus what a caller adds [count].
  std::int64_t work() const { return work_; }
  void spend(std::int64_t work) { work_ += work; }

  /// Offers the plane across the unit vector e, and returns its distance. (A step along a tiny way
  /// may give a direction that is 0 or NaN, which gives no plane.)
  double ask(const Vector& e);
  /// Newton step from e to where the gradient of the plane's distance vanishes. If pieces of the
  /// cores are blended, it follows the edges of the difference between them. False if the step is
  /// 0.
  bool stepFrom(const Vector& e, CurvedStep& step) const;
  /// The direction after a step, moved back onto its edges, which are curved.
  Vector after(const Vector& e, const CurvedStep& step) const;
  /// Descends from e, whose plane is at distance `value`, also through planes that are not the
  /// nearest.
  void descend(Vector e, double value);

  /// True for the core's flat end if the direction is perpendicular to it, to within `wide` [m].
  bool meetsCap(const CurvedFace& face, int part, double wide) const;
  /// The member of a choice, computed directly, because the sum that blend() returns has many
  /// terms. On a cap perpendicular to the direction, it is the point nearest to the direction's
  /// line, which blending ignores.
  Vector memberOf(const CurvedFace& face, const CurvedChoice& choice, double wide,
                  Vector& point_a) const;

 private:
  Vector stepOnto(const CurvedFace& face, const CurvedEdge* edge, int edges) const;
  Vector wayFrom(const CurvedFace& face, CurvedStep& step) const;

  Difference<false>& difference_;
  Progress& progress_;
  CurvedFaces faces_;
  double reach_ = 0;
  double stiff_ = 0;
  std::int64_t work_ = 0;
};

}  // namespace leeway::collision
