// Any bytes as an OMPL.app problem: a problem whose start and goal are within its limits, or an
// InputError with a message.

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace {

constexpr const char* kSpace = R"([problem]
name = pass # comment
robot = body.obj
world = body.obj
objective = length
start.x = -5
start.y = 1
start.z = 2
start.theta = 0
start.axis.x = 1
start.axis.y = 0
start.axis.z = 0
goal.x = 7
goal.y = 1
goal.z = 2
goal.theta = 1.5
goal.axis.x = 0
goal.axis.y = 0
goal.axis.z = 2
volume.min.x = -20
volume.min.y = -30
volume.min.z = -10
volume.max.x = 20
volume.max.y = 30
volume.max.z = 10

[benchmark]
time_limit = 20.0
[planner]
rrt =
)";
constexpr const char* kPlane = R"([problem]
robot = body.obj
world = body.obj
start.x = 7.02
start.y = -12.0
start.theta = 0.0
goal.x = -36.98
goal.y = -10.0
goal.theta = 2.25
)";
constexpr const char* kBody = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";

std::span<const std::uint8_t> bytesOf(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

namespace leeway::fuzz {

std::vector<std::string> seedInputs() { return {kSpace, kPlane}; }

std::vector<std::string> dictionary() {
  return {"[problem]",         "[benchmark]", "#",      "=",        "control = x", "statespace",
          "problem.",          ".axis.",      ".theta", "1e308",    "-1e308",      "nan",
          "max_min_clearance", "body.obj",    "..",     "/dev/zero"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  static const std::string body = fuzz::writeInput("body.obj", bytesOf(kBody));
  try {
    const planner::Problem problem =
        planner::loadProblem(fuzz::writeInput("input.cfg", {data, size}));
    const auto& variables = problem.robot.model->variables;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      const auto [lower, upper] = problem.goals.at(0).ranges.at(i);
      for (const double value : {problem.start.at(i), lower, upper})
        if (!(value >= variables[i].lower && value <= variables[i].upper))
          fuzz::fail("'%s' is %g, outside its limits", variables[i].name.c_str(), value);
    }
  } catch (const robots::InputError& error) {
    if (error.what()[0] == '\0') fuzz::fail("an error without a message");
  }
  return 0;
}
