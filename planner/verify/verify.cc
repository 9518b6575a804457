// Conservative advancement, after Mirtich (1996) and Zhang, Lee and Kim (2006), in its plainest
// form: for each edge and each pair of shapes, intervals of t wait in a queue; at the middle of one
// the distance d is taken, and where the pair's speed bound v allows no meeting within (d - margin)
// / 2 of motion, that much of the interval is done. What remains on both sides goes back to the
// queue.

#include "leeway/planner/verify.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <limits>
#include <numbers>
#include <optional>

#include "collision/base/work.h"
#include "leeway/collision/distance.h"
#include "planner/base/tolerances.h"
#include "planner/verify/verify_kinematics.h"
#include "planner/verify/verify_pairs.h"

namespace leeway::planner {
namespace {

using namespace verification;
using collision::DistanceRequest;
using collision::DistanceResult;
using collision::DistanceStatus;
using robots::JointType;
using robots::Model;
using robots::Pose;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", x);
  return buffer;
}

/// What the path must be before any geometry is looked at; empty when all is well.
class PathCheck {
 public:
  PathCheck(const Problem& problem, const ConfigurationSpace& space, const Path& path)
      : problem_(problem), space_(space), path_(path) {}

  /// The reason, and through `waypoint` where.
  std::string run(std::size_t& waypoint) const {
    waypoint = 0;
    if (path_.positions.empty()) return "the path has no waypoints";
    if (path_.names.size() != problem_.variables.size()) return columns();
    for (std::size_t i = 0; i < path_.names.size(); ++i)
      if (path_.names[i] != variable(i).name) return columns();
    for (; waypoint < path_.positions.size(); ++waypoint)
      if (const std::string reason = outside(path_.positions[waypoint]); !reason.empty())
        return reason;
    waypoint = 0;
    if (const std::string reason = notStart(path_.positions.front()); !reason.empty())
      return reason;
    waypoint = path_.positions.size() - 1;
    for (const Goal& goal : problem_.goals)
      if (meets(goal, path_.positions.back())) return {};
    return "the last waypoint is in none of the problem's goals";
  }

 private:
  const robots::Variable& variable(std::size_t i) const {
    return problem_.model->variables[at(problem_.variables[i])];
  }

  std::string columns() const {
    return "the path's columns are not the problem's planned variables";
  }

  std::string outside(const std::vector<double>& q) const {
    if (q.size() != path_.names.size())
      return "the waypoint has " + std::to_string(q.size()) + " values, " +
             std::to_string(path_.names.size()) + " are planned";
    for (std::size_t i = 0; i < q.size(); ++i) {
      const robots::Variable& v = variable(i);
      if (!std::isfinite(q[i])) return v.name + " is not finite";
      if (q[i] < v.lower - kVerifyWaypoint || q[i] > v.upper + kVerifyWaypoint)
        return v.name + " is " + text(q[i]) + ", outside its limits " + text(v.lower) + " to " +
               text(v.upper);
    }
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const double* x = &q[at(part.first)];
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        const double norm = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
        if (!(std::abs(norm - 1) <= kUnitQuaternion))
          return "the quaternion at " + variable(at(part.first)).name + " has length " +
                 text(norm) + ", not 1";
      }
    }
    return {};
  }

  static double angleBetween(double a, double b) {
    return std::remainder(a - b, 2 * std::numbers::pi);
  }

  /// Angle between two orientations [rad], for small angles.
  static double turnBetween(const double* a, const double* b) {
    double minus = 0, plus = 0;
    for (int k = 0; k < 4; ++k) {
      minus += (a[k] - b[k]) * (a[k] - b[k]);
      plus += (a[k] + b[k]) * (a[k] + b[k]);
    }
    return 2 * std::sqrt(std::min(minus, plus));
  }

  std::string notStart(const std::vector<double>& q) const {
    std::vector<double> start;
    for (const int v : problem_.variables) start.push_back(problem_.configuration[at(v)]);
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t i = at(part.first);
      const bool angle = part.kind == ConfigurationSpace::Kind::kCircle;
      const double apart = part.kind == ConfigurationSpace::Kind::kRotation
                               ? turnBetween(&q[i], &start[i])
                           : angle ? std::abs(angleBetween(q[i], start[i]))
                                   : std::abs(q[i] - start[i]);
      if (!(apart <= kVerifyWaypoint))
        return "the first waypoint is not the start: " + variable(i).name + " is " + text(q[i]) +
               ", the start's " + text(start[i]);
    }
    return {};
  }

  bool meets(const Goal& goal, const std::vector<double>& q) const {
    if (goal.ranges.size() != q.size()) return false;
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t i = at(part.first);
      if (part.kind == ConfigurationSpace::Kind::kRotation) {
        if (!orientationMeets(goal, q, i)) return false;
        continue;
      }
      const auto& [low, high] = goal.ranges[i];
      if (part.kind != ConfigurationSpace::Kind::kCircle) {
        if (!(q[i] >= low - kVerifyWaypoint && q[i] <= high + kVerifyWaypoint)) return false;
        continue;
      }
      // An angle may stand whole turns away from the range as it is written.
      const double middle = low / 2 + high / 2, half = high / 2 - low / 2;
      if (half < std::numbers::pi &&
          !(std::abs(angleBetween(q[i], middle)) <= half + kVerifyWaypoint))
        return false;
    }
    return true;
  }

  /// A goal's orientation is one quaternion, or free: [-1, 1] four times.
  static bool orientationMeets(const Goal& goal, const std::vector<double>& q, std::size_t i) {
    double given[4];
    bool free = true;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto& [low, high] = goal.ranges[i + k];
      free = free && low <= -1 && high >= 1;
      given[k] = low;
    }
    return free || turnBetween(&q[i], given) <= kVerifyWaypoint;
  }

  const Problem& problem_;
  const ConfigurationSpace& space_;
  const Path& path_;
};

/// One shape of one body against one of another.
struct ShapePair {
  const BodyPair* bodies;
  const robots::Geometry* a;
  const robots::Geometry* b;
  Sphere sphere_a, sphere_b;
};

class Verifier {
 public:
  Verifier(const Problem& problem, const Path& path, const PlanOptions& options)
      : problem_(problem),
        model_(*problem.model),
        path_(path),
        options_(options),
        space_(problem.model, problem.variables) {
    result_.clearance_lower = kInfinity;
    q_ = problem.configuration;
    point_.resize(at(space_.size()));
    difference_.resize(at(space_.size()));
    dq_.resize(model_.variables.size());
    collision::countInto(scratch_, cost_);
  }

  VerifyResult run() {
    std::size_t waypoint = 0;
    if (const std::string reason = PathCheck(problem_, space_, path_).run(waypoint);
        !reason.empty()) {
      const std::size_t last = path_.positions.size() < 2 ? 0 : path_.positions.size() - 2;
      const double t = waypoint > last ? 1 : 0;
      return fail(VerifyStatus::kRefuted, std::min(waypoint, last), t, t, nullptr, reason);
    }
    collectShapes();
    // A path of one waypoint is an edge that does not move.
    const std::size_t segments = std::max<std::size_t>(1, path_.positions.size() - 1);
    for (std::size_t s = 0; s < segments; ++s)
      if (!checkSegment(s)) break;
    if (refuted_) return *refuted_;
    if (undecided_) return *undecided_;
    result_.status = VerifyStatus::kCertified;
    return result_;
  }

 private:
  struct Span {
    double begin, end;
  };

  VerifyResult fail(VerifyStatus status, std::size_t segment, double t0, double t1,
                    const ShapePair* pair, const std::string& reason) const {
    VerifyResult result;
    result.status = status;
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

  void leaveOpen(std::size_t segment, const Span& span, const ShapePair* pair,
                 const std::string& reason) {
    if (!undecided_)
      undecided_ = fail(VerifyStatus::kUndecided, segment, span.begin, span.end, pair, reason);
  }

  void collectShapes() {
    bodies_ = collectBodies(problem_);
    pairs_ = collectPairs(problem_, bodies_);
    for (const BodyPair& pair : pairs_)
      for (const robots::Geometry& a : *bodies_[pair.a].geometries)
        for (const robots::Geometry& b : *bodies_[pair.b].geometries)
          shapes_.push_back({&pair, &a, &b, enclosingSphere(a.shape), enclosingSphere(b.shape)});
  }

  /// False: the whole can stop.
  bool checkSegment(std::size_t segment) {
    a_ = path_.positions[segment];
    b_ = path_.positions[std::min(segment + 1, path_.positions.size() - 1)];
    space_.difference(a_, b_, difference_);
    std::fill(dq_.begin(), dq_.end(), 0.0);
    for (std::size_t i = 0; i < difference_.size(); ++i)
      dq_[at(problem_.variables[i])] = difference_[i];
    if (const std::string reason = notContinuous(); !reason.empty()) {
      leaveOpen(segment, {0, 1}, nullptr, reason);
      return true;
    }
    for (const ShapePair& pair : shapes_)
      if (!checkPair(segment, pair)) return false;
    return true;
  }

  /// Positions are wrapped to [-pi, pi) inside an edge: a mimic joint that does not turn by whole
  /// multiples of its master would jump there.
  std::string notContinuous() const {
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      const std::size_t i = at(part.first);
      if (part.kind == ConfigurationSpace::Kind::kRotation) continue;
      if (std::abs(a_[i]) > kLargestAngle * 10 || std::abs(b_[i]) > kLargestAngle * 10)
        return "a value beyond 10000: rounding is not small there";
      if (part.kind != ConfigurationSpace::Kind::kCircle) continue;
      const auto inside = [](double x) { return x >= -std::numbers::pi && x < std::numbers::pi; };
      if (inside(a_[i]) && inside(b_[i]) && std::abs(b_[i] - a_[i]) <= std::numbers::pi) continue;
      const int master = model_.variables[at(problem_.variables[i])].joint;
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

  /// One look at the pair in the middle of a span.
  struct Look {
    Interval distance;  ///< [m]
    DistanceStatus status = DistanceStatus::kInvalid;
    double motion =
        0;  ///< how far the shapes can come nearer to each other within the span's half [m]
    double slack = 0;
    Motion a, b;
  };

  std::vector<Pose> poses(double t) {
    space_.interpolate(a_, b_, t, point_);
    for (std::size_t i = 0; i < point_.size(); ++i) q_[at(problem_.variables[i])] = point_[i];
    return placeLinks(model_, q_);
  }

  Pose place(std::size_t body, const std::vector<Pose>& X_WL) const {
    const Body& b = bodies_[body];
    return b.link < 0 ? b.X_LB : X_WL[at(b.link)] * b.X_LB;
  }

  Look look(const ShapePair& pair, double t, double half) {
    const std::vector<Pose> X_WL = poses(t);
    const Pose X_WA = place(pair.bodies->a, X_WL) * pair.a->X_BG,
               X_WB = place(pair.bodies->b, X_WL) * pair.b->X_BG;
    Look look;
    look.a = boundMotion(model_, pair.bodies->joints_a, X_WL, dq_, X_WA * pair.sphere_a.center,
                         pair.sphere_a.radius, half);
    look.b = boundMotion(model_, pair.bodies->joints_b, X_WL, dq_, X_WB * pair.sphere_b.center,
                         pair.sphere_b.radius, half);
    look.slack = look.a.slack + look.b.slack + kVerifyRounding;
    look.motion = half * (look.a.speed + look.b.speed);
    measure(pair, X_WA, X_WB, look);
    return look;
  }

  /// What must be proven: the margin. Below zero a mesh's distance is not known to change as slowly
  /// as its points move, so there it is zero.
  static double floorOf(const ShapePair& pair) {
    const bool convex = pair.a->shape.isConvex() && pair.b->shape.isConvex();
    return convex ? pair.bodies->margin : std::max(pair.bodies->margin, 0.0);
  }

  /// The distance as well as it is needed: first only whether it is enough for the whole span;
  /// itself where it is not, or where the proven clearance would suffer from knowing no more.
  void measure(const ShapePair& pair, const Pose& X_WA, const Pose& X_WB, Look& look) {
    const double margin = pair.bodies->margin;
    DistanceRequest request;
    request.depth = margin < 0;
    request.tolerance = kVerifyTolerance;
    request.threshold = floorOf(pair) + 2 * look.motion + look.slack;
    look.status = DistanceStatus::kInvalid;
    if (!std::isfinite(request.threshold))
      return;  // an unbounded shape that turns: nothing can be said
    const auto ask = [&] {
      const DistanceResult answer =
          collision::distance(pair.a->shape, X_WA, pair.b->shape, X_WB, request, scratch_);
      look.status = answer.status;
      look.distance.lower = std::max(look.distance.lower, answer.distance.lower);
      look.distance.upper = std::min(look.distance.upper, answer.distance.upper);
    };
    ask();
    if (look.status == DistanceStatus::kInvalid || look.distance.upper + look.slack <= margin)
      return;
    if (look.distance.lower > request.threshold) {
      // Enough. Twice as far is asked for until the proven clearance does not suffer, or it is
      // farther than the truth.
      const double wanted = result_.clearance_lower + look.motion + look.slack;
      do {
        const double lower = look.distance.lower;
        request.threshold = std::min(wanted, lower + std::max(std::abs(lower), kVerifyTolerance));
        if (!(look.distance.upper > request.threshold) || !(wanted > lower)) return;
        ask();
      } while (look.status == DistanceStatus::kAboveThreshold);
      return;
    }
    // Not enough: how much there is, to a fraction. The tolerance follows from an upper end that is
    // itself only an estimate at first.
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    do {
      if (!std::isfinite(look.distance.upper)) return;
      request.tolerance =
          std::max(kVerifyTolerance, kVerifyFraction * (look.distance.upper - margin));
      ask();
    } while (look.status == DistanceStatus::kConverged && request.tolerance > kVerifyTolerance &&
             look.distance.upper - look.distance.lower >
                 1.25 * kVerifyFraction * (look.distance.upper - margin));
  }

  /// False: refuted, or the work is used up.
  bool checkPair(std::size_t segment, const ShapePair& pair) {
    const double margin = pair.bodies->margin, floor = floorOf(pair);
    std::deque<Span> open{{0, 1}};
    long limit = kVerifyPairWork;
    cost_.limit = std::min(kVerifyCost, cost_.done + kVerifyPairCost);
    for (long work = 0; !open.empty(); ++work) {
      const Span span = open.front();
      open.pop_front();
      if (work >= limit || ++work_ > kVerifyWork || cost_.isSpent()) {
        leaveOpen(segment, span, &pair, "not decided within the work limit");
        return work_ <= kVerifyWork && cost_.done <= kVerifyCost;
      }
      if (work_ % 64 == 0 && options_.stop && options_.stop()) {
        leaveOpen(segment, span, &pair, "stopped before it was decided");
        return false;
      }
      const double t = span.begin + (span.end - span.begin) / 2;
      const double half = std::max(t - span.begin, span.end - t);
      const Look found = look(pair, t, half);
      if (found.status == DistanceStatus::kInvalid) {
        leaveOpen(segment, span, &pair, "no distance can be had, or no bound of the motion");
        return true;
      }
      if (found.distance.upper + found.slack <= margin) {
        refuted_ = fail(VerifyStatus::kRefuted, segment, t, t, &pair,
                        "not more than " + text(found.distance.upper) + " m apart, " +
                            text(margin) + " m are required");
        return false;
      }
      const double room = (found.distance.lower - found.slack - floor) / 2;
      if (room >= found.motion && room > 0) {
        result_.clearance_lower =
            std::min(result_.clearance_lower, found.distance.lower - found.slack - found.motion);
        continue;
      }
      if (found.distance.upper + found.slack <= floor) {
        // No part of the edge around here will be proven.
        leaveOpen(segment, {t, t}, &pair, "a mesh that overlaps within its margin is not proven");
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

  /// Part of the edge is left undecided: only a refutation is still of interest.
  void onlyRefute(long work, long& limit) {
    limit = std::min(limit, work + kVerifyOpenWork);
    cost_.limit = std::min(cost_.limit, cost_.done + kVerifyOpenCost);
  }

  /// What a positive room covers around t is done; the rest goes back.
  void split(const Span& span, double t, double half, double room, const Look& found,
             std::deque<Span>& open) {
    double done = 0;
    if (room > 0 && std::isfinite(found.motion)) {
      // The speed bounds hold for the whole half, so for less as well.
      done = half * (room / found.motion) * (1 - kVerifyRounding);
      result_.clearance_lower =
          std::min(result_.clearance_lower, found.distance.lower - found.slack - room);
    }
    if (t - done > span.begin) open.push_back({span.begin, t - done});
    if (t + done < span.end) open.push_back({t + done, span.end});
  }

  const Problem& problem_;
  const Model& model_;
  const Path& path_;
  const PlanOptions& options_;
  ConfigurationSpace space_;
  std::vector<Body> bodies_;
  std::vector<BodyPair> pairs_;
  std::vector<ShapePair> shapes_;
  std::vector<double> a_, b_, point_, difference_, q_, dq_;
  collision::Work cost_;  // of the distances
  collision::Scratch scratch_;
  VerifyResult result_;
  std::optional<VerifyResult> refuted_, undecided_;
  long work_ = 0;
};

}  // namespace

VerifyResult verify(const Problem& problem, const Path& path, const PlanOptions& options) {
  return Verifier(problem, path, options).run();
}

}  // namespace leeway::planner
