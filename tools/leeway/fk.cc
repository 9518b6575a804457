#include <fmt/format.h>

#include <Eigen/Geometry>
#include <memory>
#include <nlohmann/json.hpp>

#include "leeway/robots/inverse_kinematics.h"
#include "leeway/robots/kinematics.h"
#include "tools/leeway/info/input.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/robot_state.h"
#include "tools/leeway/support/terminal.h"
#include "tools/leeway/support/verb.h"
#include "tools/view/base/figures.h"

namespace leeway::tools {
namespace {

struct FkArguments {
  ProblemSource source;
  std::string file;
  std::vector<std::string> links;
  std::string state = "start";
  bool json = false;
};

int runFk(const FkArguments& arguments) {
  ProblemSource source = arguments.source;
  source.kinematics_only = true;
  const planner::Problem problem =
      info::loadFile(arguments.file, info::kindOf(arguments.file), source);
  const robots::Model& model = *problem.robot.model;
  std::vector<int> links;
  for (const std::string& name : arguments.links) links.push_back(parseLink(model, name));
  for (int l = 0; arguments.links.empty() && l < static_cast<int>(model.links.size()); ++l)
    links.push_back(l);
  const std::vector<double> q = parseConfiguration(problem, arguments.state);
  std::vector<robots::Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, q, X_WL);

  Json list = Json::array();
  std::vector<std::vector<std::string>> rows;
  for (const int l : links) {
    const auto i = static_cast<std::size_t>(l);
    const Eigen::Vector3d& p = X_WL[i].translation;
    const Eigen::Vector3d rpy = robots::rollPitchYaw(X_WL[i].rotation);
    const Eigen::Quaterniond turn(X_WL[i].rotation);
    list.push_back({{"link", model.links[i].name},
                    {"position", jsonVector(p)},
                    {"rpy", jsonVector(rpy)},
                    {"quaternion", {turn.x(), turn.y(), turn.z(), turn.w()}}});
    std::vector<std::string> row = {model.links[i].name};
    for (const Eigen::Vector3d& three : {p, rpy})
      for (int k = 0; k < 3; ++k) row.push_back(formatNear(three(k), 6));
    rows.push_back(row);
  }
  if (arguments.json) {
    printJson({{"state", arguments.state}, {"configuration", q}, {"links", list}});
  } else {
    fmt::print("{}", formatTable({"link", "x [m]", "y", "z", "roll [rad]", "pitch", "yaw"}, rows));
  }
  return kYes;
}

}  // namespace

Verb addFk(CLI::App& command) {
  auto arguments = std::make_shared<FkArguments>();
  arguments->source.needs_goal = false;  // a guard's file has none
  CLI::App* app = command.add_subcommand("fk", "where the links are at given joint values");
  app->add_option("file", arguments->file, "URDF (or MJCF, SDF), SRDF or problem file")
      ->type_name("FILE")
      ->required();
  addRobotArguments(*app, arguments->source);
  app->add_option("--link", arguments->links, "a link; may be repeated; default: all")
      ->type_name("NAME");
  app->add_option("--state", arguments->state,
                  "start, a group state, all planned values (1,0,2) or some joints' "
                  "(elbow=1,wrist=2), the others as at the start")
      ->type_name("STATE")
      ->capture_default_str();
  app->add_flag("--json", arguments->json, "print one JSON document");
  app->footer(
      "Examples:\n"
      "  leeway fk problems/shelf/reach.yaml --link hand\n"
      "  leeway fk robots/arm6/arm6.urdf --link tool --state elbow_joint=1,wrist1_joint=-0.5 "
      "--json");
  return {app, [arguments] { return runFk(*arguments); }};
}

}  // namespace leeway::tools
