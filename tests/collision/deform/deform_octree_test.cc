// Box pairs from the implicit octree against all pairs: every pair within reach is visited exactly
// once.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "collision/base/rounding.h"
#include "collision/deform/query/overlap_octree.h"
#include "leeway/collision/distance.h"
#include "tests/support/deformable_cases.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;
using oracle::Random;

constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

using Boxes = std::vector<FloatBox>;
using Pairs = std::vector<std::pair<int, int>>;

/// Boxes of the moved triangles.
Boxes boxesOf(std::span<const Vector3d> vertices,
              std::span<const DeformableMesh::Triangle> triangles, const Vector3d& moved) {
  Boxes boxes;
  for (const auto& t : triangles) {
    FloatBox box{{kFloatInfinity, kFloatInfinity, kFloatInfinity},
                 {-kFloatInfinity, -kFloatInfinity, -kFloatInfinity}};
    for (const std::int32_t corner : t) {
      const Vector3d p = vertices[static_cast<std::size_t>(corner)] + moved;
      for (int k = 0; k < 3; ++k) {
        box.low[k] = std::min(box.low[k], roundedDown(p[k]));
        box.high[k] = std::max(box.high[k], roundedUpToFloat(p[k]));
      }
    }
    boxes.push_back(box);
  }
  return boxes;
}

/// The octree's criterion: a grown by the reach.
bool meet(const FloatBox& a, const FloatBox& b, float reach) {
  for (int k = 0; k < 3; ++k) {
    if (!(a.low[k] - reach <= b.high[k] && b.low[k] <= a.high[k] + reach)) return false;
  }
  return true;
}

Pairs bruteForce(const Boxes& a, const Boxes& b, float reach) {
  Pairs pairs;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (meet(a[i], b[j], reach)) pairs.emplace_back(static_cast<int>(i), static_cast<int>(j));
    }
  }
  return pairs;
}

struct Found {
  Pairs pairs;  // sorted; a pair visited twice appears twice
  std::size_t cells = 0, compared = 0;
};

Found byOctree(const Boxes& a, const Boxes& b, float reach, std::size_t room) {
  std::vector<std::int32_t> lists(std::max(room, a.size() + b.size()));
  OctreePairs octree(a, b, reach, lists);
  Found found;
  EXPECT_TRUE(octree.run([&](int i, int j, float lower) {
    found.pairs.emplace_back(i, j);
    EXPECT_EQ(lower, boxDistance(a[static_cast<std::size_t>(i)], b[static_cast<std::size_t>(j)]));
    return true;
  }));
  std::sort(found.pairs.begin(), found.pairs.end());
  found.cells = octree.cells();
  found.compared = octree.compared();
  return found;
}

/// Returns the number of pairs.
std::size_t expectEachOnce(const Boxes& a, const Boxes& b, float reach, const std::string& what) {
  const Pairs truth = bruteForce(a, b, reach);
  // Memory for all levels, for some, and for the first list only.
  for (const std::size_t room : {std::size_t{1} << 16, 4 * (a.size() + b.size()), std::size_t{0}}) {
    const Found found = byOctree(a, b, reach, room);
    EXPECT_EQ(found.pairs, truth) << what << ", room " << room;
    EXPECT_LE(found.cells, 1 + a.size() * b.size()) << what << ", room " << room;
  }
  return truth.size();
}

TEST(OctreePairs, AreThoseOfBruteForceEachOnce) {
  Random random(81);
  std::size_t some = 0, none = 0;
  for (int round = 0; round < 60; ++round) {
    const testing::Sheet one = round % 2 == 0 ? testing::cloth(8) : testing::globe(4),
                         two = round % 3 == 0 ? testing::globe(3) : testing::cloth(6);
    const auto moved = [&](const testing::Sheet& sheet, int phase) {
      if (round % 5 == 4) return testing::exploded(sheet.vertices, 0.5, random.bits());
      return testing::waved(sheet.vertices, 0.3, phase);
    };
    const Boxes a = boxesOf(moved(one, round), one.triangles, {0, 0, 0}),
                b = boxesOf(moved(two, 2 * round), two.triangles,
                            random.uniform(0, 2.5) * random.direction());
    const auto reach = static_cast<float>(random.chance(0.3) ? 0 : random.uniform(0, 0.3));
    (expectEachOnce(a, b, reach, "round " + std::to_string(round)) > 0 ? some : none) += 1;
  }
  EXPECT_GT(some, 30u);
  EXPECT_GT(none, 2u);
}

// Flat boxes, corners on cell boundaries, and equal sizes: a pair in two cells is reported by one.
TEST(OctreePairs, OnTheBordersOfCellsComeOnce) {
  Random random(82);
  std::size_t count = 0;
  for (int round = 0; round < 40; ++round) {
    const auto grid = [&](int flat) {
      Boxes boxes;
      const float size = random.chance(0.5) ? 0.25F : 0.125F;
      for (int i = 0; i < 60; ++i) {
        FloatBox box;
        for (int k = 0; k < 3; ++k) {
          box.low[k] = 0.125F * static_cast<float>(random.below(9));
          box.high[k] = box.low[k] + (k < flat ? 0 : size);
        }
        boxes.push_back(box);
      }
      return boxes;
    };
    const Boxes a = grid(round % 4), b = grid(round / 4 % 4);
    const float reach = round % 2 == 0 ? 0 : 0.125F;
    count += expectEachOnce(a, b, reach, "round " + std::to_string(round));
  }
  EXPECT_GT(count, 5000u);
}

// Coplanar boxes give flat cells with identical halves. Regression: each pair of 200 flat boxes was
// visited two to four times, of 5000 up to sixteen times.
TEST(OctreePairs, OfFlatBoxesComeOnce) {
  Random random(83);
  const auto sheet = [&](int axis, bool flat) {
    Boxes boxes;
    for (int i = 0; i < 300; ++i) {
      FloatBox box;
      for (int k = 0; k < 3; ++k) {
        box.low[k] = k == axis ? 0 : static_cast<float>(random.uniform(0, 1));
        box.high[k] = k == axis && flat ? 0 : box.low[k] + 0.06F;
      }
      boxes.push_back(box);
    }
    return boxes;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const float reach : {0.0F, 0.001F, 0.1F}) {
      const Boxes a = sheet(axis, axis != 1), b = sheet(axis, true);
      EXPECT_GT(expectEachOnce(a, b, reach, "axis " + std::to_string(axis)), 300u);
    }
  }
}

// Parallel ropes: a split across them leaves each half as many pairs, one along them half.
TEST(OctreePairs, OfRopesAreFew) {
  Random random(84);
  const auto rope = [&](float x) {
    Boxes boxes;
    for (int i = 0; i < 600; ++i) {
      FloatBox box;
      for (int k = 0; k < 3; ++k) {
        const double at = k == 1 ? random.uniform(0, 100) : random.uniform(-0.02, 0.02);
        box.low[k] = static_cast<float>(at) + (k == 0 ? x : 0);
        box.high[k] = box.low[k] + (k == 1 ? 0.05F : 0.02F);
      }
      boxes.push_back(box);
    }
    return boxes;
  };
  const Boxes a = rope(0), b = rope(0.03F);
  for (const float reach : {0.0F, 0.01F, 0.05F}) {
    expectEachOnce(a, b, reach, "ropes, reach " + std::to_string(reach));
    EXPECT_LT(byOctree(a, b, reach, 1 << 16).compared, 20000u) << reach;  // of 360000
  }
}

// Coincident boxes: splitting never separates them, and must stop.
TEST(OctreePairs, ThatCannotBePartedEndAtOnce) {
  const Boxes points(50, FloatBox{{1, 2, 3}, {1, 2, 3}});
  EXPECT_EQ(expectEachOnce(points, points, 0, "points"), 2500u);
  EXPECT_LT(byOctree(points, points, 0, 1 << 16).cells, 20u);
  EXPECT_LT(byOctree(points, points, 0.5F, 1 << 16).cells, 20u);
}

/// A cube's six faces, `cells` squares along each edge, half side `half`.
testing::Sheet cube(double half, int cells) {
  testing::Sheet sheet;
  const auto vertex = [&](const Vector3d& p) {
    for (std::size_t i = 0; i < sheet.vertices.size(); ++i) {
      if ((sheet.vertices[i] - p).norm() < 1e-9) return static_cast<std::int32_t>(i);
    }
    sheet.vertices.push_back(p);
    return static_cast<std::int32_t>(sheet.vertices.size()) - 1;
  };
  for (int face = 0; face < 6; ++face) {
    const int k = face / 2;
    const bool outer = face % 2 != 0;
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const auto corner = [&](int u, int v) {
          Vector3d p;
          p[k] = outer ? half : -half;
          p[(k + 1) % 3] = half * (2.0 * (i + u) / cells - 1);
          p[(k + 2) % 3] = half * (2.0 * (j + v) / cells - 1);
          return vertex(p);
        };
        const std::int32_t a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
        sheet.triangles.push_back({a, outer ? b : c, outer ? c : b});
        sheet.triangles.push_back({a, outer ? c : d, outer ? d : c});
      }
    }
  }
  return sheet;
}

// Coplanar flat boxes exceed a cell along two axes, never along the third. Regression: they were
// split to the maximum depth, fourfold at each level, and this query took 17 s.
TEST(OctreePairs, OfCubesWhoseFacesShareAPlaneAreFew) {
  const testing::Sheet sheet = cube(0.3, 4);
  const Vector3d moved(0.1, 0.01, 0.02);
  const Boxes a = boxesOf(sheet.vertices, sheet.triangles, {0, 0, 0}),
              b = boxesOf(sheet.vertices, sheet.triangles, moved);
  for (const float reach : {0.0F, 0.01F, 0.1F}) {
    expectEachOnce(a, b, reach, "cubes, reach " + std::to_string(reach));
    EXPECT_LT(byOctree(a, b, reach, 1 << 16).cells, 2000u) << reach;
  }

  DeformOptions options;
  options.strategy = DeformStrategy::kOctree;
  Deformable one(DeformableMesh::make(sheet.vertices, sheet.triangles), nullptr, options),
      two(one.mesh(), nullptr, options);
  ASSERT_EQ(one.update(sheet.vertices, 1), UpdateStatus::kUpdated);
  ASSERT_EQ(two.update(sheet.vertices, 1), UpdateStatus::kUpdated);
  Scratch scratch;
  prepare(scratch, *one.snapshot());
  prepare(scratch, *two.snapshot());
  const DistanceResult r =
      distance(Shape::deformable(one.snapshot()), {}, Shape::deformable(two.snapshot()),
               {Eigen::Matrix3d::Identity(), moved}, {}, scratch);
  EXPECT_LT(r.distance.upper, 0);
  EXPECT_NEAR(r.distance.lower, -0.5, 1e-6);
}

}  // namespace
}  // namespace leeway::collision
