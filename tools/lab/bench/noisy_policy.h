#pragma once

// Chunks of setpoints as a learned policy might emit them: along a path, with noise.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "leeway/planner/guard.h"
#include "tools/lab/bench/splitmix.h"

namespace leeway::bench {

/// Goes to and fro along a path, towards a place some way ahead, and adds noise to the velocity,
/// which forgets itself within a quarter of a second. All setpoints are within the limits on
/// velocity and acceleration.
class NoisyPolicy {
 public:
  /// `noise`: of each joint's velocity, as a share of its limit.
  NoisyPolicy(const planner::GuardOptions& options, std::vector<std::vector<double>> path,
              double noise, std::uint64_t seed)
      : options_(options), path_(std::move(path)), noise_(noise), random_(seed) {
    drift_.assign(path_.front().size(), 0);
  }

  /// A random place of the path; the next chunks go on from there.
  std::vector<double> jump() {
    way_ = random_.uniform(0, static_cast<double>(path_.size() - 1));
    return placeAt(way_);
  }

  /// Setpoints from a motion on, row after row.
  std::vector<double> chunk(std::span<const double> place, std::span<const double> velocity,
                            int count) {
    const std::size_t n = place.size();
    std::vector<double> p(place.begin(), place.end()), v(velocity.begin(), velocity.end()), rows;
    const double T = options_.period, forgets = std::exp(-T / 0.25);
    for (int k = 0; k < count; ++k) {
      advance(p);
      const std::vector<double> target = placeAt(way_);
      for (std::size_t i = 0; i < n; ++i) {
        const double fastest = 0.8 * options_.limits.velocity[i];
        drift_[i] = forgets * drift_[i] + std::sqrt(1 - forgets * forgets) *
                                              random_.uniform(-1.7, 1.7) * noise_ * fastest;
        const double most = 0.95 * options_.limits.acceleration[i] * T;
        const double wanted = std::clamp(4 * (target[i] - p[i]) + drift_[i], -fastest, fastest);
        v[i] += std::clamp(wanted - v[i], -most, most);
        p[i] += v[i] * T;
        rows.push_back(p[i]);
      }
    }
    return rows;
  }

 private:
  std::vector<double> placeAt(double way) const {
    const auto edge = std::min(static_cast<std::size_t>(way), path_.size() - 2);
    const double t = way - static_cast<double>(edge);
    std::vector<double> place(path_[edge]);
    for (std::size_t i = 0; i < place.size(); ++i) place[i] += t * (path_[edge + 1][i] - place[i]);
    return place;
  }

  static constexpr double kAhead = 0.12;  // [rad]
  /// Moves the target on along the path until it is far enough ahead, and turns at its ends.
  void advance(const std::vector<double>& place) {
    for (int step = 0; step < 50; ++step) {
      const std::vector<double> target = placeAt(way_);
      double squared = 0;
      for (std::size_t i = 0; i < place.size(); ++i)
        squared += (target[i] - place[i]) * (target[i] - place[i]);
      if (squared > kAhead * kAhead) return;
      const double last = static_cast<double>(path_.size() - 1);
      way_ += forth_ ? 0.02 : -0.02;
      if (way_ >= last || way_ <= 0) {
        way_ = std::clamp(way_, 0.0, last);
        forth_ = !forth_;
      }
    }
  }

  const planner::GuardOptions& options_;
  std::vector<std::vector<double>> path_;
  double noise_;
  SplitMix random_;
  std::vector<double> drift_;
  double way_ = 0;  // of the target: edge and share of it
  bool forth_ = true;
};

/// A motion of polynomials, one a variable, from a place and velocity to rest.
struct RestingQuintics {
  /// `setpoints`: rows, of which the last is where the motion comes to rest, after twice their
  /// time.
  RestingQuintics(std::span<const double> place, std::span<const double> velocity,
                  std::span<const double> setpoints, double period)
      : size(place.size()), duration(2 * period * static_cast<double>(setpoints.size() / size)) {
    const double T = duration;
    for (std::size_t i = 0; i < size; ++i) {
      const double v = velocity[i], d = setpoints[setpoints.size() - size + i] - place[i];
      coefficients.insert(coefficients.end(), {place[i], v, 0, (10 * d - 6 * v * T) / (T * T * T),
                                               (-15 * d + 8 * v * T) / (T * T * T * T),
                                               (6 * d - 3 * v * T) / (T * T * T * T * T)});
    }
  }
  /// Rows of the places at multiples of `step`, from the first to that at `end`.
  std::vector<double> rows(double step, double end) const {
    std::vector<double> places;
    for (double t = step; t <= end + step / 2; t += step)
      for (std::size_t i = 0; i < size; ++i) {
        double sum = 0;
        for (std::size_t k = 6; k-- > 0;) sum = sum * t + coefficients[6 * i + k];
        places.push_back(sum);
      }
    return places;
  }

  std::size_t size;
  double duration;  ///< [s]
  std::vector<double> coefficients;
};

/// A robot that executes what a guard lets pass of a policy's chunks.
class GuardedRun {
 public:
  GuardedRun(planner::Guard& guard, NoisyPolicy& policy, std::vector<double> start)
      : guard_(guard),
        policy_(policy),
        place_(std::move(start)),
        velocity_(place_.size()),
        time_(guard.nextTime()) {}

  /// The next chunk; the robot is at rest elsewhere where it has been stuck.
  std::vector<double> next(int count) {
    if (stuck_ >= 3) {
      stuck_ = 0;
      place_ = policy_.jump();
      std::fill(velocity_.begin(), velocity_.end(), 0);
      time_ += guard_.options().period;
      guard_.check({.position = place_, .velocity = velocity_, .time = time_});
    }
    return policy_.chunk(place_, velocity_, count);
  }

  /// Goes through what passed of the last answer; where nothing did, through its stop.
  void execute() {
    const planner::GuardAnswer& answer = guard_.answer();
    const std::size_t n = place_.size();
    const std::size_t rows = answer.motion.size() / n;
    const auto passed = static_cast<std::size_t>(answer.passed);
    if (passed > 0) {
      for (std::size_t i = 0; i < n; ++i) {
        const double before = passed > 1 ? answer.motion[(passed - 2) * n + i] : answer.start[i];
        place_[i] = answer.motion[(passed - 1) * n + i];
        velocity_[i] = (place_[i] - before) / guard_.options().period;
      }
      stuck_ = 0;
      time_ = guard_.nextTime();
      return;
    }
    ++stuck_;
    for (std::size_t i = 0; i < n && rows > 0; ++i) place_[i] = answer.motion[(rows - 1) * n + i];
    std::fill(velocity_.begin(), velocity_.end(), 0);
    time_ = answer.time + (static_cast<double>(rows) + 1) * guard_.options().period;
  }
  double time() const { return time_; }
  std::span<const double> place() const { return place_; }
  std::span<const double> velocity() const { return velocity_; }

 private:
  planner::Guard& guard_;
  NoisyPolicy& policy_;
  std::vector<double> place_, velocity_;
  double time_;
  int stuck_ = 0;
};

}  // namespace leeway::bench
