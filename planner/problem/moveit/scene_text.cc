// MoveIt's text format of scenes (.scene), as RViz and PlanningScene::saveGeometryToStream() write
// it: a name, then for each object
//
//   * id
//   x y z / qx qy qz qw     pose of the object: newer files only
//   number of shapes, then for each
//     type and sizes / x y z / qx qy qz qw / r g b a
//   number of subframes, then for each name / x y z / qx qy qz qw: newer files only
//
// and a dot at the end. Poses of shapes are in the object's frame; that frame is in the planning
// frame.

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/text.h"
#include "planner/base/tolerances.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/read_shapes.h"
#include "robots/base/read_file.h"
#include "robots/mesh/mesh_treatment.h"

namespace leeway::planner {
namespace {

using robots::Pose;
using Shape = collision::Shape;

/// Words of a text with their lines.
class Words {
 public:
  Words(std::string file, std::string text) : file_(std::move(file)), text_(std::move(text)) {}

  const std::string& file() const { return file_; }
  int line() const { return line_; }

  [[noreturn]] void fail(const std::string& message) const {
    throw robots::InputError(file_, line_, message);
  }

  /// The rest of this line, without blanks at both ends.
  std::string_view restOfLine() {
    std::size_t end = text_.find('\n', place_);
    if (end == std::string::npos) end = text_.size();
    std::string_view rest = std::string_view(text_).substr(place_, end - place_);
    place_ = end;
    while (!rest.empty() && isBlank(rest.front())) rest.remove_prefix(1);
    while (!rest.empty() && isBlank(rest.back())) rest.remove_suffix(1);
    return rest;
  }

  std::string_view next(std::string_view accepted) {
    skipBlanks();
    if (place_ >= text_.size()) fail(fmt::format("ends early; {} is expected", accepted));
    const std::size_t begin = place_;
    while (place_ < text_.size() && !isBlank(text_[place_])) ++place_;
    return std::string_view(text_).substr(begin, place_ - begin);
  }

  double number(std::string_view accepted) {
    const std::string_view word = next(accepted);
    const std::optional<double> value = robots::parseFinite(std::string(word));
    if (!value)
      fail(fmt::format("'{}' stands where {} is expected", word.substr(0, kShown), accepted));
    return *value;
  }

  /// Reads a count of things that take at least two bytes each. The remaining text bounds it.
  std::size_t count(std::string_view accepted) {
    const double value = number(accepted);
    if (!(value >= 0 && value == std::floor(value) &&
          value <= static_cast<double>(text_.size() - place_)))
      fail(fmt::format("{} stands where {} is expected", value, accepted));
    return static_cast<std::size_t>(value);
  }

  bool atEnd() {
    skipBlanks();
    return place_ >= text_.size();
  }

  /// Whether the next line has several words.
  bool severalOnNextLine() {
    skipBlanks();
    const std::size_t end = std::min(text_.find('\n', place_), text_.size());
    return text_.find_first_of(" \t", place_) < text_.find_last_not_of(" \t\r\n", end);
  }

 private:
  static constexpr std::size_t kShown = 40;  // of a wrong word
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  void skipBlanks() {
    for (; place_ < text_.size() && isBlank(text_[place_]); ++place_)
      if (text_[place_] == '\n') ++line_;
  }

  std::string file_, text_;
  std::size_t place_ = 0;
  int line_ = 1;
};

Eigen::Vector3d readVector(Words& words, std::string_view accepted) {
  const double x = words.number(accepted), y = words.number(accepted), z = words.number(accepted);
  return {x, y, z};
}

Pose readPose(Words& words) {
  Pose pose;
  pose.translation = readVector(words, "x y z of a position [m]");
  Eigen::Vector4d q;
  for (double& value : q) value = words.number("x y z w of a quaternion");
  if (!(std::abs(q.norm() - 1) <= kMendableQuaternion))
    words.fail(fmt::format("a quaternion of length {}; unit length (within {}) is expected",
                           q.norm(), kMendableQuaternion));
  pose.rotation = rotationFromQuaternion(q.normalized());
  return pose;
}

Shape readMesh(Words& words) {
  const std::size_t vertex_count = words.count("a number of vertices");
  const std::size_t triangle_count = words.count("a number of triangles");
  std::vector<Eigen::Vector3d> vertices;
  for (std::size_t i = 0; i < vertex_count; ++i)
    vertices.push_back(readVector(words, "x y z of a vertex [m]"));
  std::vector<collision::TriangleMesh::Triangle> triangles;
  for (std::size_t i = 0; i < triangle_count; ++i) {
    collision::TriangleMesh::Triangle triangle;
    for (std::int32_t& corner : triangle) {
      const double index = words.number("three numbers of vertices");
      if (!(index >= 0 && index < static_cast<double>(vertex_count) && index == std::floor(index)))
        words.fail(fmt::format("triangle {} names vertex {}; 0 to {} is expected", i, index,
                               static_cast<std::int64_t>(vertex_count) - 1));
      corner = static_cast<std::int32_t>(index);
    }
    triangles.push_back(triangle);
  }
  return Shape::mesh(collision::TriangleMesh::make(vertices, triangles));
}

/// Reads a shape, and its pose in the frame that the following lines place. Sizes are full sizes.
std::pair<Shape, Pose> readShape(Words& words) {
  constexpr std::string_view kKinds = "box, sphere, cylinder, cone, plane or mesh";
  const std::string word(words.next(kKinds));
  const auto size = [&] {
    const double value = words.number("a size [m]");
    if (value < 0) words.fail(fmt::format("a size of {}; zero or more is expected", value));
    return value;
  };
  try {
    if (word == "sphere") return {Shape::sphere(size()), Pose()};
    if (word == "box") {
      const double x = size(), y = size(), z = size();
      return {Shape::box(Eigen::Vector3d(x, y, z) / 2), Pose()};
    }
    if (word == "cylinder" || word == "cone") {
      const double radius = size(), length = size();
      return {
          word == "cone" ? Shape::cone(radius, length / 2) : Shape::cylinder(radius, length / 2),
          Pose()};
    }
    if (word == "plane") {
      const Eigen::Vector3d normal = readVector(words, "a b c d of a plane");
      const std::optional<Pose> pose = halfSpacePose(normal, words.number("d of a plane"));
      if (!pose) words.fail("a plane without a usable normal; a, b, c other than 0 are expected");
      return {Shape::halfSpace(), *pose};
    }
    if (word == "mesh") return {readMesh(words), Pose()};
  } catch (const collision::InvalidShape& error) {
    words.fail(fmt::format("a {} that cannot be: {}", word, error.what()));
  }
  words.fail(
      fmt::format("'{}' is no shape that is known; {} is expected", word.substr(0, 40), kKinds));
}

}  // namespace

void readTextScene(const std::string& path, const robots::LoadOptions& load, Problem& problem) {
  Words words(path, robots::readTextFile(path, "a scene as MoveIt saves it"));
  SceneObjects objects(problem);
  words.restOfLine();  // the scene's name
  // Newer files give each object a pose. Either all objects of a file have one or none has.
  std::optional<bool> objects_have_poses;
  while (true) {
    const std::string_view marker = words.next("'*' and an object, or '.' at the end");
    if (marker == ".") {
      if (!words.atEnd())
        words.fail(fmt::format(
            "'{}' stands after the '.' that ends the scene; a scene that ends there is expected",
            words.next("").substr(0, 40)));
      break;
    }
    if (marker != "*")
      words.fail(
          fmt::format("'{}' stands where '*' and an object's name, or '.' at the end, are "
                      "expected: is it a scene that MoveIt has saved as text?",
                      marker.substr(0, 40)));
    const int line = words.line();
    robots::throwIfStopped(load.stop, "objects were read");
    Object object;
    object.name = words.restOfLine();
    if (object.name.empty()) words.fail("an object without a name; '* name' is expected");
    if (!objects_have_poses) objects_have_poses = words.severalOnNextLine();
    if (*objects_have_poses) object.X_WO = readPose(words);
    for (std::size_t left = words.count("a number of shapes"); left > 0; --left) {
      auto [shape, X_SG] = readShape(words);
      const Pose X_OS = readPose(words);
      for (int i = 0; i < 4; ++i) words.number("r g b a of a colour");
      object.geometries.push_back(
          {robots::treatedMesh(shape, {object.name}, load), X_OS * X_SG, object.name});
    }
    if (*objects_have_poses)
      for (std::size_t left = words.count("a number of subframes"); left > 0; --left) {
        words.next("the name of a subframe");
        readPose(words);
      }
    objects.add(path, line, std::move(object));
  }
}

}  // namespace leeway::planner
