#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/numbers.h"
#include "leeway/planner/plan.h"
#include "planner/base/tolerances.h"
#include "planner/search/search.h"

namespace leeway::planner {
namespace {

/// Refines what is known of the clearances of a path's edges from the world, or of the robot to
/// itself.
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

  /// Each edge to within the tolerance.
  void refineAll() {
    for (std::size_t i = 0; i < edges_.size(); ++i)
      keep(i, certifier_.edgeClearance(path_[i], path_[i + 1],
                                       {.tolerance = tolerance_, .pairs = pairs_}));
  }

  /// The path's least clearance, to a share of itself as far as a little work goes. An edge that is
  /// proven to stay above that share is not looked at closer. O(edges), beside the queries.
  void refineLeast() {
    for (const double most : {kRoughFirst, kRoughMost}) {
      for (std::size_t i = 0; i < edges_.size(); ++i) {
        const double enough = std::min((1 - kLeastShare) * least_, most);
        keep(i, certifier_.roughClearance(path_[i], path_[i + 1], enough, pairs_));
      }
      if (std::isfinite(least_)) break;
    }
    const std::int64_t before = certifier_.statistics.work;
    while (certifier_.statistics.work - before < kAllProofsWork) {
      const int i = lowestUnproven();
      if (i < 0) return;
      prove(i);
    }
  }

  const std::vector<EdgeClearance>& edges() const { return edges_; }
  /// A proof that edge i is farther than `lower`, from elsewhere.
  void raise(std::size_t i, double lower) {
    Interval& known = edges_[i].clearance;
    known.lower = std::max(known.lower, lower);
  }

  /// Of the whole path.
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
  void nameClosest(int pair, planner::PathClearance& whole) const {
    if (pair < 0) return;
    const collision::Scene& scene = certifier_.scene().scene();
    const collision::ScenePair& p = scene.pairs()[static_cast<std::size_t>(pair)];
    whole.closest_a = scene.bodies()[static_cast<std::size_t>(p.body_a)].name;
    whole.closest_b = scene.bodies()[static_cast<std::size_t>(p.body_b)].name;
  }

  /// What each edge is to keep: much of what the path does. Where a proof has failed for one, less
  /// is enough for all.
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
  double least_ = kInfinity;  ///< no more than that is the path's clearance
  std::vector<EdgeClearance> edges_;
  int tries_ = 0;  ///< proofs that have failed
};

/// The smallest margin of the pairs [m]; infinity without such pairs.
double leastMarginOf(const CompiledScene& compiled, Pairs pairs) {
  return compiled.scene().pairs().leastMargin(compiled.bodiesOfRobot(), pairs != Pairs::kSelf);
}

}  // namespace

Certificate certify(EdgeCertifier& certifier, const Path& path, double tolerance,
                    CertificateDetail detail, double world_guess) {
  const ConfigurationSpace& space = certifier.scene().space();
  Certificate certificate;
  certificate.clearance = certificate.world.clearance =
      certificate.self.clearance = {kInfinity, kInfinity};
  certificate.certified = !path.positions.empty();
  for (const std::vector<double>& position : path.positions)
    if (position.size() != static_cast<std::size_t>(space.size()) || !space.withinLimits(position))
      certificate.certified = false;
  if (path.positions.empty()) return certificate;

  // A place is an edge without length.
  const bool stays = path.positions.size() == 1;
  Waypoints positions = path.positions;
  if (stays) positions.push_back(positions[0]);
  std::vector<char> free;
  for (std::size_t i = 0; i + 1 < positions.size(); ++i) {
    const EdgeCheck check =
        certifier.certify(positions[i], positions[i + 1], EdgeRequest::persistent());
    free.push_back(check.verdict == Verdict::kFree ? 1 : 0);
    certificate.certified = certificate.certified && check.verdict == Verdict::kFree;
  }
  certificate.segments.assign(stays ? 0 : free.size(), {kInfinity, kInfinity});
  for (const Pairs pairs : {Pairs::kWorld, Pairs::kSelf}) {
    Clearances clearances(certifier, positions, tolerance, pairs,
                          pairs == Pairs::kWorld ? world_guess : 0);
    // A free edge is proven to keep its margins, which may say more than the interval.
    const double least_margin = leastMarginOf(certifier.scene(), pairs);
    for (std::size_t i = 0; i < free.size(); ++i)
      if (free[i] != 0) clearances.raise(i, least_margin);
    if (detail == CertificateDetail::kEveryEdge || stays)
      clearances.refineAll();
    else
      clearances.refineLeast();
    PathClearance& part = pairs == Pairs::kWorld ? certificate.world : certificate.self;
    part = clearances.whole();
    const double least = std::min(certificate.clearance.lower, part.clearance.lower);
    if (part.clearance.upper < certificate.clearance.upper)
      static_cast<PathClearance&>(certificate) = part;
    certificate.clearance.lower = least;
    for (std::size_t i = 0; i < certificate.segments.size(); ++i) {
      Interval& segment = certificate.segments[i];
      const Interval& found = clearances.edges()[i].clearance;
      segment = {std::min(segment.lower, found.lower), std::min(segment.upper, found.upper)};
    }
  }
  return certificate;
}

}  // namespace leeway::planner
