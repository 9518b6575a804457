// Times certified edges on a planning problem. The edges are those of a search: from states known
// to be free, towards random ones, cut at a range, the tree growing with what is certified. Prints
// microseconds an edge, by outcome, and how many stay undecided.
//
//   bench_edges ROBOT.urdf ROBOT.srdf SCENE.yaml REQUEST.yaml [edges] [range] [seed]

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <limits>
#include <memory>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"

namespace {

using leeway::planner::ConfigurationSpace;
using leeway::planner::Verdict;

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform() {  // splitmix64
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

/// CPU time of this thread: other work on the machine does not count.
double cpuMicroseconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

struct Tally {
  int count = 0;
  double microseconds = 0, worst = 0;
  std::uint64_t queries = 0;
};

void print(const char* name, const Tally& t, int all) {
  if (t.count == 0) return;
  std::printf("  %-10s %6d (%4.1f %%)  mean %8.2f us  worst %9.1f us  queries %.1f\n", name,
              t.count, 100.0 * t.count / all, t.microseconds / t.count, t.worst,
              static_cast<double>(t.queries) / t.count);
}

int run(int argc, char** argv) {
  const auto model = leeway::robots::loadModel(argv[1], argv[2]);
  const leeway::planner::Problem problem = leeway::planner::loadMoveit(model, argv[3], argv[4]);
  const int edges = argc > 5 ? std::atoi(argv[5]) : 2000;
  const double range = argc > 6 ? std::atof(argv[6]) : 1.25;
  Random random(argc > 7 ? static_cast<std::uint64_t>(std::atoll(argv[7])) : 1);

  const auto scene = std::make_shared<const leeway::planner::CompiledScene>(problem);
  leeway::planner::EdgeCertifier certifier(scene);
  const ConfigurationSpace& space = scene->space();
  const auto size = static_cast<std::size_t>(space.size());
  std::vector<double> start;
  for (const int v : problem.variables)
    start.push_back(problem.configuration[static_cast<std::size_t>(v)]);
  std::vector<std::vector<double>> tree{start};
  std::printf("%zu pairs, start %s\n", scene->scene().pairs().size(),
              certifier.decide(start) == Verdict::kFree ? "free" : "NOT FREE");

  Tally tallies[3], all;
  std::vector<double> goal(size), to(size), from;
  bool extending = false;
  for (int i = 0; i < edges; ++i) {
    if (!extending) {
      for (std::size_t k = 0; k < size; ++k) {
        const double low = std::max(space.lower(static_cast<int>(k)), -3.141592653589793);
        const double high = std::min(space.upper(static_cast<int>(k)), 3.141592653589793);
        goal[k] = low + random.uniform() * (high - low);
      }
      from = *std::min_element(tree.begin(), tree.end(), [&](const auto& x, const auto& y) {
        return space.distance(x, goal) < space.distance(y, goal);
      });
    }
    const double length = space.distance(from, goal);
    space.interpolate(from, goal, std::min(1.0, range / length), to);
    const std::uint64_t queries = certifier.statistics.distance_queries;
    const double begin = cpuMicroseconds();
    const leeway::planner::EdgeCheck check = certifier.certify(from, to);
    const double us = cpuMicroseconds() - begin;
    for (Tally* t : {&all, &tallies[static_cast<int>(check.verdict)]}) {
      ++t->count;
      t->microseconds += us;
      t->worst = std::max(t->worst, us);
      t->queries += certifier.statistics.distance_queries - queries;
    }
    extending = check.verdict == Verdict::kFree && length > range;
    if (check.verdict != Verdict::kFree) continue;
    if (tree.size() < 300) tree.push_back(to);
    from = to;
  }
  print("all", all, edges);
  print("free", tallies[0], edges);
  print("not free", tallies[1], edges);
  print("undecided", tallies[2], edges);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr,
                 "usage: bench_edges ROBOT.urdf ROBOT.srdf SCENE.yaml REQUEST.yaml [edges] [range] "
                 "[seed]\n");
    return 2;
  }
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bench_edges: %s\n", e.what());
    return 2;
  }
}
