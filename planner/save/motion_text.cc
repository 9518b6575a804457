#include "planner/save/motion_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/robots/input_error.h"
#include "robots/base/fnv.h"

namespace leeway::planner {
namespace {

using collision::Interpolation;
using Vertices = std::vector<Eigen::Vector3d>;
using Triangles = std::span<const std::array<std::int32_t, 3>>;

/// Writes motions of one obstacle.
class MotionWriter {
 public:
  MotionWriter(const DeformingObstacle& obstacle, SavedFiles& files)
      : what_("the motion of '" + obstacle.object.name + "'"),
        name_(obstacle.object.name),
        triangles_(obstacle.mesh->triangles()),
        files_(files) {}

  [[noreturn]] std::string operator()(std::monostate) const {
    throw robots::InputError(
        "", 0,
        what_ +
            " is a class of a program, which files cannot say; one of waves, lattice, "
            "morph, skinned, reduced and cache is expected");
  }

  std::string operator()(const collision::WavesMotion& motion) const {
    std::vector<std::string> waves;
    for (const collision::Wave& wave : motion.waves)
      waves.push_back(MapText()
                          .add("direction", vector(wave.direction))
                          .add("amplitude", vector(wave.amplitude))
                          .add("wavelength", number(wave.wavelength))
                          .add("frequency", number(wave.frequency))
                          .add("phase", number(wave.phase))
                          .text());
    MapText text;
    text.add("waves", listText(waves));
    if (motion.pinned)
      text.add("pinned", MapText()
                             .add("point", vector(motion.pinned->point))
                             .add("direction", vector(motion.pinned->direction))
                             .add("length", number(motion.pinned->length))
                             .text());
    return text.text();
  }

  std::string operator()(const collision::LatticeMotion& motion) const {
    std::vector<std::string> keys;
    for (const auto& key : motion.keys) {
      std::vector<std::string> moved;
      std::size_t point = 0;
      for (int k = 0; k <= motion.cells[2]; ++k)
        for (int j = 0; j <= motion.cells[1]; ++j)
          for (int i = 0; i <= motion.cells[0]; ++i, ++point) {
            const Eigen::Vector3d share(double(i) / motion.cells[0], double(j) / motion.cells[1],
                                        double(k) / motion.cells[2]);
            const Eigen::Vector3d rest =
                motion.box_lower + share.cwiseProduct(motion.box_upper - motion.box_lower);
            if (key.control_points[point] == rest) continue;
            moved.push_back(MapText()
                                .add("at", fmt::format("[{}, {}, {}]", i, j, k))
                                .add("by", vector(key.control_points[point] - rest))
                                .text());
          }
      MapText text;
      text.add("time", number(key.time));
      if (!moved.empty()) text.add("moved", listText(moved));
      keys.push_back(text.text());
    }
    MapText text;
    text.add("box", MapText()
                        .add("lower", vector(motion.box_lower))
                        .add("upper", vector(motion.box_upper))
                        .text())
        .add("cells",
             fmt::format("[{}, {}, {}]", motion.cells[0], motion.cells[1], motion.cells[2]))
        .add("keys", listText(keys));
    return named("lattice", text, motion.interpolation);
  }

  std::string operator()(const collision::MorphMotion& motion) const {
    std::vector<std::string> keys;
    for (const auto& key : motion.keys)
      keys.push_back(MapText()
                         .add("time", number(key.time))
                         .add("weights", numbersText(key.weights, what_))
                         .text());
    MapText text;
    text.add("references", targets(motion.references)).add("keys", listText(keys));
    return named("morph", text, motion.interpolation);
  }

  std::string operator()(const collision::ReducedMotion& motion) const {
    // Modes are written as the rest displaced by them.
    std::vector<Vertices> displaced = motion.modes;
    for (Vertices& mode : displaced)
      for (std::size_t v = 0; v < mode.size(); ++v) mode[v] += motion.rest[v];
    std::vector<std::string> keys, harmonics;
    for (const auto& key : motion.keys)
      keys.push_back(MapText()
                         .add("time", number(key.time))
                         .add("coordinates", numbersText(key.coordinates, what_))
                         .text());
    for (const auto& harmonic : motion.harmonics)
      harmonics.push_back(MapText()
                              .add("amplitude", number(harmonic.amplitude))
                              .add("frequency", number(harmonic.frequency))
                              .add("phase", number(harmonic.phase))
                              .text());
    MapText text;
    text.add("modes", targets(displaced));
    if (!harmonics.empty()) text.add("harmonics", listText(harmonics));
    if (!keys.empty()) text.add("keys", listText(keys));
    return named("reduced", text, motion.interpolation);
  }

  std::string operator()(const collision::SkinnedMotion& motion) const {
    std::vector<std::string> bones, weights, keys;
    const auto boneName = [](int bone) { return fmt::format("bone_{}", bone + 1); };
    const auto pose = [&](const collision::SkinnedMotion::BonePose& X, MapText text) {
      return text.add("position", vector(X.translation))
          .add("orientation", numbersText(std::span(X.quaternion.data(), 4), what_))
          .text();
    };
    for (std::size_t b = 0; b < motion.bones.size(); ++b) {
      MapText text;
      text.add("name", boneName(static_cast<int>(b)));
      if (motion.bones[b].parent >= 0) text.add("parent", boneName(motion.bones[b].parent));
      bones.push_back(pose(motion.bones[b].rest, text));
    }
    for (const auto& weight : motion.weights)
      weights.push_back(MapText()
                            .add("vertex", fmt::format("{}", weight.vertex))
                            .add("bone", boneName(weight.bone))
                            .add("weight", number(weight.weight))
                            .text());
    for (const auto& key : motion.keys) {
      MapText poses;
      for (std::size_t b = 0; b < key.poses.size(); ++b)
        poses.add(boneName(static_cast<int>(b)), pose(key.poses[b], {}));
      keys.push_back(MapText().add("time", number(key.time)).add("poses", poses.text()).text());
    }
    MapText text;
    text.add("bones", listText(bones))
        .add("weights", listText(weights))
        .add("keys", listText(keys));
    return named("skinned", text, motion.interpolation);
  }

  std::string operator()(const collision::CacheMotion& motion) const {
    const auto isSingle = [](double x) { return static_cast<double>(static_cast<float>(x)) == x; };
    MapText text;
    if (std::all_of(motion.times.begin(), motion.times.end(), isSingle) &&
        std::all_of(motion.positions.begin(), motion.positions.end(), [&](const auto& p) {
          return isSingle(p[0]) && isSingle(p[1]) && isSingle(p[2]);
        })) {
      text.add("file", wordText(files_.add(name_ + " motion", ".mdd", mdd(motion))));
    } else {
      std::vector<Vertices> frames;
      for (auto at = motion.positions.begin(); at != motion.positions.end();
           at += motion.vertex_count)
        frames.emplace_back(at, at + motion.vertex_count);
      text.add("times", numbersText(motion.times, what_)).add("frames", targets(frames));
    }
    return MapText().add("cache", text.text()).text();
  }

 private:
  /// See vertex_cache.h.
  static std::string mdd(const collision::CacheMotion& motion) {
    std::string bytes;
    const auto add = [&](std::uint32_t word) {
      for (int shift = 24; shift >= 0; shift -= 8)
        bytes.push_back(static_cast<char>((word >> static_cast<unsigned>(shift)) & 0xffU));
    };
    const auto addNumber = [&](double x) {
      add(std::bit_cast<std::uint32_t>(static_cast<float>(x)));
    };
    add(static_cast<std::uint32_t>(motion.times.size()));
    add(static_cast<std::uint32_t>(motion.vertex_count));
    for (const double time : motion.times) addNumber(time);
    for (const Eigen::Vector3d& p : motion.positions)
      for (int k = 0; k < 3; ++k) addNumber(p[k]);
    return bytes;
  }
  std::string number(double value) const { return numberText(value, what_); }
  std::string vector(const Eigen::Vector3d& v) const { return vectorText(v, what_); }
  static std::string named(const char* word, MapText& text, Interpolation interpolation) {
    if (interpolation == Interpolation::kSmooth) text.add("interpolation", "smooth");
    return MapText().add(word, text.text()).text();
  }
  std::string targets(const std::vector<Vertices>& all) const {
    std::vector<std::string> texts;
    for (const Vertices& vertices : all)
      texts.push_back(
          MapText()
              .add("file", wordText(files_.addMesh(name_ + " target", vertices, triangles_)))
              .text());
    return listText(texts);
  }

  std::string what_, name_;
  Triangles triangles_;
  SavedFiles& files_;
};

}  // namespace

std::string SavedFiles::add(const std::string& owner, const std::string& ending,
                            std::string content) {
  // Names of things may hold anything.
  std::string name;
  for (const char c : owner.substr(0, 40))
    name += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ? c : '_';
  // Other contents have another name, so that no file of another problem is replaced.
  const std::string file =
      fmt::format("{}_{}_{:016x}{}", files_.size() + 1, name, robots::fnv1a(content), ending);
  files_.emplace_back(file, std::move(content));
  return folder_ + "/" + file;
}

std::string SavedFiles::addMesh(const std::string& owner, std::span<const Eigen::Vector3d> vertices,
                                std::span<const std::array<std::int32_t, 3>> triangles) {
  std::string text;
  for (const Eigen::Vector3d& p : vertices)
    fmt::format_to(std::back_inserter(text), "v {} {} {}\n", p.x(), p.y(), p.z());
  for (const auto& [a, b, c] : triangles)
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", a + 1, b + 1, c + 1);
  return add(owner, ".obj", std::move(text));
}

std::string deformingText(const DeformingObstacle& obstacle, SavedFiles& files) {
  const std::string& name = obstacle.object.name;
  const std::string what = "deforming obstacle '" + name + "'";
  if (!obstacle.mesh) throw robots::InputError("", 0, what + " has no mesh; one is expected");
  const collision::DeformableMesh& mesh = *obstacle.mesh;
  MapText text;
  text.add("name", wordText(name)).addPose(obstacle.object.X_WO, what);
  if (obstacle.object.color) text.add("color", numbersText(*obstacle.object.color, what));
  const std::string file = files.addMesh(name, mesh.rest(), mesh.triangles());
  text.add("mesh", MapText().add("file", wordText(file)).text());
  if (mesh.closedComponentCount() == 0 && mesh.openEdgeCount() == 0)
    files.treatments.add(wordText(name), "{solid: surface}");
  if (obstacle.motion)
    text.add("motion", std::visit(MotionWriter(obstacle, files), obstacle.motion->source()));
  if (std::isfinite(obstacle.speed_bound))
    text.add("speed_bound", numberText(obstacle.speed_bound, what));
  const collision::DeformOptions& options = obstacle.options;
  text.add("strategy", wordText(toString(options.strategy)));
  text.add("options", MapText()
                          .add("volume", wordText(toString(options.volume)))
                          .add("hybrid_split", fmt::format("{}", options.hybrid_split))
                          .add("restructure_factor", numberText(options.restructure_factor, what))
                          .add("expected_queries", fmt::format("{}", options.expected_queries))
                          .text());
  return text.text();
}

}  // namespace leeway::planner
