#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::tools {

/// The source of a problem: its YAML file, or robot files with either the names of two group states
/// or a MoveIt scene and request.
struct ProblemSource {
  std::string problem;
  std::string robot, srdf, joint_limits;
  std::vector<std::string> bounds;  ///< JOINT lower upper, repeated
  std::vector<std::string> widen;   ///< joints whose bounds may exceed their own limits
  std::string group, start, goal;
  std::string scene, request;
  std::string waypoints, frame;        ///< a file of poses, and the frame that follows them
  std::vector<std::string> goal_pose;  ///< FRAME x y z qx qy qz qw; several hold at once
  std::vector<std::string> chain;      ///< BASE, TIP: the links of a chain, instead of `group`
  bool needs_goal = true;              ///< and a command line as well
  bool places_start = true;            ///< a start of poses has joint values; else the path has
  bool notes_clouds = true;            ///< prints cloudNotes(); not if the answer has them
  std::string allowed;                 ///< "auto": planner::allowTouching()
  std::vector<std::string> packages;   ///< NAME=DIR
  std::vector<std::string> xacro;      ///< NAME:=VALUE
  bool visual_as_collision = false;
  bool kinematics_only = false;  ///< unless the start depends on collisions
  bool no_cache = false;
  bool tell_again = false;  ///< warnings about a robot that an earlier command has told
  robots::Stop stop;        ///< set during reading
  robots::InputErrors* errors = nullptr;
};

/// Whether a file has the ending of a problem.
bool isProblemName(const std::string& file);

void addRobotArguments(CLI::App& app, ProblemSource& source);
void addProblemArguments(CLI::App& app, ProblemSource& source);
/// Adds the arguments of a problem and a path: two files, or only the path's with --robot.
void addProblemAndPathArguments(CLI::App& app, ProblemSource& source,
                                std::vector<std::string>& files);

/// A change of a problem that was read.
using Change = std::function<void(planner::Problem&)>;

/// Prints the loader's warnings to stderr; those about left-out entries of the robot once: a cache
/// folder remembers them, and a later command says in one line how many there are. Throws
/// robots::InputError, and robots::Stopped for an interrupt or at the end of `time_limit` [s]
/// (InterruptibleReading). `change` is made before a start of poses is placed, which must keep the
/// constraints.
planner::Problem loadProblem(const ProblemSource& source, std::optional<double> time_limit = {},
                             const Change& change = {});
/// For verbs that handle a single world: throws robots::InputError for a problem with steps.
void refuseSteps(const planner::Problem& problem, const char* verb);
/// Loads a robot alone as a problem without start, goal and world, and other sources as
/// loadProblem() does. The robot's problem plans the variables of --group, or all of them.
/// Variables without a given value have their defaults.
planner::Problem loadProblemOrRobot(const ProblemSource& source, const Change& change = {});
robots::LoadOptions loadOptions(const ProblemSource& source);
/// Loads the robot of these files, with the limits that the source names. Throws
/// robots::InputError, robots::Stopped.
std::shared_ptr<const robots::Model> loadRobotModel(const std::string& urdf,
                                                    const std::string& srdf,
                                                    const ProblemSource& source);
/// The files that the source names. Some names may be empty.
std::vector<std::string> filesOf(const ProblemSource& source);
/// Moves the problem's file from `files` to `source` and returns the path's.
std::string takePathFile(ProblemSource& source, const std::vector<std::string>& files);

/// Throws robots::InputError for the command line.
[[noreturn]] void badUsage(const std::string& message);

/// Prints each warning once per process, to stderr, unless isQuiet().
void printWarnings(const std::vector<std::string>& warnings);

}  // namespace leeway::tools
