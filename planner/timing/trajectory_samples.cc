#include "planner/timing/trajectory_samples.h"

#include <algorithm>
#include <cmath>
#include <map>
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

/// Where a trajectory is among its waypoints at a time: the number of one, plus the share of the
/// edge behind it. On a blend it is the point of the edges that passes the corner at half of the
/// time, from which the blend is proven not to depart too far.
double wayAt(const Trajectory& trajectory, double time) {
  const Trajectory::Place place = trajectory.place(time);
  if (place.blend < 0) return place.edge + place.t;
  const Blend& blend = trajectory.cuts().blends[at(place.blend)];
  const auto length = [&](int edge) {
    std::vector<double> difference(at(trajectory.space().size()));
    trajectory.space().lineDifference(trajectory.waypoints()[at(edge)],
                                      trajectory.waypoints()[at(edge) + 1], difference);
    return norm(difference);
  };
  const double left = 1 - 2 * place.t;  // to the corner; negative behind it
  const double way = left > 0 ? blend.before / length(blend.corner - 1) * left
                              : blend.after / length(blend.corner) * left;
  return blend.corner - way;
}

/// The steps of a task in numbers of the rows, with the places of their rows on lines.
std::vector<PathStep> stepsOfRows(const Trajectory& trajectory, const Samples& samples) {
  // The row of a waypoint that is passed at a row's time.
  const auto rowOf = [&](int waypoint) {
    const double time = trajectory.times()[at(waypoint)];
    const auto after = std::lower_bound(samples.times.begin(), samples.times.end(), time);
    const bool is_before = after != samples.times.begin() &&
                           (after == samples.times.end() || time - after[-1] < *after - time);
    return static_cast<int>(after - samples.times.begin()) - (is_before ? 1 : 0);
  };
  std::vector<PathStep> steps(trajectory.steps().begin(), trajectory.steps().end());
  for (PathStep& step : steps) {
    const int first = step.first, last = step.last;
    const std::vector<double> places = std::move(step.places);
    step.first = rowOf(first);
    step.last = rowOf(last);
    step.places.assign(places.empty() ? 0 : 1 + at(step.last - step.first), 0.0);
    if (places.size() != at(last - first) + 1 || first == last) continue;
    for (int row = step.first; row <= step.last; ++row) {
      const double way = wayAt(trajectory, samples.times[at(row)]) - first;
      const auto k = static_cast<std::size_t>(std::clamp(way, 0.0, last - first - 1.0));
      const double share = std::clamp(way - static_cast<double>(k), 0.0, 1.0);
      step.places[at(row - step.first)] = places[k] + share * (places[k + 1] - places[k]);
    }
    for (int waypoint = first; waypoint <= last; ++waypoint)  // times of rows are rounded
      if (const int row = rowOf(waypoint);
          nanoseconds(samples.times[at(row)]) == nanoseconds(trajectory.times()[at(waypoint)]))
        step.places[at(row - step.first)] = places[at(waypoint - first)];
    step.places.front() = places.front();
    step.places.back() = places.back();
  }
  return steps;
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
  // Between steps the motion rests, which times in whole nanoseconds miss.
  std::map<std::int64_t, double> rests;
  for (const PathStep& step : trajectory.steps()) {
    const double time = trajectory.times()[at(step.last)];
    rests[nanoseconds(time)] = time;
  }
  for (const auto& [time, after] : sampleTimes(trajectory, period)) {
    samples.times.push_back(time);
    const auto rest = rests.find(nanoseconds(time));
    const double exact = rest == rests.end() ? time : rest->second;
    std::vector<double> position(size), velocity(size), acceleration(size);
    trajectory.configuration(exact, position);
    trajectory.velocity(exact, velocity);
    trajectory.acceleration(std::max(after, exact), acceleration);
    for (const ConfigurationSpace::Part& part : space.parts())
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        const std::size_t i = at(part.first);
        quaternionRates(&position[i], &velocity[i], &acceleration[i]);
      }
    samples.positions.push_back(std::move(position));
    samples.velocities.push_back(std::move(velocity));
    samples.accelerations.push_back(std::move(acceleration));
  }
  samples.steps = stepsOfRows(trajectory, samples);
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
  path.steps = std::move(samples.steps);
  if (path.positions.size() < 2) return path;
  path.times = std::move(samples.times);
  path.velocities = std::move(samples.velocities);
  return path;
}

}  // namespace leeway::planner
