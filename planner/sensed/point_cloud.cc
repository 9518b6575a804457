#include "leeway/planner/point_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"
#include "leeway/collision/distance.h"
#include "planner/base/tolerances.h"
#include "planner/sensed/stride.h"

namespace leeway::planner {
namespace {

using collision::kLargestSize;
using collision::kSmallestSize;
using collision::kUnitRoundoff;
using Ball = PointCloud::Ball;
using Eigen::Vector3d;

/// Bounds the relative rounding of a distance of two points, added to or compared with a radius.
constexpr double kDistanceRounding = 16 * kUnitRoundoff;

void requireSize(const char* what, double size) {
  if (size >= kSmallestSize && size <= kLargestSize) return;
  throw std::invalid_argument(
      fmt::format("{} {}; {} to {} m is accepted", what, size, kSmallestSize, kLargestSize));
}

void requireNotNegative(const char* what, double distance) {
  if (distance >= 0 && distance <= kLargestSize) return;
  throw std::invalid_argument(
      fmt::format("{} {}; 0 to {} m is accepted", what, distance, kLargestSize));
}

void requirePose(const robots::Pose& X_WC) {
  if (collision::isPose(X_WC)) return;
  throw std::invalid_argument(
      "the pose of the cloud is not finite, or its matrix is not a rotation; a placement is "
      "expected");
}

/// Calls add(point, its number) for the points that are numbers; returns how many are not.
template <class Add>
std::size_t forEachPoint(const PointArray& points, const Add& add) {
  const bool is_float = points.number == PointArray::Number::kFloat;
  const std::size_t stride = strideOf(points.first, points.count, points.stride,
                                      3 * (is_float ? sizeof(float) : sizeof(double)));
  const auto* const bytes = static_cast<const std::byte*>(points.first);
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    Vector3d p;
    if (is_float) {
      float xyz[3];
      std::memcpy(xyz, bytes + i * stride, sizeof xyz);
      p = {double(xyz[0]), double(xyz[1]), double(xyz[2])};
    } else {
      double xyz[3];
      std::memcpy(xyz, bytes + i * stride, sizeof xyz);
      p = {xyz[0], xyz[1], xyz[2]};
    }
    if (!p.allFinite()) {
      ++dropped;
      continue;
    }
    for (int k = 0; k < 3; ++k)
      if (std::abs(p[k]) > kLargestSize)
        throw std::invalid_argument(
            fmt::format("point {} has the coordinate {}; up to {} m are "
                        "accepted",
                        i, p[k], kLargestSize));
    add(p, i);
  }
  return dropped;
}

template <class RadiusOf>
PointCloud cloudOf(const PointArray& points, const RadiusOf& radius_of) {
  PointCloud cloud;
  cloud.balls.reserve(points.count);
  const std::size_t dropped = forEachPoint(points, [&](const Vector3d& p, std::size_t i) {
    cloud.balls.push_back({p, radius_of(i)});
  });
  if (dropped > 0) cloud.filters.push_back({"drop", "points that are not numbers", dropped});
  return cloud;
}

struct Cell {
  std::int64_t i[3];
  bool operator==(const Cell& other) const {
    return i[0] == other.i[0] && i[1] == other.i[1] && i[2] == other.i[2];
  }
};
std::uint64_t hashOf(const Cell& cell) {
  std::uint64_t hash = 0;
  for (const std::int64_t i : cell.i)
    hash = (std::rotl(hash, 21) ^ static_cast<std::uint64_t>(i)) * 0x9E3779B97F4A7C15U;
  return hash ^ (hash >> 32U);
}

/// A bound on how far the ball reaches from `center` [m].
double reachFrom(const Vector3d& center, const Ball& ball) {
  return ((ball.center - center).norm() + ball.radius) * (1 + kDistanceRounding);
}

/// The balls of a cell.
struct CellBalls {
  Cell cell;
  std::size_t first, count = 0;
  Vector3d low, high;
  double radius = 0;
};

/// The cells of a grid that have balls, in the order of their first balls: a hash table with linear
/// probing.
class GridCells {
 public:
  explicit GridCells(std::size_t most) : slots_(std::bit_ceil(2 * most + 1), kFree) {}

  /// The number of the cell, a new one if `ball` is its first.
  std::size_t numberOf(const Cell& cell, std::size_t ball, const Vector3d& center) {
    // Points of a scan often share a cell with the one before.
    if (last_ < cells.size() && cells[last_].cell == cell) return last_;
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = static_cast<std::size_t>(hashOf(cell)) & mask;
    while (slots_[slot] != kFree && !(cells[slots_[slot]].cell == cell)) slot = (slot + 1) & mask;
    if (slots_[slot] == kFree) {
      slots_[slot] = cells.size();
      cells.push_back({cell, ball, 0, center, center, 0});
    }
    return last_ = slots_[slot];
  }
  std::vector<CellBalls> cells;

 private:
  static constexpr std::size_t kFree = ~std::size_t{0};
  std::vector<std::size_t> slots_;
  std::size_t last_ = 0;
};

/// Balls, sorted into parts whose centers are near each other.
class BallParts {
 public:
  explicit BallParts(std::vector<Ball>& balls) : balls_(balls) { add(0, balls.size()); }

  std::size_t size() const { return parts_.size(); }

  /// Halves the part with the longest diagonal. False where all centers of each part are equal.
  bool split() {
    const Part part = parts_.front();
    if (part.diagonal == 0) return false;
    std::pop_heap(parts_.begin(), parts_.end());
    parts_.pop_back();
    int axis = 0;
    (part.high - part.low).maxCoeff(&axis);
    const double low = part.low[axis], high = part.high[axis], middle = low + (high - low) / 2;
    // The highest is never on the low side, where `middle` is rounded to it.
    const auto begin = balls_.begin();
    const auto second = std::partition(
        begin + static_cast<std::ptrdiff_t>(part.begin),
        begin + static_cast<std::ptrdiff_t>(part.end),
        [&](const Ball& ball) { return ball.center[axis] <= middle && ball.center[axis] < high; });
    add(part.begin, static_cast<std::size_t>(second - begin));
    add(static_cast<std::size_t>(second - begin), part.end);
    return true;
  }

  /// One ball for each part, which contains the part's.
  std::vector<Ball> balls() const {
    std::vector<Ball> around;
    around.reserve(parts_.size());
    for (const Part& part : parts_) {
      if (part.end - part.begin == 1) {
        around.push_back(balls_[part.begin]);
        continue;
      }
      Ball outer{part.low + (part.high - part.low) / 2, 0};
      for (std::size_t b = part.begin; b < part.end; ++b)
        outer.radius = std::max(outer.radius, reachFrom(outer.center, balls_[b]));
      around.push_back(outer);
    }
    return around;
  }

 private:
  struct Part {
    std::size_t begin, end;
    Vector3d low, high;  // of the centers
    double diagonal;
    bool operator<(const Part& other) const {
      return diagonal != other.diagonal ? diagonal < other.diagonal : begin > other.begin;
    }
  };

  void add(std::size_t begin, std::size_t end) {
    Part part{begin, end, balls_[begin].center, balls_[begin].center, 0};
    for (std::size_t b = begin + 1; b < end; ++b) {
      part.low = part.low.cwiseMin(balls_[b].center);
      part.high = part.high.cwiseMax(balls_[b].center);
    }
    part.diagonal = (part.high - part.low).norm();
    parts_.push_back(part);
    std::push_heap(parts_.begin(), parts_.end());
  }

  std::vector<Ball>& balls_;
  std::vector<Part> parts_;  // a heap
};

/// How far rounding moves a point of the cloud that is placed in the world [m].
double placingError(const robots::Pose& X_WC, const Vector3d& p_C) {
  return kDistanceRounding * (X_WC.translation.lpNorm<1>() + p_C.lpNorm<1>());
}

/// Keeps the balls that are not marked.
PointCloud without(const PointCloud& cloud, const std::vector<char>& is_removed,
                   const std::string& filter, const std::string& what) {
  PointCloud kept;
  kept.filters = cloud.filters;
  kept.crops = cloud.crops;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (is_removed[i] == 0) kept.balls.push_back(cloud.balls[i]);
  kept.filters.push_back({filter, what, cloud.size() - kept.size()});
  return kept;
}

}  // namespace

double PointCloud::largestRadius() const {
  double largest = 0;
  for (const Ball& ball : balls) largest = std::max(largest, ball.radius);
  return largest;
}

bool PointCloud::isThinned() const {
  return std::any_of(filters.begin(), filters.end(),
                     [](const CloudFilter& f) { return f.name == "thin" && f.removed > 0; });
}

bool CloudRegion::replaces(const Ball& ball, bool is_thinned) const {
  if (!is_thinned) return contains(ball.center);
  const double reach = ball.radius * (1 + kDistanceRounding);
  return ((ball.center - low).array() >= reach).all() &&
         ((high - ball.center).array() >= reach).all();
}

double PointCloud::completeWithin() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Crop& crop : crops) least = std::min(least, crop.distance);
  return least;
}

bool PointCloud::Crop::covers(std::span<const Ball> others_W) const {
  const auto isInside = [](const Ball& inner, const Ball& outer) {
    if (inner.center == outer.center) return inner.radius <= outer.radius;
    return reachFrom(outer.center, inner) <= outer.radius;
  };
  for (std::size_t i = 0; i < others_W.size(); ++i) {
    const Ball& other = others_W[i];
    // The same robot has its balls in the same order.
    if ((i >= reach_W.size() || !isInside(other, reach_W[i])) &&
        std::none_of(reach_W.begin(), reach_W.end(),
                     [&](const Ball& reach) { return isInside(other, reach); }))
      return false;
  }
  return true;
}

PointCloud makeCloud(const PointArray& points, double radius) {
  requireSize("radius", radius);
  return cloudOf(points, [&](std::size_t) { return radius; });
}

PointCloud makeCloud(const PointArray& points, std::span<const double> radii) {
  if (radii.size() != points.count)
    throw std::invalid_argument(fmt::format("{} radii for {} points; one for each is expected",
                                            radii.size(), points.count));
  return cloudOf(points, [&](std::size_t i) {
    requireSize("radius", radii[i]);
    return radii[i];
  });
}

PointCloud thinned(const PointCloud& cloud, double cell) {
  requireSize("thin: a cell of", cell);
  GridCells grid(cloud.size());
  std::vector<std::size_t> cell_of(cloud.size());
  std::vector<CellBalls>& cells = grid.cells;
  for (std::size_t b = 0; b < cloud.size(); ++b) {
    const Vector3d& p = cloud.balls[b].center;
    Cell key{};
    for (int k = 0; k < 3; ++k) key.i[k] = static_cast<std::int64_t>(std::floor(p[k] / cell));
    cell_of[b] = grid.numberOf(key, b, p);
    CellBalls& balls = cells[cell_of[b]];
    ++balls.count;
    balls.low = balls.low.cwiseMin(p);
    balls.high = balls.high.cwiseMax(p);
  }
  const auto middle = [](const CellBalls& balls) {
    return Vector3d(balls.low + (balls.high - balls.low) / 2);
  };
  for (std::size_t b = 0; b < cloud.size(); ++b) {
    CellBalls& balls = cells[cell_of[b]];
    balls.radius = std::max(balls.radius, reachFrom(middle(balls), cloud.balls[b]));
  }
  PointCloud thin;
  thin.filters = cloud.filters;
  thin.crops = cloud.crops;
  thin.balls.reserve(cells.size());
  for (const CellBalls& balls : cells)
    thin.balls.push_back(balls.count == 1 ? cloud.balls[balls.first]
                                          : Ball{middle(balls), balls.radius});
  thin.filters.push_back(
      {"thin", fmt::format("balls that larger ones, up to {:.4g} m, contain", thin.largestRadius()),
       cloud.size() - thin.size()});
  return thin;
}

PointCloud thinnedTo(const PointCloud& cloud, std::size_t most_balls) {
  if (most_balls == 0)
    throw std::invalid_argument("most_balls is 0; at least one ball is accepted");
  PointCloud thin = cloud;
  if (cloud.size() > most_balls) {
    BallParts parts(thin.balls);
    while (parts.size() < most_balls && parts.split()) {
    }
    thin.balls = parts.balls();
  }
  thin.filters.push_back(
      {"thin", fmt::format("balls that larger ones, up to {:.4g} m, contain", thin.largestRadius()),
       cloud.size() - thin.size()});
  return thin;
}

PointCloud carved(const PointCloud& cloud, const robots::Pose& X_WC,
                  std::span<const robots::Geometry> shapes_W, double margin,
                  const std::string& what) {
  requireNotNegative("margin", margin);
  requirePose(X_WC);
  std::vector<char> is_removed(cloud.size(), 0);
  std::vector<Vector3d> centers_W;
  centers_W.reserve(cloud.size());
  for (const Ball& ball : cloud.balls) centers_W.push_back(X_WC * ball.center);
  collision::Scratch scratch;
  collision::DistanceRequest request;
  request.depth = false;
  for (const robots::Geometry& geometry : shapes_W) {
    const collision::Shape& shape = geometry.shape;
    const Vector3d middle = geometry.X_BG * shape.boundingCenter();
    for (std::size_t b = 0; b < cloud.size(); ++b) {
      const Ball& ball = cloud.balls[b];
      // The bounding spheres only save queries, so their rounding does not matter.
      if (is_removed[b] != 0 ||
          (centers_W[b] - middle).norm() > 1.001 * (shape.boundingRadius() + ball.radius + margin))
        continue;
      request.threshold = margin - placingError(X_WC, ball.center);
      const auto result =
          collision::distance(shape, geometry.X_BG, collision::Shape::sphere(ball.radius),
                              {Eigen::Matrix3d::Identity(), centers_W[b]}, request, scratch);
      is_removed[b] = result.distance.upper <= request.threshold ? 1 : 0;
    }
  }
  PointCloud kept = without(cloud, is_removed, "carve",
                            margin > 0 ? fmt::format("balls within {:.4g} m of {}", margin, what)
                                       : "balls that touch " + what);
  kept.filters.back().X_WC = X_WC;
  return kept;
}

PointCloud cropped(const PointCloud& cloud, const robots::Pose& X_WC, std::span<const Ball> reach_W,
                   double distance) {
  requireNotNegative("distance", distance);
  requirePose(X_WC);
  std::vector<Ball> grown(reach_W.begin(), reach_W.end());
  for (Ball& reach : grown) reach.radius += kCropGrowth * (reach.center.norm() + reach.radius);
  std::vector<char> is_removed(cloud.size(), 0);
  for (std::size_t b = 0; b < cloud.size(); ++b) {
    const Ball& ball = cloud.balls[b];
    const Vector3d center_W = X_WC * ball.center;
    const double error = placingError(X_WC, ball.center);
    is_removed[b] = std::all_of(grown.begin(), grown.end(), [&](const Ball& reach) {
      return (center_W - reach.center).norm() * (1 - kDistanceRounding) - error >
             (reach.radius + ball.radius + distance) * (1 + kDistanceRounding);
    });
  }
  PointCloud kept = without(cloud, is_removed, "crop",
                            fmt::format("balls farther than {:.4g} m from all that the robot can "
                                        "reach",
                                        distance));
  // Nothing is cropped within an infinite reach.
  if (std::all_of(grown.begin(), grown.end(),
                  [](const Ball& r) { return std::isfinite(r.radius); }))
    kept.crops.push_back({distance, X_WC, std::move(grown)});
  return kept;
}

std::string regionFault(const CloudRegion& region, const PointCloud& seen) {
  for (int k = 0; k < 3; ++k)
    if (!(region.low[k] <= region.high[k]))
      return fmt::format(
          "the region is from {} to {} along {}; a lower and an upper bound are "
          "expected",
          region.low[k], region.high[k], "xyz"[k]);
  if (!seen.crops.empty())
    return "points were cropped from what was seen in the region; all that was seen is expected";
  return {};
}

PointCloud renewed(const PointCloud& cloud, const CloudRegion& region, const PointCloud& seen) {
  if (const std::string fault = regionFault(region, seen); !fault.empty())
    throw std::invalid_argument(fault);
  PointCloud result;
  result.filters = cloud.filters;
  result.crops = cloud.crops;
  result.balls.reserve(cloud.size() + seen.size());
  std::copy_if(cloud.balls.begin(), cloud.balls.end(), std::back_inserter(result.balls),
               [&, thin = cloud.isThinned()](const Ball& b) { return !region.replaces(b, thin); });
  // Sums, because regions may be renewed at the rate of a sensor.
  const auto note = [&](const CloudFilter& filter) {
    const auto same =
        std::find_if(result.filters.begin(), result.filters.end(), [&](const CloudFilter& f) {
          return !f.X_WC && !filter.X_WC && f.name == filter.name && f.what == filter.what;
        });
    if (same == result.filters.end())
      result.filters.push_back(filter);
    else
      same->removed += filter.removed;
  };
  note({"renew", "balls of regions that were seen again", cloud.size() - result.size()});
  for (const CloudFilter& filter : seen.filters) note(filter);
  result.balls.insert(result.balls.end(), seen.balls.begin(), seen.balls.end());
  return result;
}

std::string cloudFault(const PointCloud& cloud) {
  const bool is_filtered =
      std::any_of(cloud.filters.begin(), cloud.filters.end(), [](const CloudFilter& f) {
        return (f.name == "carve" || f.name == "crop" || f.name == "renew") && f.removed > 0;
      });
  if (cloud.balls.empty() && !is_filtered) {
    std::string dropped;
    for (const CloudFilter& f : cloud.filters)
      if (f.removed > 0)
        dropped += fmt::format("{}{} {}", dropped.empty() ? ": dropped " : ", ", f.removed, f.what);
    return "no ball is left" + dropped + "; at least one is expected";
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Ball& ball = cloud.balls[i];
    if (!(ball.radius >= kSmallestSize && ball.radius <= kLargestSize))
      return fmt::format("ball {} has the radius {}; {} to {} m is accepted", i, ball.radius,
                         kSmallestSize, kLargestSize);
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(ball.center[k]) <= kLargestSize))
        return fmt::format("ball {} has the coordinate {}; up to {} m is accepted", i,
                           ball.center[k], kLargestSize);
  }
  return {};
}

std::vector<robots::Geometry> geometriesOf(const PointCloud& cloud) {
  std::vector<robots::Geometry> geometries;
  geometries.reserve(cloud.size());
  for (const Ball& ball : cloud.balls) {
    // Most clouds have one radius, and copies need no checks.
    const bool is_as_before =
        !geometries.empty() && geometries.back().shape.radius() == ball.radius;
    geometries.push_back(
        {is_as_before ? geometries.back().shape : collision::Shape::sphere(ball.radius),
         {Eigen::Matrix3d::Identity(), ball.center},
         {}});
  }
  return geometries;
}

}  // namespace leeway::planner
