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

/// The cost of paths in one compiled scene: a weight of their length, and terms of nearness, each
/// over its own pairs. Every answer is an interval that contains the true value. Thread-safe.
class PathCost {
 public:
  /// The cost of the objective and the wishes of a valid problem; null if neither has a cost.
  /// O(pairs) per term.
  static std::shared_ptr<PathCost> of(const CompiledScene& scene, const Problem& problem);

  /// The cost of an edge: the sum that adds up along a path, including weights, and the greatest
  /// nearness of each worst-place term.
  struct Edge {
    Interval sum{0, std::numeric_limits<double>::infinity()};
    std::vector<Interval> worst;
  };
  struct Request {
    double tolerance = 0.01;  ///< as in CostRequest
    /// Stops once the sum is proven to be above it.
    double cutoff = std::numeric_limits<double>::infinity();
    std::int64_t work_limit = 0;  ///< of one term, as in CostRequest
    double enough = 0;            ///< a width of the sum that suffices in any case
  };
  Edge edge(std::span<const double> a, std::span<const double> b, const Request& request);
  /// The cost of a path's edges together.
  Interval total(std::span<const Edge> edges) const;
  Interval path(const std::vector<std::vector<double>>& path, const Request& request);
  /// As reported with a result: to 1 %, within a second of counted work.
  Interval reported(const std::vector<std::vector<double>>& waypoints);

  /// The result of each of the problem's wishes along a path, with clearances to within `tolerance`
  /// [m].
  std::vector<WishResult> wishes(const std::vector<std::vector<double>>& path, double tolerance);

  /// Whether no term counts the worst place: costs of edges then add up.
  bool isAdditive() const;
  /// A lower bound on the cost of every edge from a to b, and of every path between them.
  double leastBetween(std::span<const double> a, std::span<const double> b) const;

  /// The nearest pair at a configuration, for each term with a cost there.
  struct Closest {
    EdgeClearance found;
    double slope;  ///< derivative of weight times nearness by clearance: at most 0 [1/m]
    const CompiledScene* scene;
  };
  std::vector<Closest> closestAt(std::span<const double> point);

  /// Warnings about wishes without checked pairs: they cost nothing, and stay undecided.
  const std::vector<std::string>& warnings() const { return warnings_; }
  EdgeCertifier::Statistics statistics() const;

 private:
  struct Term {
    Nearness nearness;
    double weight;
    bool worst;
    bool is_wish;
    std::shared_ptr<CertifierPool> pool;  ///< of the scene with only its pairs
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
