#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"
#include "tools/lab/base/mesh_engine.h"

namespace leeway::tools::report {

/// A deforming mesh and its motion.
struct DeformScene {
  std::string motion;  ///< "wave", "twist", ...
  DeformingSpec spec;
  /// Writes the vertices [m] at a time in [0, 1]; one for each of spec.rest.
  std::function<void(double time, std::span<Eigen::Vector3d> vertices)> vertices;
};

/// "wave": travelling waves over a cloth. "lattice": a cloth in a free-form lattice. "twist": a
/// cloth wrung about its middle, vertices from the caller. "morph": a cloth between three shapes.
/// "skinned": a tube that curls on eight bones. "reduced": a cloth in six modes. "cache": the wave
/// as a vertex cache at 25 frames/s, linear in between. "explode": the triangles of a ball fly
/// apart, vertices from the caller.
const std::vector<std::string>& deformMotions();

/// Makes a scene of approximately this number of triangles; the seed varies phases and directions.
/// `motion` is one of deformMotions(). O(triangles).
DeformScene makeDeformScene(const std::string& motion, int triangles, std::uint64_t seed);

/// The query bodies: the twelve links of an arm above the mesh, as capsules and as spheres around
/// their middles, and one link of about a thousand triangles.
struct DeformBodies {
  std::vector<collision::Shape> spheres, capsules;
  collision::Shape mesh = collision::Shape::sphere(0);
  /// X_WL of link i of twelve at a time in [0, 1]: a slow sway, near and far from the mesh.
  collision::Pose linkPose(int i, double time) const;
  /// Pose of the triangle link. place 0: far from the mesh (usually a metre and more), 1: near (a
  /// few decimetres), 2: penetrating.
  collision::Pose meshPose(int place, double time) const;
};
DeformBodies makeDeformBodies();

}  // namespace leeway::tools::report
