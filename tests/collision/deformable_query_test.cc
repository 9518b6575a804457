#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/collision/convex_hull.h"
#include "tests/collision/deformable_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;
using testing::Sheet;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr ShapeType kTypes[] = {ShapeType::kSphere,    ShapeType::kCapsule,   ShapeType::kBox,
                                ShapeType::kCylinder,  ShapeType::kCone,      ShapeType::kEllipsoid,
                                ShapeType::kHalfSpace, ShapeType::kConvexHull};

// Every triangle by itself: surfaces only.
Interval bruteForce(const DeformableSnapshot& snapshot, const Pose& X_WM, const Shape& shape,
                    const Pose& X_WS, Scratch& scratch) {
  Interval least{kInfinity, kInfinity};
  for (const auto& t : snapshot.mesh().triangles()) {
    std::vector<Vector3d> corners;
    for (const std::int32_t v : t)
      corners.push_back(snapshot.vertices()[static_cast<std::size_t>(v)]);
    const DistanceResult r = distance(Shape::convexHull(corners), X_WM, shape, X_WS, {}, scratch);
    least.lower = std::min(least.lower, r.distance.lower);
    least.upper = std::min(least.upper, r.distance.upper);
  }
  return least;
}

// Solid angles of all triangles over the sphere's (van Oosterom and Strackee 1983).
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
      DeformOptions options;
      options.strategy = strategy;
      options.hybrid_split = 40;
      Deformable deformable(mesh, nullptr, options);
      Scratch scratch;
      prepare(scratch, *deformable.snapshot());
      Count count;
      PairCache cache;
      for (int frame = 0; frame < 6; frame += testing::kFrameStep) {
        const auto vertices = frame < 4 ? testing::waved(sheet.vertices, 0.3, frame)
                                        : testing::exploded(sheet.vertices, 0.5 * frame, 5);
        ASSERT_EQ(deformable.update(vertices, frame), UpdateStatus::kUpdated);
        if (frame == 2) scratch = Scratch();  // not prepared: other ways, the same answers
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

}  // namespace
}  // namespace leeway::collision
