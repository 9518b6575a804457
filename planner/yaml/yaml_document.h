#pragma once

// Private to planner/: a YAML or JSON document as a flat tree. yaml-cpp parses; its own nodes, an
// allocation or more each, would take most of the time and memory of a world of many objects. JSON
// alone goes through nlohmann/json, which is some ten times as fast.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/input_error.h"
#include "leeway/robots/stopped.h"

namespace leeway::planner {

/// Longer YAML, which takes some 0.2 s a MiB, is refused; JSON up to robots::kLongestText is taken
/// [B].
inline constexpr std::size_t kLongestYaml = std::size_t{32} << 20;
/// Lists and maps in each other beyond this are refused: who walks them recurses.
inline constexpr std::size_t kDeepestYaml = 400;

/// A node by its number; those of a document begin with its root, 0.
using YamlIndex = std::int32_t;

struct YamlNode {
  enum class Kind : unsigned char { kNull, kScalar, kList, kMap, kAlias };
  Kind kind = Kind::kNull;
  bool is_quoted = false;  ///< a scalar in quotes: a text, whatever it looks like
  bool is_tagged = false;  ///< a scalar with a tag of its own, as "!degrees 90"
  std::int32_t line = 0;   ///< from 1; of an empty value that of what follows it
  YamlIndex parent = -1;   ///< -1: the root
  std::int32_t place = 0;  ///< among its parent's entries, from 0
  YamlIndex next = -1;     ///< the following entry; -1: the last
  YamlIndex first = -1;    ///< first entry of a list or map; an alias: what it stands for
  std::int32_t count = 0;  ///< entries of a list or map
  std::int64_t text = 0;   ///< where a scalar's text begins
  std::int64_t text_size = 0;
};

/// The one document of a file. In a map a key and its value are entries one after the other.
class YamlDocument {
 public:
  /// Parses `text`, the content of `file`. Throws robots::InputError for bad syntax, for several
  /// documents, and beyond the limits above; robots::Stopped, as `stop` is asked every some
  /// thousand entries. Without a document the root is null. O(text).
  /// Errors of those who read the document go to `errors`, where that is not null.
  YamlDocument(std::string file, std::string text, const robots::Stop& stop = {},
               robots::InputErrors* errors = nullptr);

  const std::string& file() const { return file_; }
  robots::InputErrors* errors() const { return errors_; }
  const YamlNode& node(YamlIndex i) const { return nodes_[static_cast<std::size_t>(i)]; }
  /// An alias' target; any other node itself.
  YamlIndex resolved(YamlIndex i) const { return isAlias(i) ? node(i).first : i; }
  std::string_view text(const YamlNode& scalar) const {
    return std::string_view(texts_).substr(static_cast<std::size_t>(scalar.text),
                                           static_cast<std::size_t>(scalar.text_size));
  }
  /// How messages call a value: "objects[2].box.size"; "the file" at the top. O(depth * entries).
  std::string where(YamlIndex i) const;

 private:
  class Builder;
  class YamlEvents;
  class JsonEvents;
  YamlDocument() = default;
  /// Takes `text` as JSON, and moves it into `texts_`. False, and nothing done, if it is none; then
  /// `error_line` is where it stops being JSON.
  bool parseJson(std::string& text, int& error_line);
  void parseYaml(const std::string& text);
  bool isAlias(YamlIndex i) const { return node(i).kind == YamlNode::Kind::kAlias; }

  std::string file_;
  robots::Stop stop_;  // while it is parsed
  robots::InputErrors* errors_ = nullptr;
  std::vector<YamlNode> nodes_;
  std::string texts_;  // of all scalars
};

}  // namespace leeway::planner
