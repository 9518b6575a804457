// Times pairs of triangle meshes against FCL's hierarchies of OBBs and RSSs in the same run: links
// of 1k triangles against 20k and of 2k against 2k, far, near and touching. Queries: minimum
// distance, tolerance (d > t?) and collision, ours with and without warm start. Meshes are
// generated; mesh files given as arguments form additional pairs, two by two. Pairs of solids with
// convex pieces are last, timed both with the pieces and as plain triangles.
//
// Each pair and class has a few placements. A placement is a track of slightly different poses, so
// that warm starts have a predecessor. Blocks of ours and FCL's over the track alternate. The
// result of a placement is its median block; the table shows the median placement and median ratio.
// FCL has no tolerance query, so its distance query is used instead. `differ` counts FCL's answers
// outside our interval (its own errors are near 1e-7), and verdicts on collision that differ.
//
//   bench_meshes [--placements N] [--seed S] [--pieces] [--deforming] [MESH MESH]...
//
// --pieces omits the generated pairs that have no pieces. --deforming also times each pair as
// deforming meshes at rest, whose nodes have eight boxes along fixed axes, against its triangles.

#include <fcl/fcl.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/model.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/bodies.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/bench/splitmix.h"
#include "tools/lab/fcl/fcl_shape.h"

namespace {

using Eigen::Vector3d;
using leeway::bench::bumpyBall;
using leeway::bench::cloth;
using leeway::bench::cpuNanoseconds;
using leeway::bench::dumbbell;
using leeway::bench::gear;
using leeway::bench::link;
using leeway::bench::Soup;
using leeway::bench::torus;
using leeway::collision::DistanceRequest;
using leeway::collision::DistanceResult;
using leeway::collision::PairCache;
using leeway::collision::Pose;
using leeway::collision::Scratch;
using leeway::collision::Shape;
using leeway::collision::TriangleMesh;
using leeway::lab::isometry;
using leeway::tools::report::median;

constexpr int kTrack = 8;   // poses of a placement
constexpr int kBlocks = 7;  // timed blocks of each kind; odd, so that a median exists

class Random : public leeway::bench::SplitMix {
 public:
  using SplitMix::SplitMix;
  Vector3d vector(double reach) {
    const double x = uniform(-reach, reach), y = uniform(-reach, reach), z = uniform(-reach, reach);
    return {x, y, z};
  }
  Eigen::Matrix3d rotation() {
    for (;;) {
      const Vector3d v = vector(1);
      const double w = uniform(-1, 1);
      const Eigen::Quaterniond q(w, v.x(), v.y(), v.z());
      if (q.norm() > 0.1 && q.norm() < 1) return q.normalized().toRotationMatrix();
    }
  }
};

struct Mesh {
  std::string name;
  Shape shape, triangles_only, at_rest;
  std::shared_ptr<leeway::lab::FclSurface> model;

  Mesh(const std::string& what, const Soup& soup)
      : name(what),
        shape(Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles))),
        triangles_only(
            Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles, {.decompose = false}))),
        at_rest(Shape::deformable(
            leeway::collision::Deformable(
                leeway::collision::DeformableMesh::make(soup.vertices, soup.triangles), nullptr)
                .snapshot())),
        model(leeway::lab::fclMesh(soup.vertices, soup.triangles)) {
    name += " " + std::to_string(soup.triangles.size());
  }
  int pieces() const { return shape.mesh()->pieces().pieces; }
};

Mesh readMesh(const std::string& path) {
  const Shape shape = leeway::robots::loadMesh(path, Vector3d::Ones(), "bench_meshes", 1);
  const TriangleMesh& mesh = *shape.mesh();
  const std::size_t slash = path.find_last_of('/');
  return {slash == std::string::npos ? path : path.substr(slash + 1),
          {{mesh.vertices().begin(), mesh.vertices().end()},
           {mesh.triangles().begin(), mesh.triangles().end()}}};
}

enum class Class { kFar, kNear, kTouching };
enum class Query { kDistance, kTolerance, kCollision };
constexpr const char* kClassNames[] = {"far", "near", "touching"};
constexpr const char* kQueryNames[] = {"distance", "tolerance", "collision"};

struct Track {
  Pose X_WB[kTrack];
  double truth[kTrack];  // our distance, for thresholds
};

Pose place(const Mesh& a, const Mesh& b, Class kind, Random& random, Scratch& scratch) {
  const double size = std::min(a.shape.boundingRadius(), b.shape.boundingRadius());
  DistanceRequest request;
  request.depth = false;
  for (;;) {
    Pose X;
    X.rotation = random.rotation();
    const Vector3d direction = random.rotation().col(0);
    X.translation = a.shape.boundingCenter() - X.rotation * b.shape.boundingCenter() +
                    1.2 * (a.shape.boundingRadius() + b.shape.boundingRadius()) * direction;
    // Approaches along the witnesses a few times, which also reaches into concavities.
    const double gap = kind == Class::kFar    ? size * random.uniform(1, 4)
                       : kind == Class::kNear ? size * random.uniform(0.005, 0.05)
                                              : -size * random.uniform(0.001, 0.01);
    DistanceResult r = distance(a.shape, {}, b.shape, X, request, scratch);
    X.translation += (std::max(gap, 0.01 * size) - r.distance.upper) * r.normal +
                     size * 0.5 * r.normal.cross(random.rotation().col(0));
    for (int i = 0; i < 3; ++i) {
      r = distance(a.shape, {}, b.shape, X, request, scratch);
      if (!(r.distance.lower > 0)) break;
      X.translation += (gap - r.distance.upper) * r.normal;
    }
    const DistanceResult end = distance(a.shape, {}, b.shape, X, request, scratch);
    const bool apart = end.distance.lower > 0;
    if (apart == (kind == Class::kTouching)) continue;
    if (apart && std::abs(end.distance.upper - gap) > 0.2 * gap) continue;
    return X;
  }
}

struct Timing {
  double cold = 0, warm = 0, triangles = 0, deforming = 0, fcl = 0;
  int differ = 0;
};

class Bench {
 public:
  Bench(const Mesh& a, const Mesh& b, bool deforming) : a_(a), b_(b), deforming_(deforming) {}

  Timing run(Class kind, Query query, Random& random) {
    const double size = std::min(a_.shape.boundingRadius(), b_.shape.boundingRadius());
    const Pose start = place(a_, b_, kind, random, scratch_);
    Track track;
    const Vector3d turn = random.rotation().col(0), shift = random.rotation().col(0);
    for (int i = 0; i < kTrack; ++i) {
      // Back and forth: the track closes without a jump.
      const double s = 1e-3 * (i < kTrack / 2 ? i : kTrack - i);
      track.X_WB[i].rotation = Eigen::AngleAxisd(s, turn) * start.rotation;
      track.X_WB[i].translation = start.translation + s * size * shift;
      DistanceRequest exact;
      exact.depth = false;
      track.truth[i] =
          distance(a_.shape, {}, b_.shape, track.X_WB[i], exact, scratch_).distance.upper;
    }
    Timing timing;
    const int repeats = repeatsFor(track, query);
    std::vector<double> cold, warm, triangles, deforming, fcl;
    for (int block = 0; block < kBlocks; ++block) {
      cold.push_back(timed(repeats, [&](int i) { ours(track, i, query, nullptr); }));
      if (a_.pieces() > 0 && b_.pieces() > 0) {
        triangles.push_back(timed(
            repeats, [&](int i) { of(a_.triangles_only, b_.triangles_only, track, i, query); }));
      }
      if (deforming_)
        deforming.push_back(
            timed(repeats, [&](int i) { of(a_.at_rest, b_.at_rest, track, i, query); }));
      fcl.push_back(timed(repeats, [&](int i) { theirs(track, i, query); }));
      warm.push_back(timed(repeats, [&](int i) { ours(track, i, query, &cache_); }));
    }
    timing.cold = median(cold);
    timing.warm = median(warm);
    timing.fcl = median(fcl);
    timing.triangles = triangles.empty() ? timing.cold : median(triangles);
    timing.deforming = deforming.empty() ? 0 : median(deforming);
    for (int i = 0; i < kTrack; ++i) timing.differ += agrees(track, i, query) ? 0 : 1;
    return timing;
  }

 private:
  template <typename Function>
  static double timed(int repeats, const Function& function) {
    const double begin = cpuNanoseconds();
    for (int k = 0; k < repeats; ++k) {
      for (int i = 0; i < kTrack; ++i) function(i);
    }
    return (cpuNanoseconds() - begin) / (repeats * kTrack);
  }

  // Blocks of about 0.2 ms hide the clock's resolution.
  int repeatsFor(const Track& track, Query query) {
    const double once = timed(1, [&](int i) { theirs(track, i, query); });
    return std::clamp(static_cast<int>(2e5 / (once * kTrack)), 1, 100);
  }

  static DistanceRequest request(const Track& track, int i, Query query) {
    DistanceRequest r;
    r.depth = false;
    if (query == Query::kCollision) r.threshold = 0;
    if (query == Query::kTolerance)
      r.threshold = std::max(track.truth[i], 0.01) * (i % 2 == 0 ? 0.8 : 1.25);
    if (query != Query::kDistance) r.tolerance = 0;
    return r;
  }

  DistanceResult ours(const Track& track, int i, Query query, PairCache* cache) {
    const DistanceResult r =
        distance(a_.shape, {}, b_.shape, track.X_WB[i], request(track, i, query), scratch_, cache);
    sink_ = sink_ + r.distance.lower;
    return r;
  }

  void of(const Shape& a, const Shape& b, const Track& track, int i, Query query) {
    const DistanceResult r = distance(a, {}, b, track.X_WB[i], request(track, i, query), scratch_);
    sink_ = sink_ + r.distance.lower;
  }

  double theirs(const Track& track, int i, Query query) {
    const fcl::CollisionGeometryd *a = a_.model.get(), *b = b_.model.get();
    const Eigen::Isometry3d X_WA = Eigen::Isometry3d::Identity(), X_WB = isometry(track.X_WB[i]);
    if (query == Query::kCollision) {
      const fcl::CollisionRequestd collision(1, false);
      fcl::CollisionResultd result;
      const double hits = static_cast<double>(fcl::collide(a, X_WA, b, X_WB, collision, result));
      sink_ = sink_ + hits;
      return hits;
    }
    const fcl::DistanceRequestd distance(false, false);
    fcl::DistanceResultd result;
    fcl::distance(a, X_WA, b, X_WB, distance, result);
    sink_ = sink_ + result.min_distance;
    return result.min_distance;
  }

  bool agrees(const Track& track, int i, Query query) {
    const DistanceRequest r = request(track, i, query);
    const double fcl = theirs(track, i, query);
    for (PairCache* cache : {static_cast<PairCache*>(nullptr), &cache_}) {
      const DistanceResult d = ours(track, i, query, cache);
      // FCL's collision query ignores the inside, but no placement here is completely inside.
      const double eps = 1e-6;
      bool agreed = true;
      if (query == Query::kCollision) {
        agreed = d.distance.lower > 0 ? fcl < 0.5 : d.distance.upper <= 0 && fcl > 0.5;
      } else if (query == Query::kDistance) {
        agreed = d.distance.lower > 0 ? fcl > d.distance.lower - eps && fcl < d.distance.upper + eps
                                      : fcl <= 0;
      } else {
        agreed = d.distance.lower > r.threshold
                     ? fcl > r.threshold - eps
                     : d.distance.upper <= r.threshold && fcl <= r.threshold + eps;
      }
      if (!agreed) return false;
    }
    return true;
  }

  const Mesh& a_;
  const Mesh& b_;
  const bool deforming_;
  Scratch scratch_;
  PairCache cache_;
  volatile double sink_ = 0;
};

struct Options {
  int placements = 12;
  std::uint64_t seed = 1;
  bool only_pieces = false, deforming = false;
  std::vector<std::string> files;  // used two by two
};

std::vector<std::pair<Mesh, Mesh>> pairsOf(const Options& options) {
  std::vector<std::pair<Mesh, Mesh>> pairs;
  if (!options.only_pieces) {
    pairs.emplace_back(Mesh("link", link(24, 21)), Mesh("link", link(100, 100)));
    pairs.emplace_back(Mesh("link", link(24, 21)), Mesh("bumpy ball", bumpyBall(100, 100)));
    pairs.emplace_back(Mesh("link", link(24, 21)), Mesh("torus", torus(100, 100)));
    pairs.emplace_back(Mesh("link", link(24, 21)), Mesh("cloth", cloth(100, 100)));
    pairs.emplace_back(Mesh("link", link(32, 32)), Mesh("link", link(32, 32)));
    pairs.emplace_back(Mesh("torus", torus(32, 32)), Mesh("bumpy ball", bumpyBall(32, 32)));
  }
  pairs.emplace_back(Mesh("dumbbell", dumbbell(24, 21)), Mesh("dumbbell", dumbbell(100, 100)));
  pairs.emplace_back(Mesh("dumbbell", dumbbell(32, 32)), Mesh("dumbbell", dumbbell(32, 32)));
  pairs.emplace_back(Mesh("dumbbell", dumbbell(24, 21)), Mesh("gear", gear(100, 100)));
  pairs.emplace_back(Mesh("gear", gear(25, 40)), Mesh("gear", gear(25, 40)));
  for (std::size_t i = 0; i < options.files.size(); i += 2) {
    pairs.emplace_back(readMesh(options.files[i]), readMesh(options.files[i + 1]));
  }
  return pairs;
}

void printPieces(const Mesh& mesh) {
  if (mesh.pieces() == 0) return;
  const leeway::collision::PieceSummary& summary = mesh.shape.mesh()->pieces();
  std::printf("%s: %d convex pieces, %d loose triangles, excess %.1e m\n", mesh.name.c_str(),
              summary.pieces, summary.loose_triangles, summary.excess);
}

// By class and query.
using Ratios = std::vector<double>[3][3];

// The ratios of all placements: those of pairs of triangles, those of pairs with convex pieces, and
// those of deforming meshes.
struct Summary {
  Ratios over_triangles, over_pieces, against_triangles, deforming;
};

void addTo(std::vector<double>& all, const std::vector<double>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

// Prints one row of the table, and adds its ratios to the summary.
void measure(Bench& bench, const Mesh& a, const Mesh& b, Class kind, Query query,
             const Options& options, Summary& summary) {
  Random random(options.seed);
  std::vector<double> cold, warm, triangles, fcl, cold_ratio, warm_ratio, triangle_ratio,
      deforming_ratio;
  int differ = 0;
  for (int i = 0; i < options.placements; ++i) {
    const Timing t = bench.run(kind, query, random);
    cold.push_back(t.cold);
    warm.push_back(t.warm);
    triangles.push_back(t.triangles);
    fcl.push_back(t.fcl);
    cold_ratio.push_back(t.cold / t.fcl);
    warm_ratio.push_back(t.warm / t.fcl);
    triangle_ratio.push_back(t.cold / t.triangles);
    if (options.deforming) deforming_ratio.push_back(t.deforming / t.triangles);
    differ += t.differ;
  }
  const int k = static_cast<int>(kind), q = static_cast<int>(query);
  const bool pieces = a.pieces() > 0 && b.pieces() > 0;
  addTo((pieces ? summary.over_pieces : summary.over_triangles)[k][q], cold_ratio);
  if (pieces) addTo(summary.against_triangles[k][q], triangle_ratio);
  addTo(summary.deforming[k][q], deforming_ratio);
  std::printf("%-38s %-9s %-10s %10.0f %10.0f %10.0f %10.0f %7.3f %7.3f %7.3f %7d\n",
              (a.name + " - " + b.name).c_str(), kClassNames[k], kQueryNames[q], median(cold),
              median(warm), median(triangles), median(fcl), median(cold_ratio), median(warm_ratio),
              median(triangle_ratio), differ);
  std::fflush(stdout);
}

void printRatios(const char* title, const Ratios& ratios) {
  if (ratios[0][0].empty()) return;
  std::printf("\nmedian ratio to %s, cold:\n", title);
  for (int k = 0; k < 3; ++k) {
    std::printf("  %-9s", kClassNames[k]);
    for (int q = 0; q < 3; ++q) std::printf("  %s %.3f", kQueryNames[q], median(ratios[k][q]));
    std::printf("\n");
  }
}

int run(const Options& options) {
  const std::vector<std::pair<Mesh, Mesh>> pairs = pairsOf(options);
  for (const auto& [a, b] : pairs) {
    printPieces(a);
    printPieces(b);
  }
  std::printf("%-38s %-9s %-10s %10s %10s %10s %10s %7s %7s %7s %7s\n", "pair (triangles)", "class",
              "query", "cold ns", "warm ns", "soup ns", "FCL ns", "cold/F", "warm/F", "cold/s",
              "differ");
  Summary summary;
  for (const auto& [a, b] : pairs) {
    Bench bench(a, b, options.deforming);
    for (const Class kind : {Class::kFar, Class::kNear, Class::kTouching}) {
      for (const Query query : {Query::kDistance, Query::kTolerance, Query::kCollision})
        measure(bench, a, b, kind, query, options, summary);
    }
  }
  printRatios("FCL over pairs of triangles", summary.over_triangles);
  printRatios("FCL over pairs with convex pieces", summary.over_pieces);
  printRatios("triangles over pairs with convex pieces", summary.against_triangles);
  printRatios("triangles over pairs of deforming meshes at rest", summary.deforming);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Pairs of triangle meshes, against FCL's.");
  Options options;
  app.add_option("--placements", options.placements, "of each pair and class")
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed, "of the placements");
  app.add_flag("--pieces", options.only_pieces, "only pairs with convex pieces");
  app.add_flag("--deforming", options.deforming, "also as deforming meshes at rest");
  app.add_option("meshes", options.files, "files, two by two");
  return leeway::bench::runProgram("bench_meshes", app, argc, argv, [&] {
    if (options.files.size() % 2 != 0)
      throw std::runtime_error("an even number of meshes is expected");
    return run(options);
  });
}
