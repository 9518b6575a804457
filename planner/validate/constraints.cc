// Checks the constraints of a problem, and derives the regions of poses in which they hold.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string_view>

#include "collision/base/numbers.h"
#include "leeway/planner/planners.h"
#include "planner/base/tolerances.h"
#include "planner/space/ompl_planners.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using Turn = Constraint::Turn;

/// A pose of the frame that leaves position and rotation free.
FramePose anyPose(const Constraint& constraint) {
  FramePose pose;
  pose.frame = constraint.frame;
  pose.relative_to = constraint.relative_to;
  pose.position.fill({-kAnyPosition, kAnyPosition});
  pose.rpy.fill({-std::numbers::pi, std::numbers::pi});
  return pose;
}

bool isAny(const std::pair<double, double>& range) {
  return std::isinf(range.first) && std::isinf(range.second);
}

/// A rotation whose z axis is along a vector.
Eigen::Matrix3d withAxis(const Eigen::Vector3d& vector) {
  Eigen::Matrix3d R;
  R.col(2) = vector.normalized();
  R.col(0) = R.col(2).unitOrthogonal();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

std::string vectorText(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// The least angle between a rotation that one constraint allows and one that another allows, both
/// without their tolerances, seen from the frame of relative_to.
double turnBetween(const Constraint& a, const Constraint& b) {
  if (a.turn == Turn::kAny || b.turn == Turn::kAny) return 0;
  const Eigen::Matrix3d &R_a = a.X_SR.rotation, &R_b = b.X_SR.rotation;
  if (a.turn == Turn::kFixed && b.turn == Turn::kFixed)
    return axisTurn((R_a * a.rotation).transpose() * (R_b * b.rotation)).angle;
  if (a.turn == Turn::kAxis && b.turn == Turn::kFixed) return turnBetween(b, a);
  const Eigen::Vector3d direction_b = R_b * b.direction;
  if (a.turn == Turn::kFixed) return angleBetween(R_a * (a.rotation * b.axis), direction_b);
  // A rotation keeps the angle between the two axes.
  return std::abs(angleBetween(a.axis, b.axis) - angleBetween(R_a * a.direction, direction_b));
}

/// How far places that one constraint allows are from those that another allows, without their
/// tolerances [m]. Those of different frames are not compared.
double placesBetween(const Constraint& a, const Constraint& b) {
  if (a.X_SR.rotation != b.X_SR.rotation || a.X_SR.translation != b.X_SR.translation) return 0;
  Eigen::Vector3d gap;
  for (std::size_t i = 0; i < 3; ++i)
    gap[static_cast<Eigen::Index>(i)] =
        std::max(0.0, std::max(a.position[i].first, b.position[i].first) -
                          std::min(a.position[i].second, b.position[i].second));
  return gap.norm();
}

/// Returns how two constraints of one frame, seen from one reference, contradict each other; empty
/// if both may hold.
std::string contradiction(const Constraint& a, const Constraint& b) {
  constexpr double kRounding = 1e-9;  // [m], [rad]
  if (a.frame != b.frame || a.relative_to != b.relative_to) return "";
  const double apart = placesBetween(a, b), within = a.position_tolerance + b.position_tolerance;
  if (apart > within + kRounding)
    return fmt::format(
        "the places that they allow '{}' are {:.6g} m apart, and their tolerances add up to {:.6g} "
        "m",
        a.frame, apart, within);
  const double turn = turnBetween(a, b), least = a.angle + b.angle;
  if (turn > least + kRounding)
    return fmt::format(
        "the rotations that they allow '{}' are {:.6g} rad apart, and their angles add up to "
        "{:.6g} rad",
        a.frame, turn, least);
  return "";
}

/// Returns why no configuration brings the constraint's frame to its place; empty if one may.
std::string whyBeyondReach(const Problem& problem, const Constraint& constraint) {
  const robots::PoseRegion frame = frameOf(problem, constraint);
  if (frame.base >= 0 || problem.start.size() != problem.robot.model->variables.size()) return "";
  const auto [center_W, radius] = pointReach(problem, frame.link, frame.X_LF.translation);
  const Eigen::Vector3d center = frame.X_WR.inverse() * center_W;
  Eigen::Vector3d gap;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const auto& [from, to] = constraint.position[i];
    gap[k] = std::max({0.0, from - center[k], center[k] - to});
  }
  const double beyond = gap.norm() - radius - constraint.position_tolerance;
  if (!(beyond > 0)) return "";
  return fmt::format(
      "is out of the reach of '{}' by at least {:.6g} m; a place within {:.6g} m of {} "
      "is expected",
      constraint.frame, beyond, radius, vectorText(center));
}

}  // namespace

Constraint upright(const std::string& frame, const Eigen::Vector3d& axis, double angle) {
  Constraint constraint;
  constraint.name = "upright";
  constraint.frame = frame;
  constraint.turn = Turn::kAxis;
  constraint.axis = axis;
  constraint.angle = angle;
  return constraint;
}

robots::PoseRegion frameOf(const Problem& problem, const Constraint& constraint) {
  robots::PoseRegion frame = regionOf(problem, anyPose(constraint), true);
  frame.X_WR = frame.X_WR * constraint.X_SR;
  return frame;
}

std::vector<robots::PoseRegion> regionsOf(const Problem& problem, const Constraint& constraint) {
  std::vector<robots::PoseRegion> regions;
  FramePose place = anyPose(constraint);
  bool has_place = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::pair<double, double>& range = constraint.position[i];
    if (isAny(range)) continue;
    has_place = true;
    place.position[i] = {std::max(range.first, -kAnyPosition),
                         std::min(range.second, kAnyPosition)};
  }
  place.position_tolerance = kProjectionShare * constraint.position_tolerance;
  if (constraint.turn == Turn::kFixed) {
    place.rotation = constraint.rotation;
    place.rpy.fill({0, 0});
    place.angle_tolerance = kProjectionShare * constraint.angle;
  }
  const auto add = [&](const FramePose& pose) {
    regions.push_back(regionOf(problem, pose, true));
    regions.back().X_WR = regions.back().X_WR * constraint.X_SR;
  };
  if (has_place || constraint.turn == Turn::kFixed) add(place);
  // Configurations seldom leave wide cones.
  if (constraint.turn != Turn::kAxis || constraint.angle > kMostTilt * std::numbers::sqrt2)
    return regions;
  // Let F' and R' have the axis and its direction as z. Then cos(tilt) = cos(roll) cos(pitch), and
  // a roll and a pitch of angle / sqrt(2) each tilt by less than the angle.
  FramePose tilt = anyPose(constraint);
  tilt.rotation = withAxis(constraint.axis).transpose();
  const double most = std::min(kTiltShare * constraint.angle / std::numbers::sqrt2, kMostTilt);
  tilt.rpy = {{{-most, most}, {-most, most}, {-std::numbers::pi, std::numbers::pi}}};
  tilt.angle_tolerance = kProjectionShare * constraint.angle;
  add(tilt);
  regions.back().X_WR.rotation = regions.back().X_WR.rotation * withAxis(constraint.direction);
  return regions;
}

std::optional<Fault> constraintFault(const Problem& problem, const Constraint& constraint,
                                     const std::string& where) {
  const auto fault = [&](const char* key, const std::string& what) {
    return Fault{fmt::format("{}{}{} {}", where, *key == '\0' ? "" : ".", key, what), key, {}};
  };
  bool says = constraint.turn != Turn::kAny;
  for (const auto& [from, to] : constraint.position) {
    says = says || !isAny({from, to});
    if (!(from <= to) || from == kInfinity || to == -kInfinity)
      return fault("position",
                   fmt::format("has a range from {} to {}; from <= to is expected", from, to));
    for (const double end : {from, to})
      if (std::isfinite(end) && std::abs(end) > kAnyPosition)
        return fault("position", fmt::format("is {}; at most {} is expected", end, kAnyPosition));
  }
  if (!says) return fault("", "keeps nothing; position, a rotation or an axis is expected");
  const auto tolerance = [&](const char* key, double value, double most) -> std::optional<Fault> {
    if (value >= kLeastConstraintTolerance && value <= most) return std::nullopt;
    return fault(
        key, fmt::format("is {}; {} to {} is expected", value, kLeastConstraintTolerance, most));
  };
  if (auto wrong = tolerance("position_tolerance", constraint.position_tolerance, kAnyPosition))
    return wrong;
  if (constraint.turn != Turn::kAny)
    if (auto wrong = tolerance("angle", constraint.angle, std::numbers::pi)) return wrong;
  if (constraint.turn == Turn::kAxis)
    for (const auto& [key, v] :
         {std::pair("axis", &constraint.axis), {"direction", &constraint.direction}})
      if (!(v->norm() >= kLeastAxis && v->norm() <= kMostAxis))
        return fault(key, fmt::format("is {}; a direction is expected, of length {} to {}",
                                      vectorText(*v), kLeastAxis, kMostAxis));
  if (constraint.turn == Turn::kFixed)
    if (const std::string wrong = poseFault({constraint.rotation, Eigen::Vector3d::Zero()});
        !wrong.empty())
      return fault("rotation", wrong);
  if (const std::string wrong = poseFault(constraint.X_SR); !wrong.empty())
    return fault("X_SR", wrong);
  try {
    if (const std::string why = whyBeyondReach(problem, constraint); !why.empty())
      return fault("position", why);
  } catch (const std::invalid_argument& error) {
    return Fault{where + ": " + error.what(), "frame", {}};
  }
  return std::nullopt;
}

/// The least distance between states at which a condition is looked at [rad or m]. Less takes
/// minutes for one path.
constexpr double kLeastResolution = 1e-4;

std::optional<std::string> constraintsFault(const Problem& problem) {
  if (!isConstrained(problem)) return std::nullopt;
  if (problem.condition.accept && !(problem.condition.resolution >= kLeastResolution &&
                                    std::isfinite(problem.condition.resolution)))
    return fmt::format("condition.resolution is {}; a distance of at least {} is expected",
                       problem.condition.resolution, kLeastResolution);
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < problem.constraints.size(); ++i)
    if (const std::string& name = problem.constraints[i].name;
        !name.empty() && !names.insert(name).second)
      return fmt::format(
          "constraints[{}]: two constraints are named '{}'; a name of its own is expected for each",
          i, name);
  for (std::size_t i = 0; i < problem.constraints.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (const std::string why = contradiction(problem.constraints[k], problem.constraints[i]);
          !why.empty())
        return fmt::format(
            "constraints[{}] and constraints[{}] contradict each other: {}; constraints that can "
            "hold at once are expected",
            k, i, why);
  const std::string what =
      problem.constraints.empty() ? "there is a condition" : "there are constraints";
  if (!problem.steps.empty())
    return what + " beside steps, which do not keep them; goals are expected";
  if (!std::holds_alternative<MinimumLength>(problem.objective))
    return what + ", and another objective than length, which is expected";
  if (asksForCost(problem))
    return what + ", and wishes, which do not keep them; margins without a wish are expected";
  if (findPlanner(problem.planner.name) != findPlanner("Connect"))
    return fmt::format("{}, which planner '{}' does not keep; Connect is expected", what,
                       problem.planner.name);
  const auto improve = problem.planner.parameters.find("improve");
  if (improve != problem.planner.parameters.end() && parameterNumber(improve->second) != 0.0)
    return what +
           ", which planner.parameters.improve does not keep; a planner without it is expected";
  return std::nullopt;
}

}  // namespace leeway::planner
