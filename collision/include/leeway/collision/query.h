#pragma once

// The requests and results of distance queries.

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>

#include "leeway/collision/interval.h"

namespace leeway::collision {

/// When a query may stop. Its interval contains the exact value in any case.
struct DistanceRequest {
  /// Stop when upper - lower <= tolerance [m]. NaN selects defaultTolerance() of the pair.
  double tolerance = std::numeric_limits<double>::quiet_NaN();
  /// Stop when lower > threshold ("farther than") or upper <= threshold ("not farther") [m]. NaN:
  /// no threshold.
  double threshold = std::numeric_limits<double>::quiet_NaN();
  /// False: stop as soon as overlap is proven (upper <= 0), with the lower end known by then.
  bool depth = true;
  /// Limit on the steps of GJK and of the penetration search for one pair; doubled for depths of
  /// round shapes. At a limit the interval is wider, but still holds.
  int iteration_limit = 256;
  /// Limit on the node pairs of bounding-volume hierarchies that are visited for a pair with a
  /// mesh.
  int node_limit = 10'000'000;
};

enum class DistanceStatus : unsigned char {
  kConverged,          ///< upper - lower <= tolerance, the request's or the default one
  kAboveThreshold,     ///< lower > threshold
  kNotAboveThreshold,  ///< upper <= threshold
  kOverlap,            ///< upper <= 0 and no depth was requested
  kLimit,    ///< stopped by a limit or by rounding: the interval holds, but is wider than requested
  kInvalid,  ///< a pose is not finite or its matrix is not a rotation, the frames are more than
             ///< 1e10 m apart (sum of the coordinates' differences), or both are half-spaces:
             ///< (-inf, inf)
};

/// The signed separation of A and B: their distance when apart, minus the length of the shortest
/// translation that separates them when they overlap. For overlapping meshes that length is only
/// bounded. The lower bound on it follows from the deepest pair of triangles found, from the
/// distance of an inner point to the surface, or from two balls around a common point, one in each
/// body. The upper bound is the length of a translation that is proven to separate them. Such an
/// interval can stay wider than requested (kLimit).
struct DistanceResult {
  Interval distance;  // [m]
  DistanceStatus status = DistanceStatus::kInvalid;
  /// Witness points on A and B in the frame of the poses [m]: |point_a - point_b| is within the
  /// interval's width of the distance; when overlapping, the deepest points found along `normal`.
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d point_b = Eigen::Vector3d::Zero();
  /// Unit vector from A to B. For convex shapes it is the normal of the plane that proves the lower
  /// end: moving B by t * normal adds t to that end. For meshes that overlap, moving B by -lower *
  /// normal separates them. For meshes that are apart it points from the nearest part of A to that
  /// of B; other parts may get closer when B moves along it. The normal has no meaning with
  /// kInvalid, nor with kOverlap, where no depth was requested.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  int iterations = 0;
  /// Indices into TriangleMesh::triangles() of the triangles that determine the upper end; -1 if a
  /// hull or a convex piece determines it.
  int triangle_a = -1;
  int triangle_b = -1;
};

/// Caller-owned memory of a pair's last query, for warm starts. Any content is valid: stale content
/// or that of another pair only costs time.
struct PairCache {
  /// Last separating direction, in B's frame; 0 if there is none.
  Eigen::Vector3d direction_B = Eigen::Vector3d::Zero();
  /// Number of vertex pairs of A and B that determined the last distance [count].
  int simplex_count = 0;
  int simplex_a[3] = {0, 0, 0}, simplex_b[3] = {0, 0, 0};
  int vertex_a = 0, vertex_b = 0;        ///< last support vertices
  int triangle_a = -1, triangle_b = -1;  ///< last closest triangles, or convex pieces
  int place = -1;  ///< position of the closest triangle in the hierarchy of a deforming mesh; -1:
                   ///< none
  std::uint64_t hierarchy = 0;  ///< the number of that hierarchy; 0: none
};

/// Caller-owned buffers for one thread. The constructor allocates all that queries need.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(Scratch&&) noexcept;
  Scratch& operator=(Scratch&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace leeway::collision
