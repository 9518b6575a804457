#include "leeway/planner/simplify.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/base/random.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {
namespace {

using Point = std::vector<double>;

/// What a random cut must gain, as a fraction of the path's length: with kShortcutGain, which is
/// for waypoints, a third more edges are asked for paths that are 0.4 % shorter.
constexpr double kCutGain = 1e-3;

/// Of so many random stretches and joints, that which gains most is straightened: 2 % shorter paths
/// for the same edges as with one.
constexpr int kPartChoices = 4;

/// Edges that are asked before the caller is asked whether to stop again, which costs a tenth of
/// one: some microseconds each.
constexpr int kStopTurn = 8;

/// A place on the path: t along the edge from waypoint `edge` to the next.
struct Place {
  std::size_t edge;
  double t;
};

class Shortener {
 public:
  Shortener(EdgeCertifier& certifier, std::vector<Point>& path, const SimplifyOptions& options)
      : certifier_(certifier),
        space_(certifier.scene().space()),
        path_(path),
        options_(options),
        random_(options.seed),
        defers_(options.clearance_floor == -std::numeric_limits<double>::infinity()) {}

  SimplifyResult run() {
    dropRepeated();
    dropVertices();
    const std::vector<Point> proven = path_;
    shortcut();
    if (!certifyRest()) {
      path_ = proven;
      defers_ = false;
      if (!stopped_) shortcut();
    }
    pullVertices();
    dropVertices();
    return result_;
  }

 private:
  bool stopped() {
    if (!stopped_ && options_.stop && turn_++ % kStopTurn == 0) stopped_ = options_.stop();
    return stopped_;
  }

  bool certified(const Point& a, const Point& b) {
    if (stopped() || certifier_.certify(a, b).verdict != Verdict::kFree) return false;
    if (options_.clearance_floor == -std::numeric_limits<double>::infinity()) return true;
    return certifier_.edgeClearance(a, b, options_.clearance_tolerance, options_.clearance_floor)
               .clearance.lower >= options_.clearance_floor;
  }

  double distance(const Point& a, const Point& b) const { return space_.distance(a, b); }

  /// Makes repeated waypoints one; a path of one point keeps two.
  void dropRepeated() {
    std::size_t last = 0;
    for (std::size_t i = 1; i < path_.size(); ++i) {
      if (path_[i] == path_[last] && !(i + 1 == path_.size() && last == 0)) continue;
      if (++last != i) path_[last] = std::move(path_[i]);
    }
    path_.resize(last + 1);
  }

  /// Goes on from each waypoint to the farthest that a certified edge reaches, tried by halves: O(n
  /// log n) edges.
  void dropVertices() {
    for (std::size_t i = 0; i + 2 < path_.size(); ++i) {
      for (std::size_t j = path_.size() - 1; j > i + 1; j = i + 1 + (j - i - 1) / 2) {
        if (stopped_) return;
        if (!certified(path_[i], path_[j])) continue;
        eraseBetween(i, j);
        break;
      }
    }
  }

  void eraseBetween(std::size_t i, std::size_t j) {
    path_.erase(path_.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                path_.begin() + static_cast<std::ptrdiff_t>(j));
  }

  /// Cuts leave two rests of certified edges, whose new ends rounding has moved off them: both are
  /// nearly always free, and most are cut again, so they are certified together at the end. (Where
  /// clearances are compared with a floor a rest may well be found below it: no waiting there.)
  void shortcut() {
    rest_.assign(path_.size() - 1, 0);
    result_ = {};
    int failures = 0;
    while (result_.attempts < options_.attempts && failures < options_.failures &&
           path_.size() > 2 && !stopped_) {
      ++result_.attempts;
      const bool success = result_.attempts % kPartEvery == 0 ? straightenPart() : shortcutOnce();
      failures = success ? 0 : failures + 1;
      result_.shortcuts += success;
    }
  }

  /// False when some rest of a cut is not certified.
  bool certifyRest() {
    for (std::size_t i = 0; i < rest_.size(); ++i)
      if (rest_[i] != 0 && !certified(path_[i], path_[i + 1])) return false;
    return true;
  }

  void measure() {
    along_.assign(1, 0.0);
    for (std::size_t i = 1; i < path_.size(); ++i)
      along_.push_back(along_.back() + distance(path_[i - 1], path_[i]));
  }

  Place placeAt(double s) const {
    const auto next = std::upper_bound(along_.begin() + 1, along_.end() - 1, s);
    const auto edge = static_cast<std::size_t>(next - along_.begin()) - 1;
    const double length = along_[edge + 1] - along_[edge];
    return {edge, length > 0 ? std::clamp((s - along_[edge]) / length, 0.0, 1.0) : 0.0};
  }

  /// A place within `reach` of a waypoint is the waypoint: an edge that short gains nothing.
  Place snapped(Place place, double reach) const {
    const double length = along_[place.edge + 1] - along_[place.edge];
    if (place.t * length < reach) return {place.edge, 0};
    if ((1 - place.t) * length < reach) return {place.edge + 1, 0};
    return place;
  }

  Point pointAt(const Place& place) const {
    if (place.t == 0) return path_[place.edge];
    Point point(path_[0].size());
    space_.interpolate(path_[place.edge], path_[place.edge + 1], place.t, point);
    return point;
  }

  bool shortcutOnce() {
    measure();
    const double total = along_.back();
    double s0 = random_.uniform(0, total), s1 = random_.uniform(0, total);
    if (s0 > s1) std::swap(s0, s1);
    const Place from = snapped(placeAt(s0), kShortcutSnap * total);
    const Place to = snapped(placeAt(s1), kShortcutSnap * total);
    // One edge has nothing to cut.
    if (to.edge <= from.edge || (to.edge == from.edge + 1 && to.t == 0)) return false;
    const Point a = pointAt(from), b = pointAt(to);
    // Compares the edges as they will stand, the rounding of both places included.
    const std::size_t last = to.t > 0 ? to.edge + 1 : to.edge;
    const double before = along_[last] - along_[from.edge];
    double after = distance(a, b);
    if (from.t > 0) after += distance(path_[from.edge], a);
    if (to.t > 0) after += distance(b, path_[last]);
    if (!(after < before - kCutGain * total)) return false;
    if (!certified(a, b)) return false;
    if (!defers_ && from.t > 0 && !certified(path_[from.edge], a)) return false;
    if (!defers_ && to.t > 0 && !certified(b, path_[last])) return false;
    std::vector<Point> inserted;
    std::vector<char> rests;
    if (from.t > 0) {
      inserted.push_back(a);
      rests.push_back(defers_ ? 1 : 0);
    }
    rests.push_back(0);
    if (to.t > 0) {
      inserted.push_back(b);
      rests.push_back(defers_ ? 1 : 0);
    }
    eraseBetween(from.edge, last);
    path_.insert(path_.begin() + static_cast<std::ptrdiff_t>(from.edge) + 1, inserted.begin(),
                 inserted.end());
    const auto first = rest_.begin() + static_cast<std::ptrdiff_t>(from.edge);
    rest_.erase(first, first + static_cast<std::ptrdiff_t>(last - from.edge));
    rest_.insert(rest_.begin() + static_cast<std::ptrdiff_t>(from.edge), rests.begin(),
                 rests.end());
    return true;
  }

  /// A stretch of the path in which one joint is to move evenly, the others as before.
  struct Stretch {
    std::size_t first = 0, last = 0;  // waypoints
    ConfigurationSpace::Part part;
    double gain = 0;
  };

  /// Takes out a detour of one joint where a cut of all would meet something (the partial shortcut
  /// of Geraerts and Overmars): of some random stretches and joints that which gains most, since
  /// each edge of it is to be certified.
  bool straightenPart() {
    measure();
    Stretch best;
    for (int k = 0; k < kPartChoices; ++k)
      if (const Stretch stretch = randomStretch(); stretch.gain > best.gain) best = stretch;
    if (!(best.gain > kCutGain * along_.back())) return false;
    straightened_.resize(std::max(straightened_.size(), best.last - best.first + 1));
    for (std::size_t k = best.first; k <= best.last; ++k)
      straighten(best, k, straightened_[k - best.first]);
    for (std::size_t k = best.first; k < best.last; ++k)
      if (!certified(straightened_[k - best.first], straightened_[k - best.first + 1]))
        return false;
    for (std::size_t k = best.first; k < best.last; ++k) rest_[k] = 0;
    for (std::size_t k = best.first; k <= best.last; ++k)
      path_[k].swap(straightened_[k - best.first]);
    return true;
  }

  /// Between two random waypoints; without gain where there is nothing to straighten.
  Stretch randomStretch() {
    const int count = static_cast<int>(path_.size());
    int i = random_.index(count), j = random_.index(count);
    if (i > j) std::swap(i, j);
    Stretch stretch{static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                    space_.parts()[static_cast<std::size_t>(
                        random_.index(static_cast<int>(space_.parts().size())))],
                    0};
    const double span = along_[stretch.last] - along_[stretch.first];
    if (stretch.last < stretch.first + 2 || !(span > 0)) return stretch;
    double length = 0;
    before_ = path_[stretch.first];
    for (std::size_t k = stretch.first + 1; k <= stretch.last; ++k) {
      straighten(stretch, k, after_);
      length += distance(before_, after_);
      before_.swap(after_);
    }
    stretch.gain = span - length;
    return stretch;
  }

  /// Waypoint k, with its part in a stretch where that moves evenly.
  void straighten(const Stretch& stretch, std::size_t k, Point& point) {
    point = path_[k];
    if (k == stretch.first || k == stretch.last) return;
    const double t =
        (along_[k] - along_[stretch.first]) / (along_[stretch.last] - along_[stretch.first]);
    even_.resize(point.size());
    space_.interpolate(path_[stretch.first], path_[stretch.last], t, even_);
    const std::size_t width = stretch.part.kind == ConfigurationSpace::Kind::kRotation ? 4 : 1;
    std::copy_n(even_.begin() + stretch.part.first, width, point.begin() + stretch.part.first);
  }

  /// Moves each waypoint half of the way to its place on the chord of its neighbours, or a quarter,
  /// or an eighth.
  void pullVertices() {
    Point chord(path_[0].size()), pulled(path_[0].size());
    for (int sweep = 0; sweep < kPullSweeps; ++sweep) {
      const double before = pathLength(space_, path_);
      for (std::size_t i = 1; i + 1 < path_.size(); ++i) {
        if (stopped_) return;
        const double left = distance(path_[i - 1], path_[i]);
        const double right = distance(path_[i], path_[i + 1]);
        if (!(left + right > 0)) continue;
        space_.interpolate(path_[i - 1], path_[i + 1], left / (left + right), chord);
        for (double step = 0.5; step > 0.1; step /= 2) {
          space_.interpolate(path_[i], chord, step, pulled);
          const double length = distance(path_[i - 1], pulled) + distance(pulled, path_[i + 1]);
          if (!(length < left + right - kShortcutGain * before)) break;
          if (!certified(path_[i - 1], pulled) || !certified(pulled, path_[i + 1])) continue;
          path_[i] = pulled;
          break;
        }
      }
      if (!(pathLength(space_, path_) < before * (1 - kPullGain))) return;
    }
  }

  EdgeCertifier& certifier_;
  const ConfigurationSpace& space_;
  std::vector<Point>& path_;
  const SimplifyOptions& options_;
  Random random_;
  SimplifyResult result_;
  std::vector<double> along_;
  std::vector<Point> straightened_;  ///< as many points as the longest stretch has had
  Point before_, after_, even_;
  int turn_ = 0;            ///< of stopped()
  std::vector<char> rest_;  ///< one an edge: 1 for what a cut has left of a certified one
  bool defers_;             ///< certifies them later
  bool stopped_ = false;
};

}  // namespace

SimplifyResult simplify(EdgeCertifier& certifier, std::vector<std::vector<double>>& path,
                        const SimplifyOptions& options) {
  certifier.scene().space().requirePath(path, "simplify()");
  if (path.size() < 2) return {};
  return Shortener(certifier, path, options).run();
}

double pathLength(const ConfigurationSpace& space, const std::vector<std::vector<double>>& path) {
  space.requirePath(path, "pathLength()");
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) length += space.distance(path[i - 1], path[i]);
  return length;
}

}  // namespace leeway::planner
