#include "leeway/planner/edge_certifier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"
#include "planner/edge/edge_frames.h"
#include "robots/motion/link_gaps.h"
#include "tests/support/allocations.h"
#include "tests/support/random_problem.h"
#include "tests/support/sanitized.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using testing::Random;

/// Slow twin: distance() of every pair at single configurations.
class DenseTwin {
 public:
  explicit DenseTwin(const CompiledScene& compiled)
      : compiled_(compiled),
        poses_(compiled.model().links.size()),
        q_(compiled.model().variables.size()) {}

  /// Minimum separation minus margin at a point; with `signed_distance`, minimum separation
  /// including depth.
  double at(std::span<const double> point, bool signed_distance = false) {
    compiled_.expand(point, q_);
    robots::forwardKinematics(compiled_.model(), q_, poses_);
    double least = kInfinity;
    for (const collision::ScenePair& pair : compiled_.scene().pairs()) {
      const collision::Body& a = compiled_.scene().bodies()[static_cast<std::size_t>(pair.body_a)];
      const collision::Body& b = compiled_.scene().bodies()[static_cast<std::size_t>(pair.body_b)];
      const collision::Geometry& g = a.geometries[static_cast<std::size_t>(pair.geometry_a)];
      const collision::Geometry& h = b.geometries[static_cast<std::size_t>(pair.geometry_b)];
      const auto ask = [&](double threshold) {
        collision::DistanceRequest request;
        request.depth = signed_distance;
        request.threshold = threshold;
        return collision::distance(g.shape, pose(pair.body_a) * g.X_BG, h.shape,
                                   pose(pair.body_b) * h.X_BG, request, scratch_)
            .distance;
      };
      const double enough = least + (signed_distance ? 0 : pair.margin);  // farther is irrelevant
      if (std::isfinite(enough) && ask(enough).lower > enough) continue;
      const collision::Interval d = ask(std::nan(""));
      least = std::min(least, d.upper - (signed_distance ? 0 : pair.margin));
    }
    return least;
  }

  /// Lower bound on the separation of one pair minus its margin.
  double lowestOf(std::span<const double> point, int pair_index) {
    compiled_.expand(point, q_);
    robots::forwardKinematics(compiled_.model(), q_, poses_);
    const collision::ScenePair& pair =
        compiled_.scene().pairs()[static_cast<std::size_t>(pair_index)];
    const collision::Geometry& g = compiled_.scene()
                                       .bodies()[static_cast<std::size_t>(pair.body_a)]
                                       .geometries[static_cast<std::size_t>(pair.geometry_a)];
    const collision::Geometry& h = compiled_.scene()
                                       .bodies()[static_cast<std::size_t>(pair.body_b)]
                                       .geometries[static_cast<std::size_t>(pair.geometry_b)];
    return collision::distance(g.shape, pose(pair.body_a) * g.X_BG, h.shape,
                               pose(pair.body_b) * h.X_BG, {}, scratch_)
               .distance.lower -
           pair.margin;
  }

  /// Minimum over an edge: `samples` positions, refined around the least.
  double along(std::span<const double> a, std::span<const double> b, int samples,
               bool signed_distance = false, double to = 1) {
    double best = kInfinity, best_t = 0;
    std::vector<double> point(a.size());
    const auto look = [&](double t) {
      compiled_.space().interpolate(a, b, t, point);
      const double d = at(point, signed_distance);
      if (d < best) {
        best = d;
        best_t = t;
      }
    };
    for (int i = 0; i <= samples; ++i) look(to * i / samples);
    const double around = best_t, step = to / samples;
    for (int i = -20; i <= 20; ++i) look(std::clamp(around + step * i / 20, 0.0, to));
    return best;
  }

 private:
  collision::Pose pose(int body) const {
    const int link = compiled_.bodyLink(body);
    return link < 0 ? compiled_.scene().bodies()[static_cast<std::size_t>(body)].X_WB
                    : poses_[static_cast<std::size_t>(link)];
  }
  const CompiledScene& compiled_;
  std::vector<collision::Pose> poses_;
  std::vector<double> q_;
  collision::Scratch scratch_;
};

std::vector<double> randomPoint(Random& random, const CompiledScene& compiled) {
  return robots::testing::randomConfiguration(random, compiled.model());
}

enum class Kind { kArm, kFree, kPlanar, kTree, kMeshes };

Problem problemOf(Random& random, Kind kind) {
  switch (kind) {
    case Kind::kArm:
      return testing::randomProblem(random, testing::randomArm(random), 6, 1.2);
    case Kind::kFree:
      return testing::randomProblem(
          random, testing::randomFreeBody(random, robots::JointType::kFloating), 12, 1.2);
    case Kind::kPlanar:
      return testing::randomProblem(
          random, testing::randomFreeBody(random, robots::JointType::kPlanar), 12, 1.0);
    case Kind::kMeshes: {  // a free mesh among meshes
      Problem problem = testing::randomProblem(
          random,
          robots::freeBody("body", {{testing::randomMesh(random, 0.4), random.pose(0.25), "part"}},
                           robots::JointType::kFloating, Eigen::Vector3d::Constant(-1.5),
                           Eigen::Vector3d::Constant(1.5)),
          12, 1.2);
      for (Object& object : problem.world.objects)
        if (object.name != "floor") object.geometries[0].shape = testing::randomMesh(random, 0.25);
      return problem;
    }
    case Kind::kTree:
      break;
  }
  return testing::randomProblem(random, testing::randomTreeWithShapes(random), 8, 1.0);
}

std::string replay(const std::vector<double>& a, const std::vector<double>& b) {
  std::string text = "a";
  char number[32];
  for (const std::vector<double>* v : {&a, &b}) {
    for (const double x : *v) {
      std::snprintf(number, sizeof number, " %.17g", x);
      text += number;
    }
    if (v == &a) text += "\nb";
  }
  return text;
}

struct Tally {
  int edges = 0, free = 0, not_free = 0, undecided = 0, unsafe = 0, cautious = 0, wrong_prefix = 0,
      prefixes = 0, places = 0;
};

void checkRandomEdges(Kind kind, int problems, int edges, std::uint64_t seed, Tally& tally) {
  Random random(seed);
  for (int p = 0; p < problems; ++p) {
    Problem problem = problemOf(random, kind);
    if (p % 2 == 1)
      for (Object& object : problem.world.objects)
        if (random.integer(2) == 0 && object.name != "floor")
          object.geometries[0].shape = testing::randomMesh(random, 0.25);
    const auto compiled = std::make_shared<const CompiledScene>(problem);
    EdgeCertifier certifier(compiled);
    DenseTwin twin(*compiled);
    std::vector<double> a_before, goal_before;
    for (int e = 0; e < edges; ++e) {
      // Starts free where possible, like a search's edges.
      std::vector<double> a = randomPoint(random, *compiled), b(a.size());
      for (int k = 0; k < 30 && certifier.decide(a) != Verdict::kFree; ++k)
        a = randomPoint(random, *compiled);
      std::vector<double> goal = randomPoint(random, *compiled);
      // Every other edge is near its predecessor, to exercise the cached contact.
      if (e % 2 == 1 && !a_before.empty()) {
        const std::vector<double> from = a, to = goal;
        compiled->space().interpolate(a_before, from, 0.02, a);
        compiled->space().interpolate(goal_before, to, 0.02, goal);
      }
      a_before = a;
      goal_before = goal;
      compiled->space().interpolate(a, goal, random.uniform(0.05, 1), b);
      std::vector<double> difference(a.size());
      compiled->space().difference(a, b, difference);
      if (!compiled->edgeModel().isSmooth(a, b, difference))
        continue;  // a mimic joint would jump: never certified
      EdgeRequest request;
      request.last_valid = true;
      const EdgeCheck check = certifier.certify(a, b, request);
      const double dense = twin.along(a, b, 60);
      ++tally.edges;
      tally.free += check.verdict == Verdict::kFree;
      tally.not_free += check.verdict == Verdict::kNotFree;
      tally.undecided += check.verdict == Verdict::kUndecided;
      if (check.verdict == Verdict::kFree && dense <= 0) {
        ++tally.unsafe;
        ADD_FAILURE() << "unsafe: seed " << seed << " problem " << p << " edge " << e << " dense "
                      << dense << "\n"
                      << replay(a, b);
      }
      if (check.verdict != Verdict::kFree && dense > 1e-4) {
        ++tally.cautious;
        // "Not free" is proven; only "undecided" may be cautious.
        EXPECT_EQ(check.verdict, Verdict::kUndecided)
            << "seed " << seed << " problem " << p << " edge " << e << "\n"
            << replay(a, b);
      }
      if (check.verdict == Verdict::kNotFree && check.pair >= 0) {
        // The pair is in contact at that place, to within the rounding that margins include.
        ++tally.places;
        EXPECT_GE(check.t, 0);
        EXPECT_LE(check.t, 1);
        std::vector<double> there(a.size());
        compiled->space().interpolate(a, b, check.t, there);
        EXPECT_LE(twin.lowestOf(there, check.pair), 1e-5)
            << "t " << check.t << " pair " << check.pair << ": seed " << seed << " problem " << p
            << " edge " << e << "\n"
            << replay(a, b);
      }
      if (check.verdict == Verdict::kFree) {
        EXPECT_EQ(check.last_valid, 1);
      } else if (check.last_valid > 0) {
        ++tally.prefixes;
        if (twin.along(a, b, 40, false, check.last_valid) <= 0) {
          ++tally.wrong_prefix;
          ADD_FAILURE() << "last_valid " << check.last_valid << ": seed " << seed << " problem "
                        << p << " edge " << e << "\n"
                        << replay(a, b);
        }
      }
    }
  }
}

class RandomEdges : public ::testing::TestWithParam<Kind> {};

TEST_P(RandomEdges, AgreeWithDenseSampling) {
  Tally tally;
  checkRandomEdges(GetParam(), 30, 15, 100 + static_cast<std::uint64_t>(GetParam()), tally);
  RecordProperty("free", tally.free);
  std::printf("edges %d free %d not free %d undecided %d cautious %d prefixes %d\n", tally.edges,
              tally.free, tally.not_free, tally.undecided, tally.cautious, tally.prefixes);
  EXPECT_EQ(tally.unsafe, 0);
  EXPECT_EQ(tally.wrong_prefix, 0);
  EXPECT_LE(tally.cautious, tally.edges / 200);
  // Guards the test: answers of both kinds and prefixes occur often.
  EXPECT_GT(tally.free, tally.edges / 10);
  EXPECT_GT(tally.not_free, tally.edges / 10);
  EXPECT_GT(tally.prefixes, tally.edges / 20);
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomEdges,
                         ::testing::Values(Kind::kArm, Kind::kFree, Kind::kPlanar, Kind::kTree,
                                           Kind::kMeshes));

// A wire thinner than any step, missed by all samples of a stepping check.
TEST(EdgeCertifier, NeverMissesAThinWire) {
  Random random(7);
  for (int run = 0; run < 200; ++run) {
    Problem problem = test::problemOf(test::disc(), {-1, 0, 0}, {1, 0, 0});
    Object wire;
    wire.name = "wire";
    const double radius = std::pow(10, random.uniform(-9, -4));
    wire.geometries.push_back({collision::Shape::capsule(radius, 0.5), {}, "wire"});
    wire.X_WO.translation = {random.uniform(-0.7, 0.7), random.uniform(-0.09, 0.09), 0};
    problem.world.objects.push_back(wire);
    // A needle, 1e-6 long in x, its direction of travel.
    auto model =
        robots::freeBody("needle", {{collision::Shape::box({1e-7, 0.1, 0.1}), {}, "needle"}},
                         robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0});
    problem.robot.model = model;
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    const EdgeCheck check =
        certifier.certify(std::vector<double>{-1, 0, 0}, std::vector<double>{1, 0, 0.3});
    ASSERT_NE(check.verdict, Verdict::kFree) << run;
  }
}

/// A square wall of 4 m at z = 0 with a central window of 1 m.
Object wallWithWindow() {
  std::vector<Eigen::Vector3d> corners;
  std::vector<collision::TriangleMesh::Triangle> triangles;
  for (const double half : {2.0, 0.5}) {
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      corners.emplace_back(half * x, half * y, 0);
  }
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    triangles.push_back({i, j, j + 4});
    triangles.push_back({i, j + 4, i + 4});
  }
  Object wall;
  wall.name = "wall";
  wall.geometries.push_back(
      {collision::Shape::mesh(collision::TriangleMesh::make(corners, triangles)), {}, "wall"});
  return wall;
}

// The way is ten thousand times the body's length; every work limit is sufficient.
TEST(EdgeCertifier, ASmallMeshFliesThroughAWindow) {
  for (const double half : {0.1, 0.01, 0.001, 1e-4, 1e-5}) {
    std::vector<Eigen::Vector3d> corners;
    std::vector<collision::TriangleMesh::Triangle> triangles;
    testing::appendBox(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(half), corners,
                       triangles);
    const collision::Shape cube =
        collision::Shape::mesh(collision::TriangleMesh::make(corners, triangles));
    Problem problem = test::problemOf(
        robots::freeBody("cube", {{cube, {}, "cube"}}, robots::JointType::kFloating,
                         Eigen::Vector3d::Constant(-2), Eigen::Vector3d::Constant(2)),
        {0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1});
    problem.world.objects.push_back(wallWithWindow());
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    const std::vector<double> before{-0.9, -0.2, -1, 0, 0, 0, 1}, behind{1.1, 0.25, 1, 0, 0, 0, 1},
        beside{1.1, 1.25, 1, 0, 0, 0, 1};
    for (const int limit : {0, 16'777'216, std::numeric_limits<int>::max()}) {
      EdgeRequest request;
      request.work_limit = limit;
      EXPECT_EQ(certifier.certify(before, behind, request).verdict, Verdict::kFree)
          << half << ", limit " << limit;
      EXPECT_EQ(certifier.certify(before, beside, request).verdict, Verdict::kNotFree)
          << half << ", limit " << limit;
    }
  }
}

/// A closed mesh of 2 m cubes at the given centres.
Object solidCubes(const std::vector<Eigen::Vector3d>& centers) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<collision::TriangleMesh::Triangle> triangles;
  for (const Eigen::Vector3d& c : centers)
    testing::appendBox(c, Eigen::Vector3d::Ones(), vertices, triangles);
  Object solid;
  solid.name = "solid";
  solid.geometries.push_back(
      {collision::Shape::mesh(collision::TriangleMesh::make(vertices, triangles)), {}, "solid"});
  return solid;
}

Object solidBox() { return solidCubes({Eigen::Vector3d::Zero()}); }

// A box inside a hollow one never meets its surface: sweeps of surfaces alone would call it free.
TEST(EdgeCertifier, ABodyInsideASolidIsNotFree) {
  Problem problem = test::problemOf(test::disc(), {0, 0, 0}, {0.1, 0, 0});
  problem.world.objects.push_back(solidBox());
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  EXPECT_EQ(
      certifier.certify(std::vector<double>{0, 0, 0}, std::vector<double>{0.3, 0.2, 1}).verdict,
      Verdict::kNotFree);
  EXPECT_LE(certifier
                .edgeClearance(std::vector<double>{0, 0, 0}, std::vector<double>{0.3, 0.2, 1}, 1e-3,
                               -kInfinity)
                .clearance.upper,
            0);
}

// A body may enter this solid slightly; between both places it does not meet the surface.
TEST(EdgeCertifier, AllowedDepthIsNotExceededInsideASolid) {
  Problem problem =
      test::problemOf(robots::freeBody("ball", {{collision::Shape::sphere(0.01), {}, "ball"}},
                                       robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0}),
                      {0, 0, 0}, {0.1, 0, 0});
  problem.world.objects.push_back(solidBox());
  problem.margins.common = -0.1;
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const std::vector<double> middle{0, 0, 0}, shallow{0.95, 0, 0}, out{1.2, 0, 0},
      aside{0.95, 0.5, 0};
  EXPECT_EQ(certifier.decide(middle), Verdict::kNotFree);
  EXPECT_EQ(certifier.decide(shallow), Verdict::kFree);
  EXPECT_NE(certifier.certify(middle, shallow).verdict, Verdict::kFree);
  EXPECT_NE(certifier.certify(shallow, std::vector<double>{-0.95, 0, 0}).verdict, Verdict::kFree);
  EXPECT_EQ(certifier.certify(out, std::vector<double>{1.2, 0.5, 0}).verdict, Verdict::kFree);
  EdgeRequest request;
  request.last_valid = true;
  EXPECT_LT(certifier.certify(shallow, middle, request).last_valid, 0.1);
}

/// A random tree of links with a hull each, and the proofs about pairs of them.
std::shared_ptr<robots::Model> treeWithGaps(Random& random) {
  const auto model = robots::testing::randomTree(random, 5);
  for (robots::Link& link : model->links) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 12; ++i) points.push_back(random.vector(0.12));
    link.geometries.push_back({collision::Shape::convexHull(points), random.pose(0.15), ""});
  }
  model->keepGaps(robots::provenGaps(*model));
  return model;
}

// Link-gap tables prove distances, never depths. Regression: with a negative margin, pairs without
// a proof were free at any angle.
TEST(EdgeCertifier, AllowedDepthIsThatOfLinksWithTables) {
  Random random(8);
  int free = 0, deep = 0, tables = 0;
  for (int run = 0; run < 40; ++run) {
    const auto model = treeWithGaps(random);
    tables += static_cast<int>(model->linkGaps().size());
    Problem problem =
        test::problemOf(model, model->defaultConfiguration(), model->defaultConfiguration());
    for (const double margin : {-0.005, -0.02, 0.005}) {
      problem.margins.common = margin;
      const auto scene = std::make_shared<const CompiledScene>(problem);
      EdgeCertifier certifier(scene);
      DenseTwin twin(*scene);
      for (int i = 0; i < 30; ++i) {
        const std::vector<double> a = randomPoint(random, *scene);
        std::vector<double> b = a;
        for (double& x : b) x += random.uniform(-0.05, 0.05);
        const double least = twin.at(a, true);
        if (certifier.decide(a) == Verdict::kFree) {
          ASSERT_GT(least, margin) << "run " << run << ", state " << i;
          ++free;
        } else if (least < margin) {
          ++deep;
        }
        if (certifier.certify(a, b).verdict != Verdict::kFree) continue;
        ASSERT_GT(twin.along(a, b, 10, true), margin) << "run " << run << ", edge " << i;
      }
    }
  }
  EXPECT_GT(tables, 20);
  EXPECT_GT(free, 300);
  EXPECT_GT(deep, 100);
}

// A depth query that stops at a threshold may know less than a full one. Regression: states stayed
// undecided that a full query proves free.
TEST(EdgeCertifier, AllowedDepthIsDecidedWhereItIsKnown) {
  Random random(21);
  int free = 0;
  for (int run = 0; run < 60; ++run) {
    const auto body = robots::freeBody("body", {{testing::randomMesh(random, 0.5), {}, "mesh"}},
                                       robots::JointType::kFloating, {-1, -1, -1}, {1, 1, 1});
    Problem problem =
        test::problemOf(body, body->defaultConfiguration(), body->defaultConfiguration());
    problem.world.objects = {
        {"thing", {{testing::randomMesh(random, 0.5), {}, "mesh"}}, random.pose(0.1)}};
    problem.margins.common = -random.uniform(0.05, 0.4);
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    for (int i = 0; i < 10; ++i) {
      const std::vector<double> q = robots::testing::randomConfiguration(random, *body);
      const Verdict verdict = certifier.decide(q);
      if (!(certifier.clearance(q, 1e-6).clearance.lower > problem.margins.common + 1e-6)) continue;
      ++free;
      EXPECT_EQ(verdict, Verdict::kFree) << "run " << run << ", state " << i;
    }
  }
  EXPECT_GT(free, 100);
}

// Each ball of a cover may have its own way out, so single depths do not bound the body's.
TEST(EdgeCertifier, AllowedDepthIsThatOfTheWholeBody) {
  const auto of = [](const collision::Shape& body, const Object& obstacle, double margin) {
    Problem problem =
        test::problemOf(robots::freeBody("body", {{body, {}, "body"}}, robots::JointType::kPlanar,
                                         {-2, -2, 0}, {2, 2, 0}),
                        {0, 0, 0}, {0.1, 0, 0});
    problem.world.objects.push_back(obstacle);
    problem.margins.common = margin;
    return std::make_shared<const CompiledScene>(problem);
  };
  Object ball;
  ball.name = "ball";
  ball.geometries.push_back({collision::Shape::sphere(0.05), {}, "ball"});
  const collision::Shape box = collision::Shape::box({0.5, 0.5, 0.5});
  // The edge starts at depth 0.367.
  EXPECT_NE(
      EdgeCertifier(of(box, ball, -0.3))
          .certify(
              std::vector<double>{0.11949160664579406, 0.14269096173777007, 0.7007467647857355},
              std::vector<double>{0.19798601666998913, 0.21718365313340471, 0.76789479203553201})
          .verdict,
      Verdict::kFree);
  Random random(7);
  int free = 0, deep = 0;
  for (const double margin : {-0.1, -0.2, -0.3}) {
    for (const auto& scene :
         {of(box, ball, margin), of(collision::Shape::sphere(0.05), solidBox(), margin)}) {
      EdgeCertifier certifier(scene);
      const double reach = random.integer(2) == 0 ? 1.1 : 0.6;
      for (int i = 0; i < 1500; ++i) {
        std::vector<double> a, b;
        for (int k = 0; k < 3; ++k) {
          a.push_back(random.uniform(-reach, reach));
          b.push_back(a.back() + random.uniform(-0.1, 0.1));
        }
        if (certifier.certify(a, b).verdict != Verdict::kFree) continue;
        ++free;
        for (const double t : {0.0, 0.5, 1.0}) {
          std::vector<double> point(3);
          scene->space().interpolate(a, b, t, point);
          const Interval clearance = certifier.clearance(point, 1e-6).clearance;
          ASSERT_GE(clearance.upper, margin) << a[0] << ' ' << a[1] << ' ' << a[2] << " at " << t;
          deep += clearance.upper < 0 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(free, 1000);
  EXPECT_GT(deep, 100);
}

// A ball's centre, outside the body, within 1e-23 of an obstacle's: the square of that offset
// underflows in single precision.
TEST(EdgeCertifier, AWayThatIsNoDirectionPartsNothing) {
  const std::vector<Eigen::Vector3d> corners = {
      {-0.5, -0.5, -0.5}, {0.5, -0.5, -0.5}, {-0.5, 0.5, -0.5}, {-0.5, -0.5, 0.5}};
  const auto of = [&](double radius, double margin) {
    Problem problem = test::problemOf(
        robots::freeBody("hull", {{collision::Shape::convexHull(corners), {}, "hull"}},
                         robots::JointType::kFloating, Eigen::Vector3d::Constant(-2),
                         Eigen::Vector3d::Constant(2)),
        {0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1});
    Object ball;
    ball.name = "ball";
    ball.geometries.push_back({collision::Shape::sphere(radius), {}, "ball"});
    problem.world.objects.push_back(ball);
    problem.margins.common = margin;
    return std::make_shared<const CompiledScene>(problem);
  };
  for (const double off : {0.0, 1e-14, 1e-16, 1e-18, 1e-20, 1e-22, 1e-23, 1e-24, 1e-26, 1e-40}) {
    const std::vector<double> place{-off, -off, -off, 0, 0, 0, 1};
    for (const double radius : {0.289, 0.2895, 0.292, 0.3, 0.35}) {
      EdgeCertifier certifier(of(radius, 0));
      const Verdict verdict = certifier.certify(place, place).verdict;
      // The facet is at 0.5 / 3^(1/2).
      EXPECT_EQ(verdict == Verdict::kFree, radius < 0.5 / std::sqrt(3) - off)
          << off << ' ' << radius;
    }
    // It must not be cached as a separating plane either.
    EdgeCertifier certifier(of(0.26, 0.05));
    certifier.certify(place, place);
    EXPECT_NE(certifier
                  .certify(std::vector<double>{0.01, -0.004, -0.004, 0, 0, 0, 1},
                           std::vector<double>{-0.004, 0.01, -0.004, 0, 0, 0, 1})
                  .verdict,
              Verdict::kFree)
        << off;
  }
}

// A plate turning in a slot touches both walls at once: no short translation separates them.
TEST(EdgeCertifier, ATurnLocksAPlateInASlot) {
  Problem problem = test::problemOf(
      robots::freeBody("plate", {{collision::Shape::box({0.5, 0.02, 0.1}), {}, "plate"}},
                       robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0}),
      {0, 0, 0}, {0.1, 0, 0});
  problem.world.objects.push_back(solidCubes({{0, 1.025, 0}, {0, -1.025, 0}}));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const std::vector<double> straight{0, 0, 0}, turned{0, 0, 0.0101};
  EXPECT_EQ(certifier.decide(straight), Verdict::kFree);
  EXPECT_EQ(certifier.decide(turned), Verdict::kNotFree);
  const Interval clearance = certifier.edgeClearance(straight, turned, 1e-3, -kInfinity).clearance;
  EXPECT_LT(clearance.lower, -1);
  EXPECT_LT(clearance.upper, 1e-5);
  const Interval before =
      certifier.edgeClearance(straight, std::vector<double>{0, 0, 0.009}, 1e-3, -kInfinity)
          .clearance;
  EXPECT_GT(before.lower, -1e-3);
  EXPECT_LT(before.upper - before.lower, 1.001e-3);
}

// Depths of meshes are slow. Their work is counted, and at the limit the interval stays wide.
// Regression: 1,572 of them took 2 s and ended without a lower end.
TEST(EdgeCertifier, ClearanceOfMeshesDeepInEachOtherEndsWithItsWork) {
  Problem problem =
      test::problemOf(robots::freeBody("ring", {{testing::bumpyRing(), {}, "ring"}},
                                       robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0}),
                      {-0.3, 0, 0}, {0.3, 0.1, 0.5});
  for (const double side : {-1.0, 1.0}) {
    Object object;
    object.name = side < 0 ? "left" : "right";
    object.geometries.push_back({testing::bumpyRing(), {}, object.name});
    object.X_WO.rotation =
        Eigen::AngleAxisd(2 * side, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
    object.X_WO.translation = {0.2 * side, 0.05, 0.1 * side};
    problem.world.objects.push_back(object);
  }
  problem.margins.common = -0.5;
  const auto compiled = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(compiled);
  DenseTwin twin(*compiled);
  const std::vector<double> a{-0.3, 0, 0}, b{0.3, 0.1, 0.5};
  const Interval clearance = certifier.edgeClearance(a, b, 1e-3, -kInfinity).clearance;
  EXPECT_LT(certifier.statistics.distance_queries, 700U);
  EXPECT_LE(clearance.lower, clearance.upper);
  EXPECT_LT(clearance.upper, -0.1);
  std::vector<double> point(a.size());
  for (const double t : {0.0, 0.3, 0.7, 1.0}) {
    compiled->space().interpolate(a, b, t, point);
    EXPECT_LE(clearance.lower, twin.at(point, true)) << t;
  }
}

TEST(EdgeCertifier, ClearanceHoldsTheDenseMinimum) {
  Random random(11);
  int apart = 0, overlapping = 0, wide = 0;
  for (const Kind kind : {Kind::kArm, Kind::kFree, Kind::kPlanar, Kind::kTree})
    for (int p = 0; p < 10; ++p) {
      const auto compiled = std::make_shared<const CompiledScene>(problemOf(random, kind));
      EdgeCertifier certifier(compiled);
      DenseTwin twin(*compiled);
      for (int e = 0; e < 6; ++e) {
        std::vector<double> a = randomPoint(random, *compiled), b(a.size());
        for (int k = 0; k < 30 && certifier.decide(a) != Verdict::kFree; ++k)
          a = randomPoint(random, *compiled);
        compiled->space().interpolate(a, randomPoint(random, *compiled), random.uniform(0.02, 0.4),
                                      b);
        const double tolerance = 1e-3;
        const EdgeClearance result = certifier.edgeClearance(a, b, tolerance, -kInfinity);
        const double dense = twin.along(a, b, 60, true);
        if (dense == kInfinity) continue;
        (dense > 0 ? apart : overlapping) += 1;
        std::vector<double> difference(a.size());
        compiled->space().difference(a, b, difference);
        if (!compiled->edgeModel().isSmooth(a, b, difference)) {
          // A mimic joint jumps where its master crosses its seam.
          EXPECT_EQ(result.clearance.lower, -kInfinity);
          ++wide;
          continue;
        }
        EXPECT_LE(result.clearance.lower, dense + 1e-9) << "problem " << p << " edge " << e << "\n"
                                                        << replay(a, b);
        // Samples cannot be below the minimum.
        EXPECT_LE(result.clearance.upper, dense + tolerance + 1e-9)
            << "problem " << p << " edge " << e << "\n"
            << replay(a, b);
        EXPECT_LE(result.clearance.lower, result.clearance.upper);
        wide += !(result.clearance.width() <= tolerance * 1.0001);
        std::vector<double> point(a.size());
        compiled->space().interpolate(a, b, result.t, point);
        EXPECT_NEAR(twin.at(point, true), result.clearance.upper, tolerance);
        const EdgeClearance cut = certifier.edgeClearance(a, b, tolerance, dense + 0.01);
        EXPECT_LT(cut.clearance.upper, dense + 0.01);
      }
    }
  std::printf("apart %d overlapping %d wide %d\n", apart, overlapping, wide);
  EXPECT_GT(apart, 30);
  EXPECT_GT(overlapping, 10);
  EXPECT_LE(wide, (apart + overlapping) / 50);
}

TEST(EdgeCertifier, WhatIsAskedBeyondMarginsIsKeptAlongTheEdge) {
  Random random(19);
  int free = 0, near = 0, cautious = 0;
  for (const Kind kind : {Kind::kArm, Kind::kFree, Kind::kPlanar, Kind::kTree})
    for (int p = 0; p < 12; ++p) {
      Problem problem = problemOf(random, kind);
      const double margins[] = {0, 0.02, -0.02}, margin = margins[p % 3];
      problem.margins.common = margin;
      const auto compiled = std::make_shared<const CompiledScene>(problem);
      // By lanes, and by bisection.
      EdgeCertifier certifier(compiled), rebound(compiled);
      rebound.rebind(compiled->withMarginAtLeast(-kInfinity));
      DenseTwin twin(*compiled);
      for (int e = 0; e < 8; ++e) {
        const std::vector<double> a = randomPoint(random, *compiled);
        std::vector<double> b(a.size());
        compiled->space().interpolate(a, randomPoint(random, *compiled), random.uniform(0.01, 0.2),
                                      b);
        const double dense = twin.along(a, b, 40, true), beyond = random.uniform(0, 0.1);
        for (EdgeCertifier* const asked : {&certifier, &rebound}) {
          EdgeRequest request = EdgeRequest::persistent();
          request.beyond = beyond;
          if (asked->certify(a, b, request).verdict == Verdict::kFree) {
            ++free;
            EXPECT_GT(dense, margin + beyond - 1e-9) << replay(a, b);
          } else {
            ++near;
            cautious += dense > margin + beyond + 0.02 && dense < kInfinity ? 1 : 0;
          }
          // That belongs to one request; the next one does not have it.
          const Verdict plain = asked->certify(a, b, EdgeRequest::persistent()).verdict;
          EXPECT_TRUE(plain != Verdict::kFree || dense > margin - 1e-9) << replay(a, b);
        }
      }
    }
  const auto compiled = std::make_shared<const CompiledScene>(problemOf(random, Kind::kArm));
  const std::vector<double> a = randomPoint(random, *compiled);
  EdgeCertifier certifier(compiled);
  for (const double wrong : {-1e-9, -kInfinity, kInfinity, std::nan("")}) {
    EdgeRequest request;
    request.beyond = wrong;
    EXPECT_EQ(certifier.certify(a, a, request).verdict, Verdict::kUndecided) << wrong;
  }
  EXPECT_GT(free, 60);
  EXPECT_GT(near, 60);
  EXPECT_LE(cautious, near / 10);
}

TEST(EdgeCertifier, ClearanceThatLanesBeganIsThatOfIntervalsAlone) {
  Random random(14);
  int asked = 0;
  std::uint64_t with_lanes = 0, without = 0;
  for (const Kind kind : {Kind::kArm, Kind::kFree, Kind::kPlanar, Kind::kTree})
    for (int p = 0; p < 12; ++p) {
      Problem problem = problemOf(random, kind);
      const double margins[] = {0, 0.02, -0.02};
      problem.margins.common = margins[p % 3];
      if (p % 2 == 0 && !problem.world.objects.empty())
        problem.margins.pairs.push_back(
            {problem.world.objects[0].name, problem.robot.model->links.back().name, 0.1});
      const auto compiled = std::make_shared<const CompiledScene>(problem);
      EdgeCertifier certifier(compiled), twin(compiled);
      twin.rebind(compiled->withShapes({}));  // its lanes belong to another scene
      for (int e = 0; e < 10; ++e) {
        const std::vector<double> a = randomPoint(random, *compiled);
        std::vector<double> b(a.size());
        compiled->space().interpolate(a, randomPoint(random, *compiled), random.uniform(0.02, 0.6),
                                      b);
        const double tolerance = random.uniform(0, 1) < 0.5 ? 1e-3 : 1e-5;
        const Interval found = certifier.edgeClearance(a, b, tolerance, -kInfinity).clearance;
        const Interval truth = twin.edgeClearance(a, b, tolerance, -kInfinity).clearance;
        ++asked;
        EXPECT_LE(found.lower, truth.upper) << "problem " << p << "\n" << replay(a, b);
        EXPECT_LE(truth.lower, found.upper) << "problem " << p << "\n" << replay(a, b);
        if (truth.width() <= tolerance) {
          EXPECT_LE(found.width(), tolerance * 1.0001) << "problem " << p << "\n" << replay(a, b);
        }
      }
      with_lanes += certifier.statistics.distance_queries;
      without += twin.statistics.distance_queries;
    }
  std::printf("asked %d queries %llu, %llu without lanes\n", asked,
              static_cast<unsigned long long>(with_lanes),
              static_cast<unsigned long long>(without));
  EXPECT_GT(asked, 400);
  EXPECT_LT(with_lanes, without);
}

TEST(EdgeCertifier, StateClearanceIsTheLeastOverAllPairs) {
  Random random(12);
  for (const Kind kind : {Kind::kArm, Kind::kFree, Kind::kPlanar, Kind::kTree})
    for (int p = 0; p < 8; ++p) {
      const auto compiled = std::make_shared<const CompiledScene>(problemOf(random, kind));
      EdgeCertifier certifier(compiled);
      DenseTwin twin(*compiled);
      for (int s = 0; s < 20; ++s) {
        const std::vector<double> point = randomPoint(random, *compiled);
        const double truth = twin.at(point, true);
        const StateCheck check = certifier.clearance(point, 1e-6);
        EXPECT_LE(check.clearance.lower, truth + 1e-9) << replay(point, point);
        EXPECT_GE(check.clearance.upper, truth - 1e-6) << replay(point, point);
        if (truth < kInfinity) {
          EXPECT_LE(check.clearance.width(), 2e-6) << replay(point, point);
        }
        const double beyond = twin.at(point);
        if (std::abs(beyond) > 1e-6) {
          EXPECT_EQ(check.verdict, beyond > 0 ? Verdict::kFree : Verdict::kNotFree)
              << replay(point, point);
          EXPECT_EQ(certifier.decide(point), beyond > 0 ? Verdict::kFree : Verdict::kNotFree)
              << replay(point, point);
        }
      }
    }
}

TEST(EdgeCertifier, SameCallsSameAnswers) {
  Random random(13);
  const auto compiled = std::make_shared<const CompiledScene>(problemOf(random, Kind::kArm));
  std::vector<std::vector<double>> points;
  for (int i = 0; i < 60; ++i) points.push_back(randomPoint(random, *compiled));
  const auto run = [&] {
    EdgeCertifier certifier(compiled);
    std::vector<double> answers;
    for (std::size_t i = 1; i < points.size(); ++i) {
      EdgeRequest request;
      request.last_valid = true;
      const EdgeCheck check = certifier.certify(points[i - 1], points[i], request);
      const EdgeClearance clearance = certifier.edgeClearance(points[i - 1], points[i], 1e-3, 0);
      for (const double x : {static_cast<double>(check.verdict), check.last_valid, check.t,
                             clearance.clearance.lower, clearance.clearance.upper, clearance.t})
        answers.push_back(x);
    }
    return answers;
  };
  EXPECT_EQ(run(), run());
}

// A work limit may leave edges undecided but never changes an answer; a persistent request decides
// them.
TEST(EdgeCertifier, WorkThatIsSpentIsUndecidedAndNoOtherAnswer) {
  Random random(31);
  int undecided = 0, decided = 0;
  for (const Kind kind : {Kind::kArm, Kind::kFree, Kind::kMeshes, Kind::kTree}) {
    for (int run = 0; run < casesToAsk(6); ++run) {
      Problem problem = problemOf(random, kind);
      for (std::size_t i = 1; i < problem.world.objects.size(); i += 2)
        if (problem.world.objects[i].name != "floor")
          problem.world.objects[i].geometries[0].shape = testing::randomMesh(random, 0.25);
      const auto compiled = std::make_shared<const CompiledScene>(problem);
      for (int e = 0; e < 10; ++e) {
        const std::vector<double> a = randomPoint(random, *compiled),
                                  b = randomPoint(random, *compiled);
        const auto verdict = [&](const EdgeRequest& request) {
          return EdgeCertifier(compiled).certify(a, b, request).verdict;
        };
        const Verdict truth = verdict(EdgeRequest::persistent());
        for (const std::int64_t limit : {1, 3'000, 10'000, 30'000, 0}) {
          EdgeRequest request;
          request.work_limit = limit;
          const Verdict found = verdict(request);
          if (found != Verdict::kUndecided && truth != Verdict::kUndecided) {
            ++decided;
            EXPECT_EQ(found, truth) << "limit " << limit << "\n" << replay(a, b);
          }
          undecided += found == Verdict::kUndecided && truth != Verdict::kUndecided;
        }
      }
    }
  }
  EXPECT_GT(undecided, casesToAsk(100));
  EXPECT_GT(decided, casesToAsk(300));
}

// An unplanned virtual joint places a robot; its links do not fly. Regression: they were swept by
// surfaces against their base, like free bodies, and reached the work limit.
TEST(EdgeCertifier, WhatAVirtualJointPlacesDoesNotFly) {
  Random random(33);
  const collision::Shape mesh = testing::randomMesh(random, 0.1);
  robots::RobotDescription model =
      *robots::freeBody("base", {{mesh, {}, "base"}}, robots::JointType::kFloating,
                        Eigen::Vector3d::Constant(-1), Eigen::Vector3d::Ones());
  for (int i = 1; i < 3; ++i) {
    robots::Joint joint;
    joint.name = "turn" + std::to_string(i);
    joint.type = robots::JointType::kRevolute;
    joint.parent_link = i - 1;
    joint.child_link = i;
    joint.X_PJ.translation = {0.3, 0, 0};
    joint.axis = Eigen::Vector3d::UnitZ();
    joint.first_variable = static_cast<int>(model.variables.size());
    joint.variable_count = 1;
    model.variables.push_back({joint.name, i, -3, 3, 1});
    robots::Link link;
    link.name = "link" + std::to_string(i);
    link.joint = i;
    link.geometries.push_back({mesh, {}, link.name});
    model.joints.push_back(joint);
    model.links.push_back(link);
  }
  const auto shared = std::make_shared<const robots::Model>(model);
  std::vector<double> q = shared->defaultConfiguration();
  Problem problem = test::problemOf(shared, q, q);
  problem.world.objects.push_back({"rock", {{mesh, {}, "rock"}}, test::at(0, 0, 0.5)});
  EXPECT_TRUE(
      EdgeFrames(std::make_shared<const CompiledScene>(problem), 4).edges().has_surface_pairs);
  problem.robot.variables = {7, 8};
  problem.goals = {test::pointGoal("goal", {0, 0})};
  const auto still = std::make_shared<const CompiledScene>(problem);
  EXPECT_GT(still->scene().pairs().size(), 0U);
  EXPECT_FALSE(EdgeFrames(still, 4).edges().has_surface_pairs);
}

TEST(EdgeCertifier, WhatIsNoNumberIsUndecided) {
  const Problem problem = test::wallProblem();
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const std::vector<double> good{-1, -1, 0}, bad{std::nan(""), 0, 0}, far{kInfinity, 0, 0};
  for (const std::vector<double>& q : {bad, far}) {
    EXPECT_EQ(certifier.decide(q), Verdict::kUndecided);
    EXPECT_EQ(certifier.certify(good, q).verdict, Verdict::kUndecided);
    EXPECT_EQ(certifier.certify(q, good).verdict, Verdict::kUndecided);
    EXPECT_EQ(certifier.clearance(q, 1e-3).verdict, Verdict::kUndecided);
    EXPECT_EQ(certifier.edgeClearance(good, q, 1e-3, 0).clearance.lower, -kInfinity);
  }
  EXPECT_EQ(certifier.certify(good, good).verdict, Verdict::kFree);
}

// A zero quaternion does not represent a rotation; a joint without range has a single position.
TEST(EdgeCertifier, WhatCannotBeIsUndecided) {
  Problem flyer = test::problemOf(test::flyingBox(), {0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1});
  flyer.world.objects.push_back(test::box("far", {0.1, 0.1, 0.1}, 5, 5, 5));
  EdgeCertifier flying(std::make_shared<const CompiledScene>(flyer));
  const std::vector<double> zero{0, 0, 0, 0, 0, 0, 0}, turned{0, 0, 0, 1, 0, 0, 0};
  EXPECT_EQ(flying.certify(zero, turned).verdict, Verdict::kUndecided);
  EXPECT_EQ(flying.certify(turned, zero).verdict, Verdict::kUndecided);
  EXPECT_EQ(flying.certify(turned, turned).verdict, Verdict::kFree);

  auto robot = robots::testing::chain(
      2, robots::JointType::kPrismatic, 0, [](int i, robots::Link& link, robots::Joint&) {
        if (i == 1) link.geometries.push_back({collision::Shape::sphere(0.1), {}, link.name});
      });
  const auto model = std::make_shared<robots::Model>(std::move(robot));
  Problem stuck = test::problemOf(model, {0}, {0});
  stuck.world.objects.push_back(test::box("wall", {0.05, 2, 2}, 1, 0, 0));
  EdgeCertifier sliding(std::make_shared<const CompiledScene>(stuck));
  const std::vector<double> home{0}, wall{1};
  EXPECT_EQ(sliding.certify(home, home).verdict, Verdict::kFree);
  EXPECT_EQ(sliding.decide(wall), Verdict::kUndecided);
  EXPECT_EQ(sliding.certify(home, wall).verdict, Verdict::kUndecided);
}

// Regression: a copy kept the proofs about the links of the robot that it was copied from.
TEST(EdgeCertifier, ACopyWithOtherShapesHasNoProofsOfTheOld) {
  Random random(8);
  int tables = 0;
  for (int run = 0; run < 40; ++run) {
    const auto model = treeWithGaps(random);
    tables += static_cast<int>(model->linkGaps().size());
    robots::Model copy = *model;
    EXPECT_EQ(copy.linkGaps().size(), model->linkGaps().size());
    copy.links.back().geometries.push_back({collision::Shape::sphere(0.3), {}, "tool"});
    EXPECT_TRUE(copy.linkGaps().empty());
    copy = *model;
    copy.links.back().geometries[0].X_BG.translation.x() += 0.1;
    EXPECT_TRUE(copy.linkGaps().empty());
    copy = *model;
    copy.joints.back().X_PJ.translation.x() += 0.1;
    EXPECT_TRUE(copy.linkGaps().empty());
  }
  EXPECT_GT(tables, 0);
}

// No ball holds a half-space. Robots that only slide bound its motion.
TEST(EdgeCertifier, AHalfSpaceOnALinkThatSlidesIsNeverOverlooked) {
  auto robot = robots::testing::chain(
      2, robots::JointType::kPrismatic, 2, [](int i, robots::Link& link, robots::Joint& joint) {
        joint.axis = Eigen::Vector3d::UnitZ();
        if (i == 1) link.geometries.push_back({collision::Shape::halfSpace(), {}, link.name});
      });
  const auto model = std::make_shared<robots::Model>(std::move(robot));
  Problem problem = test::problemOf(model, {-1}, {1});
  problem.world.objects.push_back(test::box("crate", {0.5, 0.5, 0.5}, 0, 0, 0.6));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const std::vector<double> below{-1}, within{0.5}, above{1.5};
  EXPECT_NE(certifier.certify(below, above).verdict, Verdict::kFree);
  EXPECT_NE(certifier.decide(within), Verdict::kFree);
  EXPECT_NE(certifier.decide(above), Verdict::kFree);
}

// When a continuous joint wraps, a mimic of half its angle would jump.
TEST(EdgeCertifier, AMimicThatWouldJumpIsUndecided) {
  auto robot = robots::testing::chain(
      3, robots::JointType::kRevolute, 1, [](int i, robots::Link& link, robots::Joint& joint) {
        link.geometries.push_back({collision::Shape::sphere(0.1), {}, link.name});
        if (i == 1) joint.type = robots::JointType::kContinuous;
        joint.axis = Eigen::Vector3d::UnitZ();
        if (i > 0) joint.X_PJ.translation = {0.5, 0, 0};
        if (i == 2) {
          joint.mimic = 1;
          joint.multiplier = 0.5;
        }
      });
  robot.disabled_pairs.push_back({0, 2, "drawn so"});
  robot.has_srdf = true;
  const auto model = std::make_shared<robots::Model>(std::move(robot));
  Problem problem = test::problemOf(model, {0}, {1});
  problem.world.objects.push_back(test::box("far", {0.1, 0.1, 0.1}, 5, 5, 5));
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  EXPECT_EQ(certifier.certify(std::vector<double>{2.0}, std::vector<double>{3.0}).verdict,
            Verdict::kFree);
  EXPECT_EQ(certifier.certify(std::vector<double>{3.0}, std::vector<double>{-3.0}).verdict,
            Verdict::kUndecided);
  // After every kEscalation undecided edges, a search's edges may cost twice as much.
  const std::int64_t first = certifier.searching().work_limit;
  EXPECT_LT(first, EdgeRequest::persistent().work_limit);
  while (certifier.statistics.undecided_edges < kEscalation)
    certifier.certify(std::vector<double>{3.0}, std::vector<double>{-3.0});
  EXPECT_EQ(certifier.searching().work_limit, 2 * first);
  while (certifier.statistics.undecided_edges < 10 * kEscalation)
    certifier.certify(std::vector<double>{3.0}, std::vector<double>{-3.0});
  EXPECT_EQ(certifier.searching().work_limit, EdgeRequest::persistent().work_limit);
  // Outside [-pi, pi), the range that edges wrap circles to.
  EXPECT_EQ(certifier.certify(std::vector<double>{3.5}, std::vector<double>{3.6}).verdict,
            Verdict::kUndecided);
}

TEST(EdgeCertifier, QueriesAllocateNothing) {
  Random random(14);
  for (const Kind kind : {Kind::kArm, Kind::kFree, Kind::kPlanar, Kind::kTree}) {
    const auto compiled = std::make_shared<const CompiledScene>(problemOf(random, kind));
    EdgeCertifier certifier(compiled);
    std::vector<std::vector<double>> points;
    for (int i = 0; i < 30; ++i) points.push_back(randomPoint(random, *compiled));
    const std::size_t before = collision::testing::allocationCount();
    for (std::size_t i = 1; i < points.size(); ++i) {
      EdgeRequest request;
      request.last_valid = true;
      certifier.decide(points[i]);
      certifier.clearance(points[i], 1e-4);
      certifier.certify(points[i - 1], points[i], request);
      certifier.edgeClearance(points[i - 1], points[i], 1e-2, -kInfinity);
    }
    EXPECT_EQ(collision::testing::allocationCount(), before);
  }
}

// Regression: a geometry with the same centre as a smaller one on the same link got its motion,
// with a thousandth of the growth. So a cube swept over a pin was certified free.
TEST(EdgeCertifier, GeometriesOfOneCentreHaveMotionsOfTheirOwn) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<collision::TriangleMesh::Triangle> triangles;
  constexpr double kHalf = 1e-3;
  const double centers[6][2] = {{1, 0}, {-1, 0}, {2, 2}, {2, -2}, {-2, 2}, {-2, -2}};
  for (const auto& c : centers) {
    const auto first = static_cast<std::int32_t>(vertices.size());
    for (int i = 0; i < 8; ++i)
      vertices.emplace_back(c[0] + ((i & 1) != 0 ? kHalf : -kHalf),
                            c[1] + ((i & 2) != 0 ? kHalf : -kHalf), (i & 4) != 0 ? kHalf : -kHalf);
    for (const auto& f : {std::array{0, 2, 1},
                          {1, 2, 3},
                          {4, 5, 6},
                          {5, 7, 6},
                          {0, 1, 4},
                          {1, 5, 4},
                          {2, 6, 3},
                          {3, 6, 7},
                          {0, 4, 2},
                          {2, 4, 6},
                          {1, 3, 5},
                          {3, 7, 5}})
      triangles.push_back({first + f[0], first + f[1], first + f[2]});
  }
  const collision::Shape cubes =
      collision::Shape::mesh(collision::TriangleMesh::make(vertices, triangles));
  const auto rod =
      robots::freeBody("rod", {{collision::Shape::sphere(1e-3), {}, "ball"}, {cubes, {}, "cubes"}},
                       robots::JointType::kFloating, {-1, -1, -1}, {1, 1, 1});
  constexpr double kTurn = 3.1;
  const std::vector<double> a = {0, 0, 0, 0, 0, 0, 1};
  const std::vector<double> b = {0, 0, 0, 0, 0, std::sin(kTurn / 2), std::cos(kTurn / 2)};
  for (int s = 0; s < 15; ++s) {
    const double angle = kTurn * (s + 0.98) / 16;
    Problem problem = test::problemOf(rod, a, a);
    problem.world.objects.push_back({"pin",
                                     {{collision::Shape::sphere(1e-5), {}, "pin"}},
                                     test::at(std::cos(angle), std::sin(angle), 0)});
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    EXPECT_EQ(certifier.certify(a, b).verdict, Verdict::kNotFree) << s;
  }
}

}  // namespace
}  // namespace leeway::planner
