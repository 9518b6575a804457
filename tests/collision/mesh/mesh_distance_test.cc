#include "collision/distance/mesh_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/convex/gjk/convex_view.h"
#include "leeway/collision/containment.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "tests/support/allocations.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

// Convex pieces of a shape: its triangles, or itself.
std::vector<Shape> piecesOf(const Shape& shape) {
  if (shape.type() != ShapeType::kMesh) return {shape};
  std::vector<Shape> pieces;
  for (const auto& t : shape.mesh()->triangles()) {
    std::vector<Vector3d> corners;
    for (const std::int32_t v : t)
      corners.push_back(shape.mesh()->vertices()[static_cast<std::size_t>(v)]);
    pieces.push_back(Shape::convexHull(corners));
  }
  return pieces;
}

struct Bodies {
  explicit Bodies(const Shape& s) : shape(s), pieces(piecesOf(s)) {}
  Shape shape;
  std::vector<Shape> pieces;
};

// Slow twin: every piece against every piece.
Interval bruteSurfaces(const Bodies& a, const Pose& X_WA, const Bodies& b, const Pose& X_WB,
                       Scratch& scratch) {
  Interval all{kInfinity, kInfinity};
  for (const Shape& p : a.pieces) {
    for (const Shape& q : b.pieces) {
      const Vector3d gap = X_WA * p.boundingCenter() - X_WB * q.boundingCenter();
      const double coarse = gap.norm() - p.boundingRadius() - q.boundingRadius();
      if (coarse - 1e-9 > all.upper) continue;
      const Interval d = distance(p, X_WA, q, X_WB, {}, scratch).distance;
      all.lower = std::min(all.lower, d.lower);
      all.upper = std::min(all.upper, d.upper);
    }
  }
  return all;
}

bool bruteHolds(const Shape& outer, const Pose& X_WO, const Shape& inner, const Pose& X_WI) {
  if (outer.type() != ShapeType::kMesh || inner.type() == ShapeType::kHalfSpace) return false;
  std::vector<Vector3d> points;
  if (inner.type() == ShapeType::kMesh) {
    for (int c = 0; c < inner.mesh()->componentCount(); ++c) {
      for (std::size_t i = 0; i < inner.mesh()->triangles().size(); ++i) {
        if (inner.mesh()->component(static_cast<int>(i)) != c) continue;
        points.push_back(
            inner.mesh()->vertices()[static_cast<std::size_t>(inner.mesh()->triangles()[i][1])]);
        break;
      }
    }
  } else if (inner.type() == ShapeType::kConvexHull) {
    points.push_back(inner.hull()->vertices().back());
  } else {
    points.push_back(Vector3d::Zero());
  }
  for (int c = 0; c < outer.mesh()->componentCount(); ++c) {
    if (!outer.mesh()->isClosed(c)) continue;
    for (const Vector3d& p : points) {
      if (std::lround(windingAround(*outer.mesh(), c, X_WO.inverse() * (X_WI * p))) != 0)
        return true;
    }
  }
  return false;
}

std::string replay(const std::string& what, const Pose& X_WA, const Pose& X_WB,
                   const DistanceResult& r, const Interval& brute) {
  std::ostringstream out;
  out.precision(17);
  out << what << "\nX_WA\n"
      << X_WA.rotation << "\n"
      << X_WA.translation.transpose() << "\nX_WB\n"
      << X_WB.rotation << "\n"
      << X_WB.translation.transpose() << "\nanswer [" << r.distance.lower << ", "
      << r.distance.upper << "] status " << static_cast<int>(r.status) << " brute force ["
      << brute.lower << ", " << brute.upper << "]";
  return out.str();
}

struct Tally {
  int unsafe = 0, cautious = 0, apart = 0, contained = 0, crossing = 0;
};

// Every answer against the slow twin at poses far, near, touching, crossing and inside.
void compare(const Bodies& a, const Pose& X_WA, const Bodies& b, const Pose& X_WB,
             const std::string& what, Scratch& scratch, Random& random, PairCache* cache,
             Tally& tally) {
  const Interval surfaces = bruteSurfaces(a, X_WA, b, X_WB, scratch);
  const bool contained = surfaces.lower > 1e-9 && (bruteHolds(a.shape, X_WA, b.shape, X_WB) ||
                                                   bruteHolds(b.shape, X_WB, a.shape, X_WA));
  const bool apart = surfaces.lower > 1e-9 && !contained;
  // Upper bound on the exact value.
  const double highest = apart ? surfaces.upper : contained ? -surfaces.lower : surfaces.upper;
  tally.apart += apart ? 1 : 0;
  tally.contained += contained ? 1 : 0;
  tally.crossing += surfaces.upper < 0 ? 1 : 0;

  const DistanceResult r = distance(a.shape, X_WA, b.shape, X_WB, {}, scratch, cache);
  const std::string text = replay(what, X_WA, X_WB, r, surfaces);
  ASSERT_LE(r.distance.lower, r.distance.upper) << text;
  if (r.distance.lower > highest) {
    ++tally.unsafe;
    ADD_FAILURE() << "unsafe: " << text;
  }
  if (apart) {
    EXPECT_GE(r.distance.upper, surfaces.lower) << text;
    EXPECT_LE(r.distance.width(), 3e-9) << text;
    EXPECT_NEAR((r.point_a - r.point_b).norm(), surfaces.upper, 1e-7) << text;
  } else if (contained) {
    EXPECT_LE(r.distance.upper, 0) << text;
  } else if (surfaces.upper < 0) {
    EXPECT_LE(r.distance.upper, 0) << text;
  }
  EXPECT_GT(r.distance.lower, -kInfinity) << text;

  const double truth = r.distance.upper;
  for (const double threshold : {0.0, truth + 1e-3, truth - 1e-3, 0.1 * random.uniform()}) {
    DistanceRequest request;
    request.threshold = threshold;
    request.tolerance = 0;
    request.depth = random.below(2) != 0;
    const DistanceResult t = distance(a.shape, X_WA, b.shape, X_WB, request, scratch, cache);
    const std::string decided =
        "threshold " + std::to_string(threshold) + " " + replay(what, X_WA, X_WB, t, surfaces);
    if (t.distance.lower > highest) {
      ++tally.unsafe;
      ADD_FAILURE() << "unsafe: " << decided;
    }
    if (t.status == DistanceStatus::kAboveThreshold && !(highest > threshold)) {
      ++tally.unsafe;
      ADD_FAILURE() << "unsafe: " << decided;
    }
    if (apart) {
      EXPECT_GE(t.distance.upper, surfaces.lower) << decided;
      if (std::abs(threshold - surfaces.upper) > 1e-8) {
        EXPECT_EQ(t.status, threshold < surfaces.upper ? DistanceStatus::kAboveThreshold
                                                       : DistanceStatus::kNotAboveThreshold)
            << decided;
      }
    }
    if (!apart && surfaces.upper < -1e-9 && threshold >= 0) {
      EXPECT_TRUE(t.status == DistanceStatus::kNotAboveThreshold) << decided;
    }
    if (contained && threshold >= 0) {
      EXPECT_TRUE(t.status == DistanceStatus::kNotAboveThreshold) << decided;
    }
  }
  for (const int limit : {0, 1, 3, 10, 30}) {
    DistanceRequest request;
    request.node_limit = limit;
    const DistanceResult t = distance(a.shape, X_WA, b.shape, X_WB, request, scratch, nullptr);
    if (t.distance.lower > highest) {
      ++tally.unsafe;
      ADD_FAILURE() << "unsafe: limit " << limit << " " << replay(what, X_WA, X_WB, t, surfaces);
    }
    if (apart) {
      EXPECT_GE(t.distance.upper, surfaces.lower)
          << "limit " << limit << " " << replay(what, X_WA, X_WB, t, surfaces);
    }
  }
  const Containment c = contains(a.shape, X_WA, b.shape, X_WB, scratch);
  if (contained || apart) {
    EXPECT_EQ(c, contained ? Containment::kYes : Containment::kNo) << text;
  }
}

// Moves b to about `gap` from a along the witness direction, if they are apart.
Pose near(const Bodies& a, const Pose& X_WA, const Bodies& b, const Pose& X_WB, double gap,
          Scratch& scratch) {
  const DistanceResult r = distance(a.shape, X_WA, b.shape, X_WB, {}, scratch);
  Pose moved = X_WB;
  if (r.distance.lower > 0)
    moved.translation += (gap - r.distance.lower) * (r.point_b - r.point_a).normalized();
  return moved;
}

TEST(MeshDistance, AgainstConvexShapes) {
  Scratch scratch;
  Tally tally;
  Random random(21);
  const auto shapes = sampleConvexShapes(random);
  const int step = bySanitizer(1, 5, 5);  // one of each kind of placement
  int pair = 0;
  for (const NamedMesh& m : sampleMeshes(21)) {
    const Bodies mesh(Shape::mesh(m.mesh));
    for (const auto& [name, shape] : shapes) {
      if (isBrief() && pair++ % 4 != 0) continue;
      const Bodies other(shape);
      PairCache cache;
      for (int i = 0; i < 12; i += step) {
        const Pose X_WA = random.pose(1), far = random.pose(i < 4 ? 2.5 : 1);
        Pose X_WB = far;
        if (i % 3 == 0)
          X_WB = near(mesh, X_WA, other, far, std::pow(10.0, -random.below(10)), scratch);
        if (i % 3 == 1) X_WB.translation = X_WA.translation + 0.3 * random.vector();
        const std::string what = m.name + " and " + name + " " + std::to_string(i);
        if (i % 2 == 0) {
          compare(mesh, X_WA, other, X_WB, what, scratch, random, &cache, tally);
        } else {
          compare(other, X_WB, mesh, X_WA, "swapped " + what, scratch, random, &cache, tally);
        }
      }
    }
  }
  EXPECT_EQ(tally.unsafe, 0);
  const int share = isBrief() ? 4 * step : step;
  EXPECT_GT(tally.apart, 300 / share);
  EXPECT_TRUE(isBrief() || tally.contained > 20 / step) << tally.contained;
  EXPECT_GT(tally.crossing, 300 / share);
}

TEST(MeshDistance, BetweenMeshes) {
  Scratch scratch;
  Tally tally;
  Random random(22);
  const auto meshes = sampleMeshes(22);
  const int step = bySanitizer(1, 3, 3);  // one kind of placement for each pair, in turn
  int kind = 0;
  for (const NamedMesh& m : meshes) {
    for (const NamedMesh& n : meshes) {
      const Bodies a(Shape::mesh(m.mesh)), b(Shape::mesh(n.mesh));
      PairCache cache;
      for (int i = kind++ % step; i < 3; i += step) {
        if (isBrief() && kind % 4 != 0) continue;
        const Pose X_WA = random.pose(1), far = random.pose(2);
        Pose X_WB = far;
        if (i % 3 == 1) X_WB = near(a, X_WA, b, far, std::pow(10.0, -random.below(10)), scratch);
        if (i % 3 == 2) X_WB.translation = X_WA.translation + 0.2 * random.vector();
        compare(a, X_WA, b, X_WB, m.name + " and " + n.name + " " + std::to_string(i), scratch,
                random, &cache, tally);
      }
    }
  }
  EXPECT_EQ(tally.unsafe, 0);
  const int share = isBrief() ? 4 * step : step;
  EXPECT_GT(tally.apart, 50 / share);
  EXPECT_TRUE(isBrief() || tally.contained > 5 / step) << tally.contained;
  EXPECT_GT(tally.crossing, 50 / share);
}

/// A mesh whose vertices are `offset` from where they were; on a grid, so that the move is exact.
Shape movedOnGrid(TriangleSoup soup, const Vector3d& offset) {
  for (Vector3d& v : soup.vertices) v = Vector3d((v * 0x1p20).array().round()) * 0x1p-20 + offset;
  return Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles));
}

// The placement takes the offset back, exactly: the same bodies in the same places, with the same
// slow twin.
TEST(MeshDistance, FarFromItsOriginAMeshIsAsNearAndAsFast) {
  Random random(48);
  const TriangleSoup torus = torusSoup(24, 12, 1, 0.3, 0, random);
  const Bodies here(movedOnGrid(torus, Vector3d::Zero()));
  const Bodies others[] = {
      Bodies(movedOnGrid(torusSoup(16, 8, 0.5, 0.1, 0.1, random), {0, 0, 0})),
      Bodies(Shape::sphere(0.2)), Bodies(Shape::box({0.1, 0.2, 0.3})),
      Bodies(Shape::convexHull(boxSoup({0.1, 0.2, 0.1}, {3e5, 0, 7}).vertices))};
  // A quarter turn has no rounding.
  Pose X_WB;
  X_WB.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Scratch scratch;
  for (const double away : {0.0, 1e3, 1e6}) {
    const Vector3d offset(away, -away, 0.5 * away);
    const Shape far = movedOnGrid(torus, offset);
    const Pose X_far{X_WB.rotation, -(X_WB.rotation * offset)};
    Random places(49);
    int steps = 0, steps_here = 0, apart = 0;
    for (int i = 0; i < casesToAsk(80); ++i) {
      const Bodies& other = others[i % 4];
      Pose X_WA = places.pose(1.5);
      X_WA.translation -= X_WA.rotation * other.shape.boundingCenter();
      const Interval truth = bruteSurfaces(other, X_WA, here, X_WB, scratch);
      const DistanceResult near = distance(other.shape, X_WA, here.shape, X_WB, {}, scratch);
      for (const bool swapped : {false, true}) {
        const DistanceResult r = swapped ? distance(far, X_far, other.shape, X_WA, {}, scratch)
                                         : distance(other.shape, X_WA, far, X_far, {}, scratch);
        const std::string text = replay("far", X_WA, X_far, r, truth);
        steps += r.iterations;
        steps_here += near.iterations;
        // Both hold the same truth, also if they overlap.
        EXPECT_LE(r.distance.lower, near.distance.upper) << text;
        EXPECT_GE(r.distance.upper, near.distance.lower) << text;
        if (!(near.distance.lower > 0)) continue;
        ++apart;
        EXPECT_LE(r.distance.lower, truth.upper) << text;
        EXPECT_GE(r.distance.upper, truth.lower) << text;
        EXPECT_LE(r.distance.width(), 1e-6 + 1e-13 * away) << text;
      }
    }
    EXPECT_LT(steps, 1.2 * steps_here + 10) << away;
    EXPECT_GT(apart, casesToAsk(60)) << away;
  }
}

// Meshes of real robots: concave, open, many components.
TEST(MeshDistance, LinksOfRobots) {
  const auto files = meshFiles();
  if (files.empty()) GTEST_SKIP() << "no test data";
  Scratch scratch;
  Tally tally;
  Random random(29);
  const Bodies box(Shape::box({0.1, 0.05, 0.02})), post(Shape::cylinder(0.02, 0.3));
  for (const auto& file : files) {
    const TriangleSoup soup = readMesh(file);
    if (soup.triangles.size() > 1400) continue;  // the slow twin is slow
    const Bodies link(Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles)));
    const double reach = link.shape.boundingRadius();
    for (int i = 0; i < 9; ++i) {
      const Bodies& other = i % 2 == 0 ? box : post;
      const Pose X_WA = random.pose(0.1), far = random.pose(2 * reach);
      Pose X_WB = far;
      if (i % 3 == 1)
        X_WB = near(link, X_WA, other, far, std::pow(10.0, -random.below(9)), scratch);
      if (i % 3 == 2)
        X_WB.translation = X_WA * link.shape.boundingCenter() + 0.3 * reach * random.vector();
      compare(link, X_WA, other, X_WB, file.filename().string() + " " + std::to_string(i), scratch,
              random, nullptr, tally);
    }
  }
  EXPECT_EQ(tally.unsafe, 0);
  EXPECT_GT(tally.apart, 50);
  EXPECT_GT(tally.crossing, 20);
}

// A closed convex mesh equals its hull: both ends of the depth are checked.
TEST(MeshDistance, DepthOfConvexMeshesHoldsThatOfTheirHulls) {
  Scratch scratch;
  Random random(23);
  const auto shapes = sampleConvexShapes(random);
  int overlapping = 0;
  for (const NamedMesh& m : sampleMeshes(23)) {
    if (m.name != "box" && m.name != "ball") continue;
    const Shape mesh = Shape::mesh(m.mesh);
    const Shape hull = Shape::convexHull(m.mesh->vertices());
    for (const auto& [name, shape] : shapes) {
      for (int i = 0; i < casesToAsk(100); ++i) {
        const Pose X_WA = random.pose(0.5), X_WB = random.pose(0.7);
        const DistanceResult exact = distance(hull, X_WA, shape, X_WB, {}, scratch);
        const DistanceResult r = distance(mesh, X_WA, shape, X_WB, {}, scratch);
        const std::string text = replay(m.name + " and " + name, X_WA, X_WB, r, exact.distance);
        EXPECT_LE(r.distance.lower, exact.distance.upper) << text;
        EXPECT_GE(r.distance.upper, exact.distance.lower) << text;
        EXPECT_GE(r.distance.lower, exact.distance.lower - 1e-6) << text;
        if (exact.distance.upper < 0) {
          ++overlapping;
          EXPECT_LE(r.distance.upper, 0) << text;
          if (shape.type() == ShapeType::kHalfSpace) {
            EXPECT_LE(r.distance.width(), 1e-8) << text;
          }
          // Moving B along the normal separates them.
          Pose moved = X_WB;
          moved.translation += (1e-6 - r.distance.lower) * r.normal;
          EXPECT_GT(distance(mesh, X_WA, shape, moved, {}, scratch).distance.lower, 0) << text;
        }
      }
    }
  }
  EXPECT_GT(overlapping, casesToAsk(200));
}

// The lower end of an overlap is the length of a separating translation; verified by the slow twin.
TEST(MeshDistance, DepthSeparates) {
  Scratch scratch;
  Random random(28);
  const auto shapes = sampleConvexShapes(random);
  int overlapping = 0, better_than_hulls = 0, inside = 0;
  for (const NamedMesh& m : sampleMeshes(28)) {
    const Bodies a(Shape::mesh(m.mesh));
    const Shape hull = Shape::convexHull(m.mesh->vertices());
    for (const auto& [name, shape] : shapes) {
      const Bodies b(shape);
      for (int i = 0; i < (kSanitized ? 2 : 8); ++i) {
        const Pose X_WA = random.pose(0.5), X_WB = random.pose(0.7);
        const DistanceResult r = distance(a.shape, X_WA, b.shape, X_WB, {}, scratch);
        if (r.distance.lower > 0) continue;
        ++overlapping;
        const double hulls = distance(hull, X_WA, shape, X_WB, {}, scratch).distance.lower;
        better_than_hulls += r.distance.lower > 0.9 * hulls ? 1 : 0;
        inside += bruteSurfaces(a, X_WA, b, X_WB, scratch).lower > 0 ? 1 : 0;
        Pose moved = X_WB;
        moved.translation += (1e-9 - r.distance.lower * (1 + 1e-12)) * r.normal;
        const Interval after = bruteSurfaces(a, X_WA, b, moved, scratch);
        EXPECT_GT(after.lower, 0) << replay(m.name + " and " + name, X_WA, X_WB, r, after);
        EXPECT_FALSE(bruteHolds(a.shape, X_WA, b.shape, moved))
            << replay(m.name + " and " + name, X_WA, X_WB, r, after);
      }
    }
  }
  EXPECT_GT(overlapping, kSanitized ? 50 : 200);
  EXPECT_GT(better_than_hulls, kSanitized ? 2 : 20);
  EXPECT_GT(inside, kSanitized ? 0 : 10);
}

TEST(MeshDistance, StaleAndForeignCachesCostTimeOnly) {
  Scratch scratch;
  Random random(24);
  const auto meshes = sampleMeshes(24);
  const Shape a = Shape::mesh(meshes[3].mesh), b = Shape::mesh(meshes[2].mesh);
  for (int i = 0; i < casesToAsk(200); ++i) {
    PairCache cache;
    cache.direction_B = 3 * random.vector();
    if (random.below(3) == 0) cache.direction_B.x() = std::nan("");
    cache.vertex_a = random.below(2000) - 1000;
    cache.vertex_b = random.below(2000) - 1000;
    cache.triangle_a = random.below(2000) - 1000;
    cache.triangle_b = random.below(2000) - 1000;
    const Pose X_WA = random.pose(1), X_WB = random.pose(1.5);
    const Interval plain = distance(a, X_WA, b, X_WB, {}, scratch).distance;
    const Interval warm = distance(a, X_WA, b, X_WB, {}, scratch, &cache).distance;
    EXPECT_LE(warm.lower, plain.upper);
    EXPECT_GE(warm.upper, plain.lower);
  }
}

// Sheets with intersecting spheres are mostly separated by an axis of one of their boxes. That
// decides a threshold without triangles, also for matrices that are only nearly rotations.
TEST(MeshDistance, BoxesOfSheetsDecideAtOnce) {
  Scratch scratch;
  Random random(30);
  const TriangleSoup sheet = boxSoup({1, 0.8, 0.01});
  const Shape mesh = Shape::mesh(TriangleMesh::make(sheet.vertices, sheet.triangles));
  int apart = 0, at_once = 0;
  for (int i = 0; i < 400; ++i) {
    Pose X_WA = random.pose(1);
    const Pose X_WB{random.pose(1).rotation, X_WA.translation + 1.2 * random.vector()};
    if (i % 4 == 0) X_WA.rotation *= 1 + 1e-8;
    const Interval exact = distance(mesh, X_WA, mesh, X_WB, {}, scratch).distance;
    for (const double threshold : {0.0, 0.5 * exact.upper, exact.upper * (1 - 1e-6)}) {
      DistanceRequest request;
      request.threshold = threshold;
      const DistanceResult r = distance(mesh, X_WA, mesh, X_WB, request, scratch);
      EXPECT_LE(r.distance.lower, exact.upper) << i;
      EXPECT_GE(r.distance.upper, exact.lower) << i;
      EXPECT_NEAR(r.normal.norm(), 1, 1e-7) << i;
      if (!(exact.lower > std::max(threshold, 0.0))) continue;
      EXPECT_GT(r.distance.lower, threshold) << i;
      if (threshold > 0) continue;
      ++apart;
      // No witness, and the normal is a box axis: only boxes were examined.
      const double along_a = (X_WA.rotation.transpose() * r.normal).cwiseAbs().maxCoeff(),
                   along_b = (X_WB.rotation.transpose() * r.normal).cwiseAbs().maxCoeff();
      double highest = -kInfinity, lowest = kInfinity;
      for (const Vector3d& v : sheet.vertices) {
        highest = std::max(highest, r.normal.dot(X_WA * v));
        lowest = std::min(lowest, r.normal.dot(X_WB * v));
      }
      at_once += r.distance.upper == kInfinity && std::max(along_a, along_b) > 1 - 1e-7 &&
                 r.distance.lower <= lowest - highest;
    }
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(10 * at_once, 7 * apart);
}

// With too few steps for a pair of triangles, the closed form provides the witnesses.
TEST(MeshDistance, WitnessesCarryTheUpperEndWithoutSteps) {
  Scratch scratch;
  const TriangleSoup box = boxSoup({0.5, 0.5, 0.5});
  const Shape mesh = Shape::mesh(TriangleMesh::make(box.vertices, box.triangles));
  Pose X_WB;
  X_WB.translation = {1.25, 0.125, 0};
  for (const int limit : {0, 1}) {
    DistanceRequest request;
    request.tolerance = 0;
    request.iteration_limit = limit;
    const DistanceResult r = distance(mesh, Pose{}, mesh, X_WB, request, scratch);
    EXPECT_NEAR(r.distance.upper, 0.25, 1e-12) << limit;
    EXPECT_NEAR((r.point_a - r.point_b).norm(), 0.25, 1e-12) << limit;
  }
}

// Regression: squares of such distances underflow to 0, so a matrix's departure from a rotation
// was not counted; the lower end was 2.5000005e-186 for a translation of 2.5e-186 m.
TEST(MeshDistance, DeparturesFromRotationsCountNextToTheSmallestNumbers) {
  Scratch scratch;
  const std::vector<Vector3d> origin(3, Vector3d::Zero());
  const TriangleMesh::Triangle triangle{0, 1, 2};
  const Shape point = Shape::mesh(TriangleMesh::make(origin, {&triangle, 1})),
              ground = Shape::halfSpace();
  for (const double departure : {-2e-7, 2e-7}) {
    for (const double far : {2.5e-186, 2.5e-20, 2.5}) {
      Pose X_WP, X_WG;
      X_WG.rotation *= 1 + departure;
      X_WP.translation = {0, 0, far};
      // Twice the error of the plane's normal: the ground's matrix may serve either way.
      for (const DistanceResult& r : {distance(point, X_WP, ground, X_WG, {}, scratch),
                                      distance(ground, X_WG, point, X_WP, {}, scratch)}) {
        EXPECT_LE(r.distance.lower, far) << departure;
        EXPECT_GE(r.distance.upper, far) << departure;
      }
    }
  }
}

TEST(MeshDistance, PosesThatAreNoneAreInvalid) {
  Scratch scratch;
  const Shape a = Shape::mesh(sampleMeshes(25)[0].mesh), b = Shape::sphere(1);
  Pose bad;
  bad.translation.x() = std::nan("");
  EXPECT_EQ(distance(a, bad, b, {}, {}, scratch).status, DistanceStatus::kInvalid);
  EXPECT_EQ(sweptDistance(a, {}, bad, 0, b, {}, scratch).status, DistanceStatus::kInvalid);
  EXPECT_EQ(sweptDistance(a, {}, {}, std::nan(""), b, {}, scratch).status,
            DistanceStatus::kInvalid);
  bad = Pose{};
  bad.rotation *= 1.1;
  EXPECT_EQ(distance(b, {}, a, bad, {}, scratch).status, DistanceStatus::kInvalid);
  EXPECT_EQ(contains(b, {}, a, bad, scratch), Containment::kUndecided);
}

// A sweep covers every chord: triangles with corners anywhere between their two placements are no
// nearer.
TEST(MeshSweptDistance, HoldsTheChords) {
  Scratch scratch;
  Random random(26);
  const auto shapes = sampleConvexShapes(random);
  const auto meshes = sampleMeshes(26);
  int unsafe = 0, proven = 0, touched = 0, pair = 0;
  const auto check = [&](const Shape& a, const Shape& b, const std::string& what) {
    const Bodies body_a(a), body_b(b);
    for (int i = 0; i < 4; ++i) {
      const Pose X_BA0 = random.pose(2);
      Pose X_BA1 = X_BA0;
      const Vector3d axis = random.direction();
      const Pose turn{Eigen::AngleAxisd(0.4 * random.uniform(), axis).toRotationMatrix(),
                      0.3 * random.vector()};
      X_BA1 = turn * X_BA1;
      const double growth = i % 2 == 0 ? 0 : 0.01;
      const DistanceResult r = sweptDistance(a, X_BA0, X_BA1, growth, b, {}, scratch);
      double nearest = kInfinity, pieces = kInfinity;
      for (const Shape& p : body_a.pieces) {
        for (const Shape& q : body_b.pieces) {
          pieces = std::min(pieces,
                            sweptDistance(p, X_BA0, X_BA1, growth, q, {}, scratch).distance.lower);
          if (p.type() != ShapeType::kConvexHull) continue;
          if (i % 2 != 0 || random.below(4) != 0) continue;
          for (int s = 0; s <= 4; ++s) {
            std::vector<Vector3d> corners;
            for (const Vector3d& v : p.hull()->vertices()) {
              corners.push_back((1 - 0.25 * s) * (X_BA0 * v) + 0.25 * s * (X_BA1 * v));
            }
            const Interval d =
                distance(Shape::convexHull(corners), {}, q, {}, {}, scratch).distance;
            nearest = std::min(nearest, d.upper);
          }
        }
      }
      const std::string text = replay(what, X_BA0, X_BA1, r, {pieces, nearest});
      if (r.distance.lower > 0 && r.distance.lower > nearest - growth) {
        ++unsafe;
        ADD_FAILURE() << "unsafe: " << text;
      }
      if (pieces > 1e-8) {
        ++proven;
        EXPECT_GE(r.distance.lower, pieces - 2e-9) << text;
      } else {
        ++touched;
      }
      // The upper end is reached by a placement.
      const double best = std::min(bruteSurfaces(body_a, X_BA0, body_b, {}, scratch).lower,
                                   bruteSurfaces(body_a, X_BA1, body_b, {}, scratch).lower);
      EXPECT_GE(r.distance.upper, best - 1e-12) << text;
      if (!(pieces > 1e-8)) continue;
      DistanceRequest request;
      request.tolerance = 0;
      request.threshold = pieces - 1e-3;
      EXPECT_EQ(sweptDistance(a, X_BA0, X_BA1, growth, b, request, scratch).status,
                DistanceStatus::kAboveThreshold)
          << text;
      request.threshold = std::max(pieces + 1e-3, 0.0);
      EXPECT_NE(sweptDistance(a, X_BA0, X_BA1, growth, b, request, scratch).status,
                DistanceStatus::kAboveThreshold)
          << text;
    }
  };
  for (const NamedMesh& m : meshes) {
    for (const auto& [name, shape] : shapes) {
      if (isBrief() && pair++ % 4 != 0) continue;
      check(Shape::mesh(m.mesh), shape, m.name + " to " + name);
      if (name != "half-space") check(shape, Shape::mesh(m.mesh), name + " to " + m.name);
    }
    if (m.mesh->triangles().size() < 150)
      check(Shape::mesh(m.mesh), Shape::mesh(meshes[0].mesh), m.name + " to box");
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(proven, isBrief() ? 40 : 200);
  EXPECT_GT(touched, isBrief() ? 10 : 50);
}

TEST(MeshDistance, AllocatesNothing) {
  Scratch scratch;
  Random random(27);
  const auto meshes = sampleMeshes(27);
  const auto shapes = sampleConvexShapes(random);
  std::size_t allocated = 0;
  for (const NamedMesh& m : meshes) {
    const Shape a = Shape::mesh(m.mesh), b = Shape::mesh(meshes[4].mesh);
    for (int i = 0; i < casesToAsk(10); ++i) {
      const Pose X_WA = random.pose(1), X_WB = random.pose(1);
      PairCache cache;
      const std::size_t before = allocationCount();
      for (const auto& [name, shape] : shapes) {
        distance(a, X_WA, shape, X_WB, {}, scratch, &cache);
        sweptDistance(a, X_WA, X_WB, 0.1, shape, {}, scratch, &cache);
        contains(shape, X_WA, a, X_WB, scratch);
      }
      distance(a, X_WA, b, X_WB, {}, scratch, &cache);
      sweptDistance(a, X_WA, X_WB, 0.1, b, {}, scratch, &cache);
      contains(b, X_WA, a, X_WB, scratch);
      allocated += allocationCount() - before;
    }
  }
  EXPECT_EQ(allocated, 0U);
}

}  // namespace
}  // namespace leeway::collision
