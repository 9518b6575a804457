#include "collision/deform/motion/blended_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/round_up.h"
#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// 2 pi turns [rad], whole turns taken off first: that is exact. Off by less than 16 units for the
/// two operations, besides 2 pi times what `turns` is off.
double angleOfTurns(double turns) { return kTwoPi * (turns - std::nearbyint(turns)); }

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

// Within a segment a vertex moves along a straight line: ds/dt times the difference of its places
// at the two keys, which is the sum of the fields times the differences of their coordinates.
void BlendedMotion::measureSegments() {
  const std::size_t n = fields_.size();
  std::vector<double> difference(n);
  for (std::size_t i = 0; i < track_->segments(); ++i) {
    double error = 0;  // of one coordinate of the sum below
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
    const KeyPlace place = track_->at(time);
    const std::vector<double>& from = coordinates_[place.key];
    const std::vector<double>& to = coordinates_[std::min(place.key + 1, coordinates_.size() - 1)];
    for (std::size_t k = 0; k < out.size(); ++k)
      out[k] = (1 - place.share) * from[k] + place.share * to[k];
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

// A coordinate is off by the share's error times the difference of two values, and four roundings;
// a harmonic one by its argument's error, 2 pi |f t| and the terms of angleOfTurns() and its sum
// with the phase, and by three units of the sine. A vertex is off by that times the fields, by the
// fields' own error times the coordinates, and by one rounding a term and sum. The factor 2 is
// above sqrt(3), from one coordinate to three.
//
// Where 7 f t leaves the range of double so may f t, whose sine is no number, and that times an
// amplitude of 0 is none, either: nothing is known of the vertices then.
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

namespace {

void requireRow(MotionKind kind, std::size_t key, const std::vector<double>& row,
                std::size_t wanted, const std::string& thing) {
  const std::string name = "key " + std::to_string(key);
  requireCount(kind, name, row.size(), wanted, thing + "s");
  const std::string prefix = name + ", " + thing + " ";
  for (std::size_t k = 0; k < row.size(); ++k)
    requireUsable(kind, prefix + std::to_string(k), row[k]);
}

void requirePhase(MotionKind kind, const std::string& what, double phase) {
  if (std::abs(phase) <= kLargestPhase) return;  // false for a NaN
  refuse(kind, what + ": " + shown(phase) + "; finite numbers up to " + shown(kLargestPhase) +
                   " are accepted");
}

}  // namespace

std::shared_ptr<const VertexMotion> VertexMotion::morph(MorphMotion motion) {
  constexpr MotionKind kKind = MotionKind::kMorph;
  if (motion.references.empty()) refuse(kKind, "no references; at least 1 is needed");
  const std::size_t vertex_count = motion.references[0].size();
  requireVertices(kKind, vertex_count);
  for (std::size_t k = 0; k < motion.references.size(); ++k) {
    const std::string name = "reference " + std::to_string(k);
    requireCount(kKind, name, motion.references[k].size(), vertex_count, "vertices");
    requireUsable(kKind, name + ", vertex", motion.references[k]);
  }
  std::vector<double> times = timesOf(motion.keys);
  requireKeys(kKind, times);
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    requireRow(kKind, i, motion.keys[i].weights, motion.references.size(), "weight");
    rows.push_back(std::move(motion.keys[i].weights));
  }
  return std::make_shared<BlendedMotion>(
      kKind, BlendedMotion::Field{}, std::move(motion.references),
      KeyTrack(std::move(times), motion.interpolation), std::move(rows));
}

namespace {

// A vertex moves with at most the sum over the modes of 2 pi |f a| times its displacement there.
BlendedMotion::HarmonicBounds boundsOf(const ReducedMotion& motion) {
  double fastest = 0, sharpest = 0;
  for (std::size_t v = 0; v < motion.rest.size(); ++v) {
    double speed = 0, acceleration = 0;
    for (std::size_t k = 0; k < motion.modes.size(); ++k) {
      const ReducedMotion::Harmonic& h = motion.harmonics[k];
      const double angular = kTwoPi * std::abs(h.frequency);
      const double moved =
          angular * std::abs(h.amplitude) * std::sqrt(squaredLength(motion.modes[k][v]));
      speed += moved;
      acceleration += angular * moved;
    }
    fastest = std::max(fastest, speed);
    sharpest = std::max(sharpest, acceleration);
  }
  const double operations = 2 * static_cast<double>(motion.modes.size()) + 16;
  return {roundedUp(fastest, operations), roundedUp(sharpest, operations), 0};
}

std::vector<BlendedMotion::Harmonic> harmonicsOf(const ReducedMotion& motion) {
  constexpr MotionKind kKind = MotionKind::kReduced;
  if (!motion.keys.empty()) {
    refuse(kKind, std::to_string(motion.harmonics.size()) + " harmonics and " +
                      std::to_string(motion.keys.size()) + " keys; one or the other is accepted");
  }
  requireCount(kKind, "the motion", motion.harmonics.size(), motion.modes.size(), "harmonics");
  std::vector<BlendedMotion::Harmonic> result;
  for (std::size_t k = 0; k < motion.harmonics.size(); ++k) {
    const ReducedMotion::Harmonic& h = motion.harmonics[k];
    const std::string name = "harmonic " + std::to_string(k) + ", ";
    requireUsable(kKind, name + "amplitude", h.amplitude);
    requireUsable(kKind, name + "frequency", h.frequency);
    requirePhase(kKind, name + "phase", h.phase);
    result.push_back({h.amplitude, h.frequency, h.phase, false});
  }
  return result;
}

}  // namespace

std::shared_ptr<const VertexMotion> VertexMotion::reduced(ReducedMotion motion) {
  constexpr MotionKind kKind = MotionKind::kReduced;
  requireVertices(kKind, motion.rest.size());
  requireUsable(kKind, "rest vertex", motion.rest);
  if (motion.modes.empty()) refuse(kKind, "no modes; at least 1 is needed");
  for (std::size_t k = 0; k < motion.modes.size(); ++k) {
    const std::string name = "mode " + std::to_string(k);
    requireCount(kKind, name, motion.modes[k].size(), motion.rest.size(), "vertices");
    requireUsable(kKind, name + ", vertex", motion.modes[k]);
  }
  if (!motion.harmonics.empty()) {
    std::vector<BlendedMotion::Harmonic> harmonics = harmonicsOf(motion);
    const BlendedMotion::HarmonicBounds bounds = boundsOf(motion);
    return std::make_shared<BlendedMotion>(kKind, std::move(motion.rest), std::move(motion.modes),
                                           std::move(harmonics), bounds);
  }
  std::vector<double> times = timesOf(motion.keys);
  requireKeys(kKind, times);
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    requireRow(kKind, i, motion.keys[i].coordinates, motion.modes.size(), "coordinate");
    rows.push_back(std::move(motion.keys[i].coordinates));
  }
  return std::make_shared<BlendedMotion>(kKind, std::move(motion.rest), std::move(motion.modes),
                                         KeyTrack(std::move(times), motion.interpolation),
                                         std::move(rows));
}

namespace {

double sumOfMagnitudes(const Vector3d& v) {
  return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z());
}

/// How much of the waves reaches a vertex.
class Envelope {
 public:
  explicit Envelope(const std::optional<PinnedEdge>& pinned) : pinned_(pinned) {
    if (!pinned_) return;
    constexpr MotionKind kKind = MotionKind::kWaves;
    for (int k = 0; k < 3; ++k) requireUsable(kKind, "pinned point", pinned_->point[k]);
    pinned_->direction = requireDirection(kKind, "pinned direction", pinned_->direction);
    requireUsable(kKind, "pinned length", pinned_->length);
    if (!(pinned_->length > 0))
      refuse(kKind, "pinned length: " + shown(pinned_->length) + "; more than 0 is accepted");
  }

  double at(const Vector3d& r) const {
    if (!pinned_) return 1;
    const Vector3d d = r - pinned_->point;
    const Vector3d& n = pinned_->direction;
    return std::clamp((d.x() * n.x() + d.y() * n.y() + d.z() * n.z()) / pinned_->length, 0.0, 1.0);
  }

  /// The unit vector is off by 4 units a coordinate, the difference by one, the products and sums
  /// by three, the quotient by one: 12 cover them.
  double error(const Vector3d& r) const {
    if (!pinned_) return 0;
    return 12 * kUnitRoundoff * (sumOfMagnitudes(r) + sumOfMagnitudes(pinned_->point)) /
           pinned_->length;
  }

 private:
  std::optional<PinnedEdge> pinned_;
};

Wave checkedWave(const Wave& wave, std::size_t number) {
  constexpr MotionKind kKind = MotionKind::kWaves;
  const std::string name = "wave " + std::to_string(number) + ", ";
  Wave result = wave;
  result.direction = requireDirection(kKind, name + "direction", wave.direction);
  for (int k = 0; k < 3; ++k) requireUsable(kKind, name + "amplitude", wave.amplitude[k]);
  requireUsable(kKind, name + "wavelength", wave.wavelength);
  if (!(wave.wavelength > 0))
    refuse(kKind, name + "wavelength: " + shown(wave.wavelength) + "; more than 0 is accepted");
  requireUsable(kKind, name + "frequency", wave.frequency);
  requirePhase(kKind, name + "phase", wave.phase);
  return result;
}

}  // namespace

std::shared_ptr<const VertexMotion> VertexMotion::waves(WavesMotion motion) {
  constexpr MotionKind kKind = MotionKind::kWaves;
  requireVertices(kKind, motion.rest.size());
  requireUsable(kKind, "rest vertex", motion.rest);
  if (motion.waves.empty()) refuse(kKind, "no waves; at least 1 is needed");
  const Envelope envelope(motion.pinned);
  BlendedMotion::HarmonicBounds bounds;
  std::vector<BlendedMotion::Field> fields;
  std::vector<BlendedMotion::Harmonic> harmonics;
  for (std::size_t k = 0; k < motion.waves.size(); ++k) {
    const Wave wave = checkedWave(motion.waves[k], k);
    BlendedMotion::Field with_cosine, with_sine;
    for (const Vector3d& r : motion.rest) {
      const double along =
          wave.direction.x() * r.x() + wave.direction.y() * r.y() + wave.direction.z() * r.z();
      double sine, cosine;
      sineCosine(angleOfTurns(along / wave.wavelength), sine, cosine);
      const double share = envelope.at(r);
      with_cosine.push_back(share * sine * wave.amplitude);
      with_sine.push_back(share * cosine * wave.amplitude);
      // `along` is off by 8 units of |r|, the sine by that times 2 pi / wavelength and 19 units.
      const double error =
          kUnitRoundoff * (7 * 10 * sumOfMagnitudes(r) / wave.wavelength + 24) + envelope.error(r);
      bounds.field_error =
          std::max(bounds.field_error,
                   roundedUp(wave.amplitude.cwiseAbs().maxCoeff() * std::min(error, 2.0), 16));
    }
    fields.push_back(std::move(with_cosine));
    fields.push_back(std::move(with_sine));
    harmonics.push_back({1, -wave.frequency, wave.phase, true});
    harmonics.push_back({1, -wave.frequency, wave.phase, false});
    const double angular = kTwoPi * std::abs(wave.frequency);
    const double speed = angular * std::sqrt(squaredLength(wave.amplitude));
    bounds.speed += speed;
    bounds.acceleration += angular * speed;
  }
  const double operations = static_cast<double>(fields.size()) + 16;
  bounds.speed = roundedUp(bounds.speed, operations);
  bounds.acceleration = roundedUp(bounds.acceleration, operations);
  return std::make_shared<BlendedMotion>(kKind, std::move(motion.rest), std::move(fields),
                                         std::move(harmonics), bounds);
}

}  // namespace leeway::collision
