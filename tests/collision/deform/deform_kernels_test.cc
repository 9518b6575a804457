// Kernels of deforming meshes: equal bytes from every instruction set, forced in turn, and valid
// bounds against plain code.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/convex/convex_distance.h"
#include "collision/deform/bounds/probe_bounds.h"
#include "collision/deform/query/probe.h"
#include "collision/deform/tree/refit.h"
#include "collision/deform/tree/tree_builder.h"
#include "tests/support/deformable_cases.h"
#include "tests/support/every_target.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

/// A mesh, its hierarchy, and one extra vertex, as in snapshots.
struct Mesh {
  std::vector<Vector3d> vertices;
  std::shared_ptr<const DeformTree> tree;

  std::size_t count() const { return vertices.size() - 1; }
};

Mesh makeMesh(Random& random, int kind) {
  testing::Sheet sheet = kind == 0   ? testing::cloth(3)
                         : kind == 1 ? testing::cloth(37)
                         : kind == 2 ? testing::cloth(21, &random)
                                     : testing::globe(9);
  sheet.vertices = testing::waved(sheet.vertices, 0.3, random.uniform(0, 6));
  if (kind == 4) {  // vertices are not shared
    const testing::Sheet whole = testing::cloth(21);
    sheet = {};
    for (const DeformTree::Triangle& t : whole.triangles) {
      const auto first = static_cast<std::int32_t>(sheet.vertices.size());
      for (const std::int32_t v : t)
        sheet.vertices.push_back(whole.vertices[static_cast<std::size_t>(v)]);
      sheet.triangles.push_back({first, first + 1, first + 2});
    }
  }
  if (kind == 3) {
    for (Vector3d& v : sheet.vertices) v += Vector3d(1e3, -2e4, 5);
  }
  Mesh mesh{sheet.vertices,
            buildDeformTree(sheet.vertices, sheet.triangles, DeformMethod::kBinned, 100)};
  mesh.vertices.push_back(Vector3d::Zero());
  return mesh;
}

/// A ball, box or half-space near the mesh, at rest or moving, with its exact form.
struct Body {
  Shape shape = Shape::sphere(0.1);
  Pose X;
  Probe probe;
};

Body makeBody(Random& random, const Mesh& mesh) {
  Body body;
  body.X.rotation = random.rotation();
  body.X.translation =
      mesh.vertices[static_cast<std::size_t>(random.below(static_cast<int>(mesh.count())))] +
      random.uniform(0, 1) * random.direction();
  Vector3d low = Vector3d::Zero(), high = low;
  double radius = 0;
  switch (random.below(3)) {
    case 0:
      radius = random.uniform(0, 0.2);
      body.shape = Shape::sphere(radius);
      break;
    case 1:
      high = {random.uniform(0, 0.3), random.uniform(0, 0.3), random.uniform(0, 0.3)};
      low = -high;
      body.shape = Shape::box(high);
      break;
    default:
      low = Vector3d::Constant(-kInfinity);
      high = {kInfinity, kInfinity, 0};
      body.shape = Shape::halfSpace();
      break;
  }
  double extent = 0;
  for (std::size_t i = 0; i < mesh.count(); ++i)
    extent = std::max(extent, 2 * mesh.vertices[i].lpNorm<1>());
  body.probe = makeProbe(low, high, radius, body.X, nullptr, extent, 0);
  return body;
}

void append(std::vector<float>& all, const WideBox& box) {
  for (int k = 0; k < 3; ++k) {
    all.insert(all.end(), box.low[k], box.low[k] + kWidth);
    all.insert(all.end(), box.high[k], box.high[k] + kWidth);
  }
}

std::vector<float> results() {
  const DeformKernels& kernels = deformKernels();
  Random random(81);
  std::vector<float> all;
  for (int kind = 0; kind < 5; ++kind) {
    Mesh mesh = makeMesh(random, kind);
    const DeformTree& tree = *mesh.tree;
    for (const double spoilt : {0.0, std::nan(""), kInfinity}) {
      if (spoilt != 0) mesh.vertices[mesh.count() / 2].y() = spoilt;
      std::vector<WideBox> boxes(tree.nodes().size()), upper(tree.nodes().size());
      const bool good =
          kernels.refit(tree, mesh.vertices.data(), 0, tree.nodeCount(), boxes.data());
      all.push_back(good ? 1 : 0);
      all.push_back(
          kernels.branches(tree, mesh.vertices.data(), 0, tree.branches().size(), upper.data())
              ? 1
              : 0);
      std::vector<BranchBox> room(tree.branches().size());
      std::vector<WideBox> in_order(tree.nodes().size());
      EXPECT_EQ(all.back() == 1,
                kernels.allBranches(tree, mesh.vertices.data(), room.data(), in_order.data()));
      Vector3d low, high;
      all.push_back(kernels.bound(mesh.vertices.data(), mesh.count(), 1e15, low, high) ? 1 : 0);
      // A rejected update leaves the rest undefined.
      if (spoilt != 0) continue;
      for (int k = 0; k < 3; ++k) {
        all.push_back(static_cast<float>(low[k]));
        all.push_back(static_cast<float>(high[k]));
      }
      for (const DeformTree::Branch& branch : tree.branches()) {
        const DeformTree::Up& up = tree.up(branch.root);
        const WideBox &box = upper[static_cast<std::size_t>(up.parent)],
                      &same = in_order[static_cast<std::size_t>(up.parent)];
        for (int k = 0; k < 3; ++k) {
          EXPECT_EQ(same.low[k][up.column], box.low[k][up.column]);
          EXPECT_EQ(same.high[k][up.column], box.high[k][up.column]);
          all.push_back(box.low[k][up.column]);
          all.push_back(box.high[k][up.column]);
        }
      }
      for (const WideBox& box : boxes) append(all, box);
      for (int i = 0; i < 40; ++i) {
        const std::int32_t node = random.below(tree.nodeCount());
        WideBox box;
        kernels.fromVertices(tree, mesh.vertices.data(), node, box);
        append(all, box);
        const DeformTree::Leaf& leaf = tree.leaf(random.below(tree.leafCount()));
        kernels.triangles(tree, mesh.vertices.data(), leaf.slot_begin, leaf.slot_end, box);
        append(all, box);
        const Body body = makeBody(random, mesh);
        WideBounds bounds;
        probeKernels().triangleBounds(body.probe, tree, mesh.vertices.data(), leaf.slot_begin,
                                      leaf.slot_end, bounds);
        all.insert(all.end(), bounds.lower, bounds.lower + (leaf.slot_end - leaf.slot_begin));
        std::vector<std::int32_t> nodes(1 + static_cast<std::size_t>(random.below(7)));
        std::vector<const WideBox*> boxes_of;
        for (std::int32_t& other : nodes) {
          other = random.below(tree.nodeCount());
          boxes_of.push_back(&boxes[static_cast<std::size_t>(other)]);
        }
        std::vector<WideBounds> of_nodes(nodes.size());
        for (const float bar : {0.3F, std::numeric_limits<float>::infinity()}) {
          probeKernels().childBounds(body.probe, tree, mesh.vertices.data(), nodes, boxes_of.data(),
                                     bar, of_nodes.data());
          for (std::size_t n = 0; n < nodes.size(); ++n) {
            all.insert(all.end(), of_nodes[n].lower, of_nodes[n].lower + kWidth);
            all.push_back(static_cast<float>(of_nodes[n].open));
            all.push_back(of_nodes[n].closed);
          }
        }
        // Any number of vertices.
        const std::span<const std::int32_t> some = tree.leafVertices().subspan(
            static_cast<std::size_t>(leaf.vertex_begin),
            1 + static_cast<std::size_t>(random.below(leaf.vertex_end - leaf.vertex_begin)));
        const Vector3d n = random.direction();
        double least = 0, plain = kInfinity;
        const bool finite = probeKernels().leastAlong(n.data(), mesh.vertices.data(), some, least);
        bool all_finite = true;
        for (const std::int32_t v : some) {
          const Vector3d& p = mesh.vertices[static_cast<std::size_t>(v)];
          all_finite = all_finite && p.allFinite();
          plain = std::min(plain, n.x() * p.x() + n.y() * p.y() + n.z() * p.z());
        }
        EXPECT_EQ(finite, all_finite);
        if (finite) {
          EXPECT_EQ(least, plain);
          all.push_back(static_cast<float>(least));
        }
      }
    }
  }
  return all;
}

TEST(DeformKernels, AreTheSameBytes) {
  const std::vector<float> best = results();
  ASSERT_GT(best.size(), 10000U);
  EXPECT_GE(onEveryTarget([&](const char* target) {
              const std::vector<float> other = results();
              ASSERT_EQ(best.size(), other.size());
              // Applies only to the emulated target, whose demotion of infinity gives the largest
              // float.
              const bool is_emulated = std::string_view(target) == "EMU128";
              const auto finite = [is_emulated](float x) {
                constexpr float kMost = std::numeric_limits<float>::max();
                return is_emulated ? std::clamp(x, -kMost, kMost) : x;
              };
              for (std::size_t i = 0; i < best.size(); ++i) {
                // 0 and -0 give equal boxes but different bytes.
                ASSERT_TRUE(finite(best[i]) == finite(other[i]) &&
                            std::signbit(best[i]) == std::signbit(other[i]))
                    << target << ", number " << i << ": " << other[i] << " for " << best[i];
              }
            }),
            1);
}

/// Boxes are the tight bounds of their vertices, by plain comparison.
TEST(DeformKernels, BoxesAreTheVertices) {
  const DeformKernels& kernels = deformKernels();
  Random random(82);
  int mixed = 0,
      full = 0;  // nodes with both leaves and inner children; nodes with the maximum of vertices
  for (int kind = 0; kind < 5; ++kind) {
    Mesh mesh = makeMesh(random, kind);
    const DeformTree& tree = *mesh.tree;
    std::vector<WideBox> boxes(tree.nodes().size()), upper(tree.nodes().size());
    ASSERT_TRUE(kernels.refit(tree, mesh.vertices.data(), 0, tree.nodeCount(), boxes.data()));
    ASSERT_TRUE(
        kernels.branches(tree, mesh.vertices.data(), 0, tree.branches().size(), upper.data()));
    const auto check = [&](const WideBox& box, std::int32_t node, int column) {
      for (int k = 0; k < 3; ++k) {
        double low = kInfinity, high = -kInfinity;
        for (const std::int32_t v : tree.vertices(node, column)) {
          low = std::min(low, mesh.vertices[static_cast<std::size_t>(v)][k]);
          high = std::max(high, mesh.vertices[static_cast<std::size_t>(v)][k]);
        }
        const auto l = static_cast<double>(box.low[k][column]),
                   h = static_cast<double>(box.high[k][column]);
        EXPECT_LE(l, low);
        EXPECT_GE(h, high);
        EXPECT_GE(l, low - 1e-6 * std::abs(low) - 1e-30);
        EXPECT_LE(h, high + 1e-6 * std::abs(high) + 1e-30);
      }
    };
    for (std::int32_t node = 0; node < tree.nodeCount(); ++node) {
      WideBox box;
      kernels.fromVertices(tree, mesh.vertices.data(), node, box);
      for (int column = 0; column < kWidth; ++column) {
        if (tree.node(node).child[column] == DeformTree::kNone) continue;
        check(boxes[static_cast<std::size_t>(node)], node, column);
        check(box, node, column);
      }
    }
    for (const DeformTree::Branch& branch : tree.branches()) {
      const DeformTree::Up& up = tree.up(branch.root);
      check(upper[static_cast<std::size_t>(up.parent)], up.parent, up.column);
    }
    for (std::int32_t node = 0; node < tree.nodeCount(); ++node) {
      int leaves = 0, nodes = 0, vertices = 0;
      for (int column = 0; column < kWidth; ++column) {
        const std::int32_t child = tree.node(node).child[column];
        if (DeformTree::isLeaf(child)) {
          ++leaves;
          vertices += static_cast<int>(tree.vertices(node, column).size());
        } else if (child != DeformTree::kNone) {
          ++nodes;
        }
      }
      mixed += leaves > 0 && nodes > 0;
      full += vertices == 3 * DeformTree::kLeafTriangles * kWidth;
    }
    // A non-finite vertex is detected at any place.
    for (int i = 0; i < 20; ++i) {
      const int last = static_cast<int>(mesh.count()) - 1;
      const int which = i == 0 ? 0 : i == 1 ? last : random.below(last);
      Vector3d& v = mesh.vertices[static_cast<std::size_t>(which)];
      const double was = std::exchange(
          v[i % 3], i % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : -kInfinity);
      EXPECT_FALSE(kernels.refit(tree, mesh.vertices.data(), 0, tree.nodeCount(), boxes.data()));
      v[i % 3] = was;
    }
  }
  EXPECT_GT(mixed, 0);
  EXPECT_GT(full, 0);
}

/// No triangle below a child is closer than the child's bound, and none of a leaf is closer than
/// the leaf's bound; children above the bar are closed, all others open.
TEST(DeformKernels, BoundsHold) {
  const DeformKernels& kernels = deformKernels();
  Random random(83);
  Scratch scratch;
  int leaves = 0, tighter = 0, open = 0, closed = 0;
  for (int i = 0; i < 240; ++i) {
    const Mesh mesh = makeMesh(random, i % 4);
    const DeformTree& tree = *mesh.tree;
    std::vector<WideBox> boxes(tree.nodes().size());
    ASSERT_TRUE(kernels.refit(tree, mesh.vertices.data(), 0, tree.nodeCount(), boxes.data()));
    const Body body = makeBody(random, mesh);
    const ConvexView view = viewOf(body.shape);
    const auto distanceOf = [&](std::int32_t slot) {
      Vector3d corners[3];
      for (std::size_t c = 0; c < 3; ++c)
        corners[c] = mesh.vertices[static_cast<std::size_t>(tree.corners(slot)[c])];
      return convexDistance(view, body.X, viewOfPoints(corners, 3, 0), {}, scratch, nullptr)
          .distance.upper;
    };
    const std::int32_t node = random.below(tree.nodeCount());
    const WideBox& box = boxes[static_cast<std::size_t>(node)];
    const auto bar = static_cast<float>(random.uniform(0, 1));
    WideBounds bounds, of_triangles;
    const WideBox* const boxes_of = &box;
    probeKernels().childBounds(body.probe, tree, mesh.vertices.data(), {&node, 1}, &boxes_of, bar,
                               &bounds);
    // A batch gives the single results.
    const std::array<std::int32_t, 3> several = {random.below(tree.nodeCount()), node,
                                                 random.below(tree.nodeCount())};
    std::array<const WideBox*, 3> boxes_of_several;
    for (std::size_t k = 0; k < 3; ++k)
      boxes_of_several[k] = &boxes[static_cast<std::size_t>(several[k])];
    std::array<WideBounds, 3> of_several;
    probeKernels().childBounds(body.probe, tree, mesh.vertices.data(), several,
                               boxes_of_several.data(), bar, of_several.data());
    EXPECT_TRUE(std::equal(bounds.lower, bounds.lower + kWidth, of_several[1].lower));
    EXPECT_EQ(bounds.open, of_several[1].open);
    EXPECT_EQ(bounds.closed, of_several[1].closed);
    float least_closed = std::numeric_limits<float>::infinity();
    for (int column = 0; column < kWidth; ++column) {
      const std::int32_t child = tree.node(node).child[column];
      const bool is_open = (bounds.open >> column & 1) != 0;
      EXPECT_EQ(is_open, child != DeformTree::kNone && !(bounds.lower[column] > bar));
      if (!is_open) least_closed = std::min(least_closed, bounds.lower[column]);
      if (child == DeformTree::kNone) continue;
      (is_open ? open : closed) += 1;
      float low[3], high[3];
      for (int k = 0; k < 3; ++k) {
        low[k] = box.low[k][column];
        high[k] = box.high[k][column];
      }
      const double by_box = lowerBound(body.probe, low, high);
      const auto lower = static_cast<double>(bounds.lower[column]);
      EXPECT_GE(lower, by_box - static_cast<double>(body.probe.slack));
      if (!DeformTree::isLeaf(child)) {
        // Only the box bound applies.
        EXPECT_LE(lower, by_box + static_cast<double>(body.probe.slack));
        continue;
      }
      ++leaves;
      tighter += lower > by_box + 1e-3 ? 1 : 0;
      const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(child));
      probeKernels().triangleBounds(body.probe, tree, mesh.vertices.data(), leaf.slot_begin,
                                    leaf.slot_end, of_triangles);
      for (std::int32_t slot = leaf.slot_begin; slot < leaf.slot_end; ++slot) {
        const double distance = distanceOf(slot);
        EXPECT_LE(lower, distance);
        EXPECT_LE(static_cast<double>(of_triangles.lower[slot - leaf.slot_begin]), distance);
      }
    }
    EXPECT_EQ(bounds.closed, least_closed);
  }
  EXPECT_GT(leaves, 500);
  EXPECT_GT(tighter, 50);
  EXPECT_GT(open, 100);
  EXPECT_GT(closed, 100);
}

}  // namespace
}  // namespace leeway::collision
