#include "planner/search/connect_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include "leeway/planner/plan.h"
#include "leeway/planner/planners.h"
#include "planner/base/tolerances.h"
#include "tests/support/build_paths.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

/// A flying box on its way around two walls with small openings.
Problem flight(std::uint64_t seed) {
  Problem problem =
      test::problemOf(test::flyingBox(), {-0.8, 0, 0, 0, 0, 0, 1}, {0.8, 0, 0, 0, 0, 0, 1});
  problem.world.objects.push_back(test::box("near wall", {0.02, 0.85, 1.2}, -0.3, -0.3, 0));
  problem.world.objects.push_back(test::box("far wall", {0.02, 0.85, 1.2}, 0.3, 0.3, 0));
  problem.seed = seed;
  problem.limits.time = 60;
  return problem;
}

PlanResult planWith(Problem problem, const std::map<std::string, std::string>& parameters) {
  problem.planner.parameters = parameters;
  return plan(problem);
}

auto answerOf(const PlanResult& result) {
  return std::tuple(result.status, result.path.positions, result.iterations, result.states,
                    result.edges, result.undecided_edges, result.distance_queries);
}

TEST(ConnectSearch, WorkersGiveTheSameAnswerForAnyNumberOfThreads) {
  int earlier = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Problem problem = flight(seed);
    const PlanResult one = planWith(problem, {{"workers", "5"}, {"threads", "1"}});
    ASSERT_EQ(one.status, PlanStatus::kSolved) << "seed " << seed;
    EXPECT_TRUE(one.certificate.certified);
    for (const char* threads : {"2", "3", "8", "0"}) {
      const PlanResult more = planWith(problem, {{"workers", "5"}, {"threads", threads}});
      EXPECT_TRUE(answerOf(more) == answerOf(one)) << "seed " << seed << ", threads " << threads;
    }
    // The first worker behaves like a single one.
    const PlanResult alone = planWith(problem, {});
    EXPECT_LE(one.iterations, alone.iterations);
    earlier += one.iterations < alone.iterations;
    if (one.iterations == alone.iterations) {
      EXPECT_EQ(one.path.positions, alone.path.positions);
    }
  }
  EXPECT_GE(earlier, 10);
}

TEST(ConnectSearch, AnIterationLimitHoldsForEachWorker) {
  Problem problem = test::wallProblem();
  problem.world.objects.push_back(
      test::box("plug", {0.05, 0.6, 0.5}, 0, 1.2, 0));  // closes the gap
  problem.limits.iterations = 300;
  std::uint64_t edges = 0;
  for (const char* threads : {"1", "2", "8"}) {
    const PlanResult result = planWith(problem, {{"workers", "3"}, {"threads", threads}});
    EXPECT_EQ(result.status, PlanStatus::kUnsolved);
    EXPECT_EQ(result.iterations, 300u);
    if (edges > 0) {
      EXPECT_EQ(result.edges, edges);
    }
    edges = result.edges;
  }
  EXPECT_GT(edges, planWith(problem, {}).edges);
}

/// A bar leaves a trap through a tube that is slightly wider than the bar.
Problem trap() {
  Problem problem = test::problemOf(
      robots::freeBody("bar", {{collision::Shape::box({0.25, 0.05, 0.05}), {}, "bar"}},
                       robots::JointType::kFloating, {-2, -2, -2}, {2, 2, 2}),
      {-0.4, 0, 0, 0, 0, std::sqrt(0.5), std::sqrt(0.5)}, {1.5, 0, 0, 0, 0, 0, 1});
  const double a = 0.8, g = 0.12, t = 0.05;  // half the trap, half the opening, half the walls
  problem.world.objects.push_back(test::box("back", {t, a, a}, -a, 0, 0));
  for (const double s : {-1.0, 1.0}) {
    const std::string name = s < 0 ? " -" : " +";
    problem.world.objects.push_back(test::box("y" + name, {a, t, a}, 0, s * a, 0));
    problem.world.objects.push_back(test::box("z" + name, {a, a, t}, 0, 0, s * a));
    const double half = (a - g) / 2;
    problem.world.objects.push_back(
        test::box("front y" + name, {0.2, half, a}, a, s * (g + half), 0));
    problem.world.objects.push_back(
        test::box("front z" + name, {0.2, g, half}, a, 0, s * (g + half)));
  }
  return problem;
}

/// Searches the way out of the trap with a first run of the given length.
struct TrapSearch {
  explicit TrapSearch(const Problem& problem)
      : scene(std::make_shared<const CompiledScene>(problem)), start(problem.start) {}

  ConnectResult search(Limits& limits, int workers, int threads, std::uint64_t first_run) const {
    const ConnectQuery query{scene,  start,   goals, seed,     accept,
                             limits, 100'000, {},    HUGE_VAL, first_run};
    ConnectChoice choice = connectChoice({}, scene->space());
    choice.workers = workers;
    choice.threads = threads;
    EdgeCertifier certifier(scene);
    return searchConnect(query, choice, certifier);
  }

  std::shared_ptr<const CompiledScene> scene;
  std::vector<double> start;
  Waypoints goals{{1.5, 0, 0, 0, 0, 0, 1}};
  std::uint64_t seed = 1;
  std::function<bool(Waypoints&, EdgeCertifier&, bool)> accept =
      [](Waypoints& path, EdgeCertifier&, bool) { return path.size() > 1; };
};

/// The first run of an arm continues while its edges are few: the path is that of a longer run.
TEST(ConnectSearch, AFirstRunGoesOnWhileItIsCheap) {
  const Problem problem = loadProblem(sourceFolder() + "/problems/table/posts.yaml");
  TrapSearch search(problem);
  search.start.clear();
  for (const int v : search.scene->space().variables())
    search.start.push_back(problem.start[static_cast<std::size_t>(v)]);
  search.goals = {{}};
  for (const auto& [low, high] : problem.goals[0].ranges) search.goals[0].push_back(low);
  for (search.seed = 1; search.seed <= 5; ++search.seed) {
    const auto run = [&](std::uint64_t first_run) {
      Limits limits(0, 100'000, {}, {});
      const ConnectResult result = search.search(limits, 1, 1, first_run);
      return std::tuple(result.path, limits.iterations());
    };
    const auto whole = run(kConnectRun);
    const std::uint64_t needed = std::get<1>(whole);
    ASSERT_TRUE(std::get<0>(whole));
    ASSERT_GT(needed, 2U);
    EXPECT_EQ(run(needed / 2), whole) << search.seed;
  }
}

TEST(ConnectSearch, NarrowRunsLeaveATrap) {
  TrapSearch trapped(trap());
  for (trapped.seed = 1; trapped.seed <= 2; ++trapped.seed) {
    const auto run = [&](int workers, int threads) {
      Limits limits(0, 100'000, {}, {});
      const ConnectResult result = trapped.search(limits, workers, threads, 200);
      return std::tuple(result.path, limits.iterations(), result.work.edges);
    };
    const auto alone = run(1, 1), several = run(3, 1);
    ASSERT_TRUE(std::get<0>(alone)) << trapped.seed;
    ASSERT_TRUE(std::get<0>(several)) << trapped.seed;
    // The first run finds no path; one of the narrow runs does.
    EXPECT_GT(std::get<1>(alone), 200U);
    EXPECT_GT(std::get<2>(alone), 0U);
    EXPECT_LE(std::get<1>(several), std::get<1>(alone));
    EXPECT_EQ(alone, run(1, 1));
    EXPECT_EQ(several, run(3, 3));
    EdgeCertifier judge(trapped.scene);
    const Waypoints& path = *std::get<0>(alone);
    for (std::size_t i = 1; i < path.size(); ++i)
      EXPECT_EQ(judge.certify(path[i - 1], path[i], EdgeRequest::persistent()).verdict,
                Verdict::kFree);
  }
}

TEST(ConnectSearch, SlidesLookAtTheLimits) {
  Problem problem = trap();
  problem.world.objects.push_back(test::box("plug", {0.02, 0.2, 0.2}, 1.02, 0, 0));
  const TrapSearch trapped(problem);
  int asked = 0;
  Limits limits(0, 0, [&asked] { return ++asked > 300; }, {});
  const ConnectResult result = trapped.search(limits, 1, 1, 10);
  EXPECT_FALSE(result.path);
  // The limits are checked at least once per kConnectTurn edges, and slides make most of these.
  EXPECT_GT(result.work.edges, limits.iterations());
  EXPECT_LE(result.work.edges, 301 * kConnectTurn);
}

TEST(ConnectSearch, ClearanceTakesWorkersToo) {
  Problem problem = test::corridorProblem();
  problem.objective = MaximumClearance{};
  problem.limits.iterations = 3000;
  problem.limits.time = 0;
  const PlanResult one = planWith(problem, {{"workers", "3"}, {"threads", "1"}});
  ASSERT_EQ(one.status, PlanStatus::kSolved);
  EXPECT_GT(one.certificate.clearance.lower, 0.5);
  EXPECT_TRUE(answerOf(planWith(problem, {{"workers", "3"}, {"threads", "4"}})) == answerOf(one));
}

TEST(ConnectSearch, StopsWhenAsked) {
  Problem problem = test::wallProblem();
  problem.world.objects.push_back(test::box("plug", {0.05, 0.6, 0.5}, 0, 1.2, 0));
  problem.planner.parameters = {{"workers", "4"}, {"threads", "4"}};
  int asked = 0;
  PlanOptions options;
  options.stop = [&asked] { return ++asked > 200; };
  EXPECT_EQ(plan(problem, options).status, PlanStatus::kUnsolved);
}

TEST(ConnectSearch, RefusesNumbersThatAreNoCounts) {
  for (const char* value : {"0", "-1", "1.5", "65", "many", ""})
    EXPECT_NE(plannerError("Connect", {{"workers", value}}), std::nullopt) << value;
  for (const char* value : {"1", "64"})
    EXPECT_EQ(plannerError("Connect", {{"workers", value}}), std::nullopt) << value;
  EXPECT_EQ(plannerError("Connect", {{"threads", "0"}}), std::nullopt);
  EXPECT_NE(plannerError("RRTConnect", {{"workers", "2"}}), std::nullopt);
  const std::vector<PlannerParameter> parameters = plannerParameters("Connect");
  EXPECT_TRUE(std::is_sorted(parameters.begin(), parameters.end(),
                             [](const auto& a, const auto& b) { return a.name < b.name; }));
  EXPECT_EQ(std::count_if(parameters.begin(), parameters.end(),
                          [](const auto& p) { return p.name == "workers"; }),
            1);
}

}  // namespace
}  // namespace leeway::planner
