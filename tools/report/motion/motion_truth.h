#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::tools::report {

/// The truth of `report motion`: separating axes of polytopes, looked at wherever a bound on speed
/// does not exclude contact. Slow, obvious, and without any code of the engine.

/// A convex polytope by its own frame's vertices and the directions that separation has to look at.
struct SlowPolytope {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3d> normals, edges;  // unit
  double reach = 0;                             ///< of the vertices, from the origin [m]
};

SlowPolytope slowBox(const Eigen::Vector3d& half_extents);
/// Of points in general position; O(n^4).
SlowPolytope slowHull(std::span<const Eigen::Vector3d> points);

/// A polytope that moves: its pose at t, and what no point of it is faster than.
struct SlowBody {
  const SlowPolytope* shape = nullptr;
  std::function<collision::Pose(double)> pose;
  double speed = 0;  // [m]
};

/// Rotation about a unit axis, by the C library's sine and cosine.
Eigen::Matrix3d slowTurn(const Eigen::Vector3d& axis, double angle);

struct TimeTruth {
  bool contact = false;
  double lower = 0, upper = 0;  ///< holds the first time of contact
  bool clear = true;            ///< false: too near to touching, or not touching, for this to tell
};

/// The first t in [0, 1] at which a pair's separation is `margin` or less (to within the
/// separation of vertices by planes of faces and edges: exact for margin 0).
TimeTruth slowFirstContact(std::span<const SlowBody> bodies,
                           std::span<const std::array<std::size_t, 2>> pairs, double margin);
TimeTruth slowFirstContact(const collision::MovingTriangle& a, const collision::MovingTriangle& b,
                           double margin);

}  // namespace leeway::tools::report
