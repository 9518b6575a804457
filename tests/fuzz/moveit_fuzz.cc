// Any bytes as a MoveIt scene and request (separated by a line of ====): a problem or an
// InputError.

#include <string_view>

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tests/fuzz/both_ways.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tests/fuzz/text_input.h"

namespace {

const char* const kSrdf =
    R"(<robot name="r"><group name="arm"><joint name="a"/><joint name="b"/></group></robot>)";
const char* const kInput = R"(name: s
robot_model_name: r
robot_state:
  joint_state: {name: [a, b], position: [0, 0]}
fixed_frame_transforms:
  - child_frame_id: world
    transform: {translation: [0, 0, 0], rotation: [0, 0, 0, 1]}
allowed_collision_matrix:
  entry_names: [base, one]
  entry_values:
    - [false, true]
    - [true, false]
world:
  collision_objects:
    - id: Can1
      pose: {position: [0, 0, 0], orientation: [0, 0, 0, 1]}
      primitives:
        - {type: cylinder, dimensions: [0.12, 0.03]}
      primitive_poses:
        - {position: [0.5, 0.1, 0.3], orientation: [0, 0, 0, 1]}
    - id: box
      primitives: [{type: box, dimensions: [1, 2, 0.5]}]
      primitive_poses: [{position: [2, 0, 0], orientation: [0, 0, 0.7071067811865476, 0.7071067811865476]}]
====
group_name: arm
planner_id: ""
num_planning_attempts: 1
allowed_planning_time: 60
max_velocity_scaling_factor: 0
start_state:
  joint_state:
    name: [a, b]
    position: [0.1, -0.2]
goal_constraints:
  - joint_constraints:
      - {joint_name: b, position: 0.5}
      - {joint_name: a, position: -0.5}
)";

}  // namespace

namespace leeway::fuzz {

std::vector<std::string> seedInputs() { return {kInput}; }

std::vector<std::string> dictionary() {
  return {"====\n",
          "*a",
          "&a ",
          "- ",
          "[]",
          "{}",
          "~",
          ".nan",
          ".inf",
          "type: sphere",
          "type: mesh",
          "dimensions: []",
          "dimensions: [1, -1]",
          "orientation: [0, 0, 0, 0]",
          "header: {frame_id: x}",
          "octomap: {}",
          "octomap: {octomap: {id: OcTree, binary: true, resolution: 0.1, data: [3, 0, -86, 0]}}",
          "meshes: [{}]",
          "planes: []",
          "attached_collision_objects: []",
          "joint_name: z",
          "position: []",
          "tolerance_above: 0.1",
          "group_name: x"};
}

}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  const auto bytes = [](std::string_view text) {
    return std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  };
  static const auto model = robots::loadModel(fuzz::writeInput("robot.urdf", bytes(fuzz::kArmUrdf)),
                                              fuzz::writeInput("robot.srdf", bytes(kSrdf)));
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t cut = std::min(input.size(), input.find("====\n"));
  const std::size_t next = std::min(input.size(), cut + 5);
  const std::string scene = fuzz::writeInput("scene0001.yaml", bytes(input.substr(0, cut)));
  const std::string request = fuzz::writeInput("request0001.yaml", bytes(input.substr(next)));
  try {
    const planner::Problem problem = fuzz::loadBothWays([&](robots::InputErrors* errors) {
      planner::ProblemOptions options;
      options.load.errors = errors;
      return planner::loadMoveit(model, scene, request, options);
    });
    if (problem.start.size() != problem.robot.model->variables.size())
      fuzz::fail("a start of the wrong size");
    if (problem.goals.empty()) fuzz::fail("a problem without a goal");
  } catch (const robots::InputError& error) {
    if (error.what()[0] == '\0') fuzz::fail("an error without a message");
  }
  return 0;
}
