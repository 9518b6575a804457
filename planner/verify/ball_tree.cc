#include "planner/verify/ball_tree.h"

#include <algorithm>
#include <numeric>

#include "planner/base/tolerances.h"

namespace leeway::planner::verification {

using Eigen::Vector3d;

BallTree::BallTree(const PointCloud& cloud) : cloud_(cloud) {
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  nodes_.reserve(2 * cloud.size());
  build(order.data(), order.data() + order.size());
}

std::uint32_t BallTree::build(std::uint32_t* begin, std::uint32_t* end) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  if (end - begin == 1) {
    nodes_[number].first = *begin;
    return number;
  }
  Vector3d low = cloud_.balls[*begin].center, high = low;
  for (const std::uint32_t* b = begin; b != end; ++b) {
    low = low.cwiseMin(cloud_.balls[*b].center);
    high = high.cwiseMax(cloud_.balls[*b].center);
  }
  PointCloud::Ball around{low + (high - low) / 2, 0};
  for (const std::uint32_t* b = begin; b != end; ++b) {
    const PointCloud::Ball& ball = cloud_.balls[*b];
    const double reach = ((ball.center - around.center).norm() + ball.radius) *
                         (1 + kVerifyRounding);  // far above that of these few operations
    around.radius = std::max(around.radius, reach);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  std::uint32_t* const middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](std::uint32_t a, std::uint32_t b) {
    return cloud_.balls[a].center[axis] < cloud_.balls[b].center[axis];
  });
  const std::uint32_t left = build(begin, middle), right = build(middle, end);
  nodes_[number] = {around, left, right};
  return number;
}

}  // namespace leeway::planner::verification
