#include "planner/edge/edge_lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/cover/ball_cover.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using collision::kTwoPi;
using collision::LaneGrowth;
using collision::LaneSweep;
using robots::Joint;
using robots::JointType;

/// The part of an edge that a lane has in the pass over all of it; exact.
constexpr float kWidth = 1.0F / collision::kLanes;

/// The middles of these parts, from that of the edge; exact.
collision::LaneValues middlesOfEdge() {
  collision::LaneValues middles;
  for (int i = 0; i < collision::kLanes; ++i)
    middles.at[i] = (static_cast<float>(i) + 0.5F) * kWidth - 0.5F;
  return middles;
}

std::size_t at(int i) { return static_cast<std::size_t>(i); }

float roundedUp(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

/// A rotation that turns z onto the unit vector `axis`, orthogonal to rounding.
Eigen::Matrix3d turningZ(const Eigen::Vector3d& axis) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d u, v;
  robots::planeAxes(axis, u, v);
  rotation << u, v, axis;
  return rotation;
}

const Joint& masterOf(const robots::Model& model, int joint) {
  const Joint* j = &model.joints[at(joint)];
  while (j->mimic >= 0) j = &model.joints[at(j->mimic)];
  return *j;
}

void copyMatrix(const Eigen::Matrix3d& m, float* out) {
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(m.data()[i]);  // column by column
}
void copyVector(const Eigen::Vector3d& v, float* out) {
  for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(v[i]);
}

void setTurn(double angle, double turn, collision::FrameStep& out) {
  out.angle = static_cast<float>(angle - kTwoPi * std::nearbyint(angle / kTwoPi));
  out.turn = static_cast<float>(turn);
}

}  // namespace

EdgeLanes::EdgeLanes(const EdgeFrames& frames) : scene_(frames.sharedScene()) {
  const robots::Model& model = scene_->model();
  middle_.resize(at(scene_->space().size()));
  q_.resize(model.variables.size());
  joint_motion_.assign(2 * model.joints.size(), 0.0F);
  addSteps();
  usable_ = usable_ && addMotions();
  if (usable_) addPieces(frames);
  usable_ = usable_ && longest_ < kLargestReach;
  sweep_.finish();
  scratch_ = std::make_unique<LaneSweep::Scratch>(sweep_);
  frame_steps_.resize(steps_.size());
  lane_frames_.resize(steps_.size());
  look_frames_.resize(steps_.size());
  growth_values_.resize(growth_.paddedSize());
  closed_.reserve(frames.pairs().size());
  pass_growth_.resize(growth_.paddedSize());
}

/// Joints that the planned variables move become steps; what is fixed between them is folded.
void EdgeLanes::addSteps() {
  const robots::Model& model = scene_->model();
  std::vector<char> planned(model.variables.size(), 0);
  for (const int v : scene_->space().variables()) planned[at(v)] = 1;
  std::vector<double> base(model.variables.size());
  std::vector<double> start(middle_.size(), 0.0);
  scene_->expand(start, base);  // what is not planned stands as it does
  std::vector<Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, base, X_WL);

  places_.resize(model.links.size());
  std::vector<int> depth;
  for (std::size_t l = 0; l < model.joints.size(); ++l) {
    const Joint& joint = model.joints[l];
    const LinkPlace parent = joint.parent_link < 0 ? LinkPlace{} : places_[at(joint.parent_link)];
    const Joint& master = masterOf(model, static_cast<int>(l));
    bool moves = false;
    for (int k = 0; joint.type != JointType::kFixed && k < master.variable_count; ++k)
      moves = moves || planned[at(master.first_variable + k)] != 0;
    if (!moves) {
      const Pose X_PL =
          joint.parent_link < 0 ? X_WL[l] : X_WL[at(joint.parent_link)].inverse() * X_WL[l];
      places_[l] = {parent.frame, parent.X_FL * X_PL};
      continue;
    }
    Step step;
    step.joint = static_cast<int>(l);
    step.X_PJ = parent.X_FL * joint.X_PJ;
    step.align =
        joint.type == JointType::kFloating ? Eigen::Matrix3d::Identity() : turningZ(joint.axis);
    step.length = step.X_PJ.translation.norm();
    // Slides of a joint, from its place at rest, are within its limits.
    const int first = joint.type == JointType::kPrismatic ? 0 : 1;
    const int slides = joint.type == JointType::kPlanar     ? 2
                       : joint.type == JointType::kFloating ? 3
                       : first == 0                         ? 1
                                                            : 0;
    for (int k = 0; k < slides; ++k) {
      const robots::Variable& v = model.variables[at(master.first_variable + k)];
      const double most = std::max(std::abs(v.lower), std::abs(v.upper));
      double factor = 1, offset = 0;
      if (joint.type == JointType::kPrismatic) {
        factor = std::abs(model.steps[l].multiplier);
        offset = std::abs(model.steps[l].offset);
      }
      step.length += factor == 0 ? offset : factor * most + offset;
    }
    const auto number = static_cast<int>(steps_.size());
    const robots::KinematicStep& k = model.steps[l];
    step.variable = at(k.variable);
    step.multiplier = k.multiplier;
    step.offset = k.offset;
    frame_reach_.push_back(step.length + (parent.frame < 0 ? 0 : frame_reach_[at(parent.frame)]));
    depth.push_back(1 + (parent.frame < 0 ? 0 : depth[at(parent.frame)]));
    deepest_ = std::max(deepest_, depth.back());
    steps_.push_back(step);
    frame_steps_.emplace_back();
    frame_steps_.back().parent = parent.frame;
    copyMatrix(step.X_PJ.rotation * step.align, frame_steps_.back().rotation);
    copyVector(step.X_PJ.translation, frame_steps_.back().translation);
    places_[l].frame = number;
    if (joint.type != JointType::kFloating) {
      places_[l].X_FL.rotation = step.align.transpose();  // the link does not know of `align`
      continue;
    }
    // The axis of a free turn is another for each edge.
    step.restores = true;
    step.length = 0;
    places_[l].frame = number + 1;
    frame_reach_.push_back(frame_reach_.back());
    deepest_ = std::max(deepest_, depth.back() + 1);
    depth.push_back(depth.back() + 1);
    steps_.push_back(step);
    frame_steps_.emplace_back();
    frame_steps_.back().parent = number;
  }
}

/// The terms of the scene's motions, from the body to the base, as robots::accelerationBound() sums
/// them.
int EdgeLanes::addMotion(const robots::RelativeMotion& motion) {
  const robots::Model& model = scene_->model();
  const auto joints = static_cast<int>(model.joints.size());
  std::vector<LaneGrowth::Term> terms;
  for (std::size_t i = motion.terms.size(); i-- > 0;) {
    const robots::RelativeMotion::Term& term = motion.terms[i];
    const JointType type = model.joints[at(term.joint)].type;
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
  return terms.size() > LaneGrowth::kMostTerms ? -1 : growth_.add(terms);
}

/// The scene's motions keep their numbers.
bool EdgeLanes::addMotions() {
  for (const robots::RelativeMotion& motion : scene_->motions())
    if (addMotion(motion) < 0) return false;
  return true;
}

/// The number of a moving piece's motion seen from the world; -1 when it has no bound.
int EdgeLanes::worldMotion(const Piece& piece) {
  const std::span<const robots::RelativeMotion> motions = scene_->motions();
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (motions[i].link == piece.link && motions[i].base < 0 &&
        motions[i].center_L == piece.bounds->outer.center)
      return static_cast<int>(i);
  // It meets nothing of the world, but its box is asked for.
  const collision::Ball& ball = piece.bounds->outer;
  return addMotion(
      robots::relativeMotion(scene_->model(), piece.link, -1, ball.center, ball.radius));
}

void EdgeLanes::addPieces(const EdgeFrames& frames) {
  const std::span<const Piece> pieces = frames.pieces();
  const collision::Scene& scene = scene_->scene();
  std::vector<int> lane_piece(pieces.size(), -1), obstacle(pieces.size(), -1);
  std::vector<char> used(pieces.size(), 0);
  for (const EdgePair& pair : frames.pairs()) used[at(pair.a)] = used[at(pair.b)] = 1;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (used[i] == 0) continue;
    const Piece& piece = pieces[i];
    const collision::Shape& shape = piece.geometry->shape;
    const Pose& X_BG = piece.geometry->X_BG;
    const bool in_world = piece.link < 0;
    const Pose X_WG = in_world ? scene.bodies()[at(piece.body)].X_WB * X_BG : Pose{};
    if (in_world) obstacle[i] = sweep_.addObstacle(shape, X_WG);
    if (in_world && shape.type() != collision::ShapeType::kMesh &&
        shape.type() != collision::ShapeType::kConvexHull)
      continue;
    const LinkPlace place = in_world ? LinkPlace{} : places_[at(piece.link)];
    const Pose X_FG = in_world ? X_WG : place.X_FL * X_BG;
    LaneSweep::Piece lane;
    lane.frame = place.frame;
    lane.motion = in_world ? -1 : worldMotion(piece);
    if (!in_world && lane.motion < 0) usable_ = false;
    const Pose X_FB = in_world ? Pose{} : place.X_FL;
    const auto placed = [](const Pose& X, const collision::Ball& ball) {
      collision::Ball moved{X * ball.center, ball.radius};
      moved.radius += collision::kTransferRounding * (moved.center.lpNorm<1>() + ball.radius);
      return moved;
    };
    lane.outer = placed(X_FB, piece.bounds->outer);
    const std::shared_ptr<const collision::BallCover> cover = collision::coverOf(shape);
    for (const collision::Ball& ball : cover->outer) lane.cover.push_back(placed(X_FG, ball));
    for (const collision::Ball& ball : cover->inner) {
      collision::Ball moved = placed(X_FG, ball);
      moved.radius = ball.radius - (moved.radius - ball.radius);
      if (moved.radius > 0) lane.inner.push_back(moved);
    }
    const auto placeAll = [&](const std::vector<Eigen::Vector3d>& points, double radius,
                              std::vector<Eigen::Vector3d>& out) {
      double moving = 0;  // rounds
      for (const Eigen::Vector3d& p : points) {
        const collision::Ball moved = placed(X_FG, {p, 0});
        out.push_back(moved.center);
        moving = std::max(moving, moved.radius);
      }
      return radius + moving;
    };
    const auto placePoints = [&](const collision::PointCover& points) {
      collision::PointCover moved;
      moved.own = points.own;
      moved.clusters = points.clusters;
      moved.nearest = points.nearest;
      moved.radius = placeAll(points.points, points.radius, moved.points);
      moved.fine_radius = std::max(placeAll(points.fine, points.fine_radius, moved.fine),
                                   moved.radius - points.radius);
      return moved;
    };
    lane.points = placePoints(cover->points);
    if (!in_world)
      for (const collision::CoverPart& part : cover->parts)
        lane.parts.push_back({placed(X_FG, part.ball), placePoints(part.points)});
    const double chain = place.frame < 0 ? 0 : frame_reach_[at(place.frame)];
    lane.reach = lane.outer.center.norm();
    for (const collision::Ball& ball : lane.cover)
      lane.reach = std::max(lane.reach, ball.center.norm());
    for (const collision::CoverPart& part : lane.parts)
      lane.reach = std::max(lane.reach, part.ball.center.norm());
    lane.reach += chain;
    longest_ = std::max(longest_, lane.reach);
    lane_piece[i] = sweep_.addPiece(lane);
  }
  const std::span<const EdgePair> pairs = frames.pairs();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const EdgePair& pair = pairs[p];
    const auto id = static_cast<int>(p);
    const bool world_a = pieces[at(pair.a)].link < 0, world_b = pieces[at(pair.b)].link < 0;
    if (!world_a && !world_b) {
      sweep_.addPiecePair(id, lane_piece[at(pair.a)], lane_piece[at(pair.b)], pair.motion,
                          pair.threshold, !pair.by_surfaces);
    } else {
      const int moving = world_a ? pair.b : pair.a, still = world_a ? pair.a : pair.b;
      sweep_.addPair(id, lane_piece[at(moving)], obstacle[at(still)], lane_piece[at(still)],
                     pair.threshold, !pair.by_surfaces);
    }
  }
}

/// The step of one joint for the present edge, what is the same for all of them being there; q_
/// holds the configuration in its middle but for quaternions, which are still those of its start.
void EdgeLanes::setStep(const EdgeFrames& frames, std::size_t i) {
  const Step& step = steps_[i];
  const Joint& joint = scene_->model().joints[at(step.joint)];
  collision::FrameStep& out = frame_steps_[i];
  const Eigen::Matrix3d& R_PJ = step.X_PJ.rotation;
  const Eigen::Vector3d& p_PJ = step.X_PJ.translation;
  const double* q = &q_[step.variable];
  const double* d = &frames.configurationDifference()[step.variable];
  switch (joint.type) {
    case JointType::kFixed:
      break;
    case JointType::kRevolute:
    case JointType::kContinuous:
      setTurn(step.multiplier * q[0] + step.offset, step.multiplier * d[0], out);
      break;
    case JointType::kPrismatic: {
      const Eigen::Vector3d axis = R_PJ * joint.axis;
      copyVector(p_PJ + axis * (step.multiplier * q[0] + step.offset), out.translation);
      copyVector(axis * (step.multiplier * d[0]), out.slide);
      break;
    }
    case JointType::kPlanar: {
      Eigen::Vector3d u, v;
      robots::planeAxes(joint.axis, u, v);
      copyVector(p_PJ + R_PJ * (u * q[0] + v * q[1]), out.translation);
      copyVector(R_PJ * (u * d[0] + v * d[1]), out.slide);
      setTurn(q[2], d[2], out);
      break;
    }
    case JointType::kFloating: {
      const Eigen::Vector3d r(d[3], d[4], d[5]);
      const double turn = r.norm();
      // Without a turn any axis will do.
      const Eigen::Matrix3d align =
          turn > kLeastTurn ? turningZ(r / turn) : Eigen::Matrix3d::Identity();
      if (step.restores) {
        copyMatrix(align.transpose(), out.rotation);
        return;
      }
      copyVector(p_PJ + R_PJ * Eigen::Vector3d(q[0], q[1], q[2]), out.translation);
      copyVector(R_PJ * Eigen::Vector3d(d[0], d[1], d[2]), out.slide);
      const Eigen::Matrix3d start =
          Eigen::Quaterniond(q[6], q[3], q[4], q[5]).normalized().toRotationMatrix();
      copyMatrix(R_PJ * start * align, out.rotation);
      setTurn(turn / 2, turn, out);
      break;
    }
  }
}

bool EdgeLanes::begin(const EdgeFrames& frames) {
  if (!usable_ || !frames.isWithinLimits()) return false;
  const robots::Model& model = scene_->model();
  const std::span<const double> a = frames.start(), difference = frames.difference();
  for (const ConfigurationSpace::Part& part : scene_->space().parts()) {
    const std::size_t i = at(part.first);
    if (part.kind == ConfigurationSpace::Kind::kRotation)
      std::copy(&a[i], &a[i] + 4, &middle_[i]);
    else
      middle_[i] = a[i] + difference[i] / 2;
  }
  scene_->expand(middle_, q_);
  double turns = 0, slides = 0;  // over half an interval
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const robots::JointMotion& motion = frames.jointMotion()[at(steps_[i].joint)];
    if (!(motion.angle <= static_cast<double>(collision::kLargestLaneTurn))) return false;
    turns += motion.angle;
    slides += motion.travel;
    setStep(frames, i);
  }
  turns /= 2 * collision::kLanes;
  slides /= 2 * collision::kLanes;
  const std::size_t joints = model.joints.size();
  for (std::size_t j = 0; j < joints; ++j) {
    joint_motion_[j] = roundedUp(frames.jointMotion()[j].angle);
    joint_motion_[joints + j] = roundedUp(frames.jointMotion()[j].travel);
  }
  // Every chain's sum of tails is at most (steps + 1) times the longest chain.
  const double rounding = collision::kLaneRounding * (deepest_ + 1) * longest_;
  slack_ = roundedUp(rounding * (1 + 4 * turns) + 2 * deepest_ * collision::kLaneRounding * slides);
  return true;
}

void EdgeLanes::countInto(collision::Work& work) {
  work_ = &work;
  scratch_->countInto(work);
}

void EdgeLanes::placeFrames(const collision::LaneValues& places,
                            std::vector<collision::LaneFrame>& frames) {
  if (work_ != nullptr) work_->add(collision::kLanePassWork);
  collision::placeFrames(frame_steps_, places, frames);
}

LaneSweep::Contact EdgeLanes::sweep() {
  const collision::LaneValues middles = middlesOfEdge();
  placeFrames(middles, lane_frames_);
  const LaneSweep::Contact again = sweep_.meetAgain(lane_frames_, slack_, *scratch_);
  if (again.id >= 0) return again;
  collision::moveFrames(frame_steps_, middles, kWidth, lane_frames_);
  growth_.run(joint_motion_, growth_values_);
  pass_growth_ = growth_values_;
  return sweep_.run(lane_frames_, pass_growth_, slack_, *scratch_);
}

LaneSweep::Contact EdgeLanes::sweepBeyond(double beyond) {
  const collision::LaneValues middles = middlesOfEdge();
  placeFrames(middles, lane_frames_);
  collision::moveFrames(frame_steps_, middles, kWidth, lane_frames_);
  growth_.run(joint_motion_, growth_values_);
  // What points may leave their chords by is a distance that must be kept; so is this.
  const float wider = roundedUp(beyond);
  for (std::size_t i = 0; i < growth_values_.size(); ++i)
    pass_growth_[i] = (growth_values_[i] + wider) * (1 + 0x1p-22F);
  const LaneSweep::Contact contact = sweep_.run(lane_frames_, pass_growth_, slack_, *scratch_);
  return contact.id >= 0 ? contact : part();
}

void EdgeLanes::closeGaps(const EdgeFrames& frames) {
  constexpr double kShare = 1.0 / collision::kLanes;
  bool closes = false;
  closed_.clear();
  for (const LaneSweep::Open& open : scratch_->open()) {
    const EdgePair& pair = frames.pairs()[at(open.id)];
    closed_.push_back(0);
    if (pair.gap < 0) continue;
    for (int lane = 0; lane < collision::kLanes; ++lane)
      if ((open.lanes >> lane & 1U) != 0 &&
          frames.keepsGap(pair, lane * kShare, (lane + 1) * kShare))
        closed_.back() |= 1U << lane;
    closes = closes || closed_.back() != 0;
  }
  if (closes) scratch_->close(closed_);
}

LaneSweep::Contact EdgeLanes::part() {
  return sweep_.separate(lane_frames_, pass_growth_, slack_, *scratch_);
}

EdgeLanes::Parts EdgeLanes::wholeEdge() {
  Parts parts;
  parts.width = 1.0 / collision::kLanes;
  for (int i = 0; i < collision::kLanes; ++i) parts.from[i] = i * parts.width;
  return parts;
}

LaneSweep::Contact EdgeLanes::sweepParts(const Parts& parts,
                                         std::span<const LaneSweep::Open> pairs) {
  const auto width = static_cast<float>(parts.width);
  collision::LaneValues middles;
  for (int i = 0; i < collision::kLanes; ++i)
    middles.at[i] = static_cast<float>(parts.from[i] - 0.5) + width / 2;
  placeFrames(middles, lane_frames_);
  collision::moveFrames(frame_steps_, middles, width, lane_frames_);
  const float share = width * collision::kLanes * (width * collision::kLanes);
  for (std::size_t i = 0; i < growth_values_.size(); ++i)
    pass_growth_[i] = share * growth_values_[i];
  return sweep_.runPairs(pairs, lane_frames_, pass_growth_, slack_, *scratch_);
}

std::optional<double> EdgeLanes::meet(int pair, double from, double width) {
  if (!sweep_.canMeet(pair)) return std::nullopt;
  // In the middle of a lane's share each, but for the whole edge at its end: the middles are those
  // of sweep() there.
  const double share = width / collision::kLanes, first = width < 1 ? share / 2 : share;
  collision::LaneValues places;
  for (int i = 0; i < collision::kLanes; ++i)
    places.at[i] = static_cast<float>(from - 0.5 + (first + i * share));
  placeFrames(places, look_frames_);
  const LaneSweep::Contact met = sweep_.meet(pair, look_frames_, slack_, *scratch_);
  if (met.id < 0) return std::nullopt;
  return 0.5 + static_cast<double>(places.at[met.lane]);
}

LaneSweep::Contact EdgeLanes::still(const collision::LaneValues& places) {
  placeFrames(places, lane_frames_);
  const LaneSweep::Contact again = sweep_.meetAgain(lane_frames_, slack_, *scratch_);
  return again.id >= 0 ? again : sweep_.runStill(lane_frames_, slack_, *scratch_);
}

}  // namespace leeway::planner
