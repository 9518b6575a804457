// Any bytes as a path file of each format: a path or an InputError; a path has rows of the right
// size and finite numbers. Any bytes as lines of a log, with the sums that they need: a verdict or
// an InputError with a message.

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "leeway/planner/path_io.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "planner/execute/log_line.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace leeway::fuzz {

namespace {

/// A log of the problem below, without sums.
constexpr const char* kStep =
    R"({"version":2,"step":0,"time":0,"decision":"plan","certified":true,"exposed":false,"reached":true,"joint_names":["a","b"],"position":[0.01,0.5],)"
    R"("motion":[{"time":0,"position":[0,0.5]},{"time":0.05,"position":[0.01,0.5]}],"stop":[],"measured":null,"observed":[],"obstacles":[{"name":"cart","seen":0,"predicted":false}])";
constexpr const char* kEnd =
    R"({"version":2,"status":"reached","problem":"fuzz","certified":true,"duration":0.05,"steps":1,"plans":1,"follows":0,"waits":0,"evasions":0)";

/// The lines with their sums.
std::string summed(std::string_view text) {
  std::string log;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    char sum[17];
    std::snprintf(sum, sizeof sum, "%016llx",
                  static_cast<unsigned long long>(planner::lineSum(line)));
    log.append(line).append(planner::kBeforeSum).append(sum).append(planner::kAfterSum) += '\n';
  }
  return log;
}

}  // namespace

std::vector<std::string> seedInputs() {
  return {
      R"({"joint_names": ["a", "b"], "positions": [[0, 0.5], [0.25, 1e-3], [1, -3]]})",
      R"({"status": "solved", "path": {"joint_names": ["b", "a"], "positions": [[0, 0.5], [0.25, 1]]}, "certificate": {}})",
      R"({"joint_trajectory": {"joint_names": ["a", "b"], "points": [{"positions": [0, 0]}, {"positions": [1, 1], "time_from_start": 1.5}]}})",
      "joint_names: [a, b]\npoints:\n  - positions: [0, 0.5]\n    time_from_start: {sec: 0, "
      "nanosec: 0}\n  - positions: [1, -1]\n",
      "time,a,b\n0,0,0.5\n1,0.5,-0.5\n",
      "0 0.5\n0.25 1\n1 -3\n",
      std::string(kStep) + "\n" + kEnd + "\n"};
}

std::vector<std::string> dictionary() {
  return {"[",
          "]",
          "{",
          "}",
          "null",
          "\"a\"",
          "\"\\u0000\"",
          "\"positions\"",
          "points:",
          "nan",
          "inf",
          "1e999",
          ",",
          "\n",
          "\r\n",
          "a,a",
          "time",
          "\"b,\"",
          "\"observed\":[{\"object\":\"cart\",\"time\":0,\"position\":[0,0,0],"
          "\"rotation\":[[1,0,0],[0,1,0],[0,0,1]],\"speed_bound\":null,\"turn_bound\":0}]"};
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
  static const planner::Problem execution = [] {
    planner::Problem p = problem;
    p.name = "fuzz";
    p.start = {0, 0.5};
    p.goals = {{"goal", {{-1, 1}, {-3, 3}}}};
    p.world.objects.push_back(
        planner::movingObject({"cart", {{collision::Shape::sphere(0.1), {}, "cart"}}, {}},
                              {.speed_bound = 0.1, .turn_bound = 0.1}));
    return p;
  }();
  const std::string log = fuzz::summed({reinterpret_cast<const char*>(data), size});
  const std::string file = fuzz::writeInput(
      "input.jsonl", {reinterpret_cast<const std::uint8_t*>(log.data()), log.size()});
  for (const std::string& input : {file, fuzz::writeInput("bytes.jsonl", {data, size})}) {
    try {
      const planner::VerifyResult result = planner::verifyLog(execution, input);
      if (result.status == planner::VerifyStatus::kCertified)
        fuzz::fail("a robot without shapes is certified");
      if (result.reason.empty()) fuzz::fail("a verdict without a reason");
    } catch (const robots::InputError& error) {
      if (error.what()[0] == '\0') fuzz::fail("an error without a message");
    }
  }
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
