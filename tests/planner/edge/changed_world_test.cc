// Worlds to which objects are added and removed, compared with the same worlds compiled from
// scratch.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/point_cloud.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "tests/support/random_model.h"
#include "tests/support/random_problem.h"
#include "tests/support/sanitized.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using testing::Random;

/// A scene, and the problem with the same content.
struct World {
  std::shared_ptr<const CompiledScene> scene;
  Problem problem;
};

std::vector<Object> objects(Random& random, const std::shared_ptr<const robots::Model>& model,
                            const std::string& name, int count, double room) {
  std::vector<Object> all = testing::randomProblem(random, model, count, room).world.objects;
  all.resize(static_cast<std::size_t>(count));  // without a floor
  for (std::size_t i = 0; i < all.size(); ++i) all[i].name = name + std::to_string(i);
  return all;
}

/// Removes some objects and adds `count` others, some of them at the poses of others, under their
/// names.
World changed(Random& random, const World& before, int count, const std::string& name,
              double room) {
  World after{nullptr, before.problem};
  std::vector<Object>& all = after.problem.world.objects;
  std::vector<Object> added = objects(random, before.problem.robot.model, name, count, room);
  std::vector<int> removed;
  for (int k = 0; k < std::min(count, 5) && !all.empty(); ++k) {
    const auto i = static_cast<std::size_t>(random.integer(static_cast<int>(all.size())));
    if (all[i].geometries.empty()) continue;  // only a name
    const int body = before.scene->scene().find(all[i].name);
    removed.push_back(body);
    if (k % 2 == 0) added[static_cast<std::size_t>(k)].name = all[i].name;  // it moves
    all[i].geometries.clear();  // margins and contacts still name it
  }
  after.scene = before.scene->withObjects(added, removed);
  for (const Object& object : added)  // names without geometries so far
    std::erase_if(all, [&](const Object& other) { return other.name == object.name; });
  all.insert(all.end(), added.begin(), added.end());
  return after;
}

using Pair = std::tuple<std::string, int, std::string, int, double>;
std::multiset<Pair> pairsOf(const CompiledScene& scene) {
  std::multiset<Pair> all;
  const auto bodies = scene.scene().bodies();
  for (const collision::ScenePair& pair : scene.scene().pairs())
    all.insert({bodies[static_cast<std::size_t>(pair.body_a)].name, pair.geometry_a,
                bodies[static_cast<std::size_t>(pair.body_b)].name, pair.geometry_b, pair.margin});
  return all;
}

std::multiset<std::tuple<std::string, std::string, std::string>> droppedOf(
    const CompiledScene& scene) {
  std::multiset<std::tuple<std::string, std::string, std::string>> all;
  for (const CompiledScene::Dropped& d : scene.dropped()) all.insert({d.a, d.b, d.reason});
  return all;
}

struct Counts {
  int free = 0, not_free = 0, undecided = 0, many = 0;
};

void expectSameAnswers(Random& random, const World& world,
                       const std::shared_ptr<const CompiledScene>& anew, Counts& counts) {
  EdgeCertifier certifier(world.scene), twin(anew);
  const auto agree = [&](Verdict x, Verdict y) {
    if (x == Verdict::kUndecided || y == Verdict::kUndecided) {
      ++counts.undecided;
      return;
    }
    EXPECT_EQ(x, y);
    ++(x == Verdict::kFree ? counts.free : counts.not_free);
  };
  const robots::Model& model = *world.problem.robot.model;
  constexpr double kTolerance = 1e-4;
  for (int i = 0; i < 30; ++i) {
    const std::vector<double> a = robots::testing::randomConfiguration(random, model);
    const std::vector<double> difference = robots::testing::randomDifference(random, model, a);
    std::vector<double> b = robots::testing::advanced(model, a, difference, i % 2 == 0 ? 1 : 0.1);
    agree(certifier.decide(a), twin.decide(a));
    agree(certifier.certify(a, b).verdict, twin.certify(a, b).verdict);
    if (i % 5 != 0) continue;
    const StateCheck x = certifier.clearance(a, kTolerance), y = twin.clearance(a, kTolerance);
    EXPECT_LE(x.clearance.lower, y.clearance.upper);
    EXPECT_LE(y.clearance.lower, x.clearance.upper);
    EXPECT_LE(x.clearance.width(), kTolerance);
    const Interval edge = certifier.edgeClearance(a, b, kTolerance, -1).clearance;
    const Interval of_twin = twin.edgeClearance(a, b, kTolerance, -1).clearance;
    EXPECT_LE(edge.lower, of_twin.upper);
    EXPECT_LE(of_twin.lower, edge.upper);
  }
}

void expectSame(Random& random, const World& world, Counts& counts) {
  const auto anew = std::make_shared<const CompiledScene>(world.problem);
  EXPECT_EQ(pairsOf(*world.scene), pairsOf(*anew));
  EXPECT_EQ(droppedOf(*world.scene), droppedOf(*anew));
  counts.many += world.scene->scene().pairs().size() > 500;
  expectSameAnswers(random, world, anew, counts);
}

// Few and many objects before, and few and many added ones, repeatedly.
TEST(ChangedWorld, AnswersAreThoseOfTheWorldCompiledAnew) {
  Random random(71);
  Counts counts;
  for (int world = 0; world < casesToAsk(24); ++world) {
    const bool is_arm = world % 3 != 2;
    const auto model = is_arm ? testing::randomArm(random)
                              : testing::randomFreeBody(random, robots::JointType::kFloating);
    const double room = is_arm ? 2 : 3;
    World now;
    now.problem = testing::randomProblem(random, model, 0, room);
    now.problem.name = "before";
    for (Object& o : objects(random, model, "thing", world % 2 == 0 ? 8 : 700, room))
      now.problem.world.objects.push_back(std::move(o));
    const std::string& link = model->links.back().name;
    if (world % 4 == 1) now.problem.margins.pairs.push_back({"robot", "world", 0.02});
    if (world % 4 == 2) now.problem.margins.pairs.push_back({"world", link, 0.03});
    for (const char* name : {"thing1", "more1", "again0"}) {
      now.problem.contacts.allowed.emplace_back(name, link);
      now.problem.margins.pairs.push_back({link, std::string(name) + "1", 0.05});
    }
    now.problem.margins.pairs.push_back({"more0", link, 0.1});
    // Names of objects that are added later, or never, are known from the start.
    for (const char* name : {"more1", "again0", "more0", "thing11", "more11", "again01"})
      if (std::none_of(now.problem.world.objects.begin(), now.problem.world.objects.end(),
                       [&](const Object& o) { return o.name == name; }))
        now.problem.world.objects.push_back({name, {}, {}});
    now.scene = std::make_shared<const CompiledScene>(now.problem);
    now = changed(random, now, 5, "more", room);
    expectSame(random, now, counts);
    now = changed(random, now, world % 4 < 2 ? 6 : 600, "again", room);
    expectSame(random, now, counts);
    // Numbers of what earlier changes have added are used again.
    const std::size_t bodies = now.scene->scene().bodies().size();
    now = changed(random, now, 5, "last", room);
    expectSame(random, now, counts);
    EXPECT_LE(now.scene->scene().bodies().size(), bodies + 5);
  }
  if (casesToAsk(24) < 24) return;
  EXPECT_GT(counts.free, 300);
  EXPECT_GT(counts.not_free, 300);
  EXPECT_GT(counts.many, 24);
  EXPECT_LT(counts.undecided, (counts.free + counts.not_free) / 50);
}

// Margins of the whole world also hold for objects that are added later; contacts have no such
// word.
TEST(ChangedWorld, TheWholeWorldInMarginsIncludesWhatComesLater) {
  Problem problem = test::corridorProblem();
  problem.margins.pairs = {{"robot", "world", 0.05}};
  const auto before = std::make_shared<const CompiledScene>(problem);
  const Object wall = test::box("wall", {0.02, 0.02, 0.5}, 9, 9, 0);
  const auto after = before->withObjects(std::vector<Object>{wall});
  int of_wall = 0;
  for (const auto& [a, i, b, j, margin] : pairsOf(*after)) {
    of_wall += b == "wall";
    EXPECT_EQ(margin, b == "wall" || before->scene().find(b) >= before->bodiesOfRobot() ? 0.05 : 0)
        << a << ' ' << b;
  }
  EXPECT_GT(of_wall, 0);
  // The word would have two meanings, with and without margins that use it.
  const std::vector<Object> world = {test::box("world", {0.1, 0.1, 0.1}, 9, 9, 0)};
  EXPECT_THROW(before->withObjects(world), robots::InputError);
  problem.margins.pairs.clear();
  EXPECT_THROW(std::make_shared<const CompiledScene>(problem)->withObjects(world),
               robots::InputError);
}

// A wall blocks the way. A plan goes around it, and the verifier proves the plan in a world
// compiled from scratch. After the removal of the wall the first plan returns.
TEST(ChangedWorld, IsPlannedIn) {
  Problem problem = test::corridorProblem();
  problem.seed = 5;
  const auto before = std::make_shared<const CompiledScene>(problem);
  const PlanResult first = plan(before, problem);
  ASSERT_EQ(first.status, PlanStatus::kSolved);
  // Across the path, in its middle.
  const std::vector<double>&from = first.path.positions.front(), &to = first.path.positions[1];
  const Object wall =
      test::box("wall", {0.02, 0.02, 0.5}, (from[0] + to[0]) / 2, (from[1] + to[1]) / 2, 0);
  const auto after = before->withObjects(std::vector<Object>{wall});
  Problem with_wall = problem;
  with_wall.world.objects.push_back(wall);
  EXPECT_NE(verify(with_wall, first.path).status, VerifyStatus::kCertified);
  const PlanResult second = plan(after, problem);
  ASSERT_EQ(second.status, PlanStatus::kSolved);
  EXPECT_EQ(verify(with_wall, second.path).status, VerifyStatus::kCertified);
  const std::vector<int> gone{after->scene().find("wall")};
  const PlanResult third = plan(after->withObjects({}, gone), problem);
  ASSERT_EQ(third.status, PlanStatus::kSolved);
  EXPECT_EQ(third.path.positions, first.path.positions);
}

TEST(ChangedWorld, AnObjectThatMovesLeavesNothingBehind) {
  Problem problem = test::wallProblem();
  problem.margins.pairs.push_back({"disc", "upper wall", 0.05});
  problem.world.objects.push_back(test::box("stone", {0.1, 0.1, 0.1}, 0, 1.2, 0));
  auto scene = std::make_shared<const CompiledScene>(problem);
  const std::vector<double> gap = {0, 1.2, 0}, side = {-1, 0, 0};
  EXPECT_EQ(EdgeCertifier(scene).decide(gap), Verdict::kNotFree);
  for (int k = 0; k < 2000; ++k) {
    const bool away = k % 2 == 0;
    scene = scene->withObjectAt("stone", away ? test::at(-1, 0, 0) : test::at(0, 1.2, 0));
    scene = scene->withObjectAt("upper wall", test::at(0, away ? 2.0 : 2.1, 0));
    ASSERT_LE(scene->scene().bodies().size(), 6U);
    ASSERT_EQ(scene->scene().pairs().size(), 3U);
    if (k < 1990) continue;
    EdgeCertifier certifier(scene);
    EXPECT_EQ(certifier.decide(gap), away ? Verdict::kFree : Verdict::kNotFree);
    EXPECT_EQ(certifier.decide(side), away ? Verdict::kNotFree : Verdict::kFree);
    for (Object& object : problem.world.objects) {
      if (object.name == "stone") object.X_WO = away ? test::at(-1, 0, 0) : test::at(0, 1.2, 0);
      if (object.name == "upper wall") object.X_WO = test::at(0, away ? 2.0 : 2.1, 0);
    }
    EXPECT_EQ(scene->differenceFrom(problem), "");
    EXPECT_EQ(pairsOf(*scene), pairsOf(CompiledScene(problem)));
  }
  EXPECT_THROW(scene->withObjectAt("moon", {}), std::invalid_argument);
  EXPECT_THROW(scene->withObjectAt("disc", {}), std::invalid_argument);
  EXPECT_THROW(scene->withObjectAt("stone", test::at(2e9, 0, 0)), robots::InputError);
}

/// Balls that a filter removed are missing at another place.
TEST(ChangedWorld, CloudsThatWereFittedToTheirPlaceDoNotMove) {
  const Problem problem = test::wallProblem();
  PointCloud cloud;
  cloud.balls.push_back({{0, 0, 0}, 0.01});
  Object whole{"dust", {}, test::at(-1, 0, 0), std::make_shared<const PointCloud>(cloud)};
  cloud.filters.push_back({"crop", "balls", 1});
  Object cropped = whole;
  cropped.cloud = std::make_shared<const PointCloud>(cloud);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const auto with_cropped = scene->withObjects(std::vector<Object>{cropped});
  EXPECT_THROW(with_cropped->withObjectAt("dust", {}), std::invalid_argument);
  const std::vector<int> gone{with_cropped->scene().find("dust")};
  const auto with_whole = with_cropped->withObjects(std::vector<Object>{whole}, gone);
  EXPECT_NE(with_whole->withObjectAt("dust", {}), nullptr);
  Problem compiled = problem;
  compiled.world.objects.push_back(cropped);
  EXPECT_THROW(CompiledScene(compiled).withObjectAt("dust", {}), std::invalid_argument);
}

/// A cloud of which nothing is left is still an object, at its new place, too.
TEST(ChangedWorld, EmptiedCloudsMove) {
  PointCloud cloud;
  cloud.balls.push_back({{0, 0, 0}, 0.01});
  Problem problem = test::wallProblem();
  problem.world.objects.push_back(
      {"dust", {}, test::at(-1, 0, 0), std::make_shared<const PointCloud>(cloud)});
  const CloudRegion around{{-1, -1, -1}, {1, 1, 1}};
  const auto emptied =
      std::make_shared<const CompiledScene>(problem)->withRegion("dust", around, {});
  const auto moved = emptied->withObjectAt("dust", test::at(-1, 0.5, 0));
  EXPECT_EQ(moved->scene().pairs().size(), emptied->scene().pairs().size());
  problem.world.objects.back().X_WO = test::at(-1, 0.5, 0);
  EXPECT_EQ(moved->withRegion("dust", around, cloud)->differenceFrom(problem), "");
}

PointCloud randomCloud(Random& random, const CloudRegion& region, int count) {
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d center;
    for (int k = 0; k < 3; ++k) center[k] = random.uniform(region.low[k], region.high[k]);
    cloud.balls.push_back({center, random.uniform(0.01, 0.03)});
  }
  return cloud;
}

// Regions of a cloud are seen again, some twice, some empty; the twin is compiled from the cloud.
TEST(ChangedWorld, RegionsOfACloudAreSeenAgain) {
  Random random(72);
  Counts counts;
  for (int world = 0; world < casesToAsk(8); ++world) {
    const bool is_arm = world % 3 != 2;
    const auto model = is_arm ? testing::randomArm(random)
                              : testing::randomFreeBody(random, robots::JointType::kFloating);
    World now;
    now.problem = testing::randomProblem(random, model, 3, 2);
    if (world % 2 == 0) now.problem.margins.pairs.push_back({"robot", "seen", 0.02});
    if (world % 4 == 1) now.problem.contacts.allowed.emplace_back("seen", model->links.back().name);
    CloudRegion room{Eigen::Vector3d::Constant(-2), Eigen::Vector3d::Constant(2)};
    Object seen{"seen", {}, test::at(0.1, 0, 0)};
    seen.cloud =
        std::make_shared<const PointCloud>(randomCloud(random, room, world % 2 == 0 ? 60 : 2000));
    now.problem.world.objects.push_back(seen);
    now.scene = std::make_shared<const CompiledScene>(now.problem);
    for (int round = 0; round < 5; ++round) {
      CloudRegion region = room;
      region.low[round % 2] = random.uniform(-1.5, 0.5);
      region.high[round % 2] = region.low[round % 2] + 0.8;
      if (round == 3) region = room;  // all of it
      const PointCloud again =
          randomCloud(random, region, round == 1 || round == 3 ? 0 : 30 + 200 * (world % 2));
      now.scene = now.scene->withRegion("seen", region, again);
      Object& object = now.problem.world.objects.back();
      object.cloud = std::make_shared<const PointCloud>(renewed(*object.cloud, region, again));
      ASSERT_EQ(object.cloud->balls.empty(), round == 3);
      EXPECT_EQ(now.scene->differenceFrom(now.problem), "");
      const auto anew = std::make_shared<const CompiledScene>(now.problem);
      EXPECT_EQ(now.scene->scene().pairs().size(), anew->scene().pairs().size());
      if (round != 3) {
        EXPECT_EQ(droppedOf(*now.scene), droppedOf(*anew));
      }
      expectSameAnswers(random, now, anew, counts);
    }
    Problem other = now.problem;
    PointCloud less = *other.world.objects.back().cloud;
    less.balls.pop_back();
    other.world.objects.back().cloud = std::make_shared<const PointCloud>(less);
    EXPECT_NE(now.scene->differenceFrom(other), "");
    // Moved or removed, all of its bodies are.
    const auto moved = now.scene->withObjectAt("seen", test::at(0, 0.3, 0));
    now.problem.world.objects.back().X_WO = test::at(0, 0.3, 0);
    const auto anew = [&] { return std::make_shared<const CompiledScene>(now.problem); };
    expectSameAnswers(random, {moved, now.problem}, anew(), counts);
    EXPECT_EQ(moved->differenceFrom(now.problem), "");
    const std::vector<int> gone{now.scene->scene().find("seen")};
    now.problem.world.objects.back().cloud = nullptr;  // margins still name it
    expectSameAnswers(random, {now.scene->withObjects({}, gone), now.problem}, anew(), counts);
  }
  EXPECT_GT(counts.free, 12 * casesToAsk(8));
  EXPECT_GT(counts.not_free, 12 * casesToAsk(8));
}

/// A thinned cloud, one that was moved, and one of which a region was thinned.
TEST(ChangedWorld, RegionsKeepBallsThatMayStandForPointsOutside) {
  PointCloud cloud;
  for (const double x : {0.82, 0.84, 0.98}) cloud.balls.push_back({{x, 0.05, 0.05}, 0.01});
  const PointCloud thin = thinned(cloud, 0.2);
  const CloudRegion region{{0, -1, -1}, {0.95, 1, 1}}, larger{{0, -1, -1}, {1, 1, 1}};
  const Problem wall = test::wallProblem();
  const auto sceneOf = [&wall](const PointCloud& seen, const robots::Pose& X_WO) {
    Problem problem = wall;
    problem.world.objects.push_back({"dust", {}, X_WO, std::make_shared<const PointCloud>(seen)});
    return std::pair(std::make_shared<const CompiledScene>(problem), problem);
  };
  const robots::Pose here = test::at(-1, 0, 0), there = test::at(-1, 0.5, 0);
  const auto [scene, problem] = sceneOf(thin, here);
  const auto renewed_there = sceneOf(renewed(thin, region, {}), there).second;
  EXPECT_EQ(scene->withRegion("dust", region, {})->differenceFrom(problem), "");
  EXPECT_EQ(scene->withObjectAt("dust", there)
                ->withRegion("dust", region, {})
                ->differenceFrom(renewed_there),
            "");
  const auto seen = sceneOf(cloud, here).first->withRegion("dust", larger, thin);
  EXPECT_EQ(seen->withRegion("dust", region, {})->differenceFrom(problem), "");
  EXPECT_NE(seen->withRegion("dust", larger, {})->differenceFrom(problem), "");
  // A ball that was seen in the region, and reaches out of it, goes by its center.
  PointCloud hand;
  hand.balls.push_back({{0.95, 0.05, 0.05}, 0.01});
  const auto gone = scene->withRegion("dust", region, hand)->withRegion("dust", region, {});
  EXPECT_EQ(gone->differenceFrom(problem), "");
}

TEST(ChangedWorld, RefusesRegionsOfWhatIsNoCloud) {
  Problem problem = test::wallProblem();
  PointCloud cloud;
  cloud.balls.push_back({{0, 0, 0}, 0.01});
  problem.world.objects.push_back(
      {"dust", {}, test::at(-1, 0, 0), std::make_shared<const PointCloud>(cloud)});
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const CloudRegion region{{-1, -1, -1}, {1, 1, 1}};
  for (const char* const name : {"moon", "disc", "upper wall"})
    EXPECT_THROW(scene->withRegion(name, region, cloud), std::invalid_argument) << name;
  EXPECT_THROW(scene->withMarginAtLeast(0.1)->withRegion("dust", region, cloud),
               std::invalid_argument);
  EXPECT_THROW(scene->withRegion("dust", {{1, 0, 0}, {0, 1, 1}}, cloud), std::invalid_argument);
  PointCloud bad = cloud;
  bad.balls[0].radius = -1;
  EXPECT_THROW(scene->withRegion("dust", region, bad), std::invalid_argument);
  PointCloud cropped = cloud;
  cropped.crops.push_back({});
  EXPECT_THROW(scene->withRegion("dust", region, cropped), std::invalid_argument);
  PointCloud carved = cloud;
  carved.filters.push_back({"carve", "balls that touch can", 1, robots::Pose()});
  EXPECT_THROW(scene->withRegion("dust", region, carved), std::invalid_argument) << "elsewhere";
  carved.filters.back().X_WC = test::at(-1, 0, 0);
  EXPECT_THROW(scene->withRegion("dust", region, carved)->withObjectAt("dust", {}),
               std::invalid_argument);
}

TEST(ChangedWorld, RefusesWhatItCannotChange) {
  Problem problem = test::wallProblem();
  problem.name = "room.yaml";
  const auto scene = std::make_shared<const CompiledScene>(problem);
  const std::vector<int> robot{0}, none{static_cast<int>(scene->scene().bodies().size())},
      negative{-1};
  for (const std::vector<int>& body : {robot, none, negative})
    EXPECT_THROW(scene->withObjects({}, body), std::invalid_argument);
  EXPECT_THROW(scene->withMarginAtLeast(0.1)->withObjects({}), std::invalid_argument);
  // A certifier's memory of pairs would be that of other pairs.
  const std::vector<int> wall{scene->bodiesOfRobot()};
  EdgeCertifier certifier(scene);
  EXPECT_THROW(certifier.rebind(scene->withObjects({}, wall)), std::invalid_argument);
  EXPECT_THROW(certifier.rebind(scene->withPairs([](const auto&) { return false; })),
               std::invalid_argument);
  certifier.rebind(scene->withMarginAtLeast(0.1));
  std::vector<Object> far{test::box("far", {1, 1, 1}, 2e9, 0, 0)};
  try {
    scene->withObjects(far);
    FAIL();
  } catch (const robots::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("room.yaml"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("'far'"), std::string::npos) << error.what();
  }
  far[0].X_WO = {};
  far[0].geometries[0].X_BG.translation.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(scene->withObjects(far), robots::InputError);
  // An object without geometries cannot collide.
  far[0].geometries.clear();
  EXPECT_EQ(scene->withObjects(far)->scene().bodies().size(), scene->scene().bodies().size());
}

}  // namespace
}  // namespace leeway::planner
