#include <gtest/gtest.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/ScopedState.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRT.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>

#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/ompl_objectives.h"
#include "planner/base/random.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;

/// A user's OMPL program with our adaptors.
class OmplAdaptors : public testing::Test {
 protected:
  OmplAdaptors()
      : scene_(std::make_shared<const CompiledScene>(test::wallProblem())),
        pool_(std::make_shared<CertifierPool>(scene_)),
        information_(makeSpaceInformation(scene_, 1, pool_)) {
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  }

  ob::ScopedState<OmplStateSpace> state(double x, double y, double theta) {
    ob::ScopedState<OmplStateSpace> s(information_);
    s->values[0] = x;
    s->values[1] = y;
    s->values[2] = theta;
    return s;
  }

  ob::ProblemDefinitionPtr definition() {
    auto definition = std::make_shared<ob::ProblemDefinition>(information_);
    definition->setStartAndGoalStates(state(-1, -1, 0), state(1, -1, 0));
    return definition;
  }

  std::shared_ptr<const CompiledScene> scene_;
  std::shared_ptr<CertifierPool> pool_;
  ob::SpaceInformationPtr information_;
};

TEST_F(OmplAdaptors, ServeAUsersPlanner) {
  const auto problem = definition();
  ompl::geometric::RRT planner(information_);
  planner.setProblemDefinition(problem);
  planner.setup();
  int turns = 0;
  planner.solve(ob::PlannerTerminationCondition([&] { return ++turns > 200000; }));
  ASSERT_TRUE(problem->hasExactSolution());
  EXPECT_TRUE(problem->getSolutionPath()->check());
  EXPECT_GT(information_->getMotionValidator()->getCheckedMotionCount(), 0u);
}

TEST_F(OmplAdaptors, ValidityAgreesWithTheCertifierAndClearanceIsABoundedLowerBound) {
  EdgeCertifier certifier(scene_);
  const auto& checker = *information_->getStateValidityChecker();
  EXPECT_EQ(checker.getSpecs().clearanceComputationType,
            ob::StateValidityCheckerSpecs::BOUNDED_APPROXIMATE);
  Random random(5);
  int valid = 0;
  for (int i = 0; i < 500; ++i) {
    const std::vector<double> q = {random.uniform(-2, 2), random.uniform(-2, 2),
                                   random.uniform(-3, 3)};
    const auto s = state(q[0], q[1], q[2]);
    const StateCheck exact = certifier.clearance(q, 1e-9);
    EXPECT_EQ(checker.isValid(s.get()), exact.verdict == Verdict::kFree);
    EXPECT_LE(checker.clearance(s.get()), exact.clearance.upper);
    EXPECT_GE(checker.clearance(s.get()), exact.clearance.lower - 1e-3);
    valid += exact.verdict == Verdict::kFree;
  }
  EXPECT_GT(valid, 50);
  EXPECT_LT(valid, 490);
  EXPECT_FALSE(checker.isValid(state(-2.5, 0, 0).get())) << "outside the limits";
}

TEST_F(OmplAdaptors, LastValidEndsACertifiedEdge) {
  EdgeCertifier certifier(scene_);
  Random random(6);
  int cut = 0;
  for (int i = 0; i < 300; ++i) {
    const auto a = state(random.uniform(-2, -0.2), random.uniform(-2, 0.5), 0);
    const auto b = state(random.uniform(0.2, 2), random.uniform(-2, 0.5), 1);
    if (!information_->isValid(a.get())) continue;
    auto last = state(9, 9, 9);
    std::pair<ob::State*, double> last_valid(last.get(), -7);
    const bool valid =
        information_->getMotionValidator()->checkMotion(a.get(), b.get(), last_valid);
    EXPECT_EQ(valid, information_->checkMotion(a.get(), b.get()));
    if (valid) {
      EXPECT_EQ(last_valid.second, -7) << "a valid motion leaves it alone";
      continue;
    }
    ++cut;
    EXPECT_GE(last_valid.second, 0);
    EXPECT_LT(last_valid.second, 1);
    EXPECT_TRUE(information_->isValid(last.get()));
    EXPECT_TRUE(information_->checkMotion(a.get(), last.get()));
    // Contact begins 0.15 before the wall's middle; the last valid state is near it.
    if (last_valid.second > 0) {
      EXPECT_LT(last->values[0], -0.14);
    }
    EXPECT_GT(last->values[0], -0.5);
  }
  EXPECT_GT(cut, 100);
}

TEST_F(OmplAdaptors, LastValidMayBeOneOfTheEnds) {
  const auto a = state(-1, -1, 0);
  auto b = state(1, -1, 0);
  std::pair<ob::State*, double> last_valid(b.get(), 0);
  EXPECT_FALSE(information_->getMotionValidator()->checkMotion(a.get(), b.get(), last_valid));
  EXPECT_LT(b->values[0], -0.14);
  EXPECT_TRUE(information_->checkMotion(a.get(), b.get()));
}

TEST_F(OmplAdaptors, ClearanceCostsAreCertifiedAlongTheEdge) {
  const OmplClearanceObjective objective(information_, pool_, 1e-3);
  EdgeCertifier certifier(scene_);
  Random random(8);
  int compared = 0;
  for (int i = 0; i < 200; ++i) {
    const std::vector<double> a = {random.uniform(-2, 2), random.uniform(-2, 2), 0};
    const std::vector<double> b = {random.uniform(-2, 2), random.uniform(-2, 2), 2};
    const double cost =
        objective.motionCost(state(a[0], a[1], a[2]).get(), state(b[0], b[1], b[2]).get()).value();
    double least = std::numeric_limits<double>::infinity();
    std::vector<double> q(3);
    for (int k = 0; k <= 200; ++k) {
      scene_->space().interpolate(a, b, k / 200.0, q);
      least = std::min(least, certifier.clearance(q, 1e-9).clearance.upper);
    }
    EXPECT_LE(cost, least);
    if (least < 0) {
      EXPECT_LE(cost, 0);
      continue;
    }
    ++compared;
    EXPECT_GE(cost, least - 1e-3 - 0.02) << "samples 0.02 apart";
  }
  EXPECT_GT(compared, 30);
  const ob::Cost wide(0.5), narrow(0.1);
  EXPECT_TRUE(objective.isCostBetterThan(wide, narrow));
  EXPECT_EQ(objective.combineCosts(wide, narrow).value(), 0.1);
  EXPECT_EQ(objective.combineCosts(objective.identityCost(), narrow).value(), 0.1);
  EXPECT_TRUE(objective.isCostBetterThan(narrow, objective.infiniteCost()));
  EXPECT_FALSE(objective.isSatisfied(wide));
}

TEST_F(OmplAdaptors, ClearanceObjectiveServesAUsersPlanner) {
  const auto problem = definition();
  const auto objective = std::make_shared<OmplClearanceObjective>(information_, pool_);
  problem->setOptimizationObjective(objective);
  ompl::geometric::RRTstar planner(information_);
  planner.setProblemDefinition(problem);
  planner.setup();
  int turns = 0;
  planner.solve(ob::PlannerTerminationCondition([&] { return ++turns > 500; }));
  ASSERT_TRUE(problem->hasExactSolution());
  const double cost = problem->getSolutionPath()->cost(objective).value();
  // Gap 0.6, disc 0.2: clearance is at most 0.2, and nearly 0 on the shortest path.
  EXPECT_GT(cost, 0.05);
  EXPECT_LE(cost, 0.2);
}

}  // namespace
}  // namespace leeway::planner
