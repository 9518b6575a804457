#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/point_cloud.h"

namespace leeway::planner {

/// A camera without distortion. Its frame C has its origin in the lens, x to the right of the
/// picture, y down, and z along the optical axis into the scene.
struct DepthCamera {
  double fx = 0, fy = 0;  ///< focal lengths [pixels], above 0
  double cx = 0, cy = 0;  ///< where the axis meets the picture; 0 is the middle of the first pixel
  /// Depth of a value of 1 [m]. None: whole numbers are millimetres, others metres (REP 118).
  std::optional<double> scale = std::nullopt;
  /// The balls cover flat surfaces whose normal is up to this angle from the line of sight [rad];
  /// from 0. See depthSpread().
  double slant = 1.0471975511965976;
};

/// A depth image in memory, row by row from the top: depth along the optical axis.
struct DepthImage {
  enum class Number : unsigned char { kUint16, kFloat, kDouble };
  const void* first = nullptr;  ///< the first pixel; need not be aligned
  std::size_t width = 0, height = 0;
  std::size_t stride = 0;  ///< from one row to the next [bytes]; 0: a row's pixels, no gap
  Number number = Number::kUint16;
  /// One byte a pixel, width x height of them; pixels with 0 are left out. Null: none is.
  const std::uint8_t* mask = nullptr;
};

/// How much the radius of a ball grows with depth [m/m]: h / (cos(slant) - h), where
/// h = hypot(1 / fx, 1 / fy) / 2 is half of a pixel's diagonal at a depth of 1 m. Whatever a pixel
/// shows of a flat surface with its normal at up to `slant` from the pixel's ray is within depth
/// times that of the surface's point on the ray (docs/sensed.md has the proof). Throws
/// std::invalid_argument for a camera that is not accepted.
double depthSpread(const DepthCamera& camera);

/// A cloud in the camera's frame: a ball for each pixel, with the radius
/// `radius` + depth * depthSpread(camera). Pixels with a depth of 0 or one that is not finite are
/// no measurements. They and those of the mask are counted in `filters`. Throws
/// std::invalid_argument for a negative depth, a camera that is not accepted, pixels at a null
/// pointer, a stride that is smaller than a row, and what makeCloud() refuses of points.
/// O(pixels).
PointCloud makeCloud(const DepthImage& image, const DepthCamera& camera, double radius);

/// Space that a camera looked at and did not see, as shapes in its frame.
struct UnseenSpace {
  double range = 0;               ///< depth up to which it counts [m]; above 0
  std::size_t most_parts = 1000;  ///< convex parts, at least 1; fewer hold more of what was seen
};
/// The name of these shapes.
inline constexpr char kUnseenName[] = "unseen";
/// Returns the space behind what the pixels show, and all of that of pixels without a measurement
/// or outside the mask, within the picture and `range`: frusta that contain it. A rectangle of
/// pixels becomes one frustum from its nearest pixel on; those that hold most of what was seen are
/// halved. What is outside the picture is not in it. Throws std::invalid_argument as makeCloud(),
/// for a range that is not above 0 and up to 1e9 m, and 0 parts. O(pixels log(parts)).
std::vector<robots::Geometry> unseenShapes(const DepthImage& image, const DepthCamera& camera,
                                           const UnseenSpace& space);
/// Replaces a cloud by carved() and leaves out the parts of its unseen space that are proven to be
/// within `margin` of `shapes_W`, which its filters count, too. O(size x shapes).
void carve(PointCloud& cloud, std::vector<robots::Geometry>& unseen, const robots::Pose& X_WC,
           std::span<const robots::Geometry> shapes_W, double margin, const std::string& what);

/// Reads a depth image from a PNG or PGM of 16 bits, and its mask, of the same size, from one of
/// any number of bits; an empty path means no mask. Throws robots::InputError for a damaged file,
/// another size of the mask and an image without a measurement, std::invalid_argument as
/// makeCloud(), robots::Stopped. With `space`, `unseen` becomes its unseenShapes(). O(pixels).
PointCloud loadDepthImage(const std::string& path, const std::string& mask_path,
                          const DepthCamera& camera, double radius, const robots::Stop& stop = {},
                          const UnseenSpace* space = nullptr,
                          std::vector<robots::Geometry>* unseen = nullptr);

}  // namespace leeway::planner
