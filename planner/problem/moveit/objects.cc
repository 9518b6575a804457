// Objects of MoveIt's messages (moveit_msgs/CollisionObject, shape_msgs).

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "leeway/collision/triangle_mesh.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/read_shapes.h"
#include "robots/mesh/mesh_path.h"
#include "robots/mesh/mesh_treatment.h"

namespace leeway::planner {
namespace {

using robots::Pose;
using Shape = collision::Shape;

/// Makes a shape. Errors from it become errors at `place`.
template <class Make>
Shape makeShape(const YamlReader& place, const Make& make) {
  try {
    return make();
  } catch (const collision::InvalidShape& error) {
    place.fail(fmt::format("{}: {}", place.where(), error.what()));
  }
}

/// Reads `type` and `dimensions`: full edges for a box; height and radius, in this order, for
/// cylinder and cone.
Shape readPrimitive(const YamlReader& primitive) {
  const YamlReader type = primitive.at("type", "box, sphere, cylinder or cone");
  const YamlReader sizes = primitive.at("dimensions", "a list of numbers");
  const std::string word = type.text();  // by name, or by the number of shape_msgs
  const bool box = word == "box" || word == "1", sphere = word == "sphere" || word == "2",
             cylinder = word == "cylinder" || word == "3", cone = word == "cone" || word == "4";
  if (!box && !sphere && !cylinder && !cone)
    type.fail(
        fmt::format("{} is '{}'; box, sphere, cylinder or cone is expected", type.where(), word));
  const std::size_t count = box ? 3 : sphere ? 1 : 2;
  std::vector<double> d;
  for (const YamlReader& size : sizes.items()) d.push_back(size.sizeNumber());
  if (d.size() != count)
    sizes.fail(fmt::format("{} is a list of {} for a {}; {} expected", sizes.where(), d.size(),
                           word,
                           box      ? "the three edges are"
                           : sphere ? "the radius is"
                                    : "height and radius are"));
  return makeShape(sizes, [&] {
    if (box) return Shape::box(Eigen::Vector3d(d[0], d[1], d[2]) / 2);
    if (sphere) return Shape::sphere(d[0]);
    // MoveIt's cone has its apex at +z and its origin at half the height, like ours.
    return cylinder ? Shape::cylinder(d[1], d[0] / 2) : Shape::cone(d[1], d[0] / 2);
  });
}

/// Reads points and triangles of their indices: shape_msgs/Mesh. Robowflex and MotionBenchMaker
/// instead write `resource`, a file by its package, path or URI, and `dimensions`, its scale.
Shape readSceneMesh(const YamlReader& mesh, std::vector<std::string>& warnings,
                    const robots::LoadOptions& load) {
  const auto dimensions = mesh.find("dimensions");
  const Eigen::Vector3d scale = dimensions ? dimensions->vector3() : Eigen::Vector3d::Ones();
  if (const auto resource = mesh.find("resource")) {
    for (const char* key : {"vertices", "triangles"})
      if (const auto own = mesh.find(key); hasContent(own))
        own->fail(
            fmt::format("{} stands beside 'resource'; one of them is expected", own->where()));
    return robots::loadMesh(
        robots::resolveMesh(resource->text(), resource->file(), resource->line(), load), scale,
        resource->file(), resource->line(), load, &warnings);
  }
  if (scale != Eigen::Vector3d::Ones())
    dimensions->fail(
        fmt::format("{} is the scale of a 'resource', which is missing; vertices [m] "
                    "without a scale are expected",
                    dimensions->where()));
  const YamlReader points = mesh.at("vertices", "a list of points [m]");
  const YamlReader faces = mesh.at("triangles", "a list of three vertex_indices each");
  std::vector<Eigen::Vector3d> vertices;
  for (const YamlReader& point : points.items()) vertices.push_back(readMoveitVector(point));
  std::vector<collision::TriangleMesh::Triangle> triangles;
  for (const YamlReader& face : faces.items()) {
    const YamlReader indices =
        face.isMap() ? face.at("vertex_indices", "three numbers of vertices") : face;
    const std::vector<YamlReader> corners = indices.items();
    if (corners.size() != 3)
      indices.fail(fmt::format("{} is a list of {}; three numbers of vertices are expected",
                               indices.where(), corners.size()));
    collision::TriangleMesh::Triangle triangle;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int64_t index = corners[i].integer(0);
      if (index >= static_cast<std::int64_t>(vertices.size()))
        corners[i].fail(fmt::format("{} is {}; a vertex from 0 to {} is expected",
                                    corners[i].where(), index,
                                    static_cast<std::int64_t>(vertices.size()) - 1));
      triangle[i] = static_cast<std::int32_t>(index);
    }
    triangles.push_back(triangle);
  }
  return makeShape(mesh,
                   [&] { return Shape::mesh(collision::TriangleMesh::make(vertices, triangles)); });
}

/// X_PH of a plane a x + b y + c z + d = 0 in P: z of H is its normal. A half-space fills z <= 0.
Pose readPlane(const YamlReader& plane) {
  const YamlReader list = plane.at("coef", "a, b, c, d of a x + b y + c z + d = 0");
  const std::vector<double> coef = list.numbers();
  if (coef.size() != 4)
    list.fail(
        fmt::format("{} is a list of {}; four numbers are expected", list.where(), coef.size()));
  const std::optional<Pose> pose = halfSpacePose({coef[0], coef[1], coef[2]}, coef[3]);
  if (!pose)
    list.fail(
        fmt::format("{} has no usable normal; a, b, c other than 0 are expected", list.where()));
  return *pose;
}

/// Reads the shapes of one key with their poses. As in MoveIt, shapes without a pose, which are the
/// last ones, are at the object's pose.
template <class Read>
void readShapes(const YamlReader& map, const char* key, const char* poses_key, Object& object,
                std::vector<std::string>& warnings, const Read& read) {
  const auto list = map.find(key), poses = map.find(poses_key);
  const std::size_t count = hasContent(list) ? list->items().size() : 0;
  const std::size_t pose_count = hasContent(poses) ? poses->items().size() : 0;
  if (pose_count > count)
    poses->fail(fmt::format("object '{}' has {} {} and {} {}; at most one for each is expected",
                            object.name, count, key, pose_count, poses_key));
  if (pose_count > 0 && pose_count < count)
    warnings.push_back(fmt::format(
        "{}:{}: object '{}' has {} {} and {} {}: the last {} at the object's pose", map.file(),
        poses->line(), object.name, count, key, pose_count, poses_key,
        count - pose_count == 1 ? "stands" : fmt::format("{} stand", count - pose_count)));
  if (count > 0 && pose_count == 0 && !map.has("pose"))
    warnings.push_back(fmt::format(
        "{}:{}: object '{}' has neither pose nor {}: it stands at the origin of its frame",
        map.file(), map.line(), object.name, poses_key));
  if (count == 0) return;
  const std::vector<YamlReader> shapes = list->items();
  const std::vector<YamlReader> places =
      pose_count > 0 ? poses->items() : std::vector<YamlReader>();
  for (std::size_t i = 0; i < count; ++i) {
    Pose X_OP;
    if (i < places.size()) X_OP = readMoveitPose(places[i], "position", "orientation", warnings);
    const auto [shape, X_PG] = read(shapes[i]);
    object.geometries.push_back({shape, X_OP * X_PG, object.name});
  }
}

}  // namespace

std::optional<Pose> halfSpacePose(const Eigen::Vector3d& normal, double offset) {
  const double length = normal.stableNorm();
  if (!(length > std::numeric_limits<double>::min()) || !std::isfinite(length)) return std::nullopt;
  Pose pose;
  const Eigen::Vector3d n = normal / length;
  Eigen::Vector3d u, v;
  robots::planeAxes(n, u, v);
  pose.rotation << u, v, n;
  pose.translation = -offset / length * n;
  if (!pose.translation.allFinite()) return std::nullopt;
  return pose;
}

Object readCollisionObject(const YamlReader& map, const robots::LoadOptions& load,
                           std::vector<std::string>& warnings) {
  robots::throwIfStopped(load.stop, "objects were read");
  const YamlReader id = map.at("id", "the object's name");
  if (const auto operation = map.find("operation");
      hasContent(operation) && operation->text() != "0" && operation->text() != "add")
    operation->fail(fmt::format("{} is '{}'; only objects that are added (0) are expected",
                                operation->where(), operation->text()));
  Object object;
  object.name = id.text();
  if (const auto pose = map.find("pose"))
    object.X_WO = readMoveitPose(*pose, "position", "orientation", warnings);
  readShapes(map, "primitives", "primitive_poses", object, warnings,
             [](const YamlReader& shape) { return std::pair(readPrimitive(shape), Pose()); });
  readShapes(map, "meshes", "mesh_poses", object, warnings, [&](const YamlReader& mesh) {
    return std::pair(readSceneMesh(mesh, warnings, load), Pose());
  });
  readShapes(map, "planes", "plane_poses", object, warnings, [](const YamlReader& plane) {
    return std::pair(Shape::halfSpace(), readPlane(plane));
  });
  // As in MoveIt, an object of one shape without a pose stands where its shape does. Frames that
  // name it refer to that.
  const bool has_pose = object.X_WO.rotation != Eigen::Matrix3d::Identity() ||
                        object.X_WO.translation != Eigen::Vector3d::Zero();
  if (!has_pose && object.geometries.size() == 1 && !hasContent(map.find("planes")))
    std::swap(object.X_WO, object.geometries[0].X_BG);
  for (collision::Geometry& g : object.geometries)
    g.shape = robots::treatedMesh(g.shape, {object.name}, load);
  return object;
}

}  // namespace leeway::planner
