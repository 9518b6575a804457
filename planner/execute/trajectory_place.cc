// Computes where a trajectory is at a time, and the time at which it passes a place.

#include <algorithm>
#include <cmath>
#include <iterator>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "planner/execute/blend.h"
#include "planner/execute/path_timing.h"

namespace leeway::planner {

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
    // Rounding must not put a time before its knot.
    for (const double knot : stretch.profile->knotArray())
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
  // Find the last stretch that begins at or before this edge. Edges without length belong to no
  // stretch.
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
  // The straight piece of the edge, or the next piece if the cuts at both ends meet and leave no
  // piece.
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

}  // namespace leeway::planner
