#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/did_you_mean.h"
#include "planner/validate/checks.h"
#include "planner/validate/names.h"
#include "robots/inverse/region.h"

namespace leeway::planner {
namespace {

using robots::Model;
using robots::Pose;

[[noreturn]] void refuse(const std::string& message) { throw std::invalid_argument(message); }

/// A frame on a link; link -1: in the world.
struct Place {
  int link = -1;
  Pose X_LF;
};

/// Whether a joint has a planned variable, or follows one that has.
bool isMoved(const Problem& problem, int j) {
  const Model& model = *problem.robot.model;
  while (model.joints[at(j)].mimic >= 0) j = model.joints[at(j)].mimic;
  const robots::Joint& joint = model.joints[at(j)];
  return std::any_of(problem.robot.variables.begin(), problem.robot.variables.end(), [&](int v) {
    return joint.variable_count > 0 && v >= joint.first_variable &&
           v < joint.first_variable + joint.variable_count;
  });
}

/// Whether a planned variable moves the link: one of a joint above it, or of such a joint's master.
bool moves(const Problem& problem, int link) {
  const Model& model = *problem.robot.model;
  for (int l = link; l >= 0; l = model.joints[at(model.links[at(l)].joint)].parent_link)
    if (isMoved(problem, model.links[at(l)].joint)) return true;
  return false;
}

/// Finds the frame of that name on the robot: a frame, a link or an attached object.
bool findOnRobot(const Problem& problem, const std::string& name, Place& place) {
  for (const Frame& frame : problem.robot.frames)
    if (frame.name == name) return place = {frame.link, frame.X_LF}, true;
  if (const int link = problem.robot.model->findLink(name); link >= 0)
    return place = {link, Pose()}, true;
  for (const Attachment& attachment : problem.robot.attachments)
    if (attachment.object.name == name) return place = {attachment.link, attachment.X_LO}, true;
  return false;
}

std::vector<std::string> namesOnRobot(const Problem& problem) {
  std::vector<std::string> names;
  for (const Frame& frame : problem.robot.frames) names.push_back(frame.name);
  for (const robots::Link& link : problem.robot.model->links) names.push_back(link.name);
  for (const Attachment& attachment : problem.robot.attachments)
    names.push_back(attachment.object.name);
  return names;
}

/// Whether planned variables move two links against each other.
bool movesApart(const Problem& problem, int a, int b) {
  const Model& model = *problem.robot.model;
  const auto jointsAbove = [&](int link) {
    std::vector<int> joints;
    for (; link >= 0; link = model.joints[at(joints.back())].parent_link)
      joints.push_back(model.links[at(link)].joint);
    return joints;
  };
  std::vector<int> above_a = jointsAbove(a), above_b = jointsAbove(b);
  while (!above_a.empty() && !above_b.empty() && above_a.back() == above_b.back()) {
    above_a.pop_back();
    above_b.pop_back();
  }
  const auto isPlanned = [&](int joint) { return isMoved(problem, joint); };
  return std::any_of(above_a.begin(), above_a.end(), isPlanned) ||
         std::any_of(above_b.begin(), above_b.end(), isPlanned);
}

/// The pose of what has that name in the world, or in the link `base` that planned variables move.
Pose namedPose(const Problem& problem, const std::string& name, bool base_moves, int& base) {
  for (const Object& object : problem.world.objects)
    if (object.name == name) {
      if (object.motion)
        refuse(fmt::format("'{}' has a motion; something at rest to be relative to is expected",
                           name));
      return object.X_WO;
    }
  for (const DeformingObstacle& obstacle : problem.world.deforming)
    if (obstacle.object.name == name) return obstacle.object.X_WO;
  Place place;
  if (!findOnRobot(problem, name, place)) {
    std::vector<std::string> known = namesOnRobot(problem);
    for (const Object& object : problem.world.objects) known.push_back(object.name);
    refuse(fmt::format("no object, link or frame '{}' to be relative to{}", name,
                       didYouMean(name, known)));
  }
  if (base_moves && moves(problem, place.link)) {
    base = place.link;
    return place.X_LF;
  }
  if (moves(problem, place.link))
    refuse(fmt::format(
        "'{}' moves with the planned joints; something at rest to be relative to is expected",
        name));
  std::vector<Pose> X_WL(problem.robot.model->links.size());
  robots::forwardKinematics(*problem.robot.model, problem.start, X_WL);
  return X_WL[at(place.link)] * place.X_LF;
}

/// Fails if a link has the name "world" and is elsewhere: the word would mean two things.
void requireOneWorld(const Problem& problem) {
  if (problem.robot.model->findLink(kWorldWord) < 0) return;
  int base = -1;
  const Pose X = namedPose(problem, kWorldWord, true, base);
  if (base >= 0 || X.rotation != Eigen::Matrix3d::Identity() || !X.translation.isZero(0))
    refuse(
        "'world' stands for the world's axes, and is the name of a link that is elsewhere as well; "
        "another name for that is expected");
}

/// The pose of a reference frame in the world, or in the link `base` that planned variables move.
Pose referencePose(const Problem& problem, const std::string& name, bool base_moves, int& base) {
  if (!name.empty() && name != kWorldWord) return namedPose(problem, name, base_moves, base);
  if (!name.empty()) requireOneWorld(problem);
  return Pose();
}

}  // namespace

robots::PoseRegion regionOf(const Problem& problem, const FramePose& pose, bool base_moves) {
  Place place;
  if (!findOnRobot(problem, pose.frame, place))
    refuse(fmt::format("no frame, link or attached object '{}'{}", pose.frame,
                       didYouMean(pose.frame, namesOnRobot(problem))));
  if (!moves(problem, place.link))
    refuse(fmt::format(
        "'{}' is not moved by the planned joints; a frame that they move is expected", pose.frame));
  robots::PoseRegion region;
  region.link = place.link;
  // With R_RF = turn * rotation, the frame F turned back by `rotation` has the orientation `turn`
  // in R. Its origin stays.
  region.X_LF = place.X_LF * Pose{pose.rotation.transpose(), Eigen::Vector3d::Zero()};
  region.X_WR = referencePose(problem, pose.relative_to, base_moves, region.base);
  if (region.base >= 0 && !movesApart(problem, region.link, region.base))
    refuse(
        fmt::format("the planned joints do not move '{}' against '{}'; two frames that they move "
                    "against each other are expected",
                    pose.frame, pose.relative_to));
  region.position = pose.position;
  region.rpy = pose.rpy;
  region.position_tolerance = pose.position_tolerance;
  region.angle_tolerance = pose.angle_tolerance;
  if (const auto fault = robots::regionFault(*problem.robot.model, region)) refuse(*fault);
  return region;
}

robots::PoseRegion poseRegion(const Problem& problem, const FramePose& pose) {
  checkRobot(problem);
  return regionOf(problem, pose);
}

}  // namespace leeway::planner
