#include "planner/objective/lower_cost.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/contact/distance_gradient.h"

namespace leeway::planner {
namespace {

using Point = std::vector<double>;

/// Of a candidate's edge that share of the tolerance of the path's cost is narrow enough.
constexpr double kEnough = 0.05;

class CostLowering {
 public:
  CostLowering(EdgeCertifier& certifier, PathCost& cost, std::vector<Point>& path,
               const LowerCostOptions& options)
      : certifier_(certifier),
        space_(certifier.scene().space()),
        cost_(cost),
        path_(path),
        options_(options),
        random_(options.seed),
        gradients_(certifier.scene()),
        difference_(path[0].size()) {}

  double run() {
    for (std::size_t i = 0; i + 1 < path_.size(); ++i)
      edges_.push_back(cost_.edge(path_[i], path_[i + 1], {.work_limit = kSearchCostWork}));
    upper_ = cost_.total(edges_).upper;
    int idle = 0;
    for (int round = 0; round < kCostRounds && idle < kIdleCostRounds && !isOver(); ++round) {
      const double before = upper_;
      for (std::size_t i = 1; i + 1 < path_.size(); ++i) moveWaypoint(i);
      bendEdges();
      for (int k = 0; k < kCostCuts; ++k) cut();
      for (std::size_t i = path_.size() - 1; i-- > 1;) replace(i - 1, i + 1, {}, 0);
      idle = before - upper_ < kCostRoundGain * before ? idle + 1 : 0;
    }
    return upper_;
  }

 private:
  bool isOver() {
    if (!is_over_ && (upper_ <= options_.enough || (options_.stop && options_.stop())))
      is_over_ = true;
    return is_over_;
  }

  /// Puts points between two waypoints, in place of those that are there, if the path is proven to
  /// cost less then, by a share `gain`.
  bool replace(std::size_t first, std::size_t last, const std::vector<Point>& points, double gain) {
    if (isOver()) return false;
    std::vector<const Point*> chain = {&path_[first]};
    for (const Point& point : points) chain.push_back(&point);
    chain.push_back(&path_[last]);
    candidate_ = edges_;
    const auto begin = candidate_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto at = candidate_.erase(begin, begin + static_cast<std::ptrdiff_t>(last - first));
    const double wanted = (1 - gain) * upper_;
    const double cutoff = wanted - cost_.total(candidate_).upper;
    double least = 0;
    for (std::size_t k = 1; k < chain.size(); ++k)
      least += cost_.leastBetween(*chain[k - 1], *chain[k]);
    if (!(least <= cutoff)) return false;
    for (std::size_t k = 1; k < chain.size(); ++k)
      if (certifier_.certify(*chain[k - 1], *chain[k]).verdict != Verdict::kFree) return false;
    const auto place = at - candidate_.begin();
    candidate_.insert(at, chain.size() - 1, {});
    for (const double tolerance : {kRoughCostTolerance, kCostTolerance}) {
      double spent = 0;
      for (std::size_t k = 1; k < chain.size(); ++k) {
        PathCost::Edge& edge = candidate_[static_cast<std::size_t>(place) + k - 1];
        edge = cost_.edge(*chain[k - 1], *chain[k],
                          {.tolerance = tolerance,
                           .cutoff = cutoff - spent,
                           .work_limit = kSearchCostWork,
                           .enough = tolerance * kEnough * upper_});
        spent += edge.sum.lower;
        if (spent > cutoff) return false;
      }
      const double upper = cost_.total(candidate_).upper;
      if (!(upper <= wanted && (gain > 0 || upper <= upper_))) continue;
      upper_ = upper;
      edges_ = candidate_;
      const auto from = path_.begin() + static_cast<std::ptrdiff_t>(first) + 1;
      const auto rest = path_.erase(from, path_.begin() + static_cast<std::ptrdiff_t>(last));
      path_.insert(rest, points.begin(), points.end());
      return true;
    }
    return false;
  }

  Point between(std::size_t edge, double t) const {
    Point point(path_[0].size());
    space_.interpolate(path_[edge], path_[edge + 1], t, point);
    return point;
  }

  /// How nearness changes along each direction of the space, per length, at a place; all 0 where
  /// nothing is near.
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

  static double norm(const Point& v) {
    double squared = 0;
    for (const double x : v) squared += x * x;
    return std::sqrt(squared);
  }

  /// A place moved by `step` along a direction, within the limits; empty where that is nowhere.
  Point moved(const Point& from, Point direction, double step) const {
    const double length = norm(direction);
    if (!(length > 0) || !std::isfinite(length)) return {};
    for (double& x : direction) x *= step / length;
    Point point(from.size());
    space_.advance(from, direction, 1, point);
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      if (part.kind != ConfigurationSpace::Kind::kLine) continue;
      const auto k = static_cast<std::size_t>(part.first);
      point[k] = std::clamp(point[k], space_.lower(part.first), space_.upper(part.first));
    }
    if (!space_.withinLimits(point) || point == from) return {};
    return point;
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

  /// Against the gradient of the cost of both edges at a waypoint: of nearness there and in their
  /// middles, and of their lengths.
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

  /// Longer steps as long as they gain, shorter ones until one does.
  bool moveAlong(std::size_t i, const Point& direction, double step) {
    bool has_moved = false;
    for (int k = 0; k < kCostSteps; ++k) {
      const Point point = moved(path_[i], direction, step);
      if (!point.empty() && replace(i - 1, i + 1, {point}, kCostGain)) {
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
    if (!point.empty()) replace(i - 1, i + 1, {point}, kCostGain);
  }

  /// Bends the edges that cost most beside their length, where something is near.
  void bendEdges() {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i + 1 < path_.size(); ++i)
      order.emplace_back(cost_.leastBetween(path_[i], path_[i + 1]) - edges_[i].sum.upper, i);
    std::sort(order.begin(), order.end());
    if (order.size() > kCostBends) order.resize(kCostBends);
    // From the end on: a bend moves the edges behind it.
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
        if (point.empty() || replace(i, i + 1, {point}, kCostGain)) break;
      }
    }
  }

  /// A straight edge between two random places.
  void cut() {
    const auto edges = static_cast<int>(path_.size()) - 1;
    int i = random_.index(edges), j = random_.index(edges);
    const double s = random_.uniform(0, 1), t = random_.uniform(0, 1);
    if (i > j) std::swap(i, j);
    if (i == j) return;
    const auto first = static_cast<std::size_t>(i), last = static_cast<std::size_t>(j);
    replace(first, last + 1, {between(first, s), between(last, t)}, kCostGain);
  }

  EdgeCertifier& certifier_;
  const ConfigurationSpace& space_;
  PathCost& cost_;
  std::vector<Point>& path_;
  const LowerCostOptions& options_;
  Random random_;
  DistanceGradient gradients_;
  Point difference_;
  std::vector<PathCost::Edge> edges_, candidate_;
  double upper_ = std::numeric_limits<double>::infinity();  ///< proven of the path
  bool is_over_ = false;
};

}  // namespace

double lowerCost(EdgeCertifier& certifier, PathCost& cost, std::vector<std::vector<double>>& path,
                 const LowerCostOptions& options) {
  if (path.size() < 2) return 0;
  return CostLowering(certifier, cost, path, options).run();
}

}  // namespace leeway::planner
