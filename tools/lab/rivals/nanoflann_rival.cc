// nanoflann's tree of points, for `report sensed`: whether a sphere or capsule of the robot
// comes nearer to a point than the radius of its ball.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nanoflann.hpp>
#include <span>
#include <vector>

#include "leeway/collision/scene.h"
#include "tools/lab/base/rivals.h"

namespace leeway::tools::report {
namespace {

using collision::ShapeType;
using Eigen::Vector3d;

/// The points, as nanoflann reads them.
struct Cloud {
  std::vector<Vector3d> points_W;
  std::size_t kdtree_get_point_count() const { return points_W.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t k) const {
    return points_W[i][static_cast<Eigen::Index>(k)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3>;

/// nanoflann's search ends at the first point that is near the segment.
class Near {
 public:
  Near(const Cloud& cloud, const Vector3d& middle, const Vector3d& half, double within)
      : cloud_(cloud),
        middle_(middle),
        half_(half),
        reach_squared_((half.norm() + within) * (half.norm() + within)),
        within_squared_(within * within) {}
  bool addPoint(double, std::uint32_t i) {
    const Vector3d p = cloud_.points_W[i] - middle_;
    const double length_squared = half_.squaredNorm();
    const double t =
        length_squared > 0 ? std::clamp(p.dot(half_) / length_squared, -1.0, 1.0) : 0.0;
    found_ = (p - t * half_).squaredNorm() <= within_squared_;
    return !found_;
  }
  double worstDist() const { return reach_squared_; }
  static bool full() { return true; }
  bool found() const { return found_; }

 private:
  const Cloud& cloud_;
  const Vector3d &middle_, &half_;
  double reach_squared_, within_squared_;
  bool found_ = false;
};

class NanoflannChecker : public StateChecker {
 public:
  explicit NanoflannChecker(const collision::Scene& scene) : scene_(scene) {
    for (const collision::Body& body : scene.bodies()) {
      for (const collision::Geometry& geometry : body.geometries) {
        const ShapeType type = geometry.shape.type();
        is_complete_ &= body.moving && (type == ShapeType::kSphere || type == ShapeType::kCapsule);
      }
      if (!body.balls) continue;
      for (const collision::Ball& ball : *body.balls) {
        if (cloud_.points_W.empty()) radius_ = ball.radius;
        is_complete_ &= ball.radius == radius_;
        cloud_.points_W.push_back(body.X_WB * ball.center);
      }
    }
    is_complete_ = is_complete_ && !cloud_.points_W.empty() && scene.pairs().listedCount() == 0;
    if (is_complete_) tree_ = std::make_unique<Tree>(3, cloud_);
  }
  bool isComplete() const { return is_complete_; }

  bool isFree(std::span<const collision::Pose> X_WB) override {
    for (const collision::ScenePairs::Row& row : scene_.pairs().rows()) {
      const auto body = static_cast<std::size_t>(row.body);
      const collision::Geometry& of =
          scene_.bodies()[body].geometries[static_cast<std::size_t>(row.geometry)];
      const collision::Pose X_WG = X_WB[body] * of.X_BG;
      const Vector3d half = of.shape.type() == ShapeType::kCapsule
                                ? Vector3d(of.shape.halfLength() * X_WG.rotation.col(2))
                                : Vector3d::Zero();
      Near near(cloud_, X_WG.translation, half, of.shape.radius() + radius_);
      tree_->findNeighbors(near, X_WG.translation.data(), nanoflann::SearchParams());
      if (near.found()) return false;
    }
    return true;
  }

 private:
  const collision::Scene& scene_;
  Cloud cloud_;
  double radius_ = 0;
  std::unique_ptr<Tree> tree_;
  bool is_complete_ = true;
};

class NanoflannEngine : public StateEngine {
 public:
  const char* name() const override { return "nanoflann"; }
  std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const override {
    auto checker = std::make_unique<NanoflannChecker>(scene);
    if (!checker->isComplete()) return nullptr;
    return checker;
  }
};

}  // namespace
}  // namespace leeway::tools::report

extern "C" leeway::tools::report::Rivals* leewayMakeRivals5() {
  using namespace leeway::tools::report;
  auto rivals = std::make_unique<Rivals>();
  rivals->states.push_back(std::make_unique<NanoflannEngine>());
  return rivals.release();
}
