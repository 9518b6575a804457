#include "planner/timing/trajectory_samples.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "collision/base/numbers.h"
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

/// Times of the rows, ascending. Keeps the last of several times within one nanosecond, because a
/// row's acceleration holds from its time on. Always keeps the start.
std::vector<double> sampleTimes(const Trajectory& trajectory, double period) {
  std::vector<double> times = trajectory.knots();
  if (period > 0)
    for (double k = 1; k * period < trajectory.duration(); ++k) times.push_back(k * period);
  std::sort(times.begin(), times.end());
  std::vector<double> result;
  for (const double time : times)
    if (result.empty() || nanoseconds(time) > nanoseconds(result.back()))
      result.push_back(time);
    else if (result.size() > 1 || time == trajectory.duration())
      result.back() = time;
  return result;
}

}  // namespace

std::int64_t nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

Samples sample(const Trajectory& trajectory, double period) {
  const ConfigurationSpace& space = trajectory.space();
  const std::size_t size = at(space.size());
  Samples samples;
  samples.times = sampleTimes(trajectory, period);
  for (const double time : samples.times) {
    std::vector<double> position(size), velocity(size), acceleration(size);
    trajectory.configuration(time, position);
    trajectory.velocity(time, velocity);
    trajectory.acceleration(time, acceleration);
    for (const ConfigurationSpace::Part& part : space.parts())
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        double* q = &position[at(part.first)];
        // q and -q are the same orientation, and waypoints may have either.
        if (!samples.positions.empty()) {
          const double* last = &samples.positions.back()[at(part.first)];
          if (q[0] * last[0] + q[1] * last[1] + q[2] * last[2] + q[3] * last[3] < 0)
            for (int k = 0; k < 4; ++k) q[k] = -q[k];
        }
        quaternionRates(q, &velocity[at(part.first)], &acceleration[at(part.first)]);
      }
    samples.positions.push_back(std::move(position));
    samples.velocities.push_back(std::move(velocity));
    samples.accelerations.push_back(std::move(acceleration));
  }
  samples.positions = unwrapped(space, std::move(samples.positions));
  return samples;
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
