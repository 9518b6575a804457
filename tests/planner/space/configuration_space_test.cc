#include "leeway/planner/configuration_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "collision/base/numbers.h"
#include "leeway/collision/triangle_mesh.h"
#include "planner/base/arc_tangent.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using robots::Joint;
using robots::JointType;

/// A chain with every kind of joint that can be planned: revolute, continuous, prismatic, planar
/// and floating.
std::shared_ptr<const robots::Model> everyKind() {
  robots::RobotDescription robot;
  auto add = [&](const char* name, JointType type, int count) {
    Joint joint;
    joint.name = name;
    joint.type = type;
    joint.parent_link = static_cast<int>(robot.links.size()) - 1;
    joint.child_link = static_cast<int>(robot.links.size());
    joint.first_variable = static_cast<int>(robot.variables.size());
    joint.variable_count = count;
    const int index = static_cast<int>(robot.joints.size());
    for (int i = 0; i < count; ++i) {
      const bool bounded = type == JointType::kRevolute || type == JointType::kPrismatic;
      robot.variables.push_back({name + std::to_string(i), index, bounded ? -2 : -kInfinity,
                                 bounded ? 2 : kInfinity, kInfinity});
    }
    robot.joints.push_back(joint);
    robot.links.push_back({name, index, {}});
  };
  add("floating", JointType::kFloating, 7);
  add("planar", JointType::kPlanar, 3);
  add("revolute", JointType::kRevolute, 1);
  add("continuous", JointType::kContinuous, 1);
  add("prismatic", JointType::kPrismatic, 1);
  return std::make_shared<robots::Model>(std::move(robot));
}

ConfigurationSpace everyKindSpace() {
  std::vector<int> variables(13);
  for (int i = 0; i < 13; ++i) variables[static_cast<std::size_t>(i)] = i;
  return {everyKind(), variables};
}

/// Uniform in [-1, 1), equal with every C++ library.
double signedUnit(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1;
}

long double wide(double x) { return static_cast<long double>(x); }

using LongQuaternion = std::array<long double, 4>;

LongQuaternion product(const LongQuaternion& a, const LongQuaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
          a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2],
          a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0],
          a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

/// exp(axis * angle / 2) in long double, for the slow twin.
LongQuaternion turn(const std::array<long double, 3>& axis, long double angle) {
  const long double n = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const long double s = std::sin(angle / 2) / n;
  return {s * axis[0], s * axis[1], s * axis[2], std::cos(angle / 2)};
}

std::vector<double> randomPoint(std::mt19937_64& random) {
  std::vector<double> q(13);
  for (double& x : q) x = 2 * signedUnit(random);
  q[9] = 3.1 * signedUnit(random);
  q[11] = 9 * signedUnit(random);
  double n = std::sqrt(q[3] * q[3] + q[4] * q[4] + q[5] * q[5] + q[6] * q[6]);
  for (std::size_t i = 3; i < 7; ++i) q[i] /= n;
  return q;
}

TEST(ArcTangent, AgreesWithLongDouble) {
  std::mt19937_64 random(1);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double scale = std::pow(10.0, 10 * signedUnit(random) - 5);
    double y = std::abs(signedUnit(random)) * (i % 2 ? scale : 1),
           x = std::abs(signedUnit(random)) + 1e-300;
    if (i % 3 == 0) std::swap(x, y);
    const long double truth = std::atan2(wide(y), wide(x));
    if (truth < 1e-300L) continue;
    worst = std::max(
        worst, static_cast<double>(std::abs((wide(firstQuadrantAngle(y, x)) - truth) / truth)));
  }
  EXPECT_LT(worst, 4 * 0x1p-52);
  EXPECT_EQ(firstQuadrantAngle(0, 1), 0);
  EXPECT_EQ(firstQuadrantAngle(1, 0), 1.57079632679489661923);
  EXPECT_EQ(firstQuadrantAngle(1e-200, 1), 1e-200);
}

TEST(ConfigurationSpace, KindsFollowTheJoints) {
  const ConfigurationSpace space = everyKindSpace();
  using Kind = ConfigurationSpace::Kind;
  std::vector<std::pair<Kind, int>> parts;
  for (const auto& part : space.parts()) parts.emplace_back(part.kind, part.first);
  const std::vector<std::pair<Kind, int>> expected = {
      {Kind::kLine, 0},    {Kind::kLine, 1}, {Kind::kLine, 2},   {Kind::kRotation, 3},
      {Kind::kLine, 7},    {Kind::kLine, 8}, {Kind::kCircle, 9}, {Kind::kLine, 10},
      {Kind::kCircle, 11}, {Kind::kLine, 12}};
  EXPECT_EQ(parts, expected);
}

TEST(ConfigurationSpace, RefusesHalfAnOrientation) {
  EXPECT_THROW(ConfigurationSpace(everyKind(), {0, 1, 2, 3, 4}), std::invalid_argument);
  EXPECT_THROW(ConfigurationSpace(everyKind(), {4, 3, 5, 6}), std::invalid_argument);
  EXPECT_THROW(ConfigurationSpace(everyKind(), {13}), std::invalid_argument);
  EXPECT_NO_THROW(ConfigurationSpace(everyKind(), {10, 3, 4, 5, 6}));
}

/// A body with a known farthest point: `size` from the origin, half of it from the z axis.
std::vector<collision::Geometry> bodyOfReach(double size, int kind) {
  using collision::Pose;
  using collision::Shape;
  const double x = size / 2, z = size * std::sqrt(0.75);
  const Eigen::Vector3d tip(x, 0, z);
  const std::vector<Eigen::Vector3d> corners = {tip, {0, 0, 0}, {0, x / 2, 0}, {0, 0, -z / 2}};
  const collision::TriangleMesh::Triangle faces[] = {{0, 1, 2}, {0, 2, 3}};
  switch (kind) {
    case 0:
      return {{Shape::box({x / 2, 0, z / 2}), {Eigen::Matrix3d::Identity(), tip / 2}, "box"}};
    case 1:
      return {{Shape::convexHull(corners), Pose{}, "hull"}};
    case 2:
      return {{Shape::mesh(collision::TriangleMesh::make(corners, faces)), Pose{}, "mesh"}};
    default:  // the farthest of several shapes counts
      return {{Shape::sphere(x / 8), {Eigen::Matrix3d::Identity(), tip * (1 - 1.0 / 16)}, "ball"},
              {Shape::sphere(x / 4), Pose{}, "hub"},
              {Shape::sphere(0), {Eigen::Matrix3d::Identity(), tip}, "tip"}};
  }
}

TEST(ConfigurationSpace, TurnsWeighHalfOfWhatTheyMoveTheFarthestPointBy) {
  const Eigen::Vector3d far(3, 3, 3);
  for (const double size : {0.01, 1.0, 70.0})
    for (int kind = 0; kind < 4; ++kind) {
      const auto geometries = bodyOfReach(size, kind);
      const ConfigurationSpace flying(
          robots::freeBody("body", geometries, JointType::kFloating, -far, far),
          {0, 1, 2, 3, 4, 5, 6});
      EXPECT_NEAR(flying.parts()[3].weight, 0.5 * size, 1e-12 * size) << kind;
      EXPECT_EQ(flying.parts()[0].weight, 1);
      const ConfigurationSpace sliding(
          robots::freeBody("body", geometries, JointType::kPlanar, -far, far), {0, 1, 2});
      const double across = kind == 3 ? size / 2 * (1 - 1.0 / 16 + 1.0 / 8) : size / 2;
      EXPECT_NEAR(sliding.parts()[2].weight, 0.5 * across, 1e-12 * size) << kind;
      const std::vector<double> a = {0, 0, 0}, b = {3, 4, 1};
      EXPECT_NEAR(sliding.distance(a, b), std::hypot(5, sliding.parts()[2].weight), 1e-12);
    }
  // Bodies without a shape.
  const ConfigurationSpace bare = everyKindSpace();
  for (const auto& part : bare.parts()) EXPECT_EQ(part.weight, 1);
}

TEST(ConfigurationSpace, TurnsOfABaseWeighWhatItCarries) {
  robots::RobotDescription robot = *everyKind();
  robot.joints[1].axis = Eigen::Vector3d::UnitZ();
  robot.links[0].geometries = {{collision::Shape::sphere(9), {}, "above"}};
  robot.links[4].geometries = {
      {collision::Shape::sphere(0.5), {Eigen::Matrix3d::Identity(), {2.5, 0, 40}}, "carried"}};
  const ConfigurationSpace space(std::make_shared<robots::Model>(std::move(robot)), {7, 8, 9, 10});
  EXPECT_NEAR(space.parts()[2].weight, 1.5, 1e-12);
  EXPECT_EQ(space.parts()[3].weight, 1);
}

TEST(ConfigurationSpace, EndPointsToTheBit) {
  const ConfigurationSpace space = everyKindSpace();
  std::mt19937_64 random(2);
  std::vector<double> result(13);
  for (int i = 0; i < 1000; ++i) {
    const auto a = randomPoint(random), b = randomPoint(random);
    space.interpolate(a, b, 0, result);
    EXPECT_EQ(result, a);
    space.interpolate(a, b, 1, result);
    EXPECT_EQ(result, b);
  }
}

/// Turns from 1e-14 rad to just below pi about any axis: difference, distance and interpolated
/// orientations against long double.
TEST(ConfigurationSpace, RotationsAgreeWithLongDoubleAtEveryAngle) {
  const ConfigurationSpace space = everyKindSpace();
  std::mt19937_64 random(3);
  int tiny = 0;
  for (int i = 0; i < 20000; ++i) {
    auto a = randomPoint(random), b = a;
    const std::array<long double, 3> axis = {wide(signedUnit(random)), wide(signedUnit(random)),
                                             wide(signedUnit(random))};
    const double angle =
        i % 2 ? std::pow(10.0, -7 + 7 * signedUnit(random)) : 1.5707 * (1 + signedUnit(random));
    if (angle < 9e-5) ++tiny;
    const LongQuaternion qa = {wide(a[3]), wide(a[4]), wide(a[5]), wide(a[6])};
    const LongQuaternion qb = product(qa, turn(axis, wide(angle)));
    const double sign = random() % 2 ? 1 : -1;  // both signs are one orientation
    for (std::size_t k = 0; k < 4; ++k) b[3 + k] = sign * static_cast<double>(qb[k]);

    std::vector<double> dq(13), middle(13), again(13);
    space.difference(a, b, dq);
    // Rounding b to doubles moves the orientation by up to 4e-16 rad, the comparison's limit.
    EXPECT_NEAR(space.distance(a, b), angle, 1e-15 + 1e-15 * angle)
        << "angle " << angle << " case " << i;
    EXPECT_EQ(dq[6], 0);
    const double t = 0.5 + 0.5 * signedUnit(random);
    space.interpolate(a, b, t, middle);
    space.advance(a, dq, t, again);
    EXPECT_EQ(middle, again);
    const LongQuaternion expected = product(qa, turn(axis, wide(t) * wide(angle)));
    long double dot = 0;
    for (std::size_t k = 0; k < 4; ++k) dot += expected[k] * wide(middle[3 + k]);
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(middle[3 + k] * (dot < 0 ? -1 : 1), static_cast<double>(expected[k]), 2e-15)
          << "angle " << angle << " t " << t << " case " << i;
    EXPECT_EQ(space.distance(a, b), space.distance(b, a));
  }
  EXPECT_GT(tiny, 5000);  // guards: the range that OMPL treats as no turn is covered
}

TEST(ConfigurationSpace, TinyTurnsDoNotJump) {
  const ConfigurationSpace space = everyKindSpace();
  std::vector<double> a(13), b(13), q(13);
  a[6] = b[6] = 1;
  b[3] = 1e-6;  // a turn of 2e-6 rad
  for (int i = 1; i < 100; ++i) {
    space.interpolate(a, b, i / 100.0, q);
    EXPECT_NEAR(q[3], 1e-8 * i, 1e-18);
  }
  b[3] = 1e-200;  // its square underflows
  space.interpolate(a, b, 0.5, q);
  EXPECT_EQ(q[3], 0.5e-200);
  EXPECT_EQ(space.distance(a, a), 0);
}

TEST(ConfigurationSpace, HalfTurnIsDefinedAndStaysUnit) {
  const ConfigurationSpace space = everyKindSpace();
  std::vector<double> a(13), b(13), q(13);
  a[6] = 1;
  b[4] = 1;  // half a turn about y: dot product exactly zero
  EXPECT_NEAR(space.distance(a, b), 3.14159265358979323846, 1e-15);
  space.interpolate(a, b, 0.5, q);
  EXPECT_NEAR(q[4], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(q[6], std::sqrt(0.5), 1e-15);
}

TEST(ConfigurationSpace, CirclesGoTheShorterWayAndWrap) {
  const ConfigurationSpace space = everyKindSpace();
  std::mt19937_64 random(4);
  for (int i = 0; i < 2000; ++i) {
    auto a = randomPoint(random), b = a;
    b[11] = 9 * signedUnit(random);
    std::vector<double> dq(13), q(13);
    space.difference(a, b, dq);
    const long double two_pi = 2 * 3.141592653589793238462643383L;
    long double shortest = wide(b[11]) - wide(a[11]);
    while (shortest > two_pi / 2) shortest -= two_pi;
    while (shortest < -two_pi / 2) shortest += two_pi;
    EXPECT_NEAR(dq[11], static_cast<double>(shortest), 4e-15);
    space.interpolate(a, b, 0.25, q);
    EXPECT_GE(q[11], -3.14159265358979323846);
    EXPECT_LT(q[11], 3.14159265358979323846);
    EXPECT_NEAR(
        static_cast<double>(std::remainder(wide(q[11]) - wide(a[11]) - shortest / 4, two_pi)), 0,
        4e-15);
  }
}

TEST(ConfigurationSpace, LinesNeverLeaveTheirEnds) {
  const ConfigurationSpace space = everyKindSpace();
  std::mt19937_64 random(5);
  for (int i = 0; i < 20000; ++i) {
    auto a = randomPoint(random), b = randomPoint(random);
    std::vector<double> q(13);
    a[10] = 2;  // the limit itself
    b[10] = i % 2 ? 2 : b[10];
    space.interpolate(a, b, 1 - std::pow(2.0, -static_cast<double>(random() % 54)), q);
    EXPECT_TRUE(space.withinLimits(q));
  }
}

// Turns of small bodies weigh little in the distance.
TEST(ConfigurationSpace, TheGreatestChangeIsInRadiansAndMetres) {
  const ConfigurationSpace space(test::disc(), std::vector<int>{0, 1, 2});
  const std::vector<double> a{0, 0, 0}, turned{0.3, -0.4, 3}, moved{0.3, -0.4, 0.1};
  EXPECT_EQ(space.greatestChange(a, turned), 3);
  EXPECT_EQ(space.greatestChange(a, moved), 0.4);
  EXPECT_LT(space.distance(a, turned), 1);
}

TEST(ConfigurationSpace, LimitsHoldForBoundedNumbersOnly) {
  const ConfigurationSpace space = everyKindSpace();
  std::mt19937_64 random(6);
  const auto good = randomPoint(random);
  EXPECT_TRUE(space.withinLimits(good));
  const auto with = [&](std::size_t i, double value) {
    auto q = good;
    q[i] = value;
    EXPECT_EQ(space.brokenLimit(q).empty(), space.withinLimits(q)) << i << " " << value;
    return space.withinLimits(q);
  };
  EXPECT_TRUE(with(10, 2));
  EXPECT_FALSE(with(10, std::nextafter(2, 3)));
  EXPECT_FALSE(with(12, -2.1));
  EXPECT_TRUE(with(11, 100));
  EXPECT_TRUE(with(0, 1e6));
  for (std::size_t i = 0; i < 13; ++i) EXPECT_FALSE(with(i, std::nan(""))) << i;
  EXPECT_FALSE(with(11, kInfinity));
  EXPECT_FALSE(with(3, 5));  // not a unit quaternion
}

}  // namespace
}  // namespace leeway::planner
