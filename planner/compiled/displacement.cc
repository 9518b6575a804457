#include "planner/compiled/displacement.h"

#include <algorithm>
#include <cmath>

#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"

namespace leeway::planner {

Displacement::Displacement(const CompiledScene& scene)
    : scene_(scene),
      departure_(at(scene.space().size())),
      chord_(departure_),
      dq_(scene.model().variables.size()),
      motion_(scene.model().joints.size()) {}

double Displacement::of(std::span<const double> changes) {
  expandDifference(scene_.space(), changes, dq_);
  robots::jointMotion(scene_.model(), dq_, motion_);
  double most = 0;
  for (const robots::RelativeMotion& motion : scene_.edgeModel().motions)
    most = std::max(most, robots::speedBound(scene_.model(), motion, motion_));
  return most > 0 ? most * (1 + kGuardChordShare) + kGuardChordRounding : 0;
}

double Displacement::beyondLimits(std::span<const double> changes) {
  const double within = of(changes);
  double turn = 0;
  for (const robots::JointMotion& motion : motion_) turn += motion.angle;
  // Distances from axes, which `of` takes from the limits, grow by at most the result r itself:
  // r <= within + turn r.
  return turn < 1 ? within / (1 - turn) * (1 + kGuardChordShare) : kInfinity;
}

double Displacement::setChord(std::span<const double> a, std::span<const double> b) {
  std::fill(departure_.begin(), departure_.end(), 0);
  double squared = 0;
  for (const ConfigurationSpace::Part& part : scene_.space().parts()) {
    const std::size_t i = at(part.first);
    if (part.kind == ConfigurationSpace::Kind::kRotation) return kInfinity;
    chord_[i] = b[i] - a[i];
    squared += chord_[i] * chord_[i];
    // The space would go the other way.
    if (part.kind == ConfigurationSpace::Kind::kCircle && !(std::abs(chord_[i]) < kLongestLineTurn))
      return kInfinity;
  }
  return squared <= kGuardLongestChord * kGuardLongestChord ? squared : kInfinity;
}

void Displacement::depart(std::span<const double> a, std::span<const double> row, double squared) {
  double along = 0;
  for (std::size_t i = 0; i < row.size(); ++i) along += (row[i] - a[i]) * chord_[i];
  const double t = squared > 0 ? std::clamp(along / squared, 0.0, 1.0) : 0;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (const double d = std::abs(row[i] - a[i] - t * chord_[i]); !(d <= departure_[i]))
      departure_[i] = d;  // NaN as well
}

}  // namespace leeway::planner
