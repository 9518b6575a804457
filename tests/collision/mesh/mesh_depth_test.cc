// Depth of concave bodies: neither end contradicts a search over all directions, and both are close
// to it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collision/solids/solid_depth.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "tests/support/allocations.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

// Length of B's shortest separating translation among many directions and steps.
double shortest(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB, double far,
                double step, Scratch& scratch) {
  DistanceRequest request;
  request.threshold = 0;
  request.depth = false;
  double best = far;
  constexpr int kDirections = 120;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z), turn = 10.1664 * i;
    const Vector3d direction(r * std::cos(turn), r * std::sin(turn), z);
    for (double length = step; length < best; length += step) {
      Pose moved = X_WB;
      moved.translation += length * direction;
      if (distance(a, X_WA, b, moved, request, scratch).distance.lower > 0) best = length;
    }
  }
  return best;
}

TEST(MeshDepth, IsEnclosedByASearchInAllDirections) {
  Random random(71);
  Scratch scratch;
  const auto meshes = sampleMeshes(71);
  int unsafe = 0, count = 0;
  double lower = 0, upper = 0;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 4; ++j) {
      if ((i + j) % bySanitizer(1, 2, 4) != 0) continue;
      for (int k = 0; k < casesToAsk(2); ++k) {
        const NamedMesh &m = meshes[static_cast<std::size_t>(i)],
                        &n = meshes[static_cast<std::size_t>(j)];
        const Shape a = Shape::mesh(m.mesh), b = Shape::mesh(n.mesh);
        const Pose X_WA = random.pose(0.1), X_WB = random.pose(0.7);
        const DistanceResult r = distance(a, X_WA, b, X_WB, {}, scratch);
        if (!(r.distance.upper <= 0)) continue;
        const double step = 0.02, twin = shortest(a, X_WA, b, X_WB, 2, step, scratch);
        ++count;
        if (-r.distance.upper > twin) {
          ++unsafe;
          ADD_FAILURE() << m.name << " and " << n.name << ": " << twin
                        << " separates, the answer is [" << r.distance.lower << ", "
                        << r.distance.upper << "]";
        }
        lower += -r.distance.lower / twin;
        upper += -r.distance.upper / twin;
        EXPECT_LT(-r.distance.lower, 2 * twin) << m.name << " and " << n.name;
      }
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(count, bySanitizer(25, 5, 2));
  EXPECT_LT(lower, 1.05 * count);
  EXPECT_GT(upper, 0.65 * count);
}

/// A deformable of these triangles at rest.
Deformable deformableOf(const TriangleMesh& mesh, DeformStrategy strategy) {
  DeformOptions options;
  options.strategy = strategy;
  options.hybrid_split = 20;
  Deformable deformable(DeformableMesh::make(mesh.vertices(), mesh.triangles()), nullptr, options);
  EXPECT_EQ(deformable.update(mesh.vertices(), 1), collision::UpdateStatus::kUpdated);
  return deformable;
}

// The twin uses rigid meshes of the same triangles.
TEST(MeshDepth, OfDeformingSolidsIsEnclosedByTheSameSearch) {
  // Strategies without a hierarchy examine fewer points.
  constexpr DeformStrategy kStrategies[] = {DeformStrategy::kOctree, DeformStrategy::kRefit,
                                            DeformStrategy::kHybrid, DeformStrategy::kLazy};
  Random random(72);
  Scratch scratch;
  const auto meshes = sampleMeshes(71);
  std::vector<Deformable> deforming;
  for (std::size_t i = 0; i < 5; ++i) {
    deforming.push_back(deformableOf(*meshes[i].mesh, kStrategies[i % 4]));
    EXPECT_GT(deforming.back().mesh()->closedComponentCount(), 0) << meshes[i].name;
    prepare(scratch, *deforming.back().snapshot());
  }
  int count = 0;
  double lower = 0, upper = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = 0; j < 5; ++j) {
      if (kSanitized && (i + j) % 3 != 0) continue;
      const Shape rigid_a = Shape::mesh(meshes[i].mesh), rigid_b = Shape::mesh(meshes[j].mesh),
                  a = (i + j) % 3 == 1 ? rigid_a : Shape::deformable(deforming[i].snapshot()),
                  b = (i + j) % 3 == 2 ? rigid_b : Shape::deformable(deforming[j].snapshot());
      const Pose X_WA = random.pose(0.1), X_WB = random.pose(0.5);
      DistanceRequest request;
      const DistanceResult r = distance(a, X_WA, b, X_WB, request, scratch);
      if (!(r.distance.upper <= 0)) continue;
      const double twin = shortest(rigid_a, X_WA, rigid_b, X_WB, 2, 0.02, scratch);
      const std::string names = meshes[i].name + " and " + meshes[j].name;
      ++count;
      EXPECT_LE(-r.distance.upper, twin) << names;
      EXPECT_LT(-r.distance.lower, 2 * twin) << names;
      lower += -r.distance.lower / twin;
      upper += -r.distance.upper / twin;
      // The translation by the lower end separates them.
      Pose moved = X_WB;
      moved.translation += (1e-9 - r.distance.lower) * r.normal;
      EXPECT_GT(distance(rigid_a, X_WA, rigid_b, moved, {}, scratch).distance.lower, 0) << names;
      // A limit costs width, but the interval stays valid.
      for (const int nodes : {1, 20, 400}) {
        request.node_limit = nodes;
        const DistanceResult limited = distance(a, X_WA, b, X_WB, request, scratch);
        EXPECT_LE(limited.distance.lower, -twin / 2) << names << ", nodes " << nodes;
        EXPECT_GE(limited.distance.upper, -twin) << names << ", nodes " << nodes;
      }
    }
  }
  EXPECT_GT(count, kSanitized ? 5 : 18);
  EXPECT_LT(lower, 1.05 * count);
  EXPECT_GT(upper, 0.65 * count);
}

// Concentric cubes of 0.6 m. Regression: only the deepest pair of triangles was known, so the depth
// was bounded by 0.01 and 0.58 m.
TEST(MeshDepth, OfConcentricDeformingCubesIsTheDistanceToTheirFaces) {
  const TriangleSoup soup = boxSoup({0.3, 0.3, 0.3});
  const NamedMesh cube = named("cube", soup);
  Pose X_WB;
  X_WB.translation = {0, 0.01, 0.02};
  Scratch scratch;
  for (const DeformStrategy strategy :
       {DeformStrategy::kRefit, DeformStrategy::kHybrid, DeformStrategy::kLazy,
        DeformStrategy::kOctree, DeformStrategy::kRebuild}) {
    const Deformable one = deformableOf(*cube.mesh, strategy),
                     two = deformableOf(*cube.mesh, strategy);
    const Shape a = Shape::deformable(one.snapshot()), b = Shape::deformable(two.snapshot());
    for (const Shape& other : {b, Shape::mesh(cube.mesh), Shape::box({0.3, 0.3, 0.3})}) {
      const DistanceResult r = distance(a, {}, other, X_WB, {}, scratch);
      EXPECT_NEAR(r.distance.lower, -0.58, 1e-6) << toString(strategy) << toString(other.type());
      EXPECT_NEAR(r.distance.upper, -0.58, 1e-6) << toString(strategy) << toString(other.type());
      const DistanceResult swapped = distance(other, X_WB, a, {}, {}, scratch);
      EXPECT_NEAR(swapped.distance.lower, -0.58, 1e-6) << toString(strategy);
      EXPECT_NEAR(swapped.distance.upper, -0.58, 1e-6) << toString(strategy);
    }
    prepare(scratch, *one.snapshot());
    prepare(scratch, *two.snapshot());
    distance(a, {}, b, X_WB, {}, scratch);
    const std::size_t before = allocationCount();
    distance(a, {}, b, X_WB, {}, scratch);
    distance(a, {}, Shape::sphere(0.3), X_WB, {}, scratch);
    EXPECT_EQ(allocationCount(), before) << toString(strategy);
  }
}

// Intermediate tolerances scale with the sizes. Regression: a fixed 1e-9 m, suited to bodies of a
// metre, widened intervals by up to 3 % for bodies of half a micrometre and up to half for half a
// nanometre.
TEST(MeshDepth, OfSmallBodiesIsThatOfLargeOnes) {
  Random random(72);
  const TriangleSoup ring = torusSoup(9, 5, 0.3, 0.1, 0, random);
  const double scales[] = {1, std::ldexp(1, -21), std::ldexp(1, -25)};
  Scratch scratch;
  std::vector<Shape> rigid, deforming;
  for (const double scale : scales) {
    std::vector<Vector3d> vertices = ring.vertices;
    for (Vector3d& v : vertices) v *= scale;
    const auto mesh = TriangleMesh::make(vertices, ring.triangles);
    rigid.push_back(Shape::mesh(mesh));
    const auto snapshot = deformableOf(*mesh, DeformStrategy::kRefit).snapshot();
    prepare(scratch, *snapshot);
    deforming.push_back(Shape::deformable(snapshot));
  }
  int overlaps = 0;
  for (int i = 0; i < casesToAsk(20); ++i) {
    const double x = random.uniform(0.05, 0.2), y = random.uniform(0.05, 0.2);
    const Pose X_WA = random.pose(0.01), X_WB = random.pose(0.5);
    for (const std::vector<Shape>& rings : {rigid, deforming}) {
      Interval expected;
      for (std::size_t k = 0; k < 3; ++k) {
        const double scale = scales[k];
        const Shape other =
            i % 2 == 0 ? Shape::sphere(x * scale) : Shape::ellipsoid(scale * Vector3d(x, y, x));
        Pose X_WC = X_WA, X_WD = X_WB;
        X_WC.translation *= scale;
        X_WD.translation *= scale;
        const Interval d = distance(rings[k], X_WC, other, X_WD, {}, scratch).distance;
        if (k == 0) {
          expected = d;
          overlaps += d.upper < 0 ? 1 : 0;
        }
        EXPECT_NEAR(d.lower / scale, expected.lower, 2e-9) << i << ", scale " << scale;
        EXPECT_NEAR(d.upper / scale, expected.upper, 2e-9) << i << ", scale " << scale;
      }
    }
  }
  EXPECT_GT(overlaps, casesToAsk(20) / 2);
}

// The deepest balls of convex solids touch where the shapes separate, so they give the exact depth.
TEST(MeshDepth, ByConcentricBallsIsExactForBoxes) {
  Scratch scratch;
  const Shape a = Shape::mesh(named("box", boxSoup({0.5, 0.4, 0.3})).mesh),
              b = Shape::box({0.2, 0.2, 0.2});
  Pose X_WB;
  X_WB.translation = {0.6, 0.1, 0.05};
  const Vector3d start(0.45, 0.1, 0.05);
  EXPECT_NEAR(solidDepth(a, {}, b, X_WB, {&start, 1}, 1000, scratch).depth, 0.1, 1e-9);
  const Vector3d outside(0.9, 0.1, 0.05);
  EXPECT_EQ(solidDepth(a, {}, b, X_WB, {&outside, 1}, 1000, scratch).depth, 0);
}

}  // namespace
}  // namespace leeway::collision
