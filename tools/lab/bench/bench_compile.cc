// bench_compile: the time from a loaded problem to the first edge.
//   bench_compile --robot R.urdf --srdf R.srdf SCENE.yaml...     MoveIt scenes with requests
//   bench_compile PROBLEM.yaml...                                problems of this project
// Compiles each problem and makes its first EdgeCertifier, once with an unprepared model (cold: a
// copy of it; data that meshes store is warm) and once with a prepared one (prepared: the same
// model as before). CPU time of this thread: medians of --rounds for each problem, then over the
// problems [us]. --boxes N: adds N boxes, out of a small arm's reach, and reports the memory of the
// last problem, its scene and its certifier.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/problem.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/problem_files.h"
#include "tools/lab/bench/program.h"

namespace {

using leeway::tools::report::median;
using namespace leeway::planner;

double microseconds() { return 1e-3 * leeway::bench::cpuNanoseconds(); }

/// Times of several problems or rounds.
struct Times {
  std::vector<double> compile, certifier, second;

  void add(const Problem& problem) {
    const double begin = microseconds();
    const auto scene = std::make_shared<const CompiledScene>(problem);
    const double compiled = microseconds();
    const auto first = std::make_unique<EdgeCertifier>(scene);
    const double made = microseconds();
    const auto another = std::make_unique<EdgeCertifier>(scene);
    const double end = microseconds();
    compile.push_back(compiled - begin);
    certifier.push_back(made - compiled);
    second.push_back(end - made);
  }
  void addMedians(const Times& rounds) {
    compile.push_back(median(rounds.compile));
    certifier.push_back(median(rounds.certifier));
    second.push_back(median(rounds.second));
  }
  void print(const char* name) const {
    fmt::print("{:<10} {:>10.1f} {:>12.1f} {:>12.1f}\n", name, median(compile), median(certifier),
               median(second));
  }
};

/// Adds boxes on a grid of 0.5 m, from 3 m away on.
void addBoxes(Problem& problem, int count) {
  const int side = std::max(1, static_cast<int>(std::ceil(std::sqrt(count / 20.0))));
  for (int k = 0; k < count; ++k) {
    Object box;
    box.name = fmt::format("box {}", k);
    box.geometries.push_back(
        {leeway::collision::Shape::box({0.1, 0.05 + 0.01 * (k % 7), 0.05}), {}, box.name});
    const int row = k / 20 % side, column = k / 20 / side;
    box.X_WO.translation = {3 + 0.5 * row, 3 + 0.5 * column, 0.5 * (k % 20)};
    problem.world.objects.push_back(std::move(box));
  }
}

/// Resident memory of this process [MB]; 0 if the system does not provide it.
double megabytes() {
  double size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return resident * 4096 / 1e6;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("From a loaded problem to the first edge.");
  leeway::bench::ProblemFiles files;
  int rounds = 21, boxes = 0;
  files.addTo(app)->required();
  app.add_option("--rounds", rounds, "a problem");
  app.add_option("--boxes", boxes, "more, in each world");
  return leeway::bench::runProgram("bench_compile", app, argc, argv, [&] {
    Times cold, prepared;
    std::size_t pairs = 0;
    for (const std::string& file : files.names()) {
      Problem problem = files.load(file);
      const double before = megabytes();
      addBoxes(problem, boxes);
      const std::shared_ptr<const leeway::robots::Model> loaded = problem.robot.model;
      {
        const double with_boxes = megabytes();
        const auto scene = std::make_shared<const CompiledScene>(problem);
        const double compiled = megabytes();
        const EdgeCertifier certifier(scene);  // includes covers of the meshes
        const double made = megabytes();
        const EdgeCertifier another(scene);
        if (boxes > 0 && &file == &files.names().back())
          fmt::print("MB: problem {:.1f}, scene {:.1f}, certifier {:.1f}, another {:.1f}\n",
                     with_boxes - before, compiled - with_boxes, made - compiled,
                     megabytes() - made);
      }
      pairs += CompiledScene(problem).scene().pairs().size();
      Times of_cold, of_prepared;
      for (int round = 0; round < rounds; ++round) {
        problem.robot.model = std::make_shared<const leeway::robots::Model>(*loaded);
        of_cold.add(problem);
        problem.robot.model = loaded;
        of_prepared.add(problem);
      }
      cold.addMedians(of_cold);
      prepared.addMedians(of_prepared);
    }
    fmt::print("{} problems, {} pairs each\n", files.names().size(), pairs / files.names().size());
    fmt::print("{:<10} {:>10} {:>12} {:>12}\n", "us", "compile", "certifier", "and another");
    cold.print("cold");
    prepared.print("prepared");
    return 0;
  });
}
