#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "leeway/planner/point_cloud.h"

namespace leeway::planner::verification {

/// The balls of a cloud as a binary tree: the ball of each node contains those of its children.
/// Node 0 is the root. The tree shares nothing with the hierarchies that the planner uses.
class BallTree {
 public:
  /// `cloud` has at least one ball and must outlive the tree. O(n log n).
  explicit BallTree(const PointCloud& cloud);

  std::size_t ballCount() const { return cloud_.size(); }
  /// Whether a node is one of the cloud's balls.
  bool isBall(std::size_t node) const { return nodes_[node].second == 0; }
  const PointCloud::Ball& ball(std::size_t node) const {
    return isBall(node) ? cloud_.balls[nodes_[node].first] : nodes_[node].around;
  }
  /// Only for nodes that are not a ball of the cloud.
  std::pair<std::size_t, std::size_t> children(std::size_t node) const {
    return {nodes_[node].first, nodes_[node].second};
  }

 private:
  /// The numbers of the two children. If `second` is 0, `first` is the number of a ball of the
  /// cloud.
  struct Node {
    PointCloud::Ball around;
    std::uint32_t first = 0, second = 0;
  };
  std::uint32_t build(std::uint32_t* begin, std::uint32_t* end);

  const PointCloud& cloud_;
  std::vector<Node> nodes_;
};

}  // namespace leeway::planner::verification
