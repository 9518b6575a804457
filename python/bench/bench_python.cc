// What python/bench/bench.py compares the Python module with: the same work in C++.
//   bench_python PROBLEM.yaml STATES     STATES: rows of float64, one state each

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"

namespace {

using namespace leeway;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The least time of `rounds` calls [s].
template <typename Call>
void time(const char* name, int rounds, Call&& call) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < rounds; ++i) {
    const double start = seconds();
    call();
    least = std::min(least, seconds() - start);
  }
  std::printf("%s %.9f\n", name, least);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: bench_python PROBLEM.yaml STATES\n", stderr);
    return 2;
  }
  const planner::Problem problem = planner::loadProblem(argv[1]);
  const auto scene = std::make_shared<const planner::CompiledScene>(problem);
  const auto columns = static_cast<std::size_t>(scene->space().size());
  std::ifstream file(argv[2], std::ios::binary | std::ios::ate);
  std::vector<double> states(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(states.data()),
            static_cast<std::streamsize>(states.size() * sizeof(double)));

  planner::EdgeCertifier certifier(scene);
  const auto valid = [&](std::size_t i) {
    const std::span<const double> state(&states[i * columns], columns);
    return scene->space().withinLimits(state) && certifier.decide(state) == planner::Verdict::kFree;
  };
  std::size_t count = 0;
  time("states", 7, [&] {
    count = 0;
    for (std::size_t i = 0; i < states.size() / columns; ++i) count += valid(i) ? 1U : 0U;
  });
  std::printf("valid %zu\n", count);
  time("state", 20000, [&] { count += valid(0) ? 1U : 0U; });
  // The call apart from what the result accounts for: what a binding adds to is small beside that.
  double around = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 500; ++i) {
    const double start = seconds();
    planner::PlanResult result = planner::plan(problem);
    const double inside = result.compile_s + result.plan_s + result.simplify_s + result.improve_s +
                          result.push_s + result.certify_s;
    around = std::min(around, seconds() - start - inside);
  }
  std::printf("around %.9f\n", around);
  return count > 0 ? 0 : 1;
}
