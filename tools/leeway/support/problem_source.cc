#include "tools/leeway/support/problem_source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>

#include "leeway/planner/cloud_notes.h"
#include "leeway/robots/cache_folder.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/placed_model.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/problem/read_states.h"
#include "planner/validate/checks.h"
#include "robots/base/read_file.h"
#include "robots/cache/content_key.h"
#include "robots/cache/disk_cache.h"
#include "tools/leeway/support/terminal.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools {

bool isProblemName(const std::string& file) {
  const std::string ending = robots::endingOf(file);
  return ending == ".yaml" || ending == ".yml" || ending == ".json" || ending == ".cfg";
}

void badUsage(const std::string& message) { throw robots::InputError("command line", 0, message); }

namespace {

/// Whether --group or --chain says what is planned.
bool saysPlanned(const ProblemSource& source) {
  if (!source.group.empty() && !source.chain.empty())
    badUsage("--group and --chain both say which joints are planned; one is expected");
  return !source.group.empty() || !source.chain.empty();
}

/// What need not be printed again.
std::set<std::string>& printedWarnings() {
  static std::set<std::string> printed;
  return printed;
}

/// Prints the warnings about a robot; those about entries that are left out only once, because
/// planning does not need these. What a certificate rests on, such as an open mesh, comes always.
void printRobotWarnings(const robots::Model& model, const ProblemSource& source) {
  const auto isRest = [](const std::string& warning) {
    return warning.find("left out") == std::string::npos;
  };
  std::vector<std::string> rest, left;
  robots::ContentKey told("told warnings");
  for (const std::string& warning : model.warnings) {
    (isRest(warning) ? rest : left).push_back(warning);
    if (!isRest(warning)) told.add(warning);
  }
  const std::size_t left_out = left.size();
  const robots::DiskCache cache(
      source.no_cache || source.tell_again || left_out < 2 ? std::string() : robots::cacheFolder());
  const std::string key = cache.isOn() ? told.finish() : "";
  if (!key.empty() && cache.read(key)) {
    printedWarnings().insert(left.begin(), left.end());  // results repeat them
    printWarnings(rest);
    printWarnings(
        {fmt::format("robot '{}': {} entries are left out, as told before; `leeway info` "
                     "names them",
                     model.name, left_out)});
    return;
  }
  printWarnings(model.warnings);
  if (!key.empty() && !isQuiet()) cache.write(key, std::as_bytes(std::span("told")));
}

std::shared_ptr<const robots::Model> loadRobot(const ProblemSource& source) {
  saysPlanned(source);
  std::shared_ptr<const robots::Model> model = loadRobotModel(source.robot, source.srdf, source);
  printRobotWarnings(*model, source);
  return model;
}

/// A problem of the robot alone, which plans what --group or --chain says, or else all joints.
planner::Problem problemOfRobot(const ProblemSource& source) {
  planner::Problem problem;
  problem.robot.model = loadRobot(source);
  problem.name = problem.robot.model->name;
  problem.start = problem.robot.model->defaultConfiguration();
  if (!source.chain.empty())
    planner::takeChain("command line", 0, source.chain[0], source.chain[1], problem);
  else
    planner::takeGroups(
        "command line", 0,
        planner::namedGroups(*problem.robot.model, source.group.empty() ? "all" : source.group),
        problem);
  return problem;
}

planner::Problem loadFromRobot(const ProblemSource& source) {
  const bool moveit = !source.scene.empty() || !source.request.empty();
  const bool states = saysPlanned(source) || !(source.start + source.goal).empty();
  const bool pose = !source.goal_pose.empty() || !source.waypoints.empty();
  if (pose && !source.goal.empty())
    badUsage(fmt::format("--goal and {} both say where to go; one is expected",
                         source.waypoints.empty() ? "--goal-pose" : "--waypoints"));
  if (moveit && states) {
    badUsage(
        "--scene and --request name start and goal already; leave --group, --chain, --start and "
        "--goal out");
  }
  if (moveit) {
    if (source.scene.empty() || source.request.empty()) {
      badUsage("--scene and --request go together");
    }
    return planner::loadMoveit(loadRobot(source), source.scene, source.request,
                               {.load = loadOptions(source)});
  }
  saysPlanned(source);
  const bool needs_goal = source.needs_goal && source.goal.empty() && !pose;
  if (source.start.empty() || needs_goal) {
    badUsage(fmt::format(
        "--robot without {}{}{} (or --scene and --request); without --group or "
        "--chain all joints are planned",
        source.start.empty() ? "--start" : "", source.start.empty() && needs_goal ? " and " : "",
        needs_goal ? "--goal, --goal-pose or --waypoints" : ""));
  }
  planner::Problem problem = problemOfRobot(source);
  planner::takeStates(source.start, source.goal.empty() ? source.start : source.goal, problem);
  if (source.goal.empty()) problem.goals.clear();
  planner::validate(problem);
  return problem;
}

/// Parses FRAME x y z qx qy qz qw, one pose of --goal-pose.
planner::FramePose parseFramePose(std::span<const std::string> words) {
  planner::FramePose pose;
  pose.frame = words[0];
  double numbers[7];
  for (std::size_t i = 0; i < 7; ++i) {
    const std::optional<double> number = robots::parseFinite(words[i + 1]);
    if (!number)
      badUsage(fmt::format("--goal-pose {}: '{}' is no finite number", pose.frame, words[i + 1]));
    numbers[i] = *number;
  }
  for (std::size_t i = 0; i < 3; ++i) pose.position[i] = {numbers[i], numbers[i]};
  pose.rpy.fill({0, 0});
  Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (!(std::abs(q.norm() - 1) <= planner::kMendableQuaternion))
    badUsage(
        fmt::format("--goal-pose {}: a quaternion of length {}; unit length (within {}) is "
                    "expected",
                    pose.frame, q.norm(), planner::kMendableQuaternion));
  pose.rotation = q.normalized().toRotationMatrix();
  return pose;
}

/// Replaces the problem's goals by the goal of --goal-pose.
void takeGoalPose(const ProblemSource& source, planner::Problem& problem) {
  constexpr std::size_t kWords = 8;
  if (!problem.steps.empty()) badUsage("--goal-pose: the problem has steps, no goal");
  planner::Goal goal{"--goal-pose", {}, {}};
  const std::span<const std::string> words = source.goal_pose;
  for (std::size_t i = 0; i + kWords <= words.size(); i += kWords) try {
      goal.poses.push_back(planner::poseRegion(problem, parseFramePose(words.subspan(i, kWords))));
    } catch (const std::invalid_argument& error) {
      badUsage(fmt::format("--goal-pose {}: {}", words[i], error.what()));
    }
  problem.goals = {goal};
}

/// Replaces the problem's goals by the line of --waypoints.
void takeWaypoints(const ProblemSource& source, planner::Problem& problem) {
  if (!problem.steps.empty()) badUsage("--waypoints: the problem has steps, no goal");
  if (!source.goal_pose.empty())
    badUsage("--goal-pose and --waypoints both say where to go; one is expected");
  std::vector<std::string> warnings;
  planner::Step step{
      "waypoints", planner::loadWaypoints(source.waypoints, source.frame, warnings), {}};
  printWarnings(warnings);
  try {
    planner::takeStep(step, problem, true);
  } catch (const std::invalid_argument& error) {
    badUsage(fmt::format("--waypoints {}: {}", source.waypoints, error.what()));
  }
  problem.goals.clear();
  problem.steps = {std::move(step)};
}

}  // namespace

void addRobotArguments(CLI::App& app, ProblemSource& source) {
  app.add_option("--robot", source.robot, "URDF, MJCF or SDF of the robot")->type_name("URDF");
  app.add_option("--srdf", source.srdf, "SRDF of the robot: groups, states, pairs that may touch")
      ->type_name("SRDF");
  app.add_option("--joint-limits", source.joint_limits,
                 "MoveIt's joint_limits.yaml: velocities, accelerations, jerks, narrower positions")
      ->type_name("YAML");
  app.add_option("--bounds", source.bounds,
                 "narrower limits of a joint [rad or m], or of JOINT/x and JOINT/y of a planar or "
                 "floating one [m]; may be repeated")
      ->type_name("JOINT LOWER UPPER")
      ->type_size(3)
      ->expected(1)
      ->take_all();
  app.add_option("--widen", source.widen,
                 "a joint whose --bounds may reach beyond its limits; may be repeated")
      ->type_name("JOINT")
      ->type_size(1)
      ->expected(1)
      ->take_all();
  app.add_option("--package", source.packages, "where package://NAME/ lies; may be repeated")
      ->type_name("NAME=DIR");
  app.add_option("--xacro", source.xacro,
                 "argument of xacro, where the robot's file ends in .xacro; may be repeated")
      ->type_name("NAME:=VALUE");
  app.add_flag("--visual-as-collision", source.visual_as_collision,
               "use the <visual> shapes of links that have no <collision>");
  app.add_flag("--no-cache", source.no_cache,
               "do not read or write the cache folder ($LEEWAY_CACHE_DIR)");
}

namespace {

void addStatesAndMoveitArguments(CLI::App& app, ProblemSource& source) {
  addRobotArguments(app, source);
  app.add_option("--group", source.group,
                 "with --robot: what is planned: all, a group of the SRDF, a joint, or several of "
                 "these: LEFT,RIGHT")
      ->type_name("NAME");
  app.add_option("--chain", source.chain,
                 "in place of --group: the joints between two links are planned")
      ->type_name("BASE TIP")
      ->expected(2);
  app.add_option("--start", source.start,
                 "with --robot: the start, a group state (also zero, middle), or a value for each "
                 "planned joint: \"0 -1.5 0\"; of several groups: \"LEFT=up, RIGHT=0 -1.5 0\"")
      ->type_name("STATE");
  app.add_option("--goal", source.goal,
                 "with --robot: the goal, in the forms of --start; \"LEFT=any, RIGHT=up\"")
      ->type_name("STATE");
  app.add_option(
         "--goal-pose", source.goal_pose,
         "pose to reach, in place of the goal: position [m] and quaternion of a frame, link "
         "or attached object in the world; again for another one to hold at once")
      ->type_name("FRAME X Y Z QX QY QZ QW")
      ->type_size(8)
      ->expected(1)
      ->take_all();
  app.add_option(
         "--waypoints", source.waypoints,
         "poses that a frame goes through on straight lines from the start, in place of the "
         "goal: .csv (x, y, z, qx, qy, qz, qw), .yaml or .json")
      ->type_name("FILE");
  app.add_option(
         "--frame", source.frame,
         "the frame, link or attached object that goes through them, where the file does not "
         "name it")
      ->type_name("NAME")
      ->needs("--waypoints");
  app.add_option("--allowed", source.allowed,
                 "auto: links that touch with all joints at zero (MJCF: qpos0), or at the nearest "
                 "limit, may "
                 "touch; a warning names them")
      ->check(CLI::IsMember({"auto"}).description(""))
      ->type_name("auto");
  app.add_option("--scene", source.scene, "MoveIt planning scene, YAML or .scene")
      ->type_name("FILE");
  app.add_option("--request", source.request, "MoveIt motion plan request")->type_name("YAML");
}

}  // namespace

void addProblemArguments(CLI::App& app, ProblemSource& source) {
  app.add_option("problem", source.problem, "problem file, or OMPL.app's .cfg")
      ->type_name("PROBLEM.yaml");
  addStatesAndMoveitArguments(app, source);
}

void addProblemAndPathArguments(CLI::App& app, ProblemSource& source,
                                std::vector<std::string>& files) {
  app.add_option("files", files,
                 "problem file (not with --robot) and path file: .yaml .json .csv .path")
      ->type_name("PROBLEM.yaml PATH")
      ->expected(1, 2);
  addStatesAndMoveitArguments(app, source);
}

robots::LoadOptions loadOptions(const ProblemSource& source) {
  robots::LoadOptions options;
  if (!source.no_cache) options.cache = robots::cacheFolder();
  for (const std::string& package : source.packages) {
    const std::size_t equals = package.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == package.size()) {
      badUsage(fmt::format("--package '{}' is not NAME=DIR", package));
    }
    const std::string directory = package.substr(equals + 1);
    if (!std::filesystem::is_directory(directory)) {
      badUsage(fmt::format("--package {}: there is no folder '{}'", package, directory));
    }
    options.packages.emplace_back(package.substr(0, equals), directory);
  }
  for (const std::string& argument : source.xacro) {
    const std::size_t sign = argument.find(":=");
    if (sign == std::string::npos || sign == 0)
      badUsage(fmt::format("--xacro '{}' is not NAME:=VALUE", argument));
    options.xacro.emplace_back(argument.substr(0, sign), argument.substr(sign + 2));
  }
  options.visual_as_collision = source.visual_as_collision;
  options.kinematics_only = source.kinematics_only;
  options.stop = source.stop;
  options.errors = source.errors;
  return options;
}

namespace {

/// Parses --bounds and --widen.
robots::JointBounds boundsOf(const ProblemSource& source) {
  constexpr std::size_t kWords = 3;
  robots::JointBounds bounds;
  const std::span<const std::string> words = source.bounds;
  for (std::size_t i = 0; i + kWords <= words.size(); i += kWords) {
    double ends[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const std::optional<double> number = robots::parseFinite(words[i + 1 + k]);
      if (!number)
        badUsage(fmt::format("--bounds {}: '{}' is no finite number", words[i], words[i + 1 + k]));
      ends[k] = *number;
    }
    const std::size_t slash = words[i].find('/');  // JOINT/x
    const std::string joint = words[i].substr(0, slash);
    const std::string axis = slash == std::string::npos ? "" : words[i].substr(slash + 1);
    if (!bounds[joint]
             .emplace(axis, robots::JointBound{ends[0], ends[1], false, "--bounds"})
             .second)
      badUsage(fmt::format("--bounds names '{}' twice; once is expected", words[i]));
  }
  for (const std::string& joint : source.widen) {
    const auto found = bounds.find(joint);
    if (found == bounds.end())
      badUsage(
          fmt::format("--widen {0} stands without its bounds; '--bounds {0} LOWER UPPER' is "
                      "expected",
                      joint));
    for (auto& [axis, bound] : found->second) bound.widens = true;
  }
  return bounds;
}

}  // namespace

std::shared_ptr<const robots::Model> loadRobotModel(const std::string& urdf,
                                                    const std::string& srdf,
                                                    const ProblemSource& source) {
  const robots::JointBounds bounds = boundsOf(source);
  const robots::LoadOptions options = loadOptions(source);
  std::shared_ptr<const robots::Model> model = robots::loadModel(urdf, srdf, options);
  if (!source.joint_limits.empty())
    model = planner::withJointLimits(*model, source.joint_limits, options);
  if (bounds.empty()) return model;
  try {
    return robots::withBounds(*model, bounds);
  } catch (const std::invalid_argument& error) {
    badUsage("--" + std::string(error.what()));
  }
}

namespace {

planner::Problem readProblem(const ProblemSource& source) {
  if (source.problem.empty() && source.robot.empty()) {
    badUsage(
        "a problem file is needed, or --robot with --start and --goal, or --robot with --scene "
        "and --request");
  }
  const std::string ending = robots::endingOf(source.problem);
  if (ending == ".srdf")
    badUsage(source.problem + " is an SRDF, which goes after --srdf, beside --robot");
  for (const char* const of_robot : {".urdf", ".xacro", ".sdf", ".xml"})
    if (ending == of_robot)
      badUsage(fmt::format(
          "{0} is a robot; --robot {0} with --start and --goal, or with --scene and --request, is "
          "expected, or a problem file",
          source.problem));
  const std::pair<const char*, bool> others[] = {{"--robot", !source.robot.empty()},
                                                 {"--srdf", !source.srdf.empty()},
                                                 {"--joint-limits", !source.joint_limits.empty()},
                                                 {"--bounds", !source.bounds.empty()},
                                                 {"--widen", !source.widen.empty()},
                                                 {"--group", !source.group.empty()},
                                                 {"--chain", !source.chain.empty()},
                                                 {"--start", !source.start.empty()},
                                                 {"--goal", !source.goal.empty()},
                                                 {"--scene", !source.scene.empty()},
                                                 {"--request", !source.request.empty()}};
  for (const auto& [option, is_given] : others)
    if (is_given && !source.problem.empty())
      badUsage(fmt::format("{} names its robot, start and goal itself; leave {} out",
                           source.problem, option));
  planner::Problem problem;
  if (source.problem.empty()) {
    problem = loadFromRobot(source);
  } else {
    problem = planner::loadProblem(source.problem,
                                   {.load = loadOptions(source), .needs_goal = source.needs_goal});
    printRobotWarnings(*problem.robot.model, source);
  }
  if (!source.allowed.empty()) planner::allowTouching(problem, source.stop);
  printWarnings(problem.warnings);
  if (!isQuiet() && source.notes_clouds)
    for (const std::string& note : planner::cloudNotes(problem)) printMessage("note: " + note);
  if (!source.waypoints.empty())
    takeWaypoints(source, problem);
  else if (!source.goal_pose.empty())
    takeGoalPose(source, problem);
  return problem;
}

}  // namespace

planner::Problem loadProblem(const ProblemSource& given, std::optional<double> time_limit,
                             const Change& change) {
  ProblemSource source = given;
  planner::Problem problem;
  {
    const InterruptibleReading reading(time_limit);
    source.stop = reading.stop();
    try {
      problem = readProblem(source);
      if (source.kinematics_only && !problem.start_poses.empty()) {
        // Such a start needs collisions, because its joint values must be free.
        source.kinematics_only = false;
        problem = readProblem(source);
      }
    } catch (const robots::Stopped& stopped) {
      if (interrupted()) throw;
      throw robots::Stopped(
          fmt::format("{}: the {:g} s for reading are over; a longer --time is expected",
                      stopped.what(), std::max(time_limit.value_or(0), planner::kLeastReading)));
    }
  }
  robots::throwIfStopped(interrupted, "the problem was read");  // after the last call of stop()
  if (change) change(problem);
  printWarnings(problem.warnings);
  return source.places_start ? planner::placeStart(problem, interrupted) : problem;
}

void refuseSteps(const planner::Problem& problem, const char* verb) {
  if (!problem.steps.empty())
    badUsage(fmt::format(
        "{} looks at one world, and {} has steps; plan, verify, clearance and view take them", verb,
        problem.name));
}

planner::Problem loadProblemOrRobot(const ProblemSource& source, const Change& change) {
  if (source.robot.empty() ||
      !(source.problem + source.start + source.goal + source.scene + source.request).empty()) {
    return loadProblem(source, {}, change);
  }
  planner::Problem problem = problemOfRobot(source);
  if (!source.allowed.empty()) planner::allowTouching(problem, source.stop);
  printWarnings(problem.warnings);
  if (change) change(problem);
  return problem;
}

std::vector<std::string> filesOf(const ProblemSource& source) {
  return {source.problem, source.robot,   source.srdf,     source.joint_limits,
          source.scene,   source.request, source.waypoints};
}

std::string takePathFile(ProblemSource& source, const std::vector<std::string>& files) {
  if (files.empty() || (files.size() == 1 && source.robot.empty())) {
    badUsage("a problem file and a path file are needed, or --robot and a path file");
  }
  if (files.size() == 2) {
    source.problem = files.front();
  }
  return files.back();
}

void printWarnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    if (printedWarnings().insert(warning).second && !isQuiet()) {
      printMessage("warning: " + warning);
    }
  }
}

}  // namespace leeway::tools
