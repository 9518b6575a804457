#include "leeway/robots/kinematics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "collision/base/sine_cosine.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {

namespace {

/// result = a * b, in a fixed order of operations.
inline void multiply(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, Eigen::Matrix3d& result) {
  for (int column = 0; column < 3; ++column) {
    const double b0 = b(0, column), b1 = b(1, column), b2 = b(2, column);
    for (int row = 0; row < 3; ++row)
      result(row, column) = (a(row, 0) * b0 + a(row, 1) * b1) + a(row, 2) * b2;
  }
}

inline void transform(const Pose& X, const Eigen::Vector3d& p, Eigen::Vector3d& result) {
  const Eigen::Matrix3d& a = X.rotation;
  for (int row = 0; row < 3; ++row)
    result(row) = ((a(row, 0) * p(0) + a(row, 1) * p(1)) + a(row, 2) * p(2)) + X.translation(row);
}

inline void turnedRotation(const KinematicStep& step, double angle, Eigen::Matrix3d& rotation) {
  double sine, cosine;
  collision::sineCosine(angle, sine, cosine);
  for (int i = 0; i < 9; ++i)
    rotation.data()[i] =
        (step.fixed.data()[i] + sine * step.sine.data()[i]) + cosine * step.cosine.data()[i];
}

/// The rotation of a quaternion xyzw of any length; of a zero one the identity.
Eigen::Matrix3d quaternionRotation(double x, double y, double z, double w) {
  const double squared_norm = ((x * x + y * y) + z * z) + w * w;
  if (squared_norm == 0) return Eigen::Matrix3d::Identity();
  const double s = 2 / squared_norm;
  Eigen::Matrix3d rotation;
  rotation << 1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),  //
      s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w),          //
      s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y);
  return rotation;
}

/// X_PC of one joint at the configuration q.
inline void localPose(const KinematicStep& step, const double* q, Pose& X_PC) {
  switch (step.type) {
    case JointType::kFixed:
      X_PC.rotation = step.fixed;
      X_PC.translation = step.translation;
      return;
    case JointType::kRevolute:
    case JointType::kContinuous:
      turnedRotation(step, step.multiplier * q[step.variable] + step.offset, X_PC.rotation);
      X_PC.translation = step.translation;
      return;
    case JointType::kPrismatic:
      X_PC.rotation = step.fixed;
      X_PC.translation =
          step.translation + step.u * (step.multiplier * q[step.variable] + step.offset);
      return;
    case JointType::kPlanar:
      turnedRotation(step, q[step.variable + 2], X_PC.rotation);
      X_PC.translation =
          step.translation + (step.u * q[step.variable] + step.v * q[step.variable + 1]);
      return;
    case JointType::kFloating: {
      const double* p = q + step.variable;
      const Eigen::Matrix3d turn = quaternionRotation(p[3], p[4], p[5], p[6]);
      multiply(step.fixed, turn, X_PC.rotation);
      transform(Pose{step.fixed, step.translation}, Eigen::Vector3d(p[0], p[1], p[2]),
                X_PC.translation);
      return;
    }
  }
}

inline void placeLink(const Model& model, std::size_t i, const double* q, Pose* X_WL) {
  const KinematicStep& step = model.steps[i];
  if (step.parent_link < 0) {
    localPose(step, q, X_WL[i]);
    return;
  }
  const Pose& X_WP = X_WL[step.parent_link];
  if (step.type == JointType::kFixed && !step.turned) {
    X_WL[i].rotation = X_WP.rotation;
    transform(X_WP, step.translation, X_WL[i].translation);
    return;
  }
  Pose X_PC;
  localPose(step, q, X_PC);
  multiply(X_WP.rotation, X_PC.rotation, X_WL[i].rotation);
  transform(X_WP, X_PC.translation, X_WL[i].translation);
}

void place(const Model& model, const double* q, Pose* X_WL) {
  const std::size_t count = model.steps.size();
  for (std::size_t i = 0; i < count; ++i) placeLink(model, i, q, X_WL);
}

}  // namespace

void forwardKinematics(const Model& model, std::span<const double> q, std::span<Pose> X_WL) {
  place(model, q.data(), X_WL.data());
}

void forwardKinematicsBatch(const Model& model, std::span<const double> q, int count,
                            std::span<Pose> X_WL) {
  const std::size_t variables = model.variables.size(), links = model.links.size();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    place(model, q.data() + i * variables, X_WL.data() + i * links);
}

void findChain(const Model& model, std::span<const int> links, std::vector<int>& chain) {
  chain.clear();
  for (const int link : links)
    for (int l = link; l >= 0; l = model.steps[static_cast<std::size_t>(l)].parent_link)
      chain.push_back(l);
  std::sort(chain.begin(), chain.end());
  chain.erase(std::unique(chain.begin(), chain.end()), chain.end());
}

void chainKinematics(const Model& model, std::span<const double> q, std::span<const int> chain,
                     std::span<Pose> X_WL) {
  for (const int link : chain)
    placeLink(model, static_cast<std::size_t>(link), q.data(), X_WL.data());
}

double kinematicsRounding(const Model& model, double reach) {
  // clang-format off
  // With u = 2^-53, in Frobenius norm, a local rotation fixed + sin * sine + cos * cosine has
  //
  //   the three matrices   < 160 u   entries of at most six products and sums of numbers within
  //                                  1.5 u (the angles' sines) or 2.5 u (the unit axis)
  //   sine and cosine        1.5 u
  //   products and sums        3 u   an entry
  //   times the parent's    < 16 u
  //   together             < 200 u   a joint; 256 u (kJointRounding) covers second-order terms
  //
  // A translation passes one product, three sums and the parent's rotation: below 256 u of its
  // length. So each joint above a point at distance d from the joint's frame moves it by at most
  // 256 u d, and d is at most `reach` plus the sum of the chain's offsets. The angle multiplier * q
  // + offset of a revolute joint rounds by 2 u |angle|: for a mimic joint, ten times as much is
  // added, which covers 1000 rad.
  // clang-format on
  std::vector<double> extent(model.joints.size());
  std::vector<double> depth(model.joints.size());
  double worst = 0;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    double travel = 0;
    const auto limitOf = [&](int variable) {
      const Variable& v = model.variables[static_cast<std::size_t>(variable)];
      const double bound = std::max(std::fabs(v.lower), std::fabs(v.upper));
      return std::isfinite(bound) ? bound : reach;  // farther out, no point is within reach
    };
    if (joint.type == JointType::kPrismatic) {
      const int master = joint.mimic >= 0
                             ? model.joints[static_cast<std::size_t>(joint.mimic)].first_variable
                             : joint.first_variable;
      travel = std::fabs(joint.multiplier) * limitOf(master) + std::fabs(joint.offset);
    } else if (joint.type == JointType::kPlanar || joint.type == JointType::kFloating) {
      for (int k = 0; k < (joint.type == JointType::kPlanar ? 2 : 3); ++k)
        travel += limitOf(joint.first_variable + k);
    }
    const bool root = joint.parent_link < 0;
    const auto parent = static_cast<std::size_t>(root ? 0 : joint.parent_link);
    extent[i] = (root ? 0 : extent[parent]) + joint.X_PJ.translation.norm() + travel;
    // Planners accept no angle beyond 1000 rad.
    const double count = joint.mimic < 0 ? 1 : joint.type == JointType::kPrismatic ? 2 : 11;
    depth[i] = (root ? 0 : depth[parent]) + count;
    worst = std::max(worst, depth[i] * kJointRounding * (reach + 2 * extent[i]));
  }
  return worst;
}

}  // namespace leeway::robots
