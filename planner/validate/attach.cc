#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/problem.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/did_you_mean.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

using robots::Pose;

int requireLink(const robots::Model& model, const std::string& name) {
  const int link = model.findLink(name);
  if (link >= 0) return link;
  std::vector<std::string> known;
  for (const robots::Link& candidate : model.links) known.push_back(candidate.name);
  throw std::invalid_argument("unknown link '" + name + "'" + didYouMean(name, known));
}

Pose linkPose(const Problem& problem, int link, std::span<const double> configuration) {
  const robots::Model& model = *problem.robot.model;
  if (configuration.empty()) configuration = problem.start;
  if (configuration.size() != model.variables.size())
    throw std::invalid_argument("a configuration of " + std::to_string(configuration.size()) +
                                " numbers; all " + std::to_string(model.variables.size()) +
                                " variables of the model are expected");
  if (!std::all_of(configuration.begin(), configuration.end(),
                   [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument("a configuration with a number that is not finite");
  std::vector<Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, configuration, X_WL);
  return X_WL[at(link)];
}

}  // namespace

Problem attached(const Problem& problem, const std::string& object, const std::string& link,
                 const std::vector<std::string>& touch_links,
                 std::span<const double> configuration) {
  Problem result = problem;
  const auto found = std::find_if(result.world.objects.begin(), result.world.objects.end(),
                                  [&](const Object& o) { return o.name == object; });
  if (std::any_of(problem.world.deforming.begin(), problem.world.deforming.end(),
                  [&](const DeformingObstacle& o) { return o.object.name == object; }))
    throw std::invalid_argument("object '" + object + "' deforms: only rigid ones can be attached");
  if (found == result.world.objects.end()) {
    if (std::any_of(problem.robot.attachments.begin(), problem.robot.attachments.end(),
                    [&](const Attachment& held) { return held.object.name == object; }))
      throw std::invalid_argument("object '" + object +
                                  "' is held already; an object that stands in the world is "
                                  "expected");
    std::vector<std::string> known;
    for (const Object& o : result.world.objects) known.push_back(o.name);
    throw std::invalid_argument("no object '" + object + "' to attach" + didYouMean(object, known));
  }
  if (found->motion)
    throw std::invalid_argument("object '" + object +
                                "' has a motion: only objects that stand still can be attached");
  if (found->cloud)
    throw std::invalid_argument("object '" + object +
                                "' is a point cloud: only objects with shapes can be attached");
  if (!(extentOf(*found) < kInfinity))
    throw std::invalid_argument("'" + object +
                                "' has a half-space, which is not held; shapes of bounded size are "
                                "expected");
  Attachment attachment;
  attachment.link = requireLink(*problem.robot.model, link);
  for (const std::string& touch : touch_links)
    attachment.touch_links.push_back(requireLink(*problem.robot.model, touch));
  attachment.X_LO = linkPose(problem, attachment.link, configuration).inverse() * found->X_WO;
  attachment.object = std::move(*found);
  attachment.object.X_WO = Pose();
  result.world.objects.erase(found);
  result.robot.attachments.push_back(std::move(attachment));
  return result;
}

Problem detached(const Problem& problem, const std::string& object,
                 std::span<const double> configuration) {
  Problem result = problem;
  const auto found = std::find_if(result.robot.attachments.begin(), result.robot.attachments.end(),
                                  [&](const Attachment& a) { return a.object.name == object; });
  if (found == result.robot.attachments.end()) {
    std::vector<std::string> known;
    for (const Attachment& a : result.robot.attachments) known.push_back(a.object.name);
    throw std::invalid_argument("no attached object '" + object + "' to detach" +
                                didYouMean(object, known));
  }
  Object put_down = std::move(found->object);
  put_down.X_WO = linkPose(problem, found->link, configuration) * found->X_LO;
  result.robot.attachments.erase(found);
  result.world.objects.push_back(std::move(put_down));
  return result;
}

Problem attachObject(const Problem& problem, const std::string& object, const std::string& link,
                     const std::vector<std::string>& touch_links,
                     std::span<const double> configuration) {
  validate(problem);
  return attached(problem, object, link, touch_links, configuration);
}

Problem detachObject(const Problem& problem, const std::string& object,
                     std::span<const double> configuration) {
  validate(problem);
  return detached(problem, object, configuration);
}

}  // namespace leeway::planner
