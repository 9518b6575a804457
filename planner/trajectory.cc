#include "leeway/planner/trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "planner/tolerances.h"

namespace leeway::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// By Newton's method, so that the C library has no say.
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

/// How fast an edge's t may change: the tightest of limit / |dq|.
double rateLimit(const ConfigurationSpace& space, std::span<const double> dq,
                 std::span<const double> limits) {
  double rate = kInfinity;
  for (const ConfigurationSpace::Part& part : space.parts()) {
    const std::size_t i = at(part.first);
    const bool rotation = part.kind == ConfigurationSpace::Kind::kRotation;
    const double change =
        rotation ? std::sqrt(dq[i] * dq[i] + dq[i + 1] * dq[i + 1] + dq[i + 2] * dq[i + 2])
                 : std::abs(dq[i]);
    if (change > 0) rate = std::min(rate, limits[i] / change);
  }
  return rate;
}

double norm(std::span<const double> v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

/// Does the second edge go on exactly where the first one points?
bool inLine(std::span<const double> first, std::span<const double> second) {
  const double a = norm(first), b = norm(second);
  if (a == 0 || b == 0) return true;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (std::abs(first[i] / a - second[i] / b) > kInLine) return false;
  return true;
}

void check(std::span<const double> limits, std::size_t size, const char* what, bool infinite) {
  if (limits.size() != size)
    throw std::invalid_argument("trajectory: " + std::to_string(limits.size()) + " limits of " +
                                what + " for " + std::to_string(size) + " variables");
  for (const double x : limits)
    if (!(x > 0) || (!infinite && !std::isfinite(x)))
      throw std::invalid_argument("trajectory: a limit of " + std::string(what) + " is " +
                                  std::to_string(x) + ", it must be positive");
}

}  // namespace

MotionLimits defaultMotionLimits(const ConfigurationSpace& space) {
  MotionLimits limits;
  for (const int v : space.variables()) {
    const double velocity = space.model().variables[at(v)].velocity;
    limits.velocity.push_back(std::isfinite(velocity) && velocity > 0 ? velocity : 1);
    limits.acceleration.push_back(limits.velocity.back() / kTimeToVelocityLimit);
  }
  return limits;
}

RestToRest::RestToRest(double speed, double acceleration, double jerk) : jerk_(jerk) {
  // Speeding up to v takes v / a + a / j where a is reached, 2 sqrt(v / j) where it is not, and
  // covers half of v times that.
  const double a = acceleration, reached = jerk == kInfinity ? 0 : a / jerk * a;
  const auto rise = [&](double v) {
    return v >= reached ? v / a + (jerk == kInfinity ? 0 : a / jerk) : 2 * std::sqrt(v / jerk);
  };
  peak_ = speed;
  if (speed * rise(speed) > 1) {  // the way is too short for full speed
    const double ramp = jerk == kInfinity ? 0 : a / jerk;
    peak_ = a * (std::sqrt(ramp * ramp + 4 / a) - ramp) / 2;
    if (peak_ < reached) peak_ = cubeRoot(jerk / 4);
    peak_ = std::min(peak_, speed);
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
  if (!(time > 0)) return {};
  if (time >= duration()) return {1, 0, 0};
  if (time < rise_) return rising(time);
  if (time <= rise_ + cruise_) return {peak_ * (rise_ / 2 + (time - rise_)), peak_, 0};
  const State back = rising(duration() - time);
  return {1 - back.way, back.speed, -back.acceleration};
}

Trajectory::Trajectory(std::shared_ptr<const ConfigurationSpace> space,
                       std::vector<std::vector<double>> waypoints, const MotionLimits& limits)
    : space_(std::move(space)), waypoints_(std::move(waypoints)) {
  const std::size_t size = at(space_->size());
  check(limits.velocity, size, "velocity", false);
  check(limits.acceleration, size, "acceleration", false);
  if (!limits.jerk.empty()) check(limits.jerk, size, "jerk", true);
  if (waypoints_.empty()) throw std::invalid_argument("trajectory: a path without waypoints");
  for (const std::vector<double>& row : waypoints_)
    if (row.size() != size)
      throw std::invalid_argument("trajectory: a waypoint of " + std::to_string(row.size()) +
                                  " numbers for " + std::to_string(size) + " variables");
  const std::size_t edges = waypoints_.size() - 1;
  for (std::size_t i = 0; i < edges; ++i) {
    differences_.emplace_back(size);
    space_->difference(waypoints_[i], waypoints_[i + 1], differences_.back());
  }
  ends_.assign(edges, 1);
  times_.assign(waypoints_.size(), 0);
  double now = 0;
  for (std::size_t first = 0, last; first < edges; first = last) {
    last = first + 1;
    // Compared with the last edge that has a length.
    for (std::size_t along = first; last < edges; ++last) {
      if (!inLine(differences_[along], differences_[last])) break;
      if (norm(differences_[last]) > 0) along = last;
    }
    std::vector<double> whole(size, 0);
    double length = 0;
    for (std::size_t e = first; e < last; ++e) {
      for (std::size_t i = 0; i < size; ++i) whole[i] += differences_[e][i];
      length += norm(differences_[e]);
    }
    double passed = 0;
    for (std::size_t e = first; e + 1 < last; ++e) {
      passed += norm(differences_[e]);
      ends_[e] = length > 0 ? passed / length : 1;
    }
    const double speed = rateLimit(*space_, whole, limits.velocity);
    if (speed == kInfinity) {  // nothing moves
      for (std::size_t e = first; e < last; ++e) times_[e + 1] = now;
      continue;
    }
    const double jerk = limits.jerk.empty() ? kInfinity : rateLimit(*space_, whole, limits.jerk);
    const RestToRest profile(speed, rateLimit(*space_, whole, limits.acceleration), jerk);
    stretches_.push_back({static_cast<int>(first), static_cast<int>(last - first), now, profile});
    // Waypoints that are run through: found by bisection, for the profile has no simple inverse.
    for (std::size_t e = first; e + 1 < last; ++e) {
      double low = 0, high = profile.duration();
      for (int k = 0; k < 100; ++k) {
        const double middle = low + (high - low) / 2;
        (profile.at(middle).way < ends_[e] ? low : high) = middle;
      }
      times_[e + 1] = now + high;
    }
    now += profile.duration();
    times_[last] = now;
  }
}

Trajectory::Place Trajectory::place(double time) const {
  Place place;
  if (stretches_.empty() || !(time > 0)) return place;
  if (time >= duration()) {
    place.edge = static_cast<int>(differences_.size()) - 1;
    place.t = 1;
    return place;
  }
  auto stretch = std::upper_bound(stretches_.begin(), stretches_.end(), time,
                                  [](double t, const Stretch& s) { return t < s.start; });
  --stretch;
  const RestToRest::State state = stretch->profile.at(time - stretch->start);
  const int last = stretch->first_edge + stretch->edges - 1;
  int edge = stretch->first_edge;
  while (edge < last && state.way >= ends_[at(edge)]) ++edge;
  const double begin = edge == stretch->first_edge ? 0 : ends_[at(edge - 1)];
  const double share = ends_[at(edge)] - begin;
  place.edge = edge;
  if (share > 0) {
    place.t = std::clamp((state.way - begin) / share, 0.0, 1.0);
    place.rate = state.speed / share;
    place.acceleration = state.acceleration / share;
  }
  return place;
}

void Trajectory::configuration(double time, std::span<double> q) const {
  if (differences_.empty() || !(time > 0)) {
    std::copy(waypoints_.front().begin(), waypoints_.front().end(), q.begin());
    return;
  }
  const Place p = place(time);
  space_->interpolate(waypoints_[at(p.edge)], waypoints_[at(p.edge) + 1], p.t, q);
}

void Trajectory::derivative(double time, bool second, std::span<double> result) const {
  std::fill(result.begin(), result.end(), 0.0);
  if (stretches_.empty() || !(time > 0) || time >= duration()) return;
  const Place p = place(time);
  const double factor = second ? p.acceleration : p.rate;
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = factor * differences_[at(p.edge)][i];
}

void Trajectory::velocity(double time, std::span<double> rate) const {
  derivative(time, false, rate);
}

void Trajectory::acceleration(double time, std::span<double> second) const {
  derivative(time, true, second);
}

}  // namespace leeway::planner
