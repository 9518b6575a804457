#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "leeway/robots/model.h"
#include "python/base/arrays.h"

namespace leeway::python {

/// A robot and what of it is planned: constant.
struct Robot {
  std::shared_ptr<const robots::Model> model;
  std::string group;  ///< "left", or of several "left, right"
  std::shared_ptr<const planner::ConfigurationSpace> space;

  /// Throws ValueError for an unknown group, one without joints, and groups that share one.
  Robot(std::shared_ptr<const robots::Model> of, const std::vector<std::string>& groups);
  /// For one whose planned variables are not those of groups, `group` is empty.
  Robot(std::shared_ptr<const robots::Model> of, std::vector<int> variables);

  std::size_t size() const { return static_cast<std::size_t>(space->size()); }
  const std::string& variableName(std::size_t i) const;
  /// One configuration of the whole model for a point of the group; the other variables as in
  /// `base`.
  void expand(std::span<const double> point, std::span<double> base) const;
};

/// {name: {"solid": ..., "weld": ...}}; None: nothing. Throws TypeError and ValueError.
std::map<std::string, robots::MeshTreatment, std::less<>> treatments(const py::object& meshes);

/// "left, right".
std::string listed(const std::vector<std::string>& names);

/// A group's name, or a sequence of names.
std::vector<std::string> groupNames(const py::object& group);

/// The planned values of a group state: of the robot's groups, or of its group of that name.
std::vector<double> namedState(const Robot& robot, const std::string& name);

void defineRobot(py::module_& module);

}  // namespace leeway::python
