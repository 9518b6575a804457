#pragma once

// Private: the tracking error that a Guard and a Replanner are given.

#include <vector>

#include "python/base/arrays.h"

namespace leeway::python {

/// A number for all joints, or one each; empty for None.
inline std::vector<double> jointErrors(const py::object& given, std::size_t size) {
  if (given.is_none()) return {};
  if (scalars(given, "joint_errors").shape.empty())
    return std::vector<double>(size, number(given, "joint_errors"));
  return numbers(given, "joint_errors", size);
}

}  // namespace leeway::python
