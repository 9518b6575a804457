#include "leeway/planner/simplify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "leeway/planner/plan.h"
#include "planner/base/random.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using Path_ = std::vector<std::vector<double>>;

/// A zigzag through the wall's gap with every edge certified.
Path_ zigzag(EdgeCertifier& certifier, std::uint64_t seed) {
  Random random(seed);
  Path_ path = {{-1, -1, 0}};
  const std::vector<std::vector<double>> by = {
      {-1.3, 0.5, 1}, {-0.3, 1.2, -1}, {0.3, 1.2, 1}, {0.7, 0.2, 2}, {0.8, -0.5, 0}};
  for (const std::vector<double>& b : by) {
    for (int tries = 0; tries < 100; ++tries) {
      std::vector<double> q = {b[0] + random.uniform(-0.1, 0.1), b[1] + random.uniform(-0.05, 0.05),
                               b[2] + random.uniform(-0.5, 0.5)};
      if (certifier.certify(path.back(), q).verdict != Verdict::kFree) continue;
      path.push_back(q);
      break;
    }
  }
  path.push_back({1, -1, 0});
  return path;
}

void expectCertified(EdgeCertifier& certifier, const Path_& path) {
  for (std::size_t i = 1; i < path.size(); ++i)
    EXPECT_EQ(certifier.certify(path[i - 1], path[i]).verdict, Verdict::kFree) << "edge " << i - 1;
}

class Simplify : public testing::Test {
 protected:
  std::shared_ptr<const CompiledScene> scene_ =
      std::make_shared<const CompiledScene>(test::wallProblem());
  EdgeCertifier certifier_{scene_};
  double length(const Path_& path) const { return pathLength(scene_->space(), path); }
};

TEST_F(Simplify, ShortensKeepsEndsAndProof) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Path_ before = zigzag(certifier_, seed);
    expectCertified(certifier_, before);
    Path_ after = before;
    SimplifyOptions options;
    options.seed = seed;
    const SimplifyResult result = simplify(certifier_, after, options);
    expectCertified(certifier_, after);
    EXPECT_EQ(after.front(), before.front());
    EXPECT_EQ(after.back(), before.back());
    EXPECT_LT(length(after), 0.9 * length(before));
    // No path around the wall's edges through its gap is shorter than 4.5.
    EXPECT_GT(length(after), 4.5);
    EXPECT_LT(length(after), 6.0);
    EXPECT_GT(result.shortcuts, 0);
    EXPECT_LE(result.attempts, options.attempts);
  }
}

TEST_F(Simplify, IsDeterministic) {
  const Path_ before = zigzag(certifier_, 3);
  SimplifyOptions options;
  options.seed = 4;
  Path_ a = before, b = before, c = before;
  simplify(certifier_, a, options);
  EdgeCertifier fresh(scene_);
  simplify(fresh, b, options);
  EXPECT_EQ(a, b);
  options.seed = 5;
  simplify(certifier_, c, options);
  EXPECT_NE(a, c);
}

TEST_F(Simplify, StopsAtOnceAndLeavesAProvenPath) {
  for (int limit = 0; limit < 60; ++limit) {
    const Path_ before = zigzag(certifier_, 9);
    Path_ after = before;
    int asked = 0, asked_after = 0;
    SimplifyOptions options;
    options.stop = [&] {
      asked_after += asked > limit;
      return ++asked > limit;
    };
    simplify(certifier_, after, options);
    EXPECT_EQ(asked_after, 0) << "asked again after it said stop";
    expectCertified(certifier_, after);
    EXPECT_LE(length(after), length(before) + 1e-12);
    EXPECT_EQ(after.back(), before.back());
    if (limit == 0) {
      EXPECT_EQ(after, before);
    }
  }
}

TEST_F(Simplify, KeepsAClearanceFloor) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Path_ path = {{-1, -1, 0},   {-0.9, 0.3, 2}, {-0.8, 1.2, 1}, {0, 1.2, -1},
                  {0.8, 1.2, 1}, {0.9, 0, 0},    {1, -1, 0}};
    SimplifyOptions options;
    options.seed = seed;
    options.clearance_floor = 0.15;
    const double before = length(path);
    simplify(certifier_, path, options);
    EXPECT_LT(length(path), before);
    for (std::size_t i = 1; i < path.size(); ++i)
      EXPECT_GE(
          certifier_
              .edgeClearance(path[i - 1], path[i], 1e-4, -std::numeric_limits<double>::infinity())
              .clearance.upper,
          0.15);
  }
}

TEST_F(Simplify, LeavesShortPathsAlone) {
  Path_ none, one = {{-1, -1, 0}}, two = {{-1, -1, 0}, {-1, -1, 0}};
  simplify(certifier_, none);
  simplify(certifier_, one);
  simplify(certifier_, two);
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(one.size(), 1u);
  EXPECT_EQ(two.size(), 2u);
}

}  // namespace
}  // namespace leeway::planner
