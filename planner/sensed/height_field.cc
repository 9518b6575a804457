#include "leeway/planner/height_field.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/base/tolerances.h"
#include "leeway/collision/invalid_shape.h"
#include "leeway/collision/triangle_mesh.h"
#include "planner/sensed/cloud_source.h"
#include "planner/sensed/gray_image.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

using collision::InvalidShape;
using collision::kLargestSize;
using collision::kSmallestSize;
using collision::TriangleMesh;
using Eigen::Vector3d;

constexpr std::size_t kMostSamples = std::size_t{1} << 20U;  // their hierarchy has two gigabytes

bool isNumber(double value) { return std::abs(value) <= kLargestSize; }

void requireAccepted(const HeightField& field) {
  if (field.columns < 2 || field.rows < 2 || field.rows > kMostSamples / field.columns)
    throw InvalidShape(
        fmt::format("a height field of {} columns and {} rows; at least 2 of each and at most {} "
                    "samples in all are accepted",
                    field.columns, field.rows, kMostSamples));
  if (field.heights.size() != field.columns * field.rows)
    throw InvalidShape(fmt::format("{} heights for {} columns and {} rows; {} are expected",
                                   field.heights.size(), field.columns, field.rows,
                                   field.columns * field.rows));
  const auto requireStep = [](char axis, double step, std::size_t count) {
    if (std::abs(step) >= kSmallestSize && isNumber(step * static_cast<double>(count))) return;
    throw InvalidShape(fmt::format(
        "samples that are {} m apart in {}; {} to {} m, either way, and a field of up to {} m are "
        "accepted",
        step, axis, kSmallestSize, kLargestSize, kLargestSize));
  };
  requireStep('x', field.step_x, field.columns);
  requireStep('y', field.step_y, field.rows);
  if (!isNumber(field.floor))
    throw InvalidShape(fmt::format("floor {}; up to {} m is accepted", field.floor, kLargestSize));
  for (std::size_t i = 0; i < field.heights.size(); ++i) {
    const double height = field.heights[i];
    if (isNumber(height) && height - field.floor >= kSmallestSize) continue;
    throw InvalidShape(fmt::format(
        "the height in row {}, column {} is {}; numbers above the floor, {}, and up to {} m are "
        "accepted",
        i / field.columns, i % field.columns, height, field.floor, kLargestSize));
  }
}

/// The samples along the edge of the field, once around: (0, 0), then along x.
std::vector<std::array<std::size_t, 2>> rimOf(std::size_t columns, std::size_t rows) {
  std::vector<std::array<std::size_t, 2>> rim;
  for (std::size_t c = 0; c + 1 < columns; ++c) rim.push_back({c, 0});
  for (std::size_t r = 0; r + 1 < rows; ++r) rim.push_back({columns - 1, r});
  for (std::size_t c = columns - 1; c > 0; --c) rim.push_back({c, rows - 1});
  for (std::size_t r = rows - 1; r > 0; --r) rim.push_back({0, r});
  return rim;
}

std::vector<double> scaled(const GrayImage& image, double scale, double offset) {
  std::vector<double> heights;
  heights.reserve(image.values.size());
  for (const std::uint16_t value : image.values) heights.push_back(offset + scale * value);
  return heights;
}

}  // namespace

collision::Shape heightFieldShape(const HeightField& field) {
  requireAccepted(field);
  const std::size_t columns = field.columns, rows = field.rows;
  const auto place = [&](std::size_t c, std::size_t r, double z) {
    return Vector3d(static_cast<double>(c) * field.step_x, static_cast<double>(r) * field.step_y,
                    z);
  };
  std::vector<Vector3d> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    triangles.push_back(
        {static_cast<std::int32_t>(a), static_cast<std::int32_t>(b), static_cast<std::int32_t>(c)});
  };
  const auto sample = [&](std::size_t c, std::size_t r) { return r * columns + c; };
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c)
      vertices.push_back(place(c, r, field.heights[sample(c, r)]));
  for (std::size_t r = 0; r + 1 < rows; ++r)
    for (std::size_t c = 0; c + 1 < columns; ++c) {
      add(sample(c, r), sample(c + 1, r), sample(c + 1, r + 1));
      add(sample(c, r), sample(c + 1, r + 1), sample(c, r + 1));
    }
  const auto rim = rimOf(columns, rows);
  const std::size_t first = vertices.size(), middle = first + rim.size();
  for (const auto& [c, r] : rim) vertices.push_back(place(c, r, field.floor));
  vertices.emplace_back(static_cast<double>(columns - 1) * field.step_x / 2,
                        static_cast<double>(rows - 1) * field.step_y / 2, field.floor);
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const std::size_t next = (i + 1) % rim.size();
    const std::size_t top = sample(rim[i][0], rim[i][1]),
                      next_top = sample(rim[next][0], rim[next][1]);
    add(top, first + i, first + next);
    add(top, first + next, next_top);
    add(middle, first + next, first + i);
  }
  collision::MeshOptions options;
  options.decompose = false;  // grounds have too many pieces
  return collision::Shape::mesh(TriangleMesh::make(vertices, triangles, options));
}

HeightField loadHeightField(const std::string& path, const HeightFile& file,
                            std::vector<std::string>& warnings, const robots::Stop& stop) {
  HeightField field;
  const std::string ending = robots::endingOf(path);
  if (ending == ".png" || ending == ".pgm") {
    if (!file.scale)
      throw std::invalid_argument(
          "a picture of heights without a scale; the height of a value of 1 [m] is expected");
    if (file.missing)
      throw std::invalid_argument(
          "'missing' beside a picture, which has all heights; it goes with texts only");
    const GrayImage image = readGrayImage(path, "a height field", stop);
    field.columns = image.width;
    field.rows = image.height;
    field.heights = scaled(image, *file.scale, file.offset);
    return field;
  }
  if (ending != ".csv" && ending != ".txt")
    throw robots::InputError(
        path, 0,
        fmt::format("has the ending '{}', which no format of height fields has; .csv, .txt, .png "
                    "and .pgm are accepted",
                    ending));
  const CloudSource source = readSource(path, "a height field", stop);
  const double scale = file.scale.value_or(1);
  std::size_t missing = 0, last = 0;
  eachRow(source, [&](const ColumnRow& row) {
    const CloudPlace place{last = row.line, 0};
    field.columns = row.cells.size();
    ++field.rows;
    for (const std::string_view cell : row.cells) {
      const double value = cell.empty() ? std::numeric_limits<double>::quiet_NaN()
                                        : readCoordinate(source, cell, place);
      if (std::isinf(value)) source.fail(place, "a height is infinite; a number is expected");
      if (std::isnan(value) && !file.missing)
        source.fail(place,
                    fmt::format("the height in column {} is missing; a number is expected, or "
                                "'missing', the height where none is known",
                                field.heights.size() % field.columns));
      if (std::isnan(value)) ++missing;
      field.heights.push_back(std::isnan(value) ? *file.missing : file.offset + scale * value);
    }
  });
  if (field.rows == 0)
    throw robots::InputError(path, 0, "holds no height; rows of numbers are expected");
  if (!robots::lastLineEnds(source.text()))
    warnings.push_back(fmt::format("{}:{}: {}", path, last, robots::kLastLineOpen));
  if (missing > 0)
    warnings.push_back(
        fmt::format("{}: {} heights are missing and taken as {} m", path, missing, *file.missing));
  return field;
}

}  // namespace leeway::planner
