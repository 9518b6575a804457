#pragma once

// Private to robots/mjcf: attributes of elements, and the classes that give them defaults.

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "robots/mjcf/mjcf_file.h"

namespace leeway::robots {

/// The attributes of an element, with those of its default class where it has none.
class Attributes {
 public:
  /// `levels`: the element, then the elements of its class, the nearest first.
  Attributes(const MjcfFile& file, std::vector<const tinyxml2::XMLElement*> levels)
      : file_(file), levels_(std::move(levels)) {}

  const MjcfFile& file() const { return file_; }
  const tinyxml2::XMLElement& element() const { return *levels_.front(); }
  /// The element that gives the attribute; null: none does.
  const tinyxml2::XMLElement* find(const char* name) const;
  /// Its text, or `otherwise`.
  std::string text(const char* name, const std::string& otherwise) const;
  double number(const char* name, double otherwise) const;
  Eigen::Vector3d vector(const char* name, const Eigen::Vector3d& otherwise) const;
  /// Exactly `count` finite numbers; nothing if the attribute is not given.
  std::optional<std::vector<double>> numbers(const char* name, std::size_t count) const;
  /// `values`, overwritten by the numbers of the outermost class, then by those of each nearer
  /// level. As in MuJoCo, a level with fewer numbers keeps the rest. Fails for more numbers than
  /// `values`.
  std::vector<double> over(const char* name, std::vector<double> values) const;
  /// The index of the text in `words`; that of `otherwise` if the attribute is not given.
  std::size_t word(const char* name, const std::vector<std::string>& words,
                   std::string_view otherwise) const;
  bool flag(const char* name, bool otherwise) const;
  /// The bits of a whole number, which may be negative.
  unsigned mask(const char* name, unsigned otherwise) const;

  [[noreturn]] void fail(const char* name, const std::string& message) const;

 private:
  const MjcfFile& file_;
  std::vector<const tinyxml2::XMLElement*> levels_;
};

/// <default>: classes of attributes, each with those of the class around it.
class DefaultClasses {
 public:
  explicit DefaultClasses(const MjcfFile& file);

  /// An element's attributes, by its own class or else by `childclass`; empty: the outermost class.
  /// `tag`: the element's name in <default>.
  Attributes of(const tinyxml2::XMLElement& element, const std::string& childclass,
                const char* tag = nullptr) const;
  /// Throws InputError unless the element's attribute names a class.
  void expectClass(const tinyxml2::XMLElement& element, const char* attribute) const;

 private:
  void read(const tinyxml2::XMLElement& element, const std::string& parent);

  const MjcfFile& file_;
  std::string main_ = "main";
  /// The elements of each class and of those around it, the nearest first. As in MuJoCo, a class
  /// has those that the class around it had when it began.
  std::map<std::string, std::vector<const tinyxml2::XMLElement*>> classes_;
};

/// Leaves out, with a warning, attributes that MuJoCo does not have for a <compiler>, <flag>,
/// <worldbody>, <body>, <frame>, <joint>, <freejoint>, <geom>, <mesh>, <exclude> or <key>. One that
/// seems to be a misspelt name is an error. Other elements pass.
void checkAttributes(const MjcfFile& file, const tinyxml2::XMLElement& element);

}  // namespace leeway::robots
