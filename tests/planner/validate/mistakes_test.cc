// Programs and files with one mistake each: every function that takes a problem refuses it, with
// the words of tests/data/mistakes.txt. A new check is a new line there, and a row here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/ompl_objectives.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/replanner.h"
#include "leeway/planner/simplify.h"
#include "leeway/planner/task.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A problem file, key by key.
using Keys = std::vector<std::pair<std::string, std::string>>;

Keys goodKeys() {
  const std::string robot = sourceFolder() + "/robots/arm7/arm7";
  return {
      {"leeway", "1"},
      {"robot", "{urdf: " + robot + ".urdf, srdf: " + robot + ".srdf, group: arm}"},
      {"frames", "{tip: {link: hand}}"},
      {"objects", "[{name: post, cylinder: {radius: 0.05, length: 1}, position: [0.5, 0.5, 0.5]}]"},
      {"start", "ready"},
      {"goal", "tucked"}};
}

/// With other values for some keys; without a goal beside steps.
std::string textOf(Keys keys, const Keys& others) {
  for (const auto& other : others) {
    std::erase_if(keys, [&](const auto& key) {
      return key.first == other.first || (other.first == "steps" && key.first == "goal");
    });
    keys.push_back(other);
  }
  std::string text;
  for (const auto& [key, value] : keys) text += key + ": " + value + "\n";
  return text;
}

Problem goodProblem() {
  static const Problem problem = [] {
    const Folder folder;
    return loadProblem(folder.write("good.yaml", textOf(goodKeys(), {})));
  }();
  return problem;
}

std::shared_ptr<const collision::DeformableMesh> cloth() {
  return collision::DeformableMesh::make(
      std::vector<Eigen::Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
      std::vector<collision::DeformableMesh::Triangle>{{0, 1, 2}});
}

DeformingObstacle deforming(const std::string& name) {
  return makeDeformingObstacle(name, cloth(), nullptr, test::at(5, 0, 0));
}

Attachment held(const std::string& name) {
  Attachment attachment;
  attachment.object = {name, {{collision::Shape::sphere(0.01), {}, name}}, {}};
  attachment.link = 8;
  return attachment;
}

robots::PoseRegion poseOf(int link) {
  return robots::PoseRegion::exact(link, {}, {}, test::at(0.4, 0, 0.4));
}

Goal poseGoal(const robots::PoseRegion& region) { return {"pose", {}, {region}}; }

collision::Pose garbage() {
  collision::Pose X;
  X.rotation.setConstant(kNan);
  return X;
}

/// A mistake: what makes it in a program, null where only files can; and in a file, if they can.
struct Mistake {
  const char* name;
  std::function<void(Problem&)> make;
  Keys keys = {};
};

using P = Problem;

void steps(P& p, std::vector<Step> steps) {
  p.goals.clear();
  p.steps = std::move(steps);
}

MoveStep toTucked() { return {goodProblem().goals[0], {}}; }

std::vector<Mistake> robotMistakes() {
  return {
      {"no_model", [](P& p) { p.robot.model = nullptr; }},
      {"no_variables", [](P& p) { p.robot.variables.clear(); }},
      {"variable_out_of_range", [](P& p) { p.robot.variables[0] = 99; }},
      {"variable_twice", [](P& p) { p.robot.variables[1] = p.robot.variables[0]; }},
      {"held_by_no_link",
       [](P& p) {
         p.robot.attachments = {held("part")};
         p.robot.attachments[0].link = -1;
       }},
      {"touch_no_link",
       [](P& p) {
         p.robot.attachments = {held("part")};
         p.robot.attachments[0].touch_links = {12};
       }},
      {"held_half_space",
       [](P& p) {
         p.robot.attachments = {held("wall")};
         p.robot.attachments[0].object.geometries[0].shape = collision::Shape::halfSpace();
       },
       {{"objects", "[{name: wall, half_space: {}, attach: {link: hand}}]"}}},
      {"held_nowhere",
       [](P& p) {
         p.robot.attachments = {held("part")};
         p.robot.attachments[0].X_LO.translation.z() = kInfinite;
       }},
      {"frame_of_no_link",
       [](P& p) {
         p.robot.frames = {{"tip", 99, {}}};
       }},
      {"frame_like_link",
       [](P& p) {
         p.robot.frames = {{"hand", 8, {}}};
       },
       {{"frames", "{hand: {link: hand}}"}}},
      {"frame_like_world",
       [](P& p) {
         p.robot.frames = {{"world", 8, {}}};
       },
       {{"frames", "{world: {link: hand}}"}}},
      {"frame_like_robot",
       [](P& p) {
         p.robot.frames = {{"robot", 8, {}}};
       },
       {{"frames", "{robot: {link: hand}}"}}},
  };
}

std::vector<Mistake> stateMistakes() {
  return {
      {"short_start", [](P& p) { p.start.pop_back(); }},
      {"start_not_finite", [](P& p) { p.start[1] = kNan; }},
      {"start_outside", [](P& p) { p.start[1] = 9; }, {{"start", "[0, 9, 0, 0, 0, 0, 0]"}}},
      {"other_not_finite", [](P& p) { p.start[7] = kInfinite; }},
      {"goal_of_another_size", [](P& p) { p.goals[0].ranges.pop_back(); }},
      {"goal_not_finite",
       [](P& p) {
         p.goals[0].ranges[0] = {0, kNan};
       }},
      {"goal_reversed",
       [](P& p) {
         p.goals[0].ranges[0] = {1, 0.5};
       }},
      {"goal_outside",
       [](P& p) {
         p.goals[0].ranges[1] = {9, 9};
       },
       {{"goal", "[0, 9, 0, 0, 0, 0, 0]"}}},
      {"goal_partly_outside",
       [](P& p) {
         p.goals[0].ranges[1] = {1, 3};
       },
       {{"goal", "[0, [1, 3], 0, 0, 0, 0, 0]"}}},
      {"goal_both_ways", [](P& p) { p.goals[0].poses = {poseOf(8)}; }},
      {"goal_pose_of_no_link", [](P& p) { p.goals = {poseGoal(poseOf(99))}; }},
      {"goal_pose_reversed",
       [](P& p) {
         robots::PoseRegion region = poseOf(8);
         region.position[0] = {1, 0};
         p.goals = {poseGoal(region)};
       }},
      {"goal_pose_no_rotation",
       [](P& p) {
         robots::PoseRegion region = poseOf(8);
         region.X_WR = garbage();
         p.goals = {poseGoal(region)};
       }},
      {"goal_beside_steps",
       [](P& p) {
         p.steps = {{"go", toTucked(), {}}};
       }},
  };
}

std::vector<Mistake> nameMistakes() {
  return {
      {"margin_of_nothing",
       [](P& p) {
         p.margins.pairs = {{"hand", "psot", 0.1}};
       },
       {{"margins", "[{between: [hand, psot], margin: 0.1}]"}}},
      {"allowed_of_nothing",
       [](P& p) {
         p.contacts.allowed = {{"finger_let", "post"}};
       },
       {{"allowed", "[[finger_let, post]]"}}},
      {"wish_of_nothing",
       [](P& p) {
         p.margins.wishes = {{"wish", {{"hand", "psot"}}, 0.1}};
       },
       {{"margins", "[{between: [hand, psot], wish: 0.1}]"}}},
      {"margin_of_one",
       [](P& p) {
         p.margins.pairs = {{"post", "post", 0.1}};
       },
       {{"margins", "[{between: [post, post], margin: 0.1}]"}}},
      {"allowed_of_one",
       [](P& p) {
         p.contacts.allowed = {{"hand", "hand"}};
       },
       {{"allowed", "[[hand, hand]]"}}},
      {"wish_of_one",
       [](P& p) {
         p.margins.wishes = {{"wish", {{"post", "post"}}, 0.1}};
       },
       {{"margins", "[{between: [post, post], wish: 0.1}]"}}},
      {"wish_of_no_pair",
       [](P& p) {
         p.margins.wishes = {{"wish", {}, 0.1}};
       }},
      {"margin_of_world_twice",
       [](P& p) {
         p.margins.pairs = {{"world", "world", 0.1}};
       },
       {{"margins", "[{between: [world, world], margin: 0.1}]"}}},
      {"margin_of_unknown_and_world",
       [](P& p) {
         p.margins.pairs = {{"hnad", "world", 0.1}};
       },
       {{"margins", "[{between: [hnad, world], margin: 0.1}]"}}},
      {"allowed_of_world",
       [](P& p) {
         p.contacts.allowed = {{"hand", "world"}};
       },
       {{"allowed", "[[hand, world]]"}}},
      {"checked_of_object",
       [](P& p) {
         p.contacts.checked = {{"hand", "post"}};
       },
       {{"checked", "[[hand, post]]"}}},
      {"checked_and_allowed",
       [](P& p) {
         p.contacts.checked = {{"link1", "link2"}};
         p.contacts.allowed = {{"link2", "link1"}};
       },
       {{"allowed", "[[link2, link1]]"}, {"checked", "[[link1, link2]]"}}},
      {"wish_of_world",
       [](P& p) {
         p.margins.wishes = {{"wish", {{"hand", "world"}}, 0.1}};
       },
       {{"margins", "[{between: [hand, world], wish: 0.1}]"}}},
      {"object_like_world",
       [](P& p) { p.world.objects[0].name = "world"; },
       {{"objects", "[{name: world, sphere: {radius: 0.1}}]"}}},
      {"object_like_link",
       [](P& p) { p.world.objects[0].name = "hand"; },
       {{"objects", "[{name: hand, sphere: {radius: 0.1}}]"}}},
      {"object_twice",
       [](P& p) { p.world.objects.push_back(p.world.objects[0]); },
       {{"objects", "[{name: post, sphere: {radius: 0.1}}, {name: post, sphere: {radius: 0.1}}]"}}},
      {"object_like_robot",
       [](P& p) { p.world.objects[0].name = "robot"; },
       {{"objects", "[{name: robot, sphere: {radius: 0.1}}]"}}},
      {"object_color",
       [](P& p) {
         p.world.objects[0].color = {0, 1.5, 0};
       },
       {{"objects", "[{name: post, sphere: {radius: 0.1}, color: [0, 1.5, 0]}]"}}},
      {"deforming_like_robot", [](P& p) { p.world.deforming = {deforming("robot")}; }},
      {"object_unnamed", [](P& p) { p.world.objects[0].name.clear(); }},
      {"held_like_object", [](P& p) { p.robot.attachments = {held("post")}; }},
      {"deforming_like_object", [](P& p) { p.world.deforming = {deforming("post")}; }},
      {"frame_unnamed",
       [](P& p) {
         p.robot.frames = {{"", 8, {}}};
       }},
  };
}

std::vector<Mistake> poseMistakes() {
  return {
      {"garbage_rotation", [](P& p) { p.world.objects[0].X_WO.rotation = garbage().rotation; }},
      {"mirrored_rotation", [](P& p) { p.world.objects[0].X_WO.rotation(0, 0) = -1; }},
      {"scaled_rotation", [](P& p) { p.world.objects[0].X_WO.rotation *= 1.001; }},
      {"pose_not_finite", [](P& p) { p.world.objects[0].X_WO.translation.x() = kNan; }},
      {"shape_nowhere",
       [](P& p) { p.world.objects[0].geometries[0].X_BG.translation.y() = kInfinite; }},
      {"frame_garbage",
       [](P& p) {
         p.robot.frames = {{"tip", 8, garbage()}};
       }},
  };
}

std::vector<Mistake> numberMistakes() {
  return {
      {"margin_not_finite", [](P& p) { p.margins.common = kNan; }},
      {"pair_margin_not_finite",
       [](P& p) {
         p.margins.pairs = {{"hand", "post", kInfinite}};
       }},
      {"wish_of_no_length",
       [](P& p) {
         p.margins.wishes = {{"wish", {{"hand", "post"}}, 0}};
       },
       {{"margins", "[{between: [hand, post], wish: 0}]"}}},
      {"wish_of_no_weight",
       [](P& p) {
         p.margins.wishes = {{"wish", {{"hand", "post"}}, 0.1, -1}};
       },
       {{"margins", "[{between: [hand, post], wish: 0.1, weight: -1}]"}}},
      {"time_not_a_number", [](P& p) { p.limits.time = kNan; }},
      {"time_negative", [](P& p) { p.limits.time = -1; }, {{"limits", "{time: -1}"}}},
      {"iterations_negative", [](P& p) { p.limits.iterations = -1; }},
      {"step_of_no_time", [](P& p) { p.execution.step = 0; }, {{"execution", "{step: 0}"}}},
      {"duration_below_step",
       [](P& p) { p.execution.duration = 0.01; },
       {{"execution", "{duration: 0.01}"}}},
      {"speed_above_1", [](P& p) { p.execution.speed = 2; }, {{"execution", "{speed: 2}"}}},
      {"look_ahead_not_a_number", [](P& p) { p.execution.look_ahead = kNan; }},
      {"buffer_negative", [](P& p) { p.execution.buffer = -1; }, {{"execution", "{buffer: -1}"}}},
      {"velocity_of_nothing",
       [](P& p) { p.execution.velocities["joint9"] = 1; },
       {{"execution", "{velocities: {joint9: 1}}"}}},
      {"velocity_of_unplanned",
       [](P& p) { p.execution.velocities["finger_joint"] = 1; },
       {{"execution", "{velocities: {finger_joint: 1}}"}}},
      {"velocity_of_0",
       [](P& p) { p.execution.velocities["joint1"] = 0; },
       {{"execution", "{velocities: {joint1: 0}}"}}},
  };
}

std::vector<Mistake> objectiveMistakes() {
  const auto cost = [](double distance, double weight) {
    return MinimumCost{0, {{{Nearness::Kind::kHinge, distance}, weight}}};
  };
  return {
      {"weight_not_a_number", [=](P& p) { p.objective = cost(0.1, kNan); }},
      {"nearness_of_no_length",
       [=](P& p) { p.objective = cost(0, 1); },
       {{"objective", "{integral: {hinge: 0}}"}}},
      {"weighs_nothing",
       [](P& p) { p.objective = MinimumCost{}; },
       {{"objective", "{weighted: {length: 0}}"}}},
      {"keep_not_a_number", [](P& p) { p.objective = MinimumLength{kNan}; }},
      {"longer_not_a_number",
       [](P& p) {
         p.objective = MaximumClearance{Pairs::kWorld, kNan};
       }},
      {"wish_beside_clearance",
       [](P& p) {
         p.margins.wishes = {{"wish", {{"hand", "post"}}, 0.1}};
         p.objective = MaximumClearance{};
       },
       {{"margins", "[{between: [hand, post], wish: 0.1}]"}, {"objective", "clearance"}}},
      {"planner_unknown",
       [](P& p) { p.planner.name = "RRTConect"; },
       {{"planner", "{name: RRTConect}"}}},
      {"parameter_unknown",
       [](P& p) { p.planner.parameters["rnge"] = "1"; },
       {{"planner", "{parameters: {rnge: 1}}"}}},
      {"planner_without_costs",
       [=](P& p) {
         p.planner.name = "LBTRRT";
         p.objective = cost(0.1, 1);
       },
       {{"planner", "{name: LBTRRT}"}, {"objective", "{integral: {hinge: 0.1}}"}}},
      {"improve_beside_clearance",
       [](P& p) {
         p.planner.parameters["improve"] = "1";
         p.objective = MaximumClearance{};
       },
       {{"planner", "{parameters: {improve: 1}}"}, {"objective", "clearance"}}},
  };
}

std::vector<Mistake> deformingMistakes() {
  return {
      {"deforming_of_another_time",
       [](P& p) {
         p.world.deforming = {deforming("cloth")};
         p.execution.start = 1;
       }},
      {"deforming_without_snapshot",
       [](P& p) {
         p.world.deforming = {deforming("cloth")};
         p.world.deforming[0].mesh = cloth();
       }},
      {"deforming_with_a_rigid_motion",
       [](P& p) {
         p.world.deforming = {deforming("cloth")};
         p.world.deforming[0].object.motion = std::make_shared<const ObjectMotion>();
       }},
      {"deforming_of_no_speed",
       [](P& p) {
         p.world.deforming = {deforming("cloth")};
         p.world.deforming[0].speed_bound = kNan;
       }},
  };
}

std::vector<Mistake> stepMistakes() {
  const auto pose = [](const std::string& frame) {
    FramePose at_origin;
    at_origin.frame = frame;
    at_origin.position.fill({0, 0});
    at_origin.rpy.fill({0, 0});
    return at_origin;
  };
  return {
      {"step_allows_nothing",
       [](P& p) {
         steps(p, {{"go", toTucked(), {{"hand", "psot"}}}});
       },
       {{"steps", "[{move: tucked, allowed: [[hand, psot]]}]"}}},
      {"step_takes_nothing",
       [](P& p) {
         steps(p, {{"take", AttachStep{"psot", "hand", {}}, {}}});
       },
       {{"steps", "[{attach: {object: psot, link: hand}}]"}}},
      {"step_held_by_nothing",
       [](P& p) {
         steps(p, {{"take", AttachStep{"post", "hnad", {}}, {}}});
       },
       {{"steps", "[{attach: {object: post, link: hnad}}]"}}},
      {"step_lets_go_of_nothing",
       [](P& p) {
         steps(p, {{"drop", DetachStep{"post"}, {}}});
       },
       {{"steps", "[{detach: post}]"}}},
      {"step_takes_half_space",
       [](P& p) {
         p.world.objects.push_back(
             {"wall", {{collision::Shape::halfSpace(), {}, "wall"}}, test::at(0, 0, -1)});
         steps(p, {{"take", AttachStep{"wall", "hand", {}}, {}}});
       },
       {{"objects", "[{name: wall, half_space: {}, position: [0, 0, -1]}]"},
        {"steps", "[{attach: {object: wall, link: hand}}]"}}},
      {"step_takes_twice",
       [](P& p) {
         steps(p, {{"take", AttachStep{"post", "hand", {}}, {}},
                   {"again", AttachStep{"post", "hand", {}}, {}}});
       },
       {{"steps", "[{attach: {object: post, link: hand}}, {attach: {object: post, link: hand}}]"}}},
      {"step_to_nothing",
       [=](P& p) {
         steps(p, {{"go", MoveStep{{}, {pose("tol")}}, {}}});
       },
       {{"steps", "[{move: {pose: {frame: tol, position: [0, 0, 0]}}}]"}}},
      {"step_of_no_length",
       [](P& p) {
         steps(p, {{"go", LineStep{"tool", {0, 0, 0}, {}}, {}}});
       },
       {{"steps", "[{line: {frame: tool, by: [0, 0, 0]}}]"}}},
      {"constraint_of_nothing",
       [](P& p) {
         p.constraints = {upright("tol", {0, 0, 1}, 3)};
       },
       {{"constraints", "[{frame: tol, axis: [0, 0, 1], angle: 3}]"}}},
      {"constraint_that_keeps_nothing",
       [](P& p) {
         p.constraints.emplace_back();
         p.constraints[0].frame = "tool";
       },
       {{"constraints", "[{frame: tool}]"}}},
      {"constraint_without_room",
       [](P& p) {
         p.constraints = {upright("tool", {0, 0, 1}, 3)};
         p.constraints[0].position_tolerance = 0;
       },
       {{"constraints", "[{frame: tool, position: [0, any, any], position_tolerance: 0}]"}}},
      {"constraint_of_any_angle",
       [](P& p) {
         p.constraints = {upright("tool", {0, 0, 1}, 4)};
       },
       {{"constraints", "[{frame: tool, axis: [0, 0, 1], angle: 4}]"}}},
      {"constraint_without_axis",
       [](P& p) {
         p.constraints = {upright("tool", {0, 0, 0}, 3)};
       },
       {{"constraints", "[{frame: tool, axis: [0, 0, 0], angle: 3}]"}}},
      {"constraint_of_one_body",
       [](Problem& p) {
         p.constraints = {upright("tool", {0, 0, 1}, 3)};
         p.constraints[0].relative_to = "hand";
       },
       {{"constraints", "[{frame: tool, relative_to: hand, axis: [0, 0, 1], angle: 3}]"}}},
      {"constraint_back_to_front",
       [](P& p) {
         p.constraints = {upright("tool", {0, 0, 1}, 3)};
         p.constraints[0].position[1] = {1, 0};
       },
       {}},
      {"constraint_of_the_base",
       [](P& p) {
         p.constraints = {upright("base", {0, 0, 1}, 3)};
       },
       {{"constraints", "[{frame: base, axis: [0, 0, 1], angle: 3}]"}}},
      {"constraint_beside_steps",
       [](P& p) {
         p.constraints = {upright("tool", {0, 0, 1}, 3)};
         steps(p, {{"go", LineStep{"tool", {0, 0, 1}, {}}, {}}});
       },
       {{"constraints", "[{frame: tool, axis: [0, 0, 1], angle: 3}]"},
        {"steps", "[{line: {frame: tool, by: [0, 0, 1]}}]"}}},
      {"constraint_beside_clearance",
       [](P& p) {
         p.constraints = {upright("tool", {0, 0, 1}, 3)};
         p.objective = MaximumClearance{};
       },
       {{"constraints", "[{frame: tool, axis: [0, 0, 1], angle: 3}]"}, {"objective", "clearance"}}},
      {"constraint_for_another_planner",
       [](P& p) {
         p.constraints = {upright("tool", {0, 0, 1}, 3)};
         p.planner.name = "RRTConnect";
       },
       {{"constraints", "[{frame: tool, axis: [0, 0, 1], angle: 3}]"},
        {"planner", "{name: RRTConnect}"}}},
      {"no_share_of_acceleration",
       [](P& p) { p.execution.acceleration_scale = 0; },
       {{"execution", "{acceleration_scale: 0}"}}},
      {"more_than_all_jerk",
       [](P& p) { p.execution.jerk_scale = 1.5; },
       {{"execution", "{jerk_scale: 1.5}"}}},
      {"step_without_tolerance",
       [](P& p) {
         steps(p, {{"go", LineStep{"tool", {0, 0, 1}, {}, 1e-9}, {}}});
       },
       {{"steps", "[{line: {frame: tool, by: [0, 0, 1], position_tolerance: 1e-9}}]"}}},
      {"step_twice",
       [](P& p) {
         steps(p, {{"go", toTucked(), {}}, {"go", toTucked(), {}}});
       },
       {{"steps", "[{name: go, move: tucked}, {name: go, move: tucked}]"}}},
      {"step_allows_beside_attach",
       [](P& p) {
         steps(p, {{"take", AttachStep{"post", "hand", {}}, {{"post", "hand"}}}});
       },
       {{"steps", "[{attach: {object: post, link: hand}, allowed: [[post, hand]]}]"}}},
  };
}

std::vector<Mistake> mistakes() {
  std::vector<Mistake> all;
  for (const auto& some :
       {robotMistakes(), stateMistakes(), nameMistakes(), poseMistakes(), numberMistakes(),
        objectiveMistakes(), deformingMistakes(), stepMistakes()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

/// tests/data/mistakes.txt, by name.
struct Line {
  std::string who, words;
};
std::map<std::string, Line> lines() {
  std::map<std::string, Line> all;
  std::ifstream file(sourceFolder() + "/tests/data/mistakes.txt");
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t first = line.find(" | "), second = line.find(" | ", first + 3);
    all[line.substr(0, first)] = {line.substr(first + 3, second - first - 3),
                                  line.substr(second + 3)};
  }
  return all;
}

/// What `call` refuses with; "accepted" when it does not.
std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const robots::InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// Every function that takes a problem.
struct Entry {
  const char* name;
  std::function<void(const Problem&)> call;
};

const std::vector<Entry>& entries() {
  static const Folder folder;
  static const auto scene = std::make_shared<const CompiledScene>(goodProblem());
  static const PlanResult result = plan(goodProblem());
  static const std::vector<Entry> all = {
      {"validate", [](const P& p) { validate(p); }},
      {"plan", [](const P& p) { plan(p); }},
      {"planTask", [](const P& p) { planTask(p); }},
      {"solve", [](const P& p) { solve(p); }},
      {"plan in a scene", [](const P& p) { plan(scene, p); }},
      {"verify", [](const P& p) { verify(p, result.path); }},
      {"CompiledScene", [](const P& p) { CompiledScene{p}; }},
      {"placeStart", [](const P& p) { placeStart(p); }},
      {"attachObject", [](const P& p) { attachObject(p, "post", "hand"); }},
      {"detachObject", [](const P& p) { detachObject(p, "post"); }},
      {"Replanner", [](const P& p) { Replanner{p}; }},
      {"replan", [](const P& p) { replan(p); }},
      {"motionLimits", [](const P& p) { motionLimits(p); }},
      {"trajectoryOf", [](const P& p) { trajectoryOf(p, result.path); }},
      {"writePath", [](const P& p) { writePath(folder.path("a.csv"), p, result); }},
      {"readPath", [](const P& p) { readPath(folder.path("a.csv"), p); }},
      {"writeTrajectory",
       [](const P& p) {
         const std::vector<TimedPoint> points = {{0, result.path.positions[0]}};
         writeTrajectory(folder.path("b.csv"), p, points);
       }},
      {"OmplCostObjective",
       [](const P& p) {
         const auto pool = std::make_shared<CertifierPool>(scene);
         Problem costs = p;
         const auto* length = std::get_if<MinimumLength>(&p.objective);
         if (length != nullptr && length->clearance == -kInfinite)
           costs.objective = MinimumCost{1, {}};
         OmplCostObjective(makeSpaceInformation(scene, 1, pool), pool, costs);
       }},
  };
  return all;
}

/// Whether a call refuses something else first: steps, missing steps, or a scene that differs.
bool mayRefuseOtherwise(const std::string& entry, const Problem& problem) {
  if (entry == "plan in a scene" || entry == "OmplCostObjective") return true;
  const bool needs_goals = entry == "plan" || entry == "solve" || entry == "plan in a scene";
  return needs_goals && !problem.steps.empty();
}

TEST(Mistakes, ListAndRowsAreTheSame) {
  std::set<std::string> programs, files, listed_programs, listed_files;
  for (const Mistake& mistake : mistakes()) {
    EXPECT_TRUE(programs.insert(mistake.name).second) << mistake.name;
    if (!mistake.keys.empty()) files.insert(mistake.name);
  }
  for (const auto& [name, line] : lines()) {
    if (line.who.find('c') != std::string::npos) listed_programs.insert(name);
    if (line.who.find('f') != std::string::npos) listed_files.insert(name);
  }
  EXPECT_EQ(programs, listed_programs);
  EXPECT_EQ(files, listed_files);
  EXPECT_GT(programs.size(), 70U);
}

TEST(Mistakes, WhatTheRowsChangeIsAGoodProblem) {
  const Problem good = goodProblem();
  EXPECT_NO_THROW(validate(good));
  EXPECT_EQ(plan(good).status, PlanStatus::kSolved);
  EXPECT_TRUE(plan(good).warnings.empty());
  Problem task = good;
  steps(task, {{"go", toTucked(), {}}});
  EXPECT_EQ(planTask(task).status, PlanStatus::kSolved);
}

TEST(Mistakes, ProgramsAreRefusedByEveryFunction) {
  const std::map<std::string, Line> listed = lines();
  for (const Mistake& mistake : mistakes()) {
    Problem problem = goodProblem();
    mistake.make(problem);
    const std::string& words = listed.at(mistake.name).words;
    for (const Entry& entry : entries()) {
      const std::string said = refusal([&] { entry.call(problem); });
      EXPECT_NE(said, "accepted") << entry.name << ": " << mistake.name;
      if (mayRefuseOtherwise(entry.name, problem)) continue;
      EXPECT_NE(said.find(words), std::string::npos) << entry.name << ": " << mistake.name << "\n"
                                                     << said;
    }
  }
}

TEST(Mistakes, FilesAreRefusedWithTheSameWordsAndTheirLine) {
  const Folder folder;
  const std::map<std::string, Line> listed = lines();
  for (const Mistake& mistake : mistakes()) {
    if (mistake.keys.empty()) continue;
    const std::string text = textOf(goodKeys(), mistake.keys);
    const std::string file = folder.write("problem.yaml", text);
    try {
      loadProblem(file);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const robots::InputError& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find(listed.at(mistake.name).words), std::string::npos) << mistake.name << "\n"
                                                                             << said;
      EXPECT_EQ(error.file(), file);
    }
  }
}

/// A scene, and one thing of its problem that changes afterwards.
TEST(Mistakes, AProblemThatHasChangedIsNotPlannedInItsScene) {
  Problem good = goodProblem();
  good.robot.attachments = {held("part")};
  good.margins.pairs = {{"hand", "post", 0.01}};
  good.world.deforming = {deforming("cloth")};
  const auto scene = std::make_shared<const CompiledScene>(good);
  const auto arm6 = robots::loadModel(sourceFolder() + "/robots/arm6/arm6.urdf", "");
  const std::vector<std::pair<std::function<void(Problem&)>, std::string>> changes = {
      {[](P& p) { p.margins.common = 0.1; }, "margins differs"},
      {[](P& p) { p.margins.pairs[0].margin = 0.1; }, "margins differs"},
      {[](P& p) {
         p.margins.pairs.push_back({"hand", "post", 0.1});
       },
       "margins differs"},
      {[](P& p) { p.contacts.allowed.emplace_back("hand", "post"); }, "contacts differs"},
      {[](P& p) { p.contacts.checked.emplace_back("link1", "link2"); }, "contacts differs"},
      {[](P& p) { p.contacts.replace_srdf = true; }, "contacts differs"},
      {[](P& p) {
         p.margins.wishes = {{"wish", {{"hand", "post"}}, 0.1}};
       },
       "margins.wishes, in the pairs that they name, differs"},
      {[](P& p) { p.start[7] = 0.01; }, "start, in a variable that is not planned, differs"},
      {[](P& p) { p.start.pop_back(); }, "the size of start differs"},
      {[](P& p) { p.robot.variables.pop_back(); }, "robot.variables differs"},
      {[](P& p) { p.robot.variables[0] = 99; }, "robot.variables differs"},
      {[](P& p) { p.robot.model = nullptr; }, "robot.model differs"},
      {[&](P& p) { p.robot.model = arm6; }, "robot.model differs"},
      {[](P& p) { p.robot.attachments.clear(); }, "robot.attachments differs"},
      {[](P& p) { p.robot.attachments[0].X_LO.translation.x() = 0.1; },
       "robot.attachments differs"},
      {[](P& p) { p.world.objects.clear(); }, "the scene has an object 'post' besides"},
      {[](P& p) { p.world.objects[0].X_WO.translation.x() += 1e-9; },
       "object 'post' stands elsewhere there"},
      {[](P& p) { p.world.objects[0].geometries[0].shape = collision::Shape::sphere(1); },
       "object 'post' has another shape there"},
      {[](P& p) { p.world.objects[0].name = "pole"; }, "the scene has no object 'pole'"},
      {[](P& p) {
         p.world.objects.push_back(test::box("wall", {1, 1, 1}, 5, 0, 0));
       },
       "the scene has no object 'wall'"},
      {[](P& p) { p.world.deforming.clear(); }, "world.deforming differs"},
      {[](P& p) { p.world.deforming = {deforming("cloth")}; },
       "world.deforming, at 'cloth', differs"},
      {[](P& p) { p.execution.start = 1; }, "execution.start differs"},
  };
  EXPECT_EQ(scene->differenceFrom(good), "");
  EXPECT_EQ(plan(scene, good).status, PlanStatus::kSolved);
  for (const auto& [change, words] : changes) {
    Problem changed = good;
    change(changed);
    EXPECT_NE(scene->differenceFrom(changed).find(words), std::string::npos)
        << words << "\n"
        << scene->differenceFrom(changed);
    EXPECT_NE(refusal([&] { plan(scene, changed); }).find(words), std::string::npos);
  }
  // Values that compiling does not read may differ.
  Problem other = good;
  other.seed = 7;
  other.start[0] = 0.1;
  other.goals[0].ranges[0] = {0.2, 0.2};
  other.objective = MinimumLength{0.01};
  EXPECT_EQ(plan(scene, other).status, PlanStatus::kSolved);
}

TEST(Mistakes, ASceneWithObjectsAddedIsOfItsProblemAsItWasOrAsItIs) {
  const Problem before = goodProblem();
  const auto scene = std::make_shared<const CompiledScene>(before);
  const Object wall = test::box("wall", {0.1, 1, 1}, 5, 0, 0),
               sill = test::box("sill", {1, 1, 1}, 6, 0, 0);
  const auto added = scene->withObjects({{wall, sill}});
  EXPECT_EQ(added->differenceFrom(before), "");
  Problem half = before;
  half.world.objects.push_back(sill);
  EXPECT_EQ(added->differenceFrom(half), "the scene has an object 'wall' besides");
  Problem after = half;
  after.world.objects.push_back(wall);  // in another order
  EXPECT_EQ(added->differenceFrom(after), "");
  EXPECT_EQ(scene->differenceFrom(after), "the scene has no object 'sill'");
  const auto gone = added->withObjects({}, {{scene->scene().find("post")}});
  after.world.objects.erase(after.world.objects.begin());
  EXPECT_EQ(gone->differenceFrom(after), "");
  // Margins and pairs of variants are the caller's.
  EXPECT_EQ(scene->withMarginAtLeast(0.01)->differenceFrom(before), "");
  EXPECT_EQ(scene->withMarginsGrown(0.01)->differenceFrom(before), "");
}

template <class Exception>
std::string thrown(const std::function<void()>& call) {
  try {
    call();
  } catch (const Exception& error) {
    return error.what();
  }
  return "accepted";
}

void expectThrown(const std::string& said, const std::string& words) {
  EXPECT_NE(said.find(words), std::string::npos) << said;
}

TEST(Mistakes, ObjectsThatAreAddedHaveNamesAndPlacesOfTheirOwn) {
  const CompiledScene scene(goodProblem());
  const auto refused = [&](std::vector<Object> objects) {
    return thrown<robots::InputError>([&] { scene.withObjects(objects); });
  };
  const Object wall = test::box("wall", {1, 1, 1}, 5, 0, 0);
  for (const char* name : {"post", "hand", "tool", ""}) {
    Object object = wall;
    object.name = name;
    expectThrown(refused({object}),
                 "'" + std::string(name) + "' is the name of another object or link");
  }
  expectThrown(refused({wall, wall}), "'wall' is the name of another object or link");
  Object lost = wall;
  lost.X_WO = garbage();
  expectThrown(refused({lost}), "the pose of 'wall'");
  // One that goes leaves its name, one that comes takes it.
  const std::vector<int> post{scene.scene().find("post")};
  const auto moved = scene.withObjects({{test::box("post", {1, 1, 1}, 5, 0, 0)}}, post);
  expectThrown(thrown<robots::InputError>([&] {
                 moved->withObjects({{test::box("post", {1, 1, 1}, 6, 0, 0)}});
               }),
               "'post' is the name of another object or link");
}

TEST(Mistakes, OnlyDeformingObstaclesTakeOtherShapes) {
  Problem problem = goodProblem();
  problem.world.deforming = {deforming("cloth")};
  const CompiledScene scene(problem);
  const int post = scene.scene().find("post"), cloth_body = scene.scene().find("cloth");
  const collision::Shape snapshot = problem.world.deforming[0].object.geometries[0].shape;
  const auto refused = [&](const CompiledScene::Replacement& replacement) {
    return thrown<std::invalid_argument>([&] { scene.withShapes({{replacement}}); });
  };
  EXPECT_NO_THROW(scene.withShapes({{{cloth_body, 0, snapshot}}}));
  expectThrown(refused({post, 0, snapshot}), "('post') is no deforming obstacle");
  expectThrown(refused({0, 0, snapshot}), "is no deforming obstacle");
  expectThrown(refused({-1, 0, snapshot}), "is no deforming obstacle");
  expectThrown(refused({99, 0, snapshot}), "is no deforming obstacle");
  expectThrown(refused({cloth_body, 1, snapshot}), "is no deforming obstacle");
  expectThrown(refused({cloth_body, 0, collision::Shape::sphere(1)}),
               "a snapshot of its own mesh is expected");
  expectThrown(refused({cloth_body, 0, deforming("cloth").object.geometries[0].shape}),
               "a snapshot of its own mesh is expected");
}

TEST(Mistakes, OtherArgumentsAreChecked) {
  const Problem good = goodProblem();
  const auto scene = std::make_shared<const CompiledScene>(good);
  const auto other = std::make_shared<const CompiledScene>(good);
  const auto invalid = [](const std::function<void()>& call) {
    return thrown<std::invalid_argument>(call);
  };
  expectThrown(invalid([] { EdgeCertifier(nullptr); }), "a compiled scene is expected");
  expectThrown(invalid([&] { EdgeCertifier(scene).rebind(nullptr); }), "a compiled scene");
  expectThrown(invalid([&] { plan(nullptr, good); }), "a compiled scene is expected");
  expectThrown(invalid([] { makeSpaceInformation(nullptr); }), "a compiled scene is expected");
  expectThrown(
      invalid([&] { makeSpaceInformation(scene, 1, std::make_shared<CertifierPool>(other)); }),
      "the certifiers are of another scene");
  expectThrown(invalid([&] { scene->withMarginAtLeast(kNan); }), "the margin is nan");
  expectThrown(invalid([&] { scene->withWorldMarginAtLeast(kNan); }), "the margin is nan");
  expectThrown(invalid([&] { scene->withMarginsGrown(-1); }), "the growth is -1");
  for (const double tolerance : {kNan, 0.0, -1.0}) {
    PlanOptions options;
    options.clearance_tolerance = tolerance;
    expectThrown(invalid([&] { plan(good, options); }), "clearance_tolerance is");
    expectThrown(invalid([&] { plan(scene, good, options); }), "clearance_tolerance is");
    expectThrown(invalid([&] { planTask(good, options); }), "clearance_tolerance is");
    ReplanOptions replan_options;
    replan_options.clearance_tolerance = tolerance;
    expectThrown(invalid([&] { Replanner(good, replan_options); }), "clearance_tolerance is");
  }
  EdgeCertifier certifier(scene);
  std::vector<std::vector<double>> path = {{0}, {1}};
  expectThrown(invalid([&] { simplify(certifier, path); }), "a waypoint of 1 numbers; 7");
  expectThrown(invalid([&] { pathLength(scene->space(), path); }), "a waypoint of 1 numbers; 7");
  expectThrown(invalid([&] { certifiedCuts(scene, path, MotionLimits()); }),
               "a waypoint of 1 numbers; 7");
  expectThrown(invalid([&] { certifiedCuts(nullptr, path, MotionLimits()); }),
               "a compiled scene is expected");
  expectThrown(invalid([] { SpeedProfile({1, 0, 1}, 1); }), "limits and a length above 0 are");
  EXPECT_EQ(certifier.decide(path[0]), Verdict::kUndecided);
  EXPECT_EQ(certifier.certify(path[0], path[1]).verdict, Verdict::kUndecided);
  EXPECT_EQ(certifier.clearance(path[0], 1e-3).verdict, Verdict::kUndecided);
  expectThrown(invalid([] { ConfigurationSpace(nullptr, {}); }), "a model is expected");
  expectThrown(invalid([&] { ConfigurationSpace(good.robot.model, {0, 0}); }), "listed twice");
  expectThrown(invalid([&] { attachObject(good, "psot", "hand"); }), "did you mean 'post'?");
  expectThrown(
      invalid([&] { attachObject(good, "post", "hand", {}, std::vector<double>(8, kNan)); }),
      "not finite");
  FramePose pose;
  pose.frame = "hand";
  pose.position.fill({0, 0});
  pose.rpy.fill({0, 0});
  pose.rotation = garbage().rotation;
  expectThrown(invalid([&] { poseRegion(good, pose); }), "its matrix is no rotation");
  Problem no_robot;
  expectThrown(thrown<robots::InputError>([&] { poseRegion(no_robot, pose); }),
               "robot.model is missing");
  expectThrown(thrown<robots::InputError>([] { problemFromStates(nullptr, "a", "b", "c"); }),
               "a model is missing");
  expectThrown(thrown<robots::InputError>([] { loadMoveit(nullptr, "a", "b"); }),
               "a model is missing");
}

/// Goals and steps, where a function needs the one or the other.
TEST(Mistakes, GoalsAndStepsAreAskedForWhereTheyAreNeeded) {
  Problem nothing = goodProblem(), task = goodProblem(), posed = goodProblem();
  nothing.goals.clear();
  steps(task, {{"go", toTucked(), {}}});
  posed.start_poses = {poseOf(8)};
  const Path path = plan(goodProblem()).path;
  EXPECT_NO_THROW(CompiledScene{nothing});
  expectThrown(refusal([&] { plan(nothing); }), "there is no goal");
  expectThrown(refusal([&] { planTask(nothing); }), "there are no steps");
  expectThrown(refusal([&] { verify(nothing, path); }), "there is no goal");
  expectThrown(refusal([&] { Replanner{nothing}; }), "there is no goal");
  expectThrown(refusal([&] { plan(task); }), "there are steps, which plan() does not follow");
  expectThrown(refusal([&] { Replanner{task}; }), "there are steps");
  for (const auto& call :
       std::vector<std::function<void()>>{[&] { plan(posed); }, [&] { Replanner{posed}; }})
    expectThrown(refusal(call), "the start is given by poses; placeStart() is expected");
  EXPECT_EQ(verify(posed, path).status, VerifyStatus::kRefuted);
}

/// A margin that has no effect has a warning.
TEST(Mistakes, AMarginOfAPairThatIsNotCheckedIsWarnedOf) {
  Problem problem = goodProblem();
  problem.world.objects.push_back(test::box("wall", {0.1, 1, 1}, 5, 0, 0));
  problem.world.objects.push_back({"later", {}, {}});
  problem.world.objects.push_back({"nothing", {}, {}});
  problem.contacts.allowed = {{"hand", "wall"}};
  problem.margins.pairs = {{"post", "wall", 0.1},
                           {"link1", "link2", 0.1},
                           {"hand", "wall", 0.1},
                           {"base", "post", 0.1},
                           {"tool", "post", 0.1},
                           {"hand", "later", 0.1},
                           {"link6", "post", 0.01},
                           {"base", "wall", 0.1, "robot and wall"},
                           {"link3", "wall", 0.1, "robot and wall"},
                           {"base", "wall", 0.1, "b and c"}};
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const std::vector<std::string> expected = {
      "object 'nothing' has no shape: nothing is checked against it",
      "the margin of 'post' and 'wall' has no effect: the pair is not checked (neither moves)",
      "the margin of 'link1' and 'link2' has no effect: the pair is not checked (adjacent)",
      "the margin of 'hand' and 'wall' has no effect: the pair is not checked (allowed by the "
      "problem)",
      "the margin of 'base' and 'post' has no effect: the pair is not checked (neither moves)",
      "the margin of 'tool' and 'post' has no effect: the pair is not checked (without a shape)",
      "the margin of b and c has no effect: none of its pairs is checked"};
  EXPECT_EQ(scene->warnings(), expected);
  EXPECT_EQ(plan(problem).warnings, expected);
}

}  // namespace
}  // namespace leeway::planner
