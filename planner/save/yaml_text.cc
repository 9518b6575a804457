#include "planner/save/yaml_text.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "leeway/robots/input_error.h"

namespace leeway::planner {

std::string numberText(double number, const std::string& what) {
  if (!std::isfinite(number))
    throw robots::InputError("", 0,
                             fmt::format("{} is {}; files hold finite numbers", what, number));
  return fmt::format("{}", number);
}

std::string wordText(std::string_view text) {
  const auto isLetter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto isPlain = [&](char c) {
    return isLetter(c) || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '/' || c == '-';
  };
  constexpr std::array<std::string_view, 11> kReserved = {
      "true", "false", "null", "yes", "no", "on", "off", "any", "y", "n", "auto"};
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  const bool is_path = text.starts_with("../") || text.starts_with('/');
  if (!text.empty() && (isLetter(text[0]) || is_path) &&
      std::all_of(text.begin(), text.end(), isPlain) &&
      std::find(kReserved.begin(), kReserved.end(), lower) == kReserved.end())
    return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += std::string("\\") + c;
    else if (byte < 0x20 || byte == 0x7f)
      quoted += fmt::format("\\x{:02x}", byte);
    else
      quoted += c;
  }
  return quoted + "\"";
}

std::string listText(std::span<const std::string> items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return "[" + text + "]";
}

std::string numbersText(std::span<const double> numbers, const std::string& what) {
  std::vector<std::string> items;
  for (const double number : numbers) items.push_back(numberText(number, what));
  return listText(items);
}

std::string vectorText(const Eigen::Vector3d& v, const std::string& what) {
  return numbersText(std::span(v.data(), 3), what);
}

std::string wordsText(const std::vector<std::string>& words) {
  std::vector<std::string> items;
  for (const std::string& word : words) items.push_back(wordText(word));
  return listText(items);
}

std::string quaternionText(const Eigen::Matrix3d& rotation, const std::string& what) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
  return numbersText(std::array{q.x(), q.y(), q.z(), q.w()}, what);
}

MapText& MapText::addPose(const collision::Pose& pose, const std::string& what) {
  if (!(pose.translation.array() == 0).all()) add("position", vectorText(pose.translation, what));
  if (pose.rotation != Eigen::Matrix3d::Identity())
    add("orientation", quaternionText(pose.rotation, what));
  return *this;
}

}  // namespace leeway::planner
