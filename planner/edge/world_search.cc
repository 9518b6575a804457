#include "planner/edge/world_search.h"

#include <Eigen/Core>
#include <cmath>

#include "collision/scene/scene_access.h"
#include "leeway/collision/distance.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

constexpr std::size_t kMostWorldTasks = std::size_t{1} << 15U;
/// Tolerance of the distance to a node's centre [m]. Nodes are larger by far.
constexpr double kNodeTolerance = 1e-5;
/// Larger boxes are those of half-spaces [m].
constexpr double kLargestNode = 1e9;

struct NodeBox {
  NodeBox(const collision::ObstacleBoxes::Level& level, std::size_t i) {
    for (int k = 0; k < 3; ++k) {
      const auto low = static_cast<double>(level.low[k][i]),
                 high = static_cast<double>(level.high[k][i]);
      center[k] = (low + high) / 2;
      half[k] = (high - low) / 2;
    }
  }
  bool isEmpty() const { return half.minCoeff() < 0; }  // padding
  bool isBounded() const { return half.maxCoeff() < kLargestNode; }

  Eigen::Vector3d center, half;
};

}  // namespace

WorldSearch::WorldSearch(const EdgeFrames& frames, collision::Workspace& workspace)
    : frames_(frames), workspace_(workspace) {
  tasks_.reserve(kMostWorldTasks);
}

bool WorldSearch::begin(std::size_t row, const Part& part) {
  const int piece = frames_.pairs().rows()[row].piece;
  boxes_ = collision::SceneAccess::boxes(frames_.scene().scene());
  shape_ = &frames_.piece(piece).shape();
  X_WA0_ = frames_.piecePose(part.slot0, piece);
  X_WA1_ = frames_.piecePose(part.slot1, piece);
  growth_ = part.growth;
  is_swept_ = part.slot0 != part.slot1;
  row_ = row;
  beyond_ = kInfinity;
  tasks_.clear();
  if (frames_.scene().scene().pairs().rows()[row].count == 0) return true;

  const Eigen::Vector3d &c0 = frames_.center(part.slot0, piece),
                        &c1 = frames_.center(part.slot1, piece);
  const Eigen::Vector3d center = (c0 + c1) / 2;
  const double radius = (c1 - c0).norm() / 2 + growth_ +
                        frames_.piece(piece).bounds().outer.radius + frames_.pairs().mostRounding();
  for (const collision::ObstacleBoxes* of : {boxes_->first().get(), boxes_}) {
    if (of == nullptr || of->levels().empty()) continue;
    const std::size_t top = of->levels().size() - 1;
    const collision::ObstacleBoxes::Level& level = of->levels()[top];
    for (std::size_t i = 0; i < level.size(); ++i) {
      const NodeBox box(level, i);
      if (box.isEmpty()) continue;
      const double apart = ((center - box.center).cwiseAbs() - box.half).cwiseMax(0).norm();
      const double lower = (1 - kSumRounding) * apart - radius;
      if (!push(box.isBounded() && !std::isnan(lower) ? lower : -kInfinity, *of, top, i))
        return false;
    }
  }
  return true;
}

bool WorldSearch::push(double lower, const collision::ObstacleBoxes& of, std::size_t level,
                       std::size_t index) {
  std::int32_t pair = -1;
  const bool is_of_first = &of != boxes_;
  if (level == 0) {
    // Slots of first() have the lowest numbers.
    const std::size_t before = is_of_first || of.first() == nullptr ? 0 : of.first()->slots();
    const std::int32_t place = boxes_->obstacle(before + index);
    if (place >= 0) pair = frames_.scene().scene().pairs().numberOf(row_, at(place));
    if (pair < 0) return true;
  }
  if (tasks_.size() == tasks_.capacity()) return false;
  tasks_.push_back({lower, pair, static_cast<std::int32_t>(index), static_cast<std::int32_t>(level),
                    is_of_first});
  std::push_heap(tasks_.begin(), tasks_.end());
  return true;
}

WorldSearch::Task WorldSearch::pop() {
  std::pop_heap(tasks_.begin(), tasks_.end());
  const Task task = tasks_.back();
  tasks_.pop_back();
  return task;
}

bool WorldSearch::expand(const Task& task, double enough) {
  const collision::ObstacleBoxes& of = task.is_of_first ? *boxes_->first() : *boxes_;
  const NodeBox node(of.levels()[at(task.level)], at(task.index));
  double from_center = -kInfinity;  // a lower bound on the distance of the node's centre
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  bool has_plane = false;
  if (node.isBounded()) {
    collision::DistanceRequest request;
    request.tolerance = kNodeTolerance;
    request.depth = false;
    collision::Scratch& scratch = collision::SceneAccess::scratch(workspace_);
    const collision::Pose X0{X_WA0_.rotation, X_WA0_.translation - node.center};
    const collision::Pose X1{X_WA1_.rotation, X_WA1_.translation - node.center};
    const collision::DistanceResult found =
        is_swept_ ? collision::sweptDistance(*shape_, X0, X1, growth_, point_, request, scratch)
                  : collision::distance(*shape_, X0, point_, {}, request, scratch);
    from_center = found.distance.lower - frames_.pairs().mostRounding();
    if (std::isnan(from_center)) from_center = -kInfinity;
    normal = found.normal;
    has_plane = shape_->isConvex() && from_center > 0;
  }
  const auto bound = [&](const NodeBox& box) {
    if (!box.isBounded()) return task.lower;
    const Eigen::Vector3d way = box.center - node.center;
    const double most = way.lpNorm<1>() + box.half.lpNorm<1>() + std::abs(from_center);
    const double lower = has_plane ? from_center + normal.dot(way) - normal.cwiseAbs().dot(box.half)
                                   : from_center - (way.cwiseAbs() + box.half).norm();
    return std::max(lower - kSumRounding * most, task.lower);
  };
  const double own = bound(node);
  if (own >= enough) {
    beyond_ = std::min(beyond_, own);
    return true;
  }
  const std::size_t below = at(task.level) - 1;
  const collision::ObstacleBoxes::Level& level = of.levels()[below];
  const std::size_t first = collision::ObstacleBoxes::kWidth * at(task.index);
  const std::size_t end = std::min(first + collision::ObstacleBoxes::kWidth, level.size());
  for (std::size_t i = first; i < end; ++i) {
    const NodeBox box(level, i);
    if (box.isEmpty()) continue;
    const double lower = std::max(own, bound(box));
    if (lower >= enough)
      beyond_ = std::min(beyond_, lower);
    else if (!push(lower, of, below, i))
      return false;
  }
  return true;
}

}  // namespace leeway::planner
