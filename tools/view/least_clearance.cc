#include "tools/view/least_clearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/edge_certifier.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/scene_names.h"

namespace leeway::tools::view {
namespace {

constexpr std::int64_t kWholeWork = 10'000'000'000;  // of the path, in each pass

/// The least clearance of a path for some pairs, refined in passes.
class Least {
 public:
  Least(const std::vector<Stage>& stages, const planner::PathEdges& edges, planner::Pairs pairs,
        const std::function<bool()>& stop)
      : stages_(stages), edges_(edges), pairs_(pairs), stop_(stop) {
    whole_.clearance = {kInfinity, kInfinity};
    if (pairs == planner::Pairs::kSelf) return;
    for (const Stage& stage : stages)
      if (stage.scene) complete_ = std::min(complete_, stage.scene->completeWithin());
  }

  planner::PathClearance refined() {
    for (const double width : kFigureWidths) {
      pass(width);
      if (figureOf(whole_.clearance) || !std::isfinite(whole_.clearance.upper) ||
          whole_.clearance.lower >= complete_)
        break;
    }
    whole_.clearance.lower = std::min(whole_.clearance.lower, complete_);
    return whole_;
  }

 private:
  /// Measures each edge to within `width`, or proves that another edge has less clearance.
  void pass(double width) {
    double lower = kInfinity;
    for (const Stage& stage : stages_) {
      if (!stage.scene || stage.last == stage.first) continue;
      planner::EdgeCertifier certifier(stage.scene);
      for (int i = stage.first; i < stage.last; ++i) {
        const double known = whole_.clearance.upper;
        planner::ClearanceRequest request{
            .tolerance = width, .work_limit = kFigureWork, .pairs = pairs_};
        if (std::isfinite(known)) request.wanted = known;
        planner::EdgeClearance found;
        if ((stop_ && stop_()) || certifier.statistics.work > kWholeWork)
          found.clearance = {-kInfinity, kInfinity};
        else
          found = certifier.edgeClearance(edges_.path.positions[at(i)],
                                          edges_.path.positions[at(i) + 1], request);
        lower = std::min(lower, found.clearance.lower);
        if (found.clearance.upper < known) keep(*stage.scene, found, i);
      }
    }
    // Every pass proves a bound of the same quantity.
    const double before = passes_++ == 0 ? -kInfinity : whole_.clearance.lower;
    whole_.clearance.lower = std::max(before, lower);
  }

  void keep(const planner::CompiledScene& scene, const planner::EdgeClearance& found, int edge) {
    const planner::PathEdges::Place& place = edges_.places[at(edge)];
    const PairNames names = pairNames(scene, found.pair);
    whole_.clearance.upper = found.clearance.upper;
    whole_.closest_a = names.a;
    whole_.closest_b = names.b;
    whole_.closest_segment = place.segment;
    whole_.closest_t = place.along(found.t);
    whole_.closest_point_a = found.closest.point_a;
    whole_.closest_point_b = found.closest.point_b;
  }

  const std::vector<Stage>& stages_;
  const planner::PathEdges& edges_;
  planner::Pairs pairs_;
  const std::function<bool()>& stop_;
  planner::PathClearance whole_;
  double complete_ = kInfinity;  // farther away clouds lack what was cropped [m]
  int passes_ = 0;
};

}  // namespace

LeastClearance leastClearance(const std::vector<Stage>& stages, const planner::PathEdges& edges,
                              const std::function<bool()>& stop) {
  LeastClearance least;
  least.world = Least(stages, edges, planner::Pairs::kWorld, stop).refined();
  least.self = Least(stages, edges, planner::Pairs::kSelf, stop).refined();
  least.all = least.self.clearance.upper < least.world.clearance.upper ? least.self : least.world;
  least.all.clearance.lower = std::min(least.world.clearance.lower, least.self.clearance.lower);
  return least;
}

LeastClearance leastClearance(const planner::Problem& problem, const planner::Path& path,
                              const std::function<bool()>& stop) {
  const auto scene = std::make_shared<const planner::CompiledScene>(firstProblem(problem));
  const planner::PathEdges edges = planner::edgesOf(scene->space(), path);
  return leastClearance(stagesOf(problem, scene, edges.path), edges, stop);
}

void narrow(LeastClearance& least, const planner::PathClearance& all,
            const planner::PathClearance& world, const planner::PathClearance& self) {
  const auto meet = [](planner::PathClearance& of, const planner::PathClearance& known) {
    const double lower = std::max(of.clearance.lower, known.clearance.lower);
    // The place stays where it is as near, to the digits that are shown.
    if (known.clearance.upper < of.clearance.upper - kMomentTolerance) of = known;
    of.clearance.lower = lower;
  };
  meet(least.all, all);
  meet(least.world, world);
  meet(least.self, self);
}

std::string nearestText(const LeastClearance& least) {
  std::string text;
  for (const auto& [what, nearest] :
       {std::pair("the world", &least.world), std::pair("itself", &least.self)}) {
    if (nearest->closest_segment >= 0)
      text += fmt::format("Nearest to {}: {} and {}, {}, edge {} at t = {:.3f}.\n", what,
                          nearest->closest_a, nearest->closest_b, clearanceText(nearest->clearance),
                          nearest->closest_segment, nearest->closest_t);
  }
  return text;
}

std::string lengthText(const planner::PlanResult& result) {
  return fmt::format("{}, length {:.4f}", counted(result.certificate.segments.size(), "edge"),
                     result.length);
}

std::string leastText(const LeastClearance& least) {
  const planner::Interval& clearance = least.all.clearance;
  if (clearance.upper < 0) return "contact, " + clearanceText(clearance);
  return clearance.lower == kInfinity ? "there is nothing else that it could touch"
                                      : "least clearance " + clearanceText(clearance);
}

}  // namespace leeway::tools::view
