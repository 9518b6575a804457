#include "collision/deform/motion/blended_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

std::vector<double> keyTimesOf(const KeyTrack& track) {
  return {track.times().begin(), track.times().end()};
}

int countOf(const BlendedMotion::Field& base, const std::vector<BlendedMotion::Field>& fields) {
  return static_cast<int>(base.empty() && !fields.empty() ? fields[0].size() : base.size());
}

}  // namespace

BlendedMotion::BlendedMotion(MotionKind kind, Field base, std::vector<Field> fields, KeyTrack track,
                             std::vector<std::vector<double>> coordinates)
    : VertexMotion(kind, countOf(base, fields), static_cast<int>(fields.size()), keyTimesOf(track)),
      base_(std::move(base)),
      fields_(std::move(fields)),
      track_(std::move(track)),
      coordinates_(std::move(coordinates)) {
  measureFields();
  measureSegments();
}

BlendedMotion::BlendedMotion(MotionKind kind, Field base, std::vector<Field> fields,
                             std::vector<Harmonic> harmonics, const HarmonicBounds& bounds)
    : VertexMotion(kind, countOf(base, fields), static_cast<int>(fields.size()), {}),
      base_(std::move(base)),
      fields_(std::move(fields)),
      harmonics_(std::move(harmonics)),
      bounds_(bounds) {
  measureFields();
}

void BlendedMotion::measureFields() {
  base_size_ = largestCoordinate(base_);
  for (const Field& field : fields_) field_sizes_.push_back(largestCoordinate(field));
}

// Within a segment a vertex moves along a straight line, with ds/dt times the difference of its
// positions at the two keys. That difference is the sum of the fields times the differences of
// their coordinates.
void BlendedMotion::measureSegments() {
  const std::size_t n = fields_.size();
  std::vector<double> difference(n);
  for (std::size_t i = 0; i < track_->segments(); ++i) {
    double error = 0;  // of a coordinate of the sum below
    for (std::size_t k = 0; k < n; ++k) {
      difference[k] = coordinates_[i + 1][k] - coordinates_[i][k];
      error += std::abs(difference[k]) * field_sizes_[k];
    }
    error *= static_cast<double>(n + 2) * kUnitRoundoff;
    double longest_squared = 0;
    for (std::size_t v = 0; v < static_cast<std::size_t>(vertexCount()); ++v) {
      double x = 0, y = 0, z = 0;
      for (std::size_t k = 0; k < n; ++k) {
        x += difference[k] * fields_[k][v].x();
        y += difference[k] * fields_[k][v].y();
        z += difference[k] * fields_[k][v].z();
      }
      longest_squared = std::max(longest_squared, x * x + y * y + z * z);
    }
    const double moved = std::sqrt(longest_squared) + 2 * error;
    speeds_.push_back(roundedUp(moved * track_->rate(i), static_cast<double>(n) + 16));
    accelerations_.push_back(roundedUp(moved * track_->rateChange(i), static_cast<double>(n) + 16));
  }
}

void BlendedMotion::parameters(double time, std::span<double> out) const {
  if (track_) {
    track_->blend(coordinates_, time, out);
    return;
  }
  for (std::size_t k = 0; k < out.size(); ++k) {
    const Harmonic& h = harmonics_[k];
    double sine, cosine;
    sineCosine(angleOfTurns(h.frequency * time) + h.phase, sine, cosine);
    out[k] = h.amplitude * (h.cosine ? cosine : sine);
  }
}

void BlendedMotion::vertices(std::span<const double> parameters, int first,
                             std::span<Vector3d> out) const {
  const auto begin = static_cast<std::size_t>(first);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t v = begin + i;
    double x = 0, y = 0, z = 0;
    if (!base_.empty()) {
      x = base_[v].x();
      y = base_[v].y();
      z = base_[v].z();
    }
    for (std::size_t k = 0; k < fields_.size(); ++k) {
      x += parameters[k] * fields_[k][v].x();
      y += parameters[k] * fields_[k][v].y();
      z += parameters[k] * fields_[k][v].z();
    }
    out[i] = {x, y, z};
  }
}

double BlendedMotion::speedBound(double t0, double t1) const {
  if (track_) return track_->largest(speeds_, t0, t1);
  return t0 <= t1 ? bounds_.speed : kInfinity;
}

double BlendedMotion::accelerationBound(double t0, double t1) const {
  if (!track_) return t0 <= t1 ? bounds_.acceleration : kInfinity;
  if (track_->jumps(t0, t1)) return kInfinity;
  return track_->largest(accelerations_, t0, t1);
}

// Errors of a parameter. With keys: the error of the share times the difference of two values, and
// four roundings. For a harmonic: the error of its argument, which is 2 pi |f t| and the terms of
// angleOfTurns() and of the sum with the phase, and three units of the sine. A vertex is off by
// these times the fields, by the fields' own error times the parameters, and by one rounding for
// each product and sum. The factor 2 > sqrt(3) leads from one coordinate to three.
//
// Where 7 f t overflows, f t may overflow, too. The sine is then NaN, and so is NaN times an
// amplitude of 0: the vertices are unknown.
double BlendedMotion::rounding(double t0, double t1) const {
  if (!(t0 <= t1)) return kInfinity;
  const double latest = std::max(std::abs(t0), std::abs(t1));
  double error = 0, size = base_size_;
  for (std::size_t k = 0; k < fields_.size(); ++k) {
    double largest = 0, coordinate_error;
    if (track_) {
      for (const std::vector<double>& row : coordinates_)
        largest = std::max(largest, std::abs(row[k]));
      coordinate_error = largest * (2 * kShareRounding + 4);
    } else {
      const Harmonic& h = harmonics_[k];
      largest = std::abs(h.amplitude);
      coordinate_error =
          largest * (7 * std::abs(h.frequency) * latest + 2 * std::abs(h.phase) + 32);
    }
    error += coordinate_error * field_sizes_[k] * kUnitRoundoff + largest * bounds_.field_error;
    size += largest * field_sizes_[k];
  }
  const auto terms = static_cast<double>(fields_.size());
  const double total =
      roundedUp(2 * (error + 2 * (terms + 2) * kUnitRoundoff * size), 4 * terms + 16);
  return total >= 0 ? total : kInfinity;
}

}  // namespace leeway::collision
