#include "collision/lanes/lane_frames.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/support/every_target.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::collision {
namespace {

using oracle::Random;

struct Chain {
  std::vector<FrameStep> steps;
  std::vector<double> lengths;
};

/// A rotation that maps axes to axes up to rounding.
Eigen::Matrix3f axesToAxes(Random& random) {
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Zero();
  const int first = random.below(3), second = (first + 1 + random.below(2)) % 3;
  rotation(first, 0) = random.chance(0.5) ? 1 : -1;
  rotation(second, 1) = random.chance(0.5) ? 1 : -1;
  rotation.col(2) = rotation.col(0).cross(rotation.col(1));
  for (int i = 0; i < 9; ++i)
    if (random.chance(0.5)) rotation(i) += random.chance(0.5) ? 0x1p-24F : -0x1p-24F;
  return rotation;
}

Chain randomChain(Random& random) {
  Chain chain;
  const int count = 1 + random.below(9);
  for (int i = 0; i < count; ++i) {
    FrameStep step;
    step.parent = i - 1;
    Eigen::Matrix3f rotation = random.rotation().cast<float>();
    const bool has_axes = random.chance(0.5);
    if (has_axes) rotation = axesToAxes(random);
    const Eigen::Vector3f t = (random.direction() * random.uniform(0, 0.6)).cast<float>();
    std::copy(rotation.data(), rotation.data() + 9, step.rotation);
    std::copy(t.data(), t.data() + 3, step.translation);
    if (has_axes) findAxes(step);
    double length = t.cast<double>().norm();
    step.angle = static_cast<float>(random.uniform(-3.14, 3.14));
    if (random.chance(0.9)) step.turn = static_cast<float>(random.uniform(-7, 7));
    if (random.chance(0.3)) {
      const Eigen::Vector3f slide = (random.direction() * random.uniform(0, 0.5)).cast<float>();
      std::copy(slide.data(), slide.data() + 3, step.slide);
      length += slide.cast<double>().norm() / 2;
    }
    chain.steps.push_back(step);
    chain.lengths.push_back(length);
  }
  return chain;
}

/// Slow twin: position of a point of the last frame at t, in double precision.
Eigen::Vector3d placeAt(const Chain& chain, const Eigen::Vector3d& r, double t) {
  Eigen::Vector3d p = r;
  for (std::size_t i = chain.steps.size(); i-- > 0;) {
    const FrameStep& s = chain.steps[i];
    const Eigen::Matrix3d rotation = Eigen::Map<const Eigen::Matrix3f>(s.rotation).cast<double>();
    const Eigen::Vector3d translation =
        Eigen::Map<const Eigen::Vector3f>(s.translation).cast<double>();
    const Eigen::Vector3d slide = Eigen::Map<const Eigen::Vector3f>(s.slide).cast<double>();
    const double angle = static_cast<double>(s.angle) + (t - 0.5) * static_cast<double>(s.turn);
    p = rotation * (Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * p) + translation +
        (t - 0.5) * slide;
  }
  return p;
}

Eigen::Vector3d laneOf(const LaneValues* v, int lane) {
  return Eigen::Vector3f(v[0].at[lane], v[1].at[lane], v[2].at[lane]).cast<double>();
}

/// Frames at the middles of the intervals begin + [k, k + 1] width / kLanes, and their motions.
void placeAndMove(const std::vector<FrameStep>& steps, std::vector<LaneFrame>& frames,
                  double begin = 0, double width = 1) {
  LaneValues middles;
  for (int i = 0; i < kLanes; ++i)
    middles.at[i] = static_cast<float>(begin - 0.5 + (i + 0.5) * width / kLanes);
  placeFrames(steps, middles, frames);
  moveFrames(steps, middles, static_cast<float>(width / kLanes), frames);
}

TEST(LaneFrames, AreWithinTheirBoundOfDoublePrecision) {
  Random random(11);
  double worst = 0, worst_way = 0;
  for (int round = 0; round < 300; ++round) {
    const Chain chain = randomChain(random);
    const std::size_t n = chain.steps.size();
    std::vector<LaneFrame> frames(n);
    const int parts = 1 << random.below(5);
    const double width = 1.0 / parts, begin = width * random.below(parts);
    placeAndMove(chain.steps, frames, begin, width);
    const Eigen::Vector3d r = random.direction() * random.uniform(0, 0.3);
    double tail = r.norm(), bound = kLaneRounding * tail, slides = 0, turns = 0;
    for (std::size_t i = n; i-- > 0;) {
      tail += chain.lengths[i];
      bound += kLaneRounding * tail;
      turns += std::abs(static_cast<double>(chain.steps[i].turn)) / (2 * kLanes);
      slides += Eigen::Map<const Eigen::Vector3f>(chain.steps[i].slide).cast<double>().norm() /
                (2 * kLanes);
    }
    const double way_bound = 4 * turns * kLaneRounding * static_cast<double>(n + 1) * tail +
                             2 * static_cast<double>(n) * kLaneRounding * slides;
    for (int lane = 0; lane < kLanes; ++lane) {
      const LaneFrame& f = frames[n - 1];
      const double t = begin + (lane + 0.5) * width / kLanes;
      Eigen::Matrix3d rotation;
      for (int i = 0; i < 9; ++i) rotation.data()[i] = static_cast<double>(f.rotation[i].at[lane]);
      const Eigen::Vector3d arm = rotation * r;
      const double error = (laneOf(f.origin, lane) + arm - placeAt(chain, r, t)).norm();
      ASSERT_LE(error, bound) << "round " << round << " lane " << lane;
      worst = std::max(worst, error / bound);
      // Half an interval's displacement, from a fourth-order difference.
      constexpr double e = 1e-3;
      const Eigen::Vector3d way = (8 * (placeAt(chain, r, t + e) - placeAt(chain, r, t - e)) -
                                   (placeAt(chain, r, t + 2 * e) - placeAt(chain, r, t - 2 * e))) /
                                  (12 * e) * width / (2 * kLanes);
      const double way_error =
          (laneOf(f.slide, lane) + laneOf(f.turn, lane).cross(arm) - way).norm();
      ASSERT_LE(way_error, way_bound + 1e-7) << "round " << round << " lane " << lane;
      worst_way = std::max(worst_way, way_error / (way_bound + 1e-7));
    }
  }
  // Bounds are tight enough to reveal an error of a few units.
  EXPECT_GT(worst, 0.01);
  EXPECT_GT(worst_way, 0.001);
}

TEST(LaneFrames, FindAxesWhereTheyMapToAxes) {
  Random random(13);
  const auto axesOf = [](const Eigen::Matrix3f& rotation) {
    FrameStep step;
    std::copy(rotation.data(), rotation.data() + 9, step.rotation);
    std::fill_n(step.axis, 3, std::int8_t{2});  // old values
    findAxes(step);
    return std::vector<int>(step.axis, step.axis + 3);
  };
  const std::vector<int> none(3, 0);
  Eigen::Matrix3f known;
  known << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  EXPECT_EQ(axesOf(known), (std::vector<int>{2, -3, -1}));
  for (int round = 0; round < 100; ++round) {
    const Eigen::Matrix3f rotation = axesToAxes(random);
    const std::vector<int> axes = axesOf(rotation);
    ASSERT_NE(axes, none);
    for (int i = 0; i < 3; ++i) {
      const int axis = axes[static_cast<std::size_t>(i)];
      const Eigen::Vector3f unit = Eigen::Vector3f::Unit(std::abs(axis) - 1) * (axis < 0 ? -1 : 1);
      EXPECT_LE((rotation.col(i) - unit).cwiseAbs().maxCoeff(), 0x1p-24F);
    }
    EXPECT_EQ(axesOf(random.rotation().cast<float>()), none);
    Eigen::Matrix3f turned = rotation;
    turned(random.below(9)) += 0x1p-22F;
    EXPECT_EQ(axesOf(turned), none);
  }
  EXPECT_EQ(axesOf(Eigen::Matrix3f::Zero()), none);
  EXPECT_EQ(axesOf(Eigen::Matrix3f::Constant(NAN)), none);
}

TEST(LaneFrames, HaveTheSameBitsOnEveryInstructionSet) {
  Random random(12);
  std::vector<Chain> chains;
  for (int i = 0; i < 20; ++i) chains.push_back(randomChain(random));
  LaneGrowth growth;
  std::vector<LaneGrowth::Term> terms;
  for (int i = 0; i < 37; ++i) {
    terms.clear();
    for (int k = 0; k < 1 + i % 5; ++k)
      terms.push_back({random.below(4), random.uniform(0, 2), random.chance(0.8)});
    growth.add(terms);
  }
  const std::vector<float> motion = {0.3F, 1.1F, 0.01F, 2.2F};
  std::vector<std::vector<float>> results;
  onEveryTarget([&](const char*) {
    std::vector<float>& bits = results.emplace_back();
    for (const Chain& chain : chains) {
      std::vector<LaneFrame> frames(chain.steps.size());
      placeAndMove(chain.steps, frames);
      const auto* begin = reinterpret_cast<const float*>(frames.data());
      bits.insert(bits.end(), begin, begin + frames.size() * sizeof(LaneFrame) / sizeof(float));
    }
    std::vector<float> sums(growth.paddedSize());
    growth.run(motion, sums);
    bits.insert(bits.end(), sums.begin(), sums.end());
  });
  ASSERT_FALSE(results.empty());
  for (const std::vector<float>& bits : results)
    EXPECT_EQ(std::memcmp(bits.data(), results[0].data(), bits.size() * sizeof(float)), 0);
}

TEST(LaneGrowth, SumsWhatASlowTwinSums) {
  Random random(13);
  LaneGrowth growth;
  std::vector<std::vector<LaneGrowth::Term>> motions(50);
  for (auto& terms : motions) {
    const int count = random.below(12);
    for (int k = 0; k < count; ++k) {
      const bool turns = random.chance(0.7);
      terms.push_back({random.below(6), turns ? random.uniform(0, 2) : 1, turns});
    }
    growth.add(terms);
  }
  const std::vector<float> joints = {0.3F, 1.1F, 0.01F, 2.2F, 0.5F, 3.1F};
  std::vector<float> sums(growth.paddedSize());
  growth.run(joints, sums);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    double speed = 0, acceleration = 0;
    for (const LaneGrowth::Term& term : motions[i]) {
      const double m = static_cast<double>(joints[static_cast<std::size_t>(term.motion)]);
      if (term.turns) acceleration += m * (m * term.reach + 2 * speed);
      speed += m * term.reach;
    }
    const double expected = acceleration / (8.0 * kLanes * kLanes);
    EXPECT_GE(static_cast<double>(sums[i]), expected) << i;
    EXPECT_LE(static_cast<double>(sums[i]), expected * 1.0001) << i;
  }
}

}  // namespace
}  // namespace leeway::collision
