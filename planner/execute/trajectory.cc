#include "leeway/planner/trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "planner/base/tolerances.h"
#include "planner/execute/blend.h"
#include "planner/execute/path_timing.h"
#include "planner/execute/timed_path.h"

namespace leeway::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// How fast an edge's t may change: the tightest of limit / |dq|; infinite where nothing moves.
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

/// When the way along a piece is passed.
double timeAt(std::span<const TimedPhase> phases, int piece, double way) {
  const auto phase = std::prev(std::upper_bound(
      phases.begin() + 1, phases.end(), way, [piece](double to, const TimedPhase& p) {
        return piece < p.piece || (piece == p.piece && to < p.way);
      }));
  const double rest = phase->piece == piece ? std::max(0.0, way - phase->way) : 0;
  const double then =
      std::sqrt(std::max(0.0, phase->rate * phase->rate + 2 * phase->acceleration * rest));
  const double speed = phase->rate + then;  // 0 at the end, which rounding may take `way` beyond
  return phase->start + (speed > 0 ? 2 * rest / speed : 0);
}

/// By bisection, for these profiles have no simple inverse.
double timeAt(const RestToRest& profile, double way) {
  double low = 0, high = profile.duration();
  if (!(way < 1)) return high;  // rounding reaches it before
  for (int k = 0; k < 100; ++k) {
    const double middle = low + (high - low) / 2;
    (profile.at(middle).way < way ? low : high) = middle;
  }
  return high;
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

MotionLimits motionLimits(const Problem& problem) {
  const Execution& execution = problem.execution;
  MotionLimits limits;
  limits.velocity = velocityLimits(problem);
  std::size_t i = 0;
  for (const int v : problem.variables) {
    const std::string& name = problem.model->variables[at(v)].name;
    const auto acceleration = execution.accelerations.find(name);
    const auto jerk = execution.jerks.find(name);
    limits.acceleration.push_back(acceleration != execution.accelerations.end()
                                      ? acceleration->second
                                      : limits.velocity[i] / kTimeToVelocityLimit);
    limits.jerk.push_back(jerk != execution.jerks.end() ? jerk->second : kInfinity);
    ++i;
  }
  return limits;
}

MotionLimits defaultMotionLimits(const ConfigurationSpace& space) {
  MotionLimits limits;
  for (const int v : space.variables()) {
    limits.velocity.push_back(velocityLimit(space.model().variables[at(v)]));
    limits.acceleration.push_back(limits.velocity.back() / kTimeToVelocityLimit);
  }
  return limits;
}

Trajectory::Trajectory(std::shared_ptr<const ConfigurationSpace> space,
                       std::vector<std::vector<double>> waypoints, const MotionLimits& limits,
                       std::span<const Blend> blends)
    : space_(std::move(space)),
      waypoints_(std::move(waypoints)),
      blends_(blends.begin(), blends.end()) {
  const std::size_t size = at(space_->size());
  if (waypoints_.empty()) throw std::invalid_argument("trajectory: a path without waypoints");
  for (const std::vector<double>& row : waypoints_)
    if (row.size() != size)
      throw std::invalid_argument("trajectory: a waypoint of " + std::to_string(row.size()) +
                                  " numbers for " + std::to_string(size) + " variables");
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
  // Compared with the last edge that has a length.
  for (int along = first; last < edges; ++last) {
    if (blendAt(last) == nullptr && !inLine(differences_[at(along)], differences_[at(last)])) break;
    if (lengths_[at(last)] > 0) along = last;
  }
  return last;
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
  const double speed = rateLimit(*space_, whole, limits.velocity);
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
  std::vector<Passed> passed;  // where the waypoints between are, or the middles of their blends
  const auto add = [&](CurvePiece piece, int edge, int blend) {
    if (!(piece.length > 0)) return;
    stretch.pieces.push_back({edge, blend});
    curve.push_back(std::move(piece));
  };
  std::vector<double> way;  // direction of the edge before
  double cut = 0;           // at the edge's begin
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

Trajectory::Place Trajectory::place(double time) const {
  Place place;
  if (stretches_.empty() || !(time >= 0)) return place;
  if (time >= duration()) {
    place.edge = static_cast<int>(differences_.size()) - 1;
    place.t = 1;
    return place;
  }
  auto stretch = std::upper_bound(stretches_.begin(), stretches_.end(), time,
                                  [](double t, const Stretch& s) { return t < s.start; });
  --stretch;
  return placeOn(*stretch, time);
}

Trajectory::Place Trajectory::placeOn(const Stretch& stretch, double time) const {
  Place place;
  if (stretch.profile) {
    double since = time - stretch.start;
    for (const double knot : stretch.profile->knots())  // as knots() tells them, not before
      if (stretch.start + knot <= time) since = std::max(since, knot);
    const RestToRest::State state = stretch.profile->at(since);
    const int last = stretch.first_edge + stretch.edges - 1;
    int edge = stretch.first_edge;
    while (edge < last && state.way >= ends_[at(edge)]) ++edge;
    const double begin = edge == stretch.first_edge ? 0 : ends_[at(edge - 1)];
    const double share = ends_[at(edge)] - begin;
    place.edge = edge;
    if (share > 0) {
      place.t = std::clamp((state.way - begin) / share, 0.0, 1.0);
      place.rate = state.speed / share;
      place.acceleration = state.acceleration / share;
    }
    return place;
  }
  const auto phase =
      std::prev(std::upper_bound(stretch.phases.begin() + 1, stretch.phases.end(), time,
                                 [](double t, const TimedPhase& p) { return t < p.start; }));
  const double dt = time - phase->start;
  const double s = phase->way + dt * (phase->rate + dt / 2 * phase->acceleration);
  const Piece& piece = stretch.pieces[at(phase->piece)];
  place.edge = piece.edge;
  place.blend = piece.blend;
  double before = 0, length = 0;
  if (piece.blend >= 0) {
    length = 2 * blends_[at(piece.blend)].length;
  } else {
    length = lengths_[at(piece.edge)];
    const Blend* cut = piece.edge > stretch.first_edge ? blendAt(piece.edge) : nullptr;
    before = cut != nullptr ? cut->length : 0;
  }
  place.t = std::clamp((before + s) / length, 0.0, 1.0);
  place.rate = (phase->rate + dt * phase->acceleration) / length;
  place.acceleration = phase->acceleration / length;
  return place;
}

std::optional<double> Trajectory::passes(int edge, double t) const {
  if (edge < 0 || at(edge) >= differences_.size() || !(t >= 0 && t <= 1)) return std::nullopt;
  // The last stretch that begins at the edge or before; edges of no length have none.
  auto stretch = std::upper_bound(stretches_.begin(), stretches_.end(), edge,
                                  [](int e, const Stretch& s) { return e < s.first_edge; });
  if (stretch == stretches_.begin()) return times_[at(edge)];
  --stretch;
  if (edge >= stretch->first_edge + stretch->edges) return times_[at(edge)];
  if (stretch->profile) {
    const double begin = edge == stretch->first_edge ? 0 : ends_[at(edge - 1)];
    return stretch->start + timeAt(*stretch->profile, begin + t * (ends_[at(edge)] - begin));
  }
  const Blend* before = edge > stretch->first_edge ? blendAt(edge) : nullptr;
  const bool last = edge + 1 == stretch->first_edge + stretch->edges;
  const Blend* after = last ? nullptr : blendAt(edge + 1);
  const double way = t * lengths_[at(edge)], begin = before != nullptr ? before->length : 0;
  if (way < begin || (after != nullptr && way > lengths_[at(edge)] - after->length))
    return std::nullopt;
  // What is left of the edge begins where the first piece does that comes with it or later: it may
  // have no length, or two cuts may meet.
  const auto piece = std::find_if(stretch->pieces.begin(), stretch->pieces.end(),
                                  [&](const Piece& p) { return p.edge >= edge; });
  const bool whole = piece != stretch->pieces.end() && piece->edge == edge && piece->blend < 0;
  return timeAt(stretch->phases, static_cast<int>(piece - stretch->pieces.begin()),
                whole ? way - begin : 0);
}

void Trajectory::configuration(double time, std::span<double> q) const {
  if (differences_.empty() || !(time > 0)) {
    std::copy(waypoints_.front().begin(), waypoints_.front().end(), q.begin());
    return;
  }
  const Place p = place(time);
  if (p.blend >= 0)
    blendPoint(*space_, waypoints_[at(p.edge) + 1], differences_[at(p.edge)],
               differences_[at(p.edge) + 1], blends_[at(p.blend)].length, p.t, q);
  else
    space_->interpolate(waypoints_[at(p.edge)], waypoints_[at(p.edge) + 1], p.t, q);
}

void Trajectory::derivative(double time, bool second, std::span<double> result) const {
  std::fill(result.begin(), result.end(), 0.0);
  if (stretches_.empty() || !(time >= 0) || time >= duration()) return;
  const Place p = place(time);
  const std::vector<double>& along = differences_[at(p.edge)];
  if (p.blend < 0) {
    const double factor = second ? p.acceleration : p.rate;
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = factor * along[i];
    return;
  }
  // dq/dt = 2 l ((1 - t) d0 + t d1) and d2q/dt2 = 2 l (d1 - d0), with unit directions d0 and d1.
  const std::vector<double>& next = differences_[at(p.edge) + 1];
  const double twice = 2 * blends_[at(p.blend)].length;
  const double a = twice / lengths_[at(p.edge)], b = twice / lengths_[at(p.edge) + 1];
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double slope = (1 - p.t) * a * along[i] + p.t * b * next[i];
    const double bend = b * next[i] - a * along[i];
    result[i] = second ? p.acceleration * slope + p.rate * p.rate * bend : p.rate * slope;
  }
}

void Trajectory::velocity(double time, std::span<double> rate) const {
  derivative(time, false, rate);
}

void Trajectory::acceleration(double time, std::span<double> second) const {
  derivative(time, true, second);
}

Trajectory trajectoryOf(const Problem& problem, const Path& path) {
  const MotionLimits limits = motionLimits(problem);
  const auto space = std::make_shared<const ConfigurationSpace>(problem.model, problem.variables);
  std::vector<Blend> blends;
  const bool smooth = std::any_of(limits.jerk.begin(), limits.jerk.end(),
                                  [](double jerk) { return jerk < kInfinity; });
  if (problem.execution.corners == Corners::kBlend && !smooth)
    blends = certifiedBlends(std::make_shared<const CompiledScene>(problem), path.positions);
  return {space, path.positions, limits, blends};
}

}  // namespace leeway::planner
