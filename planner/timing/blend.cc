#include "planner/timing/blend.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "planner/base/tolerances.h"
#include "planner/timing/leg.h"

namespace leeway::planner {
namespace {

/// The speed along the edge after the corner as a share of its last one; seen from the end, the
/// same along the edge before.
SpeedChange::State share(const Blend& blend, double t) {
  return SpeedChange(0, 1, 1, blend.ramp).at(t);
}

}  // namespace

void blendPoint(std::span<const double> corner, std::span<const double> before,
                std::span<const double> after, const Blend& blend, double t,
                std::span<double> result) {
  const double a = 2 * blend.before * share(blend, 1 - t).way / norm(before);
  const double b = 2 * blend.after * share(blend, t).way / norm(after);
  // Each number of the result depends only on the same number of the inputs, without rotations.
  for (std::size_t i = 0; i < corner.size(); ++i)
    result[i] = corner[i] + (b * after[i] - a * before[i]);
}

void blendDerivative(std::span<const double> before, std::span<const double> after,
                     const Blend& blend, double t, bool second, std::span<double> result) {
  const SpeedChange::State to = share(blend, t), from = share(blend, 1 - t);
  const double a = 2 * blend.before / norm(before) * (second ? -to.acceleration : from.speed);
  const double b = 2 * blend.after / norm(after) * (second ? to.acceleration : to.speed);
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = a * before[i] + b * after[i];
}

std::vector<double> blendDeparture(std::span<const double> before, std::span<const double> after,
                                   const Blend& blend) {
  // The point p(t) of the edges is 2 before |t - 1/2| away from the corner on one, 2 after
  // |t - 1/2| on the other. There, blend - p = 2 way (after - before), with the ways of share(), of
  // which the smaller is at most 1/8, that at half of the time without a ramp.
  const double a = blend.before / norm(before), b = blend.after / norm(after);
  std::vector<double> result(before.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = (b * after[i] - a * before[i]) / 4;
  return result;
}

BlendProof::BlendProof(const std::shared_ptr<const CompiledScene>& scene)
    : space_(scene->space()),
      certifier_(scene->withMarginsGrown(kBlendDeviation)),
      size_(at(space_.size())),
      bend_(size_),
      point_(size_),
      next_(size_),
      displacement_(*scene) {}

bool BlendProof::holds(std::span<const double> corner, std::span<const double> before,
                       std::span<const double> after, const Blend& blend) {
  const double a = blend.before / norm(before), b = blend.after / norm(after);
  for (std::size_t i = 0; i < size_; ++i) bend_[i] = b * after[i] - a * before[i];
  if (wraps(corner, before, after, blend)) return false;
  // The curve's second derivative is at most 2 bend_ / (1 - ramp). Over 1/n of the time the curve
  // stays within an eighth of it, over n^2, of its chord.
  const double deviation = displacement_.of(bend_) / (4 * (1 - blend.ramp));
  int chords = 1;
  while (chords <= kBlendChords && !(deviation / (chords * chords) <= kBlendDeviation)) chords *= 2;
  if (chords > kBlendChords) return false;
  for (int k = 0; k <= chords; ++k) {
    blendPoint(corner, before, after, blend, static_cast<double>(k) / chords, next_);
    if (!space_.withinLimits(next_)) return false;
    if (k > 0 &&
        certifier_.certify(point_, next_, EdgeRequest::persistent()).verdict != Verdict::kFree)
      return false;
    std::swap(point_, next_);
  }
  return true;
}

/// Whether a circle passes from pi to -pi within the cut, where a mimic might jump between chord
/// and curve, or turns by about half a turn, where rounding might reverse the chord.
bool BlendProof::wraps(std::span<const double> corner, std::span<const double> before,
                       std::span<const double> after, const Blend& blend) const {
  const double a = blend.before / norm(before), b = blend.after / norm(after);
  for (const ConfigurationSpace::Part& part : space_.parts()) {
    if (part.kind != ConfigurationSpace::Kind::kCircle) continue;
    const std::size_t i = at(part.first);
    const double middle = std::remainder(corner[i], collision::kTwoPi);
    const double reach = std::max(std::abs(a * before[i]), std::abs(b * after[i]));
    if (!(std::abs(middle) + reach < std::numbers::pi && reach < kBlendReach)) return true;
  }
  return false;
}

}  // namespace leeway::planner
