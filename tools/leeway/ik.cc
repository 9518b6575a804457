#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/inverse_kinematics.h"
#include "planner/problem/read_states.h"
#include "tools/leeway/info/input.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/plan_overrides.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/robot_state.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools {
namespace {

struct IkArguments {
  ProblemSource source;
  std::string file, link, group;
  std::vector<std::string> position, rpy, quaternion;
  std::string state = "start";
  std::string order = "nearest";
  int solutions = 16, starts = 500;
  std::uint64_t seed = 1;
  bool json = false;
};

/// Parses "0.4" or "0.4:0.5", and "any" for angles.
std::pair<double, double> parseRange(const std::string& option, const std::string& text,
                                     bool angle) {
  if (angle && text == "any") return {-std::numbers::pi, std::numbers::pi};
  const std::vector<std::string> parts = splitAt(':', text);
  if (parts.size() > 2)
    badUsage(fmt::format("{}: '{}' is not a number or LEAST:MOST", option, text));
  const double first = parseNumber(option, parts[0]);
  const double second = parts.size() == 2 ? parseNumber(option, parts[1]) : first;
  if (first > second) badUsage(fmt::format("{}: '{}' has its greater end first", option, text));
  return {first, second};
}

robots::PoseRegion parseRegion(const IkArguments& arguments, int link) {
  robots::PoseRegion region;
  region.link = link;
  for (std::size_t k = 0; k < 3; ++k)
    region.position[k] = parseRange("--position", arguments.position[k], false);
  if (!arguments.rpy.empty() && !arguments.quaternion.empty())
    badUsage("--rpy and --quaternion say the same; leave one out");
  if (!arguments.quaternion.empty()) {
    double q[4];
    for (std::size_t k = 0; k < 4; ++k) q[k] = parseNumber("--quaternion", arguments.quaternion[k]);
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(std::fabs(norm - 1) <= 1e-3))
      badUsage(fmt::format("--quaternion: its length is {}; a rotation's is 1", norm));
    const Eigen::Matrix3d R =
        Eigen::Quaterniond(q[3] / norm, q[0] / norm, q[1] / norm, q[2] / norm).toRotationMatrix();
    // The link has the rotation R if a frame that is turned back by R is aligned with the world.
    // Angles are less exact: near a pitch of 90 degrees they are 1e-7 off.
    region.X_LF.rotation = R.transpose();
    region.rpy.fill({0, 0});
    return region;
  }
  for (std::size_t k = 0; k < 3; ++k)
    region.rpy[k] = parseRange("--rpy", arguments.rpy.empty() ? "any" : arguments.rpy[k], true);
  return region;
}

/// The planned variables that move the link.
std::vector<int> variablesOf(const robots::Model& model, const std::vector<int>& planned,
                             int link) {
  std::vector<char> moves(model.variables.size(), 0);
  for (int l = link; l >= 0; l = model.joints[static_cast<std::size_t>(l)].parent_link) {
    const robots::Joint* joint = &model.joints[static_cast<std::size_t>(l)];
    if (joint->mimic >= 0) joint = &model.joints[static_cast<std::size_t>(joint->mimic)];
    for (int v = joint->first_variable; v < joint->first_variable + joint->variable_count; ++v)
      moves[static_cast<std::size_t>(v)] = 1;
  }
  std::vector<int> variables;
  for (const int v : planned)
    if (moves[static_cast<std::size_t>(v)]) variables.push_back(v);
  return variables;
}

struct CheckedSolution {
  robots::IkSolution solution;
  planner::StateCheck check;
  PairNames names;
  bool is_checked = true;   ///< false: CompiledScene::nothingChecked(), or meshes are missing
  PairNames too_near = {};  ///< a pair that does not keep its margin

  bool free() const { return is_checked && check.verdict == planner::Verdict::kFree; }
};

/// Measures solutions in the problem's scene and puts free ones first. Without meshes, keeps the
/// order.
std::vector<CheckedSolution> checkAll(const planner::Problem& problem, const std::vector<double>& q,
                                      const std::vector<int>& variables,
                                      const robots::IkResult& result, bool by_clearance) {
  std::vector<CheckedSolution> list;
  if (problem.robot.model->lacks_meshes) {
    for (const robots::IkSolution& solution : result.solutions)
      list.push_back({solution, {}, {}, false});
    return list;
  }
  if (result.solutions.empty()) return list;
  planner::EdgeCertifier certifier(std::make_shared<const planner::CompiledScene>(problem));
  const bool is_checked = certifier.scene().nothingChecked().empty();
  for (const robots::IkSolution& solution : result.solutions) {
    std::vector<double> all = q, point;
    for (std::size_t c = 0; c < variables.size(); ++c)
      all[static_cast<std::size_t>(variables[c])] = solution.values[c];
    for (const int v : problem.robot.variables) point.push_back(all[static_cast<std::size_t>(v)]);
    CheckedSolution checked{solution, certifier.clearance(point, 1e-6), {}, is_checked};
    checked.names = pairNames(certifier.scene(), checked.check.pair);
    if (checked.check.verdict == planner::Verdict::kNotFree)
      checked.too_near = pairNames(certifier.scene(), certifier.tooNear(point, 1e-6).pair);
    list.push_back(checked);
  }
  std::stable_sort(list.begin(), list.end(),
                   [&](const CheckedSolution& a, const CheckedSolution& b) {
                     if (a.free() != b.free()) return a.free();
                     return by_clearance && a.check.clearance.lower > b.check.clearance.lower;
                   });
  return list;
}

const char* statusOf(const robots::IkResult& result, const std::vector<CheckedSolution>& list) {
  if (result.status == robots::IkStatus::kUnreachable) return "unreachable";
  if (list.empty()) return "none";
  if (!list.front().is_checked) return "nothing_checked";
  return list.front().free() ? "found" : "colliding";
}

Json solutionJson(const CheckedSolution& checked) {
  Json closest;
  if (checked.check.pair >= 0) closest = {{"a", checked.names.a}, {"b", checked.names.b}};
  return {{"positions", checked.solution.values},
          {"free", checked.free()},
          {"clearance_lower", jsonNumber(checked.check.clearance.lower)},
          {"clearance_upper", jsonNumber(checked.check.clearance.upper)},
          {"closest", closest},
          {"position_error", checked.solution.error.position},
          {"angle_error", checked.solution.error.angle}};
}

std::string table(const robots::Model& model, const std::vector<int>& variables,
                  const std::vector<CheckedSolution>& list) {
  std::vector<std::string> heading = {"#"};
  for (const int v : variables)
    heading.push_back(model.variables[static_cast<std::size_t>(v)].name);
  heading.insert(heading.end(), {"clearance [mm]", "state", "closest"});
  std::vector<std::vector<std::string>> rows;
  for (const CheckedSolution& checked : list) {
    std::vector<std::string> row = {fmt::format("{}", rows.size() + 1)};
    for (const double value : checked.solution.values) row.push_back(formatNear(value, 4));
    row.push_back(formatLower(checked.check.clearance.lower * 1e3, 2));
    row.push_back(!checked.is_checked                                     ? "not checked"
                  : checked.free()                                        ? "free"
                  : checked.check.verdict == planner::Verdict::kUndecided ? "undecided"
                  : checked.check.clearance.upper <= 0                    ? "collision"
                  : checked.too_near.a == checked.names.a && checked.too_near.b == checked.names.b
                      ? "too near"
                      : fmt::format("too near: {}, {}", checked.too_near.a, checked.too_near.b));
    row.push_back(checked.check.pair < 0 ? "-" : checked.names.a + ", " + checked.names.b);
    rows.push_back(row);
  }
  const std::size_t words = heading.size() - 2;
  return formatTable(heading, rows, {words, words + 1});
}

/// The variables of --group, or else of the problem, that move the link; at least one.
std::vector<int> solvedVariables(const IkArguments& arguments, const planner::Problem& problem,
                                 int link) {
  const robots::Model& model = *problem.robot.model;
  std::vector<int> planned = problem.robot.variables;
  if (!arguments.group.empty()) {
    planner::Problem other = problem;
    planner::takeGroups("command line", 0, planner::namedGroups(model, arguments.group), other);
    planned = other.robot.variables;
  }
  std::vector<int> variables = variablesOf(model, planned, link);
  if (variables.empty())
    badUsage(fmt::format("--link {}: no planned joint moves it", arguments.link));
  return variables;
}

Json answerJson(const IkArguments& arguments, const robots::Model& model,
                const std::vector<int>& variables, const robots::IkResult& result,
                const std::vector<CheckedSolution>& list) {
  Json names = Json::array(), solutions = Json::array(), near;
  for (const int v : variables) names.push_back(model.variables[static_cast<std::size_t>(v)].name);
  for (const CheckedSolution& checked : list) solutions.push_back(solutionJson(checked));
  if (const auto& nearest = result.nearest; list.empty() && !nearest.values.empty())
    near = {{"positions", nearest.values},
            {"position_error", nearest.error.position},
            {"angle_error", nearest.error.angle}};
  return {{"status", statusOf(result, list)},
          {"proven", result.status == robots::IkStatus::kUnreachable},
          {"seed", arguments.seed},
          {"link", arguments.link},
          {"joint_names", names},
          {"solutions", solutions},
          {"nearest", near},
          {"counts",
           {{"starts", result.starts},
            {"iterations", result.iterations},
            {"proof_boxes", result.proof_boxes}}}};
}

void printNone(const std::string& link, const robots::IkResult& result) {
  std::string text =
      result.status == robots::IkStatus::kUnreachable
          ? fmt::format(
                "{}: {}: proven, with {} of configurations\n", link,
                verdictText("unreachable", false),
                result.proof_boxes == 1 ? "1 box" : fmt::format("{} boxes", result.proof_boxes))
          : fmt::format("{}: {} from {}; there may be one\n", link,
                        verdictText("no solution found", false),
                        counted(static_cast<std::size_t>(result.starts), "start"));
  const robots::IkSolution& nearest = result.nearest;
  if (!nearest.values.empty())
    text += fmt::format("nearest found: {:.2f} mm and {:.4f} rad away, at {:.4f}\n",
                        nearest.error.position * 1e3, nearest.error.angle,
                        fmt::join(nearest.values, ", "));
  fmt::print("{}", wrapped(text));
}

void printSolutions(const IkArguments& arguments, const robots::Model& model,
                    const std::vector<int>& variables, const std::vector<CheckedSolution>& list) {
  const auto free =
      std::count_if(list.begin(), list.end(), [](const CheckedSolution& c) { return c.free(); });
  const std::string found = fmt::format(
      "{}, {}", counted(list.size(), "solution"),
      list.front().is_checked ? fmt::format("{} free", free) : "not checked for collisions");
  fmt::print("{}{}",
             wrapped(fmt::format(
                 "{}: {}; {} first\n", arguments.link, verdictText(found, free > 0),
                 arguments.order == "clearance" ? "most clearance" : "nearest to the state")),
             table(model, variables, list));
}

/// Loads a robot. If its meshes cannot be read, loads it without them and warns, because kinematics
/// do not need meshes. Fails instead if clearance is wanted.
planner::Problem loadForIk(const IkArguments& arguments) {
  const info::FileKind kind = info::kindOf(arguments.file);
  try {
    return info::loadFile(arguments.file, kind, arguments.source);
  } catch (const robots::InputError& error) {
    if (arguments.order == "clearance") throw;
    ProblemSource source = arguments.source;
    source.kinematics_only = true;
    try {
      planner::Problem problem = info::loadFile(arguments.file, kind, source);
      printWarnings({fmt::format("{}; solutions are not checked for collisions", error.what())});
      return problem;
    } catch (const robots::InputError&) {  // the meshes are not the cause
    }
    throw;
  }
}

int runIk(const IkArguments& arguments) {
  if (arguments.solutions < 1)
    badUsage(fmt::format("--solutions {} is below 1", arguments.solutions));
  if (arguments.starts < 1) badUsage(fmt::format("--starts {} is below 1", arguments.starts));
  planner::Problem problem = loadForIk(arguments);
  const robots::Model& model = *problem.robot.model;
  const int link = parseLink(model, arguments.link);
  const std::vector<int> variables = solvedVariables(arguments, problem, link);
  const std::vector<double> q = parseConfiguration(problem, arguments.state);
  // Only the solved variables count for clearance. The other variables stay.
  problem.start = q;
  problem.robot.variables = variables;
  problem.goals.clear();
  problem.steps.clear();
  for (auto* limits :
       {&problem.execution.velocities, &problem.execution.accelerations, &problem.execution.jerks})
    limits->clear();  // maybe of joints that are not solved
  if (!problem.constraints.empty()) {
    printWarnings({"constraints of the problem are not looked at: solutions may break them"});
    problem.constraints.clear();
  }

  const robots::InverseKinematics solver(problem.robot.model, variables);
  robots::IkOptions options;
  options.seed = arguments.seed;
  options.starts = arguments.starts;
  options.max_solutions = arguments.solutions;
  options.stop = [] { return interrupted(); };
  const std::vector<robots::PoseRegion> regions = {parseRegion(arguments, link)};
  const robots::IkResult result = solver.solve(regions, q, options);
  const std::vector<CheckedSolution> list =
      checkAll(problem, q, variables, result, arguments.order == "clearance");
  if (arguments.json)
    printJson(answerJson(arguments, model, variables, result, list));
  else if (list.empty())
    printNone(arguments.link, result);
  else
    printSolutions(arguments, model, variables, list);
  return !list.empty() && list.front().free() ? kYes : kNo;
}

}  // namespace

Verb addIk(CLI::App& command) {
  auto arguments = std::make_shared<IkArguments>();
  arguments->source.needs_goal = false;  // a guard's file has none
  CLI::App* app = command.add_subcommand(
      "ik", "joint values that bring a link to a pose, with their clearance, or a proof of none");
  app->add_option("file", arguments->file, "URDF (or MJCF, SDF), SRDF or problem file")
      ->type_name("FILE")
      ->required();
  addRobotArguments(*app, arguments->source);
  app->add_option("--link", arguments->link, "the link whose frame is placed")
      ->type_name("NAME")
      ->required();
  app->add_option("--position", arguments->position,
                  "x y z in the world [m], each a number or a range LEAST:MOST")
      ->type_name("X Y Z")
      ->expected(3)
      ->required();
  app->add_option("--rpy", arguments->rpy,
                  "roll, pitch, yaw [rad], each a number, a range LEAST:MOST, or any; default: any "
                  "rotation")
      ->type_name("R P Y")
      ->expected(3);
  app->add_option("--quaternion", arguments->quaternion, "the rotation as x y z w")
      ->type_name("X Y Z W")
      ->expected(4);
  app->add_option("--group", arguments->group,
                  "joints that may move; default: the problem's, of a robot alone all")
      ->type_name("NAME");
  app->add_option("--state", arguments->state,
                  "where the search begins and all other joints are: start, a group state, all "
                  "planned values (1,0,2) or some joints' (elbow=1,wrist=2)")
      ->type_name("STATE")
      ->capture_default_str();
  app->add_option("--order", arguments->order,
                  "nearest: nearest to the state first; clearance: greatest clearance first. Free "
                  "solutions come first. clearance needs the robot's meshes; without them, nearest "
                  "does not check collisions")
      ->type_name("nearest|clearance")
      ->check(CLI::IsMember({"nearest", "clearance"}))
      ->capture_default_str();
  app->add_option("--solutions", arguments->solutions, "stop after N solutions")
      ->type_name("N")
      ->capture_default_str();
  app->add_option("--starts", arguments->starts, "stop after N starts")
      ->type_name("N")
      ->capture_default_str();
  addSeed(*app, "seed of the starts", arguments->seed);
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer(
      "Examples:\n"
      "  leeway ik robots/arm6/arm6.urdf --link tool --position 0.4 0.2 0.5 --rpy 0 0 1\n"
      "  leeway ik problems/shelf/reach.yaml --link hand --position 0.55 0.25 0.45:0.5 --rpy any "
      "any any --json");
  return {app, [arguments] { return runIk(*arguments); }};
}

}  // namespace leeway::tools
