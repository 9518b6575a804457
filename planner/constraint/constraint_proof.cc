#include "planner/constraint/constraint_proof.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using Turn = Constraint::Turn;

/// The angle between two unit vectors or rotations whose ends are `chord` apart at most, rounded
/// up; 4 where it may be any.
double angleOfChord(double chord) {
  return chord < 2 ? 2 * std::asin(chord / 2) * (1 + kLineRounding) : 4;
}

/// Whether a constraint keeps a place. How far its frame leaves chords matters to no other one.
bool keepsPlace(const Constraint& constraint) {
  return std::any_of(constraint.position.begin(), constraint.position.end(), [](const auto& range) {
    return std::isfinite(range.first) || std::isfinite(range.second);
  });
}

/// Angles of continuous joints within half a turn, so that a condition sees one place once.
void turnOnce(const ConfigurationSpace& space, std::span<double> state) {
  for (const ConfigurationSpace::Part& part : space.parts())
    if (part.kind == ConfigurationSpace::Kind::kCircle)
      state[at(part.first)] = std::remainder(state[at(part.first)], 2 * std::numbers::pi);
}

}  // namespace

ConstraintProof::ConstraintProof(const CompiledScene& scene, const Problem& problem)
    : scene_(&scene), condition_(problem.condition) {
  for (const Constraint& constraint : problem.constraints) {
    const robots::PoseRegion frame = frameOf(problem, constraint);
    parts_.push_back(
        {constraint, frame.X_WR, FrameMotion(scene, frame.link, frame.X_LF, frame.base), {}});
    parts_.back().constraint.axis.normalize();
    parts_.back().constraint.direction.normalize();
  }
}

ConstraintProof::Error ConstraintProof::errorOf(const Part& part, const robots::Pose& X_BF) {
  const Constraint& constraint = part.constraint;
  Error error;
  const Eigen::Matrix3d R_RF = part.X_BR.rotation.transpose() * X_BF.rotation;
  const Eigen::Vector3d p =
      part.X_BR.rotation.transpose() * (X_BF.translation - part.X_BR.translation);
  Eigen::Vector3d outside;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto& [from, to] = constraint.position[static_cast<std::size_t>(i)];
    outside[i] = std::max({from - p[i], p[i] - to, 0.0});
  }
  error.position = outside.norm();
  // |A - B| (Frobenius) of two rotations is sqrt(2) times the longest chord.
  if (constraint.turn == Turn::kFixed)
    error.chord = (R_RF - constraint.rotation).norm() / std::numbers::sqrt2;
  if (constraint.turn == Turn::kAxis) {
    const Eigen::Vector3d axis = R_RF * constraint.axis;
    error.cosine = axis.dot(constraint.direction);
    error.sine = (axis - error.cosine * constraint.direction).norm();
  }
  return error;
}

ConstraintProof::Error ConstraintProof::over(const Error& a, const Error& b,
                                             const ChordDeparture& departure) {
  return {std::max(a.position, b.position) + departure.origin,
          std::max(a.chord, b.chord) + departure.tips, std::max(a.sine, b.sine) + departure.tips,
          std::min(a.cosine, b.cosine) - departure.tips};
}

double ConstraintProof::angleOf(const Constraint& constraint, const Error& error) {
  if (constraint.turn == Turn::kAny) return 0;
  if (constraint.turn == Turn::kFixed) return angleOfChord(error.chord);
  const double most = std::acos(std::clamp(error.cosine, -1.0, 1.0)) + kLineRounding;
  if (!(error.cosine > 0) || !(error.sine < 1)) return most;
  return std::min(most, std::asin(error.sine) * (1 + kLineRounding));
}

bool ConstraintProof::isWithin(const Constraint& constraint, const Error& error) {
  // Both comparisons are false for NaN, which is therefore outside.
  return (!keepsPlace(constraint) ||
          error.position <= kConstraintShare * constraint.position_tolerance) &&
         angleOf(constraint, error) <= kConstraintShare * constraint.angle;
}

bool ConstraintProof::holds(std::span<const double> point) {
  return std::all_of(parts_.begin(), parts_.end(),
                     [&](Part& part) {
                       const Error error = errorOf(part, part.motion.poseAt(point));
                       return isWithin(part.constraint, over(error, error, part.motion.rounding()));
                     }) &&
         isAccepted(point, point);
}

bool ConstraintProof::holds(std::span<const double> a, std::span<const double> b) {
  return std::all_of(parts_.begin(), parts_.end(), [&](Part& part) { return holds(part, a, b); }) &&
         isAccepted(a, b);
}

bool ConstraintProof::isAccepted(std::span<const double> a, std::span<const double> b) {
  if (!condition_.accept) return true;
  const ConfigurationSpace& space = scene_->space();
  const double parts = std::ceil(space.greatestChange(a, b) / condition_.resolution);
  for (double first = 0; first <= parts; first += kConditionStates) {
    const double count = std::min(parts - first + 1, kConditionStates);
    states_.resize(a.size() * static_cast<std::size_t>(count));
    for (double i = 0; i < count; ++i) {
      const std::span<double> state(&states_[a.size() * static_cast<std::size_t>(i)], a.size());
      space.interpolate(a, b, parts > 0 ? (first + i) / parts : 0, state);
      turnOnce(space, state);
    }
    if (!condition_.accept(states_)) return false;
  }
  return true;
}

bool ConstraintProof::holds(Part& part, std::span<const double> a, std::span<const double> b) {
  FrameMotion& motion = part.motion;
  const auto errorAt = [&](double t) {
    const Error error = errorOf(part, motion.poseAt(t));
    return over(error, error, motion.rounding());
  };
  motion.begin(a, b);
  const Error first = errorAt(0);
  if (!isWithin(part.constraint, first)) return false;
  const Error last = errorAt(1);
  if (!isWithin(part.constraint, last)) return false;
  open_.assign(1, {0, 1, first, last});
  while (!open_.empty()) {
    const Span span = open_.back();
    open_.pop_back();
    const Error most = over(span.e0, span.e1, motion.departure(span.t0, span.t1));
    if (isWithin(part.constraint, most)) {
      if (keepsPlace(part.constraint))
        part.worst.deviation = std::max(part.worst.deviation, most.position);
      part.worst.angle = std::max(part.worst.angle, angleOf(part.constraint, most));
      continue;
    }
    if (span.t1 - span.t0 < 1.5 / (1 << kConstraintHalvings)) return false;
    const double middle = span.t0 / 2 + span.t1 / 2;
    const Error error = errorAt(middle);
    if (!isWithin(part.constraint, error)) return false;
    open_.push_back({middle, span.t1, error, span.e1});
    open_.push_back({span.t0, middle, span.e0, error});
  }
  return true;
}

std::string ConstraintProof::fault(std::span<const double> point) {
  for (Part& part : parts_) {
    const Constraint& constraint = part.constraint;
    const Error error = errorOf(part, part.motion.poseAt(point));
    if (isWithin(constraint, over(error, error, part.motion.rounding()))) continue;
    const auto text = [&](const char* what, double off, const char* unit, double tolerance) {
      return fmt::format(
          "constraint '{}': '{}' is {} {:.6g} {}, at most {:.6g} {} is allowed ({:g} %"
          " of its tolerance)",
          constraint.name, constraint.frame, what, off, unit, kConstraintShare * tolerance, unit,
          100 * kConstraintShare);
    };
    if (constraint.turn == Constraint::Turn::kAny ||
        !(error.position <= kConstraintShare * constraint.position_tolerance))
      return text("off where it may be by", error.position, "m", constraint.position_tolerance);
    return text("turned by", std::min(angleOf(constraint, error), std::numbers::pi), "rad",
                constraint.angle);
  }
  return isAccepted(point, point) ? "" : "the condition does not accept it";
}

std::optional<std::vector<ConstraintResult>> ConstraintProof::prove(
    const std::vector<std::vector<double>>& points, Broken* broken) {
  std::vector<ConstraintResult> results;
  const auto fail = [&](std::size_t edge, const std::string& what) {
    if (broken != nullptr) *broken = {edge, what};
    return std::nullopt;
  };
  for (Part& part : parts_) part.worst = {part.constraint.name, 0, 0};
  if (points.empty()) return fail(0, "the path has no row");
  for (std::size_t i = 0; i == 0 || i + 1 < points.size(); ++i) {
    const std::vector<double>&a = points[i], &b = points[std::min(i + 1, points.size() - 1)];
    for (Part& part : parts_)
      if (!holds(part, a, b))
        return fail(i, fmt::format("constraint '{}' is not proven to hold", part.constraint.name));
    if (!isAccepted(a, b)) return fail(i, "the condition does not hold");
  }
  for (const Part& part : parts_) results.push_back(part.worst);
  return results;
}

}  // namespace leeway::planner
