#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/deform/bounds/probe_bounds.h"
#include "collision/deform/query/probe.h"
#include "collision/deform/tree/refit.h"
#include "collision/deform/tree/tree_builder.h"
#include "collision/shapes/hull_of_part.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "tests/support/deformable_cases.h"
#include "tests/support/every_target.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using testing::Sheet;

constexpr ShapeType kTypes[] = {ShapeType::kSphere,    ShapeType::kCapsule,   ShapeType::kBox,
                                ShapeType::kCylinder,  ShapeType::kCone,      ShapeType::kEllipsoid,
                                ShapeType::kHalfSpace, ShapeType::kConvexHull};

// Triangle by triangle, surfaces only.
Interval bruteForce(const DeformableSnapshot& snapshot, const Pose& X_WM, const Shape& shape,
                    const Pose& X_WS, Scratch& scratch) {
  Interval least{kInfinity, kInfinity};
  for (const auto& t : snapshot.mesh().triangles()) {
    std::vector<Vector3d> corners;
    for (const std::int32_t v : t)
      corners.push_back(snapshot.vertices()[static_cast<std::size_t>(v)]);
    const DistanceResult r =
        distance(Shape::convexHull(hullOfPart(corners)), X_WM, shape, X_WS, {}, scratch);
    least.lower = std::min(least.lower, r.distance.lower);
    least.upper = std::min(least.upper, r.distance.upper);
  }
  return least;
}

// Sum of the triangles' solid angles in full turns (van Oosterom and Strackee 1983).
int windingAround(const DeformableSnapshot& snapshot, const Vector3d& p) {
  double sum = 0;
  for (const auto& t : snapshot.mesh().triangles()) {
    Vector3d r[3];
    for (std::size_t k = 0; k < 3; ++k)
      r[k] = snapshot.vertices()[static_cast<std::size_t>(t[k])] - p;
    const double l0 = r[0].norm(), l1 = r[1].norm(), l2 = r[2].norm();
    sum +=
        2 * std::atan2(r[0].dot(r[1].cross(r[2])), l0 * l1 * l2 + r[0].dot(r[1]) * l2 +
                                                       r[1].dot(r[2]) * l0 + r[2].dot(r[0]) * l1);
  }
  return static_cast<int>(std::lround(sum / (4 * std::acos(-1.0))));
}

struct Count {
  int queries = 0, apart = 0, touching = 0, inside = 0;
};

void compare(const DeformableSnapshot& snapshot, const Shape& cloth, const Pose& X_WM,
             const Shape& shape, const Pose& X_WS, Scratch& scratch, PairCache& cache,
             Count& count) {
  const Interval truth = bruteForce(snapshot, X_WM, shape, X_WS, scratch);
  DistanceRequest request;
  request.depth = false;
  const DistanceResult r = distance(shape, X_WS, cloth, X_WM, request, scratch, &cache);
  const auto replay = [&] {
    return std::string(toString(snapshot.strategy())) + " " + oracle::replay(shape) + " " +
           oracle::replay(X_WS) + " mesh at " + oracle::replay(X_WM);
  };
  ++count.queries;
  if (truth.lower > 0 && shape.type() != ShapeType::kHalfSpace &&
      snapshot.mesh().closedComponentCount() > 0) {
    const Vector3d p = shape.hull() != nullptr ? shape.hull()->vertices()[0] : Vector3d::Zero();
    if (windingAround(snapshot, X_WM.inverse() * (X_WS * p)) != 0) {
      ++count.inside;
      ASSERT_LE(r.distance.lower, -truth.lower) << replay();
      ASSERT_NEAR(r.distance.upper, -truth.upper, 1e-8) << replay();
      return;
    }
  }
  if (truth.lower > 0) {
    ++count.apart;
    ASSERT_LE(r.distance.lower, truth.upper) << replay();
    ASSERT_GE(r.distance.upper, truth.lower) << replay();
    ASSERT_LE(r.distance.width(), 1.001e-9 + truth.width()) << replay();
    ASSERT_NEAR((r.point_a - r.point_b).norm(), r.distance.upper, 1e-8) << replay();
    const DistanceResult swapped = distance(cloth, X_WM, shape, X_WS, request, scratch, nullptr);
    ASSERT_LE(swapped.distance.lower, truth.upper) << replay();
    ASSERT_GE(swapped.distance.upper, truth.lower) << replay();
    ASSERT_LE(swapped.distance.width(), 1.001e-9 + truth.width()) << replay();
  } else if (truth.upper <= 0) {
    ++count.touching;
    ASSERT_LE(r.distance.lower, 0) << replay();
    ASSERT_LE(r.distance.upper, 1e-9) << replay();
  }
  for (const double factor : {0.5, 0.99, 1.01, 2.0}) {
    if (!(truth.lower > 1e-6)) break;
    request.threshold = factor * truth.lower;
    const DistanceResult d = distance(shape, X_WS, cloth, X_WM, request, scratch, &cache);
    if (factor < 1) {
      ASSERT_GT(d.distance.lower, request.threshold) << replay();
    } else {
      ASSERT_LE(d.distance.upper, request.threshold)
          << d.distance.lower << " of " << truth.lower << " " << replay();
    }
  }
}

TEST(DeformableQuery, RigidShapesAgainstEveryStrategyAsByBruteForce) {
  Random random(11);
  Random numbers(12);
  int inside = 0;
  for (const Sheet& sheet : {testing::cloth(12), testing::cloth(9, &numbers), testing::globe(6)}) {
    const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
    for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
      Deformable deformable(mesh, nullptr, testing::optionsOf(strategy));
      Scratch scratch;
      prepare(scratch, *deformable.snapshot());
      Count count;
      PairCache cache;
      for (int frame = 0; frame < 6; frame += testing::kFrameStep) {
        const auto vertices = frame < 4 ? testing::waved(sheet.vertices, 0.3, frame)
                                        : testing::exploded(sheet.vertices, 0.5 * frame, 5);
        ASSERT_EQ(deformable.update(vertices, frame), UpdateStatus::kUpdated);
        if (frame == 2) scratch = Scratch();  // not prepared: other code paths, equal answers
        const auto snapshot = deformable.snapshot();
        const Shape shape = Shape::deformable(snapshot);
        for (const ShapeType type : kTypes) {
          const Shape other = oracle::randomShape(random, type, oracle::Flavour::kPlain);
          const Pose X_WM{random.rotation(), random.direction()};
          const Pose X_WS{random.rotation(),
                          X_WM.translation + 3 * random.unit() * random.direction()};
          compare(*snapshot, shape, X_WM, other, X_WS, scratch, cache, count);
          if (HasFatalFailure()) return;
        }
      }
      inside += count.inside;
      if (mesh->closedComponentCount() == 0) {
        EXPECT_GT(count.apart, count.queries / 5);
        EXPECT_GT(count.touching, count.queries / 20);
      }
    }
  }
  EXPECT_GT(inside, 10 / testing::kFrameStep);
}

// Boxes are in single precision, whose squares lose digits below 1e-19, and vertices may come that
// close to each other. Regression: lower ends exceeded the truth by a factor of 1.2 at 2.9e-23.
TEST(DeformableQuery, DistancesWhoseSquaresLeaveTheRangeOfSingles) {
  const Sheet sheet = testing::cloth(4);
  Random random(13);
  for (const double size : {1.0, 1e-20, 1e-24}) {
    std::vector<Vector3d> vertices = sheet.vertices;
    for (Vector3d& v : vertices) v *= size;
    const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
    for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
      DeformOptions options;
      options.strategy = strategy;
      Deformable deformable(mesh, nullptr, options);
      ASSERT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated);
      const auto snapshot = deformable.snapshot();
      const Shape shape = Shape::deformable(snapshot);
      Scratch scratch;
      prepare(scratch, *snapshot);
      for (int i = 0; i < 40; ++i) {
        const double far = size * random.logUniform(1e-2, size == 1 ? 1e9 : 1e3);
        const Shape ball = Shape::sphere(size < 1 || random.chance(0.5) ? 0 : 0.1 * far);
        const Pose X_WS{Eigen::Matrix3d::Identity(), far * random.direction()};
        const Interval truth = bruteForce(*snapshot, {}, ball, X_WS, scratch);
        DistanceRequest request;
        request.depth = false;
        const auto told = [&] {
          return std::string(toString(strategy)) + " " + oracle::replay(ball) + " " +
                 oracle::replay(X_WS);
        };
        const Interval found = distance(ball, X_WS, shape, {}, request, scratch).distance;
        ASSERT_LE(found.lower, truth.upper) << told();
        ASSERT_GE(found.upper, truth.lower) << told();
        request.threshold = 10 * far;
        ASSERT_LE(distance(ball, X_WS, shape, {}, request, scratch).distance.lower, truth.upper)
            << told();
      }
    }
  }
}

// The longest segments. Regression: a node's empty columns seemed near, and their contents were
// read.
TEST(DeformableQuery, CapsulesAsLongAsThereAre) {
  const Sheet sheet = testing::cloth(7);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  Eigen::Matrix3d turned;
  turned << 2.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3, 2.0 / 3, -1.0 / 3, -1.0 / 3, 2.0 / 3, 2.0 / 3;
  for (const DeformStrategy strategy : testing::strategiesWithoutMotion()) {
    DeformOptions options;
    options.strategy = strategy;
    Deformable deformable(mesh, nullptr, options);
    ASSERT_EQ(deformable.update(sheet.vertices, 1), UpdateStatus::kUpdated);
    const Shape shape = Shape::deformable(deformable.snapshot());
    Scratch scratch;
    for (const double half_length : {1e5, 1e7, 1e9}) {
      const Shape capsule = Shape::capsule(0.1, half_length);
      const Pose X_WC{turned, {1, 1, 1}};
      const Interval truth = bruteForce(*deformable.snapshot(), {}, capsule, X_WC, scratch),
                     found = distance(shape, {}, capsule, X_WC, {}, scratch).distance;
      EXPECT_LE(found.lower, truth.upper) << toString(strategy) << " " << half_length;
      EXPECT_GE(found.upper, truth.lower) << toString(strategy) << " " << half_length;
      const Interval swept = sweptDistance(capsule, X_WC, X_WC, 0, shape, {}, scratch).distance;
      EXPECT_LE(swept.lower, truth.upper) << toString(strategy) << " " << half_length;
    }
  }
}

// The caller guaranteed a corner that is not finite. Wherever its triangles are visited, nothing
// may be reported free: triangle boxes omit NaN, and the box of all vertices is the previous
// frame's. Regression: both were trusted.
TEST(DeformableQuery, ACornerThatIsNotFiniteIsNearerThanAll) {
  const int runs = bySanitizer(30, 9, 4);
  Sheet sheet = testing::cloth(40);
  Random random(14);
  int looks = 0;
  for (int run = 0; run < runs; ++run) {
    const auto vertices = testing::waved(sheet.vertices, run % 2 == 0 ? 0 : 0.3, run);
    const auto broken = static_cast<std::size_t>(random.below(static_cast<int>(vertices.size())));
    for (auto& t : sheet.triangles) {  // make it the first corner of its triangles
      const auto corner = std::find(t.begin(), t.end(), static_cast<std::int32_t>(broken));
      if (corner != t.end()) std::rotate(t.begin(), corner, t.end());
    }
    const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
    DeformOptions options;
    options.strategy = DeformStrategy::kHybrid;
    options.hybrid_split = 200;
    Deformable deformable(mesh, nullptr, options);
    ASSERT_EQ(deformable.update(vertices, 1), UpdateStatus::kUpdated);
    const std::span<Vector3d> next = deformable.nextVertices();
    std::copy(vertices.begin(), vertices.end(), next.begin());
    const Vector3d place = next[broken] + Vector3d(0, 0, 0.04);
    const double wrong = random.chance(0.5) ? std::numeric_limits<double>::quiet_NaN() : kInfinity;
    if (random.chance(0.5))
      next[broken][random.below(3)] = wrong;
    else
      next[broken].setConstant(wrong);
    const UpdateStatus status = deformable.commit(2, 1, Deformable::Vertices::kFinite, 1e-9);
    if (status != UpdateStatus::kUpdated) continue;  // it was read
    ++looks;
    const Shape shape = Shape::deformable(deformable.snapshot());
    Scratch scratch;
    for (const Shape& near : {Shape::sphere(0.01), Shape::box({0.01, 0.01, 0.01}), shape}) {
      const Pose X_WS{Eigen::Matrix3d::Identity(),
                      near.deformable() != nullptr ? Vector3d(0, 0, 0.04) : place};
      for (const double threshold : {std::numeric_limits<double>::quiet_NaN(), 0.045}) {
        DistanceRequest request;
        request.threshold = threshold;  // the neighbours' corners are farther
        const DistanceResult r = distance(near, X_WS, shape, {}, request, scratch);
        if (r.distance.upper <= threshold) continue;
        ASSERT_EQ(r.distance.lower, -kInfinity) << "run " << run << " " << toString(near.type());
      }
    }
  }
  EXPECT_GT(3 * looks, runs);
}

// Any corner may be NaN, on every instruction set. Regression: minima dropped it, or everything
// before it.
TEST(DeformableQuery, BoundsOfATriangleWithoutACornerSayNothing) {
  const std::vector<std::array<std::int32_t, 3>> triangles = {{0, 1, 2}};
  const std::vector<Vector3d> rest = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const auto tree = buildDeformTree(rest, triangles, DeformMethod::kBinned, 40);
  for (std::size_t broken = 0; broken < 3; ++broken) {
    for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
      for (int axis = 0; axis <= 3; ++axis) {
        std::vector<Vector3d> vertices = rest;
        vertices.emplace_back(0, 0, 0);  // read but unused: kernels load four doubles a vertex
        if (axis < 3)
          vertices[broken][axis] = wrong;
        else
          vertices[broken].setConstant(wrong);
        const Probe probe =
            makeProbe(Vector3d(-0.1, -0.1, 2.9), Vector3d(0.1, 0.1, 3.1), 0, Pose{}, nullptr, 1, 0);
        onEveryTarget([&](const char* target) {
          WideBounds bounds;
          probeKernels().triangleBounds(probe, *tree, vertices.data(), 0, 1, bounds);
          EXPECT_EQ(static_cast<double>(bounds.lower[0]), -kInfinity)
              << target << " " << broken << " " << wrong << " " << axis;
          WideBox box;
          deformKernels().triangles(*tree, vertices.data(), 0, 1, box);
          for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(box.low[k][0], -std::numeric_limits<float>::max()) << target;
            EXPECT_EQ(box.high[k][0], std::numeric_limits<float>::max()) << target;
          }
        });
      }
    }
  }
}

}  // namespace
}  // namespace leeway::collision
