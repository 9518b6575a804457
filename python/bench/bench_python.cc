// What python/bench/bench.py compares the Python module with: the same work in C++.
//   bench_python PROBLEM.yaml STATES     STATES: rows of float64, one state each

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/plan.h"

namespace {

using namespace leeway;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The least and the median time of `rounds` calls [s].
template <typename Call>
void time(const char* name, int rounds, Call&& call) {
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const double start = seconds();
    call();
    times.push_back(seconds() - start);
  }
  std::sort(times.begin(), times.end());
  std::printf("%s %.9f %.9f\n", name, times.front(), times[times.size() / 2]);
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
    for (std::size_t i = 0; i < states.size() / columns; ++i) count += valid(i) ? 1 : 0;
  });
  std::printf("valid %zu\n", count);
  time("state", 20000, [&] { count += valid(0) ? 1 : 0; });
  time("plan", 300, [&] { planner::plan(problem); });
  return count > 0 ? 0 : 1;
}
