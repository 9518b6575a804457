// Cost of a frame of a deforming mesh by strategy: the update of the hierarchy alone (vertices are
// ready), 12 tolerance tests and 12 minimum distances of an arm's links; then 100 frames of a mesh
// whose vertices fly apart. For "hybrid moved", a bound on the vertices' motion between frames is
// given.
//   bench_deform [cells a side ...]      default: 32 100 316 (2k, 20k and 200k triangles)

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <span>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "tools/lab/base/statistics.h"

namespace {

using leeway::tools::report::median;
using namespace leeway::collision;
using Eigen::Vector3d;

constexpr int kLinks = 12;
constexpr int kFrames = 100;

double now() {
  const auto time = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::micro>(time).count();
}

struct Cloth {
  std::vector<Vector3d> vertices;
  std::vector<DeformableMesh::Triangle> triangles;
};

// n x n cells on z = 0, side 2 m.
Cloth cloth(int n) {
  Cloth c;
  const auto at = [&](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      c.vertices.push_back({2.0 * i / n - 1, 2.0 * j / n - 1, 0});
      if (i == n || j == n) continue;
      c.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      c.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return c;
}

void wave(std::vector<Vector3d>& vertices, double phase) {
  for (Vector3d& p : vertices) {
    const double x = p.x(), y = p.y();
    p.z() = 0.2 * std::sin(3 * x + phase) * std::cos(2 * y - 0.7 * phase);
    p.x() += 0.05 * std::sin(2 * y + phase);
  }
}

// Bound on how far a vertex moves while wave()'s phase grows by `phase` [m].
double waveReach(double phase) { return std::hypot(0.2 * 1.7 * phase, 0.05 * phase) * (1 + 1e-9); }

constexpr double kStep = 0.02;  // [m]
constexpr double kReach = kStep * 1.7320508076 + 1e-9;

// Moves each vertex at its own constant velocity, up to 2 cm for each frame and axis.
void explode(std::vector<Vector3d>& vertices, int frame) {
  std::uint64_t state = 88172645463325252ULL;
  const auto uniform = [&] {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return static_cast<double>(state >> 11) * 0x1p-52 - 1;
  };
  for (Vector3d& p : vertices) {
    const double x = uniform(), y = uniform(), z = uniform();
    p += kStep * frame * Vector3d(x, y, z);
  }
}

struct Costs {
  std::vector<double> update, tolerance, distance;  // for each frame [us]
  double sum() const {
    double sum = 0;
    for (std::size_t i = 0; i < update.size(); ++i) sum += update[i] + distance[i];
    return sum;
  }
};

// Times frames; the links' answers are collected for each query.
struct Run {
  Deformable deformable;
  Scratch scratch;
  std::array<PairCache, kLinks> near{}, far{};
  Costs costs;

  void frame(const std::vector<Vector3d>& vertices, double time, double moved,
             const std::vector<Pose>& links, bool warm) {
    const std::span<Vector3d> next = deformable.nextVertices();
    std::copy(vertices.begin(), vertices.end(), next.begin());
    const double begin = now();
    if (deformable.commit(time, 1, Deformable::Vertices::kFinite, moved) != UpdateStatus::kUpdated)
      std::abort();
    const double updated = now();
    prepare(scratch, *deformable.snapshot());
    const Shape mesh = Shape::deformable(deformable.snapshot());
    static const Shape link = Shape::capsule(0.05, 0.1);
    DistanceRequest request;
    request.depth = false;
    request.threshold = 0.05;
    const double tested = now();
    for (std::size_t i = 0; i < links.size(); ++i)
      distance(link, links[i], mesh, Pose{}, request, scratch, &near[i]);
    const double tolerated = now();
    request.threshold = std::numeric_limits<double>::quiet_NaN();
    request.tolerance = 1e-6;
    for (std::size_t i = 0; i < links.size(); ++i)
      distance(link, links[i], mesh, Pose{}, request, scratch, &far[i]);
    const double over = now();
    if (!warm) return;
    costs.update.push_back(updated - begin);
    costs.tolerance.push_back(tolerated - tested);
    costs.distance.push_back(over - tolerated);
  }
};

std::vector<Pose> arm() {
  std::vector<Pose> poses;
  for (int i = 0; i < kLinks; ++i) {
    Pose X;
    X.rotation = Eigen::AngleAxisd(0.3 * i, Vector3d(1, 0.3, 0.2).normalized()).toRotationMatrix();
    X.translation = {0.6 * std::cos(0.5 * i), 0.6 * std::sin(0.5 * i), 0.35 + 0.12 * i};
    poses.push_back(X);
  }
  return poses;
}

void bench(int n) {
  const Cloth c = cloth(n);
  const auto mesh = DeformableMesh::make(c.vertices, c.triangles);
  const std::vector<Pose> links = arm();
  for (const bool exploding : {false, true}) {
    std::printf("%zu triangles, %s: us a frame\n", c.triangles.size(),
                exploding ? "exploding" : "waves");
    std::printf("%-15s %10s %12s %12s %14s\n", "strategy", "update", "12 tests", "12 distances",
                "sum of all");
    struct Row {
      DeformStrategy strategy;
      bool moved = false;
    };
    for (const auto [strategy, moved] :
         {Row{DeformStrategy::kRebuild}, Row{DeformStrategy::kRebuildLinear},
          Row{DeformStrategy::kRefit}, Row{DeformStrategy::kHybrid},
          Row{DeformStrategy::kHybrid, true}, Row{DeformStrategy::kLazy},
          Row{DeformStrategy::kRestructure}, Row{DeformStrategy::kOctree},
          Row{DeformStrategy::kAuto}}) {
      // Skipped, because it takes minutes and shows nothing new.
      if (strategy == DeformStrategy::kOctree && n > 100) continue;
      DeformOptions options;
      options.strategy = strategy;
      Run run{Deformable(mesh, nullptr, options), {}, {}, {}, {}};
      const int frames = strategy == DeformStrategy::kOctree && !exploding ? 5 : kFrames;
      int rebuilt = 0;
      for (int frame = 0; frame < frames; ++frame) {
        std::vector<Vector3d> vertices = c.vertices;
        exploding ? explode(vertices, frame) : wave(vertices, 0.05 * frame);
        const double reach = exploding ? kReach : waveReach(0.05);
        run.frame(vertices, frame,
                  moved && frame > 0 ? reach : std::numeric_limits<double>::infinity(), links,
                  exploding || frame > 1);
        rebuilt += run.deformable.statistics().triangles_rebuilt > 0 ? 1 : 0;
      }
      std::printf("%-15s %10.1f %12.2f %12.1f %14.0f  built anew in %d of %d frames\n",
                  moved ? "hybrid moved" : toString(strategy), median(run.costs.update),
                  median(run.costs.tolerance), median(run.costs.distance), run.costs.sum(), rebuilt,
                  frames);
      std::fflush(stdout);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::atoi(argv[i]));
  if (sizes.empty()) sizes = {32, 100, 316};
  for (const int n : sizes) {
    if (n < 1 || n > 2000) {
      std::fprintf(stderr, "usage: bench_deform [cells a side, 1 to 2000 ...]\n");
      return 2;
    }
    bench(n);
  }
}
