#include "planner/task/line_way.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "planner/base/arc_tangent.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using robots::Pose;

/// A vector turned about a unit axis.
Eigen::Vector3d turned(const Eigen::Vector3d& v, const Eigen::Vector3d& axis, double angle) {
  double sine, cosine;
  collision::sineCosine(angle, sine, cosine);
  return cosine * v + sine * axis.cross(v) + (1 - cosine) * axis.dot(v) * axis;
}

/// Turns a stretch into the arc from its beginning through `via` to its end.
void makeArc(const Eigen::Vector3d& via, const std::string& what, WayStretch& stretch) {
  const Eigen::Vector3d& from = stretch.from.translation;
  const Eigen::Vector3d n = arcNormal(from, via, from + stretch.along, what);
  const Eigen::Vector3d u = via - from, v = stretch.along;
  stretch.normal = n.normalized();
  const Eigen::Vector3d to_center =
      (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
  stretch.center = from + to_center;
  const Eigen::Vector3d a = -to_center, b = v - to_center;
  const double sine = stretch.normal.dot(a.cross(b)), cosine = a.dot(b);
  double angle = firstQuadrantAngle(std::abs(sine), std::abs(cosine));
  if (cosine < 0) angle = std::numbers::pi - angle;
  stretch.arc = sine < 0 ? 2 * std::numbers::pi - angle : angle;
}

/// Adds the stretch between two poses. `what` names the second one in messages.
void add(LineWay& way, const Pose& from, const Pose& to, const Eigen::Vector3d* via,
         const std::string& what) {
  WayStretch stretch;
  stretch.from = from;
  stretch.along = to.translation - from.translation;
  const AxisTurn turn = axisTurn(from.rotation.transpose() * to.rotation);
  requireOneWay(turn, what);
  stretch.axis = turn.axis;
  stretch.turn = turn.angle;
  if (via != nullptr) makeArc(*via, what, stretch);
  way.stretches.push_back(stretch);
}

}  // namespace

Pose WayStretch::at(double share) const {
  Pose X = from;
  if (turn > 0)
    for (Eigen::Index i = 0; i < 3; ++i)
      X.rotation.col(i) = from.rotation * turned(Eigen::Vector3d::Unit(i), axis, share * turn);
  X.translation = arc > 0 ? center + turned(from.translation - center, normal, share * arc)
                          : Eigen::Vector3d(from.translation + share * along);
  return X;
}

double WayStretch::length() const {
  return arc > 0 ? arc * (from.translation - center).norm() : along.norm();
}

ChordDeparture WayStretch::departure(double share) const {
  const auto of = [share](double angle) {
    return share * angle * share * angle / 8 * (1 + kLineRounding) + kLineRounding;
  };
  return {arc > 0 ? (from.translation - center).norm() * of(arc) : 0, turn > 0 ? of(turn) : 0};
}

Pose LineWay::at(double place) const {
  const auto last = static_cast<double>(stretches.size() - 1);
  const double stretch = std::clamp(std::floor(place), 0.0, last);
  return stretches[static_cast<std::size_t>(stretch)].at(place - stretch);
}

LineWay lineWay(const Problem& world, const LineStep& line, std::span<const Pose> X_WL) {
  FramePose frame;
  frame.frame = line.frame;
  frame.relative_to = line.relative_to;
  frame.position.fill({0, 0});
  frame.rpy.fill({0, 0});
  const robots::PoseRegion region = regionOf(world, frame);
  LineWay way{region.link, region.X_LF, {}};
  Pose at = X_WL[leeway::at(region.link)] * region.X_LF;
  if (line.poses.empty()) {
    // `by` and `turn` refer to the axes of the frame itself if `relative_to` is empty.
    const Eigen::Matrix3d R = line.relative_to.empty() ? at.rotation : region.X_WR.rotation;
    Pose to = at;
    to.translation += R * line.by;
    to.rotation = R * line.turn * R.transpose() * at.rotation;
    add(way, at, to, nullptr, "turn");
    return way;
  }
  for (std::size_t i = 0; i < line.poses.size(); ++i) {
    const Waypoint& pose = line.poses[i];
    Pose to = at;
    to.translation = region.X_WR * pose.position;
    if (pose.rotation) to.rotation = region.X_WR.rotation * *pose.rotation;
    const Eigen::Vector3d via = pose.via ? region.X_WR * *pose.via : Eigen::Vector3d();
    add(way, at, to, pose.via ? &via : nullptr, fmt::format("poses[{}]", i));
    at = to;
  }
  return way;
}

}  // namespace leeway::planner
