#include "robots/inverse/closed_form.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/robots/inverse_kinematics.h"
#include "leeway/robots/kinematics.h"
#include "robots/inverse/subproblems.h"
#include "tests/support/build_paths.h"
#include "tests/support/random_model.h"
#include "tests/support/sanitized.h"

namespace leeway::robots {
namespace {

using Eigen::Vector3d;
using testing::allVariables;
using testing::Random;

constexpr double kPi = std::numbers::pi;

struct Axis {
  Vector3d direction, point;
};

/// Revolute joints about these axes at angle 0, in frames with any rotation and anywhere on their
/// axes.
std::shared_ptr<const Model> armOf(Random& random, const std::vector<Axis>& axes, double limit) {
  std::vector<Pose> frames = {Pose()};
  for (const Axis& axis : axes)
    frames.push_back({random.rotation(), axis.point + random.uniform(-0.1, 0.1) * axis.direction});
  return std::make_shared<const Model>(
      testing::chain(static_cast<int>(axes.size()) + 1, JointType::kRevolute, limit,
                     [&](int i, Link&, Joint& joint) {
                       if (i == 0) return;
                       joint.X_PJ = frames[at(i - 1)].inverse() * frames[at(i)];
                       joint.axis = frames[at(i)].rotation.transpose() * axes[at(i - 1)].direction;
                     }));
}

enum class Arm { kFirstTwoMeet, kNextTwoMeet, kParallel, kThreeParallel, kNone };

/// Axes of an arm of this kind. Plain arms have right angles, so that angles of 0 are singular.
std::vector<Axis> axesOf(Random& random, Arm arm, bool plain) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const auto turned = [&](const Vector3d& v) {
    return plain ? v : Vector3d((v + random.vector(0.5)).normalized());
  };
  std::vector<Axis> axes(6);
  for (int i = 0; i < 6; ++i)
    axes[at(i)] = {turned(i == 0 || i == 3 || i == 5 ? z : y),
                   0.25 * i * z + (plain ? Vector3d(0.1 * x) : random.vector(0.2))};
  if (arm == Arm::kNone) return axes;
  if (arm == Arm::kThreeParallel) {
    axes[2].direction = axes[1].direction;
    axes[3].direction = -axes[1].direction;
    axes[5].point = axes[4].point;
    if (plain) {
      axes[4] = {z, axes[3].point};
      axes[5] = {y, axes[3].point};
    }
    return axes;
  }
  axes[4].point = axes[5].point = axes[3].point;
  if (arm == Arm::kFirstTwoMeet) axes[1].point = axes[0].point;
  if (arm == Arm::kParallel) axes[2].direction = axes[1].direction;
  if (arm == Arm::kNextTwoMeet) {
    axes[2].point = axes[1].point;
    if (plain) axes[2].direction = x, axes[0].point.setZero();
  }
  return axes;
}

Pose placed(const Model& model, const std::vector<double>& q) {
  std::vector<Pose> X_WL(model.links.size());
  forwardKinematics(model, q, X_WL);
  return X_WL.back();
}

std::vector<PoseRegion> regionOf(const Model& model, const Pose& X_WF) {
  return {PoseRegion::exact(static_cast<int>(model.links.size()) - 1, {}, {}, X_WF)};
}

double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::fabs(std::remainder(a[i] - b[i], 2 * kPi)));
  return most;
}

bool isListed(const std::vector<IkSolution>& list, const std::vector<double>& q, double within) {
  return std::any_of(list.begin(), list.end(),
                     [&](const IkSolution& s) { return apart(s.values, q) < within; });
}

/// The least singular value of the Jacobian, by differences.
double leastSingular(const Model& model, const std::vector<double>& q) {
  Eigen::MatrixXd J(6, static_cast<Eigen::Index>(q.size()));
  const Pose X = placed(model, q);
  for (std::size_t i = 0; i < q.size(); ++i) {
    std::vector<double> moved = q;
    moved[i] += 1e-6;
    const Pose Y = placed(model, moved);
    const auto c = static_cast<Eigen::Index>(i);
    J.block<3, 1>(0, c) = (Y.translation - X.translation) * 1e6;
    const Eigen::AngleAxisd turn(Y.rotation * X.rotation.transpose());
    J.block<3, 1>(3, c) = turn.angle() * turn.axis() * 1e6;
  }
  return Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues().minCoeff();
}

/// Whether a curve of solutions leads from q to a listed one: along it, some joint takes the angle
/// of the listed one.
bool leadsToListed(const std::shared_ptr<const Model>& model,
                   const std::vector<PoseRegion>& regions, const std::vector<IkSolution>& list,
                   const std::vector<double>& q) {
  for (const IkSolution& other : list)
    for (int joint = 0; joint < static_cast<int>(q.size()); ++joint) {
      std::vector<int> others = allVariables(*model);
      others.erase(others.begin() + joint);
      std::vector<double> start = q;
      start[at(joint)] = other.values[at(joint)];
      IkOptions options;
      options.starts = 1;
      options.prove = false;
      const IkResult result = InverseKinematics(model, others).solve(regions, start, options);
      if (result.solutions.empty()) continue;
      std::vector<double> found = result.solutions[0].values;
      found.insert(found.begin() + joint, other.values[at(joint)]);
      if (apart(found, other.values) < 1e-3) return true;
    }
  return false;
}

struct Counts {
  int poses = 0, found = 0, numeric = 0, singular = 0, complete = 0;
};

/// Slow twin: the numeric solver, from many starts, finds no branch that is not listed.
void compare(const std::shared_ptr<const Model>& model, const std::vector<double>& q,
             const std::vector<double>& from, Counts& counts) {
  const InverseKinematics ik(model, allVariables(*model));
  const std::vector<PoseRegion> regions = regionOf(*model, placed(*model, q));
  IkOptions options;
  options.max_solutions = 64;
  options.starts = isBrief() ? 10 : 60;
  options.prove = false;
  const IkResult closed = ik.solve(regions, from, options);
  ASSERT_EQ(closed.status, IkStatus::kFound);
  for (const IkSolution& solution : closed.solutions) {
    const PoseError error = poseError(regions[0], placed(*model, solution.values));
    EXPECT_LE(error.position, 1e-9);
    EXPECT_LE(error.angle, 1e-9);
    for (std::size_t i = 0; i < q.size(); ++i) {
      EXPECT_GE(solution.values[i], model->variables[i].lower);
      EXPECT_LE(solution.values[i], model->variables[i].upper);
    }
  }
  options.closed_form = false;
  options.starts = isBrief() ? 15 : 150;
  options.seed = 77;
  const IkResult numeric = ik.solve(regions, from, options);
  ++counts.poses;
  counts.complete += closed.starts == 1 ? 1 : 0;
  counts.found += static_cast<int>(closed.solutions.size());
  counts.numeric += static_cast<int>(numeric.solutions.size());
  std::vector<IkSolution> known = numeric.solutions;
  known.push_back({q, {}});
  for (const IkSolution& solution : known) {
    if (isListed(closed.solutions, solution.values, 1e-4)) continue;
    ++counts.singular;
    EXPECT_LT(leastSingular(*model, solution.values), 1e-3);
    EXPECT_TRUE(isListed(closed.solutions, solution.values, 2e-3) ||
                leadsToListed(model, regions, closed.solutions, solution.values));
  }
}

std::string nameOf(Arm arm) {
  static const char* const kNames[] = {"wrist, first two meet", "wrist, next two meet",
                                       "wrist, parallel", "three parallel", "none"};
  return kNames[static_cast<int>(arm)];
}

ClosedForm closedFormOf(const Model& model) {
  std::vector<Pose> X_WL(model.links.size());
  forwardKinematics(model, model.defaultConfiguration(), X_WL);
  return ClosedForm(makeChain(model, regionOf(model, Pose())[0], X_WL, allVariables(model)));
}

TEST(ClosedForm, HasAllBranchesOfRandomAndSingularPoses) {
  Random random(31);
  for (const Arm arm : {Arm::kFirstTwoMeet, Arm::kNextTwoMeet, Arm::kParallel, Arm::kThreeParallel})
    for (const bool backwards : {false, true})
      for (const bool plain : {false, true}) {
        SCOPED_TRACE(nameOf(arm) + (backwards ? ", from the hand" : "") + (plain ? ", plain" : ""));
        Counts counts;
        for (int i = 0; i < (kSanitized ? 2 : 3); ++i) {
          std::vector<Axis> axes = axesOf(random, arm, plain);
          if (backwards) std::reverse(axes.begin(), axes.end());
          const auto model = armOf(random, axes, i == 0 ? 2 : kPi);
          ASSERT_TRUE(closedFormOf(*model).exists());
          for (int pose = 0; pose < (plain ? 6 : 2); ++pose) {
            std::vector<double> q = testing::randomConfiguration(random, *model);
            const std::vector<double> from = testing::randomConfiguration(random, *model);
            if (plain && pose > 0) q[at(pose)] = 0;  // arms stretched, or axes along each other
            compare(model, q, from, counts);
          }
        }
        EXPECT_GT(counts.complete, 2) << "of " << counts.poses;
        EXPECT_GT(counts.found, counts.poses);
        EXPECT_TRUE(!plain || counts.singular > 0);
      }
}

struct NamedArm {
  std::string urdf, link;
  int given;
};

/// arm6 and arm7, and the arms in ../shared/data.
void compareArm(const NamedArm& arm) {
  SCOPED_TRACE(arm.urdf);
  const auto model = loadModel(arm.urdf, "");
  const int link = model->findLink(arm.link);
  std::vector<int> variables;
  for (int l = link; l >= 0; l = model->joints[at(l)].parent_link)
    if (model->joints[at(l)].first_variable >= 0)
      variables.push_back(model->joints[at(l)].first_variable);
  std::reverse(variables.begin(), variables.end());
  const InverseKinematics ik(model, variables);
  Random random(32);
  std::vector<Pose> X_WL(model->links.size());
  std::size_t branches = 0;
  const int poses = isBrief() ? 6 : 30;
  for (int i = 0; i < poses; ++i) {
    const auto q = testing::randomConfiguration(random, *model);
    forwardKinematics(*model, q, X_WL);
    const std::vector<PoseRegion> regions = {PoseRegion::exact(link, {}, {}, X_WL[at(link)])};
    IkOptions options;
    options.max_solutions = 64;
    options.prove = false;
    const IkResult closed = ik.solve(regions, q, options);
    ASSERT_EQ(closed.status, IkStatus::kFound);
    std::vector<double> own;
    for (const int v : variables) own.push_back(q[at(v)]);
    EXPECT_LT(apart(closed.solutions[0].values, own), 1e-6) << "the nearest first";
    branches += closed.solutions.size();
    if (arm.given >= 0) continue;
    options.closed_form = false;
    for (const IkSolution& solution : ik.solve(regions, q, options).solutions)
      EXPECT_TRUE(isListed(closed.solutions, solution.values, 1e-4)) << i;
  }
  EXPECT_GT(30 * branches, static_cast<std::size_t>(poses) * (arm.given >= 0 ? 1000 : 150));
  const PoseRegion region = PoseRegion::exact(link, {}, {}, X_WL[at(link)]);
  std::vector<int> column(model->variables.size(), -1);
  for (std::size_t c = 0; c < variables.size(); ++c) column[at(variables[c])] = static_cast<int>(c);
  const ClosedForm form(makeChain(*model, region, X_WL, column));
  EXPECT_TRUE(form.exists());
  EXPECT_EQ(form.given(), arm.given);
}

TEST(ClosedForm, HasAllBranchesOfShippedArms) {
  compareArm({sourceFolder() + "/robots/arm6/arm6.urdf", "tool", -1});
  compareArm({sourceFolder() + "/robots/arm7/arm7.urdf", "hand", 4});
}

TEST(ClosedForm, HasAllBranchesOfArmsOfTheData) {
  const std::string folder = dataFolder() + "/robots/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "without " << folder;
  compareArm({folder + "ur5/ur5.urdf", "ee_link", -1});
  compareArm({folder + "panda/panda.urdf", "panda_hand", 6});
}

// With its own angle given, each configuration of seven joints is among the solutions.
TEST(ClosedForm, SevenJointsWithOneGiven) {
  Random random(33);
  for (const Arm arm : {Arm::kFirstTwoMeet, Arm::kNextTwoMeet, Arm::kParallel, Arm::kThreeParallel})
    for (int place = 0; place < 2; ++place) {
      SCOPED_TRACE(nameOf(arm) + (place == 0 ? ", before" : ", after"));
      std::vector<Axis> axes = axesOf(random, arm, false);
      const Axis seventh = {random.direction(), random.vector(0.5)};
      axes.insert(place == 0 ? axes.begin() : axes.end(), seventh);
      const auto model = armOf(random, axes, kPi);
      const ClosedForm form = closedFormOf(*model);
      ASSERT_EQ(form.given(), place == 0 ? 0 : 6);
      for (int i = 0; i < 200; ++i) {
        const auto q = testing::randomConfiguration(random, *model);
        std::array<double, 7> angles;
        std::copy(q.begin(), q.end(), angles.begin());
        ClosedForm::Answer answer;
        form.solve(placed(*model, q), angles, answer);
        double nearest = 10;
        for (int k = 0; k < answer.count; ++k) {
          const std::vector<double> found(answer.angles[at(k)].begin(), answer.angles[at(k)].end());
          nearest = std::min(nearest, apart(found, q));
          const Pose X = placed(*model, found);
          EXPECT_LT((X.rotation - placed(*model, q).rotation).norm(), answer.singular ? 1 : 1e-7);
        }
        EXPECT_LT(nearest, answer.singular ? 1e-2 : 1e-6) << i;
      }
    }
}

TEST(ClosedForm, OnlyWhereTheGeometryAllowsIt) {
  Random random(34);
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(closedFormOf(*armOf(random, axesOf(random, Arm::kNone, false), 3)).exists());
    std::vector<Axis> axes = axesOf(random, Arm::kParallel, false);
    ASSERT_TRUE(closedFormOf(*armOf(random, axes, 3)).exists());
    axes[4].point += 1e-5 * axes[4].direction.cross(axes[3].direction).normalized();
    EXPECT_FALSE(closedFormOf(*armOf(random, axes, 3)).exists());
    axes = axesOf(random, Arm::kThreeParallel, false);
    axes[2].direction = (axes[2].direction + random.vector(1e-5)).normalized();
    EXPECT_FALSE(closedFormOf(*armOf(random, axes, 3)).exists());
  }
}

TEST(Subproblems, GiveWhatTheyAreAskedFor) {
  Random random(35);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d k = random.direction(), other = random.direction(), p = random.vector(1),
                   h = random.direction();
    const double angle = random.uniform(-kPi, kPi), second = random.uniform(-kPi, kPi);
    const Vector3d q = Eigen::AngleAxisd(angle, k) * p;
    EXPECT_NEAR(std::remainder(angleBetween(k, p, q, 9).value[0] - angle, 2 * kPi), 0, 1e-9);
    EXPECT_LT((turnAbout(k, angle) * p - q).norm(), 1e-14);
    const auto has = [&](const Angles& angles) {
      double nearest = 10;
      for (int j = 0; j < angles.count; ++j)
        nearest =
            std::min(nearest, std::fabs(std::remainder(angles.value[at(j)] - angle, 2 * kPi)));
      return nearest < 1e-6 || angles.singular;
    };
    EXPECT_TRUE(has(anglesToPlane(h, k, p, h.dot(q), 9)));
    const Vector3d to = random.vector(1);
    EXPECT_TRUE(has(anglesToDistance(k, p, to, (q - to).norm(), 9)));
    EXPECT_EQ(anglesToPlane(h, k, p, 3, 9).count, 0);
    const Vector3d p2 = Eigen::AngleAxisd(-second, other) * q;
    const MeetingPoints points = meetingPoints(k, p, other, p2);
    double nearest = 10;
    for (int j = 0; j < points.count; ++j) {
      EXPECT_NEAR(k.dot(points.point[at(j)]), k.dot(p), 1e-9);
      EXPECT_NEAR(other.dot(points.point[at(j)]), other.dot(p2), 1e-9);
      nearest = std::min(nearest, (points.point[at(j)] - q).norm());
    }
    EXPECT_LT(nearest, 1e-4);
  }
  const Vector3d z = Vector3d::UnitZ();
  EXPECT_TRUE(angleBetween(z, 2 * z, Vector3d::UnitX(), 0.5).singular);
  EXPECT_EQ(anglesToPlane(z, z, Vector3d::UnitX(), 0, 0.5).value[0], 0.5);
  EXPECT_EQ(anglesToPlane(z, z, Vector3d::UnitX(), 0.1, 0.5).count, 0);
  EXPECT_EQ(meetingPoints(z, z, Vector3d::UnitX(), Vector3d::UnitX()).count, 0);
}

}  // namespace
}  // namespace leeway::robots
