#include "planner/timing/leg.h"

#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/timing/motion_limits.h"

namespace leeway::planner {
namespace {

const Blend* blendAt(std::span<const Blend> blends, int corner) {
  const auto found = std::lower_bound(blends.begin(), blends.end(), corner,
                                      [](const Blend& b, int c) { return b.corner < c; });
  return found != blends.end() && found->corner == corner ? &*found : nullptr;
}

/// Limits on the length of a line whose unit change is `direction`.
LineLimits limitsAlong(const ConfigurationSpace& space, std::span<const double> direction,
                       const MotionLimits& limits) {
  return {1 / timeAtLimits(space, limits.velocity, direction),
          1 / timeAtLimits(space, limits.acceleration, direction),
          limits.jerk.empty() ? kInfinity : 1 / timeAtLimits(space, limits.jerk, direction)};
}

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

/// The least time of a blend within the limits, if the legs beside it reach its speeds [s]. Its
/// phases take kLeastPhase or more, so that rows can hold them.
double leastTime(const Blend& blend, const Leg& before, const Leg& after,
                 const MotionLimits& limits) {
  double time =
      std::max(2 * blend.before / before.limits.speed, 2 * blend.after / after.limits.speed);
  const double plateau = 1 - 2 * blend.ramp;
  for (const double share : {blend.ramp, plateau > kInLine ? plateau : 0})
    if (share > 0) time = std::max(time, kLeastPhase / share);
  for (std::size_t i = 0; i < limits.velocity.size(); ++i) {
    // The velocity changes by this over the time.
    const double turn =
        2 * std::abs(blend.after * after.direction[i] - blend.before * before.direction[i]);
    time = std::max(time, std::sqrt(turn / limits.acceleration[i] / (1 - blend.ramp)));
    if (!limits.jerk.empty() && limits.jerk[i] < kInfinity)
      time = std::max(time, cubeRoot(turn / limits.jerk[i] / (blend.ramp * (1 - blend.ramp))));
  }
  return time;
}

}  // namespace

double norm(std::span<const double> v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

bool inLine(std::span<const double> first, std::span<const double> second) {
  const double a = norm(first), b = norm(second);
  if (a == 0 || b == 0) return true;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (std::abs(first[i] / a - second[i] / b) > kInLine) return false;
  return true;
}

bool hasRotation(const ConfigurationSpace& space) {
  return std::any_of(space.parts().begin(), space.parts().end(), [](const auto& part) {
    return part.kind == ConfigurationSpace::Kind::kRotation;
  });
}

std::vector<Leg> legsOf(const ConfigurationSpace& space,
                        std::span<const std::vector<double>> differences,
                        std::span<const Blend> blends, const MotionLimits& limits,
                        std::span<const double> least_times, std::span<const int> rests) {
  std::vector<Leg> legs;
  const int edges = static_cast<int>(differences.size());
  for (int first = 0; first < edges;) {
    Leg leg{first, first + 1, norm(differences[at(first)]), differences[at(first)], {}};
    int along = first;  // the direction is that of the last edge with a length
    for (; leg.last < edges; ++leg.last) {
      const std::vector<double>& next = differences[at(leg.last)];
      if (blendAt(blends, leg.last) != nullptr || !inLine(differences[at(along)], next) ||
          std::binary_search(rests.begin(), rests.end(), leg.last))
        break;
      const double length = norm(next);
      if (length > 0) along = leg.last;
      leg.length += length;
      for (std::size_t i = 0; i < next.size(); ++i) leg.direction[i] += next[i];
    }
    if (leg.length > 0) {
      for (double& x : leg.direction) x /= leg.length;
      leg.limits = limitsAlong(space, leg.direction, limits);
      for (int e = first; e < leg.last && !least_times.empty(); ++e)
        if (const double length = norm(differences[at(e)]); least_times[at(e)] > 0 && length > 0)
          leg.limits.speed = std::min(leg.limits.speed, length / least_times[at(e)]);
    }
    first = leg.last;
    legs.push_back(std::move(leg));
  }
  return legs;
}

SpeedChange fastestTurn(const Leg& before, const Leg& after, const MotionLimits& limits,
                        double from, double to) {
  LineLimits turn{1, kInfinity, kInfinity};
  for (std::size_t i = 0; i < limits.velocity.size(); ++i) {
    const double change = std::abs(to * after.direction[i] - from * before.direction[i]);
    if (!(change > 0)) continue;
    turn.acceleration = std::min(turn.acceleration, limits.acceleration[i] / change);
    if (!limits.jerk.empty()) turn.jerk = std::min(turn.jerk, limits.jerk[i] / change);
  }
  if (!(turn.acceleration < kInfinity)) return {};
  const SpeedChange change = SpeedChange(0, 1, turn).withLongPhases();
  // A joint whose jerk is limited may keep its velocity in this turn. Blends have a ramp all the
  // same, because the way from one leg to the other may need it.
  const bool smooth = std::any_of(limits.jerk.begin(), limits.jerk.end(),
                                  [](double jerk) { return jerk < kInfinity; });
  if (!smooth || change.ramp > 0) return change;
  return {0, 1, change.time + kLeastPhase, kLeastPhase};
}

std::vector<double> blendTimes(std::span<const Leg> legs, std::span<const Blend> blends,
                               std::span<const int> leg_of, const MotionLimits& limits) {
  std::vector<double> times;
  for (std::size_t k = 0; k < blends.size(); ++k)
    times.push_back(leastTime(blends[k], legs[at(leg_of[k])], legs[at(leg_of[k]) + 1], limits));
  // The length of the leg before or after blend k that is in no blend, and the speed at its other
  // end.
  const auto limit = [&](std::size_t k, bool is_before) {
    const int e = leg_of[k] + (is_before ? 0 : 1);
    const bool has_other =
        is_before ? k > 0 && leg_of[k - 1] == e - 1 : k + 1 < blends.size() && leg_of[k + 1] == e;
    const std::size_t other = is_before ? k - 1 : k + 1;
    const double mine = is_before ? blends[k].before : blends[k].after;
    double length = legs[at(e)].length - mine, speed = 0;
    if (has_other) {
      const double its = is_before ? blends[other].after : blends[other].before;
      length -= its;
      speed = 2 * its / times[other];
    }
    const double most = mostSpeedAfter(legs[at(e)].limits, speed, std::max(length, 0.0));
    times[k] = std::max(times[k], 2 * mine / (most * (1 - kInLine)));
  };
  // Backwards for slowing down, then forwards for speeding up. What is lowered then is still above
  // the speed before it.
  for (std::size_t k = blends.size(); k-- > 0;) limit(k, false);
  for (std::size_t k = 0; k < blends.size(); ++k) limit(k, true);
  return times;
}

}  // namespace leeway::planner
