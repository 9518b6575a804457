#pragma once

#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/bounds/node_bounds.h"
#include "collision/deform/motion/blended_motion.h"

namespace leeway::collision {

/// Volumes of vertices that are blended from fields. T. Larsson and T. Akenine-Moller, "Efficient
/// collision detection for models deformed by morphing", 2003: a vertex is the sum over the
/// references of weight times place, each place is in its reference's volume of the node, so the
/// vertex is in the sum of weights times volumes, a weight below 0 turning its volume round.
/// O(references) a node. D. James and D. Pai, "BD-Tree: output-sensitive collision detection for
/// reduced deformation models", 2004, is the same sum with the rest shape's volume taken once and
/// one of displacements for every mode. A box is an interval along each axis; an 18-DOP has six
/// more, along the diagonals of the axes' planes; of balls, centres are blended as vertices are,
/// and radii by the weights' magnitudes.
class BlendedBounds final : public NodeBounds {
 public:
  BlendedBounds(const BlendedMotion& motion, const DeformTree& tree, DeformVolume volume,
                std::int32_t nodes);
  /// The boxes; those around the balls where there are no others.
  void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const override;
  /// Not where there are balls.
  void displacement(std::int32_t node, std::span<const double> from, std::span<const double> to,
                    double rounding, WideBox& box) const override;
  double displacementRounding(std::span<const double> from,
                              std::span<const double> to) const override;
  bool hasVolumes() const override { return volume_ != DeformVolume::kBox; }
  std::size_t bytes() const override;
  void tighten(std::int32_t node, std::span<const double> parameters, const Probe& probe,
               Bounds& bounds) const override;

 private:
  static constexpr int kDiagonals = 6;
  /// Intervals along x + y, x - y, y + z, y - z, z + x, z - x (not divided by the root of 2).
  struct Diagonals {
    float low[kDiagonals][kWidth], high[kDiagonals][kWidth];
  };
  struct Balls {
    float center[3][kWidth], radius[kWidth];
  };
  struct BlendedBalls {
    double center[3][kWidth], radius[kWidth];
  };

  /// Boxes of some fields, node by node; axes along which a field is 0 everywhere are left out.
  struct Boxes {
    std::vector<std::uint8_t> axes;  ///< one a field: those of x, y, z that are there, a bit each
    std::vector<AxisRow> rows;       ///< a node: field by field, axis by axis
    std::size_t rows_a_node = 0;

    void addField(const BlendedMotion::Field& field);
    /// Starts to bring near the rows of a node, if there is one.
    void fetch(std::int32_t node) const;
    /// To be called field by field.
    void addNode(const BlendedMotion::Field& field, std::size_t number, const DeformTree& tree,
                 std::int32_t node);
    /// Adds those of the first field times `first`, if there is one, and of the others times the
    /// parameters `to`, or what they are more than `from` where that is not empty.
    void blend(std::int32_t node, const double* first, std::span<const double> to,
               std::span<const double> from, BoxSum& sum) const;
  };

  static Diagonals diagonalsOf(const BlendedMotion::Field& field, const DeformTree& tree,
                               std::int32_t node);
  static Balls ballsOf(const BlendedMotion::Field& field, const DeformTree& tree,
                       std::int32_t node);
  double rounding(std::span<const double> parameters) const;
  BlendedBalls blendBalls(std::int32_t node, std::span<const double> parameters) const;
  void boundBoxes(std::int32_t node, std::span<const double> parameters, WideBox& box) const;
  void tightenByDiagonals(std::int32_t node, std::span<const double> parameters, const Probe& probe,
                          Bounds& bounds) const;
  void tightenByBalls(std::int32_t node, std::span<const double> parameters, const Probe& probe,
                      Bounds& bounds) const;
  /// The coordinate of field `i` of those that a node has volumes of: 1 for the base.
  double weight(std::span<const double> parameters, std::size_t i) const {
    return !has_base_ ? parameters[i] : i == 0 ? 1 : parameters[i - 1];
  }
  std::size_t volumesOfNode() const { return fields_ + (has_base_ ? 1 : 0); }

  DeformVolume volume_;
  std::size_t fields_;
  bool has_base_;
  // A node: the base's if there is one, then one a field. No boxes where there are balls.
  Boxes boxes_;
  std::vector<Diagonals> diagonals_;
  std::vector<Balls> balls_;
  Boxes differences_;                // without a base; a node: the mean's, then one a field's
  std::vector<std::uint8_t> lanes_;  // one a node: how many children it has
  double base_size_ = 0;
  std::vector<double> field_sizes_;  // largest |coordinate| [m]
};

}  // namespace leeway::collision
