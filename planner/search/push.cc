#include "planner/search/push.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/work.h"
#include "leeway/planner/simplify.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

// A path that was shortened touches its obstacles at few places. Each is found by a proof that
// fails there; the nearest waypoint, or a new one, moves along the gradient of the distance by what
// is missing, and the proof is tried again. Moves on the way prove nothing and need not: the path
// is taken whole, once all of its edges are proven, or left.

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
        gradient_(path[0].size()),
        direction_(path[0].size()),
        near_(path[0].size()),
        q_(scene_.model().variables.size()),
        X_WL_(scene_.model().links.size()),
        moved_(scene_.model().links.size()) {
    for (const ConfigurationSpace::Part& part : space_.parts())
      for (std::size_t k = 0; k < (part.kind == ConfigurationSpace::Kind::kRotation ? 3 : 1); ++k)
        directions_.push_back(index(part) + k);
  }

  /// The clearance that is proven for path(); 0: none.
  double run() {
    for (double target = options_.target; target >= options_.least && left() > 0; target /= 2) {
      path_ = original_;
      proven_.assign(path_.size() - 1, false);
      changed_.assign(path_.size() - 1, false);
      room_ = kInfinity;
      if (reach(target)) return target;
      // An end of the path limits what can be had.
      if (room_ < target && kPushEnds * room_ > target / 2) target = 2 * kPushEnds * room_;
    }
    return 0;
  }

  std::vector<Point>& path() { return path_; }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  std::int64_t left() const {
    if (options_.stop && options_.stop()) return 0;
    return options_.work - (certifier_.statistics.work - first_work_) - own_work_;
  }

  bool reach(double target) {
    int moves = 0;
    for (std::size_t i = 0; i + 1 < path_.size();) {
      if (proven_[i]) {
        ++i;
        continue;
      }
      const std::int64_t work = std::min(left(), kPushProofWork);
      if (work <= 0) return false;
      const EdgeClearance found = certifier_.proveClearance(path_[i], path_[i + 1],
                                                            {.tolerance = kBoundTolerance,
                                                             .wanted = target,
                                                             .work_limit = work,
                                                             .pairs = options_.pairs});
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
    if (is_end && share > kAtEnd) {
      room_ = found.clearance.upper;
      return false;
    }
    Point place(path_[i].size());
    space_.interpolate(path_[i], path_[i + 1], t, place);
    if (!findGradient(place, found)) return false;
    double squared = 0;
    for (const double g : gradient_) squared += g * g;
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
    space_.advance(moved, gradient_, step, place);
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

  /// How the distance of the closest pair changes along each direction of the space, by
  /// differences.
  bool findGradient(const Point& place, const EdgeClearance& found) {
    const collision::ScenePair& pair = scene_.scene().pairs()[static_cast<std::size_t>(found.pair)];
    const Eigen::Vector3d a = found.closest.point_a, b = found.closest.point_b;
    const double gap = (b - a).norm();
    const Eigen::Vector3d normal = gap > kPushGap ? ((b - a) / gap).eval() : found.closest.normal;
    if (!(std::abs(normal.squaredNorm() - 1) < 0.5)) return false;
    const int link_a = scene_.bodyLink(pair.body_a), link_b = scene_.bodyLink(pair.body_b);
    own_work_ +=
        static_cast<std::int64_t>((place.size() + 1) * X_WL_.size()) * collision::kPlacingWork;
    scene_.expand(place, q_);
    robots::forwardKinematics(scene_.model(), q_, X_WL_);
    std::fill(gradient_.begin(), gradient_.end(), 0.0);
    for (const std::size_t k : directions_) {
      direction_[k] = 1;
      space_.advance(place, direction_, kPushDifference, near_);
      direction_[k] = 0;
      scene_.expand(near_, q_);
      robots::forwardKinematics(scene_.model(), q_, moved_);
      const auto way = [&](int link, const Eigen::Vector3d& p_W) -> Eigen::Vector3d {
        if (link < 0) return Eigen::Vector3d::Zero();
        const auto l = static_cast<std::size_t>(link);
        return moved_[l] * (X_WL_[l].inverse() * p_W) - p_W;
      };
      gradient_[k] = normal.dot(way(link_b, b) - way(link_a, a)) / kPushDifference;
    }
    return true;
  }

  EdgeCertifier& certifier_;
  const CompiledScene& scene_;
  const ConfigurationSpace& space_;
  const std::vector<Point>& original_;
  const PushOptions& options_;
  std::int64_t first_work_, own_work_ = 0;
  std::vector<Point> path_;
  std::vector<char> proven_;   ///< edges, to keep the present target
  std::vector<char> changed_;  ///< edges that are not the original's
  double room_ = kInfinity;    ///< of an end of the path that is too near [m]
  Point gradient_, direction_, near_, q_;
  std::vector<std::size_t> directions_;  ///< an orientation has three
  std::vector<robots::Pose> X_WL_, moved_;
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
