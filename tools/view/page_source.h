#pragma once

#include <string_view>

namespace leeway::tools::view {

/// The page without its data, from tools/view/bundle.js; empty if the command was built without
/// node. It contains `kDataPlace` once.
std::string_view pageSource();
inline constexpr std::string_view kDataPlace = "@LEEWAY-DATA@";

}  // namespace leeway::tools::view
