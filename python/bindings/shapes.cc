#include "python/bindings/shapes.h"

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/height_field.h"
#include "leeway/robots/model.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/base/warn.h"

namespace leeway::python {
namespace {

using collision::Shape;

std::string description(const Shape& shape) {
  const std::string name = collision::toString(shape.type());
  const Eigen::Vector3d& h = shape.halfExtents();
  switch (shape.type()) {
    case collision::ShapeType::kSphere:
      return name + " of radius " + text(shape.radius());
    case collision::ShapeType::kCapsule:
    case collision::ShapeType::kCylinder:
    case collision::ShapeType::kCone:
      return name + " of radius " + text(shape.radius()) + ", length " +
             text(2 * shape.halfLength());
    case collision::ShapeType::kBox:
      return name + " of size " + text(2 * h.x()) + " x " + text(2 * h.y()) + " x " +
             text(2 * h.z());
    case collision::ShapeType::kEllipsoid:
      return name + " of semi-axes " + text(h.x()) + ", " + text(h.y()) + ", " + text(h.z());
    case collision::ShapeType::kConvexHull:
      return name + " of " + std::to_string(shape.hull()->vertices().size()) + " vertices";
    case collision::ShapeType::kMesh:
      return name + " of " + std::to_string(shape.mesh()->triangles().size()) + " triangles";
    case collision::ShapeType::kHalfSpace:
    case collision::ShapeType::kDeformable:
      break;
  }
  return name;
}

/// What a list of shapes holds at one place.
collision::Geometry geometryOf(py::handle item, const std::string& name) {
  if (py::isinstance<Shape>(item)) return {item.cast<Shape>(), {}, name};
  if (py::isinstance<py::tuple>(item) && py::len(item) == 2) {
    const auto pair = py::reinterpret_borrow<py::tuple>(item);
    if (py::isinstance<Shape>(pair[0]))
      return {pair[0].cast<Shape>(), givenPose(pair[1], "the shape's pose"), name};
  }
  throw py::type_error(std::string("shapes hold a ") + Py_TYPE(item.ptr())->tp_name +
                       "; a Shape or a pair (Shape, pose) is expected");
}

}  // namespace

Shape box(const py::object& size) { return Shape::box(0.5 * vector3(size, "size")); }
Shape sphere(const py::object& radius) { return Shape::sphere(number(radius, "radius")); }
Shape cylinder(const py::object& radius, const py::object& length) {
  return Shape::cylinder(number(radius, "radius"), 0.5 * number(length, "length"));
}
Shape capsule(const py::object& radius, const py::object& length) {
  return Shape::capsule(number(radius, "radius"), 0.5 * number(length, "length"));
}
Shape cone(const py::object& radius, const py::object& height) {
  return Shape::cone(number(radius, "radius"), 0.5 * number(height, "height"));
}
Shape ellipsoid(const py::object& semi_axes) {
  return Shape::ellipsoid(vector3(semi_axes, "semi_axes"));
}
Shape convexHull(const py::object& given) {
  const std::vector<Eigen::Vector3d> vertices = points(given, "points");
  return released([&] { return Shape::convexHull(vertices); });
}

/// A mesh from a file, or from vertices and triangles.
Shape givenMesh(const py::object& file, const py::object& vertices, const py::object& faces,
                const py::object& scale) {
  if (file.is_none() == (vertices.is_none() || faces.is_none()) ||
      vertices.is_none() != faces.is_none())
    throw py::type_error("a mesh has either a file, or vertices and triangles");
  const Rows given = scalars(scale, "scale");
  if (given.values.size() != 1 && given.values.size() != 3)
    throw py::value_error("scale holds " + std::to_string(given.values.size()) +
                          " numbers; one or three are expected");
  const Eigen::Vector3d factors(given.values.front(), given.values[given.values.size() / 2],
                                given.values.back());
  if ((factors.array() == 0).any())
    throw py::value_error("scale is " +
                          text(factors[factors[0] == 0   ? 0
                                       : factors[1] == 0 ? 1
                                                         : 2]) +
                          "; numbers other than 0 are expected");
  if (!file.is_none()) {
    const std::string path = fileName(file, "file");
    Interrupt interrupt;
    robots::LoadOptions options;
    options.stop = interrupt.callback();
    std::vector<std::string> warnings;
    Shape shape = interrupt.released(
        [&] { return robots::loadMesh(path, factors, "", 0, options, &warnings); });
    for (const std::string& warning : warnings) warn(warning);
    return shape;
  }
  std::vector<Eigen::Vector3d> scaled = points(vertices, "vertices");
  for (Eigen::Vector3d& vertex : scaled) vertex = vertex.cwiseProduct(factors);
  const auto indices = triangles(faces, "triangles");
  return released([&] { return Shape::mesh(collision::TriangleMesh::make(scaled, indices)); });
}

Shape heightField(const py::object& heights, const py::object& step, const py::object& floor) {
  Rows given = scalars(heights, "heights");
  if (given.shape.size() != 2)
    throw py::value_error("heights are expected to be an array of shape (rows, columns)");
  const Rows steps = scalars(step, "step");
  if (steps.values.size() != 1 && steps.values.size() != 2)
    throw py::value_error("step holds " + std::to_string(steps.values.size()) +
                          " numbers; one or two are expected");
  planner::HeightField field{static_cast<std::size_t>(given.shape[1]),
                             static_cast<std::size_t>(given.shape[0]),
                             std::move(given.values),
                             steps.values.front(),
                             steps.values.back(),
                             number(floor, "floor")};
  return released([&] { return planner::heightFieldShape(field); });
}

robots::MeshTreatment meshTreatment(const std::string& solid, double weld) {
  robots::MeshTreatment treatment;
  if (solid == "hull")
    treatment.solid = robots::MeshTreatment::Solid::kHull;
  else if (solid == "surface")
    treatment.solid = robots::MeshTreatment::Solid::kSurface;
  else if (solid != "auto")
    throw py::value_error("solid is '" + solid + "'; 'auto', 'hull' or 'surface' is expected");
  if (!(weld >= 0) || !std::isfinite(weld))
    throw py::value_error("weld is " + std::to_string(weld) +
                          "; a finite length of 0 or more is expected");
  if (weld > 0 && treatment.solid != robots::MeshTreatment::Solid::kAuto)
    throw py::value_error("weld goes with solid='auto' only");
  treatment.weld = weld;
  return treatment;
}

Shape mesh(const py::object& file, const py::object& vertices, const py::object& faces,
           const py::object& scale, const std::string& solid, double weld) {
  const robots::MeshTreatment treatment = meshTreatment(solid, weld);
  const Shape given = givenMesh(file, vertices, faces, scale);
  const bool is_asked = treatment.solid != robots::MeshTreatment::Solid::kAuto || weld > 0;
  return is_asked ? released([&] { return robots::withTreatment(given, treatment); }) : given;
}

void warnIfOpen(std::span<const collision::Geometry> geometries, const std::string& what) {
  std::size_t edges = 0;
  for (const collision::Geometry& geometry : geometries)
    if (geometry.shape.mesh() != nullptr) edges += geometry.shape.mesh()->openEdgeCount();
  if (edges > 0)
    warn(what + " is not closed, it has " + std::to_string(edges) +
         " open edges: where it is open, what is inside is not seen; solid='hull' takes its convex "
         "hull, weld=1e-6 closes cracks of up to a micron, solid='surface' says that it is a "
         "surface");
}

std::vector<collision::Geometry> geometriesOf(const py::object& shapes, const std::string& name) {
  std::vector<collision::Geometry> geometries;
  if (py::isinstance<Shape>(shapes)) {
    geometries.push_back(geometryOf(shapes, name));
    return geometries;
  }
  if (!py::isinstance<py::list>(shapes) && !py::isinstance<py::tuple>(shapes))
    throw py::type_error(std::string("shapes are of type ") + Py_TYPE(shapes.ptr())->tp_name +
                         "; a Shape or a list of them is expected");
  for (const py::handle item : shapes) geometries.push_back(geometryOf(item, name));
  if (geometries.empty()) throw py::value_error("shapes are empty; at least one is expected");
  return geometries;
}

void defineShapes(py::module_& module) {
  py::class_<Shape> shape(module, "Shape",
                          "A body in its own frame: immutable, shared by threads, cheap to copy. "
                          "Made by its static methods; sizes in metres, as in problem files.");
  defineCopiesOfConstant(shape);
  defineStatic(shape, "box", "(size)", "A box of whole edges (x, y, z) [m], middle at the origin.",
               box);
  defineStatic(shape, "sphere", "(radius)", "A sphere [m]; of radius 0 it is a point.", sphere);
  defineStatic(shape, "cylinder", "(radius, length)",
               "A cylinder along z, middle at the origin [m].", cylinder);
  defineStatic(shape, "capsule", "(radius, length)",
               "All within `radius` of a segment of `length` along z, middle at the origin [m].",
               capsule);
  defineStatic(shape, "cone", "(radius, height)",
               "A cone along z: base at -height/2, apex at height/2 [m].", cone);
  defineStatic(shape, "ellipsoid", "(semi_axes)", "An ellipsoid of semi-axes (x, y, z) [m].",
               ellipsoid);
  defineStatic(shape, "half_space", "()", "All below z = 0 of its frame.", Shape::halfSpace);
  defineStatic(shape, "convex_hull", "(points)", "The convex hull of points (n, 3) [m].",
               convexHull);
  defineStatic(shape, "height_field", "(heights, step, floor)",
               "What is below heights (rows, columns) [m], down to `floor` [m]: a sample every "
               "`step` [m], one number or (x, y); columns go along x, rows along y, and the first "
               "sample stands at the origin. Two triangles a cell.",
               heightField);
  defineStatic(shape, "mesh",
               "(file=None, *, vertices=None, triangles=None, scale=1.0, solid='auto', weld=0.0)",
               "A triangle mesh: a file (STL, OBJ, PLY, DAE, glTF), or vertices (n, 3) [m] and "
               "triangles (m, 3) of indices. `scale` is one number or three. What it encloses is "
               "solid; solid='hull': its convex hull is; 'surface': nothing is. `weld` closes "
               "cracks that are at most so wide [m]. A mesh that is not closed is a UserWarning.",
               [](const py::object& file, const py::object& vertices, const py::object& faces,
                  const py::object& scale, const std::string& solid, double weld) {
                 Shape made = mesh(file, vertices, faces, scale, solid, weld);
                 warnIfOpen(std::vector<collision::Geometry>{{made, {}, ""}},
                            file.is_none() ? "the mesh" : "'" + fileName(file, "file") + "'");
                 return made;
               });
  defineConstant(
      shape, "type", [](const Shape& self) { return collision::toString(self.type()); },
      "'sphere', 'capsule', 'box', 'cylinder', 'cone', 'ellipsoid', 'half_space', 'convex_hull', "
      "'mesh' or 'deformable'.");
  defineConstant(shape, "bounding_radius", &Shape::boundingRadius,
                 "Radius of a ball that holds the shape [m].");
  defineConstant(
      shape, "vertices",
      [](const py::object& self) -> py::object {
        const auto& of = self.cast<const Shape&>();
        if (of.mesh() != nullptr) return view(of.mesh()->vertices(), self);
        if (of.hull() != nullptr) return view(of.hull()->vertices(), self);
        return py::none();
      },
      "Vertices of a mesh or hull, without a copy: (n, 3), read-only [m]; else None.");
  defineConstant(
      shape, "triangles",
      [](const py::object& self) -> py::object {
        const auto& of = self.cast<const Shape&>();
        if (of.mesh() != nullptr) return view(of.mesh()->triangles(), self);
        if (of.hull() != nullptr) return view(of.hull()->facets(), self);
        return py::none();
      },
      "Triangles of a mesh, facets of a hull: (m, 3), read-only; else None.");
  shape.def("__repr__",
            [](const Shape& self) { return "<leeway.Shape: " + description(self) + ">"; });
}

}  // namespace leeway::python
