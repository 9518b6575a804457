// The proof that no configuration in a box has F in its region. Let c be the middle of the box, P a
// point fixed to F, and let joint j turn by at most h_j from c. Move the joints from c one after
// the other, the last first. While joints 1..j are still at c, axis j is where it is at c, so
//
//   |P moves with joints j..n|    <= m_j = m_(j+1) + 2 sin(h_j / 2) (d_j(P) + m_(j+1))
//   |the frame turns|             <= sum of h_j
//   change of |P - S| by joint j  <= 2 sin(h_j / 2) min(d_j(P) + m_(j+1), d_j(S))
//
// Here d_j(.) is the distance from axis j at c, and S is fixed to the base: turning P about axis j
// changes |P - S| as turning S does. A slide by h moves P by h. The box is excluded if one of these
// is less than the change that P, the frame, or |P - S| need at c to reach the region. If P is on
// the last axis, near the previous one, and S on the first axis, near the second, many terms
// vanish: for an arm with a spherical wrist, |P - S| depends only on the elbow. Any P and S are
// correct.
//
// The same holds for a point M of a link on the way. In the frame F it moves with the joints after
// its link by at most n, which is computed like m from that end. If F is in its region, M is where
// the region's middle rotation and M's place at c have it, up to the region's widths and n; and |M
// - S| changes only with the joints before its link. If M is on an axis, where the previous axis
// meets it, it moves with neither joint.

#include "robots/inverse/reach_proof.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "robots/base/tolerances.h"
#include "robots/inverse/region.h"

namespace leeway::robots {

namespace {

constexpr double kPi = std::numbers::pi;

bool turns(const ChainJoint& joint) {
  return joint.type == JointType::kRevolute || joint.type == JointType::kContinuous;
}

/// The point of the line (p, unit u) nearest to the line (q, unit v); p if they are parallel.
Eigen::Vector3d nearestPoint(const Eigen::Vector3d& p, const Eigen::Vector3d& u,
                             const Eigen::Vector3d& q, const Eigen::Vector3d& v) {
  const Eigen::Vector3d w = q - p;
  const double b = u.dot(v), across = 1 - b * b;
  return across > kProofParallelSquared
             ? Eigen::Vector3d(p + (w.dot(u) - b * w.dot(v)) / across * u)
             : p;
}

double distanceFromAxis(const Eigen::Vector3d& point, const Eigen::Vector3d& origin,
                        const Eigen::Vector3d& axis) {
  return std::sqrt(Eigen::Vector3d(point - origin).cross(axis).squaredNorm());
}

/// A point fixed to F, and its place for F in the region: the box of positions moved by `offset`,
/// and a ball of `radius` for the widths of the angles.
struct Target {
  Eigen::Vector3d p_F = Eigen::Vector3d::Zero(), offset = Eigen::Vector3d::Zero();
  double radius = 0;
};

/// A point on the axis of joint `joint`, in its child's frame, where the previous axis meets it.
struct MidPoint {
  std::size_t joint;
  Eigen::Vector3d p_C;
};

class Prover {
 public:
  Prover(const Chain& chain, const PoseRegion& region, std::span<const double> configuration,
         std::span<const double> lower, std::span<const double> upper)
      : chain_(chain),
        region_(region),
        q_(configuration.begin(), configuration.end()),
        lower_(lower),
        upper_(upper) {
    columns_ = lower.size();
    variable_.assign(columns_, -1);
    for (const ChainJoint& joint : chain.joints)
      for (int k = 0; k < 7; ++k)
        if (joint.column[at(k)] >= 0) variable_[at(joint.column[at(k)])] = joint.variable + k;
    low_.assign(lower.begin(), lower.end());
    high_.assign(upper.begin(), upper.end());
    for (const ChainJoint& joint : chain.joints) bound(joint);
    Eigen::Vector3d middle;
    for (int k = 0; k < 3; ++k) {
      const auto& [first, second] = region.rpy[at(k)];
      middle(k) = first + (second - first) / 2;
      half_angle_(k) = (second - first) / 2;
    }
    R_RF_ = rotationOf(middle);
    half_turn_ = half_angle_.sum();
    double size = chain.reach + chain.X_PF.translation.norm();
    for (const auto& range : region.position)
      size += std::max(std::fabs(range.first), std::fabs(range.second));
    for (const ChainJoint& joint : chain.joints) size += joint.translation.norm();
    for (std::size_t c = 0; c < columns_; ++c)
      if (variable_[c] >= 0) size += std::max(std::fabs(low_[c]), std::fabs(high_[c]));
    slack_ = kProofSlack * (1 + size);
    choosePoints();
  }

  ReachProof run(std::int64_t limit) {
    ReachProof proof;
    if (!bounded_) return proof;
    std::vector<Box> boxes(1);
    boxes[0].low = low_;
    boxes[0].high = high_;
    examine(boxes[0]);
    proof.boxes = 1;
    if (boxes[0].excluded) boxes.clear();
    while (!boxes.empty()) {
      Box box = std::move(boxes.back());
      boxes.pop_back();
      if (box.split < 0 || proof.boxes + 2 > limit) return proof;
      const std::size_t c = at(box.split);
      const double middle = box.low[c] + (box.high[c] - box.low[c]) / 2;
      if (!(middle > box.low[c] && middle < box.high[c])) return proof;
      Box other = box;
      box.high[c] = other.low[c] = middle;
      for (Box* half : {&box, &other}) examine(*half);
      proof.boxes += 2;
      // The half that is harder to exclude is on top, so that a failing proof is given up early.
      if (box.share < other.share) std::swap(box, other);
      if (!box.excluded) boxes.push_back(std::move(box));
      if (!other.excluded) boxes.push_back(std::move(other));
    }
    proof.proven = true;
    return proof;
  }

 private:
  struct Box {
    std::vector<double> low, high;  // one for each column
    bool excluded = false;
    double share = 0;  // of the best bound: the missing change divided by the change that the
                       // joints can make
    int split = -1;    // the column that changes it most; -1: no column matters
  };

  /// Unlimited angles take one turn; other unlimited variables have no bounds.
  void bound(const ChainJoint& joint) {
    for (int k = 0; k < 7; ++k) {
      const int column = joint.column[at(k)];
      if (column < 0) continue;
      double& low = low_[at(column)];
      double& high = high_[at(column)];
      const bool quaternion = joint.type == JointType::kFloating && k >= 3;
      const bool angle =
          joint.type == JointType::kContinuous || (joint.type == JointType::kPlanar && k == 2);
      if (quaternion) {
        low = -1;
        high = 1;
        continue;
      }
      if (std::isfinite(upper_[at(column)] - lower_[at(column)])) continue;
      if (angle) {
        low = -kPi * (1 + 1e-15);
        high = kPi * (1 + 1e-15);
      }
      // A whole turn of a master joint is not a whole turn of a mimic joint with another
      // multiplier.
      if (!angle || joint.multiplier != 1) bounded_ = false;
    }
  }

  void choosePoints() {
    if (chain_.joints.empty()) return;
    std::vector<double> q = q_;
    place(chain_, q.data(), X_RC_);
    const auto axisOf = [&](std::size_t i) {
      return Eigen::Vector3d(X_RC_[i].rotation * chain_.joints[i].axis);
    };
    targets_.push_back({Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 0});
    const std::size_t last = chain_.joints.size() - 1;
    if (turns(chain_.joints[last])) {
      Eigen::Vector3d p = X_RC_[last].translation;
      if (last > 0 && turns(chain_.joints[last - 1]))
        p = nearestPoint(p, axisOf(last), X_RC_[last - 1].translation, axisOf(last - 1));
      const Pose X_RF = X_RC_[last] * chain_.X_PF;
      Target target;
      target.p_F = X_RF.rotation.transpose() * (p - X_RF.translation);
      target.offset = R_RF_ * target.p_F;
      target.radius = target.p_F.norm() * std::min(2.0, half_turn_) * (1 + kBoundRounding);
      targets_.push_back(target);
    }
    if (turns(chain_.joints[0])) {
      has_base_point_ = true;
      p_RS_ = X_RC_[0].translation;
      if (last > 0 && turns(chain_.joints[1]))
        p_RS_ = nearestPoint(p_RS_, axisOf(0), X_RC_[1].translation, axisOf(1));
    }
    for (std::size_t i = 1; i < last && has_base_point_; ++i) {
      if (!turns(chain_.joints[i]) || !turns(chain_.joints[i - 1])) continue;
      const Eigen::Vector3d& before = X_RC_[i - 1].translation;
      const Eigen::Vector3d p =
          nearestPoint(X_RC_[i].translation, axisOf(i), before, axisOf(i - 1));
      if (distanceFromAxis(p, before, axisOf(i - 1)) < kProofMeet &&
          (p - p_RS_).norm() > kProofMeet)
        mid_points_.push_back({i, X_RC_[i].inverse() * p});
    }
  }

  /// A bound: the missing change at the middle of the box, how much the joints can change it, and
  /// the part of each joint.
  struct Bound {
    double lacking = 0, change = 0;
    std::vector<double> by_joint;
  };

  void consider(Box& box, double lacking, double change, double tolerance,
                const std::vector<double>& by_joint) {
    lacking -= tolerance + slack_;
    change *= 1 + kBoundRounding;
    if (!(lacking > 0)) lacking = 0;
    if (lacking > change) {
      box.excluded = true;
      return;
    }
    const double share = change > 0 ? lacking / change : 0;
    if (!(share > box.share) && box.split >= 0) return;
    if (!(change > kSmallestSpread)) return;
    double most = 0;
    int split = -1;
    for (std::size_t i = 0; i < chain_.joints.size(); ++i) {
      if (!(by_joint[i] > most)) continue;
      const int column = widest_[i];
      if (column < 0) continue;
      most = by_joint[i];
      split = column;
    }
    if (split < 0) return;
    box.share = share;
    box.split = split;
  }

  void examine(Box& box) {
    box.share = 0;
    box.split = -1;
    for (std::size_t c = 0; c < columns_; ++c)
      if (variable_[c] >= 0) q_[at(variable_[c])] = box.low[c] + (box.high[c] - box.low[c]) / 2;
    const Pose X_RF = place(chain_, q_.data(), X_RC_);
    const std::size_t count = chain_.joints.size();
    angle_.assign(count, 0);
    slide_.assign(count, 0);
    widest_.assign(count, -1);
    for (std::size_t i = 0; i < count; ++i) halfWidths(box, i);

    double turn = 0;
    for (std::size_t i = 0; i < count; ++i) turn += angle_[i];
    const Eigen::Matrix3d difference = X_RF.rotation * R_RF_.transpose();
    const double tolerance = region_.angle_tolerance;
    consider(box, rotationVector(difference).norm() - half_turn_, turn, tolerance, angle_);
    if (box.excluded) return;
    // z of R in F turns only with roll and pitch; x of F in R turns only with pitch and yaw.
    const double z = angleBetween(X_RF.rotation.row(2).transpose(), R_RF_.row(2).transpose());
    consider(box, z - half_angle_(0) - half_angle_(1), turn, tolerance, angle_);
    if (box.excluded) return;
    const double x = angleBetween(X_RF.rotation.col(0), R_RF_.col(0));
    consider(box, x - half_angle_(1) - half_angle_(2), turn, tolerance, angle_);
    if (box.excluded || count == 0) return;
    if (chain_.joints[count - 1].type != JointType::kFloating) considerLastAxis(box, X_RF, turn);
    for (const Target& target : targets_) {
      if (box.excluded) return;
      examinePoint(box, X_RF * target.p_F, target);
    }
    for (const MidPoint& point : mid_points_) {
      if (box.excluded) return;
      examineMidPoint(box, X_RF, point);
    }
  }

  void examineMidPoint(Box& box, const Pose& X_RF, const MidPoint& point) {
    const std::size_t count = chain_.joints.size();
    const Eigen::Vector3d p = X_RC_[point.joint] * point.p_C;
    changed_.assign(count, 0);
    double from_frame = 0;
    for (std::size_t i = point.joint + 1; i < count; ++i) {
      changed_[i] = chordOf(angle_[i]) * (awayFrom(i, p) + from_frame) + slide_[i];
      from_frame += changed_[i];
    }
    double moves = 0, changes = from_frame;
    for (std::size_t i = point.joint; i-- > 0;) {
      const double chord = chordOf(angle_[i]), reach = awayFrom(i, p) + moves;
      changed_[i] = chord * std::min(reach, awayFrom(i, p_RS_)) + slide_[i];
      moves += chord * reach + slide_[i];
      changes += changed_[i];
    }
    const Eigen::Vector3d p_F = X_RF.rotation.transpose() * (p - X_RF.translation);
    const double length = p_F.norm() * (1 + kBoundRounding);
    const Range range = distances(R_RF_ * p_F);
    const double distance = (p - p_RS_).norm();
    consider(box,
             std::max(range.first - distance, distance - range.second) -
                 length * std::min(2.0, half_turn_),
             changes, region_.position_tolerance + (length + from_frame) * region_.angle_tolerance,
             changed_);
  }

  /// The distance of a point from joint i's axis, about which it may turn; for a floating joint,
  /// from its origin.
  double awayFrom(std::size_t i, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d& origin = X_RC_[i].translation;
    return chain_.joints[i].type == JointType::kFloating
               ? (point - origin).norm()
               : distanceFromAxis(point, origin, X_RC_[i].rotation * chain_.joints[i].axis);
  }

  using Range = std::pair<double, double>;
  /// The least and greatest distance of S from the box of positions moved by `offset`.
  Range distances(const Eigen::Vector3d& offset) const {
    double near = 0, far = 0;
    for (int k = 0; k < 3; ++k) {
      const auto& [first, second] = region_.position[at(k)];
      const double a = first + offset(k) - p_RS_(k), b = second + offset(k) - p_RS_(k);
      const double least = std::max({a, -b, 0.0}), most = std::max(std::fabs(a), std::fabs(b));
      near += least * least;
      far += most * most;
    }
    return {std::sqrt(near), std::sqrt(far)};
  }

  /// Considers the last axis, which does not move when the last joint turns about it.
  void considerLastAxis(Box& box, const Pose& X_RF, double turn) {
    const std::size_t count = chain_.joints.size();
    const double last = angle_[count - 1];
    angle_[count - 1] = 0;
    const Eigen::Vector3d axis_F = chain_.X_PF.rotation.transpose() * chain_.joints[count - 1].axis;
    consider(box, angleBetween(X_RF.rotation * axis_F, R_RF_ * axis_F) - half_turn_, turn - last,
             region_.angle_tolerance, angle_);
    angle_[count - 1] = last;
  }

  void examinePoint(Box& box, const Eigen::Vector3d& p, const Target& target) {
    const std::size_t count = chain_.joints.size();
    moved_.assign(count, 0);
    changed_.assign(count, 0);
    double moves = 0, changes = 0, moves_without_first = 0;
    for (std::size_t i = count; i-- > 0;) {
      const double chord = chordOf(angle_[i]);
      const double reach = awayFrom(i, p) + moves;
      moved_[i] = chord * reach + slide_[i];
      changed_[i] =
          chord * (has_base_point_ ? std::min(reach, awayFrom(i, p_RS_)) : reach) + slide_[i];
      moves_without_first = moves;
      moves += moved_[i];
      changes += changed_[i];
    }
    const double tolerance =
        region_.position_tolerance + target.p_F.norm() * region_.angle_tolerance;
    Eigen::Vector3d outside;
    for (int k = 0; k < 3; ++k) {
      const auto& [first, second] = region_.position[at(k)];
      const double x = p(k) - target.offset(k);
      outside(k) = std::max({first - x, x - second, 0.0});
    }
    consider(box, outside.norm() - target.radius, moves, tolerance, moved_);
    if (box.excluded || !has_base_point_) return;

    // The first joint moves no point along the first axis.
    const Eigen::Vector3d axis = X_RC_[0].rotation * chain_.joints[0].axis;
    double low = 0, high = 0;
    for (int k = 0; k < 3; ++k) {
      const auto& [first, second] = region_.position[at(k)];
      const double a = first + target.offset(k) - p_RS_(k),
                   b = second + target.offset(k) - p_RS_(k);
      low += std::min(axis(k) * a, axis(k) * b);
      high += std::max(axis(k) * a, axis(k) * b);
    }
    const Eigen::Vector3d from_base = p - p_RS_;
    const double along = axis.dot(from_base);
    const double first_moved = moved_[0];
    moved_[0] = 0;
    consider(box, std::max(low - along, along - high) - target.radius, moves_without_first,
             tolerance, moved_);
    moved_[0] = first_moved;
    if (box.excluded) return;
    const double distance = from_base.norm();
    const Range range = distances(target.offset);
    consider(box, std::max(range.first - distance, distance - range.second) - target.radius,
             changes, tolerance, changed_);
  }

  /// The most that joint i turns and slides from the middle of the box, and the column to split.
  void halfWidths(const Box& box, std::size_t i) {
    const ChainJoint& joint = chain_.joints[i];
    double widest = 0;
    const auto half = [&](int k) {
      const int column = joint.column[at(k)];
      if (column < 0) return 0.0;
      const double width =
          std::fabs(joint.multiplier) * (box.high[at(column)] - box.low[at(column)]);
      if (width > widest) {
        widest = width;
        widest_[i] = column;
      }
      return width / 2 * (1 + kBoundRounding);
    };
    switch (joint.type) {
      case JointType::kRevolute:
      case JointType::kContinuous:
        angle_[i] = half(0);
        break;
      case JointType::kPrismatic:
        slide_[i] = half(0);
        break;
      case JointType::kPlanar:
        slide_[i] = half(0) + half(1);
        angle_[i] = half(2);
        break;
      default:
        slide_[i] = half(0) + half(1) + half(2);
        angle_[i] = kPi * (1 + 1e-15);  // the quaternion is not split
    }
  }

  static double chordOf(double angle) {
    if (angle >= kPi) return 2;
    double sine, cosine;
    collision::sineCosine(angle / 2, sine, cosine);
    return 2 * sine * (1 + kBoundRounding);
  }

  /// A lower bound: the chord.
  static double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::sqrt((a - b).squaredNorm());
  }

  const Chain& chain_;
  const PoseRegion& region_;
  std::vector<double> q_;
  std::span<const double> lower_, upper_;
  std::size_t columns_ = 0;
  std::vector<int> variable_;  // variable of the model, one for each column; -1: not in the chain
  std::vector<double> low_, high_;
  bool bounded_ = true;
  Eigen::Matrix3d R_RF_;  // of the middle angles
  Eigen::Vector3d half_angle_;
  double half_turn_ = 0, slack_ = 0;
  std::vector<Target> targets_;
  std::vector<MidPoint> mid_points_;
  bool has_base_point_ = false;
  Eigen::Vector3d p_RS_ = Eigen::Vector3d::Zero();
  std::vector<Pose> X_RC_;
  std::vector<double> angle_, slide_, moved_, changed_;  // one for each joint
  std::vector<int> widest_;
};

}  // namespace

ReachProof proveUnreachable(const Chain& chain, const PoseRegion& region,
                            std::span<const double> configuration, std::span<const double> lower,
                            std::span<const double> upper, std::int64_t limit) {
  return Prover(chain, region, configuration, lower, upper).run(limit);
}

}  // namespace leeway::robots
