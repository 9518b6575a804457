#include "planner/problem/read_shapes.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/height_field.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/model.h"
#include "planner/base/tolerances.h"
#include "planner/validate/format_keys.h"
#include "robots/base/files_read.h"
#include "robots/mesh/mesh_path.h"
#include "robots/mesh/mesh_treatment.h"

namespace leeway::planner {
namespace {

using collision::Geometry;
using collision::Pose;
using collision::Shape;

std::string listed(std::span<const std::string_view> words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + std::string(words[i]);
  return text;
}

Shape readMesh(const YamlReader& mesh, const std::string& owner, std::vector<std::string>& warnings,
               const robots::LoadOptions& load) {
  const YamlReader file = mesh.at("file", "a mesh file (STL, OBJ, PLY, DAE, glTF)");
  const Shape shape = robots::loadMesh(meshPath(file, load, warnings), readScale(mesh), file.file(),
                                       file.line(), load, &warnings);
  return robots::treatedMesh(shape, {owner, file.text()}, load);
}

Shape readConvexHull(const YamlReader& hull, const std::string& owner,
                     std::vector<std::string>& warnings, const robots::LoadOptions& load) {
  const auto points = hull.find("points");
  if (points.has_value() == hull.has("file"))
    hull.fail(fmt::format("{} has {}; either is expected", hull.where(),
                          points ? "both 'points' and 'file'" : "neither 'points' nor 'file'"));
  if (!points) {
    robots::LoadOptions plain = load;  // `meshes` is about meshes: a hull of one is none
    plain.meshes.clear();
    const Shape mesh = readMesh(hull, owner, warnings, plain);
    return mesh.mesh() != nullptr ? Shape::convexHull(mesh.mesh()->vertices()) : mesh;
  }
  if (const auto scale = hull.find("scale"))
    scale->fail(fmt::format("{} goes with 'file' only", scale->where()));
  std::vector<Eigen::Vector3d> vertices;
  for (const YamlReader& point : points->items()) vertices.push_back(point.vector3());
  if (vertices.empty())
    points->fail(fmt::format("{} is empty; at least one point is expected", points->where()));
  return Shape::convexHull(vertices);
}

Shape readHeightField(const YamlReader& map, std::vector<std::string>& warnings,
                      const robots::Stop& stop) {
  const YamlReader file = map.at("file", "a file of heights (CSV, PNG, PGM)");
  HeightFile read;
  if (const auto scale = map.find("scale")) read.scale = scale->number();
  if (const auto offset = map.find("offset")) read.offset = offset->number();
  if (const auto missing = map.find("missing")) read.missing = missing->number();
  const YamlReader step = map.at("step", "from one sample to the next [m], a number or [x, y]");
  const std::vector<double> steps =
      step.isList() ? step.numbers() : std::vector<double>(2, step.number());
  if (steps.size() != 2)
    step.fail(fmt::format("{} is a list of {}; a number or [x, y] in m is expected", step.where(),
                          steps.size()));
  const double floor = map.at("floor", "the height below which nothing is solid [m]").number();
  HeightField field;
  try {
    field = loadHeightField(resolvedPath(file), read, warnings, stop);
  } catch (const std::invalid_argument& error) {
    map.fail(fmt::format("{}: {}", map.where(), error.what()));
  }
  field.step_x = steps[0];
  field.step_y = steps[1];
  field.floor = floor;
  return heightFieldShape(field);
}

Shape readShape(std::string_view word, const YamlReader& sizes, const std::string& owner,
                std::vector<std::string>& warnings, const robots::LoadOptions& load) {
  if (word != "half_space" || !sizes.isNull()) sizes.expectKeys(keysOf(word));
  if (word == "half_space") return Shape::halfSpace();
  const auto radius = [&] { return sizes.at("radius", "a number [m]").sizeNumber(); };
  if (word == "box")
    return Shape::box(sizes.at("size", "the three edges [x, y, z] in m").sizeVector3() / 2);
  if (word == "sphere") return Shape::sphere(radius());
  if (word == "cylinder")
    return Shape::cylinder(radius(), sizes.at("length", "a number [m]").sizeNumber() / 2);
  if (word == "capsule")
    return Shape::capsule(radius(), sizes.at("length", "a number [m]").sizeNumber() / 2);
  if (word == "cone")
    return Shape::cone(radius(), sizes.at("height", "a number [m]").sizeNumber() / 2);
  if (word == "ellipsoid")
    return Shape::ellipsoid(sizes.at("semi_axes", "three numbers [m]").sizeVector3());
  if (word == "mesh") return readMesh(sizes, owner, warnings, load);
  if (word == "convex_hull") return readConvexHull(sizes, owner, warnings, load);
  if (word == "height_field") return readHeightField(sizes, warnings, load.stop);
  throw std::logic_error("no reader for the shape: " + std::string(word));
}

/// The key of the map that is a shape; empty if it has none. Fails if it has two.
std::string_view shapeWord(const YamlReader& map) {
  std::string_view found;
  for (const std::string_view word : shapeWords()) {
    if (!map.has(word)) continue;
    if (!found.empty())
      map.fail(fmt::format(
          "{} has both '{}' and '{}'; one shape is expected (several go under 'shapes')",
          map.where(), found, word));
    found = word;
  }
  return found;
}

Shape readOneShape(const YamlReader& map, std::string_view word, const std::string& owner,
                   std::vector<std::string>& warnings, const robots::LoadOptions& load) {
  robots::throwIfStopped(load.stop, "objects were read");
  const YamlReader sizes = map.at(word, "its sizes");
  try {
    return readShape(word, sizes, owner, warnings, load);
  } catch (const collision::InvalidShape& error) {
    sizes.fail(fmt::format("{}: {}", sizes.where(), error.what()));
  }
}

bool isUri(const std::string& path) { return path.find("://") != std::string::npos; }

}  // namespace

Eigen::Matrix3d rotationFromQuaternion(const Eigen::Vector4d& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  Eigen::Matrix3d rotation;
  rotation << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),          //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return rotation;
}

Eigen::Vector4d quaternionFromRpy(const Eigen::Vector3d& rpy) {
  double sr, cr, sp, cp, sy, cy;
  collision::sineCosine(rpy[0] / 2, sr, cr);
  collision::sineCosine(rpy[1] / 2, sp, cp);
  collision::sineCosine(rpy[2] / 2, sy, cy);
  const Eigen::Vector4d q(sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
                          cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy);
  return q / std::sqrt(q.dot(q));
}

Eigen::Vector4d readQuaternion(const YamlReader& reader, std::vector<std::string>& warnings) {
  return unitQuaternion(reader, reader.numbers(), warnings);
}

Eigen::Vector4d unitQuaternion(const YamlReader& reader, const std::vector<double>& v,
                               std::vector<std::string>& warnings) {
  if (v.size() != 4)
    reader.fail(fmt::format("{} is a list of {}; a quaternion [x, y, z, w] is expected",
                            reader.where(), v.size()));
  const double norm = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
  const double off = std::abs(norm - 1);
  if (!(off <= kMendableQuaternion))
    reader.fail(fmt::format("{} is a quaternion of length {}; unit length (within {}) is expected",
                            reader.where(), norm, kMendableQuaternion));
  if (off > kSilentQuaternion)
    warnings.push_back(fmt::format("{}:{}: {} is a quaternion of length {}, taken as normalised",
                                   reader.file(), reader.line(), reader.where(), norm));
  return Eigen::Vector4d(v[0], v[1], v[2], v[3]) / norm;
}

Eigen::Vector4d readOrientation(const YamlReader& map, std::vector<std::string>& warnings) {
  const auto orientation = map.find("orientation");
  const auto rpy = map.find("rpy");
  if (orientation && rpy)
    rpy->fail(fmt::format("{} has both 'orientation' and 'rpy'; one is expected", map.where()));
  if (orientation) return readQuaternion(*orientation, warnings);
  if (!rpy) return Eigen::Vector4d::UnitW();
  const Eigen::Vector3d angles = rpy->vector3();
  if (angles.cwiseAbs().maxCoeff() > kLargestAngle)
    rpy->fail(fmt::format("{} holds an angle of {}; at most {} rad is expected", rpy->where(),
                          angles.cwiseAbs().maxCoeff(), kLargestAngle));
  return quaternionFromRpy(angles);
}

Pose readPose(const YamlReader& map, std::vector<std::string>& warnings) {
  Pose pose;
  if (const auto position = map.find("position")) {
    pose.translation = position->vector3();
    if (const double farthest = pose.translation.cwiseAbs().maxCoeff();
        farthest > collision::kLargestSize)
      position->fail(fmt::format("{} holds {}; coordinates up to {} m are expected",
                                 position->where(), farthest, collision::kLargestSize));
  }
  pose.rotation = rotationFromQuaternion(readOrientation(map, warnings));
  return pose;
}

Geometry readGeometry(const YamlReader& map, const std::string& name,
                      std::vector<std::string>& warnings, const robots::LoadOptions& load) {
  map.expectKeys(keysOf("shape"));
  const std::string_view word = shapeWord(map);
  if (word.empty())
    map.fail(fmt::format("{} has no shape; {} is expected", map.where(), listed(shapeWords())));
  const auto own_name = map.find("name");
  return {readOneShape(map, word, name, warnings, load), readPose(map, warnings),
          own_name ? own_name->text() : name};
}

std::vector<Geometry> readGeometries(const YamlReader& map, const std::string& owner,
                                     std::vector<std::string>& warnings,
                                     const robots::LoadOptions& load) {
  const std::string_view word = shapeWord(map);
  const auto shapes = map.find("shapes");
  if (shapes && !word.empty())
    map.fail(fmt::format("{} has both 'shapes' and '{}'; one is expected", map.where(), word));
  std::vector<Geometry> geometries;
  if (shapes) {
    if (shapes->items().empty())
      shapes->fail(fmt::format("{} is empty; at least one shape is expected", shapes->where()));
    shapes->eachItem([&](const YamlReader& shape) {
      geometries.push_back(readGeometry(shape, owner, warnings, load));
    });
    return geometries;
  }
  if (word.empty())
    map.fail(fmt::format("{} has no shape; {} or 'shapes' is expected", map.where(),
                         listed(shapeWords())));
  geometries.push_back({readOneShape(map, word, owner, warnings, load), Pose(), owner});
  return geometries;
}

std::array<double, 3> readColor(const YamlReader& color) {
  const std::vector<double> v = color.isList() ? color.numbers() : std::vector<double>();
  if (v.size() != 3)
    color.fail(fmt::format("{} is {}; [red, green, blue], each from 0 to 1, is expected",
                           color.where(),
                           color.isList() ? fmt::format("a list of {}", v.size()) : "no list"));
  for (const double share : v)
    if (!(share >= 0 && share <= 1))
      color.fail(
          fmt::format("{} holds {}; numbers from 0 to 1 are expected", color.where(), share));
  return {v[0], v[1], v[2]};
}

Eigen::Vector3d readScale(const YamlReader& map) {
  const auto scale = map.find("scale");
  if (!scale) return Eigen::Vector3d::Ones();
  Eigen::Vector3d factors = scale->isList()
                                ? scale->vector3()
                                : Eigen::Vector3d(Eigen::Vector3d::Constant(scale->number()));
  if ((factors.array() == 0).any())
    scale->fail(fmt::format("{} holds a zero; other factors are expected", scale->where()));
  return factors;
}

std::string resolvedPath(const YamlReader& reader) {
  if (reader.isEmpty())
    reader.fail(
        fmt::format("{} is empty; the path of a file is expected, or no such key", reader.where()));
  const std::filesystem::path path = reader.text();
  if (isUri(path.string()))
    reader.fail(
        fmt::format("{} is '{}'; a path is expected, because only the files of meshes are "
                    "found by package://",
                    reader.where(), path.string()));
  std::string found = path.string();
  if (!path.is_absolute())
    found = (std::filesystem::path(reader.file()).parent_path() / path).lexically_normal().string();
  robots::FilesRead::note(found);
  return found;
}

std::string meshPath(const YamlReader& reader, const robots::LoadOptions& load,
                     std::vector<std::string>& warnings) {
  if (reader.isEmpty() || !isUri(reader.text())) return resolvedPath(reader);
  return robots::resolveMesh(reader.text(), reader.file(), reader.line(), load, &warnings);
}

}  // namespace leeway::planner
