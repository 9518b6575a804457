// FCL's bounding volume hierarchies over moving vertices: AABBs, and OBBs with swept spheres,
// refitted or rebuilt.

#include "tools/lab/rivals/fcl_mesh_rival.h"

#include <fcl/narrowphase/distance.h>

#include <type_traits>

#include "leeway/collision/triangle_mesh.h"
#include "tools/lab/rivals/fcl_shape_rival.h"

namespace leeway::tools::report {
namespace {

using collision::Shape;
using collision::ShapeType;

template <typename Volume>
class FclFollower : public MeshFollower {
 public:
  FclFollower(const DeformingSpec& spec, bool refit)
      : model_(lab::fclMesh<Volume>(spec.rest, spec.triangles)), refit_(refit) {}

  void setVertices(std::span<const Eigen::Vector3d> vertices, double) override {
    model_->beginReplaceModel();
    model_->replaceSubModel(std::vector<fcl::Vector3d>(vertices.begin(), vertices.end()));
  }
  void update() override { model_->endReplaceModel(refit_, true); }

  bool addBody(const Shape& shape) override {
    // FCL's distance queries need swept spheres; over plain boxes they are too slow to report.
    if constexpr (!std::is_same_v<Volume, fcl::OBBRSSd>) return false;
    switch (shape.type()) {
      case ShapeType::kSphere:
      case ShapeType::kCapsule:
      case ShapeType::kMesh:
        bodies_.push_back(lab::toFcl(shape));
        return true;
      default:
        return false;
    }
  }

  double distance(int body, const collision::Pose& X_WB) override {
    fcl::DistanceResultd result;
    return fcl::distance(model_.get(), fcl::Transform3d::Identity(),
                         bodies_[static_cast<std::size_t>(body)].get(), lab::isometry(X_WB),
                         request_, result);
  }

 private:
  std::shared_ptr<fcl::BVHModel<Volume>> model_;
  std::vector<std::shared_ptr<fcl::CollisionGeometryd>> bodies_;
  fcl::DistanceRequestd request_;
  bool refit_;
};

template <typename Volume>
class FclMeshEngine : public MeshEngine {
 public:
  FclMeshEngine(const char* name, bool refit) : name_(name), refit_(refit) {}
  const char* name() const override { return name_; }
  std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const override {
    // A node takes half a kilobyte and a frame takes seconds, which is too slow to report.
    constexpr std::size_t kMostOriented = 500'000;
    if (std::is_same_v<Volume, fcl::OBBRSSd> && spec.triangles.size() > kMostOriented)
      return nullptr;
    return std::make_unique<FclFollower<Volume>>(spec, refit_);
  }
  double tolerance() const override { return 1e-4; }

 private:
  const char* name_;
  bool refit_;
};

}  // namespace

std::vector<std::unique_ptr<MeshEngine>> makeFclMeshEngines() {
  std::vector<std::unique_ptr<MeshEngine>> engines;
  engines.push_back(std::make_unique<FclMeshEngine<fcl::AABBd>>("FCL AABB refit", true));
  engines.push_back(std::make_unique<FclMeshEngine<fcl::AABBd>>("FCL AABB rebuild", false));
  engines.push_back(std::make_unique<FclMeshEngine<fcl::OBBRSSd>>("FCL OBBRSS refit", true));
  engines.push_back(std::make_unique<FclMeshEngine<fcl::OBBRSSd>>("FCL OBBRSS rebuild", false));
  return engines;
}

}  // namespace leeway::tools::report
