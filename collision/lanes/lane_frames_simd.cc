// Frames and second-order bounds, one interval or motion in each lane.
//
// Every lane does the same operations in the same order, each rounded once (no fused multiply-add),
// so all instruction sets give the same bits.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "collision/lanes/lane_frames.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/lanes/lane_frames_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kLanes>;
using V = hn::Vec<D>;

// clang-format off
// Sine and cosine for |x| <= 7, within 24 units of 2^-24:
//   rounding of x itself, see below                                          up to 17 units
//   x less a multiple (at most 5) of pi / 2, in two parts, the first of
//   few enough bits for an exact product                                     2 units
//   Taylor's polynomials on [-pi/4, pi/4]: remainders x^11 / 11! < 2e-9
//   and x^10 / 10! < 3e-8                                                    half a unit
//   rounding of the polynomials                                              3 units
// clang-format on
HWY_INLINE void sineCosine(D d, V x, V& sine, V& cosine) {
  const V turns = hn::Round(hn::Mul(x, hn::Set(d, 0.636619772f)));
  V r = hn::Sub(x, hn::Mul(turns, hn::Set(d, 1.5703125f)));
  r = hn::Sub(r, hn::Mul(turns, hn::Set(d, 4.838267949e-4f)));
  const V r2 = hn::Mul(r, r);
  V s = hn::Set(d, 2.755731922e-6f);
  s = hn::Add(hn::Mul(s, r2), hn::Set(d, -1.984126984e-4f));
  s = hn::Add(hn::Mul(s, r2), hn::Set(d, 8.333333333e-3f));
  s = hn::Add(hn::Mul(s, r2), hn::Set(d, -1.666666667e-1f));
  s = hn::Add(hn::Mul(hn::Mul(s, r2), r), r);
  V c = hn::Set(d, 2.480158730e-5f);
  c = hn::Add(hn::Mul(c, r2), hn::Set(d, -1.388888889e-3f));
  c = hn::Add(hn::Mul(c, r2), hn::Set(d, 4.166666667e-2f));
  c = hn::Add(hn::Mul(c, r2), hn::Set(d, -0.5f));
  c = hn::Add(hn::Mul(c, r2), hn::Set(d, 1.0f));
  const hn::RebindToSigned<D> di;
  const auto quadrant = hn::ConvertTo(di, turns);
  const auto odd = hn::RebindMask(d, hn::Ne(hn::And(quadrant, hn::Set(di, 1)), hn::Zero(di)));
  const auto low = hn::RebindMask(d, hn::Ne(hn::And(quadrant, hn::Set(di, 2)), hn::Zero(di)));
  const auto turned = hn::RebindMask(
      d, hn::Ne(hn::And(hn::Add(quadrant, hn::Set(di, 1)), hn::Set(di, 2)), hn::Zero(di)));
  const V sine_value = hn::IfThenElse(odd, c, s), cosine_value = hn::IfThenElse(odd, s, c);
  sine = hn::IfThenElse(low, hn::Neg(sine_value), sine_value);
  cosine = hn::IfThenElse(turned, hn::Neg(cosine_value), cosine_value);
}

HWY_INLINE V dot3(V ax, V ay, V az, V bx, V by, V bz) {
  return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
}

// Origin of a step's frame, relative to its parent.
HWY_INLINE void placeTranslation(D d, const FrameStep& step, V middle, V* t) {
  for (int i = 0; i < 3; ++i)
    t[i] = hn::Add(hn::Set(d, step.translation[i]), hn::Mul(middle, hn::Set(d, step.slide[i])));
}

// One step in the lanes from `at` on.
HWY_INLINE void placeStep(D d, const FrameStep& step, const LaneFrame* parent, std::size_t at,
                          V middle, LaneFrame& frame) {
  V m[9], t[3];  // m: before the turn about z
  placeTranslation(d, step, middle, t);
  if (parent == nullptr) {
    for (int i = 0; i < 9; ++i) m[i] = hn::Set(d, step.rotation[i]);
    for (int i = 0; i < 3; ++i) hn::Store(t[i], d, frame.origin[i].at + at);
  } else {
    V p[9];
    for (int i = 0; i < 9; ++i) p[i] = hn::Load(d, parent->rotation[i].at + at);
    for (int column = 0; column < 3; ++column) {
      const int axis = step.axis[column];  // a number: NOLINT(bugprone-signed-char-misuse)
      if (axis != 0) {
        const LaneValues* of = parent->rotation + 3 * (std::abs(axis) - 1);
        const V sign = hn::Set(d, axis < 0 ? -0.0f : 0.0f);
        for (int row = 0; row < 3; ++row)
          m[3 * column + row] = hn::Xor(sign, hn::Load(d, of[row].at + at));
        continue;
      }
      for (int row = 0; row < 3; ++row)
        m[3 * column + row] = dot3(
            p[row], p[3 + row], p[6 + row], hn::Set(d, step.rotation[3 * column]),
            hn::Set(d, step.rotation[3 * column + 1]), hn::Set(d, step.rotation[3 * column + 2]));
    }
    for (int i = 0; i < 3; ++i) {
      const V arm = dot3(p[i], p[3 + i], p[6 + i], t[0], t[1], t[2]);
      hn::Store(hn::Add(hn::Load(d, parent->origin[i].at + at), arm), d, frame.origin[i].at + at);
    }
  }
  V s, c;
  sineCosine(d, hn::Add(hn::Set(d, step.angle), hn::Mul(middle, hn::Set(d, step.turn))), s, c);
  for (int i = 0; i < 3; ++i) {
    hn::Store(hn::Add(hn::Mul(m[i], c), hn::Mul(m[3 + i], s)), d, frame.rotation[i].at + at);
    hn::Store(hn::Sub(hn::Mul(m[3 + i], c), hn::Mul(m[i], s)), d, frame.rotation[3 + i].at + at);
    hn::Store(m[6 + i], d, frame.rotation[6 + i].at + at);
  }
}

// The motion of a placed frame. The step turns about the frame's z axis.
HWY_INLINE void moveStep(D d, const FrameStep& step, const LaneFrame* parent, std::size_t at,
                         V middle, V half, LaneFrame& frame) {
  const V swing = hn::Mul(half, hn::Set(d, step.turn));
  V drift[3], turn[3];
  for (int i = 0; i < 3; ++i) drift[i] = hn::Mul(half, hn::Set(d, step.slide[i]));
  for (int i = 0; i < 3; ++i) {
    turn[i] = parent == nullptr ? hn::Zero(d) : hn::Load(d, parent->turn[i].at + at);
    const V axis = hn::Load(d, frame.rotation[6 + i].at + at);
    hn::Store(hn::Add(turn[i], hn::Mul(axis, swing)), d, frame.turn[i].at + at);
  }
  if (parent == nullptr) {
    for (int i = 0; i < 3; ++i) hn::Store(drift[i], d, frame.slide[i].at + at);
    return;
  }
  V t[3], p[9], arm[3];  // arm: from the parent's origin
  placeTranslation(d, step, middle, t);
  for (int i = 0; i < 9; ++i) p[i] = hn::Load(d, parent->rotation[i].at + at);
  for (int i = 0; i < 3; ++i) arm[i] = dot3(p[i], p[3 + i], p[6 + i], t[0], t[1], t[2]);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const V across = hn::Sub(hn::Mul(turn[j], arm[k]), hn::Mul(turn[k], arm[j]));
    const V own = dot3(p[i], p[3 + i], p[6 + i], drift[0], drift[1], drift[2]);
    hn::Store(hn::Add(hn::Load(d, parent->slide[i].at + at), hn::Add(across, own)), d,
              frame.slide[i].at + at);
  }
}

void PlaceFrames(const FrameStep* steps, std::size_t count, const LaneValues& places,
                 LaneFrame* frames) {
  const D d;
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    const V middle = hn::Load(d, places.at + at);
    for (std::size_t i = 0; i < count; ++i)
      placeStep(d, steps[i], steps[i].parent < 0 ? nullptr : frames + steps[i].parent, at, middle,
                frames[i]);
  }
}

// half: half an interval, in t.
void MoveFrames(const FrameStep* steps, std::size_t count, const LaneValues& places, float half,
                LaneFrame* frames) {
  const D d;
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    const V middle = hn::Load(d, places.at + at);
    for (std::size_t i = 0; i < count; ++i)
      moveStep(d, steps[i], steps[i].parent < 0 ? nullptr : frames + steps[i].parent, at, middle,
               hn::Set(d, half), frames[i]);
  }
}

void SumGrowth(const std::int32_t* motion, const float* reach, const float* turns, std::size_t rows,
               const float* joint_motion, float* growth) {
  const D d;
  for (std::size_t at = 0; at < kLanes; at += hn::Lanes(d)) {
    V speed = hn::Zero(d), acceleration = hn::Zero(d);
    for (std::size_t k = 0; k < rows; ++k) {
      const std::size_t i = k * kLanes + at;
      const V m = hn::Set(d, joint_motion[motion[k]]);
      const V step = hn::Mul(m, hn::LoadU(d, reach + i));
      const V share = hn::Mul(m, hn::Add(step, hn::Add(speed, speed)));
      acceleration = hn::Add(acceleration, hn::Mul(share, hn::LoadU(d, turns + i)));
      speed = hn::Add(speed, step);
    }
    // All terms are positive, so rounding is relative: 4 units of 2^-24 for each term, below 1e-5
    // for kMostTerms. Rows with reach 0 add nothing.
    const V scale = hn::Set(d, kLaneGrowthOutwards / (8 * kLanes * kLanes));
    hn::StoreU(hn::Mul(acceleration, scale), d, growth + at);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(PlaceFrames);
HWY_EXPORT(MoveFrames);
HWY_EXPORT(SumGrowth);

// clang-format off
// Rounding, with u = 2^-24.
//
// A step's angle in a lane, at most 17 u:
//   angle, up to pi                                                   3.2 u
//   turn, up to 7, of which a lane has half                           3.5 u
//   the product                                                       3.5 u
//   the sum, up to 6.7                                                6.7 u
// A step's rotation (Frobenius norm), below 72 u on top of the parent's, second order included:
//   columns m0 c + m1 s and m1 c - m0 s, by sine and cosine (24 u)    48 u
//   their own rounding                                                4 u
//   the product with the parent's rotation                            9 u
//   the step's entries                                                2 u
//   or, where axes map to axes, in place of both                      3 u
// An origin:
//   its arm, for each step above                                      72 u of the arm's length
//   the arm itself                                                    4 u of it
//   the sum                                                           u of the origin's distance,
//                                                  which is at most the sum of all lengths
// The last two are less than 8 u of all lengths l[0 .. n) and |r|: the remaining 8 u of the 80 of
// kLaneRounding hold them up to chains of 60 steps. A point of the frame is one more arm.
//
// The motion: turn is a sum of axes, each within 72 u a step, times half |turn| / kLanes; slide is
// a sum of turns times arms; each errs as above.
// clang-format on
void findAxes(FrameStep& step) {
  std::fill_n(step.axis, 3, std::int8_t{0});
  std::int8_t axis[3] = {0, 0, 0};
  for (int i = 0; i < 9; ++i) {
    const float size = std::abs(step.rotation[i]);
    if (size <= 0x1p-24F) continue;
    if (!(std::abs(size - 1) <= 0x1p-24F) || axis[i / 3] != 0) return;
    axis[i / 3] = static_cast<std::int8_t>(step.rotation[i] < 0 ? -(i % 3 + 1) : i % 3 + 1);
  }
  if (axis[0] != 0 && axis[1] != 0 && axis[2] != 0) std::copy(axis, axis + 3, step.axis);
}

void placeFrames(std::span<const FrameStep> steps, const LaneValues& places,
                 std::span<LaneFrame> frames) {
  HWY_DYNAMIC_DISPATCH(PlaceFrames)(steps.data(), steps.size(), places, frames.data());
}

void moveFrames(std::span<const FrameStep> steps, const LaneValues& places, float width,
                std::span<LaneFrame> frames) {
  HWY_DYNAMIC_DISPATCH(MoveFrames)
  (steps.data(), steps.size(), places, 0.5f * width, frames.data());
}

int LaneGrowth::add(std::span<const Term> terms) {
  const auto lane = static_cast<std::size_t>(count_) % kLanes;
  if (lane == 0) blocks_.emplace_back();
  Block& block = blocks_.back();
  std::size_t row = 0;
  for (const Term& term : terms) {
    const auto begin = block.motion.begin() + static_cast<std::ptrdiff_t>(row);
    const auto known = std::find(begin, block.motion.end(), term.motion);
    if (known == block.motion.end()) {
      const auto place = static_cast<std::ptrdiff_t>(row * kLanes);
      block.motion.insert(begin, term.motion);
      block.reach.insert(block.reach.begin() + place, kLanes, 0.0F);
      block.turns.insert(block.turns.begin() + place, kLanes, 0.0F);
    } else {
      row += static_cast<std::size_t>(known - begin);
    }
    block.reach[row * kLanes + lane] =
        std::nextafter(static_cast<float>(term.reach), std::numeric_limits<float>::infinity());
    block.turns[row * kLanes + lane] = term.turns ? 1.0f : 0.0f;
    ++row;
  }
  return count_++;
}

void LaneGrowth::run(std::span<const float> joint_motion, std::span<float> growth) const {
  for (std::size_t b = 0; b < blocks_.size(); ++b) HWY_DYNAMIC_DISPATCH(SumGrowth)
  (blocks_[b].motion.data(), blocks_[b].reach.data(), blocks_[b].turns.data(),
   blocks_[b].motion.size(), joint_motion.data(), growth.data() + b * kLanes);
}

}  // namespace leeway::collision
#endif  // HWY_ONCE
