#pragma once

// Private to planner/: checks of the parts of a Problem. Readers of problem files name the line of
// a fault, validate() the member; the words are the same.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/planner/problem.h"
#include "leeway/planner/settings.h"
#include "planner/validate/names.h"

namespace leeway::planner {

/// A fault in a section of a problem: the whole message, "limits.time is -1; ...", and
/// where problem files say it: a key of the section, and for a map by name the name in it.
struct Fault {
  std::string message, key, name;
};

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
/// Returns the fault of a cost alone; its terms are checked one by one.
std::optional<std::string> costFault(const MinimumCost& cost);
/// Whether the objective, or wishes beside it, are a cost of paths.
bool asksForCost(const Problem& problem);
/// Why the objective does not fit the wishes.
std::optional<std::string> wishesFault(const Problem& problem);
/// Why the planner parameter `improve` has no effect on what is optimised.
std::optional<std::string> improveFault(const Problem& problem);
/// Why the planner cannot minimise the problem's cost, and which planners can.
std::optional<std::string> costPlannerFault(const Problem& problem);

/// Returns the fault of a wish's numbers. `where`: its clearance; the weight follows it.
std::optional<Fault> wishFault(const Wish& wish, const std::string& where);

/// "joint 'elbow'", of a variable of the model.
std::string variableText(const robots::Model& model, int variable);
/// Returns the fault of a range of values of a planned variable, which for one value has no
/// width: "joint 'elbow' at 4, outside its limits; -3 to 3 is expected". Nothing for orientations.
std::optional<std::string> rangeFault(const robots::Model& model, int variable, double lower,
                                      double upper);
/// Returns the fault of a goal: "goal 'reach' has joint ...". Its poses, or a range for each
/// planned variable.
std::optional<std::string> goalFault(const Problem& problem, const Goal& goal);
/// Returns the fault of the start: the whole message.
std::optional<std::string> startFault(const Problem& problem);
/// Returns the fault of poses as goal or start.
std::optional<std::string> posesFault(const Problem& problem,
                                      const std::vector<robots::PoseRegion>& poses);

/// Returns the fault of a constraint alone: "WHERE.angle is ...".
std::optional<Fault> constraintFault(const Problem& problem, const Constraint& constraint,
                                     const std::string& where);
/// Why a problem with constraints cannot be planned.
std::optional<std::string> constraintsFault(const Problem& problem);

/// Returns the fault of a pose of a problem, "is at (nan, 0, 0); ...", for behind "the pose of
/// 'a'"; empty: nothing. A matrix is a rotation when it is right-handed and orthogonal within
/// collision::kRotationTolerance.
std::string poseFault(const robots::Pose& X);
/// Returns the fault of the poses of an object and its shapes: the whole message.
std::string objectFault(const Object& object);

/// Returns the largest separation that margins, wishes or the objective depend on [m]; infinite
/// for a cost that is inverse to the distance.
double mostMargin(const Problem& problem);
/// Returns a message if the object's cloud was cropped at less than `most_margin` [m], so that
/// balls which matter may be missing; otherwise an empty string.
std::string cropFault(const Object& object, double most_margin);

/// Returns the fault of a bound on an obstacle's speed: it is below what the obstacle's own motion
/// may reach while the execution lasts.
std::optional<std::string> speedBoundFault(const DeformingObstacle& obstacle,
                                           const Execution& execution);

/// Throws robots::InputError where the model, the planned variables, the start or
/// what the robot carries makes no sense: what poses and contacts are looked up in.
void checkRobot(const Problem& problem);

/// Checks a step in the world that those before have left, and takes it there as far as names go:
/// objects are taken from where the start has them. Throws std::invalid_argument.
void takeStep(const Step& step, Problem& world);

/// Refuses a problem whose start is given by poses.
void requirePlaced(const Problem& problem);
/// And one without goals, or with steps, for a call that needs goals.
void requireGoals(const Problem& problem, const char* call);

/// Throws std::invalid_argument unless a tolerance of clearances is above 0 [m].
void requireTolerance(double tolerance, const char* call);

/// attachObject() and detachObject() of a problem that was checked.
Problem attached(const Problem& problem, const std::string& object, const std::string& link,
                 const std::vector<std::string>& touch_links,
                 std::span<const double> configuration);
Problem detached(const Problem& problem, const std::string& object,
                 std::span<const double> configuration);
/// shapesOf() and reachOf() of one that was checked as far as checkRobot() does.
std::vector<robots::Geometry> placedShapes(const Problem& problem, const std::string& name,
                                           std::span<const double> configuration);
std::vector<PointCloud::Ball> robotReach(const Problem& problem);
/// poseRegion() of one.
robots::PoseRegion regionOf(const Problem& problem, const FramePose& pose);
/// The region of a constraint's frame F itself, seen from its reference, with any pose in it.
robots::PoseRegion frameOf(const Problem& problem, const Constraint& constraint);
/// Regions in which a constraint holds: what inverse kinematics brings its frame into. They leave
/// room for what edges depart. Throws std::invalid_argument as regionOf().
std::vector<robots::PoseRegion> regionsOf(const Problem& problem, const Constraint& constraint);

}  // namespace leeway::planner
