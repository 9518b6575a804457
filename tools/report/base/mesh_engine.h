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

/// A deforming mesh before it moves.
struct DeformingSpec {
  std::vector<Eigen::Vector3d> rest;  // [m]
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::shared_ptr<const collision::VertexMotion> motion;  ///< null: vertices are simply given
};

/// One engine's form of a deforming mesh. Calls off the clock may copy and allocate.
class MeshFollower {
 public:
  virtual ~MeshFollower() = default;
  /// Hands over the next frame's vertices [m]; off the clock.
  virtual void setVertices(std::span<const Eigen::Vector3d> vertices, double time) = 0;
  /// Brings the hierarchy up to date; on the clock, as the update.
  virtual void update() = 0;
  /// Whether an update depends on how long ago the last one was: frames that are not measured
  /// because the engine is slow are then followed all the same.
  virtual bool followsEveryFrame() const { return false; }
  /// Makes room for a body that queries will ask about; false: the engine has no distance from
  /// such a shape. Bodies are numbered from 0 in order of the calls that succeeded.
  virtual bool addBody(const collision::Shape& shape) = 0;
  /// Least distance of body i at X_WB from the mesh [m], 0 or less in contact; on the clock.
  virtual double distance(int body, const collision::Pose& X_WB) = 0;
  /// Whether that is more than `threshold`. Engines without such a query measure the distance.
  virtual bool isFarther(int body, const collision::Pose& X_WB, double threshold) {
    return distance(body, X_WB) > threshold;
  }
  /// What the last update touched; negative: not told.
  virtual double nodesTouched() const { return -1; }
  virtual double verticesTouched() const { return -1; }
};

class MeshEngine {
 public:
  virtual ~MeshEngine() = default;
  virtual const char* name() const = 0;
  /// Null: not for such a mesh or motion.
  virtual std::unique_ptr<MeshFollower> follow(const DeformingSpec& spec) const = 0;
  /// Share of a length that a distance may be off by where the engine computes in single precision
  /// or to a tolerance of its own.
  virtual double tolerance() const { return 1e-6; }
};

}  // namespace leeway::tools::report
