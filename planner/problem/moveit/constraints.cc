// Position and orientation constraints of a MoveIt goal (moveit_msgs/PositionConstraint,
// OrientationConstraint) as regions of poses, never larger than what they allow.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/problem/moveit/fields.h"
#include "planner/problem/moveit/header_frames.h"
#include "planner/problem/read_shapes.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using robots::Pose;
using robots::PoseRegion;

int constrainedLink(const YamlReader& constraint, const Problem& problem) {
  const YamlReader name = constraint.at("link_name", "the name of a link");
  const int link = problem.robot.model->findLink(name.text());
  if (link >= 0) return link;
  std::vector<std::string> known;
  for (const robots::Link& candidate : problem.robot.model->links) known.push_back(candidate.name);
  name.fail(fmt::format("unknown link '{}' in {}{}", name.text(), constraint.where(),
                        didYouMean(name.text(), known)));
}

/// Half the edges of a box that fits into the primitive.
Eigen::Vector3d boxWithin(const YamlReader& primitive) {
  const YamlReader type = primitive.at("type", "box, sphere or cylinder");
  const YamlReader sizes = primitive.at("dimensions", "a list of numbers");
  const std::string word = type.text();  // by name, or by the number of shape_msgs
  const bool box = word == "box" || word == "1", sphere = word == "sphere" || word == "2",
             cylinder = word == "cylinder" || word == "3";
  if (!box && !sphere && !cylinder)
    type.fail(fmt::format("{} is '{}'; box, sphere or cylinder is expected", type.where(), word));
  std::vector<double> d;
  for (const YamlReader& size : sizes.items()) d.push_back(size.sizeNumber());
  if (d.size() != (box ? 3U : sphere ? 1U : 2U))
    sizes.fail(fmt::format("{} is a list of {} for a {}", sizes.where(), d.size(), word));
  Eigen::Vector3d half;
  if (box) half = Eigen::Vector3d(d[0], d[1], d[2]) / 2;
  if (sphere) half.setConstant(d[0] / std::sqrt(3.0));
  if (cylinder) half = {d[1] / std::sqrt(2.0), d[1] / std::sqrt(2.0), d[0] / 2};
  half.array() -= kConstraintSlack;
  if (!(half.minCoeff() >= 0))
    sizes.fail(fmt::format("{} leave no room; at least {} m each way is expected", sizes.where(),
                           kConstraintSlack));
  return half;
}

/// Tolerances of an angle from this value on mean any turn, because files write them for that.
constexpr double kAnyTurn = 3.14;
/// Where cosines are positive, an angle bounds each of three turns.
constexpr double kMostEulerTurn = 1.57;
/// A right angle as it is written, or more.
constexpr double kRightAngle = 1.571;

PoseRegion anywhere(int link) {
  PoseRegion region;
  region.link = link;
  region.position.fill({-kAnyPosition, kAnyPosition});
  region.rpy.fill({-std::numbers::pi, std::numbers::pi});
  return region;
}

}  // namespace

PoseRegion readPositionConstraint(const YamlReader& constraint, HeaderFrames& frames,
                                  Problem& problem) {
  PoseRegion region = anywhere(constrainedLink(constraint, problem));
  if (const auto offset = constraint.find("target_point_offset"); hasContent(offset))
    region.X_LF.translation = readMoveitVector(*offset);
  const YamlReader allowed = constraint.at("constraint_region", "primitives and primitive_poses");
  refuseContent(allowed, "meshes", "a primitive");
  const YamlReader primitives = allowed.at("primitives", "a list of one primitive");
  const YamlReader poses = allowed.at("primitive_poses", "a list of one pose");
  if (primitives.items().size() != 1 || poses.items().size() != 1)
    primitives.fail(fmt::format("{} has {} primitives and {} poses; one of each is expected",
                                allowed.where(), primitives.items().size(), poses.items().size()));
  const Eigen::Vector3d half = boxWithin(primitives.items()[0]);
  for (int i = 0; i < 3; ++i) region.position[at(i)] = {-half[i], half[i]};
  region.X_WR = frames.ofConstraint(constraint) *
                readMoveitPose(poses.items()[0], "position", "orientation", problem.warnings);
  return region;
}

/// MoveIt allows R = R_wanted D with D = Rx(a) Ry(b) Rz(c), |a|, |b|, |c| at most the tolerances.
/// With Q = Ry(90 degrees), which turns z to x and x to -z, Q^T D Q = Rz(a) Ry(b) Rx(-c): roll,
/// pitch and yaw of F Q in R_wanted Q.
PoseRegion readOrientationConstraint(const YamlReader& constraint, HeaderFrames& frames,
                                     Problem& problem) {
  PoseRegion region = anywhere(constrainedLink(constraint, problem));
  const Eigen::Matrix3d wanted = rotationFromQuaternion(readMoveitQuaternion(
      constraint.at("orientation", "a quaternion [x, y, z, w]"), problem.warnings));
  Eigen::Matrix3d Q;
  Q << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  region.X_LF.rotation = Q;
  region.X_WR = frames.ofConstraint(constraint) * Pose{wanted * Q, Eigen::Vector3d::Zero()};
  const char* keys[] = {"absolute_z_axis_tolerance", "absolute_y_axis_tolerance",
                        "absolute_x_axis_tolerance"};  // roll, pitch, yaw
  double tolerance[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const YamlReader value = constraint.at(keys[i], "an angle [rad]");
    tolerance[i] = value.sizeNumber() - kConstraintSlack;
    if (!(tolerance[i] >= 0))
      value.fail(fmt::format("{} is {}; at least {} rad is expected", value.where(),
                             value.sizeNumber(), kConstraintSlack));
  }
  // The other form bounds the components of the rotation vector. Three turns by a third of the
  // least tolerance stay within it together.
  const auto form = constraint.find("parameterization");
  if (hasContent(form) && form->text() != "0") {
    const double least = *std::min_element(tolerance, tolerance + 3) / 3;
    std::fill(tolerance, tolerance + 3, least);
  }
  // Near a pitch of 90 degrees, a solution's error would change roll and yaw by more than the
  // slack.
  tolerance[1] = std::min(tolerance[1], 1.5);
  for (std::size_t i = 0; i < 3; ++i) region.rpy[i] = {-tolerance[i], tolerance[i]};
  return region;
}

namespace {

/// Adds the constraint if it is valid; else fails at its place.
void add(Constraint constraint, const YamlReader& place, Problem& problem) {
  constraint.name = fmt::format("path constraint {}", problem.constraints.size() + 1);
  if (const auto fault = constraintFault(problem, constraint, place.where()))
    place.fail(fault->message);
  problem.constraints.push_back(std::move(constraint));
}

}  // namespace

void readPathPosition(const YamlReader& constraint, HeaderFrames& frames, Problem& problem) {
  const PoseRegion region = readPositionConstraint(constraint, frames, problem);
  Constraint path;
  path.frame = problem.robot.model->links[at(region.link)].name;
  if (!region.X_LF.translation.isZero(0)) {
    path.frame =
        fmt::format("{} of path constraint {}", path.frame, problem.constraints.size() + 1);
    problem.robot.frames.push_back({path.frame, region.link, region.X_LF});
  }
  path.X_SR = region.X_WR;
  // The tolerance is taken from the box.
  double least = kInfinity;
  for (const auto& [from, to] : region.position) least = std::min(least, (to - from) / 2);
  path.position_tolerance = std::min(path.position_tolerance, least / 4);
  for (std::size_t i = 0; i < 3; ++i)
    path.position[i] = {region.position[i].first + path.position_tolerance,
                        region.position[i].second - path.position_tolerance};
  add(std::move(path), constraint, problem);
}

/// All angles are at most a right angle. D = Rx(a) Ry(b) Rz(c) turns a frame. If D turns by at most
/// t, then |a|, |b| and |c| are at most t, because cos(a) cos(b), cos(b) cos(c) and sin(b) are
/// entries of D. If D may have any c and tilts the frame's z by at most t, then |a| and |b| are at
/// most t. If it may have any a and tilts x by at most t, then |b| and |c| are. The rotation vector
/// of a turn by w about u has w sqrt(1 - u_z^2) across z, and a tilt t of z has sin(t / 2) =
/// sqrt(1 - u_z^2) sin(w / 2): across z it has at most pi sin(t / 2), as w is at most pi.
void readPathOrientation(const YamlReader& constraint, HeaderFrames& frames, Problem& problem) {
  Constraint path;
  path.frame = problem.robot.model->links[at(constrainedLink(constraint, problem))].name;
  path.X_SR = frames.ofConstraint(constraint);
  path.rotation = rotationFromQuaternion(readMoveitQuaternion(
      constraint.at("orientation", "a quaternion [x, y, z, w]"), problem.warnings));
  const auto form = constraint.find("parameterization");
  const bool is_vector = hasContent(form) && form->text() != "0";
  const auto warn = [&](const std::string& what) {
    problem.warnings.push_back(fmt::format("{}:{}: {} {}", constraint.file(), constraint.line(),
                                           constraint.where(), what));
  };
  double tolerances[3];
  const char* keys[] = {"absolute_x_axis_tolerance", "absolute_y_axis_tolerance",
                        "absolute_z_axis_tolerance"};
  for (std::size_t i = 0; i < 3; ++i)
    tolerances[i] = constraint.at(keys[i], "an angle [rad]").sizeNumber();
  // Of three angles, a tilt of x or of z bounds two; a tilt of y bounds none.
  std::size_t widest = tolerances[0] > tolerances[2] ? 0 : 2;
  if (is_vector && tolerances[1] > tolerances[widest]) widest = 1;
  double tilt = kInfinity;
  for (std::size_t i = 0; i < 3; ++i)
    if (i != widest) tilt = std::min(tilt, tolerances[i]);
  const bool is_free = tolerances[widest] >= kAnyTurn;
  if (tolerances[0] >= kAnyTurn && tolerances[1] >= (is_vector ? kAnyTurn : kRightAngle) &&
      tolerances[2] >= kAnyTurn)
    return warn("allows any rotation; it is left out");
  const auto free =
      std::count_if(tolerances, tolerances + 3, [](double t) { return t >= kAnyTurn; });
  if (free > 1 || (free == 1 && !is_free))
    constraint.fail(fmt::format(
        "{} leaves turns free that are not about {} alone; one of these, or tolerances below {} "
        "about all axes are expected",
        constraint.where(), is_vector ? "one axis" : "the x or z axis", kAnyTurn));
  const auto narrowed = [&](double angle) {
    if (angle > kMostEulerTurn)
      warn(fmt::format(
          "allows turns of {} rad; the path keeps {} rad, as the three angles bound no turn beyond "
          "a right angle",
          angle, kMostEulerTurn));
    return std::min(angle, kMostEulerTurn);
  };
  // The smaller two tolerances bound a tilt of the axis with the largest one, which bounds the
  // whole turn.
  const bool tilts = is_free || (std::min(tolerances[widest], kMostEulerTurn) > tilt && !is_vector);
  if (tilts) {
    path.turn = Constraint::Turn::kAxis;
    path.axis = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(widest));
    path.direction = path.rotation * path.axis;
    path.angle = narrowed(tilt);
    if (is_vector) {
      path.angle = 2 * std::asin(path.angle / std::numbers::pi);
      warn(
          fmt::format("allows {:.4g} rad of the rotation vector about two axes; the path tilts the "
                      "third axis by "
                      "at most {:.4g} rad, which keeps both at any turn about that axis",
                      tilt, path.angle));
    }
    add(path, constraint, problem);
    if (is_free) return;
  }
  path.turn = Constraint::Turn::kFixed;
  path.angle = narrowed(tilts ? tolerances[widest] : std::min(tilt, tolerances[widest]));
  add(std::move(path), constraint, problem);
}

}  // namespace leeway::planner
