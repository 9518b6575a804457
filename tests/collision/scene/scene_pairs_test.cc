#include "leeway/collision/scene_pairs.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/scene.h"
#include "tests/support/allocations.h"
#include "tests/support/deformable_cases.h"
#include "tests/support/sanitized.h"
#include "tests/support/scene_twins.h"

namespace leeway::collision {
namespace {

using testing::Draw;
using testing::expectSame;
using testing::kMoving;
using testing::randomBuilder;
using testing::Twins;

TEST(ScenePairs, ATableIsWhatAListWouldBe) {
  Draw draw(1);
  for (int world = 0; world < 60; ++world) {
    Twins twins(randomBuilder(draw, world % 2 == 0));
    ASSERT_FALSE(twins.table.pairs().rows().empty());
    ASSERT_TRUE(twins.listed.pairs().rows().empty());
    expectSame(twins, "built");
    const int bodies = static_cast<int>(twins.listed.bodies().size());
    for (int change = 0; change < 6; ++change) {
      if (draw.below(3) == 0) {
        const double margin = draw.uniform(-0.01, 0.04);
        twins.both([&](Scene& scene) { scene.raiseMargins(margin); });
      }
      const int body = draw.below(2) == 0 ? draw.below(kMoving) : draw.below(bodies);
      const auto geometries = static_cast<int>(twins.listed.bodies()[at(body)].geometries.size());
      if (geometries == 0) continue;
      const int geometry = draw.below(geometries);
      const double growth = draw.uniform(-0.002, 0.01);
      twins.both([&](Scene& scene) { scene.growMargins(body, geometry, growth); });
      expectSame(twins, "changed");
    }
  }
}

TEST(ScenePairs, ATableAnswersAsAListWould) {
  Draw draw(2);
  int free = 0, not_free = 0;
  for (int world = 0; world < 30; ++world) {
    const Twins twins(randomBuilder(draw, world % 2 == 0));
    Workspace listed(twins.listed), table(twins.table);
    for (int state = 0; state < 20; ++state) {
      for (const int body : {0, 2}) {
        const Pose X = draw.pose(state < 10 ? 1.5 : 6);
        listed.setPose(body, X);
        table.setPose(body, X);
      }
      const SceneResult x = testing::expectSameAnswers(twins, listed, table);
      ++(x.verdict == Verdict::kFree ? free : not_free);
    }
  }
  EXPECT_GT(free, 40);
  EXPECT_GT(not_free, 40);
}

// Regression: between a negative margin and 0, the reach of a query was repeatedly set back to the
// margin, and the query never ended.
TEST(ScenePairs, DepthsInATableAnswerAsAListWould) {
  Draw draw(7);
  int between = 0;
  for (int world = 0; world < casesToAsk(40); ++world) {
    const Twins twins(randomBuilder(draw, false, -0.02));
    Workspace listed(twins.listed), table(twins.table);
    const auto ask = [&](const Pose& X) {
      listed.setPose(0, X);
      table.setPose(0, X);
      const SceneResult x = clearance(twins.listed, listed, 1e-4);
      const SceneResult y = clearance(twins.table, table, 1e-4);
      EXPECT_NEAR(x.clearance.upper, y.clearance.upper, 1e-4);
      EXPECT_TRUE(x.verdict == y.verdict || std::abs(x.clearance.upper + 0.02) < 1e-4);
      between += y.clearance.upper < 0 && y.clearance.upper > -0.02;
      return y.clearance.upper;
    };
    for (int state = 0; state < 10; ++state) {
      // From far away into depth, and from there towards the margin.
      Pose X = draw.pose(1.5);
      Eigen::Vector3d out = draw.pose(1).translation.normalized() * 6, in = X.translation;
      X.translation = out;
      if (ask(X) <= 0) continue;
      for (int step = 0; step < 40; ++step) {
        X.translation = (out + in) / 2;
        (ask(X) > -0.02 ? out : in) = X.translation;
      }
    }
  }
  EXPECT_GT(between, casesToAsk(1000));
}

// Keeps few or most pairs, repeatedly; margins change before and after.
TEST(ScenePairs, PairsThatAreKeptAreWhatAListWouldKeep) {
  Draw draw(8);
  int sparse = 0, dense = 0, none = 0;
  for (int world = 0; world < 60; ++world) {
    Twins twins(randomBuilder(draw, world % 2 == 0));
    for (int change = 0; change < 2; ++change) {
      const int share = std::array{1, 3, 19, 20}[static_cast<std::size_t>(draw.below(4))];
      const auto keeps = [&](const ScenePair& pair) {
        const auto hash = static_cast<unsigned>(pair.body_a * 31 + pair.body_b * 7 +
                                                pair.geometry_a * 3 + pair.geometry_b + change);
        return static_cast<int>(hash * 2654435761U >> 20U) % 20 < share && pair.body_a != 2;
      };
      twins.both([&](Scene& scene) { SceneAccess::keepPairs(scene, keeps); });
      expectSame(twins, "kept");
      const int body = draw.below(static_cast<int>(twins.listed.bodies().size()));
      if (!twins.listed.bodies()[at(body)].geometries.empty())
        twins.both([&](Scene& scene) { scene.growMargins(body, 0, 0.01); });
      twins.both([&](Scene& scene) { scene.raiseMargins(0.005); });
      expectSame(twins, "kept and changed");
      for (const ScenePairs::Row& row : twins.table.pairs().rows())
        ++(row.is_sparse ? sparse : dense);
      none += twins.table.pairs().rows().size() < 2;
    }
    Workspace listed(twins.listed), table(twins.table);
    for (int state = 0; state < 5; ++state) {
      const Pose X = draw.pose(1.5);
      listed.setPose(0, X);
      table.setPose(0, X);
      testing::expectSameAnswers(twins, listed, table);
    }
  }
  EXPECT_GT(sparse, 20);
  EXPECT_GT(dense, 20);
  EXPECT_GT(none, 20);
}

// Margins of left-out pairs, and a default that every pair overrides, do not belong to a pair.
TEST(ScenePairs, OnlyMarginsOfPairsThatAreThereCount) {
  SceneBuilder builder;
  builder.add({"mover", {{Shape::sphere(0.1), {}, ""}}, true, {}});
  for (int i = 0; i < 4; ++i)
    builder.add({"still" + std::to_string(i), {{Shape::sphere(0.1), {}, ""}}, false, {}});
  builder.setDefaultMargin(-1);
  for (int i = 1; i <= 4; ++i) builder.setMargin(0, i, 0.1 * i);
  builder.allow(0, 1);
  builder.allow(4, 0);
  const ScenePairs pairs = builder.build().pairs();
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs.leastMargin(), 0.2);
  EXPECT_EQ(pairs.mostMargin(), 0.1 * 3);
  EXPECT_EQ(pairs.leastMargin(1, false), kInfinity);
  EXPECT_EQ(pairs.numberOf(0, 0), -1);
  EXPECT_EQ((*pairs.begin()).body_b, 2);
}

// A growth of NaN stays NaN with any growth before and after it: such a pair is never free.
TEST(ScenePairs, GrowthsOfNaNAreNeverForgotten) {
  for (const int victim : {1, 2, 3}) {
    for (const bool lists : {false, true}) {
      SceneBuilder builder;
      builder.add({"mover", {{Shape::sphere(0.1), {}, ""}}, true, {}});
      for (int i = 1; i < 4; ++i) {
        Body still{"still", {{Shape::sphere(0.1), {}, ""}}, false, {}};
        still.X_WB.translation.x() = 10.0 * i;
        builder.add(still);
      }
      if (lists) builder.listAll();
      Scene scene = builder.build();
      scene.growMargins(1, 0, 0.1);
      scene.growMargins(victim, 0, kNaN);
      scene.growMargins(3, 0, 0.2);
      scene.raiseMargins(0.5);
      EXPECT_TRUE(std::isnan(scene.pairs().mostMargin()));
      EXPECT_EQ(scene.pairs().leastMargin(), 0);  // there is a pair, and its margin is unknown
      Workspace workspace(scene);
      EXPECT_NE(decide(scene, workspace).verdict, Verdict::kFree);
      EXPECT_NE(clearance(scene, workspace, 1e-3).verdict, Verdict::kFree);
    }
  }
}

TEST(ScenePairs, MoreThanAnIntNumbersAreRefused) {
  SceneBuilder builder;
  Body mover{"mover", {}, true, {}}, still{"still", {}, false, {}};
  for (int i = 0; i < 33'000; ++i) mover.geometries.push_back({Shape::sphere(0.1), {}, ""});
  still.geometries = mover.geometries;
  builder.add(mover);
  builder.add(still);
  try {
    builder.build();
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("33000 moving geometries times 33000"),
              std::string::npos)
        << error.what();
  }
}

// Regression: boxes end at 1e30 m, and the box of a half-space represents the whole space. Beyond
// it, a sphere deep inside intersected no box, and was free.
TEST(ScenePairs, BeyondAllBoxesNothingIsFree) {
  SceneBuilder builder;
  Pose X_WB;
  X_WB.translation.z() = -2e30;
  builder.add({"mover", {{Shape::sphere(1), {}, ""}}, true, X_WB});
  builder.add({"floor", {{Shape::halfSpace(), {}, ""}}, false, {}});
  const Twins twins(std::move(builder));
  for (const Scene* scene : {&twins.listed, &twins.table}) {
    Workspace workspace(*scene);
    EXPECT_NE(decide(*scene, workspace).verdict, Verdict::kFree);
    EXPECT_FALSE(clearance(*scene, workspace, 1e-6).clearance.lower > 0);
  }
}

// If one coordinate is NaN, the distance is unknown, however far apart the bodies are along the
// others.
TEST(ScenePairs, APoseThatIsNoNumberIsNearEverything) {
  for (int axis = 0; axis < 3; ++axis) {
    SceneBuilder builder;
    builder.add({"mover", {{Shape::sphere(0.1), {}, ""}}, true, {}});
    Body still{"still", {{Shape::sphere(0.1), {}, ""}}, false, {}};
    still.X_WB.translation[(axis + 1) % 3] = 50;
    builder.add(still);
    const Twins twins(std::move(builder));
    for (const Scene* scene : {&twins.listed, &twins.table}) {
      Workspace workspace(*scene);
      Pose X_WB;
      X_WB.translation[axis] = kNaN;
      workspace.setPose(0, X_WB);
      EXPECT_EQ(decide(*scene, workspace).verdict, Verdict::kUndecided);
      EXPECT_EQ(clearance(*scene, workspace, 1e-6).verdict, Verdict::kUndecided);
    }
  }
}

// A workspace has room for the nodes of deforming meshes that queries fill.
TEST(ScenePairs, DeformingMeshesInPlacesArePrepared) {
  const testing::Sheet sheet = testing::cloth(20);
  Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr,
                        testing::optionsOf(DeformStrategy::kLazy));
  ASSERT_EQ(deformable.update(testing::waved(sheet.vertices, 0.3, 1), 1), UpdateStatus::kUpdated);
  SceneBuilder builder;
  builder.add({"mover", {{Shape::sphere(0.1), {}, ""}}, true, {}});
  for (int i = 0; i < 100; ++i) {
    Body still{"still", {{Shape::sphere(0.1), {}, ""}}, false, {}};
    still.X_WB.translation = Eigen::Vector3d(4, i, 0);
    if (i == 70) still = {"cloth", {{Shape::deformable(deformable.snapshot()), {}, ""}}, false, {}};
    builder.add(still);
  }
  const Scene scene = builder.build();
  Workspace workspace(scene);
  workspace.setPose(0, Pose{Eigen::Matrix3d::Identity(), {0.1, 0.2, 0.2}});
  const std::size_t before = testing::allocationCount();
  const SceneResult result = clearance(scene, workspace, 1e-4);
  EXPECT_EQ(testing::allocationCount(), before);
  EXPECT_EQ(scene.pairs()[static_cast<std::size_t>(result.pair)].body_b, 71);
}

// A copy shares bodies, and neither scene is affected by changes to the other.
TEST(ScenePairs, CopiesOfAScene) {
  Draw draw(3);
  Twins twins(randomBuilder(draw, true));
  for (Scene* original : {&twins.listed, &twins.table}) {
    Scene copy = *original;
    EXPECT_EQ(&copy.bodies()[0], &original->bodies()[0]);
    original->setShape(5, 0, Shape::sphere(0.7));
    copy.setShape(6, 0, Shape::sphere(0.8));
    EXPECT_NE(&copy.bodies()[0], &original->bodies()[0]);
    EXPECT_NE(copy.bodies()[5].geometries[0].shape.radius(), 0.7);
    EXPECT_NE(original->bodies()[6].geometries[0].shape.radius(), 0.8);
    const Scene moved = std::move(copy);
    EXPECT_EQ(moved.bodies()[6].geometries[0].shape.radius(), 0.8);
  }
}

}  // namespace
}  // namespace leeway::collision
