#include "planner/problem/read_deforming.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "planner/base/did_you_mean.h"
#include "planner/problem/read_motion.h"
#include "planner/problem/read_shapes.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"
#include "planner/validate/names.h"
#include "robots/mesh/mesh_treatment.h"

namespace leeway::planner {
namespace {

using collision::Deformable;
using collision::DeformableMesh;
using collision::DeformOptions;
using collision::DeformStrategy;
using collision::DeformVolume;
using robots::IndexedMesh;

/// The words of an enumeration up to its last value.
template <typename Enum>
std::vector<std::string> wordsOf(Enum last) {
  std::vector<std::string> words;
  for (int i = 0; i <= static_cast<int>(last); ++i)
    words.emplace_back(collision::toString(static_cast<Enum>(i)));
  return words;
}

DeformOptions readOptions(const YamlReader& entry) {
  DeformOptions options;
  if (const auto strategy = entry.find("strategy")) {
    const auto known = collision::deformStrategy(strategy->text());
    if (!known)
      strategy->fail(fmt::format("strategy '{}' is unknown{}", strategy->text(),
                                 didYouMean(strategy->text(), wordsOf(DeformStrategy::kOctree))));
    options.strategy = *known;
  }
  if (const auto given = entry.find("options")) {
    given->expectKeys(keysOf("deform_options"));
    if (const auto volume = given->find("volume")) {
      const auto known = collision::deformVolume(volume->text());
      if (!known)
        volume->fail(fmt::format("volume '{}' is unknown{}", volume->text(),
                                 didYouMean(volume->text(), wordsOf(DeformVolume::kBall))));
      options.volume = *known;
    }
    if (const auto split = given->find("hybrid_split"))
      options.hybrid_split = static_cast<int>(std::min<std::int64_t>(split->integer(0), 1 << 30));
    if (const auto factor = given->find("restructure_factor")) {
      options.restructure_factor = factor->number();
      if (!(options.restructure_factor > 1))
        factor->fail(fmt::format("{} is {}; a number above 1 is expected", factor->where(),
                                 options.restructure_factor));
    }
    if (const auto queries = given->find("expected_queries"))
      options.expected_queries =
          static_cast<int>(std::min<std::int64_t>(queries->integer(0), 1 << 30));
  }
  return options;
}

/// A rectangle of the given size in the plane z = 0 with its middle at the origin. Each cell has
/// two triangles. Vertices go row by row, x fastest. All arguments are positive.
IndexedMesh gridMesh(double size_x, double size_y, int cells_x, int cells_y) {
  IndexedMesh mesh;
  for (int j = 0; j <= cells_y; ++j)
    for (int i = 0; i <= cells_x; ++i)
      mesh.vertices.emplace_back(size_x * (static_cast<double>(i) / cells_x - 0.5),
                                 size_y * (static_cast<double>(j) / cells_y - 0.5), 0);
  for (int j = 0; j < cells_y; ++j)
    for (int i = 0; i < cells_x; ++i) {
      const std::int32_t a = j * (cells_x + 1) + i, b = a + 1, c = a + cells_x + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

IndexedMesh readRestMesh(const YamlReader& entry, const robots::LoadOptions& load) {
  const auto grid = entry.find("grid"), mesh = entry.find("mesh");
  if (grid.has_value() == mesh.has_value())
    entry.fail(fmt::format("{} has {}; one of them is expected", entry.where(),
                           grid ? "both 'grid' and 'mesh'" : "neither 'grid' nor 'mesh'"));
  if (mesh) {
    mesh->expectKeys(keysOf("mesh"));
    return readVertices(*mesh, load);
  }
  grid->expectKeys(keysOf("grid"));
  const YamlReader size = grid->at("size", "[x, y] in m"), cells = grid->at("cells", "[x, y]");
  const std::vector<double> s = size.numbers();
  if (s.size() != 2 || !(s[0] > 0 && s[1] > 0))
    size.fail(fmt::format("{} is not [x, y] with two numbers above 0", size.where()));
  const std::vector<YamlReader> c = cells.items();
  if (c.size() != 2)
    cells.fail(fmt::format("{} is a list of {}; [x, y] is expected", cells.where(), c.size()));
  const std::int64_t x = c[0].integer(1), y = c[1].integer(1);
  if (x > kMostGridCells / y)
    cells.fail(fmt::format("{} makes more than {} cells; fewer are expected", cells.where(),
                           kMostGridCells));
  return gridMesh(s[0], s[1], static_cast<int>(x), static_cast<int>(y));
}

/// Whether `meshes` keeps the space that the obstacle encloses solid.
bool isSolid(const YamlReader& name, const robots::LoadOptions& load) {
  const robots::MeshTreatment* treatment = robots::treatmentOf(load, {name.text()});
  if (treatment == nullptr) return true;
  if (treatment->solid == robots::MeshTreatment::Solid::kHull || treatment->weld > 0)
    name.fail(
        fmt::format("'{}' deforms, and meshes.{} asks for a hull or a weld; solid: auto or "
                    "surface is expected",
                    name.text(), name.text()));
  return treatment->solid == robots::MeshTreatment::Solid::kAuto;
}

}  // namespace

DeformingObstacle makeDeformingObstacle(std::string name,
                                        std::shared_ptr<const DeformableMesh> mesh,
                                        std::shared_ptr<const collision::VertexMotion> motion,
                                        const robots::Pose& X_WO, double time,
                                        const DeformOptions& options, double speed_bound) {
  if (!mesh) throw std::invalid_argument("deforming obstacle '" + name + "': a mesh is expected");
  if (!(speed_bound >= 0))
    throw std::invalid_argument(
        fmt::format("deforming obstacle '{}': the speed bound is {}; at least 0 m/s is expected",
                    name, speed_bound));
  Deformable deformable(mesh, motion, options);
  const auto status = motion ? deformable.update(time) : deformable.update(mesh->rest(), time);
  if (status != collision::UpdateStatus::kUpdated)
    throw std::invalid_argument(fmt::format("deforming obstacle '{}' at {} s: {}", name, time,
                                            collision::toString(status)));
  Object object{name, {{collision::Shape::deformable(deformable.snapshot()), {}, name}}, X_WO};
  return {std::move(object), std::move(mesh), std::move(motion), speed_bound, options};
}

void readDeforming(const YamlReader& entry, const robots::LoadOptions& load, Problem& problem) {
  entry.expectKeys(keysOf("deforming"));
  const YamlReader name = entry.at("name", "a name of its own");
  if (const std::string fault = objectNameFault(name.text(), Names(problem).isKnown(name.text()));
      !fault.empty())
    name.fail(fmt::format("{} '{}' {}", name.where(), name.text(), fault));
  const IndexedMesh rest = readRestMesh(entry, load);
  for (const auto* warnings : {&rest.warnings, &rest.face_warnings})
    problem.warnings.insert(problem.warnings.end(), warnings->begin(), warnings->end());
  const auto motion_entry = entry.find("motion");
  const auto motion =
      motion_entry ? readMotion(*motion_entry, rest, load, problem.warnings) : nullptr;
  const DeformOptions options = readOptions(entry);
  const auto bound = entry.find("speed_bound");
  const double speed_bound = bound ? bound->sizeNumber() : std::numeric_limits<double>::infinity();
  try {
    problem.world.deforming.push_back(makeDeformingObstacle(
        name.text(), DeformableMesh::make(rest.vertices, rest.triangles, isSolid(name, load)),
        motion, readPose(entry, problem.warnings), problem.execution.start, options, speed_bound));
  } catch (const std::invalid_argument& error) {
    const auto strategy = entry.find("strategy");
    (strategy ? *strategy : entry).fail(fmt::format("{}: {}", entry.where(), error.what()));
  }
  if (const auto color = entry.find("color"))
    problem.world.deforming.back().object.color = readColor(*color);
  if (bound)
    if (const auto fault = speedBoundFault(problem.world.deforming.back(), problem.execution.start))
      bound->fail(fmt::format("{} {}", bound->where(), *fault));
  if (const auto margin = entry.find("margin")) {
    const double value = margin->sizeNumber();
    // The word holds for what the robot takes hold of later.
    if (Names(problem).isKnown(kRobotWord) && problem.robot.model->links.size() > 1)
      margin->fail(fmt::format(
          "{} is for the whole robot, and 'robot' is the name of a link; 'margins' between a group "
          "of the links that are meant and '{}' are expected",
          margin->where(), name.text()));
    problem.margins.pairs.push_back({kRobotWord, name.text(), value, "robot and " + name.text()});
  }
}

}  // namespace leeway::planner
