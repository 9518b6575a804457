#include "tools/leeway/info/input.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <cstddef>
#include <filesystem>
#include <vector>

#include "leeway/robots/input_error.h"
#include "robots/base/read_file.h"

namespace leeway::tools::info {
namespace {

namespace fs = std::filesystem;

/// The name of an XML file's root element, or an empty text if the file cannot be read. Sets
/// `robot_name` to the element's attribute `name`.
std::string rootElementName(const std::string& file, std::string& robot_name) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS ||
      document.RootElement() == nullptr) {
    return {};
  }
  const char* name = document.RootElement()->Attribute("name");
  robot_name = name == nullptr ? "" : name;
  return document.RootElement()->Name();
}

/// Finds the URDF that an SRDF belongs to, because an SRDF alone describes little. It is the URDF
/// with the SRDF's robot name in its folder or in the folder above.
std::string findUrdfOf(const std::string& srdf) {
  std::string robot_name;
  rootElementName(srdf, robot_name);
  const fs::path folder = fs::absolute(srdf).parent_path();
  std::vector<std::string> found;
  for (const fs::path& place : {folder, folder.parent_path()}) {
    for (const auto& entry : fs::directory_iterator(place)) {
      std::string name;
      if (robots::endingOf(entry.path().string()) == ".urdf" &&
          rootElementName(entry.path().string(), name) == "robot" && name == robot_name) {
        found.push_back(entry.path().string());
      }
    }
    if (!found.empty()) {
      break;
    }
  }
  if (found.size() != 1) {
    throw robots::InputError(srdf, 0,
                             fmt::format("an SRDF is read together with its URDF, and {} URDF of a "
                                         "robot '{}' lies beside it; name it with --robot",
                                         found.empty() ? "no" : "more than one", robot_name));
  }
  return found.front();
}

/// A robot alone: a problem that plans every variable and has no objects.
planner::Problem robotProblem(const std::string& urdf, const std::string& srdf,
                              const ProblemSource& source) {
  planner::Problem problem;
  problem.robot.model = loadRobotModel(urdf, srdf, source);
  printWarnings(problem.robot.model->warnings);
  problem.name = problem.robot.model->name;
  problem.start = problem.robot.model->defaultConfiguration();
  planner::Goal goal{"default", {}};
  for (std::size_t i = 0; i < problem.robot.model->variables.size(); ++i) {
    problem.robot.variables.push_back(static_cast<int>(i));
    goal.ranges.emplace_back(problem.start[i], problem.start[i]);
  }
  problem.goals = {goal};
  return problem;
}

}  // namespace

FileKind kindOf(const std::string& file) {
  const std::string ending = robots::endingOf(file);
  if (ending == ".srdf") {
    return FileKind::kSrdf;
  }
  if (ending == ".urdf" || ending == ".xacro" || ending == ".xml" || ending == ".sdf" ||
      ending == ".world") {
    return FileKind::kUrdf;
  }
  if (isProblemName(file)) return FileKind::kProblem;
  throw robots::InputError(file, 0,
                           fmt::format("unknown ending '{}'; .urdf, .xml (MuJoCo), .sdf, .world, "
                                       ".srdf, .yaml, .json and .cfg are accepted",
                                       ending));
}

planner::Problem loadFile(const std::string& file, FileKind kind, ProblemSource source) {
  std::error_code error;
  if (!fs::exists(file, error)) {
    throw robots::InputError(file, 0, "there is no such file");
  }
  if (kind == FileKind::kUrdf && !source.robot.empty())
    badUsage(fmt::format("{} and --robot {} are two robots; one is expected", file, source.robot));
  if (kind == FileKind::kSrdf && !source.srdf.empty())
    badUsage(fmt::format("{} and --srdf {} are two SRDFs; one is expected", file, source.srdf));
  switch (kind) {
    case FileKind::kUrdf:
      return robotProblem(file, source.srdf, source);
    case FileKind::kSrdf:
      return robotProblem(source.robot.empty() ? findUrdfOf(file) : source.robot, file, source);
    case FileKind::kProblem:
      break;
  }
  source.problem = file;
  source.tell_again = true;
  return loadProblem(source);
}

}  // namespace leeway::tools::info
