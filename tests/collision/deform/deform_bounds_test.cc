#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "collision/deform/bounds/cached_bounds.h"
#include "collision/deform/bounds/make_node_bounds.h"
#include "collision/deform/bounds/probe_bounds.h"
#include "collision/deform/query/probe.h"
#include "collision/deform/tree/tree_builder.h"
#include "tests/support/every_target.h"
#include "tests/support/motion_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

double area(const Vector3d& extent) {
  return extent.x() * extent.y() + extent.y() * extent.z() + extent.z() * extent.x();
}

struct Fit {
  double area = 0, exact = 0;  // sums over the children of all nodes
};

/// Checks that each child's box holds every vertex below it, and sums box areas. `bounds`:
/// NodeBounds or CachedBounds.
template <class BoundsOf>
void check(const VertexMotion& motion, const BoundsOf& bounds, const DeformTree& tree,
           std::span<const double> parameters, const std::string& what, Fit& fit) {
  std::vector<Vector3d> positions(static_cast<std::size_t>(motion.vertexCount()));
  motion.vertices(parameters, 0, positions);
  for (std::int32_t node = 0; node < tree.nodeCount(); ++node) {
    WideBox box;
    bounds.bound(node, parameters, box);
    for (int column = 0; column < kWidth; ++column) {
      const Vector3d low(double(box.low[0][column]), double(box.low[1][column]),
                         double(box.low[2][column]));
      const Vector3d high(double(box.high[0][column]), double(box.high[1][column]),
                          double(box.high[2][column]));
      const std::span<const std::int32_t> vertices = tree.vertices(node, column);
      if (vertices.empty()) {
        ASSERT_EQ(low.x(), std::numeric_limits<double>::infinity()) << what << " node " << node;
        ASSERT_EQ(high.x(), -std::numeric_limits<double>::infinity()) << what << " node " << node;
        continue;
      }
      Vector3d least = positions[static_cast<std::size_t>(vertices[0])], most = least;
      for (const std::int32_t v : vertices) {
        least = least.cwiseMin(positions[static_cast<std::size_t>(v)]);
        most = most.cwiseMax(positions[static_cast<std::size_t>(v)]);
      }
      ASSERT_TRUE((low.array() <= least.array()).all() && (most.array() <= high.array()).all())
          << what << " node " << node << " column " << column << ": vertices from "
          << least.transpose() << " to " << most.transpose() << ", box from " << low.transpose()
          << " to " << high.transpose();
      fit.area += area(high - low);
      fit.exact += area(most - least);
    }
  }
}

void checkDisplacement(const VertexMotion& motion, const NodeBounds& bounds, const DeformTree& tree,
                       std::span<const double> from, std::span<const double> to,
                       const std::string& what) {
  const auto count = static_cast<std::size_t>(motion.vertexCount());
  std::vector<Vector3d> before(count), after(count);
  motion.vertices(from, 0, before);
  motion.vertices(to, 0, after);
  for (std::int32_t node = 0; node < tree.nodeCount(); ++node) {
    WideBox box;
    bounds.displacement(node, from, to, bounds.displacementRounding(from, to), box);
    for (int column = 0; column < kWidth; ++column) {
      for (const std::int32_t v : tree.vertices(node, column)) {
        const auto i = static_cast<std::size_t>(v);
        for (int k = 0; k < 3; ++k) {
          // The old box, moved and grown by the displacement, contains the vertex.
          ASSERT_LE(before[i][k] + double(box.low[k][column]), after[i][k])
              << what << " node " << node << " column " << column << " vertex " << v;
          ASSERT_GE(before[i][k] + double(box.high[k][column]), after[i][k])
              << what << " node " << node << " column " << column << " vertex " << v;
        }
      }
    }
  }
}

// Box area relative to exact boxes; the limit detects bounds that became useless.
TEST(DeformBounds, HoldTheVerticesOfEveryNode) {
  int kinds = 0;
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(24, 9)) {
    const auto tree = buildDeformTree(c.mesh.vertices, c.mesh.triangles, DeformMethod::kBinned, 64);
    const auto bounds = makeNodeBounds(*c.motion, *tree, DeformVolume::kBox, tree->nodeCount());
    if (!bounds) continue;
    ++kinds;
    Random random(21);
    Fit fit;
    std::vector<double> parameters(static_cast<std::size_t>(c.motion->parameterCount()));
    std::vector<double> before = parameters;
    for (int i = 0; i < 40; ++i) {
      const double time = i == 0 ? 0.0 : random.uniform(-1, 4);
      c.motion->parameters(time, parameters);
      check(*c.motion, *bounds, *tree, parameters, c.name + " at " + std::to_string(time), fit);
      // Distant pairs and close ones.
      checkDisplacement(*c.motion, *bounds, *tree, before, parameters, c.name);
      before = parameters;
      c.motion->parameters(time + 0.01, parameters);
      checkDisplacement(*c.motion, *bounds, *tree, before, parameters, c.name);
    }
    const double ratio = fit.area / fit.exact;
    RecordProperty(c.name, std::to_string(ratio));
    EXPECT_GE(ratio, 1) << c.name;
    EXPECT_LT(ratio, 3) << c.name;
  }
  EXPECT_EQ(kinds, 7);
}

std::shared_ptr<const VertexMotion> cacheOf(const motion_cases::RestMesh& mesh, double far,
                                            double size, Random& random) {
  CacheMotion motion;
  motion.vertex_count = static_cast<int>(mesh.vertices.size());
  for (int frame = 0; frame < 5; ++frame) {
    motion.times.push_back(frame == 0 ? 0 : motion.times.back() + random.logUniform(1e-3, 10));
    const Vector3d offset = motion_cases::randomVector(random, far);
    for (const Vector3d& v : mesh.vertices) motion.positions.emplace_back(v * size + offset);
  }
  return VertexMotion::cache(std::move(motion));
}

// Between stored frames, at them, before the first and after the last.
TEST(DeformBounds, OfCachesHoldTheVertices) {
  Random random(23);
  Fit fit;
  for (int i = 0; i < 40; ++i) {
    const motion_cases::RestMesh mesh = motion_cases::cloth(9);
    const double far = i == 0 ? 0.1 : random.logUniform(1e-6, 1e6),
                 size = i == 0 ? 1 : random.logUniform(1e-6, 1e3);
    const auto motion = cacheOf(mesh, far, size, random);
    const auto& cached = dynamic_cast<const CachedVertices&>(*motion);
    const auto tree = buildDeformTree(mesh.vertices, mesh.triangles, DeformMethod::kBinned, 32);
    const CachedBounds bounds(cached, *tree, tree->nodeCount()),
        upper(cached, *tree, tree->upperCount());
    std::vector<double> parameters(2);
    for (int j = 0; j < 30; ++j) {
      const std::span<const double> times = motion->keyTimes();
      const double time = j < 5 ? times[static_cast<std::size_t>(j)]
                                : random.uniform(times.front() - 0.1, times.back() + 0.1);
      motion->parameters(time, parameters);
      Fit of_case;
      check(*motion, bounds, *tree, parameters, "case " + std::to_string(i), of_case);
      if (i == 0) fit = of_case;
      for (std::int32_t node = 0; node < tree->upperCount(); ++node) {
        WideBox box, same;
        bounds.bound(node, parameters, box);
        upper.bound(node, parameters, same);
        ASSERT_EQ(std::memcmp(&box, &same, sizeof(box)), 0);
      }
    }
  }
  EXPECT_LT(fit.area, 1.2 * fit.exact);
}

// Numbers that a file may contain: huge and tiny weights, coordinates far from the origin.
TEST(DeformBounds, HoldForHardNumbers) {
  Random random(22);
  for (int i = 0; i < 60; ++i) {
    motion_cases::RestMesh mesh = motion_cases::cloth(7);
    const double far = random.logUniform(1e-6, 1e6), size = random.logUniform(1e-6, 1e3);
    const Vector3d offset = motion_cases::randomVector(random, far);
    for (Vector3d& v : mesh.vertices) v = v * size + offset;
    const auto tree = buildDeformTree(mesh.vertices, mesh.triangles, DeformMethod::kLinear, 64);
    MorphMotion morph;
    ReducedMotion reduced;
    SkinnedMotion skinned;
    reduced.rest = skinned.rest = mesh.vertices;
    MorphMotion::Key weights;
    ReducedMotion::Key coordinates;
    SkinnedMotion::Key poses;
    for (int k = 0; k < 3; ++k) {
      std::vector<Vector3d> moved = mesh.vertices;
      for (Vector3d& v : moved) v += motion_cases::randomVector(random, size * 0.1);
      morph.references.push_back(moved);
      for (std::size_t v = 0; v < moved.size(); ++v) moved[v] -= mesh.vertices[v];
      reduced.modes.push_back(moved);
      weights.weights.push_back(random.uniform(-1, 1) * random.logUniform(1e-3, 1e3));
      coordinates.coordinates.push_back(random.uniform(-1, 1) * random.logUniform(1e-3, 1e3));
      SkinnedMotion::BonePose pose;
      pose.translation = motion_cases::randomVector(random, far);
      for (int n = 0; n < 4; ++n) pose.quaternion[n] = random.uniform(-1, 1);
      skinned.bones.push_back({k - 1, pose});
      pose.translation = motion_cases::randomVector(random, far);
      for (int n = 0; n < 4; ++n) pose.quaternion[n] = random.uniform(-1, 1);
      poses.poses.push_back(pose);
      for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) {
        if (k == v % 3 || random.chance(0.4))
          skinned.weights.push_back({v, k, random.logUniform(1e-9, 1)});
      }
    }
    morph.keys.push_back(weights);
    reduced.keys.push_back(coordinates);
    skinned.keys.push_back(poses);
    Fit fit;
    for (const auto& motion : {VertexMotion::morph(morph), VertexMotion::reduced(reduced),
                               VertexMotion::skinned(skinned)}) {
      std::vector<double> parameters(static_cast<std::size_t>(motion->parameterCount()));
      motion->parameters(0, parameters);
      const auto bounds = makeNodeBounds(*motion, *tree, DeformVolume::kBox, tree->nodeCount());
      const std::string what =
          std::string(toString(motion->kind())) + " of case " + std::to_string(i);
      check(*motion, *bounds, *tree, parameters, what, fit);
      std::vector<double> moved = parameters;
      for (double& p : moved) p += p * random.uniform(-1, 1) * random.logUniform(1e-12, 10);
      checkDisplacement(*motion, *bounds, *tree, parameters, moved, what);
    }
  }
}

TEST(DeformBounds, SameBytesOnEveryInstructionSet) {
  std::vector<std::vector<WideBox>> of_targets;
  onEveryTarget([&](const char*) {
    std::vector<WideBox>& boxes = of_targets.emplace_back();
    for (const motion_cases::MotionCase& c : motion_cases::allMotions(12, 9)) {
      const auto tree =
          buildDeformTree(c.mesh.vertices, c.mesh.triangles, DeformMethod::kBinned, 64);
      if (const auto* cached = dynamic_cast<const CachedVertices*>(c.motion.get())) {
        const CachedBounds bounds(*cached, *tree, tree->nodeCount());
        std::vector<double> parameters(2);
        for (int i = 0; i < 10; ++i) {
          c.motion->parameters(0.3 * i, parameters);
          for (std::int32_t node = 0; node < tree->nodeCount(); ++node)
            bounds.bound(node, parameters, boxes.emplace_back());
        }
      }
      const auto bounds = makeNodeBounds(*c.motion, *tree, DeformVolume::kBox, tree->nodeCount());
      if (!bounds) continue;
      std::vector<double> from(static_cast<std::size_t>(c.motion->parameterCount())), to = from;
      for (int i = 0; i < 10; ++i) {
        c.motion->parameters(0.3 * i, from);
        c.motion->parameters(0.3 * i + 0.02, to);
        for (std::int32_t node = 0; node < tree->nodeCount(); ++node) {
          // Empty columns stay unchanged.
          bounds->bound(node, to, boxes.emplace_back());
          boxes.push_back(boxes.back());
          bounds->displacement(node, from, to, bounds->displacementRounding(from, to),
                               boxes.back());
        }
      }
    }
  });
  ASSERT_FALSE(of_targets.empty());
  ASSERT_GT(of_targets[0].size(), 500U);
  for (const std::vector<WideBox>& boxes : of_targets) {
    ASSERT_EQ(boxes.size(), of_targets[0].size());
    EXPECT_EQ(std::memcmp(boxes.data(), of_targets[0].data(), boxes.size() * sizeof(WideBox)), 0);
  }
}

/// A randomly oriented box: far away, nearly touching, or around some of the vertices.
struct ProbedBox {
  Vector3d low, high;
  double radius;
  Pose X_BA;
};
ProbedBox randomBox(Random& random, std::span<const Vector3d> positions) {
  ProbedBox body;
  body.low = -motion_cases::randomVector(random, 0.2).cwiseAbs();
  body.high = motion_cases::randomVector(random, 0.2).cwiseAbs();
  if (random.chance(0.3)) body.low = body.high = Vector3d::Zero();
  body.radius = random.chance(0.5) ? random.uniform(0, 0.1) : 0;
  body.X_BA.rotation = random.chance(0.2) ? Eigen::Matrix3d::Identity() : random.rotation();
  body.X_BA.translation =
      positions[static_cast<std::size_t>(random.below(static_cast<int>(positions.size())))] +
      motion_cases::randomVector(random, random.logUniform(1e-6, 2));
  return body;
}

/// Signed distance of a vertex from the body; inside: minus the depth below which no translation
/// separates.
double separation(const ProbedBox& body, const Vector3d& vertex) {
  const Vector3d p = body.X_BA.rotation.transpose() * (vertex - body.X_BA.translation);
  const Vector3d outside = (body.low - p).cwiseMax(p - body.high);
  const double deepest = outside.maxCoeff();
  return (deepest > 0 ? outside.cwiseMax(0.0).norm() : deepest) - body.radius;
}

// Bounds of 18-DOPs and balls hold for every vertex below, for any weights, and exceed the bounds
// of boxes where they should.
TEST(DeformBounds, VolumesProveWhatHoldsForTheVerticesOfEveryNode) {
  for (const DeformVolume volume : {DeformVolume::kDop, DeformVolume::kBall}) {
    int kinds = 0;
    for (const motion_cases::MotionCase& c : motion_cases::allMotions(12, 9)) {
      const auto tree =
          buildDeformTree(c.mesh.vertices, c.mesh.triangles, DeformMethod::kBinned, 64);
      const auto bounds = makeNodeBounds(*c.motion, *tree, volume, tree->nodeCount());
      if (!bounds || c.motion->kind() == MotionKind::kSkinned) continue;
      ++kinds;
      ASSERT_TRUE(bounds->hasVolumes());
      Random random(23);
      Fit fit;
      int raised = 0;
      std::vector<double> parameters(static_cast<std::size_t>(c.motion->parameterCount()));
      std::vector<Vector3d> positions(static_cast<std::size_t>(c.motion->vertexCount()));
      for (int i = 0; i < 40; ++i) {
        c.motion->parameters(random.uniform(-1, 4), parameters);
        check(*c.motion, *bounds, *tree, parameters, c.name, fit);
        c.motion->vertices(parameters, 0, positions);
        const ProbedBox body = randomBox(random, positions);
        const Probe probe =
            makeProbe(body.low, body.high, body.radius, body.X_BA, nullptr, 10, 1e-14);
        for (std::int32_t node = 0; node < tree->nodeCount(); ++node) {
          WideBox box;
          bounds->bound(node, parameters, box);
          WideBounds found;
          for (int column = 0; column < kWidth; ++column)
            found.lower[column] = -std::numeric_limits<float>::infinity();
          bounds->tighten(node, parameters, probe, found);
          for (int column = 0; column < kWidth; ++column) {
            const std::span<const std::int32_t> vertices = tree->vertices(node, column);
            if (vertices.empty()) break;
            double least = std::numeric_limits<double>::infinity();
            for (const std::int32_t v : vertices)
              least = std::min(least, separation(body, positions[static_cast<std::size_t>(v)]));
            ASSERT_LE(double(found.lower[column]), least)
                << c.name << " " << toString(volume) << " node " << node << " column " << column;
            const float low[3] = {box.low[0][column], box.low[1][column], box.low[2][column]},
                        high[3] = {box.high[0][column], box.high[1][column], box.high[2][column]};
            raised += double(found.lower[column]) > lowerBound(probe, low, high) + 1e-3 ? 1 : 0;
          }
        }
      }
      EXPECT_GT(raised, 0) << c.name << " " << toString(volume);
    }
    EXPECT_EQ(kinds, 5);
  }
}

TEST(DeformBounds, OtherMotionsHaveNone) {
  for (const motion_cases::MotionCase& c : motion_cases::allMotions(4, 9)) {
    const auto tree = buildDeformTree(c.mesh.vertices, c.mesh.triangles, DeformMethod::kBinned, 64);
    const MotionKind kind = c.motion->kind();
    const bool has_none =
        kind == MotionKind::kLattice || kind == MotionKind::kCache || kind == MotionKind::kOwn;
    EXPECT_EQ(makeNodeBounds(*c.motion, *tree, DeformVolume::kBox, tree->nodeCount()) == nullptr,
              has_none)
        << c.name;
  }
}

}  // namespace
}  // namespace leeway::collision
