#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include "collision/mesh/point_in_solid.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"
#include "tests/support/from_environment.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

// The inside of a mesh whose solids share edges and facets, whose facets are turned, doubled and
// cut in several ways, and whose corners meet in T-junctions.

namespace leeway::collision::testing {
namespace {

using Eigen::Vector3d;

// A convex solid with its facets as polygons. Its coordinates are whole numbers, so its planes
// decide whether a point is inside, without rounding that matters.
struct Solid {
  std::vector<Vector3d> corners;
  std::vector<std::vector<int>> facets;  // counter-clockwise from outside

  bool holds(const Vector3d& p) const {
    return std::all_of(facets.begin(), facets.end(), [&](const std::vector<int>& f) {
      const auto at = [&](std::size_t k) { return corners[static_cast<std::size_t>(f[k])]; };
      return (at(1) - at(0)).cross(at(2) - at(0)).dot(p - at(0)) < 0;
    });
  }
};

Solid box(const Vector3d& low, const Vector3d& high) {
  Solid solid;
  for (int i = 0; i < 8; ++i)
    solid.corners.emplace_back((i & 1) != 0 ? high.x() : low.x(), (i & 2) != 0 ? high.y() : low.y(),
                               (i & 4) != 0 ? high.z() : low.z());
  solid.facets = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  return solid;
}

// Half a box, cut along a diagonal of its bottom.
Solid prism(const Vector3d& low, const Vector3d& high) {
  Solid solid = box(low, high);
  solid.facets = {{0, 2, 1}, {4, 5, 6}, {0, 1, 5, 4}, {0, 4, 6, 2}, {1, 2, 6, 5}};
  return solid;
}

Solid randomSolid(Random& random) {
  Vector3d low, high;
  for (int k = 0; k < 3; ++k) {
    const int a = random.below(5);
    low[k] = a;
    high[k] = a + 1 + random.below(5 - a);
  }
  return random.below(3) == 0 ? prism(low, high) : box(low, high);
}

// A facet of a solid, sometimes with a corner within one of its edges. This is a T-junction,
// because the facet across the edge does not have it. Halves and quarters of whole numbers lie
// exactly on the edge.
std::vector<Vector3d> polygonOf(const Solid& solid, const std::vector<int>& facet, Random& random) {
  std::vector<Vector3d> polygon;
  const std::size_t n = facet.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3d &a = solid.corners[static_cast<std::size_t>(facet[k])],
                   &b = solid.corners[static_cast<std::size_t>(facet[(k + 1) % n])];
    polygon.push_back(a);
    if (random.below(12) == 0) polygon.push_back(a + 0.25 * (1 + random.below(3)) * (b - a));
  }
  return polygon;
}

// Cuts a facet from a random corner on; `turned` flips it.
void appendFacet(const std::vector<Vector3d>& polygon, bool turned, Random& random,
                 TriangleSoup& soup) {
  const int n = static_cast<int>(polygon.size()), first = random.below(n);
  for (int k = 1; k + 1 < n; ++k) {
    const auto v = static_cast<std::int32_t>(soup.vertices.size());
    for (const int c : {0, k, k + 1})
      soup.vertices.push_back(polygon[static_cast<std::size_t>((first + c) % n)]);
    if (turned)
      soup.triangles.push_back({v, v + 2, v + 1});
    else
      soup.triangles.push_back({v, v + 1, v + 2});
  }
}

struct Union {
  std::vector<Solid> solids;
  TriangleSoup soup;

  bool holds(const Vector3d& p) const {
    return std::any_of(solids.begin(), solids.end(), [&](const Solid& s) { return s.holds(p); });
  }
};

// Up to six solids on a lattice: they touch, overlap and share corners, edges and facets. Some are
// turned inside out, some facets are turned, and some occur twice, cut in two ways.
Union randomUnion(Random& random) {
  Union result;
  for (int k = 1 + random.below(6); k > 0; --k) {
    const Solid& solid = result.solids.emplace_back(randomSolid(random));
    const bool turned = random.below(2) != 0;
    for (const auto& facet : solid.facets) {
      const std::vector<Vector3d> polygon = polygonOf(solid, facet, random);
      appendFacet(polygon, turned != (random.below(8) == 0), random, result.soup);
      if (random.below(6) == 0) appendFacet(polygon, random.below(2) != 0, random, result.soup);
    }
  }
  return result;
}

Vector3d randomPoint(Random& random) { return 2.5 * Vector3d::Ones() + 3 * random.vector(); }

bool isInside(const TriangleMesh& mesh, const Vector3d& p) {
  for (int c = 0; c < mesh.componentCount(); ++c) {
    if (!mesh.isClosed(c)) continue;
    const Side side = sideOf(mesh, c, p);
    EXPECT_NE(side, Side::kUnknown);
    if (side == Side::kInside) return true;
  }
  return false;
}

// Points of many unions, and the number of wrong answers.
struct Count {
  int asked = 0, inside = 0, wrong = 0;

  void compare(bool answer, bool truth) {
    ++asked;
    inside += truth ? 1 : 0;
    wrong += answer != truth ? 1 : 0;
  }
  void print() const { std::printf("%d points of unions: %d wrong\n", asked, wrong); }
};

TEST(SolidParts, UnionsOfTouchingTurnedAndDoubledSolidsHaveTheirInside) {
  const int unions = static_cast<int>(fromEnvironment("LEEWAY_TEST_UNIONS", isBrief() ? 15 : 100));
  Random random(fromEnvironment("LEEWAY_TEST_SEED", 46));
  Count count;
  int shared = 0;
  for (int i = 0; i < unions; ++i) {
    const Union u = randomUnion(random);
    const auto mesh = TriangleMesh::make(u.soup.vertices, u.soup.triangles, {.decompose = false});
    ASSERT_EQ(mesh->openEdgeCount(), 0U) << "union " << i;
    for (std::size_t t = 0; t < mesh->triangles().size(); ++t)
      shared += mesh->windingWeight(static_cast<int>(t)) > 1 ? 1 : 0;
    for (int k = 0; k < 100; ++k) {
      const Vector3d p = randomPoint(random);
      count.compare(isInside(*mesh, p), u.holds(p));
      ASSERT_EQ(count.wrong, 0) << "union " << i << ", point " << p.transpose();
    }
  }
  count.print();
  EXPECT_GT(count.inside, 5 * unions);
  EXPECT_GT(shared, unions / 10);  // facets that several solids share
}

// Files have noise: each corner of each triangle is rounded separately, and turned solids meet in
// T-junctions that are not exact.
TEST(SolidParts, WeldClosesWhatNoiseHasOpened) {
  constexpr double kNoise = 1e-7, kWeld = 1e-6;
  const int unions = static_cast<int>(fromEnvironment("LEEWAY_TEST_UNIONS", isBrief() ? 15 : 100));
  Random random(fromEnvironment("LEEWAY_TEST_SEED", 47));
  Count count;
  int open = 0;
  for (int i = 0; i < unions; ++i) {
    Union u = randomUnion(random);
    const Pose X = random.pose(10);
    for (Vector3d& v : u.soup.vertices) v = X * v + kNoise * random.vector();
    open += TriangleMesh::make(u.soup.vertices, u.soup.triangles, {.decompose = false})
                        ->openEdgeCount() > 0
                ? 1
                : 0;
    const auto mesh =
        TriangleMesh::make(u.soup.vertices, u.soup.triangles, {.decompose = false, .weld = kWeld});
    ASSERT_EQ(mesh->openEdgeCount(), 0U) << "union " << i;
    for (int k = 0; k < 100; ++k) {
      const Vector3d p = randomPoint(random);
      // A point this close to a facet may be on either side of it.
      const bool is_near = std::any_of(u.solids.begin(), u.solids.end(), [&](const Solid& s) {
        return s.holds(p + 1e-5 * random.direction()) != s.holds(p - 1e-5 * random.direction());
      });
      if (is_near) continue;
      count.compare(isInside(*mesh, X * p), u.holds(p));
      ASSERT_EQ(count.wrong, 0) << "union " << i << ", point " << p.transpose();
    }
  }
  count.print();
  EXPECT_EQ(open, unions);
  EXPECT_GT(count.inside, 5 * unions);
}

// Two boxes of different sizes that share the edge x = y = 0, z = 0 to 4. Their facets y = 0 are
// cut along it at the heights `first`, their facets x = 0 at `second`. Bits of `turned` turn the
// small box, the large one, and one facet of each back.
TriangleSoup boxesOnOneEdge(const std::vector<double>& first, const std::vector<double>& second,
                            int turned) {
  TriangleSoup soup;
  const auto vertex = [&](const Vector3d& p) {
    const auto found = std::find(soup.vertices.begin(), soup.vertices.end(), p);
    const auto v = static_cast<std::int32_t>(found - soup.vertices.begin());
    if (found == soup.vertices.end()) soup.vertices.push_back(p);
    return v;
  };
  for (const double size : {1.0, 2.0}) {
    const Solid solid = box({0, 0, 0}, {size, size, 4});
    for (std::size_t f = 0; f < solid.facets.size(); ++f) {
      std::vector<Vector3d> polygon;
      for (std::size_t k = 0; k < 4; ++k) {
        const Vector3d &a = solid.corners[static_cast<std::size_t>(solid.facets[f][k])],
                       &b = solid.corners[static_cast<std::size_t>(solid.facets[f][(k + 1) % 4])];
        polygon.push_back(a);
        if ((f != 2 && f != 4) || !a.head<2>().isZero(0) || !b.head<2>().isZero(0)) continue;
        std::vector<double> cuts = f == 2 ? first : second;
        if (b.z() < a.z()) std::reverse(cuts.begin(), cuts.end());
        for (const double z : cuts) polygon.emplace_back(0, 0, z);
      }
      // A fan from a corner beside the edge has no flat triangle.
      std::rotate(polygon.begin(),
                  std::find_if(polygon.begin(), polygon.end(),
                               [](const Vector3d& p) { return !p.head<2>().isZero(0); }),
                  polygon.end());
      bool turn = (turned & (size < 2 ? 1 : 2)) != 0;
      if (f == 2 && (turned & 4) != 0) turn = !turn;
      for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
        const std::int32_t a = vertex(polygon[0]), b = vertex(polygon[k]),
                           c = vertex(polygon[k + 1]);
        soup.triangles.push_back({a, turn ? c : b, turn ? b : c});
      }
    }
  }
  return soup;
}

/// Exactly two triangles used an edge and each of its parts, so that the boxes were taken for one
/// surface that winds about the smaller box twice, in opposite directions: a ball within both was
/// certified.
TEST(SolidParts, SolidsThatShareACutEdgeAreNoOneSurface) {
  using Cuts = std::vector<double>;
  const std::pair<Cuts, Cuts> cases[] = {{{}, {1}},     {{}, {1, 2}},  {{}, {1, 2, 3}}, {{2}, {1}},
                                         {{2}, {1, 3}}, {{1, 2}, {3}}, {{1, 3}, {2}},   {{}, {}}};
  for (const auto& [first, second] : cases) {
    for (int turned = 0; turned < 8; ++turned) {
      SCOPED_TRACE(::testing::PrintToString(first) + ::testing::PrintToString(second) + " " +
                   std::to_string(turned));
      TriangleSoup soup = boxesOnOneEdge(first, second, turned);
      const auto deformable = DeformableMesh::make(soup.vertices, soup.triangles);
      EXPECT_EQ(deformable->openEdgeCount() > 0, first != second);
      EXPECT_EQ(deformable->closedComponentCount() == 0, first != second);
      // A fine mesh beside them would cut off a search through all vertices.
      Random random(1);
      if (turned == 0)
        append(soup, ballSoup(80, 80, 4, 0, random), {Eigen::Matrix3d::Identity(), {9, 9, 0}});
      const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles, {.decompose = false});
      EXPECT_EQ(mesh->openEdgeCount(), 0U);
      EXPECT_TRUE(isInside(*mesh, {0.5, 0.5, 0.7}));
      EXPECT_TRUE(isInside(*mesh, {1.5, 0.5, 0.7}));
      EXPECT_FALSE(isInside(*mesh, {2.5, 0.5, 0.7}));
    }
  }
}

/// A weld as large as facets folded the surface onto itself and lost the inside: a unit cube
/// without its lid, welded by 2 m, did not even count as open.
TEST(SolidParts, AWeldThatIsNotSmallAgainstTheFacetsIsRefused) {
  const std::vector<Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                         {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const std::vector<TriangleMesh::Triangle> open = {{0, 3, 2}, {0, 2, 1}, {0, 1, 5}, {0, 5, 4},
                                                    {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6},
                                                    {3, 0, 4}, {3, 4, 7}};
  // The facets' heights are sqrt(1/2).
  for (const double weld : {0.18, 0.5, 1.0, 2.0, 5.0})
    EXPECT_THROW(TriangleMesh::make(corners, open, {.weld = weld}), InvalidShape) << weld;
  for (const double weld : {0.0, 1e-6, 0.1, 0.17})
    EXPECT_GT(TriangleMesh::make(corners, open, {.weld = weld})->openEdgeCount(), 0U) << weld;
  std::vector<TriangleMesh::Triangle> closed = open;
  closed.push_back({4, 5, 6});
  closed.push_back({4, 6, 7});
  EXPECT_EQ(TriangleMesh::make(corners, closed, {.weld = 2})->closedComponentCount(), 1);
}

/// A weld must be small against the open part, not only against a larger part beside it.
TEST(SolidParts, AWeldThatIsNotSmallAgainstOnePartIsRefused) {
  TriangleSoup soup = boxSoup({0.5, 0.5, 0.5});
  soup.triangles.pop_back();
  append(soup, boxSoup({20, 20, 20}), {Eigen::Matrix3d::Identity(), {100, 0, 0}});
  for (const double weld : {1.0, 2.0, 5.0})
    EXPECT_THROW(TriangleMesh::make(soup.vertices, soup.triangles, {.weld = weld}), InvalidShape);
  EXPECT_GT(TriangleMesh::make(soup.vertices, soup.triangles, {.weld = 1e-3})->openEdgeCount(), 0U);
}

/// A crack between two halves of a fine ball is closed, or the weld is refused.
TEST(SolidParts, TwoHalvesOfABallAreWeldedOrRefused) {
  Random random(3);
  for (int rings = 10; rings <= (kSanitized ? 10 : 40); rings *= 2) {
    const TriangleSoup ball = ballSoup(rings, 2 * rings, 1, 0, random);
    TriangleSoup halves;
    halves.vertices = ball.vertices;
    for (const Vector3d& v : ball.vertices) halves.vertices.push_back(v - 5e-4 * Vector3d::UnitZ());
    for (TriangleMesh::Triangle t : ball.triangles) {
      double height = 0;
      for (const auto v : t) height += ball.vertices[static_cast<std::size_t>(v)].z();
      if (height < 0)
        for (auto& v : t) v += static_cast<std::int32_t>(ball.vertices.size());
      halves.triangles.push_back(t);
    }
    int refused = 0;
    for (const double weld : {1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0}) {
      try {
        const auto mesh = TriangleMesh::make(halves.vertices, halves.triangles, {.weld = weld});
        EXPECT_EQ(mesh->openEdgeCount(), 0U) << rings << ", " << weld;
        for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(0.3, 0.2, 0.1), Vector3d(0, 0, 0.5)})
          EXPECT_TRUE(isInside(*mesh, p)) << rings << ", " << weld;
      } catch (const InvalidShape&) {
        ++refused;
      }
    }
    EXPECT_GE(refused, 2);
    EXPECT_LE(refused, 5);
  }
}

}  // namespace
}  // namespace leeway::collision::testing
