#pragma once

// Conversions between numpy and the library. Every input is checked, and copied before the
// interpreter's lock is released, because another thread may change or resize an array meanwhile.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/collision/pose.h"

namespace leeway::python {

namespace py = pybind11;

/// Rows of numbers, and the caller's shape without its last axis.
struct Rows {
  std::vector<double> values;
  std::vector<py::ssize_t> shape;
  std::size_t columns = 0;

  std::size_t count() const;
  std::span<const double> row(std::size_t i) const { return {&values[i * columns], columns}; }
};

/// `value` as an array of real numbers, which may be infinite or NaN, of any shape. Throws
/// TypeError for other types, ValueError for a masked array with masked entries.
py::array realArray(py::handle value, const char* name);
/// `value` as finite float64 numbers, with `columns` in the last axis. Other axes are free, or
/// there are at most `axes` - 1 of them. Throws ValueError or TypeError with a one-line message
/// that begins with `name`.
Rows rows(py::handle value, const char* name, std::size_t columns, int axes = -1);
/// One row.
std::vector<double> numbers(py::handle value, const char* name, std::size_t columns);
/// Numbers of any shape: `columns` is 1, `shape` is that of `value`.
Rows scalars(py::handle value, const char* name);
Eigen::Vector3d vector3(py::handle value, const char* name);
std::vector<Eigen::Vector3d> points(py::handle value, const char* name);  ///< of shape (n, 3)
std::vector<std::array<std::int32_t, 3>> triangles(py::handle value, const char* name);
/// A finite number, which is not True or False.
double number(py::handle value, const char* name);
/// Whether `value` is True or False, of Python or numpy.
bool isTruth(py::handle value);
/// A whole number from 0 to `largest`; no float, True or False. Throws ValueError.
std::uint64_t whole(py::handle value, const char* name, std::uint64_t largest);
template <class Integer>
Integer whole(py::handle value, const char* name) {
  return static_cast<Integer>(
      whole(value, name, std::uint64_t{std::numeric_limits<Integer>::max()}));
}
/// A text. Throws TypeError for what is none, ValueError for characters that are no Unicode.
std::string word(py::handle value, const char* name);
/// A wrong value for messages, in one line.
std::string shown(py::handle value);

/// None, a position (3), a position and a quaternion x y z qx qy qz qw (7), or a matrix (4, 4).
collision::Pose pose(py::handle value, const char* name);
/// The same, but throws ValueError for None: a thing that was not found is nowhere.
collision::Pose givenPose(py::handle value, const char* name);
/// As in problem files: a position, and a quaternion x y z w, or angles roll, pitch, yaw. What is
/// None is as in `by_default`.
collision::Pose pose(py::handle position, py::handle orientation, py::handle rpy,
                     const collision::Pose& by_default = {});

/// An array of float64 that owns `values`, without a copy.
py::array_t<double> array(std::vector<double> values, std::vector<py::ssize_t> shape);
py::array_t<double> array(const Eigen::Vector3d& vector);
py::array_t<double> array(std::span<const double> values);
/// Rows of equal length; `columns` is the length if the list is empty.
py::array_t<double> array(const std::vector<std::vector<double>>& rows, std::size_t columns);
/// A read-only view of (n, 3) numbers that `owner` keeps alive.
py::array view(std::span<const Eigen::Vector3d> points, py::handle owner);
py::array view(std::span<const std::array<std::int32_t, 3>> triangles, py::handle owner);
/// Writes a matrix (4, 4), row by row.
void writeMatrix(const collision::Pose& pose, double* out);
py::array_t<double> matrix(const collision::Pose& pose);

/// A list of strings.
py::list listOf(const std::vector<std::string>& names);
/// Returns an object with the content of `value` that cannot be changed: lists whose methods refuse
/// it, mapping proxies for dicts, read-only arrays, and the same for their elements. Copies of it
/// may be changed.
py::object constant(const py::object& value);
/// A str or os.PathLike.
std::string fileName(py::handle value, const char* name);

/// A number in the shortest form that reads back the same, for texts: "0.1", "inf".
std::string text(double value);
/// A table in HTML for notebooks. Cells are escaped.
std::string htmlTable(const std::string& caption, const std::vector<std::string>& heading,
                      const std::vector<std::vector<std::string>>& rows);
/// The value of a word, or a ValueError that lists the accepted words.
[[noreturn]] void unknownWord(const char* name, std::string_view word, std::string_view accepted);

}  // namespace leeway::python
