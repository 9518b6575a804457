// Balls of bodies against spheres as geometries, and against all balls one by one.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "collision/scene/scene_access.h"
#include "leeway/collision/scene.h"
#include "tests/support/allocations.h"
#include "tests/support/from_environment.h"
#include "tests/support/sanitized.h"
#include "tests/support/scene_twins.h"

namespace leeway::collision {
namespace {

using testing::Draw;
using Balls = std::vector<Ball>;

/// Balls on a wavy surface, some in one place, some of other sizes.
Balls randomBalls(Draw& draw, int count) {
  Balls balls;
  for (int i = 0; i < count; ++i) {
    const double x = draw.uniform(-0.5, 0.5), y = draw.uniform(-0.5, 0.5);
    balls.push_back({{x, y, 0.1 * std::sin(5 * x)}, draw.uniform(0.01, 0.02)});
    if (i % 10 == 1) balls.back() = balls[balls.size() - 2];
  }
  return balls;
}

Body bodyOfBalls(const std::string& name, const Balls& balls, const Pose& X_WB, bool as_spheres) {
  Body body{name, {}, false, X_WB};
  if (!as_spheres) {
    body.balls = std::make_shared<const Balls>(balls);
    return body;
  }
  for (const Ball& ball : balls)
    body.geometries.push_back(
        {Shape::sphere(ball.radius), {Eigen::Matrix3d::Identity(), ball.center}, ""});
  return body;
}

/// A capsule and a sphere that moves, as one body.
Body mover() {
  Body body{"mover", {}, true, {}};
  body.geometries.push_back({Shape::capsule(0.05, 0.15), {}, ""});
  body.geometries.push_back(
      {Shape::sphere(0.08), {Eigen::Matrix3d::Identity(), {0.1, 0.1, 0.2}}, ""});
  return body;
}

double signedDistance(const Eigen::Vector3d& p, const Pose& X_WB) {
  const Eigen::Vector3d in_body = X_WB.rotation.transpose() * (p - X_WB.translation);
  const Eigen::Vector3d on_axis(0, 0, std::clamp(in_body.z(), -0.15, 0.15));
  return std::min((in_body - on_axis).norm() - 0.05,
                  (in_body - Eigen::Vector3d(0.1, 0.1, 0.2)).norm() - 0.08);
}

double least(const Balls& balls, const Pose& X_WC, const Pose& X_WB) {
  double least = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls)
    least = std::min(least, signedDistance(X_WC * ball.center, X_WB) - ball.radius);
  return least;
}

/// LEEWAY_TEST_QUERIES sets the number of queries, and LEEWAY_TEST_SEED selects other ones.
TEST(SceneBalls, NoAnswerIsOutsideOfTheDistanceOfAllBalls) {
  Draw draw(static_cast<unsigned>(fromEnvironment("LEEWAY_TEST_SEED", 1)));
  const auto queries = static_cast<int>(
      fromEnvironment("LEEWAY_TEST_QUERIES", static_cast<std::uint64_t>(casesToAsk(100'000))));
  const double tolerance = 1e-6, rounding = 1e-12;
  int asked = 0, free = 0, not_free = 0, wrong = 0;
  for (const int count : {1, 40, 300, 1500}) {
    const Balls balls = randomBalls(draw, count);
    const Pose X_WC = draw.pose(0.3);
    SceneBuilder builder;
    builder.add(mover());
    builder.add(bodyOfBalls("cloud", balls, X_WC, false));
    builder.setDefaultMargin(0.01);
    const Scene scene = builder.build();
    ASSERT_EQ(scene.pairs().size(), 2 * balls.size());
    Workspace workspace(scene);
    for (int i = 0; i < queries / 4; ++i) {
      const auto expect = [&](bool holds) {
        if (holds) return;
        ++wrong;
        ADD_FAILURE() << count << " balls, query " << i;
      };
      const Pose X_WB = draw.pose(0.7);
      workspace.setPose(0, X_WB);
      const double truth = least(balls, X_WC, X_WB);
      if (i % 10 == 0) {
        const Interval clearance = collision::clearance(scene, workspace, tolerance).clearance;
        expect(clearance.lower <= truth + rounding && clearance.upper >= truth - rounding);
        expect(clearance.width() <= 2 * tolerance);
      }
      const Verdict verdict = decide(scene, workspace).verdict;
      free += verdict == Verdict::kFree;
      not_free += verdict == Verdict::kNotFree;
      ++asked;
      expect(verdict == Verdict::kFree      ? truth > 0.01 - rounding
             : verdict == Verdict::kNotFree ? truth <= 0.01 + rounding
                                            : std::abs(truth - 0.01) <= 1e-9);
    }
  }
  std::printf("%d queries of clouds: %d free, %d not, %d wrong\n", asked, free, not_free, wrong);
  EXPECT_GT(free, asked / 100);
  EXPECT_GT(not_free, asked / 200);
}

/// Both forms of a world: bodies of balls among others, the balls in front of the moving body
/// (where their pairs are listed) or behind it.
Scene worldOfBalls(unsigned seed, bool as_spheres, bool in_front) {
  Draw draw(seed);
  SceneBuilder builder;
  const auto addCloud = [&] {
    Body cloud = bodyOfBalls("cloud", randomBalls(draw, 90), draw.pose(0.3), as_spheres);
    const Geometry box{Shape::box({0.1, 0.1, 0.1}), draw.pose(0.3), ""};
    cloud.geometries.insert(cloud.geometries.begin(), box);
    builder.add(std::move(cloud));
  };
  if (in_front) addCloud();
  builder.add(mover());
  builder.add(Body{
      "floor", {{Shape::halfSpace(), {}, ""}}, false, {Eigen::Matrix3d::Identity(), {0, 0, -0.9}}});
  if (!in_front) addCloud();
  builder.setDefaultMargin(0.01);
  builder.setMargin(in_front ? 0 : 2, in_front ? 1 : 0, 0.03);
  return builder.build();
}

void expectTheSame(const Scene& balls, const Scene& spheres, Draw& draw, int mover) {
  ASSERT_EQ(balls.pairs().size(), spheres.pairs().size());
  for (auto pair = balls.pairs().begin(); pair != balls.pairs().end(); ++pair) {
    const ScenePair b = *pair, s = spheres.pairs()[pair.number()];
    ASSERT_EQ(b.body_b, s.body_b);
    ASSERT_EQ(b.geometry_b, s.geometry_b);
    ASSERT_EQ(b.margin, s.margin);
  }
  Workspace of_balls(balls), of_spheres(spheres);
  for (int i = 0; i < 200; ++i) {
    const Pose X_WB = draw.pose(0.9);
    of_balls.setPose(mover, X_WB);
    of_spheres.setPose(mover, X_WB);
    const SceneResult b = clearance(balls, of_balls, 1e-6),
                      s = clearance(spheres, of_spheres, 1e-6);
    EXPECT_EQ(b.verdict, s.verdict);
    EXPECT_EQ(b.pair, s.pair);
    EXPECT_NEAR(b.clearance.lower, s.clearance.lower, 1e-12);
    EXPECT_NEAR(b.clearance.upper, s.clearance.upper, 1e-12);
    EXPECT_EQ(decide(balls, of_balls).verdict, decide(spheres, of_spheres).verdict);
  }
}

TEST(SceneBalls, AnswersAreThoseOfSpheres) {
  Draw draw(2);
  for (unsigned seed = 0; seed < 6; ++seed)
    for (const bool in_front : {false, true})
      expectTheSame(worldOfBalls(seed, false, in_front), worldOfBalls(seed, true, in_front), draw,
                    in_front ? 1 : 0);
}

TEST(SceneBalls, ChangesAddMoveAndRemoveThem) {
  Draw draw(3);
  const Balls first = randomBalls(draw, 80), second = randomBalls(draw, 80),
              third = randomBalls(draw, 30);
  const Pose X_1 = draw.pose(0.3), X_2 = draw.pose(0.3), X_3 = draw.pose(0.3), X_4 = draw.pose(0.3);
  const auto made = [&](bool as_spheres) {
    SceneBuilder builder;
    builder.add(mover());
    builder.add(bodyOfBalls("a", first, X_1, as_spheres));
    builder.add(bodyOfBalls("b", third, X_2, as_spheres));
    SceneChange change(builder.build());
    change.remove(1);
    change.setDefaultMargin(0.02);
    const int added = change.add(bodyOfBalls("c", second, X_3, as_spheres));
    change.setMargin(0, added, 0.01);
    SceneChange again(std::move(change).build());
    again.remove(added);
    // Its number is used again by one with as many balls.
    EXPECT_EQ(again.add(bodyOfBalls("d", first, X_4, as_spheres)), added);
    EXPECT_NE(again.add(bodyOfBalls("e", third, X_1, as_spheres)), added);
    Scene scene = std::move(again).build();
    const std::pair<int, Pose> moved[] = {{added, X_2}};
    scene.setPoses(moved);
    EXPECT_EQ(scene.find("a"), -1);
    return scene;
  };
  const Scene balls = made(false);
  expectTheSame(balls, made(true), draw, 0);
  // The change against a scene that is built at once.
  SceneBuilder builder;
  builder.add(mover());
  builder.add(bodyOfBalls("b", third, X_2, false));
  builder.add(bodyOfBalls("d", first, X_2, false));
  builder.add(bodyOfBalls("e", third, X_1, false));
  const Scene at_once = builder.build();
  Workspace changed(balls), fresh(at_once);
  for (int i = 0; i < 200; ++i) {
    const Pose X_WB = draw.pose(0.9);
    changed.setPose(0, X_WB);
    fresh.setPose(0, X_WB);
    EXPECT_NEAR(clearance(balls, changed, 1e-6).clearance.upper,
                clearance(at_once, fresh, 1e-6).clearance.upper, 2e-6);
  }
}

/// Balls that are removed, in a body that is listed or has places, again and again.
TEST(SceneBalls, BallsWithoutPairsAreAsIfTheyWereNotThere) {
  Draw draw(5);
  for (const bool in_front : {false, true}) {
    const Scene whole = worldOfBalls(5, false, in_front);
    const int cloud = in_front ? 0 : 2, mover = in_front ? 1 : 0;
    std::vector<char> is_gone(90, 0);
    Scene scene = whole;
    for (int round = 0; round < 3; ++round) {
      std::vector<std::int32_t> gone;
      for (std::int32_t b = 0; b < 90; ++b)
        if (draw.uniform(0, 1) < 0.3) gone.push_back(b);
      for (const std::int32_t b : gone) is_gone[static_cast<std::size_t>(b)] = 1;
      SceneChange change(std::move(scene));
      change.removeBalls(cloud, gone);
      scene = std::move(change).build();
    }
    // The same geometries in a scene that only keeps the other pairs.
    Scene kept = whole;
    SceneAccess::keepPairs(kept, [&](const ScenePair& pair) {
      return pair.body_b != cloud || pair.geometry_b == 0 ||
             is_gone[static_cast<std::size_t>(pair.geometry_b - 1)] == 0;
    });
    ASSERT_EQ(scene.pairs().size(), kept.pairs().size());
    ASSERT_LT(scene.pairs().size(), whole.pairs().size());
    Workspace of_scene(scene), of_kept(kept);
    for (int i = 0; i < 200; ++i) {
      const Pose X_WB = draw.pose(0.9);
      of_scene.setPose(mover, X_WB);
      of_kept.setPose(mover, X_WB);
      EXPECT_EQ(decide(scene, of_scene).verdict, decide(kept, of_kept).verdict);
      EXPECT_NEAR(clearance(scene, of_scene, 1e-6).clearance.upper,
                  clearance(kept, of_kept, 1e-6).clearance.upper, 2e-6);
    }
    SceneChange change(std::move(scene));
    for (const std::int32_t wrong : {-1, 90})
      EXPECT_THROW(change.removeBalls(cloud, {&wrong, 1}), std::invalid_argument);
    const std::int32_t first = 0;
    EXPECT_THROW(change.removeBalls(mover, {&first, 1}), std::invalid_argument);
  }
}

TEST(SceneBalls, QueriesDoNotAllocate) {
  const Scene scene = worldOfBalls(4, false, false);
  Workspace workspace(scene);
  Draw draw(4);
  for (int i = 0; i < 50; ++i) {
    workspace.setPose(0, draw.pose(0.9));
    const std::size_t before = testing::allocationCount();
    decide(scene, workspace);
    clearance(scene, workspace, 1e-6);
    EXPECT_EQ(testing::allocationCount(), before);
  }
}

TEST(SceneBalls, RefusesThoseThatNoQueryAnswersFor) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refusal = [](const Balls& balls, bool moving) {
    Body body = bodyOfBalls("scan", balls, {}, false);
    body.moving = moving;
    SceneBuilder builder;
    builder.add(mover());
    builder.add(body);
    try {
      builder.build();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const Ball good{{0, 0, 0}, 0.1};
  EXPECT_EQ(refusal({good, good}, false), "");
  EXPECT_EQ(refusal({}, true), "");
  EXPECT_EQ(refusal({good}, true),
            "scene: ball 0 of 'scan' moves; balls of a fixed body are expected");
  EXPECT_EQ(refusal({good, {{0, nan, 0}, 0.1}}, false),
            "scene: ball 1 of 'scan' has a centre that is not finite");
  for (const double radius : {nan, -0.1, 1e10, 1e-12})
    EXPECT_NE(refusal({good, good, {{0, 0, 0}, radius}}, false).find("ball 2 of 'scan'"),
              std::string::npos)
        << radius;
  SceneBuilder builder;
  builder.add(mover());
  SceneChange change(builder.build());
  EXPECT_THROW(change.add(bodyOfBalls("scan", {{{0, 0, 0}, nan}}, {}, false)),
               std::invalid_argument);
  Scene scene = worldOfBalls(1, false, false);
  EXPECT_THROW(scene.setShape(2, 1, Shape::sphere(1)), std::out_of_range);
  scene.setShape(2, 0, Shape::sphere(1));
}

}  // namespace
}  // namespace leeway::collision
