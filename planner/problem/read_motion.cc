#include "planner/problem/read_motion.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "planner/problem/read_shapes.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

using collision::Interpolation;
using collision::VertexMotion;
using Vertices = std::vector<Eigen::Vector3d>;

// ------------------------------------------------------------------------------------------------
// displaced vertices

/// Displaces vertices by `by` times (1 - (d / radius)^2)^2, where d is their distance from the
/// centre. Vertices beyond the radius stay.
void addBump(const YamlReader& bump, const Vertices& rest, Vertices& displaced) {
  bump.expectKeys(keysOf("bump"));
  const Eigen::Vector3d center = bump.at("center", "three numbers [m]").vector3();
  const Eigen::Vector3d by = bump.at("by", "three numbers [m]").vector3();
  const YamlReader size = bump.at("radius", "a number [m]");
  const double radius = size.number();
  if (!(radius > 0))
    size.fail(fmt::format("{} is {}; a number above 0 is expected", size.where(), radius));
  bool moves = false;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const double share = 1 - (rest[v] - center).squaredNorm() / (radius * radius);
    if (!(share > 0)) continue;
    displaced[v] += share * share * by;
    moves = true;
  }
  if (!moves)
    bump.fail(
        fmt::format("{} moves no vertex: none is within {} m of its center; a center at the "
                    "mesh is expected",
                    bump.where(), radius));
}

/// The vertices of `file`, the rest displaced by `bumps`, or the rest.
Vertices readTarget(const YamlReader& target, const Vertices& rest, const robots::LoadOptions& load,
                    std::vector<std::string>& warnings) {
  target.expectKeys(keysOf("target"));
  const auto file = target.find("file"), bumps = target.find("bumps");
  if (file && bumps)
    target.fail(fmt::format("{} has both 'file' and 'bumps'; one is expected", target.where()));
  if (const auto scale = target.find("scale"); scale && !file)
    scale->fail(fmt::format("{} goes with 'file' only", scale->where()));
  if (file) {
    robots::IndexedMesh mesh = readVertices(target, load);
    if (mesh.vertices.size() != rest.size())
      file->fail(fmt::format("{} has {} vertices; the mesh's {} are expected", file->text(),
                             mesh.vertices.size(), rest.size()));
    // (Its faces are not used: the mesh at rest has them.)
    warnings.insert(warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
    return std::move(mesh.vertices);
  }
  Vertices displaced = rest;
  if (bumps)
    for (const YamlReader& bump : bumps->items()) addBump(bump, rest, displaced);
  return displaced;
}

// ------------------------------------------------------------------------------------------------
// motions

std::shared_ptr<const VertexMotion> readWaves(const YamlReader& list, const YamlReader& motion,
                                              const Vertices& rest) {
  collision::WavesMotion result;
  result.rest = rest;
  for (const YamlReader& entry : list.items()) {
    entry.expectKeys(keysOf("wave"));
    collision::Wave wave;
    wave.direction = entry.at("direction", "three numbers, of travel").vector3();
    wave.amplitude = entry.at("amplitude", "three numbers [m]").vector3();
    wave.wavelength = entry.at("wavelength", "a number [m]").number();
    wave.frequency = entry.at("frequency", "a number [Hz]").number();
    wave.phase = optionalNumber(entry, "phase", 0);
    result.waves.push_back(wave);
  }
  if (const auto pinned = motion.find("pinned")) {
    pinned->expectKeys(keysOf("pinned"));
    collision::PinnedEdge edge;
    edge.point = pinned->at("point", "three numbers [m]").vector3();
    edge.direction = pinned->at("direction", "three numbers, away from the edge").vector3();
    edge.length = pinned->at("length", "a number [m]").number();
    result.pinned = edge;
  }
  return VertexMotion::waves(std::move(result));
}

/// Control points at rest: a regular grid in the box, x fastest.
Vertices controlPoints(const collision::LatticeMotion& lattice) {
  Vertices points;
  for (int k = 0; k <= lattice.cells[2]; ++k)
    for (int j = 0; j <= lattice.cells[1]; ++j)
      for (int i = 0; i <= lattice.cells[0]; ++i) {
        const Eigen::Vector3d share(static_cast<double>(i) / lattice.cells[0],
                                    static_cast<double>(j) / lattice.cells[1],
                                    static_cast<double>(k) / lattice.cells[2]);
        points.push_back(lattice.box_lower +
                         share.cwiseProduct(lattice.box_upper - lattice.box_lower));
      }
  return points;
}

std::array<std::int64_t, 3> readTriple(const YamlReader& list, std::int64_t lowest,
                                       const std::array<std::int64_t, 3>& highest) {
  const std::vector<YamlReader> items = list.items();
  if (items.size() != 3)
    list.fail(fmt::format("{} is a list of {}; three whole numbers are expected", list.where(),
                          items.size()));
  std::array<std::int64_t, 3> result{};
  for (std::size_t k = 0; k < 3; ++k) {
    result[k] = items[k].integer(lowest);
    if (result[k] > highest[k])
      items[k].fail(fmt::format("{} is {}; {} to {} is expected", items[k].where(), result[k],
                                lowest, highest[k]));
  }
  return result;
}

std::shared_ptr<const VertexMotion> readLattice(const YamlReader& lattice, const Vertices& rest) {
  lattice.expectKeys(keysOf("lattice"));
  collision::LatticeMotion result;
  result.rest = rest;
  const YamlReader box = lattice.at("box", "lower and upper corner");
  box.expectKeys(keysOf("bounds"));
  result.box_lower = box.at("lower", "three numbers [m]").vector3();
  result.box_upper = box.at("upper", "three numbers [m]").vector3();
  const auto cells = readTriple(lattice.at("cells", "[x, y, z]"), 1, {16, 16, 16});
  for (std::size_t k = 0; k < 3; ++k) result.cells[k] = static_cast<int>(cells[k]);
  for (const YamlReader& entry : lattice.at("keys", "a list of keys").items()) {
    entry.expectKeys(keysOf("lattice_key"));
    collision::LatticeMotion::Key key;
    key.time = entry.at("time", "a number [s]").number();
    key.control_points = controlPoints(result);
    if (const auto moved = entry.find("moved"))
      for (const YamlReader& point : moved->items()) {
        point.expectKeys(keysOf("control_point"));
        const auto place = readTriple(point.at("at", "[x, y, z]"), 0, cells);
        const std::int64_t index =
            (place[2] * (cells[1] + 1) + place[1]) * (cells[0] + 1) + place[0];
        key.control_points[static_cast<std::size_t>(index)] +=
            point.at("by", "three numbers [m]").vector3();
      }
    result.keys.push_back(std::move(key));
  }
  result.interpolation = readInterpolation(lattice);
  return VertexMotion::lattice(std::move(result));
}

std::shared_ptr<const VertexMotion> readMorph(const YamlReader& morph, const Vertices& rest,
                                              const robots::LoadOptions& load,
                                              std::vector<std::string>& warnings) {
  morph.expectKeys(keysOf("morph"));
  collision::MorphMotion result;
  for (const YamlReader& target : morph.at("references", "a list of targets").items())
    result.references.push_back(readTarget(target, rest, load, warnings));
  for (const YamlReader& entry : morph.at("keys", "a list of keys").items()) {
    entry.expectKeys(keysOf("morph_key"));
    result.keys.push_back({entry.at("time", "a number [s]").number(),
                           entry.at("weights", "one number a reference").numbers()});
  }
  result.interpolation = readInterpolation(morph);
  return VertexMotion::morph(std::move(result));
}

/// A cache whose frames are targets, which have double precision.
std::shared_ptr<const VertexMotion> readFrames(const YamlReader& cache, const Vertices& rest,
                                               const robots::LoadOptions& load,
                                               std::vector<std::string>& warnings) {
  cache.expectKeys(keysOf("cache"));
  if (cache.find("file"))
    cache.fail(fmt::format("{} has both 'file' and 'frames'; one is expected", cache.where()));
  for (const char* key : {"scale", "start", "rate"})
    if (const auto other = cache.find(key))
      other->fail(fmt::format("{} goes with 'file' only", other->where()));
  collision::CacheMotion result{static_cast<int>(rest.size()), {}, {}};
  const YamlReader times = cache.at("times", "a number a frame [s]");
  result.times = times.numbers();
  const std::vector<YamlReader> frames = cache.at("frames", "a list of targets").items();
  if (frames.size() != result.times.size())
    times.fail(fmt::format("{} has {} numbers; as many as 'frames', {}, are expected",
                           times.where(), result.times.size(), frames.size()));
  for (const YamlReader& frame : frames) {
    const Vertices vertices = readTarget(frame, rest, load, warnings);
    result.positions.insert(result.positions.end(), vertices.begin(), vertices.end());
  }
  return VertexMotion::cache(std::move(result));
}

std::shared_ptr<const VertexMotion> readReduced(const YamlReader& reduced, const Vertices& rest,
                                                const robots::LoadOptions& load,
                                                std::vector<std::string>& warnings) {
  reduced.expectKeys(keysOf("reduced"));
  collision::ReducedMotion result;
  result.rest = rest;
  for (const YamlReader& target : reduced.at("modes", "a list of targets").items()) {
    Vertices mode = readTarget(target, rest, load, warnings);
    for (std::size_t v = 0; v < mode.size(); ++v) mode[v] -= rest[v];
    result.modes.push_back(std::move(mode));
  }
  if (const auto harmonics = reduced.find("harmonics"))
    for (const YamlReader& entry : harmonics->items()) {
      entry.expectKeys(keysOf("harmonic"));
      result.harmonics.push_back({optionalNumber(entry, "amplitude", 1),
                                  entry.at("frequency", "a number [Hz]").number(),
                                  optionalNumber(entry, "phase", 0)});
    }
  if (const auto keys = reduced.find("keys"))
    for (const YamlReader& entry : keys->items()) {
      entry.expectKeys(keysOf("reduced_key"));
      result.keys.push_back({entry.at("time", "a number [s]").number(),
                             entry.at("coordinates", "one number a mode").numbers()});
    }
  result.interpolation = readInterpolation(reduced);
  return VertexMotion::reduced(std::move(result));
}

std::shared_ptr<const VertexMotion> readWord(std::string_view word, const YamlReader& value,
                                             const YamlReader& motion, const Vertices& rest,
                                             const robots::LoadOptions& load,
                                             std::vector<std::string>& warnings) {
  if (word == "waves") return readWaves(value, motion, rest);
  if (word == "lattice") return readLattice(value, rest);
  if (word == "morph") return readMorph(value, rest, load, warnings);
  if (word == "skinned") return readSkinned(value, rest, warnings);
  if (word == "cache")
    return value.find("frames") ? readFrames(value, rest, load, warnings) : readCache(value, rest);
  return readReduced(value, rest, load, warnings);
}

}  // namespace

double optionalNumber(const YamlReader& map, std::string_view key, double otherwise) {
  const auto value = map.find(key);
  return value ? value->number() : otherwise;
}

Interpolation readInterpolation(const YamlReader& map) {
  const auto given = map.find("interpolation");
  if (!given || given->text() == "linear") return Interpolation::kLinear;
  if (given->text() != "smooth")
    given->fail(
        fmt::format("{} is '{}'; linear or smooth is expected", given->where(), given->text()));
  return Interpolation::kSmooth;
}

robots::IndexedMesh readVertices(const YamlReader& map, const robots::LoadOptions& load) {
  const YamlReader file = map.at("file", "an OBJ file");
  std::vector<std::string> warnings;
  const std::string path = meshPath(file, load, warnings);
  if (!std::filesystem::is_regular_file(path))
    file.fail(fmt::format("{} names '{}', which does not exist; an existing file is expected",
                          file.where(), path));
  const std::string ending = robots::endingOf(path);
  if (ending != ".obj")
    file.fail(
        fmt::format("{} has the ending '{}'; an OBJ is expected, whose vertices have numbers "
                    "that a motion can go by",
                    file.where(), ending));
  robots::IndexedMesh mesh = robots::importIndexed(path, readScale(map), file.file(), file.line());
  mesh.warnings.insert(mesh.warnings.begin(), warnings.begin(), warnings.end());
  return mesh;
}

std::shared_ptr<const VertexMotion> readMotion(const YamlReader& motion,
                                               const robots::IndexedMesh& rest,
                                               const robots::LoadOptions& load,
                                               std::vector<std::string>& warnings) {
  motion.expectKeys(keysOf("motion"));
  constexpr std::array<std::string_view, 6> kWords = {"waves",   "lattice", "morph",
                                                      "skinned", "reduced", "cache"};
  std::string_view found;
  for (const std::string_view word : kWords) {
    if (!motion.has(word)) continue;
    if (!found.empty())
      motion.fail(
          fmt::format("{} has both '{}' and '{}'; one is expected", motion.where(), found, word));
    found = word;
  }
  if (found.empty())
    motion.fail(fmt::format(
        "{} has none of waves, lattice, morph, skinned, reduced and cache; one is expected",
        motion.where()));
  if (found != "waves" && motion.has("pinned"))
    motion.at("pinned", "").fail("pinned goes with waves only");
  const YamlReader value = motion.at(found, "");
  try {
    return readWord(found, value, motion, rest.vertices, load, warnings);
  } catch (const collision::InvalidMotion& error) {
    value.fail(fmt::format("{}: {}", value.where(), error.what()));
  }
}

// ------------------------------------------------------------------------------------------------
// objects that move

namespace {

using collision::PoseMotion;

/// Refuses keys of `map` that say what `key` says otherwise.
void expectAlone(const YamlReader& map, std::string_view key,
                 std::initializer_list<std::string_view> others) {
  for (const std::string_view other : others)
    if (const auto found = map.find(std::string(other)))
      found->fail(fmt::format("key '{}' stands beside '{}'; one of them is expected", other, key));
}

/// Turns of half a turn to within this angle [rad] are refused: 3.1416 and 3.14159 are both meant
/// as half a turn, and go opposite ways.
constexpr double kWrittenHalfTurn = 1e-3;

/// Checks the way from the key before the last one to the last, which goes the shorter way round.
/// `turn`: the angles about x, y and z between them as they are written [rad], or NaN.
void expectOneWay(const YamlReader& item, const std::vector<PoseMotion::Key>& keys,
                  const Eigen::Vector3d& turn, std::vector<std::string>& warnings) {
  if (keys.size() < 2) return;
  const Eigen::AngleAxisd way(keys[keys.size() - 2].X_WB.rotation.transpose() *
                              keys.back().X_WB.rotation);
  if (way.angle() > std::numbers::pi - kWrittenHalfTurn)
    item.fail(
        fmt::format("{} is half a turn from the key before it, and the way round is not "
                    "known; a key between them is expected",
                    item.where()));
  double most = 0;
  for (const double angle : turn)
    if (std::abs(angle) > most) most = std::abs(angle);
  if (most > std::numbers::pi)
    warnings.push_back(fmt::format(
        "{}:{}: {} differs from the key before it by {:.4g} rad as written; the object turns the "
        "shorter way, by {:.4g} rad",
        item.file(), item.line(), item.where(), most, way.angle()));
}

std::shared_ptr<const PoseMotion> readKeys(const YamlReader& list,
                                           std::vector<std::string>& warnings) {
  std::vector<PoseMotion::Key> keys;
  // NaN where a key is written in another way.
  const Eigen::Vector3d other = Eigen::Vector3d::Constant(std::nan(""));
  Eigen::Vector3d before = other;
  for (const YamlReader& item : list.items()) {
    item.expectKeys(keysOf("moving_key"));
    keys.push_back({item.at("time", "a time in s").number(), readPose(item, warnings)});
    const auto written = item.find("rpy");
    const Eigen::Vector3d rpy = written ? written->vector3() : other;
    expectOneWay(item, keys, rpy - before, warnings);
    before = rpy;
  }
  return PoseMotion::keys(std::move(keys));
}

/// The bound under `key`, which an object that was only seen must have.
double readBound(const YamlReader& moving, std::string_view key, const char* unit, bool has_poses) {
  if (const auto bound = moving.find(std::string(key))) return bound->sizeNumber();
  if (!has_poses)
    moving.fail(
        fmt::format("{} has no '{}', and neither 'keys' nor 'velocity'; a bound in {} is expected, "
                    "because what is not known is not safe",
                    moving.where(), key, unit));
  return std::numeric_limits<double>::infinity();
}

void readObjectMotion(const YamlReader& map, const YamlReader& moving, Object& object,
                      Problem& problem) {
  moving.expectKeys(keysOf("moving"));
  ObjectMotion motion;
  const auto keys = moving.find("keys"), velocity = moving.find("velocity"),
             turning = moving.find("turning"), age = moving.find("age");
  try {
    if (keys) {
      expectAlone(moving, "keys", {"velocity", "turning", "time", "age"});
      expectAlone(map, "moving.keys", {"position", "orientation", "rpy"});
      motion.poses = readKeys(*keys, problem.warnings);
    } else if (velocity || turning) {
      expectAlone(moving, velocity ? "velocity" : "turning", {"age"});
      const Eigen::Vector3d still = Eigen::Vector3d::Zero();
      motion.poses = PoseMotion::steady({optionalNumber(moving, "time", 0), object.X_WO},
                                        velocity ? velocity->vector3() : still,
                                        turning ? turning->vector3() : still);
    } else {
      if (const auto time = moving.find("time"))
        time->fail(fmt::format(
            "key 'time' stands without 'velocity' or 'turning'; 'age' is expected, of a pose that "
            "was seen"));
      if (age) motion.age = age->sizeNumber();
    }
  } catch (const collision::InvalidMotion& error) {
    (keys ? *keys : moving).fail(fmt::format("{}: {}", moving.where(), error.what()));
  }
  motion.speed_bound = readBound(moving, "speed_bound", "m/s", motion.poses != nullptr);
  // movingObject() has the one of a cloud.
  motion.turn_bound = readBound(moving, "turn_bound", "rad/s", motion.poses || object.cloud);
  try {
    object = movingObject(object, motion, problem.execution.start);
  } catch (const std::invalid_argument& error) {
    moving.fail(fmt::format("{}: {}", moving.where(), error.what()));
  }
  if (const auto fault = speedBoundFault(object, problem.execution.start))
    moving.fail(fmt::format("{}: the speed bound {}", moving.where(), *fault));
}

}  // namespace

void readObjectMotions(const YamlReader& objects, Problem& problem) {
  std::vector<Object>& all = problem.world.objects;
  objects.eachItem([&](const YamlReader& map) {
    const auto name = map.find("name"), moving = map.find("moving");
    if (!name || !moving) return;
    const auto object = std::find_if(all.begin(), all.end(),
                                     [&](const Object& o) { return o.name == name->text(); });
    // One that could not be read has no shapes; its fault is known.
    if (object != all.end() && (!object->geometries.empty() || object->cloud))
      readObjectMotion(map, *moving, *object, problem);
  });
}

}  // namespace leeway::planner
