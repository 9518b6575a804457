#pragma once

#include <span>
#include <string>
#include <vector>

#include "leeway/collision/distance.h"
#include "leeway/collision/scene.h"
#include "leeway/collision/shape.h"
#include "leeway/robots/model.h"
#include "python/base/arrays.h"

namespace leeway::python {

// Sizes as in problem files. Throw collision::InvalidShape, robots::InputError or ValueError.
collision::Shape box(const py::object& size);
collision::Shape sphere(const py::object& radius);
collision::Shape cylinder(const py::object& radius, const py::object& length);
collision::Shape capsule(const py::object& radius, const py::object& length);
collision::Shape cone(const py::object& radius, const py::object& height);
collision::Shape ellipsoid(const py::object& semi_axes);
collision::Shape convexHull(const py::object& points);
/// Heights (rows, columns), a step of one number or two, and the floor.
collision::Shape heightField(const py::object& heights, const py::object& step,
                             const py::object& floor);
/// From a file, or from vertices and triangles.
collision::Shape mesh(const py::object& file, const py::object& vertices,
                      const py::object& triangles, const py::object& scale,
                      const std::string& solid, double weld);
/// Warns of meshes that are not closed. `what`: they, for the text.
void warnIfOpen(std::span<const collision::Geometry> geometries, const std::string& what);
/// Returns the treatment of a mesh that keywords give. Throws ValueError.
robots::MeshTreatment meshTreatment(const std::string& solid, double weld);

/// A shape, or a list of shapes or pairs (shape, pose). `name` is that of the geometries.
std::vector<collision::Geometry> geometriesOf(const py::object& shapes, const std::string& name);

void defineShapes(py::module_& module);
void defineDistances(py::module_& module);

/// The calling thread's buffers for queries.
collision::Scratch& threadScratch();

}  // namespace leeway::python
