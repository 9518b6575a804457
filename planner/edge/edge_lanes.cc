#include "planner/edge/edge_lanes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/scene/scene_access.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"
#include "planner/compiled/prepared_robot.h"

namespace leeway::planner {
namespace {

using collision::kTwoPi;
using collision::LaneSweep;
using robots::Joint;
using robots::JointType;

/// The width of an interval in the pass over the whole edge; exact.
constexpr float kWidth = 1.0F / collision::kLanes;

/// Kinds of pairs for collision::LaneSweep.
constexpr std::uint8_t kOfWorld = LaneSweep::kOfWorld, kOfRobot = 2;

/// The middles of these parts, minus 1/2; exact.
constexpr collision::LaneValues kMiddles = [] {
  collision::LaneValues middles{};
  for (int i = 0; i < collision::kLanes; ++i)
    middles.at[i] = (static_cast<float>(i) + 0.5F) * kWidth - 0.5F;
  return middles;
}();

void setTurn(double angle, double turn, collision::FrameStep& out) {
  // Rounds like std::nearbyint(), without a call, because angles are far below 2^51.
  constexpr double kWholes = 0x1.8p52;
  const double turns = (angle / kTwoPi + kWholes) - kWholes;
  out.angle = static_cast<float>(angle - kTwoPi * turns);
  out.turn = static_cast<float>(turn);
}

}  // namespace

namespace {

/// The table of a scene's pairs, in the form that lanes use.
class EdgeWorld final : public collision::LaneWorld {
 public:
  EdgeWorld(const EdgeScene& edges, const collision::Scene& scene) : edges_(edges), scene_(scene) {}
  Placed placed(int place) const override {
    const auto of = scene_.pairs().geometryIn(at(place));
    const collision::Body& body = scene_.bodies()[at(of.body)];
    const std::size_t stored = body.geometries.size(), number = at(of.geometry);
    if (number >= stored) {
      const collision::Ball& ball = (*body.balls)[number - stored];
      return {nullptr, {}, {body.X_WB * ball.center, ball.radius}};
    }
    const collision::Geometry& g = body.geometries[number];
    return {&g.shape, body.X_WB * g.X_BG, {}};
  }
  std::optional<Pair> pairOf(int row, int place) const override {
    const std::int32_t number = scene_.pairs().numberOf(at(row), at(place));
    if (number < 0) return std::nullopt;
    const EdgePair pair = edges_.pairs[at(number)];
    return Pair{pair.threshold, !pair.by_surfaces};
  }

 private:
  const EdgeScene& edges_;
  const collision::Scene& scene_;
};

}  // namespace

SceneLanes::SceneLanes(const CompiledScene& scene, const EdgeScene& edges)
    : robot(scene.edgeModel().robot->lanes(scene.model())), sweep(robot.sweep) {
  const std::vector<RobotLanes::Piece> pieces = addPieces(scene, edges);
  if (usable) addPairs(edges, pieces);
  if (usable && !edges.pairs.rows().empty()) setWorld(scene, edges, pieces);
  sweep.finish();
}

std::vector<RobotLanes::Piece> SceneLanes::addPieces(const CompiledScene& scene,
                                                     const EdgeScene& edges) {
  const std::span<const Piece> listed = edges.pieces.listed();
  std::vector<char> used(listed.size(), 0);
  bool is_bounded = true;
  for (const EdgePair& pair : edges.pairs.listed()) {
    used[at(pair.a)] = used[at(pair.b)] = 1;
    is_bounded = is_bounded && robot.is_bounded[at(pair.motion)] != 0;
  }
  for (const EdgePairs::Row& row : edges.pairs.rows()) {
    used[at(row.piece)] = 1;
    is_bounded = is_bounded && robot.is_bounded[at(row.motion)] != 0;
  }
  const std::vector<int>& of_world = scene.edgeModel().robot->motions().of_world;
  std::vector<RobotLanes::Piece> lane_pieces = robot.pieces;
  // A group's balls may reach as far as its pieces without pairs.
  for (const RobotLanes::Piece& piece : robot.pieces) longest = std::max(longest, piece.reach);
  lane_pieces.resize(listed.size());
  for (std::size_t i = 0; i < listed.size(); ++i) {
    if (used[i] == 0) continue;
    longest = std::max(longest, lane_pieces[i].reach);
    if (listed[i].link >= 0) is_bounded = is_bounded && robot.is_bounded[at(of_world[i])] != 0;
  }
  if (!edges.pairs.rows().empty()) addPlaced(scene, edges);
  usable = is_bounded && longest < kLargestReach;
  return lane_pieces;
}

void SceneLanes::addPlaced(const CompiledScene& scene, const EdgeScene& edges) {
  for (const std::int32_t place : collision::SceneAccess::added(scene.scene())) {
    const Piece piece = edges.pieces[at(edges.pairs.pieceIn(at(place)))];
    const RobotLanes::Piece added =
        addStill(piece.geometry(), scene.scene().bodies()[at(piece.body)].X_WB,
                 piece.bounds().outer, sweep, place);
    sweep.setBalls(added.obstacle, added.piece);
    longest = std::max(longest, added.reach);
  }
}

void SceneLanes::addPairs(const EdgeScene& edges, std::span<const RobotLanes::Piece> lane_pieces) {
  const std::span<const EdgePair> listed = edges.pairs.listed();
  sweep.reservePairs(listed.size());
  for (const EdgePair& pair : listed) {
    const bool world_a = edges.pieces.listed()[at(pair.a)].link < 0,
               world_b = edges.pieces.listed()[at(pair.b)].link < 0;
    if (!world_a && !world_b) {
      sweep.addPiecePair(lane_pieces[at(pair.a)].piece, lane_pieces[at(pair.b)].piece, pair.motion,
                         pair.threshold, !pair.by_surfaces, kOfRobot, pair.gap >= 0);
      continue;
    }
    const RobotLanes::Piece& mover = lane_pieces[at(world_a ? pair.b : pair.a)];
    const RobotLanes::Piece& still = lane_pieces[at(world_a ? pair.a : pair.b)];
    sweep.addPair(mover.piece, still.obstacle, still.piece, pair.threshold, !pair.by_surfaces,
                  pair.is_self ? kOfRobot : kOfWorld, pair.gap >= 0);
  }
}

void SceneLanes::setWorld(const CompiledScene& scene, const EdgeScene& edges,
                          std::span<const RobotLanes::Piece> lane_pieces) {
  std::vector<LaneSweep::Row> rows;
  for (const EdgePairs::Row& row : edges.pairs.rows())
    rows.push_back({lane_pieces[at(row.piece)].piece, row.most_threshold});
  sweep.setWorld(std::make_shared<EdgeWorld>(edges, scene.scene()), rows,
                 scene.scene().pairs().places(), collision::SceneAccess::sharedBoxes(scene.scene()),
                 collision::SceneAccess::scaleOfStill(scene.scene()));
}

EdgeLanes::EdgeLanes(const EdgeFrames& frames, collision::Scratch& queries, collision::Work& work)
    : scene_(frames.sharedScene()),
      lanes_(scene_->lanes()),
      robot_(lanes_.robot),
      work_(work),
      scratch_(lanes_.sweep, queries, work),
      frame_steps_(robot_.frame_steps),
      frames_(collision::spareArray<collision::LaneFrame>(2 * robot_.steps.size())),
      lane_frames_(frames_.get(), robot_.steps.size()),
      contact_frames_(frames_.get() + robot_.steps.size(), robot_.steps.size()) {
  const robots::Model& model = scene_->model();
  middle_.resize(at(scene_->space().size()));
  q_.resize(model.variables.size());
  joint_motion_.assign(2 * model.joints.size(), 0.0F);
  growth_values_.resize(robot_.growth.paddedSize());
  pass_growth_.resize(growth_values_.size());
  const std::size_t most_kept = frames.pairs().listed().size() + LaneSweep::kMostNear;
  closed_.reserve(std::min(frames.pairs().size(), most_kept));
}

/// Computes a joint's step for the current edge. q_ is the configuration in the edge's middle,
/// except for quaternions, which are those of its start.
void EdgeLanes::setStep(const EdgeFrames& frames, std::size_t i) {
  const Step& step = robot_.steps[i];
  const Joint& joint = scene_->model().joints[at(step.joint)];
  collision::FrameStep& out = frame_steps_[i];
  const Eigen::Matrix3d& R_PJ = step.X_PJ.rotation;
  const Eigen::Vector3d& p_PJ = step.X_PJ.translation;
  const double* q = &q_[step.variable];
  const double* dq = &frames.configurationDifference()[step.variable];
  switch (joint.type) {
    case JointType::kFixed:
      break;
    case JointType::kRevolute:
    case JointType::kContinuous:
      setTurn(step.multiplier * q[0] + step.offset, step.multiplier * dq[0], out);
      break;
    case JointType::kPrismatic: {
      const Eigen::Vector3d axis = R_PJ * joint.axis;
      copyVector(p_PJ + axis * (step.multiplier * q[0] + step.offset), out.translation);
      copyVector(axis * (step.multiplier * dq[0]), out.slide);
      break;
    }
    case JointType::kPlanar: {
      Eigen::Vector3d u, v;
      robots::planeAxes(joint.axis, u, v);
      copyVector(p_PJ + R_PJ * (u * q[0] + v * q[1]), out.translation);
      copyVector(R_PJ * (u * dq[0] + v * dq[1]), out.slide);
      setTurn(q[2], dq[2], out);
      break;
    }
    case JointType::kFloating:
      setFloatingStep(step, q, dq, out);
      break;
  }
}

void EdgeLanes::setFloatingStep(const Step& step, const double* q, const double* dq,
                                collision::FrameStep& out) const {
  const Eigen::Matrix3d& R_PJ = step.X_PJ.rotation;
  const Eigen::Vector3d r(dq[3], dq[4], dq[5]);
  const double turn = r.norm();
  // For a zero turn, any axis is acceptable.
  const Eigen::Matrix3d align =
      turn > kLeastTurn ? turningZ(r / turn) : Eigen::Matrix3d::Identity();
  if (step.restores) {
    copyMatrix(align.transpose(), out.rotation);
    return;
  }
  copyVector(step.X_PJ.translation + R_PJ * Eigen::Vector3d(q[0], q[1], q[2]), out.translation);
  copyVector(R_PJ * Eigen::Vector3d(dq[0], dq[1], dq[2]), out.slide);
  const Eigen::Matrix3d start =
      Eigen::Quaterniond(q[6], q[3], q[4], q[5]).normalized().toRotationMatrix();
  copyMatrix(R_PJ * start * align, out.rotation);
  setTurn(turn / 2, turn, out);
}

bool EdgeLanes::begin(const EdgeFrames& frames) {
  if (frames.sharedScene() != scene_ || !lanes_.usable || !frames.isWithinLimits()) return false;
  const std::span<const double> a = frames.start(), difference = frames.difference();
  for (const ConfigurationSpace::Part& part : scene_->space().parts()) {
    const std::size_t i = at(part.first);
    if (part.kind == ConfigurationSpace::Kind::kRotation)
      std::copy(&a[i], &a[i] + 4, &middle_[i]);
    else
      middle_[i] = a[i] + difference[i] / 2;
  }
  scene_->expand(middle_, q_);
  double turns = 0, slides = 0;  // of all steps over half an interval [rad, m]
  for (std::size_t i = 0; i < robot_.steps.size(); ++i) {
    const robots::JointMotion& motion = frames.jointMotion()[at(robot_.steps[i].joint)];
    if (!(motion.angle <= static_cast<double>(collision::kLargestLaneTurn))) return false;
    turns += motion.angle;
    slides += motion.travel;
    setStep(frames, i);
  }
  turns /= 2 * collision::kLanes;
  slides /= 2 * collision::kLanes;
  // Over every chain, the sum of the lengths from each of its steps to its end is at most (steps +
  // 1) times the longest chain.
  const double rounding = collision::kLaneRounding * (robot_.deepest + 1) * lanes_.longest;
  slack_ = collision::floatAbove(rounding * (1 + 4 * turns) +
                                 2 * robot_.deepest * collision::kLaneRounding * slides);
  return true;
}

void EdgeLanes::placeFrames(const collision::LaneValues& places,
                            std::span<collision::LaneFrame> frames) {
  work_.add(collision::kLanePassWork);
  collision::placeFrames(frame_steps_, places, frames);
}

void EdgeLanes::beginPass(const EdgeFrames& frames, const collision::LaneValues& middles) {
  collision::moveFrames(frame_steps_, middles, kWidth, lane_frames_);
  const std::span<const robots::JointMotion> motion = frames.jointMotion();
  for (const int moved : frames.movedJoints()) {
    const std::size_t j = at(moved);
    joint_motion_[j] = collision::floatAbove(motion[j].angle);
    joint_motion_[motion.size() + j] = collision::floatAbove(motion[j].travel);
  }
  robot_.growth.run(joint_motion_, growth_values_);
  pass_growth_ = growth_values_;
}

namespace {

std::uint8_t kindsOf(Pairs asked) {
  if (asked == Pairs::kAll) return kOfWorld | kOfRobot;
  return asked == Pairs::kSelf ? kOfRobot : kOfWorld;
}

/// EdgeFrames::keepsGap() over the whole edge.
class GapProofs final : public LaneSweep::Proofs {
 public:
  GapProofs(const EdgeFrames& frames, const Asked& asked, double beyond)
      : frames_(frames), asked_(asked), beyond_(beyond) {}
  bool keeps(int id) const override {
    const EdgePair& pair = frames_.pairs().listed()[at(id)];  // only listed pairs have proofs
    return frames_.keepsGap(pair, asked_.thresholdOf(pair) + beyond_, 0, 1);
  }

 private:
  const EdgeFrames& frames_;
  const Asked& asked_;
  double beyond_;
};

}  // namespace

LaneSweep::Contact EdgeLanes::sweep(const EdgeFrames& frames, const Asked& asked) {
  placeFrames(kMiddles, lane_frames_);
  const LaneSweep::Contact again =
      lanes_.sweep.meetAgain(lane_frames_, slack_, scratch_, kindsOf(asked.pairs));
  if (again.id >= 0) return again;
  beginPass(frames, kMiddles);
  demandInPass(beyond_);
  const GapProofs proofs(frames, asked, 0);
  return lanes_.sweep.run(lane_frames_, pass_growth_, slack_, scratch_,
                          {kindsOf(asked.pairs), &proofs});
}

/// Growth is a distance that must be kept in addition to the threshold. So is `beyond`.
void EdgeLanes::demandInPass(double beyond) {
  if (!(beyond > 0)) return;
  const float wider = collision::floatAbove(beyond);
  for (float& growth : pass_growth_) growth = (growth + wider) * (1 + 0x1p-22F);  // rounded up
}

LaneSweep::Contact EdgeLanes::sweepBeyond(const EdgeFrames& frames, const Asked& asked,
                                          double beyond) {
  placeFrames(kMiddles, lane_frames_);
  beginPass(frames, kMiddles);
  demandInPass(beyond);
  const GapProofs proofs(frames, asked, beyond);
  return lanes_.sweep.run(lane_frames_, pass_growth_, slack_, scratch_,
                          {kindsOf(asked.pairs), &proofs});
}

void EdgeLanes::closeGaps(const EdgeFrames& frames, const Asked& asked) {
  constexpr double kShare = 1.0 / collision::kLanes;
  bool closes = false;
  closed_.clear();
  for (const LaneSweep::Open& open : scratch_.open()) {
    closed_.push_back(0);
    if (at(open.id) >= frames.pairs().listed().size()) continue;  // with the world
    const EdgePair& pair = frames.pairs().listed()[at(open.id)];
    if (pair.gap < 0) continue;
    for (int interval = 0; interval < collision::kLanes; ++interval)
      if ((open.intervals >> interval & 1U) != 0 &&
          frames.keepsGap(pair, asked.thresholdOf(pair), interval * kShare,
                          (interval + 1) * kShare))
        closed_.back() |= 1U << interval;
    closes = closes || closed_.back() != 0;
  }
  if (closes) scratch_.close(closed_);
}

LaneSweep::Contact EdgeLanes::searchPlanes() {
  return lanes_.sweep.separate(lane_frames_, pass_growth_, slack_, scratch_);
}

EdgeLanes::Parts::Range EdgeLanes::Parts::rangeOf(std::uint32_t intervals) const {
  double begin = 1, end = 0;  // parts need not be in the order of time
  for (int interval = 0; interval < collision::kLanes; ++interval) {
    if ((intervals >> interval & 1U) == 0) continue;
    begin = std::min(begin, from[interval]);
    end = std::max(end, from[interval] + width);
  }
  return {begin, end - begin};
}

const EdgeLanes::Parts& EdgeLanes::wholeEdge() {
  static const Parts whole = [] {
    Parts parts;
    parts.width = 1.0 / collision::kLanes;
    for (int i = 0; i < collision::kLanes; ++i) parts.from[i] = i * parts.width;
    return parts;
  }();
  return whole;
}

LaneSweep::Contact EdgeLanes::sweepParts(const Parts& parts,
                                         std::span<const LaneSweep::Open> pairs) {
  const auto width = static_cast<float>(parts.width);
  collision::LaneValues middles;
  for (int i = 0; i < collision::kLanes; ++i)
    middles.at[i] = static_cast<float>(parts.from[i] - 0.5) + width / 2;
  placeFrames(middles, lane_frames_);
  collision::moveFrames(frame_steps_, middles, width, lane_frames_);
  const float share_squared = width * collision::kLanes * (width * collision::kLanes);
  for (std::size_t i = 0; i < growth_values_.size(); ++i)
    pass_growth_[i] = share_squared * growth_values_[i];
  demandInPass(beyond_);
  return lanes_.sweep.runPairs(pairs, lane_frames_, pass_growth_, slack_, scratch_);
}

std::optional<double> EdgeLanes::findContact(int pair, double from, double width) {
  if (!lanes_.sweep.canMeet(pair, scratch_)) return std::nullopt;
  // Checks the middle of each share. Over the whole edge these are the middles of sweep(),
  // so the ends of the shares are checked instead.
  const double share = width / collision::kLanes, first = width < 1 ? share / 2 : share;
  collision::LaneValues places;
  for (int i = 0; i < collision::kLanes; ++i)
    places.at[i] = static_cast<float>(from - 0.5 + (first + i * share));
  placeFrames(places, contact_frames_);
  const LaneSweep::Contact contact = lanes_.sweep.meet(pair, contact_frames_, slack_, scratch_);
  if (contact.id < 0) return std::nullopt;
  return 0.5 + static_cast<double>(places.at[contact.interval]);
}

LaneSweep::Contact EdgeLanes::checkStates(const collision::LaneValues& places) {
  placeFrames(places, lane_frames_);
  const LaneSweep::Contact again = lanes_.sweep.meetAgain(lane_frames_, slack_, scratch_);
  return again.id >= 0 ? again : lanes_.sweep.runStill(lane_frames_, slack_, scratch_);
}

}  // namespace leeway::planner
