#pragma once

// Seeded deforming meshes for tests.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision::testing {

/// Brute force is slow under sanitizers, so out of six frames they run the even ones, which cover
/// every kind.
inline constexpr int kFrameStep = kSanitized ? 2 : 1;

struct Sheet {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
};

/// A square cloth of n x n cells on z = 0, side 2, centred at the origin; `numbered` shuffles its
/// vertices.
inline Sheet cloth(int n, oracle::Random* numbered = nullptr) {
  Sheet sheet;
  const auto count = static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 1);
  std::vector<std::int32_t> number(count);
  for (std::size_t i = 0; i < count; ++i) number[i] = static_cast<std::int32_t>(i);
  if (numbered != nullptr) {
    for (std::size_t i = count; i > 1; --i)
      std::swap(number[i - 1],
                number[static_cast<std::size_t>(numbered->below(static_cast<int>(i)))]);
  }
  sheet.vertices.resize(count);
  const auto at = [&](int i, int j) { return number[static_cast<std::size_t>(i * (n + 1) + j)]; };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      sheet.vertices[static_cast<std::size_t>(at(i, j))] = {2.0 * i / n - 1, 2.0 * j / n - 1, 0};
      if (i == n || j == n) continue;
      sheet.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      sheet.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return sheet;
}

/// A closed sphere of radius 1: n rings of 2 n vertices and two poles.
inline Sheet globe(int n) {
  Sheet sheet;
  const double pi = std::acos(-1.0);
  sheet.vertices.push_back({0, 0, 1});
  for (int i = 1; i <= n; ++i) {
    for (int j = 0; j < 2 * n; ++j) {
      const double theta = pi * i / (n + 1), phi = pi * j / n;
      sheet.vertices.push_back(
          {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    }
  }
  sheet.vertices.push_back({0, 0, -1});
  const auto at = [&](int i, int j) { return 1 + i * 2 * n + j % (2 * n); };
  const auto last = static_cast<std::int32_t>(sheet.vertices.size()) - 1;
  for (int j = 0; j < 2 * n; ++j) {
    sheet.triangles.push_back({0, at(0, j), at(0, j + 1)});
    sheet.triangles.push_back({last, at(n - 1, j + 1), at(n - 1, j)});
    for (int i = 0; i + 1 < n; ++i) {
      sheet.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      sheet.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return sheet;
}

/// Waves of the given height; the phase changes their form.
inline std::vector<Eigen::Vector3d> waved(std::span<const Eigen::Vector3d> rest, double height,
                                          double phase) {
  std::vector<Eigen::Vector3d> moved(rest.begin(), rest.end());
  for (Eigen::Vector3d& p : moved) {
    const Eigen::Vector3d r = p;
    p.z() += height * std::sin(3 * r.x() + phase) * std::cos(2 * r.y() - 0.7 * phase);
    p.x() += 0.3 * height * std::sin(2 * r.y() + 1.3 * phase);
  }
  return moved;
}

/// Each vertex displaced in its own direction, `far` on average.
inline std::vector<Eigen::Vector3d> exploded(std::span<const Eigen::Vector3d> rest, double far,
                                             std::uint64_t seed) {
  oracle::Random random(seed);
  std::vector<Eigen::Vector3d> moved(rest.begin(), rest.end());
  for (Eigen::Vector3d& p : moved) p += 2 * far * random.unit() * random.direction();
  return moved;
}

inline const std::vector<DeformStrategy>& strategiesWithoutMotion() {
  static const std::vector<DeformStrategy> all = {
      DeformStrategy::kRebuild, DeformStrategy::kRebuildLinear, DeformStrategy::kRefit,
      DeformStrategy::kHybrid,  DeformStrategy::kLazy,          DeformStrategy::kRestructure,
      DeformStrategy::kOctree,  DeformStrategy::kAuto};
  return all;
}

/// Options of a strategy; hybrid trees get lower levels even for small meshes.
inline DeformOptions optionsOf(DeformStrategy strategy) {
  DeformOptions options;
  options.strategy = strategy;
  options.hybrid_split = 40;
  return options;
}

}  // namespace leeway::collision::testing
