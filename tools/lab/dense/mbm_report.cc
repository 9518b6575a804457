// mbm_report: reads the lines of `leeway batch` on MoveIt problems, checks every path densely with
// FCL, and prints a table by set.
//   mbm_report --robot R.urdf [--srdf R.srdf] [--step 0.002] [--scenes FOLDER] LINES.jsonl
// A line's `problem` is the scene's path, or with --scenes, FOLDER/SET/sceneNNNN.yaml has the scene
// of problem SET/sceneNNNN.yaml: tools/scripts/sense makes such problems. The request is
// requestNNNN.yaml in the scene's folder. Exit status 1 when any problem is unsolved, uncertified,
// unverified or collides.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/problem_files.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/dense/dense_world.h"

namespace {

using leeway::bench::requestOf;
using leeway::dense::Collision;
using leeway::dense::DenseWorld;
using leeway::tools::report::quantile;
using Json = nlohmann::json;

/// Ends of a path within this of the request count as equal [rad].
constexpr double kSameConfiguration = 1e-9;

struct Row {
  int problems = 0, solved = 0, invalid = 0, errors = 0, certified = 0, verified = 0, colliding = 0,
      wrong_ends = 0;
  long long states = 0;
  std::vector<double> plan_ms, total_ms;

  void add(const Row& r) {
    problems += r.problems, solved += r.solved, invalid += r.invalid, errors += r.errors,
        certified += r.certified;
    verified += r.verified, colliding += r.colliding, wrong_ends += r.wrong_ends,
        states += r.states;
    plan_ms.insert(plan_ms.end(), r.plan_ms.begin(), r.plan_ms.end());
    total_ms.insert(total_ms.end(), r.total_ms.begin(), r.total_ms.end());
  }

  bool good() const {
    return errors == 0 && invalid == 0 && solved == problems && certified == solved &&
           verified == solved && colliding == 0 && wrong_ends == 0;
  }
};

/// Checks the path's states, spaced at most `step` [rad] apart; prints the first that collides.
bool collides(DenseWorld& world, const std::string& problem, const std::vector<std::string>& names,
              const std::vector<std::vector<double>>& rows, double step, long long& states) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double>& from = rows[i == 0 ? 0 : i - 1];
    const std::vector<double>& to = rows[i];
    double squared = 0;
    for (std::size_t k = 0; k < to.size(); ++k) squared += (to[k] - from[k]) * (to[k] - from[k]);
    const int count = std::max(1, static_cast<int>(std::ceil(std::sqrt(squared) / step)));
    for (int n = 1; n <= count; ++n) {
      const double t = static_cast<double>(n) / count;
      std::vector<double> q(to.size());
      for (std::size_t k = 0; k < q.size(); ++k) q[k] = (1 - t) * from[k] + t * to[k];
      ++states;
      const Collision collision = world.check(names, q);
      if (!collision.found) continue;
      fmt::print("{}: '{}' and '{}' collide on edge {} at t = {:.6f}: {:.17g}\n", problem,
                 collision.a, collision.b, i == 0 ? 0 : i - 1, t, fmt::join(q, " "));
      return true;
    }
  }
  return false;
}

/// The MoveIt scene of a problem; `scenes`: see above.
std::string sceneOf(const std::filesystem::path& problem, const std::string& scenes) {
  if (scenes.empty()) return problem.string();
  return (std::filesystem::path(scenes) / problem.parent_path().filename() / problem.filename())
      .string();
}

/// Whether start or goal collides; rejecting the problem is then correct.
bool endsCollide(DenseWorld& world) {
  for (const auto* end : {&world.start(), &world.goal()}) {
    std::vector<std::string> names;
    std::vector<double> q;
    for (const auto& [name, value] : *end) names.push_back(name), q.push_back(value);
    if (world.check(names, q).found) return true;
  }
  return false;
}

void judge(const Json& line, const std::shared_ptr<const leeway::robots::Model>& model, double step,
           const std::string& scenes, Row& row) {
  const std::string problem = line.at("problem");
  const std::string status = line.at("status");
  ++row.problems;
  const std::string scene = sceneOf(problem, scenes);
  DenseWorld world(model, scene, requestOf(scene));
  if (status == "invalid_start" || status == "invalid_goal") {
    ++row.invalid;
    fmt::print("{}: {}; FCL finds start or goal {}\n", problem, status,
               endsCollide(world) ? "in collision" : "free");
    return;
  }
  if (status != "solved") {
    if (status != "unsolved") ++row.errors;
    fmt::print("{}: {} {}\n", problem, status, line.value("error", ""));
    return;
  }
  ++row.solved;
  const Json& time = line.at("time_s");
  const double plan_s = time.at("plan");
  double total_s = 0;
  for (const char* part : {"compile", "plan", "simplify", "improve", "push", "certify"})
    total_s += time.at(part).get<double>();
  row.plan_ms.push_back(1e3 * plan_s);
  row.total_ms.push_back(1e3 * total_s);
  if (line.at("certificate").value("certified", false)) ++row.certified;
  if (line.contains("verify") && line["verify"].is_object()) {
    if (line["verify"].value("status", "") == "certified") {
      ++row.verified;
    } else {
      fmt::print("{}: verify says {}\n", problem, line["verify"].dump());
    }
  }
  const auto names = line.at("path").at("joint_names").get<std::vector<std::string>>();
  const auto rows = line.at("path").at("positions").get<std::vector<std::vector<double>>>();
  if (rows.size() < 2 || world.startError(names, rows.front()) > kSameConfiguration ||
      world.goalError(names, rows.back()) > kSameConfiguration) {
    ++row.wrong_ends;
    fmt::print("{}: the path's ends are not the request's\n", problem);
  }
  if (collides(world, problem, names, rows, step, row.states)) ++row.colliding;
}

void print(const std::string& name, const Row& r) {
  fmt::print(
      "{:<28} {:>4} {:>6} {:>7} {:>6} {:>9} {:>8} {:>9} {:>9} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} "
      "{:>10}\n",
      name, r.problems, r.solved, r.invalid, r.errors, r.certified, r.verified, r.colliding,
      r.wrong_ends, quantile(r.plan_ms, 0.5), quantile(r.plan_ms, 0.95), quantile(r.total_ms, 0.5),
      quantile(r.total_ms, 0.95), r.states);
}

int run(const std::string& robot, const std::string& srdf, double step, const std::string& scenes,
        const std::string& file) {
  const auto model = leeway::robots::loadModel(robot, srdf);
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file + ": cannot be opened");
  std::map<std::string, Row> sets;
  std::string text;
  while (std::getline(stream, text)) {
    if (text.empty()) continue;
    const Json line = Json::parse(text);
    const std::filesystem::path problem = line.at("problem").get<std::string>();
    judge(line, model, step, scenes, sets[problem.parent_path().filename().string()]);
  }
  fmt::print("\n{:<28} {:>4} {:>6} {:>7} {:>6} {:>9} {:>8} {:>9} {:>9} {:>17} {:>17} {:>10}\n",
             "set", "of", "solved", "invalid", "error", "certified", "verified", "colliding",
             "ends off", "plan ms 50%   95%", "total ms 50%  95%", "states");
  Row all;
  for (const auto& [name, row] : sets) {
    print(name, row);
    all.add(row);
  }
  print("all", all);
  return all.good() && all.problems > 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Checks the paths of `leeway batch` densely with FCL and prints a table by set.");
  std::string robot, srdf, scenes, lines;
  double step = 0.002;
  app.add_option("--robot", robot, "URDF")->required();
  app.add_option("--srdf", srdf, "SRDF");
  app.add_option("--step", step, "distance between states that are looked at [rad]")
      ->check(CLI::PositiveNumber);
  app.add_option("--scenes", scenes, "folder with the scenes, by set")
      ->check(CLI::ExistingDirectory);
  app.add_option("lines", lines, "output of leeway batch --verify")->required();
  return leeway::bench::runProgram("mbm_report", app, argc, argv,
                                   [&] { return run(robot, srdf, step, scenes, lines); });
}
