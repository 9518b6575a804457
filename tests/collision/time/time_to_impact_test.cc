#include "leeway/collision/time_to_impact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/base/numbers.h"
#include "tests/support/sanitized.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

long double extended(double x) { return static_cast<long double>(x); }

/// Slow twin in extended precision: how far the fastest allowed motion gets within t.
long double reach(const PointMotion& m, long double t) {
  const long double cap = extended(m.speed_cap), a = extended(m.acceleration),
                    v = std::min(extended(m.speed), cap);
  if (a == 0 || v >= cap) return v * t;
  const long double rising = std::min(t, (cap - v) / a);
  return v * rising + a * rising * rising / 2 + (t - rising > 0 ? cap * (t - rising) : 0);
}

TEST(TimeToImpact, GapIsUsedUpNeverEarlierAndHardlyLater) {
  oracle::Random random(5);
  int capped = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto power = [&] { return std::pow(10.0, random.uniform(-6, 4)); };
    PointMotion m{random.uniform(0, 1) < 0.2 ? 0 : power(),
                  random.uniform(0, 1) < 0.2 ? 0 : power(),
                  random.uniform(0, 1) < 0.5 ? kInfinity : power()};
    if (m.speed == 0 && m.acceleration == 0) continue;
    const double gap = power();
    const double t = timeToImpact(gap, m);
    ASSERT_TRUE(std::isfinite(t));
    EXPECT_LE(reach(m, extended(t)), extended(gap)) << i;
    EXPECT_GE(reach(m, extended(t) * (1 + 1e-13L)), extended(gap) * (1 - 1e-12L)) << i;
    capped += m.speed + m.acceleration * t > m.speed_cap;
  }
  EXPECT_GT(capped, 2000);
}

TEST(TimeToImpact, EdgesOfTheDomain) {
  EXPECT_EQ(timeToImpact(0, {1, 1}), 0);
  EXPECT_EQ(timeToImpact(-1, {0, 0}), 0);
  EXPECT_EQ(timeToImpact(1, {0, 0}), kInfinity);
  EXPECT_EQ(timeToImpact(1, {kInfinity, kInfinity, 0}), kInfinity);
  EXPECT_EQ(timeToImpact(1, {kInfinity, 0}), 0);
  EXPECT_EQ(timeToImpact(kInfinity, {1, 1}), kInfinity);
  EXPECT_EQ(timeToImpact(kInfinity, {kInfinity, kInfinity}), 0);
  EXPECT_NEAR(timeToImpact(1, {0, kInfinity, 2}), 0.5, 1e-14);
  const double nan = std::nan("");
  EXPECT_EQ(timeToImpact(nan, {0, 0}), 0);
  EXPECT_EQ(timeToImpact(1, {nan, 0}), 0);
  EXPECT_EQ(timeToImpact(1, {0, nan}), 0);
  EXPECT_EQ(timeToImpact(1, {0, 0, nan}), 0);
  EXPECT_EQ(timeToImpact(1, {-1, 0}), 0);
  EXPECT_GT(timeToImpact(1e300, {1e-300, 0}), 1e300);
}

/// A body that swings and turns, with bounds in closed form.
struct Swing {
  Eigen::Vector3d center, amplitude, axis;
  double frequency, spin, radius;

  Pose at(double t) const {
    Pose X;
    X.rotation = Eigen::AngleAxisd(spin * t, axis).toRotationMatrix();
    X.translation = center + amplitude * std::sin(frequency * t);
    return X;
  }
  PointMotion motion(double t) const {
    const double a = amplitude.norm() * frequency;
    return {(a * std::abs(std::cos(frequency * t)) + spin * radius) * (1 + 1e-12) + 1e-12,
            (a * frequency + spin * spin * radius) * (1 + 1e-12),
            (a + spin * radius) * (1 + 1e-12)};
  }
};

struct Crowd {
  Scene scene;
  std::vector<Swing> swings;  // of those that move

  /// `lists`: all pairs are listed, and checked one by one.
  Crowd(int moving, int still, std::uint64_t seed, bool lists = false) {
    oracle::Random random(seed);
    SceneBuilder builder;
    if (lists) builder.listAll();
    for (int i = 0; i < moving + still; ++i) {
      Body body;
      body.name = "body" + std::to_string(i);
      body.moving = i < moving;
      const Eigen::Vector3d half(random.uniform(0.05, 0.3), random.uniform(0.05, 0.3),
                                 random.uniform(0.05, 0.3));
      body.geometries.push_back({Shape::box(half), Pose{}, ""});
      const auto vector = [&](double size) {
        return Eigen::Vector3d(random.uniform(-size, size), random.uniform(-size, size),
                               random.uniform(-size, size));
      };
      if (!body.moving) body.X_WB.translation = vector(2);
      builder.add(body);
      if (!body.moving) continue;
      swings.push_back({vector(1), vector(0.5), vector(1).normalized(), random.uniform(0.1, 3),
                        random.uniform(0, 2), half.norm()});
    }
    builder.setDefaultMargin(0.01);
    scene = builder.build();
  }
  void place(double t, Workspace& workspace) const {
    for (std::size_t b = 0; b < swings.size(); ++b)
      workspace.setPose(static_cast<int>(b), swings[b].at(t));
  }
};

/// The reports of a schedule about a swinging crowd, compared with checks of all pairs.
struct Watch {
  int pairs = 0, met = 0, unsafe = 0, missed = 0, imminent = 0;
  std::uint64_t looks = 0, exact = 0;
};

Watch watched(const Crowd& crowd, int steps) {
  Watch run;
  run.pairs = static_cast<int>(crowd.scene.pairs().size());
  Workspace workspace(crowd.scene), truth(crowd.scene);
  ImpactSchedule schedule(crowd.scene);
  std::vector<char> below(static_cast<std::size_t>(run.pairs), 0);
  const double dt = 0.01;
  for (int k = 0; k < steps; ++k) {
    const double t = k * dt;
    for (std::size_t b = 0; b < crowd.swings.size(); ++b)
      schedule.setMotion(static_cast<int>(b), crowd.swings[b].motion(t), t);
    crowd.place(t, workspace);
    const ImpactReport report = schedule.advance(t, dt, workspace);
    EXPECT_EQ(report.safe_until, schedule.safeUntil());
    EXPECT_EQ(schedule.due(report.next_pair), report.safe_until);
    EXPECT_EQ(static_cast<std::size_t>(report.imminent), schedule.imminent().size());
    EXPECT_TRUE(std::is_sorted(schedule.imminent().begin(), schedule.imminent().end()));
    run.imminent += report.imminent;
    std::vector<char> imminent(static_cast<std::size_t>(run.pairs), 0);
    for (const std::int32_t p : schedule.imminent()) imminent[static_cast<std::size_t>(p)] = 1;
    // Brute force: every pair at times within the step.
    for (int s = 0; s < 4; ++s) {
      const double now = t + dt * s / 4;
      crowd.place(now, truth);
      for (int p = 0; p < run.pairs; ++p) {
        DistanceRequest request;
        request.threshold = 0.01;
        const bool touches = pairDistance(crowd.scene, truth, p, request).distance.upper <= 0.01;
        if (!touches) continue;
        below[static_cast<std::size_t>(p)] = 1;
        run.unsafe += now < schedule.due(p);
        run.missed += !imminent[static_cast<std::size_t>(p)];
      }
    }
  }
  for (const char b : below) run.met += b;
  run.looks = schedule.statistics.looks;
  run.exact = schedule.statistics.exact;
  return run;
}

TEST(ImpactSchedule, NothingTouchesBeforeItSays) {
  const Watch run = watched(Crowd(12, 0, 3), 800);
  EXPECT_EQ(run.unsafe, 0);
  EXPECT_EQ(run.missed, 0);
  EXPECT_GT(run.met, 10);         // pairs that meet
  EXPECT_LT(run.met, run.pairs);  // and not all
  EXPECT_LT(run.exact * 4, 800u * static_cast<unsigned>(run.pairs));
}

TEST(ImpactSchedule, NothingTouchesBeforeItSaysInRows) {
  const Crowd listed(3, 200, 3, true), rows(3, 200, 3);
  ASSERT_TRUE(listed.scene.pairs().rows().empty());
  ASSERT_EQ(rows.scene.pairs().rows().size(), 3u);
  const int steps = isBrief() ? 60 : 300;
  const Watch twin = watched(listed, steps), run = watched(rows, steps);
  EXPECT_EQ(run.pairs, twin.pairs);
  EXPECT_EQ(run.met, twin.met);
  EXPECT_GT(run.met, steps / 60);
  EXPECT_EQ(run.unsafe, 0);
  EXPECT_EQ(run.missed, 0);
  EXPECT_LT(run.exact * 40, static_cast<unsigned>(steps * run.pairs));
  EXPECT_LT(run.imminent, 2 * twin.imminent);
  EXPECT_LT(run.looks * 10, static_cast<unsigned>(steps * run.pairs));
}

/// A moving ball at the origin, and boxes in a row along x, each 10 m from the next. `lists`: all
/// pairs are listed.
Scene rowOfBoxes(int boxes, bool lists = false, double radius = 0.5) {
  SceneBuilder builder;
  if (lists) builder.listAll();
  Body ball;
  ball.name = "ball";
  ball.moving = true;
  ball.geometries.push_back({Shape::sphere(radius), Pose{}, ""});
  builder.add(ball);
  for (int i = 1; i <= boxes; ++i) {
    Body box;
    box.name = "box" + std::to_string(i);
    box.geometries.push_back({Shape::box({0.5, 0.5, 0.5}), Pose{}, ""});
    box.X_WB.translation = {10.0 * i, 0, 0};
    builder.add(box);
  }
  return builder.build();
}

TEST(ImpactSchedule, RowsAreDueWithTheirNearest) {
  const Scene scene = rowOfBoxes(500);
  Workspace workspace(scene);
  ImpactSchedule schedule(scene);
  EXPECT_EQ(schedule.safeUntil(), -kInfinity);
  schedule.setMotion(0, {1, 0, 1}, 0);
  const ImpactReport far = schedule.advance(0, 0.01, workspace);
  EXPECT_GT(far.safe_until, 3);  // the gap is 9 m; the search doubles its reach
  EXPECT_LE(far.safe_until, 9);
  EXPECT_EQ(far.next_pair, 0);
  EXPECT_EQ(far.imminent, 0);
  EXPECT_LT(schedule.statistics.looks, 10u);
  // Between boxes 2 and 3, closer to the former.
  workspace.setPose(0, {Eigen::Matrix3d::Identity(), {21.1, 0, 0}});
  const ImpactReport near = schedule.advance(9, 0.2, workspace);
  EXPECT_NEAR(near.safe_until, 9.1, 1e-3);
  EXPECT_EQ(near.next_pair, 1);
  ASSERT_EQ(near.imminent, 1);
  EXPECT_EQ(schedule.imminent()[0], 1);
  EXPECT_EQ(near.violated, 0);
}

// Regression: a fixed body counted as one with a known infinite speed, so a speed without
// acceleration did not make it due.
TEST(ImpactSchedule, WhatStandsStillMayMoveAllTheSame) {
  for (const bool lists : {false, true}) {
    const Scene scene = rowOfBoxes(500, lists);
    EXPECT_EQ(scene.pairs().rows().empty(), lists);
    Workspace workspace(scene);
    ImpactSchedule schedule(scene);
    schedule.setMotion(0, {0, 0, 0}, 0);
    EXPECT_EQ(schedule.advance(0, 0.01, workspace).safe_until, kInfinity);
    schedule.setMotion(400, {90, 0, 90}, 1);  // at x = 4000
    EXPECT_EQ(schedule.safeUntil(), 1);
    const ImpactReport report = schedule.advance(1, 0.01, workspace);
    EXPECT_LE(report.safe_until, 1 + 3999 / 90.0);
    EXPECT_GT(report.safe_until, 1);
    schedule.setMotion(400, {90, std::nan(""), 90}, 1);
    EXPECT_EQ(schedule.advance(1, 0.01, workspace).imminent, lists ? 1 : 500);
  }
}

// Regression: the first reach of a fixed point was 0, and doubled for ever.
TEST(ImpactSchedule, PointsInRowsHaveAReach) {
  for (const PointMotion& motion :
       {PointMotion{0, 0, 0}, PointMotion{1, 0, 1}, PointMotion{kInfinity, kInfinity, kInfinity}}) {
    for (const double horizon : {0.0, 0.01}) {
      const Scene scene = rowOfBoxes(20, false, 0);
      Workspace workspace(scene);
      ImpactSchedule schedule(scene);
      schedule.setMotion(0, motion, 0);
      const ImpactReport report = schedule.advance(0, horizon, workspace);
      const double slowest = motion.speed == 0 ? kInfinity : 9.5 / motion.speed;
      EXPECT_LE(report.safe_until, slowest);
      EXPECT_GE(report.safe_until, slowest / 2 - 1e-9);
    }
  }
}

TEST(ImpactSchedule, RowsWithoutPairsAreNeverDue) {
  SceneBuilder builder;
  for (int i = 0; i < 5; ++i) {
    Body body{"body" + std::to_string(i), {{Shape::sphere(0.5), {}, ""}}, i < 2, {}};
    body.X_WB.translation.x() = i < 2 ? 0 : 10.0 * i;
    builder.add(body);
  }
  for (int i = 0; i < 5; ++i) builder.allow(0, i);
  const Scene scene = builder.build();
  ASSERT_EQ(scene.pairs().size(), 3u);
  Workspace workspace(scene);
  ImpactSchedule schedule(scene);
  schedule.setMotion(1, {1, 0, 1}, 0);  // the motion of body 0 is unknown
  const ImpactReport report = schedule.advance(0, 0.01, workspace);
  EXPECT_GT(report.safe_until, 9);
  EXPECT_LE(report.safe_until, 19);
  EXPECT_EQ(report.next_pair, scene.pairs().numberOf(1, 0));
  schedule.setMotion(0, {3, 0, 3}, 1);
  EXPECT_EQ(schedule.safeUntil(), report.safe_until);
}

TEST(ImpactSchedule, WhatIsNoMotionIsDueAtOnce) {
  EXPECT_EQ(timeToImpact(1, closing({2, 0, 2}, {-2, 0, 2})), 0);
  EXPECT_EQ(timeToImpact(1, closing({2, 0, 2}, {0, std::nan(""), 2})), 0);
  // With a fixed body, the cap is that of the other body; a body without acceleration contributes
  // its speed.
  EXPECT_NEAR(timeToImpact(1, closing({0, kInfinity, 2}, {0, 0})), 0.5, 1e-12);
  EXPECT_NEAR(timeToImpact(3, closing({0, kInfinity, 2}, {1, 0})), 1, 1e-12);
  for (const bool lists : {false, true}) {
    const Scene scene = rowOfBoxes(5, lists);
    Workspace workspace(scene);
    ImpactSchedule schedule(scene);
    schedule.setMotion(0, {0, 0, 0}, 0);
    schedule.advance(0, 0.01, workspace);
    schedule.setMotion(0, {5, 0, 5}, std::nan(""));
    EXPECT_EQ(schedule.safeUntil(), -kInfinity);
    EXPECT_LE(schedule.advance(1, 0.01, workspace).safe_until, 1 + 9 / 5.0);
    schedule.setMotion(3, {-5, 0, 5}, 1);
    EXPECT_GT(schedule.advance(1, 0.01, workspace).imminent, 0);
  }
}

TEST(ImpactSchedule, UnknownMotionsAreImminentInRowsToo) {
  const Scene scene = rowOfBoxes(70'000);
  Workspace workspace(scene);
  ImpactSchedule schedule(scene);
  const ImpactReport report = schedule.advance(0, 0.01, workspace);
  EXPECT_EQ(report.imminent, 70'000);
  ASSERT_EQ(schedule.imminent().size(), ImpactSchedule::kMostNamed);
  EXPECT_EQ(schedule.imminent()[1], 1);
  EXPECT_LE(report.safe_until, 0);
  EXPECT_EQ(schedule.due(69'999), report.safe_until);
  workspace.setPose(0, {Eigen::Matrix3d::Identity(), {std::nan(""), 0, 0}});
  schedule.setMotion(0, {0, 0, 0}, 0);
  EXPECT_EQ(schedule.advance(0, 0.01, workspace).imminent, 70'000);
}

TEST(ImpactSchedule, FasterThanSaidIsLookedAtAgain) {
  SceneBuilder builder;
  for (const char* name : {"a", "b"}) {
    Body body;
    body.name = name;
    body.moving = true;
    body.geometries.push_back({Shape::sphere(0.1), Pose{}, ""});
    builder.add(body);
  }
  const Scene scene = builder.build();
  Workspace workspace(scene);
  workspace.setPose(1, {Eigen::Matrix3d::Identity(), {1.2, 0, 0}});
  ImpactSchedule schedule(scene);
  EXPECT_EQ(schedule.safeUntil(), -kInfinity);
  EXPECT_LT(schedule.advance(0, 1, workspace).safe_until, 0.01);  // unknown motions
  schedule.setMotion(0, {0.5, 0, 1}, 0);
  schedule.setMotion(1, {0, 0, 0}, 0);
  EXPECT_NEAR(schedule.advance(0, 1, workspace).safe_until, 2, 1e-3);
  EXPECT_EQ(schedule.statistics.looks, 2u);
  schedule.setMotion(0, {0.4, 0, 1}, 0.5);  // slower: no change
  EXPECT_NEAR(schedule.safeUntil(), 2, 1e-3);
  schedule.setMotion(0, {0.8, 0, 1}, 0.5);
  EXPECT_LE(schedule.safeUntil(), 0.5);
  EXPECT_NEAR(schedule.advance(0.5, 0.1, workspace).safe_until, 1.75, 1e-3);
  const double nan = std::nan("");
  EXPECT_EQ(schedule.advance(nan, 0.1, workspace).safe_until, -kInfinity);
  EXPECT_EQ(schedule.advance(0.5, nan, workspace).safe_until, -kInfinity);
  workspace.setPose(1, {Eigen::Matrix3d::Identity(), {0.15, 0, 0}});
  schedule.setMotion(1, {9, 0, 9}, 0.5);
  const ImpactReport report = schedule.advance(0.6, 0.1, workspace);
  EXPECT_EQ(report.violated, 1);
  EXPECT_EQ(report.imminent, 1);
  EXPECT_EQ(schedule.imminent()[0], 0);
  EXPECT_EQ(report.next_pair, 0);
}

TEST(ImpactSchedule, NoPairsAreSafeForever) {
  const Scene scene = SceneBuilder().build();
  Workspace workspace(scene);
  ImpactSchedule schedule(scene);
  const ImpactReport report = schedule.advance(0, 1, workspace);
  EXPECT_EQ(report.safe_until, kInfinity);
  EXPECT_EQ(report.next_pair, -1);
}

}  // namespace
}  // namespace leeway::collision
