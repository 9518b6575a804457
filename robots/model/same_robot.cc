#include "robots/model/same_robot.h"

#include <algorithm>
#include <utility>

namespace leeway::robots {

namespace {

bool isSameShape(const collision::Shape& a, const collision::Shape& b) {
  return a.type() == b.type() && a.radius() == b.radius() && a.halfLength() == b.halfLength() &&
         a.halfExtents() == b.halfExtents() && a.hull() == b.hull() && a.mesh() == b.mesh() &&
         a.deformable() == b.deformable();
}

bool isSameJoint(const Joint& a, const Joint& b) {
  return a.type == b.type && a.parent_link == b.parent_link && a.child_link == b.child_link &&
         isSamePose(a.X_PJ, b.X_PJ) && a.axis == b.axis && a.first_variable == b.first_variable &&
         a.mimic == b.mimic && a.multiplier == b.multiplier && a.offset == b.offset;
}

bool isSameStep(const KinematicStep& a, const KinematicStep& b) {
  return a.type == b.type && a.parent_link == b.parent_link && a.variable == b.variable &&
         a.multiplier == b.multiplier && a.offset == b.offset && a.turned == b.turned &&
         a.fixed == b.fixed && a.sine == b.sine && a.cosine == b.cosine &&
         a.translation == b.translation && a.u == b.u && a.v == b.v;
}

}  // namespace

bool isSamePose(const Pose& a, const Pose& b) {
  return a.rotation == b.rotation && a.translation == b.translation;
}

bool areSameGeometries(std::span<const Geometry> a, std::span<const Geometry> b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [](const Geometry& x, const Geometry& y) {
        return x.name == y.name && isSameShape(x.shape, y.shape) && isSamePose(x.X_BG, y.X_BG);
      });
}

bool areSameBodies(const RobotDescription& a, const RobotDescription& b) {
  return std::equal(a.joints.begin(), a.joints.end(), b.joints.begin(), b.joints.end(),
                    isSameJoint) &&
         std::equal(a.links.begin(), a.links.end(), b.links.begin(), b.links.end(),
                    [](const Link& x, const Link& y) {
                      return areSameGeometries(x.geometries, y.geometries);
                    });
}

bool isSameRobot(const RobotDescription& a, const RobotDescription& b) {
  return a.has_srdf == b.has_srdf && a.unchecked_links == b.unchecked_links &&
         a.enabled_pairs == b.enabled_pairs && a.asked_pairs == b.asked_pairs &&
         std::equal(a.disabled_pairs.begin(), a.disabled_pairs.end(), b.disabled_pairs.begin(),
                    b.disabled_pairs.end(),
                    [](const DisabledPair& x, const DisabledPair& y) {
                      return x.link_a == y.link_a && x.link_b == y.link_b && x.reason == y.reason &&
                             x.is_of_mjcf == y.is_of_mjcf;
                    }) &&
         std::equal(a.links.begin(), a.links.end(), b.links.begin(), b.links.end(),
                    [](const Link& x, const Link& y) { return x.name == y.name; }) &&
         areSameBodies(a, b);
}

bool hasStepsOfItsJoints(const Model& model) {
  const auto count = static_cast<int>(model.joints.size());
  if (std::any_of(model.joints.begin(), model.joints.end(),
                  [&](const Joint& joint) { return joint.mimic >= count; }))
    return false;
  RobotDescription joints;
  joints.joints = model.joints;
  const Model made(std::move(joints));
  return std::equal(model.steps.begin(), model.steps.end(), made.steps.begin(), made.steps.end(),
                    isSameStep);
}

}  // namespace leeway::robots
