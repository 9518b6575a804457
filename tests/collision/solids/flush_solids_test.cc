// Solids with flush faces: no triangle of one crosses a triangle of the other, but they overlap
// nevertheless.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "collision/convex/gjk/convex_view.h"
#include "collision/solids/common_point.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/time_of_contact.h"
#include "tests/support/allocations.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/polycubes.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

/// A mesh as a shape, rigid or deforming.
class Body {
 public:
  Body(const std::shared_ptr<const TriangleMesh>& mesh, bool deforms, Scratch& scratch)
      : shape_(Shape::mesh(mesh)) {
    if (!deforms) return;
    DeformOptions options;
    options.strategy = DeformStrategy::kRefit;
    deformable_ = std::make_unique<Deformable>(
        DeformableMesh::make(mesh->vertices(), mesh->triangles()), nullptr, options);
    EXPECT_EQ(deformable_->update(mesh->vertices(), 1), UpdateStatus::kUpdated);
    prepare(scratch, *deformable_->snapshot());
    shape_ = Shape::deformable(deformable_->snapshot());
  }
  const Shape& shape() const { return shape_; }

 private:
  std::unique_ptr<Deformable> deformable_;
  Shape shape_;
};

DistanceRequest withoutDepth() {
  DistanceRequest request;
  request.depth = false;
  return request;
}

/// The shortest translation of B along an axis of the grid after which no cell is shared.
double shortestAlongAxes(const Cells& a, const Cells& b, const Cell& by) {
  int shortest = 100;
  for (std::size_t k = 0; k < 3; ++k) {
    for (const int way : {1, -1}) {
      Cell at = by;
      int length = 0;
      for (; contactOf(a, b, at) == CellContact::kOverlap; ++length) at[k] += way;
      shortest = std::min(shortest, length);
    }
  }
  return shortest;
}

struct Tally {
  int overlaps = 0, touches = 0, apart = 0;
  int by_point = 0;  // overlaps proven by a common point
};

/// Pairs on a grid, in their own frame or both rotated and moved by the same pose.
Tally decideGridPairs(std::uint64_t seed, int pairs, bool bricks, bool deforms_a, bool deforms_b) {
  Random random(seed);
  Scratch scratch;
  Tally tally;
  for (int i = 0; i < pairs; ++i) {
    const CellSolid a = bricks ? randomBrickSolid(random) : randomPolycubeSolid(random),
                    b = bricks ? randomBrickSolid(random) : randomPolycubeSolid(random);
    const Cell by{random.below(5) - 2, random.below(5) - 2, random.below(5) - 2};
    const Body body_a(a.mesh, deforms_a, scratch), body_b(b.mesh, deforms_b, scratch);
    Pose X_WA, X_WB;
    if (i % 2 == 1) X_WA = X_WB = random.pose(2);
    X_WB.translation += X_WA.rotation * Vector3d(by[0], by[1], by[2]);
    const std::size_t before = allocationCount();
    const DistanceResult r =
        distance(body_a.shape(), X_WA, body_b.shape(), X_WB, withoutDepth(), scratch);
    EXPECT_EQ(allocationCount(), before);
    SCOPED_TRACE("pair " + std::to_string(i) + ": " + std::to_string(r.distance.lower) + " to " +
                 std::to_string(r.distance.upper));
    switch (contactOf(a.cells, b.cells, by)) {
      case CellContact::kApart:
        ++tally.apart;
        EXPECT_GT(r.distance.lower, 0);
        break;
      case CellContact::kTouch:
        // At a distance of 0 neither can be proven, and an overlap would be wrong.
        ++tally.touches;
        EXPECT_LE(r.distance.lower, 0);
        EXPECT_GE(r.distance.upper, 0);
        break;
      case CellContact::kOverlap: {
        ++tally.overlaps;
        EXPECT_LT(r.distance.upper, -1e-6);
        EXPECT_LE(r.distance.lower, r.distance.upper);
        tally.by_point += r.point_a == r.point_b ? 1 : 0;
        // Depths: at most the length of a translation that separates, and one that does separate.
        const DistanceResult deep =
            distance(body_a.shape(), X_WA, body_b.shape(), X_WB, {}, scratch);
        const double shortest = shortestAlongAxes(a.cells, b.cells, by);
        EXPECT_GE(deep.distance.upper, -shortest * (1 + 1e-12));
        EXPECT_LT(deep.distance.upper, -1e-6);
        if (bricks && !deforms_a && !deforms_b) {
          EXPECT_NEAR(deep.distance.upper, -shortest, 1e-11);
          EXPECT_NEAR(deep.distance.lower, -shortest, 1e-11);
        }
        Pose clear = X_WB;
        clear.translation += (1e-9 - deep.distance.lower) * deep.normal;
        EXPECT_GT(distance(body_a.shape(), X_WA, body_b.shape(), clear, withoutDepth(), scratch)
                      .distance.lower,
                  0);
        break;
      }
    }
  }
  return tally;
}

// Regression: none of the polycubes' overlaps was proven, and a sixth of the bricks' overlaps was
// not.
TEST(FlushSolids, OnAGridOverlapWhereTheyShareACell) {
  const int pairs = casesToAsk(1000);
  const Tally bricks = decideGridPairs(91, pairs, true, false, false);
  EXPECT_GT(bricks.overlaps, pairs / 8);
  EXPECT_GT(bricks.touches, pairs / 4);
  EXPECT_GT(bricks.apart, pairs / 8);
  const Tally cells = decideGridPairs(92, pairs, false, false, false);
  EXPECT_GT(cells.overlaps, pairs / 12);
  EXPECT_GT(cells.touches, pairs / 4);
  EXPECT_GT(cells.by_point, cells.overlaps / 2);
}

TEST(FlushSolids, OnAGridOverlapWhereTheyDeform) {
  const int pairs = bySanitizer(300, 60, 60);  // the first that needs a common point is number 42
  for (const bool both : {false, true}) {
    if (isBrief() && !both) continue;
    const Tally bricks = decideGridPairs(93, pairs, true, true, both);
    EXPECT_GT(bricks.by_point, 0);
    EXPECT_GT(bricks.touches, pairs / 4);
    const Tally cells = decideGridPairs(94, pairs, false, true, both);
    EXPECT_GT(cells.by_point, cells.overlaps / 2);
    EXPECT_GT(cells.touches, pairs / 4);
  }
}

/// A prism along z with a regular outline.
TriangleSoup prism(int corners, double radius, double bottom, double top, double phase = 0) {
  TriangleSoup soup;
  for (const double z : {bottom, top}) {
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners + phase;
      soup.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  for (int i = 0; i < corners; ++i) {
    const int next = (i + 1) % corners;
    soup.triangles.push_back({i, next, corners + next});
    soup.triangles.push_back({i, corners + next, corners + i});
    if (i == 0 || next == 0) continue;
    soup.triangles.push_back({0, next, i});
    soup.triangles.push_back({corners, corners + i, corners + next});
  }
  return soup;
}

/// A tube along z: concave.
TriangleSoup tube(int corners, double inner, double outer, double bottom, double top) {
  TriangleSoup soup;
  for (const double z : {bottom, top}) {
    for (const double radius : {inner, outer}) {
      for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / corners;
        soup.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
      }
    }
  }
  for (int i = 0; i < corners; ++i) {
    const auto at = [&](int ring, int k) { return ring * corners + (i + k) % corners; };
    const int quads[4][4] = {{at(1, 0), at(1, 1), at(3, 1), at(3, 0)},
                             {at(0, 1), at(0, 0), at(2, 0), at(2, 1)},
                             {at(0, 0), at(0, 1), at(1, 1), at(1, 0)},
                             {at(2, 1), at(2, 0), at(3, 0), at(3, 1)}};
    for (const auto& q : quads) {
      soup.triangles.push_back({q[0], q[1], q[2]});
      soup.triangles.push_back({q[0], q[2], q[3]});
    }
  }
  return soup;
}

struct FlushPair {
  std::string name;
  TriangleSoup a, b;
  Vector3d by;
  double depth;  // of the shortest translation that separates
};

std::vector<FlushPair> flushPairs() {
  Random random(5);
  const TriangleSoup
      brick = boxSoup({0.5, 0.5, 1}),
      cube = boxSoup({1, 1, 1}), hose = tube(12, 0.5, 1, 0, 2),
      octahedron{
          {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}},
      sheet{{{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}},
            {{0, 1, 2}, {0, 2, 3}}},
      ball = ballSoup(8, 12, 1, 0.2, random), torus = torusSoup(20, 10, 1, 0.3, 0.1, random);
  TriangleSoup grid;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) append(grid, boxSoup({0.4, 0.4, 0.5}, Vector3d(i, j, 0)));
  const double in_hexagon = std::sqrt(3.0) / 2;
  return {
      {"bricks, half", brick, brick, {0, 0, 1}, 1},
      {"the same brick", brick, brick, {0, 0, 0}, 1},
      {"hexagons, half", prism(6, 1, 0, 2), prism(6, 1, 1, 3), {0, 0, 0}, 1},
      {"32 sides, half", prism(32, 1, 0, 2), prism(32, 1, 1, 3), {0, 0, 0}, 1},
      {"corners on faces",
       prism(6, 1, 0, 2),
       prism(6, in_hexagon, 0.5, 1.5, std::numbers::pi / 6),
       {0, 0, 0},
       1.5},
      {"edges on faces, flush ends",
       prism(6, 1, 0, 2),
       prism(6, in_hexagon, 0, 2, std::numbers::pi / 6),
       {0, 0, 0},
       std::sqrt(3.0)},
      {"an octahedron in a cube", cube, octahedron, {0, 0, 0}, 2},
      {"a diamond in a square", cube, prism(4, 1, -1, 1), {0, 0, 0}, 2},
      {"tubes, half", hose, tube(12, 0.5, 1, 1, 3), {0, 0, 0}, 1},
      {"the same tube", hose, hose, {0, 0, 0}, 2},
      {"a tube and its wall", hose, tube(12, 0.5, 0.75, 0.5, 1.5), {0, 0, 0}, 1.5},
      {"thin plates", boxSoup({1, 1, 1e-4}), boxSoup({1, 1, 1e-4}), {0.5, 0, 0}, 2e-4},
      {"thinner plates", boxSoup({1, 1, 5e-7}), boxSoup({1, 1, 5e-7}), {0.5, 0, 0}, 1e-6},
      {"a micrometre deep", brick, brick, {0, 0, 2 - 1e-6}, 1e-6},
      {"a nanometre deep", brick, brick, {0, 0, 2 - 1e-9}, 1e-9},
      {"a brick in a corner", cube, boxSoup({0.5, 0.5, 0.5}), {0.5, 0.5, 0.5}, 1},
      {"a slice", cube, boxSoup({0.5, 1, 1}), {0.25, 0, 0}, 1.25},
      {"grids", grid, grid, {1, 0, 0.5}, 0.5},
      {"grids, half", grid, grid, {0.5, 0, 0}, 1},
      {"a sheet across a brick", brick, sheet, {0, 0, 0.3}, 0.7},
      {"a bumpy ball and itself", ball, ball, {0, 0, 0}, 2.5},
      {"a torus and itself", torus, torus, {0, 0, 0}, 1},
  };
}

TEST(FlushSolids, OfAllKindsOverlap) {
  Random random(95);
  Scratch scratch;
  int number = 0;
  for (const FlushPair& pair : flushPairs()) {
    ++number;
    const auto mesh_a = TriangleMesh::make(pair.a.vertices, pair.a.triangles),
               mesh_b = TriangleMesh::make(pair.b.vertices, pair.b.triangles);
    const int cases = bySanitizer(18, 5, 5);
    for (int i = 0; i < cases; ++i) {
      if (isBrief() && i != number % cases) continue;  // one of each pair, in turn
      SCOPED_TRACE(pair.name + ", " + std::to_string(i));
      const Body a(mesh_a, i % 3 > 0, scratch), b(mesh_b, i % 3 > 1, scratch);
      Pose X_WA;
      if (i >= 3) X_WA = random.pose(i < cases / 2 ? 0 : 5);
      Pose X_WB = X_WA;
      X_WB.translation += X_WA.rotation * pair.by;
      const DistanceResult r = i % 2 == 0 ? distance(a.shape(), X_WA, b.shape(), X_WB, {}, scratch)
                                          : distance(b.shape(), X_WB, a.shape(), X_WA, {}, scratch);
      EXPECT_LT(r.distance.upper, 0);
      EXPECT_GE(r.distance.upper, -pair.depth * (1 + 1e-9) - 1e-13);
      const DistanceResult quick =
          distance(a.shape(), X_WA, b.shape(), X_WB, withoutDepth(), scratch);
      EXPECT_LT(quick.distance.upper, 0);
    }
  }
}

/// By solid angles.
bool isInsideAny(const TriangleMesh& mesh, const Vector3d& p) {
  for (int c = 0; c < mesh.componentCount(); ++c)
    if (mesh.isClosed(c) && std::lround(windingAround(mesh, c, p)) != 0) return true;
  return false;
}

double fromSurface(const TriangleMesh& mesh, const Vector3d& p) {
  double least = 1e9;
  const Shape point = Shape::sphere(0);
  Pose X;
  X.translation = p;
  for (const auto& t : mesh.triangles()) {
    std::vector<Vector3d> corners;
    for (const auto v : t) corners.push_back(mesh.vertices()[static_cast<std::size_t>(v)]);
    const Shape triangle = Shape::convexHull(corners);
    least = std::min(least, distance(triangle, {}, point, X, {}).distance.upper);
  }
  return least;
}

// A common point is inside both solids, or on one and inside the other, and not deeper than its
// distances from both surfaces.
TEST(FlushSolids, AreProvenByPointsInsideBoth) {
  Random random(96);
  Scratch scratch;
  int found = 0, inside_both = 0;
  for (int i = 0; i < casesToAsk(150); ++i) {
    const CellSolid a = randomPolycubeSolid(random), b = randomPolycubeSolid(random);
    Pose X_WB;
    X_WB.translation = {random.below(5) - 2.0, random.below(5) - 2.0, random.below(5) - 2.0};
    if (i % 3 == 2) X_WB.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    const Shape shape_a = Shape::mesh(a.mesh), shape_b = Shape::mesh(b.mesh);
    // (Keeps the triangles that touch.)
    distance(shape_a, {}, shape_b, X_WB, withoutDepth(), scratch);
    const RelativePose relative = relativePose({}, X_WB);
    const CommonPoint common = commonPoint(shape_a, shape_b, relative, scratch);
    if (!(common.depth > 0)) continue;
    ++found;
    const Vector3d in_a = X_WB * common.point;
    const double of_a = fromSurface(*a.mesh, in_a), of_b = fromSurface(*b.mesh, common.point);
    const bool inside_a = isInsideAny(*a.mesh, in_a), inside_b = isInsideAny(*b.mesh, common.point);
    EXPECT_TRUE(inside_a || of_a < 1e-12);
    EXPECT_TRUE(inside_b || of_b < 1e-12);
    EXPECT_TRUE((inside_a && of_a > 1e-12) || (inside_b && of_b > 1e-12));
    EXPECT_LE(common.depth, of_a + of_b + 1e-12);
    inside_both += inside_a && inside_b && of_a > 1e-12 && of_b > 1e-12 ? 1 : 0;
  }
  EXPECT_GT(found, casesToAsk(10));
  EXPECT_GT(inside_both, 0);
}

// A motion along the grid: first contact where cells meet face to face.
TEST(FlushSolids, MeetWhenTheirCellsDo) {
  Random random(97);
  Scratch scratch;
  int hits = 0, frees = 0;
  for (int i = 0; i < casesToAsk(400); ++i) {
    const bool bricks = i % 4 == 0;
    const CellSolid a = bricks ? randomBrickSolid(random) : randomPolycubeSolid(random),
                    b = bricks ? randomBrickSolid(random) : randomPolycubeSolid(random);
    const auto axis = static_cast<std::size_t>(random.below(3));
    const Cell by{random.below(4) - 1, random.below(4) - 1, random.below(4) - 1};
    // How far A may move until it shares a face with B, and until it touches B anywhere.
    double first = 1e9, beside = 1e9;
    for (const Cell& c : a.cells) {
      for (const Cell& d : b.cells) {
        bool meets = true, touches = true;
        for (std::size_t k = 0; k < 3; ++k) {
          if (k == axis) continue;
          meets = meets && c[k] + by[k] == d[k];
          touches = touches && std::abs(c[k] + by[k] - d[k]) <= 1;
        }
        const double way = d[axis] - c[axis] - 1;
        if (meets) first = std::min(first, way);
        if (touches) beside = std::min(beside, way);
      }
    }
    if (beside < first) continue;  // slides along B first: in contact, which cannot be proven
    Vector3d from(by[0], by[1], by[2]), to = from;
    from[static_cast<Eigen::Index>(axis)] = -12.3;
    to[static_cast<Eigen::Index>(axis)] = 13.1;
    Pose X_WB;
    if (i % 2 == 1) X_WB = random.pose(1);
    const StraightMotion motion({X_WB.rotation, X_WB * from}, {X_WB.rotation, X_WB * to});
    const ContactResult result =
        timeOfContact(Shape::mesh(a.mesh), motion, Shape::mesh(b.mesh), Still(X_WB), {}, scratch);
    if (first > 1e8) {
      ++frees;
      EXPECT_EQ(result.status, ContactStatus::kFree) << i;
      continue;
    }
    ++hits;
    const double truth = (first + 12.3) / 25.4;
    ASSERT_EQ(result.status, ContactStatus::kContact) << i;
    EXPECT_LE(result.time.lower, truth + 1e-12) << i;
    EXPECT_GE(result.time.upper, truth - 1e-12) << i;
    EXPECT_LE(result.time.width(), 1.001e-6) << i;
  }
  EXPECT_GT(hits, casesToAsk(100));
  EXPECT_GT(frees, casesToAsk(40));
}

}  // namespace
}  // namespace leeway::collision
