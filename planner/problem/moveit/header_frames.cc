#include "planner/problem/moveit/header_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/robots/groups.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/did_you_mean.h"
#include "planner/problem/moveit/fields.h"
#include "robots/urdf/srdf.h"

namespace leeway::planner {
namespace {

using robots::Model;
using robots::Pose;

/// Poses of one frame are the same if they differ by less than this [m, and entries of rotations]:
/// the rounding of kinematics.
constexpr double kSamePose = 1e-9;

bool isSame(const Pose& a, const Pose& b) {
  return (a.translation - b.translation).lpNorm<Eigen::Infinity>() <= kSamePose &&
         (a.rotation - b.rotation).lpNorm<Eigen::Infinity>() <= kSamePose;
}

/// As in MoveIt, "/base" is "base".
std::string withoutSlash(const std::string& name) {
  return name.substr(std::min(name.find_first_not_of('/'), name.size()));
}

std::optional<YamlReader> frameId(const YamlReader& message) {
  const auto header = message.find("header");
  const auto id = header && header->isMap() ? header->find("frame_id") : std::nullopt;
  return hasContent(id) ? id : std::nullopt;
}

}  // namespace

bool HeaderFrames::hasFixedBase() const {
  const Model& model = *problem_.robot.model;
  return model.joints[at(model.links[0].joint)].type == robots::JointType::kFixed;
}

const std::string& HeaderFrames::parentFrame() {
  if (!parent_frame_)
    parent_frame_ = withoutSlash(robots::parentFrame(*problem_.robot.model, stop_));
  return *parent_frame_;
}

const std::string& HeaderFrames::planningFrame() {
  if (hasFixedBase()) return problem_.robot.model->links[0].name;
  static const std::string kWorld = "world";
  return parentFrame().empty() ? kWorld : parentFrame();
}

Pose HeaderFrames::linkPose(int link, const std::vector<double>& configuration) {
  // Most calls are about one configuration.
  if (X_WL_.empty() || configuration != placed_at_) {
    X_WL_.resize(problem_.robot.model->links.size());
    robots::forwardKinematics(*problem_.robot.model, configuration, X_WL_);
    placed_at_ = configuration;
  }
  return X_WL_[at(link)];
}

void HeaderFrames::setSceneState(std::vector<double> configuration) {
  scene_state_ = std::move(configuration);
  if (scene_state_ == problem_.start) scene_state_.clear();
}

Pose HeaderFrames::startPose(const FramePlace& place) {
  return place.link < 0 ? place.X_LF : linkPose(place.link, problem_.start) * place.X_LF;
}

void HeaderFrames::warnOfPlacedBase(const std::string& file, int line, const std::string& what) {
  const Model& model = *problem_.robot.model;
  if (warned_ || !hasFixedBase() || isSame(model.joints[at(model.links[0].joint)].X_PJ, Pose()))
    return;
  warned_ = true;
  problem_.warnings.push_back(
      fmt::format("{}:{}: {} has no frame_id and is in the world; the base '{}' was placed "
                  "elsewhere, and a frame_id of that name would move with it",
                  file, line, what, model.links[0].name));
}

FramePlace HeaderFrames::find(const YamlReader& message) {
  const auto id = frameId(message);
  if (id) return find(*id, withoutSlash(id->text()));
  warnOfPlacedBase(message.file(), message.line(), message.where());
  return {};
}

FramePlace HeaderFrames::find(const YamlReader& id, const std::string& name) {
  const Model& model = *problem_.robot.model;
  if (!hasFixedBase() && name == planningFrame()) return {};
  if (const int link = model.findLink(name); link >= 0) return {link, Pose()};
  for (const Attachment& held : problem_.robot.attachments)
    if (held.object.name == name) return {held.link, held.X_LO};
  for (const auto& objects = problem_.world.objects; seen_ < objects.size(); ++seen_)
    objects_.emplace(objects[seen_].name, objects[seen_].X_WO);
  if (const auto object = objects_.find(name); object != objects_.end())
    return {-1, object->second};
  if (const auto found = transforms_.find(name); found != transforms_.end())
    return {-1, found->second};
  if (isWorld(name)) return {};
  std::vector<std::string> known = {"world"};
  if (!parentFrame().empty() && parentFrame() != "world") known.push_back(parentFrame());
  for (const auto& [frame, pose] : transforms_)
    if (frame != "world") known.push_back(frame);
  for (const robots::Link& link : model.links) known.push_back(link.name);
  for (const Object& object : problem_.world.objects) known.push_back(object.name);
  id.fail(fmt::format("unknown frame '{}' in {}{}", name, id.where(), didYouMean(name, known)));
}

void HeaderFrames::expectPlanningFrame(const YamlReader& message) {
  const auto id = frameId(message);
  if (!id) return;
  const std::string name = withoutSlash(id->text());
  if (!isWorld(name) && name != planningFrame())
    id->fail(fmt::format("{} is '{}'; the planning frame '{}' is expected", id->where(), name,
                         planningFrame()));
}

void HeaderFrames::readTransforms(const YamlReader& scene) {
  const auto transforms = scene.find("fixed_frame_transforms");
  if (hasContent(transforms))
    transforms->eachItem([&](const YamlReader& entry) { readTransform(entry); });
}

/// MoveIt writes the frame's name into header.frame_id and the planning frame into child_frame_id,
/// and takes the transform for the frame's pose in the planning frame. Others, MotionBenchMaker
/// among them, write the two names the other way round, as tf does, with the same transform.
void HeaderFrames::readTransform(const YamlReader& entry) {
  const Pose X_PF = readMoveitPose(entry.at("transform", "translation and rotation"), "translation",
                                   "rotation", problem_.warnings);
  const YamlReader child = entry.at("child_frame_id", "the name of a frame");
  const auto id = frameId(entry);
  std::string name = withoutSlash(child.text()), base = id ? withoutSlash(id->text()) : "";
  const bool is_identity = isSame(X_PF, Pose());
  if (base.empty() && is_identity) {  // so MotionBenchMaker writes the planning frame itself
    transforms_.emplace(name, Pose());
    return;
  }
  if (base.empty() ? name == planningFrame() : base == name) {
    if (is_identity) return;
    child.fail(
        fmt::format("{} is '{}', and {}; the frame's name in header.frame_id, and the "
                    "planning frame '{}' in child_frame_id are expected",
                    child.where(), name,
                    id ? "so is header.frame_id" : "header.frame_id is missing", planningFrame()));
  }
  if (!base.empty()) {
    if (name == planningFrame() || (base != planningFrame() && isWorld(name)))
      std::swap(name, base);
    else if (base != planningFrame() && !isWorld(base))
      child.fail(
          fmt::format("{} is '{}', and header.frame_id '{}'; the planning frame '{}' is expected "
                      "as one of them",
                      child.where(), name, base, planningFrame()));
  }
  if (base.empty()) warnOfPlacedBase(entry.file(), entry.line(), entry.where());
  // In a robot with a fixed base, the planning frame is the root link.
  const bool is_on_base = hasFixedBase() && base == planningFrame();
  const Pose X_WF = is_on_base ? linkPose(0, problem_.start) * X_PF : X_PF;
  // MoveIt does not use transforms of these.
  const int link = problem_.robot.model->findLink(name);
  if (link >= 0 || (!hasFixedBase() && name == planningFrame())) {
    if (!isSame(X_WF, startPose({link, Pose()})))
      problem_.warnings.push_back(fmt::format("{}:{}: the transform of '{}' is not used: {}",
                                              entry.file(), entry.line(), name,
                                              link >= 0 ? "the link stands where the start has it"
                                                        : "that is the planning frame itself"));
    return;
  }
  if (const auto [same, is_new] = transforms_.emplace(name, X_WF);
      !is_new && !isSame(same->second, X_WF))
    entry.fail(
        fmt::format("frame '{}' stands twice in fixed_frame_transforms; once is expected", name));
}

Pose HeaderFrames::ofObject(const YamlReader& message) {
  const FramePlace place = find(message);
  const Pose X_WF = startPose(place);
  if (place.link >= 0 && !scene_state_.empty() &&
      !isSame(linkPose(place.link, scene_state_) * place.X_LF, X_WF))
    frameId(message)->fail(
        fmt::format("'{}' stands elsewhere in the scene's robot_state than at the request's start; "
                    "a frame that does not move between them, such as '{}', is expected",
                    frameId(message)->text(), planningFrame()));
  return X_WF;
}

Pose HeaderFrames::inLink(const YamlReader& place, const FramePlace& of, int link, bool of_scene) {
  if (of.link == link) return of.X_LF;
  const Pose X_LF = linkPose(link, problem_.start).inverse() * startPose(of);
  if (!of_scene || scene_state_.empty()) return X_LF;
  const Pose X_WF = of.link < 0 ? of.X_LF : linkPose(of.link, scene_state_) * of.X_LF;
  if (!isSame(linkPose(link, scene_state_).inverse() * X_WF, X_LF))
    place.fail(
        fmt::format("{} is held elsewhere in the scene's robot_state than at the request's start; "
                    "a header.frame_id of its link '{}' is expected",
                    place.where(), problem_.robot.model->links[at(link)].name));
  return X_LF;
}

Pose HeaderFrames::inLink(const YamlReader& message, int link, bool of_scene) {
  return inLink(message, find(message), link, of_scene);
}

Pose HeaderFrames::inLink(const YamlReader& place, const Pose& X_WO, int link, bool of_scene) {
  return inLink(place, FramePlace{-1, X_WO}, link, of_scene);
}

Pose HeaderFrames::ofConstraint(const YamlReader& message) {
  const FramePlace place = find(message);
  if (place.link >= 0 &&
      robots::movesLink(*problem_.robot.model, problem_.robot.variables, place.link)) {
    const YamlReader id = *frameId(message);
    id.fail(
        fmt::format("{}: '{}' moves with the planned joints; something at rest to be relative "
                    "to is expected",
                    id.where(), id.text()));
  }
  return startPose(place);
}

}  // namespace leeway::planner
