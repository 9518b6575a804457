// bench_deform: what a frame of a deforming mesh costs, by strategy. Google Benchmark chooses the
// frames and prints the times, which are CPU times of this thread.
//   bench_deform --benchmark_filter='update/wave/20000/.*'
// Names are PART/MOTION/TRIANGLES/STRATEGY. Parts: the update of the hierarchy alone (the vertices
// are ready), 12 tests "farther than 5 cm?" of an arm's links, and their 12 least distances.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/deform/deform_scenes.h"
#include "tools/lab/deform/own_mesh_engine.h"

namespace {

using namespace leeway::tools::report;
using leeway::bench::cpuNanoseconds;

constexpr int kFrames = 100;  ///< to and fro, so that no frame jumps
constexpr std::array<const char*, 3> kParts = {"update", "tests", "distances"};

const DeformScene& sceneOf(const std::string& motion, int triangles) {
  static std::map<std::pair<std::string, int>, DeformScene> scenes;
  const auto [place, is_new] = scenes.try_emplace({motion, triangles});
  if (is_new) place->second = makeDeformScene(motion, triangles, 1);
  return place->second;
}

void timeFrames(benchmark::State& state, const MeshEngine& engine, const std::string& motion,
                int triangles, std::size_t part) {
  const DeformScene& scene = sceneOf(motion, triangles);
  const DeformBodies bodies = makeDeformBodies();
  const std::unique_ptr<MeshFollower> follower = engine.follow(scene.spec);
  for (const auto& capsule : bodies.capsules) follower->addBody(capsule);
  const int links = static_cast<int>(bodies.capsules.size());
  std::vector<Eigen::Vector3d> vertices(scene.spec.rest.size());
  int frame = 0;
  for ([[maybe_unused]] const auto iteration : state) {
    const double time = 1 - std::abs(1 - static_cast<double>(++frame % (2 * kFrames)) / kFrames);
    scene.vertices(time, vertices);
    follower->setVertices(vertices, time);
    std::vector<leeway::collision::Pose> poses;
    for (int i = 0; i < links; ++i) poses.push_back(bodies.linkPose(i, time));
    double begin = cpuNanoseconds();
    follower->update();
    if (part > 0) begin = cpuNanoseconds();
    for (int i = 0; i < links; ++i) {
      const auto& X_WB = poses[static_cast<std::size_t>(i)];
      if (part == 1) benchmark::DoNotOptimize(follower->isFarther(i, X_WB, 0.05));
      if (part == 2) benchmark::DoNotOptimize(follower->distance(i, X_WB));
    }
    state.SetIterationTime(1e-9 * (cpuNanoseconds() - begin));
  }
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const auto engines = makeOwnMeshEngines();
  for (std::size_t part = 0; part < kParts.size(); ++part)
    for (const std::string& motion : deformMotions())
      for (const int triangles : {2000, 20000, 200000})
        for (const auto& engine : engines) {
          const std::string strategy = std::string(engine->name()).substr(7);  // after "leeway "
          // An octree of 200,000 triangles takes minutes, and shows nothing new.
          const bool is_slow = strategy == "octree" && triangles > 20000;
          if (is_slow || !engine->follow(sceneOf(motion, 200).spec)) continue;
          const std::string name = std::string(kParts[part]) + "/" + motion + "/" +
                                   std::to_string(triangles) + "/" + strategy;
          benchmark::RegisterBenchmark(name.c_str(),
                                       [=, &engine](benchmark::State& state) {
                                         timeFrames(state, *engine, motion, triangles, part);
                                       })
              ->UseManualTime()
              ->Unit(benchmark::kMicrosecond);
        }
  benchmark::RunSpecifiedBenchmarks();
}
