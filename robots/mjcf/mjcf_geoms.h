#pragma once

// Private to robots/mjcf: geoms and the meshes that they name.

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "robots/mjcf/mjcf_settings.h"
#include "robots/urdf/urdf_document.h"

namespace leeway::robots {

/// The masks of a geom. Two geoms may collide if the contype of one and the conaffinity of the
/// other share a bit.
struct GeomMasks {
  unsigned contype = 1, conaffinity = 1;

  bool isNone() const { return contype == 0 && conaffinity == 0; }
  bool meets(const GeomMasks& other) const {
    return (contype & other.conaffinity) != 0 || (other.contype & conaffinity) != 0;
  }
  bool operator<(const GeomMasks& other) const {
    return contype != other.contype ? contype < other.contype : conaffinity < other.conaffinity;
  }
};

/// Reads geoms as MuJoCo collides them: meshes as their convex hulls, or as the primitives that it
/// fits to them.
class GeomReader {
 public:
  /// `file` and the others must outlive this.
  GeomReader(const MjcfFile& file, const MjcfSettings& settings, const DefaultClasses& classes);

  struct Geom {
    std::string name;
    GeomMasks masks;
    std::optional<UrdfCollision> shape;  ///< nothing: it collides with nothing
  };
  /// Reads a geom. X_LF places the frame that `element` is in on the body's link; `is_static`: the
  /// body stands still. Throws InputError.
  Geom read(const tinyxml2::XMLElement& element, const std::string& childclass, const Pose& X_LF,
            bool is_static);
  /// The shape of a geom as MuJoCo draws it, meshes as they are; nothing for a plane, and for a
  /// group that its viewer hides by default. Throws InputError.
  std::optional<UrdfCollision> readVisual(const tinyxml2::XMLElement& element,
                                          const std::string& childclass, const Pose& X_LF) const;

 private:
  struct Mesh {
    std::string path;
    Eigen::Vector3d scale = Eigen::Vector3d::Ones();
    Pose X_GM;  ///< places the scaled vertices of the file on the geom
  };
  void readMesh(const tinyxml2::XMLElement& element);
  Mesh resolved(const tinyxml2::XMLElement& element) const;
  UrdfCollision shapeOf(const Attributes& a, std::size_t type, const Pose& X_LF) const;
  void readShape(const Attributes& a, std::size_t type, const Pose& X_LF,
                 UrdfCollision& shape) const;
  void readMeshGeom(const Attributes& a, UrdfCollision& shape) const;
  /// A primitive that is fitted to the geom's mesh.
  void readFit(const Attributes& a, UrdfCollision& shape) const;
  /// The <mesh> that a geom names.
  const tinyxml2::XMLElement& meshOf(const Attributes& a) const;

  const MjcfFile& file_;
  const MjcfSettings& settings_;
  const DefaultClasses& classes_;
  std::map<std::string, const tinyxml2::XMLElement*> meshes_;
  std::set<std::string> paired_;  // geoms that a <pair> of <contact> names
};

}  // namespace leeway::robots
