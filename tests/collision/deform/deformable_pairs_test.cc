#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "collision/base/numbers.h"
#include "collision/base/work.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/deformable_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using testing::Sheet;

std::vector<Shape> trianglesOf(const DeformableSnapshot& snapshot) {
  std::vector<Shape> shapes;
  for (const auto& t : snapshot.mesh().triangles()) {
    std::vector<Vector3d> corners;
    for (const std::int32_t v : t)
      corners.push_back(snapshot.vertices()[static_cast<std::size_t>(v)]);
    shapes.push_back(Shape::convexHull(corners));
  }
  return shapes;
}

// The surfaces of two bodies, pair by pair.
Interval bruteForce(const std::vector<Shape>& a, const Pose& X_WA, const std::vector<Shape>& b,
                    const Pose& X_WB, Scratch& scratch) {
  Interval least{kInfinity, kInfinity};
  for (const Shape& s : a) {
    for (const Shape& t : b) {
      const DistanceResult r = distance(s, X_WA, t, X_WB, {}, scratch);
      least.lower = std::min(least.lower, r.distance.lower);
      least.upper = std::min(least.upper, r.distance.upper);
    }
  }
  return least;
}

Deformable made(const Sheet& sheet, DeformStrategy strategy,
                const std::vector<Vector3d>& vertices) {
  DeformOptions options;
  options.strategy = strategy;
  options.hybrid_split = 20;
  Deformable deformable(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr, options);
  EXPECT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated);
  return deformable;
}

TEST(DeformablePairs, MeshesAndOtherDeformingMeshesAsByBruteForce) {
  Random random(21);
  const Sheet sheet = testing::cloth(5), other_sheet = testing::cloth(4);
  int apart = 0, touching = 0;
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    Scratch scratch;
    for (int round = 0; round < 6; round += testing::kFrameStep) {
      const auto one = made(sheet, strategy, testing::waved(sheet.vertices, 0.3, round));
      const auto moved = round < 4 ? testing::waved(other_sheet.vertices, 0.4, 2 * round)
                                   : testing::exploded(other_sheet.vertices, 0.5, 3);
      const auto two = made(other_sheet, strategy, moved);
      if (round > 0) {
        prepare(scratch, *one.snapshot());
        prepare(scratch, *two.snapshot());
      }
      const Pose X_WA{random.rotation(), random.direction()};
      const Pose X_WB{random.rotation(),
                      X_WA.translation + (0.3 + 2 * random.unit()) * random.direction()};
      const Interval truth = bruteForce(trianglesOf(*one.snapshot()), X_WA,
                                        trianglesOf(*two.snapshot()), X_WB, scratch);
      const Shape a = Shape::deformable(one.snapshot()), b = Shape::deformable(two.snapshot());
      const Shape rigid = Shape::mesh(TriangleMesh::make(moved, other_sheet.triangles));
      PairCache cache;
      for (const auto& [s, t] : {std::pair{a, b}, std::pair{a, rigid}}) {
        for (int again = 0; again < 2; ++again) {
          DistanceRequest request;
          request.depth = false;
          const DistanceResult r = distance(s, X_WA, t, X_WB, request, scratch, &cache);
          const std::string replay = std::string(toString(strategy)) + " " + std::to_string(round) +
                                     " " + toString(t.type()) + " " + oracle::replay(X_WA) + " " +
                                     oracle::replay(X_WB);
          ASSERT_LE(r.distance.lower, truth.upper) << replay;
          if (truth.lower > 0) {
            ++apart;
            ASSERT_GE(r.distance.upper, truth.lower) << replay;
            ASSERT_LE(r.distance.width(), 1.001e-9 + truth.width()) << replay;
          } else {
            ++touching;
            ASSERT_LE(r.distance.upper, 1e-9) << replay;
          }
          const DistanceResult swapped = distance(t, X_WB, s, X_WA, request, scratch, &cache);
          ASSERT_LE(swapped.distance.lower, truth.upper) << replay;
          if (truth.lower > 0) {
            ASSERT_GE(swapped.distance.upper, truth.lower) << replay;
          }
        }
      }
    }
  }
  EXPECT_GT(apart, kSanitized ? 15 : 50);
  EXPECT_GT(touching, 20 / testing::kFrameStep);
}

TEST(DeformablePairs, OverlapsAreEnclosed) {
  Random random(22);
  const Sheet globe = testing::globe(5);
  Scratch scratch;
  int deep = 0, undone = 0;
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    const auto deformable = made(globe, strategy, globe.vertices);
    const Shape solid = Shape::deformable(deformable.snapshot());
    for (int i = 0; i < 12; ++i) {
      const Shape ball = Shape::sphere(random.uniform(0.05, 0.4));
      const Pose X{random.rotation(), random.uniform(0, 1.3) * random.direction()};
      const DistanceResult r = distance(ball, X, solid, Pose{}, {}, scratch);
      // The globe's surface lies between the sphere of radius 1 and the one through its cells'
      // centres.
      const double outer = X.translation.norm() - 1 - ball.radius(), inner = outer + 0.09;
      ASSERT_LE(r.distance.lower, inner);
      ASSERT_GE(r.distance.upper, outer);
      if (r.distance.upper < 0) {
        ++deep;
        // The guarantee of the lower end: moved by that length along the normal, they are apart.
        if (!(r.distance.lower > -kInfinity)) continue;
        Pose moved;
        moved.translation = (-r.distance.lower + 1e-6) * r.normal;
        DistanceRequest apart;
        apart.threshold = 0;
        undone += distance(ball, X, solid, moved, apart, scratch).distance.lower > 0;
      }
    }
  }
  EXPECT_GT(deep, 40);
  EXPECT_GT(undone, deep / 2);
}

TEST(DeformablePairs, AHalfSpaceKnowsTheDepthOfTheLowestVertex) {
  const Sheet sheet = testing::cloth(12);
  Scratch scratch;
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    const auto vertices = testing::waved(sheet.vertices, 0.3, 2);
    const auto deformable = made(sheet, strategy, vertices);
    double lowest = kInfinity;
    for (const Vector3d& v : vertices) lowest = std::min(lowest, v.z());
    for (const double height : {-1.0, 0.0, 1.0}) {
      Pose X;
      X.translation.z() = height;
      const DistanceResult r = distance(Shape::halfSpace(), Pose{},
                                        Shape::deformable(deformable.snapshot()), X, {}, scratch);
      EXPECT_LE(r.distance.lower, lowest + height) << toString(strategy) << height;
      EXPECT_GE(r.distance.upper, lowest + height) << toString(strategy) << height;
      EXPECT_NEAR(r.distance.upper, lowest + height, 1e-8) << toString(strategy) << height;
    }
  }
}

// Regression: the infinite extent of a half-space counted as rounding, and all 7,200 triangles were
// tested, also those of rigid meshes.
TEST(DeformablePairs, AHalfSpaceIsComparedWithFewTriangles) {
  const Sheet sheet = testing::cloth(60);
  const auto vertices = testing::waved(sheet.vertices, 0.3, 2);
  const auto deformable = made(sheet, DeformStrategy::kRefit, vertices);
  Pose X;
  X.translation.z() = 1;
  for (const Shape& mesh : {Shape::mesh(TriangleMesh::make(vertices, sheet.triangles)),
                            Shape::deformable(deformable.snapshot())}) {
    Scratch scratch;
    Work work;
    countInto(scratch, work);
    const DistanceResult r = distance(Shape::halfSpace(), Pose{}, mesh, X, {}, scratch);
    EXPECT_GT(r.distance.lower, 0.5);
    EXPECT_LE(r.iterations, 400) << toString(mesh.type());
    EXPECT_LE(work.done, 400 * kPairWork) << toString(mesh.type());
  }
}

TEST(DeformablePairs, SweepsClaimNoMoreThanAnyPlacementOnTheWayHas) {
  Random random(23);
  const Sheet sheet = testing::cloth(6);
  Scratch scratch;
  int positive = 0, tight = 0;
  const ShapeType types[] = {ShapeType::kSphere, ShapeType::kCapsule, ShapeType::kBox,
                             ShapeType::kConvexHull, ShapeType::kMesh};
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    const auto deformable = made(sheet, strategy, testing::waved(sheet.vertices, 0.3, 1));
    if (strategy != DeformStrategy::kLazy) prepare(scratch, *deformable.snapshot());
    const Shape cloth = Shape::deformable(deformable.snapshot());
    for (int i = 0; i < 40; ++i) {
      const Shape body =
          oracle::randomShape(random, types[random.below(5)], oracle::Flavour::kPlain);
      const bool cloth_moves = random.chance(0.3);
      const Shape &a = cloth_moves ? cloth : body, &b = cloth_moves ? body : cloth;
      const Pose X0{random.rotation(), (1 + 2 * random.unit()) * random.direction()};
      const Pose X1{X0.rotation, X0.translation + 0.6 * random.unit() * random.direction()};
      const double growth = 0.01 * random.unit();
      DistanceRequest request;
      if (random.chance(0.5)) request.threshold = 0;
      const DistanceResult r = sweptDistance(a, X0, X1, growth, b, request, scratch);
      positive += r.distance.lower > 0;
      double least = kInfinity;
      for (int k = 0; k <= 8; ++k) {
        const Pose X{X0.rotation, X0.translation + k / 8.0 * (X1.translation - X0.translation)};
        DistanceRequest surfaces;
        surfaces.depth = false;
        const DistanceResult at = distance(a, X, b, Pose{}, surfaces, scratch);
        least = std::min(least, at.distance.upper);
        ASSERT_LE(r.distance.lower, at.distance.upper - growth + 1e-9)
            << toString(strategy) << i << toString(body.type());
      }
      // If there is no threshold, the claim is as tight as the placements allow.
      if (request.threshold != request.threshold && r.distance.lower > 0)
        tight += r.distance.lower > least - growth - 0.05;
    }
  }
  EXPECT_GT(positive, 80);
  EXPECT_GT(tight, 30);
}

// Each triangle descends the rigid mesh's own hierarchy. All share one limit: the counted work
// stays close to that number of pairs.
TEST(DeformablePairs, NodesOfRigidMeshesCountTowardsTheLimit) {
  Random random(27);
  const Sheet sheet = testing::cloth(16);
  const Shape rigid = Shape::mesh(TriangleMesh::make(
      testing::waved(testing::cloth(24).vertices, 0.2, 2), testing::cloth(24).triangles));
  const auto deformable =
      made(sheet, DeformStrategy::kRefit, testing::waved(sheet.vertices, 0.2, 1));
  const Shape cloth = Shape::deformable(deformable.snapshot());
  int cut = 0;
  for (int i = 0; i < casesToAsk(40); ++i) {
    const Pose X{random.rotation(), random.uniform(0.3, 0.8) * random.direction()};
    DistanceRequest request;
    request.depth = false;
    Scratch whole, scratch;
    const DistanceResult truth = distance(rigid, X, cloth, {}, request, whole);
    request.node_limit = 60;
    Work work;
    countInto(scratch, work);
    const DistanceResult limited = distance(rigid, X, cloth, {}, request, scratch);
    ASSERT_LE(limited.distance.lower, truth.distance.upper) << oracle::replay(X);
    ASSERT_GE(limited.distance.upper, truth.distance.lower) << oracle::replay(X);
    ASSERT_LT(work.done, 100'000) << oracle::replay(X);
    cut += limited.status == DistanceStatus::kLimit ? 1 : 0;
  }
  EXPECT_GT(cut, casesToAsk(40) / 4);
}

TEST(DeformablePairs, SelfDistanceAsByBruteForce) {
  const Sheet sheet = testing::cloth(7);
  Scratch scratch;
  int apart = 0, crossing = 0;
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    for (int frame = 0; frame < 6; frame += testing::kFrameStep) {
      const auto vertices = frame < 4 ? testing::waved(sheet.vertices, 0.2 * frame, frame)
                                      : testing::exploded(sheet.vertices, 0.5, 7);
      const auto deformable = made(sheet, strategy, vertices);
      const auto snapshot = deformable.snapshot();
      if (frame > 0) prepare(scratch, *snapshot);
      const std::vector<Shape> shapes = trianglesOf(*snapshot);
      Interval truth{kInfinity, kInfinity};
      for (std::size_t i = 0; i < shapes.size(); ++i) {
        for (std::size_t j = i + 1; j < shapes.size(); ++j) {
          const auto &s = sheet.triangles[i], &t = sheet.triangles[j];
          if (std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end()) continue;
          DistanceRequest request;
          request.depth = false;
          const DistanceResult r = distance(shapes[i], {}, shapes[j], {}, request, scratch);
          truth.lower = std::min(truth.lower, r.distance.lower);
          truth.upper = std::min(truth.upper, r.distance.upper);
        }
      }
      PairCache cache;
      for (int again = 0; again < 2; ++again) {
        const DistanceResult r = selfDistance(*snapshot, {}, scratch, &cache);
        if (truth.lower > 0) {
          ++apart;
          ASSERT_LE(r.distance.lower, truth.upper) << toString(strategy) << frame;
          ASSERT_GE(r.distance.upper, truth.lower) << toString(strategy) << frame;
          ASSERT_LE(r.distance.width(), 1.001e-9 + truth.width()) << toString(strategy) << frame;
          ASSERT_LT(r.triangle_a, r.triangle_b);
          ASSERT_NEAR((r.point_a - r.point_b).norm(), r.distance.upper, 1e-8);
        } else {
          ++crossing;
          ASSERT_LE(r.distance.upper, 1e-9) << toString(strategy) << frame;
        }
      }
    }
  }
  EXPECT_GT(apart, 20 / testing::kFrameStep);
  EXPECT_GT(crossing, 10 / testing::kFrameStep);
}

// In the notch of an L, its hull is 0.47 away. Regression: with a loose tolerance, which was met
// before any triangle of the L was visited, the hull's witness points, 0.019 apart, were returned.
TEST(DeformablePairs, WitnessesAreOfTheMeshAndNotOfItsHull) {
  const Shape ell = Shape::mesh(oracle::ellMesh(1));
  const Vector3d vertices[] = {{0.68, 0.68, 0}, {0.69, 0.68, 0.01}, {0.68, 0.69, -0.01}};
  const DeformableMesh::Triangle triangle[] = {{0, 1, 2}};
  const Deformable deformable(DeformableMesh::make(vertices, triangle));
  const Shape shape = Shape::deformable(deformable.snapshot());
  const double truth = 0.68 - 1.0 / 3;
  Scratch scratch;
  for (const double tolerance : {1e-9, 0.15, 0.2, 0.3, 0.4}) {
    DistanceRequest request;
    request.tolerance = tolerance;
    for (const bool swapped : {false, true}) {
      const DistanceResult r = swapped ? distance(shape, {}, ell, {}, request, scratch, nullptr)
                                       : distance(ell, {}, shape, {}, request, scratch, nullptr);
      EXPECT_LE(r.distance.lower, truth);
      EXPECT_GE(r.distance.upper, truth);
      EXPECT_LE(r.distance.width(), tolerance);
      const double gap = (r.point_a - r.point_b).norm(), width = r.distance.width();
      EXPECT_GE(gap, r.distance.lower - width - 1e-12) << tolerance << (swapped ? " swapped" : "");
      EXPECT_LE(gap, r.distance.upper + width + 1e-12) << tolerance << (swapped ? " swapped" : "");
    }
  }
}

}  // namespace
}  // namespace leeway::collision
