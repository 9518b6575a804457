#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "leeway/planner/ompl_validity.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/wish_result.h"

namespace leeway::planner {

/// What paths cost in one compiled scene: a weight of their length, and terms of nearness, each of
/// its own pairs. Every answer is an interval that holds. Thread-safe.
class PathCost {
 public:
  /// The cost by the objective and the wishes of a valid problem; null if neither has a cost.
  /// O(pairs) a term.
  static std::shared_ptr<PathCost> of(const CompiledScene& scene, const Problem& problem);

  /// Of an edge: what adds up along a path, weights included, and the greatest nearness of each
  /// term that counts its worst.
  struct Edge {
    Interval sum{0, std::numeric_limits<double>::infinity()};
    std::vector<Interval> worst;
  };
  struct Request {
    double tolerance = 0.01;  ///< as CostRequest's
    /// Stops where the sum is known to be above it.
    double cutoff = std::numeric_limits<double>::infinity();
    std::int64_t work_limit = 0;  ///< of one term, as CostRequest's
    double enough = 0;            ///< a width of the sum that is good enough in any case
  };
  Edge edge(std::span<const double> a, std::span<const double> b, const Request& request);
  /// Of a path's edges together.
  Interval total(std::span<const Edge> edges) const;
  Interval path(const std::vector<std::vector<double>>& path, const Request& request);
  /// As it is told of a result: to 1 %, as far as a second of counted work goes.
  Interval reported(const std::vector<std::vector<double>>& waypoints);

  /// What becomes of the problem's wishes along a path, clearances to within `tolerance` [m].
  std::vector<WishResult> wishes(const std::vector<std::vector<double>>& path, double tolerance);

  /// No term counts its worst: costs of edges add up.
  bool isAdditive() const;
  /// No edge from a to b, and no path between them, costs less.
  double leastBetween(std::span<const double> a, std::span<const double> b) const;

  /// What is nearest at a configuration, for each term that it costs something.
  struct Closest {
    EdgeClearance found;
    double slope;  ///< of weight times nearness, by clearance: 0 or below [1/m]
    const CompiledScene* scene;
  };
  std::vector<Closest> closestAt(std::span<const double> point);

  /// Of wishes none of whose pairs is checked: they cost nothing, and stay undecided.
  const std::vector<std::string>& warnings() const { return warnings_; }
  EdgeCertifier::Statistics statistics() const;

 private:
  struct Term {
    Nearness nearness;
    double weight;
    bool worst;
    bool is_wish;
    std::shared_ptr<CertifierPool> pool;  ///< of the scene with its pairs alone
  };
  PathCost(const CompiledScene& scene, const Problem& problem);
  static Interval meanOf(EdgeCertifier& certifier, std::span<const double> a,
                         std::span<const double> b, CostRequest request, double enough);

  std::shared_ptr<const CompiledScene> scene_;
  double length_ = 0;
  std::vector<Term> terms_;
  std::vector<std::string> warnings_;
};

}  // namespace leeway::planner
