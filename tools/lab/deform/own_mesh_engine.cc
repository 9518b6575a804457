#include "tools/lab/deform/own_mesh_engine.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "collision/base/numbers.h"
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

/// Information about the motion that an engine uses in addition to each frame's vertices.
enum class Knows { kNothing, kMotion };

class OwnFollower : public MeshFollower {
 public:
  OwnFollower(const DeformingSpec& spec, DeformStrategy strategy, DeformVolume volume, Knows knows)
      : deformable_(collision::DeformableMesh::make(spec.rest, spec.triangles), spec.motion,
                    options(strategy, volume)),
        knows_(spec.motion ? knows : Knows::kNothing) {
    takeSnapshot();
  }

  void setVertices(std::span<const Eigen::Vector3d> vertices, double time) override {
    time_ = time;
    // Only these use the motion; the others skip a second evaluation of the vertices.
    if (knows_ == Knows::kMotion) {
      deformable_.evaluate(time);
      return;
    }
    const std::span<Eigen::Vector3d> next = deformable_.nextVertices();
    std::copy(vertices.begin(), vertices.end(), next.begin());
  }

  void update() override {
    if (deformable_.commit(time_, kInfinity, Deformable::Vertices::kFinite) !=
        collision::UpdateStatus::kUpdated)
      throw std::runtime_error("an update was refused");
    takeSnapshot();
  }

  // Bounds on the motion hold from one update to the next.
  bool followsEveryFrame() const override {
    return knows_ == Knows::kMotion && deformable_.options().strategy == DeformStrategy::kHybrid;
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
    request.depth = false;  // rivals have no depth
    return collision::distance(shape_, {}, body.shape, X_WB, request, scratch_, &cache);
  }

  Deformable deformable_;
  Shape shape_ = Shape::sphere(0);
  std::vector<Body> bodies_;
  collision::Scratch scratch_;
  Knows knows_;
  double time_ = kInfinity;
};

class OwnMeshEngine : public MeshEngine {
 public:
  OwnMeshEngine(DeformStrategy strategy, DeformVolume volume, Knows knows)
      : strategy_(strategy),
        volume_(volume),
        knows_(knows),
        name_(std::string("leeway ") + collision::toString(strategy)) {
    if (volume != DeformVolume::kBox) name_ += std::string(" ") + collision::toString(volume);
    if (strategy == DeformStrategy::kHybrid && knows == Knows::kMotion) name_ += " moved";
  }
  const char* name() const override { return name_.c_str(); }
  std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const override {
    if (strategy_ == DeformStrategy::kHybrid && knows_ == Knows::kMotion && !spec.motion)
      return nullptr;
    try {
      return std::make_unique<OwnFollower>(spec, strategy_, volume_, knows_);
    } catch (const std::invalid_argument&) {
      return nullptr;  // strategy does not apply to this kind of motion
    }
  }

 private:
  DeformStrategy strategy_;
  DeformVolume volume_;
  Knows knows_;
  std::string name_;
};

}  // namespace

std::vector<std::unique_ptr<MeshEngine>> makeOwnMeshEngines() {
  std::vector<std::unique_ptr<MeshEngine>> engines;
  const auto add = [&](DeformStrategy strategy, Knows knows = Knows::kNothing,
                       DeformVolume volume = DeformVolume::kBox) {
    engines.push_back(std::make_unique<OwnMeshEngine>(strategy, volume, knows));
  };
  add(DeformStrategy::kRebuild);
  add(DeformStrategy::kRebuildLinear);
  add(DeformStrategy::kRefit);
  add(DeformStrategy::kHybrid);
  add(DeformStrategy::kHybrid, Knows::kMotion);
  add(DeformStrategy::kLazy);
  for (const DeformVolume volume : {DeformVolume::kBox, DeformVolume::kDop, DeformVolume::kBall})
    add(DeformStrategy::kMorph, Knows::kMotion, volume);
  add(DeformStrategy::kSkinned, Knows::kMotion);
  for (const DeformVolume volume : {DeformVolume::kBox, DeformVolume::kDop, DeformVolume::kBall})
    add(DeformStrategy::kReduced, Knows::kMotion, volume);
  add(DeformStrategy::kRestructure);
  add(DeformStrategy::kOctree);
  add(DeformStrategy::kAuto, Knows::kMotion);
  return engines;
}

}  // namespace leeway::tools::report
