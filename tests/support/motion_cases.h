#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "collision/base/sine_cosine.h"
#include "leeway/collision/vertex_motion.h"
#include "tools/truth/oracle/generate.h"

// Rest meshes with motions of every kind. Equal bytes on every machine.

namespace leeway::collision::motion_cases {

using Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;

struct RestMesh {
  std::vector<Vector3d> vertices;
  std::vector<Triangle> triangles;
};

inline double sine(double x) {
  double s, c;
  sineCosine(x, s, c);
  return s;
}
inline double cosine(double x) { return sine(x + 1.5707963267948966); }

/// columns x rows vertices over `u` and `v`, periodic if `around`; two triangles for each cell.
inline std::vector<Triangle> gridTriangles(int columns, int rows, bool around) {
  std::vector<Triangle> result;
  const int last_column = around ? columns : columns - 1;
  for (int y = 0; y + 1 < rows; ++y) {
    for (int x = 0; x < last_column; ++x) {
      const int next = (x + 1) % columns;
      const int a = y * columns + x, b = y * columns + next, c = a + columns, d = b + columns;
      result.push_back({a, b, d});
      result.push_back({a, d, c});
    }
  }
  return result;
}

/// A square of side 1 m in the x-z plane, hanging from z = 1 down to 0.
inline RestMesh cloth(int side) {
  RestMesh mesh;
  for (int z = 0; z < side; ++z) {
    for (int x = 0; x < side; ++x)
      mesh.vertices.push_back({double(x) / (side - 1), 0, 1 - double(z) / (side - 1)});
  }
  mesh.triangles = gridTriangles(side, side, false);
  return mesh;
}

/// Closed, radius 0.5 m, `rings` of 2 * rings vertices between two poles.
inline RestMesh sphere(int rings) {
  RestMesh mesh;
  const int columns = 2 * rings;
  for (int y = 0; y < rings; ++y) {
    const double latitude = 3.141592653589793 * (y + 1) / (rings + 1);
    for (int x = 0; x < columns; ++x) {
      const double longitude = 6.283185307179586 * x / columns;
      mesh.vertices.push_back({0.5 * sine(latitude) * cosine(longitude),
                               0.5 * sine(latitude) * sine(longitude), -0.5 * cosine(latitude)});
    }
  }
  mesh.triangles = gridTriangles(columns, rings, true);
  const int south = static_cast<int>(mesh.vertices.size()), north = south + 1;
  mesh.vertices.push_back({0, 0, -0.5});
  mesh.vertices.push_back({0, 0, 0.5});
  for (int x = 0; x < columns; ++x) {
    const int next = (x + 1) % columns, top = (rings - 1) * columns;
    mesh.triangles.push_back({south, next, x});
    mesh.triangles.push_back({north, top + x, top + next});
  }
  return mesh;
}

/// Closed, along z from 0 to 1 m, radius 0.1 m.
inline RestMesh tube(int rings) {
  RestMesh mesh = sphere(rings);
  for (Vector3d& v : mesh.vertices) {
    const double z = v.z() + 0.5, radius = std::sqrt(v.x() * v.x() + v.y() * v.y());
    const double scale = radius > 0 ? 0.1 / radius : 0;
    v = {v.x() * scale, v.y() * scale, z};
  }
  return mesh;
}

inline Vector3d randomVector(oracle::Random& random, double size) {
  const double x = random.uniform(-size, size), y = random.uniform(-size, size);
  return {x, y, random.uniform(-size, size)};
}

inline std::shared_ptr<const VertexMotion> wavesOf(const RestMesh& mesh, oracle::Random& random,
                                                   bool pinned = true) {
  WavesMotion motion;
  motion.rest = mesh.vertices;
  for (int k = 0; k < 3; ++k) {
    Wave wave;
    wave.direction = randomVector(random, 1);
    wave.amplitude = randomVector(random, 0.05);
    wave.wavelength = random.uniform(0.3, 2);
    wave.frequency = random.uniform(-2, 2);
    wave.phase = random.uniform(-4, 4);
    motion.waves.push_back(wave);
  }
  if (pinned) motion.pinned = PinnedEdge{{0, 0, 1}, {0, 0, -1}, 0.4};
  return VertexMotion::waves(std::move(motion));
}

/// Four keys from 0 s to 3 s, unevenly spaced.
inline const std::array<double, 4>& keyTimes() {
  static const std::array<double, 4> times = {0, 0.7, 1.9, 3};
  return times;
}

inline std::shared_ptr<const VertexMotion> latticeOf(const RestMesh& mesh, oracle::Random& random,
                                                     Interpolation interpolation) {
  LatticeMotion motion;
  motion.rest = mesh.vertices;
  motion.box_lower = Vector3d(-0.6, -0.6, -0.6);
  motion.box_upper = Vector3d(1.1, 0.7, 1.2);
  motion.cells[0] = 3;
  motion.cells[1] = 2;
  motion.cells[2] = 4;
  motion.interpolation = interpolation;
  for (const double time : keyTimes()) {
    LatticeMotion::Key key;
    key.time = time;
    for (int z = 0; z <= 4; ++z) {
      for (int y = 0; y <= 2; ++y) {
        for (int x = 0; x <= 3; ++x) {
          const Vector3d place(x / 3.0, y / 2.0, z / 4.0);
          key.control_points.push_back(motion.box_lower +
                                       place.cwiseProduct(motion.box_upper - motion.box_lower) +
                                       randomVector(random, 0.15));
        }
      }
    }
    motion.keys.push_back(std::move(key));
  }
  return VertexMotion::lattice(std::move(motion));
}

/// Smooth bumps, a different pattern for each `number`.
inline std::vector<Vector3d> bumped(const RestMesh& mesh, int number, double height) {
  std::vector<Vector3d> result;
  for (const Vector3d& v : mesh.vertices) {
    const double n = number + 1;
    result.push_back(v + height * Vector3d(sine(3 * n * v.z() + v.y()), cosine(2 * n * v.x()),
                                           sine(n * (v.x() + 2 * v.y() + v.z()))));
  }
  return result;
}

inline std::shared_ptr<const VertexMotion> morphOf(const RestMesh& mesh, oracle::Random& random,
                                                   Interpolation interpolation, double lowest,
                                                   double highest) {
  MorphMotion motion;
  motion.interpolation = interpolation;
  for (int k = 0; k < 3; ++k) motion.references.push_back(bumped(mesh, k, 0.1));
  for (const double time : keyTimes()) {
    MorphMotion::Key key;
    key.time = time;
    const double a = random.uniform(lowest, highest), b = random.uniform(lowest, highest);
    key.weights = {a, b, 1 - a - b};
    motion.keys.push_back(std::move(key));
  }
  return VertexMotion::morph(std::move(motion));
}

/// A chain of bones along z; each vertex follows the nearest two.
inline std::shared_ptr<const VertexMotion> skinnedOf(const RestMesh& mesh, oracle::Random& random,
                                                     Interpolation interpolation) {
  constexpr int kBones = 4;
  SkinnedMotion motion;
  motion.rest = mesh.vertices;
  motion.interpolation = interpolation;
  for (int b = 0; b < kBones; ++b) {
    SkinnedMotion::Bone bone;
    bone.parent = b - 1;
    bone.rest.translation = {0, 0, b == 0 ? 0 : 1.0 / kBones};
    motion.bones.push_back(bone);
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double along = std::clamp(mesh.vertices[v].z(), 0.0, 1.0) * kBones - 0.5;
    const int lower = std::clamp(static_cast<int>(std::floor(along)), 0, kBones - 2);
    const double share = std::clamp(along - lower, 0.0, 1.0);
    motion.weights.push_back({static_cast<int>(v), lower, 2 * (1 - share)});
    if (share > 0) motion.weights.push_back({static_cast<int>(v), lower + 1, 2 * share});
  }
  for (const double time : keyTimes()) {
    SkinnedMotion::Key key;
    key.time = time;
    for (int b = 0; b < kBones; ++b) {
      SkinnedMotion::BonePose pose = motion.bones[static_cast<std::size_t>(b)].rest;
      const Vector3d turn = randomVector(random, 0.6);
      pose.quaternion = {turn.x(), turn.y(), turn.z(), random.chance(0.5) ? 1.2 : -1.2};
      if (b == 0) pose.translation += randomVector(random, 0.2);
      key.poses.push_back(pose);
    }
    motion.keys.push_back(std::move(key));
  }
  return VertexMotion::skinned(std::move(motion));
}

inline std::shared_ptr<const VertexMotion> reducedOf(const RestMesh& mesh, oracle::Random& random,
                                                     bool harmonic) {
  ReducedMotion motion;
  motion.rest = mesh.vertices;
  motion.interpolation = Interpolation::kSmooth;
  for (int k = 0; k < 4; ++k) {
    std::vector<Vector3d> mode = bumped(mesh, k, 0.3);
    for (std::size_t v = 0; v < mode.size(); ++v) mode[v] -= mesh.vertices[v];
    motion.modes.push_back(std::move(mode));
    if (harmonic) {
      motion.harmonics.push_back(
          {random.uniform(-0.3, 0.3), random.uniform(0.2, 2), random.uniform(-3, 3)});
    }
  }
  for (const double time : keyTimes()) {
    if (harmonic) break;
    ReducedMotion::Key key;
    key.time = time;
    for (int k = 0; k < 4; ++k) key.coordinates.push_back(random.uniform(-0.4, 0.4));
    motion.keys.push_back(std::move(key));
  }
  return VertexMotion::reduced(std::move(motion));
}

inline std::shared_ptr<const VertexMotion> cacheOf(const RestMesh& mesh, oracle::Random& random) {
  CacheMotion motion;
  motion.vertex_count = static_cast<int>(mesh.vertices.size());
  for (int frame = 0; frame < 8; ++frame) {
    motion.times.push_back(0.4 * frame + 0.1 * random.uniform(0, 1));
    for (const Vector3d& v : bumped(mesh, 1, 0.05 * sine(frame))) motion.positions.push_back(v);
  }
  return VertexMotion::cache(std::move(motion));
}

/// Each triangle flies off in its own direction: a user-defined motion over a mesh without shared
/// vertices.
class Explosion final : public VertexMotion {
 public:
  Explosion(std::vector<Vector3d> rest, double speed, std::uint64_t seed)
      : VertexMotion(MotionKind::kOwn, static_cast<int>(rest.size()), 1, {}),
        rest_(std::move(rest)),
        speed_(speed) {
    oracle::Random random(seed);
    for (std::size_t v = 0; v < rest_.size(); v += 3) {
      const Vector3d way = randomVector(random, speed / 2);
      for (int k = 0; k < 3; ++k) velocities_.push_back(way);
    }
  }
  void parameters(double time, std::span<double> out) const override { out[0] = time; }
  void vertices(std::span<const double> parameters, int first,
                std::span<Vector3d> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const std::size_t v = static_cast<std::size_t>(first) + i;
      out[i] = rest_[v] + parameters[0] * velocities_[v];
    }
  }
  double speedBound(double, double) const override { return speed_; }
  double accelerationBound(double, double) const override { return 0; }
  double rounding(double t0, double t1) const override {
    return 1e-15 * (2 + speed_ * std::max(std::abs(t0), std::abs(t1)));
  }

 private:
  std::vector<Vector3d> rest_, velocities_;
  double speed_;
};

/// The triangles of `mesh` with unshared vertices.
inline RestMesh soup(const RestMesh& mesh) {
  RestMesh result;
  for (const Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::int32_t>(result.vertices.size());
    for (const std::int32_t v : t)
      result.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

struct MotionCase {
  std::string name;
  RestMesh mesh;
  std::shared_ptr<const VertexMotion> motion;
};

/// Every kind of motion over a suitable mesh; about 2 to 4 size^2 triangles.
inline std::vector<MotionCase> allMotions(int size, std::uint64_t seed) {
  oracle::Random random(seed);
  std::vector<MotionCase> cases;
  const RestMesh curtain = cloth(size), ball = sphere(size / 2 + 1), limb = tube(size / 2 + 1);
  const auto add = [&](const char* name, const RestMesh& mesh,
                       std::shared_ptr<const VertexMotion> motion) {
    cases.push_back({name, mesh, std::move(motion)});
  };
  add("waves", curtain, wavesOf(curtain, random));
  add("lattice", curtain, latticeOf(curtain, random, Interpolation::kLinear));
  add("lattice, smooth, closed", ball, latticeOf(ball, random, Interpolation::kSmooth));
  add("morph", ball, morphOf(ball, random, Interpolation::kLinear, 0, 0.5));
  add("morph, any weights", curtain, morphOf(curtain, random, Interpolation::kSmooth, -1, 1.5));
  add("skinned", limb, skinnedOf(limb, random, Interpolation::kLinear));
  add("skinned, smooth", curtain, skinnedOf(curtain, random, Interpolation::kSmooth));
  add("reduced, harmonic", ball, reducedOf(ball, random, true));
  add("reduced, keys", curtain, reducedOf(curtain, random, false));
  add("cache", curtain, cacheOf(curtain, random));
  const RestMesh pieces = soup(ball);
  add("explosion", pieces, std::make_shared<Explosion>(pieces.vertices, 0.5, random.bits()));
  return cases;
}

}  // namespace leeway::collision::motion_cases
