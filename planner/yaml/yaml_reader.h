#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/robots/input_error.h"
#include "leeway/robots/stopped.h"
#include "planner/yaml/yaml_document.h"
#include "robots/base/read_on.h"

namespace leeway::planner {

/// A place in a YAML file, read strictly: a wrong type, a missing or unknown key and a number that
/// is not finite throw InputError with file and line. JSON is YAML, too. Cheap to copy.
class YamlReader {
 public:
  /// The only document of a file. Throws for an unreadable file, bad syntax, no or several
  /// documents, and robots::Stopped.
  /// With `errors`, reading goes on after an error where this class says so.
  static YamlReader load(const std::string& path, const robots::Stop& stop = {},
                         robots::InputErrors* errors = nullptr);
  /// A JSON document that begins at `line` of a file. Throws InputError for other texts.
  static YamlReader ofJson(const std::string& path, std::string text, int line);

  const std::string& file() const { return document_->file(); }
  int line() const { return line_; }
  /// How messages call this place: "objects[2].box.size"; "the file" at the top.
  std::string where() const { return document_->where(place_); }
  [[noreturn]] void fail(const std::string& message) const;
  /// Calls read(). False where it threw an InputError that was kept.
  template <class Read>
  bool readOn(const Read& read) const {
    return robots::readOn(document_->errors(), read);
  }

  bool isMap() const { return node().kind == YamlNode::Kind::kMap; }
  bool isList() const { return node().kind == YamlNode::Kind::kList; }
  bool isScalar() const { return node().kind == YamlNode::Kind::kScalar; }
  bool isNull() const { return node().kind == YamlNode::Kind::kNull; }
  /// Nothing, or a text, list or map without content.
  bool isEmpty() const { return isNull() || (isScalar() ? node().text_size == 0 : size() == 0); }

  // Maps.
  /// Fails unless this is a map whose keys are all in `known`, each once. Keeps each wrong key
  /// where errors are gathered.
  void expectKeys(std::span<const std::string_view> known) const;
  /// All entries in file order; fails unless a map, and for a key that stands twice.
  std::vector<std::pair<std::string, YamlReader>> entries() const;
  /// Calls visit(key, value) for all entries; after an error with the next one where errors are
  /// gathered.
  template <class Visit>
  void eachEntry(const Visit& visit) const {
    for (const std::pair<std::string, YamlReader>& entry : entries())
      readOn([&] { visit(entry.first, entry.second); });
  }
  bool has(std::string_view key) const { return find(key).has_value(); }
  std::optional<YamlReader> find(std::string_view key) const;
  /// The value of a key that must be there; `accepted` says what is expected of it.
  YamlReader at(std::string_view key, std::string_view accepted) const;

  // Lists.
  /// Entries of a list or a map.
  std::size_t size() const {
    return static_cast<std::size_t>(isMap() ? node().count / 2 : node().count);
  }
  std::vector<YamlReader> items() const;  ///< fails unless a list
  /// Calls visit(item) for each of a list's; after an error with the next one where errors are
  /// gathered.
  template <class Visit>
  void eachItem(const Visit& visit) const {
    for (const YamlReader& item : items()) readOn([&] { visit(item); });
  }

  // Values.
  std::string text() const;     ///< any scalar, not empty
  std::string anyText() const;  ///< any scalar; "" is empty
  double number() const;        ///< finite
  double sizeNumber() const;    ///< finite and not negative
  std::int64_t integer(std::int64_t lowest) const;
  std::uint64_t seed() const;  ///< a whole number, up to 2^64 - 1
  bool boolean() const;        ///< true or false
  std::vector<double> numbers() const;
  Eigen::Vector3d vector3() const;
  Eigen::Vector3d sizeVector3() const;  ///< no negative entry

 private:
  YamlReader(std::shared_ptr<const YamlDocument> document, YamlIndex place, int parent_line);
  const YamlNode& node() const { return document_->node(document_->resolved(place_)); }
  /// Fails for a value with a tag, which may change what it means: "!degrees 90".
  std::string_view scalar() const;
  void expectMap() const;
  [[noreturn]] void failTwice(YamlIndex key, const YamlReader& first) const;
  /// Calls visit(key) for every key of a map, until it returns false.
  template <class Visit>
  void forEachKey(const Visit& visit) const;
  const YamlNode& keyNode(YamlIndex key) const { return document_->node(document_->resolved(key)); }
  int keyLine(YamlIndex key) const { return document_->node(key).line; }
  YamlReader valueOf(YamlIndex key) const;
  std::string shown() const;  ///< the offending value, short enough for a message

  std::shared_ptr<const YamlDocument> document_;
  YamlIndex place_;  // an alias is not resolved here
  int line_;
};

}  // namespace leeway::planner
