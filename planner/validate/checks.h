#pragma once

// Private to planner/: checks of the parts of a Problem. Readers of problem files add the line of a
// fault and validate() adds the member. The rest of the message is the same.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/planner/problem.h"
#include "leeway/planner/settings.h"
#include "planner/validate/names.h"

namespace leeway::planner {

/// A fault in a section of a problem. `message` is the whole message, "limits.time is -1; ...".
/// `key` is the key of the section with the fault; `name` is the name in the map at that key, if it
/// has names.
struct Fault {
  std::string message, key, name;
};

/// Returns a warning about the meshes that are not closed and that no warning of the loaders names;
/// empty if there are none. It names the key of files, or the means `of_program`s. O(warnings *
/// open meshes + geometries).
std::string openMeshes(const Problem& problem, bool of_program);
/// Returns a warning if a variable is not planned and its start is outside the robot's own limits.
/// Readers of problem files add file and line. O(planned variables).
std::optional<std::string> passiveWarning(const Problem& problem, int variable);

/// The numbers that a setting accepts, in words: "zero or more".
std::string expectedNumber(const Setting& setting);
/// Returns the fault of a number as the value of a setting: "WHERE is VALUE; ... is expected".
std::optional<std::string> numberFault(const Setting& setting, std::string_view where,
                                       double value);
/// Returns the fault of the first number that its setting does not accept.
std::optional<std::string> numbersFault(const Problem& problem);
/// Returns the fault of an execution whose numbers are accepted one by one.
std::optional<Fault> executionFault(const Problem& problem);

/// Returns the fault of a term of a cost. `where`: the term.
std::optional<Fault> termFault(const CostTerm& term, const std::string& where);
/// Returns the fault of a cost as a whole. Does not check its terms.
std::optional<std::string> costFault(const MinimumCost& cost);
/// Whether the problem minimises a cost of paths, by its objective or by wishes.
bool asksForCost(const Problem& problem);
/// Returns why the objective does not fit the wishes.
std::optional<std::string> wishesFault(const Problem& problem);
/// Returns why the planner parameter `improve` has no effect on what is optimised.
std::optional<std::string> improveFault(const Problem& problem);
/// Returns why the planner cannot minimise the problem's cost, and which planners can.
std::optional<std::string> costPlannerFault(const Problem& problem);

/// Returns the fault of a wish's numbers. `where`: its clearance; the weight follows it.
std::optional<Fault> wishFault(const Wish& wish, const std::string& where);

/// The name of a variable of the model in messages: "joint 'elbow'".
std::string variableText(const robots::Model& model, int variable);
/// Returns the fault of a range of values of a planned variable: "joint 'elbow' at 4, outside its
/// limits; -3 to 3 is expected". The range of a single value has no width. Returns nothing for
/// variables of orientations.
std::optional<std::string> rangeFault(const robots::Model& model, int variable, double lower,
                                      double upper);
/// Returns the same for one value of any variable that `bounds` or MoveIt's joint_limits.yaml
/// limit: those bind joints that are not planned, too. The robot's own limits do not, because
/// drivers report joints beyond them.
std::optional<std::string> boundsFault(const robots::Model& model, int variable, double value);
/// Returns the fault of a goal: "goal 'reach' has joint ...". Checks its poses, or the range of
/// each planned variable.
std::optional<std::string> goalFault(const Problem& problem, const Goal& goal);
/// Returns the fault of the start: the whole message.
std::optional<std::string> startFault(const Problem& problem);
/// Returns the fault of poses as goal or start.
std::optional<std::string> posesFault(const Problem& problem,
                                      const std::vector<robots::PoseRegion>& poses);

/// Certificate::conditions of a problem with a condition.
inline constexpr const char* kSampled = "sampled";
/// Whether paths keep more than margins: constraints, or a condition.
inline bool isConstrained(const Problem& problem) {
  return !problem.constraints.empty() || problem.condition.accept;
}
/// Returns the fault of one constraint: "WHERE.angle is ...".
std::optional<Fault> constraintFault(const Problem& problem, const Constraint& constraint,
                                     const std::string& where);
/// Returns why a problem with constraints, or with a condition, cannot be planned. O(pairs of
/// constraints).
std::optional<std::string> constraintsFault(const Problem& problem);

/// Returns the fault of a pose, "is at (nan, 0, 0); ...", to follow "the pose of 'a'" in a message;
/// empty if the pose is valid. A matrix is a rotation if it is right-handed and orthogonal within
/// collision::kRotationTolerance.
std::string poseFault(const robots::Pose& X);
/// Returns the fault of the poses of an object and its shapes: the whole message.
std::string objectFault(const Object& object);

/// Returns the largest separation that affects margins, wishes or the objective [m]; infinite for a
/// cost that is inverse to the distance.
double mostMargin(const Problem& problem);
/// Whether the margins of all pairs are the same, named in the same order.
bool areSameMargins(const Margins& x, const Margins& y);
/// The clearance that the objective length keeps from the world, as a margin of these pairs [m];
/// -infinity: none.
double keptClearance(const Problem& problem);
/// Requirements that a problem has of the crops of its clouds.
struct CropNeeds {
  double margin = 0;                      ///< mostMargin() [m]
  std::vector<PointCloud::Ball> reach_W;  ///< robotReach()
  std::string grasp = {};                 ///< firstGrasp()
};
/// Returns the first step that attaches an object, "step 'take'"; empty: none.
std::string firstGrasp(const Problem& problem);
/// Returns the needs of a problem that passed checkRobot(). O(geometries of the robot).
CropNeeds cropNeeds(const Problem& problem);
/// Returns a message if balls which matter may be missing from the object's cropped cloud because
/// it was cropped for another robot, pose or margin; otherwise an empty string.
std::string cropFault(const Object& object, const CropNeeds& needs);

/// Returns the fault of a bound on an obstacle's speed that is below the speed which the obstacle's
/// own motion may reach from `start` [s] on, without an end, because a Guard has none.
std::optional<std::string> speedBoundFault(const DeformingObstacle& obstacle, double start);
std::optional<std::string> speedBoundFault(const Object& object, double start);

/// When obstacles that move stand where a plan sees them [s]; nothing if none moves.
std::optional<double> obstaclesAt(const Problem& problem);

/// Returns a message, to follow the cloud's name, if the cloud was carved at another pose than
/// X_WC, where what was carved out may be in the way; otherwise an empty string.
std::string carveFault(const PointCloud& cloud, const robots::Pose& X_WC);
/// Whether the object's cloud was cropped or carved for the place where it stands.
bool isFitted(const Object& object);
/// A bound on how far points of an object are from its frame's origin [m]; infinite with a
/// half-space.
double extentOf(const Object& object);
/// A bound on the speed of an object's points, from one on its origin's speed [m/s] and one on its
/// turning [rad/s]; infinite where one is NaN.
double pointSpeed(double speed, double turning, double extent);
/// Returns the fault of an object's motion, behind its name: "moves and ..."; empty: nothing, or it
/// stands still. `start`: Execution::start [s].
std::string motionFault(const Object& object, double start);

/// Throws robots::InputError if the model, the planned variables, the start or the attached objects
/// are invalid. Poses and contacts are looked up in these.
void checkRobot(const Problem& problem);

/// Whether the robot moves in a step.
inline bool movesRobot(const Step& step) {
  return std::holds_alternative<MoveStep>(step.action) ||
         std::holds_alternative<LineStep>(step.action);
}
/// Checks a step in the world that the steps before it leave, and applies the step to `world` as
/// far as names are concerned: objects are attached where they are at the start. `is_first`: none
/// before it has moved the robot. Throws std::invalid_argument.
void takeStep(const Step& step, Problem& world, bool is_first);

/// A rotation by an angle in [0, pi] about a unit axis.
struct AxisTurn {
  Eigen::Vector3d axis;
  double angle;
};
AxisTurn axisTurn(const Eigen::Matrix3d& rotation);
/// Throws std::invalid_argument for half a turn, whose way round is not known. `what`: the pose.
void requireOneWay(const AxisTurn& turn, const std::string& what);
/// Returns a vector along the normal of the arc through three points. Throws std::invalid_argument
/// for points of one line.
Eigen::Vector3d arcNormal(const Eigen::Vector3d& from, const Eigen::Vector3d& via,
                          const Eigen::Vector3d& to, const std::string& what);
/// Throws std::invalid_argument for a line without motion, invalid numbers or rotations, half turns
/// and arcs without a circle. `X_RF`: the frame's first pose in its reference, if it is known.
void checkWay(const LineStep& line, const std::optional<robots::Pose>& X_RF);

/// Throws for a problem whose start is given by poses.
void requirePlaced(const Problem& problem);
/// Throws for a problem without goals, or with steps. `call` needs goals.
void requireGoals(const Problem& problem, const char* call);

/// Throws std::invalid_argument unless the tolerance of clearances is above 0 [m].
void requireTolerance(double tolerance, const char* call);

/// attachObject() and detachObject() for a problem that was checked.
Problem attached(const Problem& problem, const std::string& object, const std::string& link,
                 const std::vector<std::string>& touch_links,
                 std::span<const double> configuration);
Problem detached(const Problem& problem, const std::string& object,
                 std::span<const double> configuration);
/// shapesOf(), shapesToCarve() and reachOf() for a problem that passed checkRobot().
std::vector<robots::Geometry> placedShapes(const Problem& problem, const std::string& name,
                                           std::span<const double> configuration);
std::vector<robots::Geometry> carveShapes(const Problem& problem,
                                          std::span<const std::string> names,
                                          std::span<const double> configuration);
std::vector<PointCloud::Ball> robotReach(const Problem& problem);
/// The ball in the world that a point of a link stays in for all values of the planned joints.
PointCloud::Ball pointReach(const Problem& problem, int link, const Eigen::Vector3d& p_L);
/// poseRegion() for a problem that passed checkRobot(). `base_moves`: whether it may be relative to
/// what planned joints move, which is then the region's base.
robots::PoseRegion regionOf(const Problem& problem, const FramePose& pose, bool base_moves = false);
/// The region for a constraint's frame F, seen from its reference frame, that allows any pose.
robots::PoseRegion frameOf(const Problem& problem, const Constraint& constraint);
/// Returns regions in which a constraint holds, as targets of inverse kinematics. They leave room
/// for the departure of edges. Throws std::invalid_argument as regionOf() does.
std::vector<robots::PoseRegion> regionsOf(const Problem& problem, const Constraint& constraint);

}  // namespace leeway::planner
