#include <algorithm>
#include <cmath>
#include <limits>

#include "leeway/planner/plan.h"
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

}  // namespace

double leastMargin(const collision::Scene& scene) {
  double least = kInfinity;
  for (const collision::ScenePair& pair : scene.pairs()) least = std::min(least, pair.margin);
  return least;
}

Certificate certify(EdgeCertifier& certifier, const Path& path, double tolerance) {
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
  const double least_margin = leastMargin(scene);
  for (std::size_t i = 1; i < path.positions.size(); ++i) {
    const std::vector<double>&a = path.positions[i - 1], &b = path.positions[i];
    const bool free = certifier.certify(a, b, EdgeRequest::persistent()).verdict == Verdict::kFree;
    if (!free) certificate.certified = false;
    EdgeClearance edge = certifier.edgeClearance(a, b, tolerance, -kInfinity);
    // A free edge is proven to keep its margins, which may say more than the interval.
    if (free) edge.clearance.lower = std::max(edge.clearance.lower, least_margin);
    certificate.segments.push_back(edge.clearance);
    certificate.clearance.lower = std::min(certificate.clearance.lower, edge.clearance.lower);
    if (edge.clearance.upper < certificate.clearance.upper) {
      certificate.clearance.upper = edge.clearance.upper;
      certificate.closest_segment = static_cast<int>(i) - 1;
      certificate.closest_t = edge.t;
      certificate.closest_point_a = edge.closest.point_a;
      certificate.closest_point_b = edge.closest.point_b;
      name(scene, edge.pair, certificate.closest_a, certificate.closest_b);
    }
  }
  return certificate;
}

}  // namespace leeway::planner
