#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"
#include "python/base/arrays.h"

namespace leeway::python {

/// What surrounds a robot. Changed with the interpreter's lock held only; whoever plans copies it
/// before (shapes are shared).
struct World {
  planner::World value;
  std::uint64_t changes = 0;  ///< that change() was called for
  bool is_constant = false;   ///< of a problem that is

  bool has(const std::string& name) const;
  /// To be changed. Throws TypeError for a constant one.
  planner::World& change();
};

bool hasObject(const planner::World& world, const std::string& name);
std::vector<std::string> objectNames(const planner::World& world);

void defineWorld(py::module_& module);

}  // namespace leeway::python
