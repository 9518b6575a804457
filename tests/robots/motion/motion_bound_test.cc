#include "leeway/robots/motion_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/robots/kinematics.h"
#include "tests/support/random_model.h"

namespace leeway::robots {
namespace {

using testing::Random;

/// A point fixed to `link`, in the frame of `base`, at t along an edge.
class Track {
 public:
  Track(const Model& model, std::vector<double> q, std::vector<double> dq, int link, int base)
      : model_(model),
        q_(std::move(q)),
        dq_(std::move(dq)),
        link_(link),
        base_(base),
        poses_(model.links.size()) {}

  Eigen::Vector3d operator()(double t, const Eigen::Vector3d& p_L) {
    place(t);
    const Eigen::Vector3d p_W = poses_[static_cast<std::size_t>(link_)] * p_L;
    return base_ < 0 ? p_W : poses_[static_cast<std::size_t>(base_)].inverse() * p_W;
  }
  std::span<const Pose> place(double t) {
    forwardKinematics(model_, testing::advanced(model_, q_, dq_, t), poses_);
    return poses_;
  }

 private:
  const Model& model_;
  std::vector<double> q_, dq_;
  int link_, base_;
  std::vector<Pose> poses_;
};

// First and second differences over any step obey the bounds: no derivative is approximated.
TEST(MotionBound, HoldsOnRandomTrees) {
  Random random(1);
  int checked = 0, biting = 0, biting_local = 0;
  double tightest = 0;
  for (int run = 0; run < 1500; ++run) {
    const auto model = testing::randomTree(random, 3 + random.integer(8));
    const auto links = static_cast<int>(model->links.size());
    const std::vector<double> q = testing::randomConfiguration(random, *model);
    const std::vector<double> dq = testing::randomDifference(random, *model, q);
    const int link = random.integer(links), base = random.integer(links + 1) - 1;
    const Eigen::Vector3d center = random.vector(0.2);
    const double radius = random.uniform(0, 0.2);
    const RelativeMotion motion = relativeMotion(*model, link, base, center, radius);
    std::vector<JointMotion> joint_motion(model->joints.size());
    jointMotion(*model, dq, joint_motion);
    const double acceleration = accelerationBound(*model, motion, joint_motion);
    const double speed = speedBound(*model, motion, joint_motion);
    Track track(*model, q, dq, link, base);
    for (int k = 0; k < 12; ++k) {
      const double half = random.uniform(0.01, 0.5), middle = random.uniform(half, 1 - half);
      const MotionBound local =
          localMotionBound(*model, motion, joint_motion, track.place(middle), half);
      const Eigen::Vector3d p = center + radius * random.direction();
      const Eigen::Vector3d p0 = track(middle - half, p), p1 = track(middle, p),
                            p2 = track(middle + half, p);
      const double second = (p0 - 2 * p1 + p2).norm() / (half * half),
                   first = (p2 - p0).norm() / (2 * half);
      const double rounding = 1e-12 / (half * half);
      ++checked;
      ASSERT_LE(second, acceleration + rounding)
          << "run " << run << " link " << link << " base " << base;
      ASSERT_LE(second, local.acceleration + rounding)
          << "run " << run << " link " << link << " base " << base;
      ASSERT_LE(first, speed + rounding) << "run " << run << " link " << link << " base " << base;
      ASSERT_LE(first, local.speed + rounding)
          << "run " << run << " link " << link << " base " << base;
      ASSERT_LE(local.acceleration, acceleration);
      ASSERT_LE(p1.norm(), motion.base_reach + 1e-12);
      if (acceleration > 0) tightest = std::max(tightest, second / acceleration);
      biting += second > 0.2 * acceleration && acceleration > 1e-3;
      biting_local += second > 0.2 * local.acceleration && acceleration > 1e-3;
    }
  }
  EXPECT_GT(checked, 10000);
  EXPECT_GT(biting, checked / 50);  // guards against useless bounds
  EXPECT_GT(biting_local, checked / 10);
  EXPECT_GT(tightest, 0.9);
}

TEST(MotionBound, ReachesHoldAtEveryConfiguration) {
  Random random(2);
  for (int run = 0; run < 300; ++run) {
    const auto model = testing::randomTree(random, 3 + random.integer(6));
    const auto links = static_cast<int>(model->links.size());
    const int link = random.integer(links), base = random.integer(links + 1) - 1;
    const Eigen::Vector3d center = random.vector(0.2);
    const RelativeMotion motion = relativeMotion(*model, link, base, center, 0.1);
    std::vector<Pose> poses(model->links.size());
    for (int k = 0; k < 20; ++k) {
      forwardKinematics(*model, testing::randomConfiguration(random, *model), poses);
      const Eigen::Vector3d p =
          poses[static_cast<std::size_t>(link)] * (center + 0.1 * random.direction());
      for (const RelativeMotion::Term& term : motion.terms) {
        const Joint& joint = model->joints[static_cast<std::size_t>(term.joint)];
        if (joint.type == JointType::kPrismatic) continue;
        const Pose& X_WC = poses[static_cast<std::size_t>(joint.child_link)];
        const Eigen::Vector3d arm = p - X_WC.translation;
        const double distance = joint.type == JointType::kFloating
                                    ? arm.norm()
                                    : arm.cross(X_WC.rotation * joint.axis).norm();
        ASSERT_LE(distance, term.reach + 1e-12) << "run " << run << " joint " << joint.name;
      }
    }
  }
}

TEST(MotionBound, CommonMotionCostsNothing) {
  Random random(3);
  for (int run = 0; run < 100; ++run) {
    const auto model = testing::randomTree(random, 8);
    const RelativeMotion own = relativeMotion(*model, 5, 5, Eigen::Vector3d::Zero(), 0.1);
    EXPECT_TRUE(own.terms.empty());
    for (const RelativeMotion::Term& term :
         relativeMotion(*model, 7, 6, Eigen::Vector3d::Zero(), 0.1).terms)
      for (int shared = model->joints[6].parent_link; shared >= 0;
           shared = model->joints[static_cast<std::size_t>(shared)].parent_link)
        for (int above = 7; above != shared && above >= 0;
             above = model->joints[static_cast<std::size_t>(above)].parent_link)
          if (model->joints[static_cast<std::size_t>(above)].parent_link == shared) {
            EXPECT_NE(term.joint, shared);
          }
  }
}

// A finger that slides along x on a link that turns about z.
void slidingFinger(int i, Link& /*link*/, Joint& joint) {
  if (i == 2) joint.type = JointType::kPrismatic;
  joint.axis = i == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
}

TEST(MotionBound, PassiveJointsOutsideTheirLimitsCount) {
  // A finger at 65 mm, beyond its limit of 40 mm.
  RobotDescription robot = testing::chain(3, JointType::kRevolute, 2, slidingFinger);
  robot.variables[1].lower = 0;
  robot.variables[1].upper = 0.04;
  const Model model(std::move(robot));
  std::vector<VariableRange> ranges = limitRanges(model);
  ranges[1] = {0.065, 0.065};
  const RelativeMotion motion = relativeMotion(model, 2, -1, Eigen::Vector3d::Zero(), 0.01, ranges);
  ASSERT_EQ(motion.terms.size(), 1U);
  EXPECT_GE(motion.terms[0].reach, 0.075);
  EXPECT_LT(motion.terms[0].reach, 0.0751);
}

TEST(MotionBound, UnlimitedPrismaticIsInfiniteAndLocalIsNot) {
  RobotDescription robot = testing::chain(3, JointType::kRevolute, 2, slidingFinger);
  robot.variables[1].lower = -kInfinity;
  robot.variables[1].upper = kInfinity;
  const Model model(std::move(robot));
  const RelativeMotion motion = relativeMotion(model, 2, -1, Eigen::Vector3d::Zero(), 0.01);
  ASSERT_EQ(motion.terms.size(), 2U);
  EXPECT_TRUE(std::isinf(motion.terms[0].reach));
  std::vector<JointMotion> joint_motion(3);
  jointMotion(model, std::vector<double>{0.0, 0.5}, joint_motion);
  EXPECT_EQ(accelerationBound(model, motion, joint_motion), 0);  // 0 * infinity must not give NaN
  jointMotion(model, std::vector<double>{1.0, 0.5}, joint_motion);
  std::vector<Pose> poses(3);
  forwardKinematics(model, std::vector<double>{0.0, 0.3}, poses);
  EXPECT_TRUE(std::isinf(accelerationBound(model, motion, joint_motion)));
  const MotionBound local = localMotionBound(model, motion, joint_motion, poses, 0.5);
  EXPECT_GT(local.acceleration, 0.3 + 2 * 0.5);
  EXPECT_LT(local.acceleration, 0.57 + 2 * 0.5);
}

TEST(ProvenApart, ProvesWhatCannotMeetAndNothingElse) {
  // Links of 1 m in the plane. With turns of up to 0.5 rad the first and third stay apart; with 3
  // rad they meet.
  for (const double limit : {0.5, 3.0}) {
    const auto arm = [](int i, Link& link, Joint& joint) {
      Geometry g{collision::Shape::capsule(0.05, 0.4), {}, ""};
      g.X_BG.rotation =
          Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY()).toRotationMatrix();
      g.X_BG.translation = {0.5, 0, 0};
      link.geometries.push_back(g);
      joint.axis = Eigen::Vector3d::UnitZ();
      if (i > 0) joint.X_PJ.translation = {1, 0, 0};
    };
    RobotDescription robot = testing::chain(4, JointType::kRevolute, limit, arm);
    const Model model(std::move(robot));
    const std::vector<std::pair<int, int>> candidates{{0, 2}, {0, 3}, {1, 3}};
    EXPECT_EQ(provenApart(model, candidates).size(), limit < 1 ? 3U : 0U) << limit;
  }
}

}  // namespace
}  // namespace leeway::robots
