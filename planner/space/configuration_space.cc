#include "leeway/planner/configuration_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "collision/base/greatest.h"
#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/arc_tangent.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using collision::kTwoPi;
using robots::Pose;

using Kind = ConfigurationSpace::Kind;

/// std::remainder is exact by IEEE 754, so it is the same on every machine.
double wrapped(double angle) {
  const double x = std::remainder(angle, kTwoPi);
  return x >= std::numbers::pi ? -std::numbers::pi : x;
}

bool unlimited(const robots::Variable& variable) {
  return std::isinf(variable.lower) && std::isinf(variable.upper);
}

/// Rotation vector r with b = a * exp(r / 2), |r| <= pi, for quaternions xyzw near unit length. The
/// half angle comes from sine and cosine together, because an arc cosine of the scalar product
/// would lose small angles.
void rotationDifference(const double* a, const double* b, double* r) {
  double v[3] = {(a[3] * b[0] - b[3] * a[0]) - (a[1] * b[2] - a[2] * b[1]),
                 (a[3] * b[1] - b[3] * a[1]) - (a[2] * b[0] - a[0] * b[2]),
                 (a[3] * b[2] - b[3] * a[2]) - (a[0] * b[1] - a[1] * b[0])};
  double w = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  if (w < 0) {  // b and -b are the same rotation; this is the shorter way
    w = -w;
    for (double& x : v) x = -x;
  }
  const double sine = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  // A tiny angle equals its sine to rounding, and the sine may have underflowed.
  const bool tiny = sine < kTinyAngle * w;
  const double scale = tiny ? 2 / w : sine > 0 ? 2 * firstQuadrantAngle(sine, w) / sine : 0;
  for (int i = 0; i < 3; ++i) r[i] = scale * v[i];
}

double rotationAngle(const double* r) { return std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]); }

/// a * exp(t r / 2), normalised.
void rotationAdvance(const double* a, const double* r, double t, double* result) {
  const double angle = rotationAngle(r);
  double sine = 0, cosine = 1, scale = t / 2;
  if (angle >= kTinyAngle) {
    collision::sineCosine(t * angle / 2, sine, cosine);
    scale = sine / angle;
  }
  const double e[3] = {scale * r[0], scale * r[1], scale * r[2]};
  const double p[4] = {a[3] * e[0] + cosine * a[0] + (a[1] * e[2] - a[2] * e[1]),
                       a[3] * e[1] + cosine * a[1] + (a[2] * e[0] - a[0] * e[2]),
                       a[3] * e[2] + cosine * a[2] + (a[0] * e[1] - a[1] * e[0]),
                       a[3] * cosine - (a[0] * e[0] + a[1] * e[1] + a[2] * e[2])};
  const double norm = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
  for (int i = 0; i < 4; ++i) result[i] = p[i] / norm;
}

/// The largest distance of a point of `geometry` from the line through `p_BC` along `axis_B`, or
/// from that point if the axis is 0 [m]; for round shapes, that of the bounding sphere.
double reachOf(const collision::Geometry& geometry, const Eigen::Vector3d& p_BC,
               const Eigen::Vector3d& axis_B) {
  const auto from = [&](const Eigen::Vector3d& p_GP) {
    const Eigen::Vector3d r = geometry.X_BG * p_GP - p_BC;
    return (r - axis_B.dot(r) * axis_B).norm();
  };
  const auto most = [&](std::span<const Eigen::Vector3d> points) {
    double reach = 0;
    for (const Eigen::Vector3d& p : points) reach = std::max(reach, from(p));
    return reach;
  };
  const collision::Shape& shape = geometry.shape;
  if (shape.hull() != nullptr) return most(shape.hull()->vertices());
  if (shape.mesh() != nullptr) return most(shape.mesh()->vertices());
  if (shape.type() != collision::ShapeType::kBox)
    return from(shape.boundingCenter()) + shape.boundingRadius();
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i)
    for (int k = 0; k < 3; ++k)
      corners[i][k] = ((i >> k & 1) != 0 ? 1 : -1) * shape.halfExtents()[k];
  return most(corners);
}

/// The largest distance of a point that `joint` moves from the joint's origin, or from its axis if
/// it is planar, with all other joints at their defaults [m].
double reachOf(const robots::Model& model, int joint) {
  std::vector<Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, model.defaultConfiguration(), X_WL);
  const robots::Joint& turned = model.joints[at(joint)];
  const Pose& X_WC = X_WL[at(turned.child_link)];
  const Eigen::Vector3d axis_W = turned.type == robots::JointType::kPlanar
                                     ? Eigen::Vector3d(X_WC.rotation * turned.axis)
                                     : Eigen::Vector3d::Zero();
  double reach = 0;
  for (int l = turned.child_link; at(l) < model.links.size(); ++l) {
    int above = l;
    while (above > turned.child_link) above = model.joints[at(above)].parent_link;
    if (above != turned.child_link) continue;
    const Pose X_LW = X_WL[at(l)].inverse();
    for (const collision::Geometry& geometry : model.links[at(l)].geometries)
      reach = std::max(reach, reachOf(geometry, X_LW * X_WC.translation, X_LW.rotation * axis_W));
  }
  return reach;
}

/// The weight of a turn [m/rad]; 1 if no moved link has a shape.
double turnWeight(const robots::Model& model, int joint) {
  const double reach = reachOf(model, joint);
  return reach > 0 && std::isfinite(reach) ? kTurnShare * reach : 1;
}

}  // namespace

ConfigurationSpace::ConfigurationSpace(std::shared_ptr<const robots::Model> model,
                                       std::vector<int> variables)
    : model_(std::move(model)), variables_(std::move(variables)) {
  if (!model_) throw std::invalid_argument("configuration space: a model is expected");
  for (std::size_t i = 0; i < variables_.size();) {
    const int v = variables_[i];
    if (v < 0 || at(v) >= model_->variables.size())
      throw std::invalid_argument("configuration space: variable index out of range");
    if (std::find(variables_.begin(), variables_.begin() + static_cast<std::ptrdiff_t>(i), v) !=
        variables_.begin() + static_cast<std::ptrdiff_t>(i))
      throw std::invalid_argument("configuration space: variable " + std::to_string(v) +
                                  " is listed twice");
    const robots::Variable& variable = model_->variables[at(v)];
    const robots::Joint& joint = model_->joints[at(variable.joint)];
    const int place = v - joint.first_variable;
    if (joint.type == robots::JointType::kFloating && place >= 3) {
      for (std::size_t k = 0; k < 4; ++k)
        if (place != 3 || i + k >= variables_.size() ||
            variables_[i + k] != v + static_cast<int>(k))
          throw std::invalid_argument("configuration space: the orientation of '" + joint.name +
                                      "' must be planned whole, its four variables in order");
      parts_.push_back({Kind::kRotation, static_cast<int>(i), turnWeight(*model_, variable.joint)});
      i += 4;
      continue;
    }
    const bool turned = joint.type == robots::JointType::kPlanar && place == 2;
    const bool angle = turned || joint.type == robots::JointType::kContinuous;
    parts_.push_back({angle && unlimited(variable) ? Kind::kCircle : Kind::kLine,
                      static_cast<int>(i), turned ? turnWeight(*model_, variable.joint) : 1});
    ++i;
  }
  for (const int v : variables_) {
    lower_.push_back(model_->variables[at(v)].lower);
    upper_.push_back(model_->variables[at(v)].upper);
  }
}

void ConfigurationSpace::difference(std::span<const double> a, std::span<const double> b,
                                    std::span<double> dq) const {
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kLine) dq[i] = b[i] - a[i];
    if (part.kind == Kind::kCircle) dq[i] = std::remainder(b[i] - a[i], kTwoPi);
    if (part.kind == Kind::kRotation) {
      rotationDifference(&a[i], &b[i], &dq[i]);
      dq[i + 3] = 0;
    }
  }
}

void ConfigurationSpace::advance(std::span<const double> a, std::span<const double> dq, double t,
                                 std::span<double> result) const {
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kLine) result[i] = a[i] + t * dq[i];
    if (part.kind == Kind::kCircle) result[i] = wrapped(a[i] + t * dq[i]);
    if (part.kind == Kind::kRotation) rotationAdvance(&a[i], &dq[i], t, &result[i]);
  }
}

void ConfigurationSpace::interpolate(std::span<const double> a, std::span<const double> b, double t,
                                     std::span<double> result) const {
  if (t == 0 || t == 1) {
    const std::span<const double> end = t == 0 ? a : b;
    if (end.data() != result.data()) std::copy(end.begin(), end.end(), result.begin());
    return;
  }
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind ==
        Kind::kLine)  // clamped, because rounding could leave the limits that a and b keep
      result[i] = std::clamp(a[i] + t * (b[i] - a[i]), std::min(a[i], b[i]), std::max(a[i], b[i]));
    if (part.kind == Kind::kCircle)
      result[i] = wrapped(a[i] + t * std::remainder(b[i] - a[i], kTwoPi));
    if (part.kind == Kind::kRotation) {
      double r[3];
      rotationDifference(&a[i], &b[i], r);
      rotationAdvance(&a[i], r, t, &result[i]);
    }
  }
}

double ConfigurationSpace::change(const Part& part, std::span<const double> a,
                                  std::span<const double> b) {
  const std::size_t i = at(part.first);
  if (part.kind == Kind::kCircle) return std::remainder(b[i] - a[i], kTwoPi);
  if (part.kind != Kind::kRotation) return b[i] - a[i];
  double r[3];
  rotationDifference(&a[i], &b[i], r);
  return rotationAngle(r);
}

double ConfigurationSpace::greatestChange(std::span<const double> a,
                                          std::span<const double> b) const {
  double most = 0;
  for (const Part& part : parts_) most = collision::greatest(most, std::abs(change(part, a, b)));
  return most;
}

double ConfigurationSpace::distance(std::span<const double> a, std::span<const double> b) const {
  double squared = 0;
  for (const Part& part : parts_) {
    const double d = part.weight * change(part, a, b);
    squared += d * d;
  }
  return std::sqrt(squared);
}

void ConfigurationSpace::requirePath(std::span<const std::vector<double>> waypoints,
                                     const char* call) const {
  for (const std::vector<double>& row : waypoints)
    if (row.size() != variables_.size())
      throw std::invalid_argument(std::string(call) + ": a waypoint of " +
                                  std::to_string(row.size()) + " numbers; " +
                                  std::to_string(variables_.size()) + " are expected");
}

bool ConfigurationSpace::withinLimits(std::span<const double> a) const {
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kRotation) {
      const double squared =
          a[i] * a[i] + a[i + 1] * a[i + 1] + a[i + 2] * a[i + 2] + a[i + 3] * a[i + 3];
      if (!(std::abs(squared - 1) <= 2 * kUnitQuaternion)) return false;  // NaN fails
      continue;
    }
    if (!std::isfinite(a[i])) return false;
    if (part.kind == Kind::kLine && !(a[i] >= lower(part.first) && a[i] <= upper(part.first)))
      return false;
  }
  return true;
}

std::string ConfigurationSpace::brokenLimit(std::span<const double> a) const {
  for (int i = 0; i < size(); ++i)
    if (!(std::isfinite(a[at(i)]) && a[at(i)] >= lower(i) && a[at(i)] <= upper(i)))
      return fmt::format("{} = {} is outside {} to {}",
                         model_->variables[at(variables_[at(i)])].name, a[at(i)], lower(i),
                         upper(i));
  for (const Part& part : parts_) {
    if (part.kind != Kind::kRotation) continue;
    const std::size_t i = at(part.first);
    const double length =
        std::sqrt(a[i] * a[i] + a[i + 1] * a[i + 1] + a[i + 2] * a[i + 2] + a[i + 3] * a[i + 3]);
    if (!(std::abs(length * length - 1) <= 2 * kUnitQuaternion))
      return fmt::format(
          "the quaternion that begins with {} has length {}; unit length is expected",
          model_->variables[at(variables_[i])].name, length);
  }
  return {};
}

void ConfigurationSpace::unwrap(std::span<const double> previous, std::span<double> next) const {
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kRotation && previous[i] * next[i] + previous[i + 1] * next[i + 1] +
                                                previous[i + 2] * next[i + 2] +
                                                previous[i + 3] * next[i + 3] <
                                            0)
      for (std::size_t k = i; k < i + 4; ++k) next[k] = -next[k];
    if (part.kind != Kind::kCircle) continue;
    // Exactly half a turn rounds to zero turns either way, so unwrapped points stay unchanged.
    const double turns = std::nearbyint((previous[i] - next[i]) / kTwoPi);
    if (turns != 0) next[i] += turns * kTwoPi;
  }
}

const char* ConfigurationSpace::interpolation() const {
  for (const Part& part : parts_)
    if (part.kind == Kind::kRotation) return kSpaceGeodesic;
  for (const int v : variables_)
    if (model_->joints[at(model_->variables[at(v)].joint)].type == robots::JointType::kPlanar)
      return kPlaneGeodesic;
  return kJointLinear;
}

void ConfigurationSpace::lineDifference(std::span<const double> a, std::span<const double> b,
                                        std::span<double> dq) const {
  difference(a, b, dq);
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kCircle) dq[i] = b[i] - a[i];
  }
}

void ConfigurationSpace::alongLine(std::span<const double> a, std::span<const double> b, double t,
                                   std::span<double> result) const {
  interpolate(a, b, t, result);
  if (t == 0 || t == 1) return;
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind == Kind::kCircle) result[i] = a[i] + t * (b[i] - a[i]);
  }
}

int ConfigurationSpace::edgesAlongLine(std::span<const double> a, std::span<const double> b) const {
  double most = 0;
  for (const Part& part : parts_) {
    const std::size_t i = at(part.first);
    if (part.kind != Kind::kCircle) continue;
    const double turn = b[i] - a[i];
    if (std::remainder(turn, kTwoPi) == turn) continue;
    if (!(std::abs(a[i]) <= kLargestAngle && std::abs(b[i]) <= kLargestAngle)) return 0;
    most = std::max(most, std::abs(turn));
  }
  return most > 0 ? static_cast<int>(std::ceil(most / kLongestLineTurn)) : 1;
}

std::vector<std::vector<double>> unwrapped(const ConfigurationSpace& space,
                                           std::vector<std::vector<double>> rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) space.unwrap(rows[i - 1], rows[i]);
  return rows;
}

}  // namespace leeway::planner
