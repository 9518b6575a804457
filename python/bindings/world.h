#pragma once

#include "leeway/planner/problem.h"
#include "python/base/arrays.h"

namespace leeway::python {

/// What surrounds a robot. Changed with the interpreter's lock held only; whoever plans copies it
/// before (shapes are shared).
struct World {
  planner::World value;

  bool has(const std::string& name) const;
};

bool hasObject(const planner::World& world, const std::string& name);
std::vector<std::string> objectNames(const planner::World& world);

void defineWorld(py::module_& module);

}  // namespace leeway::python
