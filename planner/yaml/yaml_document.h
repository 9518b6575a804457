#pragma once

// Private to planner/: a YAML or JSON document as a flat tree. yaml-cpp parses, but its own nodes
// need an allocation or more each, which would take most of the time and memory of a world of many
// objects. JSON goes through nlohmann/json, which is about ten times as fast.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/input_error.h"
#include "leeway/robots/stopped.h"

namespace leeway::planner {

/// Longer YAML is refused, because it takes about 0.2 s per MiB. JSON may be as long as
/// robots::kLongestText [B].
inline constexpr std::size_t kLongestYaml = std::size_t{32} << 20;
/// Deeper nesting of lists and maps is refused, because readers recurse.
inline constexpr std::size_t kDeepestYaml = 400;

/// A node by its number; those of a document begin with its root, 0.
using YamlIndex = std::int32_t;

struct YamlNode {
  enum class Kind : unsigned char { kNull, kScalar, kList, kMap, kAlias };
  Kind kind = Kind::kNull;
  bool is_quoted = false;  ///< a scalar in quotes, which is always a text
  bool is_tagged = false;  ///< a scalar with a tag, such as "!degrees 90"
  std::int32_t line = 0;   ///< from 1; an empty value has that of what follows it
  YamlIndex parent = -1;   ///< -1: the root
  std::int32_t place = 0;  ///< among its parent's entries, from 0
  YamlIndex next = -1;     ///< the following entry; -1: the last
  YamlIndex first = -1;    ///< first entry of a list or map; the target of an alias
  std::int32_t count = 0;  ///< entries of a list or map
  std::int64_t text = 0;   ///< where a scalar's text begins
  std::int64_t text_size = 0;
};

/// The one document of a file. In a map a key and its value are entries one after the other.
class YamlDocument {
 public:
  /// Parses `text`, the content of `file`. Throws robots::InputError for bad syntax, several
  /// documents, and texts beyond the limits above. Calls `stop` after every few thousand entries,
  /// and throws robots::Stopped if it returns true. Without a document the root is null. Readers of
  /// the document add their errors to `errors`, unless it is null. O(text).
  YamlDocument(std::string file, std::string text, const robots::Stop& stop = {},
               robots::InputErrors* errors = nullptr);

  /// Parses a text that is JSON and begins at `line` of `file`. Throws robots::InputError for
  /// others. O(text).
  static YamlDocument ofJson(std::string file, std::string text, int line);

  const std::string& file() const { return file_; }
  robots::InputErrors* errors() const { return errors_; }
  const YamlNode& node(YamlIndex i) const { return nodes_[static_cast<std::size_t>(i)]; }
  /// An alias' target; any other node itself.
  YamlIndex resolved(YamlIndex i) const { return isAlias(i) ? node(i).first : i; }
  std::string_view text(const YamlNode& scalar) const {
    return std::string_view(texts_).substr(static_cast<std::size_t>(scalar.text),
                                           static_cast<std::size_t>(scalar.text_size));
  }
  /// The name of a value in messages: "objects[2].box.size"; "the file" at the top. O(depth *
  /// entries).
  std::string where(YamlIndex i) const;

 private:
  class Builder;
  class YamlEvents;
  class JsonEvents;
  YamlDocument() = default;
  /// Parses `text`, which begins at `first_line`, as JSON, and moves it into `texts_`. If it is not
  /// JSON, returns false, changes nothing, and sets `error_line` to the line of the first error.
  bool parseJson(std::string& text, int& error_line, int first_line = 1);
  void parseYaml(const std::string& text);
  bool isAlias(YamlIndex i) const { return node(i).kind == YamlNode::Kind::kAlias; }

  std::string file_;
  robots::Stop stop_;  // during parsing
  robots::InputErrors* errors_ = nullptr;
  std::vector<YamlNode> nodes_;
  std::string texts_;  // of all scalars
};

}  // namespace leeway::planner
