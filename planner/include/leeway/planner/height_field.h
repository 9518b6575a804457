#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "leeway/collision/shape.h"
#include "leeway/robots/stopped.h"

namespace leeway::planner {

/// Heights on a grid: the sample in column c and row r stands at x = c * step_x, y = r * step_y of
/// the field's frame.
struct HeightField {
  std::size_t columns = 0, rows = 0;  ///< samples, at least 2 each and 2^20 in all
  std::vector<double> heights;        ///< row by row [m]
  double step_x = 0, step_y = 0;      ///< between samples [m]; below 0: the other way
  double floor = 0;                   ///< below all heights: what is solid ends there [m]
};

/// The solid below the heights, down to the floor, as a closed mesh: two triangles a cell, cut from
/// the sample in column c, row r to that in c + 1, r + 1; walls around, and a bottom. Throws
/// collision::InvalidShape for sizes, steps and heights that are not accepted. O(n log n) in
/// samples.
collision::Shape heightFieldShape(const HeightField& field);

/// How heights stand in a file.
struct HeightFile {
  std::optional<double> scale = std::nullopt;  ///< height of a value of 1 [m]; none: 1, of texts
  double offset = 0;                           ///< height of a value of 0 [m]
  /// Height where a text has "nan" or nothing [m]; none: that is refused.
  std::optional<double> missing = std::nullopt;
};

/// Reads rows and columns, and heights as offset + scale * value, from a PNG or PGM of 8 or 16 bits
/// or from a text with numbers in columns (.csv, .txt). The first row of the file is row 0. Steps
/// and floor are left as they are. Adds to `warnings` how many heights are missing. Throws
/// robots::InputError with line or byte for a damaged file, std::invalid_argument for a scale that
/// a picture lacks and `missing` beside one, robots::Stopped. O(size of the file).
HeightField loadHeightField(const std::string& path, const HeightFile& file,
                            std::vector<std::string>& warnings, const robots::Stop& stop = {});

}  // namespace leeway::planner
