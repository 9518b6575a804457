#include "leeway/robots/model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"

namespace leeway::robots {

namespace {

template <typename Item>
int findByName(const std::vector<Item>& items, std::string_view name) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  return found == items.end() ? -1 : static_cast<int>(found - items.begin());
}

/// The cross product matrix: skew(a) b = a x b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d result;
  result << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return result;
}

KinematicStep compile(const RobotDescription& robot, const Joint& joint) {
  KinematicStep step;
  step.type = joint.type;
  step.parent_link = joint.parent_link;
  step.multiplier = joint.multiplier;
  step.offset = joint.offset;
  step.variable = joint.mimic >= 0
                      ? robot.joints[static_cast<std::size_t>(joint.mimic)].first_variable
                      : joint.first_variable;
  step.translation = joint.X_PJ.translation;
  step.turned = joint.X_PJ.rotation != Eigen::Matrix3d::Identity();
  step.fixed = joint.X_PJ.rotation;
  step.sine = step.cosine = Eigen::Matrix3d::Zero();
  step.u = step.v = Eigen::Vector3d::Zero();
  const Eigen::Matrix3d& R_PJ = joint.X_PJ.rotation;
  const Eigen::Vector3d& a = joint.axis;
  if (joint.type == JointType::kPrismatic) {
    step.u = R_PJ * a;
  } else if (joint.type == JointType::kPlanar) {
    Eigen::Vector3d u, v;
    planeAxes(a, u, v);
    step.u = R_PJ * u;
    step.v = R_PJ * v;
  }
  if (joint.type == JointType::kRevolute || joint.type == JointType::kContinuous ||
      joint.type == JointType::kPlanar) {
    // Rodrigues: R(angle) = a a' + sin [a] + cos (1 - a a').
    const Eigen::Matrix3d along = a * a.transpose();
    step.fixed = R_PJ * along;
    step.sine = R_PJ * skew(a);
    step.cosine = R_PJ * (Eigen::Matrix3d::Identity() - along);
  }
  return step;
}

}  // namespace

void planeAxes(const Eigen::Vector3d& normal, Eigen::Vector3d& u, Eigen::Vector3d& v) {
  // R = 1 + [w] + [w]^2 / (1 + z) with w = z axis x normal. For z < 0 the sum 1 + z cancels:
  // (x^2 + y^2) / (1 - z) equals it.
  const double x = normal.x(), y = normal.y(), z = normal.z(), squared = x * x + y * y;
  if (z < 0 && !(squared > 1e-300)) {  // opposite to the z axis: half a turn about x
    u = Eigen::Vector3d::UnitX();
    v = -Eigen::Vector3d::UnitY();
    return;
  }
  const double k = z < 0 ? (1 - z) / squared : 1 / (1 + z);
  u = {1 - k * x * x, -k * x * y, -x};
  v = {-k * x * y, 1 - k * y * y, -y};
}

int RobotDescription::findLink(std::string_view wanted) const { return findByName(links, wanted); }
int RobotDescription::findJoint(std::string_view wanted) const {
  return findByName(joints, wanted);
}
int RobotDescription::findVariable(std::string_view wanted) const {
  return findByName(variables, wanted);
}
int RobotDescription::findGroup(std::string_view wanted) const {
  return findByName(groups, wanted);
}

std::string RobotDescription::whyLeftOut(std::string_view kind, std::string_view wanted) const {
  const auto found = std::find_if(left_out.begin(), left_out.end(), [&](const LeftOut& entry) {
    return entry.kind == kind && entry.name == wanted;
  });
  return found == left_out.end() ? "" : "; it is left out: " + found->why;
}

std::string RobotDescription::whyStateLeftOut(std::string_view state,
                                              std::span<const int> planned) const {
  for (const LeftOut& entry : left_out) {
    if (entry.kind != "group state" || entry.name != state) continue;
    const int group = findGroup(entry.group);
    if (group < 0) continue;
    const std::vector<int>& of = groups[static_cast<std::size_t>(group)].variables;
    if (std::all_of(planned.begin(), planned.end(),
                    [&](int v) { return std::find(of.begin(), of.end(), v) != of.end(); }))
      return "; it is left out: " + entry.why;
  }
  return "";
}

std::string RobotDescription::placeOf(const std::string& file) const {
  return file.empty() || folder.empty() ? file : (std::filesystem::path(folder) / file).string();
}

void RobotDescription::expectMeshes() const {
  if (lacks_meshes)
    throw InputError(urdf_file, 0,
                     "was read without its meshes, so that collisions cannot be checked; a robot "
                     "that is read with them is expected");
}

Model::Model(RobotDescription description) : RobotDescription(std::move(description)) {
  steps.reserve(joints.size());
  for (const Joint& joint : joints) steps.push_back(compile(*this, joint));
  if (findGroup("all") < 0 && whyLeftOut("group", "all").empty()) {
    Group all;
    all.name = "all";
    for (int i = 0; i < static_cast<int>(variables.size()); ++i) all.variables.push_back(i);
    for (int i = 0; i < static_cast<int>(links.size()); ++i) all.links.push_back(i);
    groups.push_back(std::move(all));
  }
}

namespace {

/// All at rest, or at the nearest values within limitsOf(variable).
template <class LimitsOf>
std::vector<double> restWithin(const Model& model, const LimitsOf& limitsOf) {
  std::vector<double> q;
  q.reserve(model.variables.size());
  for (const Variable& variable : model.variables) {
    const auto [lower, upper] = limitsOf(variable);
    q.push_back(std::clamp(variable.rest, lower, upper));
  }
  return q;
}

}  // namespace

std::vector<double> Model::defaultConfiguration() const {
  return restWithin(*this, [](const Variable& v) { return std::pair(v.lower, v.upper); });
}

std::vector<double> Model::fileConfiguration() const {
  return restWithin(
      *this, [](const Variable& v) { return v.file_limits.value_or(std::pair(v.lower, v.upper)); });
}

}  // namespace leeway::robots
