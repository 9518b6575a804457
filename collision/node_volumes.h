#pragma once

// Private to collision/: balls and 18-DOPs of sets of vertices from the structure of a motion,
// where a box does not fit well. NodeBounds has the boxes that queries descend through.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/blended_motion.h"
#include "collision/skinned_motion.h"

namespace leeway::collision {

struct BoundingBall {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // [m]
  double radius = 0;                                 // [m]
};

/// Intervals along x, y, z, x + y, x - y, y + z, y - z, z + x and z - x (not unit vectors).
struct Dop18 {
  static constexpr std::size_t kDirections = 9;
  std::array<double, kDirections> low{}, high{};
};
/// The nine products of a point with those directions.
std::array<double, Dop18::kDirections> alongDop(const Eigen::Vector3d& p);

/// The volumes of some vertices of a blended motion: the references' volumes blended as the
/// vertices are (Larsson and Akenine-Moller 2003); for reduced motions the BD-tree's spheres (James
/// and Pai 2004), the rest ball displaced by the mean of every mode and grown by coordinate times
/// the mode's largest departure from its mean. O(fields) an answer; holds the vertices as evaluated
/// for these parameters, rounding included.
class BlendedVolumes {
 public:
  BlendedVolumes(const BlendedMotion& motion, std::span<const std::int32_t> vertices);
  BoundingBall ball(std::span<const double> parameters) const;
  Dop18 dop(std::span<const double> parameters) const;

 private:
  struct Field {
    BoundingBall ball;
    Dop18 dop;
    double size;  // largest |coordinate| [m]
  };
  double rounding(std::span<const double> parameters) const;
  std::vector<Field> fields_;  // the base's first, if there is one
  bool has_base_;
};

/// The ball of some vertices of a skinned motion: Kavan and Zara 2005 (derived in the source).
/// O(bones of the vertices) an answer, which holds as above.
class SkinnedBall {
 public:
  SkinnedBall(const SkinnedVertices& motion, std::span<const std::int32_t> vertices);
  BoundingBall ball(std::span<const double> parameters) const;

 private:
  struct Part {
    std::int32_t bone;
    double mean, range;  // every weight is within `range` of `mean`; the means add up to 1
  };
  BoundingBall rest_;
  std::vector<Part> parts_;
  double terms_ = 0;  // most weights of a vertex, or parts
};

}  // namespace leeway::collision
