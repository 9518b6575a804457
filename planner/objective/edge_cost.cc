// Integrals of nearness along an edge, by branch and bound over its parts.
//
// Let [t0, t1] be a part with middle m, seen from body b of a pair. No point of body a leaves the
// chord of its positions at t0 and m, or at m and t1, by more than g = (h/2)^2 A / 8. So in each
// half
//   the gap at a fixed plane is at least the line through its values at the ends, minus g
//     (the least over points of lines is above the line through the least at both ends);
//   the distance of two fixed points is at most the line through its values, plus g
//     (a norm of a line is convex).
// With the plane and the points of the distance at m, both lines meet there except for g, and the
// gap between them falls with h^2. The least of the pairs' lower lines at both ends of a half gives
// a line that is below all of them. Nearness never increases with the distance, and its integral
// over a line has a closed form. So each half gives both ends of an interval. The part with the
// widest interval is halved next.

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/distance/plane_gap.h"
#include "collision/scene/scene_access.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"
#include "planner/edge/edge_certifier_impl.h"
#include "planner/objective/nearness.h"

namespace leeway::planner {

class EdgeCertifier::Impl::CostSearch {
 public:
  CostSearch(Impl& impl, const CostRequest& request)
      : impl_(impl), request_(request), reach_(reachOf(request.nearness)) {}

  EdgeCost run() {
    const int start = impl_.frames.place(0), end = start < 0 ? -1 : impl_.frames.place(1);
    if (end < 0) return {};
    if (!impl_.takeWholeEdge(start, end, reach_ + impl_.frames.pairs().mostRounding())) return {};
    parts_.clear();
    add(impl_.queue.intervals().front());
    while (!isEnough() && splitWidest()) {
    }
    return result();
  }

 private:
  /// Bounds at both ends of half a part; their lines bound the clearance in between.
  struct Line {
    double begin, end;
    double sum() const { return begin + end; }
  };

  bool isEnough() const {
    return upper_ - lower_ <= std::max(request_.tolerance * upper_, CostRequest::kLeast) ||
           lower_ > request_.cutoff || impl_.work.isSpent();
  }

  static bool isNarrower(const CostPart& x, const CostPart& y) {
    return x.upper - x.lower < y.upper - y.lower;
  }

  void add(EdgeInterval interval) {
    parts_.push_back(bounded(interval));
    lower_ += parts_.back().lower;
    upper_ += parts_.back().upper;
    std::push_heap(parts_.begin(), parts_.end(), isNarrower);
  }

  /// False if the list of parts is full.
  bool splitWidest() {
    const CostPart widest = parts_.front();
    if (widest.interval.level >= kDeepestLevel || widest.middle < 0 ||
        parts_.size() + 1 >= parts_.capacity() || !impl_.queue.hasRoomToHalve(widest.interval) ||
        impl_.frames.used() + 2 > kEdgeSlots)
      return false;
    std::pop_heap(parts_.begin(), parts_.end(), isNarrower);
    parts_.pop_back();
    lower_ -= widest.lower;
    upper_ -= widest.upper;
    const auto [left, right] = impl_.queue.halve(widest.interval, widest.middle);
    add(left);
    add(right);
    return true;
  }

  /// The integral of nearness over a part. Keeps the pairs that may be the nearest.
  CostPart bounded(EdgeInterval& interval) {
    ++impl_.statistics->intervals;
    impl_.queries.startInterval();
    CostPart part{interval, -1, 0, interval.h, -kInfinity, kInfinity};
    part.middle = impl_.frames.place(interval.t0 + interval.h / 2);
    if (part.middle < 0) return part;
    sortPairs(interval);
    for (Line& line : uppers_) line = {kInfinity, kInfinity};
    for (Line& line : lowers_) line = {reach_, reach_};
    double enough = reach_;  // greater distances cost nothing
    std::size_t kept = 0;
    for (const auto& [lower, p] : impl_.order) {
      if (lower >= enough || !bound(interval, part.middle, p, enough)) continue;
      impl_.queue.pairs(interval)[kept++] = p;
      enough = std::min(enough, std::max(highest(uppers_[0]), highest(uppers_[1])));
    }
    interval.end = interval.begin + static_cast<int>(kept);
    part.interval = interval;
    // Below 0 the lines are not valid, because depths of meshes may grow faster than points move.
    const double least = std::min(lowest(lowers_[0]), lowest(lowers_[1]));
    part.clearance = least > 0 ? least : -kInfinity;
    part.nearest = std::min({uppers_[0].begin, uppers_[0].end, uppers_[1].end});
    part.upper = part.lower = 0;
    for (int half = 0; half < 2; ++half) {
      part.upper += interval.h / 2 * meanOver(lowers_[half].begin, lowers_[half].end).upper;
      part.lower += interval.h / 2 * meanOver(uppers_[half].begin, uppers_[half].end).lower;
    }
    return part;
  }

  Interval meanOver(double begin, double end) const {
    return meanNearness(request_.nearness, begin, end);
  }
  static double lowest(const Line& line) { return std::min(line.begin, line.end); }
  static double highest(const Line& line) { return std::max(line.begin, line.end); }

  /// The open pairs that may come within reach, nearest first by their balls.
  void sortPairs(const EdgeInterval& interval) {
    impl_.order.clear();
    for (const int p : impl_.queue.pairs(interval)) {
      const EdgePair& pair = impl_.frames.pair(p);
      double growth = 0;
      const double lower = impl_.queries.coarseSweep(interval, pair, growth) - pair.rounding;
      if (lower < reach_) impl_.order.emplace_back(lower, p);
    }
    std::sort(impl_.order.begin(), impl_.order.end());
  }

  /// Applies a pair's bounds to a part; false if the pair is never nearer than `enough`.
  bool bound(const EdgeInterval& interval, int middle, int p, double enough) {
    const EdgePair& pair = impl_.frames.pair(p);
    const robots::MotionBound& moves = impl_.queries.motionOf(interval, pair.motion);
    const double half_way = interval.h / 2 * moves.speed;
    const double growth = interval.h * interval.h / 4 * moves.acceleration / 8 + pair.rounding;
    collision::DistanceRequest request;
    // A tolerance finer than how far points leave their chords does not help.
    request.tolerance = std::max(kCostDistance * request_.nearness.distance, growth / 4);
    if (std::isfinite(enough)) request.threshold = enough + half_way + pair.rounding;
    collision::DistanceResult found = impl_.queries.distanceAt(middle, pair, request);
    if (found.status == collision::DistanceStatus::kNotAboveThreshold &&
        found.distance.width() > request.tolerance) {
      request.threshold = std::numeric_limits<double>::quiet_NaN();
      found = impl_.queries.distanceAt(middle, pair, request);
    }
    const double lower = found.distance.lower - pair.rounding;
    if (lower - half_way >= enough) return false;
    const collision::ThreePoses X_BA{impl_.frames.relative(interval.slot0, pair),
                                     impl_.frames.relative(middle, pair),
                                     impl_.frames.relative(interval.slot1, pair)};
    const collision::ThreeGaps above = boundAbove(pair, found, middle, X_BA, growth, half_way);
    boundBelow(pair, found, middle, X_BA, growth, lower, half_way, above);
    return true;
  }

  /// By the two nearest points, or by speed if there are none.
  collision::ThreeGaps boundAbove(const EdgePair& pair, const collision::DistanceResult& found,
                                  int middle, const collision::ThreePoses& X_BA, double growth,
                                  double half_way) {
    collision::ThreeGaps above;
    const double upper = found.distance.upper + pair.rounding;
    if (found.distance.lower > 0) {
      const bool is_reversed = isReversed(pair);
      const Eigen::Vector3d& a_W = is_reversed ? found.point_b : found.point_a;
      const Eigen::Vector3d& b_W = is_reversed ? found.point_a : found.point_b;
      const Eigen::Vector3d a_A = impl_.frames.piecePose(middle, pair.a).inverse() * a_W;
      const Eigen::Vector3d b_B = impl_.frames.piecePose(middle, pair.b).inverse() * b_W;
      // Points of hulls may protrude from meshes; the upper end allows for this.
      const double excess = std::max(0.0, found.distance.upper - (a_W - b_W).norm());
      for (std::size_t k = 0; k < above.size(); ++k)
        above[k] = (X_BA[k] * a_A - b_B).norm() + excess + growth + kWitness;
    } else {
      // Contact gives no information about where points go.
      above[1] = std::max(upper, 0.0);
      above[0] = above[2] = above[1] + half_way;
    }
    for (std::size_t half = 0; half < 2; ++half) {
      const Line line{above[half], above[half + 1]};
      if (line.sum() < uppers_[half].sum()) uppers_[half] = line;
    }
    return above;
  }

  /// By planes, or by speed.
  void boundBelow(const EdgePair& pair, const collision::DistanceResult& found, int middle,
                  const collision::ThreePoses& X_BA, double growth, double lower, double half_way,
                  const collision::ThreeGaps& above) {
    const collision::Shape& a = impl_.frames.piece(pair.a).shape();
    const collision::Shape& b = impl_.frames.piece(pair.b).shape();
    const Eigen::Vector3d away_W = isReversed(pair) ? found.normal : -found.normal;
    const Eigen::Vector3d away_B =
        impl_.frames.piecePose(middle, pair.b).rotation.transpose() * away_W;
    collision::ThreeGaps below = collision::planeGaps(a, X_BA, b, away_B);
    // A hull may be nearer than the mesh.
    const double slack = std::max(kPlaneSlack * request_.nearness.distance, growth);
    if (!impl_.frames.isConvex(pair) && lower > 0 && below[1] < lower - slack) {
      collision::ThreeGaps wanted = above;
      for (double& gap : wanted) gap = std::min(gap, reach_) - slack;
      int nodes = kPlaneNodes;
      const collision::ThreeGaps of_surface = collision::surfaceGaps(
          a, X_BA, b, wanted, nodes, collision::SceneAccess::scratch(impl_.workspace));
      impl_.work.add((kPlaneNodes - nodes) * collision::kPairWork);
      if (of_surface[1] > below[1]) below = of_surface;
    }
    for (std::size_t half = 0; half < 2; ++half) {
      const Line by_plane{below[half] - growth, below[half + 1] - growth};
      Line by_speed{lower - half_way, lower - half_way};
      (half == 0 ? by_speed.end : by_speed.begin) = lower;
      const Line& line = meanOver(by_plane.begin, by_plane.end).upper <
                                 meanOver(by_speed.begin, by_speed.end).upper
                             ? by_plane
                             : by_speed;
      lowers_[half] = {std::min(lowers_[half].begin, boundOf(line.begin)),
                       std::min(lowers_[half].end, boundOf(line.end))};
    }
  }

  /// NaN bounds nothing, so it becomes -infinity.
  static double boundOf(double lower) { return std::isnan(lower) ? -kInfinity : lower; }

  bool isReversed(const EdgePair& pair) const { return pair.is_reversed; }

  EdgeCost result() const {
    EdgeCost cost;
    cost.mean = cost.clearance = {kInfinity, kInfinity};
    double lower = 0, upper = 0;
    for (const CostPart& part : parts_) {
      lower += part.lower;
      upper += part.upper;
      cost.clearance.lower = std::min(cost.clearance.lower, part.clearance);
      cost.clearance.upper = std::min(cost.clearance.upper, part.nearest);
    }
    cost.mean = {std::max(0.0, lower - kCostRounding), std::min(1.0, upper + kCostRounding)};
    if (upper == 0) cost.mean = {0, 0};
    cost.worst = {nearnessAt(request_.nearness, cost.clearance.upper),
                  nearnessAt(request_.nearness, cost.clearance.lower)};
    return cost;
  }

  Impl& impl_;
  const CostRequest& request_;
  double reach_;  ///< nearness is 0 from there on [m]
  std::vector<CostPart>& parts_ = impl_.cost_parts;
  double lower_ = 0, upper_ = 0;  ///< sums over parts_
  Line uppers_[2], lowers_[2];    ///< of the current part
};

EdgeCost EdgeCertifier::edgeCost(std::span<const double> a, std::span<const double> b,
                                 const CostRequest& request) {
  ++statistics.edges;
  Impl& impl = *impl_;
  impl.startWork(request.work_limit > 0 ? request.work_limit : kCostWork);
  if (!(request.nearness.distance > 0) || !impl.frames.begin(a, b)) return {};
  const EdgeCost cost = Impl::CostSearch(impl, request).run();
  statistics.work += impl.work.done;
  return cost;
}

}  // namespace leeway::planner
