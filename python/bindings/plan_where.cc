// Plans with a condition on states that is written in Python.

#include <algorithm>

#include "leeway/planner/task.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/plan.h"

namespace leeway::python {
namespace {

/// Asks the caller's function about states, in one call.
bool isAccepted(const py::object& accept, std::span<const double> states, std::size_t columns,
                Interrupt& interrupt) {
  const py::gil_scoped_acquire locked;
  try {
    const auto count = static_cast<py::ssize_t>(states.size() / columns);
    const py::object answer = accept(array(std::vector<double>(states.begin(), states.end()),
                                           {count, static_cast<py::ssize_t>(columns)}));
    // Nothing but bools: a text would count by its length.
    const auto given = py::array::ensure(answer);
    const bool are_bools = given && given.dtype().kind() == 'b';
    const auto accepted = are_bools ? py::array_t<bool, py::array::c_style>::ensure(given)
                                    : py::array_t<bool, py::array::c_style>(0);
    if (!are_bools || !accepted || accepted.ndim() != 1 || accepted.shape(0) != count) {
      PyErr_Clear();
      throw py::type_error("accept(states) did not return " + std::to_string(count) +
                           " bools, one a state");
    }
    return std::all_of(accepted.data(), accepted.data() + count, [](bool yes) { return yes; });
  } catch (...) {
    interrupt.fail();
    return false;
  }
}

Result planWhere(const Problem& problem, const py::object& accept, const py::object& resolution,
                 const py::object& stop) {
  if (PyCallable_Check(accept.ptr()) == 0)
    throw py::type_error(
        "accept is no function; one of states (n, joints) that returns n bools is expected");
  const double apart = number(resolution, "resolution");
  if (!(apart > 0)) throw py::value_error("resolution is " + text(apart) + "; above 0 is expected");
  requireGoal(problem);
  const std::shared_ptr<const planner::Problem> value = problem.value();
  planner::validate(*value);  // before what a condition needs
  Interrupt interrupt(stop);
  planner::PlanOptions options;
  options.stop = interrupt.callback();
  planner::Problem conditional = *value;
  conditional.condition.resolution = apart;
  conditional.condition.accept = [&](std::span<const double> states) {
    return isAccepted(accept, states, value->robot.variables.size(), interrupt);
  };
  planner::PlanResult result =
      interrupt.released([&] { return planner::solve(conditional, options); });
  interrupt.rethrow();
  return {value, std::move(result)};
}

}  // namespace

void definePlanWhere(py::module_& module) {
  define(module, "plan_where", "(problem, accept, *, resolution=0.05, stop=None)",
         "Plans with a condition of your own: accept(states) of shape (n, joints) returns n bools. "
         "Every edge is certified to keep its margins and the problem's constraints; the condition "
         "holds at states at most `resolution` [rad or m] apart on it, and is not proven between "
         "them: certificate.conditions is 'sampled'. The same planning as plan() with constraints, "
         "with what these need. The result's problem, and with it verify(), does not know the "
         "condition.\n\n"
         "The price: a call of Python for each edge, about 10 us and what `accept` takes.",
         planWhere);
}

}  // namespace leeway::python
