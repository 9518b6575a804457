#include "leeway/planner/depth_image.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
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

}  // namespace

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
  const double scale = camera.scale.value_or(image.number == Number::kUint16 ? 1e-3 : 1);
  const auto* const bytes = static_cast<const std::byte*>(image.first);
  const std::size_t size = sizeOf(image.number), row = image.width * size;
  const std::size_t stride = strideOf(image.first, image.height, image.stride, row);
  PointCloud cloud;
  std::size_t masked = 0, dropped = 0;
  for (std::size_t r = 0; r < image.height; ++r)
    for (std::size_t c = 0; c < image.width; ++c) {
      if (image.mask != nullptr && image.mask[r * image.width + c] == 0) {
        ++masked;
        continue;
      }
      const double value = depthAt(bytes + r * stride + c * size, image.number);
      if (value == -std::numeric_limits<double>::infinity())
        throw std::invalid_argument(
            fmt::format("the pixel at row {}, column {} has the depth -inf, so that something is "
                        "nearer than the camera measures; a depth, 0, nan or inf is expected, or a "
                        "mask that leaves the pixel out",
                        r, c));
      if (value == 0 || !std::isfinite(value)) {
        ++dropped;
        continue;
      }
      const double z = scale * value;
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
    }
  if (masked > 0) cloud.filters.push_back({"drop", "pixels that the mask leaves out", masked});
  if (dropped > 0) cloud.filters.push_back({"drop", "pixels without a measurement", dropped});
  return cloud;
}

PointCloud loadDepthImage(const std::string& path, const std::string& mask_path,
                          const DepthCamera& camera, double radius, const robots::Stop& stop) {
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
  PointCloud cloud = makeCloud({image.values.data(), image.width, image.height, 0, Number::kUint16,
                                mask.empty() ? nullptr : mask.data()},
                               camera, radius);
  if (cloud.balls.empty())
    throw robots::InputError(
        path, 0,
        fmt::format("none of its {} x {} pixels is a measurement{}; at least one above 0 is "
                    "expected",
                    image.width, image.height, mask.empty() ? "" : " that the mask keeps"));
  return cloud;
}

}  // namespace leeway::planner
