#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "planner/base/tolerances.h"
#include "planner/constraint/frame_motion.h"
#include "planner/execute/blend.h"
#include "planner/execute/path_timing.h"
#include "planner/execute/timed_path.h"
#include "planner/task/stages.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

/// Limit on the rate of an edge's t: the least limit / |dq|; infinite if nothing moves.
double rateLimit(const ConfigurationSpace& space, std::span<const double> dq,
                 std::span<const double> limits) {
  return 1 / timeAtLimits(space, limits, dq);
}

std::vector<double> direction(std::span<const double> difference) {
  const double length = norm(difference);
  std::vector<double> result(difference.begin(), difference.end());
  for (double& x : result) x /= length;
  return result;
}

void checkLimits(std::span<const double> limits, std::size_t size, const char* what,
                 bool infinite) {
  if (limits.size() != size)
    throw std::invalid_argument("trajectory: " + std::to_string(limits.size()) + " limits of " +
                                what + " for " + std::to_string(size) + " variables");
  for (const double x : limits)
    if (!(x > 0) || (!infinite && !std::isfinite(x)))
      throw std::invalid_argument("trajectory: a limit of " + std::string(what) + " is " +
                                  std::to_string(x) + ", it must be positive");
}

}  // namespace

Trajectory::Trajectory(std::shared_ptr<const ConfigurationSpace> space,
                       std::vector<std::vector<double>> waypoints, const MotionLimits& limits,
                       std::span<const Blend> blends, std::span<const double> least_times)
    : space_(std::move(space)),
      waypoints_(std::move(waypoints)),
      blends_(blends.begin(), blends.end()),
      least_times_(least_times.begin(), least_times.end()) {
  const std::size_t size = at(space_->size());
  if (waypoints_.empty()) throw std::invalid_argument("trajectory: a path without waypoints");
  space_->requirePath(waypoints_, "trajectory");
  const std::size_t edges = waypoints_.size() - 1;
  for (std::size_t i = 0; i < edges; ++i) {
    differences_.emplace_back(size);
    space_->difference(waypoints_[i], waypoints_[i + 1], differences_.back());
    lengths_.push_back(norm(differences_.back()));
  }
  check(limits);
  ends_.assign(edges, 1);
  times_.assign(waypoints_.size(), 0);
  double now = 0;
  for (int first = 0; first < static_cast<int>(edges);) {
    const int last = stretchEnd(first);
    bool bent = false;
    for (int corner = first + 1; corner < last; ++corner) bent = bent || blendAt(corner) != nullptr;
    if (bent)
      addBent(first, last, limits, now);
    else
      addStraight(first, last, limits, now);
    now = times_[at(last)];
    first = last;
  }
}

void Trajectory::check(const MotionLimits& limits) const {
  const std::size_t size = at(space_->size());
  checkLimits(limits.velocity, size, "velocity", false);
  checkLimits(limits.acceleration, size, "acceleration", false);
  if (!limits.jerk.empty()) checkLimits(limits.jerk, size, "jerk", true);
  if (!least_times_.empty()) {
    if (least_times_.size() + 1 != waypoints_.size())
      throw std::invalid_argument("trajectory: " + std::to_string(least_times_.size()) +
                                  " least times for " + std::to_string(waypoints_.size() - 1) +
                                  " edges");
    for (const double time : least_times_)
      if (!(time >= 0) || !std::isfinite(time))
        throw std::invalid_argument("trajectory: a least time of " + std::to_string(time) +
                                    " s, it must be 0 or more");
    if (!blends_.empty()) throw std::invalid_argument("trajectory: least times beside blends");
  }
  if (blends_.empty()) return;
  for (const double jerk : limits.jerk)
    if (jerk < kInfinity)
      throw std::invalid_argument("trajectory: blends go with unlimited jerk only");
  if (hasRotation(*space_))
    throw std::invalid_argument("trajectory: blends in a space with rotations");
  std::vector<double> left = lengths_;
  int before = 0;
  for (const Blend& blend : blends_) {
    if (!(blend.corner > before && at(blend.corner) + 1 < waypoints_.size() && blend.length > 0))
      throw std::invalid_argument("trajectory: blend of corner " + std::to_string(blend.corner) +
                                  " over " + std::to_string(blend.length));
    before = blend.corner;
    for (const int edge : {blend.corner - 1, blend.corner}) {
      left[at(edge)] -= blend.length;
      if (!(left[at(edge)] >= -kInLine * lengths_[at(edge)]))
        throw std::invalid_argument("trajectory: the blend of corner " +
                                    std::to_string(blend.corner) + " is longer than its edge");
    }
  }
}

const Blend* Trajectory::blendAt(int corner) const {
  const auto found = std::lower_bound(blends_.begin(), blends_.end(), corner,
                                      [](const Blend& b, int c) { return b.corner < c; });
  return found != blends_.end() && found->corner == corner ? &*found : nullptr;
}

int Trajectory::stretchEnd(int first) const {
  const int edges = static_cast<int>(differences_.size());
  int last = first + 1;
  // The direction is that of the last edge with a length.
  for (int along = first; last < edges; ++last) {
    if (blendAt(last) == nullptr && !inLine(differences_[at(along)], differences_[at(last)])) break;
    if (lengths_[at(last)] > 0) along = last;
  }
  return last;
}

double Trajectory::rateOf(int first, int last, double length) const {
  double rate = kInfinity;
  if (least_times_.empty()) return rate;
  for (int e = first; e < last; ++e)
    if (least_times_[at(e)] > 0 && lengths_[at(e)] > 0)
      rate = std::min(rate, lengths_[at(e)] / length / least_times_[at(e)]);
  return rate;
}

void Trajectory::addStraight(int first, int last, const MotionLimits& limits, double now) {
  std::vector<double> whole(at(space_->size()), 0);
  double length = 0;
  for (int e = first; e < last; ++e) {
    for (std::size_t i = 0; i < whole.size(); ++i) whole[i] += differences_[at(e)][i];
    length += lengths_[at(e)];
  }
  double passed = 0;
  for (int e = first; e + 1 < last; ++e) {
    passed += lengths_[at(e)];
    ends_[at(e)] = length > 0 ? passed / length : 1;
  }
  const double speed =
      std::min(rateLimit(*space_, whole, limits.velocity), rateOf(first, last, length));
  if (speed == kInfinity) {  // nothing moves
    for (int e = first; e < last; ++e) times_[at(e) + 1] = now;
    return;
  }
  const double jerk = limits.jerk.empty() ? kInfinity : rateLimit(*space_, whole, limits.jerk);
  const RestToRest profile(speed, rateLimit(*space_, whole, limits.acceleration), jerk);
  stretches_.push_back({first, last - first, now, profile});
  for (int e = first; e + 1 < last; ++e) times_[at(e) + 1] = now + timeAt(profile, ends_[at(e)]);
  times_[at(last)] = now + profile.duration();
}

void Trajectory::addBent(int first, int last, const MotionLimits& limits, double now) {
  Stretch stretch{first, last - first, now, std::nullopt};
  std::vector<CurvePiece> curve;
  struct Passed {
    int piece;
    double way;
  };
  std::vector<Passed> passed;  // the waypoints between, or the middles of their blends
  const auto add = [&](CurvePiece piece, int edge, int blend) {
    if (!(piece.length > 0)) return;
    stretch.pieces.push_back({edge, blend});
    curve.push_back(std::move(piece));
  };
  std::vector<double> way;  // direction of the edge before
  double cut = 0;           // length that the blend before takes of the edge
  for (int e = first; e < last; ++e) {
    const double length = lengths_[at(e)];
    const Blend* blend = e + 1 < last ? blendAt(e + 1) : nullptr;
    const double cut_after = blend != nullptr ? blend->length : 0;
    if (length > 0) {
      way = direction(differences_[at(e)]);
      add({way, way, length - cut - cut_after, true}, e, -1);
    }
    if (blend != nullptr) {
      passed.push_back({static_cast<int>(curve.size()), blend->length});
      add({way, direction(differences_[at(e) + 1]), 2 * blend->length, false}, e,
          static_cast<int>(blend - blends_.data()));
    } else {
      passed.push_back({std::max(0, static_cast<int>(curve.size()) - 1),
                        curve.empty() ? 0 : curve.back().length});
    }
    cut = cut_after;
  }
  stretch.phases = timeOptimal(curve, limits.velocity, limits.acceleration);
  for (TimedPhase& phase : stretch.phases) phase.start += now;
  for (int e = first; e + 1 < last; ++e)
    times_[at(e) + 1] =
        timeAt(stretch.phases, passed[at(e - first)].piece, passed[at(e - first)].way);
  times_[at(last)] = stretch.phases.back().start;
  stretches_.push_back(std::move(stretch));
}

std::vector<double> Trajectory::knots() const {
  std::vector<double> result(times_.begin(), times_.end());
  for (const Stretch& stretch : stretches_) {
    if (stretch.profile)
      for (const double knot : stretch.profile->knots()) result.push_back(stretch.start + knot);
    for (const TimedPhase& phase : stretch.phases) result.push_back(phase.start);
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

namespace {

/// The least time of each edge of a task's path at which lines keep the speed of their frames [s];
/// empty: no line has one.
std::vector<double> leastTimes(const Problem& problem, const ConfigurationSpace& space,
                               const Path& path) {
  const auto lineOf = [](const Step& step) -> const LineStep* {
    const auto* line = std::get_if<LineStep>(&step.action);
    return line != nullptr && std::isfinite(line->speed) ? line : nullptr;
  };
  if (std::none_of(problem.steps.begin(), problem.steps.end(),
                   [&](const Step& step) { return lineOf(step) != nullptr; }))
    return {};
  if (path.steps.empty() || path.steps.size() > problem.steps.size())
    throw std::invalid_argument(
        "trajectory: the path of a task whose lines have a speed does not have its steps");
  std::vector<double> times(path.positions.size() - 1, 0.0);
  Problem world = firstWorld(problem);
  for (std::size_t s = 0; s < path.steps.size(); ++s) {
    const PathStep& stretch = path.steps[s];
    const auto standAt = [&](int row) {
      for (std::size_t i = 0; i < path.positions[at(row)].size(); ++i)
        world.start[at(space.variables()[i])] = path.positions[at(row)][i];
    };
    standAt(stretch.first);
    if (const LineStep* line = lineOf(problem.steps[s])) {
      FramePose frame;
      frame.frame = line->frame;
      frame.position.fill({0, 0});
      frame.rpy.fill({0, 0});
      const robots::PoseRegion region = regionOf(world, frame);
      FrameMotion motion(space, world.start, region.link, region.X_LF);
      for (int e = stretch.first; e < stretch.last; ++e) {
        motion.begin(path.positions[at(e)], path.positions[at(e) + 1]);
        times[at(e)] = motion.speed(kSpeedParts) / line->speed;
      }
    }
    standAt(stretch.last);
    const std::vector<double> configuration = world.start;
    world = worldAfter(world, problem.steps[s], configuration);
  }
  return times;
}

}  // namespace

Trajectory trajectoryOf(const Problem& problem, const Path& path) {
  const MotionLimits limits = motionLimits(problem);
  const auto space =
      std::make_shared<const ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  const Path edges = edgesOf(*space, path).path;
  const std::vector<std::vector<double>>& waypoints = edges.positions;
  std::vector<Blend> blends;
  const bool smooth = std::any_of(limits.jerk.begin(), limits.jerk.end(),
                                  [](double jerk) { return jerk < kInfinity; });
  // The corners of a task are in different worlds.
  if (problem.execution.corners == Corners::kBlend && !smooth && path.steps.empty())
    blends = certifiedBlends(std::make_shared<const CompiledScene>(problem), waypoints);
  return {space, waypoints, limits, blends, leastTimes(problem, *space, edges)};
}

}  // namespace leeway::planner
