#include "python/base/arrays.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

namespace leeway::python {
namespace {

/// A quaternion in a file may be off unit length by rounding, but not by a wrong order of its
/// numbers.
constexpr double kLargestNormError = 1e-3;

std::string shapeText(const py::array& array) { return py::str(array.attr("shape")); }

std::string indexText(const char* name, std::size_t index, const py::array& array) {
  std::string text;
  for (py::ssize_t axis = array.ndim() - 1; axis >= 0; --axis) {
    const auto size = static_cast<std::size_t>(array.shape(axis));
    text = std::to_string(index % size) + (text.empty() ? "" : ", ") + text;
    index /= size;
  }
  return text.empty() ? name : name + ("[" + text + "]");
}

/// The numbers of an array, checked and copied.
std::vector<double> values(const py::array& array, const char* name) {
  const auto doubles =
      py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!doubles) throw py::type_error(std::string(name) + " holds no numbers of float64");
  std::vector<double> copy(doubles.data(), doubles.data() + doubles.size());
  for (std::size_t i = 0; i < copy.size(); ++i)
    if (!std::isfinite(copy[i]))
      throw py::value_error(indexText(name, i, array) + " is " + text(copy[i]) +
                            "; a finite number is expected");
  return copy;
}

Eigen::Matrix3d rotation(double x, double y, double z, double w, const char* name) {
  const Eigen::Quaterniond q(w, x, y, z);
  if (!(std::abs(q.norm() - 1) <= kLargestNormError))
    throw py::value_error(std::string(name) + " has length " + text(q.norm()) +
                          "; a unit quaternion x y z w is expected");
  return q.normalized().toRotationMatrix();
}

}  // namespace

py::array realArray(py::handle value, const char* name) {
  const py::array array = py::array::ensure(value);
  if (!array)
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; an array of numbers is expected");
  if (py::hasattr(value, "mask") &&
      py::module_::import("numpy.ma").attr("is_masked")(value).cast<bool>())
    throw py::value_error(std::string(name) +
                          " has masked entries; an array without a mask is expected, as filled() "
                          "returns it");
  const char kind = array.dtype().kind();
  if (array.size() > 0 && kind != 'f' && kind != 'i' && kind != 'u')
    throw py::type_error(std::string(name) + " has dtype " + std::string(py::str(array.dtype())) +
                         "; real numbers are expected");
  return array;
}

std::size_t Rows::count() const { return columns == 0 ? 0 : values.size() / columns; }

Rows rows(py::handle value, const char* name, std::size_t columns, int axes) {
  const py::array array = realArray(value, name);
  const bool fits = array.ndim() >= 1 && (axes < 0 || array.ndim() <= axes) &&
                    static_cast<std::size_t>(array.shape(array.ndim() - 1)) == columns;
  if (!fits)
    throw py::value_error(std::string(name) + " has shape " + shapeText(array) + "; " +
                          (axes == 1   ? "("
                           : axes == 2 ? "(n, "
                                       : "(..., ") +
                          std::to_string(columns) + (axes == 1 ? ",)" : ")") + " is expected");
  Rows result;
  result.values = values(array, name);
  result.columns = columns;
  result.shape.assign(array.shape(), array.shape() + array.ndim() - 1);
  return result;
}

std::vector<double> numbers(py::handle value, const char* name, std::size_t columns) {
  return rows(value, name, columns, 1).values;
}

Rows scalars(py::handle value, const char* name) {
  const py::array array = realArray(value, name);
  return {values(array, name), {array.shape(), array.shape() + array.ndim()}, 1};
}

Eigen::Vector3d vector3(py::handle value, const char* name) {
  const std::vector<double> three = numbers(value, name, 3);
  return {three[0], three[1], three[2]};
}

std::vector<Eigen::Vector3d> points(py::handle value, const char* name) {
  const Rows given = rows(value, name, 3, 2);
  if (given.shape.size() != 1)
    throw py::value_error(std::string(name) + " is a single point; (n, 3) is expected");
  std::vector<Eigen::Vector3d> result(given.count());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = Eigen::Vector3d::Map(&given.values[3 * i]);
  return result;
}

std::vector<std::array<std::int32_t, 3>> triangles(py::handle value, const char* name) {
  const py::array array = realArray(value, name);
  const char kind = array.dtype().kind();
  if (array.ndim() != 2 || array.shape(1) != 3 || (kind != 'i' && kind != 'u'))
    throw py::value_error(std::string(name) + " has shape " + shapeText(array) + " and dtype " +
                          std::string(py::str(array.dtype())) +
                          "; (n, 3) whole numbers are expected");
  const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>(array);
  std::vector<std::array<std::int32_t, 3>> result(static_cast<std::size_t>(wide.shape(0)));
  for (std::size_t i = 0; i < 3 * result.size(); ++i) {
    const std::int64_t index = wide.data()[i];
    if (index < 0 || index > std::numeric_limits<std::int32_t>::max())
      throw py::value_error(indexText(name, i, array) + " is " + std::to_string(index) +
                            "; the index of a vertex is expected");
    result[i / 3][i % 3] = static_cast<std::int32_t>(index);
  }
  return result;
}

bool isTruth(py::handle value) {
  // (numpy's own is not derived from bool.)
  const std::string type = Py_TYPE(value.ptr())->tp_name;
  return py::isinstance<py::bool_>(value) || type == "numpy.bool_" || type == "numpy.bool";
}

std::string shown(py::handle value) {
  std::string text_of;
  try {
    text_of = std::string(py::repr(value)).substr(0, 100);
  } catch (const py::error_already_set&) {  // for example, too many digits
    text_of = std::string("of type ") + Py_TYPE(value.ptr())->tp_name;
  }
  std::replace(text_of.begin(), text_of.end(), '\n', ' ');
  return text_of;
}

std::uint64_t whole(py::handle value, const char* name, std::uint64_t largest) {
  const py::object index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  const unsigned long long result = index ? PyLong_AsUnsignedLongLong(index.ptr()) : 0;
  if (!index || PyErr_Occurred() != nullptr || result > largest || isTruth(value)) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + " is " + shown(value) +
                          "; a whole number of at least 0 and at most " + std::to_string(largest) +
                          " is expected");
  }
  return result;
}

double number(py::handle value, const char* name) {
  const double result = PyFloat_AsDouble(value.ptr());
  const bool fails = result == -1 && PyErr_Occurred() != nullptr;
  if (fails && PyErr_ExceptionMatches(PyExc_OverflowError) != 0) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + " is beyond 1.8e308; a finite number is expected");
  }
  if (fails || isTruth(value)) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a number is expected");
  }
  if (!std::isfinite(result))
    throw py::value_error(std::string(name) + " is " + text(result) +
                          "; a finite number is expected");
  return result;
}

collision::Pose pose(py::handle value, const char* name) {
  collision::Pose result;
  if (value.is_none()) return result;
  const py::array array = realArray(value, name);
  const bool is_matrix = array.ndim() == 2 && array.shape(0) == 4 && array.shape(1) == 4;
  if (!is_matrix && !(array.ndim() == 1 && (array.shape(0) == 3 || array.shape(0) == 7)))
    throw py::value_error(std::string(name) + " has shape " + shapeText(array) +
                          "; a position (3,), a position and quaternion (7,) or a matrix (4, 4) is "
                          "expected");
  const std::vector<double> v = values(array, name);
  if (!is_matrix) {
    result.translation << v[0], v[1], v[2];
    if (v.size() == 7) result.rotation = rotation(v[3], v[4], v[5], v[6], name);
    return result;
  }
  const auto m = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(v.data());
  result.rotation = m.topLeftCorner<3, 3>();
  result.translation = m.topRightCorner<3, 1>();
  const Eigen::Matrix3d error =
      result.rotation * result.rotation.transpose() - Eigen::Matrix3d::Identity();
  const bool last_row = v[12] == 0 && v[13] == 0 && v[14] == 0 && v[15] == 1;
  // Queries accept rotations with an error of up to this, and widen their intervals by it.
  if (!last_row || !(error.norm() <= 1e-6) || result.rotation.determinant() < 0)
    throw py::value_error(std::string(name) +
                          " is no rigid placement; a rotation and the last row 0 0 0 1 are "
                          "expected");
  return result;
}

collision::Pose givenPose(py::handle value, const char* name) {
  if (value.is_none())
    throw py::value_error(
        std::string(name) +
        " is None; a position (3,), a position and quaternion (7,) or a matrix (4, 4) is expected");
  return pose(value, name);
}

collision::Pose pose(py::handle position, py::handle orientation, py::handle rpy,
                     const collision::Pose& by_default) {
  collision::Pose result = by_default;
  if (!position.is_none()) result.translation = vector3(position, "position");
  if (!orientation.is_none() && !rpy.is_none())
    throw py::value_error("orientation and rpy are both given; one is expected");
  if (!orientation.is_none()) {
    const std::vector<double> q = numbers(orientation, "orientation", 4);
    result.rotation = rotation(q[0], q[1], q[2], q[3], "orientation");
  } else if (!rpy.is_none()) {
    const Eigen::Vector3d angles = vector3(rpy, "rpy");
    result.rotation = (Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()))
                          .toRotationMatrix();
  }
  return result;
}

py::array_t<double> array(std::vector<double> values, std::vector<py::ssize_t> shape) {
  auto owned = std::make_unique<std::vector<double>>(std::move(values));
  const double* const data = owned->data();
  const py::capsule owner(owned.release(),
                          [](void* p) { delete static_cast<std::vector<double>*>(p); });
  return py::array_t<double>(std::move(shape), data, owner);
}

py::array_t<double> array(std::span<const double> values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::array_t<double> array(const Eigen::Vector3d& vector) {
  return array(std::span<const double>(vector.data(), 3));
}

py::array_t<double> array(const std::vector<std::vector<double>>& rows, std::size_t columns) {
  std::vector<double> values;
  values.reserve(rows.size() * columns);
  for (const std::vector<double>& row : rows) values.insert(values.end(), row.begin(), row.end());
  return array(std::move(values),
               {static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(columns)});
}

namespace {

/// The type of a list that cannot be changed. Its copies are plain lists.
py::handle readOnlyList() {
  static PyObject* const type = [] {
    py::dict methods;
    const py::cpp_function refuse([](const py::args&, const py::kwargs&) {
      throw py::type_error("this list is read-only; list() makes one to change of it");
    });
    for (const char* name : {"append", "extend", "insert", "remove", "pop", "clear", "sort",
                             "reverse", "__setitem__", "__delitem__", "__iadd__", "__imul__"})
      methods[name] = refuse;
    methods["__module__"] = "leeway";
    const py::object list = py::type::of(py::list());
    py::object made = py::type::of(list)("ReadOnlyList", py::make_tuple(list), methods);
    made.attr("__reduce__") = py::cpp_function(
        [](const py::object& self) {
          return py::make_tuple(py::type::of(py::list()), py::make_tuple(py::tuple(self)));
        },
        py::is_method(made));
    return made.release().ptr();
  }();
  return type;
}

}  // namespace

py::object constant(const py::object& value) {
  if (py::isinstance<py::array>(value)) {
    value.attr("flags").attr("writeable") = false;
    return value;
  }
  const bool is_list = py::isinstance<py::list>(value);
  if (is_list || py::isinstance<py::tuple>(value)) {
    py::list items;
    for (const py::handle item : value)
      items.append(constant(py::reinterpret_borrow<py::object>(item)));
    return is_list ? readOnlyList()(items) : py::object(py::tuple(items));
  }
  if (!py::isinstance<py::dict>(value)) return value;
  py::dict result;
  for (const auto& [key, item] : py::reinterpret_borrow<py::dict>(value))
    result[key] = constant(py::reinterpret_borrow<py::object>(item));
  return py::reinterpret_steal<py::object>(PyDictProxy_New(result.ptr()));
}

namespace {

py::array readOnly(py::array array) {
  array.attr("flags").attr("writeable") = false;
  return array;
}

}  // namespace

py::array view(std::span<const Eigen::Vector3d> points, py::handle owner) {
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));
  return readOnly(py::array_t<double>({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}},
                                      points.empty() ? nullptr : points.front().data(), owner));
}

py::array view(std::span<const std::array<std::int32_t, 3>> triangles, py::handle owner) {
  return readOnly(
      py::array_t<std::int32_t>({static_cast<py::ssize_t>(triangles.size()), py::ssize_t{3}},
                                triangles.empty() ? nullptr : triangles.front().data(), owner));
}

void writeMatrix(const collision::Pose& pose, double* out) {
  auto m = Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(out);
  m.setIdentity();
  m.topLeftCorner<3, 3>() = pose.rotation;
  m.topRightCorner<3, 1>() = pose.translation;
}

py::array_t<double> matrix(const collision::Pose& pose) {
  std::vector<double> values(16);
  writeMatrix(pose, values.data());
  return array(std::move(values), {4, 4});
}

py::list listOf(const std::vector<std::string>& names) {
  py::list list;
  for (const std::string& name : names) list.append(name);
  return list;
}

std::string word(py::handle value, const char* name) {
  if (!py::isinstance<py::str>(value))
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a word is expected");
  Py_ssize_t size = 0;
  const char* const bytes = PyUnicode_AsUTF8AndSize(value.ptr(), &size);
  if (bytes != nullptr) return {bytes, static_cast<std::size_t>(size)};
  PyErr_Clear();  // half of a surrogate pair
  throw py::value_error(std::string(name) + " is " + std::string(py::str(py::repr(value))) +
                        ", which is no Unicode text; a word is expected");
}

std::string fileName(py::handle value, const char* name) {
  if (!py::isinstance<py::str>(value) && !py::hasattr(value, "__fspath__"))
    throw py::type_error(std::string(name) + " is of type " + Py_TYPE(value.ptr())->tp_name +
                         "; a file's name is expected");
  std::string file = py::str(py::module_::import("os").attr("fspath")(value));
  if (file.empty())
    throw py::value_error(std::string(name) + " is empty; a file's name is expected");
  return file;
}

std::string text(double value) { return py::repr(py::float_(value)); }

namespace {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text)
    result += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return result;
}

std::string htmlRow(const std::vector<std::string>& cells, const std::string& tag) {
  std::string row = "<tr>";
  for (const std::string& cell : cells) row += "<" + tag + ">" + escaped(cell) + "</" + tag + ">";
  return row + "</tr>";
}

}  // namespace

std::string htmlTable(const std::string& caption, const std::vector<std::string>& heading,
                      const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table><caption>" + escaped(caption) + "</caption>" + htmlRow(heading, "th");
  for (const std::vector<std::string>& row : rows) html += htmlRow(row, "td");
  return html + "</table>";
}

void unknownWord(const char* name, std::string_view word, std::string_view accepted) {
  std::string shown(word.substr(0, 100));  // for example, of an array
  std::replace(shown.begin(), shown.end(), '\n', ' ');
  throw py::value_error(std::string(name) + " is '" + shown + "'; " + std::string(accepted) +
                        " is expected");
}

}  // namespace leeway::python
