#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

/// The largest x in [low, high] with excess(x) <= 0, to adjacent numbers, where `excess` rises;
/// `low` if there is none. Secants, and bisection where they converge slowly: limits may differ by
/// any power of ten.
template <class Excess>
double largestWithout(double low, double high, const Excess& excess) {
  double at_high = excess(high);
  if (at_high <= 0) return high;
  double at_low = excess(low);
  if (at_low >= 0) return low;
  constexpr double kLeastShare = 0.02, kNarrow = 4e-16;
  constexpr int kSteps = 2500;  // bisection through all exponents of a double
  bool secant = true;
  for (int i = 0; i < kSteps && high - low > kNarrow * high; ++i) {
    const double width = high - low;
    const double share =
        secant ? std::clamp(at_low / (at_low - at_high), kLeastShare, 1 - kLeastShare) : 0.5;
    const double middle = low + share * width;
    if (!(middle > low && middle < high)) break;
    const double x = excess(middle);
    if (x <= 0) {
      low = middle;
      at_low = x;
    } else {
      high = middle;
      at_high = x;
    }
    secant = high - low < width / 2;
  }
  return low;
}

/// The time of a phase: at least kLeastPhase, or 0 for a phase that is not there.
double phase(double time) { return time > 0 ? std::max(time, kLeastPhase) : 0; }

}  // namespace

SpeedChange::SpeedChange(double first, double last, const LineLimits& limits)
    : from(first), to(last) {
  const double change = to - from;
  if (!(change > 0)) return;
  const double a = limits.acceleration, j = limits.jerk;
  const double whole = j == kInfinity ? 0 : a / j;  // until the acceleration is a
  if (change >= whole * a) {
    time = change / a + whole;
    ramp = std::min(whole, time / 2);
  } else {
    time = 2 * std::sqrt(change / j);
    ramp = time / 2;
  }
}

SpeedChange SpeedChange::withLongPhases() const {
  if (!(time > 0)) return *this;
  if (to - from <= kSameSpeed * to) return {from, to, 0, 0};
  const double plateau = time - 2 * ramp, longer = phase(ramp);
  return {from, to, 2 * longer + phase(plateau > kInLine * time ? plateau : 0), longer};
}

SpeedChange::State SpeedChange::at(double t) const {
  if (!(time > 0)) return {0, from, 0};
  const double a = (to - from) / (time - ramp), j = ramp > 0 ? a / ramp : 0;
  if (t < ramp) return {from * t + j * t * t * t / 6, from + j * t * t / 2, j * t};
  if (t <= time - ramp) {
    const double u = t - ramp;
    return {from * t + a * ramp * ramp / 6 + a * ramp / 2 * u + a * u * u / 2,
            from + a * ramp / 2 + a * u, a};
  }
  const double u = time - t;
  return {way() - to * u + j * u * u * u / 6, to - j * u * u / 2, j * u};
}

SpeedProfile::SpeedProfile(const LineLimits& limits, double length, double first, double last)
    : length_(length) {
  if (!(limits.speed > 0 && limits.acceleration > 0 && limits.jerk > 0 && length > 0))
    throw std::invalid_argument("SpeedProfile: limits and a length above 0 are expected");
  const double least = std::max(first, last);
  if (!(first >= 0 && last >= 0 && least <= limits.speed))
    throw std::invalid_argument("SpeedProfile: speeds from 0 to the limit are expected");
  bool is_long = true;  // there is room for long phases
  const auto change = [&](double from, double to) {
    const SpeedChange fastest(from, to, limits);
    return is_long ? fastest.withLongPhases() : fastest;
  };
  const auto excess = [&](double speed) {
    return change(first, speed).way() + change(last, speed).way() - length;
  };
  is_long = excess(least) <= 0;
  const double peak = largestWithout(least, limits.speed, excess);
  rise_ = change(first, peak);
  fall_ = change(last, peak);
  if (peak > 0) cruise_ = std::max(0.0, (length - rise_.way() - fall_.way()) / peak);
  if (!(cruise_ < kLeastPhase)) return;
  // One of the changes takes the time of a short cruise, too.
  SpeedChange& longer = rise_.time > fall_.time ? rise_ : fall_;
  if (!(longer.time > 0)) return;
  const double way = length - (&longer == &rise_ ? fall_ : rise_).way();
  const double time = std::max(longer.time, 2 * way / (longer.from + longer.to));
  longer.ramp *= time / longer.time;
  longer.time = time;
  cruise_ = 0;
}

SpeedProfile::State SpeedProfile::at(double time) const {
  const double end = duration();
  if (!(time >= 0)) return {0, rise_.from, 0};
  if (time >= end) return {length_, fall_.from, 0};
  if (time < rise_.time) return rise_.at(time);
  if (time < rise_.time + cruise_)
    return {rise_.way() + rise_.to * (time - rise_.time), rise_.to, 0};
  const State back = fall_.at(std::min(end - time, fall_.time));
  return {length_ - back.way, back.speed, -back.acceleration};
}

double SpeedProfile::timeAt(double way) const {
  double low = 0, high = duration();
  if (!(way > 0)) return 0;
  if (!(way < length_)) return high;  // rounding reaches it before
  for (int k = 0; k < 100; ++k) {
    const double middle = low + (high - low) / 2;
    (at(middle).way < way ? low : high) = middle;
  }
  return high;
}

std::array<double, 8> SpeedProfile::knotArray() const {
  const double end = duration(), fall = rise_.time + cruise_;
  std::array<double, 8> times = {0,    rise_.ramp,        rise_.time - rise_.ramp, rise_.time,
                                 fall, fall + fall_.ramp, end - fall_.ramp,        end};
  for (std::size_t i = 1; i < times.size(); ++i) times[i] = std::max(times[i], times[i - 1]);
  return times;
}

std::vector<double> SpeedProfile::knots() const {
  const std::array<double, 8> times = knotArray();
  std::vector<double> result(times.begin(), times.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

double mostSpeedAfter(const LineLimits& limits, double speed, double length) {
  return largestWithout(speed, std::max(speed, limits.speed), [&](double last) {
    return SpeedChange(speed, last, limits).withLongPhases().way() - length;
  });
}

}  // namespace leeway::planner
