#include "tools/lab/ik/ik_report.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "collision/base/numbers.h"
#include "leeway/robots/inverse_kinematics.h"
#include "leeway/robots/kinematics.h"
#include "robots/inverse/chain.h"
#include "robots/inverse/reach_proof.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/splitmix.h"

namespace leeway::tools::report {
namespace {

using robots::Pose;
using robots::PoseRegion;

/// Limit on the solutions of a search for all branches, and the starts of that search.
constexpr int kMostBranches = 64, kBranchStarts = 100;

/// Limit on the boxes of proofs that are tried for reachable poses.
constexpr int kProofBoxes = 100;

class Cases {
 public:
  Cases(const IkRobot& robot, std::uint64_t seed)
      : model_(*robot.model), link_(robot.link), random_(seed), X_WL_(model_.links.size()) {
    std::vector<char> moves(model_.variables.size(), 0);
    for (int l = link_; l >= 0; l = model_.joints[at(l)].parent_link) {
      const robots::Joint& joint = model_.joints[at(l)];
      const int first = model_.steps[at(l)].variable;
      const int count = joint.mimic >= 0 ? 1 : joint.variable_count;
      for (int k = 0; k < count; ++k) moves[at(first + k)] = 1;
    }
    for (int v = 0; v < static_cast<int>(moves.size()); ++v)
      if (moves[at(v)]) variables_.push_back(v);
  }

  const std::vector<int>& variables() const { return variables_; }

  std::vector<double> configuration() {
    std::vector<double> q = model_.defaultConfiguration();
    for (const int v : variables_) {
      const auto [low, high] = range(v);
      q[at(v)] = random_.uniform(low, high);
    }
    return q;
  }
  Pose pose(const std::vector<double>& q) {
    robots::forwardKinematics(model_, q, X_WL_);
    return X_WL_[at(link_)];
  }
  std::pair<double, double> range(int v) const {
    const robots::Variable& variable = model_.variables[at(v)];
    const double pi = std::numbers::pi;
    return {std::isfinite(variable.lower) ? variable.lower : -pi,
            std::isfinite(variable.upper) ? variable.upper : pi};
  }

  /// A pose beyond the farthest place of 2000 random configurations, as seen from the first joint,
  /// by 2 % to half, with a random rotation.
  Pose beyond() {
    if (!(reach_ > 0)) {
      int first = link_;
      for (int l = link_; l >= 0; l = model_.joints[at(l)].parent_link)
        if (model_.joints[at(l)].type != robots::JointType::kFixed) first = l;
      pose(model_.defaultConfiguration());
      base_ = X_WL_[at(first)].translation;
      for (int i = 0; i < 2000; ++i)
        reach_ = std::max(reach_, (pose(configuration()).translation - base_).norm());
    }
    Eigen::Vector3d direction = pose(configuration()).translation - base_;
    direction.normalize();
    Eigen::Vector3d rpy;
    for (int k = 0; k < 3; ++k) rpy(k) = random_.uniform(-3, 3);
    return {robots::rotationOf(rpy), base_ + reach_ * random_.uniform(1.02, 1.5) * direction};
  }

 private:
  const robots::Model& model_;
  int link_;
  bench::SplitMix random_;
  std::vector<Pose> X_WL_;
  std::vector<int> variables_;
  Eigen::Vector3d base_ = Eigen::Vector3d::Zero();
  double reach_ = 0;
};

/// The chain for other solvers; empty if they do not support one of its joints.
std::optional<IkChain> serialChain(const IkRobot& robot, Cases& cases) {
  const robots::Model& model = *robot.model;
  std::vector<int> path;
  for (int l = robot.link; l >= 0; l = model.joints[at(l)].parent_link) path.push_back(l);
  std::reverse(path.begin(), path.end());
  IkChain chain;
  Pose before;
  for (const int l : path) {
    const robots::Joint& joint = model.joints[at(l)];
    before = before * joint.X_PJ;
    if (joint.type == robots::JointType::kFixed) continue;
    if (joint.mimic >= 0 || joint.variable_count != 1) return std::nullopt;
    const auto [lower, upper] = cases.range(joint.first_variable);
    chain.joints.push_back(
        {before, joint.axis, joint.type == robots::JointType::kPrismatic, lower, upper});
    before = Pose{};
  }
  chain.X_JF = before;
  return chain;
}

/// An engine's answer for one pose.
struct Answer {
  bool found = false;
  std::vector<double> values;
  double seconds = 0;
};

class Tally {
 public:
  Tally(const IkRobot& robot, const char* engine) { row_.robot = robot.name, row_.engine = engine; }

  void add(const IkRobot& robot, Cases& cases, std::vector<double> q, const PoseRegion& region,
           const Answer& answer) {
    ++row_.poses;
    microseconds_.push_back(answer.seconds * 1e6);
    if (!answer.found) return;
    bool right = true;
    for (std::size_t c = 0; c < answer.values.size(); ++c) {
      const int v = cases.variables()[c];
      const robots::Variable& variable = robot.model->variables[at(v)];
      right = right && answer.values[c] >= variable.lower && answer.values[c] <= variable.upper;
      q[at(v)] = answer.values[c];
    }
    const robots::PoseError error = robots::poseError(region, cases.pose(q));
    const double worst = std::max(error.position, error.angle);
    ++(right && worst <= 1e-9 ? row_.solved : right && worst <= 1e-5 ? row_.coarse : row_.wrong);
    if (right && worst <= 1e-5) row_.worst_error = std::max(row_.worst_error, worst);
  }
  void addAll(double seconds, std::size_t branches) {
    all_.push_back(seconds * 1e6);
    branches_ += static_cast<double>(branches);
  }
  IkRow row() {
    row_.median_us = median(microseconds_);
    row_.most_us = quantile(microseconds_, 0.95);
    row_.all_us = median(all_);
    row_.branches = all_.empty() ? std::nan("") : branches_ / static_cast<double>(all_.size());
    return row_;
  }

 private:
  IkRow row_;
  std::vector<double> microseconds_, all_;
  double branches_ = 0;
};

}  // namespace

std::vector<IkRow> measureIk(const std::vector<IkRobot>& robots,
                             const std::vector<const IkEngine*>& rivals,
                             const IkReportOptions& options) {
  std::vector<IkRow> rows;
  for (const IkRobot& robot : robots) {
    Cases cases(robot, options.seed);
    const robots::InverseKinematics own(robot.model, cases.variables());
    const std::optional<IkChain> chain = serialChain(robot, cases);
    std::vector<Tally> tallies = {Tally(robot, "Leeway")};
    std::vector<std::unique_ptr<IkSolver>> solvers;
    for (const IkEngine* rival : rivals) {
      if (!chain) break;
      tallies.emplace_back(robot, rival->name());
      solvers.push_back(rival->prepare(*chain));
    }
    for (int i = 0; i < options.poses; ++i) {
      if (options.progress && i % 100 == 0)
        options.progress(fmt::format("{}: pose {} of {}", robot.name, i, options.poses));
      const Pose X_WF = cases.pose(cases.configuration());
      const std::vector<double> start = cases.configuration();
      const PoseRegion region = PoseRegion::exact(robot.link, {}, {}, X_WF);
      robots::IkOptions first;
      first.starts = kIkStarts;
      double begin = bench::cpuNanoseconds();
      const robots::IkResult result = own.solve({&region, 1}, start, first);
      Answer answer;
      answer.seconds = 1e-9 * (bench::cpuNanoseconds() - begin);
      answer.found = result.status == robots::IkStatus::kFound;
      if (answer.found) answer.values = result.solutions.front().values;
      tallies[0].add(robot, cases, start, region, answer);
      if (cases.variables().size() <= 6 && i % 10 == 0) {
        robots::IkOptions all;
        all.starts = kBranchStarts;
        all.max_solutions = kMostBranches;
        begin = bench::cpuNanoseconds();
        const robots::IkResult branches = own.solve({&region, 1}, start, all);
        tallies[0].addAll(1e-9 * (bench::cpuNanoseconds() - begin), branches.solutions.size());
      }
      std::vector<double> joints;
      for (const int v : cases.variables()) joints.push_back(start[at(v)]);
      for (std::size_t r = 0; r < solvers.size(); ++r) {
        answer.values.assign(joints.size(), 0);
        begin = bench::cpuNanoseconds();
        answer.found = solvers[r]->solve(X_WF, joints, answer.values);
        answer.seconds = 1e-9 * (bench::cpuNanoseconds() - begin);
        tallies[1 + r].add(robot, cases, start, region, answer);
      }
    }
    std::vector<IkRow> added;
    added.reserve(tallies.size());
    for (Tally& tally : tallies) added.push_back(tally.row());
    if (options.on_rows) options.on_rows(added);
    rows.insert(rows.end(), added.begin(), added.end());
  }
  return rows;
}

std::vector<IkProofRow> measureIkProofs(const std::vector<IkRobot>& robots,
                                        const IkReportOptions& options) {
  std::vector<IkProofRow> rows;
  for (const IkRobot& robot : robots) {
    if (options.progress) options.progress(fmt::format("{}: proofs", robot.name));
    const robots::Model& model = *robot.model;
    Cases cases(robot, options.seed + 1);
    const robots::InverseKinematics own(robot.model, cases.variables());
    IkProofRow row;
    row.robot = robot.name;
    std::vector<double> milliseconds;
    const std::vector<double> q = model.defaultConfiguration();
    for (; row.beyond < options.beyond; ++row.beyond) {
      const PoseRegion region = PoseRegion::exact(robot.link, {}, {}, cases.beyond());
      const double begin = bench::cpuNanoseconds();
      const robots::IkResult result = own.solve({&region, 1}, q);
      milliseconds.push_back((bench::cpuNanoseconds() - begin) * 1e-6);
      row.proven += result.status == robots::IkStatus::kUnreachable ? 1 : 0;
      row.found += result.status == robots::IkStatus::kFound ? 1 : 0;
    }
    row.median_ms = median(milliseconds);
    row.most_ms = quantile(milliseconds, 0.95);

    std::vector<int> column(model.variables.size(), -1);
    std::vector<double> lower, upper;
    for (const int v : cases.variables()) {
      column[at(v)] = static_cast<int>(lower.size());
      lower.push_back(model.variables[at(v)].lower);
      upper.push_back(model.variables[at(v)].upper);
    }
    std::vector<Pose> X_WL(model.links.size());
    robots::forwardKinematics(model, q, X_WL);
    for (; row.reachable < 10 * options.beyond; ++row.reachable) {
      const PoseRegion region =
          PoseRegion::exact(robot.link, {}, {}, cases.pose(cases.configuration()));
      const robots::Chain chain = robots::makeChain(model, region, X_WL, column);
      row.wrong +=
          robots::proveUnreachable(chain, region, q, lower, upper, kProofBoxes).proven ? 1 : 0;
    }
    if (options.on_proof_rows) options.on_proof_rows({row});
    rows.push_back(row);
  }
  return rows;
}

Table ikRows(const std::vector<IkRow>& rows) {
  Table table({"robot", "engine", "poses", "solved", "coarse", "wrong", "first_us_median",
               "first_us_95", "worst_error:.3g", "all_us_median", "branches"});
  for (const IkRow& r : rows)
    table.add({r.robot, r.engine, r.poses, r.solved, r.coarse, r.wrong, r.median_us, r.most_us,
               r.worst_error, r.all_us, r.branches});
  return table;
}

Table ikTable(const std::vector<IkRow>& rows) {
  Table table({"robot", "engine", "poses", "to 1e-9 [%]:.3f", "to 1e-5 [%]:.3f", "wrong",
               "first [us]:.3g", "95 %:.3g", "error:.3g", "all [us]:.3g", "branches:.3g"},
              2);
  for (const IkRow& r : rows)
    table.add({r.robot, r.engine, r.poses, 100.0 * r.solved / std::max(1, r.poses),
               100.0 * (r.solved + r.coarse) / std::max(1, r.poses), r.wrong, r.median_us,
               r.most_us, r.worst_error, r.all_us, r.branches});
  return table;
}

Table ikProofRows(const std::vector<IkProofRow>& rows) {
  Table table({"robot", "beyond", "proven", "found", "open", "proof_ms_median", "proof_ms_95",
               "reachable", "wrong"});
  for (const IkProofRow& r : rows)
    table.add({r.robot, r.beyond, r.proven, r.found, r.beyond - r.proven - r.found, r.median_ms,
               r.most_ms, r.reachable, r.wrong});
  return table;
}

}  // namespace leeway::tools::report
