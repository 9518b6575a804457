#include "tools/report/rivals/fcl_state_rival.h"

#include <fcl/geometry/shape/halfspace.h>
#include <fcl/narrowphase/collision.h>

#include <utility>
#include <vector>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "tools/report/rivals/fcl_shape_rival.h"

namespace leeway::tools::report {
namespace {

using collision::Shape;
using collision::ShapeType;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

Geometry makeGeometry(const Shape& shape) {
  if (shape.type() == ShapeType::kMesh)
    return makeFclModel<fcl::OBBRSSd>(shape.mesh()->vertices(), shape.mesh()->triangles());
  if (shape.type() == ShapeType::kHalfSpace)
    return std::make_shared<fcl::Halfspaced>(fcl::Vector3d::UnitZ(), 0);
  ReportShape convex{shape, {}};
  if (shape.hull() != nullptr)
    convex.points.assign(shape.hull()->vertices().begin(), shape.hull()->vertices().end());
  return makeFclShape(convex);
}

class FclChecker : public StateChecker {
 public:
  explicit FclChecker(const collision::Scene& scene) : scene_(scene) {
    for (const collision::Body& body : scene.bodies()) {
      first_.push_back(parts_.size());
      for (const collision::Geometry& geometry : body.geometries) {
        parts_.push_back({makeGeometry(geometry.shape), fcl::Transform3d::Identity(),
                          Eigen::Vector3d::Zero(), geometry.shape.boundingRadius()});
        complete_ = complete_ && parts_.back().shape;
      }
      if (!body.moving) place(parts_.size() - body.geometries.size(), body, body.X_WB);
    }
  }

  bool complete() const { return complete_; }

  bool isFree(std::span<const collision::Pose> X_WB) override {
    for (std::size_t b = 0; b < first_.size(); ++b)
      if (scene_.bodies()[b].moving) place(first_[b], scene_.bodies()[b], X_WB[b]);
    for (const collision::ScenePair& pair : scene_.pairs()) {
      const Part& a = partOf(pair.body_a, pair.geometry_a);
      const Part& b = partOf(pair.body_b, pair.geometry_b);
      const double reach = a.radius + b.radius;  // infinite for half-spaces
      if ((a.p_WC - b.p_WC).squaredNorm() > reach * reach) continue;
      fcl::CollisionResultd result;
      if (fcl::collide(a.shape.get(), a.X_WG, b.shape.get(), b.X_WG, request_, result) > 0)
        return false;
    }
    return true;
  }

 private:
  struct Part {
    Geometry shape;
    fcl::Transform3d X_WG;
    Eigen::Vector3d p_WC;  ///< centre of the bounding sphere
    double radius;
  };

  const Part& partOf(int body, int geometry) const {
    return parts_[first_[static_cast<std::size_t>(body)] + static_cast<std::size_t>(geometry)];
  }

  void place(std::size_t first, const collision::Body& body, const collision::Pose& X_WB) {
    for (std::size_t i = 0; i < body.geometries.size(); ++i) {
      const collision::Pose X_WG = X_WB * body.geometries[i].X_BG;
      parts_[first + i].X_WG = toFcl(X_WG);
      parts_[first + i].p_WC = X_WG * body.geometries[i].shape.boundingCenter();
    }
  }

  const collision::Scene& scene_;
  std::vector<Part> parts_;
  std::vector<std::size_t> first_;  ///< of each body
  fcl::CollisionRequestd request_;
  bool complete_ = true;
};

class FclStateEngine : public StateEngine {
 public:
  const char* name() const override { return "FCL"; }
  std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const override {
    auto checker = std::make_unique<FclChecker>(scene);
    if (!checker->complete()) return nullptr;
    return checker;
  }
};

}  // namespace

std::unique_ptr<StateEngine> makeFclStateEngine() { return std::make_unique<FclStateEngine>(); }

}  // namespace leeway::tools::report
