#pragma once

// What may be said of a problem by keyword, and read or set as its attribute: one table for both.

#include "python/bindings/problem.h"

namespace leeway::python {

/// Properties of class Problem, one a setting.
void defineSettings(py::class_<Problem>& problem);
/// Throws TypeError for a keyword that is left.
void noMore(const char* call, const py::dict& keywords);

}  // namespace leeway::python
