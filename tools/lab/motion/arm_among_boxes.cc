#include "tools/lab/motion/arm_among_boxes.h"

#include <cmath>
#include <string>
#include <utility>

#include "leeway/robots/link_motion.h"

namespace leeway::tools::report::motion_families {
namespace {

constexpr std::size_t kLinks = 7, kBoxes = 5;
constexpr double kLength = 0.2;  // [m]

Vector3d axis(std::size_t joint) { return joint % 2 == 0 ? Vector3d::UnitZ() : Vector3d::UnitY(); }

/// Middle of a link's box, computed here so that it is independent of robots::.
Pose pose(const std::vector<double>& q, const std::vector<double>& dq, std::size_t link, double t) {
  Pose X;
  for (std::size_t i = 0; i <= link; ++i)
    X = X * placed({0, 0, i == 0 ? 0 : kLength}, slowTurn(axis(i), q[i] + t * dq[i]));
  return X * placed({0, 0, kLength / 2});
}

/// The box's frame on a link.
class Mounted final : public collision::RigidMotion {
 public:
  explicit Mounted(std::shared_ptr<const RigidMotion> link)
      : link_(std::move(link)), mounted_(*link_, X_LB_) {}
  Pose pose(double t) const override { return mounted_.pose(t); }
  collision::FrameVelocity velocity(double t) const override { return mounted_.velocity(t); }
  collision::FrameMotionBound bound(double t0, double t1) const override {
    return mounted_.bound(t0, t1);
  }
  double rounding(double reach) const override { return mounted_.rounding(reach); }

 private:
  std::shared_ptr<const RigidMotion> link_;
  Pose X_LB_ = placed({0, 0, kLength / 2});
  collision::MountedMotion mounted_;
};

}  // namespace

ArmAmongBoxes::ArmAmongBoxes() {
  robots::RobotDescription robot;
  robot.name = "chain";
  for (std::size_t i = 0; i <= kLinks; ++i) {
    robots::Joint joint;
    joint.name = "joint" + std::to_string(i);
    joint.parent_link = static_cast<int>(i) - 1;
    joint.child_link = static_cast<int>(i);
    if (i > 0) {
      joint.type = robots::JointType::kContinuous;
      joint.X_PJ.translation = Vector3d(0, 0, i == 1 ? 0 : kLength);
      joint.axis = axis(i - 1);
      joint.first_variable = static_cast<int>(i) - 1;
      joint.variable_count = 1;
      robot.variables.push_back({joint.name, static_cast<int>(i), -HUGE_VAL, HUGE_VAL, HUGE_VAL});
    }
    robots::Link link;
    link.name = "link" + std::to_string(i);
    link.joint = static_cast<int>(i);
    robot.joints.push_back(joint);
    robot.links.push_back(link);
  }
  model_ = std::make_shared<const robots::Model>(std::move(robot));
}

void ArmAmongBoxes::add(FamilyMaker& make) {
  if (link_.shape == nullptr) link_ = make.box({0.05, 0.05, kLength / 2 - 0.02});
  Random& r = make.random;
  std::vector<double> q(kLinks), dq(kLinks);
  for (std::size_t i = 0; i < kLinks; ++i) {
    q[i] = r.uniform(-1.5, 1.5);
    dq[i] = r.uniform(-0.8, 0.8);
  }
  ContactCase c;
  std::vector<SlowBody> slow;
  for (std::size_t i = 0; i < kLinks; ++i) {
    c.spec.bodies.push_back({link_.shape,
                             std::make_shared<Mounted>(std::make_shared<robots::LinkMotion>(
                                 model_, static_cast<int>(i) + 1, q, dq)),
                             false});
    double speed = 0;
    for (std::size_t k = 0; k <= i; ++k)
      speed += std::abs(dq[k]) * kLength * static_cast<double>(i - k + 2);
    slow.push_back({link_.slow, [=](double t) { return pose(q, dq, i, t); }, speed});
  }
  for (std::size_t i = 0; i < kBoxes; ++i) {
    const Body box = make.box(0.05, 0.2);
    Pose X = placed(vector(r, 0.5, 1.4));
    X.rotation = r.rotation();
    c.spec.bodies.push_back({box.shape, std::make_shared<collision::Still>(X), true});
    slow.push_back({box.slow, [X](double) { return X; }, 0});
    for (std::size_t k = 0; k < kLinks; ++k) c.spec.pairs.push_back({k, kLinks + i});
  }
  const TimeTruth truth = slowFirstContact(slow, c.spec.pairs, 0);
  // Contact at the start has a separate family.
  if (truth.contact && truth.upper == 0) return;
  make.keep(std::move(c), truth);
}

}  // namespace leeway::tools::report::motion_families
