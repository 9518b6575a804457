#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/time_of_contact.h"

namespace leeway::tools::report {

/// The truth of `report motion`: separating axes of polytopes, searched wherever a bound on speed
/// does not exclude contact. It is slow and simple, and shares no code with the engine.

/// A convex polytope: vertices in its own frame, and the directions a separating-axis test needs.
struct SlowPolytope {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3d> normals, edges;  // unit
  double reach = 0;                             ///< largest vertex distance from the origin [m]
};

SlowPolytope slowBox(const Eigen::Vector3d& half_extents);
/// Hull of points in general position; O(n^4).
SlowPolytope slowHull(std::span<const Eigen::Vector3d> points);

/// A moving polytope: its pose at t, and a bound on the speed of its points.
struct SlowBody {
  const SlowPolytope* shape = nullptr;
  std::function<collision::Pose(double)> pose;
  double speed = 0;  // [m]
};

/// Rotation about a unit axis, by the C library's sine and cosine.
Eigen::Matrix3d slowTurn(const Eigen::Vector3d& axis, double angle);

struct TimeTruth {
  bool contact = false;
  double lower = 0, upper = 0;  ///< contains the first time of contact
  bool clear = true;            ///< false: too close to touching to be decided
};

/// The first t in [0, 1] at which a pair's separation is at most `margin`. Separation is measured
/// only along the planes of faces and edges: exact for margin 0.
TimeTruth slowFirstContact(std::span<const SlowBody> bodies,
                           std::span<const std::array<std::size_t, 2>> pairs, double margin);
TimeTruth slowFirstContact(const collision::MovingTriangle& a, const collision::MovingTriangle& b,
                           double margin);

}  // namespace leeway::tools::report
