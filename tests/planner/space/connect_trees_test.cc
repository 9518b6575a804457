#include "planner/space/connect_trees.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "tests/support/mixed_space.h"

namespace leeway::planner {
namespace {

using Point = std::span<const double>;
using Edge = std::function<bool(Point, Point)>;

/// A point in the square from -2 to 2.
ConfigurationSpace square() {
  robots::RobotDescription robot = robots::testing::chain(
      3, robots::JointType::kPrismatic, 2, [](int, robots::Link&, robots::Joint&) {});
  return {std::make_shared<robots::Model>(std::move(robot)), {0, 1}};
}

/// A wall at x = 0 with a gap of the given width about y = 1.
Edge wallWithGap(double gap) {
  return [gap](Point a, Point b) {
    if ((a[0] < 0) == (b[0] < 0)) return true;
    const double y = a[1] + (b[1] - a[1]) * a[0] / (a[0] - b[0]);
    return std::abs(y - 1) < gap / 2;
  };
}

struct Found {
  std::vector<std::vector<double>> path;
  int iterations = 0;
};

Found search(const ConfigurationSpace& space, const std::vector<double>& start,
             const std::vector<std::vector<double>>& goals, const Edge& edge,
             ConnectSettings settings, std::uint64_t seed, int limit = 100000) {
  ConnectTrees trees({space, start, goals, edge}, settings, seed);
  Found found;
  while (++found.iterations < limit)
    if (trees.iterate()) {
      found.path = trees.path();
      break;
    }
  return found;
}

double lengthOf(const ConfigurationSpace& space, const std::vector<std::vector<double>>& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) length += space.distance(path[i - 1], path[i]);
  return length;
}

/// A proof of an edge is then a proof of the path's edge.
TEST(ConnectTrees, AsksEdgesInThePathsDirection) {
  using Points = std::vector<double>;
  const ConfigurationSpace space = square();
  const std::vector<std::vector<double>> goals{{1, -1}, {1, -1.5}};
  const Edge gap = wallWithGap(0.4);
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    std::set<std::pair<Points, Points>> free;
    const Edge edge = [&](Point a, Point b) {
      if (!gap(a, b)) return false;
      free.insert({Points(a.begin(), a.end()), Points(b.begin(), b.end())});
      return true;
    };
    const Found found = search(space, {-1, -1}, goals, edge, {0.3, seed % 2 == 0, true}, seed);
    ASSERT_FALSE(found.path.empty()) << seed;
    for (std::size_t i = 1; i < found.path.size(); ++i)
      EXPECT_EQ(free.count({found.path[i - 1], found.path[i]}), 1) << seed << ", edge " << i;
  }
}

/// With twelve joints a range is a twentieth of the extent, and no sample is within four ranges of
/// a root. Regression: both trees stopped growing once their roots had failed.
TEST(ConnectTrees, ManyJointsGrowAfterFailures) {
  const int joints = 12;
  robots::RobotDescription robot = robots::testing::chain(
      joints + 1, robots::JointType::kRevolute, 2, [](int, robots::Link&, robots::Joint&) {});
  std::vector<int> variables(joints);
  std::iota(variables.begin(), variables.end(), 0);
  const ConfigurationSpace space(std::make_shared<robots::Model>(std::move(robot)), variables);
  const std::vector<double> start(joints, -1.5);
  const std::vector<std::vector<double>> goals{std::vector<double>(joints, 1.5)};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    int failures = 4;
    const Edge edge = [&failures](Point, Point) { return failures-- <= 0; };
    const Found found = search(space, start, goals, edge, {defaultRange(space)}, seed, 1000);
    EXPECT_FALSE(found.path.empty()) << seed;
  }
}

TEST(ConnectTrees, FindsPathsBelowABoundOnly) {
  const ConfigurationSpace space = square();
  const std::vector<double> start{-1, -1};
  const std::vector<std::vector<double>> goals{{1, -1}, {1, -1.5}};
  const Edge edge = wallWithGap(0.4);
  // Near the lower end of the gap.
  const std::vector<double> corner{0, 0.8};
  const double least = space.distance(start, corner) + space.distance(corner, goals[0]);
  for (const double share : {0.999, 1.5}) {
    int found = 0;
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      ConnectTrees trees({space, start, goals, edge, share * least}, {0.3, true, true}, seed);
      bool met = false;
      for (int i = 0; i < 500 && !met; ++i) met = trees.iterate();
      found += met;
      if (met) {
        EXPECT_LT(lengthOf(space, trees.path()), share * least * (1 + 1e-12));
      }
    }
    if (share < 1) {
      EXPECT_EQ(found, 0);
    } else {
      EXPECT_GE(found, 10);
    }
  }
}

TEST(ConnectTrees, FindsTheGapWithAnySettings) {
  const ConfigurationSpace space = square();
  const std::vector<double> start{-1, -1};
  const std::vector<std::vector<double>> goals{{1, -1}};
  const Edge edge = wallWithGap(0.1);
  for (const bool balance : {false, true})
    for (const bool dynamic : {false, true})
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const ConnectSettings settings{0.3, balance, dynamic, seed % 2 == 0};
        const Found found = search(space, start, goals, edge, settings, seed);
        ASSERT_GE(found.path.size(), 2U) << seed;
        EXPECT_EQ(found.path.front(), start);
        EXPECT_EQ(found.path.back(), goals[0]);
        for (std::size_t i = 1; i < found.path.size(); ++i) {
          EXPECT_TRUE(edge(found.path[i - 1], found.path[i]));
          EXPECT_LE(space.distance(found.path[i - 1], found.path[i]), 0.3 * (1 + 1e-12));
        }
      }
}

/// If trees never grow and the range is as long as the space, edges end in the samples.
TEST(ConnectTrees, SamplesOfASequenceFillTheSpaceEvenly) {
  const ConfigurationSpace space = testing::mixedSpace(false);
  const std::size_t size = static_cast<std::size_t>(space.size());
  Random random(3);
  const std::vector<double> start = testing::randomPoint(random, space);
  const std::vector<std::vector<double>> goals{testing::randomPoint(random, space)};
  constexpr int kSamples = 1 << 10, kCells = 32;
  double worst[2] = {0,
                     0};  // count in a cell, from its mean, of random samples and of the sequence
  for (const bool low : {false, true})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      std::vector<std::vector<double>> asked;
      const Edge edge = [&](Point a, Point b) {
        const Point sample = std::equal(a.begin(), a.end(), start.begin()) ? b : a;
        asked.emplace_back(sample.begin(), sample.end());
        return false;  // no node is added, so every sample is tried
      };
      ConnectTrees trees({space, start, goals, edge}, {1e9, true, false, low}, seed);
      for (int i = 0; i < kSamples; ++i) trees.iterate();
      ASSERT_GT(asked.size(), static_cast<std::size_t>(kSamples - 10));
      for (const ConfigurationSpace::Part& part : space.parts()) {
        const auto i = static_cast<std::size_t>(part.first);
        if (part.kind == ConfigurationSpace::Kind::kRotation) {
          double squares[4] = {};
          for (const std::vector<double>& q : asked) {
            double squared = 0;
            for (std::size_t k = 0; k < 4; ++k) squared += q[i + k] * q[i + k];
            EXPECT_NEAR(squared, 1, 1e-14);
            for (std::size_t k = 0; k < 4; ++k) squares[k] += q[i + k] * q[i + k] / kSamples;
          }
          // The mean square is 1/4, the variance of one 1/16.
          for (const double mean : squares) EXPECT_NEAR(mean, 0.25, 4 * 0.25 / 32);
          continue;
        }
        const bool is_line = part.kind == ConfigurationSpace::Kind::kLine;
        const double lower = is_line ? space.lower(part.first) : -std::numbers::pi;
        const double upper = is_line ? space.upper(part.first) : std::numbers::pi;
        int counts[kCells] = {};
        for (const std::vector<double>& q : asked) {
          ASSERT_EQ(q.size(), size);
          ASSERT_GE(q[i], lower);
          ASSERT_LE(q[i], upper);
          ++counts[std::min(kCells - 1,
                            static_cast<int>(kCells * (q[i] - lower) / (upper - lower)))];
        }
        for (const int count : counts)
          worst[low] = std::max(worst[low], std::abs(count - double{kSamples} / kCells));
      }
    }
  EXPECT_LE(worst[1], 5);
  EXPECT_GT(worst[0], 10);
}

TEST(ConnectTrees, OneSeedIsOnePath) {
  const ConfigurationSpace space = testing::mixedSpace(false);
  Random random(3);
  const std::vector<double> start = testing::randomPoint(random, space);
  const std::vector<std::vector<double>> goals{testing::randomPoint(random, space),
                                               testing::randomPoint(random, space)};
  const Edge edge = [](Point a, Point b) { return std::sin(5 * a[0]) + std::sin(7 * b[1]) < 1; };
  const Found first = search(space, start, goals, edge, {1, true, true}, 4);
  const Found again = search(space, start, goals, edge, {1, true, true}, 4);
  ASSERT_FALSE(first.path.empty());
  EXPECT_EQ(first.path, again.path);
  EXPECT_NE(first.path, search(space, start, goals, edge, {1, true, true}, 5).path);
}

TEST(ConnectTrees, ReachesOneOfSeveralGoals) {
  const ConfigurationSpace space = square();
  // The second goal cannot be reached.
  const std::vector<std::vector<double>> goals{{1, 1}, {1.5, -1.5}};
  const Edge edge = [](Point a, Point b) {
    return !(b[0] > 1.4 && b[1] < -1.4) && !(a[0] > 1.4 && a[1] < -1.4);
  };
  const Found found = search(space, {-1, 0}, goals, edge, {0.5, true, true}, 1);
  ASSERT_FALSE(found.path.empty());
  EXPECT_EQ(found.path.back(), goals[0]);
}

TEST(ConnectTrees, NothingIsFoundWhereNothingIsFree) {
  const ConfigurationSpace space = square();
  const Edge edge = [](Point, Point) { return false; };
  EXPECT_TRUE(search(space, {-1, 0}, {{1, 0}}, edge, {0.5, true, true}, 1, 1000).path.empty());
}

TEST(ConnectTrees, RangesThatAreNoLengthsEndAllTheSame) {
  const ConfigurationSpace space = square();
  const Edge edge = [](Point, Point) { return true; };
  for (const double range : {0.0, 1e-300, -1.0, std::nan(""), HUGE_VAL}) {
    const Found found = search(space, {-1, 0}, {{1, 0}}, edge, {range, true, true}, 1);
    ASSERT_GE(found.path.size(), 2U) << range;
    EXPECT_EQ(found.path.back(), (std::vector<double>{1, 0}));
  }
}

TEST(ConnectTrees, SlidesLeadThroughAGapThatSamplesMiss) {
  const ConfigurationSpace space = square();
  const std::vector<double> start{-1, -1};
  const Edge edge = wallWithGap(0.004);
  // The slide goes along the wall, then into the gap: first half of the remaining way up, then the
  // rest.
  int slides = 0, slid = 0;
  const ConnectSlide slide = [&](Point from, Point target, std::vector<double>& points) {
    ++slides;
    if ((from[0] < 0) == (target[0] < 0)) return;
    const double side = from[0] < 0 ? -0.01 : 0.01;
    const double x[] = {side, side, -side}, y[] = {from[1], 1, 1};
    std::vector<double> at(from.begin(), from.end());
    for (int i = 0; i < 3; ++i) {
      const std::vector<double> next{x[i], y[i]};
      ASSERT_TRUE(edge(at, next));
      points.insert(points.end(), next.begin(), next.end());
      at = next;
      ++slid;
    }
  };
  for (const bool late : {false, true})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      // The first goal cannot be reached if another comes late.
      std::vector<std::vector<double>> goals{{late ? 5.0 : 1.0, -1}};
      const Edge apart = [&](Point a, Point b) { return a[0] < 2 && b[0] < 2 && edge(a, b); };
      ConnectTask task{space, start, goals, apart};
      task.slide = &slide;
      ConnectTrees trees(task, {0.3, true, false}, seed);
      bool met = false;
      for (int i = 0; i < 200 && !met; ++i) {
        if (i == 20 && late) {
          goals.push_back({1, -1});
          trees.takeGoals();
        }
        met = trees.iterate();
      }
      ASSERT_TRUE(met) << seed;
      const std::vector<std::vector<double>> path = trees.path();
      EXPECT_EQ(path.front(), start);
      EXPECT_EQ(path.back(), goals.back());
      for (std::size_t i = 1; i < path.size(); ++i) EXPECT_TRUE(edge(path[i - 1], path[i]));
    }
  EXPECT_GT(slid, 0);
  EXPECT_LT(search(space, start, {{1, -1}}, edge, {0.3, true, true}, 1, 200).path.size(), 2U);
}

TEST(ConnectTrees, ExtentCountsTurnsUpToHalfOnes) {
  // Two numbers from -2 to 2, and one of them a slide.
  EXPECT_NEAR(usefulExtent(square()), std::sqrt(32.0), 1e-12);
  robots::RobotDescription robot = robots::testing::chain(
      3, robots::JointType::kRevolute, 2, [](int, robots::Link&, robots::Joint&) {});
  const ConfigurationSpace turning{std::make_shared<robots::Model>(std::move(robot)), {0, 1}};
  EXPECT_NEAR(usefulExtent(turning), std::sqrt(2 * std::numbers::pi * std::numbers::pi), 1e-12);
}

TEST(ConnectTrees, ABodysRangeIsARadiansWay) {
  const auto range = [](robots::JointType type, double world, double size) {
    const Eigen::Vector3d bound = Eigen::Vector3d::Constant(world);
    const auto body = robots::freeBody("ball", {{collision::Shape::sphere(size), {}, "ball"}}, type,
                                       -bound, bound);
    return defaultRange({body, body->groups[0].variables});
  };
  for (const auto type : {robots::JointType::kFloating, robots::JointType::kPlanar})
    for (const double size : {0.01, 1.0, 50.0}) {
      EXPECT_NEAR(range(type, 3 * size, size), 0.5 * size, 1e-12 * size);
      EXPECT_NEAR(range(type, 4 * size, size), 0.5 * size, 1e-12 * size);
      EXPECT_LT(range(type, size / 4, size), 0.4 * size);
      // A small body in a large world still makes progress.
      EXPECT_GT(range(type, 1e3 * size, size), 50 * size);
      EXPECT_LT(range(type, 1e3 * size, size), 150 * size);
    }
}

}  // namespace
}  // namespace leeway::planner
