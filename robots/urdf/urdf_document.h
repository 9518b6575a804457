#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"
#include "leeway/robots/model.h"

namespace leeway::robots {

/// A primitive that MuJoCo fits to a mesh.
struct MeshFit {
  enum class Inertia : unsigned char { kLegacy, kExact, kShell };
  Inertia inertia = Inertia::kLegacy;  ///< of the mesh: how its parts count
  bool to_bounds = false;              ///< around the mesh, not of about its inertia
  double scale = 1;                    ///< of the sizes
  Pose X_GM;                           ///< places the scaled mesh on the geom
};

/// A <collision> of a link of a URDF or SDF, as written, or a <visual> that stands in for it; a
/// geom of an MJCF file.
struct UrdfCollision {
  enum class Kind : unsigned char {
    kBox,
    kSphere,
    kCylinder,
    kMesh,
    kCapsule,
    kEllipsoid,
    kPlane  ///< the half-space below z = 0
  };
  std::string file;
  int line = 0;      ///< of the geometry's element
  std::string name;  ///< may be empty
  Pose X_LG;
  Kind kind = Kind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< box, ellipsoid: whole edges, axes [m]
  double radius = 0, length = 0;  ///< sphere, cylinder, capsule's straight part [m]
  std::string mesh_file;
  std::string mesh_from;  ///< the file whose folder mesh_file starts from; empty: the document's
  Eigen::Vector3d mesh_scale = Eigen::Vector3d::Ones();
  bool is_hull = false;        ///< of the mesh, unless LoadOptions::meshes says otherwise
  std::optional<MeshFit> fit;  ///< a primitive whose size and place follow from the mesh
};

struct UrdfLink {
  std::string name;
  std::string file;
  int line = 0;
  std::vector<UrdfCollision> collisions;
  std::vector<UrdfCollision> visuals;  ///< with UrdfDocument::with_visuals
  bool has_visual = false;             ///< whether or not visual shapes are read
  bool visual_stands_in = false;       ///< for the collision shapes
};

struct UrdfJoint {
  std::string name;
  std::string file;
  int line = 0;
  JointType type = JointType::kFixed;
  int parent = -1, child = -1;  ///< indices of links
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  Pose X_PJ;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< as written, not normalised
  bool has_limit = false;
  double lower = 0, upper = 0;  ///< 0 where not given, as URDF has it
  bool lacks_range = false;     ///< neither of them is given, in a URDF
  double velocity = std::numeric_limits<double>::infinity();
  double acceleration = std::numeric_limits<double>::infinity();  ///< and deceleration
  double jerk = std::numeric_limits<double>::infinity();
  int limit_line = 0;
  bool has_mimic = false;
  std::string mimic;
  int mimic_line = 0;
  double multiplier = 1, offset = 0;
  std::vector<double> rest;  ///< Variable::rest of its variables; empty: zeros
};

/// A named configuration.
struct UrdfState {
  std::string name;
  std::vector<std::pair<int, std::vector<double>>> values;  ///< joint, its variables
};

/// A URDF, or another description of a robot in its terms, checked: names are unique, there is one
/// root and no cycle, all numbers are finite and sensible.
struct UrdfDocument {
  std::string path, name;
  std::vector<UrdfLink> links;    ///< in file order
  std::vector<UrdfJoint> joints;  ///< in file order
  std::vector<std::string> warnings;
  bool with_visuals = false;                 ///< whether visual shapes are read
  std::vector<std::string> unread_visuals;   ///< why they are left out, each with file and line
  std::vector<DisabledPair> disabled_pairs;  ///< by an MJCF or SDF; of links as here
  std::vector<std::pair<int, int>> enabled_pairs;  ///< neighbours that are checked all the same
  std::vector<std::pair<int, int>> asked_pairs;    ///< that an MJCF checks by a <pair>
  std::vector<UrdfState> states;                   ///< the keys of an MJCF file
  /// The XML that bears on motion and collision, in the words of plain URDF 1.0: capsules are
  /// cylinders in it, Drake's ellipsoids boxes of their half axes.
  std::string essence;
};

class XmlFile;  // xml_reader.h

inline std::string lineOf(int line) { return "line " + std::to_string(line); }

/// Reads and checks a URDF, by TinyXML2, which keeps line numbers. `with_visuals`: also UrdfLink's
/// visuals; those that cannot be read are left out. Throws InputError.
UrdfDocument readUrdf(XmlFile& file, const LoadOptions& options, bool with_visuals = false);

/// The shape of a geometry that is not a mesh. Throws InputError for wrong sizes.
collision::Shape primitiveOf(const UrdfCollision& geometry);

/// Throws InputError unless the links form one tree, and every mimic leads to a joint of one
/// position. A mimic of a joint that is not defined is an independent joint, with a warning. Called
/// by readUrdf().
void checkStructure(UrdfDocument& document);

/// Reads the document's essence with urdfdom, the reader that robot software shares. Throws
/// InputError where urdfdom reads another robot.
void compareWithUrdfdom(const UrdfDocument& document);

/// The joints of a document by name; of two of one name the first. Valid while the document's list
/// stays. O(joints).
using JointsByName = std::unordered_map<std::string_view, const UrdfJoint*>;
JointsByName jointsByName(const UrdfDocument& document);

/// Lets a joint of one position stand still there.
void lockAt(UrdfJoint& joint, double position);

/// The rotation of fixed-axis angles roll, pitch, yaw [rad]: Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d rollPitchYaw(const Eigen::Vector3d& rpy);

}  // namespace leeway::robots
