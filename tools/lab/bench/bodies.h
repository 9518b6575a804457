#pragma once

// Triangle meshes generated for measurements.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "leeway/collision/triangle_mesh.h"

namespace leeway::bench {

struct Soup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<collision::TriangleMesh::Triangle> triangles;
};

/// A grid of `along` rings of `around` points. Each end is closed by a point, or the last ring is
/// joined to the first.
inline Soup rings(int along, int around, bool joined,
                  const std::function<Eigen::Vector3d(double, double)>& at) {
  Soup soup;
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < around; ++j) {
      const double u = joined ? static_cast<double>(i) / along : (i + 0.5) / along;
      soup.vertices.push_back(at(u, 2 * std::numbers::pi * j / around));
    }
  }
  const auto index = [&](int i, int j) { return (i % along) * around + j % around; };
  for (int i = 0; i < (joined ? along : along - 1); ++i) {
    for (int j = 0; j < around; ++j) {
      soup.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      soup.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  if (joined) return soup;
  const int first = static_cast<int>(soup.vertices.size());
  soup.vertices.push_back(at(0, 0));
  soup.vertices.push_back(at(1, 0));
  for (int j = 0; j < around; ++j) {
    soup.triangles.push_back({first, index(0, j), index(0, j + 1)});
    soup.triangles.push_back({first + 1, index(along - 1, j + 1), index(along - 1, j)});
  }
  return soup;
}

/// A robot arm's link: two thick joints, a bent, thinner tube between them. Closed, concave.
inline Soup link(int along, int around) {
  return rings(along, around, false, [](double u, double v) -> Eigen::Vector3d {
    const double bend = 1.2 * (u - 0.5);
    const Eigen::Vector3d center(0.35 * std::sin(bend), 0, 0.35 * (1 - std::cos(bend)));
    const Eigen::Vector3d across(std::sin(bend), 0, -std::cos(bend));
    const double end = std::min(u, 1 - u);
    double radius = end < 0.25 ? 0.07 : 0.045;
    if (end < 0.04) radius *= end / 0.04;
    return center + radius * (std::cos(v) * across + std::sin(v) * Eigen::Vector3d::UnitY());
  });
}

inline Soup torus(int along, int around) {
  return rings(along, around, true, [](double u, double v) -> Eigen::Vector3d {
    const double r = 0.2 + 0.07 * std::cos(v);
    return {r * std::cos(2 * std::numbers::pi * u), r * std::sin(2 * std::numbers::pi * u),
            0.07 * std::sin(v)};
  });
}

inline Soup bumpyBall(int along, int around) {
  return rings(along, around, false, [](double u, double v) -> Eigen::Vector3d {
    const double a = std::numbers::pi * u;
    const double r = 0.2 * (1 + 0.1 * std::sin(9 * a) * std::sin(7 * v) * std::sin(a));
    return {r * std::sin(a) * std::cos(v), r * std::sin(a) * std::sin(v), r * std::cos(a)};
  });
}

/// Two balls on a rod.
inline Soup dumbbell(int along, int around) {
  const double cut = std::asin(0.3);
  return rings(along, around, false, [cut](double u, double v) -> Eigen::Vector3d {
    const double side = u < 0.5 ? -1 : 1, end = 1 - std::abs(2 * u - 1);  // 0 at the ends
    const double a = std::min(end / 0.9, 1.0) * (std::numbers::pi - cut);
    const double x =
        end < 0.9 ? 0.15 + 0.1 * std::cos(a) : (0.15 - 0.1 * std::cos(cut)) * (1 - end) / 0.1;
    const double r = end < 0.9 ? 0.1 * std::sin(a) : 0.03;
    return {side * x, r * std::cos(v), r * std::sin(v)};
  });
}

/// A disc with ten teeth.
inline Soup gear(int along, int around) {
  return rings(along, around, false, [](double u, double v) -> Eigen::Vector3d {
    const double phase = std::fmod(10 * v / (2 * std::numbers::pi), 1.0);
    const double profile = phase < 0.35 ? 0.2 : phase < 0.85 ? 0.16 : 0.2;
    const double r = u > 0 && u < 1 ? profile : 0;
    return {r * std::cos(v), r * std::sin(v), 0.06 * (u - 0.5)};
  });
}

/// An open sheet in waves.
inline Soup cloth(int along, int across) {
  Soup soup;
  for (int i = 0; i <= along; ++i) {
    for (int j = 0; j <= across; ++j) {
      const double x = static_cast<double>(i) / along - 0.5,
                   y = static_cast<double>(j) / across - 0.5;
      soup.vertices.emplace_back(x, y, 0.03 * std::sin(19 * x) * std::cos(13 * y) + 0.1 * x * y);
    }
  }
  const auto at = [&](int i, int j) { return i * (across + 1) + j; };
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < across; ++j) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

}  // namespace leeway::bench
