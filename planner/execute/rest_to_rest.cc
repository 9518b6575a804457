#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"

namespace leeway::planner {
namespace {

/// Uses Newton's method, which gives the same result with every C library.
double cubeRoot(double x) {
  if (!(x > 0) || !std::isfinite(x)) return 0;
  double root = std::max(1.0, x);
  for (int i = 0; i < 2000; ++i) {
    const double next = (2 * root + x / (root * root)) / 3;
    if (!(next < root)) break;
    root = next;
  }
  return root;
}

}  // namespace

RestToRest::RestToRest(double speed, double acceleration, double jerk) : jerk_(jerk) {
  if (!(speed > 0 && acceleration > 0 && jerk > 0))
    throw std::invalid_argument("RestToRest: limits above 0 are expected");
  // Speeding up to v takes v / a + a / j if a is reached, else 2 sqrt(v / j). It covers v / 2 times
  // that time.
  const double a = acceleration, reached = jerk == kInfinity ? 0 : a / jerk * a;
  const auto rise = [&](double v) {
    return v >= reached ? v / a + (jerk == kInfinity ? 0 : a / jerk) : 2 * std::sqrt(v / jerk);
  };
  peak_ = speed;
  if (speed * rise(speed) > 1) {  // too short for full speed
    const double ramp = jerk == kInfinity ? 0 : a / jerk;
    const double top = reached * rise(reached) > 1  // nor for full acceleration
                           ? cubeRoot(jerk / 4)
                           : a * (std::sqrt(ramp * ramp + 4 / a) - ramp) / 2;
    peak_ = std::min(top, speed);
  }
  rise_ = rise(peak_);
  ramp_ = jerk == kInfinity ? 0 : std::min(a / jerk, rise_ / 2);
  peak_acceleration_ = jerk == kInfinity ? a : std::min(a, jerk * ramp_);
  cruise_ = std::max(0.0, (1 - peak_ * rise_) / peak_);
}

RestToRest::State RestToRest::rising(double t) const {
  if (t < ramp_) return {jerk_ * t * t * t / 6, jerk_ * t * t / 2, jerk_ * t};
  const double a = peak_acceleration_;
  if (t <= rise_ - ramp_) {
    const double u = t - ramp_;  // after ramping up
    const double v0 = a * ramp_ / 2, s0 = a * ramp_ * ramp_ / 6;
    return {s0 + v0 * u + a * u * u / 2, v0 + a * u, a};
  }
  const double u = rise_ - t;  // before full speed
  const double j = ramp_ > 0 ? jerk_ : 0;
  return {peak_ * rise_ / 2 - peak_ * u + j * u * u * u / 6, peak_ - j * u * u / 2, j * u};
}

RestToRest::State RestToRest::at(double time) const {
  if (!(time >= 0)) return {};
  if (time >= duration()) return {1, 0, 0};
  if (time < rise_) return rising(time);
  if (time < rise_ + cruise_) return {peak_ * (rise_ / 2 + (time - rise_)), peak_, 0};
  const State back = rising(std::min(duration() - time, rise_));
  return {1 - back.way, back.speed, -back.acceleration};
}

std::array<double, 8> RestToRest::knotArray() const {
  const double end = duration();
  std::array<double, 8> times = {
      0, ramp_, rise_ - ramp_, rise_, rise_ + cruise_, rise_ + cruise_ + ramp_, end - ramp_, end};
  for (std::size_t i = 1; i < times.size(); ++i) times[i] = std::max(times[i], times[i - 1]);
  return times;
}

std::vector<double> RestToRest::knots() const {
  const std::array<double, 8> times = knotArray();
  std::vector<double> result(times.begin(), times.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

}  // namespace leeway::planner
