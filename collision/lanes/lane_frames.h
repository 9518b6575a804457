#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/base/tolerances.h"

namespace leeway::collision {

/// Number of intervals of one motion that are processed together, one in each lane of vector
/// registers.
inline constexpr int kLanes = 16;

/// One number for each interval, in single precision. Lanes only filter: their rounding is included
/// in every bound, and cases that they leave open are decided in double precision.
struct alignas(64) LaneValues {
  float at[kLanes];
};

/// A rigid frame in the middle of each interval, and its motion there. A point r of the frame (in
/// its axes) is at origin + R r. In half an interval it moves by slide + turn x (R r), to first
/// order.
struct LaneFrame {
  LaneValues rotation[9];  ///< column by column
  LaneValues origin[3];    ///< [m]
  LaneValues turn[3];      ///< angular velocity times half an interval [rad]
  LaneValues slide[3];     ///< the origin's velocity times half an interval [m]
};

/// A frame that turns about its own z axis and slides at constant speeds, relative to its parent.
/// At t in [0, 1] its rotation is rotation * Rz(angle + (t - 1/2) turn), and its origin is at
/// translation + (t - 1/2) slide.
struct FrameStep {
  int parent = -1;                                  ///< index of an earlier step; -1: the world
  float rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< column by column
  float translation[3] = {0, 0, 0};                 ///< [m]
  float slide[3] = {0, 0, 0};                       ///< [m]
  float angle = 0;                                  ///< at t = 1/2, in [-pi, pi] [rad]
  float turn = 0;                                   ///< within kLargestLaneTurn [rad]
  /// Set if `rotation` maps axes to axes: its column i is axis |axis[i]| - 1, or the opposite if
  /// axis[i] < 0. 0 if it does not, or if findAxes() was not called. placeFrames() then needs no
  /// product.
  std::int8_t axis[3] = {0, 0, 0};
};
/// Sets `axis` if each column of `rotation` has one entry within 2^-24 of 1 or -1 and the others
/// within that of 0, as in most robots; otherwise sets all of it to 0. placeFrames() uses it from
/// then on.
void findAxes(FrameStep& step);

/// Moves frame i of `frames` to that of steps[i] at t = 1/2 + places; its motion stays unchanged.
///
/// Rounding: let l[0 .. n) be the lengths of the steps of a frame's chain (translation and slide
/// together, the root's first). A point within |r| of the frame's origin departs from its exact
/// position by at most kLaneRounding * sum over j = 0 .. n of (l[j] + .. + l[n - 1] + |r|); this is
/// derived next to the definition. O(steps); never throws or allocates. Same bits on every
/// instruction set.
void placeFrames(std::span<const FrameStep> steps, const LaneValues& places,
                 std::span<LaneFrame> frames);
/// Sets the motions of placed frames over intervals of this width in t around their places.
void moveFrames(std::span<const FrameStep> steps, const LaneValues& places, float width,
                std::span<LaneFrame> frames);

/// Second-order bounds of many motions at once, one motion in each lane: the sums of
/// robots::accelerationBound(). A motion is a row of terms from the body to its base.
class LaneGrowth {
 public:
  struct Term {
    int motion;    ///< index into the joints' motions, an argument of run()
    double reach;  ///< [m]; for slides 1
    bool turns;
  };
  /// Limit on the terms of a motion: its rounding is bounded up to here [count].
  static constexpr std::size_t kMostTerms = 40;
  /// Adds a motion of at most kMostTerms terms, those nearest to the body first, with finite
  /// reaches. Returns its number.
  int add(std::span<const Term> terms);
  int size() const { return count_; }

  /// Computes for all motions how far points leave their chords over one of kLanes intervals: h^2 A
  /// / 8 with h = 1 / kLanes [m], rounding included. `growth` has room for paddedSize() numbers;
  /// joint_motion: |dq| of joints' turns and slides, rounded up. O(terms).
  void run(std::span<const float> joint_motion, std::span<float> growth) const;
  std::size_t paddedSize() const { return blocks_.size() * kLanes; }

 private:
  int count_ = 0;
  // kLanes motions, one in each lane. A row is one joint's term in all of them, so that the joint's
  // motion is read once; reach is 0 in motions that the joint does not affect. Each motion's terms
  // keep their order.
  struct Block {
    std::vector<std::int32_t> motion;  // one for each row
    std::vector<float> reach, turns;   // kLanes a row
  };
  std::vector<Block> blocks_;
};

}  // namespace leeway::collision
