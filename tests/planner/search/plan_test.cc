#include "leeway/planner/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "leeway/planner/planners.h"
#include "leeway/robots/input_error.h"
#include "planner/search/goals.h"
#include "tests/support/folder.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

/// Checks that every edge is proven, the ends are start and goal, and the certificate's interval
/// holds for dense samples.
void expectCertified(const Problem& problem, const PlanResult& result) {
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  ASSERT_GE(result.path.positions.size(), 2u);
  EXPECT_EQ(result.path.positions.front(), problem.start);
  ASSERT_GE(result.goal, 0);
  const Goal& goal = problem.goals[static_cast<std::size_t>(result.goal)];
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EXPECT_TRUE(goalHolds(*scene, goal, result.path.positions.back()));
  EdgeCertifier certifier(scene);
  std::vector<double> q(problem.start.size());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < result.path.positions.size(); ++i) {
    double least_here = std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 100; ++k) {
      scene->space().interpolate(result.path.positions[i - 1], result.path.positions[i], k / 100.0,
                                 q);
      const StateCheck check = certifier.clearance(q, 1e-7);
      EXPECT_EQ(check.verdict, Verdict::kFree) << "segment " << i - 1 << " at " << k / 100.0;
      least_here = std::min(least_here, check.clearance.upper);
    }
    EXPECT_LE(result.certificate.segments[i - 1].lower, least_here);
    least = std::min(least, least_here);
  }
  EXPECT_LE(result.certificate.clearance.lower, least);
  EXPECT_GE(result.certificate.clearance.upper, result.certificate.clearance.lower);
}

std::vector<std::string> allPlanners() {
  std::vector<std::string> names;
  for (const PlannerTraits& traits : plannerNames()) names.push_back(traits.name);
  return names;
}

TEST(Plan, TellsTheEdgesThatItFindsFree) {
  for (const char* planner : {"Connect", "RRTConnect"}) {
    Problem problem = test::wallProblem();
    problem.planner.name = planner;
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    std::size_t edges = 0;
    std::set<double> heights;
    PlanOptions options;
    options.on_edge = [&](std::span<const double> a, std::span<const double> b) {
      ++edges;
      heights.insert(a[1]);
      EXPECT_EQ(certifier.certify(a, b, EdgeRequest::persistent()).verdict, Verdict::kFree);
    };
    const PlanResult told = plan(problem, options);
    EXPECT_EQ(told.status, PlanStatus::kSolved) << planner;
    EXPECT_GT(edges, 2u) << planner;
    EXPECT_GT(heights.size(), 2u) << planner;
    // A listener changes nothing.
    EXPECT_EQ(told.path.positions, plan(problem).path.positions) << planner;
  }
}

class EachPlanner : public testing::TestWithParam<std::string> {};

TEST_P(EachPlanner, SolvesTheWallAndCertifies) {
  const PlannerTraits& traits = *findPlanner(GetParam());
  Problem problem = test::wallProblem();
  problem.planner.name = traits.name;
  problem.limits.iterations = traits.optimizing ? 1500 : 1000000;
  if (!traits.exact) problem.limits.iterations = 30000;  // random steps need many
  // Multithreaded planners check their limits a varying number of times: limited by time.
  if (!traits.deterministic) problem.limits.iterations = 0;
  if (!traits.deterministic) problem.limits.time = traits.optimizing ? 0.5 : 20;
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.planner, traits.name);
  EXPECT_EQ(result.deterministic, traits.deterministic);
  expectCertified(problem, result);
  EXPECT_GT(result.iterations, 0u);
  EXPECT_GT(result.length, 4.0) << "the straight way is closed";
}

INSTANTIATE_TEST_SUITE_P(Ompl, EachPlanner, testing::ValuesIn(allPlanners()),
                         [](const auto& each) { return each.param; });

TEST(Plan, FliesThroughAWindow) {
  Problem problem = test::problemOf(test::flyingBox(), {-0.8, 0, 0, 0, 0, 0, 1},
                                    {0.8, 0, 0, 0, 0, std::sqrt(0.5), std::sqrt(0.5)});
  // A window of 0.3 x 0.3 at y = 0.4, z = 0.
  problem.world.objects.push_back(test::box("left", {0.02, 0.6, 1.5}, 0, -0.35, 0));
  problem.world.objects.push_back(test::box("right", {0.02, 0.5, 1.5}, 0, 1.05, 0));
  problem.world.objects.push_back(test::box("below", {0.02, 0.15, 0.7}, 0, 0.4, -0.85));
  problem.world.objects.push_back(test::box("above", {0.02, 0.15, 0.7}, 0, 0.4, 0.85));
  problem.limits.iterations = 200000;
  expectCertified(problem, plan(problem));
}

TEST(Plan, StraightWayIsTheAnswerWhereItIsFree) {
  Problem problem = test::problemOf(test::disc(), {-1, -1, 0}, {1, -1, 0});
  const PlanResult result = plan(problem);
  expectCertified(problem, result);
  EXPECT_EQ(result.path.positions.size(), 2u);
  EXPECT_EQ(result.iterations, 0u);
  EXPECT_EQ(result.length, 2.0);
}

TEST(Plan, StartInsideItsGoalStays) {
  Problem problem = test::wallProblem();
  problem.goals[0] = test::pointGoal("here", problem.start);
  const PlanResult result = plan(problem);
  expectCertified(problem, result);
  EXPECT_EQ(result.length, 0.0);
}

TEST(Plan, InvalidStartNamesPairDepthAndPlace) {
  Problem problem = test::wallProblem();
  problem.start = {-0.1, -1, 0};
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kInvalidStart);
  EXPECT_EQ(std::set<std::string>({result.offending_a, result.offending_b}),
            std::set<std::string>({"disc", "lower wall"}));
  EXPECT_NEAR(result.offending.clearance.upper, -0.05, 1e-4);
  EXPECT_NEAR(result.offending.closest.point_a.x(), -0.05, 0.06);
  EXPECT_TRUE(result.path.positions.empty());
}

TEST(Plan, AllGoalsInvalidNamesTheLeastDeep) {
  Problem problem = test::wallProblem();
  problem.goals = {test::pointGoal("deep", {0, -1, 0}), test::pointGoal("shallow", {0.12, -1, 0})};
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kInvalidGoal);
  EXPECT_NEAR(result.offending.clearance.upper, -0.03, 1e-4);
  EXPECT_EQ(result.warnings.size(), 2u);
}

TEST(Plan, InvalidGoalsAmongOthersAreLeftOutWithAWarning) {
  Problem problem = test::wallProblem();
  problem.goals.insert(problem.goals.begin(), test::pointGoal("inside", {0, -1, 0}));
  const PlanResult result = plan(problem);
  expectCertified(problem, result);
  EXPECT_EQ(result.goal, 1);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_NE(result.warnings[0].find("'inside'"), std::string::npos);
  problem.margins.common = -0.01;
  EXPECT_NE(plan(problem).warnings.at(0).find(
                "mm deep in each other there, and less than 10 mm is required"),
            std::string::npos);
}

TEST(Plan, GoalRangesAreReachedByEveryKindOfPlanner) {
  for (const char* planner : {"Connect", "RRTConnect", "RRT", "BITstar", "KPIECE1", "FMT"}) {
    Problem problem = test::wallProblem();
    problem.planner.name = planner;
    problem.limits.iterations = 5000;
    // A box of goals, half of it inside the wall, at any angle.
    problem.goals[0].ranges = {{0, 1}, {-1.5, -1}, {-3.2, 3.2}};
    const PlanResult result = plan(problem);
    SCOPED_TRACE(planner);
    expectCertified(problem, result);
  }
}

TEST(Plan, AnglesOfARangeCountModuloATurn) {
  Problem problem = test::wallProblem();
  problem.goals[0].ranges[2] = {6, 6.5};
  const PlanResult result = plan(problem);
  expectCertified(problem, result);
  EXPECT_LT(result.length, 7) << "6.28 is where it started";
}

TEST(Plan, UnsolvableProblemEndsAtItsIterations) {
  for (const std::string planner :
       {"Connect", "RRTConnect", "FMT", "BITstar", "LazyPRM", "SBL", "PDST"}) {
    Problem problem = test::wallProblem();
    problem.world.objects[0] = test::box("wall", {0.05, 3, 0.5}, 0, 0, 0);
    problem.planner.name = planner;
    problem.limits.iterations = 500;
    problem.limits.time = 0;
    const PlanResult result = plan(problem);
    EXPECT_EQ(result.status, PlanStatus::kUnsolved) << planner;
    EXPECT_EQ(result.iterations, 500u) << planner;
    EXPECT_TRUE(result.path.positions.empty()) << planner;
  }
}

/// The result says which pair blocked the search and how near it came; the same for the same seed,
/// and for several workers.
TEST(Plan, UnsolvedTellsWhatWasInTheWay) {
  Problem problem = test::wallProblem();
  problem.world.objects[0] = test::box("wall", {0.05, 3, 0.5}, 0, 0, 0);
  problem.limits.iterations = 500;
  problem.limits.time = 0;
  for (const std::string planner : {"Connect", "workers", "RRTConnect", "PRM", "RRTstar"}) {
    const bool is_connect = planner == "Connect" || planner == "workers";
    problem.planner.name = is_connect ? "Connect" : planner;
    problem.planner.parameters.clear();
    if (planner == "workers") problem.planner.parameters["workers"] = "3";
    const PlanResult result = plan(problem);
    ASSERT_FALSE(result.blocked.empty()) << planner;
    EXPECT_EQ(std::minmax(result.blocked[0].a, result.blocked[0].b),
              std::minmax(std::string("disc"), std::string("wall")));
    EXPECT_GT(result.blocked[0].edges, 5U) << planner;
    EXPECT_TRUE(result.long_turns.empty());
    EXPECT_EQ(result.gap.from.empty(), !is_connect) << planner;
    if (!is_connect) continue;
    EXPECT_LT(result.gap.from[0], 0) << "on the start's side";
    EXPECT_GT(result.gap.to[0], 0);
    EXPECT_GE(result.gap.distance, 0.3) << "the wall and a disc's radius on either side";
    EXPECT_LT(result.gap.distance, 2);
    const PlanResult again = plan(problem);
    EXPECT_EQ(again.gap.from, result.gap.from);
    EXPECT_EQ(again.gap.to, result.gap.to);
    EXPECT_EQ(again.blocked[0].edges, result.blocked[0].edges);
  }
}

TEST(Plan, UnsolvedNamesJointsThatGoTheLongWay) {
  // A boom that would have to pass through a post; the shorter turn is beyond its limits.
  const Folder folder;
  const auto model = robots::loadModel(
      folder.write("boom.urdf", R"(<robot name="r"><link name="base"/><link name="boom"><collision>
<origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="boom"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>)"),
      "");
  Problem problem = test::problemOf(model, {-2}, {2});
  problem.world.objects.push_back(test::box("post", {0.1, 0.1, 0.5}, 0.7, 0, 0));
  problem.limits.iterations = 200;
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kUnsolved);
  EXPECT_EQ(result.long_turns, std::vector<std::string>{"turn"});
  problem.goals.push_back(test::pointGoal("other", {1}));
  EXPECT_TRUE(plan(problem).long_turns.empty()) << "the shorter turn to this goal is within them";
}

TEST(Plan, UnsolvableProblemEndsAtItsTime) {
  for (const std::string planner : {"Connect", "RRTConnect", "PRM", "CForest"}) {
    Problem problem = test::wallProblem();
    problem.world.objects[0] = test::box("wall", {0.05, 3, 0.5}, 0, 0, 0);
    problem.planner.name = planner;
    problem.limits.time = 0.1;
    EXPECT_EQ(plan(problem).status, PlanStatus::kUnsolved) << planner;
  }
}

TEST(Plan, StopEndsAndProgressIsTold) {
  for (const std::string planner : {"Connect", "RRTConnect", "RRTstar", "PRM"}) {
    Problem problem = test::wallProblem();
    problem.world.objects[0] = test::box("wall", {0.05, 3, 0.5}, 0, 0, 0);
    problem.planner.name = planner;
    problem.limits.time = 0;
    std::atomic<int> asked{0};
    std::vector<std::string> phases;
    PlanOptions options;
    options.stop = [&] { return ++asked > 200; };
    options.progress = [&](const std::string& phase, double elapsed) {
      EXPECT_GE(elapsed, 0);
      if (phases.empty() || phases.back() != phase) phases.push_back(phase);
    };
    EXPECT_EQ(plan(problem, options).status, PlanStatus::kUnsolved) << planner;
    EXPECT_GT(asked, 200);
    EXPECT_EQ(phases, (std::vector<std::string>{"compile", "plan"}));
  }
}

std::string refusal(const Problem& problem) {
  try {
    plan(problem);
  } catch (const robots::InputError& error) {
    return error.what();
  }
  return "nothing was wrong";
}

TEST(Plan, RefusesWhatCannotBeMeant) {
  const auto expectRefusal = [](const Problem& problem, std::vector<std::string> words) {
    const std::string message = refusal(problem);
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << message << " lacks " << word;
  };
  Problem problem = test::wallProblem();
  problem.planner.name = "RRTConect";
  expectRefusal(problem, {"'RRTConect' is unknown", "'RRTConnect'"});
  problem.planner.name = "rrt*";
  problem.planner.parameters = {{"goal_bia", "0.1"}};
  expectRefusal(problem, {"'goal_bia' is unknown", "'goal_bias'"});
  for (const char* bad : {"", "fast", "nan", "inf", "-1", "0.5x"}) {
    problem.planner.parameters = {{"goal_bias", bad}};
    expectRefusal(problem, {"'goal_bias' cannot be '" + std::string(bad) + "'", "is expected"});
  }
  problem.planner.parameters = {{"focus_search", "2"}};
  expectRefusal(problem, {"true or false"});
  problem = test::wallProblem();
  problem.start[1] = 2.5;
  expectRefusal(problem, {"start", "'disc/y'", "2.5", "-2", "2"});
  problem = test::wallProblem();
  problem.goals[0].ranges[0] = {5, 6};
  expectRefusal(problem, {"goal 'goal'", "'disc/x'", "5 to 6", "-2 to 2"});
  problem = test::wallProblem();
  problem.goals.clear();
  expectRefusal(problem, {"no goal"});
}

TEST(Planners, ParametersAreTakenAndListed) {
  Problem problem = test::wallProblem();
  problem.planner.name = "RRT*";
  problem.planner.parameters = {{"range", "0.5"}, {"focus_search", "true"}, {"goal_bias", "0.1"}};
  problem.limits.iterations = 1500;
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.planner, "RRTstar");
  expectCertified(problem, result);
  EXPECT_GE(plannerNames().size(), 38u);
  const auto parameters = plannerParameters("RRTConnect");
  ASSERT_EQ(parameters.size(), 2u);
  EXPECT_EQ(parameters[1].name, "range");
}

}  // namespace
}  // namespace leeway::planner
