#include "collision/deform/motion/key_track.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "collision/base/rounding.h"

namespace leeway::collision {

KeyTrack::KeyTrack(std::vector<double> times, Interpolation interpolation)
    : times_(std::move(times)), interpolation_(interpolation) {}

// u = (t - a) / (b - a) is off by three roundings, all relative. s = u u (3 - 2 u) has |ds/du|
// <= 1.5 and five roundings of numbers up to 3 u^2: 1.5 * 3 + 10 < 16 units.
KeyPlace KeyTrack::at(double time) const {
  if (!(time > times_.front())) return {0, 0};  // a NaN is held at the first key
  if (time >= times_.back()) return {times_.size() - 1, 0};
  const auto after = std::upper_bound(times_.begin(), times_.end(), time);
  const double begin = *(after - 1);
  const double u = std::min((time - begin) / (*after - begin), 1.0);
  const double s = interpolation_ == Interpolation::kSmooth ? u * u * (3 - 2 * u) : u;
  return {static_cast<std::size_t>(after - times_.begin()) - 1, std::min(s, 1.0)};
}

void KeyTrack::blend(std::span<const std::vector<double>> rows, double time,
                     std::span<double> out) const {
  const KeyPlace place = at(time);
  const std::vector<double>& from = rows[place.key];
  const std::vector<double>& to = rows[std::min(place.key + 1, rows.size() - 1)];
  for (std::size_t k = 0; k < out.size(); ++k)
    out[k] = (1 - place.share) * from[k] + place.share * to[k];
}

double KeyTrack::rate(std::size_t segment) const {
  const double steepest = interpolation_ == Interpolation::kSmooth ? 1.5 : 1;
  return roundedUp(steepest / (times_[segment + 1] - times_[segment]), 3);
}

double KeyTrack::rateChange(std::size_t segment) const {
  if (interpolation_ == Interpolation::kLinear) return 0;
  const double duration = times_[segment + 1] - times_[segment];
  return roundedUp(6 / duration / duration, 5);
}

double KeyTrack::largest(std::span<const double> of_segments, double t0, double t1) const {
  if (!(t0 <= t1)) return std::numeric_limits<double>::infinity();
  if (t1 < times_.front() || t0 > times_.back()) return 0;
  // The segments from the last that begins before t0 to the first that ends after t1.
  const auto first = std::lower_bound(times_.begin(), times_.end(), t0);
  const auto last = std::upper_bound(times_.begin(), times_.end(), t1);
  const auto begin = static_cast<std::size_t>(first - times_.begin());
  const auto end = std::min(static_cast<std::size_t>(last - times_.begin()), segments());
  double result = 0;
  for (std::size_t i = begin == 0 ? 0 : begin - 1; i < end; ++i)
    result = std::max(result, of_segments[i]);
  return result;
}

bool KeyTrack::jumps(double t0, double t1) const {
  if (interpolation_ == Interpolation::kSmooth) return false;
  const auto after = std::upper_bound(times_.begin(), times_.end(), t0);
  return times_.size() > 1 && after != times_.end() && *after < t1;
}

}  // namespace leeway::collision
