#include "planner/timing/trajectory_samples.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/timing/leg.h"

namespace leeway::planner {
namespace {

/// Replaces the derivatives w and a of a rotation vector in the body's frame by those of the
/// quaternion: q' = q w / 2, q'' = q a / 2 - |w|^2 q / 4.
void quaternionRates(const double* q, double* velocity, double* acceleration) {
  const auto times = [q](const double* v, double* result) {
    result[0] = (q[3] * v[0] + q[1] * v[2] - q[2] * v[1]) / 2;
    result[1] = (q[3] * v[1] + q[2] * v[0] - q[0] * v[2]) / 2;
    result[2] = (q[3] * v[2] + q[0] * v[1] - q[1] * v[0]) / 2;
    result[3] = -(q[0] * v[0] + q[1] * v[1] + q[2] * v[2]) / 2;
  };
  double rate[4], second[4];
  times(velocity, rate);
  times(acceleration, second);
  const double squared =
      velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2];
  for (int k = 0; k < 4; ++k) {
    velocity[k] = rate[k];
    acceleration[k] = second[k] - squared / 4 * q[k];
  }
}

struct RowTime {
  double whole;  ///< in whole nanoseconds
  double after;  ///< the time for derivatives that jump there
};

/// Times of the rows, ascending, in whole nanoseconds as in files. Of knots that are nearer to each
/// other than kLeastRow it keeps the last, because a row's acceleration holds from its time on.
std::vector<RowTime> sampleTimes(const Trajectory& trajectory, double period) {
  std::vector<double> times = trajectory.knots();
  if (period > 0) {
    std::vector<double> steps;
    for (double k = 1; k * period < trajectory.duration(); ++k) steps.push_back(k * period);
    addSpaced(steps, times);
  }
  std::vector<RowTime> result;
  for (const double time : times) {
    const bool is_end = time == trajectory.duration();
    const double whole = (is_end ? std::ceil(time * 1e9) : std::round(time * 1e9)) / 1e9;
    const RowTime row{whole, std::max(whole, time)};
    const bool is_near =
        !result.empty() && whole - result.back().whole < kLeastRow - 2e-9;  // both are rounded
    if (is_near && result.size() > 1)
      result.back() = row;
    else if (!is_near || is_end)
      result.push_back(row);
  }
  return result;
}

}  // namespace

void addSpaced(std::span<const double> added, std::vector<double>& times) {
  std::vector<double> all;
  all.reserve(times.size() + added.size());
  auto next = times.begin();
  for (const double time : added) {
    while (next != times.end() && *next <= time) all.push_back(*next++);
    if ((all.empty() || time - all.back() >= kLeastRow) &&
        (next == times.end() || *next - time >= kLeastRow))
      all.push_back(time);
  }
  all.insert(all.end(), next, times.end());
  times = std::move(all);
}

std::int64_t nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

Samples sample(const Trajectory& trajectory, double period) {
  const ConfigurationSpace& space = trajectory.space();
  const std::size_t size = at(space.size());
  Samples samples;
  for (const auto& [time, after] : sampleTimes(trajectory, period)) {
    samples.times.push_back(time);
    std::vector<double> position(size), velocity(size), acceleration(size);
    trajectory.configuration(time, position);
    trajectory.velocity(time, velocity);
    trajectory.acceleration(after, acceleration);
    for (const ConfigurationSpace::Part& part : space.parts())
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        const std::size_t i = at(part.first);
        quaternionRates(&position[i], &velocity[i], &acceleration[i]);
      }
    samples.positions.push_back(std::move(position));
    samples.velocities.push_back(std::move(velocity));
    samples.accelerations.push_back(std::move(acceleration));
  }
  return samples;
}

double quinticDeparture(double time, const RowMotion& begin, const RowMotion& end) {
  constexpr double kMost = 0.01728;  // at s = 2/5
  const double step = 6 * (end.position - begin.position) / (time * time);
  const double first = step - (4 * begin.velocity + 2 * end.velocity) / time,
               last = (2 * begin.velocity + 4 * end.velocity) / time - step;
  return kMost * time * time *
         (std::abs(begin.acceleration - first) + std::abs(end.acceleration - last));
}

bool areQuinticsCubic(const Samples& samples) {
  const auto row = [&](std::size_t k, std::size_t i) -> RowMotion {
    return {samples.positions[k][i], samples.velocities[k][i], samples.accelerations[k][i]};
  };
  for (std::size_t k = 1; k < samples.times.size(); ++k)
    for (std::size_t i = 0; i < samples.positions[k].size(); ++i)
      if (!(quinticDeparture(samples.times[k] - samples.times[k - 1], row(k - 1, i), row(k, i)) <=
            kQuinticSlack))
        return false;
  return true;
}

Path motionOf(const Trajectory& trajectory) {
  const ConfigurationSpace& space = trajectory.space();
  if (hasRotation(space))
    throw std::invalid_argument("motionOf(): orientations do not move on cubics");
  Samples samples = sample(trajectory, 0);
  Path path;
  for (const int v : space.variables()) path.names.push_back(space.model().variables[at(v)].name);
  path.positions = std::move(samples.positions);
  if (path.positions.size() < 2) return path;
  path.times = std::move(samples.times);
  path.velocities = std::move(samples.velocities);
  return path;
}

}  // namespace leeway::planner
