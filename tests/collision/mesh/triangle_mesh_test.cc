#include "leeway/collision/triangle_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "collision/mesh/mesh_tree.h"
#include "collision/shapes/hull_builder.h"
#include "collision/shapes/hull_distance.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "tests/support/mesh_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

TEST(TriangleMesh, WeldsByEqualityAndFindsSolids) {
  for (const bool weld : {false, true}) {
    TriangleSoup soup = boxSoup({1, 2, 3});
    if (!weld) soup = unwelded(soup);
    const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
    EXPECT_EQ(mesh->vertices().size(), 8U);
    EXPECT_EQ(mesh->triangles().size(), 12U);
    EXPECT_EQ(mesh->componentCount(), 1);
    EXPECT_TRUE(mesh->isClosed(0));
  }
}

TEST(TriangleMesh, MendsOrientation) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    TriangleSoup soup = torusSoup(12, 6, 1, 0.3, 0.1, random);
    for (auto& t : soup.triangles) {
      if (random.below(2) != 0) std::swap(t[0], t[1]);
    }
    const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
    ASSERT_EQ(mesh->closedComponentCount(), 1);
    double volume = 0;
    for (const auto& t : mesh->triangles()) {
      const auto at = [&](std::size_t k) {
        return mesh->vertices()[static_cast<std::size_t>(t[k])];
      };
      volume += at(0).dot(at(1).cross(at(2))) / 6;
    }
    EXPECT_GT(volume, 0.5);
  }
}

TEST(TriangleMesh, WhatIsNotClosedIsASurface) {
  TriangleSoup hole = boxSoup({1, 1, 1});
  hole.triangles.pop_back();
  const auto open = TriangleMesh::make(hole.vertices, hole.triangles);
  EXPECT_EQ(open->closedComponentCount(), 0);
  EXPECT_EQ(open->openEdgeCount(), 3U);
  EXPECT_EQ(DeformableMesh::make(hole.vertices, hole.triangles)->openEdgeCount(), 3U);

  const TriangleSoup box = boxSoup({1, 1, 1});
  const auto surface = TriangleMesh::make(box.vertices, box.triangles, {.solid = false});
  EXPECT_EQ(surface->closedComponentCount(), 0);
  EXPECT_EQ(surface->openEdgeCount(), 0U) << "it was asked for";

  // A sheet is not meant as a solid, wherever it lies.
  TriangleSoup sheet;
  append(sheet, {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}},
         Random(3).pose(2));
  EXPECT_EQ(TriangleMesh::make(sheet.vertices, sheet.triangles)->openEdgeCount(), 0U);

  // The same with a hole. Slightly raised, it may enclose a volume.
  TriangleSoup panel;
  for (const double half : {1.0, 0.5})
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
      panel.vertices.emplace_back(half * x, half * y, 0);
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    panel.triangles.push_back({i, j, j + 4});
    panel.triangles.push_back({i, j + 4, i + 4});
  }
  EXPECT_EQ(TriangleMesh::make(panel.vertices, panel.triangles)->openEdgeCount(), 0U);
  panel.vertices[4].z() = 1e-3;
  EXPECT_EQ(TriangleMesh::make(panel.vertices, panel.triangles)->openEdgeCount(), 8U);

  // A Moebius strip has a border. A Klein bottle, glued from a grid with one twist, has neither a
  // border nor an orientation.
  TriangleSoup klein;
  constexpr int n = 8;
  for (int i = 0; i < n * n; ++i) klein.vertices.emplace_back(i % n, i / n, 0.1 * (i * i % 7));
  const auto at = [](int i, int j) {
    if (i >= n) {
      i -= n;
      j = n - j;
    }
    return i * n + (j + n) % n;
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      klein.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      klein.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  const auto mesh = TriangleMesh::make(klein.vertices, klein.triangles);
  EXPECT_EQ(mesh->componentCount(), 1);
  EXPECT_EQ(mesh->closedComponentCount(), 0);
  EXPECT_GT(mesh->openEdgeCount(), 0U) << "its inside is not known, though no edge is open";
}

TEST(TriangleMesh, ASolidMayHaveFacetsTwiceFinsAndWalls) {
  TriangleSoup soup = boxSoup({1, 1, 1});
  soup.triangles.push_back(soup.triangles[0]);            // a facet twice
  std::swap(soup.triangles[3][0], soup.triangles[3][1]);  // one turned
  soup.vertices.emplace_back(3, 0, 0);
  soup.triangles.push_back({1, 3, 8});  // a fin along an edge
  soup.triangles.push_back({0, 3, 7});  // a wall through the inside
  const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
  EXPECT_EQ(mesh->triangles().size(), 15U);
  EXPECT_EQ(mesh->closedComponentCount(), 1);
  EXPECT_TRUE(mesh->isClosed(mesh->component(0)));
  EXPECT_FALSE(mesh->isClosed(mesh->component(13)));
  EXPECT_FALSE(mesh->isClosed(mesh->component(14)));
}

TEST(TriangleMesh, DegenerateTrianglesStayAndDoNotOpenASolid) {
  TriangleSoup soup = boxSoup({1, 1, 1});
  soup.triangles.push_back({0, 0, 1});  // a segment along an edge
  soup.triangles.push_back({3, 3, 3});  // a corner
  soup.vertices.emplace_back(5, 5, 5);
  soup.triangles.push_back({8, 8, 8});  // a separate point
  const auto mesh = TriangleMesh::make(soup.vertices, soup.triangles);
  EXPECT_EQ(mesh->triangles().size(), 15U);
  EXPECT_EQ(mesh->componentCount(), 2);
  EXPECT_EQ(mesh->closedComponentCount(), 1);
  EXPECT_EQ(mesh->component(12), mesh->component(0));
  EXPECT_FALSE(mesh->isClosed(mesh->component(14)));
}

TEST(TriangleMesh, RejectsWhatIsNoMesh) {
  const std::vector<Vector3d> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  using Triangles = std::vector<TriangleMesh::Triangle>;
  EXPECT_THROW(TriangleMesh::make(points, {}), InvalidShape);
  EXPECT_THROW(TriangleMesh::make(points, Triangles{{0, 1, 3}}), InvalidShape);
  EXPECT_THROW(TriangleMesh::make(points, Triangles{{0, 1, -1}}), InvalidShape);
  std::vector<Vector3d> bad = points;
  bad[1].y() = std::numeric_limits<double>::quiet_NaN();
  try {
    TriangleMesh::make(bad, Triangles{{0, 1, 2}});
    FAIL();
  } catch (const InvalidShape& e) {
    EXPECT_NE(std::string(e.what()).find("vertex 1"), std::string::npos);
  }
}

// Each node's sphere, box and core grown by the excess hold its triangles. A vertex's distance from
// the core's hull is bounded facet by facet of the core's exact hull.
void expectTreeHolds(const TriangleMesh& mesh) {
  const MeshTree& tree = mesh.tree();
  std::vector<int> seen(mesh.triangles().size(), 0);
  double worst = 0;
  for (std::size_t id = 0; id < tree.nodes().size(); ++id) {
    const MeshNode& node = tree.nodes()[id];
    const ConvexView view = tree.nodeView(node);
    const std::span<const Vector3d> core(view.points, static_cast<std::size_t>(view.count));
    const HullBuilder hull(core);
    for (int slot = node.triangle_begin; slot < node.triangle_end; ++slot) {
      if (node.isLeaf()) ++seen[static_cast<std::size_t>(tree.triangleOf(slot))];
      ASSERT_EQ(tree.slotOf(tree.triangleOf(slot)), slot);
      for (int k = 0; k < 3; ++k) {
        const Vector3d& v = tree.corners(slot)[k];
        ASSERT_LE((v - node.center).norm(), node.radius);
        ASSERT_TRUE((v.array() >= node.low.array()).all() &&
                    (v.array() <= node.high.array()).all());
        ASSERT_LE(v.norm(), tree.extent());
        bool of_core = false;
        for (const Vector3d& c : core) of_core = of_core || c == v;
        if (of_core || hull.dimension() < 3) continue;
        worst = std::max(worst, distanceFromHull(v, core, hull) - node.excess);
      }
    }
    if (!node.isLeaf()) {
      ASSERT_EQ(tree.node(static_cast<int>(id) + 1).triangle_begin, node.triangle_begin);
      ASSERT_EQ(tree.node(static_cast<int>(id) + 1).triangle_end,
                tree.node(node.right).triangle_begin);
      ASSERT_EQ(tree.node(node.right).triangle_end, node.triangle_end);
    }
  }
  EXPECT_LE(worst, 1e-13);
  for (const int count : seen) ASSERT_EQ(count, 1);
}

TEST(MeshTree, NodesHoldTheirTriangles) {
  for (const NamedMesh& m : sampleMeshes(11)) {
    SCOPED_TRACE(m.name);
    expectTreeHolds(*m.mesh);
  }
}

TEST(MeshTree, NodesHoldTheirTrianglesInTheRobots) {
  const auto files = meshFiles();
  if (files.empty()) GTEST_SKIP() << "no test data";
  for (const auto& file : files) {
    const TriangleSoup soup = readMesh(file);
    if (soup.triangles.size() > 3000) continue;  // large ones take seconds here
    SCOPED_TRACE(file.filename().string());
    expectTreeHolds(*TriangleMesh::make(soup.vertices, soup.triangles));
  }
}

}  // namespace
}  // namespace leeway::collision
