#include "tools/lab/clearance/clearance_report.h"

#include <fmt/format.h>
#include <ompl/base/objectives/MaximizeMinClearanceObjective.h>
#include <ompl/base/objectives/StateCostIntegralObjective.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/prm/PRMstar.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "collision/base/numbers.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/simplify.h"
#include "planner/base/clock.h"
#include "planner/space/ompl_lock.h"
#include "planner/space/ompl_planners.h"
#include "tools/lab/planning/rival_space.h"

namespace leeway::tools::report {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using planner::Clock;
using planner::secondsSince;

std::shared_ptr<const planner::CompiledScene> worldAlone(const planner::CompiledScene& scene) {
  return scene.withPairs([&](const collision::ScenePair& pair) { return !scene.isOfRobot(pair); });
}

double hingeAt(double hinge, double clearance) {
  return std::clamp(1 - clearance / hinge, 0.0, 1.0);
}

/// Least clearance and integral of a path at samples, evenly along each edge.
struct Dense {
  double least = kInfinity, integral = 0;
};
Dense denseOf(const planner::CompiledScene& world, const Rows& path, double hinge, int samples) {
  planner::EdgeCertifier certifier(std::make_shared<const planner::CompiledScene>(world));
  const planner::ConfigurationSpace& space = world.space();
  const double length = planner::pathLength(space, path);
  Dense dense;
  std::vector<double> q(path[0].size());
  const auto clearanceAt = [&](std::size_t i, double t) {
    constexpr double kTolerance = 1e-6;
    space.interpolate(path[i - 1], path[i], t, q);
    const double clearance = certifier.clearance(q, kTolerance).clearance.upper;
    dense.least = std::min(dense.least, clearance);
    return clearance;
  };
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double edge = space.distance(path[i - 1], path[i]);
    const int count =
        std::max(2, length > 0 ? static_cast<int>(std::ceil(samples * edge / length)) : 2);
    clearanceAt(i, 0);
    for (int k = 0; k < count; ++k)
      dense.integral += edge / count * hingeAt(hinge, clearanceAt(i, (k + 0.5) / count));
    clearanceAt(i, 1);
  }
  return dense;
}

/// The hinge of a state's clearance, as OMPL integrates it: over states in steps, with trapezoids.
class HingeIntegral : public ob::StateCostIntegralObjective {
 public:
  HingeIntegral(const ob::SpaceInformationPtr& information, double hinge)
      : StateCostIntegralObjective(information, true), hinge_(hinge) {}
  ob::Cost stateCost(const ob::State* state) const override {
    return ob::Cost(hingeAt(hinge_, si_->getStateValidityChecker()->clearance(state)));
  }

 private:
  double hinge_;
};

constexpr const char *kBitStar = "BIT*", *kPrmStar = "PRM*", *kRrtStar = "RRT*";

std::shared_ptr<ob::Planner> plannerOf(const std::string& name,
                                       const ob::SpaceInformationPtr& information) {
  if (name == kBitStar) return std::make_shared<og::BITstar>(information);
  if (name == kPrmStar) return std::make_shared<og::PRMstar>(information);
  return std::make_shared<og::RRTstar>(information);
}

class Measurement {
 public:
  Measurement(const PlanningProblem& named, const ClearanceReportOptions& options)
      : named_(named),
        options_(options),
        scene_(std::make_shared<const planner::CompiledScene>(named.problem)),
        world_(worldAlone(*scene_)) {}

  ClearanceRow ours(bool integral, std::uint64_t seed, double time) {
    ClearanceRow row = rowOf("Leeway", integral, seed, time);
    planner::Problem problem = named_.problem;
    problem.seed = seed;
    problem.limits.time = time;
    // Removes the wishes in the file, because the report sets its own objective.
    problem.margins.wishes.clear();
    if (integral)
      problem.objective =
          planner::MinimumCost{0, {{{planner::Nearness::Kind::kHinge, options_.hinge}, 1}}};
    else
      problem.objective = planner::MaximumClearance{};
    const auto begin = Clock::now();
    const planner::PlanResult result = planner::plan(problem);
    row.took = secondsSince(begin);
    row.status = planner::toString(result.status);
    take(result.path.positions, row);
    if (!row.solved()) return row;
    last_ = result.path.positions.back();
    // The samples give the least clearance and the integral to about their spacing.
    constexpr double kSampling = 2e-3;
    const double slack = kSampling * row.length;
    row.unsound = row.least < result.certificate.world.clearance.lower - 1e-6 || row.colliding ||
                  (integral && (row.integral < result.cost.lower - slack ||
                                row.integral > result.cost.upper + slack));
    return row;
  }

  ClearanceRow theirs(const StateEngine& engine, const char* name, bool integral,
                      std::uint64_t seed, double time) {
    ClearanceRow row =
        rowOf(fmt::format("{}, {} at {:g} %", name, engine.name(), 100 * options_.resolution),
              integral, seed, time);
    row.status = "left out";
    Rows goals = pointsOf(named_.problem);
    if (goals.empty() && !last_.empty()) goals.push_back(last_);
    if (goals.empty()) return row;
    planner::Problem problem = named_.problem;
    problem.margins = {};
    const auto begin = Clock::now();
    const auto scene = std::make_shared<const planner::CompiledScene>(problem);
    const auto world = worldAlone(*scene);
    const auto checker = engine.prepare(scene->scene()), distances = engine.prepare(world->scene());
    if (!checker || !distances) return row;
    const planner::QuietOmpl quiet;
    const RivalSpace space(scene, *checker, distances.get(), options_.resolution, seed);
    const ob::ProblemDefinitionPtr definition = space.definition(startPoint(problem), goals);
    const ob::SpaceInformationPtr& information = space.information();
    const auto& validity = *information->getStateValidityChecker();
    if (std::isnan(validity.clearance(definition->getStartState(0)))) return row;
    if (integral)
      definition->setOptimizationObjective(
          std::make_shared<HingeIntegral>(information, options_.hinge));
    else
      definition->setOptimizationObjective(
          std::make_shared<ob::MaximizeMinClearanceObjective>(information));
    std::shared_ptr<ob::Planner> planner;
    {
      const std::lock_guard<std::recursive_mutex> lock(planner::omplSeedLock());
      planner::seedOmpl(seed);
      planner = plannerOf(name, information);
    }
    planner->setProblemDefinition(definition);
    planner->setup();
    planner->solve(ob::timedPlannerTerminationCondition(std::max(0.0, time - secondsSince(begin))));
    row.took = secondsSince(begin);
    row.status = definition->hasExactSolution() ? "solved" : "unsolved";
    if (row.solved())
      take(
          space.rowsOf(*std::static_pointer_cast<og::PathGeometric>(definition->getSolutionPath())),
          row);
    return row;
  }

 private:
  ClearanceRow rowOf(std::string planner, bool integral, std::uint64_t seed, double time) const {
    ClearanceRow row{named_.name, named_.set, std::move(planner), integral ? "integral" : "least",
                     seed,        time};
    return row;
  }

  void take(const Rows& path, ClearanceRow& row) {
    if (!row.solved() || path.size() < 2) return;
    const Dense dense = denseOf(*world_, path, options_.hinge, options_.samples);
    row.least = dense.least;
    row.integral = dense.integral;
    row.length = planner::pathLength(scene_->space(), path);
    planner::Problem without = named_.problem;
    without.margins = {};
    planner::EdgeCertifier certifier(std::make_shared<const planner::CompiledScene>(without));
    row.colliding = collides(certifier, path);
  }

  const PlanningProblem& named_;
  const ClearanceReportOptions& options_;
  std::shared_ptr<const planner::CompiledScene> scene_, world_;
  std::vector<double> last_;  ///< the goal of our last path
};

}  // namespace

std::vector<ClearanceRow> measureClearance(const std::vector<PlanningProblem>& problems,
                                           const std::vector<const StateEngine*>& rivals,
                                           const ClearanceReportOptions& options) {
  std::vector<ClearanceRow> rows;
  for (const PlanningProblem& named : problems) {
    Measurement measurement(named, options);
    for (int k = 0; k < options.seeds; ++k) {
      const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(k);
      for (const bool integral : {false, true})
        for (const double time : options.times) {
          if (options.progress)
            options.progress(fmt::format("{}, seed {}, {} in {:g} s", named.name, seed,
                                         integral ? "integral" : "least", time));
          std::vector<ClearanceRow> added{measurement.ours(integral, seed, time)};
          for (const StateEngine* engine : rivals)
            for (const char* name : {kBitStar, kPrmStar, kRrtStar})
              added.push_back(measurement.theirs(*engine, name, integral, seed, time));
          if (options.on_rows) options.on_rows(added);
          rows.insert(rows.end(), added.begin(), added.end());
        }
    }
  }
  return rows;
}

}  // namespace leeway::tools::report
