#include "leeway/planner/ompl_connect.h"

#include <gtest/gtest.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/util/Console.h>
#include <ompl/util/Exception.h>

#include <memory>
#include <vector>

#include "leeway/planner/ompl_motion_validator.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;

/// An OMPL program that plans the wall's problem with Connect.
class OmplConnectTest : public testing::Test {
 protected:
  OmplConnectTest()
      : scene_(std::make_shared<const CompiledScene>(test::wallProblem())),
        information_(makeSpaceInformation(scene_, 1, std::make_shared<CertifierPool>(scene_))) {
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  }

  ob::ScopedState<OmplStateSpace> state(double x, double y) {
    ob::ScopedState<OmplStateSpace> s(information_);
    s->values[0] = x;
    s->values[1] = y;
    s->values[2] = 0;
    return s;
  }

  ob::ProblemDefinitionPtr definition() {
    auto definition = std::make_shared<ob::ProblemDefinition>(information_);
    definition->setStartAndGoalStates(state(-1, -1), state(1, -1));
    return definition;
  }

  static ob::PlannerTerminationCondition looks(int most) {
    auto left = std::make_shared<int>(most);
    return ob::PlannerTerminationCondition([left] { return --*left < 0; });
  }

  std::vector<double> valuesOf(const ob::ProblemDefinition& definition) {
    std::vector<double> values;
    auto* path = definition.getSolutionPath()->as<ompl::geometric::PathGeometric>();
    for (const ob::State* s : path->getStates()) {
      std::vector<double> point;
      information_->getStateSpace()->copyToReals(point, s);
      values.insert(values.end(), point.begin(), point.end());
    }
    return values;
  }

  std::shared_ptr<const CompiledScene> scene_;
  ob::SpaceInformationPtr information_;
};

TEST_F(OmplConnectTest, PlansACertifiedPathFromStartToGoal) {
  const auto problem = definition();
  OmplConnect planner(information_);
  planner.setProblemDefinition(problem);
  planner.setup();
  ASSERT_EQ(planner.solve(looks(200000)), ob::PlannerStatus::EXACT_SOLUTION);
  auto* path = problem->getSolutionPath()->as<ompl::geometric::PathGeometric>();
  EXPECT_TRUE(problem->getSolutionPath()->check());
  EXPECT_EQ(information_->distance(path->getStates().front(), state(-1, -1).get()), 0);
  EXPECT_EQ(information_->distance(path->getStates().back(), state(1, -1).get()), 0);
  EXPECT_GT(path->length(), 3);  // through the gap
}

TEST_F(OmplConnectTest, RepeatsItselfAfterClear) {
  OmplConnect planner(information_);
  std::vector<double> first;
  for (int run = 0; run < 2; ++run) {
    const auto problem = definition();
    planner.clear();
    planner.setProblemDefinition(problem);
    ASSERT_EQ(planner.solve(looks(200000)), ob::PlannerStatus::EXACT_SOLUTION);
    if (run == 0)
      first = valuesOf(*problem);
    else
      EXPECT_EQ(valuesOf(*problem), first);
  }
}

TEST_F(OmplConnectTest, TakesParametersByName) {
  OmplConnect planner(information_);
  EXPECT_TRUE(planner.params().setParam("range", "0.5"));
  EXPECT_TRUE(planner.params().setParam("balance", "0"));
  EXPECT_TRUE(planner.params().setParam("dynamic_domain", "0"));
  EXPECT_TRUE(planner.getLowDiscrepancy());
  EXPECT_TRUE(planner.params().setParam("low_discrepancy", "0"));
  EXPECT_EQ(planner.getRange(), 0.5);
  EXPECT_FALSE(planner.getBalance());
  EXPECT_FALSE(planner.getDynamicDomain());
  EXPECT_FALSE(planner.getLowDiscrepancy());
  const auto problem = definition();
  planner.setProblemDefinition(problem);
  ASSERT_EQ(planner.solve(looks(200000)), ob::PlannerStatus::EXACT_SOLUTION);
  auto* path = problem->getSolutionPath()->as<ompl::geometric::PathGeometric>();
  for (std::size_t i = 1; i < path->getStateCount(); ++i)
    EXPECT_LE(information_->distance(path->getState(static_cast<unsigned>(i - 1)),
                                     path->getState(static_cast<unsigned>(i))),
              0.5 + 1e-9);
}

TEST_F(OmplConnectTest, StopsWhenAsked) {
  OmplConnect planner(information_);
  planner.setProblemDefinition(definition());
  EXPECT_EQ(planner.solve(looks(0)), ob::PlannerStatus::TIMEOUT);
}

TEST_F(OmplConnectTest, RefusesAProblemWithoutAStart) {
  const auto problem = std::make_shared<ob::ProblemDefinition>(information_);
  OmplConnect planner(information_);
  problem->setGoalState(state(1, -1));
  planner.setProblemDefinition(problem);
  EXPECT_THROW(planner.solve(looks(100)), ompl::Exception);
}

TEST(OmplConnect, RefusesOtherSpaces) {
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  auto space = std::make_shared<ob::RealVectorStateSpace>(2);
  space->setBounds(0, 1);
  const auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker([](const ob::State*) { return true; });
  information->setup();
  OmplConnect planner(information);
  EXPECT_THROW(planner.setup(), ompl::Exception);
}

}  // namespace
}  // namespace leeway::planner
