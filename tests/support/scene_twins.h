#pragma once

// Random scenes with many pairs, and their slow twins.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "leeway/collision/scene.h"
#include "tests/support/allocations.h"

namespace leeway::collision::testing {

inline constexpr int kMoving = 3;

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
  }
  Pose pose(double size) {
    const auto vector = [&](double s) {
      return Eigen::Vector3d(uniform(-s, s), uniform(-s, s), uniform(-s, s));
    };
    return {Eigen::AngleAxisd(uniform(-3, 3), vector(1).normalized()).toRotationMatrix(),
            vector(size)};
  }
  Shape shape() {
    if (below(2) == 0) return Shape::sphere(uniform(0.01, 0.2));
    return Shape::box({uniform(0.01, 0.2), uniform(0.01, 0.2), uniform(0.01, 0.2)});
  }
  /// A shape whose depth has no closed form.
  Shape roundShape() {
    if (below(2) == 0) return Shape::cylinder(uniform(0.05, 0.2), uniform(0.05, 0.2));
    return Shape::ellipsoid({uniform(0.05, 0.2), uniform(0.05, 0.2), uniform(0.05, 0.2)});
  }

 private:
  std::mt19937_64 engine_;
};

/// Three moving bodies, followed by 30 to 60 fixed ones, with exceptions. If the margin is a depth:
/// with round shapes and without exceptions.
inline SceneBuilder randomBuilder(Draw& draw, bool one_each, double margin = 0.01) {
  SceneBuilder builder;
  const int count = kMoving + 30 + draw.below(30);
  for (int i = 0; i < count; ++i) {
    Body body;
    body.name = "body" + std::to_string(i);
    body.moving = i < kMoving && i != 1;
    body.X_WB = draw.pose(2);
    for (int g = one_each ? 0 : draw.below(3); g >= 0; --g)
      body.geometries.push_back(
          {margin < 0 ? draw.roundShape() : draw.shape(), draw.pose(0.2), ""});
    if (!one_each && i > kMoving && i % 11 == 0) body.geometries.clear();
    builder.add(std::move(body));
  }
  builder.setDefaultMargin(margin);
  for (int k = draw.below(12); k > 0; --k) builder.allow(draw.below(kMoving), draw.below(count));
  if (margin < 0) return builder;
  for (int k = draw.below(12); k > 0; --k)
    builder.setMargin(draw.below(count), draw.below(kMoving), draw.uniform(-0.01, 0.05));
  return builder;
}

/// The same scene twice: with all pairs listed, which are tested one by one, and with a table.
struct Twins {
  explicit Twins(SceneBuilder builder) : table(builder.build()) {
    builder.listAll();
    listed = builder.build();
  }
  Twins(Scene all_listed, Scene other) : listed(std::move(all_listed)), table(std::move(other)) {}
  void both(const std::function<void(Scene&)>& change) {
    change(listed);
    change(table);
  }
  Scene listed, table;
};

using Key = std::tuple<int, int, int, int>;
inline Key keyOf(const ScenePair& pair) {
  return {pair.body_a, pair.geometry_a, pair.body_b, pair.geometry_b};
}

inline std::vector<ScenePair> sorted(const ScenePairs& pairs) {
  std::vector<ScenePair> all(pairs.begin(), pairs.end());
  std::sort(all.begin(), all.end(),
            [](const auto& x, const auto& y) { return keyOf(x) < keyOf(y); });
  return all;
}

inline void expectSame(const Twins& twins, const std::string& what) {
  const ScenePairs& pairs = twins.table.pairs();
  ASSERT_EQ(pairs.size(), twins.listed.pairs().size()) << what;
  const std::vector<ScenePair> x = sorted(twins.listed.pairs()), y = sorted(pairs);
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_EQ(keyOf(x[i]), keyOf(y[i])) << what;
    ASSERT_TRUE(x[i].margin == y[i].margin || (std::isnan(x[i].margin) && std::isnan(y[i].margin)))
        << what;
  }
  for (const int body : {0, kMoving})
    for (const bool with : {false, true})
      EXPECT_EQ(twins.listed.pairs().leastMargin(body, with), pairs.leastMargin(body, with))
          << what;
  const double most = twins.listed.pairs().mostMargin();
  EXPECT_TRUE(most == pairs.mostMargin() || (std::isnan(most) && std::isnan(pairs.mostMargin())));
  std::vector<std::size_t> in_rows(pairs.rows().size());
  for (std::size_t p = pairs.listedCount(); p < pairs.numbers(); ++p) {
    const ScenePairs::Place of = pairs.placeOf(p);
    EXPECT_EQ(pairs.numberOf(of.row, of.place), pairs.has(p) ? static_cast<int>(p) : -1) << what;
    if (!pairs.has(p)) continue;
    ++in_rows[of.row];
    const double margin = pairs[p].margin;
    EXPECT_TRUE(pairs.marginOf(of) == margin || std::isnan(margin)) << what;
    EXPECT_TRUE(pairs.rows()[of.row].least <= margin || std::isnan(margin)) << what;
    EXPECT_TRUE(pairs.rows()[of.row].most >= margin || std::isnan(pairs.rows()[of.row].most))
        << what;
  }
  for (std::size_t row = 0; row < in_rows.size(); ++row)
    EXPECT_EQ(pairs.rows()[row].count, in_rows[row]) << what;
}

/// clearance() and decide() of both, in the same poses; those of `table` allocate nothing. Returns
/// the clearance() of the first.
inline SceneResult expectSameAnswers(const Twins& twins, Workspace& listed, Workspace& table) {
  const SceneResult x = clearance(twins.listed, listed, 1e-4);
  const std::size_t before = allocationCount();
  const SceneResult y = clearance(twins.table, table, 1e-4);
  const SceneResult decided = decide(twins.table, table);
  EXPECT_EQ(allocationCount(), before);
  EXPECT_EQ(x.verdict, y.verdict);
  if (std::isfinite(x.clearance.upper) || std::isfinite(y.clearance.upper)) {
    EXPECT_NEAR(x.clearance.lower, y.clearance.lower, 1e-4);
    EXPECT_NEAR(x.clearance.upper, y.clearance.upper, 1e-4);
  } else {
    EXPECT_EQ(x.clearance.upper, y.clearance.upper);
  }
  EXPECT_EQ(decided.verdict, decide(twins.listed, listed).verdict);
  EXPECT_LE(decided.clearance.lower, x.clearance.upper);
  return x;
}

}  // namespace leeway::collision::testing
