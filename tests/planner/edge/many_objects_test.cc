// Worlds of many things: what is far is skipped by a hierarchy, which may change no answer.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "tests/support/small_problems.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::planner {
namespace {

using oracle::Random;

constexpr int kObjects = 600;
// Worlds of so few things that no hierarchy stands above them.
constexpr int kShare = 50;

collision::Shape someShape(Random& random) {
  const double r = random.uniform(0.01, 0.08), h = random.uniform(0.01, 0.2);
  switch (random.below(4)) {
    case 0:
      return collision::Shape::sphere(r);
    case 1:
      return collision::Shape::capsule(r, h);
    case 2:
      return collision::Shape::cylinder(r, h);
    default:
      return collision::Shape::box({r, h, r});
  }
}

/// A flying box among shapes all around, on a floor.
Problem crowd(Random& random) {
  Problem problem =
      test::problemOf(test::flyingBox(), {0, 0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 0, 1});
  collision::Pose X_WF;
  X_WF.translation.z() = -1.2;
  problem.world.objects.push_back({"floor", {{collision::Shape::halfSpace(), {}, "floor"}}, X_WF});
  for (int i = 1; i < kObjects; ++i) {
    const Eigen::Vector3d p(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-1, 4));
    problem.world.objects.push_back(
        {"thing " + std::to_string(i), {{someShape(random), {}, "shape"}}, {random.rotation(), p}});
  }
  problem.contacts.allowed.emplace_back("flyer", "thing 7");
  problem.margins.common = 0.01;
  problem.margins.pairs.push_back({"thing 8", "flyer", 0.3});
  return problem;
}

std::vector<double> somewhere(Random& random) {
  std::vector<double> q;
  for (int i = 0; i < 3; ++i) q.push_back(random.uniform(-0.95, 0.95));
  const Eigen::Quaterniond turn(random.rotation());
  for (const double x : turn.coeffs()) q.push_back(x);
  return q;
}

/// The same world in shares.
class Shares {
 public:
  explicit Shares(const CompiledScene& scene) {
    const auto bodies = static_cast<int>(scene.scene().bodies().size());
    for (int first = 0; first < bodies; first += kShare)
      certifiers_.emplace_back(scene.withPairs([&](const collision::ScenePair& pair) {
        return pair.body_b >= first && pair.body_b < first + kShare;
      }));
  }
  /// The worst of all shares: not free before undecided before free.
  template <class Ask>
  Verdict worst(const Ask& ask) {
    Verdict worst = Verdict::kFree;
    for (EdgeCertifier& certifier : certifiers_) {
      const Verdict verdict = ask(certifier);
      if (verdict == Verdict::kNotFree) return verdict;
      if (verdict == Verdict::kUndecided) worst = verdict;
    }
    return worst;
  }
  std::deque<EdgeCertifier>& certifiers() { return certifiers_; }

 private:
  std::deque<EdgeCertifier> certifiers_;
};

TEST(ManyObjects, AnswersAreThoseOfSmallWorlds) {
  Random random(31);
  const Problem problem = crowd(random);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EXPECT_EQ(scene->scene().pairs().size(), static_cast<std::size_t>(kObjects - 1));
  EdgeCertifier certifier(scene);
  Shares shares(*scene);
  int free = 0, not_free = 0;
  for (int i = 0; i < 400; ++i) {
    const std::vector<double> a = somewhere(random);
    std::vector<double> b = i % 2 == 0 ? somewhere(random) : a;
    if (i % 2 != 0)
      for (int k = 0; k < 3; ++k) b[static_cast<std::size_t>(k)] *= 0.9;
    EXPECT_EQ(certifier.decide(a), shares.worst([&](EdgeCertifier& share) {
      return share.decide(a);
    })) << i;
    const Verdict edge = certifier.certify(a, b).verdict;
    EXPECT_EQ(edge, shares.worst([&](EdgeCertifier& share) { return share.certify(a, b).verdict; }))
        << i;
    free += edge == Verdict::kFree;
    not_free += edge == Verdict::kNotFree;
  }
  EXPECT_GT(free, 30);
  EXPECT_GT(not_free, 30);
}

TEST(ManyObjects, ClearanceIsTheLeastOfSmallWorlds) {
  Random random(32);
  Problem problem = crowd(random);
  const auto scene = std::make_shared<const CompiledScene>(problem);
  EdgeCertifier certifier(scene);
  Shares shares(*scene);
  constexpr double kTolerance = 1e-4, kNoCutoff = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < 60; ++i) {
    const std::vector<double> a = somewhere(random);
    std::vector<double> b = a;
    for (int k = 0; k < 3; ++k) b[static_cast<std::size_t>(k)] *= 0.8;
    const collision::Interval whole =
        certifier.edgeClearance(a, b, kTolerance, kNoCutoff).clearance;
    double lower = whole.upper, upper = whole.upper + 1;
    for (EdgeCertifier& share : shares.certifiers()) {
      const collision::Interval part = share.edgeClearance(a, b, kTolerance, kNoCutoff).clearance;
      lower = std::min(lower, part.lower);
      upper = std::min(upper, part.upper);
    }
    EXPECT_LE(whole.lower, upper) << i;
    EXPECT_LE(lower, whole.upper) << i;
    EXPECT_LE(whole.upper - whole.lower, 2 * kTolerance) << i;
  }
}

// Names of allowed pairs and margins are looked up, not compared with all pairs.
TEST(ManyObjects, PairsAndMarginsAreFoundByName) {
  Random random(33);
  const CompiledScene scene(crowd(random));
  int wide = 0;
  for (const collision::ScenePair& pair : scene.scene().pairs()) {
    const std::string& name = scene.scene().bodies()[static_cast<std::size_t>(pair.body_b)].name;
    EXPECT_NE(name, "thing 7");
    EXPECT_EQ(pair.margin, name == "thing 8" ? 0.3 : 0.01) << name;
    wide += name == "thing 8";
  }
  EXPECT_EQ(wide, 1);
  ASSERT_EQ(scene.dropped().size(), 1U);
  EXPECT_EQ(scene.dropped()[0].b, "thing 7");
}

}  // namespace
}  // namespace leeway::planner
