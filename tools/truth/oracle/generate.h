#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::oracle {

/// SplitMix64: equal numbers on all machines for equal seeds.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits();
  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double lower, double upper) { return lower + (upper - lower) * unit(); }
  /// Log-uniform; both ends positive.
  double logUniform(double lower, double upper);
  /// Uniform in 0 .. n - 1.
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  bool chance(double p) { return unit() < p; }
  Eigen::Vector3d direction();
  Eigen::Matrix3d rotation();

 private:
  std::uint64_t state_;
};

/// The difficulty for which a shape is made.
enum class Flavour { kPlain, kThin, kZero, kTiny, kHuge, kDuplicates };
constexpr std::array<Flavour, 6> kFlavours = {Flavour::kPlain, Flavour::kThin,
                                              Flavour::kZero,  Flavour::kTiny,
                                              Flavour::kHuge,  Flavour::kDuplicates};

/// A random shape of the given type, about 0.05 to 1 m unless the flavour says otherwise. Thin: one
/// size of 1e-6; zero: one size of 0 (hulls: flat); tiny: 1e-3 to 1e-6; huge: 1e3; duplicates:
/// hulls with equal or nearly equal points. Meshes: closed tetrahedra, boxes, an L-shaped solid,
/// open sheets.
collision::Shape randomShape(Random& random, collision::ShapeType type, Flavour flavour);

/// Closed solids and open surfaces with known insides.
std::shared_ptr<const collision::TriangleMesh> boxMesh(const Eigen::Vector3d& half_extents);
std::shared_ptr<const collision::TriangleMesh> ellMesh(
    double size);  ///< concave: an L of two boxes
std::shared_ptr<const collision::TriangleMesh> sheetMesh(Random& random, double size,
                                                         int cells);  ///< open, wavy

/// A shape's size: its bounding radius, 1 for a half-space.
double sizeOf(const collision::Shape& shape);

/// C++ code that recreates the shape, and a pose's numbers, at 17 digits: printed by failed tests.
std::string replay(const collision::Shape& shape);
std::string replay(const collision::Pose& pose);

}  // namespace leeway::oracle
