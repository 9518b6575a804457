#include "tools/view/base/json_text.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace leeway::tools {

Json jsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json jsonVector(const Eigen::Vector3d& v) {
  return {jsonNumber(v.x()), jsonNumber(v.y()), jsonNumber(v.z())};
}

std::string jsonText(const Json& document, int indent) {
  return document.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace leeway::tools
