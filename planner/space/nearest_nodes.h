#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "leeway/planner/configuration_space.h"

namespace leeway::planner {

/// Points of a configuration space in single precision, in blocks of kBlock that are compared in
/// parallel. The distance is that of ConfigurationSpace to within rounding, except for rotations:
/// twice the chord between their quaternions, which is up to a tenth less than the angle and has
/// the same order. Every instruction set gives the same answers.
class NearestNodes {
 public:
  static constexpr std::size_t kBlock = 16;

  explicit NearestNodes(const ConfigurationSpace& space);

  /// Points get the numbers 0, 1, 2 ... O(size of a point), amortised.
  void add(std::span<const double> point);
  std::size_t size() const { return size_; }

  struct Nearest {
    std::uint32_t node = 0;
    float distance = 0;
  };
  /// The node nearest to a point; for equal distances the first. At least one node must exist.
  /// O(nodes).
  Nearest nearest(std::span<const double> point) const;

  /// The order of a point's numbers in a block: first lines, then circles, then rotations of four.
  struct Layout {
    std::size_t lines = 0, circles = 0, rotations = 0;
    std::size_t rows() const { return lines + circles + 4 * rotations; }
  };

 private:
  void write(std::span<const double> point, float* first, std::size_t stride) const;

  Layout layout_;
  std::vector<std::size_t> order_;  ///< row -> index into the point
  std::vector<float> weight_;       ///< of each row
  std::vector<float> turn_;         ///< of each row: a whole turn, or 8 times a squared weight
  std::vector<float> rows_;         ///< block by block, row by row, kBlock floats each
  std::size_t size_ = 0;
  mutable std::vector<float> query_;
};

}  // namespace leeway::planner
