#include "tools/view/executed_clearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <variant>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/execute/obstacles.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools::view {
namespace {

using planner::CompiledScene;
using planner::EdgeCertifier;
using planner::TimedPoint;

constexpr double kExecutedWidths[] = {1e-4, 1e-5, 1.9e-6, 1e-7};  // [m]
constexpr std::int64_t kRowWork = kFigureWork / 10;
/// Limit on placements of obstacles that move in each pass, times the vertices that each updates
/// and what it costs besides.
constexpr double kPlacedVertices = 2e7, kPlacementCost = 1000;
constexpr int kMostHalvings = 40;  // of a row

/// Passes over the steps of an execution, each with narrower intervals.
class StepsPasses {
 public:
  StepsPasses(const planner::Problem& problem, std::shared_ptr<const CompiledScene> scene,
              const std::vector<planner::ReplanStep>& steps, const std::function<bool()>& stop)
      : problem_(problem), scene_(std::move(scene)), steps_(steps), stop_(stop) {
    found_.least.world.clearance = found_.least.self.clearance = {kInfinity, kInfinity};
    double vertices = kPlacementCost;
    for (const planner::DeformingObstacle& o : problem.world.deforming)
      vertices += o.mesh->vertexCount();
    most_placements_ = static_cast<int>(kPlacedVertices / vertices);
  }

  ExecutedClearance refined() {
    pass(kExecutedWidths[0], true);
    for (const double width : kExecutedWidths) {
      pass(width, false);
      const auto hasFigure = [](const planner::PathClearance& of) {
        return !std::isfinite(of.clearance.upper) || figureOf(of.clearance);
      };
      if ((hasFigure(found_.least.world) && hasFigure(found_.least.self)) || (stop_ && stop_()))
        break;
    }
    LeastClearance& least = found_.least;
    least.world.clearance.lower = std::min(least.world.clearance.lower, scene_->completeWithin());
    found_.is_self_nearer = least.self.clearance.upper < least.world.clearance.upper;
    if (!found_.is_known && std::isfinite(least.world.clearance.upper))
      least.world.clearance.upper = kInfinity;
    least.all = found_.is_self_nearer ? least.self : least.world;
    least.all.clearance.lower = std::min(least.world.clearance.lower, least.self.clearance.lower);
    return found_;
  }

 private:
  /// A part of the motion from row to row.
  struct Part {
    double t0, t1;
    std::vector<double> from, to;
  };

  planner::PathClearance& of(bool is_self) {
    return is_self ? found_.least.self : found_.least.world;
  }

  /// `only_samples`: looks at the middles of rows, for upper ends that spare work later.
  void pass(double width, bool only_samples) {
    width_ = width;
    placements_ = 0;
    lower_[0] = lower_[1] = kInfinity;
    planner::Obstacles obstacles(problem_, scene_);
    found_.has_obstacles = !obstacles.empty();
    EdgeCertifier still(obstacles.still());
    std::vector<std::unique_ptr<EdgeCertifier>> movers(obstacles.groups());
    for (const planner::ReplanStep& step : steps_) {
      for (const planner::ObstacleSight& sight : step.observed) see(sight, obstacles);
      obstacles.look(step.time);
      if (!step.certified) continue;
      found_.is_known = found_.is_known && obstacles.arePredicted();
      for (std::size_t i = 0; i + 1 < step.motion.size(); ++i) {
        const TimedPoint &a = step.motion[i], &b = step.motion[i + 1];
        const Part row{a.time, b.time, a.position, b.position};
        for (const planner::Pairs pairs : {planner::Pairs::kWorld, planner::Pairs::kSelf})
          if (!only_samples)
            keepLower(pairs == planner::Pairs::kSelf, take(still, row, pairs, 0, 0));
        for (std::size_t g = 0; g < movers.size(); ++g) {
          const auto of_group = obstacles.sceneOf(g);
          if (of_group->scene().pairs().size() == 0) continue;
          if (!movers[g] || !of_group->hasPairsOf(movers[g]->scene()))
            movers[g] = std::make_unique<EdgeCertifier>(of_group);
          if (only_samples)
            sample(obstacles.place(g, (a.time + b.time) / 2, (a.time + b.time) / 2, true),
                   *movers[g], row);
          else
            refine(obstacles, g, *movers[g], row, kMostHalvings);
        }
      }
    }
    if (only_samples) return;
    for (const bool is_self : {false, true}) {
      double& known = of(is_self).clearance.lower;
      // Every pass proves a bound of the same quantity.
      known = passes_ == 0 ? lower_[is_self] : std::max(known, lower_[is_self]);
    }
    ++passes_;
  }

  static void see(const planner::ObstacleSight& sight, planner::Obstacles& obstacles) {
    const planner::Obstacles::Bound bound{sight.speed_bound, sight.turn_bound};
    if (const auto* X_WO = std::get_if<robots::Pose>(&sight.seen))
      obstacles.set(sight.object, *X_WO, sight.time, bound);
    else if (const auto* seen = std::get_if<planner::SeenCloud>(&sight.seen))
      obstacles.set(sight.object, planner::Obstacles::CloudSight{seen->cloud, seen->X_WO},
                    sight.time, bound);
    else
      obstacles.set(sight.object, std::span<const Eigen::Vector3d>(std::get<0>(sight.seen)),
                    sight.time, bound);
  }

  void keepLower(bool is_self, double lower) { lower_[is_self] = std::min(lower_[is_self], lower); }

  /// Measures a part whose obstacles are within `growth` of their places [m], and count as if they
  /// came nearer by `nearer` on average [m]. Returns the lower end.
  double take(EdgeCertifier& certifier, const Part& part, planner::Pairs pairs, double growth,
              double nearer) {
    const bool is_self = pairs == planner::Pairs::kSelf;
    const double known = of(is_self).clearance.upper;
    planner::ClearanceRequest request{
        .tolerance = std::max(width_ / 4, growth / 4), .work_limit = kRowWork, .pairs = pairs};
    if (std::isfinite(known)) request.wanted = known + growth;
    const planner::EdgeClearance edge = certifier.edgeClearance(part.from, part.to, request);
    const double upper = edge.clearance.upper + growth - 2 * nearer;
    if (upper < known && edge.pair >= 0)
      keep(certifier.scene(), is_self, upper, edge.pair, edge.closest, part, edge.t);
    return edge.clearance.lower - growth;
  }

  void keep(const CompiledScene& scene, bool is_self, double upper, int pair,
            const collision::DistanceResult& closest, const Part& part, double t) {
    planner::PathClearance& least = of(is_self);
    ExecutedPlace& place = is_self ? found_.self : found_.world;
    const PairNames names = pairNames(scene, pair);
    least.clearance.upper = upper;
    least.closest_a = names.a;
    least.closest_b = names.b;
    least.closest_point_a = closest.point_a;
    least.closest_point_b = closest.point_b;
    place.time = part.t0 + t * (part.t1 - part.t0);
    place.position.resize(part.from.size());
    scene_->space().interpolate(part.from, part.to, t, place.position);
  }

  /// Measures the middle of a part against a group of obstacles that move, and returns it.
  std::vector<double> sample(const planner::Obstacles::Placement& placed, EdgeCertifier& certifier,
                             const Part& part) {
    std::vector<double> half(part.from.size());
    scene_->space().interpolate(part.from, part.to, 0.5, half);
    certifier.rebind(placed.middle);
    const planner::StateCheck state = certifier.clearance(half, width_ / 4);
    const double upper =
        state.clearance.upper + (found_.is_known ? 1 : -1) * placed.growth_at_middle;
    if (state.pair >= 0 && upper < found_.least.world.clearance.upper)
      keep(certifier.scene(), false, upper, state.pair, state.closest, part, 0.5);
    return half;
  }

  /// Measures a part against a group of obstacles that move, and halves it where that is not
  /// accurate.
  void refine(planner::Obstacles& obstacles, std::size_t group, EdgeCertifier& certifier,
              const Part& part, int halvings) {
    ++placements_;
    const planner::Obstacles::Placement placed = obstacles.place(group, part.t0, part.t1, true);
    certifier.rebind(placed.middle);
    // Obstacles that may be anywhere within bounds count as if they came nearer.
    const double nearer = found_.is_known ? 0 : placed.growth_at_middle;
    const double moves = placed.growth - placed.growth_at_middle;  // besides that
    const double lower = take(certifier, part, planner::Pairs::kWorld, placed.growth, nearer);
    const double known = found_.least.world.clearance.upper;
    const double middle = part.t0 + (part.t1 - part.t0) / 2;
    if (!(lower < known - width_) || moves <= width_ / 4 || halvings == 0 ||
        placements_ > most_placements_ || !(part.t0 < middle && middle < part.t1) ||
        (stop_ && stop_()))
      return keepLower(false, lower);
    const std::vector<double> half = sample(placed, certifier, part);
    refine(obstacles, group, certifier, {part.t0, middle, part.from, half}, halvings - 1);
    refine(obstacles, group, certifier, {middle, part.t1, half, part.to}, halvings - 1);
  }

  const planner::Problem& problem_;
  std::shared_ptr<const CompiledScene> scene_;
  const std::vector<planner::ReplanStep>& steps_;
  const std::function<bool()>& stop_;
  ExecutedClearance found_;
  double width_ = 0;
  double lower_[2] = {kInfinity, kInfinity};  // of the pass, by is_self
  int placements_ = 0, most_placements_ = 0, passes_ = 0;
};

}  // namespace

ExecutedClearance executedClearance(const planner::Problem& problem,
                                    const std::shared_ptr<const CompiledScene>& scene,
                                    const std::vector<planner::ReplanStep>& steps,
                                    const std::function<bool()>& stop) {
  return StepsPasses(problem, scene, steps, stop).refined();
}

std::string nearestText(const ExecutedClearance& executed, bool certified) {
  const planner::PathClearance& least = executed.least.all;
  if (least.closest_a.empty()) return "";
  return fmt::format("Nearest{}: {} and {}, {}, at {:.2f} s.",
                     certified ? "" : " in the steps that are proven", least.closest_a,
                     least.closest_b, clearanceText(least.clearance), executed.all().time);
}

std::string keptText(const ExecutedClearance& executed) {
  const planner::Interval& clearance = executed.least.all.clearance;
  return std::isfinite(clearance.lower)
             ? leastText(executed.least) +
                   (executed.has_obstacles ? " while the obstacles move" : "")
             : "there is nothing else that it could touch";
}

}  // namespace leeway::tools::view
