// scan_check: paths among point clouds against dense sampling.
//   scan_check [--step 0.002] LINES.jsonl
// Reads the lines of `leeway batch` on problems whose clouds stand still (tools/scripts/scans makes
// such ones), and looks at each path every `step` [rad]: FCL's distance of every link from the
// points must be above the radius of their balls. The points are those that filters left; links are
// placed without Leeway's kinematics. Exit status 1 if a line is not solved, certified and free.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/dense/dense_world.h"

namespace {

using leeway::dense::DenseWorld;
using Json = nlohmann::json;

struct Sums {
  int problems = 0, free = 0, contacts = 0;
  long long states = 0;
};

/// The points of all clouds, and their largest radius [m].
std::vector<Eigen::Vector3d> pointsOf(const leeway::planner::Problem& problem, double& radius) {
  std::vector<Eigen::Vector3d> points_W;
  for (const leeway::planner::Object& object : problem.world.objects) {
    if (!object.geometries.empty() || !object.cloud)
      throw std::runtime_error(object.name + " has shapes; only clouds are looked at");
    for (const auto& ball : object.cloud->balls) {
      points_W.push_back(object.X_WO.rotation * ball.center + object.X_WO.translation);
      radius = std::max(radius, ball.radius);
    }
  }
  return points_W;
}

void judge(const Json& line, double step, Sums& sums) {
  const std::string file = line.at("problem");
  ++sums.problems;
  if (line.at("status") != "solved" || !line.at("certificate").value("certified", false)) {
    fmt::print("{}: {}, not certified\n", file, line.at("status").get<std::string>());
    return;
  }
  const leeway::planner::Problem problem = leeway::planner::loadProblem(file);
  const leeway::robots::Model& model = *problem.robot.model;
  std::vector<std::pair<std::string, double>> start;
  for (std::size_t v = 0; v < model.variables.size(); ++v)
    start.emplace_back(model.variables[v].name, problem.start[v]);
  DenseWorld robot(problem.robot.model, start);
  double radius = 0;
  const auto points = DenseWorld::pointsOf(pointsOf(problem, radius));
  const auto names = line.at("path").at("joint_names").get<std::vector<std::string>>();
  const auto rows = line.at("path").at("positions").get<std::vector<std::vector<double>>>();
  double least = std::numeric_limits<double>::infinity();
  std::string link;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    double squared = 0;
    for (std::size_t k = 0; k < names.size(); ++k)
      squared += (rows[i + 1][k] - rows[i][k]) * (rows[i + 1][k] - rows[i][k]);
    const int count = std::max(1, static_cast<int>(std::ceil(std::sqrt(squared) / step)));
    for (int n = i == 0 ? 0 : 1; n <= count; ++n) {
      const double t = static_cast<double>(n) / count;
      std::vector<double> q(names.size());
      for (std::size_t k = 0; k < q.size(); ++k) q[k] = (1 - t) * rows[i][k] + t * rows[i + 1][k];
      ++sums.states;
      const auto [distance, of] = robot.leastDistance(*points, names, q);
      if (!(distance >= least)) least = distance, link = of;
    }
  }
  const bool is_free = least > radius;
  (is_free ? sums.free : sums.contacts) += 1;
  fmt::print("{}: {}, {} comes to {:.3f} mm of a ball\n", file, is_free ? "free" : "CONTACT", link,
             1e3 * (least - radius));
}

int run(const std::string& file, double step) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file + ": cannot be opened");
  Sums sums;
  for (std::string text; std::getline(stream, text);)
    if (!text.empty()) judge(Json::parse(text), step, sums);
  fmt::print("{} problems, {} free, {} with contacts, {} states\n", sums.problems, sums.free,
             sums.contacts, sums.states);
  return sums.problems > 0 && sums.free == sums.problems ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Checks the paths of `leeway batch` among point clouds densely with FCL.");
  std::string lines;
  double step = 0.002;
  app.add_option("--step", step, "distance between states that are looked at [rad]")
      ->check(CLI::PositiveNumber);
  app.add_option("lines", lines, "output of leeway batch")->required();
  return leeway::bench::runProgram("scan_check", app, argc, argv, [&] { return run(lines, step); });
}
