#include "planner/improve/lower_cost.h"

#include <cmath>
#include <numeric>

#include "collision/base/numbers.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/contact/distance_gradient.h"

namespace leeway::planner {
namespace {

/// Sufficient width of the cost of a candidate's edge, as a share of the tolerance of the path's
/// cost.
constexpr double kEnough = 0.05;

/// Its measure is the upper end of the path's cost.
class CostLowering : PathImprover {
 public:
  CostLowering(EdgeCertifier& certifier, PathCost& cost, Waypoints& path,
               const LowerCostOptions& options)
      : PathImprover(certifier, path, options.stop),
        cost_(cost),
        options_(options),
        random_(options.seed),
        gradients_(certifier.scene()),
        difference_(path[0].size()) {}

  double run() {
    for (std::size_t i = 0; i + 1 < path_.size(); ++i)
      edges_.push_back(cost_.edge(path_[i], path_[i + 1], {.work_limit = kSearchCostWork}));
    upper_ = cost_.total(edges_).upper;
    is_over_ = upper_ <= options_.enough;
    int idle = 0;
    for (int round = 0; round < kCostRounds && idle < kIdleCostRounds && !isOver(); ++round) {
      const double before = upper_;
      for (std::size_t i = 1; i + 1 < path_.size(); ++i) moveWaypoint(i);
      bendEdges();
      for (int k = 0; k < kCostCuts; ++k) cut();
      for (std::size_t i = path_.size() - 1; i-- > 1;) takeIfCheaper({i - 1, i + 1, {}}, 0);
      idle = before - upper_ < kCostRoundGain * before ? idle + 1 : 0;
    }
    return upper_;
  }

 private:
  /// Takes the move if the path is then proven to cost less, by a share `gain`.
  bool takeIfCheaper(const Move& move, double gain) {
    gain_ = gain;
    return take(move);
  }

  bool mayGain(const Move& move) override {
    if (isOver()) return false;
    candidate_ = edges_;
    replace(candidate_, move.first, move.last, std::span<const PathCost::Edge>());
    wanted_ = (1 - gain_) * upper_;
    cutoff_ = wanted_ - cost_.total(candidate_).upper;
    double least = 0;
    for (std::size_t k = 0; k <= move.points.size(); ++k)
      least += cost_.leastBetween(pointOf(move, k), pointOf(move, k + 1));
    return least <= cutoff_;
  }

  /// The interval of the candidate is narrowed only as far as the comparison needs.
  bool gains(const Move& move) override {
    replace(candidate_, move.first, move.first,
            std::vector<PathCost::Edge>(move.points.size() + 1));
    for (const double tolerance : {kRoughCostTolerance, kCostTolerance}) {
      double spent = 0;
      for (std::size_t k = 0; k <= move.points.size(); ++k) {
        PathCost::Edge& edge = candidate_[move.first + k];
        edge = cost_.edge(pointOf(move, k), pointOf(move, k + 1),
                          {.tolerance = tolerance,
                           .cutoff = cutoff_ - spent,
                           .work_limit = kSearchCostWork,
                           .enough = tolerance * kEnough * upper_});
        spent += edge.sum.lower;
        if (spent > cutoff_) return false;
      }
      const double upper = cost_.total(candidate_).upper;
      if (!(upper <= wanted_ && (gain_ > 0 || upper <= upper_))) continue;
      upper_ = upper;
      return true;
    }
    return false;
  }

  void keep(const Move&) override {
    edges_.swap(candidate_);
    is_over_ = is_over_ || upper_ <= options_.enough;
  }

  /// The derivative of nearness along each direction of the space, per length, at a place; all 0 if
  /// no pair is near.
  Point nearnessGradient(const Point& place) {
    Point gradient(place.size(), 0.0);
    for (const PathCost::Closest& closest : cost_.closestAt(place)) {
      const std::span<const double> of_distance =
          gradients_.find(place, closest.found, *closest.scene);
      for (std::size_t k = 0; k < of_distance.size(); ++k)
        gradient[k] += closest.slope * of_distance[k];
    }
    return gradient;
  }

  /// A place moved by `step` along a direction, within the limits; empty if the limits do not allow
  /// it.
  Point moved(const Point& from, const Point& direction, double step) const {
    const double length =
        std::sqrt(std::inner_product(direction.begin(), direction.end(), direction.begin(), 0.0));
    if (!(length > 0) || !std::isfinite(length)) return {};
    Point point = advanced(from, direction, step / length);
    return point == from ? Point{} : point;
  }

  Point randomDirection() {
    Point direction(path_[0].size(), 0.0);
    for (const ConfigurationSpace::Part& part : space_.parts())
      for (int k = 0; k < (part.kind == ConfigurationSpace::Kind::kRotation ? 3 : 1); ++k) {
        const int i = part.first + k;
        direction[static_cast<std::size_t>(i)] = random_.uniform(-1, 1);
      }
    return direction;
  }

  /// The direction against the gradient of the cost of both edges at a waypoint: of nearness there
  /// and in their middles, and of their lengths.
  Point downhill(std::size_t i) {
    const double before = space_.distance(path_[i - 1], path_[i]);
    const double after = space_.distance(path_[i], path_[i + 1]);
    Point down(path_[0].size(), 0.0);
    const auto add = [&](const Point& gradient, double weight) {
      for (std::size_t k = 0; k < down.size(); ++k) down[k] -= weight * gradient[k];
    };
    add(nearnessGradient(path_[i]), (before + after) / 4);
    add(nearnessGradient(between(i - 1, 0.5)), before / 4);
    add(nearnessGradient(between(i, 0.5)), after / 4);
    for (const std::size_t other : {i - 1, i + 1}) {
      const double length = other < i ? before : after;
      if (!(length > 0)) continue;
      space_.difference(path_[i], path_[other], difference_);
      const double weight = cost_.leastBetween(path_[i], path_[other]) / length;
      for (std::size_t k = 0; k < down.size(); ++k) down[k] += weight * difference_[k] / length;
    }
    return down;
  }

  /// Tries longer steps as long as they gain, or shorter ones until one gains.
  bool moveAlong(std::size_t i, const Point& direction, double step) {
    bool has_moved = false;
    for (int k = 0; k < kCostSteps; ++k) {
      const Point point = moved(path_[i], direction, step);
      if (!point.empty() && takeIfCheaper({i - 1, i + 1, {&point, 1}}, kCostGain)) {
        has_moved = true;
        step *= 2;
      } else if (has_moved || isOver()) {
        break;
      } else {
        step /= 3;
      }
    }
    return has_moved;
  }

  void moveWaypoint(std::size_t i) {
    if (isOver()) return;
    const double step = kCostStep * std::min(space_.distance(path_[i - 1], path_[i]),
                                             space_.distance(path_[i], path_[i + 1]));
    if (moveAlong(i, downhill(i), step)) return;
    const Point point = moved(path_[i], randomDirection(), random_.uniform(0, 1) * step);
    if (!point.empty()) takeIfCheaper({i - 1, i + 1, {&point, 1}}, kCostGain);
  }

  /// Bends the edges with the greatest cost in addition to their length, where a pair is near.
  void bendEdges() {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i + 1 < path_.size(); ++i)
      order.emplace_back(cost_.leastBetween(path_[i], path_[i + 1]) - edges_[i].sum.upper, i);
    std::sort(order.begin(), order.end());
    if (order.size() > kCostBends) order.resize(kCostBends);
    // Starts at the end, because a bend changes the numbers of the edges after it.
    std::sort(order.begin(), order.end(),
              [](const auto& a, const auto& b) { return a.second > b.second; });
    for (const auto& [gain, i] : order) {
      if (isOver() || path_.size() > kMostCostWaypoints) return;
      const double t = random_.uniform(0.25, 0.75);
      const Point place = between(i, t);
      Point down = nearnessGradient(place);
      for (double& x : down) x = -x;
      double step = kCostStep * space_.distance(path_[i], path_[i + 1]);
      for (int k = 0; k < kCostSteps; ++k, step /= 3) {
        const Point point = moved(place, down, step);
        if (point.empty() || takeIfCheaper({i, i + 1, {&point, 1}}, kCostGain)) break;
      }
    }
  }

  /// Tries a straight edge between two random places.
  void cut() {
    const auto edges = static_cast<int>(path_.size()) - 1;
    int i = random_.index(edges), j = random_.index(edges);
    const double s = random_.uniform(0, 1), t = random_.uniform(0, 1);
    if (i > j) std::swap(i, j);
    if (i == j) return;
    const auto first = static_cast<std::size_t>(i), last = static_cast<std::size_t>(j);
    const Point points[] = {between(first, s), between(last, t)};
    takeIfCheaper({first, last + 1, points}, kCostGain);
  }

  PathCost& cost_;
  const LowerCostOptions& options_;
  Random random_;
  DistanceGradient gradients_;
  Point difference_;
  std::vector<PathCost::Edge> edges_, candidate_;  ///< of the path, and of the current move
  double upper_ = kInfinity;                       ///< proven for the path
  double gain_ = 0, wanted_ = 0, cutoff_ = 0;      ///< of the current move
};

}  // namespace

double lowerCost(EdgeCertifier& certifier, PathCost& cost, Waypoints& path,
                 const LowerCostOptions& options) {
  if (path.size() < 2) return 0;
  return CostLowering(certifier, cost, path, options).run();
}

}  // namespace leeway::planner
