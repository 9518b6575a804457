#pragma once

// Private to planner/: meshes whose vertices keep the order of their file.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "leeway/collision/deformable_mesh.h"

namespace leeway::planner {

struct IndexedMesh {
  std::vector<Eigen::Vector3d> vertices;  // [m]
  std::vector<collision::DeformableMesh::Triangle> triangles;
};

/// The `v` and `f` lines of a Wavefront OBJ, vertices in the order of the file; polygons become
/// fans. (Assimp, which reads rigid meshes, reorders vertices.) Throws robots::InputError with file
/// and line.
IndexedMesh readObj(const std::string& file);

/// A rectangle of `size` in the plane z = 0, its middle at the origin, in cells of two triangles.
/// Vertices row by row, x fastest. All arguments positive.
IndexedMesh gridMesh(double size_x, double size_y, int cells_x, int cells_y);

}  // namespace leeway::planner
