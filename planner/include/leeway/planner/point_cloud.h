#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/collision/ball.h"
#include "leeway/robots/model.h"

namespace leeway::planner {

/// A filter that was applied to a cloud.
struct CloudFilter {
  std::string name;         ///< "drop", "carve", "crop", "thin" or "renew"
  std::string what;         ///< "points that are not numbers", "balls that touch can"
  std::size_t removed = 0;  ///< balls that are gone [count]
  /// The cloud's pose when "carve" was applied. The cloud is refused at another pose, because the
  /// balls that were carved out may be in the way there. Empty: not known.
  std::optional<robots::Pose> X_WC = {};
};

/// A union of balls, one around each point that a sensor saw. Plans, checks and proofs take exactly
/// that union for the obstacle. Space between and behind the balls is free (docs/sensed.md).
/// Immutable once it belongs to an object.
struct PointCloud {
  using Ball = collision::Ball;
  /// A call of cropped(): the balls that it removed are farther than `distance` from `reach_W`
  /// while the cloud stands at `X_WC`.
  struct Crop {
    double distance = 0;  ///< [m]
    robots::Pose X_WC;
    std::vector<Ball> reach_W;

    /// Whether each ball of `others_W` is proven to be inside one of `reach_W`.
    /// O(balls x balls), O(balls) for the same balls.
    bool covers(std::span<const Ball> others_W) const;
  };
  std::vector<Ball> balls;           ///< in the cloud's frame C; radii from 1e-9 m
  std::vector<CloudFilter> filters;  ///< in the order in which they were applied
  /// The crops of the cloud. A problem is refused if one of its margins is larger than a crop's
  /// distance, the cloud stands elsewhere, or the robot reaches beyond a crop's reach.
  std::vector<Crop> crops;

  std::size_t size() const { return balls.size(); }
  /// The least distance of all crops [m]; infinite for a cloud that was not cropped.
  double completeWithin() const;
  /// 0 for no balls. O(size).
  double largestRadius() const;
  /// Whether a ball may stand for several points, as after thinned().
  bool isThinned() const;
};

/// Points in memory, as drivers and sensor_msgs/PointCloud2 keep them: x, y and z stand one after
/// the other, in this machine's byte order.
struct PointArray {
  enum class Number : unsigned char { kFloat, kDouble };
  const void* first = nullptr;  ///< x of the first point; need not be aligned
  std::size_t count = 0;        ///< of points
  std::size_t stride = 0;       ///< from one point to the next [bytes]; 0: three numbers, no gap
  Number number = Number::kFloat;
};

/// The cloud of points with one radius [m]. Points with a coordinate that is not finite are
/// dropped, and counted in `filters`. Throws std::invalid_argument for a radius outside 1e-9 to
/// 1e9 m, a coordinate beyond 1e9 m, points at a null pointer, and a stride that is smaller than
/// three numbers. O(count).
PointCloud makeCloud(const PointArray& points, double radius);
/// The same with one radius a point; those of dropped points are not looked at.
PointCloud makeCloud(const PointArray& points, std::span<const double> radii);

/// Reads the points of a file: .ply (vertices), .pcd (ascii, binary, binary_compressed), .xyz,
/// .txt and .csv (numbers in columns), in metres and in the file's own frame. Other properties and
/// columns are left out. Drops points as makeCloud() does. Adds to `warnings`, with file and line.
/// Throws robots::InputError with line or byte for a damaged file and for one without a point,
/// std::invalid_argument for a radius as makeCloud() does, robots::Stopped. O(size of the file).
PointCloud loadCloud(const std::string& path, double radius, std::vector<std::string>& warnings,
                     const robots::Stop& stop = {});

/// One ball for each cell of a cubic grid with edges of `cell` [m] in which balls have their
/// centers. It contains all balls of its cell, so the union only grows. A ball that is alone in its
/// cell stays as it is. Throws std::invalid_argument for a cell outside 1e-9 to 1e9 m. O(size).
PointCloud thinned(const PointCloud& cloud, double cell);

/// At most `most_balls` > 0 balls, which contain all balls of the cloud, so the union only grows.
/// The cloud is halved again and again where its parts are longest. A part of several balls becomes
/// one that contains them; a ball that is a part of its own stays as it is. Throws
/// std::invalid_argument for 0. O(size log(most_balls)) on surfaces.
PointCloud thinnedTo(const PointCloud& cloud, std::size_t most_balls);

/// Without the balls that are proven to be within `margin` >= 0 [m] of one of the shapes; X_BG of
/// these is their pose in the world, X_WC that of the cloud. `what` names the shapes in `filters`.
/// O(size x shapes) comparisons, and a distance for each ball that is near a shape.
PointCloud carved(const PointCloud& cloud, const robots::Pose& X_WC,
                  std::span<const robots::Geometry> shapes_W, double margin,
                  const std::string& what);

/// Without the balls that are proven to be farther than `distance` >= 0 [m] from all balls of
/// `reach_W`, such as reachOf() (problem.h). The result keeps the crop in `crops`.
/// O(size x reach).
PointCloud cropped(const PointCloud& cloud, const robots::Pose& X_WC,
                   std::span<const PointCloud::Ball> reach_W, double distance);

/// A box along the axes of a cloud's frame, its faces included. Bounds may be infinite.
struct CloudRegion {
  Eigen::Vector3d low, high;  ///< [m]
  bool contains(const Eigen::Vector3d& p) const {
    return (low.array() <= p.array()).all() && (p.array() <= high.array()).all();
  }
  /// Whether renewed() removes a ball of a cloud that is, or is not, thinned.
  bool replaces(const PointCloud::Ball& ball, bool is_thinned) const;
};
/// The cloud after a sensor saw a region again: without the balls that have their centers in it
/// (of a thinned cloud: that lie in it as a whole, because others may stand for points outside),
/// and then those of `seen`, whose filters are added. A ball of `seen` may be anywhere. `seen` may
/// have no ball: nothing is there any more. Throws std::invalid_argument for a region with a NaN or
/// a lower bound above the upper one, and for a cropped `seen`. O(size).
/// CompiledScene::withRegion() does the same to a compiled cloud, at the cost of the region.
PointCloud renewed(const PointCloud& cloud, const CloudRegion& region, const PointCloud& seen);
/// Returns the fault of renewed()'s arguments; empty if they are accepted.
std::string regionFault(const CloudRegion& region, const PointCloud& seen);

/// Returns a message about the first ball that is not accepted, "ball 7 has the radius -1; ...", or
/// an empty string. Radii from 1e-9 to 1e9 m and coordinates up to 1e9 m are accepted. A cloud
/// without a ball is accepted only if carved(), cropped() or renewed() removed all that it had.
/// O(size).
std::string cloudFault(const PointCloud& cloud);

/// The balls as shapes in the cloud's frame. Throws collision::InvalidShape for a radius that no
/// sphere can have.
std::vector<robots::Geometry> geometriesOf(const PointCloud& cloud);

}  // namespace leeway::planner
