#include "leeway/planner/compiled_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <string>

#include "leeway/planner/plan.h"
#include "leeway/planner/replanner.h"
#include "leeway/robots/input_error.h"
#include "planner/compiled/edge_model.h"
#include "planner/edge/edge_frames.h"
#include "planner/task/stages.h"
#include "robots/model/model_builder.h"
#include "tests/support/random_model.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

/// A column of 0.2 m links with balls far smaller than the gaps, on revolute joints; those in
/// `fixed` are fixed.
std::shared_ptr<robots::Model> column(int links, const std::vector<int>& fixed = {}) {
  auto robot = robots::testing::chain(
      links, robots::JointType::kRevolute, 3, [&](int i, robots::Link& link, robots::Joint& joint) {
        link.geometries.push_back({collision::Shape::sphere(0.05), test::at(0, 0, 0.1), link.name});
        if (std::find(fixed.begin(), fixed.end(), i) != fixed.end())
          joint.type = robots::JointType::kFixed;
        joint.axis = Eigen::Vector3d::UnitY();
        if (i > 0) joint.X_PJ = test::at(0, 0, 0.2);
      });
  return std::make_shared<robots::Model>(std::move(robot));
}

std::string reason(const CompiledScene& compiled, const std::string& a, const std::string& b) {
  for (const CompiledScene::Dropped& d : compiled.dropped())
    if ((d.a == a && d.b == b) || (d.a == b && d.b == a)) return d.reason;
  return "";
}

bool kept(const CompiledScene& compiled, const std::string& a, const std::string& b) {
  for (const collision::ScenePair& pair : compiled.scene().pairs()) {
    const std::string& x = compiled.scene().bodies()[static_cast<std::size_t>(pair.body_a)].name;
    const std::string& y = compiled.scene().bodies()[static_cast<std::size_t>(pair.body_b)].name;
    if ((x == a && y == b) || (x == b && y == a)) return true;
  }
  return false;
}

Problem problemWith(std::shared_ptr<robots::Model> model) {
  const std::vector<double> q = model->defaultConfiguration();
  Problem problem = test::problemOf(model, q, q);
  problem.world.objects.push_back(test::box("table", {0.1, 0.1, 0.1}, 0.7, 0, 0));
  return problem;
}

TEST(CompiledScene, AdjacentAndDisabledPairsAreDroppedWithReasons) {
  auto model = column(5);
  model->has_srdf = true;
  model->disabled_pairs.push_back({1, 3, "Never"});
  Problem problem = problemWith(model);
  problem.contacts.allowed.emplace_back("link4", "table");
  const CompiledScene compiled(problem);
  EXPECT_EQ(reason(compiled, "link1", "link2"), "adjacent");
  EXPECT_EQ(reason(compiled, "link1", "link3"), "disabled by the SRDF: Never");
  EXPECT_EQ(reason(compiled, "link4", "table"), "allowed by the problem");
  EXPECT_TRUE(kept(compiled, "link0", "link2"));
  EXPECT_TRUE(kept(compiled, "link2", "link4"));
  EXPECT_TRUE(kept(compiled, "link3", "table"));
  EXPECT_FALSE(kept(compiled, "link1", "link3"));
  EXPECT_FALSE(kept(compiled, "link0", "table"));  // neither moves
}

TEST(CompiledScene, AMatrixReplacesTheSrdfsPairs) {
  auto model = column(5);
  model->has_srdf = true;
  model->disabled_pairs.push_back({1, 3, "Never"});
  Problem problem = problemWith(model);
  problem.contacts.replace_srdf = true;
  problem.contacts.allowed.emplace_back("link2", "link4");
  const CompiledScene compiled(problem);
  EXPECT_TRUE(kept(compiled, "link1", "link3"));
  EXPECT_EQ(reason(compiled, "link2", "link4"), "allowed by the problem");
}

/// They are checked although a joint, the SRDF or geometry leave them out, unless a step allows
/// them.
TEST(CompiledScene, CheckedPairsAreChecked) {
  for (const bool has_srdf : {true, false}) {
    auto model = column(5);
    model->has_srdf = has_srdf;
    if (has_srdf) model->disabled_pairs.push_back({1, 3, "Never"});
    Problem problem = problemWith(model);
    const CompiledScene before(problem);
    EXPECT_FALSE(kept(before, "link1", "link2"));
    EXPECT_EQ(kept(before, "link1", "link3"), !has_srdf);
    problem.contacts.checked = {{"link2", "link1"}, {"link1", "link3"}};
    const CompiledScene after(problem);
    EXPECT_TRUE(kept(after, "link1", "link2"));
    EXPECT_TRUE(kept(after, "link1", "link3"));
    EXPECT_FALSE(kept(after, "link2", "link3"));
    EXPECT_EQ(before.dropped().size(), after.dropped().size() + (has_srdf ? 2 : 1));
    const Problem stage =
        stageOf(problem, {"step", DetachStep{"none"}, {{"link1", "link2"}, {"link3", "link1"}}});
    EXPECT_EQ(CompiledScene(stage).dropped().size(), after.dropped().size() + 2);
  }
}

TEST(CompiledScene, PassiveJointsFoldIntoTheWorld) {
  auto model = column(5);
  model->has_srdf = true;
  Problem problem = problemWith(model);
  problem.start[0] = 0.5;  // joint1 is fixed, joints 2 to 4 are planned
  problem.robot.variables = {1, 2, 3};
  problem.goals.clear();
  const CompiledScene compiled(problem);
  const int link1 = compiled.scene().find("link1"), link2 = compiled.scene().find("link2");
  EXPECT_FALSE(compiled.scene().bodies()[static_cast<std::size_t>(link1)].moving);
  EXPECT_EQ(compiled.bodyLink(link1), -1);
  EXPECT_EQ(compiled.bodyLink(link2), 2);
  EXPECT_NEAR(compiled.scene().bodies()[static_cast<std::size_t>(link1)].X_WB.rotation(0, 2),
              std::sin(0.5), 1e-12);
  EXPECT_EQ(reason(compiled, "link0", "link1"), "adjacent");
  EXPECT_TRUE(kept(compiled, "link0", "link2"));
  std::vector<double> q(4);
  compiled.expand(std::vector<double>{1, 2, 3}, q);
  EXPECT_EQ(q, (std::vector<double>{0.5, 1, 2, 3}));
}

/// Regression: links that were proven never to touch were left out where they had no margin, and
/// clearances, costs and what they leave to a controller did not include them.
TEST(CompiledScene, WithoutAnSrdfLinksThatNeverMeetAreChecked) {
  auto model = column(6, {3});  // link2 and link3 are rigidly joined
  model->has_srdf = false;
  Problem problem = problemWith(model);
  const CompiledScene compiled(problem);
  EXPECT_EQ(reason(compiled, "link2", "link3"), "adjacent");
  for (const auto& [a, b] : {std::pair("link1", "link3"), {"link2", "link4"}, {"link3", "link5"}})
    EXPECT_TRUE(kept(compiled, a, b)) << a << " and " << b;
  auto stiff = column(4);
  for (robots::Variable& v : stiff->variables) v.lower = -0.3, v.upper = 0.3;
  EXPECT_TRUE(kept(CompiledScene(problemWith(stiff)), "link0", "link2"));
}

TEST(CompiledScene, AttachedThingsMoveWithTheirLink) {
  auto model = column(4);
  model->has_srdf = true;
  Problem problem = problemWith(model);
  Attachment cup;
  cup.object = {"cup", {{collision::Shape::sphere(0.03), test::at(0, 0, 0.01), "cup"}}, {}};
  cup.link = 3;
  cup.X_LO = test::at(0, 0, 0.2);
  cup.touch_links = {2};
  problem.robot.attachments.push_back(cup);
  const CompiledScene compiled(problem);
  EXPECT_EQ(reason(compiled, "cup", "link3"), "attached");
  EXPECT_EQ(reason(compiled, "cup", "link2"), "attached");
  EXPECT_TRUE(kept(compiled, "cup", "link1"));
  EXPECT_TRUE(kept(compiled, "cup", "table"));
  const int body = compiled.scene().find("cup");
  EXPECT_EQ(compiled.bodyLink(body), 3);
  const collision::Geometry& g =
      compiled.scene().bodies()[static_cast<std::size_t>(body)].geometries[0];
  EXPECT_NEAR(g.X_BG.translation.z(), 0.21, 1e-15);
}

TEST(CompiledScene, ObjectsWithoutAPlaceAreRefused) {
  // Regression: in lanes a box at (5, 5, NaN) was far from everything, so every edge was free of
  // it.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<collision::Pose> bad(4);
  bad[0].translation = {5, 5, nan};
  bad[1].translation.x() = std::numeric_limits<double>::infinity();
  bad[2].rotation(0, 0) = nan;
  bad[3].rotation *= 2;
  for (const collision::Pose& X : bad) {
    Problem problem = test::wallProblem();
    problem.world.objects.push_back({"post", {{collision::Shape::sphere(0.1), {}, "post"}}, X});
    const auto refused = [](const auto& ask) {
      try {
        ask();
      } catch (const robots::InputError& error) {
        return std::string(error.what());
      }
      return std::string("accepted");
    };
    for (const std::string& said :
         {refused([&] { CompiledScene{problem}; }), refused([&] { plan(problem); }),
          refused([&] { Replanner{problem}; })}) {
      EXPECT_NE(said.find("the pose of 'post'"), std::string::npos) << said;
      EXPECT_NE(said.find("orthogonal"), std::string::npos) << said;
    }
    problem.world.objects.pop_back();
    Attachment held;
    held.object = {"post", {{collision::Shape::sphere(0.1), {}, "post"}}, {}};
    held.link = 0;
    held.X_LO = X;
    problem.robot.attachments.push_back(held);
    EXPECT_NE(refused([&] { CompiledScene{problem}; }).find("the pose of 'post'"),
              std::string::npos);
  }
}

TEST(CompiledScene, MarginsByName) {
  auto model = column(4);
  model->has_srdf = true;
  Problem problem = problemWith(model);
  problem.margins.common = 0.01;
  problem.margins.pairs.push_back({"table", "link3", 0.05});
  const CompiledScene compiled(problem);
  int wide = 0;
  for (const collision::ScenePair& pair : compiled.scene().pairs()) {
    const bool named = pair.body_a == compiled.scene().find("link3") &&
                       pair.body_b == compiled.scene().find("table");
    EXPECT_EQ(pair.margin, named ? 0.05 : 0.01);
    wide += named;
  }
  EXPECT_EQ(wide, 1);
  EXPECT_EQ(compiled.edges().leastMargin(Pairs::kAll), 0.01);
  EXPECT_EQ(compiled.edges().leastMargin(Pairs::kWorld), 0.01);
  const auto of_world =
      compiled.withPairs([&](const collision::ScenePair& pair) { return pair.margin == 0.05; });
  EXPECT_EQ(of_world->edges().leastMargin(Pairs::kAll), 0.05);
  EXPECT_EQ(of_world->edges().leastMargin(Pairs::kWorld), 0.05);
  EXPECT_EQ(of_world->edges().leastMargin(Pairs::kSelf), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(of_world->edges().areAllNear());
  EXPECT_EQ(of_world->edges().near_anywhere.size(), 1U);
}

std::vector<EdgePair> inSceneOrder(const CompiledScene& scene) {
  std::vector<EdgePair> pairs(scene.edges().pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const EdgePair pair = scene.edges().pairs[i];
    pairs[static_cast<std::size_t>(pair.scene_pair)] = pair;
  }
  return pairs;
}

/// A kept pair keeps its own motion, even if keep() answers differently the second time.
/// Regression: pairs took other pairs' motions and were certified farther apart than they are.
TEST(CompiledScene, PairsThatAreKeptKeepTheirMotions) {
  auto model = column(7);
  model->has_srdf = true;
  const CompiledScene whole(problemWith(model));
  const collision::ScenePairs& pairs = whole.scene().pairs();
  std::size_t asked = 0;
  const auto reduced =
      whole.withPairs([&](const collision::ScenePair&) { return asked++ % 4 == 1; });
  EXPECT_EQ(asked, pairs.size());
  const collision::ScenePairs& left = reduced->scene().pairs();
  ASSERT_EQ(left.size(), (pairs.size() + 2) / 4);
  for (std::size_t p = 0; p < left.size(); ++p) {
    EXPECT_EQ(left[p].body_a, pairs[4 * p + 1].body_a);
    EXPECT_EQ(left[p].body_b, pairs[4 * p + 1].body_b);
  }
  const std::vector<EdgePair> before = inSceneOrder(whole), now = inSceneOrder(*reduced);
  ASSERT_EQ(now.size(), left.size());
  for (std::size_t p = 0; p < now.size(); ++p) {
    const EdgePair& kept = before[4 * p + 1];
    EXPECT_EQ(now[p].a, kept.a);
    EXPECT_EQ(now[p].b, kept.b);
    EXPECT_EQ(now[p].motion, kept.motion);
    EXPECT_EQ(now[p].is_reversed, kept.is_reversed);
    EXPECT_EQ(now[p].threshold, kept.threshold);
    EXPECT_EQ(now[p].gap, kept.gap);
  }
}

}  // namespace
}  // namespace leeway::planner
