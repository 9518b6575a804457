#pragma once

#include <string_view>

namespace leeway::tools::view {

/// The page without its data, as tools/view/bundle.js makes it; empty where the command was built
/// without node. `kDataPlace` stands in it once.
std::string_view pageSource();
inline constexpr std::string_view kDataPlace = "@LEEWAY-DATA@";

}  // namespace leeway::tools::view
