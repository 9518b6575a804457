#pragma once

// Private to robots/mjcf: what the file says for all of its elements.

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/collision/pose.h"
#include "robots/mjcf/mjcf_file.h"

namespace leeway::robots {

using collision::Pose;

/// <compiler>, and what of <option> decides which bodies collide.
struct MjcfSettings {
  bool degrees = true;
  std::string euler = "xyz";  ///< the axes of euler angles; capitals: of the parent
  std::string mesh_folder;
  bool strips_paths = false;
  bool auto_limits = true;
  bool filters_parents = true;  ///< a body does not collide with its parent

  double angle(double written) const;  ///< [rad]
};

MjcfSettings readSettings(const MjcfFile& file);

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
  /// Exactly `count` numbers; nothing where the attribute is not given.
  std::optional<std::vector<double>> numbers(const char* name, std::size_t count) const;
  /// As many numbers as `values` has or fewer, written over it. Of a class that gives more than the
  /// element the rest stays, as MuJoCo has it.
  std::vector<double> over(const char* name, std::vector<double> values) const;
  /// The place of the text in `words`; that of `otherwise` where it is not given.
  std::size_t word(const char* name, const std::vector<std::string>& words,
                   std::string_view otherwise) const;
  bool flag(const char* name, bool otherwise) const;
  /// Bits of a mask.
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

  /// Of the element's own class, or else of `childclass`; empty: the outermost. `tag`: the
  /// element's name in <default>.
  Attributes of(const tinyxml2::XMLElement& element, const std::string& childclass,
                const char* tag = nullptr) const;
  /// Throws InputError unless the element's attribute names a class.
  void expectClass(const tinyxml2::XMLElement& element, const char* attribute) const;

 private:
  struct Class {
    std::string parent;
    std::vector<const tinyxml2::XMLElement*> elements;
  };
  void read(const tinyxml2::XMLElement& element, const std::string& parent);

  const MjcfFile& file_;
  std::string main_ = "main";
  std::map<std::string, Class> classes_;
};

/// `pos` and the one attribute that gives an orientation.
Pose poseOf(const Attributes& attributes, const MjcfSettings& settings);
/// The rotation of `angle` [rad] about an axis of any length but 0.
Eigen::Matrix3d rotationAbout(const Eigen::Vector3d& axis, double angle);
/// The shortest rotation of the z axis onto a direction of any length but 0; opposite to it, half a
/// turn about x.
Eigen::Matrix3d rotationOfZ(const Eigen::Vector3d& direction);
/// The rotation of w x y z of any length but 0.
Eigen::Matrix3d rotationOf(const std::vector<double>& quaternion);

/// Throws InputError where an attribute is none that MuJoCo has for a <body>, <frame>, <joint>,
/// <freejoint>, <geom>, <mesh>, <compiler> or <exclude>. Other elements pass.
void checkAttributes(const MjcfFile& file, const tinyxml2::XMLElement& element);

}  // namespace leeway::robots
