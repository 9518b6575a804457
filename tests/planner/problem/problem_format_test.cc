#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "leeway/collision/deformable_mesh.h"
#include "planner/validate/format_keys.h"
#include "tests/support/build_paths.h"

namespace leeway::planner {
namespace {

using nlohmann::json;

json schema() {
  std::ifstream stream(leeway::sourceFolder() + "/problems/schema.json");
  return json::parse(stream);
}

const json& definition(const json& schema, const std::string& name) {
  return name == "problem" ? schema : schema.at("$defs").at(name);
}

/// Editors and loader must agree: schema and loader know exactly the same keys.
TEST(ProblemSchema, KnowsTheLoadersKeysAndNoOthers) {
  const json all = schema();
  for (const MapFormat& format : mapFormats()) {
    const std::string name(format.name);
    const json& kind = definition(all, name);
    ASSERT_TRUE(kind.contains("properties")) << name;
    std::set<std::string> in_schema, in_loader(format.keys.begin(), format.keys.end());
    for (const auto& entry : kind.at("properties").items()) in_schema.insert(entry.key());
    EXPECT_EQ(in_schema, in_loader) << name;
    EXPECT_EQ(kind.at("additionalProperties"), false) << name;
  }
}

TEST(ProblemSchema, HasNoKindThatTheLoaderLacks) {
  std::set<std::string> known = {"state", "group_state", "value",
                                 "joint_limits"};  // not maps: alternative forms
  for (const MapFormat& format : mapFormats()) known.insert(std::string(format.name));
  const json all = schema();
  for (const auto& entry : all.at("$defs").items())
    EXPECT_EQ(known.count(entry.key()), 1U) << entry.key();
}

/// Editors offer the strategies that there are.
TEST(ProblemSchema, ListsEveryStrategy) {
  const json all = schema();
  const json& words = definition(all, "deforming").at("properties").at("strategy").at("enum");
  const std::set<std::string> in_schema = words;
  std::set<std::string> known;
  for (int i = 0; i < 256; ++i) {
    const std::string word = collision::toString(static_cast<collision::DeformStrategy>(i));
    if (collision::deformStrategy(word)) known.insert(word);
  }
  EXPECT_EQ(in_schema, known);
}

/// Every reference in the schema resolves.
TEST(ProblemSchema, ReferencesResolve) {
  const json all = schema();
  int count = 0;
  const auto walk = [&](const json& node, const auto& self) -> void {
    if (node.is_object() && node.contains("$ref")) {
      EXPECT_NO_THROW(all.at(json::json_pointer(node.at("$ref").get<std::string>().substr(1))))
          << node;
      ++count;
    }
    if (node.is_structured())
      for (const json& child : node) self(child, self);
  };
  walk(all, walk);
  EXPECT_GT(count, 30);
}

}  // namespace
}  // namespace leeway::planner
