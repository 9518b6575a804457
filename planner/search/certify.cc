#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "leeway/planner/plan.h"
#include "planner/base/tolerances.h"
#include "planner/base/waypoints.h"
#include "planner/constraint/constraint_proof.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {
namespace {

/// Refines the clearances of a path's edges from the world, or of the robot from itself.
class Clearances {
 public:
  Clearances(EdgeCertifier& certifier, const Waypoints& path, double tolerance, Pairs pairs,
             double guess)
      : certifier_(certifier),
        path_(path),
        tolerance_(tolerance),
        pairs_(pairs),
        guess_(guess),
        edges_(path.size() - 1) {}

  /// Encloses the clearance of each edge to within the tolerance.
  void refineAll() {
    for (std::size_t i = 0; i < edges_.size(); ++i)
      keep(i, certifier_.edgeClearance(path_[i], path_[i + 1],
                                       {.tolerance = tolerance_, .pairs = pairs_}));
  }

  /// Encloses the path's least clearance to a share of itself, with little work. An edge that is
  /// proven to stay above that share is not refined. O(edges), in addition to the queries.
  void refineLeast() {
    if (pairs_ == Pairs::kSelf)
      keep(0, certifier_.nearest(path_[0], pairs_, kInfinity));
    else
      look();
    const std::int64_t before = certifier_.statistics.work;
    while (certifier_.statistics.work - before < kAllProofsWork) {
      const int i = lowestUnproven();
      if (i < 0) return;
      prove(i);
    }
  }

  const std::vector<EdgeClearance>& edges() const { return edges_; }
  /// Whether edge i is proven to keep all margins of these pairs.
  bool keepsMargins(std::size_t i) const { return edges_[i].keeps_margins; }
  /// Applies a proof from elsewhere that the clearance of edge i exceeds `lower`.
  void raise(std::size_t i, double lower) {
    Interval& known = edges_[i].clearance;
    known.lower = std::max(known.lower, lower);
  }

  /// The clearance of the whole path.
  planner::PathClearance whole() const {
    planner::PathClearance whole;
    whole.clearance = {kInfinity, kInfinity};
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const EdgeClearance& edge = edges_[i];
      whole.clearance.lower = std::min(whole.clearance.lower, edge.clearance.lower);
      if (!(edge.clearance.upper < whole.clearance.upper)) continue;
      whole.clearance.upper = edge.clearance.upper;
      whole.closest_segment = static_cast<int>(i);
      whole.closest_t = edge.t;
      whole.closest_point_a = edge.closest.point_a;
      whole.closest_point_b = edge.closest.point_b;
      nameClosest(edge.pair, whole);
    }
    return whole;
  }

 private:
  /// Bounds from a few passes of lanes.
  void look() {
    // The nearest obstacle is usually a little farther than the clearance that a push has kept.
    const double first =
        guess_ > 0 ? std::min(kRoughBeyondGuess * guess_, kRoughFirst) : kRoughFirst;
    for (const double most : {first, kRoughFirst, kRoughMost}) {
      for (std::size_t i = 0; i < edges_.size(); ++i) {
        for (int pass = 0; pass < kRoughPasses; ++pass) {
          const double before = least_, enough = std::min((1 - kLeastShare) * least_, most);
          keep(i, certifier_.roughClearance(path_[i], path_[i + 1], enough, pairs_, true));
          if (edges_[i].clearance.lower >= enough || !(least_ < before)) break;
        }
      }
      if (std::isfinite(least_)) break;
    }
  }

  void nameClosest(int pair, planner::PathClearance& whole) const {
    if (pair < 0) return;
    const collision::Scene& scene = certifier_.scene().scene();
    const collision::ScenePair& p = scene.pairs()[static_cast<std::size_t>(pair)];
    whole.closest_a = scene.bodies()[static_cast<std::size_t>(p.body_a)].name;
    whole.closest_b = scene.bodies()[static_cast<std::size_t>(p.body_b)].name;
  }

  /// The clearance that each edge should keep: a large share of the path's. After a failed proof of
  /// one edge, a smaller clearance is enough for all.
  double wanted() const {
    if (!std::isfinite(least_)) return kRoughMost;
    if (!(least_ > 0)) return least_ - std::max(tolerance_, -kLeastShare * least_);
    const double wanted = (1 - kLeastShare) * least_;
    if (tries_ == 0 && wanted < guess_ && guess_ < least_) return guess_;
    return std::pow(kProofFall, tries_) * wanted;
  }

  int lowestUnproven() const {
    const auto lowest = std::min_element(
        edges_.begin(), edges_.end(),
        [](const auto& a, const auto& b) { return a.clearance.lower < b.clearance.lower; });
    const bool is_enough = tries_ >= kProofTries || lowest->clearance.lower >= wanted();
    return is_enough ? -1 : static_cast<int>(lowest - edges_.begin());
  }

  void prove(int edge) {
    const auto i = static_cast<std::size_t>(edge);
    const double before = least_, lower = edges_[i].clearance.lower;
    keep(i, certifier_.proveClearance(path_[i], path_[i + 1],
                                      {.tolerance = tolerance_,
                                       .wanted = wanted(),
                                       .work_limit = kProofWork,
                                       .pairs = pairs_}));
    if (!(least_ < before) && !(edges_[i].clearance.lower > lower)) ++tries_;
  }

  void keep(std::size_t i, EdgeClearance found) {
    EdgeClearance& known = edges_[i];
    found.clearance.lower = std::max(found.clearance.lower, known.clearance.lower);
    found.keeps_margins = found.keeps_margins || known.keeps_margins;
    known.keeps_margins = found.keeps_margins;
    if (found.clearance.upper < known.clearance.upper)
      known = found;
    else
      known.clearance.lower = found.clearance.lower;
    least_ = std::min(least_, known.clearance.upper);
  }

  EdgeCertifier& certifier_;
  const Waypoints& path_;
  double tolerance_;
  Pairs pairs_;
  double guess_;
  double least_ = kInfinity;  ///< upper bound on the path's clearance
  std::vector<EdgeClearance> edges_;
  int tries_ = 0;  ///< number of failed proofs
};

}  // namespace

namespace {

bool isAsLong(const ConfigurationSpace& space, const std::vector<double>& row) {
  return row.size() == at(space.size());
}

/// The names of a path, if it has some, are those of its columns.
void requireNames(const ConfigurationSpace& space, const Path& path) {
  if (path.names.empty()) return;
  std::vector<std::string> names;
  for (const int v : space.variables()) names.push_back(space.model().variables[at(v)].name);
  if (path.names != names)
    throw std::invalid_argument(
        fmt::format("a path with columns {}; {}, the planned variables, are expected",
                    fmt::join(path.names, ", "), fmt::join(names, ", ")));
}

bool haveEdges(const ConfigurationSpace& space, const Waypoints& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (!isAsLong(space, rows[i]) || (i > 0 && space.edgesAlongLine(rows[i - 1], rows[i]) == 0))
      return false;
  return true;
}

}  // namespace

PathEdges edgesOf(const ConfigurationSpace& space, const Path& path) {
  if (!path.times.empty())
    throw std::invalid_argument("a path with times, which moves on cubics: lines are expected");
  requireNames(space, path);
  for (const PathStep& step : path.steps)
    if (step.first < 0 || step.last < step.first || at(step.last) >= path.positions.size())
      throw std::invalid_argument(fmt::format(
          "a path of {} rows whose step '{}' goes from row {} to row {}: rows of the path are "
          "expected",
          path.positions.size(), step.name, step.first, step.last));
  PathEdges edges{{path.names, {}, path.steps}, {}};
  Waypoints& points = edges.path.positions;
  std::vector<int> place;  // the index of each row among the points
  for (std::size_t i = 0; i < path.positions.size(); ++i) {
    place.push_back(static_cast<int>(points.size()));
    points.push_back(path.positions[i]);
    if (i + 1 == path.positions.size()) break;
    const std::vector<double>&a = path.positions[i], &b = path.positions[i + 1];
    const int count = isAsLong(space, a) && isAsLong(space, b) ? space.edgesAlongLine(a, b) : 0;
    if (count == 0)
      throw std::invalid_argument(
          fmt::format("the line from row {} of a path: rows of {} numbers, and continuous joints "
                      "within 1000 rad, are expected",
                      i, space.size()));
    for (int k = 0; k < count; ++k) {
      const PathEdges::Place part{static_cast<int>(i), static_cast<double>(k) / count,
                                  static_cast<double>(k + 1) / count};
      edges.places.push_back(part);
      if (k + 1 == count) break;
      points.emplace_back(a.size());
      space.alongLine(a, b, part.t1, points.back());
    }
  }
  for (PathStep& step : edges.path.steps) {
    if (step.places.size() == at(step.last - step.first) + 1) {
      std::vector<double> places;
      for (int row = step.first; row < step.last; ++row) {
        const int parts = place.at(at(row) + 1) - place[at(row)];
        const double from = step.places[at(row - step.first)];
        const double to = step.places[at(row - step.first) + 1];
        for (int k = 0; k < parts; ++k) places.push_back(from + (to - from) * k / parts);
      }
      places.push_back(step.places.back());
      step.places = std::move(places);
    }
    step.first = place.at(at(step.first));
    step.last = place.at(at(step.last));
  }
  return edges;
}

Certificate certify(EdgeCertifier& certifier, const Path& path, double tolerance,
                    CertificateDetail detail, double world_guess) {
  const ConfigurationSpace& space = certifier.scene().space();
  Certificate certificate;
  certificate.margins = certifier.scene().margins();
  certificate.unchecked = countUnchecked(certifier.scene().dropped());
  certificate.clearance = certificate.world.clearance =
      certificate.self.clearance = {kInfinity, kInfinity};
  if (path.positions.empty()) return certificate;
  if (!haveEdges(space, path.positions)) {
    for (PathClearance* part :
         {static_cast<PathClearance*>(&certificate), &certificate.world, &certificate.self})
      part->clearance.lower = -kInfinity;
    return certificate;
  }
  certificate.certified = certifier.scene().nothingChecked().empty() &&
                          std::all_of(path.positions.begin(), path.positions.end(),
                                      [&](const std::vector<double>& position) {
                                        return space.withinLimits(position);
                                      });

  // A single place is an edge without length.
  const bool stays = path.positions.size() == 1;
  const PathEdges lines = edgesOf(space, path);
  Waypoints positions = lines.path.positions;
  if (stays) positions.push_back(positions[0]);
  const std::size_t edges = positions.size() - 1;
  Clearances of_world(certifier, positions, tolerance, Pairs::kWorld, world_guess);
  Clearances of_robot(certifier, positions, tolerance, Pairs::kSelf, 0);
  // A free edge is proven to keep its margins, which may be a stronger statement than the interval.
  const double margin_of_world = certifier.scene().edges().leastMargin(Pairs::kWorld);
  const double margin_of_robot = certifier.scene().edges().leastMargin(Pairs::kSelf);
  const auto certifyEdges = [&] {
    for (std::size_t i = 0; i < edges; ++i) {
      const bool is_free =
          (of_world.keepsMargins(i) && of_robot.keepsMargins(i)) ||
          certifier.certify(positions[i], positions[i + 1], EdgeRequest::persistent()).verdict ==
              Verdict::kFree;
      certificate.certified = certificate.certified && is_free;
      if (!is_free) continue;
      of_world.raise(i, margin_of_world);
      of_robot.raise(i, margin_of_robot);
    }
  };
  // Margins that the clearances of world and robot prove are not proven again. If bodies may
  // overlap, the margins come first, because they may be the only proven bound on depths.
  const bool begins_with_margins = std::min(margin_of_world, margin_of_robot) < 0;
  if (begins_with_margins) certifyEdges();
  for (Clearances* clearances : {&of_world, &of_robot}) {
    if (detail == CertificateDetail::kEveryEdge || stays)
      clearances->refineAll();
    else
      clearances->refineLeast();
  }
  if (!begins_with_margins) certifyEdges();

  certificate.segments.assign(path.positions.size() - 1, {kInfinity, kInfinity});
  for (const Clearances* clearances : {&of_world, &of_robot}) {
    PathClearance& part = clearances == &of_world ? certificate.world : certificate.self;
    part = clearances->whole();
    if (!stays && part.closest_segment >= 0) {
      const PathEdges::Place& place = lines.places[at(part.closest_segment)];
      part.closest_segment = place.segment;
      part.closest_t = place.along(part.closest_t);
    }
    const double least = std::min(certificate.clearance.lower, part.clearance.lower);
    if (part.clearance.upper < certificate.clearance.upper)
      static_cast<PathClearance&>(certificate) = part;
    certificate.clearance.lower = least;
    for (std::size_t i = 0; i < lines.places.size(); ++i) {
      Interval& segment = certificate.segments[at(lines.places[i].segment)];
      const Interval& found = clearances->edges()[i].clearance;
      segment = {std::min(segment.lower, found.lower), std::min(segment.upper, found.upper)};
    }
  }
  // Cropped points may be this near.
  const double most = certifier.scene().completeWithin();
  for (Interval* clearance : {&certificate.clearance, &certificate.world.clearance})
    clearance->lower = std::min(clearance->lower, most);
  for (Interval& segment : certificate.segments) segment.lower = std::min(segment.lower, most);
  return certificate;
}

std::optional<std::vector<ConstraintResult>> proveConstraints(const CompiledScene& scene,
                                                              const Problem& problem,
                                                              const Path& path) {
  scene.requireConstraints(problem);
  return ConstraintProof(scene, problem).prove(edgesOf(scene.space(), path).path.positions);
}

std::string brokenConstraint(const CompiledScene& scene, const Problem& problem,
                             std::span<const double> point) {
  scene.requireConstraints(problem);
  if (point.size() != at(scene.space().size()))
    return fmt::format("the point has {} numbers; {} are expected", point.size(),
                       scene.space().size());
  return ConstraintProof(scene, problem).fault(point);
}

}  // namespace leeway::planner
