#include "leeway/robots/motion_bound.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {
namespace {

double outwards(double x) { return x + kReachRounding * (1 + std::abs(x)); }

/// Holds the body over all positions of the joints walked so far, in the frame that the walk has
/// reached.
struct Ball {
  Eigen::Vector3d center;
  double radius;
};

/// The positions of a joint of one degree of freedom. A mimic's follow from its masters'.
VariableRange jointRange(const Model& model, int joint, std::span<const VariableRange> ranges) {
  double multiplier = 1, offset = 0;
  const Joint* j = &model.joints[at(joint)];
  for (std::size_t steps = 0; j->mimic >= 0 && steps < model.joints.size(); ++steps) {
    offset += multiplier * j->offset;
    multiplier *= j->multiplier;
    j = &model.joints[at(j->mimic)];
  }
  if (j->first_variable < 0) return {offset, offset};
  const VariableRange& r = ranges[at(j->first_variable)];
  // A joint of multiplier 0 stands still; 0 * infinity would be NaN.
  if (multiplier == 0) return {offset, offset};
  const double x = multiplier * r.lower + offset, y = multiplier * r.upper + offset;
  return {std::min(x, y), std::max(x, y)};
}

/// Middle and half width of a range; the half width of an unlimited one is infinite.
struct Spread {
  double middle, half;
};
Spread spread(const VariableRange& r) {
  if (!std::isfinite(r.lower) || !std::isfinite(r.upper)) return {0, kInfinity};
  const double middle = r.lower + (r.upper - r.lower) / 2;
  return {middle, std::max(r.upper - middle, middle - r.lower)};
}

Eigen::Vector3d rotated(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& p) {
  double s, c;
  collision::sineCosine(angle, s, c);
  return c * p + s * axis.cross(p) + (1 - c) * axis.dot(p) * axis;
}

/// Holds the ball at all angles about an axis through the origin. `reach` is its points' largest
/// distance from the axis.
Ball turned(const Ball& ball, const Eigen::Vector3d& axis, double& reach) {
  const double along = axis.dot(ball.center);
  reach = outwards((ball.center - along * axis).norm() + ball.radius);
  return {along * axis, reach};
}

/// Holds the ball at all rotations about the origin. `reach` is as for turned(), from the origin.
Ball turnedFreely(const Ball& ball, double& reach) {
  reach = outwards(ball.center.norm() + ball.radius);
  return {Eigen::Vector3d::Zero(), reach};
}

bool isConstant(const VariableRange& r) { return r.lower == r.upper; }

bool isConstant(const Model& model, int joint, std::span<const VariableRange> ranges) {
  const Joint& j = model.joints[at(joint)];
  if (j.type == JointType::kFixed) return true;
  if (j.type == JointType::kPlanar || j.type == JointType::kFloating) {
    for (int k = 0; k < j.variable_count; ++k)
      if (!isConstant(ranges[at(j.first_variable + k)])) return false;
    return true;
  }
  return isConstant(jointRange(model, joint, ranges));
}

/// One step of the walk from the body to the base: over a joint from its child's frame to its
/// parent's, or from parent to child (`inverted`). Sets `reach` for joints that turn.
Ball cross(const Model& model, int joint, bool inverted, Ball ball,
           std::span<const VariableRange> ranges, double& reach) {
  const Joint& j = model.joints[at(joint)];
  if (inverted) ball.center = j.X_PJ.inverse() * ball.center;
  const double sign = inverted ? -1 : 1;
  switch (j.type) {
    case JointType::kFixed:
      break;
    case JointType::kRevolute:
    case JointType::kContinuous: {
      const VariableRange r = jointRange(model, joint, ranges);
      if (isConstant(r))
        ball.center = rotated(j.axis, sign * r.lower, ball.center);
      else
        ball = turned(ball, j.axis, reach);
      break;
    }
    case JointType::kPrismatic: {
      const Spread s = spread(jointRange(model, joint, ranges));
      ball.center += sign * s.middle * j.axis;
      ball.radius += s.half;
      break;
    }
    case JointType::kPlanar: {
      const VariableRange& x = ranges[at(j.first_variable)];
      const VariableRange& y = ranges[at(j.first_variable + 1)];
      const double drift = std::hypot(std::max(std::abs(x.lower), std::abs(x.upper)),
                                      std::max(std::abs(y.lower), std::abs(y.upper)));
      if (inverted) ball.radius += drift;
      ball = turned(ball, j.axis, reach);
      if (!inverted) ball.radius += drift;
      break;
    }
    case JointType::kFloating: {
      Eigen::Vector3d middle, half;
      for (int k = 0; k < 3; ++k) {
        const Spread s = spread(ranges[at(j.first_variable + k)]);
        middle[k] = s.middle;
        half[k] = s.half;
      }
      const double drift = half.array().isFinite().all() ? half.norm() : kInfinity;
      if (inverted) ball = {ball.center - middle, ball.radius + drift};
      ball = turnedFreely(ball, reach);
      if (!inverted) ball = {ball.center + middle, ball.radius + drift};
      break;
    }
  }
  if (!inverted) ball.center = j.X_PJ * ball.center;
  ball.radius = outwards(ball.radius);
  return ball;
}

/// Links from `link` up to the root, `link` first.
std::vector<int> ancestors(const Model& model, int link) {
  std::vector<int> result;
  for (int l = link; l >= 0; l = model.joints[at(model.links[at(l)].joint)].parent_link)
    result.push_back(l);
  return result;
}

}  // namespace

std::vector<VariableRange> limitRanges(const Model& model) {
  std::vector<VariableRange> ranges;
  ranges.reserve(model.variables.size());
  for (const Variable& v : model.variables) ranges.push_back({v.lower, v.upper});
  return ranges;
}

RelativeMotion relativeMotion(const Model& model, int link, int base,
                              const Eigen::Vector3d& center_L, double radius) {
  return relativeMotion(model, link, base, center_L, radius, limitRanges(model));
}

RelativeMotion relativeMotion(const Model& model, int link, int base,
                              const Eigen::Vector3d& center_L, double radius,
                              std::span<const VariableRange> ranges) {
  std::vector<int> up = ancestors(model, link), down = ancestors(model, base);
  while (!up.empty() && !down.empty() &&
         up.back() == down.back()) {  // joints above both move neither against the other
    up.pop_back();
    down.pop_back();
  }
  RelativeMotion motion{link, base, {}, center_L, radius, 0};
  Ball ball{center_L, outwards(radius)};
  const auto step = [&](int l, bool inverted) {
    const int joint = model.links[at(l)].joint;
    double reach = 0;
    ball = cross(model, joint, inverted, ball, ranges, reach);
    if (!isConstant(model, joint, ranges)) motion.terms.push_back({joint, reach, inverted});
  };
  for (const int l : up) step(l, false);
  std::reverse(down.begin(), down.end());
  for (const int l : down) step(l, true);
  // The walk begins at the body, the terms at the base.
  std::reverse(motion.terms.begin(), motion.terms.end());
  motion.base_reach = outwards(ball.center.norm() + ball.radius);
  return motion;
}

namespace {

JointMotion motionOf(const Model& model, std::size_t joint, std::span<const double> dq) {
  const Joint* j = &model.joints[joint];
  double factor = 1;
  for (std::size_t steps = 0; j->mimic >= 0 && steps < model.joints.size(); ++steps) {
    factor *= j->multiplier;
    j = &model.joints[at(j->mimic)];
  }
  JointMotion m;
  if (j->first_variable < 0 || j->variable_count == 0) return m;
  const double* d = &dq[at(j->first_variable)];
  switch (model.joints[joint].type) {
    case JointType::kFixed:
      break;
    case JointType::kRevolute:
    case JointType::kContinuous:
      m.angle = std::abs(factor * d[0]);
      break;
    case JointType::kPrismatic:
      m.travel = std::abs(factor * d[0]);
      break;
    case JointType::kPlanar:
      m.travel = std::sqrt(d[0] * d[0] + d[1] * d[1]);
      m.angle = std::abs(d[2]);
      break;
    case JointType::kFloating:
      m.travel = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      m.angle = std::sqrt(d[3] * d[3] + d[4] * d[4] + d[5] * d[5]);
      break;
  }
  return m;
}

}  // namespace

void jointMotion(const Model& model, std::span<const double> dq,
                 std::span<JointMotion> joint_motion) {
  for (std::size_t i = 0; i < model.joints.size(); ++i) joint_motion[i] = motionOf(model, i, dq);
}

void jointMotion(const Model& model, std::span<const int> joints, std::span<const double> dq,
                 std::span<JointMotion> joint_motion) {
  for (const int j : joints) joint_motion[at(j)] = motionOf(model, at(j), dq);
}

namespace {

// clang-format off
/// Sums the joints' shares from the body to the base. Joints nearer to the body enter a term only
/// through `speed`, their sum so far:
///
///   joint    adds to speed   adds to acceleration
///   turn     |dq| rho        |dq|^2 rho (centripetal) + 2 |dq| speed (Coriolis)
///   slide    |dq|            nothing
// clang-format on
struct Sum {
  double speed = 0, acceleration = 0;

  void turn(double angle, double reach) {
    if (angle == 0) return;  // the reach may be infinite, and 0 * infinity is NaN
    acceleration += angle * (angle * reach + 2 * speed);
    speed += angle * reach;
  }
  void slide(double travel) { speed += travel; }
};

/// `reach(term, speed so far)` is rho of a joint that turns.
template <typename Reach>
MotionBound sumTerms(const Model& model, const RelativeMotion& motion,
                     std::span<const JointMotion> joint_motion, const Reach& reach) {
  Sum sum;
  for (std::size_t i = motion.terms.size(); i-- > 0;) {
    const RelativeMotion::Term& term = motion.terms[i];
    const JointMotion& m = joint_motion[at(term.joint)];
    if (model.joints[at(term.joint)].type == JointType::kPrismatic) {
      sum.slide(m.travel);
      continue;
    }
    if (term.inverted)
      sum.slide(m.travel);  // seen from the child, the slide of a free joint is nearer to the body
    if (m.angle != 0) sum.turn(m.angle, reach(term, sum.speed));
    if (!term.inverted) sum.slide(m.travel);
  }
  return {sum.speed * (1 + kBoundRounding), sum.acceleration * (1 + kBoundRounding)};
}

}  // namespace

double accelerationBound(const Model& model, const RelativeMotion& motion,
                         std::span<const JointMotion> joint_motion) {
  return sumTerms(model, motion, joint_motion, [](const auto& term, double) { return term.reach; })
      .acceleration;
}

double speedBound(const Model& model, const RelativeMotion& motion,
                  std::span<const JointMotion> joint_motion) {
  return sumTerms(model, motion, joint_motion, [](const auto& term, double) { return term.reach; })
      .speed;
}

MotionBound localMotionBound(const Model& model, const RelativeMotion& motion,
                             std::span<const JointMotion> joint_motion, std::span<const Pose> X_WL,
                             double half_interval, bool within_limits) {
  const Eigen::Vector3d center_W =
      motion.link < 0 ? motion.center_L : X_WL[at(motion.link)] * motion.center_L;
  return sumTerms(model, motion, joint_motion, [&](const RelativeMotion::Term& term, double speed) {
    const Joint& joint = model.joints[at(term.joint)];
    const Pose& X_WC = X_WL[at(joint.child_link)];
    const Eigen::Vector3d arm = center_W - X_WC.translation;
    const double squared = joint.type == JointType::kFloating
                               ? arm.squaredNorm()
                               : arm.cross(X_WC.rotation * joint.axis).squaredNorm();
    // Joints between this one and the body move it from its place at the middle by at most their
    // speed times the time from there.
    const double local = outwards(std::sqrt(squared) + motion.radius + half_interval * speed);
    return within_limits ? std::min(term.reach, local) : local;
  });
}

}  // namespace leeway::robots
