#include "leeway/planner/guard.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/point_cloud.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/model.h"
#include "planner/base/random.h"
#include "tests/support/allocations.h"
#include "tests/support/build_paths.h"
#include "tests/support/dense_truth.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();
using Rows = std::vector<std::vector<double>>;

std::vector<double> flat(const Rows& rows) {
  std::vector<double> values;
  for (const std::vector<double>& row : rows) values.insert(values.end(), row.begin(), row.end());
  return values;
}

/// The slow twin: states of a motion by kinematics and distance queries.
class Truth {
 public:
  explicit Truth(const Problem& problem)
      : scene_(problem),
        workspace_(scene_.scene()),
        q_(scene_.model().variables.size()),
        X_WL_(scene_.model().links.size()) {}

  const ConfigurationSpace& space() const { return scene_.space(); }

  bool touches(std::span<const double> point) {
    scene_.expand(point, q_);
    robots::forwardKinematics(scene_.model(), q_, X_WL_);
    for (int b = 0; b < scene_.bodiesOfRobot(); ++b)
      if (const int link = scene_.bodyLink(b); link >= 0)
        workspace_.setPose(b, X_WL_[static_cast<std::size_t>(link)]);
    return collision::decide(scene_.scene(), workspace_).verdict == collision::Verdict::kNotFree;
  }

  /// Whether some state of the motion through the rows touches, every `step` of a period. `errors`:
  /// each state is off by random numbers of up to these.
  bool touches(std::span<const double> start, std::span<const double> rows, double step,
               std::span<const double> errors = {}) {
    const std::size_t n = start.size();
    std::vector<double> a(start.begin(), start.end()), b(n), point(n);
    for (std::size_t k = 0; k * n < rows.size(); ++k) {
      b.assign(rows.begin() + static_cast<std::ptrdiff_t>(k * n),
               rows.begin() + static_cast<std::ptrdiff_t>((k + 1) * n));
      for (double t = 0; t < 1 + step / 2; t += step) {
        space().alongLine(a, b, std::min(t, 1.0), point);
        for (std::size_t i = 0; i < errors.size(); ++i)
          point[i] += random_.uniform(-errors[i], errors[i]);
        if (touches(point)) return true;
      }
      a = b;
    }
    return false;
  }

 private:
  CompiledScene scene_;
  collision::Workspace workspace_;
  std::vector<double> q_;
  std::vector<robots::Pose> X_WL_;
  Random random_{9, 0};
};

/// Whether an answer keeps the limits from a velocity and acceleration on, with rest at its end;
/// both are set to those of the last row that passed.
void expectLimits(const Guard& guard, std::vector<double>& velocity,
                  std::vector<double>& acceleration) {
  const GuardAnswer& answer = guard.answer();
  const double T = guard.options().period;
  const std::size_t n = answer.start.size();
  const std::size_t rows = answer.motion.size() / n;
  std::vector<double> then_velocity = velocity, then_acceleration = acceleration;
  for (std::size_t i = 0; i < n; ++i) {
    double p = answer.start[i], v = velocity[i], a = acceleration[i];
    for (std::size_t k = 0; k < rows + 2; ++k) {
      const double next = k < rows ? answer.motion[k * n + i] : p;
      const double now = (next - p) / T, change = (now - v) / T;
      EXPECT_LE(std::abs(now), guard.options().limits.velocity[i] * (1 + 1e-5) + 1e-9);
      EXPECT_LE(std::abs(change), guard.options().limits.acceleration[i] * (1 + 1e-5) + 1e-9);
      EXPECT_LE(std::abs(change - a) / T, guard.options().limits.jerk[i] * (1 + 1e-5) + 1e-6);
      p = next;
      v = now;
      a = change;
      if (k + 1 == static_cast<std::size_t>(answer.passed)) {
        then_velocity[i] = v;
        then_acceleration[i] = a;
      }
    }
  }
  velocity = then_velocity;
  acceleration = then_acceleration;
}

/// Setpoints of a disc that goes on from x = -1 towards the wall at x = 0 at this speed [m/s],
/// after having sped up.
Rows towardsWall(double speed, double acceleration, double period, int count) {
  Rows rows;
  double x = -1, v = 0;
  for (int k = 0; k < count; ++k) {
    v = std::min(speed, v + acceleration * period);
    x += v * period;
    rows.push_back({x, -1, 0});
  }
  return rows;
}

TEST(Guard, PassesWhatHasRoomToStop) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 2}};
  Guard guard(problem);
  Truth truth(problem);
  const std::vector<double> chunk = flat(towardsWall(0.8, 2, 0.02, 60));
  const GuardAnswer& answer = guard.check({.setpoints = chunk});
  EXPECT_TRUE(answer.certified);
  EXPECT_FALSE(answer.goes_on);
  EXPECT_EQ(answer.reason, GuardReason::kNotFree);
  EXPECT_TRUE(answer.in_stop);
  EXPECT_EQ(answer.a, "disc");
  EXPECT_EQ(answer.b, "lower wall");
  // The disc meets the wall at x = -0.15, and stops from 0.8 m/s within 0.16 m.
  ASSERT_GT(answer.passed, 20);
  const double last = chunk[3 * (static_cast<std::size_t>(answer.passed) - 1)];
  EXPECT_GT(last, -0.34);
  EXPECT_LT(last, -0.30);
  EXPECT_FALSE(truth.touches(answer.start, answer.motion, 0.05));
  EXPECT_LT(answer.motion[answer.motion.size() - 3], -0.15);
  // Only a few edges have been asked for 60 setpoints.
  EXPECT_LT(answer.edges, 30u);
}

TEST(Guard, AFreeChunkCostsTwoEdges) {
  Guard guard(test::wallProblem());
  const GuardAnswer& answer = guard.check({.setpoints = flat(towardsWall(0.2, 2, 0.02, 50))});
  EXPECT_EQ(answer.passed, 50);
  EXPECT_EQ(answer.reason, GuardReason::kPassed);
  EXPECT_LE(answer.edges, 4u);
  EXPECT_GT(answer.work, 0);
}

TEST(Guard, SaysWhichLimitAChunkBreaks) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}, {"disc/y", 1}};
  problem.execution.accelerations = {{"disc/x", 2}, {"disc/y", 2}};
  problem.execution.jerks = {{"disc/y", 50}};
  const auto ask = [&](const Rows& rows) {
    Guard guard(problem);
    return guard.check({.setpoints = flat(rows)});
  };
  GuardAnswer answer = ask({{-1, -1, 0}, {-1 + 0.03, -1, 0}});
  EXPECT_EQ(answer.reason, GuardReason::kLimit);
  EXPECT_EQ(answer.passed, 1);
  EXPECT_EQ(answer.limit, MotionLimit::kVelocity);
  EXPECT_EQ(answer.variable, 0);
  EXPECT_NEAR(answer.value, 1.5, 1e-9);
  EXPECT_EQ(answer.allowed, 1);
  answer = ask({{-1 - 0.002, -1, 0}});
  EXPECT_EQ(answer.limit, MotionLimit::kAcceleration);
  EXPECT_NEAR(answer.value, -5, 1e-9);
  EXPECT_EQ(answer.allowed, -2);
  EXPECT_TRUE(answer.certified);
  EXPECT_TRUE(answer.motion.empty());
  answer = ask({{-1, -1 + 0.0006, 0}});
  EXPECT_EQ(answer.limit, MotionLimit::kJerk);
  EXPECT_EQ(answer.variable, 1);
  Guard guard(problem);
  const std::vector<double> at_edge = {-1.9999, -1, 0}, beyond = {-2.0001, -1, 0};
  answer = guard.check({.setpoints = beyond, .position = at_edge});
  EXPECT_EQ(answer.limit, MotionLimit::kPosition);
  EXPECT_EQ(answer.allowed, -2);
  // A stop that leaves the limits does not pass, either.
  Guard other(problem);
  const std::vector<double> fast = {-0.5, 0, 0}, place = {-1.98, -1, 0}, next = {-1.99, -1, 0};
  answer = other.check({.setpoints = next, .position = place, .velocity = fast});
  EXPECT_EQ(answer.passed, 0);
  EXPECT_TRUE(answer.in_stop);
  EXPECT_EQ(answer.limit, MotionLimit::kPosition);
  EXPECT_FALSE(answer.certified);
}

/// Chunks that go to a random place, with noise, within limits.
class Policy {
 public:
  Policy(const Guard& guard, std::uint64_t seed, double noise)
      : options_(guard.options()),
        space_(guard.scene()->space()),
        random_(seed, 0),
        noise_(noise) {}

  /// `elsewhere`: to another place than before.
  std::vector<double> chunk(std::span<const double> start, std::span<const double> velocity,
                            int count, bool elsewhere = false) {
    const std::size_t n = start.size();
    if (target_.empty() || elsewhere) {
      target_.resize(n);
      for (std::size_t i = 0; i < n; ++i) {
        const double low = std::max(space_.lower(static_cast<int>(i)), -3.0);
        const double high = std::min(space_.upper(static_cast<int>(i)), 3.0);
        target_[i] = random_.uniform(low, high);
      }
    }
    std::vector<double> p(start.begin(), start.end()), v(velocity.begin(), velocity.end()), rows;
    for (int k = 0; k < count; ++k)
      for (std::size_t i = 0; i < n; ++i) {
        const double most = options_.limits.acceleration[i] * options_.period;
        const double wanted =
            std::clamp(2 * (target_[i] - p[i]) + random_.uniform(-noise_, noise_),
                       -0.9 * options_.limits.velocity[i], 0.9 * options_.limits.velocity[i]);
        v[i] += std::clamp(wanted - v[i], -most, most);
        p[i] += v[i] * options_.period;
        rows.push_back(p[i]);
      }
    return rows;
  }

 private:
  const GuardOptions& options_;
  const ConfigurationSpace& space_;
  Random random_;
  double noise_;
  std::vector<double> target_;
};

struct Executed {
  int chunks = 0, whole = 0, none = 0, touched = 0, edges = 0;
};

/// Runs a noisy policy behind a guard, and looks at all that it lets the robot do, and would let it
/// do if the next call never came.
Executed execute(const Problem& problem, const GuardOptions& options, std::uint64_t seed,
                 int chunks, double step) {
  Guard guard(problem, options);
  Truth truth(problem);
  Policy policy(guard, seed, 0.3);
  std::vector<double> place = startPoint(problem), velocity(place.size()), acceleration(velocity);
  Random random(seed, 7);
  Executed done;
  bool blocked = false;
  for (int c = 0; c < chunks; ++c) {
    const int count = 1 + static_cast<int>(random.uniform(0, 30));
    const std::vector<double> chunk = policy.chunk(place, velocity, count, blocked || c % 8 == 0);
    const GuardAnswer& answer = guard.check({.setpoints = chunk});
    EXPECT_TRUE(answer.certified) << c;
    EXPECT_LE(answer.passed, count);
    EXPECT_TRUE(std::equal(answer.start.begin(), answer.start.end(), place.begin())) << c;
    EXPECT_TRUE(std::equal(
        chunk.begin(),
        chunk.begin() +
            static_cast<std::ptrdiff_t>(static_cast<std::size_t>(answer.passed) * place.size()),
        answer.motion.begin()));
    EXPECT_EQ(answer.passed == count, answer.reason == GuardReason::kPassed);
    ++done.chunks;
    blocked = answer.passed < count;
    done.whole += answer.passed == count ? 1 : 0;
    done.none += answer.passed == 0 ? 1 : 0;
    done.touched += truth.touches(answer.start, answer.motion, step, options.joint_errors) ? 1 : 0;
    done.edges += static_cast<int>(answer.edges);
    expectLimits(guard, velocity, acceleration);
    if (testing::Test::HasFailure()) return done;
    // The robot goes through what passed; where nothing did, one period of the stop.
    const std::size_t n = place.size(), rows = answer.motion.size() / n;
    const std::size_t go = std::min(rows, static_cast<std::size_t>(std::max(1, answer.passed)));
    const std::vector<double> before = place;
    if (go > 0) {
      const std::vector<double> way(answer.motion.begin(), answer.motion.end());
      place.assign(way.begin() + static_cast<std::ptrdiff_t>((go - 1) * n),
                   way.begin() + static_cast<std::ptrdiff_t>(go * n));
      if (answer.passed == 0)
        for (std::size_t i = 0; i < n; ++i) {
          const double v = (place[i] - answer.start[i]) / options.period;
          acceleration[i] = (v - velocity[i]) / options.period;
          velocity[i] = v;
        }
    } else {
      for (std::size_t i = 0; i < n; ++i) {
        acceleration[i] = 0;
        velocity[i] = 0;
      }
    }
  }
  return done;
}

class ShippedProblems : public testing::TestWithParam<const char*> {};

TEST_P(ShippedProblems, NothingTouchesBehindAGuard) {
  const Problem problem =
      loadProblem(leeway::sourceFolder() + "/problems/" + std::string(GetParam()));
  const Executed done = execute(problem, {}, 3, 40, 0.05);
  EXPECT_EQ(done.touched, 0);
  EXPECT_GT(done.whole, 0);
  EXPECT_LT(done.whole, done.chunks);
  RecordProperty("whole", done.whole);
}

TEST_P(ShippedProblems, NorWithTrackingErrors) {
  const Problem problem =
      loadProblem(leeway::sourceFolder() + "/problems/" + std::string(GetParam()));
  GuardOptions options;
  options.joint_errors.assign(problem.robot.variables.size(), 0.0005);
  const Executed done = execute(problem, options, 5, 25, 0.1);
  EXPECT_EQ(done.touched, 0);
}

TEST_P(ShippedProblems, NorWithLimitsOnJerk) {
  Problem problem = loadProblem(leeway::sourceFolder() + "/problems/" + std::string(GetParam()));
  GuardOptions options;
  options.limits = motionLimits(problem);
  for (std::size_t i = 0; i < options.limits.velocity.size(); ++i)
    options.limits.jerk[i] = 2.2 * options.limits.acceleration[i] / options.period;
  const Executed done = execute(problem, options, 4, 25, 0.1);
  EXPECT_EQ(done.touched, 0);
  EXPECT_GT(done.whole, 0);
}

/// The value or a derivative of a polynomial, by powers.
double valueOf(std::span<const double> coefficients, int order, double t) {
  double sum = 0;
  for (std::size_t k = static_cast<std::size_t>(order); k < coefficients.size(); ++k) {
    double term = coefficients[k] * std::pow(t, static_cast<double>(k) - order);
    for (int i = 0; i < order; ++i) term *= static_cast<double>(k) - i;
    sum += term;
  }
  return sum;
}

/// A motion of polynomials of degree 5 from a state to rest at a place [all in one vector].
std::vector<double> quintics(std::span<const double> p, std::span<const double> v,
                             std::span<const double> a, std::span<const double> to, double time) {
  std::vector<double> all;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double T = time, d = to[i] - p[i];
    all.insert(all.end(),
               {p[i], v[i], a[i] / 2, (20 * d - 12 * v[i] * T - 3 * a[i] * T * T) / (2 * T * T * T),
                (-30 * d + 16 * v[i] * T + 3 * a[i] * T * T) / (2 * std::pow(T, 4)),
                (12 * d - 6 * v[i] * T - a[i] * T * T) / (2 * std::pow(T, 5))});
  }
  return all;
}

/// Runs a policy of polynomials behind a guard, with calls in the middle of periods, too.
Executed executePolynomials(const Problem& problem, const GuardOptions& options, std::uint64_t seed,
                            int chunks) {
  Guard guard(problem, options);
  Truth truth(problem);
  Random random(seed, 3);
  const double T = guard.options().period;
  const MotionLimits& limits = guard.options().limits;
  std::vector<double> p = startPoint(problem), v(p.size()), a(p.size());
  const std::size_t n = p.size();
  std::vector<double> point(n), to(n);
  double time = 0;
  Executed done;
  for (int c = 0; c < chunks; ++c) {
    for (std::size_t i = 0; i < n; ++i) {
      const double low = std::max(truth.space().lower(static_cast<int>(i)), p[i] - 0.4);
      const double high = std::min(truth.space().upper(static_cast<int>(i)), p[i] + 0.4);
      to[i] = random.uniform(low, high);
    }
    const int count = 10 + static_cast<int>(random.uniform(0, 50));
    const std::vector<double> chunk = quintics(p, v, a, to, count * T);
    const GuardAnswer& answer =
        guard.check({.polynomials = chunk, .duration = count * T, .time = time});
    EXPECT_NE(answer.reason, GuardReason::kInvalid) << c;
    EXPECT_EQ(answer.on_polynomials, answer.goes_on ? answer.on_polynomials : answer.passed);
    ++done.chunks;
    done.whole += answer.passed == count ? 1 : 0;
    done.none += answer.passed == 0 ? 1 : 0;
    const auto of = [&](std::size_t i) { return std::span<const double>(chunk).subspan(6 * i, 6); };
    for (int k = 0; k < answer.passed * 20; ++k) {
      const double t = k * T / 20;
      for (std::size_t i = 0; i < n; ++i) {
        point[i] = valueOf(of(i), 0, t);
        EXPECT_LE(std::abs(valueOf(of(i), 1, t)), limits.velocity[i] * (1 + 1e-5));
        EXPECT_LE(std::abs(valueOf(of(i), 2, t)), limits.acceleration[i] * (1 + 1e-5));
        EXPECT_LE(std::abs(valueOf(of(i), 3, t)), limits.jerk[i] * (1 + 1e-5));
        EXPECT_GE(point[i], truth.space().lower(static_cast<int>(i)) - 1e-9);
        EXPECT_LE(point[i], truth.space().upper(static_cast<int>(i)) + 1e-9);
      }
      done.touched += k % 4 == 0 && truth.touches(point) ? 1 : 0;
    }
    const auto passed = static_cast<std::size_t>(answer.passed);
    for (std::size_t k = 1; k <= passed; ++k)
      for (std::size_t i = 0; i < n; ++i)
        EXPECT_NEAR(answer.motion[(k - 1) * n + i], valueOf(of(i), 0, static_cast<double>(k) * T),
                    1e-9);
    const std::size_t rows = answer.motion.size() / n;
    const auto rowOf = [&](std::size_t k) {
      return k == 0 ? answer.start : answer.motion.subspan((k - 1) * n, n);
    };
    done.touched += truth.touches(rowOf(passed), answer.motion.subspan(passed * n), 0.1) ? 1 : 0;
    if (passed > 0) {  // the stop keeps limits from the polynomials' last velocity on
      const double s = static_cast<double>(passed) * T;
      for (std::size_t i = 0; i < n; ++i) {
        double speed = valueOf(of(i), 1, s);
        for (std::size_t k = passed + 1; k <= rows + 1; ++k) {
          const double now = k <= rows ? (rowOf(k)[i] - rowOf(k - 1)[i]) / T : 0;
          EXPECT_LE(std::abs(now - speed) / T, limits.acceleration[i] * (1 + 1e-5) + 1e-9);
          speed = now;
        }
      }
    }
    if (testing::Test::HasFailure()) return done;
    if (passed > 1) {  // the next polynomials begin on these
      const double s = (static_cast<double>(passed) - (c % 2 == 0 ? 0.5 : 0)) * T;
      time = answer.time + s;
      for (std::size_t i = 0; i < n; ++i) {
        p[i] = valueOf(of(i), 0, s);
        v[i] = valueOf(of(i), 1, s);
        a[i] = valueOf(of(i), 2, s);
      }
    } else {  // the robot stops
      time = answer.time + (static_cast<double>(rows) + 2) * T;
      p.assign(rowOf(rows).begin(), rowOf(rows).end());
      v.assign(n, 0);
      a.assign(n, 0);
    }
  }
  return done;
}

TEST_P(ShippedProblems, NothingTouchesOnPolynomialsThatPass) {
  Problem problem = loadProblem(leeway::sourceFolder() + "/problems/" + std::string(GetParam()));
  const Executed done = executePolynomials(problem, {}, 11, 40);
  EXPECT_EQ(done.touched, 0);
  EXPECT_GT(done.whole, 0);
  EXPECT_LT(done.none, done.chunks);
  RecordProperty("whole", done.whole);
  RecordProperty("none", done.none);
}

/// The disc of the wall problem on one polynomial in x, from x = -1, y = -1.
std::vector<double> alongX(const std::vector<double>& terms) {
  std::vector<double> all(3 * terms.size());
  std::copy(terms.begin(), terms.end(), all.begin());
  all[terms.size()] = -1;
  return all;
}

TEST(Guard, PolynomialsPassAsFarAsThereIsRoomToStop) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 2}};
  Guard guard(problem);
  // Speeds up as the setpoints of PassesWhatHasRoomToStop: x = -1 + t^2, to 0.8 m/s.
  const std::vector<double> faster = alongX({-1, 0, 1});
  const GuardAnswer& first = guard.check({.polynomials = faster, .duration = 0.4});
  ASSERT_EQ(first.passed, 20);
  EXPECT_EQ(first.on_polynomials, 20);
  const std::vector<double> on = alongX({-0.84, 0.8});
  const GuardAnswer& answer = guard.check({.polynomials = on, .duration = 1.2});
  EXPECT_TRUE(answer.certified);
  EXPECT_EQ(answer.reason, GuardReason::kNotFree);
  EXPECT_TRUE(answer.in_stop);
  EXPECT_EQ(answer.b, "lower wall");
  const double last = answer.motion[3 * (static_cast<std::size_t>(answer.passed) - 1)];
  EXPECT_GT(last, -0.34);
  EXPECT_LT(last, -0.30);
  // A later call finds the robot on the polynomial.
  const GuardAnswer& bad =
      guard.check({.setpoints = std::vector<double>{kNan}, .time = answer.time + 5 * 0.02});
  EXPECT_EQ(bad.reason, GuardReason::kInvalid);
  EXPECT_NEAR(bad.start[0], -0.84 + 0.8 * 0.1, 1e-12);
  EXPECT_TRUE(bad.certified);
}

TEST(Guard, WhatIsLeftOfPolynomialsIsTold) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 2}};
  GuardOptions options;
  Guard guard(problem, options);
  const std::vector<double> there = alongX({-1, 0, 1, -1. / 3});
  EXPECT_EQ(guard.check({.polynomials = there, .duration = 0.8}).passed, 40);
  options.work = 1;  // nothing is proven
  Guard poor(problem, options);
  const GuardAnswer& none = poor.check({.polynomials = there, .duration = 0.8});
  EXPECT_EQ(none.passed, 0);
  EXPECT_EQ(none.reason, GuardReason::kWork);
  EXPECT_EQ(none.on_polynomials, 0);
  const GuardAnswer& late = guard.check({.time = 30 * 0.02});
  EXPECT_NEAR(late.start[0], valueOf(std::span(there).first(4), 0, 0.6), 1e-12);
  EXPECT_EQ(late.on_polynomials, 0);  // it stops
  // Polynomials that turn aside 0.3 mm before the wall, which a stop along their velocity does not.
  problem.execution.velocities = {{"disc/x", 1}, {"disc/y", 1}};
  problem.execution.accelerations = {{"disc/x", 2}, {"disc/y", 2}};
  options.work = GuardOptions().work;
  Guard near(problem, options);
  const std::vector<double> start = {-0.99297, -0.5, 0};
  const std::vector<double> faster = {-0.99297, 0, 1, 0, -0.5, 0, -1, 0, 0, 0, 0, 0};
  const std::vector<double> on = {-0.83297, 0.8, -0.66, -0.8, 0, 0};
  const std::vector<double> aside = {-0.57697, 0.8, 0, -1 / 2.4, -0.916, -0.8, 0, 0, 0, 0, 0, 0};
  const auto x = [&](double t) { return valueOf(std::span(aside).first(4), 0, t); };
  ASSERT_EQ(near.check({.polynomials = faster, .duration = 0.4, .position = start}).passed, 20);
  ASSERT_EQ(near.check({.polynomials = on, .duration = 0.32}).passed, 16);
  ASSERT_EQ(near.check({.polynomials = aside, .duration = 0.8}).passed, 40);
  const double begin = near.answer().time;
  const GuardAnswer& left = near.check({.time = begin + 37 * 0.02});
  EXPECT_TRUE(left.goes_on);
  EXPECT_TRUE(left.certified);
  EXPECT_EQ(left.on_polynomials, 3);
  EXPECT_NEAR(left.start[0], x(0.74), 1e-12);
  EXPECT_NEAR(left.motion[6], x(0.8), 1e-12);
  // Between two periods it goes on from the one before.
  const GuardAnswer& later = near.check({.time = begin + 38.5 * 0.02});
  EXPECT_TRUE(later.goes_on);
  EXPECT_EQ(later.on_polynomials, 2);
  EXPECT_NEAR(later.start[0], x(0.76), 1e-12);
  const GuardAnswer& end = near.check({.time = begin + 41 * 0.02});
  EXPECT_TRUE(end.certified);
  EXPECT_EQ(end.on_polynomials, 0);
}

TEST(Guard, PolynomialsKeepTheLimitsAtEveryTime) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}, {"disc/y", 1}};
  problem.execution.accelerations = {{"disc/x", 2}, {"disc/y", 2}};
  problem.execution.jerks = {{"disc/y", 50}};
  const auto ask = [&](const std::vector<double>& terms, double duration) {
    Guard guard(problem);
    return guard.check({.polynomials = alongX(terms), .duration = duration});
  };
  // x = -1 - c (t^2 / 2 - t^3 / 3): its speed has its peak c / 4 at t = 1/2.
  const auto bump = [](double c) { return std::vector<double>{-1, 0, -c / 2, c / 3}; };
  EXPECT_EQ(ask(bump(2), 1).passed, 50);  // starts with all of the acceleration
  GuardAnswer answer = ask(bump(2.001), 1);
  EXPECT_EQ(answer.passed, 0);
  EXPECT_EQ(answer.limit, MotionLimit::kAcceleration);
  EXPECT_EQ(answer.allowed, -2);
  problem.execution.velocities = {{"disc/x", 0.25}, {"disc/y", 1}};
  EXPECT_EQ(ask(bump(1), 1).passed, 50);  // the limit is touched at one time
  answer = ask(bump(1.001), 1);
  EXPECT_EQ(answer.reason, GuardReason::kLimit);
  EXPECT_EQ(answer.limit, MotionLimit::kVelocity);
  EXPECT_EQ(answer.variable, 0);
  EXPECT_EQ(answer.allowed, -0.25);
  EXPECT_LT(answer.value, -0.25);
  EXPECT_GE(answer.passed, 23);  // it is reached at 0.484 s
  EXPECT_LE(answer.passed, 24);
  // A limit on the position that is left between two whole periods, and regained at the next.
  problem.execution.velocities = {{"disc/x", 1}, {"disc/y", 1}};
  const std::vector<double> edge = {-1.9995, -1, 0}, slow = {-0.1, 0, 0};
  Guard guard(problem);
  answer = guard.check({.polynomials = alongX({-1.9995, -0.1, 1}),
                        .duration = 0.1,
                        .position = edge,
                        .velocity = slow});
  EXPECT_EQ(answer.passed, 0);
  EXPECT_EQ(answer.limit, MotionLimit::kPosition);
  EXPECT_EQ(answer.allowed, -2);
  // Where they begin, acceleration is the change of velocity over a period.
  EXPECT_EQ(ask({-1, -0.04}, 0.1).passed, 5);
  answer = ask({-1, -0.05}, 0.1);
  EXPECT_EQ(answer.limit, MotionLimit::kAcceleration);
  EXPECT_NEAR(answer.value, -2.5, 1e-9);
}

TEST(Guard, ARobotAtRestIsWhereItIsAtAnyTime) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 2}};
  for (const double periods : {0.5, 1.0, 1.5}) {
    Guard guard(problem);
    const GuardAnswer& first = guard.check({.time = periods * 0.02});  // without polynomials
    EXPECT_EQ(first.start[0], -1);
    EXPECT_EQ(first.start[1], -1);
  }
  // From rest to rest: x = -1 + (3 s^2 - 2 s^3) / 20 with s = t / 0.6; then within a period.
  for (const double periods : {0.5, 0.95, 1.0, 3.3}) {
    Guard guard(problem);
    const double T = 0.6;
    const std::vector<double> there = alongX({-1, 0, 0.15 / (T * T), -0.1 / (T * T * T)});
    ASSERT_EQ(guard.check({.polynomials = there, .duration = T}).passed, 30);
    const double end = guard.answer().motion[guard.answer().motion.size() - 3];
    EXPECT_NEAR(end, -0.95, 1e-6);
    EXPECT_NEAR(guard.check({.time = T + periods * 0.02}).start[0], -0.95, 1e-6) << periods;
  }
}

TEST(Guard, PolynomialsOfOnePeriodDoNotAddUpTheirJumps) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 2}};
  // Each begins 20 us after the last one, 0.04 m/s faster: what one period allows.
  Guard guard(problem);
  double x = -1;
  for (int k = 1; k <= 5; ++k) {
    const double v = 0.04 * k;
    const GuardAnswer& answer =
        guard.check({.polynomials = alongX({x, v}), .duration = 0.1, .time = (k - 1) * 2e-5});
    EXPECT_EQ(answer.passed, k == 1 ? 5 : 0) << k;
    if (k == 1) {
      x += v * 2e-5;
      continue;
    }
    EXPECT_EQ(answer.limit, MotionLimit::kAcceleration);
    break;
  }
  // A setpoint that follows within the period does not pass, either.
  Guard other(problem);
  other.check({.polynomials = alongX({-1, 0.04}), .duration = 0.1});
  const GuardAnswer& mixed =
      other.check({.setpoints = std::vector<double>{-1 + 0.08 * 0.02, -1, 0}, .time = 2e-5});
  EXPECT_EQ(mixed.passed, 0);
  EXPECT_EQ(mixed.limit, MotionLimit::kAcceleration);
  // A limit on jerk holds for the jump of the velocity where polynomials begin.
  problem.execution.jerks = {{"disc/x", 10}};
  Guard smooth(problem);
  const GuardAnswer& jump = smooth.check({.polynomials = alongX({-1, 0.04}), .duration = 0.1});
  EXPECT_EQ(jump.passed, 0);
  EXPECT_EQ(jump.limit, MotionLimit::kJerk);
  EXPECT_NEAR(jump.value, 100, 1e-6);
  EXPECT_EQ(smooth.check({.polynomials = alongX({-1, 0, 0.05, 1}), .duration = 0.1}).passed, 5);
}

TEST(Guard, PolynomialsThatMakeNoSenseStopTheRobot) {
  const Problem problem = test::wallProblem();
  const std::vector<double> good = alongX({-1, 0, 0.1}), setpoints = {-1, -1, 0};
  const std::vector<double> elsewhere = alongX({-0.999, 0, 0.1}), nan = alongX({-1, kNan});
  const std::vector<double> odd(4, 0), many = alongX({-1, 0, 0, 0, 0, 0, 0, 0, 0});
  const GuardRequest requests[] = {{.polynomials = good},
                                   {.duration = 0.1},
                                   {.polynomials = good, .duration = -0.1},
                                   {.polynomials = good, .duration = kNan},
                                   {.polynomials = good, .duration = 0.11},
                                   {.polynomials = good, .duration = 65 * 0.02},
                                   {.polynomials = good, .duration = kInfinite},
                                   {.polynomials = good, .duration = 0.001},
                                   {.setpoints = setpoints, .polynomials = good, .duration = 0.1},
                                   {.polynomials = elsewhere, .duration = 0.1},
                                   {.polynomials = nan, .duration = 0.1},
                                   {.polynomials = odd, .duration = 0.1},
                                   {.polynomials = many, .duration = 0.1}};
  int i = 0;
  for (const GuardRequest& request : requests) {
    Guard guard(problem);
    const GuardAnswer& answer = guard.check(request);
    EXPECT_EQ(answer.reason, GuardReason::kInvalid) << i;
    EXPECT_EQ(answer.passed, 0) << i;
    EXPECT_TRUE(answer.certified) << i;
    EXPECT_EQ(guard.check({.polynomials = good, .duration = 0.1}).passed, 5) << i++;
  }
}

TEST(Guard, PolynomialsAllocateNothing) {
  const Problem problem = loadProblem(leeway::sourceFolder() + "/problems/shelf/reach.yaml");
  Guard guard(problem);
  const std::vector<double> start = startPoint(problem), rest(start.size());
  std::vector<double> to = start;
  for (double& q : to) q += 0.05;
  const std::vector<double> chunk = quintics(start, rest, rest, to, 1);
  const std::size_t before = collision::testing::allocationCount();
  guard.check({.polynomials = chunk, .duration = 1});
  guard.check({.time = 0.51});
  guard.check({.polynomials = chunk, .duration = 1});
  EXPECT_EQ(collision::testing::allocationCount(), before);
}

INSTANTIATE_TEST_SUITE_P(Guard, ShippedProblems,
                         testing::Values("shelf/reach.yaml", "dual_arm/swap.yaml", "bin/pick.yaml",
                                         "snake/clutter.yaml", "table/posts.yaml",
                                         "mesh/tote.yaml"),
                         [](const auto& file) {
                           const std::string name = file.param;
                           return name.substr(0, name.find('/'));
                         });

TEST(Guard, WhenNothingPassesItStopsOnTheWayThatIsProven) {
  Problem problem = test::wallProblem();
  Guard guard(problem);
  const Rows rows = towardsWall(0.3, 2, 0.02, 20);
  ASSERT_EQ(guard.check({.setpoints = flat(rows)}).passed, 20);
  // A jump of half a metre does not pass: the robot brakes from where it is.
  const GuardAnswer& answer = guard.check({.setpoints = std::vector<double>{0, -1, 0}});
  EXPECT_EQ(answer.passed, 0);
  EXPECT_TRUE(answer.certified);
  EXPECT_FALSE(answer.goes_on);
  EXPECT_EQ(answer.reason, GuardReason::kLimit);
  EXPECT_EQ(answer.start[0], rows.back()[0]);
  ASSERT_GT(answer.motion.size(), 3u);
  EXPECT_GT(answer.motion[0], answer.start[0]);
}

TEST(Guard, WithoutWorkThereIsTheStopOfTheLastAnswer) {
  Problem problem = test::wallProblem();
  GuardOptions options;
  options.work = 1;  // one edge
  Guard guard(problem, options);
  const GuardAnswer& first = guard.check({.setpoints = flat(towardsWall(0.3, 2, 0.02, 20))});
  EXPECT_EQ(first.passed, 0);
  EXPECT_EQ(first.reason, GuardReason::kWork);
  EXPECT_FALSE(first.certified);           // nothing has been proven yet
  EXPECT_TRUE(guard.check({}).certified);  // standing is one edge
  const GuardAnswer& later = guard.check({.setpoints = flat(towardsWall(0.3, 2, 0.02, 20))});
  EXPECT_EQ(later.reason, GuardReason::kWork);
  EXPECT_TRUE(later.certified);
  EXPECT_TRUE(later.goes_on);
  EXPECT_TRUE(later.motion.empty());
}

TEST(Guard, AnEmptyChunkStops) {
  Guard guard(test::wallProblem());
  guard.check({.setpoints = flat(towardsWall(0.3, 2, 0.02, 20))});
  const GuardAnswer& answer = guard.check({});
  EXPECT_EQ(answer.reason, GuardReason::kPassed);
  EXPECT_TRUE(answer.certified);
  EXPECT_GT(answer.motion.size(), 0u);
}

TEST(Guard, ALateCallFindsTheRobotOnItsStop) {
  Guard guard(test::wallProblem());
  const Rows rows = towardsWall(0.3, 2, 0.02, 20);
  const GuardAnswer& first = guard.check({.setpoints = flat(rows)});
  const std::vector<double> motion(first.motion.begin(), first.motion.end());
  const double T = 0.02, begin = first.time;
  // On a row of the stop, between two rows, and after its end.
  const GuardAnswer& on_row = guard.check({.time = begin + 22 * T});
  EXPECT_NEAR(on_row.start[0], motion[3 * 21], 1e-12);
  EXPECT_TRUE(on_row.certified);
  const std::vector<double> left(on_row.motion.begin(), on_row.motion.end());
  const GuardAnswer& between = guard.check({.time = begin + 23.5 * T});
  EXPECT_NEAR(between.start[0], (left[0] + left[3]) / 2, 1e-12);
  const GuardAnswer& after = guard.check({.time = begin + 1000 * T});
  EXPECT_TRUE(after.motion.empty());
  EXPECT_TRUE(after.certified);
  EXPECT_NEAR(after.time, begin + 1000 * T, 1e-12);
}

TEST(Guard, SecondsSince1970AreAsGoodAsAnyTime) {
  const Problem problem = test::wallProblem();
  for (const double T : {0.02, 0.001}) {
    const Rows rows = towardsWall(0.3, 0.5, T, 60);
    for (const double begin : {0.0, 1.764e9 + 0.3}) {
      GuardOptions options;
      options.period = T;
      Guard guard(problem, options);
      for (int k = 0; k + 10 <= 60; ++k) {
        const Rows chunk(rows.begin() + k, rows.begin() + k + 10);
        const GuardAnswer& answer = guard.check({.setpoints = flat(chunk), .time = begin + k * T});
        EXPECT_EQ(answer.passed, 10) << T << " " << begin << " " << k << toString(answer.reason);
        EXPECT_TRUE(answer.certified);
      }
    }
  }
}

TEST(Guard, BadRequestsStopTheRobot) {
  Problem problem = test::wallProblem();
  const std::vector<double> good = flat(towardsWall(0.3, 2, 0.02, 3));
  const std::vector<double> nan_setpoint = {-1, kNan, 0}, short_row = {-1, -1};
  const std::vector<double> many(3 * 65, 0.0), nan_state = {kNan, 0, 0}, short_state = {0};
  const GuardRequest requests[] = {{.setpoints = nan_setpoint},
                                   {.setpoints = short_row},
                                   {.setpoints = many},
                                   {.setpoints = good, .position = nan_state},
                                   {.setpoints = good, .position = short_state},
                                   {.setpoints = good, .velocity = nan_state},
                                   {.setpoints = good, .time = kNan},
                                   {.setpoints = good, .time = kInfinite},
                                   {.setpoints = good, .time = -1},
                                   {.setpoints = good, .time = 1.76e18},
                                   {.setpoints = good, .time = 1.76e15}};
  for (const GuardRequest& request : requests) {
    Guard guard(problem);
    // Where the robot begins must be readable, and how fast it is there.
    if (!request.position.empty() || !request.velocity.empty()) guard.check({});
    for (int round = 0; round < 2; ++round) {
      const GuardAnswer& answer = guard.check(request);
      EXPECT_EQ(answer.reason, GuardReason::kInvalid);
      EXPECT_EQ(answer.passed, 0);
      EXPECT_TRUE(answer.certified);
      EXPECT_EQ(guard.check({.setpoints = good}).passed, round == 0 ? 3 : 0);
      EXPECT_TRUE(guard.answer().certified);
    }
  }
}

TEST(Guard, AMeasuredStateIsComparedWithTheMotion) {
  Problem problem = test::wallProblem();
  GuardOptions options;
  options.joint_errors = {0.01, 0.01, 0.01};
  Guard guard(problem, options);
  const Rows rows = towardsWall(0.3, 2, 0.02, 20);
  guard.check({.setpoints = flat(rows)});
  std::vector<double> measured = rows.back();
  measured[0] += 0.005;
  const GuardAnswer& near = guard.check({.position = measured});
  EXPECT_EQ(near.start[0], rows.back()[0]);  // the motion goes on where the controller has it
  measured = {-1.5, 1.2, 0};
  const GuardAnswer& far = guard.check({.position = measured});
  EXPECT_EQ(far.start[0], -1.5);
  EXPECT_TRUE(far.certified);  // there is room for a stop
  measured = {-0.1, 0, 0};     // in the wall
  const GuardAnswer& inside = guard.check({.position = measured});
  EXPECT_FALSE(inside.certified);
  EXPECT_EQ(inside.reason, GuardReason::kNotFree);
  EXPECT_EQ(inside.b, "lower wall");
}

/// Regression: after a request with a fault beside it, the robot was taken to be elsewhere.
TEST(Guard, APositionCountsAlsoInABadRequest) {
  const Problem problem = test::wallProblem();
  const std::vector<double> rows = flat(towardsWall(0.3, 2, 0.02, 5)), unread(3, kNan);
  const std::vector<double> away = {-1.5, 1.2, 0};
  for (const bool is_first : {true, false}) {
    Guard fast(problem), untimed(problem);
    if (!is_first) {
      ASSERT_EQ(fast.check({.setpoints = rows}).passed, 5);
      ASSERT_EQ(untimed.check({.setpoints = rows}).passed, 5);
    }
    const GuardAnswer& lost = fast.check({.position = away, .velocity = unread});
    EXPECT_EQ(lost.reason, GuardReason::kInvalid);
    EXPECT_EQ(lost.start[0], -1.5);
    EXPECT_FALSE(lost.certified);
    EXPECT_FALSE(fast.check({.setpoints = rows}).certified);
    EXPECT_FALSE(fast.check({.position = away, .time = -5}).certified);
    EXPECT_TRUE(fast.check({.position = away}).certified);
    // At what time, and so how fast, it was there is not known unless it was at rest.
    EXPECT_EQ(untimed.check({.position = away, .time = 1e300}).certified, is_first);
    EXPECT_EQ(untimed.answer().start[0], -1.5);
    EXPECT_EQ(untimed.check({.setpoints = rows}).passed, 0);
  }
  EXPECT_FALSE(Guard(problem).check({.velocity = unread}).certified);
}

TEST(Guard, CallsAllocateNothing) {
  const Problem problem = loadProblem(leeway::sourceFolder() + "/problems/shelf/reach.yaml");
  Guard guard(problem);
  Policy policy(guard, 1, 0.3);
  const std::vector<double> start = startPoint(problem), rest(start.size());
  std::vector<std::vector<double>> chunks;
  for (int c = 0; c < 30; ++c) chunks.push_back(policy.chunk(start, rest, 40));
  const std::vector<double> bad(3, kNan);
  const std::size_t before = collision::testing::allocationCount();
  for (const std::vector<double>& chunk : chunks) {
    guard.check({.setpoints = chunk});
    guard.check({.setpoints = bad});
    guard.check({.position = start});
  }
  EXPECT_EQ(collision::testing::allocationCount(), before);
}

TEST(Guard, TheSameCallsGiveTheSameAnswers) {
  const Problem problem = loadProblem(leeway::sourceFolder() + "/problems/shelf/reach.yaml");
  std::vector<double> answers[2];
  for (std::vector<double>& values : answers) {
    Guard guard(problem);
    Policy policy(guard, 2, 0.5);
    std::vector<double> start = startPoint(problem), rest(start.size());
    for (int c = 0; c < 30; ++c) {
      const GuardAnswer& answer = guard.check({.setpoints = policy.chunk(start, rest, 20)});
      values.push_back(answer.passed);
      values.push_back(static_cast<double>(answer.edges));
      values.insert(values.end(), answer.motion.begin(), answer.motion.end());
    }
  }
  EXPECT_EQ(answers[0], answers[1]);
}

TEST(Guard, RefusesWhatItDoesNotGuard) {
  const auto expect = [](auto change, std::initializer_list<std::string> words) {
    Problem problem = test::wallProblem();
    problem.name = "wall";
    GuardOptions options;
    change(problem, options);
    robots::expectInputError([&] { Guard(problem, options); }, "wall", 0, words);
  };
  expect([](Problem&, GuardOptions& o) { o.period = 0; }, {"period is 0", "0.0001"});
  expect([](Problem&, GuardOptions& o) { o.period = kNan; }, {"period is nan"});
  expect([](Problem&, GuardOptions& o) { o.most_setpoints = 0; }, {"most_setpoints is 0"});
  expect([](Problem&, GuardOptions& o) { o.work = 0; }, {"work is 0"});
  expect([](Problem&, GuardOptions& o) { o.horizon = kInfinite; }, {"horizon is inf"});
  expect([](Problem&, GuardOptions& o) { o.point_error = -1; }, {"point_error is -1"});
  expect([](Problem&, GuardOptions& o) { o.joint_errors = {1}; }, {"joint_errors has 1", "3"});
  expect([](Problem&, GuardOptions& o) { o.joint_errors = {0, 0, 1}; }, {"joint_errors", "1 rad"});
  expect([](Problem&, GuardOptions& o) { o.joint_errors = {1, -1, 0}; }, {"joint_errors[1] is -1"});
  expect(
      [](Problem&, GuardOptions& o) {
        o.limits = {{1, 0, 1}, {1, 1, 1}, {}};
      },
      {"limits.velocity[1] is 0"});
  expect(
      [](Problem&, GuardOptions& o) {
        o.limits = {{1, 1, 1}, {}, {}};
      },
      {"limits.acceleration has 0"});
  expect([](Problem& p, GuardOptions&) { p.steps.push_back({"line", LineStep{}, {}}); }, {"steps"});
  expect(
      [](Problem& p, GuardOptions&) {
        p.robot.model =
            robots::freeBody("disc", {}, robots::JointType::kPlanar, {-2, -2, 0}, {2, 2, 0});
      },
      {"no pair is checked"});
  Problem flyer = test::problemOf(test::flyingBox(), {0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1});
  flyer.world.objects.push_back(test::box("box", {0.1, 0.1, 0.1}, 0.8, 0.8, 0.8));
  robots::expectInputError([&] { Guard{flyer}; }, "test", 0, {"floating"});
}

// -------------------------------------------------------------------------------------------------
// Obstacles that move

/// An upright sheet across the disc's way at x = 0, 0.4 high, from y = 0.95 to 1.45.
const std::vector<Eigen::Vector3d> kSheet = {
    {0, 0.95, -0.2}, {0, 1.45, -0.2}, {0, 0.95, 0.2}, {0, 1.45, 0.2}};
const std::vector<collision::DeformableMesh::Triangle> kSheetTriangles = {{0, 1, 3}, {0, 3, 2}};

std::vector<Eigen::Vector3d> sheetAt(double x) {
  std::vector<Eigen::Vector3d> vertices = kSheet;
  for (Eigen::Vector3d& v : vertices) v.x() += x;
  return vertices;
}

/// The disc is left of the gap at y = 1.2, through which the sheet comes.
Problem sheetProblem(std::shared_ptr<const collision::VertexMotion> motion, double x,
                     double speed_bound = kInfinite) {
  Problem problem = test::wallProblem();
  problem.start = {-1, 1.2, 0};
  problem.goals = {test::pointGoal("goal", {1, 1.2, 0})};
  problem.execution.velocities = {{"disc/x", 1}, {"disc/y", 1}};
  problem.execution.accelerations = {{"disc/x", 5}, {"disc/y", 5}};
  problem.world.deforming.push_back(
      makeDeformingObstacle("sheet", collision::DeformableMesh::make(sheetAt(x), kSheetTriangles),
                            std::move(motion), {}, 0, {}, speed_bound));
  return problem;
}

std::vector<double> still(const std::vector<double>& place, int count) {
  std::vector<double> rows;
  for (int k = 0; k < count; ++k) rows.insert(rows.end(), place.begin(), place.end());
  return rows;
}

TEST(Guard, AKnownMotionIsFollowed) {
  // The sheet comes from x = 1 at 0.5 m/s; the disc goes towards it at 0.4 m/s from x = -1.
  collision::MorphMotion keys;
  keys.references = {sheetAt(1), sheetAt(-1)};
  keys.keys = {{0, {1, 0}}, {4, {0, 1}}};
  const Problem problem = sheetProblem(collision::VertexMotion::morph(keys), 1);
  Guard guard(problem);
  std::vector<TimedPoint> executed = {{0, {-1, 1.2, 0}}};
  std::vector<double> place = {-1, 1.2, 0};
  double v = 0;
  int passed = 0, stopped = 0;
  for (int c = 0; c < 30; ++c) {
    guard.look(guard.nextTime());
    std::vector<double> rows;
    double x = place[0], speed = v;
    for (int k = 0; k < 5; ++k) {
      speed = std::min(0.4, speed + 5 * 0.02);
      x += speed * 0.02;
      rows.insert(rows.end(), {x, 1.2, 0});
    }
    const GuardAnswer& answer = guard.check({.setpoints = rows});
    if (!answer.certified) break;  // the sheet has come to a robot at rest
    const int go = std::max(1, answer.passed);
    for (int k = 0; k < go; ++k) {
      const std::size_t row = 3 * static_cast<std::size_t>(k);
      if (row < answer.motion.size())
        place.assign(answer.motion.begin() + static_cast<std::ptrdiff_t>(row),
                     answer.motion.begin() + static_cast<std::ptrdiff_t>(row + 3));
      executed.push_back({answer.time + (k + 1) * 0.02, place});
    }
    v = answer.passed > 0 ? 0.4 : 0;
    passed += answer.passed;
    stopped += answer.passed == 0 ? 1 : 0;
    if (stopped > 0) break;
  }
  EXPECT_GT(passed, 40);
  EXPECT_GT(stopped, 0);
  EXPECT_GT(test::denseClearance(problem, executed, 0.001, 1), 0);
}

TEST(Guard, ASpeedBoundGrowsWithAge) {
  Problem problem = sheetProblem(nullptr, 0);
  Guard guard(problem);
  const auto passed = [&](double bound, double age) {
    Guard fresh(problem);
    EXPECT_EQ(fresh.setVertices("sheet", sheetAt(0), 0, bound), Observation::kTaken);
    fresh.look(age);
    // The disc's edge is 0.9 m from the sheet; it stands there for 50 periods.
    return fresh.check({.setpoints = still({-1, 1.2, 0}, 50), .time = age}).passed;
  };
  EXPECT_EQ(passed(0, 0), 50);
  EXPECT_EQ(passed(0.5, 0), 50);    // 0.5 m in 1 s
  EXPECT_EQ(passed(0.5, 0.5), 50);  // 0.75 m
  const int later = passed(0.5, 1.2);
  EXPECT_GT(later, 10);
  EXPECT_LT(later, 31);  // 0.9 m are reached at 1.8 s
  EXPECT_EQ(passed(0.5, 1.9), 0);
  EXPECT_EQ(passed(kInfinite, 0), 0);
  EXPECT_EQ(passed(10, 0.05), 1);  // the first slices are short
}

TEST(Guard, ObservationsThatFailStopTheRobotUntilTheyAreGoodAgain) {
  Problem problem = sheetProblem(nullptr, 0);
  GuardOptions options;
  options.horizon = 1;
  Guard guard(problem, options);
  const std::vector<double> here = still({-1, 1.2, 0}, 10);
  EXPECT_EQ(guard.check({.setpoints = here}).passed, 0);  // never seen: no bound
  ASSERT_EQ(guard.setVertices("sheet", sheetAt(0), 0.2, 0.2), Observation::kTaken);
  guard.look(0.2);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.2}).passed, 10);
  // Refused ones leave the last one.
  std::vector<Eigen::Vector3d> bad = sheetAt(0);
  bad[2].y() = kNan;
  EXPECT_EQ(guard.setVertices("sheet", bad, 0.3, 0.2), Observation::kInvalid);
  bad.resize(3);
  EXPECT_EQ(guard.setVertices("sheet", bad, 0.3, 0.2), Observation::kInvalid);
  EXPECT_EQ(guard.setVertices("sheet", sheetAt(0), 0.1, 0.2), Observation::kLate);
  EXPECT_EQ(guard.setVertices("sheet", sheetAt(0), kNan, 0.2), Observation::kLate);
  EXPECT_THROW(guard.setVertices("curtain", sheetAt(0), 0.3, 0.2), std::invalid_argument);
  EXPECT_THROW(guard.setVertices("sheet", sheetAt(0), 0.3, -1), std::invalid_argument);
  EXPECT_THROW(guard.look(kNan), std::invalid_argument);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.4}).passed, 10);
  // Without another look, the bounds end at 1.2 s.
  const GuardAnswer& late = guard.check({.setpoints = here, .time = 1.1});
  EXPECT_EQ(late.reason, GuardReason::kStale);
  EXPECT_LT(late.passed, 6);
  // A jump of 0.4 m in 1 s at 0.2 m/s: nothing passes, and another stop is proven.
  EXPECT_EQ(guard.setVertices("sheet", sheetAt(0.4), 1.2, 0.2), Observation::kJumped);
  guard.look(1.2);
  const GuardAnswer& jumped = guard.check({.setpoints = here, .time = 1.25});
  EXPECT_EQ(jumped.reason, GuardReason::kJumped);
  EXPECT_EQ(jumped.a, "sheet");
  EXPECT_EQ(jumped.passed, 0);
  EXPECT_TRUE(jumped.certified);
  EXPECT_EQ(guard.setVertices("sheet", sheetAt(0.41), 1.3, 0.2), Observation::kTaken);
  guard.look(1.3);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 1.3}).passed, 10);
}

TEST(Guard, ARobotAtRestIsNotCertifiedWhereSomethingMayReachIt) {
  Problem problem = sheetProblem(nullptr, 0);
  Guard guard(problem);
  ASSERT_EQ(guard.setVertices("sheet", sheetAt(-0.85), 0.1, 1), Observation::kTaken);
  guard.look(0.2);
  const GuardAnswer& answer = guard.check({.time = 0.2});
  EXPECT_FALSE(answer.certified);
  EXPECT_EQ(answer.b, "sheet");
  ASSERT_NE(guard.setVertices("sheet", sheetAt(0), 0.3, 0.1), Observation::kInvalid);
  guard.look(0.3);
  EXPECT_TRUE(guard.check({.time = 0.3}).certified);
}

TEST(Guard, CallsAmongObstaclesAllocateNothing) {
  Problem problem = sheetProblem(nullptr, 0);
  Guard guard(problem);
  const std::vector<double> here = still({-1, 1.2, 0}, 30);
  for (int k = 0; k < 3; ++k) {
    guard.setVertices("sheet", sheetAt(0.01 * k), 0.1 * k, 0.3);
    guard.look(0.1 * k);
    const std::size_t before = collision::testing::allocationCount();
    EXPECT_GT(guard.check({.setpoints = here, .time = 0.1 * k}).passed, 0);
    EXPECT_EQ(collision::testing::allocationCount(), before) << k;
  }
}

/// sheetProblem() with a rigid plate in place of the sheet.
Problem plateProblem(const ObjectMotion& motion, double x) {
  Problem problem = sheetProblem(nullptr, 0);
  problem.world.deforming.clear();
  problem.world.objects.push_back(
      movingObject(test::box("plate", {0.005, 0.25, 0.2}, x, 1.2, 0), motion));
  return problem;
}

robots::Pose plateAt(double x, double turned = 0) {
  robots::Pose pose = test::at(x, 1.2, 0);
  pose.rotation << std::cos(turned), -std::sin(turned), 0, std::sin(turned), std::cos(turned), 0, 0,
      0, 1;
  return pose;
}

TEST(Guard, AnObjectsKnownMotionIsFollowed) {
  for (const bool is_steady : {false, true}) {
    const auto poses =
        is_steady ? collision::PoseMotion::steady({0, plateAt(1)}, {-0.5, 0, 0}, {0, 0, 0.3})
                  : collision::PoseMotion::keys({{0, plateAt(1)}, {4, plateAt(-1, 1)}});
    const Problem problem = plateProblem({.poses = poses}, 1);
    Guard guard(problem);
    std::vector<TimedPoint> executed = {{0, {-1, 1.2, 0}}};
    std::vector<double> place = {-1, 1.2, 0};
    int passed = 0;
    bool stopped = false;
    while (!stopped && executed.size() < 200) {
      guard.look(guard.nextTime());
      const double v = passed > 0 ? 0.4 : 0;
      std::vector<double> rows;
      double x = place[0], speed = v;
      for (int k = 0; k < 5; ++k) {
        speed = std::min(0.4, speed + 5 * 0.02);
        x += speed * 0.02;
        rows.insert(rows.end(), {x, 1.2, 0});
      }
      const GuardAnswer& answer = guard.check({.setpoints = rows});
      if (!answer.certified) break;  // the plate has come to a robot at rest
      stopped = answer.passed == 0;
      const std::size_t count = stopped ? answer.motion.size() / 3 : std::size_t(answer.passed);
      for (std::size_t k = 0; k < count; ++k) {
        place.assign(answer.motion.begin() + static_cast<std::ptrdiff_t>(3 * k),
                     answer.motion.begin() + static_cast<std::ptrdiff_t>(3 * k + 3));
        executed.push_back({answer.time + (static_cast<double>(k) + 1) * 0.02, place});
      }
      passed += answer.passed;
    }
    EXPECT_GT(passed, 40);
    EXPECT_GT(test::denseClearance(problem, executed, 0.001, 1), 0);
  }
}

TEST(Guard, AnObjectsBoundsGrowWithAge) {
  const Problem problem = plateProblem({}, 0);
  const auto passed = [&](double speed, double turning, double age) {
    Guard fresh(problem);
    EXPECT_EQ(fresh.setPose("plate", plateAt(0), 0, speed, turning), Observation::kTaken);
    fresh.look(age);
    // The disc's edge is 0.895 m from the plate, whose points are within 0.32 m of its origin; it
    // stands there for 50 periods.
    return fresh.check({.setpoints = still({-1, 1.2, 0}, 50), .time = age}).passed;
  };
  EXPECT_EQ(passed(0, 0, 0), 50);
  EXPECT_EQ(passed(0.5, 0, 0.5), 50);  // 0.75 m
  EXPECT_EQ(passed(0.34, 0.5, 0.5), 50);
  const int later = passed(0.5, 0, 1.2);
  EXPECT_GT(later, 10);
  EXPECT_LT(later, 31);
  EXPECT_LT(passed(0.34, 0.5, 1.2), 31);
  EXPECT_EQ(passed(0.5, 0, 1.9), 0);
  EXPECT_EQ(passed(kInfinite, 0, 0), 0);
  EXPECT_EQ(passed(0, kInfinite, 0), 0);
}

TEST(Guard, ObservationsOfObjectsThatFailStopTheRobotUntilTheyAreGoodAgain) {
  const Problem problem = plateProblem({}, 0);
  GuardOptions options;
  options.horizon = 1;
  Guard guard(problem, options);
  const std::vector<double> here = still({-1, 1.2, 0}, 10);
  EXPECT_EQ(guard.check({.setpoints = here}).passed, 0);  // no bound
  ASSERT_EQ(guard.setPose("plate", plateAt(0), 0.2, 0.2, 0), Observation::kTaken);
  guard.look(0.2);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.2}).passed, 10);
  robots::Pose bad = plateAt(0);
  bad.translation.y() = kNan;
  EXPECT_EQ(guard.setPose("plate", bad, 0.3, 0.2, 0), Observation::kInvalid);
  bad = plateAt(0);
  bad.rotation(2, 2) = -1;  // a mirror
  EXPECT_EQ(guard.setPose("plate", bad, 0.3, 0.2, 0), Observation::kInvalid);
  EXPECT_EQ(guard.setPose("plate", plateAt(0), 0.1, 0.2, 0), Observation::kLate);
  EXPECT_EQ(guard.setPose("plate", plateAt(0), kNan, 0.2, 0), Observation::kLate);
  EXPECT_THROW(guard.setPose("upper wall", plateAt(0), 0.3, 0.2, 0), std::invalid_argument);
  EXPECT_THROW(guard.setPose("plate", plateAt(0), 0.3, -1, 0), std::invalid_argument);
  EXPECT_THROW(guard.setPose("plate", plateAt(0), 0.3, 0, kNan), std::invalid_argument);
  EXPECT_THROW(guard.setVertices("plate", sheetAt(0), 0.3, 0.2), std::invalid_argument);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.4}).passed, 10);
  // A jump of 0.4 m in 1 s at 0.2 m/s.
  EXPECT_EQ(guard.setPose("plate", plateAt(0.4), 1.2, 0.2, 0), Observation::kJumped);
  guard.look(1.2);
  const GuardAnswer& jumped = guard.check({.setpoints = here, .time = 1.2});
  EXPECT_EQ(jumped.reason, GuardReason::kJumped);
  EXPECT_EQ(jumped.a, "plate");
  EXPECT_EQ(guard.setPose("plate", plateAt(0.41), 1.3, 0.2, 0), Observation::kTaken);
  guard.look(1.3);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 1.3}).passed, 10);
  // With a turning bound of 0 a turn is a jump.
  EXPECT_EQ(guard.setPose("plate", plateAt(0.41, 0.5), 1.4, 0.2, 0), Observation::kJumped);
}

TEST(Guard, AnObservationAheadOfTimeDoesNotShutOutThoseThatFollow) {
  Guard guard(plateProblem({}, 0));
  const std::vector<double> here = still({-1, 1.2, 0}, 10);
  ASSERT_EQ(guard.setPose("plate", plateAt(0), 0.2, 0.2, 0), Observation::kTaken);
  guard.look(0.2);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.2}).passed, 10);
  EXPECT_EQ(guard.setPose("plate", plateAt(0), 1000, 0.2, 0), Observation::kTaken);
  guard.look(0.4);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.4}).passed, 0);
  EXPECT_EQ(guard.setPose("plate", plateAt(0.01), 0.5, 0.2, 0), Observation::kTaken);
  guard.look(0.5);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.5}).passed, 10);
  EXPECT_EQ(guard.setPose("plate", plateAt(0), 0.4, 0.2, 0), Observation::kLate);
}

TEST(Guard, CallsAmongObjectsThatMoveAllocateNothing) {
  Guard guard(plateProblem({}, 0));
  const std::vector<double> here = still({-1, 1.2, 0}, 30);
  for (int k = 0; k < 3; ++k) {
    guard.setPose("plate", plateAt(0.01 * k, 0.01 * k), 0.1 * k, 0.3, 0.2);
    guard.look(0.1 * k);
    const std::size_t before = collision::testing::allocationCount();
    EXPECT_GT(guard.check({.setpoints = here, .time = 0.1 * k}).passed, 0);
    EXPECT_EQ(collision::testing::allocationCount(), before) << k;
  }
}

// -------------------------------------------------------------------------------------------------
// Clouds that are seen again and again

/// Balls of 2 cm on a line at x, across the gap.
std::shared_ptr<const PointCloud> fenceAt(double x) {
  auto cloud = std::make_shared<PointCloud>();
  for (double y = 0.9; y < 1.5; y += 0.02) cloud->balls.push_back({{x, y, 0}, 0.02});
  return cloud;
}

/// sheetProblem() with a cloud in place of the sheet.
Problem fenceProblem(double x) {
  Problem problem = sheetProblem(nullptr, 0);
  problem.world.deforming.clear();
  Object fence{"fence", {}, {}};
  fence.cloud = fenceAt(x);
  problem.world.objects.push_back(movingObject(fence, {.speed_bound = 0, .turn_bound = 0}));
  return problem;
}

TEST(Guard, ACloudsBoundGrowsWithAge) {
  const Problem problem = fenceProblem(1.8);
  const auto passed = [&](double bound, double age) {
    Guard fresh(problem);
    EXPECT_EQ(fresh.setCloud("fence", fenceAt(0), 0, bound), Observation::kTaken);
    fresh.look(age);
    // The disc's edge is 0.88 m from the fence; it stands there for 50 periods.
    return fresh.check({.setpoints = still({-1, 1.2, 0}, 50), .time = age}).passed;
  };
  EXPECT_EQ(passed(0, 0), 50);
  EXPECT_EQ(passed(0.5, 0), 50);    // 0.5 m in 1 s
  EXPECT_EQ(passed(0.5, 0.5), 50);  // 0.75 m
  const int later = passed(0.5, 1.2);
  EXPECT_GT(later, 10);
  EXPECT_LT(later, 30);  // 0.88 m are reached at 1.76 s
  EXPECT_EQ(passed(0.5, 1.9), 0);
  EXPECT_EQ(passed(kInfinite, 0), 0);
}

TEST(Guard, ANewCloudCountsFromTheNextLookOn) {
  Guard guard(fenceProblem(1.8));
  const std::vector<double> here = still({-1, 1.2, 0}, 10);
  EXPECT_EQ(guard.check({.setpoints = here}).passed, 10);
  // Balls may be anywhere in a new cloud: what was proven is not proven any more.
  EXPECT_EQ(guard.setCloud("fence", fenceAt(1.79), 0.2, 0.2), Observation::kTaken);
  const GuardAnswer& before = guard.check({.setpoints = here, .time = 0.2});
  EXPECT_EQ(before.reason, GuardReason::kStale);
  EXPECT_EQ(before.passed, 0);
  EXPECT_FALSE(before.certified);
  guard.look(0.2);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.2}).passed, 10);
  // Refused ones leave the last one, and what is proven.
  const auto bad = [](double coordinate, double radius) {
    auto cloud = std::make_shared<PointCloud>();
    cloud->balls = {{{0, 0, 0}, 0.02}, {{0, coordinate, 0}, radius}};
    return cloud;
  };
  const auto take = [&](std::shared_ptr<const PointCloud> cloud, double time,
                        const std::optional<robots::Pose>& X_WO = {}) {
    return guard.setCloud("fence", std::move(cloud), time, 0.2, X_WO);
  };
  EXPECT_EQ(take(bad(kNan, 0.02), 0.3), Observation::kInvalid);
  EXPECT_EQ(take(bad(kInfinite, 0.02), 0.3), Observation::kInvalid);
  EXPECT_EQ(take(bad(0, -1), 0.3), Observation::kInvalid);
  EXPECT_EQ(take(std::make_shared<PointCloud>(), 0.3), Observation::kInvalid);
  EXPECT_EQ(take(nullptr, 0.3), Observation::kInvalid);
  EXPECT_EQ(take(fenceAt(0), 0.3, test::at(kNan, 0, 0)), Observation::kInvalid);
  EXPECT_EQ(take(fenceAt(0), 0.1), Observation::kLate);
  EXPECT_EQ(take(fenceAt(0), kNan), Observation::kLate);
  EXPECT_THROW(guard.setCloud("fence", fenceAt(0), 0.3, -1), std::invalid_argument);
  EXPECT_THROW(guard.setCloud("upper wall", fenceAt(0), 0.3, 0), std::invalid_argument);
  EXPECT_THROW(guard.setVertices("fence", sheetAt(0), 0.3, 0), std::invalid_argument);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.4}).passed, 10);
  // Another number of balls, in another frame, far from those before.
  auto one = std::make_shared<PointCloud>();
  one->balls = {{{0, 0, 0}, 0.02}};
  EXPECT_EQ(take(one, 0.5, test::at(-0.9, 1.2, 0)), Observation::kTaken);
  guard.look(0.5);
  const GuardAnswer& met = guard.check({.setpoints = here, .time = 0.5});
  EXPECT_EQ(met.reason, GuardReason::kNotFree);
  EXPECT_EQ(met.b, "fence");
  EXPECT_EQ(take(one, 0.6, test::at(1, 0, 0)), Observation::kTaken);
  guard.look(0.6);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.6}).passed, 10);
  // A pose moves the balls that were seen last.
  EXPECT_EQ(guard.setPose("fence", test::at(-0.9, 1.2, 0), 0.7, 10, 0), Observation::kJumped);
  guard.look(0.7);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.7}).passed, 0);
}

/// Regression: the balls before it were taken to be near its own.
TEST(Guard, AScanAheadOfTimeDoesNotHideTheOneBefore) {
  Guard guard(fenceProblem(-1));  // on the robot
  const std::vector<double> here = still({-1, 1.2, 0}, 10);
  ASSERT_EQ(guard.setCloud("fence", fenceAt(1.8), 0.5, 0.1), Observation::kTaken);
  guard.look(0);
  EXPECT_FALSE(guard.check({.setpoints = here, .time = 0}).certified);
  guard.look(0.5);
  EXPECT_EQ(guard.check({.setpoints = here, .time = 0.5}).passed, 10);
  // Sums of periods are rounded.
  ASSERT_EQ(guard.setCloud("fence", fenceAt(1.8), 0.7, 0.1), Observation::kTaken);
  const double before = std::nextafter(0.7, 0.0);
  guard.look(before);
  EXPECT_EQ(guard.check({.setpoints = here, .time = before}).passed, 10);
}

/// Regression: the bound of a cloud is one on its points. It was taken for one on its origin, and
/// for a cloud that does not turn.
TEST(Guard, ACloudThatTurnsWithinTheSpeedOfItsPointsHasNotJumped) {
  Guard guard(fenceProblem(1.8));
  ASSERT_EQ(guard.setCloud("fence", fenceAt(1.8), 0, 0.1), Observation::kTaken);
  robots::Pose turned;
  turned.rotation = Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_EQ(guard.setPose("fence", turned, 0.1, 0.1, 0), Observation::kTaken);
  turned.rotation = Eigen::AngleAxisd(0.014, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_EQ(guard.setPose("fence", turned, 0.2, 0.1, 0), Observation::kJumped);
}

TEST(Guard, ACarvedCloudIsRefusedElsewhere) {
  Guard guard(fenceProblem(1.8));
  const robots::Geometry post{collision::Shape::sphere(0.05), test::at(1.8, 1.2, 0), {}};
  const auto cut =
      std::make_shared<const PointCloud>(carved(*fenceAt(1.8), {}, {&post, 1}, 0, "post"));
  EXPECT_EQ(guard.setCloud("fence", cut, 0, 0, test::at(0, 0.1, 0)), Observation::kInvalid);
  EXPECT_EQ(guard.setCloud("fence", cut, 0, 0), Observation::kTaken);
  EXPECT_EQ(guard.setPose("fence", test::at(0, 0.1, 0), 0, 0, 0), Observation::kInvalid);
  EXPECT_EQ(guard.setPose("fence", {}, 0, 0, 0), Observation::kTaken);
  guard.look(0);
  EXPECT_EQ(guard.check({.setpoints = still({-1, 1.2, 0}, 5), .time = 0}).passed, 5);
}

TEST(Guard, NothingIsProvenWhereTheRobotsFirstPositionIsNotReadable) {
  Guard guard(fenceProblem(1.8));
  const std::vector<double> here = {-1, 1.2, 0}, unread = {-1, kNan, 0};
  const std::vector<double> setpoints = still(here, 5);
  EXPECT_FALSE(guard.check({.setpoints = setpoints, .position = unread}).certified);
  EXPECT_FALSE(guard.check({.setpoints = setpoints}).certified);
  EXPECT_EQ(guard.check({.setpoints = setpoints, .position = here}).passed, 5);
  EXPECT_TRUE(guard.check({.setpoints = setpoints, .position = unread}).certified);
}

TEST(Guard, AFenceThatAppearsStopsTheRobotBeforeIt) {
  for (const double error : {0.0, 0.01}) {
    GuardOptions options;
    options.joint_errors.assign(3, error);
    options.joint_errors[2] = 0;
    Guard guard(fenceProblem(1.8), options);
    double x = -1, speed = 0;
    int passed = 0;
    for (int c = 0; c < 60; ++c) {
      const double now = guard.nextTime();
      // It is seen from 1 s on, at 0.5, and comes at 0.1 m/s.
      const double fence = now < 1 ? 1.8 : 0.5 - 0.1 * (now - 1);
      ASSERT_EQ(guard.setCloud("fence", fenceAt(fence), now, 0.1), Observation::kTaken);
      guard.look(now);
      std::vector<double> rows;
      double to = x, v = speed;
      for (int k = 0; k < 5; ++k) {
        v = std::min(0.4, v + 5 * 0.02);
        to += v * 0.02;
        rows.insert(rows.end(), {to, 1.2, 0});
      }
      const GuardAnswer& answer = guard.check({.setpoints = rows});
      if (!answer.certified) break;  // the fence has come to a robot at rest
      passed += answer.passed;
      for (int k = 0; k < std::max(1, answer.passed); ++k)
        if (const std::size_t row = 3 * static_cast<std::size_t>(k); row < answer.motion.size()) {
          speed = (answer.motion[row] - x) / 0.02;
          x = answer.motion[row];
        }
      const double later = guard.nextTime();
      if (now >= 1) {
        EXPECT_GT(0.5 - 0.1 * (later - 1) - x - 0.12, error);
      }
      if (answer.passed == 0 && speed == 0) break;
    }
    EXPECT_GT(passed, 40);
    EXPECT_GT(x, -0.3);
  }
}

TEST(Guard, CallsAmongCloudsAllocateNothing) {
  Guard guard(fenceProblem(1.8));
  const std::vector<double> here = still({-1, 1.2, 0}, 30);
  for (int k = 0; k < 3; ++k) {
    guard.setCloud("fence", fenceAt(0.01 * k), 0.1 * k, 0.3);
    guard.look(0.1 * k);
    const std::size_t before = collision::testing::allocationCount();
    EXPECT_GT(guard.check({.setpoints = here, .time = 0.1 * k}).passed, 0);
    EXPECT_EQ(collision::testing::allocationCount(), before) << k;
  }
}

// -------------------------------------------------------------------------------------------------
// Faults that were found in review

TEST(Guard, ErrorsKeepPairsThatOtherwiseNeverMeet) {
  // The third link turns 0.01 above the first one, and never meets it.
  const auto link = [](const char* name, const char* xyz) {
    return std::string("<link name=\"") + name + "\"><collision><origin xyz=\"" + xyz +
           "\"/><geometry><box size=\"0.2 0.05 0.05\"/></geometry></collision></link>";
  };
  const auto joint = [](const char* name, const char* parent, const char* child, const char* xyz) {
    return std::string("<joint name=\"") + name + "\" type=\"revolute\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><origin xyz=\"" + xyz +
           "\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"1\"/>"
           "</joint>";
  };
  const Folder folder;
  const auto model = robots::loadModel(
      folder.write("r.urdf", "<robot name=\"r\">" + link("base", "0 0 0") + link("l1", "0.5 0 0") +
                                 "<link name=\"l2\"/>" + link("l3", "0 0 0.06") +
                                 joint("a", "base", "l1", "0 0 0") +
                                 joint("b", "l1", "l2", "0.5 0 0") +
                                 joint("c", "l2", "l3", "0 0 0") + "</robot>"),
      "");
  Problem problem = test::problemOf(model, {0, 0, 0}, {0.5, 0, 0});
  problem.world.objects.push_back(test::box("box", {0.1, 0.1, 0.1}, 0, 5, 0));
  for (const double common : {0.0, -0.005}) {
    problem.margins.common = common;
    const auto reason = [&](double point_error) {
      GuardOptions options;
      options.point_error = point_error;
      return Guard(problem, options).check({}).reason;
    };
    EXPECT_EQ(reason(0), GuardReason::kPassed);
    EXPECT_EQ(reason(0.001), GuardReason::kPassed);
    EXPECT_EQ(reason(0.05), GuardReason::kNotFree);
  }
}

TEST(Guard, ErrorsBeyondTheCropOfACloudAreRefused) {
  Problem problem = test::wallProblem();
  PointCloud cloud;
  cloud.balls.push_back({{0, 5, 0}, 0.01});
  cloud.crops.push_back({0.1, {}, reachOf(problem)});
  problem.world.objects.push_back({"seen", {}, {}, std::make_shared<const PointCloud>(cloud)});
  GuardOptions options;
  options.point_error = 0.04;
  EXPECT_TRUE(Guard(problem, options).check({}).certified);
  options.point_error = 0.06;
  robots::expectInputError([&] { Guard(problem, options); }, "test", 0, {"cloud 'seen' lacks"});
}

TEST(Guard, ALookBeforeAnObservationGrowsBackwards) {
  const Problem problem = sheetProblem(nullptr, 0);
  const std::vector<double> here = still({-1, 1.2, 0}, 1);
  {
    Guard guard(problem);  // nothing is known before the first observation
    ASSERT_EQ(guard.setVertices("sheet", sheetAt(0), 0.5, 1), Observation::kTaken);
    guard.look(0);
    EXPECT_FALSE(guard.check({.setpoints = here, .time = 0}).certified);
  }
  const auto isCertified = [&](double bound, double bound_later, double time) {
    Guard guard(problem);
    guard.setVertices("sheet", sheetAt(0), 0.1, bound);
    guard.setVertices("sheet", sheetAt(0), 0.9, bound_later);
    guard.look(time);
    return guard.check({.setpoints = here, .time = time}).certified;
  };
  EXPECT_TRUE(isCertified(1, 0.1, 0.3));
  EXPECT_FALSE(isCertified(2, 0.1, 0.3));   // 1.2 m before; the disc is 0.9 m away
  EXPECT_FALSE(isCertified(1, 0.1, 0.05));  // before both
}

TEST(Guard, AfterAJumpNothingIsProvenUntilTheNextLook) {
  Guard guard(sheetProblem(nullptr, 0));
  guard.setVertices("sheet", sheetAt(0), 0, 0.2);
  guard.look(0);
  ASSERT_EQ(guard.check({.setpoints = still({-1, 1.2, 0}, 10), .time = 0}).passed, 10);
  ASSERT_EQ(guard.setVertices("sheet", sheetAt(0.4), 0.2, 0.2), Observation::kJumped);
  EXPECT_FALSE(guard.check({.time = 0.2}).certified);
  EXPECT_EQ(guard.answer().reason, GuardReason::kJumped);
  guard.look(0.2);
  EXPECT_TRUE(guard.check({.time = 0.2}).certified);
}

TEST(Guard, AGreaterSpeedBoundEndsTheMotionThatWasProven) {
  std::vector<double> rows;
  for (int k = 1; k <= 20; ++k) rows.insert(rows.end(), {-1 + 0.002 * k, 1.2, 0});
  collision::MorphMotion keys;
  keys.references = {sheetAt(0), sheetAt(1)};
  keys.keys = {{0, {1, 0}}, {4, {0, 1}}};
  for (const auto& motion :
       {std::shared_ptr<const collision::VertexMotion>(), collision::VertexMotion::morph(keys)}) {
    Guard guard(sheetProblem(motion, 0));
    if (!motion) guard.setVertices("sheet", sheetAt(0), 0, 0.2);
    guard.look(0);
    ASSERT_GT(guard.check({.setpoints = rows, .time = 0}).passed, 10);
    ASSERT_EQ(guard.setVertices("sheet", sheetAt(0), 0.1, 1000), Observation::kTaken);
    EXPECT_FALSE(guard.check({.time = 0.1}).certified);
    guard.look(0.1);
    EXPECT_FALSE(guard.check({.time = 0.1}).certified);
    EXPECT_FALSE(guard.answer().goes_on);
  }
}

TEST(Guard, RestJustBeforeALookIsProvenAsAnyOther) {
  Guard guard(sheetProblem(nullptr, 0));
  guard.setVertices("sheet", sheetAt(-1), 1, 0.1);  // in the disc
  guard.look(1);
  EXPECT_FALSE(guard.check({.time = 1 - 1e-9}).certified);
}

TEST(Guard, AStopKeepsLimitsOnVelocity) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 5}};
  problem.execution.jerks = {{"disc/x", 50}};
  Guard guard(problem);
  std::vector<double> rows, velocity(3), acceleration(3);
  double x = -1, v = 0;
  for (int k = 1; k <= 12; ++k) {
    v += std::min(k, 5) * 0.02;  // 1 m/s at the end, and still faster with every row
    x += v * 0.02;
    rows.insert(rows.end(), {x, -1, 0});
  }
  const GuardAnswer& answer = guard.check({.setpoints = rows});
  EXPECT_GT(answer.passed, 5);
  EXPECT_LT(answer.passed, 12);
  EXPECT_EQ(answer.limit, MotionLimit::kVelocity);
  EXPECT_TRUE(answer.in_stop);
  expectLimits(guard, velocity, acceleration);
}

/// Regression: acceleration that has to end first took it beyond the limit.
TEST(Guard, AStopFromWithinAPeriodKeepsLimitsOnVelocity) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 0.3}};
  problem.execution.accelerations = {{"disc/x", 8}};
  problem.execution.jerks = {{"disc/x", 30}};
  GuardOptions options;
  options.period = 0.1;
  std::vector<double> rows;
  for (int k = 1; k <= 4; ++k) rows.insert(rows.end(), {-1 + 0.029 * k, -1, 0});
  for (const double time : {0.03, 0.048, 0.07}) {
    Guard guard(problem, options);
    ASSERT_EQ(guard.check({.setpoints = rows, .time = 0}).passed, 4);
    const GuardAnswer& stop = guard.check({.time = time});
    EXPECT_TRUE(stop.certified);
    double x = stop.start[0];
    for (std::size_t i = 0; i < stop.motion.size(); i += 3) {
      EXPECT_LE(std::abs(stop.motion[i] - x) / options.period, 0.3 * (1 + 1e-5)) << time;
      x = stop.motion[i];
    }
  }
}

TEST(Guard, VelocityChangesWithinAPeriodAreAccelerations) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 5}};
  const std::vector<double> first = {-1 + 0.002, -1, 0};  // 0.1 m/s
  const auto ask = [&](double speed) {
    Guard guard(problem);
    EXPECT_EQ(guard.check({.setpoints = first, .time = 0}).passed, 1);
    const std::vector<double> next = {-1 + 0.0002 + speed * 0.02, -1, 0};
    return guard.check({.setpoints = next, .time = 0.002}).passed;
  };
  EXPECT_EQ(ask(0.2), 0);  // 50 m/s^2
  EXPECT_EQ(ask(0.1099), 1);
  EXPECT_EQ(ask(0.0901), 1);
  EXPECT_EQ(ask(0), 0);
  // A stop does not brake harder either.
  Guard guard(problem);
  guard.check({.setpoints = first, .time = 0});
  const GuardAnswer& stop = guard.check({.time = 0.002});
  EXPECT_TRUE(stop.certified);
  ASSERT_GE(stop.motion.size(), 3u);
  EXPECT_NEAR((stop.motion[0] - stop.start[0]) / 0.02, 0.09, 1e-9);
  // Under limits on jerk acceleration, 5 m/s^2, falls by no more than 1 in the 2 ms.
  problem.execution.jerks = {{"disc/x", 500}};
  Guard smooth(problem);
  EXPECT_EQ(smooth.check({.setpoints = first, .time = 0}).passed, 1);
  const GuardAnswer& slow = smooth.check({.time = 0.002});
  EXPECT_TRUE(slow.certified);
  EXPECT_FALSE(slow.goes_on);
  ASSERT_GE(slow.motion.size(), 3u);
  EXPECT_NEAR((slow.motion[0] - slow.start[0]) / 0.02, 0.108, 1e-9);
}

/// Regression: jerk was looked at up to the first row of a stop from within a period alone, and was
/// 2.2 times the limit in the second.
TEST(Guard, AStopFromWithinAPeriodKeepsLimitsOnJerk) {
  constexpr double T = 0.02, kMost = 5, kJerk = 100;
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", kMost}};
  problem.execution.jerks = {{"disc/x", kJerk}};
  Random random(3, 0);
  int certified = 0;
  for (int round = 0; round < 300; ++round) {
    Guard guard(problem);
    std::vector<double> rows;
    double x = -1, v = 0, a = 0;
    for (int k = 0; k < 6; ++k) {
      a = std::clamp(a + random.uniform(-0.9, 0.9) * kJerk * T, -kMost, kMost);
      v = std::clamp(v + a * T, -1.0, 1.0);
      x += v * T;
      rows.insert(rows.end(), {x, -1, 0});
    }
    const std::size_t whole = static_cast<std::size_t>(round) % 4;
    if (guard.check({.setpoints = rows, .time = 0}).passed < static_cast<int>(whole) + 1) continue;
    const double since = T * random.uniform(0.05, 0.95);
    const auto velocityTo = [&](std::size_t row) {
      return (rows[3 * row] - (row == 0 ? -1 : rows[3 * row - 3])) / T;
    };
    const double now = velocityTo(whole), last = whole > 0 ? velocityTo(whole - 1) : 0;
    double before = (now - last) / T, speed = now;
    const GuardAnswer& stop = guard.check({.time = static_cast<double>(whole) * T + since});
    ASSERT_TRUE(stop.certified) << round;
    if (stop.goes_on) continue;
    ++certified;
    double place = stop.start[0];
    for (std::size_t k = 0; k < stop.motion.size() / 3 + 2; ++k) {
      const double time = k == 0 ? since : T;
      const double next = 3 * k < stop.motion.size() ? stop.motion[3 * k] : place;
      const double then = (next - place) / T, change = (then - speed) / time;
      EXPECT_LE(std::abs(change), kMost * (1 + 1e-5) + 1e-6 / time) << round << " " << k;
      EXPECT_LE(std::abs(change - before), kJerk * time * (1 + 1e-5) + 1e-9 / time)
          << round << " " << k;
      place = next;
      speed = then;
      before = change;
    }
  }
  EXPECT_GT(certified, 200);
}

/// Regression: plan() alone took the clearance of the objective length as a margin, and others
/// certified what does not keep it.
TEST(Guard, TheClearanceOfTheObjectiveIsAMarginForAll) {
  Problem problem = test::wallProblem();
  const std::vector<double> start = startPoint(problem);
  problem.goals = {test::pointGoal("goal", start)};
  const auto verdict = [&](double clearance) {
    problem.objective = MinimumLength{clearance};
    const auto scene = std::make_shared<const CompiledScene>(problem);
    const bool is_free = EdgeCertifier(scene).decide(start) == Verdict::kFree;
    Path path;
    for (const int v : problem.robot.variables)
      path.names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
    path.positions = {start};
    const bool is_verified = verify(problem, path).status == VerifyStatus::kCertified;
    EXPECT_EQ(is_free, is_verified) << clearance;
    EXPECT_EQ(is_free, Guard(problem).check({}).certified) << clearance;
    // An object that comes later keeps it, too.
    const auto without = scene->withObjects({}, std::vector<int>{scene->bodiesOfRobot()});
    const auto again = without->withObjects(std::vector<Object>{problem.world.objects[0]});
    EXPECT_EQ(is_free, EdgeCertifier(again).decide(start) == Verdict::kFree) << clearance;
    EXPECT_EQ(EdgeCertifier(without).decide(start), Verdict::kFree);
    return is_free;
  };
  const double distance = EdgeCertifier(std::make_shared<const CompiledScene>(problem))
                              .clearance(start, 1e-6)
                              .clearance.lower;
  EXPECT_TRUE(verdict(distance - 0.01));
  EXPECT_FALSE(verdict(distance + 0.01));
  const auto scene = std::make_shared<const CompiledScene>(problem);
  problem.objective = MinimumLength{};
  EXPECT_NE(scene->differenceFrom(problem).find("objective"), std::string::npos);
}

TEST(Guard, AStopDoesNotTurnACircleTheOtherWay) {
  GuardOptions options;
  options.period = 1;
  options.limits = {{10, 10, 10}, {1, 1, 1}, {}};
  Guard guard(test::wallProblem(), options);
  const std::vector<double> place = {-1, -1, 0}, slow = {0, 0, 3.5}, fast = {0, 0, 5};
  EXPECT_TRUE(guard.check({.position = place, .velocity = slow}).certified);
  Guard other(test::wallProblem(), options);
  EXPECT_FALSE(other.check({.position = place, .velocity = fast}).certified);
  EXPECT_EQ(other.answer().reason, GuardReason::kLimit);
}

/// Regression: drivers report the angle of a continuous joint with whole turns, or without them.
TEST(Guard, WholeTurnsOfACircleStayOnTheMotion) {
  for (const double turns : {-3, -1, 1, 2})
    for (const bool follows_measured : {false, true}) {
      Guard guard(test::wallProblem());
      guard.check({});
      const std::vector<double> start(guard.answer().start.begin(), guard.answer().start.end());
      std::vector<double> measured = start, next = start;
      measured[2] += turns * 2 * std::numbers::pi;
      EXPECT_TRUE(guard.check({.position = measured}).certified);
      EXPECT_EQ(guard.answer().start[2], start[2]) << "without setpoints, the commanded turn";
      // Setpoints follow in the turn that was measured, or in the one that is commanded.
      next[2] = (follows_measured ? measured : start)[2] + 1e-4;
      EXPECT_EQ(guard.check({.setpoints = next, .position = measured}).passed, 1) << turns;
      EXPECT_NEAR(guard.answer().start[2], next[2] - 1e-4, 1e-12);
      measured[2] += 0.1;
      guard.check({.position = measured});
      EXPECT_EQ(guard.answer().start[2], measured[2]) << "it is elsewhere";
    }
}

TEST(Guard, ARobotWithoutAStopIsNotTakenToRest) {
  Guard guard(test::wallProblem());
  const std::vector<double> place = {-1, -1, 0}, fast = {1e6, 0, 0};
  EXPECT_FALSE(guard.check({.position = place, .velocity = fast}).certified);
  EXPECT_EQ(guard.answer().reason, GuardReason::kLimit);
  EXPECT_EQ(guard.answer().limit, MotionLimit::kVelocity);
  EXPECT_EQ(guard.answer().variable, 0);
  EXPECT_EQ(guard.answer().value, 1e6);
  EXPECT_FALSE(guard.check({}).certified);
  EXPECT_FALSE(guard.check({}).certified);
  EXPECT_TRUE(guard.check({.position = place}).certified);
}

TEST(Guard, UnequalMarginsDoNotStopTheRobot) {
  Problem problem = test::wallProblem();
  problem.start = {-0.4, -1, 0};
  problem.world.objects.push_back(test::box("far", {0.1, 0.1, 0.1}, 1.8, -1.8, 0));
  problem.margins.pairs.push_back({"disc", "far", 0.5});
  problem.execution.accelerations = {{"disc/y", 1}};
  Guard guard(problem);
  std::vector<double> rows;
  double y = -1, v = 0;
  for (int k = 0; k < 20; ++k) {
    v += 0.02;
    y += v * 0.02;
    rows.insert(rows.end(), {-0.4, y, 0});
  }
  EXPECT_EQ(guard.check({.setpoints = rows}).passed, 20);
}

TEST(Guard, StopsThatLeaveTheLimitsAreWork) {
  Problem problem = test::wallProblem();
  problem.execution.velocities = {{"disc/x", 1}};
  problem.execution.accelerations = {{"disc/x", 0.1}};
  std::vector<double> rows;
  double x = -1, v = 0;
  for (int k = 0; k < 220; ++k) {
    v -= 0.1 * 0.02;
    x += v * 0.02;
    rows.insert(rows.end(), {x, -1, 0});
  }
  GuardOptions options;
  options.most_setpoints = 300;
  // Setpoints beyond the middle have no room for a stop, so stops of up to 220 rows are tried.
  EXPECT_GT(Guard(problem, options).check({.setpoints = rows}).passed, 100);
  options.work = 20'000;
  Guard guard(problem, options);
  const GuardAnswer& answer = guard.check({.setpoints = rows});
  EXPECT_EQ(answer.passed, 0);
  EXPECT_TRUE(answer.in_stop);
  EXPECT_EQ(answer.limit, MotionLimit::kPosition);
}

}  // namespace
}  // namespace leeway::planner
