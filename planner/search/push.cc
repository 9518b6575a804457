#include "planner/search/push.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/simplify.h"
#include "planner/base/tolerances.h"
#include "planner/contact/distance_gradient.h"

// A path that was shortened touches its obstacles at few places. Each is found by a rough look at
// an edge, or by a proof that fails there, which costs much more; the nearest waypoint, or a new
// one, moves along the gradient of the distance by what is missing, and the edge is asked again.
// Moves on the way prove nothing and need not: the path is taken whole, once all of its edges are
// proven, or left.

namespace leeway::planner {
namespace {

using Point = std::vector<double>;

class Pusher {
 public:
  Pusher(EdgeCertifier& certifier, const std::vector<Point>& path, const PushOptions& options)
      : certifier_(certifier),
        scene_(certifier.scene()),
        space_(scene_.space()),
        original_(path),
        options_(options),
        first_work_(certifier.statistics.work),
        gradients_(scene_) {}

  /// The clearance that is proven for path(); 0: none.
  double run() {
    const double most = std::min(options_.target, kPushEnds * roomOfEnds());
    reset();
    for (double target = most; target >= options_.least && left() > 0; target /= 2) {
      keep_ = target / 2 >= options_.least
                  ? static_cast<std::int64_t>(kPushKept * static_cast<double>(left()))
                  : 0;
      if (reach(target)) return target;
      // Where only the work was spent, much of the path keeps the next target already.
      if (left() > keep_) reset();
    }
    return 0;
  }

  std::vector<Point>& path() { return path_; }

 private:
  std::int64_t left() const {
    if (options_.stop && options_.stop()) return 0;
    return options_.work - (certifier_.statistics.work - first_work_) - own_work_;
  }

  /// What the ends keep, which never move; infinity where that is more than is aimed at.
  double roomOfEnds() {
    double room = kInfinity;
    for (const Point* end : {&original_.front(), &original_.back()}) {
      const Interval found = certifier_
                                 .edgeClearance(*end, *end,
                                                {.tolerance = kBoundTolerance,
                                                 .wanted = options_.target / kPushEnds,
                                                 .work_limit = kPushProofWork,
                                                 .pairs = options_.pairs})
                                 .clearance;
      room = std::min(room, found.upper);
    }
    return room;
  }

  /// A rough look, and where that does not tell, a proof.
  EdgeClearance ask(const Point& a, const Point& b, double target, std::int64_t work) {
    const EdgeClearance found = certifier_.roughClearance(a, b, target, options_.pairs, true);
    if (found.clearance.lower >= target || found.clearance.upper < target) return found;
    return certifier_.proveClearance(a, b,
                                     {.tolerance = kBoundTolerance,
                                      .wanted = target,
                                      .work_limit = work,
                                      .pairs = options_.pairs});
  }

  void reset() {
    path_ = original_;
    proven_.assign(path_.size() - 1, false);
    changed_.assign(path_.size() - 1, false);
  }

  bool reach(double target) {
    int moves = 0;
    for (std::size_t i = 0; i + 1 < path_.size();) {
      if (proven_[i]) {
        ++i;
        continue;
      }
      const std::int64_t work = std::min(left() - keep_, kPushProofWork);
      if (work <= 0) return false;
      const EdgeClearance found = ask(path_[i], path_[i + 1], target, work);
      if (found.clearance.lower >= target) {
        proven_[i++] = true;
        continue;
      }
      if (!std::isfinite(found.clearance.upper) || moves++ == kMostPushes ||
          !moveAway(i, found, target))
        return false;
      i = i > 0 ? i - 1 : 0;  // a moved waypoint changes the edge before, too
    }
    if (!(pathLength(space_, path_) <= options_.longest)) return false;
    for (std::size_t i = 0; i + 1 < path_.size(); ++i)
      if (changed_[i] && certifier_.certify(path_[i], path_[i + 1]).verdict != Verdict::kFree)
        return false;
    return true;
  }

  /// Moves a waypoint near the place where edge i is too near, or makes one there.
  bool moveAway(std::size_t i, const EdgeClearance& found, double target) {
    const double t = found.t;
    const std::size_t last = path_.size() - 1;
    std::size_t waypoint = i;
    double share = 1 - t;
    if (t > 0.5) waypoint = i + 1, share = t;
    const bool is_end = waypoint == 0 || waypoint == last;
    if (is_end && share > kAtEnd) return false;
    Point place(path_[i].size());
    space_.interpolate(path_[i], path_[i + 1], t, place);
    own_work_ += gradients_.work();
    const std::span<const double> gradient = gradients_.find(place, found, scene_);
    double squared = 0;
    for (const double g : gradient) squared += g * g;
    if (!(squared > kLeastPushGradient)) return false;
    if (is_end || share < kPushSnap) {
      const auto at = static_cast<std::ptrdiff_t>(i) + 1;
      path_.insert(path_.begin() + at, place);
      proven_.insert(proven_.begin() + at, false);
      changed_.insert(changed_.begin() + at, true);
      waypoint = i + 1;
      share = 1;
    }
    const double step = std::min((kPushBeyond * target - found.clearance.upper) / share / squared,
                                 kLongestPush / std::sqrt(squared));
    Point& moved = path_[waypoint];
    space_.advance(moved, gradient, step, place);
    for (const ConfigurationSpace::Part& part : space_.parts())
      if (part.kind == ConfigurationSpace::Kind::kLine)
        place[index(part)] =
            std::clamp(place[index(part)], space_.lower(part.first), space_.upper(part.first));
    moved = place;
    proven_[waypoint - 1] = proven_[waypoint] = false;
    changed_[waypoint - 1] = changed_[waypoint] = true;
    return space_.withinLimits(moved);
  }

  static std::size_t index(const ConfigurationSpace::Part& part) {
    return static_cast<std::size_t>(part.first);
  }

  EdgeCertifier& certifier_;
  const CompiledScene& scene_;
  const ConfigurationSpace& space_;
  const std::vector<Point>& original_;
  const PushOptions& options_;
  std::int64_t first_work_, own_work_ = 0;
  std::int64_t keep_ = 0;  ///< of the work, for lesser targets
  std::vector<Point> path_;
  std::vector<char> proven_;   ///< edges, to keep the present target
  std::vector<char> changed_;  ///< edges that are not the original's
  DistanceGradient gradients_;
};

}  // namespace

double push(EdgeCertifier& certifier, std::vector<std::vector<double>>& path,
            const PushOptions& options) {
  if (path.size() < 2 || !(options.least > 0)) return 0;
  Pusher pusher(certifier, path, options);
  const double clearance = pusher.run();
  if (clearance > 0) path = std::move(pusher.path());
  return clearance;
}

}  // namespace leeway::planner
