#include "planner/execute/timed_path.h"

#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/timing/motion_limits.h"

namespace leeway::planner {
namespace {

/// The point at t of the edge. Rounding never moves it outside limits that both ends keep.
std::vector<double> pointOn(const ConfigurationSpace& space, std::span<const double> a,
                            std::span<const double> b, double t) {
  std::vector<double> point(a.size());
  space.interpolate(a, b, t, point);
  for (const ConfigurationSpace::Part& part : space.parts())
    if (part.kind == ConfigurationSpace::Kind::kLine) {
      const std::size_t i = at(part.first);
      point[i] = std::clamp(point[i], std::min(a[i], b[i]), std::max(a[i], b[i]));
    }
  return point;
}

}  // namespace

double edgeDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    std::span<const double> a, std::span<const double> b) {
  std::vector<double> dq(a.size());
  space.difference(a, b, dq);
  return timeAtLimits(space, limits, dq);
}

double pathDuration(const ConfigurationSpace& space, std::span<const double> limits,
                    const std::vector<std::vector<double>>& path) {
  double time = 0;
  for (std::size_t i = 1; i < path.size(); ++i)
    time += edgeDuration(space, limits, path[i - 1], path[i]);
  return time;
}

std::vector<TimedPoint> partOf(const ConfigurationSpace& space, std::span<const TimedPoint> motion,
                               double t0, double t1) {
  const auto place = [&](double t) {
    std::size_t i = 1;
    // The first of rows with one time, so that the part begins where the motion does.
    while (i + 1 < motion.size() && motion[i].time < t) ++i;
    const TimedPoint &a = motion[i - 1], &b = motion[i];
    if (t <= a.time) return a.position;
    if (t >= b.time) return b.position;
    return pointOn(space, a.position, b.position, (t - a.time) / (b.time - a.time));
  };
  std::vector<TimedPoint> part = {{t0, place(t0)}};
  for (const TimedPoint& row : motion)
    if (row.time > t0 && row.time < t1) part.push_back(row);
  part.push_back({t1, place(t1)});
  return part;
}

}  // namespace leeway::planner
