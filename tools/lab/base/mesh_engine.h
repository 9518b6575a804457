#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {
class VertexMotion;
}

namespace leeway::tools::report {

/// A deforming mesh at rest.
struct DeformingSpec {
  std::vector<Eigen::Vector3d> rest;  // [m]
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::shared_ptr<const collision::VertexMotion> motion;  ///< null: no motion model, only vertices
};

/// One engine's form of a deforming mesh. Calls marked "off the clock" may copy and allocate.
class MeshFollower {
 public:
  virtual ~MeshFollower() = default;
  /// Passes the next frame's vertices [m]; off the clock.
  virtual void setVertices(std::span<const Eigen::Vector3d> vertices, double time) = 0;
  /// Updates the hierarchy; on the clock.
  virtual void update() = 0;
  /// True if the cost of an update depends on the time since the last one. Such an engine also
  /// follows the frames at which it is not measured.
  virtual bool followsEveryFrame() const { return false; }
  /// Adds a body for later queries; false if the engine has no distance from such a shape. Bodies
  /// are numbered from 0 in order of the successful calls.
  virtual bool addBody(const collision::Shape& shape) = 0;
  /// Minimum distance of body i at X_WB from the mesh [m], <= 0 in contact; on the clock.
  virtual double distance(int body, const collision::Pose& X_WB) = 0;
  /// Whether the distance exceeds `threshold`. By default computed from the distance.
  virtual bool isFarther(int body, const collision::Pose& X_WB, double threshold) {
    return distance(body, X_WB) > threshold;
  }
  /// Nodes that the last update touched; negative if unknown.
  virtual double nodesTouched() const { return -1; }
  virtual double verticesTouched() const { return -1; }
};

class MeshEngine {
 public:
  virtual ~MeshEngine() = default;
  virtual const char* name() const = 0;
  /// Null if the engine does not support such a mesh or motion.
  virtual std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const = 0;
  /// Allowed error of a distance, relative to lengths: single precision or the engine's own
  /// tolerance.
  virtual double tolerance() const { return 1e-6; }
};

}  // namespace leeway::tools::report
