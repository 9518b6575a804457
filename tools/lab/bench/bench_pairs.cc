// Times distance queries of convex pairs against Debian's FCL (libccd), in one run on one core.
//
//   bench_pairs [--rounds N] [--seed N] [--family WORD]
//   bench_pairs --among N [--rounds N] [--seed N]
//
// Pairs are made from a seed: sizes of 0.1 to 1 m, any rotation, gaps log-uniform from 1e-7 to 10 m
// unless a family specifies otherwise. Blocks of eight pairs are timed, ours and FCL's alternately.
// The result of a block is its median over the rounds, that of a family its median over the blocks.
// For warm families, our query has the cache of the previous frame. Columns:
//
//   off      answers of FCL farther from our interval than its tolerance explains
//   verdict  pairs that only one of the two calls apart; of `d > t`: contradicts our distance query
//   failed   FCL's exceptions
//   open     our answers wider than requested
//
// The tests with the quadruple-precision oracle decide which answer is correct. `d > t` is compared
// with our own distance query. Depths of a mesh have no comparison, because FCL lacks them.
//
// With --among, checks a box of 0.2 m against a scene of N such boxes, ours by decide() and FCL's
// by its dynamic AABB tree, at 5000 places: sparse to dense, along the axes and turned.

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/default_broadphase_callbacks.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "leeway/collision/scene.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/pair_families.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/bench/splitmix.h"
#include "tools/lab/fcl/fcl_shape.h"

namespace {

using leeway::bench::cpuNanoseconds;
using leeway::bench::Pair;
using leeway::bench::pairFamilies;
using leeway::bench::PairFamily;
using leeway::bench::Query;
using leeway::collision::DistanceRequest;
using leeway::collision::DistanceResult;
using leeway::collision::DistanceStatus;
using leeway::collision::PairCache;
using leeway::collision::Scratch;
using leeway::tools::report::median;

/// Pairs timed together.
constexpr int kBlock = 8;

double theirDistance(const Pair& pair, const fcl::DistanceRequestd& request) {
  fcl::DistanceResultd result;
  try {
    fcl::distance(pair.a.theirs.get(), pair.F_WA, pair.b.theirs.get(), pair.F_WB, request, result);
  } catch (const std::exception&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return result.min_distance;
}

double now() {
  return std::chrono::duration<double, std::nano>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

double clockCost() {
  std::vector<double> costs;
  for (int i = 0; i < 1001; ++i) {
    const double begin = now();
    costs.push_back(now() - begin);
  }
  return median(costs);
}

/// Consumes results, so that timed calls are not optimised away.
volatile double sink = 0;

struct Disagreement {
  int off = 0, verdict = 0, failed = 0;
};

void compare(const DistanceResult& ours, double theirs, bool depth, Disagreement& d) {
  // Ten times FCL's distance tolerance [m].
  constexpr double kOff = 1e-5;
  if (!std::isfinite(theirs)) {
    ++d.failed;
    return;
  }
  const bool apart = ours.distance.lower > 0, they_apart = theirs > 0;
  if (apart != they_apart) {
    d.verdict += std::abs(ours.distance.upper) > kOff ? 1 : 0;
  } else if ((apart || depth) &&
             (theirs < ours.distance.lower - kOff || theirs > ours.distance.upper + kOff)) {
    ++d.off;
  }
}

/// Times one block [ns]: ours, and FCL's query or, for kVerify, our own distance query.
std::pair<double, double> timeBlock(const PairFamily& family, const Pair* pairs,
                                    const fcl::DistanceRequestd& fcl_request, Scratch& scratch,
                                    PairCache& cache, DistanceResult* results,
                                    double* their_results) {
  const bool verify = family.query == Query::kVerify;
  const bool rival = family.pairs.front().a.theirs != nullptr;
  PairCache* const kept = family.query == Query::kWarm ? &cache : nullptr;
  const auto ask = [&](const Pair& pair, const DistanceRequest& request, PairCache* pair_cache) {
    return distance(pair.a.ours, pair.X_WA, pair.b.ours, pair.X_WB, request, scratch, pair_cache);
  };
  double begin = now();
  for (int i = 0; i < kBlock; ++i) {
    DistanceRequest request;
    if (verify) request.threshold = pairs[i].threshold;
    results[i] = ask(pairs[i], request, kept);
  }
  const double our_time = now() - begin;
  begin = now();
  for (int i = 0; i < kBlock; ++i) {
    if (verify) {
      their_results[i] = ask(pairs[i], {}, nullptr).distance.upper;
    } else {
      their_results[i] = rival ? theirDistance(pairs[i], fcl_request) : 0;
    }
  }
  return {our_time, now() - begin};
}

void run(const PairFamily& family, int rounds, double clock_cost) {
  const std::size_t blocks = family.pairs.size() / kBlock;
  std::vector<std::vector<double>> ours(blocks), theirs(blocks);
  Scratch scratch;
  fcl::DistanceRequestd fcl_request;
  fcl_request.gjk_solver_type = fcl::GST_LIBCCD;
  fcl_request.enable_nearest_points = true;
  fcl_request.enable_signed_distance = family.query == Query::kDepth;
  const bool verify = family.query == Query::kVerify;
  const bool rival = family.pairs.front().a.theirs != nullptr;
  Disagreement disagreement;
  int open = 0;
  double result_sum = 0;
  for (int round = -1; round < rounds; ++round) {
    PairCache cache;
    for (std::size_t block = 0; block < blocks; ++block) {
      const Pair* pairs = &family.pairs[block * kBlock];
      DistanceResult results[kBlock];
      double their_results[kBlock];
      if (block > 0 && pairs[0].track != pairs[-1].track) cache = {};
      const auto [our_time, their_time] =
          timeBlock(family, pairs, fcl_request, scratch, cache, results, their_results);
      for (int i = 0; i < kBlock; ++i) result_sum += results[i].distance.upper + their_results[i];
      if (round >= 0) {
        ours[block].push_back((our_time - clock_cost) / kBlock);
        theirs[block].push_back((their_time - clock_cost) / kBlock);
        continue;
      }
      for (int i = 0; i < kBlock; ++i) {
        open += results[i].status == DistanceStatus::kLimit ? 1 : 0;
        if (!rival) continue;
        if (!verify) {
          compare(results[i], their_results[i], family.query == Query::kDepth, disagreement);
        } else if (results[i].distance.lower > pairs[i].threshold
                       ? pairs[i].gap <= pairs[i].threshold
                       : pairs[i].gap > pairs[i].threshold) {
          ++disagreement.verdict;
        }
      }
    }
  }
  sink = result_sum;
  std::vector<double> block_ours, block_theirs;
  for (std::size_t i = 0; i < blocks; ++i) {
    block_ours.push_back(median(ours[i]));
    block_theirs.push_back(median(theirs[i]));
  }
  const double our_median = median(block_ours), their_median = median(block_theirs);
  if (rival) {
    std::printf("%-18s %8.1f %8.1f   %5.3f   %4.2f %s", family.name, our_median, their_median,
                our_median / their_median, family.target,
                our_median <= family.target * their_median ? "ok  " : "MISS");
  } else {
    std::printf("%-18s %8.1f %8s   %5s   %4s     ", family.name, our_median, "-", "-", "-");
  }
  std::printf("   %3zu  %3d  %3d  %3d  %3d\n", family.pairs.size(), disagreement.off,
              disagreement.verdict, disagreement.failed, open);
}

/// Places of boxes of a scene: in a cube of this size [m].
std::vector<leeway::collision::Pose> places(int count, double size, bool turned,
                                            leeway::bench::SplitMix& random) {
  std::vector<leeway::collision::Pose> all(static_cast<std::size_t>(count));
  for (auto& X : all) {
    const auto uniform = [&] { return random.uniform(0, 1); };
    for (int k = 0; k < 3; ++k) X.translation[k] = size * uniform();
    if (!turned) continue;
    Eigen::Vector4d q;
    for (int k = 0; k < 4; ++k) q[k] = uniform() - 0.5;
    X.rotation = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
  }
  return all;
}

void runAmong(int count, double size, bool turned, int rounds, std::uint64_t seed) {
  namespace ours = leeway::collision;
  leeway::bench::SplitMix random(seed);
  const auto bodyOf = [](const std::string& name, const ours::Pose& X_WB, bool moving) {
    ours::Body body;
    body.name = name;
    body.X_WB = X_WB;
    body.moving = moving;
    body.geometries.push_back({ours::Shape::box({0.1, 0.1, 0.1}), {}, ""});
    return body;
  };
  const auto box = std::make_shared<fcl::Boxd>(0.2, 0.2, 0.2);
  ours::SceneBuilder builder;
  builder.add(bodyOf("moving", {}, true));
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  fcl::DynamicAABBTreeCollisionManagerd manager;
  for (const ours::Pose& X : places(count, size, turned, random)) {
    builder.add(bodyOf(std::to_string(objects.size()), X, false));
    objects.push_back(std::make_unique<fcl::CollisionObjectd>(box, leeway::lab::isometry(X)));
    manager.registerObject(objects.back().get());
  }
  manager.setup();
  const ours::Scene scene = builder.build();
  ours::Workspace workspace(scene);
  fcl::CollisionObjectd moving(box);
  const std::vector<ours::Pose> queries = places(5000, size, turned, random);
  std::vector<double> time, their_time;
  int contacts = 0, differ = 0;
  for (int round = 0; round < rounds; ++round) {
    std::vector<bool> meets;
    double start = cpuNanoseconds();
    for (const ours::Pose& X : queries) {
      workspace.setPose(0, X);
      meets.push_back(decide(scene, workspace).verdict != ours::Verdict::kFree);
    }
    time.push_back(cpuNanoseconds() - start);
    std::size_t i = 0;
    contacts = differ = 0;
    start = cpuNanoseconds();
    for (const ours::Pose& X : queries) {
      moving.setTransform(leeway::lab::isometry(X));
      moving.computeAABB();
      fcl::DefaultCollisionData<double> found;
      manager.collide(&moving, &found, fcl::DefaultCollisionFunction<double>);
      contacts += found.result.isCollision() ? 1 : 0;
      differ += meets[i++] != found.result.isCollision() ? 1 : 0;
    }
    their_time.push_back(cpuNanoseconds() - start);
  }
  const double each = 1 / static_cast<double>(queries.size());
  std::printf("%6d %6.1f %-6s %8.0f %8.0f %7.2f %9d %6d\n", count, size, turned ? "yes" : "no",
              median(time) * each, median(their_time) * each, median(time) / median(their_time),
              contacts, differ);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Distance queries of convex pairs, against FCL's.");
  int rounds = 31;
  std::uint64_t seed = 1;
  std::string only;
  int among = 0;
  app.add_option("--rounds", rounds, "of each block; their median counts")
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", seed, "of the pairs");
  app.add_option("--family", only, "only families with this in their name");
  app.add_option("--among", among, "instead, check a box against scenes of this many boxes")
      ->check(CLI::PositiveNumber);
  return leeway::bench::runProgram("bench_pairs", app, argc, argv, [&] {
    if (among > 0) {
      std::printf("median ns a check\n%6s %6s %-6s %8s %8s %7s %9s %6s\n", "boxes", "size",
                  "turned", "ours", "FCL", "ratio", "contacts", "differ");
      for (const double size : {4.0, 8.0, 20.0})
        for (const bool turned : {false, true}) runAmong(among, size, turned, rounds, seed);
      return 0;
    }
    std::printf("median ns a query; FCL with libccd (d > t: our own distance query)\n");
    std::printf("%-18s %8s %8s   %5s   target      pairs  off verdict failed open\n", "family",
                "ours", "FCL", "ratio");
    const double clock_cost = clockCost();
    for (const PairFamily& family : pairFamilies(seed, only)) run(family, rounds, clock_cost);
    return 0;
  });
}
