#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/scene.h"
#include "leeway/collision/shape.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/prepared_store.h"
#include "leeway/robots/stopped.h"

namespace leeway::robots {

using collision::Geometry;
using collision::Pose;

enum class JointType : unsigned char {
  kFixed,
  kRevolute,
  kContinuous,
  kPrismatic,
  kPlanar,
  kFloating
};

/// One joint: X_PC(q) = X_PJ * motion(q), P the parent link, C the child link.
struct Joint {
  std::string name;
  JointType type = JointType::kFixed;
  int parent_link = -1;  ///< -1: the world
  int child_link = -1;
  Pose X_PJ;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit; planar: the normal of the plane
  /// First variable and their number: 0 fixed or mimic, 1 revolute, continuous, prismatic; planar 3
  /// (x, y, theta); floating 7 (x y z qx qy qz qw).
  int first_variable = -1;
  int variable_count = 0;
  /// A mimic joint's position is multiplier * (master's position) + offset; mimic is the master's
  /// joint index.
  int mimic = -1;
  double multiplier = 1;
  double offset = 0;
};

/// The directions of a planar joint's x and y: the shortest rotation of the z axis onto `normal`
/// (unit) takes the x and y axes to u and v. O(1).
void planeAxes(const Eigen::Vector3d& normal, Eigen::Vector3d& u, Eigen::Vector3d& v);

/// One number of a configuration. Continuous joints and quaternions have infinite limits.
struct Variable {
  std::string name;  ///< the joint's name; planar and floating: joint name + "/x", "/y", "/theta",
                     ///< "/qx", ...
  int joint = -1;
  double lower, upper;  ///< [rad or m]; -+infinity where unlimited
  double velocity;      ///< [rad/s or m/s]; infinity where not given
  /// The source of a range that is narrower than the joint element's own, with file and line: a
  /// limit of a mimic joint, or withBounds(). Empty if the range is the element's own.
  std::string narrowed_by = {};
  double acceleration = std::numeric_limits<double>::infinity();  ///< [rad/s^2 or m/s^2]
  double jerk = std::numeric_limits<double>::infinity();          ///< [rad/s^3 or m/s^3]
  /// The limits of the robot's file, where withBounds() has replaced them: touchRange().
  std::optional<std::pair<double, double>> file_limits = {};
  /// Where the robot's file places it: in MJCF files qpos0, in others 0; 1 for the last number of a
  /// quaternion.
  double rest = 0;

  /// Returns the range in which it is decided whether links touch wherever their joint stands [rad
  /// or m]: lower and upper, and at least the file's limits. Narrower limits must not make a pair
  /// touch everywhere that does not.
  std::pair<double, double> touchRange() const {
    if (!file_limits) return {lower, upper};
    return {std::min(lower, file_limits->first), std::max(upper, file_limits->second)};
  }
};

struct Link {
  std::string name;
  int joint = -1;  ///< that moves it; the root's joins it to the world: fixed, planar or floating
  std::vector<Geometry> geometries;
};

struct Group {
  std::string name;
  std::vector<int> variables;  ///< indices of the variables that it plans, in tree order
  std::vector<int> links;
};

struct GroupState {
  std::string name;
  std::string group;
  std::vector<std::pair<int, double>> values;  ///< variable, value
};

struct DisabledPair {
  int link_a, link_b;
  std::string reason;
  bool is_of_mjcf = false;  ///< by the MJCF's or SDF's own rules; else by the SRDF
};

/// An entry of the SRDF that is wrong. Planning does not need it unless someone names it.
struct LeftOut {
  std::string kind;  ///< "group", "group state", "virtual joint", "end effector", ...
  std::string name;
  std::string group;  ///< of a group state
  std::string why;    ///< FILE:LINE: what is wrong
};

/// Proven distances of two links between which exactly two joints move, by the angles of both. Arc
/// k of kArcs holds the angles [k, k + 1] * 2 pi / kArcs, whole turns added.
struct LinkGap {
  static constexpr int kArcs = 128;
  int link_a = -1, link_b = -1;
  int joint = -1, other = -1;
  /// For each arc of `joint`: all geometries of both are farther apart, at any angle of `other`
  /// [m]; 0: not proven.
  std::vector<float> gaps;
  /// For arcs i of `joint` with gaps[i] = 0 and k of `other`, at i * kArcs + k: 1 if the links are
  /// proven farther apart than `cell_gap`.
  std::vector<char> cells;
  float cell_gap = 0;  ///< [m]

  /// Angles [rad].
  struct Range {
    double from, to;
  };
  /// The least proven distance over two ranges of angles [m]; 0: not proven, the links may overlap.
  /// O(arcs of one range times those of the other).
  double over(const Range& angles, const Range& others) const;
};

/// What forward kinematics reads of joint i: X_PC = [fixed + sin * sine + cos * cosine,
/// translation + ...].
struct KinematicStep {
  JointType type = JointType::kFixed;
  int parent_link = -1;
  int variable = -1;  ///< of the joint or of the mimic's master
  double multiplier = 1, offset = 0;
  bool turned = false;  ///< false: X_PJ only translates
  Eigen::Matrix3d fixed, sine, cosine;
  Eigen::Vector3d translation, u, v;  ///< u: prismatic axis; planar: directions of x and y, in P
};

/// How a mesh is read.
struct MeshTreatment {
  enum class Solid : unsigned char {
    kAuto,     ///< what its triangles enclose is solid, see collision::TriangleMesh
    kHull,     ///< its convex hull is
    kSurface,  ///< nothing is: a surface without an inside
  };
  Solid solid = Solid::kAuto;
  double weld = 0;  ///< collision::MeshOptions::weld [m]; 0 for a hull
};

/// The parts of LoadOptions that decide what a robot's files say, for programs that write the names
/// of these files down.
struct ReadWith {
  std::vector<std::pair<std::string, std::string>> packages, xacro;
  bool visual_as_collision = false;
  std::map<std::string, MeshTreatment, std::less<>> meshes;  ///< those of links and of their files
};

/// What a robot is made of. Links stand in tree order, parents before children; link 0 is the root.
struct RobotDescription {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;  ///< joint i moves link i: joints[i].child_link == i
  std::vector<Variable> variables;
  std::vector<Group> groups;  ///< from the SRDF
  /// From the SRDF, and the keys of an MJCF file, which are states of the group "all".
  std::vector<GroupState> group_states;
  std::vector<DisabledPair> disabled_pairs;
  /// Links that may touch everything (SRDF: disable_default_collisions): objects by this list;
  /// links by `disabled_pairs`, which has all their pairs but those of `enabled_pairs`.
  std::vector<int> unchecked_links;
  /// Pairs that are checked though they are neighbours, the lower link first (SRDF:
  /// enable_collisions).
  std::vector<std::pair<int, int>> enabled_pairs;
  /// Pairs that an MJCF file names in a <pair>, the lower link first. A warning names those that
  /// are not checked.
  std::vector<std::pair<int, int>> asked_pairs;
  std::vector<LeftOut> left_out;  ///< of the SRDF; each is in `warnings`, too
  bool has_srdf = false;
  bool lacks_meshes = false;          ///< read with kinematics_only, and the URDF has some
  std::string urdf_file, srdf_file;   ///< as given to loadModel(); empty for a free body
  std::string folder;                 ///< the working folder of loadModel()
  ReadWith read_with;                 ///< how loadModel() read them
  std::string cache;                  ///< LoadOptions::cache, for proofs about its links
  std::vector<std::string> warnings;  ///< of the loaders, each with file and line

  int findLink(std::string_view name) const;  ///< -1 when unknown
  int findJoint(std::string_view name) const;
  int findVariable(std::string_view name) const;
  int findGroup(std::string_view name) const;
  /// The end of a message about an unknown name: "; it is left out: WHY" where left_out has an
  /// entry of this kind and name, else empty.
  std::string whyLeftOut(std::string_view kind, std::string_view name) const;
  /// The same for a group state, when the variables `planned` are planned. Also empty if the
  /// state's group lacks one of them.
  std::string whyStateLeftOut(std::string_view state, std::span<const int> planned) const;
  /// Throws InputError if lacks_meshes: without its meshes a robot's collisions cannot be checked.
  void expectMeshes() const;
  /// Returns the path of a file or folder that was given to loadModel(). It does not depend on the
  /// present working folder.
  std::string placeOf(const std::string& file) const;
};

/// A robot, constant from its first use on: what is prepared of it is kept with it. A copy may be
/// changed before it is used. If its joints change, make a new one by Model(RobotDescription).
/// Configurations are spans of variables.size() doubles in the order of `variables`.
class Model : public RobotDescription {
 public:
  /// Compiles `steps`, and adds the group "all" of every variable and link unless there is one, or
  /// one that is left out. O(joints).
  explicit Model(RobotDescription description);

  std::vector<KinematicStep> steps;  ///< one a joint
  /// Takes proofs for pairs of links that stay near each other. They hold for the joints and
  /// geometries as they are now.
  void keepGaps(std::vector<LinkGap> gaps);
  /// The proofs that loadModel() or keepGaps() gave; none once joints or geometries have changed.
  /// O(joints + geometries).
  const std::vector<LinkGap>& linkGaps() const;

  /// What planning has prepared of this robot.
  PreparedStore prepared;

  /// Each variable at rest, or the nearest value inside the limits. Joints of MJCF files rest where
  /// these place them (qpos0), all others at zero.
  std::vector<double> defaultConfiguration() const;
  /// The same within the limits of the robot's file, where withBounds() has replaced them: where
  /// links touch at rest does not depend on what a problem narrows.
  std::vector<double> fileConfiguration() const;

 private:
  std::vector<LinkGap> link_gaps_;
  std::shared_ptr<const RobotDescription> gaps_of_;  ///< the robot that they were proven for
};

/// How robots and meshes are read.
struct LoadOptions {
  /// NAME, DIR: where package://NAME/... is; searched before ROS_PACKAGE_PATH, AMENT_PREFIX_PATH
  /// and the folders from the URDF's up.
  std::vector<std::pair<std::string, std::string>> packages = {};
  /// NAME, VALUE: arguments of xacro, for a URDF or SRDF that ends in .xacro.
  std::vector<std::pair<std::string, std::string>> xacro = {};
  /// True: links have no mesh shapes, and no mesh file is read. A model that lacks some then is
  /// refused by whatever checks collisions (lacks_meshes).
  bool kinematics_only = false;
  /// The <visual> shapes of a link stand in for its <collision> shapes, if it has none of these. A
  /// warning names the links.
  bool visual_as_collision = false;
  /// The folder that keeps what takes time to make of mesh files and robots, for the next process;
  /// empty: nothing is kept. The answers are the same, byte for byte. cacheFolder()
  /// (cache_folder.h) is the usual one.
  std::string cache = {};
  /// Asked between the parts of what is read: some thousand lines, an object, a stage of a mesh (of
  /// a million triangles a second or two), a proof about a pair of links. Once it is true, reading
  /// ends with Stopped.
  Stop stop = {};
  /// By the name of a link or object that has meshes, or by the path of a mesh as its file names
  /// it.
  std::map<std::string, MeshTreatment, std::less<>> meshes = {};
  /// Where it is set, it gathers the names in `meshes` that were found, for who loads more than a
  /// robot. Else loadModel() refuses a name that is not the robot's.
  std::set<std::string>* meshes_found = nullptr;
  /// Where it is set, it gathers all that is wrong: reading goes on after an error where it can,
  /// and throws the first in the end.
  InputErrors* errors = nullptr;
};

/// Reads a URDF, MJCF or SDF and (unless `srdf_path` is empty) an SRDF, with their meshes. Throws
/// InputError, naming file and line, for what is missing or makes no sense; lesser faults are in
/// the model's warnings.
std::shared_ptr<const Model> loadModel(const std::string& urdf_path, const std::string& srdf_path,
                                       const LoadOptions& options = {});

/// A model of one link on a planar or floating joint named `name`: a free body. A box bounds its
/// variables (planar: x, y); group "all" holds them. Throws std::invalid_argument: lower > upper.
std::shared_ptr<const Model> freeBody(const std::string& name, std::vector<Geometry> geometries,
                                      JointType type, const Eigen::Vector3d& lower,
                                      const Eigen::Vector3d& upper);

/// Reads a mesh file: STL, OBJ, PLY, DAE, glTF or GLB, exactly as written; other formats are
/// refused. Applies the file's unit and node transforms, then `scale`; ignores its up
/// axis, as RViz and MoveIt do. Polygons are cut into triangles that cover exactly them; what has
/// no area is left out. Throws InputError that names `referrer`:`line`, which asked for it, and the
/// mesh's own line or byte; lesser faults are appended to `warnings`, in the same form.
collision::Shape loadMesh(const std::string& path, const Eigen::Vector3d& scale,
                          const std::string& referrer, int line, const LoadOptions& options = {},
                          std::vector<std::string>* warnings = nullptr);

/// A mesh with a treatment, built again. Other shapes are returned as they are. Throws
/// collision::InvalidShape. O(n log n).
collision::Shape withTreatment(const collision::Shape& mesh, const MeshTreatment& treatment);

}  // namespace leeway::robots
