// Worlds of many objects: a hierarchy skips distant ones, and must not change an answer.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "collision/lanes/lane_sweep.h"
#include "leeway/collision/distance.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/robots/kinematics.h"
#include "planner/compiled/edge_model.h"
#include "planner/compiled/prepared_robot.h"
#include "planner/edge/edge_frames.h"
#include "tests/support/random_model.h"
#include "tests/support/small_problems.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::planner {
namespace {

using oracle::Random;

constexpr int kObjects = 600;
// Worlds with too few objects for a hierarchy.
constexpr int kShare = 50;
// Distant objects: enough that their boxes alone form a tree.
constexpr int kFar = 1152;

// The first kinds are round or have closed forms. All kinds include hulls and meshes, and shapes
// that lanes treat as a cylinder or a box.
constexpr int kFirstKinds = 4, kAllKinds = 8;

collision::Shape someShape(Random& random, int kinds) {
  const double r = random.uniform(0.01, 0.08), h = random.uniform(0.01, 0.2);
  switch (random.below(kinds)) {
    case 0:
      return collision::Shape::sphere(r);
    case 1:
      return collision::Shape::capsule(r, h);
    case 2:
      return collision::Shape::cylinder(r, h);
    case 3:
      return collision::Shape::box({r, h, r});
    case 4:
      return collision::Shape::mesh(oracle::boxMesh({h, r, r}));
    case 5:
      return collision::Shape::cone(r, h);
    case 6:
      return collision::Shape::ellipsoid({r, h, r});
    default: {
      std::vector<Eigen::Vector3d> points;
      for (int i = 0; i < 9; ++i) points.push_back(h * random.direction());
      return collision::Shape::convexHull(points);
    }
  }
}

/// Adds shapes all around, on a floor, and `far` objects beyond the reach of any robot.
void addCrowd(Random& random, int far, int kinds, Problem& problem, int near = kObjects) {
  collision::Pose X_WF;
  X_WF.translation.z() = -1.2;
  problem.world.objects.push_back({"floor", {{collision::Shape::halfSpace(), {}, "floor"}}, X_WF});
  for (int i = 1; i < near; ++i) {
    const Eigen::Vector3d p(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-1, 4));
    problem.world.objects.push_back({"thing " + std::to_string(i),
                                     {{someShape(random, kinds), {}, "shape"}},
                                     {random.rotation(), p}});
  }
  for (int i = 0; i < far; ++i)
    problem.world.objects.push_back({"far " + std::to_string(i),
                                     {{collision::Shape::sphere(0.1), {}, "ball"}},
                                     test::at(20 + i % 128, 20 + i / 128, 0)});
}

/// A flying box in such a world.
Problem crowd(Random& random, int far = 0, int kinds = kFirstKinds) {
  Problem problem =
      test::problemOf(test::flyingBox(), {0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1});
  addCrowd(random, far, kinds, problem);
  problem.contacts.allowed.emplace_back("flyer", "thing 7");
  problem.margins.common = 0.01;
  problem.margins.pairs.push_back({"thing 8", "flyer", 0.3});
  return problem;
}

std::vector<double> somewhere(Random& random) {
  std::vector<double> q;
  for (int i = 0; i < 3; ++i) q.push_back(random.uniform(-0.95, 0.95));
  const Eigen::Quaterniond turn(random.rotation());
  for (const double x : turn.coeffs()) q.push_back(x);
  return q;
}

/// The same world, divided into shares.
class Shares {
 public:
  explicit Shares(const CompiledScene& scene) {
    const int bodies = std::min(kObjects + 1, static_cast<int>(scene.scene().bodies().size()));
    for (int first = 0; first < bodies; first += kShare)
      certifiers_.emplace_back(scene.withPairs([&](const collision::ScenePair& pair) {
        return pair.body_b >= first && pair.body_b < first + kShare;
      }));
  }
  /// The worst answer of all shares: not free before undecided before free.
  template <class Ask>
  Verdict worst(const Ask& ask) {
    Verdict worst = Verdict::kFree;
    for (EdgeCertifier& certifier : certifiers_) {
      const Verdict verdict = ask(certifier);
      if (verdict == Verdict::kNotFree) return verdict;
      if (verdict == Verdict::kUndecided) worst = verdict;
    }
    return worst;
  }
  std::deque<EdgeCertifier>& certifiers() { return certifiers_; }

 private:
  std::deque<EdgeCertifier> certifiers_;
};

void expectAnswersOfSmallWorlds(int far) {
  Random random(31);
  const Problem problem = crowd(random, far);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EXPECT_EQ(scene->scene().pairs().size(), static_cast<std::size_t>(kObjects + far - 1));
  EdgeCertifier certifier(scene);
  Shares shares(*scene);
  int free = 0, not_free = 0;
  for (int i = 0; i < 400; ++i) {
    const std::vector<double> a = somewhere(random);
    std::vector<double> b = i % 2 == 0 ? somewhere(random) : a;
    if (i % 2 != 0)
      for (int k = 0; k < 3; ++k) b[static_cast<std::size_t>(k)] *= 0.9;
    EXPECT_EQ(certifier.decide(a), shares.worst([&](EdgeCertifier& share) {
      return share.decide(a);
    })) << i;
    const Verdict edge = certifier.certify(a, b).verdict;
    EXPECT_EQ(edge, shares.worst([&](EdgeCertifier& share) { return share.certify(a, b).verdict; }))
        << i;
    free += edge == Verdict::kFree;
    not_free += edge == Verdict::kNotFree;
  }
  EXPECT_GT(free, 30);
  EXPECT_GT(not_free, 30);
}

TEST(ManyObjects, AnswersAreThoseOfSmallWorlds) { expectAnswersOfSmallWorlds(0); }
TEST(ManyObjects, AnswersWithFarThingsAreThoseOfSmallWorlds) { expectAnswersOfSmallWorlds(kFar); }

void expectClearanceOfSmallWorlds(int far) {
  Random random(32);
  Problem problem = crowd(random, far);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  Shares shares(*scene);
  constexpr double kTolerance = 1e-4, kNoCutoff = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < 60; ++i) {
    const std::vector<double> a = somewhere(random);
    std::vector<double> b = a;
    for (int k = 0; k < 3; ++k) b[static_cast<std::size_t>(k)] *= 0.8;
    const collision::Interval whole =
        certifier.edgeClearance(a, b, kTolerance, kNoCutoff).clearance;
    double lower = whole.upper, upper = whole.upper + 1;
    for (EdgeCertifier& share : shares.certifiers()) {
      const collision::Interval part = share.edgeClearance(a, b, kTolerance, kNoCutoff).clearance;
      lower = std::min(lower, part.lower);
      upper = std::min(upper, part.upper);
    }
    EXPECT_LE(whole.lower, upper) << i;
    EXPECT_LE(lower, whole.upper) << i;
    EXPECT_LE(whole.upper - whole.lower, 2 * kTolerance) << i;
  }
}

TEST(ManyObjects, ClearanceIsTheLeastOfSmallWorlds) { expectClearanceOfSmallWorlds(0); }
TEST(ManyObjects, ClearanceWithFarThingsIsTheLeastOfSmallWorlds) {
  expectClearanceOfSmallWorlds(kFar);
}

// Distant objects change neither pairs nor answers. Neither does a variant, after which only exact
// sweeps are used.
TEST(ManyObjects, FarThingsChangeNothing) {
  Random random(34), again(34);
  const auto few = std::make_shared<const CompiledScene>(crowd(random));
  const auto many = std::make_shared<const CompiledScene>(crowd(again, kFar));
  const EdgePairs &of_few = few->edges().pairs, &of_many = many->edges().pairs;
  ASSERT_EQ(of_many.size(), of_few.size() + kFar);
  for (std::size_t i = 0; i < of_few.numbers(); ++i) {
    const EdgePair pair = of_many[i], same = of_few[i];
    EXPECT_EQ(pair.a, same.a);
    EXPECT_EQ(pair.b, same.b);
    EXPECT_EQ(pair.motion, same.motion);
    EXPECT_EQ(pair.threshold, same.threshold);
    EXPECT_EQ(pair.rounding, same.rounding);
    EXPECT_EQ(pair.scene_pair, same.scene_pair);
  }
  EdgeCertifier x(few), y(many), swept_x(few), swept_y(many);
  swept_x.rebind(few->withMarginAtLeast(0.02));
  swept_y.rebind(many->withMarginAtLeast(0.02));
  for (int i = 0; i < 100; ++i) {
    const std::vector<double> a = somewhere(random);
    std::vector<double> b = a;
    for (int k = 0; k < 3; ++k) b[static_cast<std::size_t>(k)] += random.uniform(-0.2, 0.2);
    const EdgeCheck p = x.certify(a, b), q = y.certify(a, b);
    EXPECT_EQ(p.verdict, q.verdict);
    EXPECT_EQ(p.t, q.t);
    EXPECT_EQ(p.pair, q.pair);
    EXPECT_EQ(swept_x.certify(a, b).verdict, swept_y.certify(a, b).verdict);
    const StateCheck s = x.clearance(a, 1e-4), t = y.clearance(a, 1e-4);
    EXPECT_EQ(s.clearance.lower, t.clearance.lower);
    EXPECT_EQ(s.clearance.upper, t.clearance.upper);
    EXPECT_EQ(s.pair, t.pair);
    const EdgeClearance e = x.edgeClearance(a, b, 1e-7, 0), f = y.edgeClearance(a, b, 1e-7, 0);
    // Searches of other boxes end with other intervals of the same value. Equal ends may be
    // infinite.
    EXPECT_LE(e.clearance.lower, f.clearance.upper);
    EXPECT_LE(f.clearance.lower, e.clearance.upper);
    if (e.clearance.lower != f.clearance.lower) {
      EXPECT_NEAR(e.clearance.lower, f.clearance.lower, 1e-7);
    }
    EXPECT_NEAR(e.clearance.upper, f.clearance.upper, 1e-7);
  }
}

/// The bodies of a pair; (-1, -1) if no pair decided.
std::pair<int, int> bodiesOf(const CompiledScene& scene, int pair) {
  if (pair < 0) return {-1, -1};
  const collision::ScenePair of = scene.scene().pairs()[static_cast<std::size_t>(pair)];
  return {of.body_a, of.body_b};
}

/// Compares with the distances of all pairs, one by one.
void expectClearanceOfAllPairs(const CompiledScene& scene, std::span<const double> point,
                               const StateCheck& check) {
  std::vector<double> q(scene.model().variables.size());
  scene.expand(point, q);
  std::vector<collision::Pose> X_WL(scene.model().links.size());
  robots::forwardKinematics(scene.model(), q, X_WL);
  const auto bodies = scene.scene().bodies();
  double upper = std::numeric_limits<double>::infinity();
  bool is_free = true;
  for (const collision::ScenePair& pair : scene.scene().pairs()) {
    const auto placed = [&](int body, int geometry) {
      const collision::Body& b = bodies[static_cast<std::size_t>(body)];
      const collision::Geometry g = b.geometry(static_cast<std::size_t>(geometry));
      const int link = scene.bodyLink(body);
      const collision::Pose& X_WB = link < 0 ? b.X_WB : X_WL[static_cast<std::size_t>(link)];
      return std::pair(g.shape, X_WB * g.X_BG);
    };
    const auto [a, X_WA] = placed(pair.body_a, pair.geometry_a);
    const auto [b, X_WB] = placed(pair.body_b, pair.geometry_b);
    const collision::Interval apart = collision::distance(a, X_WA, b, X_WB, {}).distance;
    upper = std::min(upper, apart.upper);
    is_free = is_free && apart.lower > pair.margin - 1e-9;
    EXPECT_LE(check.clearance.lower, apart.upper + 1e-9);
  }
  EXPECT_LE(check.clearance.upper, upper + 1e-4 + 1e-9);
  if (check.verdict == Verdict::kFree) {
    EXPECT_TRUE(is_free);
  }
}

/// `many` is the scene of `few` with distant objects. Returns how many of `edges` are free.
int expectSameAnswers(const std::shared_ptr<const CompiledScene>& few,
                      const std::shared_ptr<const CompiledScene>& many,
                      const std::vector<std::array<std::vector<double>, 2>>& edges) {
  EdgeCertifier x(few), y(many);
  int free = 0;
  for (const auto& [a, b] : edges) {
    EXPECT_EQ(x.decide(a), y.decide(a));
    const EdgeCheck p = x.certify(a, b), q = y.certify(a, b);
    EXPECT_EQ(p.verdict, q.verdict);
    EXPECT_EQ(p.t, q.t);
    EXPECT_EQ(bodiesOf(*few, p.pair), bodiesOf(*many, q.pair));
    free += p.verdict == Verdict::kFree;
    const StateCheck s = x.clearance(a, 1e-4), t = y.clearance(a, 1e-4);
    EXPECT_EQ(bodiesOf(*few, s.pair), bodiesOf(*many, t.pair));
    expectClearanceOfAllPairs(*few, a, s);
    EXPECT_LE(s.clearance.lower, t.clearance.upper);
    EXPECT_LE(t.clearance.lower, s.clearance.upper);
  }
  return free;
}

using Variant = std::function<std::shared_ptr<const CompiledScene>(
    const std::shared_ptr<const CompiledScene>&)>;

const std::shared_ptr<const collision::DeformableMesh>& tetrahedron() {
  static const auto mesh = collision::DeformableMesh::make(
      std::vector<Eigen::Vector3d>{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
      std::vector<collision::DeformableMesh::Triangle>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
  return mesh;
}

/// The tetrahedron as a deforming obstacle.
void addDeforming(const std::string& name, const Eigen::Vector3d& p, Problem& problem) {
  problem.world.deforming.push_back(
      makeDeformingObstacle(name, tetrahedron(), nullptr, test::at(p.x(), p.y(), p.z())));
}

/// The tetrahedron, scaled.
collision::Shape scaledTetrahedron(double by) {
  std::vector<Eigen::Vector3d> vertices(tetrahedron()->rest().begin(), tetrahedron()->rest().end());
  for (Eigen::Vector3d& v : vertices) v *= by;
  collision::Deformable deformable(tetrahedron());
  EXPECT_EQ(deformable.update(vertices, 0), collision::UpdateStatus::kUpdated);
  return collision::Shape::deformable(deformable.snapshot());
}

/// Margins and shapes that replace those of a compiled scene that contains "cloth".
std::vector<Variant> variants() {
  using Scene = std::shared_ptr<const CompiledScene>;
  const auto replaced = [](const Scene& scene, double size, double growth) {
    const std::vector<CompiledScene::Replacement> shapes = {
        {scene->scene().find("cloth"), 0, scaledTetrahedron(size), growth}};
    return scene->withShapes(shapes);
  };
  return {[](const Scene& scene) { return scene; },
          [](const Scene& scene) { return scene->withWorldMarginAtLeast(0.03); },
          [](const Scene& scene) { return scene->withMarginsGrown(0.02); },
          [=](const Scene& scene) { return replaced(scene, 0.3, 0); },
          [=](const Scene& scene) { return replaced(scene, 1e-3, 0.2); },
          [=](const Scene& scene) {
            return replaced(scene->withMarginsGrown(0.01), 0.2, 0.01)->withMarginAtLeast(0.04);
          }};
}

TEST(ManyObjects, VariantsAnswerAsPairsOneByOne) {
  Random random(37), again(37);
  const auto among = [](Random& draws, int far) {
    Problem problem = crowd(draws, far, kAllKinds);
    addDeforming("cloth", {0.5, 2.5, 0.5}, problem);
    return std::make_shared<const CompiledScene>(problem);
  };
  const auto few = among(random, 0), many = among(again, kFar);
  std::vector<std::array<std::vector<double>, 2>> edges;
  for (int i = 0; i < 60; ++i) {
    const std::vector<double> a = somewhere(random);
    std::vector<double> b = a;
    for (int k = 0; k < 3; ++k) b[static_cast<std::size_t>(k)] += random.uniform(-0.2, 0.2);
    edges.push_back({a, b});
  }
  std::vector<int> free;
  for (const Variant& variant : variants())
    free.push_back(expectSameAnswers(variant(few), variant(many), edges));
  EXPECT_GT(free[0], 10);
  EXPECT_LE(free[1], free[0]);
  EXPECT_LE(free[2], free[0]);
}

/// Several links, with a row for each, and pairs of links with each other.
TEST(ManyObjects, VariantsOfAnArmAnswerAsPairsOneByOne) {
  constexpr int kLinks = 6;
  constexpr int kNear = 146;
  robots::RobotDescription arm = robots::testing::chain(
      kLinks, robots::JointType::kRevolute, 3, [](int i, robots::Link& link, robots::Joint& joint) {
        link.geometries.push_back(
            {collision::Shape::capsule(0.04, 0.08), test::at(0, 0, 0.1), link.name});
        joint.axis = i % 2 == 0 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
        if (i > 0) joint.X_PJ = test::at(0, 0, 0.25);
      });
  const auto model = std::make_shared<robots::Model>(std::move(arm));
  const std::vector<double> home = model->defaultConfiguration();
  const auto among = [&](int far) {
    Random random(38);
    Problem problem = test::problemOf(model, home, home);
    addCrowd(random, far, kAllKinds, problem, kNear);
    addDeforming("cloth", {0.5, 2.5, 0.5}, problem);
    problem.margins.common = 0.005;
    return std::make_shared<const CompiledScene>(problem);
  };
  const auto few = among(0), many = among(kFar);
  Random random(39);
  std::vector<std::array<std::vector<double>, 2>> edges;
  for (int i = 0; i < 60; ++i) {
    std::vector<double> a, b;
    for (std::size_t k = 0; k < home.size(); ++k) {
      a.push_back(random.uniform(-1.2, 1.2));
      b.push_back(a.back() + random.uniform(-0.1, 0.1));
    }
    edges.push_back({a, b});
  }
  std::vector<int> free;
  for (const Variant& variant : variants())
    free.push_back(expectSameAnswers(variant(few), variant(many), edges));
  EXPECT_GT(free[0], 10);
  EXPECT_LE(free[1], free[0]);
  EXPECT_LE(free[2], free[0]);
}

// One of many pairs is never free, at any distance.
TEST(ManyObjects, AGrowthOfNaNIsNeverForgotten) {
  Random random(35);
  Problem problem = crowd(random, kFar);
  addDeforming("near", {0, 3, 0}, problem);
  addDeforming("far", {50, 0, 0}, problem);
  addDeforming("farther", {500, 0, 0}, problem);
  const CompiledScene scene(problem);
  const std::vector<double> q = {0, 0, 0.5, 0, 0, 0, 1};
  for (const char* name : {"near", "far", "farther"}) {
    const int body = scene.scene().find(name);
    const std::vector<CompiledScene::Replacement> shapes = {
        {body, 0, scene.scene().bodies()[static_cast<std::size_t>(body)].geometries[0].shape,
         std::numeric_limits<double>::quiet_NaN()}};
    const auto changed = scene.withShapes(shapes);
    for (const auto& variant : {changed, changed->withMarginAtLeast(0.001)}) {
      const auto only = [&](bool with) {
        return EdgeCertifier(variant->withPairs([&](const collision::ScenePair& pair) {
          return pair.body_b > kObjects && (with || pair.body_b != body);
        }));
      };
      EXPECT_NE(only(true).decide(q), Verdict::kFree);
      EXPECT_NE(only(true).certify(q, q).verdict, Verdict::kFree);
      EXPECT_NE(only(true).clearance(q, 1e-3).verdict, Verdict::kFree);
      EXPECT_EQ(only(false).decide(q), Verdict::kFree);
      EdgeCertifier certifier(variant);
      EXPECT_NE(certifier.decide(q), Verdict::kFree);
      EXPECT_NE(certifier.certify(q, q).verdict, Verdict::kFree);
    }
  }
}

/// An arm of balls next to a rack that a static link holds, so that pairs of the robot itself are
/// listed. Regression: they got the motions of other pairs.
TEST(ManyObjects, PairsOfTheRobotWithItselfKeepTheirMotions) {
  robots::RobotDescription arm = robots::testing::chain(
      6, robots::JointType::kRevolute, 3, [](int i, robots::Link& link, robots::Joint& joint) {
        link.geometries.push_back({collision::Shape::sphere(0.05), test::at(0, 0, 0.1), link.name});
        joint.axis = Eigen::Vector3d::UnitY();
        if (i > 0) joint.X_PJ = test::at(0, 0, 0.2);
      });
  const auto model = std::make_shared<robots::Model>(std::move(arm));
  const std::vector<double> q = model->defaultConfiguration();
  for (const int balls : {100, 4000}) {
    Problem problem = test::problemOf(model, q, q);
    problem.world.objects.push_back(test::box("table", {0.1, 0.1, 0.1}, 3, 0, 0));
    Attachment held;
    held.object.name = "rack";
    held.link = 0;
    for (int i = 0; i < balls; ++i)
      held.object.geometries.push_back(
          {collision::Shape::sphere(0.01), test::at(0.02 * (i % 64), 0.02 * (i / 64), -3), ""});
    problem.robot.attachments.push_back(held);
    const auto scene = std::make_shared<const CompiledScene>(problem);
    const EdgePairs& pairs = scene->edges().pairs;
    const std::vector<int>& of_world = scene->edgeModel().robot->motions().of_world;
    std::size_t still = 0;
    for (std::size_t p = 0; p < pairs.numbers(); ++p) {
      const EdgePair pair = pairs[p];
      if (scene->edges().pieces[static_cast<std::size_t>(pair.b)].link >= 0) continue;
      ++still;
      ASSERT_EQ(pair.motion, of_world[static_cast<std::size_t>(pair.a)]) << balls << " " << p;
    }
    EXPECT_GT(still, static_cast<std::size_t>(4 * balls));
    EXPECT_EQ(EdgeCertifier(scene).certify(q, q).verdict, Verdict::kFree);
  }
}

/// If an object is so large that lanes are not usable, lanes have no world, and no query uses it.
TEST(ManyObjects, LanesThatAreNotUsableNeedNoWorld) {
  Problem problem =
      test::problemOf(test::flyingBox(), {0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1});
  for (int i = 0; i < kFar; ++i)
    problem.world.objects.push_back({"far " + std::to_string(i),
                                     {{collision::Shape::sphere(0.1), {}, "ball"}},
                                     test::at(20 + i % 128, 20 + i / 128, 0)});
  const std::vector<Eigen::Vector3d> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  problem.world.objects.push_back(
      {"hill", {{collision::Shape::convexHull(corners), {}, "hull"}}, test::at(20000, 0, 0)});
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  std::vector<double> end = problem.start;
  end[0] = 0.5;
  EXPECT_EQ(certifier.certify(problem.start, end).verdict, Verdict::kFree);
  EXPECT_EQ(certifier.decide(end), Verdict::kFree);
}

/// `count` objects within the box around a turned flyer, but next to it; one of them is placed on
/// it.
Problem thingsBesideAFlyer(const std::vector<double>& at, const collision::Shape& shape,
                           std::size_t count, std::size_t intruder) {
  Problem problem = test::problemOf(test::flyingBox(), at, at);
  for (std::size_t i = 0; i < count; ++i) {
    const collision::Pose X_WB = i == intruder
                                     ? test::at(0, 0, 0)
                                     : test::at(-0.05 + 0.001 * static_cast<double>(i % 100),
                                                0.040 + 0.0003 * static_cast<double>(i / 100 % 27),
                                                0.040 + 0.0003 * static_cast<double>(i / 2700));
    problem.world.objects.push_back({"thing " + std::to_string(i), {{shape, {}, "shape"}}, X_WB});
  }
  return problem;
}

/// More pairs are near at once than are kept: some are not checked, and a pair in contact is never
/// free.
TEST(ManyObjects, MoreThanAreKeptAreNearAtOnce) {
  constexpr std::size_t kKept = collision::LaneSweep::kMostNear, kNear = kKept + 4000;
  const double w = std::cos(0.125 * std::numbers::pi), x = std::sin(0.125 * std::numbers::pi);
  const std::vector<double> a = {-0.05, 0, 0, x, 0, 0, w}, b = {0.05, 0, 0, x, 0, 0, w};
  const auto small = collision::Shape::box(Eigen::Vector3d::Constant(5e-5));
  // If all are kept, they are decided.
  EdgeCertifier kept(std::make_shared<const CompiledScene>(
      thingsBesideAFlyer(a, small, kKept - 4000, std::string::npos)));
  EXPECT_EQ(kept.decide(a), Verdict::kFree);
  // Balls that are apart from a cover need not be kept.
  EdgeCertifier of_balls(std::make_shared<const CompiledScene>(
      thingsBesideAFlyer(a, collision::Shape::sphere(1e-4), kNear, std::string::npos)));
  EXPECT_EQ(of_balls.decide(a), Verdict::kFree);
  for (const std::size_t intruder : {kNear, std::size_t{0}, kNear / 2, kNear - 1}) {
    const auto scene =
        std::make_shared<const CompiledScene>(thingsBesideAFlyer(a, small, kNear, intruder));
    EdgeCertifier certifier(scene);
    EXPECT_EQ(certifier.decide(a), Verdict::kUndecided) << intruder;
    const bool is_free = intruder == kNear;
    const Verdict wrong = is_free ? Verdict::kNotFree : Verdict::kFree;
    EXPECT_NE(certifier.certify(a, b).verdict, wrong) << intruder;
    const StateCheck state = certifier.clearance(a, 1e-4);
    if (is_free) {
      EXPECT_GT(state.clearance.upper, 0);
    } else {
      EXPECT_LT(state.clearance.lower, 0) << intruder;
    }
  }
}

/// Names of allowed pairs and margins are looked up, not compared with all pairs.
TEST(ManyObjects, PairsAndMarginsAreFoundByName) {
  Random random(33);
  const CompiledScene scene(crowd(random));
  int wide = 0;
  for (const collision::ScenePair& pair : scene.scene().pairs()) {
    const std::string& name = scene.scene().bodies()[static_cast<std::size_t>(pair.body_b)].name;
    EXPECT_NE(name, "thing 7");
    EXPECT_EQ(pair.margin, name == "thing 8" ? 0.3 : 0.01) << name;
    wide += name == "thing 8";
  }
  EXPECT_EQ(wide, 1);
  ASSERT_EQ(scene.dropped().size(), 1U);
  EXPECT_EQ(scene.dropped()[0].b, "thing 7");
}

}  // namespace
}  // namespace leeway::planner
