#pragma once

// What a distance query is asked, and what it answers.

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>

#include "leeway/collision/interval.h"

namespace leeway::collision {

/// What is asked of a query. The answer's interval always holds the truth; these say when it is
/// good enough.
struct DistanceRequest {
  /// Stop when upper - lower <= tolerance [m]. NaN: that of defaultTolerance().
  double tolerance = std::numeric_limits<double>::quiet_NaN();
  /// Stop when lower > threshold ("farther than") or upper <= threshold ("not farther"); NaN: no
  /// threshold [m].
  double threshold = std::numeric_limits<double>::quiet_NaN();
  /// False: a pair proven to overlap (upper <= 0) is answered at once with whatever lower end is
  /// known.
  bool depth = true;
  /// GJK and penetration steps for one pair, twice for round depths. It costs width, never truth.
  int iteration_limit = 256;
  /// Node pairs of bounding-volume hierarchies visited for a pair with a mesh. The same holds.
  int node_limit = 10'000'000;
};

enum class DistanceStatus : unsigned char {
  kConverged,          ///< upper - lower <= tolerance, the request's or the default one
  kAboveThreshold,     ///< lower > threshold
  kNotAboveThreshold,  ///< upper <= threshold
  kOverlap,            ///< upper <= 0 and no depth was asked
  kLimit,    ///< stopped by a limit or by rounding: the interval holds, but is wider than asked
  kInvalid,  ///< a pose that is not finite or not a rotation, or half-space with half-space; the
             ///< interval is (-inf, inf)
};

/// Signed separation of A and B: the distance when apart, minus the length of the smallest
/// translation that separates them when they overlap. Of overlapping meshes that length is enclosed
/// only: at least what the deepest pair of triangles found, the way from inside to the surface, or
/// two balls around a common point, one in either body, say; at most a translation that is proven
/// to separate them. Such an interval can stay wider than asked (kLimit).
struct DistanceResult {
  Interval distance;  // [m]
  DistanceStatus status = DistanceStatus::kInvalid;
  /// Witness points on A and B in the frame of the poses [m]: |point_a - point_b| is within the
  /// interval's width of the distance; when overlapping, the deepest points found along `normal`.
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d point_b = Eigen::Vector3d::Zero();
  /// Unit vector from A to B. For convex shapes the lower end is proven along it: moving B by
  /// t * normal adds t to it. For meshes that overlap, moving B by -lower * normal separates; for
  /// meshes that are apart it points from the nearest part of A to that of B, and nothing is
  /// promised of other parts.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  int iterations = 0;
  /// Triangles (of the meshes as given by TriangleMesh::triangles()) that carry the upper end; -1
  /// if none (a hull or a convex piece does).
  int triangle_a = -1;
  int triangle_b = -1;
};

/// Caller-owned memory of a pair's last query, for warm starts. Stale or foreign content costs
/// time, never truth.
struct PairCache {
  Eigen::Vector3d direction_B =
      Eigen::Vector3d::Zero();  ///< last separating direction, in B's frame; 0: none
  int simplex_count = 0;  ///< vertices of A and B that carried the last distance, pairwise; 0: none
  int simplex_a[3] = {0, 0, 0}, simplex_b[3] = {0, 0, 0};
  int vertex_a = 0, vertex_b = 0;        ///< last support vertices
  int triangle_a = -1, triangle_b = -1;  ///< last closest triangles, or convex pieces
  int place = -1;  ///< of the closest triangle in the hierarchy of a deforming mesh; -1: none
  std::uint64_t hierarchy = 0;  ///< which one that is, by its number; 0: none
};

/// Caller-owned buffers of one thread. Everything a query needs is allocated in the constructor.
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
