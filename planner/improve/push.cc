#include "planner/improve/push.h"

#include <cmath>
#include <numeric>

#include "collision/base/numbers.h"
#include "leeway/planner/simplify.h"
#include "planner/base/tolerances.h"
#include "planner/contact/distance_gradient.h"

// A shortened path touches its obstacles at few places. A rough measurement of an edge finds each
// place, or else a failed proof, which costs much more. Around it the nearest waypoint, or a new
// one, moves along the gradient of the distance by the missing clearance. The edges, including the
// neighbours, are measured again until all of them keep their targets. This is one move of the
// path; only the margins of the other pairs and the length remain to be checked. Failed proofs take
// nearly all of the work. So a move that gains nothing, or ends in contact, ends the attempt.

namespace leeway::planner {
namespace {

class Pusher : PathImprover {
 public:
  Pusher(EdgeCertifier& certifier, Waypoints& path, const PushOptions& options)
      : PathImprover(certifier, path, options.stop),
        options_(options),
        first_work_(certifier.statistics.work),
        length_(pathLength(space_, path)),
        edges_(path.size() - 1, Edge{options.target, false}),
        gradients_(certifier.scene()) {}

  /// Returns the clearance that is proven for the path; 0: none.
  double run() {
    limitBy(path_.front(), edges_.front());
    limitBy(path_.back(), edges_.back());
    // The whole path keeps no more than its ends. Ends with too little clearance do not limit other
    // places.
    const double most = std::min(edges_.front().target, edges_.back().target);
    if (most >= kPushEnough)
      for (Edge& edge : edges_) edge.target = most;
    for (std::size_t i = 0; i < edges_.size() && left() > 0;) {
      const double target = edges_[i].target;
      if (edges_[i].is_proven || isGivenUp(i)) {
        ++i;
        continue;
      }
      const EdgeClearance found = ask(path_[i], path_[i + 1], target);
      if (found.clearance.lower >= target)
        edges_[i].is_proven = true;
      else if (!pushAt(i, found))
        edges_[i].target = lesser(target);
    }
    return std::accumulate(edges_.begin(), edges_.end(), kInfinity, [](double kept, const Edge& e) {
      return std::min(kept, e.is_proven ? e.target : 0);
    });
  }

 private:
  struct Edge {
    double target;   ///< that it should keep [m]
    bool is_proven;  ///< to keep the target
  };

  /// An end never moves, so its edge keeps no more than the end has.
  void limitBy(const Point& end, Edge& edge) {
    const Interval room = certifier_
                              .edgeClearance(end, end,
                                             {.tolerance = kBoundTolerance,
                                              .wanted = options_.target / kPushEnds,
                                              .work_limit = kPushProofWork,
                                              .pairs = options_.pairs})
                              .clearance;
    edge.target = std::min(edge.target, kPushEnds * room.upper);
  }

  std::int64_t left() {
    if (isOver()) return 0;
    return options_.work - (certifier_.statistics.work - first_work_) - own_work_;
  }

  bool isGivenUp(std::size_t i) const { return edges_[i].target < options_.least; }

  /// The next target after a failed one: the clearance of an end that limits it, otherwise
  /// kPushEnough, finally the least; 0: none.
  double lesser(double target) const {
    if (kPushEnds * room_ < target) return kPushEnds * room_;
    const double next = std::max(options_.least, target > kPushEnough ? kPushEnough : 0);
    return next < target ? next : 0;
  }

  /// A rough measurement, and a proof if that does not decide. Skips the proof for an edge in
  /// contact, because the depth in it costs more than all other measurements at the place.
  EdgeClearance ask(const Point& a, const Point& b, double target) {
    const EdgeClearance found = certifier_.roughClearance(a, b, target, options_.pairs, true);
    if (found.clearance.lower >= target || found.clearance.upper < target) return found;
    if (!std::isfinite(found.clearance.upper) && !isFree(a, b)) return found;
    return certifier_.proveClearance(a, b,
                                     {.tolerance = kBoundTolerance,
                                      .wanted = target,
                                      .work_limit = std::max(left() / kPushProofs, kPushProofWork),
                                      .pairs = options_.pairs});
  }

  /// Checks only the margins, which lanes decide in a few microseconds.
  bool isFree(const Point& a, const Point& b) {
    return certifier_.certify(a, b).verdict == Verdict::kFree;
  }

  /// Whether edge i and the changed edges around it now keep their targets.
  bool pushAt(std::size_t i, const EdgeClearance& found) {
    first_ = i;
    last_ = i + 1;
    points_ = {path_[i], path_[i + 1]};
    moved_ = {edges_[i]};
    room_ = kInfinity;
    near_ = 0;
    found_ = found;
    const auto kept = static_cast<std::int64_t>(kPushKept * static_cast<double>(left()));
    if (!movePoints(kept)) {  // the points are close to a smaller target now
      const double target = lesser(edges_[i].target);
      if (!(target >= options_.least)) return false;
      for (Edge& edge : moved_) edge.target = std::min(edge.target, target);
      if (!areProven(kept / 2) && !movePoints(kept / 2)) return false;
    }
    return take({first_, last_, std::span(points_).subspan(1, points_.size() - 2)});
  }

  /// Moves points until all edges between them keep their targets. False if moves gain nothing, if
  /// there are too many of them, or if only `kept` of the work is left.
  bool movePoints(std::int64_t kept) {
    double nearest = found_.clearance.upper;
    for (int moves = 0, idle = 0; moves < kMostPushes && left() > kept; ++moves) {
      if (!moveAway()) return false;
      if (areProven(kept)) return true;
      const double now = found_.clearance.upper;
      if (now >= nearest + kPushGain * (moved_[near_].target - nearest))
        nearest = now, idle = 0;
      else if (++idle == kIdlePushes)
        return false;
    }
    return false;
  }

  /// Whether all edges between the points keep their targets. If not, edge `near_` does not, or the
  /// work limit was reached there.
  bool areProven(std::int64_t kept) {
    for (near_ = 0; near_ < moved_.size(); ++near_) {
      Edge& edge = moved_[near_];
      if (edge.is_proven) continue;
      if (left() <= kept) return false;
      found_ = ask(points_[near_], points_[near_ + 1], edge.target);
      edge.is_proven = found_.clearance.lower >= edge.target;
      if (!edge.is_proven) return false;
    }
    return true;
  }

  bool mayGain(const Move& move) override {
    next_length_ = length_ - lengthBetween(move.first, move.last) + lengthOf(move);
    return next_length_ <= options_.longest;
  }

  void keep(const Move& move) override {
    length_ = next_length_;
    replace(edges_, move.first, move.last, moved_);
  }

  /// At the place where the edge `near_` is too near, moves one of the points nearby, or adds a new
  /// one.
  bool moveAway() {
    const std::size_t k = near_;
    const EdgeClearance& found = found_;
    if (!std::isfinite(found.clearance.upper)) return false;
    std::size_t moved = found.t > 0.5 ? k + 1 : k;
    double share = found.t > 0.5 ? found.t : 1 - found.t;
    const bool is_first = moved == 0, is_last = moved + 1 == points_.size();
    const bool is_fixed = (is_first && (first_ == 0 || isGivenUp(first_ - 1))) ||
                          (is_last && (last_ == edges_.size() || isGivenUp(last_)));
    if (is_fixed && share > kAtEnd) {
      room_ = found.clearance.upper;
      return false;
    }
    Point place(points_[k].size());
    space_.interpolate(points_[k], points_[k + 1], found.t, place);
    own_work_ += gradients_.work();
    const std::span<const double> gradient = gradients_.find(place, found, certifier_.scene());
    const double squared =
        std::inner_product(gradient.begin(), gradient.end(), gradient.begin(), 0.0);
    if (!(squared > kLeastPushGradient)) return false;
    const double target = moved_[k].target;
    if (is_fixed || share < kPushSnap) {
      moved = k + 1;
      share = 1;
      points_.insert(points_.begin() + static_cast<std::ptrdiff_t>(moved), place);
      moved_.insert(moved_.begin() + static_cast<std::ptrdiff_t>(k), moved_[k]);
    } else if (is_first) {
      moved = 1;
      points_.insert(points_.begin(), path_[--first_]);
      moved_.insert(moved_.begin(), neighbor(first_, target));
    } else if (is_last) {
      moved_.push_back(neighbor(last_, target));
      points_.push_back(path_[++last_]);
    }
    const double step = std::min((kPushBeyond * target - found.clearance.upper) / share / squared,
                                 kLongestPush / std::sqrt(squared));
    Point next = advanced(points_[moved], gradient, step);
    if (next.empty()) return false;
    points_[moved] = std::move(next);
    moved_[moved - 1].is_proven = moved_[moved].is_proven = false;
    return true;
  }

  /// A neighbouring edge that a waypoint at a place also moves. The target of the place is
  /// sufficient there.
  Edge neighbor(std::size_t i, double target) const {
    return {std::min(edges_[i].target, target), false};
  }

  const PushOptions& options_;
  std::int64_t first_work_, own_work_ = 0;
  double length_, next_length_ = 0;
  std::vector<Edge> edges_;  ///< of the path
  // The current move: points from one waypoint to another, and the edges between them.
  std::size_t first_ = 0, last_ = 0;
  Waypoints points_;
  std::vector<Edge> moved_;
  std::size_t near_ = 0;     ///< one of these edges that is too near, ...
  EdgeClearance found_;      ///< ... and the place
  double room_ = kInfinity;  ///< clearance of an end that limited the target [m]
  DistanceGradient gradients_;
};

}  // namespace

double push(EdgeCertifier& certifier, Waypoints& path, const PushOptions& options) {
  if (path.size() < 2 || !(options.least > 0)) return 0;
  return Pusher(certifier, path, options).run();
}

}  // namespace leeway::planner
