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

// Boxes are singles, whose squares leave their range at 1.8e19 and lose digits below 1e-19: lower
// ends were above 1.9e19 (infinite), and 1.2 times 2.9e-23.
TEST(DeformableQuery, DistancesWhoseSquaresLeaveTheRangeOfSingles) {
  const Sheet sheet = testing::cloth(4);
  Random random(13);
  for (const double size : {1.0, 1e-20, 1e-24}) {
    std::vector<Vector3d> vertices = sheet.vertices;
    for (Vector3d& v : vertices) v *= size;
    const auto mesh = DeformableMesh::make(vertices, sheet.triangles);
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
        const double far = size * random.logUniform(1e-2, size == 1 ? 1e30 : 1e3);
        const Shape ball = Shape::sphere(random.chance(0.5) ? 0 : 0.1 * far);
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

// The caller has vouched for what is none: wherever its triangles are looked at, nothing is told to
// be free.
TEST(DeformableQuery, ACornerThatIsNotFiniteIsNearerThanAll) {
  const Sheet sheet = testing::cloth(12);
  const auto mesh = DeformableMesh::make(sheet.vertices, sheet.triangles);
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), kInfinity}) {
    for (const bool at_ball : {false, true}) {
      DeformOptions options;
      options.strategy = DeformStrategy::kHybrid;
      options.hybrid_split = 40;
      Deformable deformable(mesh, nullptr, options);
      ASSERT_EQ(deformable.update(sheet.vertices, 1), UpdateStatus::kUpdated);
      const std::span<Vector3d> next = deformable.nextVertices();
      std::copy(sheet.vertices.begin(), sheet.vertices.end(), next.begin());
      const std::size_t broken = at_ball ? next.size() / 2 : 0;
      const Vector3d place = next[next.size() / 2] + Vector3d(0, 0, 0.5);
      next[broken].y() = wrong;
      const UpdateStatus status = deformable.commit(2, 1, Deformable::Vertices::kFinite, 1e-9);
      if (status != UpdateStatus::kUpdated) continue;  // it had been read
      const Shape shape = Shape::deformable(deformable.snapshot());
      Scratch scratch;
      const DistanceResult r = distance(
          Shape::sphere(0.1), Pose{Eigen::Matrix3d::Identity(), place}, shape, {}, {}, scratch);
      if (at_ball) {
        ASSERT_EQ(r.distance.lower, -kInfinity);
      }
    }
  }
}

}  // namespace
}  // namespace leeway::collision
