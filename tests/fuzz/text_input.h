#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace leeway::fuzz {

/// Two joints of an arm, `a` limited and `b` continuous.
inline constexpr const char* kArmUrdf = R"(<robot name="r">
  <link name="base"/><link name="one"/><link name="two"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="b" type="continuous"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/></joint>
</robot>
)";

/// A folder private to this process, removed when it ends normally.
const std::string& scratchFolder();

/// Writes the bytes to `name` in the scratch folder and returns its path.
std::string writeInput(const std::string& name, std::span<const std::uint8_t> bytes);

/// Contents of the existing files among `paths`, relative to the repository's root.
std::vector<std::string> sourceTexts(const std::vector<std::string>& paths);

/// Contents of all files below `folder` (relative to the repository's root) with the given ending,
/// sorted by name.
std::vector<std::string> sourceTextsUnder(const std::string& folder, const std::string& ending);

}  // namespace leeway::fuzz
