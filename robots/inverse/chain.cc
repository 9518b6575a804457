#include "robots/inverse/chain.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"

namespace leeway::robots {

namespace {

Eigen::Matrix3d turned(const ChainJoint& joint, double angle) {
  double s, c;
  collision::sineCosine(angle, s, c);
  return (joint.fixed + s * joint.sine) + c * joint.cosine;
}

Eigen::Matrix3d quaternionRotation(const double* p) {
  const double x = p[0], y = p[1], z = p[2], w = p[3];
  const double squared_norm = ((x * x + y * y) + z * z) + w * w;
  if (squared_norm == 0) return Eigen::Matrix3d::Identity();
  const double s = 2 / squared_norm;
  Eigen::Matrix3d R;
  R << 1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),  //
      s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w),   //
      s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y);
  return R;
}

/// The angular velocity in P of a floating joint whose quaternion p (xyzw) changes in component k:
/// twice the vector part of the change times the inverse of p.
Eigen::Vector3d quaternionTurn(const double* p, int k) {
  const double squared_norm = ((p[0] * p[0] + p[1] * p[1]) + p[2] * p[2]) + p[3] * p[3];
  if (squared_norm == 0)
    return k < 3 ? Eigen::Vector3d(2 * Eigen::Vector3d::Unit(k)) : Eigen::Vector3d::Zero();
  const Eigen::Vector3d v(p[0], p[1], p[2]);
  if (k == 3) return -2 / squared_norm * v;
  const Eigen::Vector3d e = Eigen::Vector3d::Unit(k);
  return 2 / squared_norm * (p[3] * e - e.cross(v));
}

}  // namespace

Chain makeChain(const Model& model, const PoseRegion& region, std::span<const Pose> X_WL,
                std::span<const int> column) {
  Chain chain;
  std::vector<int> path;
  for (int link = region.link; link >= 0; link = model.joints[at(link)].parent_link)
    path.push_back(link);
  std::reverse(path.begin(), path.end());

  // `before` transforms the frame of the chain's last joint (R at first) to that of the current
  // link.
  Pose before = region.base < 0 ? region.X_WR.inverse() : Pose{};
  double travel = 0;
  for (const int link : path) {
    const KinematicStep& step = model.steps[at(link)];
    const Joint& joint = model.joints[at(link)];
    ChainJoint moving;
    bool moves = false;
    const int count = joint.type == JointType::kFixed      ? 0
                      : joint.type == JointType::kPlanar   ? 3
                      : joint.type == JointType::kFloating ? 7
                                                           : 1;
    for (int k = 0; k < count; ++k) {
      moving.column[at(k)] = column[at(step.variable + k)];
      moves = moves || moving.column[at(k)] >= 0;
    }
    const Pose X_WP = step.parent_link < 0 ? Pose{} : X_WL[at(step.parent_link)];
    if (!moves) {
      before = before * (X_WP.inverse() * X_WL[at(link)]);
      continue;
    }
    moving.type = step.type;
    moving.variable = step.variable;
    moving.multiplier = step.multiplier;
    moving.offset = step.offset;
    moving.fixed = before.rotation * step.fixed;
    moving.sine = before.rotation * step.sine;
    moving.cosine = before.rotation * step.cosine;
    moving.translation = before * step.translation;
    moving.u = before.rotation * step.u;
    moving.v = before.rotation * step.v;
    moving.axis = joint.axis;
    if (!chain.joints.empty()) chain.reach += std::sqrt(moving.translation.squaredNorm());
    if (step.type == JointType::kPrismatic) {
      const Variable& v = model.variables[at(step.variable)];
      const double range = std::fabs(step.multiplier) * (v.upper - v.lower);
      if (std::isfinite(range)) travel += range;
    }
    chain.joints.push_back(moving);
    before = Pose{};
  }
  chain.X_PF = before * region.X_LF;
  if (!chain.joints.empty())
    chain.reach += std::sqrt(chain.X_PF.translation.squaredNorm()) + travel;
  return chain;
}

Chain makeBaseChain(const Model& model, const PoseRegion& region, std::span<const Pose> X_WL,
                    std::span<const int> column) {
  PoseRegion of_base;
  of_base.link = region.base;
  of_base.X_LF = region.X_WR;
  return makeChain(model, of_base, X_WL, column);
}

Pose place(const Chain& chain, const double* q, std::vector<Pose>& X_RC) {
  X_RC.resize(chain.joints.size());
  Pose X{};
  for (std::size_t i = 0; i < chain.joints.size(); ++i) {
    const ChainJoint& joint = chain.joints[i];
    const double* value = q + joint.variable;
    Eigen::Matrix3d R_PC;
    Eigen::Vector3d p_PC = joint.translation;
    switch (joint.type) {
      case JointType::kRevolute:
      case JointType::kContinuous:
        R_PC = turned(joint, joint.multiplier * value[0] + joint.offset);
        break;
      case JointType::kPrismatic:
        R_PC = joint.fixed;
        p_PC += joint.u * (joint.multiplier * value[0] + joint.offset);
        break;
      case JointType::kPlanar:
        R_PC = turned(joint, value[2]);
        p_PC += joint.u * value[0] + joint.v * value[1];
        break;
      default:
        R_PC = joint.fixed * quaternionRotation(value + 3);
        p_PC += joint.fixed * Eigen::Vector3d(value[0], value[1], value[2]);
    }
    X.translation += X.rotation * p_PC;
    X.rotation = (X.rotation * R_PC).eval();
    X_RC[i] = X;
  }
  return X * chain.X_PF;
}

void findTwists(const Chain& chain, const double* q, const std::vector<Pose>& X_RC,
                const Pose& X_RF, std::vector<Twist>& twists) {
  twists.clear();
  for (std::size_t i = 0; i < chain.joints.size(); ++i) {
    const ChainJoint& joint = chain.joints[i];
    const Eigen::Matrix3d R_RP = i == 0 ? Eigen::Matrix3d::Identity() : X_RC[i - 1].rotation;
    const auto slide = [&](int k, const Eigen::Vector3d& direction_P) {
      if (joint.column[at(k)] >= 0)
        twists.push_back({joint.column[at(k)], R_RP * direction_P, Eigen::Vector3d::Zero()});
    };
    const Eigen::Vector3d arm = X_RF.translation - X_RC[i].translation;
    const auto turn = [&](int k, const Eigen::Vector3d& axis_R) {
      if (joint.column[at(k)] >= 0)
        twists.push_back({joint.column[at(k)], axis_R.cross(arm), axis_R});
    };
    switch (joint.type) {
      case JointType::kRevolute:
      case JointType::kContinuous:
        turn(0, joint.multiplier * (X_RC[i].rotation * joint.axis));
        break;
      case JointType::kPrismatic:
        slide(0, joint.multiplier * joint.u);
        break;
      case JointType::kPlanar:
        slide(0, joint.u);
        slide(1, joint.v);
        turn(2, X_RC[i].rotation * joint.axis);
        break;
      default:
        for (int k = 0; k < 3; ++k) slide(k, joint.fixed.col(k));
        for (int k = 0; k < 4; ++k)
          turn(3 + k, R_RP * (joint.fixed * quaternionTurn(q + joint.variable + 3, k)));
    }
  }
}

}  // namespace leeway::robots
