#include "planner/space/nearest_nodes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "planner/base/random.h"
#include "tests/support/every_target.h"
#include "tests/support/mixed_space.h"

namespace leeway::planner {
namespace {

/// The slow twin: the node of least distance() in double precision.
std::size_t slowNearest(const ConfigurationSpace& space,
                        const std::vector<std::vector<double>>& points,
                        const std::vector<double>& query) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (space.distance(points[i], query) < space.distance(points[best], query)) best = i;
  return best;
}

TEST(NearestNodes, AgreesWithDistancesInDoublePrecision) {
  Random random(5);
  const ConfigurationSpace space = testing::mixedSpace();
  NearestNodes nodes(space);
  std::vector<std::vector<double>> points;
  for (int i = 0; i < 400; ++i) {
    points.push_back(testing::randomPoint(random, space));
    nodes.add(points.back());
    const std::vector<double> query = testing::randomPoint(random, space);
    const NearestNodes::Nearest found = nodes.nearest(query);
    ASSERT_LT(found.node, points.size());
    const double least = space.distance(points[slowNearest(space, points, query)], query);
    const double distance = space.distance(points[found.node], query);
    // A chord of a quaternion is up to a tenth shorter than its angle.
    EXPECT_LE(0.9 * distance, least) << i;
    EXPECT_LE(found.distance, distance + 1e-4) << i;
    EXPECT_GE(found.distance, 0.9 * distance - 1e-4) << i;
  }
}

TEST(NearestNodes, IsExactWithoutRotations) {
  Random random(6);
  const ConfigurationSpace space = testing::mixedSpace(false);
  NearestNodes nodes(space);
  std::vector<std::vector<double>> points;
  for (int i = 0; i < 1000; ++i) {
    points.push_back(testing::randomPoint(random, space));
    nodes.add(points.back());
  }
  for (int i = 0; i < 200; ++i) {
    const std::vector<double> query = testing::randomPoint(random, space);
    const NearestNodes::Nearest found = nodes.nearest(query);
    const double least = space.distance(points[slowNearest(space, points, query)], query);
    EXPECT_NEAR(space.distance(points[found.node], query), least, 1e-5);
    EXPECT_NEAR(found.distance, least, 1e-5);
  }
}

// Regression: padding was nearer than every node if all parts are rotations.
TEST(NearestNodes, RotationsAloneAreNotMistakenForPadding) {
  Random random(9);
  const ConfigurationSpace mixed = testing::mixedSpace();
  std::vector<int> variables;
  for (const ConfigurationSpace::Part& part : mixed.parts())
    if (part.kind == ConfigurationSpace::Kind::kRotation)
      for (int k = 0; k < 4; ++k) variables.push_back(part.first + k);
  const ConfigurationSpace space(
      std::shared_ptr<const robots::Model>(std::shared_ptr<const robots::Model>(), &mixed.model()),
      variables);
  EXPECT_GE(onEveryTarget([&](const char* target) {
              for (const std::uint32_t count : {1U, 15U, 16U, 17U}) {
                NearestNodes nodes(space);
                for (std::uint32_t i = 0; i < count; ++i)
                  nodes.add(testing::randomPoint(random, space));
                for (int i = 0; i < 20; ++i)
                  EXPECT_LT(nodes.nearest(testing::randomPoint(random, space)).node, count)
                      << target;
              }
            }),
            1);
}

// Regression: a start that had wound around a circle three times was far from everything.
TEST(NearestNodes, CirclesCountModuloWholeTurns) {
  Random random(10);
  const ConfigurationSpace space = testing::mixedSpace(false);
  NearestNodes nodes(space);
  std::vector<double> wound = testing::randomPoint(random, space);
  const std::vector<double> point = wound;
  for (const ConfigurationSpace::Part& part : space.parts())
    if (part.kind == ConfigurationSpace::Kind::kCircle)
      wound[static_cast<std::size_t>(part.first)] += 6 * std::numbers::pi;
  nodes.add(wound);
  EXPECT_NEAR(nodes.nearest(point).distance, 0, 1e-5);
  EXPECT_NEAR(nodes.nearest(wound).distance, 0, 1e-5);
}

TEST(NearestNodes, TheFirstOfEqualNodes) {
  const ConfigurationSpace space = testing::mixedSpace();
  Random random(7);
  const std::vector<double> point = testing::randomPoint(random, space);
  for (std::size_t count : {1U, 2U, 16U, 17U, 40U}) {
    NearestNodes nodes(space);
    for (std::size_t i = 0; i < count; ++i) nodes.add(point);
    EXPECT_EQ(nodes.nearest(testing::randomPoint(random, space)).node, 0U);
  }
}

TEST(NearestNodes, TheSameOnEveryInstructionSet) {
  const ConfigurationSpace space = testing::mixedSpace();
  expectTheSameBytesOnEveryTarget([&] {
    Random random(8);
    NearestNodes nodes(space);
    std::vector<float> answers;
    for (int i = 0; i < 300; ++i) {
      nodes.add(testing::randomPoint(random, space));
      const NearestNodes::Nearest found = nodes.nearest(testing::randomPoint(random, space));
      answers.push_back(static_cast<float>(found.node));
      answers.push_back(found.distance);
    }
    return answers;
  });
}

}  // namespace
}  // namespace leeway::planner
