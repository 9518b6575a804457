// What EdgeLanes makes once of a scene: frames of the joints that move, and pieces and pairs for
// collision::LaneSweep.

#include <algorithm>
#include <cmath>

#include "collision/base/tolerances.h"
#include "collision/cover/ball_cover.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/edge_lanes_steps.h"
#include "planner/edge/edge_model.h"

namespace leeway::planner {
namespace {

using collision::Ball;
using collision::LaneGrowth;
using collision::LaneSweep;
using robots::Joint;
using robots::JointType;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

const Joint& masterOf(const robots::Model& model, int joint) {
  const Joint* j = &model.joints[at(joint)];
  while (j->mimic >= 0) j = &model.joints[at(j->mimic)];
  return *j;
}

/// A ball in another frame, larger by what rounding moves its centre.
Ball placed(const Pose& X, const Ball& ball) {
  Ball moved{X * ball.center, ball.radius};
  moved.radius += collision::kTransferRounding * (moved.center.lpNorm<1>() + ball.radius);
  return moved;
}

/// Appends points in another frame; returns how far rounding moves them, added to `radius`.
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

/// The farthest that a ball's centre is from the frame's origin [m].
double reachOf(const LaneSweep::Piece& piece) {
  double reach = piece.outer.center.norm();
  for (const Ball& ball : piece.cover) reach = std::max(reach, ball.center.norm());
  for (const collision::CoverPart& part : piece.parts)
    reach = std::max(reach, part.ball.center.norm());
  return reach;
}

}  // namespace

class EdgeLanes::Builder {
 public:
  Builder(EdgeLanes& lanes, const EdgeFrames& frames)
      : lanes_(lanes), frames_(frames), scene_(*lanes.scene_), model_(scene_.model()) {}

  /// False when lanes cannot be trusted with this scene.
  bool build() {
    addSteps();
    if (!addMotions()) return false;
    addPieces();
    addPairs();
    return has_bounds_ && lanes_.longest_ < kLargestReach;
  }

 private:
  /// Where a link is in the last frame below it; frame -1: the world.
  struct LinkPlace {
    int frame = -1;
    Pose X_FL;
  };

  // Joints that the planned variables move become steps; what is fixed between them is folded.

  void addSteps() {
    std::vector<char> planned(model_.variables.size(), 0);
    for (const int v : scene_.space().variables()) planned[at(v)] = 1;
    std::vector<double> base(model_.variables.size());
    const std::vector<double> start(at(scene_.space().size()), 0.0);
    scene_.expand(start, base);  // what is not planned stands as it does
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
    Step step;
    step.joint = l;
    step.X_PJ = parent.X_FL * joint.X_PJ;
    step.variable = at(kinematics.variable);
    step.multiplier = kinematics.multiplier;
    step.offset = kinematics.offset;
    const int frame = append(step, parent.frame, lengthOf(step));
    places_[at(l)].frame = frame;
    const Eigen::Matrix3d align = floating ? Eigen::Matrix3d::Identity() : turningZ(joint.axis);
    copyMatrix(step.X_PJ.rotation * align, lanes_.frame_steps_[at(frame)].rotation);
    copyVector(step.X_PJ.translation, lanes_.frame_steps_[at(frame)].translation);
    if (!floating) {
      places_[at(l)].X_FL.rotation = align.transpose();
      return;
    }
    // Each edge turns a free body about another axis.
    step.restores = true;
    places_[at(l)].frame = append(step, frame, 0);
  }

  /// `length`: of translation and slide together, at most [m].
  int append(const Step& step, int parent, double length) {
    reach_.push_back(length + (parent < 0 ? 0 : reach_[at(parent)]));
    depth_.push_back(1 + (parent < 0 ? 0 : depth_[at(parent)]));
    lanes_.deepest_ = std::max(lanes_.deepest_, depth_.back());
    lanes_.steps_.push_back(step);
    lanes_.frame_steps_.emplace_back();
    lanes_.frame_steps_.back().parent = parent;
    return static_cast<int>(lanes_.steps_.size()) - 1;
  }

  /// Of a step's translation and slide together, within the joint's limits, at most [m].
  double lengthOf(const Step& step) const {
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

  /// The scene's motions keep their numbers.
  bool addMotions() {
    const auto& motions = scene_.edgeModel().motions;
    return std::all_of(motions.begin(), motions.end(),
                       [this](const robots::RelativeMotion& m) { return addMotion(m) >= 0; });
  }

  /// The terms of a motion, from the body to the base, as robots::accelerationBound() sums them; -1
  /// when there is no bound.
  int addMotion(const robots::RelativeMotion& motion) {
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
      if (!std::isfinite(term.reach)) return -1;
      if (slides && term.inverted) terms.push_back(slide);
      terms.push_back(turn);
      if (slides && !term.inverted) terms.push_back(slide);
    }
    return terms.size() > LaneGrowth::kMostTerms ? -1 : lanes_.growth_.add(terms);
  }

  /// The number of a moving piece's motion seen from the world; -1 when it has no bound.
  int worldMotion(const Piece& piece) {
    const auto& motions = scene_.edgeModel().motions;
    const Ball& ball = piece.bounds->outer;
    for (std::size_t i = 0; i < motions.size(); ++i)
      if (motions[i].link == piece.link && motions[i].base < 0 &&
          motions[i].center_L == ball.center && motions[i].radius == ball.radius)
        return static_cast<int>(i);
    // It meets nothing of the world, but its box is asked for.
    return addMotion(robots::relativeMotion(model_, piece.link, -1, ball.center, ball.radius));
  }

  // Pieces and pairs.

  void addPieces() {
    const std::span<const Piece> pieces = frames_.pieces();
    lane_piece_.assign(pieces.size(), -1);
    obstacle_.assign(pieces.size(), -1);
    std::vector<char> used(pieces.size(), 0);
    for (const EdgePair& pair : frames_.pairs()) used[at(pair.a)] = used[at(pair.b)] = 1;
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (used[i] != 0) addPiece(i);
  }

  void addPiece(std::size_t i) {
    const Piece& piece = frames_.pieces()[i];
    const collision::Shape& shape = piece.geometry->shape;
    const Pose& X_BG = piece.geometry->X_BG;
    LaneSweep::Piece lane;
    if (piece.link < 0) {
      const Pose X_WG = scene_.scene().bodies()[at(piece.body)].X_WB * X_BG;
      obstacle_[i] = lanes_.sweep_.addObstacle(shape, X_WG);
      // Of these two an obstacle is only their box: balls say more.
      if (shape.type() != collision::ShapeType::kMesh &&
          shape.type() != collision::ShapeType::kConvexHull)
        return;
      addCover(shape, piece.bounds->outer, Pose{}, X_WG, lane);
      lane.reach = reachOf(lane);
    } else {
      const LinkPlace& place = places_[at(piece.link)];
      const Pose X_FG = place.X_FL * X_BG;
      lane.frame = place.frame;
      lane.motion = worldMotion(piece);
      has_bounds_ = has_bounds_ && lane.motion >= 0;
      addCover(shape, piece.bounds->outer, place.X_FL, X_FG, lane);
      for (const collision::CoverPart& part : collision::coverOf(shape)->parts)
        lane.parts.push_back({placed(X_FG, part.ball), placedPoints(X_FG, part.points)});
      lane.reach = reachOf(lane) + (place.frame < 0 ? 0 : reach_[at(place.frame)]);
    }
    lanes_.longest_ = std::max(lanes_.longest_, lane.reach);
    lane_piece_[i] = lanes_.sweep_.addPiece(lane);
    if (piece.link >= 0) lanes_.moving_.push_back({static_cast<int>(i), lane_piece_[i]});
  }

  /// Balls and points of a geometry, in frame F.
  static void addCover(const collision::Shape& shape, const Ball& outer, const Pose& X_FB,
                       const Pose& X_FG, LaneSweep::Piece& lane) {
    lane.outer = placed(X_FB, outer);
    const std::shared_ptr<const collision::BallCover> cover = collision::coverOf(shape);
    for (const Ball& ball : cover->outer) lane.cover.push_back(placed(X_FG, ball));
    for (const Ball& ball : cover->inner) {
      Ball moved = placed(X_FG, ball);
      moved.radius = ball.radius - (moved.radius - ball.radius);  // rounded inwards
      if (moved.radius > 0) lane.inner.push_back(moved);
    }
    lane.points = placedPoints(X_FG, cover->points);
  }

  void addPairs() {
    const std::span<const Piece> pieces = frames_.pieces();
    const std::span<const EdgePair> pairs = frames_.pairs();
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const EdgePair& pair = pairs[p];
      const auto id = static_cast<int>(p);
      const bool world_a = pieces[at(pair.a)].link < 0, world_b = pieces[at(pair.b)].link < 0;
      if (!world_a && !world_b) {
        lanes_.moving_pairs_.push_back(id);
        lanes_.sweep_.addPiecePair(id, lane_piece_[at(pair.a)], lane_piece_[at(pair.b)],
                                   pair.motion, pair.threshold, !pair.by_surfaces);
        continue;
      }
      const int moving = world_a ? pair.b : pair.a, still = world_a ? pair.a : pair.b;
      lanes_.sweep_.addPair(id, lane_piece_[at(moving)], obstacle_[at(still)],
                            lane_piece_[at(still)], pair.threshold, !pair.by_surfaces);
    }
  }

  EdgeLanes& lanes_;
  const EdgeFrames& frames_;
  const CompiledScene& scene_;
  const robots::Model& model_;
  bool has_bounds_ = true;                  // of every piece's acceleration
  std::vector<LinkPlace> places_;           // one a link
  std::vector<double> reach_;               // lengths up to a frame [m]
  std::vector<int> depth_;                  // steps up to a frame
  std::vector<int> lane_piece_, obstacle_;  // one a piece; -1: none
};

EdgeLanes::EdgeLanes(const EdgeFrames& frames) : scene_(frames.sharedScene()) {
  const robots::Model& model = scene_->model();
  middle_.resize(at(scene_->space().size()));
  q_.resize(model.variables.size());
  joint_motion_.assign(2 * model.joints.size(), 0.0F);
  usable_ = Builder(*this, frames).build();
  sweep_.finish();
  scratch_ = std::make_unique<LaneSweep::Scratch>(sweep_);
  lane_frames_.resize(steps_.size());
  contact_frames_.resize(steps_.size());
  growth_values_.resize(growth_.paddedSize());
  pass_growth_.resize(growth_.paddedSize());
  closed_.reserve(frames.pairs().size());
}

}  // namespace leeway::planner
