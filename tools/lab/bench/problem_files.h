#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::bench {

/// The MoveIt request for a scene: for .../sceneNNNN.yaml, .../requestNNNN.yaml. Throws
/// std::runtime_error for other names.
inline std::string requestOf(std::string scene) {
  const std::size_t at = scene.rfind("scene"), folder = scene.rfind('/');
  if (at == std::string::npos || (folder != std::string::npos && at < folder))
    throw std::runtime_error(scene + ": a file named sceneNNNN.yaml is expected");
  return scene.replace(at, 5, "request");
}

/// The problems that a program is given: files of this project or, with --robot, MoveIt scenes
/// whose requests are beside them.
class ProblemFiles {
 public:
  /// Adds --robot, --srdf and the files. Must outlive `app`.
  CLI::Option* addTo(CLI::App& app) {
    app.add_option("--robot", robot_, "URDF, for MoveIt scenes");
    app.add_option("--srdf", srdf_, "SRDF");
    return app.add_option("files", names_, "problems, or MoveIt scenes with requests beside them");
  }
  const std::vector<std::string>& names() const { return names_; }
  /// Loads the robot with the first of them. Throws robots::InputError.
  planner::Problem load(const std::string& name) {
    if (!model_ && !robot_.empty()) model_ = robots::loadModel(robot_, srdf_);
    return model_ ? planner::loadMoveit(model_, name, requestOf(name)) : planner::loadProblem(name);
  }

 private:
  std::string robot_, srdf_;
  std::vector<std::string> names_;
  std::shared_ptr<const robots::Model> model_;
};

}  // namespace leeway::bench
