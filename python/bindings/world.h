#pragma once

#include <cstdint>
#include <set>
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

/// The pose of a rigid object that was seen at `time` [s]. Throws ValueError for None, and for a
/// position alone of an object that was turned before: by its motion, or seen so, as `turned` says.
collision::Pose seenPose(const planner::World& world, const std::string& name, py::handle given,
                         double time, const std::set<std::string>& turned);
/// Whether a pose turns what it places. If an observation with it is taken, `turned` gets the name.
bool isTurned(const collision::Pose& X_WO);

/// The balls around points (n, 3), of any strides; those that are NaN are dropped. `radius`: a
/// number, or one a point. Perhaps without a ball.
planner::PointCloud cloudOf(const py::object& points, const py::object& radius);
/// A list of names. Throws TypeError for a text.
std::vector<std::string> namesOf(const py::object& names, const char* name);

void defineWorld(py::module_& module);

}  // namespace leeway::python
