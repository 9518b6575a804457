#include "leeway/collision/scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "collision/cover/coarse_shape.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/allocations.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
  }
  Eigen::Vector3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  Pose pose(double size) {
    const Eigen::Vector3d axis = vector(1).normalized();
    return {Eigen::AngleAxisd(uniform(-3.1, 3.1), axis).toRotationMatrix(), vector(size)};
  }
  Shape shape(double s) {
    switch (engine_() % 8) {
      case 0:
        return Shape::sphere(uniform(0.1, 1) * s);
      case 1:
        return Shape::capsule(uniform(0.1, 0.5) * s, uniform(0, 1) * s);
      case 2:
        return Shape::box({uniform(0.1, 1) * s, uniform(0, 1) * s, uniform(0.1, 1) * s});
      case 3:
        return Shape::cylinder(uniform(0.1, 1) * s, uniform(0.01, 1) * s);
      case 4:
        return Shape::cone(uniform(0.1, 1) * s, uniform(0.1, 1) * s);
      case 5:
        return Shape::ellipsoid({uniform(0.1, 1) * s, uniform(0.1, 1) * s, uniform(0.1, 1) * s});
      default: {
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < 15; ++i) points.push_back(vector(s));
        if (engine_() % 2 == 0) return Shape::convexHull(points);
        std::vector<TriangleMesh::Triangle> triangles;  // a soup: no inside
        for (int i = 0; i + 2 < 15; i += 3) triangles.push_back({i, i + 1, i + 2});
        return Shape::mesh(TriangleMesh::make(points, triangles));
      }
    }
  }

 private:
  std::mt19937_64 engine_;
};

/// Four moving and eight fixed bodies, one of them a floor.
Scene randomScene(Draw& draw, double margin) {
  SceneBuilder builder;
  for (int i = 0; i < 12; ++i) {
    Body body;
    body.name = "body" + std::to_string(i);
    body.moving = i % 3 == 0;
    body.X_WB = draw.pose(1.5);
    for (int g = 0; g < 1 + i % 2; ++g)
      body.geometries.push_back({draw.shape(0.4), draw.pose(0.2), ""});
    if (i == 11) body.geometries = {{Shape::halfSpace(), {}, "floor"}};
    if (i == 11) body.X_WB = Pose{Eigen::Matrix3d::Identity(), {0, 0, -1.2}};
    builder.add(std::move(body));
  }
  builder.setDefaultMargin(margin);
  return builder.build();
}

Interval slow(const Scene& scene, const Workspace& workspace, const ScenePair& pair) {
  Scratch scratch;
  const Geometry& a = scene.bodies()[static_cast<std::size_t>(pair.body_a)]
                          .geometries[static_cast<std::size_t>(pair.geometry_a)];
  const Geometry& b = scene.bodies()[static_cast<std::size_t>(pair.body_b)]
                          .geometries[static_cast<std::size_t>(pair.geometry_b)];
  const Body& body_b = scene.bodies()[static_cast<std::size_t>(pair.body_b)];
  const Pose& X_WB = body_b.moving ? workspace.pose(pair.body_b) : body_b.X_WB;
  return distance(a.shape, workspace.pose(pair.body_a) * a.X_BG, b.shape, X_WB * b.X_BG, {},
                  scratch)
      .distance;
}

TEST(Scene, AgreesWithEveryPairByItself) {
  Draw draw(1);
  int free = 0, not_free = 0;
  const int runs = kSanitized ? 9 : 40;
  for (int run = 0; run < runs; ++run) {
    const double margin = run % 3 == 0 ? 0.05 : run % 3 == 1 ? 0 : -0.02;
    const Scene scene = randomScene(draw, margin);
    Workspace workspace(scene);
    for (int state = 0; state < 10; ++state) {
      for (int b = 0; b < 12; b += 3) workspace.setPose(b, draw.pose(state < 5 ? 1.5 : 4));
      Interval truth{kInfinity, kInfinity};
      for (const ScenePair& pair : scene.pairs()) {
        const Interval d = slow(scene, workspace, pair);
        truth.lower = std::min(truth.lower, d.lower);
        truth.upper = std::min(truth.upper, d.upper);
      }
      const SceneResult decided = decide(scene, workspace);
      const SceneResult exact = clearance(scene, workspace, 1e-4);
      if (std::min(std::abs(truth.lower - margin), std::abs(truth.upper - margin)) > 1e-9 &&
          (truth.lower > margin) == (truth.upper > margin)) {
        const Verdict expected = truth.lower > margin ? Verdict::kFree : Verdict::kNotFree;
        EXPECT_EQ(decided.verdict, expected) << "run " << run << " state " << state;
        EXPECT_EQ(exact.verdict, expected) << "run " << run << " state " << state;
        ++(expected == Verdict::kFree ? free : not_free);
      }
      EXPECT_LE(decided.clearance.lower, truth.upper + 1e-12);
      EXPECT_GE(decided.clearance.upper, truth.lower - 1e-12);
      EXPECT_LE(exact.clearance.lower, truth.upper + 1e-12);
      EXPECT_GE(exact.clearance.upper, truth.lower - 1e-12);
      if (truth.lower > 0) {
        EXPECT_LE(exact.clearance.width(), 1.01e-4) << "run " << run << " state " << state;
        EXPECT_NEAR((exact.closest.point_a - exact.closest.point_b).norm(), exact.clearance.upper,
                    2e-4);
      }
    }
  }
  EXPECT_GT(free, runs * 3 / 4);
  EXPECT_GT(not_free, runs * 5 / 2);
}

// Bounds for a point against the coarse shape enclose the distance of a ball of radius 0.
TEST(Scene, CoarseShapesBoundPoints) {
  Draw draw(2);
  Scratch scratch;
  int near = 0, exact = 0;
  for (int run = 0; run < 400; ++run) {
    const Shape shape = run % 20 == 0 ? Shape::halfSpace() : draw.shape(0.5);
    const Pose X = draw.pose(1);
    const CoarseShape coarse(shape, X);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d p = X.translation + draw.vector(1);
      const Interval d =
          distance(Shape::sphere(0), Pose{Eigen::Matrix3d::Identity(), p}, shape, X, {}, scratch)
              .distance;
      EXPECT_LE(coarse.lower(p), d.upper) << toString(shape.type()) << " run " << run;
      EXPECT_GE(coarse.upper(p), d.lower) << toString(shape.type()) << " run " << run;
      near += d.upper <= 0;
      exact += coarse.upper(p) - coarse.lower(p) < 1e-9;
    }
    for (const Ball& ball : innerBalls(shape, X)) {
      const Interval d = distance(Shape::sphere(0), Pose{Eigen::Matrix3d::Identity(), ball.center},
                                  shape, X, {}, scratch)
                             .distance;
      EXPECT_LE(d.lower, -ball.radius + 1e-9) << toString(shape.type()) << " run " << run;
    }
  }
  EXPECT_GT(near, 200);
  EXPECT_GT(exact, 2000);
}

TEST(Scene, PairsAreThoseThatCanMeet) {
  SceneBuilder builder;
  const auto body = [&](const char* name, bool moving, int geometries) {
    Body b;
    b.name = name;
    b.moving = moving;
    for (int g = 0; g < geometries; ++g) b.geometries.push_back({Shape::sphere(0.1), {}, ""});
    return builder.add(std::move(b));
  };
  const int wall = body("wall", false, 2), table = body("table", false, 1);
  const int arm = body("arm", true, 2), hand = body("hand", true, 1), cup = body("cup", true, 1);
  builder.allow(hand, cup);
  builder.allow(table, arm);
  builder.setDefaultMargin(0.01);
  builder.setMargin(cup, table, -0.002);
  const Scene scene = builder.build();
  // wall-arm 4, wall-hand 2, wall-cup 2, table-hand 1, table-cup 1, arm-hand 2, arm-cup 2
  EXPECT_EQ(scene.pairs().size(), 14U);
  for (const ScenePair& pair : scene.pairs()) {
    EXPECT_TRUE(scene.bodies()[static_cast<std::size_t>(pair.body_a)].moving);
    EXPECT_FALSE(pair.body_a == arm && pair.body_b == table);
    EXPECT_EQ(pair.margin, pair.body_a == cup && pair.body_b == table ? -0.002 : 0.01);
  }
  EXPECT_EQ(scene.find("cup"), cup);
  EXPECT_EQ(scene.find("nothing"), -1);
  EXPECT_EQ(wall, 0);
  builder.setMargin(cup, table, kInfinity);
  EXPECT_THROW(builder.build(), std::invalid_argument);
}

/// Pairs are in the order of their bodies, whichever of them the base scene has.
TEST(Scene, BegunWithAnotherSceneIsThatOfAllItsBodies) {
  Draw draw(12);
  const auto below = [&](int n) { return static_cast<int>(draw.uniform(0, n)); };
  int kept = 0, allowed = 0;
  for (int run = 0; run < 60; ++run) {
    std::vector<Body> bodies;
    for (int b = 0; b < 9; ++b) {
      Body body{"body " + std::to_string(b), {}, draw.uniform(0, 1) < 0.4, draw.pose(2)};
      for (int g = below(3); g >= 0; --g)
        body.geometries.push_back({Shape::sphere(0.1 * (g + 1)), draw.pose(0.1), ""});
      bodies.push_back(body);
    }
    const int base = below(10);
    SceneBuilder whole, begun;
    for (int b = 0; b < base; ++b) begun.add(bodies[static_cast<std::size_t>(b)]);
    std::vector<std::pair<int, int>> touching;
    for (int k = 0; k < 6; ++k) touching.emplace_back(below(9), below(9));
    for (const auto& [a, b] : touching)
      if (a < base && b < base) begun.allow(a, b);
    SceneBuilder more(begun.build());
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      whole.add(bodies[b]);
      if (static_cast<int>(b) >= base) {
        EXPECT_EQ(more.add(bodies[b]), static_cast<int>(b));
      }
    }
    for (SceneBuilder* builder : {&whole, &more}) {
      builder->setDefaultMargin(0.01);
      builder->setMargin(2, 5, 0.03);
      for (const auto& [a, b] : touching) builder->allow(a, b);
    }
    const Scene expected = whole.build(), scene = std::move(more).build();
    ASSERT_EQ(scene.bodies().size(), expected.bodies().size());
    ASSERT_EQ(scene.pairs().size(), expected.pairs().size()) << "run " << run;
    auto twin = expected.pairs().begin();
    for (auto pair = scene.pairs().begin(); pair != scene.pairs().end(); ++pair, ++twin) {
      const ScenePair x = *pair, y = *twin;
      EXPECT_EQ(pair.number(), twin.number());
      EXPECT_EQ(x.body_a, y.body_a);
      EXPECT_EQ(x.geometry_a, y.geometry_a);
      EXPECT_EQ(x.body_b, y.body_b);
      EXPECT_EQ(x.geometry_b, y.geometry_b);
      EXPECT_EQ(x.margin, y.margin);
      kept += x.body_a < base && x.body_b < base;
    }
    allowed += static_cast<int>(touching.size());
    Workspace one(scene), other(expected);
    for (int b = 0; b < 9; ++b) {
      if (!bodies[static_cast<std::size_t>(b)].moving) continue;
      const Pose X = draw.pose(1);
      one.setPose(b, X);
      other.setPose(b, X);
    }
    EXPECT_EQ(clearance(scene, one, 1e-6).clearance.lower,
              clearance(expected, other, 1e-6).clearance.lower);
  }
  EXPECT_GT(kept, 500);
  EXPECT_GT(allowed, 100);
}

TEST(Scene, HalfSpacesAreRefusedByName) {
  SceneBuilder builder;
  const int held = builder.add({"held", {{Shape::halfSpace(), {}, ""}}, true, {}});
  const int floor = builder.add({"floor", {{Shape::halfSpace(), {}, ""}}, false, {}});
  builder.add({"wall", {{Shape::halfSpace(), {}, ""}}, false, {}});
  std::string message;
  try {
    builder.build();
  } catch (const std::invalid_argument& error) {
    message = error.what();
  }
  EXPECT_NE(message.find("'held' with half-space of 'floor'"), std::string::npos) << message;
  // Pairs that may touch, or are both at rest, are skipped.
  builder.allow(held, floor);
  builder.allow(held, 2);
  EXPECT_TRUE(builder.build().pairs().empty());
}

TEST(Scene, WithoutPairsThereIsNothingToBeNear) {
  const Scene scene = SceneBuilder().build();
  Workspace workspace(scene);
  EXPECT_EQ(decide(scene, workspace).verdict, Verdict::kFree);
  const SceneResult result = clearance(scene, workspace, 1e-3);
  EXPECT_EQ(result.verdict, Verdict::kFree);
  EXPECT_EQ(result.clearance.lower, kInfinity);
  EXPECT_EQ(result.pair, -1);
}

TEST(Scene, APoseThatIsNoNumberIsUndecided) {
  Draw draw(3);
  const Scene scene = randomScene(draw, 0);
  Workspace workspace(scene);
  for (int b = 0; b < 12; b += 3)
    workspace.setPose(b, Pose{Eigen::Matrix3d::Identity(), {std::nan(""), 0, 0}});
  EXPECT_EQ(decide(scene, workspace).verdict, Verdict::kUndecided);
  EXPECT_EQ(clearance(scene, workspace, 1e-3).verdict, Verdict::kUndecided);
}

TEST(Scene, APoseThatIsNoNumberLeavesNothingKnown) {
  SceneBuilder builder;
  builder.add({"ball", {{Shape::sphere(0.1), {}, ""}}, true, {}});
  builder.add({"lost", {{Shape::sphere(0.1), {}, ""}}, true, {}});
  builder.add({"wall", {{Shape::box({1, 1, 1}), {}, ""}}, false, {}});
  const Scene scene = builder.build();
  Workspace workspace(scene);
  workspace.setPose(0, Pose{Eigen::Matrix3d::Identity(), {2, 0, 0}});
  for (const double bad : {std::nan(""), kInfinity, -kInfinity}) {
    workspace.setPose(1, Pose{Eigen::Matrix3d::Identity(), {5, 5, bad}});
    const SceneResult result = clearance(scene, workspace, 1e-6);
    EXPECT_EQ(result.verdict, Verdict::kUndecided);
    EXPECT_EQ(result.clearance.lower,
              -kInfinity);  // regression: NaN was dropped and 0.9 m returned
    EXPECT_LE(result.clearance.upper, 0.9 + 1e-6);
    for (auto pair = scene.pairs().begin(); pair != scene.pairs().end(); ++pair) {
      if ((*pair).body_a != 1 && (*pair).body_b != 1) continue;
      const DistanceResult one =
          pairDistance(scene, workspace, static_cast<int>(pair.number()), {});
      EXPECT_EQ(one.status, DistanceStatus::kInvalid);
      EXPECT_EQ(one.distance.lower, -kInfinity);
      EXPECT_EQ(one.distance.upper, kInfinity);
    }
  }
}

TEST(Scene, PosesThatAreNoneAreRefused) {
  const auto build = [](const Pose& X_WB, const Pose& X_BG) {
    SceneBuilder builder;
    builder.add({"ball", {{Shape::sphere(0.1), {}, ""}}, true, {}});
    builder.add({"post", {{Shape::box({0.1, 0.1, 0.1}), X_BG, ""}}, false, X_WB});
    return builder.build().pairs().size();
  };
  EXPECT_EQ(build({}, {}), 1U);
  std::vector<Pose> bad(8);
  for (std::size_t k = 0; k < 3; ++k) bad[k].translation[static_cast<int>(k)] = std::nan("");
  bad[3].translation.y() = kInfinity;
  bad[4].rotation(1, 2) = std::nan("");
  bad[5].rotation *= 2;
  bad[6].rotation.setZero();
  bad[7].rotation(0, 1) = 1e-3;
  for (const Pose& X : bad) {
    EXPECT_THROW(build(X, {}), std::invalid_argument);
    EXPECT_THROW(build({}, X), std::invalid_argument);
  }
}

// The pose of a fixed body is always that of the scene.
TEST(Scene, OnlyWhatMovesIsPlaced) {
  SceneBuilder builder;
  builder.add({"ball", {{Shape::sphere(0.1), {}, ""}}, true, {}});
  builder.add({"wall", {{Shape::box({1, 1, 1}), {}, ""}}, false, {}});
  const Scene scene = builder.build();
  Workspace workspace(scene);
  workspace.setPose(0, Pose{Eigen::Matrix3d::Identity(), {2, 0, 0}});
  workspace.setPose(1, Pose{Eigen::Matrix3d::Identity(), {9, 0, 0}});
  EXPECT_NEAR(clearance(scene, workspace, 1e-9).clearance.lower, 0.9, 1e-6);
  EXPECT_THROW(workspace.pose(1), std::out_of_range);
}

TEST(Scene, PoseErrorWidensEveryAnswer) {
  SceneBuilder builder;
  Body ball{"ball", {{Shape::sphere(1), {}, ""}}, true, {}};
  Body wall{"wall", {{Shape::box({1, 1, 1}), {}, ""}}, false, {}};
  builder.add(ball);
  builder.add(wall);
  const Scene scene = builder.build();
  Workspace workspace(scene);
  workspace.setPose(0, Pose{Eigen::Matrix3d::Identity(), {2.001, 0, 0}});
  EXPECT_EQ(decide(scene, workspace).verdict, Verdict::kFree);
  workspace.pose_error = 0.01;
  EXPECT_EQ(decide(scene, workspace).verdict, Verdict::kUndecided);
  const SceneResult result = clearance(scene, workspace, 1e-6);
  EXPECT_LE(result.clearance.lower, 0.001 - 0.01);
  EXPECT_GE(result.clearance.upper, 0.001 + 0.01);
}

TEST(Scene, QueriesAllocateNothing) {
  Draw draw(4);
  const Scene scene = randomScene(draw, 0.01);
  Workspace workspace(scene);
  std::vector<Pose> poses;
  for (int i = 0; i < 80; ++i) poses.push_back(draw.pose(2));
  const std::size_t before = testing::allocationCount();
  for (std::size_t i = 0; i + 4 <= poses.size(); i += 4) {
    for (int b = 0; b < 4; ++b) workspace.setPose(3 * b, poses[i + static_cast<std::size_t>(b)]);
    decide(scene, workspace);
    clearance(scene, workspace, 1e-4);
  }
  EXPECT_EQ(testing::allocationCount(), before);
}

}  // namespace
}  // namespace leeway::collision
