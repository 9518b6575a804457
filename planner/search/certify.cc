#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/planner/plan.h"
#include "planner/base/tolerances.h"
#include "planner/search/search.h"

namespace leeway::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void name(const collision::Scene& scene, int pair, std::string& a, std::string& b) {
  if (pair < 0) return;
  const collision::ScenePair& p = scene.pairs()[static_cast<std::size_t>(pair)];
  a = scene.bodies()[static_cast<std::size_t>(p.body_a)].name;
  b = scene.bodies()[static_cast<std::size_t>(p.body_b)].name;
}

/// Refines what is known of the clearances of a path's edges.
class PathClearance {
 public:
  PathClearance(EdgeCertifier& certifier, const Waypoints& path, double tolerance)
      : certifier_(certifier), path_(path), tolerance_(tolerance), edges_(path.size() - 1) {}

  /// Each edge to within the tolerance.
  void refineAll() {
    for (std::size_t i = 0; i < edges_.size(); ++i) refine(i, {.tolerance = tolerance_});
  }

  /// The path's least clearance, to a tenth of itself as far as a little work goes. An edge that is
  /// known to stay above it is not looked at closer. O(edges), beside the queries.
  void refineLeast() {
    for (std::size_t i = 0; i < edges_.size(); ++i)
      keep(i, certifier_.roughClearance(path_[i], path_[i + 1], std::min(least_, kRoughMost)));
    for (int k = 0; k < kLeastRefinements; ++k) {
      const auto lowest = std::min_element(edges_.begin(), edges_.end(),
                                           [](const EdgeClearance& a, const EdgeClearance& b) {
                                             return a.clearance.lower < b.clearance.lower;
                                           });
      const double lower = lowest->clearance.lower;
      // Without an upper end any will do.
      const double enough =
          std::isfinite(least_) ? std::max(tolerance_, kLeastShare * least_) : kRoughMost;
      if (!(lower < least_ - enough)) return;
      refine(static_cast<std::size_t>(lowest - edges_.begin()),
             {.tolerance = enough, .wanted = least_ - enough, .work_limit = kLeastWork});
      if (!(lowest->clearance.lower > lower)) return;
    }
  }

  const std::vector<EdgeClearance>& edges() const { return edges_; }
  /// A proof that edge i is farther than `lower`, from elsewhere.
  void raise(std::size_t i, double lower) {
    Interval& known = edges_[i].clearance;
    known.lower = std::max(known.lower, lower);
  }

 private:
  void refine(std::size_t i, const ClearanceRequest& request) {
    keep(i, certifier_.edgeClearance(path_[i], path_[i + 1], request));
  }

  void keep(std::size_t i, EdgeClearance found) {
    EdgeClearance& known = edges_[i];
    found.clearance.lower = std::max(found.clearance.lower, known.clearance.lower);
    if (found.clearance.upper < known.clearance.upper)
      known = found;
    else
      known.clearance.lower = found.clearance.lower;
    least_ = std::min(least_, known.clearance.upper);
  }

  EdgeCertifier& certifier_;
  const Waypoints& path_;
  double tolerance_;
  double least_ = kInfinity;  ///< no more than that is the path's clearance
  std::vector<EdgeClearance> edges_;
};

}  // namespace

double leastMargin(const collision::Scene& scene) {
  double least = kInfinity;
  for (const collision::ScenePair& pair : scene.pairs()) least = std::min(least, pair.margin);
  return least;
}

Certificate certify(EdgeCertifier& certifier, const Path& path, double tolerance,
                    CertificateDetail detail) {
  const collision::Scene& scene = certifier.scene().scene();
  const ConfigurationSpace& space = certifier.scene().space();
  Certificate certificate;
  certificate.clearance = {kInfinity, kInfinity};
  certificate.certified = !path.positions.empty();
  for (const std::vector<double>& position : path.positions)
    if (position.size() != static_cast<std::size_t>(space.size()) || !space.withinLimits(position))
      certificate.certified = false;

  if (path.positions.size() == 1) {
    const StateCheck check = certifier.clearance(path.positions[0], tolerance);
    certificate.clearance = check.clearance;
    certificate.certified = certificate.certified && check.verdict == Verdict::kFree;
    name(scene, check.pair, certificate.closest_a, certificate.closest_b);
    certificate.closest_segment = check.pair < 0 ? -1 : 0;
    certificate.closest_point_a = check.closest.point_a;
    certificate.closest_point_b = check.closest.point_b;
  }
  if (path.positions.size() < 2) return certificate;

  PathClearance clearance(certifier, path.positions, tolerance);
  // A free edge is proven to keep its margins, which may say more than the interval.
  const double least_margin = leastMargin(scene);
  for (std::size_t i = 0; i + 1 < path.positions.size(); ++i) {
    const EdgeCheck check =
        certifier.certify(path.positions[i], path.positions[i + 1], EdgeRequest::persistent());
    if (check.verdict == Verdict::kFree)
      clearance.raise(i, least_margin);
    else
      certificate.certified = false;
  }
  if (detail == CertificateDetail::kEveryEdge)
    clearance.refineAll();
  else
    clearance.refineLeast();

  for (std::size_t i = 0; i < clearance.edges().size(); ++i) {
    const EdgeClearance& edge = clearance.edges()[i];
    certificate.segments.push_back(edge.clearance);
    certificate.clearance.lower = std::min(certificate.clearance.lower, edge.clearance.lower);
    if (edge.clearance.upper < certificate.clearance.upper) {
      certificate.clearance.upper = edge.clearance.upper;
      certificate.closest_segment = static_cast<int>(i);
      certificate.closest_t = edge.t;
      certificate.closest_point_a = edge.closest.point_a;
      certificate.closest_point_b = edge.closest.point_b;
      name(scene, edge.pair, certificate.closest_a, certificate.closest_b);
    }
  }
  return certificate;
}

}  // namespace leeway::planner
