#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/blended_motion.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

// A vertex is no faster than the sum over the modes of 2 pi |f a| times its displacement there. Its
// acceleration has another factor of 2 pi |f|.
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
  MotionSource source = motion;
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
    return withSource(
        std::make_shared<BlendedMotion>(kKind, std::move(motion.rest), std::move(motion.modes),
                                        std::move(harmonics), bounds),
        std::move(source));
  }
  std::vector<double> times = timesOf(motion.keys);
  requireKeys(kKind, times);
  std::vector<std::vector<double>> rows;
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    requireRow(kKind, i, motion.keys[i].coordinates, motion.modes.size(), "coordinate");
    rows.push_back(std::move(motion.keys[i].coordinates));
  }
  return withSource(std::make_shared<BlendedMotion>(
                        kKind, std::move(motion.rest), std::move(motion.modes),
                        KeyTrack(std::move(times), motion.interpolation), std::move(rows)),
                    std::move(source));
}

}  // namespace leeway::collision
