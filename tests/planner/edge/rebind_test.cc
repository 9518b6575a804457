// A certifier rebound to another instant answers like a new one.
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/input_error.h"
#include "planner/base/random.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using collision::Deformable;
using collision::DeformableMesh;
using collision::Shape;

/// A disc, a post, and a deforming square, plus objects where the disc never is.
struct DiscWorld {
  explicit DiscWorld(std::size_t far = 0)
      : problem(test::problemOf(test::disc(), {-1.5, 0, 0}, {1.5, 0, 0})) {
    const std::vector<Eigen::Vector3d> rest = {
        {-0.3, 0, -0.3}, {0.3, 0, -0.3}, {0.3, 0, 0.3}, {-0.3, 0, 0.3}};
    mesh = DeformableMesh::make(rest, std::vector<DeformableMesh::Triangle>{{0, 1, 2}, {0, 2, 3}});
    problem.world.objects.push_back(test::box("post", {0.1, 0.1, 0.5}, 0, 1, 0));
    for (std::size_t i = 0; i < far; ++i)
      problem.world.objects.push_back(
          test::box("far " + std::to_string(i), {0.1, 0.1, 0.1}, 50, 0.5 * double(i), 0));
    problem.world.deforming.push_back(makeDeformingObstacle("square", mesh, nullptr, {}));
    problem.margins.common = 0.01;
    scene = std::make_shared<const CompiledScene>(problem);
    body = scene->scene().find("square");
  }
  Shape pulled(Random& random) const {
    std::vector<Eigen::Vector3d> vertices(mesh->rest().begin(), mesh->rest().end());
    const Eigen::Vector3d by(random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2), 0);
    for (Eigen::Vector3d& v : vertices)
      v += by + 0.2 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0);
    Deformable deformable(mesh);
    EXPECT_EQ(deformable.update(vertices, 1), collision::UpdateStatus::kUpdated);
    return Shape::deformable(deformable.snapshot());
  }

  Problem problem;
  std::shared_ptr<const DeformableMesh> mesh;
  std::shared_ptr<const CompiledScene> scene;
  int body = -1;
};

TEST(CompiledScene, RefusesDeformingObstaclesThatAreNotTheirOwnOrNotOfTheStart) {
  const DiscWorld world;
  for (const char* name : {"post", "square", "disc"}) {
    Problem twice = world.problem;
    twice.world.deforming.push_back(makeDeformingObstacle(name, world.mesh, nullptr, {}));
    EXPECT_THROW(CompiledScene{twice}, robots::InputError) << name;
  }
  Problem late = world.problem;
  late.execution.start = 1;
  EXPECT_THROW(CompiledScene{late}, robots::InputError);
  Problem raw = world.problem;
  raw.world.deforming.push_back({{"another", {}, {}}, world.mesh, nullptr, 1, {}});
  EXPECT_THROW(CompiledScene{raw}, robots::InputError);
  Problem more = world.problem;
  more.world.deforming.push_back(makeDeformingObstacle("another", world.mesh, nullptr, {}));
  EXPECT_NO_THROW(CompiledScene{more});
}

TEST(Rebind, AnswersAsANewCertifier) {
  const DiscWorld world;
  Random random(5);
  EdgeCertifier rebound(world.scene);
  int free = 0, not_free = 0;
  for (int k = 0; k < 60; ++k) {
    const std::vector<CompiledScene::Replacement> shapes = {
        {world.body, 0, world.pulled(random), k % 3 == 0 ? 0.05 : 0.0}};
    const auto scene = world.scene->withShapes(shapes);
    rebound.rebind(scene);
    EdgeCertifier fresh(scene);
    for (int i = 0; i < 20; ++i) {
      std::vector<double> a(3), b(3);
      for (std::vector<double>* q : {&a, &b})
        *q = {random.uniform(-1.9, 1.9), random.uniform(-1.9, 1.9), random.uniform(-3, 3)};
      const Verdict x = rebound.certify(a, b).verdict, y = fresh.certify(a, b).verdict;
      EXPECT_EQ(x, y) << k << " " << i;
      EXPECT_EQ(rebound.decide(a), fresh.decide(a)) << k << " " << i;
      free += x == Verdict::kFree;
      not_free += x == Verdict::kNotFree;
    }
  }
  EXPECT_GT(free, 200);
  EXPECT_GT(not_free, 200);
}

TEST(Rebind, GrowthIsKeptBesidesTheMargin) {
  const DiscWorld world;
  Deformable deformable(world.mesh);
  const std::vector<double> q = {0, -0.2, 0};  // the disc's rim is 0.1 from the square
  const auto verdict = [&](double growth) {
    const std::vector<CompiledScene::Replacement> shapes = {
        {world.body, 0, Shape::deformable(deformable.snapshot()), growth}};
    return EdgeCertifier(world.scene->withShapes(shapes)).decide(q);
  };
  EXPECT_EQ(verdict(0), Verdict::kFree);
  EXPECT_EQ(verdict(0.089), Verdict::kFree);
  EXPECT_EQ(verdict(0.091), Verdict::kNotFree);
  EXPECT_NE(verdict(std::numeric_limits<double>::infinity()), Verdict::kFree);
  EXPECT_NE(verdict(std::numeric_limits<double>::quiet_NaN()), Verdict::kFree);
  // The same holds far away, and along an edge.
  const std::vector<CompiledScene::Replacement> shapes = {
      {world.body, 0, Shape::deformable(deformable.snapshot()),
       std::numeric_limits<double>::quiet_NaN()}};
  EdgeCertifier certifier(world.scene->withShapes(shapes));
  const std::vector<double> far = {1.8, -1.8, 0};
  EXPECT_NE(certifier.decide(far), Verdict::kFree);
  EXPECT_NE(certifier.certify(far, far).verdict, Verdict::kFree);
}

TEST(Rebind, PairsCanBeAskedApart) {
  const DiscWorld world;
  const auto with = [&](bool square) {
    return world.scene->withPairs([&, square](const collision::ScenePair& pair) {
      return (pair.body_a == world.body || pair.body_b == world.body) == square;
    });
  };
  EXPECT_EQ(with(true)->scene().pairs().size() + with(false)->scene().pairs().size(),
            world.scene->scene().pairs().size());
  const std::vector<double> at_post = {0, 1, 0}, at_square = {0, 0, 0};
  EXPECT_EQ(EdgeCertifier(with(true)).decide(at_post), Verdict::kFree);
  EXPECT_EQ(EdgeCertifier(with(true)).decide(at_square), Verdict::kNotFree);
  EXPECT_EQ(EdgeCertifier(with(false)).decide(at_post), Verdict::kNotFree);
  EXPECT_EQ(EdgeCertifier(with(false)).decide(at_square), Verdict::kFree);
}

// Many objects, whose boxes are a tree, change nothing.
TEST(Rebind, ManyThingsChangeNothing) {
  const DiscWorld few, many(1024);
  Random random(6), same(6);
  EdgeCertifier alone(few.scene), among(many.scene);
  int free = 0, not_free = 0;
  for (int k = 0; k < 20; ++k) {
    const double growth = k % 3 == 0 ? 0.05 : 0.0;
    const std::vector<CompiledScene::Replacement> x = {{few.body, 0, few.pulled(random), growth}};
    const std::vector<CompiledScene::Replacement> y = {{many.body, 0, many.pulled(same), growth}};
    alone.rebind(few.scene->withShapes(x));
    among.rebind(many.scene->withShapes(y));
    EdgeCertifier fresh(many.scene->withShapes(y));
    for (int i = 0; i < 20; ++i) {
      std::vector<double> a(3), b(3);
      for (std::vector<double>* q : {&a, &b})
        *q = {random.uniform(-1.9, 1.9), random.uniform(-1.9, 1.9), random.uniform(-3, 3)};
      for (int n = 0; n < 6; ++n) same.uniform(0, 1);
      const Verdict verdict = alone.certify(a, b).verdict;
      EXPECT_EQ(among.certify(a, b).verdict, verdict) << k << " " << i;
      EXPECT_EQ(fresh.certify(a, b).verdict, verdict) << k << " " << i;
      const Verdict state = alone.decide(a);
      EXPECT_EQ(among.decide(a), state) << k << " " << i;
      EXPECT_EQ(fresh.decide(a), state) << k << " " << i;
      free += verdict == Verdict::kFree;
      not_free += verdict == Verdict::kNotFree;
    }
  }
  EXPECT_GT(free, 60);
  EXPECT_GT(not_free, 60);
}

}  // namespace
}  // namespace leeway::planner
