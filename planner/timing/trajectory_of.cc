#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/constraint/frame_motion.h"
#include "planner/task/line_motion.h"
#include "planner/task/line_way.h"
#include "planner/task/stages.h"
#include "planner/timing/choose_cuts.h"
#include "planner/timing/leg.h"
#include "planner/timing/motion_limits.h"
#include "planner/timing/trajectory_samples.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
Trajectory::Trajectory(std::shared_ptr<const ConfigurationSpace> space,
                       std::vector<std::vector<double>> waypoints, const MotionLimits& limits,
                       Cuts cuts, std::span<const double> least_times,
                       std::span<const PathStep> steps)
    : space_(std::move(space)),
      waypoints_(std::move(waypoints)),
      cuts_(std::move(cuts)),
      steps_(steps.begin(), steps.end()),
      least_times_(least_times.begin(), least_times.end()) {
  if (waypoints_.empty()) throw std::invalid_argument("trajectory: a path without waypoints");
  if (!space_) throw std::invalid_argument("trajectory: a space is expected");
  space_->requirePath(waypoints_, "trajectory");
  for (const std::vector<double>& row : waypoints_)
    for (const double x : row)
      if (!std::isfinite(x))
        throw std::invalid_argument("trajectory: a waypoint with " + std::to_string(x) +
                                    "; finite numbers are expected");
  check(limits, steps);
  waypoints_ = unwrapped(*space_, std::move(waypoints_));
  leaveOut();
  for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
    differences_.emplace_back(at(space_->size()));
    space_->lineDifference(points_[i], points_[i + 1], differences_.back());
    lengths_.push_back(norm(differences_.back()));
  }
  std::vector<int> rests;
  for (const PathStep& step : steps) rests.push_back(keptIndex(step.last));
  const std::vector<Leg> legs = legsOf(*space_, differences_, blends_, limits, least_times_, rests);
  std::vector<int> leg_of;  // each blend: the leg before it
  for (std::size_t e = 0; e + 1 < legs.size() && leg_of.size() < blends_.size(); ++e)
    if (blends_[leg_of.size()].corner == legs[e].last) leg_of.push_back(static_cast<int>(e));
  checkRoom(legs, leg_of);
  addPieces(legs, blendTimes(legs, blends_, leg_of, limits));
  timeWaypoints();
}

void Trajectory::check(const MotionLimits& limits, std::span<const PathStep> steps) const {
  requireLimits(limits, at(space_->size()));
  if (!least_times_.empty()) {
    if (least_times_.size() + 1 != waypoints_.size())
      throw std::invalid_argument("trajectory: " + std::to_string(least_times_.size()) +
                                  " least times for " + std::to_string(waypoints_.size() - 1) +
                                  " edges");
    for (const double time : least_times_)
      if (!(time >= 0) || !std::isfinite(time))
        throw std::invalid_argument("trajectory: a least time of " + std::to_string(time) +
                                    " s, it must be 0 or more");
  }
  int before = 0;
  for (const int waypoint : cuts_.left_out) {
    if (!(waypoint > before && at(waypoint) + 1 < waypoints_.size()))
      throw std::invalid_argument("trajectory: waypoint " + std::to_string(waypoint) +
                                  " is left out, which is out of order or an end");
    before = waypoint;
  }
  const std::vector<int> cut = cutCorners();
  before = 0;
  for (const PathStep& step : steps) {
    if (!(step.first >= 0 && step.first <= step.last && step.last >= before &&
          at(step.last) < waypoints_.size()) ||
        std::binary_search(cut.begin(), cut.end(), step.last))
      throw std::invalid_argument("trajectory: a step of a task ends at waypoint " +
                                  std::to_string(step.last) +
                                  ", which is out of order or cut; it must rest there");
    before = step.last;
  }
  before = 0;
  if (cuts_.blends.empty()) return;
  if (hasRotation(*space_))
    throw std::invalid_argument("trajectory: blends in a space with rotations");
  const bool smooth = std::any_of(limits.jerk.begin(), limits.jerk.end(),
                                  [](double jerk) { return jerk < kInfinity; });
  for (const Blend& blend : cuts_.blends) {
    if (!(blend.corner > before && at(blend.corner) + 1 < waypoints_.size() && blend.before > 0 &&
          blend.after > 0 && blend.ramp >= 0 && blend.ramp <= 0.5) ||
        std::binary_search(cuts_.left_out.begin(), cuts_.left_out.end(), blend.corner))
      throw std::invalid_argument("trajectory: blend of corner " + std::to_string(blend.corner) +
                                  " over " + std::to_string(blend.before) + " and " +
                                  std::to_string(blend.after) + " with a ramp of " +
                                  std::to_string(blend.ramp));
    if (smooth && !(blend.ramp > 0))
      throw std::invalid_argument("trajectory: the blend of corner " +
                                  std::to_string(blend.corner) +
                                  " has no ramp, but jerk is limited");
    before = blend.corner;
  }
}

int Trajectory::keptIndex(int waypoint) const {
  return static_cast<int>(std::lower_bound(kept_.begin(), kept_.end(), waypoint) - kept_.begin());
}

/// Fills what numbers only the waypoints that are passed.
void Trajectory::leaveOut() {
  for (int i = 0; i < static_cast<int>(waypoints_.size()); ++i) {
    if (std::binary_search(cuts_.left_out.begin(), cuts_.left_out.end(), i)) continue;
    kept_.push_back(i);
    points_.push_back(waypoints_[at(i)]);
  }
  points_ = unwrapped(*space_, std::move(points_));
  if (!least_times_.empty()) {  // those of an edge in place of several take their sum
    std::vector<double> sums;
    for (std::size_t k = 0; k + 1 < kept_.size(); ++k)
      sums.push_back(std::accumulate(least_times_.begin() + kept_[k],
                                     least_times_.begin() + kept_[k + 1], 0.0));
    least_times_ = std::move(sums);
  }
  blends_ = cuts_.blends;
  for (Blend& blend : blends_) blend.corner = keptIndex(blend.corner);
}

/// Those left out are timed in proportion to the lengths of the edges beside them.
void Trajectory::timeWaypoints() {
  std::vector<double> difference(at(space_->size()));
  for (std::size_t k = 0; k + 1 < kept_.size(); ++k) {
    std::vector<double> passed;
    for (int e = kept_[k]; e < kept_[k + 1]; ++e) {
      space_->difference(waypoints_[at(e)], waypoints_[at(e) + 1], difference);
      passed.push_back((passed.empty() ? 0 : passed.back()) + norm(difference));
    }
    waypoint_times_.push_back(times_[k]);
    for (std::size_t i = 0; i + 1 < passed.size(); ++i)
      waypoint_times_.push_back(times_[k] +
                                (times_[k + 1] - times_[k]) *
                                    (passed.back() > 0 ? passed[i] / passed.back() : 0));
  }
  waypoint_times_.push_back(times_.back());
}

std::vector<int> Trajectory::cutCorners() const {
  std::vector<int> corners = cuts_.left_out;
  for (const Blend& blend : cuts_.blends) corners.push_back(blend.corner);
  std::sort(corners.begin(), corners.end());
  return corners;
}

void Trajectory::checkRoom(std::span<const Leg> legs, std::span<const int> leg_of) const {
  std::vector<double> left = lengths_;
  for (std::size_t k = 0; k < blends_.size(); ++k) {
    const Blend& blend = blends_[k];
    left[at(blend.corner) - 1] -= blend.before;
    left[at(blend.corner)] -= blend.after;
    for (const int edge : {blend.corner - 1, blend.corner})
      if (!(left[at(edge)] >= -kInLine * lengths_[at(edge)]))
        throw std::invalid_argument("trajectory: the blend of corner " +
                                    std::to_string(blend.corner) + " is longer than its edge");
    const Leg &from = legs[at(leg_of[k])], &to = legs[at(leg_of[k]) + 1];
    const bool starts = k == 0 || leg_of[k - 1] + 1 != leg_of[k];
    const bool ends = k + 1 == blends_.size() || leg_of[k + 1] != leg_of[k] + 1;
    if ((starts && !(from.length - blend.before > 0)) || (ends && !(to.length - blend.after > 0)))
      throw std::invalid_argument("trajectory: the blend of corner " +
                                  std::to_string(blend.corner) +
                                  " leaves no length for starting or coming to rest");
  }
}

const Blend* Trajectory::blendAt(int corner) const {
  const auto found = std::lower_bound(blends_.begin(), blends_.end(), corner,
                                      [](const Blend& b, int c) { return b.corner < c; });
  return found != blends_.end() && found->corner == corner ? &*found : nullptr;
}

void Trajectory::addPieces(std::span<const Leg> legs, std::span<const double> blend_times) {
  ends_.assign(differences_.size(), 0);
  times_.assign(points_.size(), 0);
  double now = 0, speed = 0, cut = 0;  // at the beginning of the leg
  std::size_t next = 0;                // of the blends
  for (const Leg& leg : legs) {
    double passed = 0;
    for (int e = leg.first; e < leg.last; ++e) {
      passed += lengths_[at(e)];
      ends_[at(e)] = passed;
    }
    const bool blended = next < blends_.size() && blends_[next].corner == leg.last;
    const double cut_after = blended ? blends_[next].before : 0;
    const double speed_after = blended ? 2 * cut_after / blend_times[next] : 0;
    const double length = leg.length - cut - cut_after;
    // Blends that meet leave no more than rounding.
    if (length > (blended && cut > 0 ? kInLine * leg.length : 0)) {
      const SpeedProfile profile(leg.limits, length, std::min(speed, leg.limits.speed),
                                 std::min(speed_after, leg.limits.speed));
      for (int e = leg.first; e + 1 < leg.last; ++e)
        times_[at(e) + 1] = now + profile.timeAt(ends_[at(e)] - cut);
      pieces_.push_back({now, leg.first, leg.last, -1, cut, 0, profile});
      now += profile.duration();
    } else {
      for (int e = leg.first; e + 1 < leg.last; ++e) times_[at(e) + 1] = now;
    }
    times_[at(leg.last)] = now;
    cut = speed = 0;
    if (!blended) continue;
    const double time = blend_times[next];
    pieces_.push_back({now, leg.last - 1, leg.last, static_cast<int>(next), 0, time, std::nullopt});
    times_[at(leg.last)] = now + time / 2;
    now += time;
    cut = blends_[next].after;
    speed = 2 * cut / time;
    ++next;
  }
}

std::vector<double> Trajectory::knots() const {
  std::vector<double> result = {0, duration()};
  for (const Piece& piece : pieces_) {
    if (piece.profile) {
      for (const double knot : piece.profile->knots()) result.push_back(piece.start + knot);
      continue;
    }
    const double ramp = blends_[at(piece.blend)].ramp * piece.time;
    for (const double knot : {0.0, ramp, piece.time - ramp, piece.time})
      result.push_back(piece.start + knot);
  }
  std::sort(result.begin(), result.end());
  addSpaced(times_, result);
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

namespace {

/// Additions of an execution to a path: cuts, the least times of edges, and the steps of a task
/// with the bounds that hold for the cuts, too.
struct Additions {
  Cuts cuts;
  std::vector<double> least_times;
  std::vector<PathStep> steps;
};

/// Cuts of a path with constraints, which they keep.
Cuts constrainedCuts(const Problem& problem, const std::shared_ptr<const CompiledScene>& scene,
                     const std::vector<std::vector<double>>& waypoints,
                     const MotionLimits& limits) {
  ConstraintProof proof(*scene, problem);
  std::vector<FrameMotion> frames;
  for (const Constraint& constraint : problem.constraints) {
    const robots::PoseRegion frame = frameOf(problem, constraint);
    frames.emplace_back(*scene, frame.link, frame.X_LF, frame.base);
  }
  CutRules rules;
  rules.leaves_out = false;
  rules.allows = [&](int corner, std::span<const double> departure) {
    const auto i = at(corner);
    const auto proven = proof.prove({waypoints[i - 1], waypoints[i], waypoints[i + 1]});
    if (!proven) return false;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const Constraint& constraint = problem.constraints[k];
      const ChordDeparture moves = frames[k].reach(departure), slack = frames[k].rounding();
      if (!((*proven)[k].deviation + moves.origin + slack.origin <=
            kConstraintShare * constraint.position_tolerance) ||
          !((*proven)[k].angle + moves.tips + slack.tips <= kConstraintShare * constraint.angle))
        return false;
    }
    return true;
  };
  return chooseCuts(scene, waypoints, limits, rules);
}

/// Goes through a task's steps, each in its world.
class TaskAdditions {
 public:
  TaskAdditions(const Problem& problem, const ConfigurationSpace& space, const Path& path,
                const MotionLimits& limits)
      : problem_(problem), space_(space), path_(path), limits_(limits) {}

  Additions run() {
    if (path_.steps.size() > problem_.steps.size())
      throw std::invalid_argument("trajectory: the path of a task does not have its steps");
    added_.least_times.assign(path_.positions.size() - 1, 0.0);
    added_.cuts.clearance = kInfinity;
    added_.steps = path_.steps;
    Problem world = firstWorld(problem_);
    for (std::size_t s = 0; s < path_.steps.size(); ++s) {
      const PathStep& stretch = path_.steps[s];
      const Step& step = problem_.steps[s];
      standAt(stretch.first, world);
      add(stageOf(world, step), step, stretch, added_.steps[s]);
      standAt(stretch.last, world);
      const std::vector<double> configuration = world.start;
      world = worldAfter(world, step, configuration);
    }
    if (added_.cuts.clearance == kInfinity) added_.cuts.clearance = -kInfinity;
    return std::move(added_);
  }

 private:
  void standAt(int row, Problem& world) const {
    for (std::size_t i = 0; i < path_.positions[at(row)].size(); ++i)
      world.start[at(space_.variables()[i])] = path_.positions[at(row)][i];
  }

  /// `added`: the stretch; bounds on its departure are widened to those of cuts.
  void add(const Problem& stage, const Step& step, const PathStep& stretch, PathStep& added) {
    const int edges = stretch.last - stretch.first;
    if (edges == 0) return;
    const std::span<const std::vector<double>> rows(&path_.positions[at(stretch.first)],
                                                    at(edges) + 1);
    const bool blends = problem_.execution.corners == Corners::kBlend && edges > 1;
    CutRules rules;
    const auto* line = std::get_if<LineStep>(&step.action);
    if (line == nullptr) {
      if (blends) append(chooseCuts(compiled(stage), rows, limits_, rules), stretch.first);
      return;
    }
    FramePose pose;
    pose.frame = line->frame;
    pose.position.fill({0, 0});
    pose.rpy.fill({0, 0});
    const robots::PoseRegion region = regionOf(stage, pose);
    FrameMotion frame(space_, stage.start, region.link, region.X_LF);
    const std::span<double> least(&added_.least_times[at(stretch.first)], at(edges));
    if (std::isfinite(line->speed)) {
      for (std::size_t e = 0; e < least.size(); ++e) {
        frame.begin(rows[e], rows[e + 1]);
        least[e] = frame.speed(kSpeedParts) / line->speed;
      }
      rules.speed = [&](std::span<const double> direction) {
        return line->speed / frame.reach(direction).origin;
      };
    }
    if (!blends || stretch.places.size() != rows.size()) return;
    rules.leaves_out = false;
    rules.least_times = least;
    std::vector<robots::Pose> X_WL(stage.robot.model->links.size());
    robots::forwardKinematics(*stage.robot.model, stage.start, X_WL);
    const LineWay way = lineWay(stage, *line, X_WL);
    rules.allows = [&](int corner, std::span<const double> departure) {
      LineDeparture off;
      for (const std::size_t e : {at(corner) - 1, at(corner)}) {
        const LineDeparture edge = lineDeparture(frame, way, stretch.places[e],
                                                 stretch.places[e + 1], rows[e], rows[e + 1]);
        off.deviation = std::max(off.deviation, edge.deviation);
        off.turn = std::max(off.turn, edge.turn);
      }
      const ChordDeparture moves = frame.reach(departure), slack = frame.rounding();
      return off.deviation + moves.origin + slack.origin <=
                 kConstraintShare * line->position_tolerance &&
             off.turn + moves.tips + slack.tips <= kConstraintShare * line->angle_tolerance;
    };
    const Cuts cuts = chooseCuts(compiled(stage), rows, limits_, rules);
    append(cuts, stretch.first);
    if (cuts.blends.empty()) return;
    added.deviation = std::max(added.deviation, kConstraintShare * line->position_tolerance);
    added.turn = std::max(added.turn, kConstraintShare * line->angle_tolerance);
  }

  static std::shared_ptr<const CompiledScene> compiled(const Problem& stage) {
    return std::make_shared<const CompiledScene>(stage);
  }

  /// Adds the cuts of a step, whose first waypoint is `first`.
  void append(const Cuts& cuts, int first) {
    if (cuts.blends.empty() && cuts.left_out.empty()) return;
    for (Blend blend : cuts.blends) {
      blend.corner += first;
      added_.cuts.blends.push_back(blend);
    }
    for (const int waypoint : cuts.left_out) added_.cuts.left_out.push_back(waypoint + first);
    added_.cuts.clearance = std::min(added_.cuts.clearance, cuts.clearance);
  }

  const Problem& problem_;
  const ConfigurationSpace& space_;
  const Path& path_;
  const MotionLimits& limits_;
  Additions added_;
};

Additions additionsTo(const Problem& problem, const ConfigurationSpace& space, const Path& path,
                      const MotionLimits& limits) {
  if (!problem.steps.empty()) {
    const bool is_timed =
        std::any_of(problem.steps.begin(), problem.steps.end(), [](const Step& step) {
          const auto* line = std::get_if<LineStep>(&step.action);
          return line != nullptr && std::isfinite(line->speed);
        });
    if (!is_timed && problem.execution.corners != Corners::kBlend) return {{}, {}, path.steps};
    return TaskAdditions(problem, space, path, limits).run();
  }
  // A condition is looked at on edges.
  if (problem.execution.corners != Corners::kBlend || problem.condition.accept ||
      path.positions.size() < 3)
    return {};
  const auto scene = std::make_shared<const CompiledScene>(problem);
  if (!problem.constraints.empty())
    return {constrainedCuts(problem, scene, path.positions, limits), {}, {}};
  return {certifiedCuts(scene, path.positions, limits), {}, {}};
}

}  // namespace

Trajectory trajectoryOf(const Problem& problem, const Path& path) {
  const MotionLimits limits = motionLimits(problem);
  const auto space =
      std::make_shared<const ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  if (path.steps.empty() && !problem.steps.empty())
    throw std::invalid_argument("trajectory: the path of a task does not have its steps");
  const Path edges = edgesOf(*space, path).path;
  Additions added = additionsTo(problem, *space, edges, limits);
  return {space, edges.positions, limits, std::move(added.cuts), added.least_times, added.steps};
}

}  // namespace leeway::planner
