#include "planner/compiled/prepared_robot.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/input_error.h"
#include "planner/compiled/edge_model.h"
#include "planner/edge/edge_frames.h"
#include "tests/support/random_problem.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using testing::Random;

std::shared_ptr<const PreparedRobot> preparedOf(const Problem& problem) {
  return CompiledScene(problem).edgeModel().robot;
}

/// Arms and trees among shapes and a mesh; some carry a mesh.
Problem randomWorld(Random& random, int run) {
  const auto robot =
      run % 2 == 0 ? testing::randomArm(random) : testing::randomTreeWithShapes(random);
  const auto model = std::make_shared<robots::Model>(*robot);
  if (run % 4 < 2)
    model->links.back().geometries.push_back(
        {testing::randomMesh(random, 0.1), random.pose(0.05), "mesh"});
  Problem problem = testing::randomProblem(random, model, 6, 0.8);
  problem.world.objects.push_back(
      {"rock", {{testing::randomMesh(random, 0.2), {}, "rock"}}, random.pose(0.8)});
  return problem;
}

std::vector<double> randomPoint(Random& random, const Problem& problem) {
  return robots::testing::randomConfiguration(random, *problem.robot.model);
}

// Regression: a planned joint that its limits lock was placed by the start of the first problem for
// all later problems, although that start is refused.
TEST(PreparedRobot, ALockedJointStandsAtItsLimits) {
  const auto makeArm = [] {
    auto robot = robots::testing::chain(
        4, robots::JointType::kRevolute, 2, [](int i, robots::Link& link, robots::Joint& joint) {
          link.geometries.push_back({collision::Shape::sphere(0.1), {}, link.name});
          joint.axis = Eigen::Vector3d::UnitZ();
          if (i > 0) joint.X_PJ.translation = {0.5, 0, 0};
        });
    robot.variables[0].lower = robot.variables[0].upper = 0;
    robot.has_srdf = true;
    return std::make_shared<robots::Model>(std::move(robot));
  };
  const auto problemOf = [](const std::shared_ptr<const robots::Model>& model) {
    Problem problem = test::problemOf(model, {0, 0, 0}, {0, 1, 1});
    problem.world.objects.push_back(test::box("wall", {0.2, 0.2, 0.2}, 1, 0, 0));
    return problem;
  };
  const auto warm = makeArm(), cold = makeArm();
  Problem outside = problemOf(warm);
  outside.start[0] = 1.57;
  EXPECT_THROW(CompiledScene{outside}, robots::InputError);
  EdgeCertifier after(std::make_shared<const CompiledScene>(problemOf(warm)));
  EdgeCertifier alone(std::make_shared<const CompiledScene>(problemOf(cold)));
  int hits = 0;
  for (double x = -2; x <= 2; x += 0.25)
    for (double y = -2; y <= 2; y += 0.25) {
      const std::vector<double> q{0, x, y};
      const Verdict verdict = alone.decide(q);
      EXPECT_EQ(after.decide(q), verdict) << x << " " << y;
      hits += verdict == Verdict::kNotFree ? 1 : 0;
    }
  EXPECT_GT(hits, 10);
}

TEST(PreparedRobot, IsSharedByAllThatDoesNotConcernIt) {
  const auto model = test::disc();
  Problem problem = test::problemOf(model, {-1, -1, 0}, {1, -1, 0});
  const std::shared_ptr<const PreparedRobot> robot = preparedOf(problem);
  problem.world.objects.push_back(test::box("post", {0.1, 0.1, 0.5}, 0, 0, 0));
  problem.start[0] = 0.5;  // planned
  problem.seed = 9;
  problem.margins.common = -0.01;
  EXPECT_EQ(preparedOf(problem), robot);
  Problem with_contact = problem;
  with_contact.contacts.allowed.emplace_back("disc", "post");
  EXPECT_NE(preparedOf(with_contact), robot);
  Problem turned = problem;
  turned.robot.variables.pop_back();
  turned.goals[0].ranges.pop_back();
  const std::shared_ptr<const PreparedRobot> at_zero = preparedOf(turned);
  EXPECT_NE(at_zero, robot);
  turned.start[2] = 0.1;  // not planned
  EXPECT_NE(preparedOf(turned), at_zero);
  Problem holding = problem;
  holding.robot.attachments.push_back({test::box("cup", {0.05, 0.05, 0.05}, 0, 0, 0), 0, {}, {}});
  const std::shared_ptr<const PreparedRobot> with_cup = preparedOf(holding);
  EXPECT_NE(with_cup, robot);
  EXPECT_EQ(preparedOf(holding), with_cup);
  holding.robot.attachments[0].X_LO.translation.x() = 0.2;
  EXPECT_NE(preparedOf(holding), with_cup);
  EXPECT_EQ(preparedOf(problem), robot);
}

TEST(PreparedRobot, GoesWithItsModel) {
  auto model = test::disc();
  Problem problem = test::problemOf(model, {-1, -1, 0}, {1, -1, 0});
  std::weak_ptr<const PreparedRobot> robot = preparedOf(problem);
  EXPECT_FALSE(robot.expired());
  problem.robot.model.reset();
  model.reset();
  EXPECT_TRUE(robot.expired());
}

/// A problem compiled after others of its robot equals one that is compiled alone: pairs, reasons
/// and answers.
TEST(PreparedRobot, ChangesNoAnswer) {
  Random random(21);
  int free = 0, not_free = 0;
  for (int run = 0; run < 30; ++run) {
    Problem problem = randomWorld(random, run);
    preparedOf(problem);
    problem.world.objects.pop_back();
    if (run % 3 == 0)
      problem.contacts.allowed.emplace_back("object0", problem.robot.model->links[1].name);
    if (run % 5 == 0) problem.margins.pairs.push_back({"object1", "object2", 0.02});
    problem.start = randomPoint(random, problem);
    const std::shared_ptr<const PreparedRobot> before = preparedOf(problem);
    problem.world.objects.push_back(
        {"stone", {{testing::randomMesh(random, 0.2), {}, "stone"}}, random.pose(0.8)});
    Problem alone = problem;
    alone.robot.model = std::make_shared<const robots::Model>(*problem.robot.model);
    const auto scene = std::make_shared<const CompiledScene>(problem);
    const auto expected = std::make_shared<const CompiledScene>(alone);
    ASSERT_EQ(scene->edgeModel().robot, before);
    ASSERT_NE(expected->edgeModel().robot, before);
    ASSERT_EQ(scene->scene().pairs().size(), expected->scene().pairs().size());
    ASSERT_EQ(scene->dropped().size(), expected->dropped().size());
    for (std::size_t d = 0; d < scene->dropped().size(); ++d) {
      EXPECT_EQ(scene->dropped()[d].a, expected->dropped()[d].a);
      EXPECT_EQ(scene->dropped()[d].b, expected->dropped()[d].b);
      EXPECT_EQ(scene->dropped()[d].reason, expected->dropped()[d].reason);
    }
    for (std::size_t b = 0; b < scene->scene().bodies().size(); ++b)
      EXPECT_EQ(scene->scene().bodies()[b].X_WB.translation,
                expected->scene().bodies()[b].X_WB.translation);
    const EdgeFrames frames(scene, 1), expected_frames(expected, 1);
    for (std::size_t p = 0; p < frames.pairs().numbers(); ++p) {
      const EdgePair &x = frames.pairs()[p], &y = expected_frames.pairs()[p];
      EXPECT_EQ(x.scene_pair, y.scene_pair);
      EXPECT_EQ(x.a, y.a);
      EXPECT_EQ(x.b, y.b);
      EXPECT_EQ(x.motion, y.motion);
      EXPECT_EQ(x.threshold, y.threshold);
      EXPECT_EQ(x.gap, y.gap);
    }
    EdgeCertifier certifier(scene), twin(expected);
    std::vector<double> b(static_cast<std::size_t>(scene->space().size()));
    for (int i = 0; i < 40; ++i) {
      const std::vector<double> a = randomPoint(random, problem);
      scene->space().interpolate(a, randomPoint(random, problem), random.uniform(0, 0.3), b);
      const EdgeCheck check = certifier.certify(a, b), same = twin.certify(a, b);
      ASSERT_EQ(check.verdict, same.verdict) << "run " << run << ", edge " << i;
      ASSERT_EQ(check.pair, same.pair);
      ASSERT_EQ(check.t, same.t);
      ++(check.verdict == Verdict::kFree ? free : not_free);
    }
  }
  EXPECT_GT(free, 100);
  EXPECT_GT(not_free, 100);
}

/// Threads compile the same problem, or make certifiers of one scene.
TEST(PreparedRobot, ThreadsPrepareAndShareIt) {
  Random random(22);
  const Problem problem = randomWorld(random, 0);
  std::vector<std::vector<double>> points;
  for (int i = 0; i < 20; ++i) points.push_back(randomPoint(random, problem));
  const auto shared = std::make_shared<const CompiledScene>(problem);
  std::vector<std::vector<Verdict>> verdicts(4);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < verdicts.size(); ++t)
    threads.emplace_back([&, t] {
      EdgeCertifier certifier(t < 2 ? shared : std::make_shared<const CompiledScene>(problem));
      for (std::size_t i = 1; i < points.size(); ++i)
        verdicts[t].push_back(certifier.certify(points[i - 1], points[i]).verdict);
    });
  for (std::thread& thread : threads) thread.join();
  for (const auto& of_thread : verdicts) EXPECT_EQ(of_thread, verdicts[0]);
}

/// The shared data of a scene's certifiers refers to the scene: a copy has its own, and a moved
/// scene gets new data.
TEST(PreparedRobot, CopiesOfAScenePassForItAndOutliveIt) {
  Random random(23);
  const Problem problem = randomWorld(random, 2);
  std::vector<std::vector<double>> points;
  for (int i = 0; i < 20; ++i) points.push_back(randomPoint(random, problem));
  const auto verdictsOf = [&](const std::shared_ptr<const CompiledScene>& scene) {
    EdgeCertifier certifier(scene);
    std::vector<Verdict> verdicts;
    for (std::size_t i = 1; i < points.size(); ++i)
      verdicts.push_back(certifier.certify(points[i - 1], points[i]).verdict);
    return verdicts;
  };
  auto scene = std::make_shared<CompiledScene>(problem);
  const std::vector<Verdict> verdicts = verdictsOf(scene);
  const auto copy = std::make_shared<const CompiledScene>(*scene);
  EXPECT_NE(&copy->edges(), &scene->edges());
  const EdgeScene* const edges = &scene->edges();
  const auto moved = std::make_shared<const CompiledScene>(std::move(*scene));
  EXPECT_NE(&moved->edges(), edges);  // the old data refer to the scene's old address
  scene.reset();
  EXPECT_EQ(verdictsOf(copy), verdicts);
  EXPECT_EQ(verdictsOf(moved), verdicts);
}

}  // namespace
}  // namespace leeway::planner
