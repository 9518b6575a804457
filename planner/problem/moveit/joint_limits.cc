// MoveIt's joint_limits.yaml.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "collision/base/numbers.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/placed_model.h"
#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "planner/base/tolerances.h"
#include "planner/problem/moveit/fields.h"
#include "planner/yaml/yaml_reader.h"

namespace leeway::planner {
namespace {

using robots::Model;

constexpr std::array<std::string_view, 4> kTop = {"joint_limits", "default_velocity_scaling_factor",
                                                  "default_acceleration_scaling_factor",
                                                  "cartesian_limits"};
/// Parameters of a ROS node stand below these, in this order.
constexpr std::array<std::string_view, 3> kWrappers = {"/**", "ros__parameters",
                                                       "robot_description_planning"};
constexpr std::array<std::string_view, 21> kEntry = {
    "has_position_limits", "min_position",      "max_position",
    "has_velocity_limits", "max_velocity",      "min_velocity",
    "has_jerk_limits",     "max_jerk",          "has_acceleration_limits",
    "max_acceleration",    "min_acceleration",  "has_deceleration_limits",
    "max_deceleration",    "has_effort_limits", "max_effort",
    "angle_wraparound",    "has_soft_limits",   "soft_lower_limit",
    "soft_upper_limit",    "k_position",        "k_velocity"};

std::string placeOf(const YamlReader& place) {
  return fmt::format("{}:{}", place.file(), place.line());
}

class JointLimits {
 public:
  JointLimits(const Model& model, const YamlReader& file)
      : file_(file), model_(std::make_shared<Model>(model)) {}

  std::shared_ptr<const Model> read() {
    if (!file_.isMap()) file_.fail("is no map; joint_limits, limits by joint, are expected");
    for (const std::string_view& wrapper : kWrappers)
      if (const auto inside = file_.find(wrapper)) {
        file_.expectKeys({&wrapper, 1});
        if (!inside->isMap()) inside->fail("is no map; limits of joints are expected");
        file_ = *inside;
      }
    file_.expectKeys(kTop);
    if (const auto cartesian = file_.find("cartesian_limits"))
      warn(*cartesian, "'cartesian_limits' is left out: only joints have limits");
    for (const auto& [key, setting] :
         {std::pair("default_velocity_scaling_factor", "speed"),
          std::pair("default_acceleration_scaling_factor", "acceleration_scale")})
      if (const auto factor = file_.find(key))
        warn(*factor,
             fmt::format("'{}' is left out; execution.{} says it for a problem", key, setting));
    const YamlReader limits = file_.at("joint_limits", "a map of limits by joint");
    if (limits.isNull()) return model_;
    limits.eachEntry([&](const std::string& joint, const YamlReader& entry) {
      if (entry.isNull()) return;
      entry.expectKeys(kEntry);
      if (knows(joint, entry)) readJoint(joint, entry);
    });
    return model_;
  }

 private:
  void warn(const YamlReader& place, const std::string& what) {
    model_->warnings.push_back(fmt::format("{}: {}", placeOf(place), what));
  }

  /// Whether the robot has the joint. Refuses a name that is close to that of a joint, because its
  /// limit would be lost. Other names belong to parts that this robot lacks, such as a gripper.
  bool knows(const std::string& joint, const YamlReader& entry) {
    if (model_->findJoint(joint) >= 0) return true;
    std::vector<std::string> known;
    for (const robots::Joint& j : model_->joints)
      if (j.type != robots::JointType::kFixed) known.push_back(j.name);
    if (const std::string* near = robots::nearestName(joint, known))
      entry.fail(fmt::format("robot '{}' has no joint '{}'; did you mean '{}'?", model_->name,
                             joint, *near));
    warn(entry,
         fmt::format("robot '{}' has no joint '{}': its limits are left out", model_->name, joint));
    return false;
  }

  /// The value of an active limit. As in MoveIt, a given limit is active unless has_... is false.
  static std::optional<YamlReader> limit(const YamlReader& entry, const char* has,
                                         const char* key) {
    const auto flag = entry.find(has);
    if (flag && !readMoveitBoolean(*flag)) return std::nullopt;
    const auto value = entry.find(key);
    if (flag && !value)
      flag->fail(
          fmt::format("{} is true, and '{}' is missing; a number is expected", flag->where(), key));
    return value;
  }

  void readJoint(const std::string& name, const YamlReader& entry) {
    const robots::Joint& joint = model_->joints[at(model_->findJoint(name))];
    const robots::Joint& master = joint.mimic < 0 ? joint : model_->joints[at(joint.mimic)];
    const double ratio = joint.mimic < 0 ? 1 : joint.multiplier;
    if (master.first_variable < 0 || ratio == 0) {
      warn(entry, fmt::format("joint '{}' does not move: its limits are left out", name));
      return;
    }
    for (const char* key : {"has_effort_limits", "angle_wraparound"})
      if (const auto flag = entry.find(key); flag && readMoveitBoolean(*flag))
        warn(*flag, fmt::format("'{}' of joint '{}' is left out: nothing here uses it", key, name));
    warnOfSoftLimits(name, entry);
    readRates(entry, master, std::abs(ratio), isFollowed(master));
    readPositions(name, entry, master, joint.mimic < 0 ? 0 : joint.offset, ratio);
  }

  /// Soft limits are named and not used, as those of a URDF's <safety_controller>.
  void warnOfSoftLimits(const std::string& name, const YamlReader& entry) {
    const auto has = entry.find("has_soft_limits");
    if (has && !readMoveitBoolean(*has)) return;
    std::optional<YamlReader> first = has;
    std::string limits;
    for (const char* key : {"soft_lower_limit", "soft_upper_limit"})
      if (const auto value = entry.find(key)) {
        limits += fmt::format("{} {} {}", limits.empty() ? "" : ",", key, value->number());
        if (!first) first = value;
      }
    if (first)
      warn(*first, fmt::format("soft limits of joint '{}' are left out{}{}; min_position and "
                               "max_position would narrow its range",
                               name, limits.empty() ? "" : ":", limits));
  }

  bool isFollowed(const robots::Joint& master) const {
    return std::any_of(model_->joints.begin(), model_->joints.end(), [&](const robots::Joint& j) {
      return j.mimic >= 0 && &model_->joints[at(j.mimic)] == &master;
    });
  }

  /// Limits of joints that follow another one also limit that one. If `is_shared`, the least limit
  /// holds, in any order of reading.
  void readRates(const YamlReader& entry, const robots::Joint& master, double ratio,
                 bool is_shared) {
    const auto rate = [&](const char* has, const char* key) -> std::optional<double> {
      const auto value = limit(entry, has, key);
      if (!value) return std::nullopt;
      // Decelerations are written with either sign.
      const bool is_signed = std::string_view(key) == "max_deceleration";
      const double number = is_signed ? std::abs(value->number()) : value->number();
      if (!(number >= kLeastLimit && number <= kMostLimit))
        value->fail(fmt::format("{} is {}; a number from {} to {} is expected", value->where(),
                                value->number(), kLeastLimit, kMostLimit));
      return number / ratio;
    };
    const auto velocity = rate("has_velocity_limits", "max_velocity");
    auto acceleration = rate("has_acceleration_limits", "max_acceleration");
    const auto deceleration = rate("has_deceleration_limits", "max_deceleration");
    if (deceleration) acceleration = std::min(acceleration.value_or(kInfinity), *deceleration);
    const auto jerk = rate("has_jerk_limits", "max_jerk");
    for (const auto& [has, key] : {std::pair("has_velocity_limits", "min_velocity"),
                                   std::pair("has_acceleration_limits", "min_acceleration")})
      if (const auto value = entry.find(key)) {
        const auto flag = entry.find(has);
        if (flag && !readMoveitBoolean(*flag)) continue;
        const auto most = entry.find(std::string("max_") + (key + 4));
        if (!most || value->number() != -most->number())
          warn(*value, fmt::format("{} is left out: limits are the same in both directions",
                                   value->where()));
      }
    const double own = model_->variables[at(master.first_variable)].velocity;
    if (velocity && *velocity > own && !is_shared)
      warn(*entry.find("max_velocity"),
           fmt::format("{} is {}, above {} of the robot's file, and is taken in its place",
                       entry.find("max_velocity")->where(), *velocity * ratio, own * ratio));
    for (int k = 0; k < master.variable_count; ++k) {
      robots::Variable& variable = model_->variables[at(master.first_variable + k)];
      const auto take = [&](double& held, const std::optional<double>& given) {
        if (!given) return;
        held = is_shared ? std::min(held, *given) : *given;
      };
      take(variable.velocity, velocity);
      take(variable.acceleration, acceleration);
      take(variable.jerk, jerk);
    }
  }

  void readPositions(const std::string& name, const YamlReader& entry, const robots::Joint& master,
                     double offset, double ratio) {
    const auto flag = entry.find("has_position_limits");
    const auto low = entry.find("min_position"), high = entry.find("max_position");
    if ((flag && !readMoveitBoolean(*flag)) || (!flag && !low && !high)) return;
    if (flag && !low && !high) limit(entry, "has_position_limits", "max_position");  // fails
    const YamlReader& place = low ? *low : *high;
    if (master.variable_count != 1) {
      warn(place, fmt::format("position limits of joint '{}' are left out; 'bounds' limit planar "
                              "and floating joints",
                              name));
      return;
    }
    double lower = low ? low->number() : -kInfinity, upper = high ? high->number() : kInfinity;
    if (!(lower <= upper))
      place.fail(
          fmt::format("{} is {}, and max_position {}; a lower limit below the upper one is "
                      "expected",
                      place.where(), lower, upper));
    lower = (lower - offset) / ratio;
    upper = (upper - offset) / ratio;
    if (ratio < 0) std::swap(lower, upper);
    const robots::Variable& own = model_->variables[at(master.first_variable)];
    if ((std::isfinite(lower) && lower < own.lower) || (std::isfinite(upper) && upper > own.upper))
      warn(place, fmt::format("the limits of joint '{}' reach beyond {} to {} of the robot's file, "
                              "which hold; 'bounds' with 'widen' would widen them",
                              name, own.lower, own.upper));
    lower = std::max(lower, own.lower);
    upper = std::min(upper, own.upper);
    if (!(lower <= upper))
      place.fail(
          fmt::format("the limits of joint '{}' leave nothing of {} to {}, its range in the "
                      "robot's file; limits that meet it are expected",
                      name, own.lower, own.upper));
    if (lower == own.lower && upper == own.upper) return;
    if (!std::isfinite(lower) || !std::isfinite(upper))
      place.fail(
          fmt::format("joint '{}' has a limit on one side only; a min_position and a "
                      "max_position are expected",
                      name));
    const std::map<std::string, robots::JointBound> bound{
        {"", {lower, upper, false, placeOf(place)}}};
    if (const std::string fault = robots::boundFault(*model_, master.name, "", bound.at(""));
        !fault.empty())
      place.fail(fault);
    model_ = std::make_shared<Model>(*robots::withBounds(*model_, {{master.name, bound}}));
  }

  YamlReader file_;
  std::shared_ptr<Model> model_;
};

}  // namespace

std::shared_ptr<const Model> withJointLimits(const Model& model, const std::string& yaml_path,
                                             const robots::LoadOptions& options) {
  return JointLimits(model, YamlReader::load(yaml_path, options.stop, options.errors)).read();
}

}  // namespace leeway::planner
