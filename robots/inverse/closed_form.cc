#include "robots/inverse/closed_form.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "collision/base/numbers.h"
#include "robots/base/tolerances.h"
#include "robots/inverse/subproblems.h"

namespace leeway::robots {

namespace {

/// Candidates for the given one of seven joints, in order of preference. An arm that other joints
/// can swing around misses the fewest poses with any angle of joint 5, then of joint 3.
constexpr int kGivenOrder[] = {4, 2, 6, 0, 5, 1, 3};

/// A unit vector perpendicular to a unit vector.
Eigen::Vector3d acrossOf(const Eigen::Vector3d& unit) {
  int least;
  unit.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d across = unit.cross(Eigen::Vector3d::Unit(least));
  return across / std::sqrt(across.squaredNorm());
}

/// The part of v perpendicular to the unit vector k.
Eigen::Vector3d across(const Eigen::Vector3d& k, const Eigen::Vector3d& v) {
  return v - k.dot(v) * k;
}

}  // namespace

/// Six joints in the order in which they are solved: E1 E2 ... E6 = G, where Ei turns about axis i
/// and G moves F from its place at angle 0 to its target.
struct ClosedForm::Arm {
  std::array<Axis, 6> axes;
  Pose G;
  std::array<double, 6> otherwise;  ///< angles to use where any angle solves
  std::array<std::size_t, 6> joints;

  const Eigen::Vector3d& h(int i) const { return axes[at(i)].direction; }
  const Eigen::Vector3d& p(int i) const { return axes[at(i)].point; }
  /// The point x, turned about axis i by R.
  Eigen::Vector3d turned(int i, const Eigen::Matrix3d& R, const Eigen::Vector3d& x) const {
    return p(i) + R * (x - p(i));
  }
  void add(Answer& answer, const std::array<double, 6>& angles) const {
    if (answer.count == static_cast<int>(answer.angles.size())) return;
    auto& next = answer.angles[at(answer.count++)];
    for (std::size_t i = 0; i < 6; ++i) next[joints[i]] = angles[i];
  }
};

namespace {

template <typename AxisType>
bool areParallel(const AxisType& a, const AxisType& b) {
  return a.direction.cross(b.direction).squaredNorm() < kSameAxis * kSameAxis;
}

/// The meeting point of two axes: the middle between their nearest points.
template <typename AxisType>
Eigen::Vector3d meetingPoint(const AxisType& a, const AxisType& b) {
  const Eigen::Vector3d w = b.point - a.point;
  const double c = a.direction.dot(b.direction);
  const double squared_sine = 1 - c * c, u = w.dot(a.direction), v = w.dot(b.direction);
  const Eigen::Vector3d on_a = a.point + (u - c * v) / squared_sine * a.direction;
  const Eigen::Vector3d on_b = b.point + (c * u - v) / squared_sine * b.direction;
  return (on_a + on_b) / 2;
}

template <typename AxisType>
bool doMeet(const AxisType& a, const AxisType& b) {
  const Eigen::Vector3d normal = a.direction.cross(b.direction);
  const double sine = std::sqrt(normal.squaredNorm());
  // Nearly parallel axes have a badly determined meeting point.
  return sine > kMeetingSine && std::fabs(normal.dot(b.point - a.point)) < kSameAxis * sine;
}

}  // namespace

ClosedForm::ClosedForm(const Chain& chain) {
  const std::size_t count = chain.joints.size();
  if (count != 6 && count != 7) return;
  Pose X;
  for (const ChainJoint& joint : chain.joints) {
    if ((joint.type != JointType::kRevolute && joint.type != JointType::kContinuous) ||
        joint.multiplier != 1)
      return;
    for (const ChainJoint& other : chain.joints)
      if (&other != &joint && other.column[0] == joint.column[0]) return;
    X.translation += X.rotation * joint.translation;
    X.rotation = (X.rotation * (joint.fixed + joint.cosine)).eval();
    axes_.push_back({X.rotation * joint.axis, X.translation});
  }
  X_RF0_inverse_ = (X * chain.X_PF).inverse();
  for (const int given : kGivenOrder) {
    given_ = count == 7 ? given : -1;
    int next = 0;
    for (int& joint : joints_) {
      if (next == given_) ++next;
      joint = next++;
    }
    for (int direction = 0; direction < 2; ++direction) {
      kind_ = kindOf(axes_, joints_);
      if (kind_ != Kind::kNone) return;
      std::reverse(joints_.begin(), joints_.end());
    }
    if (count == 6) return;
  }
}

/// Examines only neighbours in the chain, whose relative placement does not depend on any angle.
ClosedForm::Kind ClosedForm::kindOf(const std::vector<Axis>& axes,
                                    const std::array<int, 6>& joints) {
  const auto axis = [&](int i) -> const Axis& { return axes[at(joints[at(i)])]; };
  const auto areNeighbours = [&](int i) {
    return std::abs(joints[at(i + 1)] - joints[at(i)]) == 1;
  };
  const auto meet = [&](int i) { return areNeighbours(i) && doMeet(axis(i), axis(i + 1)); };
  const auto parallel = [&](int i) {
    return areNeighbours(i) && areParallel(axis(i), axis(i + 1));
  };
  if (meet(4) && parallel(1) && parallel(2)) return Kind::kThreeParallel;
  if (!meet(3) || !meet(4)) return Kind::kNone;
  const Eigen::Vector3d between = meetingPoint(axis(3), axis(4)) - meetingPoint(axis(4), axis(5));
  if (!(between.squaredNorm() < kSameAxis * kSameAxis)) return Kind::kNone;
  if (meet(0)) return Kind::kWristFirstTwoMeet;
  if (meet(1)) return Kind::kWristNextTwoMeet;
  return parallel(1) ? Kind::kWristParallel : Kind::kNone;
}

/// Joints 1 to 3 bring the wrist's centre to its target; joints 4 to 6 turn the hand about it.
class ClosedForm::WristSolver {
 public:
  WristSolver(const Arm& arm, Answer& answer)
      : arm_(arm),
        answer_(answer),
        wrist_(meetingPoint(arm.axes[4], arm.axes[5])),
        target_(arm.G * wrist_),
        roll_(acrossOf(arm.h(5))),
        t_(arm.otherwise) {}

  /// At O: |E3 wrist - O| = |target - O|.
  void firstTwoMeet() {
    const Eigen::Vector3d O = meetingPoint(arm_.axes[0], arm_.axes[1]);
    const Eigen::Vector3d to = target_ - O;
    const Angles elbows = anglesToDistance(arm_.h(2), wrist_ - arm_.p(2), O - arm_.p(2),
                                           std::sqrt(to.squaredNorm()), arm_.otherwise[2]);
    note(elbows);
    for (int i = 0; i < elbows.count; ++i) {
      t_[2] = elbows.value[at(i)];
      const Eigen::Matrix3d R3 = turnAbout(arm_.h(2), t_[2]);
      const Eigen::Vector3d from = arm_.turned(2, R3, wrist_) - O;
      const MeetingPoints points = meetingPoints(arm_.h(0), to, arm_.h(1), from);
      note(points);
      for (int j = 0; j < points.count; ++j) {
        const Angles first = angleBetween(arm_.h(0), points.point[at(j)], to, arm_.otherwise[0]);
        note(first);
        t_[0] = first.value[0];
        turnHand(turnAbout(arm_.h(0), t_[0]), R3,
                 angleBetween(arm_.h(1), from, points.point[at(j)], arm_.otherwise[1]));
      }
    }
  }

  /// E2 E3 wrist = E1^-1 target: both are at the same distance from O, where the axes of E2 and E3
  /// meet.
  void nextTwoMeet() {
    const Eigen::Vector3d O = meetingPoint(arm_.axes[1], arm_.axes[2]);
    const Angles firsts =
        anglesToDistance(-arm_.h(0), target_ - arm_.p(0), O - arm_.p(0),
                         std::sqrt((wrist_ - O).squaredNorm()), arm_.otherwise[0]);
    note(firsts);
    for (int i = 0; i < firsts.count; ++i) {
      t_[0] = firsts.value[at(i)];
      const Eigen::Matrix3d R1 = turnAbout(arm_.h(0), t_[0]);
      const Eigen::Vector3d to = arm_.turned(0, R1.transpose(), target_) - O;
      const MeetingPoints points = meetingPoints(arm_.h(1), to, arm_.h(2), wrist_ - O);
      note(points);
      for (int j = 0; j < points.count; ++j) {
        const Angles third =
            angleBetween(arm_.h(2), wrist_ - O, points.point[at(j)], arm_.otherwise[2]);
        note(third);
        t_[2] = third.value[0];
        turnHand(R1, turnAbout(arm_.h(2), t_[2]),
                 angleBetween(arm_.h(1), points.point[at(j)], to, arm_.otherwise[1]));
      }
    }
  }

  /// E2 E3 wrist = E1^-1 target: as far along both axes.
  void nextTwoParallel() {
    const Eigen::Vector3d& h = arm_.h(1);
    const Eigen::Vector3d& O = arm_.p(1);
    const Angles firsts = anglesToPlane(h, -arm_.h(0), target_ - arm_.p(0),
                                        h.dot(wrist_ - arm_.p(0)), arm_.otherwise[0]);
    note(firsts);
    for (int i = 0; i < firsts.count; ++i) {
      t_[0] = firsts.value[at(i)];
      const Eigen::Matrix3d R1 = turnAbout(arm_.h(0), t_[0]);
      const Eigen::Vector3d to = arm_.turned(0, R1.transpose(), target_) - O;
      const Angles elbows =
          anglesToDistance(arm_.h(2), across(h, wrist_ - arm_.p(2)), across(h, O - arm_.p(2)),
                           std::sqrt(across(h, to).squaredNorm()), arm_.otherwise[2]);
      note(elbows);
      for (int j = 0; j < elbows.count; ++j) {
        t_[2] = elbows.value[at(j)];
        const Eigen::Matrix3d R3 = turnAbout(arm_.h(2), t_[2]);
        turnHand(R1, R3, angleBetween(h, arm_.turned(2, R3, wrist_) - O, to, arm_.otherwise[1]));
      }
    }
  }

 private:
  template <typename Part>
  void note(const Part& part) {
    answer_.singular = answer_.singular || part.singular;
  }

  /// Adds the answers for joints 1 and 3 with the values in t_, turned by R1 and R3.
  void turnHand(const Eigen::Matrix3d& R1, const Eigen::Matrix3d& R3, const Angles& second) {
    note(second);
    t_[1] = second.value[0];
    const Eigen::Matrix3d R03 = R1 * turnAbout(arm_.h(1), t_[1]) * R3;
    const Eigen::Matrix3d R36 = R03.transpose() * arm_.G.rotation;
    const Eigen::Vector3d hand = R36 * arm_.h(5);
    const Angles bends =
        anglesToPlane(arm_.h(3), arm_.h(4), arm_.h(5), arm_.h(3).dot(hand), arm_.otherwise[4]);
    note(bends);
    for (int i = 0; i < bends.count; ++i) {
      t_[4] = bends.value[at(i)];
      const Eigen::Matrix3d R5 = turnAbout(arm_.h(4), t_[4]);
      const Angles first = angleBetween(arm_.h(3), R5 * arm_.h(5), hand, arm_.otherwise[3]);
      note(first);
      t_[3] = first.value[0];
      const Eigen::Matrix3d R45 = turnAbout(arm_.h(3), t_[3]) * R5;
      t_[5] = angleBetween(arm_.h(5), roll_, R45.transpose() * (R36 * roll_), 0).value[0];
      arm_.add(answer_, t_);
    }
  }

  const Arm& arm_;
  Answer& answer_;
  const Eigen::Vector3d wrist_, target_, roll_;
  std::array<double, 6> t_;
};

void ClosedForm::solve(const Pose& X_RF, const std::array<double, 7>& angles,
                       Answer& answer) const {
  answer.count = 0;
  answer.singular = false;
  answer.angles.fill(angles);
  Arm arm;
  arm.G = X_RF * X_RF0_inverse_;
  Pose given;  // E of the given joint
  if (given_ >= 0) {
    const Axis& axis = axes_[at(given_)];
    given.rotation = turnAbout(axis.direction, angles[at(given_)]);
    given.translation = axis.point - given.rotation * axis.point;
    arm.G = arm.G * given.inverse();
  }
  const bool backwards = joints_[0] > joints_[5];
  for (int i = 0; i < 6; ++i) {
    const int joint = joints_[at(i)];
    Axis axis = axes_[at(joint)];
    if (given_ >= 0 && joint > given_) axis = {given.rotation * axis.direction, given * axis.point};
    // From hand to base the turns are inverted: the same angles about opposite axes.
    if (backwards) axis.direction = -axis.direction;
    arm.axes[at(i)] = axis;
    arm.joints[at(i)] = at(joint);
    arm.otherwise[at(i)] = angles[at(joint)];
  }
  if (backwards) arm.G = arm.G.inverse();
  switch (kind_) {
    case Kind::kNone:
      break;
    case Kind::kWristFirstTwoMeet:
      return WristSolver(arm, answer).firstTwoMeet();
    case Kind::kWristNextTwoMeet:
      return WristSolver(arm, answer).nextTwoMeet();
    case Kind::kWristParallel:
      return WristSolver(arm, answer).nextTwoParallel();
    case Kind::kThreeParallel:
      return solveParallel(arm, answer);
  }
}

void ClosedForm::solveParallel(const Arm& arm, Answer& answer) {
  const Eigen::Vector3d& h = arm.h(1);
  const Eigen::Vector3d wrist = meetingPoint(arm.axes[4], arm.axes[5]);
  const Eigen::Vector3d target = arm.G * wrist;
  const Eigen::Vector3d side = acrossOf(h);
  const double sign3 = h.dot(arm.h(2)) > 0 ? 1 : -1, sign4 = h.dot(arm.h(3)) > 0 ? 1 : -1;
  std::array<double, 6> t = arm.otherwise;
  const auto note = [&answer](const auto& part) {
    answer.singular = answer.singular || part.singular;
  };

  // Joints 2 to 4 move no point along h, and leave h unchanged.
  const Angles firsts =
      anglesToPlane(h, -arm.h(0), target - arm.p(0), h.dot(wrist - arm.p(0)), arm.otherwise[0]);
  note(firsts);
  for (int i = 0; i < firsts.count; ++i) {
    t[0] = firsts.value[at(i)];
    const Eigen::Matrix3d R1 = turnAbout(arm.h(0), t[0]);
    const Eigen::Vector3d y = arm.turned(0, R1.transpose(), target);
    const Eigen::Matrix3d R16 = R1.transpose() * arm.G.rotation;
    const Angles bends =
        anglesToPlane(h, arm.h(4), arm.h(5), h.dot(R16 * arm.h(5)), arm.otherwise[4]);
    note(bends);
    for (int j = 0; j < bends.count; ++j) {
      t[4] = bends.value[at(j)];
      const Eigen::Matrix3d R5 = turnAbout(arm.h(4), t[4]);
      const Angles last =
          angleBetween(-arm.h(5), R5.transpose() * h, R16.transpose() * h, arm.otherwise[5]);
      note(last);
      t[5] = last.value[0];
      const Eigen::Matrix3d R56 = R5 * turnAbout(arm.h(5), t[5]);
      const double sum = angleBetween(h, side, R16 * (R56.transpose() * side), 0).value[0];
      // E2 E3 moves axis 4 to s.
      const Eigen::Vector3d s = y - turnAbout(h, sum) * (wrist - arm.p(3)) - arm.p(1);
      const Angles elbows =
          anglesToDistance(arm.h(2), across(h, arm.p(3) - arm.p(2)), across(h, arm.p(1) - arm.p(2)),
                           std::sqrt(across(h, s).squaredNorm()), arm.otherwise[2]);
      note(elbows);
      for (int k = 0; k < elbows.count; ++k) {
        t[2] = elbows.value[at(k)];
        const Eigen::Vector3d from = arm.turned(2, turnAbout(arm.h(2), t[2]), arm.p(3)) - arm.p(1);
        const Angles second = angleBetween(h, from, s, arm.otherwise[1]);
        note(second);
        t[1] = second.value[0];
        t[3] = sign4 * (sum - t[1] - sign3 * t[2]);
        arm.add(answer, t);
      }
    }
  }
}

}  // namespace leeway::robots
