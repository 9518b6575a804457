// Any bytes as a problem file beside the shipped robots: a complete problem or an InputError.

#include <filesystem>

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tests/fuzz/both_ways.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"
#include "tests/support/build_paths.h"

namespace leeway::fuzz {

std::vector<std::string> seedInputs() {
  std::vector<std::string> seeds = sourceTextsUnder("problems", ".yaml");
  seeds.push_back("version: 1\nrobot: {urdf: robot.urdf}\nstart: {a: 0}\ngoal: {a: 1}\n");
  return seeds;
}

std::vector<std::string> dictionary() {
  return {"&a ",          "*a",         "<<: *a",
          "!!binary ",    "- ",         "? ",
          "[[[[",         "{}",         "\t",
          "\n---\n",      "start:",     "goal:",
          "null",         "~",          "box: {size: [1, 1, 1]}",
          ".nan",         ".inf",       "-.inf",
          "[0, 0, 0, 0]", "margin: -1", "margin: 1e308",
          "\xff\xfe",     "\xc3\x28",   "moveit:",
          "time_limit:",  "seed:"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  // Problems refer to the repository's robots and meshes from problems/<folder>/: mirrors that
  // tree.
  static const bool linked = [] {
    namespace fs = std::filesystem;
    const fs::path root = fuzz::scratchFolder();
    fs::create_directories(root / "problems" / "fuzz");
    for (const char* folder : {"robots"})
      fs::create_directory_symlink(fs::path(leeway::sourceFolder()) / folder, root / folder);
    for (const auto& entry : fs::directory_iterator(fs::path(leeway::sourceFolder()) / "problems"))
      if (entry.is_directory())
        fs::create_directory_symlink(entry.path(), root / "problems" / entry.path().filename());
    return true;
  }();
  (void)linked;
  for (const char* name : {"problems/fuzz/input.yaml", "problems/input.yaml"}) {
    const std::string path = fuzz::writeInput(name, {data, size});
    try {
      const planner::Problem problem = fuzz::loadBothWays([&](robots::InputErrors* errors) {
        planner::ProblemOptions options;
        options.load.errors = errors;
        return planner::loadProblem(path, options);
      });
      if (!problem.robot.model) fuzz::fail("a problem without a model");
      if (problem.start.size() != problem.robot.model->variables.size())
        fuzz::fail("a start of the wrong size");
      if (problem.goals.empty() && problem.steps.empty())
        fuzz::fail("a problem without goals and steps");
      for (const planner::Goal& goal : problem.goals)
        if (goal.ranges.size() != (goal.poses.empty() ? problem.robot.variables.size() : 0))
          fuzz::fail("a goal of the wrong size");
      for (const double q : problem.start)
        if (!(q - q == 0)) fuzz::fail("a start that is not finite");
    } catch (const robots::InputError& error) {
      if (error.what()[0] == '\0') fuzz::fail("an error without a message");
    }
  }
  return 0;
}
