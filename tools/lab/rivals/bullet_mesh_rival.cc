// Bullet's quantised hierarchy over moving vertices.

#include "tools/lab/rivals/bullet_mesh_rival.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

namespace leeway::tools::report {
namespace {

class BulletFollower final : public MeshFollower {
 public:
  BulletFollower(const DeformingSpec& spec, bool refit) : refit_(refit) {
    for (const auto& t : spec.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
    setVertices(spec.rest, 0);
    btIndexedMesh mesh;
    mesh.m_numTriangles = static_cast<int>(spec.triangles.size());
    mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(indices_.data());
    mesh.m_triangleIndexStride = 3 * sizeof(int);
    mesh.m_numVertices = static_cast<int>(vertices_.size());
    mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(vertices_.data());
    mesh.m_vertexStride = sizeof(Eigen::Vector3d);
    mesh.m_indexType = PHY_INTEGER;
    mesh.m_vertexType = PHY_DOUBLE;
    triangles_.addIndexedMesh(mesh);
    shape_ = std::make_unique<btBvhTriangleMeshShape>(&triangles_, true);
  }

  void setVertices(std::span<const Eigen::Vector3d> vertices, double) override {
    if (vertices_.empty()) vertices_.resize(vertices.size());
    std::copy(vertices.begin(), vertices.end(), vertices_.begin());
  }

  void update() override {
    if (refit_) {
      // The quantisation grid is fixed at construction; a mesh that outgrows it triggers warnings
      // and needs a new hierarchy.
      shape_->recalcLocalAabb();
      shape_->refitTree(shape_->getLocalAabbMin(), shape_->getLocalAabbMax());
    } else {
      shape_->buildOptimizedBvh();
      shape_->recalcLocalAabb();
    }
  }

  bool addBody(const collision::Shape&) override { return false; }
  double distance(int, const collision::Pose&) override {
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  std::vector<int> indices_;
  std::vector<Eigen::Vector3d> vertices_;
  btTriangleIndexVertexArray triangles_;
  std::unique_ptr<btBvhTriangleMeshShape> shape_;
  bool refit_;
};

class BulletMeshEngine : public MeshEngine {
 public:
  BulletMeshEngine(const char* name, bool refit) : name_(name), refit_(refit) {}
  const char* name() const override { return name_; }
  std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const override {
    return std::make_unique<BulletFollower>(spec, refit_);
  }

 private:
  const char* name_;
  bool refit_;
};

}  // namespace

std::vector<std::unique_ptr<MeshEngine>> makeBulletMeshEngines() {
  std::vector<std::unique_ptr<MeshEngine>> engines;
  engines.push_back(std::make_unique<BulletMeshEngine>("Bullet refit", true));
  engines.push_back(std::make_unique<BulletMeshEngine>("Bullet rebuild", false));
  return engines;
}

}  // namespace leeway::tools::report
