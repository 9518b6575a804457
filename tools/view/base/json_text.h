#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace leeway::tools {

using Json = nlohmann::ordered_json;

/// Infinity and NaN become null. A clearance is null if nothing is near.
Json jsonNumber(double value);
Json jsonVector(const Eigen::Vector3d& v);

/// A document as text, in one line if `indent` is -1. Names and paths that are not UTF-8 get the
/// replacement character, because JSON cannot contain them.
std::string jsonText(const Json& document, int indent = -1);

}  // namespace leeway::tools
