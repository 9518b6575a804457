// Computes where a trajectory is at a time, and the time at which it passes a place.

#include <algorithm>
#include <cmath>
#include <iterator>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "planner/base/tolerances.h"
#include "planner/timing/blend.h"

namespace leeway::planner {

Trajectory::Place Trajectory::place(double time) const {
  Place place = placeInside(time);
  place.edge = kept_[at(place.edge)];
  return place;
}

Trajectory::Place Trajectory::placeInside(double time) const {
  Place place;
  if (pieces_.empty() || !(time >= 0)) return place;
  if (time >= duration()) {
    place.edge = static_cast<int>(differences_.size()) - 1;
    place.t = 1;
    return place;
  }
  const auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), time,
                                      [](double t, const Piece& p) { return t < p.start; });
  return placeOn(*std::prev(piece), time);
}

Trajectory::Place Trajectory::placeOn(const Piece& piece, double time) const {
  Place place;
  place.edge = piece.edge;
  place.blend = piece.blend;
  if (!piece.profile) {
    place.t = std::clamp((time - piece.start) / piece.time, 0.0, 1.0);
    place.rate = 1 / piece.time;
    return place;
  }
  double since = time - piece.start;
  // Rounding must not put a time before its knot.
  for (const double knot : piece.profile->knotArray())
    if (piece.start + knot <= time) since = std::max(since, knot);
  const SpeedProfile::State state = piece.profile->at(since);
  const double way = piece.begin + state.way;
  while (place.edge + 1 < piece.last && way >= ends_[at(place.edge)]) ++place.edge;
  const double begin = place.edge == piece.edge ? 0 : ends_[at(place.edge) - 1];
  const double length = lengths_[at(place.edge)];
  if (length > 0) {
    place.t = std::clamp((way - begin) / length, 0.0, 1.0);
    place.rate = state.speed / length;
    place.acceleration = state.acceleration / length;
  }
  return place;
}

std::optional<double> Trajectory::passes(int edge, double t) const {
  const auto kept = std::lower_bound(kept_.begin(), kept_.end(), edge);
  if (edge < 0 || at(edge) + 1 >= waypoints_.size() || !(t >= 0 && t <= 1) || *kept != edge ||
      kept[1] != edge + 1)
    return std::nullopt;
  edge = static_cast<int>(kept - kept_.begin());
  const auto on_leg = [&](const Piece& p) {
    return p.blend < 0 && p.edge <= edge && edge < p.last;
  };
  const auto piece = std::find_if(pieces_.begin(), pieces_.end(), on_leg);
  const double way = t * lengths_[at(edge)];
  if (piece == pieces_.end()) {
    // Blends meet on this edge, or nothing moves.
    const Blend* before = blendAt(edge);
    if (before == nullptr) return times_[at(edge)];
    if (std::abs(way - before->after) > kInLine * lengths_[at(edge)]) return std::nullopt;
    const auto blend = std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& p) {
      return p.blend >= 0 && &blends_[at(p.blend)] == before;
    });
    return blend->start + blend->time;
  }
  const double passed = (edge == piece->edge ? 0 : ends_[at(edge) - 1]) + way - piece->begin;
  const double slack = kInLine * ends_[at(piece->last) - 1];
  if (passed < -slack || passed > piece->profile->length() + slack) return std::nullopt;
  return piece->start + piece->profile->timeAt(passed);
}

void Trajectory::configuration(double time, std::span<double> q) const {
  if (differences_.empty() || !(time > 0)) {
    std::copy(points_.front().begin(), points_.front().end(), q.begin());
    return;
  }
  const Place p = placeInside(time);
  if (p.blend >= 0)
    blendPoint(points_[at(p.edge) + 1], differences_[at(p.edge)], differences_[at(p.edge) + 1],
               blends_[at(p.blend)], p.t, q);
  else
    space_->alongLine(points_[at(p.edge)], points_[at(p.edge) + 1], p.t, q);
}

void Trajectory::derivative(double time, bool second, std::span<double> result) const {
  std::fill(result.begin(), result.end(), 0.0);
  if (pieces_.empty() || !(time >= 0) || time >= duration()) return;
  const Place p = placeInside(time);
  double factor = second ? p.acceleration : p.rate;
  if (p.blend >= 0) {
    blendDerivative(differences_[at(p.edge)], differences_[at(p.edge) + 1], blends_[at(p.blend)],
                    p.t, second, result);
    factor = second ? p.rate * p.rate : p.rate;
  } else {
    std::copy(differences_[at(p.edge)].begin(), differences_[at(p.edge)].end(), result.begin());
  }
  for (double& x : result) x *= factor;
}

void Trajectory::velocity(double time, std::span<double> rate) const {
  derivative(time, false, rate);
}

void Trajectory::acceleration(double time, std::span<double> second) const {
  derivative(time, true, second);
}

}  // namespace leeway::planner
