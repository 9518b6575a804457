// Results, scenes and certifiers that answer another question than the one asked are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "leeway/planner/ompl_motion_validator.h"
#include "leeway/planner/path_io.h"
#include "leeway/planner/trajectory.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/placed_model.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using std::invalid_argument;

Problem glass() { return loadProblem(leeway::sourceFolder() + "/problems/constrained/glass.yaml"); }

std::shared_ptr<const CompiledScene> sceneOf(const Problem& problem) {
  return std::make_shared<const CompiledScene>(problem);
}

TEST(OtherQuestions, APathOfOneRowIsProvenAsAnyOther) {
  const Problem problem = glass();
  const auto scene = sceneOf(problem);
  std::vector<double> start = startPoint(problem), tilted = start;
  tilted[5] += 1;
  EXPECT_TRUE(proveConstraints(*scene, problem, {{}, {start}, {}}));
  EXPECT_FALSE(proveConstraints(*scene, problem, {{}, {tilted}, {}}));
  EXPECT_FALSE(proveConstraints(*scene, problem, {{}, {}, {}}));
  EXPECT_EQ(brokenConstraint(*scene, problem, start), "");
  EXPECT_NE(brokenConstraint(*scene, problem, tilted), "");
  start.pop_back();
  EXPECT_EQ(brokenConstraint(*scene, problem, start), "the point has 6 numbers; 7 are expected");
  tilted[5] = std::nan("");
  EXPECT_NE(brokenConstraint(*scene, problem, tilted), "");
}

TEST(OtherQuestions, LongAxesOfConstraintsAreRefused) {
  for (const double length : {1e200, 1e7, std::numeric_limits<double>::infinity(), 1e-7}) {
    Problem problem = glass();
    ASSERT_FALSE(problem.constraints.empty());
    problem.constraints[0] = upright(problem.constraints[0].frame, {0, 0, length}, 0.1);
    EXPECT_THROW(validate(problem), robots::InputError) << length;
    problem.constraints[0].axis = {0, 0, 1};
    problem.constraints[0].direction = {0, 0, length};
    EXPECT_THROW(validate(problem), robots::InputError) << length;
  }
}

TEST(OtherQuestions, ConstraintsAreProvenForTheScenesProblemOnly) {
  const Problem problem = glass();
  const auto scene = sceneOf(problem);
  const std::vector<double> start = startPoint(problem);
  Problem other = problem;
  other.robot.model =
      robots::withBasePose(*problem.robot.model, {Eigen::Matrix3d::Identity(), {0, 0, 5}});
  EXPECT_THROW(proveConstraints(*scene, other, {{}, {start}, {}}), robots::InputError);
  EXPECT_THROW(brokenConstraint(*scene, other, start), robots::InputError);
  // An object that a constraint is relative to, and that has moved in the scene.
  Problem relative = problem;
  ASSERT_FALSE(relative.world.objects.empty());
  const Object& object = relative.world.objects.front();
  relative.constraints[0].relative_to = object.name;
  const auto compiled = sceneOf(relative);
  robots::Pose elsewhere = object.X_WO;
  elsewhere.translation.z() += 5;
  const auto now = compiled->withObjectAt(object.name, elsewhere);
  EXPECT_NO_THROW(compiled->requireProblem(relative));
  EXPECT_THROW(now->requireProblem(relative), robots::InputError);
  EXPECT_THROW(plan(now, relative), robots::InputError);
  EXPECT_NO_THROW(now->requireProblem(problem) /* which is relative to the world */);
}

TEST(OtherQuestions, ColumnsAndStepsOfAPathAreThoseOfTheProblem) {
  const Problem problem = test::wallProblem();
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EdgeCertifier certifier(sceneOf(problem));
  EXPECT_TRUE(certify(certifier, result.path, 1e-4).certified);
  Path path = result.path;
  std::reverse(path.names.begin(), path.names.end());
  EXPECT_THROW(certify(certifier, path, 1e-4), invalid_argument);
  path.names = {"a"};
  EXPECT_THROW(certify(certifier, path, 1e-4), invalid_argument);
  path.names.clear();
  EXPECT_TRUE(certify(certifier, path, 1e-4).certified);
  for (const auto& [first, last] : {std::pair(-7, 1), {0, 1 << 30}, {1, 0}}) {
    path.steps = {{"a step", first, last, 0, 0, {}}};
    EXPECT_THROW(edgesOf(certifier.scene().space(), path), invalid_argument);
    EXPECT_THROW(trajectoryOf(problem, path), invalid_argument);
  }
}

TEST(OtherQuestions, FilesSayCertifiedOnlyOfWhatIsInThem) {
  const Folder folder;
  Problem problem = test::wallProblem();
  const PlanResult result = plan(problem);
  ASSERT_TRUE(result.certificate.certified);
  const Trajectory trajectory = trajectoryOf(problem, result.path);
  EXPECT_NO_THROW(writeTrajectory(folder.path("t.json"), problem, result, trajectory));
  const auto space =
      std::make_shared<const ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  std::vector<std::vector<double>> others = result.path.positions;
  others[1][0] += 1e-6;
  const Trajectory other(space, others, motionLimits(problem));
  EXPECT_THROW(writeTrajectory(folder.path("o.json"), problem, result, other), invalid_argument);
  problem.margins.common += 0.05;
  EXPECT_THROW(writePath(folder.path("p.json"), problem, result), invalid_argument);
  EXPECT_THROW(writeTrajectory(folder.path("p.json"), problem, result, trajectory),
               invalid_argument);
  EXPECT_THROW(Trajectory(nullptr, others, motionLimits(problem)), invalid_argument);
  PlanResult bad = result;
  bad.path.positions[1][0] = others[1][0] = std::nan("");
  EXPECT_THROW(Trajectory(space, others, motionLimits(problem)), invalid_argument);
  problem.margins = result.certificate.margins;
  EXPECT_NO_THROW(writePath(folder.path("p.json"), problem, result));
  EXPECT_THROW(writePath(folder.path("p.json"), problem, bad), invalid_argument);
}

// A model is made of its description. What a program changes in it afterwards is prepared again, or
// refused where the model keeps more than the description.
TEST(OtherQuestions, AModelThatChangesIsNotTheOneBefore) {
  Problem problem = test::wallProblem();
  const auto model = std::make_shared<robots::Model>(*problem.robot.model);
  problem.robot.model = model;
  const PlanResult before = plan(problem);
  ASSERT_EQ(before.status, PlanStatus::kSolved);
  const auto scene = sceneOf(problem);
  for (robots::Link& link : model->links)
    for (robots::Geometry& geometry : link.geometries) geometry.X_BG.translation.y() += 0.1;
  const Problem fresh = [&] {
    Problem copy = problem;
    copy.robot.model = std::make_shared<robots::Model>(*model);
    return copy;
  }();
  EXPECT_THROW(plan(scene, problem), robots::InputError);
  const PlanResult after = plan(problem), alone = plan(fresh);
  EXPECT_EQ(after.path.positions, alone.path.positions);
  EXPECT_NE(after.path.positions, before.path.positions);
  EXPECT_EQ(after.certificate.clearance.lower, alone.certificate.clearance.lower);
  model->joints.back().X_PJ.translation.x() += 0.1;
  EXPECT_THROW(plan(problem), robots::InputError);
  EXPECT_THROW(verify(problem, before.path), robots::InputError);
  *model = robots::Model(robots::RobotDescription(*model));
  EXPECT_NO_THROW(plan(problem));
}

TEST(OtherQuestions, AScenePartIsNotTheProblem) {
  const Problem problem = test::wallProblem();
  const auto scene = sceneOf(problem);
  const auto part = scene->withPairs([](const collision::ScenePair&) { return false; });
  EXPECT_THROW(plan(part, problem), robots::InputError);
  EXPECT_EQ(plan(scene, problem).status, PlanStatus::kSolved);
  const auto whole = scene->withPairs([](const collision::ScenePair&) { return true; });
  EXPECT_EQ(plan(whole, problem).status, PlanStatus::kSolved);
}

TEST(OtherQuestions, OmplsCheckersTakeThePoolOfTheirSpace) {
  const Problem problem = test::wallProblem();
  const auto scene = sceneOf(problem);
  const auto pool = std::make_shared<CertifierPool>(scene);
  const auto information = makeSpaceInformation(scene, 1, pool);
  EXPECT_NO_THROW(OmplMotionValidator(information, pool));
  EXPECT_NO_THROW(OmplValidityChecker(information, pool));
  // Another scene of the same space answers for itself.
  const auto again = std::make_shared<CertifierPool>(sceneOf(problem));
  EXPECT_NO_THROW(OmplMotionValidator(information, again));
  Problem narrower = problem;
  robots::JointBounds bounds;
  bounds["disc"]["x"] = {-1.5, 1.5, false, ""};
  narrower.robot.model = robots::withBounds(*problem.robot.model, bounds);
  const auto narrow = std::make_shared<CertifierPool>(sceneOf(narrower));
  EXPECT_THROW(OmplMotionValidator(information, narrow), invalid_argument);
  EXPECT_THROW(OmplValidityChecker(information, narrow), invalid_argument);
  EXPECT_THROW(OmplMotionValidator(information, nullptr), invalid_argument);
  EXPECT_THROW(OmplValidityChecker(information, nullptr), invalid_argument);
}

TEST(OtherQuestions, StartsWithoutAValueAreRefused) {
  Problem problem = test::wallProblem();
  problem.start.clear();
  EXPECT_THROW(startPoint(problem), robots::InputError);
  problem = test::wallProblem();
  problem.robot.variables = {99};
  EXPECT_THROW(startPoint(problem), robots::InputError);
}

}  // namespace
}  // namespace leeway::planner
