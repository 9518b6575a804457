#pragma once

#include "collision/deform/bounds/motion_boxes.h"
#include "collision/deform/bounds/node_bounds.h"
#include "collision/deform/motion/blended_motion.h"

namespace leeway::collision {

/// Bounding volumes of vertices that are blended from fields.
///
/// T. Larsson and T. Akenine-Moller, "Efficient collision detection for models deformed by
/// morphing", 2003: a vertex is the sum over the references of weight times position, and each
/// position is in its reference's volume of the node. So the vertex is in the sum of weights times
/// volumes, where a negative weight mirrors its volume. O(references) for each node. D. James and
/// D. Pai, "BD-Tree: output-sensitive collision detection for reduced deformation models", 2004:
/// the sum is that of the rest shape's volume (the base) and a volume of displacements for every
/// mode.
///
/// A box is an interval along each axis. An 18-DOP has six more, along the diagonals of the
/// coordinate planes. Centres of balls are blended like vertices, and radii by the magnitudes of
/// the weights.
class BlendedBounds final : public NodeBounds {
 public:
  BlendedBounds(const BlendedMotion& motion, const DeformTree& tree, DeformVolume volume,
                std::int32_t nodes);
  /// The boxes; with kBall, the boxes around the balls.
  void bound(std::int32_t node, std::span<const double> parameters, WideBox& box) const override;
  /// Not available with kBall.
  void displacement(std::int32_t node, std::span<const double> from, std::span<const double> to,
                    double rounding, WideBox& box) const override;
  double displacementRounding(std::span<const double> from,
                              std::span<const double> to) const override;
  bool hasVolumes() const override { return volume_ != DeformVolume::kBox; }
  std::size_t bytes() const override;
  void tighten(std::int32_t node, std::span<const double> parameters, const Probe& probe,
               WideBounds& bounds) const override;

 private:
  static constexpr int kDiagonals = 6;
  /// Intervals along x + y, x - y, y + z, y - z, z + x, z - x (not normalised).
  struct Diagonals {
    float low[kDiagonals][kWidth], high[kDiagonals][kWidth];
  };
  struct Balls {
    float center[3][kWidth], radius[kWidth];
  };
  struct BlendedBalls {
    double center[3][kWidth], radius[kWidth];
  };

  /// Boxes of some fields, node by node, without the axes along which a field is 0 everywhere.
  struct Boxes {
    std::vector<std::uint8_t> axes;  ///< one for each field: a bit for each of x, y, z that is kept
    std::vector<AxisRow> rows;       ///< node by node, field by field, axis by axis
    std::size_t rows_a_node = 0;

    void addField(const BlendedMotion::Field& field);
    /// Prefetches the rows of a node, if there is such a node.
    void fetch(std::int32_t node) const;
    /// Appends the rows of a field in a node; called node by node, field by field.
    void addNode(const BlendedMotion::Field& field, std::size_t number, const DeformTree& tree,
                 std::int32_t node);
    /// Adds the boxes of the node's fields, each times its parameter in `to` (or in to - from, if
    /// `from` is not empty). If there is one more field than parameters in `to`, the first field is
    /// multiplied by *first, or skipped if `first` is null.
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
                          WideBounds& bounds) const;
  void tightenByBalls(std::int32_t node, std::span<const double> parameters, const Probe& probe,
                      WideBounds& bounds) const;
  /// The weight of a node's volume i: 1 for the base, which is the first one.
  double weight(std::span<const double> parameters, std::size_t i) const {
    return !has_base_ ? parameters[i] : i == 0 ? 1 : parameters[i - 1];
  }
  std::size_t volumesOfNode() const { return fields_ + (has_base_ ? 1 : 0); }

  DeformVolume volume_;
  std::size_t fields_;
  bool has_base_;
  // For each node that of the base, if there is one, then one for each field. No boxes with kBall.
  Boxes boxes_;
  std::vector<Diagonals> diagonals_;
  std::vector<Balls> balls_;
  Boxes differences_;  // without a base: of the mean of the fields, then of each field minus the
                       // mean
  std::vector<std::uint8_t> children_;  // children of each node
  double base_size_ = 0;
  std::vector<double> field_sizes_;  // largest |coordinate| [m]
};

}  // namespace leeway::collision
