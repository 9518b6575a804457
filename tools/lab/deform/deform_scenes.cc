#include "tools/lab/deform/deform_scenes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/collision/vertex_motion.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::tools::report {
namespace {

using collision::InvalidMotion;
using collision::Pose;
using collision::Shape;
using collision::VertexMotion;
using Eigen::Vector3d;
using oracle::Random;
using Triangle = std::array<std::int32_t, 3>;

constexpr double kPi = std::numbers::pi;

struct Grid {
  std::vector<Vector3d> vertices;
  std::vector<Triangle> triangles;
};

/// A sheet of columns x rows quads, each split in two; `place` maps [0, 1]^2 into space.
Grid makeGrid(int columns, int rows, const std::function<Vector3d(double, double)>& place) {
  Grid grid;
  for (int i = 0; i <= rows; ++i)
    for (int j = 0; j <= columns; ++j)
      grid.vertices.push_back(
          place(static_cast<double>(j) / columns, static_cast<double>(i) / rows));
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const std::int32_t a = i * (columns + 1) + j, b = a + columns + 1;
      grid.triangles.push_back({a, a + 1, b});
      grid.triangles.push_back({a + 1, b + 1, b});
    }
  }
  return grid;
}

/// Two metres square, in the plane z = 0.
Grid makeCloth(int triangles) {
  const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(triangles / 2.0))));
  return makeGrid(n, n, [](double u, double v) { return Vector3d(2 * u - 1, 2 * v - 1, 0); });
}

DeformScene withMotion(const char* name, Grid grid, std::shared_ptr<const VertexMotion> motion) {
  DeformScene scene;
  scene.motion = name;
  scene.vertices = [motion](double time, std::span<Vector3d> out) { motion->evaluate(time, out); };
  scene.spec = {std::move(grid.vertices), std::move(grid.triangles), std::move(motion)};
  return scene;
}

DeformScene wave(int triangles, Random& random) {
  Grid cloth = makeCloth(triangles);
  collision::WavesMotion motion;
  motion.rest = cloth.vertices;
  for (const double length : {1.3, 0.6, 0.25}) {
    const double angle = random.uniform(0, 2 * kPi);
    motion.waves.push_back({{std::cos(angle), std::sin(angle), 0},
                            {0, 0, 0.08 * length},
                            length,
                            2,
                            random.uniform(0, 2 * kPi)});
  }
  return withMotion("wave", std::move(cloth), VertexMotion::waves(std::move(motion)));
}

DeformScene lattice(int triangles, Random& random) {
  Grid cloth = makeCloth(triangles);
  collision::LatticeMotion motion;
  motion.rest = cloth.vertices;
  motion.box_lower = {-1, -1, -0.1}, motion.box_upper = {1, 1, 0.1};
  motion.cells[0] = motion.cells[1] = 3, motion.cells[2] = 1;
  for (int key = 0; key < 5; ++key) {
    collision::LatticeMotion::Key k;
    k.time = 0.25 * key;
    for (int z = 0; z < 2; ++z)
      for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
          k.control_points.push_back(Vector3d(2.0 * x / 3 - 1, 2.0 * y / 3 - 1, 0.2 * z - 0.1) +
                                     (key == 0 ? 0.0 : 1.0) * random.uniform(0, 0.25) *
                                         random.direction());
    motion.keys.push_back(std::move(k));
  }
  return withMotion("lattice", std::move(cloth), VertexMotion::lattice(std::move(motion)));
}

/// A cloth whose ends turn in opposite directions, up to 270 degrees.
DeformScene twist(int triangles, Random& random) {
  Grid cloth = makeCloth(triangles);
  DeformScene scene;
  scene.motion = "twist";
  const double phase = random.uniform(0, 0.3);
  scene.vertices = [rest = cloth.vertices, phase](double time, std::span<Vector3d> out) {
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const double angle = rest[i].x() * (time + phase) * 1.5 * kPi / 1.3;
      const double c = std::cos(angle), s = std::sin(angle), y = 0.25 * rest[i].y();
      out[i] = {rest[i].x(), c * y, s * y};
    }
  };
  scene.spec = {std::move(cloth.vertices), std::move(cloth.triangles), nullptr};
  return scene;
}

DeformScene morph(int triangles, Random& random) {
  Grid cloth = makeCloth(triangles);
  collision::MorphMotion motion;
  const double x = random.uniform(-0.3, 0.3), y = random.uniform(-0.3, 0.3);
  std::vector<Vector3d> heap = cloth.vertices, saddle = cloth.vertices;
  for (Vector3d& v : heap)
    v.z() = 0.4 * std::exp(-4 * ((v.x() - x) * (v.x() - x) + (v.y() - y) * (v.y() - y)));
  for (Vector3d& v : saddle) v.z() = 0.15 * (v.x() * v.x() - v.y() * v.y());
  motion.references = {cloth.vertices, std::move(heap), std::move(saddle)};
  motion.keys = {{0, {1, 0, 0}}, {0.4, {0, 1, 0}}, {0.7, {0.2, 0.3, 0.5}}, {1, {0, 0, 1}}};
  return withMotion("morph", std::move(cloth), VertexMotion::morph(std::move(motion)));
}

/// Eight bones along x, each bending a little; a vertex follows the two nearest.
DeformScene skinned(int triangles, Random& random) {
  constexpr int kBones = 8;
  constexpr double kLength = 2.0 / kBones;
  const int around = std::max(3, static_cast<int>(std::lround(std::sqrt(triangles / 6.0))));
  const int along = std::max(1, triangles / (2 * around));
  Grid tube = makeGrid(along, around, [](double u, double v) {
    const double angle = 2 * kPi * v;
    return Vector3d(2 * u - 1, 0.12 * std::cos(angle), 0.12 * std::sin(angle) + 0.05);
  });
  collision::SkinnedMotion motion;
  motion.rest = tube.vertices;
  for (int b = 0; b < kBones; ++b)
    motion.bones.push_back({b - 1, {{b == 0 ? -1 : kLength, 0, 0}, Eigen::Vector4d::UnitW()}});
  for (std::size_t i = 0; i < tube.vertices.size(); ++i) {
    const double place = (tube.vertices[i].x() + 1) / kLength - 0.5;
    const int first = std::clamp(static_cast<int>(std::floor(place)), 0, kBones - 2);
    const double share = std::clamp(place - first, 0.0, 1.0);
    if (share < 1) motion.weights.push_back({static_cast<int>(i), first, 1 - share});
    if (share > 0) motion.weights.push_back({static_cast<int>(i), first + 1, share});
  }
  for (int key = 0; key < 4; ++key) {
    collision::SkinnedMotion::Key k;
    k.time = key / 3.0;
    for (int b = 0; b < kBones; ++b) {
      const double half = key == 0 ? 0 : random.uniform(-0.2, 0.2);
      k.poses.push_back({motion.bones[static_cast<std::size_t>(b)].rest.translation,
                         {0, std::sin(half), 0.3 * std::sin(half), std::cos(half)}});
    }
    motion.keys.push_back(std::move(k));
  }
  return withMotion("skinned", std::move(tube), VertexMotion::skinned(std::move(motion)));
}

DeformScene reduced(int triangles, Random& random) {
  Grid cloth = makeCloth(triangles);
  collision::ReducedMotion motion;
  motion.rest = cloth.vertices;
  for (int m = 0; m < 6; ++m) {
    const int a = 1 + m % 3, b = 1 + m / 3;
    std::vector<Vector3d> mode;
    for (const Vector3d& v : cloth.vertices)
      mode.emplace_back(0, 0,
                        std::sin(a * kPi * (v.x() + 1) / 2) * std::sin(b * kPi * (v.y() + 1) / 2));
    motion.modes.push_back(std::move(mode));
    motion.harmonics.push_back({0.12 / (a + b), 0.7 * (a + b) / 2, random.uniform(0, 2 * kPi)});
  }
  return withMotion("reduced", std::move(cloth), VertexMotion::reduced(std::move(motion)));
}

/// The wave recorded at 25 frames/s, as animation tools export it, and played back.
DeformScene cache(int triangles, Random& random) {
  constexpr int kFramesPerSecond = 25;
  DeformScene recorded = wave(triangles, random);
  collision::CacheMotion motion;
  motion.vertex_count = static_cast<int>(recorded.spec.rest.size());
  motion.positions.reserve((kFramesPerSecond + 1) * recorded.spec.rest.size());
  std::vector<Vector3d> frame(recorded.spec.rest.size());
  for (int i = 0; i <= kFramesPerSecond; ++i) {
    motion.times.push_back(static_cast<double>(i) / kFramesPerSecond);
    recorded.vertices(motion.times.back(), frame);
    motion.positions.insert(motion.positions.end(), frame.begin(), frame.end());
  }
  return withMotion("cache", {std::move(recorded.spec.rest), std::move(recorded.spec.triangles)},
                    VertexMotion::cache(std::move(motion)));
}

/// A ball of unconnected triangles, each flying outwards up to three radii.
DeformScene explode(int triangles, Random& random) {
  const int n = std::max(2, static_cast<int>(std::lround(std::sqrt(triangles / 4.0))));
  const Grid ball = makeGrid(2 * n, n, [](double u, double v) {
    return Vector3d(0.5 * std::sin(kPi * v) * std::cos(2 * kPi * u),
                    0.5 * std::sin(kPi * v) * std::sin(2 * kPi * u), 0.5 * std::cos(kPi * v));
  });
  DeformScene scene;
  scene.motion = "explode";
  std::vector<Vector3d> velocity;
  for (const Triangle& t : ball.triangles) {
    const auto next = static_cast<std::int32_t>(scene.spec.rest.size());
    scene.spec.triangles.push_back({next, next + 1, next + 2});
    for (const std::int32_t corner : t)
      scene.spec.rest.push_back(ball.vertices[static_cast<std::size_t>(corner)]);
    velocity.push_back(2 * scene.spec.rest.back() + random.uniform(0.2, 1) * random.direction());
  }
  scene.vertices = [rest = scene.spec.rest, velocity = std::move(velocity)](
                       double time, std::span<Vector3d> out) {
    for (std::size_t i = 0; i < rest.size(); ++i) out[i] = rest[i] + time * velocity[i / 3];
  };
  return scene;
}

using MakeScene = DeformScene (*)(int, Random&);
const std::vector<std::pair<std::string, MakeScene>>& makers() {
  static const std::vector<std::pair<std::string, MakeScene>> all = {
      {"wave", wave},       {"lattice", lattice}, {"twist", twist}, {"morph", morph},
      {"skinned", skinned}, {"reduced", reduced}, {"cache", cache}, {"explode", explode}};
  return all;
}

constexpr double kLinkRadius = 0.04, kLinkHalf = 0.06;

}  // namespace

const std::vector<std::string>& deformMotions() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const auto& maker : makers()) result.push_back(maker.first);
    return result;
  }();
  return names;
}

DeformScene makeDeformScene(const std::string& motion, int triangles, std::uint64_t seed) {
  for (const auto& [name, make] : makers()) {
    Random random(seed);
    if (name == motion) return make(triangles, random);
  }
  throw std::invalid_argument("no motion '" + motion + "'");
}

DeformBodies makeDeformBodies() {
  DeformBodies bodies;
  for (int i = 0; i < 12; ++i) {
    bodies.capsules.push_back(Shape::capsule(kLinkRadius, kLinkHalf));
    bodies.spheres.push_back(Shape::sphere(kLinkRadius + kLinkHalf));
  }
  const Grid ball = makeGrid(32, 16, [](double u, double v) {
    return Vector3d(0.08 * std::sin(kPi * v) * std::cos(2 * kPi * u),
                    0.08 * std::sin(kPi * v) * std::sin(2 * kPi * u), 0.2 * std::cos(kPi * v));
  });
  bodies.mesh = Shape::mesh(collision::TriangleMesh::make(ball.vertices, ball.triangles));
  return bodies;
}

Pose DeformBodies::linkPose(int i, double time) const {
  // An arm from the mesh's side, over it and down towards it.
  const double s = i / 11.0;
  const double sway = 0.15 * std::sin(2 * kPi * time + 3 * s);
  Pose X;
  X.translation = {-1.1 + 1.4 * s, sway, 0.25 + 0.75 * std::sin(kPi * (0.35 + 0.6 * s))};
  X.rotation = Eigen::AngleAxisd(kPi / 2 + 1.2 * s + sway, Vector3d::UnitY()).toRotationMatrix();
  return X;
}

Pose DeformBodies::meshPose(int place, double time) const {
  constexpr double kHeight[] = {1.5, 0.55, 0.05};
  Pose X;
  X.translation = {0.3 + 0.1 * std::sin(2 * kPi * time), 0.2, kHeight[place]};
  X.rotation = Eigen::AngleAxisd(0.4 + 0.2 * time, Vector3d::UnitX()).toRotationMatrix();
  return X;
}

}  // namespace leeway::tools::report
