#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"
#include "leeway/planner/settings.h"
#include "python/bindings/robot.h"
#include "python/bindings/world.h"

namespace leeway::python {

/// A problem, used with the interpreter's lock held. Lists, dicts, arrays and the World that it has
/// handed out are its own: value() reads them again where they have changed.
class Problem {
 public:
  Problem() = default;
  /// `is_constant`: of what was compiled or answered. It cannot be set, and hands out what cannot
  /// be changed.
  explicit Problem(std::shared_ptr<const planner::Problem> value, bool is_constant = false)
      : value_(std::move(value)), is_constant_(is_constant) {}
  /// A copy has the content and may be changed.
  Problem(const Problem& other) : value_(other.value()) {}
  Problem(Problem&&) = default;
  Problem& operator=(const Problem& other) { return *this = Problem(other); }
  Problem& operator=(Problem&&) = default;

  /// The content as it is now; never changed, for any thread. Throws where what was handed out
  /// makes no sense now.
  const std::shared_ptr<const planner::Problem>& value() const;
  const planner::Problem& operator*() const { return *value(); }
  const planner::Problem* operator->() const { return value().get(); }

  Robot robot() const { return {value_->robot.model, value_->robot.variables}; }
  std::size_t size() const { return value_->robot.variables.size(); }
  /// Sets what is given by keyword. Throws TypeError for other keywords.
  void apply(const py::dict& settings);

  py::object attribute(const planner::Setting& setting) const;
  void set(const planner::Setting& setting, const py::object& value);

 private:
  struct HandedOut {
    py::object object, image;
  };
  /// Takes the value of each setting that was handed out and has changed, but of the one named.
  void takeChanges(const std::string& except = {}) const;

  mutable std::shared_ptr<const planner::Problem> value_;
  mutable std::map<std::string, HandedOut> handed_out_;
  /// Attributes that were handed out and then replaced. To change them would have no effect.
  mutable std::vector<std::pair<std::string, HandedOut>> replaced_;
  bool is_constant_ = false;
};

/// Whether it may be said of a problem by keyword: margin=0.01.
bool isSetting(const std::string& name);

/// The problem that a call means: (problem) or (robot, world, start, goal), with settings. `call`
/// is for messages. Takes what it knows from `keywords`.
Problem problemOf(const char* call, const py::args& args, py::dict& keywords,
                  bool needs_start = false);

/// Throws ValueError where there is nothing to plan to.
void requireGoal(const Problem& problem);

/// "start", "goal", a group state, numbers, or a map by joint.
std::vector<double> statePoint(const Problem& problem, const py::object& state);

void defineProblem(py::module_& module);

}  // namespace leeway::python
