#include "tools/report/own_mesh_engine.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/vertex_motion.h"

namespace leeway::tools::report {
namespace {

using collision::Deformable;
using collision::DeformOptions;
using collision::DeformStrategy;
using collision::DeformVolume;
using collision::DistanceRequest;
using collision::Shape;

class OwnFollower : public MeshFollower {
 public:
  OwnFollower(const DeformingSpec& spec, DeformStrategy strategy, DeformVolume volume)
      : deformable_(collision::DeformableMesh::make(spec.rest, spec.triangles), spec.motion,
                    options(strategy, volume)),
        by_motion_(spec.motion &&
                   (strategy == DeformStrategy::kMorph || strategy == DeformStrategy::kSkinned ||
                    strategy == DeformStrategy::kReduced || strategy == DeformStrategy::kAuto)) {
    takeSnapshot();
  }

  void setVertices(std::span<const Eigen::Vector3d> vertices, double time) override {
    time_ = time;
    // Only these look at the motion; the others are spared computing the vertices once more.
    if (by_motion_) {
      deformable_.evaluate(time);
      return;
    }
    const std::span<Eigen::Vector3d> next = deformable_.nextVertices();
    std::copy(vertices.begin(), vertices.end(), next.begin());
  }

  void update() override {
    if (deformable_.commit(time_, std::numeric_limits<double>::infinity(),
                           Deformable::Vertices::kFinite) != collision::UpdateStatus::kUpdated)
      throw std::runtime_error("an update was refused");
    takeSnapshot();
  }

  bool addBody(const Shape& shape) override {
    bodies_.push_back({shape, {}, {}});
    return true;
  }

  double distance(int body, const collision::Pose& X_WB) override {
    Body& b = bodies_[static_cast<std::size_t>(body)];
    return ask(b, X_WB, DistanceRequest{}, b.distance_cache).distance.upper;
  }

  bool isFarther(int body, const collision::Pose& X_WB, double threshold) override {
    Body& b = bodies_[static_cast<std::size_t>(body)];
    DistanceRequest request;
    request.threshold = threshold;
    return ask(b, X_WB, request, b.threshold_cache).distance.lower > threshold;
  }

  double nodesTouched() const override {
    return static_cast<double>(deformable_.statistics().nodes_touched);
  }
  double verticesTouched() const override {
    return static_cast<double>(deformable_.statistics().vertices_touched);
  }

 private:
  struct Body {
    Shape shape;
    collision::PairCache distance_cache, threshold_cache;
  };

  static DeformOptions options(DeformStrategy strategy, DeformVolume volume) {
    DeformOptions result;
    result.strategy = strategy;
    result.volume = volume;
    return result;
  }

  void takeSnapshot() {
    const auto snapshot = deformable_.snapshot();
    collision::prepare(scratch_, *snapshot);
    shape_ = Shape::deformable(snapshot);
  }

  collision::DistanceResult ask(Body& body, const collision::Pose& X_WB, DistanceRequest request,
                                collision::PairCache& cache) {
    request.depth = false;  // rivals tell none
    return collision::distance(shape_, {}, body.shape, X_WB, request, scratch_, &cache);
  }

  Deformable deformable_;
  Shape shape_ = Shape::sphere(0);
  std::vector<Body> bodies_;
  collision::Scratch scratch_;
  bool by_motion_;
  double time_ = 0;
};

class OwnMeshEngine : public MeshEngine {
 public:
  OwnMeshEngine(DeformStrategy strategy, DeformVolume volume)
      : strategy_(strategy),
        volume_(volume),
        name_(std::string("leeway ") + collision::toString(strategy)) {
    if (volume != DeformVolume::kBox) name_ += std::string(" ") + collision::toString(volume);
  }
  const char* name() const override { return name_.c_str(); }
  std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const override {
    try {
      return std::make_unique<OwnFollower>(spec, strategy_, volume_);
    } catch (const std::invalid_argument&) {
      return nullptr;  // not a strategy for this kind of motion
    }
  }

 private:
  DeformStrategy strategy_;
  DeformVolume volume_;
  std::string name_;
};

}  // namespace

std::vector<std::unique_ptr<MeshEngine>> makeOwnMeshEngines() {
  constexpr std::array<DeformStrategy, 11> kAll = {
      DeformStrategy::kRebuild, DeformStrategy::kRebuildLinear, DeformStrategy::kRefit,
      DeformStrategy::kHybrid,  DeformStrategy::kLazy,          DeformStrategy::kMorph,
      DeformStrategy::kSkinned, DeformStrategy::kReduced,       DeformStrategy::kRestructure,
      DeformStrategy::kOctree,  DeformStrategy::kAuto};
  std::vector<std::unique_ptr<MeshEngine>> engines;
  for (const DeformStrategy strategy : kAll) {
    engines.push_back(std::make_unique<OwnMeshEngine>(strategy, DeformVolume::kBox));
    if (strategy != DeformStrategy::kMorph && strategy != DeformStrategy::kReduced) continue;
    for (const DeformVolume volume : {DeformVolume::kDop, DeformVolume::kBall})
      engines.push_back(std::make_unique<OwnMeshEngine>(strategy, volume));
  }
  return engines;
}

}  // namespace leeway::tools::report
