// The shape of a line: where its turns and arcs can be known, and what makes no sense.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "planner/base/arc_tangent.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

[[noreturn]] void refuseWay(const std::string& message) { throw std::invalid_argument(message); }

std::string pointText(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

void checkTurn(const std::string& key, const Eigen::Matrix3d& rotation) {
  if (const std::string wrong = poseFault({rotation, Eigen::Vector3d::Zero()}); !wrong.empty())
    refuseWay(key + " " + wrong);
}

}  // namespace

AxisTurn axisTurn(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond turn(rotation);
  if (turn.w() < 0) turn.coeffs() *= -1;
  const double sine = turn.vec().norm();
  AxisTurn result{Eigen::Vector3d::UnitZ(), 2 * firstQuadrantAngle(sine, turn.w())};
  if (sine > 0) result.axis = turn.vec() / sine;
  return result;
}

void requireOneWay(const AxisTurn& turn, const std::string& what) {
  if (!(turn.angle < std::numbers::pi - kHalfTurnSlack))
    refuseWay(what +
              " is half a turn from the pose before, which may go either way round; a pose between "
              "them is expected");
}

Eigen::Vector3d arcNormal(const Eigen::Vector3d& from, const Eigen::Vector3d& via,
                          const Eigen::Vector3d& to, const std::string& what) {
  const Eigen::Vector3d u = via - from, v = to - from, n = u.cross(v);
  // (Where two of the points nearly coincide, rounding decides on the plane.)
  const double longest = std::max({u.norm(), v.norm(), (v - u).norm()});
  if (!(n.norm() > kLeastArc * longest * longest))
    refuseWay(fmt::format(
        "{}: via ({}, {}, {}) is on one line with the arc's ends, or two of the three points "
        "coincide; three points of a circle are expected",
        what, via.x(), via.y(), via.z()));
  return n;
}

void checkWay(const LineStep& line, const std::optional<robots::Pose>& X_RF) {
  if (!(line.speed > 0))
    refuseWay(fmt::format("speed is {}; a number above 0 is expected [m/s]", line.speed));
  if (line.poses.empty()) {
    checkTurn("turn", line.turn);
    const bool turns = !line.turn.isIdentity(0);
    if (!(line.by.norm() > 0 || (turns && line.by.isZero(0))) || !line.by.allFinite())
      refuseWay(fmt::format("by is {}; the way from here [x, y, z] in m is expected",
                            line.by.isZero(0) ? "of no length" : pointText(line.by)));
    requireOneWay(axisTurn(line.turn), "turn");
    return;
  }
  if (!line.by.isZero(0) || !line.turn.isIdentity(0))
    refuseWay("it has both 'by' or a turn and 'poses'; one is expected");
  std::optional<Eigen::Vector3d> place;     // of the pose before, in R
  std::optional<Eigen::Matrix3d> rotation;  // likewise
  if (X_RF) place = X_RF->translation, rotation = X_RF->rotation;
  for (std::size_t i = 0; i < line.poses.size(); ++i) {
    const Waypoint& pose = line.poses[i];
    const std::string where = fmt::format("poses[{}]", i);
    for (const auto& [key, p] :
         {std::pair("position", &pose.position), {"via", pose.via ? &*pose.via : &pose.position}})
      if (!p->allFinite() || p->cwiseAbs().maxCoeff() > kAnyPosition)
        refuseWay(fmt::format("{}.{} is {}; numbers up to {} m are expected", where, key,
                              pointText(*p), kAnyPosition));
    if (pose.rotation) checkTurn(where + ".rotation", *pose.rotation);
    if (pose.via && place) arcNormal(*place, *pose.via, pose.position, where);
    if (pose.rotation && rotation)
      requireOneWay(axisTurn(rotation->transpose() * *pose.rotation), where);
    place = pose.position;
    if (pose.rotation) rotation = pose.rotation;
  }
}

}  // namespace leeway::planner
