// Convex pieces of closed meshes: their claims about the solid, and queries with them against the
// same meshes without.

#include "collision/mesh/convex_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/query/point_in_snapshot.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/shapes/hull_builder.h"
#include "collision/shapes/hull_distance.h"
#include "collision/shapes/point_triangle.h"
#include "leeway/collision/distance.h"
#include "tests/support/allocations.h"
#include "tests/support/every_target.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

constexpr double kPi = 3.14159265358979323846;

// Triangulates a plane counter-clockwise polygon by ear clipping.
std::vector<std::array<int, 3>> triangulated(const std::vector<Eigen::Vector2d>& outline) {
  std::vector<int> left(outline.size());
  std::iota(left.begin(), left.end(), 0);
  const auto turn = [&](int a, int b, int c) {
    const Eigen::Vector2d u = outline[static_cast<std::size_t>(b)] -
                              outline[static_cast<std::size_t>(a)],
                          v = outline[static_cast<std::size_t>(c)] -
                              outline[static_cast<std::size_t>(a)];
    return u.x() * v.y() - u.y() * v.x();
  };
  std::vector<std::array<int, 3>> triangles;
  while (left.size() > 3) {
    const std::size_t before = left.size();
    for (std::size_t i = 0; i < left.size() && left.size() == before; ++i) {
      const int a = left[(i + before - 1) % before], b = left[i], c = left[(i + 1) % before];
      bool ear = turn(a, b, c) > 0;
      for (const int p : left) {
        if (p == a || p == b || p == c) continue;
        ear = ear && !(turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0);
      }
      if (!ear) continue;
      triangles.push_back({a, b, c});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
    }
    if (left.size() == before) return {};
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

// The polygon's prism, sides cut into `layers`.
TriangleSoup prism(const std::vector<Eigen::Vector2d>& outline, double height, int layers) {
  TriangleSoup soup;
  const int n = static_cast<int>(outline.size());
  for (int i = 0; i <= layers; ++i) {
    for (const auto& p : outline) soup.vertices.emplace_back(p.x(), p.y(), height * i / layers);
  }
  for (int i = 0; i < layers; ++i) {
    for (int j = 0; j < n; ++j) {
      const int a = i * n + j, b = i * n + (j + 1) % n;
      soup.triangles.push_back({a, b, b + n});
      soup.triangles.push_back({a, b + n, a + n});
    }
  }
  for (const auto& t : triangulated(outline)) {
    soup.triangles.push_back({t[0], t[2], t[1]});
    soup.triangles.push_back({t[0] + layers * n, t[1] + layers * n, t[2] + layers * n});
  }
  return soup;
}

// A body of revolution about x.
TriangleSoup turned(int along, int around, const std::function<Eigen::Vector2d(double)>& outline) {
  TriangleSoup soup;
  for (int i = 1; i < along; ++i) {
    const Eigen::Vector2d p = outline(static_cast<double>(i) / along);
    for (int j = 0; j < around; ++j) {
      const double v = 2 * kPi * j / around;
      soup.vertices.emplace_back(p.x(), p.y() * std::cos(v), p.y() * std::sin(v));
    }
  }
  const auto at = [&](int i, int j) { return (i - 1) * around + j % around; };
  const int first = static_cast<int>(soup.vertices.size());
  soup.vertices.emplace_back(outline(0).x(), 0, 0);
  soup.vertices.emplace_back(outline(1).x(), 0, 0);
  for (int j = 0; j < around; ++j) {
    soup.triangles.push_back({first, at(1, j), at(1, j + 1)});
    soup.triangles.push_back({first + 1, at(along - 1, j + 1), at(along - 1, j)});
    for (int i = 1; i + 1 < along; ++i) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

TriangleSoup dumbbell(int along, int around) {
  const double cut = std::asin(0.3);
  return turned(along, around, [&](double u) -> Eigen::Vector2d {
    const double side = u < 0.5 ? -1 : 1, end = 1 - std::abs(2 * u - 1);  // 0 at the ends
    if (end < 0.9) {
      const double a = end / 0.9 * (kPi - cut);
      return {side * (0.5 + 0.3 * std::cos(a)), 0.3 * std::sin(a)};
    }
    return {side * (0.5 - 0.3 * std::cos(cut)) * (1 - end) / 0.1, 0.09};
  });
}

TriangleSoup dentedBall(int along, int around) {
  return turned(along, around, [](double u) -> Eigen::Vector2d {
    const double x = 0.5 * std::cos(kPi * u), r = 0.5 * std::sin(kPi * u);
    return {std::min(x, 0.55 - 0.6 * std::cos(2 * r)), r};
  });
}

TriangleSoup gear(int teeth, int layers) {
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 4 * teeth; ++i) {
    const double a = 2 * kPi * (i + 0.2 * (i % 2 == 0 ? 1 : -1)) / (4 * teeth);
    const double r = i % 4 < 2 ? 0.5 : 0.4;
    outline.emplace_back(r * std::cos(a), r * std::sin(a));
  }
  return prism(outline, 0.2, layers);
}

// Coordinates rounded to floats, as in files.
TriangleSoup rounded(TriangleSoup soup, const Pose& X) {
  for (auto& v : soup.vertices) {
    v = X * v;
    for (int k = 0; k < 3; ++k) v[k] = roundedToSingle(v[k]);
  }
  return soup;
}

struct Case {
  std::string name;
  TriangleSoup soup;
  bool pays;
};

std::vector<Case> concaveSolids(std::uint64_t seed) {
  Random random(seed);
  const std::vector<Eigen::Vector2d> l = {{0, 0},     {0.8, 0},   {0.8, 0.2},
                                          {0.2, 0.2}, {0.2, 0.9}, {0, 0.9}},
                                     u = {{0, 0},     {0.9, 0},   {0.9, 0.8}, {0.7, 0.8},
                                          {0.7, 0.2}, {0.2, 0.2}, {0.2, 0.7}, {0, 0.7}};
  // Decomposing is two hundred times slower under sanitizers, so they use smaller solids of every
  // kind.
  const auto count = [](int plain, int sanitized) { return kSanitized ? sanitized : plain; };
  const TriangleSoup bar = dumbbell(count(24, 14), count(14, 8)), wheel = gear(9, count(6, 4));
  std::vector<Case> cases;
  cases.push_back({"L", prism(l, 0.3, 4), true});
  cases.push_back({"U", prism(u, 0.3, count(16, 8)), true});
  cases.push_back(
      {"turned L in single precision", rounded(prism(l, 0.3, 12), random.pose(1)), true});
  // Its walls are needles, bent by rounding.
  cases.push_back(
      {"turned U in single precision", rounded(prism(u, 0.3, 16), random.pose(1)), false});
  cases.push_back({"gear", wheel, true});
  cases.push_back(
      {"gear in single precision", rounded(gear(7, count(8, 5)), random.pose(0.5)), true});
  cases.push_back({"dumbbell", bar, true});
  cases.push_back({"dumbbell in single precision", rounded(bar, random.pose(0.3)), true});
  cases.push_back({"dented ball", dentedBall(count(18, 12), count(16, 10)), false});
  cases.push_back({"torus", torusSoup(count(16, 10), count(24, 20), 0.6, 0.2, 0, random), true});
  cases.push_back({"bumpy torus", torusSoup(count(14, 10), 10, 0.6, 0.2, 0.2, random), false});
  cases.push_back({"bumpy ball", ballSoup(count(12, 8), count(16, 10), 0.5, 0.3, random), false});
  // Two touching solids with a cavity between them.
  TriangleSoup two = dumbbell(count(20, 14), count(10, 8));
  append(two, prism(l, 0.3, 4), random.pose(0.2));
  cases.push_back({"two solids", two, true});
  return cases;
}

double distanceFromSurface(const TriangleMesh& mesh, const Vector3d& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles()) {
    const auto at = [&](std::size_t k) { return mesh.vertices()[static_cast<std::size_t>(t[k])]; };
    best = std::min(best, (closestPointOnTriangle(p, at(0), at(1), at(2)) - p).norm());
  }
  return best;
}

bool isInside(const TriangleMesh& mesh, const Vector3d& p) {
  for (int c = 0; c < mesh.componentCount(); ++c) {
    if (mesh.isClosed(c) && sideOf(mesh, c, p) == Side::kInside) return true;
  }
  return false;
}

// Patches lie in their hulls, and hulls in the solid up to the excess.
void expectHeld(const std::string& name, const TriangleMesh& mesh, Random& random,
                int points_a_piece) {
  const ConvexPieces pieces = convexPieces(mesh);
  std::vector<int> seen(mesh.triangles().size(), 0);
  for (const ConvexPiece& piece : pieces.pieces) {
    const auto vertices = piece.hull->vertices();
    const HullBuilder hull(vertices);
    for (const std::int32_t t : piece.triangles) {
      ++seen[static_cast<std::size_t>(t)];
      for (const std::int32_t v : mesh.triangles()[static_cast<std::size_t>(t)]) {
        ASSERT_EQ(distanceFromHull(mesh.vertices()[static_cast<std::size_t>(v)], vertices, hull), 0)
            << name;
      }
    }
    EXPECT_LE(piece.excess, pieces.summary.excess);
    for (int i = 0; i < points_a_piece; ++i) {
      // Hull corners, edges, facets and interior.
      Vector3d p = Vector3d::Zero();
      double sum = 0;
      const int corners = 1 + random.below(5);
      for (int k = 0; k < corners; ++k) {
        const double share = random.uniform(0, 1);
        p += share *
             vertices[static_cast<std::size_t>(random.below(static_cast<int>(vertices.size())))];
        sum += share;
      }
      p /= sum;
      if (isInside(mesh, p)) continue;
      // Point and distance are rounded.
      EXPECT_LE(distanceFromSurface(mesh, p),
                piece.excess + kRelativeRounding * mesh.tree().extent())
          << name;
    }
  }
  for (const int count : seen) ASSERT_LE(count, 1) << name;
}

TEST(ConvexPieces, LieInTheSolidAndHoldTheirTriangles) {
  Random random(81);
  for (const Case& c : concaveSolids(81)) {
    const NamedMesh m = named(c.name, c.soup);
    ASSERT_GT(m.mesh->closedComponentCount(), 0) << c.name;
    const PieceSummary& summary = m.mesh->pieces();
    EXPECT_EQ(summary.use == PieceSummary::Use::kUsed, c.pays) << c.name;
    if (summary.use != PieceSummary::Use::kUsed) {
      EXPECT_EQ(summary.pieces, 0);
      EXPECT_EQ(m.mesh->tree().pieceCount(), 0);
      continue;
    }
    EXPECT_EQ(m.mesh->tree().pieceCount(), summary.pieces);
    EXPECT_LT(kPieceTriangles * (summary.pieces + summary.loose_triangles),
              static_cast<double>(m.mesh->triangles().size()) + 1e-9)
        << c.name;
    // Solids with unrounded corners have exact pieces, up to the planes' rounding.
    const bool single = c.name.find("single") != std::string::npos;
    EXPECT_LE(summary.excess, single ? 1e-5 : 1e-11) << c.name;
    expectHeld(c.name, *m.mesh, random, casesToAsk(60));
  }
}

TEST(ConvexPieces, SayWhyNot) {
  using Use = PieceSummary::Use;
  Random random(82);
  const auto use = [](const TriangleSoup& soup) {
    return TriangleMesh::make(soup.vertices, soup.triangles)->pieces().use;
  };
  TriangleSoup open = dumbbell(14, 8);
  EXPECT_EQ(use(open), Use::kUsed);
  EXPECT_EQ(TriangleMesh::make(open.vertices, open.triangles, {.decompose = false})->pieces().use,
            Use::kNotAsked);
  open.triangles.pop_back();
  EXPECT_EQ(use(open), Use::kOpen);
  EXPECT_EQ(use(boxSoup({1, 1, 1})), Use::kUsed);
  TriangleSoup dented = boxSoup({1, 1, 1});
  dented.vertices[0] *= 0.3;
  EXPECT_EQ(use(dented), Use::kSmall);
  EXPECT_EQ(use(ballSoup(12, 16, 0.5, 0.3, random)), Use::kConcave);
}

/// A box, octahedron or tetrahedron, placed and rounded.
TriangleSoup smallConvex(int kind, const Pose& X) {
  TriangleSoup solid = boxSoup({0.3, 0.2, 0.1});
  if (kind == 1) {
    solid = {
        {{0.3, 0, 0}, {-0.3, 0, 0}, {0, 0.2, 0}, {0, -0.2, 0}, {0, 0, 0.4}, {0, 0, -0.1}},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  }
  if (kind == 2)
    solid = {{{0, 0, 0}, {0.4, 0, 0}, {0, 0.4, 0}, {0, 0, 0.4}},
             {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  TriangleSoup placed;
  append(placed, solid, X);
  return placed;
}

// Convex components are pieces, however few triangles they have. Regression: a box mesh was not,
// and its depth in a cylinder stayed 4 % wide.
TEST(ConvexPieces, ConvexComponentsAreWhole) {
  Random random(90);
  for (const int count : {1, 2, 5, 40}) {
    for (int kind = 0; kind < 4; ++kind) {
      TriangleSoup soup;
      for (int i = 0; i < count; ++i) {
        Pose X = random.pose(0.3);
        X.translation += Vector3d(2 * i, 0, 0);
        append(soup, smallConvex(kind < 3 ? kind : i % 3, X));
      }
      const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
      ASSERT_EQ(mesh->pieces().use, PieceSummary::Use::kUsed) << count << " " << kind;
      EXPECT_EQ(mesh->pieces().pieces, count);
      EXPECT_EQ(mesh->pieces().loose_triangles, 0);
      // Coordinates reach 80 m.
      EXPECT_LE(mesh->pieces().excess, 1e-12);
      expectHeld("convex", *mesh, random, casesToAsk(20));
    }
  }
  // The same with another component that is not convex.
  TriangleSoup mixed = torusSoup(20, 10, 1, 0.3, 0.2, random);
  EXPECT_EQ(TriangleMesh::make(mixed.vertices, mixed.triangles)->pieces().use,
            PieceSummary::Use::kConcave);
  append(mixed, smallConvex(0, random.pose(0.1)));
  const auto mesh = TriangleMesh::make(mixed.vertices, mixed.triangles);
  EXPECT_EQ(mesh->pieces().pieces, 1);
  EXPECT_EQ(mesh->pieces().loose_triangles, 400);
  expectHeld("torus and box", *mesh, random, casesToAsk(20));
}

// A component with a dent deeper than the rounding of mesh files is not convex. The excess covers
// shallower dents.
TEST(ConvexPieces, DentedComponentsAreNotWhole) {
  Random random(93);
  for (const double depth : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.1}) {
    TriangleSoup soup = boxSoup({0.3, 0.2, 0.1});
    // A vertex in the middle of the top, a little below it.
    soup.vertices.emplace_back(0, 0, 0.1 - depth);
    soup.triangles[2] = {4, 5, 8};
    soup.triangles[3] = {5, 7, 8};
    soup.triangles.push_back({7, 6, 8});
    soup.triangles.push_back({6, 4, 8});
    TriangleSoup placed;
    append(placed, soup, random.pose(0.3));
    const auto mesh = TriangleMesh::make(placed.vertices, placed.triangles);
    EXPECT_EQ(mesh->closedComponentCount(), 1);
    if (depth > 2e-7) {
      EXPECT_EQ(mesh->pieces().use, PieceSummary::Use::kSmall) << depth;
      continue;
    }
    EXPECT_EQ(mesh->pieces().pieces, 1) << depth;
    EXPECT_GE(mesh->pieces().excess, depth);
    EXPECT_LE(mesh->pieces().excess, 10 * depth + 1e-14);
    expectHeld("dented", *mesh, random, casesToAsk(200));
  }
}

// The depth of a convex mesh is that of its hull.
TEST(ConvexPieces, AreAsDeepAsTheirHulls) {
  Random random(91);
  Scratch scratch;
  int deep = 0;
  for (int i = 0; i < casesToAsk(300); ++i) {
    const TriangleSoup soup = smallConvex(i % 3, random.pose(0.1)),
                       other = smallConvex(i / 3 % 3, random.pose(0.1));
    const Shape mesh = Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles)),
                hull = Shape::convexHull(soup.vertices);
    auto partners = sampleConvexShapes(random);
    partners.emplace_back("mesh", Shape::mesh(TriangleMesh::make(other.vertices, other.triangles)));
    for (const auto& [name, partner] : partners) {
      const Shape twin =
          partner.isConvex() ? partner : Shape::convexHull(partner.mesh()->vertices());
      const Pose X = random.pose(0.2);
      const DistanceResult of_hull = distance(hull, {}, twin, X, {}, scratch);
      if (!(of_hull.distance.upper < -1e-6)) continue;
      ++deep;
      const DistanceResult of_mesh = distance(mesh, {}, partner, X, {}, scratch);
      EXPECT_LE(of_mesh.distance.lower, of_hull.distance.upper) << name;
      EXPECT_GE(of_mesh.distance.upper, of_hull.distance.lower) << name;
      EXPECT_LE(of_mesh.distance.width(), std::max(of_hull.distance.width(), 1e-9)) << name;
    }
  }
  EXPECT_GT(deep, casesToAsk(1000));
}

TEST(ConvexPieces, ACylinderInABoxOfTwelveTriangles) {
  const TriangleSoup soup = boxSoup({0.5, 0.4, 0.3});
  const Shape box = Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles)),
              cylinder = Shape::cylinder(0.1, 0.2);
  Pose X;
  X.translation = {0.3, 0.1, 0.05};
  // The exit along x: the cylinder's radius plus the distance of the box's face.
  const DistanceResult r = distance(box, {}, cylinder, X);
  EXPECT_EQ(r.status, DistanceStatus::kConverged);
  EXPECT_NEAR(r.distance.lower, -0.3, 1e-12);
  EXPECT_NEAR(r.distance.upper, -0.3, 1e-12);
}

// Triangles that repeat a vertex attach to solids without opening them, and stay loose.
TEST(ConvexPieces, WithTrianglesThatAreNone) {
  Random random(89);
  TriangleSoup soup = dumbbell(14, 8);
  const auto plain = TriangleMesh::make(soup.vertices, soup.triangles);
  const TriangleMesh::Triangle edge{soup.triangles[3][0], soup.triangles[3][0],
                                    soup.triangles[3][1]};
  soup.triangles.insert(soup.triangles.begin(), edge);
  soup.triangles.push_back({0, 5, 5});  // a chord
  soup.triangles.push_back({7, 7, 7});
  const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
  ASSERT_EQ(mesh->closedComponentCount(), 1);
  EXPECT_EQ(mesh->pieces().pieces, plain->pieces().pieces);
  EXPECT_EQ(mesh->pieces().loose_triangles, plain->pieces().loose_triangles + 3);
  expectHeld("dumbbell with segments", *mesh, random, casesToAsk(20));
}

// A convex mesh is one piece.
TEST(ConvexPieces, OneForABall) {
  Random random(83);
  const TriangleSoup ball = ballSoup(14, 20, 0.5, 0, random);
  const auto mesh = TriangleMesh::make(ball.vertices, ball.triangles);
  EXPECT_EQ(mesh->pieces().pieces, 1);
  EXPECT_EQ(mesh->pieces().loose_triangles, 0);
  EXPECT_LE(mesh->pieces().excess, 1e-13);
}

// A solid with and without pieces.
struct Twins {
  std::string name;
  Shape pieces, soup;
};

Twins twins(const std::string& name, const TriangleSoup& soup) {
  return {name, Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles)),
          Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles, {.decompose = false}))};
}

struct Tally {
  int asked = 0, unsafe = 0, apart = 0, overlap = 0, shallower = 0;
};

// Both verdicts occur, and pieces usually reach greater depths than triangles.
void expectManyOfBoth(const Tally& tally) {
  EXPECT_EQ(tally.unsafe, 0);
  EXPECT_GT(tally.apart, 0.35 * tally.asked);
  EXPECT_GT(tally.overlap, 0.15 * tally.asked);
  EXPECT_LE(tally.shallower, 1 + tally.overlap / 10);
}

// Both answers contain the truth: they agree, and both decide pairs that are apart.
void compare(const Twins& a, const Pose& X_WA, const Twins& b, const Pose& X_WB, Scratch& scratch,
             Random& random, PairCache* cache, Tally& tally) {
  std::ostringstream text;
  text.precision(17);
  text << a.name << " and " << b.name << "\nX_WA\n"
       << X_WA.rotation << "\n"
       << X_WA.translation.transpose() << "\nX_WB\n"
       << X_WB.rotation << "\n"
       << X_WB.translation.transpose();
  const DistanceResult soup = distance(a.soup, X_WA, b.soup, X_WB, {}, scratch);
  const DistanceResult r = distance(a.pieces, X_WA, b.pieces, X_WB, {}, scratch, cache);
  text << "\npieces [" << r.distance.lower << ", " << r.distance.upper << "] soup ["
       << soup.distance.lower << ", " << soup.distance.upper << "]";
  const auto unsafe = [&](const DistanceResult& d, const char* what) {
    if (d.distance.lower <= soup.distance.upper && d.distance.upper >= soup.distance.lower) return;
    ++tally.unsafe;
    ADD_FAILURE() << what << " [" << d.distance.lower << ", " << d.distance.upper << "] "
                  << text.str();
  };
  unsafe(r, "distance");
  const bool apart = soup.distance.lower > 0, overlap = soup.distance.upper <= 0;
  ++tally.asked;
  tally.apart += apart ? 1 : 0;
  tally.overlap += overlap ? 1 : 0;
  if (apart) {
    EXPECT_LE(r.distance.width(), 3e-9) << text.str();
    EXPECT_NEAR((r.point_a - r.point_b).norm(), soup.distance.upper, 1e-7) << text.str();
    EXPECT_NEAR((r.point_b - r.point_a).normalized().dot(r.normal), 1,
                soup.distance.upper > 1e-4 ? 1e-6 : 2)
        << text.str();
  } else if (overlap) {
    EXPECT_LE(r.distance.upper, soup.distance.upper < -1e-8 ? 0 : 1e-9) << text.str();
    tally.shallower += r.distance.upper > 0.85 * soup.distance.upper + 1e-8 ? 1 : 0;
    Pose moved = X_WB;
    moved.translation += (1e-9 - r.distance.lower * (1 + 1e-12)) * r.normal;
    EXPECT_GT(distance(a.soup, X_WA, b.soup, moved, {}, scratch).distance.lower, 0) << text.str();
  }
  for (const double threshold : {0.0, soup.distance.upper + 1e-3, soup.distance.upper - 1e-3,
                                 soup.distance.upper + 2e-9, 0.1 * random.uniform()}) {
    DistanceRequest request;
    request.threshold = threshold;
    request.tolerance = 0;
    request.depth = random.below(2) != 0;
    const DistanceResult t = distance(a.pieces, X_WA, b.pieces, X_WB, request, scratch, cache);
    unsafe(t, "threshold");
    // Near contact, a negative threshold requires a depth.
    const bool told = request.depth || threshold >= 0 || soup.distance.lower > 1e-8;
    if (apart && told && std::abs(threshold - soup.distance.upper) > 1.5e-9) {
      EXPECT_EQ(t.status, threshold < soup.distance.upper ? DistanceStatus::kAboveThreshold
                                                          : DistanceStatus::kNotAboveThreshold)
          << "threshold " << threshold << " " << text.str();
    }
    if (overlap && soup.distance.upper < -1e-9 && threshold >= 0) {
      EXPECT_EQ(t.status, DistanceStatus::kNotAboveThreshold) << text.str();
    }
    const DistanceResult other = distance(b.pieces, X_WB, a.pieces, X_WA, request, scratch);
    unsafe(other, "threshold, swapped");
    const auto open = [](const DistanceResult& d) {
      return d.status != DistanceStatus::kAboveThreshold &&
             d.status != DistanceStatus::kNotAboveThreshold;
    };
    EXPECT_TRUE(open(t) || open(other) || t.status == other.status)
        << "threshold " << threshold << " " << text.str();
  }
  for (const int limit : {0, 1, 5, 25}) {
    DistanceRequest request;
    request.node_limit = limit;
    unsafe(distance(a.pieces, X_WA, b.pieces, X_WB, request, scratch), "limit");
  }
  DistanceRequest fine;
  fine.tolerance = 1e-14;
  unsafe(distance(a.pieces, X_WA, b.pieces, X_WB, fine, scratch), "fine");
  const DistanceResult swapped = distance(b.pieces, X_WB, a.pieces, X_WA, {}, scratch);
  unsafe(swapped, "swapped");
}

Pose nearTo(const Twins& a, const Pose& X_WA, const Twins& b, const Pose& X_WB, double gap,
            Scratch& scratch) {
  const DistanceResult r = distance(a.soup, X_WA, b.soup, X_WB, {}, scratch);
  Pose moved = X_WB;
  if (r.distance.lower > 0)
    moved.translation += (gap - r.distance.lower) * (r.point_b - r.point_a).normalized();
  return moved;
}

Pose somePose(int i, const Twins& a, const Pose& X_WA, const Twins& b, Random& random,
              Scratch& scratch) {
  const double reach = a.soup.boundingRadius() + b.soup.boundingRadius();
  Pose X_WB = random.pose(1);
  X_WB.translation = X_WA * a.soup.boundingCenter() - X_WB.rotation * b.soup.boundingCenter();
  if (i % 4 == 3) {  // deep
    X_WB.translation += 0.4 * reach * random.vector();
    return X_WB;
  }
  X_WB.translation += (i % 4 == 0 ? 2 : 1.1) * reach * random.direction();
  if (i % 4 == 0) return X_WB;
  const double gap = std::pow(10.0, -random.below(10));
  return nearTo(a, X_WA, b, X_WB, i % 4 == 1 ? gap : -0.1 * gap, scratch);
}

TEST(ConvexPieces, AnswerAsTheTrianglesDo) {
  Scratch scratch;
  Random random(84);
  Tally tally;
  std::vector<Twins> solids;
  for (const Case& c : concaveSolids(84)) solids.push_back(twins(c.name, c.soup));
  // Every solid with every other in each kind of placement. If that is expensive, with two of them,
  // and with one kind at a time in turn.
  const std::size_t n = solids.size(), partners = bySanitizer<std::size_t>(n, 2, 1);
  int kind = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < partners; ++j) {
      const Twins &a = solids[i], &b = solids[(i + j) % n];
      PairCache cache;
      for (int k = 0; k < (kSanitized ? 1 : 4); ++k) {
        const Pose X_WA = random.pose(1);
        compare(a, X_WA, b, somePose(kind++, a, X_WA, b, random, scratch), scratch, random, &cache,
                tally);
      }
    }
  }
  expectManyOfBoth(tally);
}

TEST(ConvexPieces, AnswerAsTheTrianglesDoToConvexShapes) {
  Scratch scratch;
  Random random(85);
  Tally tally;
  const auto shapes = sampleConvexShapes(random);
  const int step = bySanitizer(1, 2, 7);  // of the pairs of bodies
  int kind = 0, pair = 0;
  for (const Case& c : concaveSolids(85)) {
    const Twins solid = twins(c.name, c.soup);
    for (const auto& [name, shape] : shapes) {
      if (shape.type() == ShapeType::kHalfSpace || pair++ % step != 0) continue;
      const Twins other{name, shape, shape};
      PairCache cache;
      for (int i = 0; i < casesToAsk(8); ++i, ++kind) {
        const Pose X_WA = random.pose(1);
        const Pose X_WB = somePose(kind, solid, X_WA, other, random, scratch);
        if (random.below(2) == 0) {
          compare(solid, X_WA, other, X_WB, scratch, random, &cache, tally);
        } else {
          compare(other, X_WB, solid, X_WA, scratch, random, &cache, tally);
        }
      }
    }
  }
  expectManyOfBoth(tally);
}

// Small, large, far from the origin, and nearly flat.
TEST(ConvexPieces, OfAnySizeAndPlace) {
  Random random(86);
  const auto cases = concaveSolids(86);
  for (const double scale :
       kSanitized ? std::vector{1e-6, 1e6} : std::vector{1e-6, 1e-3, 1e3, 1e6}) {
    for (const std::size_t k : {0U, 4U, 6U}) {
      TriangleSoup soup = cases[k].soup;
      for (auto& v : soup.vertices) v = scale * (v + Vector3d(3, -2, 1));
      const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
      EXPECT_EQ(mesh->pieces().use, PieceSummary::Use::kUsed) << cases[k].name << scale;
      EXPECT_LE(mesh->pieces().excess, 1e-10 * scale);
      expectHeld(cases[k].name, *mesh, random, casesToAsk(20));
    }
  }
  TriangleSoup plate = cases[0].soup;
  for (auto& v : plate.vertices) v.z() *= 1e-4;
  const auto mesh = TriangleMesh::make(plate.vertices, plate.triangles);
  expectHeld("plate", *mesh, random, casesToAsk(40));
}

TEST(ConvexPieces, LinksOfRobots) {
  const auto files = meshFiles();
  if (files.empty()) GTEST_SKIP() << "no test data";
  Scratch scratch;
  Random random(87);
  Tally tally;
  int used = 0;
  const Shape box = Shape::box({0.1, 0.05, 0.02});
  const Twins post{"box", box, box};
  for (const auto& file : files) {
    const TriangleSoup soup = readMesh(file);
    if (soup.triangles.size() > 2500) continue;  // the twin is slow
    const Twins link = twins(file.filename().string(), soup);
    if (link.pieces.mesh()->pieces().use != PieceSummary::Use::kUsed) continue;
    ++used;
    expectHeld(link.name, *link.pieces.mesh(), random, casesToAsk(20));
    for (int i = 0; i < 8; ++i) {
      const Pose X_WA = random.pose(0.1);
      const Twins& other = i < 4 ? link : post;
      compare(link, X_WA, other, somePose(i, link, X_WA, other, random, scratch), scratch, random,
              nullptr, tally);
    }
  }
  EXPECT_GE(used, 5);
  EXPECT_EQ(tally.unsafe, 0);
}

TEST(ConvexPieces, AllocateNothingInQueriesAndTakeAnyCache) {
  Scratch scratch;
  Random random(88);
  const Twins a = twins("dumbbell", dumbbell(14, 8)), b = twins("gear", gear(9, 4));
  const Shape ball = Shape::sphere(0.2);
  std::size_t allocated = 0;
  for (int i = 0; i < casesToAsk(300); ++i) {
    PairCache cache;
    cache.direction_B = 3 * random.vector();
    if (random.below(3) == 0) cache.direction_B.x() = std::nan("");
    cache.simplex_count = random.below(8) - 2;
    for (int k = 0; k < 3; ++k) {
      cache.simplex_a[k] = random.below(2000) - 1000;
      cache.simplex_b[k] = random.below(2000) - 1000;
    }
    cache.vertex_a = random.below(2000) - 1000;
    cache.vertex_b = random.below(2000) - 1000;
    const int count_a = a.pieces.mesh()->tree().triangleCount(),
              count_b = b.pieces.mesh()->tree().triangleCount();
    cache.triangle_a = random.below(count_a + 20) - 5;
    cache.triangle_b = random.below(count_b + 20) - 5;
    PairCache other = cache;
    const Pose X_WA = random.pose(1), X_WB = random.pose(1);
    const std::size_t before = allocationCount();
    const Interval warm = distance(a.pieces, X_WA, b.pieces, X_WB, {}, scratch, &cache).distance;
    const Interval again = distance(a.pieces, X_WA, b.pieces, X_WB, {}, scratch, &cache).distance;
    const Interval convex = distance(a.pieces, X_WA, ball, X_WB, {}, scratch, &other).distance;
    allocated += allocationCount() - before;
    const Interval plain = distance(a.pieces, X_WA, b.pieces, X_WB, {}, scratch).distance;
    const Interval plain_convex = distance(a.pieces, X_WA, ball, X_WB, {}, scratch).distance;
    for (const auto& [l, r] :
         {std::pair(warm, plain), std::pair(again, plain), std::pair(convex, plain_convex)}) {
      EXPECT_LE(l.lower, r.upper);
      EXPECT_GE(l.upper, r.lower);
    }
  }
  EXPECT_EQ(allocated, 0U);
}

/// Every number from decompositions and queries with them.
std::vector<double> answersWithPieces() {
  Random random(90);
  Scratch scratch;
  PairCache cache;
  std::vector<double> all;
  std::vector<Shape> shapes;
  for (const TriangleSoup& soup :
       kSanitized ? std::vector{dumbbell(14, 8), gear(5, 4)}
                  : std::vector{dumbbell(24, 14), gear(9, 6), dentedBall(20, 24)}) {
    const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
    const PieceSummary& pieces = mesh->pieces();
    all.insert(all.end(), {double(pieces.pieces), double(pieces.loose_triangles), pieces.excess});
    shapes.push_back(Shape::mesh(mesh));
  }
  const std::size_t solids = shapes.size();
  shapes.push_back(Shape::box({0.2, 0.1, 0.05}));
  shapes.push_back(Shape::capsule(0.05, 0.2));
  shapes.push_back(Shape::cylinder(0.1, 0.2));
  for (int i = 0; i < casesToAsk(300); ++i) {
    const Shape& a = shapes[static_cast<std::size_t>(random.below(static_cast<int>(solids)))];
    const Shape& b =
        shapes[static_cast<std::size_t>(random.below(static_cast<int>(shapes.size())))];
    const Pose X_WA = random.pose(0.3), X_WB = random.pose(i % 2 == 0 ? 0.3 : 1);
    DistanceRequest request;
    if (i % 3 == 0) request.threshold = 0.1 * random.uniform();
    if (i % 5 == 0) request.tolerance = 1e-14;
    for (PairCache* with : {static_cast<PairCache*>(nullptr), &cache}) {
      const DistanceResult r = distance(a, X_WA, b, X_WB, request, scratch, with);
      all.insert(all.end(),
                 {r.distance.lower, r.distance.upper, r.point_a.x(), r.point_a.y(), r.point_a.z(),
                  r.point_b.x(), r.point_b.y(), r.point_b.z(), r.normal.x(), r.normal.y(),
                  r.normal.z(), double(r.iterations), double(static_cast<int>(r.status))});
    }
  }
  return all;
}

TEST(ConvexPieces, TheSameBytesOnEveryInstructionSet) {
  expectTheSameBytesOnEveryTarget(answersWithPieces);
}

// Equal pieces every time.
TEST(ConvexPieces, AreDeterministic) {
  const TriangleSoup soup = gear(9, 6);
  const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
  const ConvexPieces first = convexPieces(*mesh), second = convexPieces(*mesh);
  ASSERT_EQ(first.pieces.size(), second.pieces.size());
  for (std::size_t i = 0; i < first.pieces.size(); ++i) {
    EXPECT_EQ(first.pieces[i].triangles, second.pieces[i].triangles);
    EXPECT_EQ(first.pieces[i].excess, second.pieces[i].excess);
  }
}

}  // namespace
}  // namespace leeway::collision
