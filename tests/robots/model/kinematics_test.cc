#include "leeway/robots/kinematics.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

using Real = long double;

/// Slow twin: homogeneous matrices in long double, the C library's sine and cosine, directly from
/// the Joint structs.
struct Frame {
  std::array<std::array<Real, 4>, 4> m{};
  static Frame identity() {
    Frame f;
    for (std::size_t i = 0; i < 4; ++i) f.m[i][i] = 1;
    return f;
  }
};

Frame operator*(const Frame& a, const Frame& b) {
  Frame c;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) c.m[i][j] += a.m[i][k] * b.m[k][j];
  return c;
}

Frame translation(Real x, Real y, Real z) {
  Frame f = Frame::identity();
  f.m[0][3] = x;
  f.m[1][3] = y;
  f.m[2][3] = z;
  return f;
}

/// From the quaternion (sin(angle/2) axis, cos(angle/2)): independent of the product's formula.
Frame fromQuaternion(Real x, Real y, Real z, Real w) {
  const Real n = std::sqrt(x * x + y * y + z * z + w * w);
  x /= n, y /= n, z /= n, w /= n;
  Frame f = Frame::identity();
  f.m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 0};
  f.m[1] = {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 0};
  f.m[2] = {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), 0};
  return f;
}

Frame turn(const Eigen::Vector3d& axis, Real angle) {
  const Real s = std::sin(angle / 2);
  return fromQuaternion(s * static_cast<Real>(axis.x()), s * static_cast<Real>(axis.y()),
                        s * static_cast<Real>(axis.z()), std::cos(angle / 2));
}

Frame fromPose(const Pose& X) {
  Frame f = translation(static_cast<Real>(X.translation.x()), static_cast<Real>(X.translation.y()),
                        static_cast<Real>(X.translation.z()));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      f.m[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
          static_cast<Real>(X.rotation(i, j));
  return f;
}

Frame motion(const Model& model, const Joint& joint, const std::vector<double>& q) {
  const auto value = [&](int i) { return static_cast<Real>(q[static_cast<std::size_t>(i)]); };
  const Eigen::Vector3d& a = joint.axis;
  Real position = 0;
  if (joint.mimic >= 0)
    position = static_cast<Real>(joint.multiplier) *
                   value(model.joints[static_cast<std::size_t>(joint.mimic)].first_variable) +
               static_cast<Real>(joint.offset);
  else if (joint.variable_count == 1)
    position = value(joint.first_variable);
  const int first = joint.first_variable;
  switch (joint.type) {
    case JointType::kFixed:
      return Frame::identity();
    case JointType::kRevolute:
    case JointType::kContinuous:
      return turn(a, position);
    case JointType::kPrismatic:
      return translation(position * static_cast<Real>(a.x()), position * static_cast<Real>(a.y()),
                         position * static_cast<Real>(a.z()));
    case JointType::kPlanar: {
      Eigen::Vector3d u, v;
      planeAxes(a, u, v);
      const Eigen::Vector3d t =
          u * q[static_cast<std::size_t>(first)] + v * q[static_cast<std::size_t>(first) + 1];
      return translation(static_cast<Real>(t.x()), static_cast<Real>(t.y()),
                         static_cast<Real>(t.z())) *
             turn(a, value(first + 2));
    }
    case JointType::kFloating:
      return translation(value(first), value(first + 1), value(first + 2)) *
             fromQuaternion(value(first + 3), value(first + 4), value(first + 5), value(first + 6));
  }
  return Frame::identity();
}

std::vector<Frame> slowKinematics(const Model& model, const std::vector<double>& q) {
  std::vector<Frame> X_WL;
  for (const Joint& joint : model.joints) {
    const Frame above = joint.parent_link < 0 ? Frame::identity()
                                              : X_WL[static_cast<std::size_t>(joint.parent_link)];
    X_WL.push_back(above * fromPose(joint.X_PJ) * motion(model, joint, q));
  }
  return X_WL;
}

std::vector<double> randomConfiguration(const Model& model, std::mt19937_64& random) {
  std::vector<double> q;
  for (const Variable& v : model.variables)
    q.push_back(std::uniform_real_distribution<double>(std::max(v.lower, -5.0),
                                                       std::min(v.upper, 5.0))(random));
  return q;
}

/// Compares all links at `count` random configurations; returns the largest error of a point within
/// `reach`, relative to the bound.
double compare(const Model& model, int count, double reach) {
  std::mt19937_64 random(7);
  std::vector<Pose> X_WL(model.links.size());
  const double bound = kinematicsRounding(model, reach);
  double worst = 0;
  for (int n = 0; n < count; ++n) {
    const std::vector<double> q = randomConfiguration(model, random);
    forwardKinematics(model, q, X_WL);
    const std::vector<Frame> exact = slowKinematics(model, q);
    for (std::size_t l = 0; l < X_WL.size(); ++l) {
      // Corners of a cube about the world's origin as points of the link: X_WL^-1 w has the same
      // position in both.
      for (int corner = 0; corner < 8; ++corner) {
        const double d = reach / std::sqrt(3.0);
        const Eigen::Vector3d w((corner & 1) != 0 ? d : -d, (corner & 2) != 0 ? d : -d,
                                (corner & 4) != 0 ? d : -d);
        const Eigen::Vector3d p = X_WL[l].inverse() * w;
        Real squared = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          Real fast = static_cast<Real>(X_WL[l].translation(static_cast<int>(i))),
               slow = exact[l].m[i][3];
          for (std::size_t k = 0; k < 3; ++k) {
            fast += static_cast<Real>(X_WL[l].rotation(static_cast<int>(i), static_cast<int>(k))) *
                    static_cast<Real>(p(static_cast<int>(k)));
            slow += exact[l].m[i][k] * static_cast<Real>(p(static_cast<int>(k)));
          }
          squared += (fast - slow) * (fast - slow);
        }
        worst = std::max(worst, static_cast<double>(std::sqrt(squared)) / bound);
      }
    }
  }
  EXPECT_LE(worst, 1.0);
  EXPECT_GT(worst, 1e-4) << "the bound is far from what happens";
  return worst;
}

constexpr const char* kAllJoints = R"(<robot name="all_joints">
  <link name="a"/> <link name="b"/> <link name="c"/> <link name="d"/> <link name="e"/> <link name="f"/> <link name="g"/> <link name="h"/>
  <joint name="turn" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"/>
    <axis xyz="1 2 -3"/><limit lower="-2" upper="1.5" effort="1" velocity="2"/></joint>
  <joint name="wheel" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0 0.3 0" rpy="1.5707963 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="slide" type="prismatic"><parent link="c"/><child link="d"/><origin rpy="0.1 0.2 0.3"/><axis xyz="0 1 1"/>
    <limit lower="-0.5" upper="0.25" effort="1" velocity="2"/></joint>
  <joint name="plane" type="planar"><parent link="d"/><child link="e"/><origin xyz="0.3 0 0"/><axis xyz="1 1 1"/></joint>
  <joint name="fly" type="floating"><parent link="e"/><child link="f"/><origin xyz="0 0 0.2" rpy="0 1 0"/></joint>
  <joint name="follow" type="revolute"><parent link="f"/><child link="g"/><axis xyz="0 1 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="2"/><mimic joint="turn" multiplier="-2" offset="0.25"/></joint>
  <joint name="follow_slide" type="prismatic"><parent link="a"/><child link="h"/><axis xyz="0 1 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="2"/><mimic joint="follow" multiplier="0.5" offset="1"/></joint>
</robot>)";

TEST(Kinematics, EveryJointTypeAgainstTheSlowTwin) {
  const Folder folder;
  const auto model = loadModel(folder.write("robot.urdf", kAllJoints), "");
  compare(*model, 2000, 1.0);
}

TEST(Kinematics, MimicChainsAreResolvedToTheJointThatMoves) {
  const Folder folder;
  const auto model = loadModel(folder.write("robot.urdf", kAllJoints), "");
  const Joint& follow = model->joints[static_cast<std::size_t>(model->findJoint("follow"))];
  const Joint& chained = model->joints[static_cast<std::size_t>(model->findJoint("follow_slide"))];
  EXPECT_EQ(follow.mimic, model->findJoint("turn"));
  EXPECT_EQ(chained.mimic, model->findJoint("turn"));
  EXPECT_EQ(chained.variable_count, 0);
  EXPECT_DOUBLE_EQ(chained.multiplier, -1);  // 0.5 (-2 q + 0.25) + 1
  EXPECT_DOUBLE_EQ(chained.offset, 1.125);
  EXPECT_EQ(model->variables.size(), 3u + 3u + 7u);
}

/// So their master may turn without end, and no product of 0 and infinity is taken.
TEST(Kinematics, MimicsOfMultiplierZeroStandStill) {
  const Folder folder;
  const auto model = loadModel(folder.write("robot.urdf", R"(<robot name="r">
  <link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <joint name="turn" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
  <joint name="still" type="prismatic"><parent link="a"/><child link="c"/><axis xyz="2 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="2"/><mimic joint="turn" multiplier="0" offset="0.5"/></joint>
  <joint name="chained" type="revolute"><parent link="c"/><child link="d"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="1" velocity="2"/><mimic joint="still" multiplier="4" offset="1"/></joint>
</robot>)"),
                               "");
  ASSERT_EQ(model->variables.size(), 1u);
  for (const char* name : {"still", "chained"})
    EXPECT_EQ(model->joints[static_cast<std::size_t>(model->findJoint(name))].type,
              JointType::kFixed);
  std::vector<Pose> X_WL(model->links.size());
  forwardKinematics(*model, std::vector<double>{1}, X_WL);
  const Pose& X = X_WL[static_cast<std::size_t>(model->findLink("d"))];
  EXPECT_EQ(X.translation, Eigen::Vector3d(0.5, 0, 0));
  EXPECT_NEAR(X.rotation(1, 0), std::sin(3), 1e-15);
  ASSERT_FALSE(model->warnings.empty());
  EXPECT_NE(model->warnings[0].find("robot.urdf:7: joint \"chained\""), std::string::npos)
      << model->warnings[0];
}

TEST(Kinematics, PlaneAxesAreRightHandedForEveryNormal) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d n(normal(random), normal(random), normal(random));
    if (i < 6) n = (i % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(i / 2);
    if (i >= 6 && i < 30) n.head<2>() *= std::pow(10.0, -i / 2.0), n.z() = -1;
    n /= n.norm();
    Eigen::Vector3d u, v;
    planeAxes(n, u, v);
    Eigen::Matrix3d R;
    R << u, v, n;
    EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-14) << n.transpose();
    EXPECT_GT(R.determinant(), 0) << n.transpose();
  }
  Eigen::Vector3d u, v;
  planeAxes(Eigen::Vector3d::UnitZ(), u, v);
  EXPECT_EQ(u, Eigen::Vector3d::UnitX());
  EXPECT_EQ(v, Eigen::Vector3d::UnitY());
}

TEST(Kinematics, BatchIsTheSameToTheBit) {
  const Folder folder;
  const auto model = loadModel(folder.write("robot.urdf", kAllJoints), "");
  std::mt19937_64 random(8);
  const std::size_t links = model->links.size();
  for (int count : {0, 1, 2, 3, 4, 5, 8, 17}) {
    std::vector<double> rows;
    for (int i = 0; i < count; ++i)
      for (double value : randomConfiguration(*model, random)) rows.push_back(value);
    std::vector<Pose> batch(links * static_cast<std::size_t>(count)), single(links);
    forwardKinematicsBatch(*model, rows, count, batch);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      forwardKinematics(
          *model, std::span(rows).subspan(i * model->variables.size(), model->variables.size()),
          single);
      for (std::size_t l = 0; l < links; ++l) {
        ASSERT_EQ(std::memcmp(single[l].rotation.data(), batch[i * links + l].rotation.data(),
                              sizeof(double) * 9),
                  0);
        ASSERT_EQ(std::memcmp(single[l].translation.data(), batch[i * links + l].translation.data(),
                              sizeof(double) * 3),
                  0);
      }
    }
  }
}

TEST(Kinematics, AChainIsTheSameToTheBitAndNothingElseMoves) {
  const Folder folder;
  const auto model = loadModel(folder.write("robot.urdf", kAllJoints), "");
  const auto count = static_cast<int>(model->links.size());
  std::mt19937_64 random(9);
  const auto bytesOf = [](const Pose& X) {
    std::array<double, 12> all{};
    std::copy_n(X.rotation.data(), 9, all.begin());
    std::copy_n(X.translation.data(), 3, all.begin() + 9);
    return all;
  };
  std::vector<int> chain;
  findChain(*model, std::array{-1, -1}, chain);
  EXPECT_TRUE(chain.empty());
  for (int a = -1; a < count; ++a)
    for (int b = 0; b < count; ++b) {
      findChain(*model, std::array{a, b}, chain);
      ASSERT_TRUE(std::is_sorted(chain.begin(), chain.end()));
      const std::vector<double> q = randomConfiguration(*model, random),
                                other = randomConfiguration(*model, random);
      std::vector<Pose> all(model->links.size()), some(model->links.size()), untouched;
      forwardKinematics(*model, q, all);
      forwardKinematics(*model, other, some);
      untouched = some;
      chainKinematics(*model, q, chain, some);
      for (int l = 0; l < count; ++l) {
        const auto i = static_cast<std::size_t>(l);
        const bool is_in = std::binary_search(chain.begin(), chain.end(), l);
        EXPECT_TRUE(is_in || (l != a && l != b));
        if (is_in && model->steps[i].parent_link >= 0) {
          EXPECT_TRUE(std::binary_search(chain.begin(), chain.end(), model->steps[i].parent_link));
        }
        EXPECT_EQ(bytesOf(some[i]), bytesOf(is_in ? all[i] : untouched[i]));
      }
    }
}

TEST(Kinematics, FreeBodyHoldsBoundsAndMoves) {
  const auto body = freeBody("piano", {{collision::Shape::sphere(0.5), {}, ""}}, JointType::kPlanar,
                             {-1, -2, 0}, {3, 4, 0});
  ASSERT_EQ(body->variables.size(), 3u);
  EXPECT_EQ(body->variables[0].name, "piano/x");
  EXPECT_EQ(body->variables[2].name, "piano/theta");
  EXPECT_EQ(body->variables[1].lower, -2);
  EXPECT_EQ(body->variables[1].upper, 4);
  EXPECT_FALSE(body->variables[2].lower > -1e300);
  EXPECT_EQ(body->groups.back().name, "all");
  std::vector<Pose> X(1);
  forwardKinematics(*body, std::array{1.0, 2.0, 0.5}, X);
  EXPECT_EQ(X[0].translation, Eigen::Vector3d(1, 2, 0));
  EXPECT_NEAR(X[0].rotation(1, 0), std::sin(0.5), 1e-16);
  const auto flier = freeBody("flier", {}, JointType::kFloating, {0.5, -1, -1}, {1, 1, 1});
  EXPECT_EQ(flier->defaultConfiguration(), (std::vector<double>{0.5, 0, 0, 0, 0, 0, 1}));
  compare(*flier, 500, 1.0);
}

TEST(Kinematics, RealArmsAgainstTheSlowTwin) {
  for (const std::string arm : {"panda", "ur5"}) {
    LEEWAY_NEEDS_DATA("robots/" + arm);
    const std::string file = dataFolder() + "/robots/" + arm + "/" + arm;
    const auto model = loadModel(file + ".urdf", file + ".srdf");
    compare(*model, 500, 2.0);
    EXPECT_LT(kinematicsRounding(*model, 2.0), 1e-11) << arm;
  }
}

}  // namespace
}  // namespace leeway::robots
