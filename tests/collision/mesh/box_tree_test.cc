#include "collision/mesh/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "collision/mesh/descent/box_gaps.h"
#include "collision/mesh/mesh_tree.h"
#include "collision/shapes/hull_of_part.h"
#include "leeway/collision/distance.h"
#include "tests/collision/convex/box_cases.h"
#include "tests/support/every_target.h"
#include "tests/support/mesh_cases.h"
#include "tests/support/sanitized.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using namespace testing;

// The box as a hull of its corners, in double.
Shape hullOf(const OrientedBox& box) {
  Eigen::Matrix3d planes;
  Vector3d center, half;
  for (int k = 0; k < 3; ++k) {
    center[k] = static_cast<double>(box.center[k]);
    half[k] = static_cast<double>(box.half[k]);
    for (int i = 0; i < 3; ++i) planes(k, i) = static_cast<double>(box.axis[k][i]);
  }
  const Eigen::Matrix3d inverse = planes.inverse();
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    const Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    corners.push_back(center + inverse * half.cwiseProduct(sign));
  }
  return Shape::convexHull(corners);
}

TEST(BoxGaps, AreBelowTheDistanceAndNearItWhenFar) {
  Random random(51);
  Scratch scratch;
  int unsafe = 0, apart = 0, separated = 0;
  double share = 0;
  for (int i = 0; i < casesToAsk(1500); ++i) {
    BoxNode node{};
    const double reach = std::pow(10, random.uniform(-1, 1));
    const OrientedBox query = randomBox(random, reach, 1);
    for (int column = 0; column < BoxNode::kWidth; ++column) {
      setColumn(node, column, column == 7 ? query : randomBox(random, reach, 1));
    }
    float gap[BoxNode::kWidth];
    boxGaps(node, query, {}, gap);
    for (int column = 0; column < BoxNode::kWidth; ++column) {
      const double d =
          distance(hullOf(node.box(column)), {}, hullOf(query), {}, {}, scratch).distance.upper;
      if (static_cast<double>(gap[column]) > std::max(d, 0.0)) {
        ++unsafe;
        ADD_FAILURE() << "case " << i << " column " << column << ": gap " << gap[column] << " > "
                      << d;
      }
      if (!(d > 1e-4)) continue;
      ++apart;
      separated += gap[column] > 0 ? 1 : 0;
      if (d > 10) {
        EXPECT_GT(static_cast<double>(gap[column]), 0.9 * d);
      }
      share += std::max(static_cast<double>(gap[column]), 0.0) / d;
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(apart, casesToAsk(5000));
  EXPECT_GT(separated, 0.95 * apart);
  EXPECT_GT(share, 0.9 * apart);
}

TEST(BoxGaps, AlongADirectionAreBelowTheDistanceToo) {
  Random random(54);
  Scratch scratch;
  int unsafe = 0, exact = 0, larger = 0;
  for (int i = 0; i < casesToAsk(1500); ++i) {
    BoxNode node{};
    const double reach = std::pow(10, random.uniform(-1, 1));
    const OrientedBox query = randomBox(random, reach, 1);
    for (int column = 0; column < BoxNode::kWidth; ++column)
      setColumn(node, column, randomBox(random, reach, 1));
    const Shape of_query = hullOf(query);
    const DistanceResult first = distance(of_query, {}, hullOf(node.box(0)), {}, {}, scratch);
    // Also a random one, because any direction must be valid; as long as rotations may be, see
    // box_gaps_simd.cc.
    const bool parts = i % 2 == 0 && first.distance.lower > 1e-3;
    const Vector3d direction = (1 + 1e-6) * (parts ? first.normal : random.direction());
    float gap[BoxNode::kWidth], plain[BoxNode::kWidth];
    boxGaps(node, query, boxDirection(direction), gap);
    boxGaps(node, query, {}, plain);
    for (int column = 0; column < BoxNode::kWidth; ++column) {
      const double d =
          distance(hullOf(node.box(column)), {}, of_query, {}, {}, scratch).distance.upper;
      if (static_cast<double>(gap[column]) > std::max(d, 0.0)) {
        ++unsafe;
        ADD_FAILURE() << "case " << i << " column " << column << ": gap " << gap[column] << " > "
                      << d;
      }
      EXPECT_GE(gap[column], plain[column]);
      larger += gap[column] > plain[column] ? 1 : 0;
    }
    // Along the line of the nearest points only rounding is lost.
    if (!parts) continue;
    ++exact;
    EXPECT_NEAR(static_cast<double>(gap[0]), first.distance.lower, 1e-4 * (1 + reach));
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_GT(exact, casesToAsk(300));
  EXPECT_GT(larger, casesToAsk(300));
}

TEST(BoxGaps, AreTheSameOnEveryInstructionSet) {
  const auto run = [] {
    Random random(52);
    std::vector<float> all;
    for (int i = 0; i < 200; ++i) {
      BoxNode node{};
      for (int column = 0; column < BoxNode::kWidth; ++column)
        setColumn(node, column, randomBox(random, 1, 0.5));
      float gap[BoxNode::kWidth];
      const OrientedBox query = randomBox(random, 1, 0.5);
      boxGaps(node, query, boxDirection(random.direction()), gap);
      all.insert(all.end(), gap, gap + BoxNode::kWidth);
    }
    return all;
  };
  expectTheSameBytesOnEveryTarget(run);
}

TEST(BoxTree, EveryBoxHoldsItsTriangles) {
  auto meshes = sampleMeshes(53);
  Random random(53);
  TriangleSoup pieces;
  for (int i = 0; i < 12; ++i) append(pieces, ballSoup(7, 9, 0.2, 0, random), random.pose(1));
  meshes.push_back(named("balls", pieces));
  int pieces_met = 0;
  for (const NamedMesh& m : meshes) {
    const MeshTree& tree = m.mesh->tree();
    const BoxTree& boxes = tree.boxes();
    if (!boxes.usable()) {
      EXPECT_LT(tree.extent(), 1e-10) << m.name;
      continue;
    }
    std::set<int> met;
    // Slots below a box; every corner must be inside it.
    const std::function<std::vector<int>(int, int)> check = [&](int id, int column) {
      const BoxNode& node = boxes.node(id);
      std::vector<int> slots;
      int child = node.child[column];
      if (~child >= boxes.firstPiece()) {
        ++pieces_met;
        child = boxes.pieceNode(~child - boxes.firstPiece());
      }
      if (child < 0) {
        slots.push_back(~child);
        EXPECT_TRUE(met.insert(~child).second);
      } else {
        for (int i = 0; i < boxes.node(child).count; ++i) {
          const std::vector<int> part = check(child, i);
          slots.insert(slots.end(), part.begin(), part.end());
        }
      }
      const OrientedBox box = node.box(column);
      bool holds = true;
      for (const int slot : slots) {
        const Vector3d* corners = tree.corners(slot);
        for (int c = 0; c < 3; ++c) {
          for (int k = 0; k < 3; ++k) {
            double along = 0;
            for (int i = 0; i < 3; ++i) {
              along += static_cast<double>(box.axis[k][i]) *
                       (corners[c][i] - tree.middle()[i] - static_cast<double>(box.center[i]));
            }
            holds &= std::abs(along) <= static_cast<double>(box.half[k]);
          }
        }
      }
      EXPECT_TRUE(holds) << m.name << ", node " << id << " column " << column;
      return slots;
    };
    check(0, 0);
    EXPECT_EQ(static_cast<int>(met.size()), tree.triangleCount()) << m.name;
  }
  EXPECT_GE(pieces_met, 12);
}

// Triangles so close to a line that the squared offset is subnormal. Regression: axes were 0.85 to
// 1.09 long; along a long axis the gap exceeds the boxes' distance.
TEST(BoxTree, AxesHaveLengthOneHoweverThinAMeshIs) {
  int axes = 0;
  for (const double beside : {1e-9, 1e-10, 3e-11, 1e-11, 3e-12, 1e-12}) {
    std::vector<Vector3d> vertices;
    std::vector<MeshTree::Triangle> triangles;
    for (int i = 0; i < 24; ++i) {
      const double along = (i * 7 % 24) / 24.0;
      vertices.emplace_back(along, along, 1e-70 * (1 + beside * (i * 5 % 11)));
      if (i >= 2) triangles.push_back({i - 2, i - 1, i});
    }
    MeshTree tree(vertices, triangles, std::vector<std::int32_t>(triangles.size(), 0),
                  planTree(vertices, triangles), hullOfPart(vertices));
    tree.makeBoxes(vertices, triangles, {});
    const std::function<void(int)> check = [&](int id) {
      const BoxNode& node = tree.boxes().node(id);
      for (int column = 0; column < node.count; ++column) {
        const OrientedBox box = node.box(column);
        Eigen::Matrix3d rows;
        for (int k = 0; k < 3; ++k) {
          for (int i = 0; i < 3; ++i) rows(k, i) = static_cast<double>(box.axis[k][i]);
        }
        const Eigen::Matrix3d off = rows * rows.transpose() - Eigen::Matrix3d::Identity();
        EXPECT_LT(off.cwiseAbs().maxCoeff(), 0x1p-20) << "beside " << beside << ", node " << id;
        ++axes;
        if (node.child[column] >= 0) check(node.child[column]);
      }
    };
    ASSERT_TRUE(tree.boxes().usable());
    check(0);
  }
  EXPECT_GT(axes, 100);
}

// Regression: such a mesh was reported farther than 1.490015 m, at most 1.490383 m away.
TEST(BoxTree, AThinMeshIsNoFartherThanItIs) {
  std::vector<Vector3d> line;
  const double along[] = {0.671875, 0.0625, 0.296875, 0.8125}, beside[] = {6, 6, 5, 3};
  for (int i = 0; i < 4; ++i)
    line.emplace_back(along[i], along[i], 1e-70 * (1 + 3e-11 * beside[i]));
  const Vector3d m(0.5, 0.5, -1.5);
  const Vector3d body[] = {m, m + Vector3d(0.01, -0.003, 0), m + Vector3d(-0.004, 0.01, 0),
                           m + Vector3d(0.003, 0.004, 0.01)};
  const MeshTree::Triangle strip[] = {{0, 1, 2}, {1, 2, 3}},
                           sides[] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Shape a = Shape::mesh(TriangleMesh::make(line, strip)),
              b = Shape::mesh(TriangleMesh::make(body, sides));
  const double truth = std::hypot(1.49, 0.001 / std::sqrt(2.0));  // of the last corner from x = y
  Scratch scratch;
  DistanceRequest request;
  const Interval plain = distance(a, {}, b, {}, request, scratch).distance;
  EXPECT_NEAR(plain.lower, truth, 1e-9);
  EXPECT_NEAR(plain.upper, truth, 1e-9);
  request.threshold = 1.490015;
  EXPECT_LE(distance(a, {}, b, {}, request, scratch).distance.lower, truth + 1e-12);
}

}  // namespace
}  // namespace leeway::collision
