#include <numbers>

#include "leeway/robots/inverse_kinematics.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/robot.h"

namespace leeway::python {
namespace {

using robots::IkStatus;

/// The answer, and of how many joints.
struct Inverse {
  robots::IkResult value;
  std::size_t columns;
};

const char* statusName(IkStatus status) {
  return status == IkStatus::kFound         ? "found"
         : status == IkStatus::kUnreachable ? "unreachable"
                                            : "none";
}

Inverse solve(const Robot& robot, const std::string& link, const py::object& target,
              const py::object& start, int solutions, std::uint64_t seed, const py::object& stop) {
  const int index = robot.model->findLink(link);
  if (index < 0) throw py::value_error("no link '" + link + "'");
  if (solutions < 1) throw py::value_error("solutions are below 1; at least one is expected");
  auto region = robots::PoseRegion::exact(index, {}, {}, givenPose(target, "pose"));
  if (py::len(target) == 3)  // a position
    region.rpy.fill({-std::numbers::pi, std::numbers::pi});
  std::vector<double> q = robot.model->defaultConfiguration();
  if (!start.is_none()) robot.expand(numbers(start, "start", robot.size()), q);
  Interrupt interrupt(stop);
  robots::IkOptions options;
  options.seed = seed;
  options.max_solutions = solutions;
  options.stop = interrupt.callback();
  Inverse result{
      released([&] {
        const std::span<const int> variables = robot.space->variables();
        const robots::InverseKinematics solver(robot.model, {variables.begin(), variables.end()});
        return solver.solve(std::span(&region, 1), q, options);
      }),
      robot.size()};
  interrupt.rethrow();
  return result;
}

}  // namespace

void defineInverse(py::module_& module) {
  py::class_<Inverse> inverse(module, "Inverse",
                              "What inverse_kinematics() found. True if there is a solution.");
  defineConstant(
      inverse, "status", [](const Inverse& self) { return statusName(self.value.status); },
      "'found', 'none' (there may be one) or 'unreachable' (proven: there is none).");
  defineConstant(
      inverse, "solutions",
      [](const Inverse& self) {
        std::vector<std::vector<double>> rows;
        for (const robots::IkSolution& solution : self.value.solutions)
          rows.push_back(solution.values);
        return array(rows, self.columns);
      },
      "Configurations within the limits: (n, joints) [rad or m], the nearest to the start first.");
  defineConstant(
      inverse, "nearest",
      [](const Inverse& self) {
        const robots::IkSolution& best =
            self.value.solutions.empty() ? self.value.nearest : self.value.solutions.front();
        return array(std::span<const double>(best.values));
      },
      "The first solution; without one, what comes nearest to the pose: (joints,).");
  inverse.def("__bool__", [](const Inverse& self) { return !self.value.solutions.empty(); });
  inverse.def("__repr__", [](const Inverse& self) {
    return std::string("<leeway.Inverse: ") + statusName(self.value.status) + ", " +
           std::to_string(self.value.solutions.size()) + " solutions>";
  });
  define(module, "inverse_kinematics",
         "(robot, link, pose, *, start=None, solutions=1, seed=1, stop=None)",
         "Configurations of the planned joints that bring a link to a pose in the world: a "
         "position and quaternion (7,), a matrix (4, 4), or a position (3,) with any turn. Looks "
         "from `start` (joints,) first. Without a solution it tries to prove that there is none. "
         "Contacts are not looked at: Scene.valid() is for that.",
         solve);
}

}  // namespace leeway::python
