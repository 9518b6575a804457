#pragma once

// Private to planner/: values as YAML writes them on one line.

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/collision/pose.h"

namespace leeway::planner {

/// A finite number that reads back to the bit. Throws robots::InputError, which begins with `what`,
/// for another one.
std::string numberText(double number, const std::string& what);
/// A text, in quotes unless it reads back as it is.
std::string wordText(std::string_view text);
/// [a, b, ...].
std::string listText(std::span<const std::string> items);
std::string numbersText(std::span<const double> numbers, const std::string& what);
std::string vectorText(const Eigen::Vector3d& v, const std::string& what);
std::string wordsText(const std::vector<std::string>& words);
/// [x, y, z, w] of a rotation.
std::string quaternionText(const Eigen::Matrix3d& rotation, const std::string& what);

/// {key: value, ...}.
class MapText {
 public:
  MapText& add(std::string_view key, std::string value) {
    text_ += (text_.empty() ? "" : ", ") + std::string(key) + ": " + std::move(value);
    return *this;
  }
  /// `position` and `orientation`, unless they are the identity's.
  MapText& addPose(const collision::Pose& pose, const std::string& what);
  std::string text() const { return "{" + text_ + "}"; }
  bool empty() const { return text_.empty(); }

 private:
  std::string text_;
};

}  // namespace leeway::planner
