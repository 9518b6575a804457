#include "planner/constraint/constrained_way.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planner/base/tolerances.h"
#include "planner/validate/checks.h"

namespace leeway::planner {

ConstrainedWay::ConstrainedWay(const CompiledScene& scene, const Problem& problem,
                               const IsFree& is_free, double range)
    : scene_(scene),
      is_free_(is_free),
      range_(range),
      proof_(scene, problem),
      kinematics_(problem.robot.model, problem.robot.variables),
      q_(problem.start.size()) {
  for (const Constraint& constraint : problem.constraints)
    for (robots::PoseRegion& region : regionsOf(problem, constraint))
      regions_.push_back(std::move(region));
}

bool ConstrainedWay::isFree(std::span<const double> a, std::span<const double> b) {
  return proof_.holds(a, b) && is_free_(a, b);
}

bool ConstrainedWay::project(std::vector<double>& point) {
  if (proof_.holds(point)) return true;
  if (regions_.empty()) return false;
  scene_.expand(point, q_);
  robots::IkOptions options;
  options.starts = 1;
  options.closed_form = false;
  options.prove = false;
  robots::IkResult found = kinematics_.solve(regions_, q_, options);
  if (found.solutions.empty()) return false;
  point = std::move(found.solutions.front().values);
  return scene_.space().withinLimits(point);
}

bool ConstrainedWay::go(std::span<const double> from, std::span<const double> target,
                        std::vector<double>& points) {
  const ConfigurationSpace& space = scene_.space();
  at_.assign(from.begin(), from.end());
  next_.resize(from.size());
  double step = range_;
  for (int edges = 0; edges < kWayEdges; ++edges) {
    const double left = space.distance(at_, target);
    if (!(left > 0)) return true;
    const bool is_last = left <= step;
    if (is_last) {
      next_.assign(target.begin(), target.end());
    } else {
      space.interpolate(at_, target, step / left, next_);
    }
    const bool reaches =
        is_last ? proof_.holds(at_, next_)
                : project(next_) && space.distance(next_, target) < left - kWayGain * step &&
                      space.distance(at_, next_) < kWayDetour * step && proof_.holds(at_, next_);
    if (!reaches) {
      step = std::min(step, left) / 2;
      if (step < kShortestWayStep * range_) return false;
      continue;
    }
    if (!is_free_(at_, next_)) return false;
    points.insert(points.end(), next_.begin(), next_.end());
    if (is_last) return true;
    at_.swap(next_);
    step = std::min(2 * step, range_);
  }
  return false;
}

namespace {

using Point = std::vector<double>;

double lengthOf(const ConfigurationSpace& space, const std::vector<Point>& path, std::size_t first,
                std::size_t last) {
  double length = 0;
  for (std::size_t i = first; i < last; ++i) length += space.distance(path[i], path[i + 1]);
  return length;
}

/// Leaves points out: after each point that stays, tries edges to the 2nd, 4th, 8th, ... next one.
void leaveOut(ConstrainedWay& way, std::vector<Point>& path) {
  for (std::size_t i = 0; i + 2 < path.size(); ++i) {
    std::size_t next = i + 1;
    for (std::size_t skip = 2; i + skip < path.size(); skip *= 2) {
      if (!way.isFree(path[i], path[i + skip])) break;
      next = i + skip;
    }
    path.erase(path.begin() + static_cast<std::ptrdiff_t>(i) + 1,
               path.begin() + static_cast<std::ptrdiff_t>(next));
  }
}

}  // namespace

void shorten(ConstrainedWay& way, const ConfigurationSpace& space,
             std::vector<std::vector<double>>& path, std::uint64_t seed,
             const std::function<bool()>& stop) {
  Random random(seed, 0);
  std::vector<double> points;
  for (int cut = 0, in_vain = 0; cut < kWayCuts && in_vain < kWayCutsInVain; ++cut) {
    if (path.size() < 3 || stop()) break;
    ++in_vain;
    auto i = static_cast<std::size_t>(random.index(static_cast<int>(path.size())));
    auto k = static_cast<std::size_t>(random.index(static_cast<int>(path.size())));
    if (cut == 0) i = 0, k = path.size() - 1;
    if (i > k) std::swap(i, k);
    if (k - i < 2) continue;
    points.clear();
    if (!way.go(path[i], path[k], points)) continue;
    const std::size_t size = path[i].size();
    std::vector<Point> cut_path{path[i]};
    for (std::size_t p = 0; p < points.size(); p += size)
      cut_path.emplace_back(points.begin() + static_cast<std::ptrdiff_t>(p),
                            points.begin() + static_cast<std::ptrdiff_t>(p + size));
    if (!(lengthOf(space, cut_path, 0, cut_path.size() - 1) <
          (1 - kWayCutGain) * lengthOf(space, path, i, k)))
      continue;
    in_vain = 0;
    path.erase(path.begin() + static_cast<std::ptrdiff_t>(i),
               path.begin() + static_cast<std::ptrdiff_t>(k) + 1);
    path.insert(path.begin() + static_cast<std::ptrdiff_t>(i), cut_path.begin(), cut_path.end());
  }
  leaveOut(way, path);
}

}  // namespace leeway::planner
