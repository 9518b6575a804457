// bench_guard: what a guard's answers cost.
//   bench_guard --robot R.urdf --srdf R.srdf SCENE.yaml...     MoveIt scenes with requests
//   bench_guard PROBLEM.yaml...                                problems of this project
// Each problem is planned; a noisy policy goes to and fro along the path, in chunks of --setpoints
// setpoints that are --period apart, and the robot executes what passes. CPU time of this thread
// for each answer [us]: over all chunks, and over those that pass whole.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/noisy_policy.h"
#include "tools/lab/bench/problem_files.h"
#include "tools/lab/bench/program.h"

namespace {

using namespace leeway::planner;
using leeway::tools::report::quantile;

void printRow(const char* name, const std::vector<double>& times, double edges) {
  const auto at = [&](double share) { return times.empty() ? 0 : quantile(times, share); };
  fmt::print(
      "{:<10} {:>8} chunks  median {:>7.1f}  90 % {:>7.1f}  99 % {:>8.1f}  99.9 % {:>8.1f}  "
      "longest {:>8.1f} us  {:>5.1f} edges\n",
      name, times.size(), at(0.5), at(0.9), at(0.99), at(0.999), at(1),
      edges / std::max(1.0, static_cast<double>(times.size())));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What a guard's answers cost.");
  leeway::bench::ProblemFiles files;
  int chunks = 1000, setpoints = 50;
  bool polynomials = false;
  double period = 0.02, noise = 0.08;
  std::uint64_t seed = 1;
  files.addTo(app)->required();
  app.add_option("--chunks", chunks, "of each problem")->capture_default_str();
  app.add_option("--setpoints", setpoints)->capture_default_str();
  app.add_flag("--polynomials", polynomials,
               "one a joint, in place of setpoints, over as many periods");
  app.add_option("--period", period)->capture_default_str();
  app.add_option("--noise", noise, "of velocities, as a share of their limits")
      ->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  return leeway::bench::runProgram("bench_guard", app, argc, argv, [&] {
    std::vector<double> all, whole;
    double all_edges = 0, whole_edges = 0;
    for (const std::string& file : files.names()) {
      Problem problem = files.load(file);
      problem.limits = {5, 100'000};
      const PlanResult planned = plan(problem);
      if (planned.status != PlanStatus::kSolved) continue;
      GuardOptions options;
      options.period = period;
      options.most_setpoints = std::max(options.most_setpoints, setpoints);
      Guard guard(problem, options);
      leeway::bench::NoisyPolicy policy(guard.options(), planned.path.positions, noise, seed);
      leeway::bench::GuardedRun run(guard, policy, planned.path.positions.front());
      for (int c = 0; c < chunks; ++c) {
        const std::vector<double> chunk = run.next(polynomials ? setpoints / 2 : setpoints);
        const leeway::bench::RestingQuintics curves(run.place(), run.velocity(), chunk, period);
        const GuardRequest request = polynomials
                                         ? GuardRequest{.polynomials = curves.coefficients,
                                                        .duration = curves.duration,
                                                        .time = run.time()}
                                         : GuardRequest{.setpoints = chunk, .time = run.time()};
        if (!problem.world.deforming.empty()) guard.look(run.time());
        const double begin = leeway::bench::cpuNanoseconds();
        const GuardAnswer& answer = guard.check(request);
        const double us = (leeway::bench::cpuNanoseconds() - begin) / 1e3;
        all.push_back(us);
        all_edges += static_cast<double>(answer.edges);
        if (answer.reason == GuardReason::kPassed) {
          whole.push_back(us);
          whole_edges += static_cast<double>(answer.edges);
        }
        run.execute();
      }
    }
    printRow("all", all, all_edges);
    printRow("whole", whole, whole_edges);
    return 0;
  });
}
