#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "collision/base/rounding.h"
#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/blended_motion.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

double sumOfMagnitudes(const Vector3d& v) {
  return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z());
}

// The factor by which a pinned edge scales the waves at a vertex.
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

  // A bound on the error of at(): 4 units for a coordinate of the unit vector, one for the
  // difference, three for products and sums, one for the quotient; 12 cover them.
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
  MotionSource source = motion;
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
      // `along` is off by 8 units of |r|; the sine by 2 pi / wavelength times that and 19 units.
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
  return withSource(
      std::make_shared<BlendedMotion>(kKind, std::move(motion.rest), std::move(fields),
                                      std::move(harmonics), bounds),
      std::move(source));
}

}  // namespace leeway::collision
