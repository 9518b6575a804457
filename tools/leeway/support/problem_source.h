#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::tools {

/// Where a problem comes from: its YAML file; or robot files with either the names of two group
/// states, or a MoveIt scene and request.
struct ProblemSource {
  std::string problem;
  std::string robot, srdf, joint_limits;
  std::vector<std::string> bounds;  ///< JOINT lower upper; several
  std::vector<std::string> widen;   ///< joints whose bounds may be wider than their own limits
  std::string group, start, goal;
  std::string scene, request;
  std::string waypoints, frame;        ///< a file of poses, and what goes through them
  std::vector<std::string> goal_pose;  ///< FRAME x y z qx qy qz qw; several: at once
  std::vector<std::string> chain;      ///< BASE, TIP: the links of a chain in place of `group`
  std::string allowed;                 ///< "auto": planner::allowTouching()
  std::vector<std::string> packages;   ///< NAME=DIR
  std::vector<std::string> xacro;      ///< NAME:=VALUE
  bool visual_as_collision = false;
  bool kinematics_only = false;  ///< unless the start depends on collisions
  bool no_cache = false;
  robots::Stop stop;  ///< set while it is read
  robots::InputErrors* errors = nullptr;
};

void addRobotArguments(CLI::App& app, ProblemSource& source);
void addProblemArguments(CLI::App& app, ProblemSource& source);
/// A problem and a path: two files, or with --robot the path's alone.
void addProblemAndPathArguments(CLI::App& app, ProblemSource& source,
                                std::vector<std::string>& files);
/// Throws robots::InputError, and robots::Stopped for an interrupt or a `time_limit` [s] that is
/// over (InterruptibleReading); prints the loader's warnings to stderr.
planner::Problem loadProblem(const ProblemSource& source, std::optional<double> time_limit = {});
/// For verbs that look at one world: throws robots::InputError for a problem with steps.
void refuseSteps(const planner::Problem& problem, const char* verb);
/// A problem without start, goal and world, when the source is a robot without them: the variables
/// of --group, or all; the others, and where nothing is said these too, at their defaults.
/// Otherwise as loadProblem().
planner::Problem loadProblemOrRobot(const ProblemSource& source);
robots::LoadOptions loadOptions(const ProblemSource& source);
/// The robot of these files, with the limits that the source names. Throws robots::InputError,
/// robots::Stopped.
std::shared_ptr<const robots::Model> loadRobotModel(const std::string& urdf,
                                                    const std::string& srdf,
                                                    const ProblemSource& source);
/// The files that the source names; empty names among them.
std::vector<std::string> filesOf(const ProblemSource& source);
/// Moves the problem's file from `files` to `source` and returns the path's.
std::string takePathFile(ProblemSource& source, const std::vector<std::string>& files);

/// Throws robots::InputError of the command line.
[[noreturn]] void badUsage(const std::string& message);

/// Each warning once in the life of the process, to stderr, unless isQuiet().
void printWarnings(const std::vector<std::string>& warnings);

}  // namespace leeway::tools
