#include "tools/lab/motion/edge_report.h"

#include <ompl/util/Console.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/ompl_state_space.h"
#include "leeway/planner/verify.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/asked_edges.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/edge_stepper.h"

namespace leeway::tools::report {
namespace {

using planner::CompiledScene;
using planner::EdgeCertifier;
using planner::Problem;
using planner::Verdict;
using planner::VerifyStatus;

constexpr int kRounds = 5;
constexpr std::array<const char*, 3> kKinds = {"free", "near", "colliding"};
constexpr std::array<const char*, 5> kMethods = {"certified", "first order", "1/32", "0.5 %",
                                                 "1 %"};

double cpuMicroseconds() { return 1e-3 * bench::cpuNanoseconds(); }

struct Edge : bench::AskedEdge {
  std::size_t kind = 0;
};

/// verify() on a single edge, as a separate problem.
class SingleEdge {
 public:
  explicit SingleEdge(const Problem& problem) : problem_(problem) {
    for (const int v : problem.robot.variables)
      path_.names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
    problem_.goals.resize(1);
  }

  VerifyStatus verify(const std::vector<double>& a, const std::vector<double>& b) {
    path_.positions = {a, b};
    auto& ranges = problem_.goals[0].ranges;
    ranges.clear();
    for (std::size_t i = 0; i < a.size(); ++i) {
      problem_.start[static_cast<std::size_t>(problem_.robot.variables[i])] = a[i];
      ranges.push_back({b[i], b[i]});
    }
    return planner::verify(problem_, path_).status;
  }

 private:
  Problem problem_;
  planner::Path path_;
};

/// Judges an edge: 1 free, 0 not free, -1 undecided.
using Method = std::function<int(const Edge&)>;

EdgeRow measure(const std::string& problem, std::size_t kind, std::size_t method,
                const std::vector<Edge>& edges, const Method& ask, int rounds) {
  EdgeRow row{problem, kKinds[kind], kMethods[method], 0, 0, 0, 0};
  std::vector<double> sums;
  for (int round = 0; round < rounds; ++round) {
    double sum = 0;
    for (const Edge& edge : edges) {
      if (edge.kind != kind) continue;
      const double begin = cpuMicroseconds();
      const int said = ask(edge);
      sum += cpuMicroseconds() - begin;
      if (round > 0) continue;
      ++row.edges;
      const bool collides = kKinds[kind] == std::string("colliding");
      row.missed += collides && said == 1;
      row.cautious += !collides && said == 0;
      row.undecided += said < 0;
    }
    sums.push_back(sum);
  }
  if (row.edges > 0) row.us = quantile(sums, 0.5) / row.edges;
  return row;
}

void measureProblem(const NamedProblem& named, const EdgeReportOptions& options,
                    std::vector<EdgeRow>& rows) {
  const auto scene = std::make_shared<const CompiledScene>(named.problem);
  EdgeCertifier certifier(scene);
  SingleEdge single(named.problem);
  // Edges that verify() leaves undecided have no known truth.
  std::vector<Edge> known;
  for (const bench::AskedEdge& asked :
       bench::askedEdges(named.problem, scene, options.iterations).some(options.edges)) {
    Edge edge{asked};
    const VerifyStatus status = single.verify(edge.a, edge.b);
    if (status == VerifyStatus::kUndecided) continue;
    edge.kind = 2;
    if (status == VerifyStatus::kCertified) {
      const double near = named.problem.margins.common + kNear;
      edge.kind =
          certifier.edgeClearance(edge.a, edge.b, 1e-3, near).clearance.upper < near ? 1 : 0;
    }
    known.push_back(std::move(edge));
  }
  const double extent =
      planner::OmplStateSpace(std::make_shared<const planner::ConfigurationSpace>(scene->space()))
          .getMaximumExtent();
  const auto stepping = [&](double step) {
    const auto stepper = std::make_shared<bench::Stepper>(scene, step);
    return [stepper](const Edge& e) { return stepper->isFree(e.a, e.b) ? 1 : 0; };
  };
  const std::array<Method, 5> methods = {
      [&](const Edge& e) {
        const Verdict verdict = certifier.certify(e.a, e.b).verdict;
        return verdict == Verdict::kFree ? 1 : verdict == Verdict::kNotFree ? 0 : -1;
      },
      [&](const Edge& e) {
        const VerifyStatus status = single.verify(e.a, e.b);
        return status == VerifyStatus::kCertified ? 1 : status == VerifyStatus::kRefuted ? 0 : -1;
      },
      stepping(1.0 / 32), stepping(0.005 * extent), stepping(0.01 * extent)};
  // An edge of zero length measures verify()'s setup and one state.
  double setup = 0;
  if (!known.empty()) {
    const double begin = cpuMicroseconds();
    single.verify(known[0].a, known[0].a);
    setup = cpuMicroseconds() - begin;
  }
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind)
    for (std::size_t m = 0; m < methods.size(); ++m) {
      EdgeRow row = measure(named.name, kind, m, known, methods[m], m == 1 ? 1 : kRounds);
      if (m == 1) row.us = std::max(0.0, row.us - setup);
      if (row.edges > 0) rows.push_back(std::move(row));
    }
}

}  // namespace

std::vector<EdgeRow> measureEdges(const std::vector<NamedProblem>& problems,
                                  const EdgeReportOptions& options) {
  std::vector<EdgeRow> rows;
  ompl::msg::OutputHandler* const told = ompl::msg::getOutputHandler();
  ompl::msg::noOutputHandler();
  for (const NamedProblem& named : problems) {
    if (options.progress) options.progress("edges of " + named.name);
    std::vector<EdgeRow> added;
    measureProblem(named, options, added);
    if (options.on_rows) options.on_rows(added);
    rows.insert(rows.end(), added.begin(), added.end());
  }
  ompl::msg::useOutputHandler(told);
  return rows;
}

Table edgeRows(const std::vector<EdgeRow>& rows) {
  Table table({"problem", "kind", "method", "edges", "missed", "cautious", "undecided", "us"});
  for (const EdgeRow& r : rows)
    table.add({r.problem, r.kind, r.method, r.edges, r.missed, r.cautious, r.undecided, r.us});
  return table;
}

Table edgesTable(const std::vector<EdgeRow>& rows) {
  Table table({"edges", "method", "count", "missed", "cautious", "open", "us an edge:.2f"}, 2);
  for (const char* kind : kKinds) {
    for (const char* method : kMethods) {
      EdgeRow sum{"", kind, method, 0, 0, 0, 0, 0};
      for (const EdgeRow& r : rows) {
        if (r.kind != kind || r.method != method) continue;
        sum.edges += r.edges, sum.missed += r.missed, sum.cautious += r.cautious,
            sum.undecided += r.undecided, sum.us += r.us * r.edges;
      }
      table.add({kind, method, sum.edges, sum.missed, sum.cautious, sum.undecided,
                 sum.us / std::max(1, sum.edges)});
    }
  }
  return table;
}

}  // namespace leeway::tools::report
