// The flat tree, compared with yaml-cpp's own nodes.

#include "planner/yaml/yaml_document.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "leeway/robots/input_error.h"
#include "planner/yaml/yaml_reader.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

/// Expects the same tree below a node of each; returns the number of nodes compared.
int expectSame(const YamlDocument& document, YamlIndex index, const YAML::Node& truth) {
  const YamlNode& node = document.node(document.resolved(index));
  if (document.node(index).kind != YamlNode::Kind::kAlias) {
    EXPECT_EQ(node.line, truth.Mark().line + 1);
  }
  int count = 1;
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      EXPECT_TRUE(truth.IsNull());
      break;
    case YamlNode::Kind::kScalar:
      EXPECT_TRUE(truth.IsScalar());
      EXPECT_EQ(document.text(node), truth.Scalar());
      EXPECT_EQ(node.is_quoted, truth.Tag() == "!");
      break;
    case YamlNode::Kind::kList: {
      EXPECT_TRUE(truth.IsSequence());
      EXPECT_EQ(static_cast<std::size_t>(node.count), truth.size());
      YamlIndex entry = node.first;
      for (const YAML::Node& item : truth) {
        count += expectSame(document, entry, item);
        entry = document.node(entry).next;
      }
      EXPECT_EQ(entry, -1);
      break;
    }
    case YamlNode::Kind::kMap: {
      EXPECT_TRUE(truth.IsMap());
      EXPECT_EQ(static_cast<std::size_t>(node.count), 2 * truth.size());
      YamlIndex entry = node.first;
      for (const auto& item : truth) {
        count += expectSame(document, entry, item.first);
        entry = document.node(entry).next;
        count += expectSame(document, entry, item.second);
        entry = document.node(entry).next;
      }
      EXPECT_EQ(entry, -1);
      break;
    }
    case YamlNode::Kind::kAlias:
      ADD_FAILURE() << "an alias of an alias";
  }
  return count;
}

int expectSame(const std::string& text) {
  SCOPED_TRACE(text.substr(0, 2000));
  return expectSame(YamlDocument("file.yaml", text), 0, YAML::Load(text));
}

TEST(YamlDocument, AgreesWithYamlCppOnShippedFiles) {
  int nodes = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(sourceFolder() + "/problems")) {
    const std::string ending = entry.path().extension();
    if (ending != ".yaml" && ending != ".json") continue;
    nodes += expectSame(readText(entry.path()));
  }
  EXPECT_GT(nodes, 1000);
}

TEST(YamlDocument, AgreesWithYamlCppOnOddOnes) {
  for (const char* text :
       {"", "~", "a", "'a'", "[]", "{}", "a:\nb: null\n", "- \n- ''\n- \"x\\ny\"\n",
        "? [1, 2]\n: b\n", "a: &x {b: 1}\nc: *x\nd: [*x, *x]\n", "a: &x 1\nb: &x 2\nc: *x\n",
        "|\n two\n lines\n", "!tag a: !tag\n", "a: 1\na: 2\n", "{a, b: , c}",
        "%YAML 1.2\n---\na: 1\n...\n"})
    expectSame(text);
}

/// Regression: yaml-cpp takes a lone carriage return for a blank; what stood behind it was part of
/// the comment before it.
TEST(YamlReader, ALoneCarriageReturnEndsALine) {
  const Folder folder;
  const std::string file = folder.write("a.yaml", "a: 1 # here\rb: [1, 2]\r\nc: 'd\re'\n");
  const YamlReader root = YamlReader::load(file);
  EXPECT_EQ(root.entries().size(), 3U);
  EXPECT_EQ(root.at("b", "").line(), 2);
  EXPECT_EQ(root.at("c", "").text(), "d e");  // as YAML folds lines
}

/// Random nested lists and maps in flow style.
std::string randomText(std::mt19937_64& random, int depth) {
  static const std::vector<std::string> kScalars = {"1", "-2.5e3", "'quoted'", "~", "word", "\"\""};
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  if (depth == 0 || below(3) == 0) return kScalars[below(kScalars.size())];
  const bool is_map = below(2) == 0;
  std::string text(1, is_map ? '{' : '[');
  for (std::size_t i = 0, count = below(5); i < count; ++i) {
    if (i > 0) text += below(2) == 0 ? ", " : ",\n  ";
    if (is_map) text += "k" + std::to_string(below(4)) + ": ";
    text += randomText(random, depth - 1);
  }
  return text + (is_map ? '}' : ']');
}

TEST(YamlDocument, AgreesWithYamlCppOnRandomOnes) {
  std::mt19937_64 random(1);
  int nodes = 0;
  for (int i = 0; i < 500; ++i) nodes += expectSame(randomText(random, 5));
  EXPECT_GT(nodes, 5000);
}

/// Random JSON: lists, maps and scalars over several lines.
std::string randomJson(std::mt19937_64& random, int depth) {
  static const std::vector<std::string> kScalars = {"0",
                                                    "-0",
                                                    "-2.5e+3",
                                                    "1E5",
                                                    "12345678901234567890123",
                                                    "true",
                                                    "false",
                                                    "null",
                                                    "\"a\"",
                                                    "\"\"",
                                                    "\"-1\"",
                                                    "\"a \\\"b\\\" \\n\"",
                                                    "\"\\u00e9, [{\"",
                                                    "\"\xC3\xA9:\""};
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const auto space = [&] { return std::string(below(3) == 0 ? "\n" : below(2) == 0 ? " " : ""); };
  if (depth == 0 || (depth < 5 && below(3) == 0)) return kScalars[below(kScalars.size())];
  const bool is_map = below(2) == 0;
  std::string text(1, is_map ? '{' : '[');
  for (std::size_t i = 0, count = below(5); i < count; ++i) {
    if (i > 0) text += "," + space();
    if (is_map) text += "\"k" + std::to_string(below(4)) + "\": ";
    text += randomJson(random, depth - 1) + space();
  }
  return text + space() + (is_map ? '}' : ']');
}

/// By another parser than YAML, but the same nodes. yaml-cpp places what is empty by what follows.
TEST(YamlDocument, JsonAgreesWithYamlCpp) {
  std::mt19937_64 random(1);
  int nodes = 0;
  for (int i = 0; i < 500; ++i)
    nodes +=
        expectSame((i % 3 == 0 ? "\n\n " : "") + randomJson(random, 5) + (i % 2 == 0 ? "\n" : ""));
  EXPECT_GT(nodes, 5000);
}

TEST(YamlDocument, ReadsLargeJsonAndRefusesLargeYaml) {
  std::string text = "[";
  while (text.size() <= kLongestYaml) text += "[0.1234567890123456, -0.1234567890123456],\n";
  const std::string unfinished = text + "[1, 2}\n";
  text += "3]\n";
  const YamlDocument document("file.json", text);
  EXPECT_EQ(document.node(0).count, std::count(text.begin(), text.end(), '\n'));
  const auto messageOf = [](const std::string& content) -> std::string {
    try {
      const YamlDocument refused("file.json", content);
    } catch (const robots::InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto lines = std::count(unfinished.begin(), unfinished.end(), '\n');
  EXPECT_EQ(messageOf(unfinished),
            "file.json:" + std::to_string(lines) +
                ": is no JSON from here on; beyond 32 MiB only JSON is expected");
  text[0] = '-';
  EXPECT_EQ(messageOf(text), "file.json: holds 32 MiB of YAML; at most 32 is expected, or JSON");
}

TEST(YamlDocument, RefusesWhatIsNestedTooDeep) {
  for (const std::size_t levels : {kDeepestYaml, kDeepestYaml + 1, std::size_t{100000}})
    for (const bool is_json : {true, false}) {
      const std::string text =
          std::string(levels, '[') + (is_json ? "" : "a") + std::string(levels, ']');
      if (levels == kDeepestYaml)
        EXPECT_NO_THROW(YamlDocument("file.yaml", text));
      else
        EXPECT_THROW(YamlDocument("file.yaml", text), robots::InputError) << levels;
    }
}

TEST(YamlDocument, NamesPlacesAsTheyAreWritten) {
  const YamlDocument document("file.yaml",
                              "objects:\n- {box: {size: [1, 2]}}\n- &x [a: 1]\nb: *x\n");
  std::vector<std::string> places;
  for (YamlIndex i = 0;; ++i) {
    places.push_back(document.where(i));
    if (document.node(i).kind == YamlNode::Kind::kAlias) break;
  }
  const auto count = [&](const std::string& place) {
    return std::count(places.begin(), places.end(), place);
  };
  EXPECT_EQ(places[0], "the file");
  EXPECT_EQ(count("objects[0].box.size[1]"), 1);
  EXPECT_EQ(count("objects[1][0].a"), 2) << "a key and its value";
  EXPECT_EQ(places.back(), "b");
}

TEST(YamlDocument, AnAliasOfItselfEnds) {
  const YamlDocument document("file.yaml", "a: &x [1, *x]\n");
  const YamlNode& list = document.node(3 - 1);
  ASSERT_EQ(list.kind, YamlNode::Kind::kList);
  const YamlIndex alias = document.node(list.first).next;
  EXPECT_EQ(document.resolved(alias), 2);
  EXPECT_EQ(document.where(alias), "a[1]");
}

TEST(YamlDocument, RefusesASecondDocument) {
  EXPECT_THROW(YamlDocument("file.yaml", "a: 1\n---\nb: 1\n"), robots::InputError);
}

}  // namespace
}  // namespace leeway::planner
