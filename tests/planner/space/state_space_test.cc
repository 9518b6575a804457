#include <gtest/gtest.h>
#include <ompl/base/ProjectionEvaluator.h>
#include <ompl/base/ScopedState.h>

#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <thread>

#include "leeway/planner/ompl_state_space.h"
#include "planner/base/random.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

namespace ob = ompl::base;
constexpr double kPi = 3.14159265358979323846;

std::shared_ptr<OmplStateSpace> spaceOf(const std::shared_ptr<const robots::Model>& model,
                                        std::uint64_t seed = 1) {
  std::vector<int> variables;
  for (std::size_t i = 0; i < model->variables.size(); ++i)
    variables.push_back(static_cast<int>(i));
  auto space = std::make_shared<OmplStateSpace>(
      std::make_shared<const ConfigurationSpace>(model, variables), seed);
  space->setup();
  return space;
}

/// Owns one state.
struct Held {
  explicit Held(const OmplStateSpace& s) : space(s), state(s.allocState()) {}
  ~Held() { space.freeState(state); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  std::span<double> q() { return space.point(state); }
  void set(std::vector<double> values) { std::copy(values.begin(), values.end(), q().begin()); }
  const OmplStateSpace& space;
  ob::State* state;
};

TEST(OmplStateSpace, PassesOmplsSanityChecks) {
  for (const auto& model : {test::disc(), test::flyingBox()}) {
    const auto space = spaceOf(model);
    EXPECT_NO_THROW(space->sanityChecks()) << model->name;
  }
}

TEST(OmplStateSpace, DimensionExtentAndMeasureFollowTheMetric) {
  const auto planar = spaceOf(test::disc());
  EXPECT_EQ(planar->getDimension(), 3u);
  const double disc = planar->space().parts()[2].weight;
  EXPECT_NEAR(planar->getMaximumExtent(), std::hypot(4, 4, kPi * disc), 1e-12);
  EXPECT_NEAR(planar->getMeasure(), 16 * 2 * kPi * disc, 1e-9);
  const auto flying = spaceOf(test::flyingBox());
  EXPECT_EQ(flying->getDimension(), 6u);
  const double box = flying->space().parts()[3].weight;
  EXPECT_NEAR(flying->getMaximumExtent(), std::hypot(std::sqrt(12), kPi * box), 1e-12);
  EXPECT_NEAR(flying->getMeasure(), 8 * 8 * kPi * kPi * box * box * box, 1e-9);
}

TEST(OmplStateSpace, MeasureOfRotationsIsWhatDistancesSay) {
  // The share of random rotations within an angle of a given one is the ball's volume over the
  // total measure.
  Random random(7);
  const double angle = 0.8;
  // Volume in the angle metric: integral of 4 pi (2 sin(r / 2))^2 dr.
  const double ball = 8 * kPi * (angle - std::sin(angle));
  int hits = 0;
  const int count = 200000;
  for (int i = 0; i < count; ++i) {
    double q[4];
    random.quaternion(q);
    hits += 2 * std::acos(std::min(1.0, std::abs(q[3]))) < angle;
  }
  const double expected = ball / (8 * kPi * kPi) * count;
  EXPECT_GT(hits, 1000);
  EXPECT_NEAR(hits, expected, 5 * std::sqrt(expected));
}

TEST(OmplStateSpace, SmallRotationsAreNeitherEqualNorLost) {
  const auto space = spaceOf(test::flyingBox());
  const double weight = space->space().parts()[3].weight;
  Held a(*space), b(*space), c(*space);
  a.set({0, 0, 0, 0, 0, 0, 1});
  for (double angle = 1e-3; angle > 1e-150; angle /= 7) {
    b.set({0, 0, 0, std::sin(angle / 2), 0, 0, std::cos(angle / 2)});
    EXPECT_FALSE(space->equalStates(a.state, b.state)) << angle;
    EXPECT_NEAR(space->distance(a.state, b.state) / weight, angle, 1e-14 * angle);
    space->interpolate(a.state, b.state, 0.5, c.state);
    EXPECT_NEAR(space->distance(a.state, c.state) / weight, angle / 2, 1e-14 * angle);
  }
  b.set({0, 0, 0, 0, 0, 0, -1});
  EXPECT_TRUE(space->equalStates(a.state, b.state)) << "q and -q are one rotation";
}

TEST(OmplStateSpace, InterpolatesAndMeasuresAsTheConfigurationSpaceDoes) {
  for (const auto& model : {test::disc(), test::flyingBox()}) {
    const auto space = spaceOf(model);
    const auto sampler = space->allocStateSampler();
    Held a(*space), b(*space), c(*space);
    std::vector<double> expected(a.q().size());
    for (int i = 0; i < 1000; ++i) {
      sampler->sampleUniform(a.state);
      sampler->sampleUniform(b.state);
      const double t = i / 999.0;
      space->interpolate(a.state, b.state, t, c.state);
      space->space().interpolate(a.q(), b.q(), t, expected);
      EXPECT_EQ(std::memcmp(expected.data(), c.q().data(), expected.size() * 8), 0);
      EXPECT_EQ(space->distance(a.state, b.state), space->space().distance(a.q(), b.q()));
    }
  }
}

TEST(OmplStateSpace, SamplesKeepTheLimitsAndTheDistance) {
  for (const auto& model : {test::disc(), test::flyingBox()}) {
    const auto space = spaceOf(model);
    const auto sampler = space->allocStateSampler();
    Held center(*space), s(*space);
    for (int i = 0; i < 5000; ++i) {
      sampler->sampleUniform(center.state);
      EXPECT_TRUE(space->satisfiesBounds(center.state));
      const double distance = i % 2 == 0 ? 0.05 : 1.5;
      sampler->sampleUniformNear(s.state, center.state, distance);
      EXPECT_TRUE(space->satisfiesBounds(s.state));
      EXPECT_LE(space->distance(center.state, s.state),
                distance * std::sqrt(static_cast<double>(space->getDimension())) + 1e-9);
      sampler->sampleGaussian(s.state, center.state, 0.3);
      EXPECT_TRUE(space->satisfiesBounds(s.state));
    }
  }
}

TEST(OmplStateSpace, UniformSamplesFillEveryVariable) {
  const auto space = spaceOf(test::flyingBox());
  const auto sampler = space->allocStateSampler();
  Held s(*space);
  std::vector<std::map<int, int>> cells(7);
  const int count = 20000, bins = 10;
  for (int i = 0; i < count; ++i) {
    sampler->sampleUniform(s.state);
    for (std::size_t k = 0; k < 3; ++k) ++cells[k][static_cast<int>((s.q()[k] + 1) / 2 * bins)];
  }
  for (std::size_t k = 0; k < 3; ++k)
    for (int bin = 0; bin < bins; ++bin)
      EXPECT_NEAR(cells[k][bin], count / bins, 5 * std::sqrt(count / bins)) << k << ' ' << bin;
}

TEST(OmplStateSpace, GaussianSamplesHaveTheirDeviation) {
  Random random(3);
  double sum = 0, squares = 0;
  const int count = 100000;
  for (int i = 0; i < count; ++i) {
    const double x = random.gaussian();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / count, 0, 0.02);
  EXPECT_NEAR(squares / count, 1, 0.03);
}

TEST(OmplStateSpace, SamplersHaveTheSpacesSeedAndNoOther) {
  const auto draw = [](std::uint64_t seed, int sampler_index) {
    const auto space = spaceOf(test::flyingBox(), seed);
    ob::StateSamplerPtr sampler;
    for (int i = 0; i <= sampler_index; ++i) sampler = space->allocStateSampler();
    Held s(*space);
    sampler->sampleUniform(s.state);
    return std::vector<double>(s.q().begin(), s.q().end());
  };
  EXPECT_EQ(draw(5, 0), draw(5, 0));
  EXPECT_EQ(draw(5, 2), draw(5, 2));
  std::set<std::vector<double>> different;
  for (std::uint64_t seed = 0; seed < 5; ++seed)
    for (int k = 0; k < 5; ++k) different.insert(draw(seed, k));
  EXPECT_EQ(different.size(), 25u);
}

TEST(OmplStateSpace, SerialisesAddressesAndProjects) {
  const auto space = spaceOf(test::flyingBox());
  Held a(*space), b(*space);
  a.set({0.1, -0.2, 0.3, 0.5, 0.5, -0.5, 0.5});
  std::vector<char> bytes(space->getSerializationLength());
  space->serialize(bytes.data(), a.state);
  space->deserialize(b.state, bytes.data());
  EXPECT_TRUE(space->equalStates(a.state, b.state));
  std::vector<double> reals;
  space->copyToReals(reals, a.state);
  EXPECT_EQ(reals, std::vector<double>(a.q().begin(), a.q().end()));
  EXPECT_EQ(space->getValueAddressAtIndex(a.state, 7), nullptr);
  const ob::ProjectionEvaluatorPtr projection = space->getDefaultProjection();
  ASSERT_EQ(projection->getDimension(), 3u);
  Eigen::VectorXd p(3);
  projection->project(a.state, p);
  EXPECT_EQ(p, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_NEAR(projection->getCellSizes(0), 0.1, 1e-15);
}

TEST(OmplStateSpace, EnforcesBounds) {
  const auto space = spaceOf(test::flyingBox());
  Held a(*space);
  a.set({3, -3, 0.5, 0, 0, 0, 2});
  space->enforceBounds(a.state);
  EXPECT_EQ(std::vector<double>(a.q().begin(), a.q().end()),
            (std::vector<double>{1, -1, 0.5, 0, 0, 0, 1}));
  a.set({std::nan(""), 0, 0, 0, 0, 0, 1});
  EXPECT_FALSE(space->satisfiesBounds(a.state));
}

TEST(OmplStateSpace, RefusesJointsWithoutLimits) {
  const double inf = std::numeric_limits<double>::infinity();
  const auto model =
      robots::freeBody("body", {}, robots::JointType::kFloating, {-1, -1, -1}, {1, 1, inf});
  EXPECT_THROW(spaceOf(model), std::invalid_argument);
}

}  // namespace
}  // namespace leeway::planner
