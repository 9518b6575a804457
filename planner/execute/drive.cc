#include "planner/execute/drive.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

Drive::Drive(const std::shared_ptr<const ConfigurationSpace>& space, const Waypoints& path,
             const MotionLimits& limits, double period, Cuts cuts)
    : trajectory_(space, path, limits, std::move(cuts)), limits_(limits), period_(period) {
  sections_.push_back({0, 0});
  std::vector<double> velocity(leeway::at(space->size()));
  for (const double time : trajectory_.times()) {
    trajectory_.velocity(time, velocity);
    const bool rests =
        trajectory_.place(time).blend < 0 &&
        std::all_of(velocity.begin(), velocity.end(), [](double v) { return v == 0; });
    const double takes = time - sections_.back().time;
    if (!rests || !(takes > 0)) continue;
    const int periods = static_cast<int>(std::ceil(takes / period_ - kGuardSameTime));
    sections_.push_back({rows() + std::max(1, periods), time});
  }
  findCorners();
}

std::vector<double> Drive::at(double time) const {
  time = std::max(0.0, time);
  const ConfigurationSpace& space = trajectory_.space();
  std::vector<double> place(leeway::at(space.size()));
  auto next = std::upper_bound(sections_.begin(), sections_.end(), time,
                               [](double t, const Section& s) { return t < s.row; });
  double seconds = trajectory_.duration();
  if (next != sections_.end()) {
    const Section& now = *std::prev(next);
    seconds = std::min(now.time + (time - now.row) * period_, next->time);
  }
  trajectory_.configuration(seconds, place);
  // Rounding must not put it outside limits that the path keeps.
  for (const ConfigurationSpace::Part& part : space.parts())
    if (part.kind == ConfigurationSpace::Kind::kLine) {
      double& q = place[leeway::at(part.first)];
      q = std::clamp(q, space.lower(part.first), space.upper(part.first));
    }
  return place;
}

double Drive::timeOf(double seconds) const {
  auto next = std::upper_bound(sections_.begin(), sections_.end(), seconds,
                               [](double t, const Section& s) { return t < s.time; });
  const Section& now = *std::prev(next);
  return now.row + (seconds - now.time) / period_;
}

int Drive::restFrom(int row) const {
  for (const Section& section : sections_)
    if (section.row >= row) return section.row;
  return rows();
}

void Drive::findCorners() {
  std::vector<double> passed;  // waypoints at which the path may turn [s]
  const std::vector<int> cut = trajectory_.cutCorners();
  for (std::size_t i = 0; i < trajectory_.times().size(); ++i)
    if (!std::binary_search(cut.begin(), cut.end(), static_cast<int>(i)))
      passed.push_back(trajectory_.times()[i]);
  const auto add = [&](double time) { corners_.push_back({time, at(time)}); };
  const std::vector<double> knots = trajectory_.knots();
  const auto inBlend = [&](std::size_t k) {
    return k + 1 < knots.size() &&
           trajectory_.place(knots[k] + (knots[k + 1] - knots[k]) / 2).blend >= 0;
  };
  for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
    const double end = timeOf(knots[k + 1]);
    if (inBlend(k))
      for (double row = std::floor(timeOf(knots[k])) + 1; row < end; ++row) add(row);
    if (inBlend(k) != inBlend(k + 1) || k + 2 == knots.size() ||
        std::binary_search(passed.begin(), passed.end(), knots[k + 1]))
      add(end);
  }
}

Waypoints Drive::pathFrom(double time) const {
  Waypoints path = {at(time)};
  for (const Corner& corner : corners_)
    if (corner.time > time && corner.place != path.back()) path.push_back(corner.place);
  return path;
}

std::vector<double> Drive::stop(int row) const {
  row = std::min(row, rows());
  std::vector<double> best(leeway::at(restFrom(row) - row));
  std::iota(best.begin(), best.end(), row + 1.0);
  const ConfigurationSpace& space = trajectory_.space();
  const std::size_t size = leeway::at(space.size());
  std::vector<double> before(size), change(size);
  for (const int wait : kStopWaits) {
    const int first = row + wait;
    if (leeway::at(wait) >= best.size()) break;
    // The fastest change of speed at the velocity there, and twice the time in which the
    // acceleration there may end.
    space.difference(at(first - 2), at(first - 1), before);
    space.difference(at(first - 1), at(first), change);
    LineLimits rate{1, kInfinity, kInfinity};
    double ending = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double velocity = std::abs(change[i]) / period_;
      const double acceleration = std::abs(change[i] - before[i]) / (period_ * period_);
      if (!(velocity > 0)) continue;
      rate.acceleration = std::min(rate.acceleration, limits_.acceleration[i] / velocity);
      if (limits_.jerk.empty()) continue;
      rate.jerk = std::min(rate.jerk, limits_.jerk[i] / velocity);
      ending = std::max(ending, 2 * acceleration / limits_.jerk[i]);
    }
    if (!(rate.acceleration < kInfinity)) continue;
    const SpeedChange fastest(0, 1, rate);
    for (const double share : kStopTimes) {
      const double periods = std::ceil(share * (fastest.time + ending) / period_);
      if (!(wait + periods < static_cast<double>(best.size()))) break;
      const SpeedChange slowing(0, 1, periods, periods * fastest.ramp / fastest.time);
      std::vector<double> times;
      for (double k = 1; k <= periods; ++k)
        times.push_back(std::min<double>(first + k - slowing.at(k).way, rows()));
      if (!keepsLimits(first, times)) continue;
      best.resize(leeway::at(wait));
      std::iota(best.begin(), best.end(), row + 1.0);
      best.insert(best.end(), times.begin(), times.end());
      break;
    }
  }
  return best;
}

bool Drive::keepsLimits(int row, const std::vector<double>& times) const {
  const ConfigurationSpace& space = trajectory_.space();
  const std::size_t size = leeway::at(space.size()), count = times.size() + 5;
  std::vector<double> velocity(size), acceleration(size), before(size), earlier(size);
  std::vector<double> place = at(std::max(0, row - 2));
  for (std::size_t k = 1; k < count; ++k) {
    const double time = k < 3                  ? std::max(0.0, row - 2.0 + static_cast<double>(k))
                        : k < times.size() + 3 ? times[k - 3]
                                               : times.back();
    std::vector<double> next = at(time);
    space.difference(place, next, velocity);
    for (std::size_t i = 0; i < size; ++i) {
      velocity[i] /= period_;
      acceleration[i] = (velocity[i] - before[i]) / period_;
    }
    for (const ConfigurationSpace::Part& part : space.parts()) {
      if (k < 3) break;  // those before the stop
      const std::size_t i = leeway::at(part.first);
      const std::size_t n = part.kind == ConfigurationSpace::Kind::kRotation ? 3 : 1;
      const auto exceeds = [&](const std::vector<double>& now, const std::vector<double>* last,
                               double over, double limit, double rounding) {
        double squared = 0;
        for (std::size_t c = i; c < i + n; ++c) {
          const double d = (now[c] - (last == nullptr ? 0 : (*last)[c])) / over;
          squared += d * d;
        }
        return !(std::sqrt(squared) <= limit * (1 + kGuardLimitSlack) + rounding);
      };
      const double rounding = kGuardDifference * (std::abs(next[i]) + 1) / period_;
      if (exceeds(velocity, nullptr, 1, limits_.velocity[i], rounding) ||
          exceeds(acceleration, nullptr, 1, limits_.acceleration[i], rounding * 4 / period_) ||
          (!limits_.jerk.empty() && exceeds(acceleration, &earlier, period_, limits_.jerk[i],
                                            rounding * 16 / (period_ * period_))))
        return false;
    }
    std::swap(before, velocity);
    std::swap(earlier, acceleration);
    place = std::move(next);
  }
  return true;
}

}  // namespace leeway::planner
