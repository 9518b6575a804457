#include "leeway/planner/simplify.h"

#include "collision/base/numbers.h"
#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/improve/improve_path.h"

namespace leeway::planner {
namespace {

/// The gain that a random cut must have, as a fraction of the path's length. With kShortcutGain,
/// which is for waypoints, a third more edges are checked and paths are 0.4 % shorter.
constexpr double kCutGain = 1e-3;

/// Number of random stretches and joints from which the one with the greatest gain is straightened.
/// Paths are 2 % shorter for the same number of edges than with one.
constexpr int kPartChoices = 4;

/// Edges between two polls of `stop`. A poll costs a tenth of an edge, which takes a few
/// microseconds.
constexpr int kStopTurn = 8;

/// A place on the path: t along the edge from waypoint `edge` to the next.
struct Place {
  std::size_t edge;
  double t;
};

/// Its measure is the length.
class Shortener : PathImprover {
 public:
  Shortener(EdgeCertifier& certifier, Waypoints& path, const SimplifyOptions& options)
      : PathImprover(certifier, path, options.stop, kStopTurn),
        options_(options),
        random_(options.seed) {}

  SimplifyResult run() {
    dropRepeated();
    rest_.assign(path_.size() - 1, 0);
    dropVertices();
    const Waypoints proven = path_;
    shortcut();
    if (!certifyRest()) {
      path_ = proven;
      rest_.assign(path_.size() - 1, 0);
      defers_ = false;
      if (!is_over_) shortcut();
    }
    pullVertices();
    dropVertices();
    return result_;
  }

 private:
  bool mayGain(const Move& move) override {
    return least_gain_ == -kInfinity ||
           lengthOf(move) < lengthBetween(move.first, move.last) - least_gain_;
  }

  bool proves(const Move& move, std::size_t edge) override {
    return (defers_ && isRest(move, edge)) || PathImprover::proves(move, edge);
  }

  void keep(const Move& move) override {
    std::vector<char> rests(move.points.size() + 1, 0);
    for (std::size_t k = 0; k < rests.size(); ++k) rests[k] = defers_ && isRest(move, k) ? 1 : 0;
    replace(rest_, move.first, move.last, rests);
  }

  /// Whether an edge of a cut is the rest of a proven edge.
  bool isRest(const Move& move, std::size_t edge) const {
    return (edge == 0 && begins_inside_) || (edge == move.points.size() && ends_inside_);
  }

  bool takeIfShorter(const Move& move, double by) {
    least_gain_ = by;
    return take(move);
  }

  /// Merges repeated waypoints; a path of one point keeps two.
  void dropRepeated() {
    std::size_t last = 0;
    for (std::size_t i = 1; i < path_.size(); ++i) {
      if (path_[i] == path_[last] && !(i + 1 == path_.size() && last == 0)) continue;
      if (++last != i) path_[last] = std::move(path_[i]);
    }
    path_.resize(last + 1);
  }

  /// Continues from each waypoint to the farthest one that a certified edge reaches, found by
  /// halving: O(n log n) edges.
  void dropVertices() {
    for (std::size_t i = 0; i + 2 < path_.size(); ++i)
      for (std::size_t j = path_.size() - 1; j > i + 1; j = i + 1 + (j - i - 1) / 2) {
        if (is_over_) return;
        if (takeIfShorter({i, j, {}}, -kInfinity)) break;
      }
  }

  /// Cuts leave two rests of certified edges, whose new ends rounding has moved off the edges. Both
  /// are nearly always free, and most are cut again, so they are certified together at the end.
  void shortcut() {
    result_ = {};
    int failures = 0;
    while (result_.attempts < options_.attempts && failures < options_.failures &&
           path_.size() > 2 && !isOver()) {
      ++result_.attempts;
      const bool success = result_.attempts % kPartEvery == 0 ? straightenPart() : cut();
      failures = success ? 0 : failures + 1;
      result_.shortcuts += success;
    }
  }

  /// False if some rest of a cut is not certified.
  bool certifyRest() {
    for (std::size_t i = 0; i < rest_.size(); ++i)
      if (rest_[i] != 0 && !PathImprover::proves({i, i + 1, {}}, 0)) return false;
    return true;
  }

  void measure() {
    along_.assign(1, 0.0);
    for (std::size_t i = 1; i < path_.size(); ++i)
      along_.push_back(along_.back() + space_.distance(path_[i - 1], path_[i]));
  }

  /// A place within `reach` of a waypoint is the waypoint, because such a short edge gains nothing.
  Place placeAt(double s, double reach) const {
    const auto next = std::upper_bound(along_.begin() + 1, along_.end() - 1, s);
    const auto edge = static_cast<std::size_t>(next - along_.begin()) - 1;
    const double length = along_[edge + 1] - along_[edge];
    const double t = length > 0 ? std::clamp((s - along_[edge]) / length, 0.0, 1.0) : 0.0;
    if (t * length < reach) return {edge, 0};
    if ((1 - t) * length < reach) return {edge + 1, 0};
    return {edge, t};
  }

  /// Tries a straight edge between two random places.
  bool cut() {
    measure();
    const double total = along_.back();
    double s0 = random_.uniform(0, total), s1 = random_.uniform(0, total);
    if (s0 > s1) std::swap(s0, s1);
    const Place from = placeAt(s0, kShortcutSnap * total), to = placeAt(s1, kShortcutSnap * total);
    // A cut needs more than one edge.
    if (to.edge <= from.edge || (to.edge == from.edge + 1 && to.t == 0)) return false;
    begins_inside_ = from.t > 0;
    ends_inside_ = to.t > 0;
    Waypoints points;
    if (begins_inside_) points.push_back(between(from.edge, from.t));
    if (ends_inside_) points.push_back(between(to.edge, to.t));
    const std::size_t last = ends_inside_ ? to.edge + 1 : to.edge;
    const bool success = takeIfShorter({from.edge, last, points}, kCutGain * total);
    begins_inside_ = ends_inside_ = false;
    return success;
  }

  /// Removes a detour of one joint where a cut of all joints would collide (the partial shortcut of
  /// Geraerts and Overmars). Of some random stretches and joints it takes the one with the greatest
  /// gain, because each of its edges must be certified.
  bool straightenPart() {
    measure();
    double most = kCutGain * along_.back();
    std::size_t first = 0, last = 0;
    const int count = static_cast<int>(path_.size());
    const int parts = static_cast<int>(space_.parts().size());
    for (int k = 0; k < kPartChoices; ++k) {
      int i = random_.index(count), j = random_.index(count);
      if (i > j) std::swap(i, j);
      const auto part = static_cast<std::size_t>(random_.index(parts));
      const auto from = static_cast<std::size_t>(i), to = static_cast<std::size_t>(j);
      const double gain = straighten(from, to, space_.parts()[part]);
      if (!(gain > most)) continue;
      most = gain;
      first = from;
      last = to;
      straightened_.swap(candidate_);
    }
    if (last == 0) return false;
    return takeIfShorter({first, last, std::span(straightened_).first(last - first - 1)},
                         -kInfinity);
  }

  /// The gain if, between two waypoints, one part moves at constant rate and the others as before.
  /// candidate_ gets the points.
  double straighten(std::size_t first, std::size_t last, const ConfigurationSpace::Part& part) {
    const double span = along_[last] - along_[first];
    if (last < first + 2 || !(span > 0)) return 0;
    const std::size_t width = part.kind == ConfigurationSpace::Kind::kRotation ? 4 : 1;
    candidate_.resize(std::max(candidate_.size(), last - first - 1));
    even_.resize(path_[0].size());
    double length = 0;
    const Point* before = &path_[first];
    for (std::size_t k = first + 1; k < last; ++k) {
      Point& point = candidate_[k - first - 1];
      point = path_[k];
      space_.interpolate(path_[first], path_[last], (along_[k] - along_[first]) / span, even_);
      std::copy_n(even_.begin() + part.first, width, point.begin() + part.first);
      length += space_.distance(*before, point);
      before = &point;
    }
    return span - (length + space_.distance(*before, path_[last]));
  }

  /// Moves each waypoint half of the way to its position on the chord of its neighbours, or a
  /// quarter, or an eighth.
  void pullVertices() {
    Point chord(path_[0].size()), pulled(path_[0].size());
    for (int sweep = 0; sweep < kPullSweeps; ++sweep) {
      const double before = pathLength(space_, path_);
      for (std::size_t i = 1; i + 1 < path_.size(); ++i) {
        if (is_over_) return;
        const double left = space_.distance(path_[i - 1], path_[i]);
        const double right = space_.distance(path_[i], path_[i + 1]);
        if (!(left + right > 0)) continue;
        space_.interpolate(path_[i - 1], path_[i + 1], left / (left + right), chord);
        for (double step = 0.5; step > 0.1; step /= 2) {
          space_.interpolate(path_[i], chord, step, pulled);
          if (takeIfShorter({i - 1, i + 1, {&pulled, 1}}, kShortcutGain * before)) break;
        }
      }
      if (!(pathLength(space_, path_) < before * (1 - kPullGain))) return;
    }
  }

  const SimplifyOptions& options_;
  Random random_;
  SimplifyResult result_;
  double least_gain_ = 0;
  std::vector<double> along_;           ///< the length up to each waypoint
  Waypoints straightened_, candidate_;  ///< the longest stretch so far determines their size
  Point even_;
  std::vector<char> rest_;  ///< one per edge: 1 for the rest of a certified edge after a cut
  bool begins_inside_ = false, ends_inside_ = false;  ///< edges of the current cut
  bool defers_ = true;                                ///< certifies rests later
};

}  // namespace

SimplifyResult simplify(EdgeCertifier& certifier, std::vector<std::vector<double>>& path,
                        const SimplifyOptions& options) {
  certifier.scene().space().requirePath(path, "simplify()");
  if (path.size() < 2) return {};
  if (options.clearance_floor == -kInfinity) return Shortener(certifier, path, options).run();
  EdgeCertifier wider(certifier.scene().withMarginAtLeast(options.clearance_floor));
  const SimplifyResult result = Shortener(wider, path, options).run();
  certifier.statistics += wider.statistics;
  return result;
}

double pathLength(const ConfigurationSpace& space, const std::vector<std::vector<double>>& path) {
  space.requirePath(path, "pathLength()");
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) length += space.distance(path[i - 1], path[i]);
  return length;
}

}  // namespace leeway::planner
