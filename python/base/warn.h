#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace leeway::python {

/// Raises a UserWarning at the line of Python that called.
inline void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw pybind11::error_already_set();
}

}  // namespace leeway::python
