#include "planner/objective/path_cost.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "collision/base/numbers.h"
#include "planner/base/tolerances.h"
#include "planner/objective/nearness.h"
#include "planner/validate/checks.h"

namespace leeway::planner {
namespace {

Interval outwards(Interval sum) {
  return {sum.lower - kSumRounding * std::abs(sum.lower),
          sum.upper + kSumRounding * std::abs(sum.upper)};
}

/// The scene with only the pairs that a wish names.
std::shared_ptr<const CompiledScene> withPairsOf(const CompiledScene& scene, const Wish& wish) {
  std::set<std::pair<std::string, std::string>> named;
  for (const auto& [a, b] : wish.pairs) {
    named.emplace(a, b);
    named.emplace(b, a);
  }
  const auto bodies = scene.scene().bodies();
  return scene.withPairs([&](const collision::ScenePair& pair) {
    return named.count({bodies[static_cast<std::size_t>(pair.body_a)].name,
                        bodies[static_cast<std::size_t>(pair.body_b)].name}) != 0;
  });
}

/// A single place becomes an edge without length.
std::vector<std::vector<double>> withAnEdge(std::vector<std::vector<double>> waypoints) {
  if (waypoints.size() == 1) waypoints.push_back(waypoints[0]);
  return waypoints;
}

std::shared_ptr<const CompiledScene> withPairsOf(const CompiledScene& scene, Pairs of) {
  return scene.withPairs([&](const collision::ScenePair& pair) {
    return of == Pairs::kAll || scene.isOfRobot(pair) == (of == Pairs::kSelf);
  });
}

}  // namespace

std::shared_ptr<PathCost> PathCost::of(const CompiledScene& scene, const Problem& problem) {
  if (!asksForCost(problem)) return nullptr;
  return std::shared_ptr<PathCost>(new PathCost(scene, problem));
}

PathCost::PathCost(const CompiledScene& scene, const Problem& problem)
    : scene_(std::make_shared<const CompiledScene>(scene)) {
  const auto* cost = std::get_if<MinimumCost>(&problem.objective);
  length_ = cost == nullptr ? 1 : cost->length;
  const auto add = [&](const Nearness& nearness, double weight, bool worst, bool is_wish,
                       std::shared_ptr<const CompiledScene> pairs) {
    terms_.push_back(
        {nearness, weight, worst, is_wish, std::make_shared<CertifierPool>(std::move(pairs))});
  };
  if (cost != nullptr)
    for (const CostTerm& term : cost->terms)
      if (term.weight > 0)
        add(term.nearness, term.weight, term.worst, false, withPairsOf(scene, term.of));
  for (const Wish& wish : problem.margins.wishes) {
    auto pairs = withPairsOf(scene, wish);
    if (pairs->scene().pairs().empty())
      warnings_.push_back(fmt::format("wish of {} m between {}: none of its pairs is checked",
                                      wish.clearance, wish.name));
    add({Nearness::Kind::kHinge, wish.clearance}, wish.weight, false, true, std::move(pairs));
  }
}

PathCost::Edge PathCost::edge(std::span<const double> a, std::span<const double> b,
                              const Request& request) {
  Edge edge;
  const double length = scene_->space().distance(a, b);
  edge.sum.lower = edge.sum.upper = length_ * length;
  for (const Term& term : terms_) {
    EdgeCertifier& certifier = term.pool->local().certifier;
    if (term.worst) {
      // A clearance beyond the reach of nearness costs nothing, so its value does not matter.
      const Interval clearance =
          certifier
              .edgeClearance(a, b,
                             {.tolerance = kWorstCostShare * term.nearness.distance,
                              .wanted = reachOf(term.nearness),
                              .work_limit = request.work_limit})
              .clearance;
      edge.worst.push_back(
          {nearnessAt(term.nearness, clearance.upper), nearnessAt(term.nearness, clearance.lower)});
      continue;
    }
    CostRequest asked{term.nearness, request.tolerance, kInfinity, request.work_limit};
    const double scale = term.weight * length;
    if (!(scale > 0)) continue;
    asked.cutoff = (request.cutoff - edge.sum.lower) / scale;
    const Interval mean = meanOf(certifier, a, b, asked, request.enough / scale);
    edge.sum.lower += scale * mean.lower;
    edge.sum.upper += scale * mean.upper;
    if (edge.sum.lower > request.cutoff) {
      edge.sum.upper = kInfinity;  // not all terms were evaluated
      break;
    }
  }
  edge.sum = outwards(edge.sum);
  return edge;
}

/// A first estimate converts `enough` to a share of the mean.
Interval PathCost::meanOf(EdgeCertifier& certifier, std::span<const double> a,
                          std::span<const double> b, CostRequest request, double enough) {
  if (!(enough > 0)) return certifier.edgeCost(a, b, request).mean;
  const double wanted = request.tolerance;
  request.tolerance = std::max(wanted, kFirstCostTolerance);
  const Interval first = certifier.edgeCost(a, b, request).mean;
  if (first.width() <= std::max(enough, wanted * first.upper) || first.lower > request.cutoff)
    return first;
  request.tolerance = std::max(wanted, enough / first.upper);
  const Interval mean = certifier.edgeCost(a, b, request).mean;
  return {std::max(first.lower, mean.lower), std::min(first.upper, mean.upper)};
}

Interval PathCost::total(std::span<const Edge> edges) const {
  Interval sum{0, 0};
  for (const Edge& edge : edges) {
    sum.lower += edge.sum.lower;
    sum.upper += edge.sum.upper;
  }
  std::size_t worst = 0;
  for (const Term& term : terms_) {
    if (!term.worst) continue;
    Interval greatest{0, 0};
    for (const Edge& edge : edges) {
      // An edge that was cut off has no worst values, and its upper end is infinity anyway.
      if (worst >= edge.worst.size()) continue;
      greatest = {std::max(greatest.lower, edge.worst[worst].lower),
                  std::max(greatest.upper, edge.worst[worst].upper)};
    }
    sum.lower += term.weight * greatest.lower;
    sum.upper += term.weight * greatest.upper;
    ++worst;
  }
  return outwards(sum);
}

Interval PathCost::path(const std::vector<std::vector<double>>& path, const Request& request) {
  const std::vector<std::vector<double>> waypoints = withAnEdge(path);
  std::vector<Edge> edges;
  for (std::size_t i = 1; i < waypoints.size(); ++i)
    edges.push_back(edge(waypoints[i - 1], waypoints[i], request));
  return total(edges);
}

Interval PathCost::reported(const std::vector<std::vector<double>>& waypoints) {
  const std::size_t asked = std::max<std::size_t>(1, waypoints.size() * terms_.size());
  const std::int64_t work = kCostReportWork / static_cast<std::int64_t>(asked);
  // The width of an edge's cost is compared with the cost of the whole path.
  const Interval rough = path(waypoints, {.tolerance = kFirstCostTolerance, .work_limit = work});
  const Interval fine =
      path(waypoints, {.tolerance = 0.8 * kCostTolerance,
                       .work_limit = work,
                       .enough = 0.2 * kCostTolerance * rough.lower / static_cast<double>(asked)});
  return {std::max(rough.lower, fine.lower), std::min(rough.upper, fine.upper)};
}

std::vector<WishResult> PathCost::wishes(const std::vector<std::vector<double>>& path,
                                         double tolerance) {
  const std::vector<std::vector<double>> waypoints = withAnEdge(path);
  std::vector<WishResult> results;
  for (const Term& term : terms_) {
    if (!term.is_wish) continue;
    EdgeCertifier& certifier = term.pool->local().certifier;
    const double wanted = term.nearness.distance;
    WishResult result{{kInfinity, kInfinity}, std::nullopt, {0, 0}};
    // Nothing is proven about pairs that are not checked.
    bool is_kept = !certifier.scene().scene().pairs().empty(), is_missed = false;
    for (std::size_t i = 1; i < waypoints.size(); ++i) {
      const std::vector<double>&a = waypoints[i - 1], &b = waypoints[i];
      const double scale = term.weight * scene_->space().distance(a, b);
      const Interval mean = certifier.edgeCost(a, b, {.nearness = term.nearness}).mean;
      result.cost.lower += scale * mean.lower;
      result.cost.upper += scale * mean.upper;
      Interval found = certifier.edgeClearance(a, b, {.tolerance = tolerance}).clearance;
      if (found.lower < wanted && found.upper >= wanted) {
        // So near to the wish that a proof is needed.
        const Interval proof =
            certifier
                .proveClearance(
                    a, b, {.tolerance = tolerance, .wanted = wanted, .work_limit = kPersistentWork})
                .clearance;
        found = {std::max(found.lower, proof.lower), std::min(found.upper, proof.upper)};
      }
      is_kept = is_kept && found.lower >= wanted;
      is_missed = is_missed || found.upper < wanted;
      result.clearance = {std::min(result.clearance.lower, found.lower),
                          std::min(result.clearance.upper, found.upper)};
    }
    if (is_kept || is_missed) result.kept = is_kept;
    result.cost = is_kept ? Interval{0, 0} : outwards(result.cost);
    results.push_back(result);
  }
  return results;
}

bool PathCost::isAdditive() const {
  return std::none_of(terms_.begin(), terms_.end(), [](const Term& term) { return term.worst; });
}

double PathCost::leastBetween(std::span<const double> a, std::span<const double> b) const {
  return (1 - kSumRounding) * length_ * scene_->space().distance(a, b);
}

std::vector<PathCost::Closest> PathCost::closestAt(std::span<const double> point) {
  std::vector<Closest> closest;
  for (const Term& term : terms_) {
    EdgeCertifier& certifier = term.pool->local().certifier;
    const EdgeClearance found = certifier.edgeClearance(
        point, point,
        {.tolerance = kGradientShare * term.nearness.distance, .wanted = reachOf(term.nearness)});
    const double d = found.clearance.upper, distance = term.nearness.distance;
    if (found.pair < 0 || !(d < reachOf(term.nearness))) continue;
    const double slope = term.nearness.kind == Nearness::Kind::kHinge ? -1 / distance
                         : d > distance                               ? -distance / (d * d)
                                                                      : -1 / distance;
    closest.push_back({found, term.weight * slope, &certifier.scene()});
  }
  return closest;
}

EdgeCertifier::Statistics PathCost::statistics() const {
  EdgeCertifier::Statistics sum;
  for (const Term& term : terms_) sum += term.pool->statistics();
  return sum;
}

}  // namespace leeway::planner
