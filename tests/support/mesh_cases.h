#pragma once

// Seeded bodies and poses for the tests of hulls and meshes.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/mesh_files.h"
#include "tests/support/sanitized.h"

namespace leeway::collision::testing {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// In [low, high), equal on every platform.
  double uniform(double low = -1, double high = 1) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int below(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  Eigen::Vector3d vector() {
    const double x = uniform(), y = uniform(), z = uniform();
    return {x, y, z};
  }
  Eigen::Vector3d direction() {
    for (;;) {
      const Eigen::Vector3d v = vector();
      if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
  }
  Pose pose(double reach) {
    Pose pose;
    Eigen::Vector4d q;
    do {
      for (int k = 0; k < 4; ++k) q[k] = uniform();
    } while (q.norm() > 1 || q.norm() < 0.1);
    q.normalize();
    pose.rotation = Eigen::Quaterniond(q).toRotationMatrix();
    pose.translation = reach * vector();
    return pose;
  }

 private:
  std::mt19937_64 engine_;
};

inline void append(TriangleSoup& soup, const TriangleSoup& part, const Pose& X = {}) {
  const auto first = static_cast<std::int32_t>(soup.vertices.size());
  for (const auto& v : part.vertices) soup.vertices.push_back(X * v);
  for (auto t : part.triangles) {
    for (auto& i : t) i += first;
    soup.triangles.push_back(t);
  }
}

inline TriangleSoup boxSoup(const Eigen::Vector3d& half,
                            const Eigen::Vector3d& center = Eigen::Vector3d::Zero()) {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    soup.vertices.push_back(center + half.cwiseProduct(sign));
  }
  soup.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return soup;
}

/// A grid over two angles, closed in both: a torus, bumpy unless `bumps` is 0. Concave.
inline TriangleSoup torusSoup(int around, int across, double big, double small, double bumps,
                              Random& random) {
  TriangleSoup soup;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * 3.14159265358979 * i / around, v = 2 * 3.14159265358979 * j / across;
      const double r = small * (1 + bumps * random.uniform());
      soup.vertices.emplace_back((big + r * std::cos(v)) * std::cos(u),
                                 (big + r * std::cos(v)) * std::sin(u), r * std::sin(v));
    }
  }
  const auto at = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

/// A sphere of rings whose radius varies by `bumps`; convex when that is 0.
inline TriangleSoup ballSoup(int rings, int sectors, double radius, double bumps, Random& random) {
  TriangleSoup soup;
  soup.vertices.emplace_back(0, 0, radius);
  for (int i = 1; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double a = 3.14159265358979 * i / rings, b = 2 * 3.14159265358979 * j / sectors;
      const double r = radius * (1 + bumps * random.uniform());
      soup.vertices.emplace_back(r * std::sin(a) * std::cos(b), r * std::sin(a) * std::sin(b),
                                 r * std::cos(a));
    }
  }
  soup.vertices.emplace_back(0, 0, -radius);
  const auto at = [&](int i, int j) { return 1 + (i - 1) * sectors + j % sectors; };
  const int last = static_cast<int>(soup.vertices.size()) - 1;
  for (int j = 0; j < sectors; ++j) {
    soup.triangles.push_back({0, at(1, j), at(1, j + 1)});
    soup.triangles.push_back({last, at(rings - 1, j + 1), at(rings - 1, j)});
    for (int i = 1; i + 1 < rings; ++i) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

/// Each triangle with its own corners, as in STL.
inline TriangleSoup unwelded(const TriangleSoup& soup) {
  TriangleSoup result;
  for (const auto& t : soup.triangles) {
    const auto first = static_cast<std::int32_t>(result.vertices.size());
    for (const std::int32_t v : t)
      result.vertices.push_back(soup.vertices[static_cast<std::size_t>(v)]);
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

struct NamedMesh {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;
};

inline NamedMesh named(const std::string& name, const TriangleSoup& soup) {
  return {name, TriangleMesh::make(soup.vertices, soup.triangles)};
}

/// Bodies of about 1 m: convex and concave, closed and open, single and multiple components,
/// degenerate. Coarser under sanitizers, which are ten times slower.
inline std::vector<NamedMesh> sampleMeshes(std::uint64_t seed) {
  Random random(seed);
  std::vector<NamedMesh> meshes;
  meshes.push_back(named("box", boxSoup({0.5, 0.3, 0.2})));
  meshes.push_back(named("ball", ballSoup(8, 12, 0.5, 0, random)));
  meshes.push_back(named("bumpy ball", unwelded(ballSoup(kSanitized ? 6 : 9, kSanitized ? 8 : 14,
                                                         0.6, 0.25, random))));
  meshes.push_back(
      named("torus", torusSoup(kSanitized ? 14 : 24, kSanitized ? 6 : 10, 0.6, 0.2, 0.1, random)));
  TriangleSoup nested = boxSoup({0.6, 0.6, 0.6});
  append(nested, boxSoup({0.2, 0.2, 0.2}), random.pose(0.1));
  append(nested, ballSoup(5, 8, 0.2, 0.2, random), {Eigen::Matrix3d::Identity(), {1.2, 0, 0}});
  meshes.push_back(named("several", unwelded(nested)));
  TriangleSoup open = torusSoup(kSanitized ? 12 : 16, kSanitized ? 6 : 8, 0.5, 0.2, 0.3, random);
  open.triangles.erase(open.triangles.begin() + 20, open.triangles.begin() + 60);
  meshes.push_back(named("open", open));
  TriangleSoup loose;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d center = random.vector();
    const auto first = static_cast<std::int32_t>(loose.vertices.size());
    for (int k = 0; k < 3; ++k) loose.vertices.push_back(center + 0.2 * random.vector());
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  meshes.push_back(named("loose triangles", loose));
  meshes.push_back(named("one triangle", {{{0, 0, 0}, {0.5, 0, 0.1}, {0, 0.4, 0}}, {{0, 1, 2}}}));
  meshes.push_back(named("needle", {{{0, 0, 0}, {0.5, 0.25, 0.125}, {1, 0.5, 0.25}}, {{0, 1, 2}}}));
  meshes.push_back(named("point", {{{0.1, 0.2, 0.3}}, {{0, 0, 0}}}));
  TriangleSoup flat;
  const int corners = kSanitized ? 30 : 100;
  for (int i = 0; i < corners; ++i) {
    const double a = 2 * 3.14159265358979 * i / corners;
    flat.vertices.emplace_back(std::cos(a), std::sin(a), 0.0);
  }
  for (int i = 2; i < corners; ++i) flat.triangles.push_back({0, i - 1, i});
  meshes.push_back(named("flat disc", flat));
  return meshes;
}

inline std::vector<std::pair<std::string, Shape>> sampleConvexShapes(Random& random) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 20; ++i) points.push_back(0.3 * random.vector() + Eigen::Vector3d(0.2, 0, 0));
  return {{"sphere", Shape::sphere(0.2)},
          {"point", Shape::sphere(0)},
          {"capsule", Shape::capsule(0.1, 0.4)},
          {"box", Shape::box({0.3, 0.2, 0.1})},
          {"cylinder", Shape::cylinder(0.2, 0.3)},
          {"cone", Shape::cone(0.25, 0.3)},
          {"ellipsoid", Shape::ellipsoid({0.3, 0.2, 0.1})},
          {"hull", Shape::convexHull(points)},
          {"half-space", Shape::halfSpace()}};
}

/// Winding number of a component around p by solid angles: slow twin of exact crossing counts.
inline double windingAround(const TriangleMesh& mesh, int component, const Eigen::Vector3d& p) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.triangles().size(); ++i) {
    if (mesh.component(static_cast<int>(i)) != component) continue;
    const auto at = [&](std::size_t k) {
      return Eigen::Vector3d(mesh.vertices()[static_cast<std::size_t>(mesh.triangles()[i][k])] - p);
    };
    const Eigen::Vector3d a = at(0), b = at(1), c = at(2);
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)),
                          la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

}  // namespace leeway::collision::testing
