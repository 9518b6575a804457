#include "tools/lab/growth/growth_report.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "planner/base/clock.h"
#include "planner/space/ompl_lock.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/asked_edges.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/growth/growth_worlds.h"
#include "tools/lab/planning/rival_states.h"

namespace leeway::tools::report {
namespace {

using planner::Clock;
using planner::CompiledScene;
using planner::EdgeCertifier;
using planner::secondsSince;

constexpr double kStep = 1.0 / 32;  // a rival's step along an edge [rad]
constexpr unsigned long long kAskedIterations = 2000;

/// Memory in use on the heap [bytes].
double heapBytes() {
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
#else
  return 0;
#endif
}

using bench::AskedEdge;

std::vector<AskedEdge> askedEdges(const planner::Problem& problem, int most) {
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const planner::QuietOmpl quiet;
  return bench::askedEdges(problem, scene, kAskedIterations).some(most);
}

/// The mean CPU time of `ask` over the edges; median of the rounds [us].
double microsecondsAnEdge(const std::vector<AskedEdge>& edges, int rounds,
                          const std::function<void(const AskedEdge&)>& ask) {
  if (edges.empty()) return 0;
  std::vector<double> sums;
  for (int round = 0; round < rounds; ++round) {
    const double begin = bench::cpuNanoseconds();
    for (const AskedEdge& edge : edges) ask(edge);
    sums.push_back(bench::cpuNanoseconds() - begin);
  }
  return 1e-3 * median(sums) / static_cast<double>(edges.size());
}

/// Walks up to the first state that is not free.
void walk(const planner::ConfigurationSpace& space, RivalStates& states, const AskedEdge& edge,
          std::vector<double>& at) {
  const int steps =
      std::max(1, static_cast<int>(std::ceil(space.distance(edge.a, edge.b) / kStep)));
  for (int i = 1; i <= steps; ++i) {
    space.interpolate(edge.a, edge.b, static_cast<double>(i) / steps, at);
    if (!states.isFree(at)) return;
  }
}

/// Moves the last object: time until the new world can be queried [s].
double secondsToChange(const CompiledScene& scene, const planner::Problem& problem, int rounds) {
  planner::Object moved = problem.world.objects.back();
  moved.X_WO.translation.z() += 0.01;
  const int before = static_cast<int>(scene.scene().bodies().size()) - 1;
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) {
    const auto begin = Clock::now();
    const EdgeCertifier certifier(scene.withObjects({&moved, 1}, {&before, 1}));
    times.push_back(secondsSince(begin));
  }
  return median(times);
}

GrowthRow ours(const std::string& family, std::int64_t count, std::vector<AskedEdge>& edges,
               const GrowthReportOptions& options) {
  GrowthRow row{family, count, "Leeway"};
  // Meshes store data for their queries, so a new world is made here to measure all of it.
  const double before = heapBytes();
  const auto begin = Clock::now();
  planner::Problem problem = growthProblem(family, count);
  const double read_s = secondsSince(begin), with_problem = heapBytes();
  const auto compile = Clock::now();
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  row.make_s = secondsSince(compile) + (family == "triangles" ? read_s : 0);
  row.bytes = heapBytes() - (family == "triangles" ? before : with_problem);
  if (family == "boxes" || family == "points")
    row.change_s = secondsToChange(*scene, problem, options.rounds);
  if (edges.empty() || family == "joints") edges = askedEdges(problem, options.edges);
  row.edges = static_cast<int>(edges.size());
  row.edge_us = microsecondsAnEdge(
      edges, options.rounds, [&](const AskedEdge& edge) { certifier.certify(edge.a, edge.b); });
  problem.seed = options.seed;
  problem.limits.time = options.time;
  const planner::PlanResult result = planner::plan(scene, problem);
  row.status = planner::toString(result.status);
  row.plan_s =
      result.plan_s + result.simplify_s + result.improve_s + result.push_s + result.certify_s;
  return row;
}

GrowthRow theirs(const std::string& family, std::int64_t count, const StateEngine& engine,
                 const std::vector<AskedEdge>& edges, const GrowthReportOptions& options) {
  GrowthRow row{family, count, engine.name()};
  row.status = "left out";
  const auto scene = std::make_shared<const CompiledScene>(growthProblem(family, count));
  const double before = heapBytes();
  const auto begin = Clock::now();
  const std::unique_ptr<StateChecker> checker = engine.prepare(scene->scene());
  if (!checker) return row;
  row.make_s = secondsSince(begin);
  row.bytes = heapBytes() - before;
  row.status = "measured";
  row.edges = static_cast<int>(edges.size());
  RivalStates states(*scene, *checker);
  std::vector<double> at(scene->space().variables().size());
  row.edge_us = microsecondsAnEdge(edges, options.rounds, [&](const AskedEdge& edge) {
    walk(scene->space(), states, edge, at);
  });
  return row;
}

}  // namespace

std::vector<GrowthRow> measureGrowth(const std::vector<const StateEngine*>& rivals,
                                     const GrowthReportOptions& options) {
  std::vector<GrowthRow> rows;
  for (const auto& [family, counts] : options.counts) {
    std::vector<AskedEdge> edges;
    for (const std::int64_t count : counts) {
      if (options.progress) options.progress(fmt::format("{} {}", count, family));
      std::vector<GrowthRow> added{ours(family, count, edges, options)};
      for (const StateEngine* engine : rivals)
        added.push_back(theirs(family, count, *engine, edges, options));
      if (options.on_rows) options.on_rows(added);
      rows.insert(rows.end(), added.begin(), added.end());
    }
  }
  return rows;
}

}  // namespace leeway::tools::report
