#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/base/tolerances.h"

namespace leeway::collision {

/// Intervals of one motion that are processed together, one in each lane of vector registers.
inline constexpr int kLanes = 16;

/// One number for each interval, in single precision: lanes filter. Their rounding is inside every
/// bound; what they leave open is decided in double precision.
struct alignas(64) LaneValues {
  float at[kLanes];
};

/// A rigid frame in the middle of each interval, and its motion there. A point r of the frame (in
/// its axes) is at origin + R r and moves by slide + turn x (R r) in half an interval, to first
/// order.
struct LaneFrame {
  LaneValues rotation[9];  ///< column by column
  LaneValues origin[3];    ///< [m]
  LaneValues turn[3];      ///< angular velocity times half an interval [rad]
  LaneValues slide[3];     ///< the origin's velocity times half an interval [m]
};

/// A frame that turns about its own z axis and slides at constant speeds, seen from its parent; at
/// t in [0, 1] rotation * Rz(angle + (t - 1/2) turn), at translation + (t - 1/2) slide.
struct FrameStep {
  int parent = -1;  ///< index of a step before this one; -1: the world
  float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< column by column
  float translation[3] = {0, 0, 0};                 ///< [m]
  float slide[3] = {0, 0, 0};                       ///< [m]
  float angle = 0;                                  ///< at t = 1/2, in [-pi, pi] [rad]
  float turn = 0;                                   ///< within kLargestLaneTurn [rad]
  /// Where `rotation` maps axes to axes: its column i is axis |axis[i]| - 1, or the opposite where
  /// axis[i] < 0. 0: it does not, or nobody has looked. placeFrames() then needs no product.
  std::int8_t axis[3] = {0, 0, 0};
};
/// Sets `axis` where each column of `rotation` has one entry within 2^-24 of 1 or -1 and the others
/// within that of 0, as in most robots; else all of it to 0. placeFrames() takes it from then on.
void findAxes(FrameStep& step);

/// Frame i of `frames` becomes that of steps[i] at t = 1/2 + places; its motion stays as it was.
///
/// Rounding: let l[0 .. n) be the lengths of the steps of a frame's chain (translation and slide
/// together, the root's first). A point within |r| of the frame's origin departs from its exact
/// position by at most kLaneRounding * sum over j = 0 .. n of (l[j] + .. + l[n - 1] + |r|); derived
/// beside the definition. O(steps); never throws or allocates. Same bits on every instruction set.
void placeFrames(std::span<const FrameStep> steps, const LaneValues& places,
                 std::span<LaneFrame> frames);
/// Sets the motions of placed frames, over intervals of this width in t around their places.
void moveFrames(std::span<const FrameStep> steps, const LaneValues& places, float width,
                std::span<LaneFrame> frames);

/// Second-order bounds of many motions at once, one motion a lane: the sums of
/// robots::accelerationBound(). A motion is a row of terms from the body to its base.
class LaneGrowth {
 public:
  struct Term {
    int motion;    ///< index into the joints' motions that run() is given
    double reach;  ///< [m]; for slides 1
    bool turns;
  };
  /// Terms of a motion at most: its rounding is bounded up to here [count].
  static constexpr std::size_t kMostTerms = 40;
  /// Adds a motion of at most kMostTerms terms, those nearest to the body first, all reaches
  /// finite. Returns its number.
  int add(std::span<const Term> terms);
  int size() const { return count_; }

  /// For all motions how far points leave their chords over one of kLanes intervals: h^2 A / 8 with
  /// h = 1 / kLanes [m], rounding included. `growth` has room for paddedSize() numbers;
  /// joint_motion: |dq| of joints' turns and slides, rounded up. O(terms).
  void run(std::span<const float> joint_motion, std::span<float> growth) const;
  std::size_t paddedSize() const { return blocks_.size() * kLanes; }

 private:
  int count_ = 0;
  // kLanes motions, a lane each. A row is one joint's term in all of them, so that its motion is
  // read once; reach 0 in motions that the joint does not move. Each motion's terms keep their
  // order.
  struct Block {
    std::vector<std::int32_t> motion;  // one a row
    std::vector<float> reach, turns;   // kLanes a row
  };
  std::vector<Block> blocks_;
};

}  // namespace leeway::collision
