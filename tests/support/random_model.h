#pragma once

// Random kinematic trees and edges for tests.

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "leeway/robots/model.h"
#include "robots/model/model_builder.h"

namespace leeway::robots::testing {

/// splitmix64: equal numbers everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low = 0, double high = 1) {
    return low + (high - low) * (static_cast<double>(next() >> 11U) * 0x1p-53);
  }
  int integer(int count) { return static_cast<int>(next() % static_cast<std::uint64_t>(count)); }
  double normal() {
    return std::sqrt(-2 * std::log(1 - uniform())) * std::cos(6.283185307179586 * uniform());
  }
  Eigen::Vector3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  Eigen::Vector3d direction() {
    Eigen::Vector3d v(normal(), normal(), normal());
    return v.normalized();
  }
  Eigen::Matrix3d rotation() {
    return Eigen::Quaterniond(normal(), normal(), normal(), normal())
        .normalized()
        .toRotationMatrix();
  }
  Pose pose(double size) { return {rotation(), vector(size)}; }

 private:
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }
  std::uint64_t state_;
};

/// A chain of `count` links: link i, "link<i>", is the child of joint i, "joint<i>", and the parent
/// of the next joint. Joint 0 is fixed, the others are of `type`. edit(i, link, joint) may change
/// both before they are appended. Returns with variables from -limit to limit.
template <class Edit>
RobotDescription chain(int count, JointType type, double limit, const Edit& edit) {
  RobotDescription robot;
  for (int i = 0; i < count; ++i) {
    Link link;
    link.name = "link" + std::to_string(i);
    link.joint = i;
    Joint joint;
    joint.name = "joint" + std::to_string(i);
    joint.type = i == 0 ? JointType::kFixed : type;
    joint.parent_link = i - 1;
    joint.child_link = i;
    edit(i, link, joint);
    robot.links.push_back(link);
    robot.joints.push_back(joint);
    appendVariables(robot, i, Eigen::Vector3d::Constant(-limit), Eigen::Vector3d::Constant(limit));
  }
  return robot;
}

/// A tree of `count` links: all joint types, mimic joints included, random parents.
inline std::shared_ptr<Model> randomTree(Random& random, int count) {
  RobotDescription robot;
  static constexpr JointType kTypes[] = {
      JointType::kRevolute, JointType::kRevolute, JointType::kContinuous, JointType::kPrismatic,
      JointType::kFixed,    JointType::kPlanar,   JointType::kFloating};
  for (int i = 0; i < count; ++i) {
    Link link;
    link.name = "link" + std::to_string(i);
    link.joint = i;
    robot.links.push_back(link);
    Joint joint;
    joint.name = "joint" + std::to_string(i);
    joint.type = i == 0 ? JointType::kFixed : kTypes[random.integer(7)];
    joint.parent_link = i == 0 ? -1 : std::max(0, i - 1 - random.integer(3));
    joint.child_link = i;
    joint.X_PJ = random.pose(0.5);
    joint.axis = random.direction();
    const bool single = joint.type == JointType::kRevolute || joint.type == JointType::kPrismatic;
    if (single && random.integer(4) == 0)
      for (int m = i - 1; m > 0 && joint.mimic < 0; --m)
        if (robot.joints[static_cast<std::size_t>(m)].variable_count == 1) {
          joint.mimic = m;
          joint.multiplier = random.uniform(-1.5, 1.5);
          joint.offset = random.uniform(-0.3, 0.3);
        }
    robot.joints.push_back(joint);
    const Eigen::Vector3d size = joint.type == JointType::kRevolute
                                     ? Eigen::Vector3d::Constant(2.5)
                                     : Eigen::Vector3d::Constant(0.6);
    appendVariables(robot, i, -size, size);
  }
  return std::make_shared<Model>(std::move(robot));
}

/// The numbers of all variables.
inline std::vector<int> allVariables(const Model& model) {
  std::vector<int> variables(model.variables.size());
  std::iota(variables.begin(), variables.end(), 0);
  return variables;
}

/// A configuration within the limits.
inline std::vector<double> randomConfiguration(Random& random, const Model& model) {
  std::vector<double> q;
  for (const Variable& v : model.variables)
    q.push_back(std::isfinite(v.lower) ? random.uniform(v.lower, v.upper) : random.uniform(-3, 3));
  for (const Joint& joint : model.joints)
    if (joint.type == JointType::kFloating) {
      const Eigen::Quaterniond turn(random.rotation());
      const auto first = static_cast<std::size_t>(joint.first_variable);
      q[first + 3] = turn.x();
      q[first + 4] = turn.y();
      q[first + 5] = turn.z();
      q[first + 6] = turn.w();
    }
  return q;
}

/// A difference that stays within the limits from q, as the planner's difference() gives.
inline std::vector<double> randomDifference(Random& random, const Model& model,
                                            const std::vector<double>& q) {
  const std::vector<double> to = randomConfiguration(random, model);
  std::vector<double> dq(q.size());
  const double scale = random.uniform(0.05, 1);
  for (std::size_t i = 0; i < q.size(); ++i) dq[i] = scale * (to[i] - q[i]);
  for (const Joint& joint : model.joints)
    if (joint.type == JointType::kFloating) {
      const Eigen::Vector3d turn = random.direction() * random.uniform(0, 3.1);
      for (int k = 0; k < 3; ++k)
        dq[static_cast<std::size_t>(joint.first_variable + 3 + k)] = turn[k];
      dq[static_cast<std::size_t>(joint.first_variable + 6)] = 0;
    }
  return dq;
}

/// q + t dq.
inline std::vector<double> advanced(const Model& model, const std::vector<double>& q,
                                    const std::vector<double>& dq, double t) {
  std::vector<double> result(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) result[i] = q[i] + t * dq[i];
  for (const Joint& joint : model.joints)
    if (joint.type == JointType::kFloating) {
      const auto f = static_cast<std::size_t>(joint.first_variable);
      const Eigen::Vector3d turn(dq[f + 3], dq[f + 4], dq[f + 5]);
      const Eigen::Quaterniond r(Eigen::AngleAxisd(t * turn.norm(), turn.normalized()));
      const Eigen::Quaterniond p = Eigen::Quaterniond(q[f + 6], q[f + 3], q[f + 4], q[f + 5]) * r;
      result[f + 3] = p.x();
      result[f + 4] = p.y();
      result[f + 5] = p.z();
      result[f + 6] = p.w();
    }
  return result;
}

}  // namespace leeway::robots::testing
