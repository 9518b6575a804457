#include "tools/lab/growth/growth_report.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <span>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/point_cloud.h"
#include "leeway/robots/kinematics.h"
#include "planner/space/ompl_lock.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/asked_edges.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/growth/growth_worlds.h"
#include "tools/lab/planning/rival_states.h"

namespace leeway::tools::report {
namespace {

using planner::CompiledScene;
using planner::EdgeCertifier;

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

/// Plans with several seeds until there are `most` edges, or the seeds are used up.
std::vector<AskedEdge> askedEdges(planner::Problem problem, int most, int seeds = 1) {
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const planner::QuietOmpl quiet;
  std::vector<AskedEdge> edges;
  for (; seeds > 0 && edges.size() < static_cast<std::size_t>(most); --seeds, ++problem.seed)
    for (AskedEdge& edge : bench::askedEdges(problem, scene, kAskedIterations)
                               .some(most - static_cast<int>(edges.size())))
      edges.push_back(std::move(edge));
  return edges;
}

/// Sets the mean CPU time of `ask` over the edges, as the median of the rounds, and the median over
/// the edges [us].
void timeEdges(const std::vector<AskedEdge>& edges, int rounds, GrowthRow& row,
               const std::function<void(const AskedEdge&)>& ask) {
  row.edges = static_cast<int>(edges.size());
  if (edges.empty()) return;
  std::vector<double> sums, each(edges.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < rounds; ++round) {
    const double begin = bench::cpuNanoseconds();
    for (const AskedEdge& edge : edges) ask(edge);
    sums.push_back(bench::cpuNanoseconds() - begin);
  }
  row.edge_us = 1e-3 * median(sums) / static_cast<double>(edges.size());
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const double begin = bench::cpuNanoseconds();
      ask(edges[i]);
      each[i] = std::min(each[i], bench::cpuNanoseconds() - begin);
    }
  row.edge_median_us = 1e-3 * median(each);
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

/// Median of the rounds [s].
template <class Run>
double secondsOf(int rounds, const Run& run) {
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) times.push_back(run());
  return median(times);
}

/// Moves the last object: time until the new world can be queried [s].
double secondsToChange(const CompiledScene& scene, const planner::Problem& problem, int rounds) {
  planner::Object moved = problem.world.objects.back();
  moved.X_WO.translation.z() += 0.01;
  const int before = static_cast<int>(scene.scene().bodies().size()) - 1;
  return secondsOf(rounds, [&] {
    const double begin = bench::processSeconds();
    const EdgeCertifier certifier(scene.withObjects({&moved, 1}, {&before, 1}));
    return bench::processSeconds() - begin;
  });
}

std::vector<double> middleOf(const planner::ConfigurationSpace& space, const AskedEdge& edge) {
  std::vector<double> middle(edge.a.size());
  space.interpolate(edge.a, edge.b, 0.5, middle);
  return middle;
}

/// The distance of the arm's capsules from the balls, one by one [m].
double distanceOfAll(const CompiledScene& scene, const planner::PointCloud& cloud,
                     std::span<const double> point) {
  std::vector<double> q(scene.model().variables.size());
  std::vector<robots::Pose> X_WL(scene.model().links.size());
  scene.expand(point, q);
  robots::forwardKinematics(scene.model(), q, X_WL);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t link = 0; link < X_WL.size(); ++link)
    for (const robots::Geometry& geometry : scene.model().links[link].geometries) {
      const robots::Pose X_WG = X_WL[link] * geometry.X_BG;
      const Eigen::Vector3d axis = X_WG.rotation.col(2);
      const double half = geometry.shape.halfLength(), radius = geometry.shape.radius();
      for (const collision::Ball& ball : cloud.balls) {
        const Eigen::Vector3d p = ball.center - X_WG.translation;
        const double along = std::clamp(p.dot(axis), -half, half);
        const double squared = (p - along * axis).squaredNorm();
        const double within = least + radius + ball.radius;  // negative only deep inside
        if (within < 0 || squared < within * within)
          least = std::min(least, std::sqrt(squared) - radius - ball.radius);
      }
    }
  return least;
}

/// Counts the answers about the middles of edges that the truth is outside of.
void compare(const std::vector<AskedEdge>& edges, const std::shared_ptr<const CompiledScene>& scene,
             const planner::PointCloud& cloud, GrowthRow& row) {
  constexpr double kRounding = 1e-9;  // of the truth, and of our poses [m]
  EdgeCertifier certifier(scene);
  for (const AskedEdge& edge : edges) {
    const std::vector<double> state = middleOf(scene->space(), edge);
    const double truth = distanceOfAll(*scene, cloud, state);
    const collision::Interval said = certifier.clearance(state, 1e-4).clearance;
    ++row.states;
    row.too_high += said.lower > truth + kRounding ? 1 : 0;
    row.too_low += said.upper < truth - kRounding ? 1 : 0;
  }
}

/// The middle tenth of the balls from below.
planner::CloudRegion tenthOf(const planner::PointCloud& cloud) {
  std::vector<double> heights;
  for (const collision::Ball& ball : cloud.balls) heights.push_back(ball.center.z());
  std::sort(heights.begin(), heights.end());
  const double all = std::numeric_limits<double>::infinity();
  return {{-all, -all, heights[heights.size() * 45 / 100]},
          {all, all, heights[heights.size() * 55 / 100]}};
}

GrowthRow oursAmongPoints(std::int64_t count, std::vector<AskedEdge>& edges,
                          const GrowthReportOptions& options) {
  GrowthRow row{"points", count, "Leeway"};
  planner::Problem problem = growthProblem("points", count);
  planner::Object& seen = problem.world.objects.front();
  std::vector<float> points;
  for (const collision::Ball& ball : seen.cloud->balls)
    for (const double coordinate : ball.center) points.push_back(static_cast<float>(coordinate));
  std::shared_ptr<const CompiledScene> scene;
  row.make_s = secondsOf(options.rounds, [&] {
    seen.cloud = nullptr;
    scene = nullptr;
    const double before = heapBytes(), begin = bench::processSeconds();
    seen.cloud = std::make_shared<const planner::PointCloud>(
        planner::makeCloud({points.data(), points.size() / 3}, kSeenRadius));
    scene = std::make_shared<const CompiledScene>(problem);
    const EdgeCertifier certifier(scene);
    const double seconds = bench::processSeconds() - begin;
    row.bytes = heapBytes() - before;
    return seconds;
  });
  constexpr int kSeeds = 20;  // a plan asks for few edges
  if (edges.empty()) edges = askedEdges(problem, options.edges, kSeeds);
  EdgeCertifier certifier(scene);
  timeEdges(edges, options.rounds, row,
            [&](const AskedEdge& edge) { certifier.certify(edge.a, edge.b); });
  problem.seed = options.seed;
  problem.limits.time = options.time;
  const planner::PlanResult result = planner::plan(scene, problem);
  row.status = planner::toString(result.status);
  row.plan_s =
      result.plan_s + result.simplify_s + result.improve_s + result.push_s + result.certify_s;
  compare(edges, scene, *seen.cloud, row);

  const planner::CloudRegion region = tenthOf(*seen.cloud);
  planner::PointCloud again;
  for (const collision::Ball& ball : seen.cloud->balls)
    if (region.contains(ball.center))
      again.balls.push_back({ball.center + Eigen::Vector3d(1e-3, 0, 0), ball.radius});
  std::shared_ptr<const CompiledScene> renewed;
  row.change_s = secondsOf(options.rounds, [&] {
    renewed = nullptr;
    const double begin = bench::processSeconds();
    renewed = scene->withRegion(seen.name, region, again);
    const EdgeCertifier changed(renewed);
    return bench::processSeconds() - begin;
  });
  compare(edges, renewed, planner::renewed(*seen.cloud, region, again), row);
  return row;
}

GrowthRow ours(const std::string& family, std::int64_t count, std::vector<AskedEdge>& edges,
               const GrowthReportOptions& options) {
  if (family == "points") return oursAmongPoints(count, edges, options);
  GrowthRow row{family, count, "Leeway"};
  // Meshes store data for their queries, so a new world is made here to measure all of it.
  const double before = heapBytes(), begin = bench::processSeconds();
  planner::Problem problem = growthProblem(family, count);
  const double read_s = bench::processSeconds() - begin, with_problem = heapBytes();
  const double compile = bench::processSeconds();
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  row.make_s = bench::processSeconds() - compile + (family == "triangles" ? read_s : 0);
  row.bytes = heapBytes() - (family == "triangles" ? before : with_problem);
  if (family == "boxes") row.change_s = secondsToChange(*scene, problem, options.rounds);
  if (edges.empty() || family == "joints") edges = askedEdges(problem, options.edges);
  timeEdges(edges, options.rounds, row,
            [&](const AskedEdge& edge) { certifier.certify(edge.a, edge.b); });
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
  const planner::Problem problem = growthProblem(family, count);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const double before = heapBytes(), begin = bench::processSeconds();
  const std::unique_ptr<StateChecker> checker = engine.prepare(scene->scene());
  if (!checker) return row;
  row.make_s = bench::processSeconds() - begin;
  row.bytes = heapBytes() - before;
  row.status = "measured";
  RivalStates states(*scene, *checker);
  std::vector<double> at(scene->space().variables().size());
  timeEdges(edges, options.rounds, row,
            [&](const AskedEdge& edge) { walk(scene->space(), states, edge, at); });
  for (std::size_t i = 0; family == "points" && i < edges.size(); ++i) {
    constexpr double kTouch = 1e-6;  // below it, rounding decides [m]
    const std::vector<double> state = middleOf(scene->space(), edges[i]);
    const double truth = distanceOfAll(*scene, *problem.world.objects.front().cloud, state);
    const bool is_free = states.isFree(state);
    ++row.states;
    row.too_high += is_free && truth < -kTouch ? 1 : 0;
    row.too_low += !is_free && truth > kTouch ? 1 : 0;
  }
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
