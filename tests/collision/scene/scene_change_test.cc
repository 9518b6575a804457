#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/scene/scene_access.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/scene.h"
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

/// A scene that changes repeatedly, and a builder that makes the same scene at once.
class Changing {
 public:
  /// `lists`: the initial scene has no table.
  Changing(Draw& draw, bool one_each, bool lists)
      : draw_(draw), one_each_(one_each), first_(randomBuilder(draw, one_each)) {
    first_.setDefaultMargin(0.01);
    SceneBuilder first = first_;
    if (lists) first.listAll();
    scene = first.build();
    built_ = static_cast<int>(scene.bodies().size());
  }

  void change() {
    SceneChange change(scene);
    change.setDefaultMargin(0.01);
    const int bodies = static_cast<int>(scene.bodies().size());
    std::set<int> removed;
    for (int k = draw_.below(4); k > 0; --k) {
      const int kind = draw_.below(3);
      const int body = kind == 0                      ? 1
                       : kind == 1 && bodies > built_ ? built_ + draw_.below(bodies - built_)
                                                      : kMoving + draw_.below(bodies - kMoving);
      if (scene.isRemoved(body) || !removed.insert(body).second) continue;
      change.remove(body);
      for (int i = 0; i < kMoving; ++i) allowed_.emplace_back(i, body);
    }
    for (int k = draw_.below(6); k > 0; --k) {
      Body body;
      body.name = "more" + std::to_string(k);
      body.X_WB = draw_.pose(2);
      for (int g = one_each_ ? 0 : draw_.below(3) - 1; g >= 0; --g)
        body.geometries.push_back({draw_.shape(), draw_.pose(0.2), ""});
      if (draw_.below(4) == 0 && !body.geometries.empty()) {
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < 8; ++i) points.push_back(draw_.pose(0.2).translation);
        body.geometries.back().shape = Shape::convexHull(points);
      }
      const int number = change.add(body);
      take(number, body, removed);
      const int moving = draw_.below(2) * 2;
      if (draw_.below(4) == 0) {
        change.allow(moving, number);
        allowed_.emplace_back(moving, number);
      }
      if (draw_.below(3) == 0) {
        const double margin = draw_.uniform(-0.01, 0.05);
        draw_.below(2) == 0 ? change.setMargin(moving, number, margin)
                            : change.setMargin(number, moving, margin);
        margins_.push_back({moving, number, margin});
      }
    }
    scene = std::move(change).build();
    for (const int body : removed) EXPECT_TRUE(scene.isRemoved(body));
  }

  Twins twins() const {
    SceneBuilder all = first_;
    for (const Body& body : added_) all.add(body);
    for (const auto& [a, b] : allowed_) all.allow(a, b);
    for (const Margin& m : margins_) all.setMargin(m.a, m.b, m.margin);
    all.listAll();
    return {all.build(), scene};
  }
  Scene scene;
  int used_again = 0;  ///< numbers of removed bodies

 private:
  struct Margin {
    int a, b;
    double margin;
  };

  /// A body that a change has added with this number: the next one, or that of a removed body with
  /// as many geometries, of which nothing is left.
  void take(int number, const Body& body, std::set<int>& removed) {
    const auto i = static_cast<std::size_t>(number - built_);
    if (i == added_.size()) {
      added_.push_back(body);
      return;
    }
    ASSERT_LT(i, added_.size());
    EXPECT_TRUE(removed.erase(number) == 1 || scene.isRemoved(number));
    EXPECT_EQ(added_[i].geometries.size(), body.geometries.size());
    added_[i] = body;
    std::erase_if(allowed_, [&](const auto& pair) { return pair.second == number; });
    std::erase_if(margins_, [&](const Margin& m) { return m.b == number; });
    ++used_again;
  }

  Draw& draw_;
  bool one_each_;
  SceneBuilder first_;
  int built_ = 0;
  std::vector<Body> added_;
  std::vector<std::pair<int, int>> allowed_;
  std::vector<Margin> margins_;
};

// With and without a table in the initial scene.
TEST(SceneChange, IsWhatBuildingAnewWouldBe) {
  Draw draw(11);
  int with_table = 0, free = 0, not_free = 0, used_again = 0;
  const int worlds = isBrief() ? 12 : 90;
  for (int world = 0; world < worlds; ++world) {
    Changing changing(draw, world % 2 == 0, world % 3 == 0);
    for (int change = 0; change < 6; ++change) {
      const Scene before = changing.scene;
      const std::size_t pairs = before.pairs().size();
      changing.change();
      EXPECT_EQ(before.pairs().size(), pairs);
      const Twins twins = changing.twins();
      expectSame(twins, "world " + std::to_string(world));
      ASSERT_EQ(twins.listed.bodies().size(), twins.table.bodies().size());
      std::size_t body = 0;
      for (const Body& b : twins.table.bodies()) EXPECT_EQ(&b, &twins.table.bodies()[body++]);
      EXPECT_EQ(body, twins.table.bodies().size());
      with_table += !twins.table.pairs().rows().empty();
      Workspace listed(twins.listed), changed(twins.table);
      for (int state = 0; state < 10; ++state) {
        for (const int moving : {0, 2}) {
          const Pose X = draw.pose(state < 5 ? 1.5 : 6);
          listed.setPose(moving, X);
          changed.setPose(moving, X);
        }
        const SceneResult x = testing::expectSameAnswers(twins, listed, changed);
        ++(x.verdict == Verdict::kFree ? free : not_free);
      }
    }
    used_again += changing.used_again;
  }
  EXPECT_GT(90 * used_again, 100 * worlds);
  EXPECT_GT(90 * with_table, 300 * worlds);
  EXPECT_GT(90 * free, 500 * worlds);
  EXPECT_GT(90 * not_free, 300 * worlds);
}

// Margins and shapes of a changed scene can be changed like those of any other.
TEST(SceneChange, ChangesFurther) {
  Draw draw(12);
  for (int world = 0; world < 40; ++world) {
    Changing changing(draw, world % 2 == 0, world % 3 == 2);
    for (int change = 0; change < 3; ++change) changing.change();
    Twins twins = changing.twins();
    const int bodies = static_cast<int>(twins.listed.bodies().size());
    for (int k = 0; k < 6; ++k) {
      const int body = draw.below(4) == 0 ? draw.below(kMoving) : bodies - 1 - draw.below(20);
      const Body& of = twins.listed.bodies()[static_cast<std::size_t>(body)];
      if (of.geometries.empty()) continue;
      const int geometry = draw.below(static_cast<int>(of.geometries.size()));
      const double growth = draw.uniform(0, 0.01);
      const Shape shape = draw.shape();
      const Scene copy = twins.table;
      const Shape before = of.geometries[static_cast<std::size_t>(geometry)].shape;
      twins.both([&](Scene& scene) {
        scene.growMargins(body, geometry, growth);
        scene.setShape(body, geometry, shape);
      });
      expectSame(twins, "changed");
      EXPECT_EQ(copy.bodies()[static_cast<std::size_t>(body)]
                    .geometries[static_cast<std::size_t>(geometry)]
                    .shape.boundingRadius(),
                before.boundingRadius());
      Workspace listed(twins.listed), changed(twins.table);
      const Pose X = draw.pose(1.5);
      listed.setPose(0, X);
      changed.setPose(0, X);
      testing::expectSameAnswers(twins, listed, changed);
    }
    // The same holds if the scene is the base of another builder.
    SceneBuilder again(twins.table);
    again.add({"last", {{Shape::sphere(0.1), {}, ""}}, false, {}});
    SceneBuilder twin(twins.listed);
    twin.add({"last", {{Shape::sphere(0.1), {}, ""}}, false, {}});
    expectSame({twin.build(), again.build()}, "built upon");
  }
}

// A deforming body is near everything, also if a change adds it.
TEST(SceneChange, AddsWhatDeforms) {
  const testing::Sheet sheet = testing::cloth(20);
  Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr,
                        testing::optionsOf(DeformStrategy::kRefit));
  SceneBuilder builder;
  builder.add({"hand", {{Shape::sphere(0.05), {}, ""}}, true, {}});
  for (int i = 0; i < 100; ++i) {
    Body still{"still", {{Shape::sphere(0.1), {}, ""}}, false, {}};
    still.X_WB.translation = Eigen::Vector3d(4, i, 0);
    builder.add(still);
  }
  SceneChange change(builder.build());
  const int cloth =
      change.add({"cloth", {{Shape::deformable(deformable.snapshot()), {}, ""}}, false, {}});
  Scene scene = std::move(change).build();
  Workspace workspace(scene);
  workspace.setPose(0, Pose{Eigen::Matrix3d::Identity(), {0.1, 0.2, 0.2}});
  const SceneResult still = clearance(scene, workspace, 1e-4);
  EXPECT_EQ(scene.pairs()[static_cast<std::size_t>(still.pair)].body_b, cloth);
  ASSERT_EQ(deformable.update(testing::waved(sheet.vertices, 0.3, 1), 1), UpdateStatus::kUpdated);
  scene.setShape(cloth, 0, Shape::deformable(deformable.snapshot()));
  workspace.prepare(scene);
  const SceneResult waved = clearance(scene, workspace, 1e-4);
  EXPECT_EQ(scene.pairs()[static_cast<std::size_t>(waved.pair)].body_b, cloth);
  EXPECT_NE(waved.clearance.lower, still.clearance.lower);
}

// Repeated changes: find() returns the present body with the name.
TEST(SceneChange, MovesABody) {
  SceneBuilder builder;
  builder.add({"hand", {{Shape::sphere(0.05), {}, ""}}, true, {}});
  builder.add({"stone", {{Shape::sphere(0.1), {}, ""}}, false, {}});
  Scene scene = builder.build();
  for (int step = 1; step < 5; ++step) {
    SceneChange change(scene);
    change.remove(scene.find("stone"));
    Body stone = scene.bodies()[at(scene.find("stone"))];
    stone.X_WB.translation.x() = step;
    change.add(stone);
    scene = std::move(change).build();
    ASSERT_EQ(scene.pairs().size(), 1U);
    EXPECT_EQ((*scene.pairs().begin()).body_b, scene.find("stone"));
    Workspace workspace(scene);
    EXPECT_NEAR(clearance(scene, workspace, 1e-9).clearance.lower, step - 0.15, 1e-6);
  }
  SceneChange change(scene);
  change.remove(scene.find("stone"));
  EXPECT_EQ(std::move(change).build().find("stone"), -1);
}

// Thousands of moves leave one body behind, and nothing of where it has been.
TEST(SceneChange, MovesLeaveNothingBehind) {
  for (const bool is_far : {false, true}) {
    SceneBuilder builder;
    builder.setDefaultMargin(0.01);
    builder.add({"hand", {{Shape::sphere(0.05), {}, ""}, {Shape::sphere(0.02), {}, ""}}, true, {}});
    for (int i = 0; i < 20; ++i) {
      Body stone{"stone" + std::to_string(i), {{Shape::sphere(0.1), {}, ""}}, false, {}};
      stone.X_WB.translation.y() = i;
      builder.add(stone);
    }
    Scene scene = builder.build();
    const auto move = [&](const std::string& name, double x) {
      SceneChange change(scene);
      change.setDefaultMargin(0.01);
      Body stone = scene.bodies()[at(scene.find(name))];
      change.remove(scene.find(name));
      stone.X_WB.translation.x() = x;
      const int number = change.add(stone);
      if (x > 2) change.allow(0, number);
      if (x < 0) change.setMargin(0, number, 0.2);
      scene = std::move(change).build();
      return number;
    };
    const int first = move("stone0", 1);
    const int second = move("stone1", 1);
    EXPECT_EQ(second, first + 1);
    const std::size_t pairs = scene.pairs().size();
    for (int k = 0; k < 3000; ++k) {
      const double x = is_far && k == 7 ? 1e6 : 0.001 * (k % 4000) - 1;
      ASSERT_EQ(move(k % 2 == 0 ? "stone0" : "stone1", x), k % 2 == 0 ? first : second);
      ASSERT_EQ(scene.bodies().size(), 23U);
      ASSERT_EQ(scene.pairs().places(), 22U);
    }
    move("stone0", 1);
    move("stone1", 1);
    EXPECT_EQ(scene.pairs().size(), pairs);
    EXPECT_LT(SceneAccess::scaleOfStill(scene), 100);
    for (const ScenePair& pair : scene.pairs()) EXPECT_EQ(pair.margin, 0.01);
    Workspace workspace(scene);
    EXPECT_NEAR(clearance(scene, workspace, 1e-9).clearance.lower, 0.85, 1e-6);
    // The margin is gone, and the two that were allowed meet.
    move("stone0", 0.05);
    EXPECT_EQ(decide(scene, workspace = Workspace(scene)).verdict, Verdict::kNotFree);
  }
}

TEST(SceneChange, RefusesWhatItCannotChange) {
  for (const bool lists : {false, true}) {
    SceneBuilder builder;
    builder.add({"plate", {{Shape::halfSpace(), {}, ""}}, true, {}});
    builder.add({"stone", {{Shape::sphere(0.1), {}, ""}}, false, {}});
    if (lists) builder.listAll();
    const Scene scene = builder.build();
    const Body floor{"floor", {{Shape::halfSpace(), {}, ""}}, false, {}};
    const Body stone{"pebble", {{Shape::sphere(0.01), {}, ""}}, false, {}};
    const auto changed = [&](auto&& make) {
      SceneChange change(scene);
      make(change);
      return std::move(change).build();
    };
    const auto refused = [&](auto&& make) { EXPECT_THROW(changed(make), std::invalid_argument); };
    for (const int body : {0, 2, -1}) refused([body](SceneChange& change) { change.remove(body); });
    refused([&](SceneChange& change) { change.remove(change.add(stone)); });
    refused([](SceneChange& change) {
      change.remove(1);
      change.remove(1);
    });
    refused([](SceneChange& change) {
      change.add({"car", {{Shape::sphere(1), {}, ""}}, true, {}});
    });
    refused([&](SceneChange& change) { change.add(floor); });
    refused([&](SceneChange& change) {
      change.setMargin(0, change.add(stone), std::numeric_limits<double>::quiet_NaN());
    });
    refused([&](SceneChange& change) { change.setMargin(change.add(stone), 1, 0.1); });
    refused([](SceneChange& change) { change.setMargin(0, 1, 0.1); });
    refused([](SceneChange& change) { change.allow(0, 2); });
    refused([](SceneChange& change) {
      Pose far;
      far.translation.x() = std::numeric_limits<double>::infinity();
      change.add({"far", {{Shape::sphere(1), {}, ""}}, false, far});
    });
    const Scene allowed = changed([&](SceneChange& change) { change.allow(change.add(floor), 0); });
    EXPECT_EQ(allowed.pairs().size(), 1U);
    const Scene without = changed([](SceneChange& change) { change.remove(1); });
    EXPECT_TRUE(without.pairs().empty());
    SceneChange again(without);
    EXPECT_THROW(again.remove(1), std::invalid_argument);
  }
}

}  // namespace
}  // namespace leeway::collision
