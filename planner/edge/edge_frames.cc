#include "planner/edge/edge_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/rounding.h"
#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/lanes/obstacle_boxes.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/prepared_robot.h"

namespace leeway::planner {

EdgeFrames::EdgeFrames(std::shared_ptr<const CompiledScene> scene, int capacity)
    : scene_(std::move(scene)), links_(scene_->model().links.size()), capacity_(capacity) {
  const ConfigurationSpace& space = scene_->space();
  const auto size = static_cast<std::size_t>(space.size());
  const std::size_t variables = scene_->model().variables.size();
  numbers_.resize(4 * size + 2 * variables);
  double* next = numbers_.data();
  for (std::span<double>* point : {&a_, &b_, &difference_, &point_})
    *point = {std::exchange(next, next + size), size};
  for (std::span<double>* q : {&q_, &dq_}) *q = {std::exchange(next, next + variables), variables};
  shared_slots_ = collision::spareArray<int>(kSharedPlaces + 1);
  only_lines_ = std::all_of(space.parts().begin(), space.parts().end(), [](const auto& part) {
    return part.kind == ConfigurationSpace::Kind::kLine;
  });
  take();
  joint_motion_.resize(scene_->model().joints.size());
  poses_.reserve(at(capacity) * links_);
  centers_.reserve(at(capacity) * moving_.size());
}

void EdgeFrames::rebind(std::shared_ptr<const CompiledScene> scene) {
  scene_ = std::move(scene);
  take();
  release(0);
}

EdgePair EdgeFrames::findPair(int number) const {
  const EdgePairs& all = edges_->pairs;
  return known_pairs_.of(number - static_cast<int>(all.listed().size()), [&](std::int32_t) {
    return all.inTable(at(number), piece(all.stillOf(at(number))));
  });
}

const Piece& EdgeFrames::findPiece(int number) const {
  return known_pieces_.of(number - static_cast<int>(edges_->pieces.listed().size()),
                          [&](std::int32_t) { return edges_->pieces[at(number)]; });
}

void EdgeFrames::take() {
  edges_ = &scene_->edges();
  known_pairs_.resize(edges_->pairs.numbers() - edges_->pairs.listed().size());
  known_pieces_.resize(scene_->scene().pairs().places());
  moving_ = edges_->moving;
  const RobotMotions& motions = scene_->edgeModel().robot->motions();
  largest_ = motions.largest_exact;
  moved_joints_ = motions.moved_joints;
}

namespace {

/// The largest number of arcs of a table that a range of angles crosses.
std::int64_t arcsIn(const robots::LinkGap::Range& range) {
  const double arcs =
      std::abs(range.to - range.from) * robots::LinkGap::kArcs / collision::kTwoPi + 2;
  return arcs < robots::LinkGap::kArcs ? static_cast<std::int64_t>(arcs) : robots::LinkGap::kArcs;
}

}  // namespace

robots::LinkGap::Range EdgeFrames::range(const EdgeModel::Angle& angle, double t0,
                                         double t1) const {
  if (angle.place < 0) return {angle.offset, angle.offset};
  const double start = angle.multiplier * a_[at(angle.place)] + angle.offset;
  const double turn = angle.multiplier * difference_[at(angle.place)];
  return {start + t0 * turn, start + t1 * turn};
}

bool EdgeFrames::keepsGap(const EdgePair& pair, double threshold, double t0, double t1) const {
  if (pair.gap < 0) return false;
  const EdgeModel::Gap& gap = scene_->edgeModel().gaps[at(pair.gap)];
  const robots::LinkGap::Range angles = range(gap.joint, t0, t1), others = range(gap.other, t0, t1);
  if (work_ != nullptr) work_->add(arcsIn(angles) * arcsIn(others) * collision::kCellWork);
  const double kept = gap.table->over(angles, others);
  // 0 means that nothing is proven, even if the margin lets bodies overlap.
  return kept > 0 && kept > threshold;
}

bool EdgeFrames::isExact(std::span<const double> point) const {
  for (std::size_t i = 0; i < point.size(); ++i)
    if (!(std::abs(point[i]) <= largest_[i])) return false;  // written so that NaN fails
  return true;
}

/// Also needed outside the limits: a joint without range has no motion term and must be in its
/// position, and a quaternion that is nearly zero is not a rotation.
bool EdgeFrames::isWellFormed(std::span<const double> point) const {
  const ConfigurationSpace& space = scene_->space();
  for (const ConfigurationSpace::Part& part : space.parts()) {
    const double* x = &point[at(part.first)];
    if (part.kind == ConfigurationSpace::Kind::kRotation) {
      if (!(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] > 0.25)) return false;
    } else if (space.lower(part.first) == space.upper(part.first) &&
               *x != space.lower(part.first)) {
      return false;
    }
  }
  return true;
}

/// As takeAny(), if each number of a point is a separate line, as in most robots.
bool EdgeFrames::takeLines(std::span<const double> a, std::span<const double> b) {
  const ConfigurationSpace& space = scene_->space();
  bool is_exact = true, is_well_formed = true, is_within = true;
  for (std::size_t i = 0; i < a_.size(); ++i) {
    const double x = a[i], y = b[i];
    const double lower = space.lower(static_cast<int>(i)), upper = space.upper(static_cast<int>(i));
    // All written so that NaN fails.
    is_exact &= std::abs(x) <= largest_[i] && std::abs(y) <= largest_[i];
    is_well_formed &= lower != upper || (x == lower && y == lower);
    is_within &= x >= lower && x <= upper && y >= lower && y <= upper;
    a_[i] = x;
    b_[i] = y;
    difference_[i] = y - x;
  }
  within_limits_ = is_within;
  return is_exact && is_well_formed;
}

bool EdgeFrames::takeAny(std::span<const double> a, std::span<const double> b) {
  if (!isExact(a) || !isExact(b) || !isWellFormed(a) || !isWellFormed(b)) return false;
  const ConfigurationSpace& space = scene_->space();
  std::copy(a.begin(), a.end(), a_.begin());
  std::copy(b.begin(), b.end(), b_.begin());
  space.difference(a_, b_, difference_);
  within_limits_ = space.withinLimits(a_) && space.withinLimits(b_);
  return true;
}

bool EdgeFrames::begin(std::span<const double> a, std::span<const double> b) {
  release(0);
  if (a.size() != a_.size() || b.size() != b_.size()) return false;
  if (only_lines_ ? !takeLines(a, b) : !takeAny(a, b)) return false;
  const EdgeModel& model = scene_->edgeModel();
  if (!model.isSmooth(a_, b_, difference_)) return false;
  if (!within_limits_ && scene_->completeWithin() < kInfinity) return false;
  expandDifference(scene_->space(), difference_, dq_);
  robots::jointMotion(scene_->model(), moved_joints_, dq_, joint_motion_);
  watch_reach_ = !within_limits_ || model.reach >= kLargestReach;
  return true;
}

int EdgeFrames::place(double t) {
  if (used_ >= capacity_) return -1;
  if (work_ != nullptr) work_->add(static_cast<std::int64_t>(links_) * collision::kPlacingWork);
  const int slot = used_;
  if (t == 0)
    scene_->expand(a_, q_);
  else if (t == 1)
    scene_->expand(b_, q_);
  else {
    scene_->space().advance(a_, difference_, t, point_);
    scene_->expand(point_, q_);
  }
  if (at(slot + 1) * links_ > poses_.size()) {
    poses_.resize(at(slot + 1) * links_);
    centers_.resize(at(slot + 1) * moving_.size());
  }
  const std::span<Pose> X_WL{poses_.data() + at(slot) * links_, links_};
  robots::forwardKinematics(scene_->model(), q_, X_WL);
  Eigen::Vector3d* centers = centers_.data() + at(slot) * moving_.size();
  const std::span<const Piece> listed = edges_->pieces.listed();  // all moving pieces are listed
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    const Piece& moving = listed[at(moving_[i])];
    centers[i] = X_WL[at(moving.link)] * moving.bounds().outer.center;
    // Beyond the reach the bound on rounding does not hold. Limits keep bodies within it.
    if (watch_reach_ &&
        !(centers[i].norm() + moving.bounds().outer.radius <= scene_->edgeModel().reach))
      return -1;
  }
  ++used_;
  return slot;
}

int EdgeFrames::slotAt(double t) {
  const double number = t * kSharedPlaces;
  if (number != std::floor(number)) return place(t);
  if (shared_generation_ != generation_) {
    std::fill_n(shared_slots_.get(), kSharedPlaces + 1, -1);
    shared_generation_ = generation_;
  }
  int& slot = shared_slots_[static_cast<std::size_t>(number)];
  if (slot < 0) slot = place(t);
  return slot;
}

bool EdgeFrames::nearInRow(std::size_t row, int slot, double reach,
                           collision::SpareVector<int>& pairs) const {
  const EdgePairs::Row& of = edges_->pairs.rows()[row];
  const Eigen::Vector3d& at_center = center(slot, of.piece);
  // (The rounding of the sums is far below that of single precision, which rounds outwards.)
  const double radius = piece(of.piece).bounds().outer.radius + reach + of.most_threshold;
  collision::ObstacleBoxes::Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = collision::roundedDown(at_center[k] - radius);
    box.high[k] = collision::roundedUpToFloat(at_center[k] + radius);
  }
  const collision::ScenePairs& in_scene = scene_->scene().pairs();
  if (in_scene.rows()[row].count == 0) return true;
  const collision::ObstacleBoxes& boxes = *collision::SceneAccess::boxes(scene_->scene());
  bool has_room = true;
  boxes.forEachNear(box, [&](std::size_t i) {
    const std::int32_t place = boxes.obstacle(i);
    const std::int32_t pair = place < 0 ? -1 : in_scene.numberOf(row, at(place));
    if (pair < 0) return true;
    has_room = has_room && pairs.size() < pairs.capacity();
    if (has_room) pairs.push_back(pair);
    return has_room;
  });
  return has_room;
}

Pose EdgeFrames::piecePose(int slot, int number) const {
  const Piece& p = piece(number);
  const Pose& X_WB =
      p.link >= 0 ? links(slot)[at(p.link)] : scene_->scene().bodies()[at(p.body)].X_WB;
  return p.at_origin ? X_WB : X_WB * p.geometry().X_BG;
}

Pose EdgeFrames::relative(int slot, const EdgePair& pair) const {
  const Pose X_WA = piecePose(slot, pair.a);
  const Piece& b = piece(pair.b);
  if (b.link < 0)
    return (scene_->scene().bodies()[at(b.body)].X_WB * b.geometry().X_BG).inverse() * X_WA;
  const Pose X_WB = piecePose(slot, pair.b);
  return {X_WB.rotation.transpose() * X_WA.rotation,
          X_WB.rotation.transpose() * (X_WA.translation - X_WB.translation)};
}

Eigen::Vector3d EdgeFrames::inFrameOf(int slot, int number, const Eigen::Vector3d& p_W) const {
  const std::span<const Piece> listed = edges_->pieces.listed();
  const int link = at(number) < listed.size() ? listed[at(number)].link : -1;
  if (link < 0) return p_W;
  const Pose& X_WL = links(slot)[at(link)];
  return X_WL.rotation.transpose() * (p_W - X_WL.translation);
}

robots::MotionBound EdgeFrames::motionNear(int motion, int slot, double half) const {
  return robots::localMotionBound(scene_->model(), scene_->edgeModel().motions[at(motion)],
                                  joint_motion_, links(slot), half, within_limits_);
}

}  // namespace leeway::planner
