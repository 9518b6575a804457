// Validates a whole problem. Programs, files and Python all use this function.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/planner/planners.h"
#include "leeway/robots/groups.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"
#include "robots/model/same_robot.h"

namespace leeway::planner {
namespace {

using robots::Model;

[[noreturn]] void refuse(const Problem& problem, const std::string& message) {
  throw robots::InputError(problem.name, 0, message);
}

void require(const Problem& problem, const std::optional<std::string>& fault) {
  if (fault) refuse(problem, *fault);
}

void require(const Problem& problem, const std::optional<Fault>& fault) {
  if (fault) refuse(problem, fault->message);
}

void requirePose(const Problem& problem, const robots::Pose& X, const std::string& name) {
  if (const std::string fault = poseFault(X); !fault.empty())
    refuse(problem, fmt::format("the pose of '{}' {}", name, fault));
}

void checkVariables(const Problem& problem) {
  const Model& model = *problem.robot.model;
  const std::vector<int>& variables = problem.robot.variables;
  if (variables.empty())
    refuse(problem, "robot.variables is empty; at least one planned variable is expected");
  std::vector<char> seen(model.variables.size(), 0);
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const int v = variables[i];
    if (v < 0 || at(v) >= seen.size())
      refuse(problem, fmt::format("robot.variables[{}] is {}; a variable of the model, 0 to {}, is "
                                  "expected",
                                  i, v, static_cast<int>(seen.size()) - 1));
    if (seen[at(v)] != 0)
      refuse(problem, fmt::format("robot.variables[{}] is {} ({}), which stands there twice; each "
                                  "planned variable once is expected",
                                  i, v, variableText(model, v)));
    seen[at(v)] = 1;
  }
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const robots::Joint& joint = model.joints[at(model.variables[at(variables[i])].joint)];
    const int place = variables[i] - joint.first_variable;
    if (joint.type != robots::JointType::kFloating || place < 3) continue;
    const std::size_t first = i - std::min(i, at(place - 3));
    for (std::size_t k = 0; k < 4; ++k)
      if (first + k >= variables.size() ||
          variables[first + k] != joint.first_variable + 3 + static_cast<int>(k))
        refuse(problem,
               fmt::format("robot.variables has part of the orientation of joint '{}'; its "
                           "four variables, in their order, are expected",
                           joint.name));
  }
}

/// Refuses a link's number that the model does not have.
template <class Where>
void requireLink(const Problem& problem, int link, const Where& where) {
  const std::size_t links = problem.robot.model->links.size();
  if (link >= 0 && at(link) < links) return;
  refuse(problem, fmt::format("{} is {}; a link of the model, 0 to {}, is expected", where(), link,
                              static_cast<int>(links) - 1));
}

void checkCarried(const Problem& problem) {
  for (std::size_t i = 0; i < problem.robot.attachments.size(); ++i) {
    const Attachment& held = problem.robot.attachments[i];
    const auto where = [&] { return fmt::format("robot.attachments[{}]", i); };
    requireLink(problem, held.link, [&] { return where() + ".link"; });
    for (const int link : held.touch_links)
      requireLink(problem, link, [&] { return where() + ".touch_links"; });
    requirePose(problem, held.X_LO, held.object.name);
    if (held.object.cloud)
      refuse(problem, fmt::format("{}.object.cloud: '{}' is a point cloud, which is not held; "
                                  "shapes are expected",
                                  where(), held.object.name));
    if (!(extentOf(held.object) < kInfinity))
      refuse(problem, fmt::format("{}.object: '{}' has a half-space, which is not held; shapes of "
                                  "bounded size are expected",
                                  where(), held.object.name));
  }
  for (std::size_t i = 0; i < problem.robot.frames.size(); ++i) {
    const Frame& frame = problem.robot.frames[i];
    const auto where = [&] { return fmt::format("robot.frames[{}]", i); };
    requireLink(problem, frame.link, [&] { return where() + ".link"; });
    requirePose(problem, frame.X_LF, frame.name);
  }
}

/// Returns the fault of a deforming obstacle. Execution sees it as it is at the beginning.
std::string deformingFault(const DeformingObstacle& obstacle, const Execution& execution) {
  const collision::DeformableSnapshot* snapshot =
      obstacle.mesh && obstacle.object.geometries.size() == 1
          ? obstacle.object.geometries[0].shape.deformable()
          : nullptr;
  if (snapshot == nullptr || &snapshot->mesh() != obstacle.mesh.get())
    return "has no snapshot of its mesh; see makeDeformingObstacle()";
  if (obstacle.object.motion)
    return "has a rigid motion, which deforming obstacles do not follow; positions of its vertices "
           "at times are expected";
  if (snapshot->time() != execution.start)
    return fmt::format("is as it is at {} s; execution starts at {} s; the same time is expected",
                       snapshot->time(), execution.start);
  if (!(obstacle.speed_bound >= 0))
    return fmt::format("has the speed bound {}; at least 0 m/s is expected", obstacle.speed_bound);
  return {};
}

void requireObject(const Problem& problem, const Object& object) {
  if (const std::string fault = objectFault(object); !fault.empty()) refuse(problem, fault);
}

void checkWorld(const Problem& problem) {
  std::optional<CropNeeds> needs;
  for (const Object& object : problem.world.objects) {
    requireObject(problem, object);
    if (const std::string fault = motionFault(object, problem.execution.start); !fault.empty())
      refuse(problem, fmt::format("object '{}' {}", object.name, fault));
    if (const auto fault = speedBoundFault(object, problem.execution.start))
      refuse(problem, fmt::format("the speed bound of object '{}' {}", object.name, *fault));
    if (!object.cloud || object.cloud->crops.empty()) continue;
    if (!needs) needs = cropNeeds(problem);
    if (const std::string fault = cropFault(object, *needs); !fault.empty()) refuse(problem, fault);
  }
  for (const Attachment& held : problem.robot.attachments) {
    requireObject(problem, held.object);
    if (held.object.motion)
      refuse(problem, fmt::format("object '{}' is held and has a motion; one that moves with its "
                                  "link only is expected",
                                  held.object.name));
  }
  for (const DeformingObstacle& obstacle : problem.world.deforming) {
    requireObject(problem, obstacle.object);
    if (const std::string fault = deformingFault(obstacle, problem.execution); !fault.empty())
      refuse(problem, fmt::format("deforming obstacle '{}' {}", obstacle.object.name, fault));
    if (const auto fault = speedBoundFault(obstacle, problem.execution.start))
      refuse(problem, fmt::format("the speed bound of deforming obstacle '{}' {}",
                                  obstacle.object.name, *fault));
  }
}

/// Checks the names of frames, and the pairs of names in contacts, margins, wishes and steps.
void checkNames(const Problem& problem) {
  const Names names(problem);
  if (!names.fault().empty()) refuse(problem, names.fault());
  std::set<std::string_view> frames;
  for (std::size_t i = 0; i < problem.robot.frames.size(); ++i) {
    const std::string& name = problem.robot.frames[i].name;
    if (const std::string fault = frameNameFault(names, name); !fault.empty())
      refuse(problem, fault);
    if (!frames.insert(name).second)
      refuse(problem, fmt::format("frame '{}' has the name of another frame; a name of its own is "
                                  "expected",
                                  name));
  }
  const auto requirePair = [&](const std::string& a, const std::string& b, const auto& where) {
    if (const std::string fault = names.pairFault(a, b); !fault.empty())
      refuse(problem, where() + ": " + fault);
  };
  const auto& allowed = problem.contacts.allowed;
  for (std::size_t i = 0; i < allowed.size(); ++i)
    requirePair(allowed[i].first, allowed[i].second,
                [i] { return fmt::format("contacts.allowed[{}]", i); });
  const auto& checked = problem.contacts.checked;
  for (std::size_t i = 0; i < checked.size(); ++i)
    if (const std::string fault = names.checkedFault(checked[i].first, checked[i].second);
        !fault.empty())
      refuse(problem, fmt::format("contacts.checked[{}]: {}", i, fault));
  const auto& pairs = problem.margins.pairs;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto where = [i] { return fmt::format("margins.pairs[{}]", i); };
    if (const std::string fault = names.marginFault(pairs[i].a, pairs[i].b); !fault.empty())
      refuse(problem, where() + ": " + fault);
    if (!std::isfinite(pairs[i].margin))
      refuse(problem,
             fmt::format("{}.margin is {}; a finite number is expected", where(), pairs[i].margin));
  }
  const auto& wishes = problem.margins.wishes;
  for (std::size_t i = 0; i < wishes.size(); ++i) {
    const auto where = [i] { return fmt::format("margins.wishes[{}]", i); };
    if (wishes[i].pairs.empty())
      refuse(problem, where() + ".pairs is empty; at least one pair of names is expected");
    for (const auto& [a, b] : wishes[i].pairs) requirePair(a, b, where);
  }
  for (std::size_t s = 0; s < problem.steps.size(); ++s)
    for (const auto& [a, b] : problem.steps[s].allowed)
      requirePair(a, b, [s] { return fmt::format("steps[{}].allowed", s); });
}

void checkSteps(const Problem& problem) {
  if (problem.steps.empty()) return;
  if (!problem.goals.empty())
    refuse(problem, "there are goals beside the steps; one of them is expected");
  std::set<std::string_view> names;
  Problem world = problem;  // as each step finds it
  world.steps.clear();
  bool is_first = true;  // that moves
  for (std::size_t s = 0; s < problem.steps.size(); ++s) {
    const Step& step = problem.steps[s];
    if (!step.name.empty() && !names.insert(step.name).second)
      refuse(problem, fmt::format("steps[{}]: two steps are named '{}'; a name of its own is "
                                  "expected for each",
                                  s, step.name));
    try {
      takeStep(step, world, is_first);
      is_first = is_first && !movesRobot(step);
    } catch (const std::invalid_argument& error) {
      refuse(problem, fmt::format("steps[{}]{}: {}", s,
                                  step.name.empty() ? "" : " ('" + step.name + "')", error.what()));
    }
  }
}

}  // namespace

void checkRobot(const Problem& problem) {
  if (!problem.robot.model)
    refuse(problem, "robot.model is missing; one of loadModel() or freeBody() is expected");
  if (!robots::hasStepsOfItsJoints(*problem.robot.model))
    refuse(problem,
           "robot.model has joints that have changed since it was made; "
           "Model(RobotDescription) of the changed robot is expected");
  checkVariables(problem);
  require(problem, startFault(problem));
  checkCarried(problem);
}

namespace {

/// A line's frame where the robot stands, seen from the line's reference.
robots::Pose startOf(const Problem& world, const robots::PoseRegion& region) {
  std::vector<robots::Pose> X_WL(world.robot.model->links.size());
  robots::forwardKinematics(*world.robot.model, world.start, X_WL);
  return region.X_WR.inverse() * (X_WL[at(region.link)] * region.X_LF);
}

}  // namespace

void takeStep(const Step& step, Problem& world, bool is_first) {
  if (!movesRobot(step) && !step.allowed.empty())
    throw std::invalid_argument(
        "nothing moves in this step; a step that moves is expected beside "
        "'allowed'");
  if (const auto* move = std::get_if<MoveStep>(&step.action)) {
    for (const FramePose& pose : move->poses) regionOf(world, pose);
    if (!move->poses.empty()) {
      if (move->goal.ranges.empty() && move->goal.poses.empty()) return;
      throw std::invalid_argument("it has both a goal and poses; one is expected");
    }
    if (const auto fault = goalFault(world, move->goal)) throw std::invalid_argument(*fault);
  } else if (const auto* line = std::get_if<LineStep>(&step.action)) {
    for (const auto& [key, value] : {std::pair("position_tolerance", line->position_tolerance),
                                     {"angle_tolerance", line->angle_tolerance}})
      if (!(value >= kLeastLineTolerance) || !std::isfinite(value))
        throw std::invalid_argument(
            fmt::format("{} is {}; at least {} is expected", key, value, kLeastLineTolerance));
    FramePose place;
    place.frame = line->frame;
    place.relative_to = line->relative_to;
    place.position.fill({0, 0});
    place.rpy.fill({0, 0});
    const robots::PoseRegion region = regionOf(world, place);
    const bool stands = is_first && world.start_poses.empty();
    checkWay(*line, stands ? std::optional(startOf(world, region)) : std::nullopt);
  } else if (const auto* attach = std::get_if<AttachStep>(&step.action)) {
    world = attached(world, attach->object, attach->link, attach->touch, {});
  } else {
    world = detached(world, std::get<DetachStep>(step.action).object, {});
  }
}

namespace {

/// Returns which planned joint moves none of the frames that place the start: nothing says where it
/// stands. Constraints may place others.
std::optional<std::string> unplacedFault(const Problem& problem) {
  if (problem.start_poses.empty() || !problem.constraints.empty()) return std::nullopt;
  for (const int v : problem.robot.variables)
    if (std::none_of(problem.start_poses.begin(), problem.start_poses.end(),
                     [&](const robots::PoseRegion& region) {
                       return robots::movesLink(*problem.robot.model, {&v, 1}, region.link);
                     }))
      return fmt::format(
          "start says nothing of {}, which moves none of the frames that have a pose; a pose of a "
          "frame that it moves, or joint values, are expected",
          variableText(*problem.robot.model, v));
  return std::nullopt;
}

}  // namespace

void validate(const Problem& problem) {
  checkRobot(problem);
  checkWorld(problem);
  checkNames(problem);
  if (const auto wrong = posesFault(problem, problem.start_poses))
    refuse(problem, "start has a pose: " + *wrong);
  require(problem, unplacedFault(problem));
  for (const Goal& goal : problem.goals) require(problem, goalFault(problem, goal));
  checkSteps(problem);
  for (std::size_t i = 0; i < problem.constraints.size(); ++i)
    require(problem,
            constraintFault(problem, problem.constraints[i], fmt::format("constraints[{}]", i)));
  require(problem, constraintsFault(problem));
  require(problem, numbersFault(problem));
  if (const auto* cost = std::get_if<MinimumCost>(&problem.objective)) {
    require(problem, costFault(*cost));
    for (std::size_t i = 0; i < cost->terms.size(); ++i)
      require(problem, termFault(cost->terms[i], fmt::format("objective.terms[{}]", i)));
  }
  for (std::size_t i = 0; i < problem.margins.wishes.size(); ++i)
    require(problem, wishFault(problem.margins.wishes[i], fmt::format("margins.wishes[{}]", i)));
  require(problem, wishesFault(problem));
  require(problem, plannerError(problem.planner.name, problem.planner.parameters));
  require(problem, costPlannerFault(problem));
  require(problem, improveFault(problem));
  require(problem, executionFault(problem));
}

void requireTolerance(double tolerance, const char* call) {
  if (!(tolerance > 0))
    throw std::invalid_argument(fmt::format(
        "{}: clearance_tolerance is {}; a length above 0 is expected [m]", call, tolerance));
}

void requirePlaced(const Problem& problem) {
  if (problem.start_poses.empty()) return;
  refuse(problem, "the start is given by poses; placeStart() is expected to find its joint values");
}

void requireGoals(const Problem& problem, const char* call) {
  requirePlaced(problem);
  if (!problem.steps.empty())
    refuse(problem,
           fmt::format("there are steps, which {} does not follow; goals are expected", call));
  if (problem.goals.empty()) refuse(problem, "there is no goal; at least one is expected");
}

}  // namespace leeway::planner
