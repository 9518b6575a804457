#include "leeway/planner/depth_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "planner/sensed/gray_image.h"
#include "planner/sensed/stride.h"

namespace leeway::planner {
namespace {

using collision::kLargestSize;
using collision::kUnitRoundoff;
using Number = DepthImage::Number;

// Limits of the accepted values: pixels far wider and narrower than any camera's.
constexpr double kSmallestFocalLength = 1, kLargestFocalLength = 1e6;  // [pixels]
constexpr double kLargestSlant = 1.5;                                  // [rad]

/// Covers the rounding of a ball's center and radius, of a few operations each.
constexpr double kPixelRounding = 32 * kUnitRoundoff;

void requireWithin(const char* what, double value, double lowest, double greatest,
                   const char* unit) {
  if (value >= lowest && value <= greatest) return;
  throw std::invalid_argument(
      fmt::format("{} {}; {} to {}{} is accepted", what, value, lowest, greatest, unit));
}

double depthAt(const std::byte* pixel, Number number) {
  const auto load = [&](auto value) {
    std::memcpy(&value, pixel, sizeof value);
    return static_cast<double>(value);
  };
  if (number == Number::kUint16) return load(std::uint16_t{});
  return number == Number::kFloat ? load(float{}) : load(double{});
}

std::size_t sizeOf(Number number) {
  return number == Number::kUint16 ? 2 : number == Number::kFloat ? 4 : 8;
}

/// Calls visit(row, column, depth [m]) for each pixel; a depth that was not measured is 0. Throws
/// for a depth that is negative.
template <class Visit>
void eachPixel(const DepthImage& image, const DepthCamera& camera, const Visit& visit) {
  const double scale = camera.scale.value_or(image.number == Number::kUint16 ? 1e-3 : 1);
  const auto* const bytes = static_cast<const std::byte*>(image.first);
  const std::size_t size = sizeOf(image.number), row = image.width * size;
  const std::size_t stride = strideOf(image.first, image.height, image.stride, row);
  for (std::size_t r = 0; r < image.height; ++r)
    for (std::size_t c = 0; c < image.width; ++c) {
      const double value = depthAt(bytes + r * stride + c * size, image.number);
      visit(r, c, std::isfinite(value) ? scale * value : 0, value);
    }
}

/// A rectangle of pixels, from the first row and column to before the last.
struct Tile {
  std::size_t top, bottom, left, right;
  double nearest;  ///< depth of the nearest pixel [m]
  double waste;    ///< space that was seen behind that, times a constant factor [m^3]
  bool operator<(const Tile& other) const { return waste < other.waste; }
};

/// The depths up to which an image was seen free, cut at a range.
class SeenDepths {
 public:
  SeenDepths(const DepthImage& image, const DepthCamera& camera, double range)
      : width_(image.width), depths_(image.width * image.height), range_(range) {
    eachPixel(image, camera, [&](std::size_t r, std::size_t c, double z, double) {
      const bool is_seen = image.mask == nullptr || image.mask[r * width_ + c] != 0;
      depths_[r * width_ + c] = is_seen && z > 0 ? std::min(z, range) : 0;
    });
  }
  Tile tile(std::size_t top, std::size_t bottom, std::size_t left, std::size_t right) const {
    Tile tile{top, bottom, left, right, range_, 0};
    for (std::size_t r = top; r < bottom; ++r)
      for (std::size_t c = left; c < right; ++c)
        tile.nearest = std::min(tile.nearest, depths_[r * width_ + c]);
    for (std::size_t r = top; r < bottom; ++r)
      for (std::size_t c = left; c < right; ++c)
        tile.waste += std::pow(depths_[r * width_ + c], 3) - std::pow(tile.nearest, 3);
    return tile;
  }

 private:
  std::size_t width_;
  std::vector<double> depths_;  // 0: not seen
  double range_;
};

/// The space of a tile's rays from its nearest pixel to the range.
collision::Shape frustumOf(const Tile& tile, const DepthCamera& camera, double range) {
  // A frustum that is very thin has no hull.
  const double near = std::min(tile.nearest, range * (1 - 1e-3));
  std::vector<Eigen::Vector3d> corners;
  for (const double z : {near, range})
    for (const std::size_t r : {tile.top, tile.bottom})
      for (const std::size_t c : {tile.left, tile.right})
        if (z > 0 || corners.empty())
          corners.emplace_back(z * ((static_cast<double>(c) - 0.5 - camera.cx) / camera.fx),
                               z * ((static_cast<double>(r) - 0.5 - camera.cy) / camera.fy), z);
  return collision::Shape::convexHull(corners);
}

}  // namespace

std::vector<robots::Geometry> unseenShapes(const DepthImage& image, const DepthCamera& camera,
                                           const UnseenSpace& space) {
  depthSpread(camera);
  requireWithin("range", space.range, collision::kSmallestSize, kLargestSize, " m");
  if (space.most_parts == 0) throw std::invalid_argument("most_parts 0; at least 1 is accepted");
  std::vector<robots::Geometry> shapes;
  if (image.width == 0 || image.height == 0) return shapes;
  const SeenDepths depths(image, camera, space.range);
  std::vector<Tile> tiles = {depths.tile(0, image.height, 0, image.width)};
  while (tiles.size() < space.most_parts && tiles.front().waste > 0) {
    std::pop_heap(tiles.begin(), tiles.end());
    const Tile t = tiles.back();
    tiles.pop_back();
    const std::size_t rows = t.bottom - t.top, columns = t.right - t.left;
    const auto add = [&](const Tile& half) {
      tiles.push_back(half);
      std::push_heap(tiles.begin(), tiles.end());
    };
    if (rows > columns) {
      add(depths.tile(t.top, t.top + rows / 2, t.left, t.right));
      add(depths.tile(t.top + rows / 2, t.bottom, t.left, t.right));
    } else {
      add(depths.tile(t.top, t.bottom, t.left, t.left + columns / 2));
      add(depths.tile(t.top, t.bottom, t.left + columns / 2, t.right));
    }
  }
  for (const Tile& tile : tiles)
    if (tile.nearest < space.range)
      shapes.push_back({frustumOf(tile, camera, space.range), {}, kUnseenName});
  return shapes;
}

void carve(PointCloud& cloud, std::vector<robots::Geometry>& unseen, const robots::Pose& X_WC,
           std::span<const robots::Geometry> shapes_W, double margin, const std::string& what) {
  cloud = carved(cloud, X_WC, shapes_W, margin, what);
  collision::Scratch scratch;
  collision::DistanceRequest request;
  request.depth = false;
  request.threshold = margin;
  const std::size_t removed = std::erase_if(unseen, [&](const robots::Geometry& part) {
    return std::any_of(shapes_W.begin(), shapes_W.end(), [&](const robots::Geometry& shape) {
      return collision::distance(shape.shape, shape.X_BG, part.shape, X_WC * part.X_BG, request,
                                 scratch)
                 .distance.upper <= margin;
    });
  });
  if (removed > 0)
    cloud.filters.push_back({"carve", "parts of unseen space that touch " + what, removed, X_WC});
}

double depthSpread(const DepthCamera& camera) {
  requireWithin("fx", camera.fx, kSmallestFocalLength, kLargestFocalLength, " pixels");
  requireWithin("fy", camera.fy, kSmallestFocalLength, kLargestFocalLength, " pixels");
  requireWithin("cx", camera.cx, -kLargestFocalLength, kLargestFocalLength, " pixels");
  requireWithin("cy", camera.cy, -kLargestFocalLength, kLargestFocalLength, " pixels");
  requireWithin("slant", camera.slant, 0, kLargestSlant, " rad");
  if (camera.scale)
    requireWithin("scale", *camera.scale, collision::kSmallestSize, kLargestSize, " m");
  double sine, cosine;
  collision::sineCosine(camera.slant, sine, cosine);
  const double half = std::hypot(1 / camera.fx, 1 / camera.fy) / 2;
  // Wider pixels see past the horizon of a surface that stands so slanted.
  if (!(cosine > 2 * half))
    throw std::invalid_argument(fmt::format(
        "slant {} with pixels as wide as fx {} and fy {} make them; a smaller slant is accepted",
        camera.slant, camera.fx, camera.fy));
  return half / (cosine - half) * (1 + kPixelRounding);
}

PointCloud makeCloud(const DepthImage& image, const DepthCamera& camera, double radius) {
  const double spread = depthSpread(camera);
  requireWithin("radius", radius, collision::kSmallestSize, kLargestSize, " m");
  PointCloud cloud;
  std::size_t masked = 0, dropped = 0;
  eachPixel(image, camera, [&](std::size_t r, std::size_t c, double z, double value) {
    if (image.mask != nullptr && image.mask[r * image.width + c] == 0) {
      ++masked;
      return;
    }
    if (value == -std::numeric_limits<double>::infinity())
      throw std::invalid_argument(
          fmt::format("the pixel at row {}, column {} has the depth -inf, so that something is "
                      "nearer than the camera measures; a depth, 0, nan or inf is expected, or a "
                      "mask that leaves the pixel out",
                      r, c));
    if (value == 0 || !std::isfinite(value)) {
      ++dropped;
      return;
    }
    const Eigen::Vector3d p(z * ((static_cast<double>(c) - camera.cx) / camera.fx),
                            z * ((static_cast<double>(r) - camera.cy) / camera.fy), z);
    const double reach =
        (radius + z * spread) * (1 + kPixelRounding) + kPixelRounding * p.lpNorm<1>();
    if (!(z > 0) || !(p.lpNorm<1>() <= kLargestSize) || !(reach <= kLargestSize))
      throw std::invalid_argument(fmt::format(
          "the pixel at row {}, column {} has the depth {} m; depths from 0 on whose points and "
          "radii are up to {} m are accepted",
          r, c, z, kLargestSize));
    cloud.balls.push_back({p, reach});
  });
  if (masked > 0) cloud.filters.push_back({"drop", "pixels that the mask leaves out", masked});
  if (dropped > 0) cloud.filters.push_back({"drop", "pixels without a measurement", dropped});
  return cloud;
}

PointCloud loadDepthImage(const std::string& path, const std::string& mask_path,
                          const DepthCamera& camera, double radius, const robots::Stop& stop,
                          const UnseenSpace* space, std::vector<robots::Geometry>* unseen) {
  const GrayImage image = readGrayImage(path, "a depth image", stop);
  if (image.bits != 16)
    throw robots::InputError(path, 0,
                             fmt::format("has {} bits a pixel; a depth image of 16 bits is "
                                         "expected",
                                         image.bits));
  std::vector<std::uint8_t> mask;
  if (!mask_path.empty()) {
    const GrayImage of_mask = readGrayImage(mask_path, "a mask", stop);
    if (of_mask.width != image.width || of_mask.height != image.height)
      throw robots::InputError(
          mask_path, 0,
          fmt::format("has {} x {} pixels; a mask of {} x {}, as {} has, is expected",
                      of_mask.width, of_mask.height, image.width, image.height, path));
    for (const std::uint16_t value : of_mask.values) mask.push_back(value != 0 ? 1 : 0);
  }
  const DepthImage depth{image.values.data(), image.width,
                         image.height,        0,
                         Number::kUint16,     mask.empty() ? nullptr : mask.data()};
  PointCloud cloud = makeCloud(depth, camera, radius);
  if (cloud.balls.empty())
    throw robots::InputError(
        path, 0,
        fmt::format("none of its {} x {} pixels is a measurement{}; at least one above 0 is "
                    "expected",
                    image.width, image.height, mask.empty() ? "" : " that the mask keeps"));
  if (space != nullptr) *unseen = unseenShapes(depth, camera, *space);
  return cloud;
}

}  // namespace leeway::planner
