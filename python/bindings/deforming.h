#pragma once

#include <memory>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/vertex_motion.h"
#include "python/base/arrays.h"

namespace leeway::python {

/// Where the vertices of a mesh are at any time.
struct Motion {
  std::shared_ptr<const collision::VertexMotion> value;
};

std::shared_ptr<const collision::DeformableMesh> deformableMesh(const py::object& vertices,
                                                                const py::object& triangles);
/// Null for None.
std::shared_ptr<const collision::VertexMotion> motionOf(const py::object& motion);
/// A bound on a speed [m/s or rad/s]; infinite for None.
double speedBoundOf(const py::object& value, const char* name = "speed_bound");
collision::DeformStrategy strategyOf(const py::object& word);

void defineDeforming(py::module_& module);

}  // namespace leeway::python
