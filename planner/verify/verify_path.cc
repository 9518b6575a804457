// Conservative advancement, after Mirtich (1996) and Zhang, Lee and Kim (2006), in its simplest
// form. A queue holds the open intervals of t for each edge and each pair of shapes. The distance d
// at an interval's middle and the pair's speed bound v prove the part of the interval where
//
//   |t - middle| v < (d - margin) / 2
//
// The rest on both sides goes back to the queue.
//
// An obstacle that moves is placed at the time of the middle, and v includes its speed. If only a
// bound on its motion is known since it was seen, d is reduced by how far it can have moved.
//
// A cloud is a tree of balls, and each ball contains those below it. An interval is checked with
// the tree's root first. If a ball does not suffice, the interval is checked with its children.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "leeway/collision/distance.h"
#include "leeway/planner/verify.h"
#include "planner/base/clock.h"
#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"
#include "planner/verify/ball_tree.h"
#include "planner/verify/frame_check.h"
#include "planner/verify/kinematics.h"
#include "planner/verify/pairs.h"
#include "planner/verify/path_check.h"
#include "planner/verify/pose_check.h"
#include "planner/verify/task_check.h"
#include "planner/verify/timed_check.h"

namespace leeway::planner {
namespace {

using namespace verification;
using collision::DistanceRequest;
using collision::DistanceResult;
using collision::DistanceStatus;
using robots::JointType;
using robots::Model;
using robots::Pose;

/// One shape of one body against one of another.
struct ShapePair {
  const BodyPair* bodies;
  const robots::Geometry* a;
  const robots::Geometry* b;
  Sphere sphere_a, sphere_b;
};

/// One shape of one body against the cloud of another.
struct CloudPair {
  const BodyPair* bodies;
  bool is_of_a;  ///< the shape's body is the first of the two
  const robots::Geometry* shape;
  Sphere sphere;
  const BallTree* cloud;  ///< in the segment that is checked; null: without a ball

  /// The body with the cloud.
  std::size_t body() const { return is_of_a ? bodies->b : bodies->a; }
};

/// Trees that are kept, of clouds that were seen in different steps [count].
constexpr std::size_t kMostTrees = 64;

class Verifier {
 public:
  Verifier(const Problem& problem, const Path& path, const PlanOptions& options,
           const ClearanceWish& wish, TimedPath* timed = nullptr)
      : problem_(problem),
        model_(*problem.robot.model),
        path_(path),
        options_(options),
        wish_(wish),
        timed_(timed),
        space_(problem.robot.model, problem.robot.variables) {
    result_.clearance_lower = kInfinity;
    q_ = problem.start;
    point_.resize(at(space_.size()));
    difference_.resize(at(space_.size()));
    dq_.resize(model_.variables.size());
    collision::countInto(scratch_, cost_);
  }

  VerifyResult run() {
    model_.expectMeshes();
    if (const std::optional<PathFault> fault =
            findFault(problem_, space_, path_, timed_ == nullptr)) {
      const std::size_t last = path_.positions.size() < 2 ? 0 : path_.positions.size() - 2;
      const double t = fault->waypoint > last ? 1 : 0;
      return fail(VerifyStatus::kRefuted, std::min(fault->waypoint, last), t, t, nullptr,
                  fault->reason);
    }
    collectShapes();
    result_.unchecked = countUnchecked(pairs_.unchecked);
    if (!pairs_.nothing_checked.empty())
      return fail(VerifyStatus::kNothingChecked, 0, 0, 1, nullptr, pairs_.nothing_checked);
    // A path of one waypoint is an edge without motion.
    const std::size_t segments = std::max<std::size_t>(1, path_.positions.size() - 1);
    // A sampled trajectory has many edges, so the work limit grows with their number.
    std::size_t pairs = shapes_.size();
    for (const CloudPair& pair : clouds_) pairs += mostBalls(pair.body());
    const double looks = kVerifyLooks * static_cast<double>(segments * pairs);
    most_work_ = kVerifyWork + static_cast<long>(looks);
    most_cost_ = kVerifyCost * (most_work_ / kVerifyWork);
    for (std::size_t s = 0; s < segments; ++s)
      if (!checkSegment(s)) break;
    if (refuted_) return *refuted_;
    if (auto broken = findBrokenConstraint(problem_, path_, options_.stop)) {
      broken->unchecked = result_.unchecked;
      if (broken->status == VerifyStatus::kRefuted || !undecided_) return *broken;
    }
    if (auto unaccepted = findUnaccepted(problem_, space_, path_)) {
      unaccepted->unchecked = result_.unchecked;
      return *unaccepted;
    }
    if (undecided_) return *undecided_;
    result_.status = VerifyStatus::kCertified;
    if (problem_.condition.accept) result_.conditions = kSampled;
    refine(segments);
    for (const Object& object : problem_.world.objects)
      if (object.cloud)
        result_.clearance_lower = std::min(result_.clearance_lower, object.cloud->completeWithin());
    if (closest_ != nullptr) {
      result_.closest_a = bodies_[closest_->a].name;
      result_.closest_b = bodies_[closest_->b].name;
    }
    return result_;
  }

 private:
  /// Narrows the interval of a certified path's clearance. Proves that every pair is farther apart
  /// than the least distance found so far minus a width. The number of looks is inverse to the
  /// width for pairs that keep their distance, and to its root for pairs that pass each other.
  void refine(std::size_t segments) {
    const double others = wish_.others.upper;
    const auto is_enough = [&] {
      return result_.clearance_lower >= others ||
             wish_.is_enough({std::min(result_.clearance_lower, wish_.others.lower),
                              std::min(result_.clearance_upper, others)});
    };
    if (!wish_.is_enough) return;
    work_ = 0;
    most_work_ = kVerifyRefineWork;
    most_cost_ = cost_.done + kVerifyRefineCost;
    for (width_ = kVerifyWidest; width_ >= kVerifyNarrowest && !is_enough(); width_ /= 10) {
      for (std::size_t s = 0; s < segments; ++s)
        if (!checkSegment(s) || undecided_) return;
      const double least = std::min(result_.clearance_upper, others) - width_;
      result_.clearance_lower = std::max(result_.clearance_lower, least);
    }
  }

  /// The separation that a pair is proven to exceed [m].
  double floorOf(const ShapePair& pair) const {
    const double least = std::min(result_.clearance_upper, wish_.others.upper);
    return std::max(provableMargin(pair), least - width_);  // an infinite width: the margin
  }
  /// The share of the room above the floor that a proof may use up. Proofs of margins use half of
  /// it, so that they also prove a clearance that is larger than the margin.
  double roomShare() const { return isRefining() ? 1 : 0.5; }
  bool isRefining() const { return width_ < kInfinity; }
  /// Records a bound that was proven for some span. While refining, all spans have the same bound.
  void proven(double bound) {
    if (!isRefining()) result_.clearance_lower = std::min(result_.clearance_lower, bound);
  }

  struct Span {
    double begin, end;
  };

  VerifyResult fail(VerifyStatus status, std::size_t segment, double t0, double t1,
                    const ShapePair* pair, const std::string& reason) const {
    VerifyResult result;
    result.status = status;
    result.unchecked = result_.unchecked;
    result.segment = static_cast<int>(segment);
    result.t0 = t0;
    result.t1 = t1;
    if (pair != nullptr) {
      result.a = bodies_[pair->bodies->a].name;
      result.b = bodies_[pair->bodies->b].name;
    }
    result.reason = reason;
    return result;
  }

  struct Look;
  static std::string tooNear(const Look& look, double margin) {
    char text[96];
    const double upper = look.distance.upper - look.nearer;
    if (upper <= 0)
      std::snprintf(text, sizeof text, "at least %.3f mm deep", std::floor(-upper * 1e6) / 1e3);
    else
      std::snprintf(text, sizeof text, "at most %.3f mm apart", std::ceil(upper * 1e6) / 1e3);
    const std::string found =
        look.nearer > 0 ? text + std::string(" if it moves as its bounds allow") : text;
    std::snprintf(text, sizeof text, "; they must be more than %.6g mm apart", margin * 1e3);
    return found + text;
  }

  void leaveOpen(std::size_t segment, const Span& span, const ShapePair* pair,
                 const std::string& reason) {
    if (!undecided_)
      undecided_ = fail(VerifyStatus::kUndecided, segment, span.begin, span.end, pair, reason);
  }

  void collectShapes() {
    bodies_ = collectBodies(problem_);
    if (timed_ != nullptr) {
      movers_.resize(bodies_.size());
      for (std::size_t b = 0; b < bodies_.size(); ++b)
        for (std::size_t m = 0; m < timed_->bodies.size(); ++m)
          if (bodies_[b].link < 0 && bodies_[b].name == timed_->bodies[m].name()) movers_[b] = m;
    }
    pairs_ = collectPairs(problem_, bodies_);
    for (const BodyPair& pair : pairs_.checked)
      for (const robots::Geometry& a : *bodies_[pair.a].geometries)
        for (const robots::Geometry& b : *bodies_[pair.b].geometries)
          shapes_.push_back({&pair, &a, &b, enclosingSphere(a.shape), enclosingSphere(b.shape)});
    for (const BodyPair& pair : pairs_.checked) {
      collectClouds(pair, true);
      collectClouds(pair, false);
    }
  }

  /// Pairs each shape of one body with the cloud of the other body.
  void collectClouds(const BodyPair& pair, bool is_of_a) {
    const Body& body = bodies_[is_of_a ? pair.a : pair.b];
    const std::size_t of = is_of_a ? pair.b : pair.a;
    if (bodies_[of].cloud == nullptr || mostBalls(of) == 0) return;
    for (const robots::Geometry& shape : *body.geometries)
      clouds_.push_back({&pair, is_of_a, &shape, enclosingSphere(shape.shape), nullptr});
  }

  /// The cloud of a body in a step: that of the problem, or the last one that was seen instead.
  const PointCloud* cloudIn(std::size_t step, std::size_t body) const {
    if (timed_ == nullptr || !movers_[body]) return bodies_[body].cloud;
    const Sighting& known = timed_->known[step][*movers_[body]];
    return known.cloud ? known.cloud.get() : bodies_[body].cloud;
  }
  /// The number of balls of a body's largest cloud.
  std::size_t mostBalls(std::size_t body) const {
    std::size_t most = bodies_[body].cloud->size();
    for (std::size_t step = 0; timed_ != nullptr && step < timed_->known.size(); ++step)
      most = std::max(most, cloudIn(step, body)->size());
    return most;
  }
  /// Gives each pair the tree of its cloud in the current segment.
  void takeClouds() {
    if (trees_.size() > kMostTrees) trees_.clear();
    const std::size_t step = timed_ == nullptr ? 0 : timed_->steps[segment_];
    for (CloudPair& pair : clouds_) {
      const PointCloud* const cloud = cloudIn(step, pair.body());
      pair.cloud =
          cloud->balls.empty() ? nullptr : &trees_.try_emplace(cloud, *cloud).first->second;
    }
  }

  /// Returns false if the whole path is decided or the work limit is reached.
  bool checkSegment(std::size_t segment) {
    if (timed_ != nullptr && timed_->steps[segment] == kGap) return true;
    if (options_.progress)
      options_.progress(isRefining() ? "narrowing the clearance" : "edge", secondsSince(begin_));
    a_ = path_.positions[segment];
    b_ = path_.positions[std::min(segment + 1, path_.positions.size() - 1)];
    placed_at_ = std::numeric_limits<double>::quiet_NaN();
    // The space goes the shorter way, as long as it is not nearly half a turn.
    if (timed_ != nullptr) space_.unwrap(a_, b_);
    space_.lineDifference(a_, b_, difference_);
    segment_ = segment;
    cubics_.clear();
    if (path_.times.size() > 1) cubics_ = cubicsOf(path_, segment);
    std::fill(dq_.begin(), dq_.end(), 0.0);
    for (std::size_t i = 0; i < difference_.size(); ++i)
      dq_[at(problem_.robot.variables[i])] = cubics_.empty() ? difference_[i] : cubics_[i].speed();
    if (const std::string reason = notContinuous(); !reason.empty()) {
      leaveOpen(segment, {0, 1}, nullptr, reason);
      return true;
    }
    const bool is_exposed = timed_ != nullptr && std::binary_search(timed_->exposed.begin(),
                                                                    timed_->exposed.end(), segment);
    const auto isLeft = [&](const BodyPair& pair) {
      return is_exposed && (movers_[pair.a] || movers_[pair.b]);
    };
    for (const ShapePair& pair : shapes_)
      if (!isLeft(*pair.bodies) && !checkPair(segment, pair)) return false;
    takeClouds();
    for (const CloudPair& pair : clouds_)
      if (pair.cloud != nullptr && !isLeft(*pair.bodies) && !checkCloud(segment, pair))
        return false;
    return true;
  }

  /// Returns why the edge is not a continuous motion; empty if it is one. The planner wraps circles
  /// to [-pi, pi). A mimic joint that does not turn by whole multiples of its master jumps there.
  std::string notContinuous() const {
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t i = at(part.first);
      if (!cubics_.empty() && part.kind == ConfigurationSpace::Kind::kRotation)
        return "numbers of an orientation that move on cubics";
      if (part.kind == ConfigurationSpace::Kind::kRotation) continue;
      if (!cubics_.empty() && !cubics_[i].isShort())
        return "a cubic with a coefficient beyond " + numberText(kVerifyCubic) +
               ": rounding is not small there";
      if (std::abs(a_[i]) > kLargestAngle * 10 || std::abs(b_[i]) > kLargestAngle * 10)
        return "a value beyond 10000: rounding is not small there";
      if (std::abs(difference_[i]) > kLargestAngle &&
          part.kind == ConfigurationSpace::Kind::kCircle)
        return "a turn of more than 1000 rad: rounding is not small there";
      if (part.kind != ConfigurationSpace::Kind::kCircle) continue;
      if (timed_ != nullptr && std::abs(difference_[i]) > kLongestLineTurn)
        return "a turn of nearly half a turn, which may go either way";
      const auto inside = [](double x) { return x >= -std::numbers::pi && x < std::numbers::pi; };
      if (inside(a_[i]) && inside(b_[i]) &&
          (cubics_.empty() || (inside(cubics_[i].least()) && inside(cubics_[i].most()))))
        continue;
      const int master = model_.variables[at(problem_.robot.variables[i])].joint;
      for (const robots::Joint& joint : model_.joints) {
        double factor = 1;
        const robots::Joint* j = &joint;
        for (; j->mimic >= 0; j = &model_.joints[at(j->mimic)]) factor *= j->multiplier;
        const bool turns =
            joint.type == JointType::kRevolute || joint.type == JointType::kContinuous;
        if (j != &joint && j == &model_.joints[at(master)] &&
            !(turns && factor == std::round(factor)))
          return "joint " + joint.name + " mimics " + j->name +
                 " and would jump where that wraps around";
      }
    }
    return {};
  }

  /// The result for a pair at the middle of a span.
  struct Look {
    Interval distance;  ///< [m]
    DistanceStatus status = DistanceStatus::kInvalid;
    double motion = 0;  ///< bound on the shapes' approach within half of the span [m]
    double slack = 0;   ///< rounding of both placements, and `grown` [m]
    double grown = 0;   ///< how far the second shape can be from where it was placed [m]
    double nearer = 0;  ///< how much nearer it can certainly be [m]
    Motion a, b;

    /// A distance that the pair can certainly have [m].
    double upper() const { return distance.upper + (slack - grown) - nearer; }
  };

  /// Records that a pair of bodies is as near as the look found.
  void met(const Look& look, const BodyPair& bodies) {
    const double upper = look.distance.upper + look.slack;
    if (look.status == DistanceStatus::kInvalid || !(upper < result_.clearance_upper)) return;
    result_.clearance_upper = upper;
    closest_ = &bodies;
  }

  /// The poses of the links at t. Kept, because all pairs of an edge are looked at in its middle
  /// first.
  const std::vector<Pose>& poses(double t) {
    if (t == placed_at_) return X_WL_;
    if (cubics_.empty())
      space_.alongLine(a_, b_, t, point_);
    else
      for (std::size_t i = 0; i < point_.size(); ++i) point_[i] = cubics_[i].at(t);
    for (std::size_t i = 0; i < point_.size(); ++i) q_[at(problem_.robot.variables[i])] = point_[i];
    X_WL_ = placeLinks(model_, q_);
    placed_at_ = t;
    return X_WL_;
  }

  Pose place(std::size_t body, const std::vector<Pose>& X_WL) const {
    const Body& b = bodies_[body];
    return b.link < 0 ? b.X_LB : X_WL[at(b.link)] * b.X_LB;
  }

  /// The place of the second shape of a pair if it moves by itself. `half` is a share of the edge.
  std::optional<Place> placeMover(const ShapePair& pair, double t, double half) {
    if (timed_ == nullptr || !movers_[pair.bodies->b]) return std::nullopt;
    const std::size_t m = *movers_[pair.bodies->b];
    const double begin = timed_->times[segment_], end = timed_->times[segment_ + 1];
    const Sphere sphere_O{pair.b->X_BG * pair.sphere_b.center, pair.sphere_b.radius};
    return timed_->bodies[m].at(timed_->known[timed_->steps[segment_]][m],
                                begin + t * (end - begin), half * (end - begin), sphere_O);
  }

  Look look(const ShapePair& pair, double t, double half) {
    const std::vector<Pose>& X_WL = poses(t);
    const std::optional<Place> mover = placeMover(pair, t, half);
    const Pose X_WA = place(pair.bodies->a, X_WL) * pair.a->X_BG,
               X_WB = (mover ? mover->X_WO : place(pair.bodies->b, X_WL)) * pair.b->X_BG;
    Look look;
    look.a = boundMotion(model_, pair.bodies->joints_a, X_WL, dq_, X_WA * pair.sphere_a.center,
                         pair.sphere_a.radius, half);
    look.b = boundMotion(model_, pair.bodies->joints_b, X_WL, dq_, X_WB * pair.sphere_b.center,
                         pair.sphere_b.radius, half);
    look.slack = look.a.slack + look.b.slack + kVerifyRounding;
    look.motion = half * (look.a.speed + look.b.speed);
    if (mover) {
      const double duration = timed_->times[segment_ + 1] - timed_->times[segment_];
      if (duration > 0) look.motion += half * duration * mover->speed * (1 + kVerifyRounding);
      look.grown = mover->grown;
      look.nearer = mover->nearer;
      look.slack += mover->slack + mover->grown;
    }
    measure(pair, mover && mover->shape != nullptr ? *mover->shape : pair.b->shape, X_WA, X_WB,
            look);
    return look;
  }

  /// The separation that can be proven for a pair: its margin, but at least 0 for meshes, because
  /// the depth of overlapping meshes may change faster than their points move.
  static double provableMargin(const ShapePair& pair) {
    const bool convex = pair.a->shape.isConvex() && pair.b->shape.isConvex();
    return convex ? pair.bodies->margin : std::max(pair.bodies->margin, 0.0);
  }

  /// Computes the distance as exactly as needed. The first request is whether it suffices for the
  /// whole span. If it does, raises the threshold until the certified clearance does not depend on
  /// it. If not, computes its value.
  void measure(const ShapePair& pair, const collision::Shape& shape_b, const Pose& X_WA,
               const Pose& X_WB, Look& look) {
    const double margin = pair.bodies->margin, floor = isRefining() ? floorOf(pair) : margin;
    DistanceRequest request;
    request.depth = margin < 0;
    request.tolerance = kVerifyTolerance;
    request.threshold = floorOf(pair) + look.motion / roomShare() + look.slack;
    look.status = DistanceStatus::kInvalid;
    if (!std::isfinite(request.threshold))
      return;  // the rotation of an unbounded shape has no speed bound
    const auto ask = [&] {
      const DistanceResult answer =
          collision::distance(pair.a->shape, X_WA, shape_b, X_WB, request, scratch_);
      look.status = answer.status;
      look.distance.lower = std::max(look.distance.lower, answer.distance.lower);
      look.distance.upper = std::min(look.distance.upper, answer.distance.upper);
    };
    ask();
    if (look.status == DistanceStatus::kInvalid || look.upper() <= margin) return;
    if (look.distance.lower > request.threshold) {
      if (isRefining()) return;
      // It suffices. Double the threshold until it reaches the clearance so far or the true
      // distance.
      const double wanted = result_.clearance_lower + look.motion + look.slack;
      do {
        const double lower = look.distance.lower;
        request.threshold = std::min(wanted, lower + std::max(std::abs(lower), kVerifyTolerance));
        if (!(look.distance.upper > request.threshold) || !(wanted > lower)) return;
        ask();
      } while (look.status == DistanceStatus::kAboveThreshold);
      return;
    }
    // It does not suffice. Measure to a fraction of the distance. The tolerance follows the upper
    // bound, which is an estimate at first.
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    do {
      if (!std::isfinite(look.distance.upper)) return;
      request.tolerance =
          std::max(kVerifyTolerance, kVerifyFraction * (look.distance.upper - look.grown - floor));
      ask();
    } while (look.status == DistanceStatus::kConverged && request.tolerance > kVerifyTolerance &&
             look.distance.upper - look.distance.lower >
                 1.25 * kVerifyFraction * (look.distance.upper - look.grown - floor));
  }

  /// Returns false if the path is refuted or the work limit is reached.
  bool checkPair(std::size_t segment, const ShapePair& pair) {
    const double margin = pair.bodies->margin;
    std::deque<Span> open{{0, 1}};
    long limit = kVerifyPairWork;
    cost_.limit = std::min(most_cost_, cost_.done + kVerifyPairCost);
    for (long work = 0; !open.empty(); ++work) {
      if (isRefining() && undecided_) return false;
      const Span span = open.front();
      open.pop_front();
      if (work >= limit || ++work_ > most_work_ || cost_.isSpent()) {
        leaveOpen(segment, span, &pair, "not decided within the work limit");
        return work_ <= most_work_ && cost_.done <= most_cost_;
      }
      if (work_ % 64 == 0 && options_.stop && options_.stop()) {
        leaveOpen(segment, span, &pair, "stopped before it was decided");
        return false;
      }
      const double t = span.begin + (span.end - span.begin) / 2;
      const double half = std::max(t - span.begin, span.end - t);
      const Look found = look(pair, t, half);
      met(found, *pair.bodies);
      const double floor = floorOf(pair);
      if (found.status == DistanceStatus::kInvalid) {
        leaveOpen(segment, span, &pair, "no distance can be had, or no bound of the motion");
        return true;
      }
      if (found.upper() <= margin) {
        refuted_ = fail(VerifyStatus::kRefuted, segment, t, t, &pair, tooNear(found, margin));
        return false;
      }
      const double room = (found.distance.lower - found.slack - floor) * roomShare();
      if (room >= found.motion && room > 0) {
        proven(found.distance.lower - found.slack - found.motion);
        continue;
      }
      if (found.distance.upper + found.slack - 2 * found.grown <= floor) {
        // No proof is possible here, so the edge stays undecided or is refuted.
        leaveOpen(segment, {t, t}, &pair,
                  found.grown > 0 ? "it may come too near within the bounds on its motion"
                                  : "a mesh that overlaps within its margin is not proven");
        onlyRefute(work, limit);
      }
      if (found.motion <= kVerifySmallestMotion || !(t > span.begin && t < span.end)) {
        leaveOpen(segment, span, &pair, "too near to decide");
        onlyRefute(work, limit);
        continue;
      }
      split(span, t, half, room, found, open);
    }
    return true;
  }

  /// A part of a cloud, and the span in which its distance from the shape is still to be proven.
  struct OpenPart {
    std::size_t node;
    Span span;
  };

  /// The shapes of a pair, with the ball `part` in place of the cloud.
  static ShapePair withPart(const CloudPair& pair, const robots::Geometry& part) {
    const Sphere around = enclosingSphere(part.shape);
    return pair.is_of_a ? ShapePair{pair.bodies, pair.shape, &part, pair.sphere, around}
                        : ShapePair{pair.bodies, &part, pair.shape, around, pair.sphere};
  }

  /// checkPair() for a shape and all balls of a cloud at once.
  bool checkCloud(std::size_t segment, const CloudPair& pair) {
    std::vector<OpenPart> open{{0, {0, 1}}};
    const long limit =
        std::min(most_work_, work_ + kVerifyPairWork + static_cast<long>(pair.cloud->ballCount()));
    cost_.limit = most_cost_;
    while (!open.empty()) {
      if (isRefining() && undecided_) return false;
      const OpenPart part = open.back();
      open.pop_back();
      const PointCloud::Ball& ball = pair.cloud->ball(part.node);
      if (ball.radius > collision::kLargestSize && !pair.cloud->isBall(part.node)) {
        const auto [left, right] = pair.cloud->children(part.node);
        open.push_back({right, part.span});
        open.push_back({left, part.span});
        continue;
      }
      const robots::Geometry geometry{
          collision::Shape::sphere(ball.radius), {Eigen::Matrix3d::Identity(), ball.center}, {}};
      const ShapePair shapes = withPart(pair, geometry);
      if (++work_ > limit || cost_.isSpent()) {
        leaveOpen(segment, part.span, &shapes, "not decided within the work limit");
        return work_ <= most_work_ && cost_.done <= most_cost_;
      }
      if (work_ % 64 == 0 && options_.stop && options_.stop()) {
        leaveOpen(segment, part.span, &shapes, "stopped before it was decided");
        return false;
      }
      switch (checkPart(segment, pair, part, ball.radius, shapes, open)) {
        case PartAnswer::kGoOn:
          break;
        case PartAnswer::kUndecided:
          return true;
        case PartAnswer::kRefuted:
          return false;
      }
    }
    return true;
  }

  enum class PartAnswer : unsigned char { kGoOn, kUndecided, kRefuted };

  /// Looks at the middle of the span and adds what remains open to `open`.
  PartAnswer checkPart(std::size_t segment, const CloudPair& pair, const OpenPart& part,
                       double radius, const ShapePair& shapes, std::vector<OpenPart>& open) {
    const auto [node, span] = part;
    const double t = span.begin + (span.end - span.begin) / 2;
    const double half = std::max(t - span.begin, span.end - t);
    const Look found = look(shapes, t, half);
    const bool is_ball = pair.cloud->isBall(node);
    if (is_ball) met(found, *pair.bodies);
    if (found.status == DistanceStatus::kInvalid) {
      leaveOpen(segment, span, &shapes, "no distance can be had, or no bound of the motion");
      return PartAnswer::kUndecided;
    }
    if (is_ball && found.upper() <= pair.bodies->margin) {
      refuted_ =
          fail(VerifyStatus::kRefuted, segment, t, t, &shapes, tooNear(found, pair.bodies->margin));
      return PartAnswer::kRefuted;
    }
    const double room = (found.distance.lower - found.slack - floorOf(shapes)) * roomShare();
    const double clearance = found.distance.lower - found.slack - found.motion;
    // The certified clearance must not depend on a ball that is much larger than its contents.
    const bool is_coarse = !isRefining() && !is_ball && clearance < result_.clearance_lower &&
                           radius > kVerifyCoarse * found.distance.lower;
    if (room >= found.motion && room > 0 && !is_coarse) {
      proven(clearance);
      return PartAnswer::kGoOn;
    }
    const bool is_short =
        found.motion <= kVerifySmallestMotion || !(t > span.begin && t < span.end);
    if (!is_ball && (is_coarse || is_short || !(radius < found.motion))) {
      const auto [left, right] = pair.cloud->children(node);
      open.push_back({right, span});
      open.push_back({left, span});
      return PartAnswer::kGoOn;
    }
    if (is_short) {
      leaveOpen(segment, span, &shapes, "too near to decide");
      return PartAnswer::kUndecided;
    }
    std::deque<Span> remains;
    split(span, t, half, room, found, remains);
    for (const Span& remain : remains) open.push_back({node, remain});
    return PartAnswer::kGoOn;
  }

  /// Reduces the pair's limits, because after an undecided part only a refutation matters.
  void onlyRefute(long work, long& limit) {
    limit = std::min(limit, work + kVerifyOpenWork);
    cost_.limit = std::min(cost_.limit, cost_.done + kVerifyOpenCost);
  }

  /// Proves the part around t that the room covers. Puts the rest of the span back into the queue.
  void split(const Span& span, double t, double half, double room, const Look& found,
             std::deque<Span>& open) {
    double done = 0;
    if (room > 0 && std::isfinite(found.motion)) {
      // The speed bounds of half the span hold for any part of it.
      done = half * (room / found.motion) * (1 - kVerifyRounding);
      proven(found.distance.lower - found.slack - room);
    }
    if (t - done > span.begin) open.push_back({span.begin, t - done});
    if (t + done < span.end) open.push_back({t + done, span.end});
  }

  const Problem& problem_;
  const Model& model_;
  const Path& path_;
  const PlanOptions& options_;
  const ClearanceWish& wish_;
  TimedPath* timed_;  ///< null: nothing moves by itself
  const Clock::time_point begin_ = Clock::now();
  ConfigurationSpace space_;
  std::vector<Body> bodies_;
  std::vector<std::optional<std::size_t>> movers_;  ///< of bodies: which of timed_->bodies
  std::size_t segment_ = 0;
  verification::Pairs pairs_;
  std::vector<ShapePair> shapes_;
  std::map<const PointCloud*, BallTree> trees_;
  std::vector<CloudPair> clouds_;
  std::vector<double> a_, b_, point_, difference_, q_, dq_;
  std::vector<Cubic> cubics_;  ///< of the segment; empty: a line
  collision::Work cost_;       // of the distances
  collision::Scratch scratch_;
  VerifyResult result_;
  const BodyPair* closest_ = nullptr;  ///< of result_.clearance_upper
  std::optional<VerifyResult> refuted_, undecided_;
  std::vector<Pose> X_WL_;    // at placed_at_
  double width_ = kInfinity;  ///< finite while refining [m]
  double placed_at_ = std::numeric_limits<double>::quiet_NaN();
  long work_ = 0, most_work_ = 0;
  std::int64_t most_cost_ = 0;
};

}  // namespace

VerifyResult verification::verifyValid(const Problem& problem, const Path& path,
                                       const PlanOptions& options, const ClearanceWish& wish) {
  return Verifier(problem, path, options, wish).run();
}

VerifyResult verification::verifyTimed(const Problem& problem, TimedPath& motion,
                                       const PlanOptions& options, const ClearanceWish& wish) {
  return Verifier(problem, motion.path, options, wish, &motion).run();
}

namespace {

/// The result for a start that is given by poses: the path must begin at them.
VerifyResult verifyFromPoses(const Problem& problem, const Path& path, const PlanOptions& options,
                             const std::function<bool(const Interval&)>& is_enough) {
  VerifyResult refuted;
  refuted.status = VerifyStatus::kRefuted;
  refuted.segment = 0;
  refuted.reason = "the path has no waypoints, or not one value for each planned variable";
  const std::vector<int>& variables = problem.robot.variables;
  if (path.positions.empty() || path.positions.front().size() != variables.size()) return refuted;
  const std::vector<double>& first = path.positions.front();
  Problem placed = problem;
  placed.start_poses.clear();
  for (std::size_t i = 0; i < first.size(); ++i) placed.start[at(variables[i])] = first[i];
  const std::vector<Pose> X_WL = placeLinks(*problem.robot.model, placed.start);
  refuted.reason = "the first waypoint is not at the poses of the start, or is outside the limits";
  const bool is_there =
      ConfigurationSpace(problem.robot.model, variables).withinLimits(first) &&
      std::all_of(problem.start_poses.begin(), problem.start_poses.end(),
                  [&](const robots::PoseRegion& pose) { return isInRegion(pose, X_WL); });
  return is_there ? verify(placed, path, options, is_enough) : refuted;
}

}  // namespace

VerifyResult verify(const Problem& problem, const Path& path, const PlanOptions& options,
                    const std::function<bool(const Interval&)>& is_enough) {
  validate(problem);
  if (!problem.start_poses.empty()) return verifyFromPoses(problem, path, options, is_enough);
  if (!path.times.empty() && problem.condition.accept) {
    VerifyResult result;
    result.reason =
        "the rows are joined by cubics, and conditions are looked at along straight lines only; a "
        "path's file (--output) has lines";
    return result;
  }
  if (!problem.steps.empty()) return verifyTask(problem, path, options, {is_enough});
  requireGoals(problem, "verify()");
  return verifyValid(problem, path, options, {is_enough});
}

}  // namespace leeway::planner
