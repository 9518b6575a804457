// Any bytes as a path file of each format: a path or an InputError; a path has rows of the right
// size and finite numbers.

#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  return {
      R"({"joint_names": ["a", "b"], "positions": [[0, 0.5], [0.25, 1e-3], [1, -3]]})",
      R"({"status": "solved", "path": {"joint_names": ["b", "a"], "positions": [[0, 0.5], [0.25, 1]]}, "certificate": {}})",
      R"({"joint_trajectory": {"joint_names": ["a", "b"], "points": [{"positions": [0, 0]}, {"positions": [1, 1], "time_from_start": 1.5}]}})",
      "joint_names: [a, b]\npoints:\n  - positions: [0, 0.5]\n    time_from_start: {sec: 0, "
      "nanosec: 0}\n  - positions: [1, -1]\n",
      "time,a,b\n0,0,0.5\n1,0.5,-0.5\n",
      "0 0.5\n0.25 1\n1 -3\n"};
}

std::vector<std::string> dictionary() {
  return {"[",   "]",   "{",     "}", "null", "\"a\"", "\"\\u0000\"", "\"positions\"", "points:",
          "nan", "inf", "1e999", ",", "\n",   "\r\n",  "a,a",         "time",          "\"b,\""};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  static const planner::Problem problem = [] {
    const std::string text = fuzz::kArmUrdf;
    planner::Problem p;
    p.robot.model = robots::loadModel(
        fuzz::writeInput("robot.urdf",
                         {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}),
        "");
    p.robot.variables = {0, 1};
    p.start = {0, 0};
    p.goals.push_back({"goal", {{0, 0}, {0, 0}}});
    return p;
  }();
  for (const char* name : {"input.json", "input.yaml", "input.csv", "input.path"}) {
    try {
      const planner::Path path = planner::readPath(fuzz::writeInput(name, {data, size}), problem);
      for (const std::vector<double>& row : path.positions) {
        if (row.size() != problem.robot.variables.size())
          fuzz::fail("%s: a row of %zu", name, row.size());
        for (const double q : row)
          if (!(q - q == 0)) fuzz::fail("%s: a position that is not finite", name);
      }
      if (path.positions.empty()) fuzz::fail("%s: a path without waypoints", name);
    } catch (const robots::InputError& error) {
      if (error.what()[0] == '\0') fuzz::fail("an error without a message");
    }
  }
  return 0;
}
