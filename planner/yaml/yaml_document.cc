#include "planner/yaml/yaml_document.h"

#include <fmt/format.h>

namespace leeway::planner {

std::string YamlDocument::where(YamlIndex i) const {
  const YamlNode& value = node(i);
  if (value.parent < 0) return "the file";
  const YamlNode& parent = node(value.parent);
  std::string above = where(value.parent);
  if (parent.kind == YamlNode::Kind::kList) return fmt::format("{}[{}]", above, value.place);
  YamlIndex key = parent.first;
  while (node(key).place + 1 < value.place) key = node(key).next;
  const std::string_view name = text(node(resolved(key)));
  return parent.parent < 0 ? std::string(name) : fmt::format("{}.{}", above, name);
}

}  // namespace leeway::planner
