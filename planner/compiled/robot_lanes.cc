#include "planner/compiled/robot_lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/cover/ball_cover.h"
#include "collision/scene/scene_access.h"
#include "leeway/robots/kinematics.h"
#include "planner/compiled/edge_model.h"

namespace leeway::planner {
namespace {

using collision::Ball;
using collision::LaneGrowth;
using collision::LaneSweep;
using collision::Pose;
using robots::Joint;
using robots::JointType;

const Joint& masterOf(const robots::Model& model, int joint) {
  const Joint* j = &model.joints[at(joint)];
  while (j->mimic >= 0) j = &model.joints[at(j->mimic)];
  return *j;
}

/// A ball in another frame, enlarged by the rounding of its centre.
Ball placed(const Pose& X, const Ball& ball) {
  Ball moved{X * ball.center, ball.radius};
  moved.radius += collision::kTransferRounding * (moved.center.lpNorm<1>() + ball.radius);
  return moved;
}

/// Appends points in another frame. Returns how far rounding moves them, plus `radius`.
double placePoints(const Pose& X, const std::vector<Eigen::Vector3d>& points, double radius,
                   std::vector<Eigen::Vector3d>& out) {
  double rounding = 0;
  for (const Eigen::Vector3d& p : points) {
    const Ball moved = placed(X, Ball{p, 0});
    out.push_back(moved.center);
    rounding = std::max(rounding, moved.radius);
  }
  return radius + rounding;
}

collision::PointCover placedPoints(const Pose& X, const collision::PointCover& points) {
  collision::PointCover moved;
  moved.own = points.own;
  moved.clusters = points.clusters;
  moved.nearest = points.nearest;
  moved.radius = placePoints(X, points.points, points.radius, moved.points);
  moved.fine_radius = std::max(placePoints(X, points.fine, points.fine_radius, moved.fine),
                               moved.radius - points.radius);
  return moved;
}

/// The largest distance of a ball's centre from the frame's origin [m].
double reachOf(const LaneSweep::Piece& piece) {
  double reach = piece.outer.center.norm();
  for (const Ball& ball : piece.cover) reach = std::max(reach, ball.center.norm());
  for (const collision::CoverPart& part : piece.parts)
    reach = std::max(reach, part.ball.center.norm());
  return reach;
}

/// The smallest number of pieces of a frame that form a group, and the number of balls around a
/// group [count].
constexpr std::size_t kLeastGroup = 5, kGroupBalls = 8;

/// A ball around some balls; its centre is the middle of theirs.
Ball around(std::span<const Ball> balls) {
  Ball all;
  for (const Ball& ball : balls) all.center += ball.center / static_cast<double>(balls.size());
  for (const Ball& ball : balls)
    all.radius = std::max(all.radius, (ball.center - all.center).norm() + ball.radius);
  all.radius += collision::kTransferRounding * (all.center.lpNorm<1>() + all.radius);
  return all;
}

/// Halves at the median along the axis with the largest spread of centres; reorders the balls.
std::size_t halve(std::span<Ball> balls) {
  Eigen::AlignedBox3d box;
  for (const Ball& ball : balls) box.extend(ball.center);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t half = balls.size() / 2;
  std::nth_element(
      balls.begin(), balls.begin() + static_cast<std::ptrdiff_t>(half), balls.end(),
      [axis](const Ball& x, const Ball& y) { return x.center[axis] < y.center[axis]; });
  return half;
}

/// Balls and points of a geometry, in frame F.
void addCover(const collision::BallCover& cover, const Pose& X_FG, LaneSweep::Piece& lane) {
  for (const Ball& ball : cover.outer) lane.cover.push_back(placed(X_FG, ball));
  for (const Ball& ball : cover.inner) {
    Ball moved = placed(X_FG, ball);
    moved.radius = ball.radius - (moved.radius - ball.radius);  // rounded inwards
    if (moved.radius > 0) lane.inner.push_back(moved);
  }
  lane.points = placedPoints(X_FG, cover.points);
}

class RobotLanesBuilder {
 public:
  RobotLanesBuilder(const robots::Model& model, const RobotLanes::Source& robot, RobotLanes& lanes)
      : model_(model), robot_(robot), lanes_(lanes) {}

  void build() {
    addSteps();
    for (const robots::RelativeMotion& motion : robot_.motions.motions) addMotion(motion);
    addPieces();
    lanes_.sweep.finishPieces();
  }

 private:
  /// The pose of a link in the last frame below it; frame -1: the world.
  struct LinkPlace {
    int frame = -1;
    Pose X_FL;
  };

  // Joints that the planned variables move become steps; fixed joints between them are folded in.

  void addSteps() {
    std::vector<char> planned(model_.variables.size(), 0);
    for (const int v : robot_.variables) planned[at(v)] = 1;
    std::vector<double> base(model_.variables.size(), 0.0);
    for (std::size_t v = 0; v < base.size(); ++v)
      if (!planned[v]) base[v] = robot_.ranges[v].lower;  // keeps its value
    std::vector<Pose> X_WL(model_.links.size());
    robots::forwardKinematics(model_, base, X_WL);

    places_.resize(model_.links.size());
    for (std::size_t l = 0; l < model_.joints.size(); ++l) {
      const Joint& joint = model_.joints[l];
      const LinkPlace parent = joint.parent_link < 0 ? LinkPlace{} : places_[at(joint.parent_link)];
      if (isMoved(static_cast<int>(l), planned)) {
        addStep(static_cast<int>(l), parent);
        continue;
      }
      const Pose X_PL =
          joint.parent_link < 0 ? X_WL[l] : X_WL[at(joint.parent_link)].inverse() * X_WL[l];
      places_[l] = {parent.frame, parent.X_FL * X_PL};
    }
  }

  bool isMoved(int joint, const std::vector<char>& planned) const {
    if (model_.joints[at(joint)].type == JointType::kFixed) return false;
    const Joint& master = masterOf(model_, joint);
    const auto first = planned.begin() + master.first_variable;
    return std::any_of(first, first + master.variable_count, [](char p) { return p != 0; });
  }

  void addStep(int l, const LinkPlace& parent) {
    const Joint& joint = model_.joints[at(l)];
    const robots::KinematicStep& kinematics = model_.steps[at(l)];
    const bool floating = joint.type == JointType::kFloating;
    RobotLanes::Step step;
    step.joint = l;
    step.X_PJ = parent.X_FL * joint.X_PJ;
    step.variable = at(kinematics.variable);
    step.multiplier = kinematics.multiplier;
    step.offset = kinematics.offset;
    const int frame = append(step, parent.frame, lengthOf(step));
    places_[at(l)].frame = frame;
    const Eigen::Matrix3d align = floating ? Eigen::Matrix3d::Identity() : turningZ(joint.axis);
    copyMatrix(step.X_PJ.rotation * align, lanes_.frame_steps[at(frame)].rotation);
    copyVector(step.X_PJ.translation, lanes_.frame_steps[at(frame)].translation);
    if (!floating) {
      findAxes(lanes_.frame_steps[at(frame)]);
      places_[at(l)].X_FL.rotation = align.transpose();
      return;
    }
    // Each edge turns a free body about another axis.
    step.restores = true;
    places_[at(l)].frame = append(step, frame, 0);
  }

  /// `length`: the greatest length of translation and slide together [m].
  int append(const RobotLanes::Step& step, int parent, double length) {
    reach_.push_back(length + (parent < 0 ? 0 : reach_[at(parent)]));
    depth_.push_back(1 + (parent < 0 ? 0 : depth_[at(parent)]));
    lanes_.deepest = std::max(lanes_.deepest, depth_.back());
    lanes_.steps.push_back(step);
    lanes_.frame_steps.emplace_back();
    lanes_.frame_steps.back().parent = parent;
    return static_cast<int>(lanes_.steps.size()) - 1;
  }

  /// The greatest length of a step's translation and slide together, within the joint's limits [m].
  double lengthOf(const RobotLanes::Step& step) const {
    double length = step.X_PJ.translation.norm();
    const JointType type = model_.joints[at(step.joint)].type;
    const Joint& master = masterOf(model_, step.joint);
    const auto most = [&](int k) {
      const robots::Variable& v = model_.variables[at(master.first_variable + k)];
      return std::max(std::abs(v.lower), std::abs(v.upper));
    };
    if (type == JointType::kPrismatic) {
      const double factor = std::abs(step.multiplier), offset = std::abs(step.offset);
      length += factor == 0 ? offset : factor * most(0) + offset;  // 0 times no limit is NaN
    }
    const int slides = type == JointType::kPlanar ? 2 : type == JointType::kFloating ? 3 : 0;
    for (int k = 0; k < slides; ++k) length += most(k);
    return length;
  }

  // Bounds on accelerations.

  void addMotion(const robots::RelativeMotion& motion) {
    std::vector<LaneGrowth::Term> terms = termsOf(motion);
    const bool is_bounded =
        terms.size() <= LaneGrowth::kMostTerms &&
        std::all_of(terms.begin(), terms.end(),
                    [](const LaneGrowth::Term& term) { return std::isfinite(term.reach); });
    if (!is_bounded) terms.clear();  // keeps its number
    lanes_.is_bounded.push_back(is_bounded ? 1 : 0);
    lanes_.growth.add(terms);
  }

  /// The terms of a motion, from the body to the base, as robots::accelerationBound() sums them.
  std::vector<LaneGrowth::Term> termsOf(const robots::RelativeMotion& motion) const {
    const auto joints = static_cast<int>(model_.joints.size());
    std::vector<LaneGrowth::Term> terms;
    for (std::size_t i = motion.terms.size(); i-- > 0;) {
      const robots::RelativeMotion::Term& term = motion.terms[i];
      const JointType type = model_.joints[at(term.joint)].type;
      const LaneGrowth::Term slide{joints + term.joint, 1, false};
      const LaneGrowth::Term turn{term.joint, term.reach, true};
      const bool slides = type == JointType::kPlanar || type == JointType::kFloating;
      if (type == JointType::kPrismatic) {
        terms.push_back(slide);
        continue;
      }
      if (slides && term.inverted) terms.push_back(slide);
      terms.push_back(turn);
      if (slides && !term.inverted) terms.push_back(slide);
    }
    return terms;
  }

  // Geometries.

  /// The moving geometries, and the static ones that some link must not touch.
  void addPieces() {
    const collision::Scene& scene = robot_.scene;
    std::vector<char> used;
    for (std::size_t b = 0; b < scene.bodies().size(); ++b)
      used.insert(used.end(), scene.bodies()[b].geometries.size(), scene.bodies()[b].moving);
    for (const collision::ScenePair& pair : scene.pairs())
      used[at(indexOf(pair.body_b, pair.geometry_b))] = 1;
    lanes_.pieces.resize(used.size());
    for (std::size_t b = 0; b < scene.bodies().size(); ++b)
      for (std::size_t g = 0; g < scene.bodies()[b].geometries.size(); ++g)
        if (used[at(indexOf(static_cast<int>(b), static_cast<int>(g)))] != 0)
          addPiece(static_cast<int>(b), static_cast<int>(g));
    for (const auto& [frame, group] : of_frames_) addGroup(group);
  }

  /// Pieces that fixed joints connect, such as grippers.
  struct Group {
    std::vector<int> pieces;  // of the sweep
    std::vector<Ball> balls;  // that contain them
  };

  /// O(balls log balls).
  void addGroup(const Group& group) {
    if (group.pieces.size() < kLeastGroup) return;
    std::vector<Ball> balls = group.balls, around_all{around(balls)};
    std::vector<std::span<Ball>> shares{balls};
    while (shares.size() < kGroupBalls) {
      // The part with the largest ball.
      const auto largest =
          std::max_element(around_all.begin(), around_all.end(),
                           [](const Ball& x, const Ball& y) { return x.radius < y.radius; });
      const auto i = static_cast<std::size_t>(largest - around_all.begin());
      if (shares[i].size() < 2) break;
      const std::size_t half = halve(shares[i]);
      shares.push_back(shares[i].subspan(half));
      shares[i] = shares[i].first(half);
      around_all.push_back(around(shares.back()));
      around_all[i] = around(shares[i]);
    }
    lanes_.sweep.addGroup(group.pieces, around_all);
  }

  int indexOf(int body, int geometry) const {
    return collision::SceneAccess::geometryIndex(robot_.scene, body, geometry);
  }

  void addPiece(int body, int geometry) {
    const int index = indexOf(body, geometry);
    const collision::Body& b = robot_.scene.bodies()[at(body)];
    const collision::Geometry& g = b.geometries[at(geometry)];
    const Ball& outer = collision::SceneAccess::bounds(robot_.scene, index).outer;
    RobotLanes::Piece& result = lanes_.pieces[at(index)];
    if (!b.moving) {
      result = addStill(g, b.X_WB, outer, lanes_.sweep);
      return;
    }
    const LinkPlace& place = places_[at(robot_.carriers[at(body)])];
    const Pose X_FG = place.X_FL * g.X_BG;
    LaneSweep::Piece lane;
    lane.frame = place.frame;
    lane.motion = robot_.motions.of_world[at(index)];
    lane.outer = placed(place.X_FL, outer);
    const std::shared_ptr<const collision::BallCover> cover = collision::coverOf(g.shape);
    addCover(*cover, X_FG, lane);
    for (const collision::CoverPart& part : cover->parts)
      lane.parts.push_back({placed(X_FG, part.ball), placedPoints(X_FG, part.points)});
    lane.reach = reachOf(lane);
    if (place.frame >= 0) {
      lane.reach += reach_[at(place.frame)];
      // No ball holds a half-space: lanes would take one that moves for near nothing.
      if (!std::isfinite(outer.radius)) lane.reach = kInfinity;
    }
    result.reach = lane.reach;
    result.piece = lanes_.sweep.addPiece(lane);
    if (place.frame < 0 || lane.cover.empty()) return;
    Group& group = of_frames_[place.frame];
    group.pieces.push_back(result.piece);
    group.balls.insert(group.balls.end(), lane.cover.begin(), lane.cover.end());
  }

  const robots::Model& model_;
  const RobotLanes::Source& robot_;
  RobotLanes& lanes_;
  std::vector<LinkPlace> places_;  // one per link
  std::vector<double> reach_;      // lengths up to a frame [m]
  std::vector<int> depth_;         // steps up to a frame
  std::map<int, Group> of_frames_;
};

}  // namespace

RobotLanes::RobotLanes(const robots::Model& model, const Source& robot) {
  RobotLanesBuilder(model, robot, *this).build();
}

RobotLanes::Piece addStill(const collision::Geometry& geometry, const Pose& X_WB, const Ball& outer,
                           LaneSweep& sweep, int place) {
  const collision::Shape& shape = geometry.shape;
  const Pose X_WG = X_WB * geometry.X_BG;
  RobotLanes::Piece result;
  result.obstacle = sweep.addObstacle(shape, X_WG, place);
  // For these two shapes an obstacle is only their box; balls are tighter.
  if (shape.type() != collision::ShapeType::kMesh &&
      shape.type() != collision::ShapeType::kConvexHull)
    return result;
  LaneSweep::Piece lane;
  lane.outer = placed(Pose{}, outer);
  addCover(*collision::coverOf(shape), X_WG, lane);
  result.reach = lane.reach = reachOf(lane);
  result.piece = sweep.addPiece(lane);
  return result;
}

}  // namespace leeway::planner
