#pragma once

#include <yaml-cpp/yaml.h>

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

namespace leeway::planner {

/// A place in a YAML file, read strictly: a wrong type, a missing or unknown key and a number that
/// is not finite throw InputError with file and line (from 1; yaml-cpp counts from 0). JSON is
/// YAML, too. Cheap to copy.
class YamlReader {
 public:
  /// The only document of a file. Throws for an unreadable file, bad syntax, no or several
  /// documents.
  static YamlReader load(const std::string& path);

  const std::string& file() const { return *file_; }
  int line() const { return line_; }
  /// How messages call this place: "objects[2].box.size"; "the file" at the top.
  const std::string& where() const { return where_; }
  [[noreturn]] void fail(const std::string& message) const;

  bool isMap() const { return node_.IsMap(); }
  bool isList() const { return node_.IsSequence(); }
  bool isScalar() const { return node_.IsScalar(); }
  bool isNull() const { return node_.IsNull(); }
  /// Nothing, or a text, list or map without content.
  bool isEmpty() const {
    return isNull() || (isScalar() ? node_.Scalar().empty() : node_.size() == 0);
  }

  // Maps.
  /// Fails unless this is a map whose keys are all in `known`, each once.
  void expectKeys(std::span<const std::string_view> known) const;
  /// All entries in file order; fails unless a map, and for a key that stands twice.
  std::vector<std::pair<std::string, YamlReader>> entries() const;
  bool has(std::string_view key) const { return find(key).has_value(); }
  std::optional<YamlReader> find(std::string_view key) const;
  /// The value of a key that must be there; `accepted` says what is expected of it.
  YamlReader at(std::string_view key, std::string_view accepted) const;

  // Lists.
  std::size_t size() const { return node_.size(); }
  std::vector<YamlReader> items() const;  ///< fails unless a list

  // Values.
  std::string text() const;   ///< any scalar, not empty
  double number() const;      ///< finite
  double sizeNumber() const;  ///< finite and not negative
  std::int64_t integer(std::int64_t lowest) const;
  std::uint64_t seed() const;  ///< a whole number, up to 2^64 - 1
  bool boolean() const;        ///< true or false
  std::vector<double> numbers() const;
  Eigen::Vector3d vector3() const;
  Eigen::Vector3d sizeVector3() const;  ///< no negative entry

 private:
  YamlReader(std::shared_ptr<const std::string> file, const YAML::Node& node, std::string where,
             int parent_line);
  void expectMap() const;
  YamlReader valueOf(const YAML::detail::iterator_value& entry) const;
  std::string shown() const;  ///< the offending value, short enough for a message

  std::shared_ptr<const std::string> file_;
  YAML::Node node_;
  std::string where_;
  int line_;
};

}  // namespace leeway::planner
