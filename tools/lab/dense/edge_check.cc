// edge_check: certified edges against dense sampling, for a robot among the obstacles of scenes.
//   edge_check --robot R.urdf --srdf R.srdf [--asked] [--count N] [--seed S] [--shard i/N]
//     [--step 0.002] [--every-place] SCENE.yaml...
// Checks random edges, scene by scene in turn, or with --asked those that planning and simplifying
// request (bench_edges replays the same), with one seed after another until there are enough. FCL
// checks certified edges every 0.002 rad: a collision makes them unsafe (none is allowed). Rejected
// edges are checked at the same places for a pair within 0.1 mm: if there is none, the rejection
// was cautious (at most 0.1 % are allowed). The exit status is 1 if either check fails. With
// --every-place, all pairs are also checked at all places of all edges, whereas most are otherwise
// skipped as too far apart to meet: the first collision must be the same. A random edge depends
// only on seed and number; of the requested edges, each shard takes every N-th.

#include <fmt/format.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "tools/lab/bench/asked_edges.h"
#include "tools/lab/bench/problem_files.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/dense/dense_world.h"
#include "tools/truth/oracle/generate.h"

namespace {

using leeway::bench::requestOf;
using leeway::dense::Collision;
using leeway::dense::DenseWorld;
using leeway::oracle::Random;
using leeway::planner::EdgeCertifier;
using leeway::planner::EdgeCheck;
using leeway::planner::Verdict;

/// A rejected edge counts as cautious if its clearance exceeds this everywhere [m].
constexpr double kCautiousClearance = 1e-4;
/// Allowed share of cautious edges.
constexpr double kCautiousShare = 0.001;

/// Planner iterations for one problem and seed.
constexpr unsigned long long kPlannerLooks = 2000;

struct Options {
  std::string robot, srdf, shard = "0/1";
  std::vector<std::string> scenes;
  bool asked = false, every_place = false;
  long long count = 1000;
  std::uint64_t seed = 1;
  double step = 0.002;
};

struct Edge {
  std::vector<double> from, to;
  double length = 0;
};

struct Counts {
  long long edges = 0, free = 0, rejected = 0, undecided = 0, unsafe = 0, cautious = 0, states = 0;
  long long differ = 0;  // with --every-place
  double certify_free_s = 0, certify_rejected_s = 0, sampling_s = 0;
};

/// Half of the edges begin anywhere, half at a valid state, like those of a tree. Lengths 0.1 to 3
/// rad, log-uniform.
Edge randomEdge(Random& random, EdgeCertifier& certifier) {
  const auto& space = certifier.scene().space();
  const std::size_t n = static_cast<std::size_t>(space.size());
  const auto anywhere = [&] {
    std::vector<double> q(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double lower = space.lower(static_cast<int>(i)),
                   upper = space.upper(static_cast<int>(i));
      q[i] = random.uniform(std::max(lower, -3.14159), std::min(upper, 3.14159));
    }
    return q;
  };
  Edge edge;
  edge.from = anywhere();
  if (random.chance(0.5))
    for (int i = 0; i < 100 && certifier.decide(edge.from) != Verdict::kFree; ++i)
      edge.from = anywhere();
  // A uniform direction, then clipped to the limits, as planners extend.
  std::vector<double> d(n);
  double squared;
  do {
    squared = 0;
    for (double& x : d) x = random.uniform(-1, 1), squared += x * x;
  } while (squared > 1 || squared < 0.01);
  const double wanted = random.logUniform(0.1, 3.0) / std::sqrt(squared);
  edge.to = edge.from;
  for (std::size_t i = 0; i < n; ++i) {
    edge.to[i] = std::clamp(edge.from[i] + wanted * d[i], space.lower(static_cast<int>(i)),
                            space.upper(static_cast<int>(i)));
    edge.length += (edge.to[i] - edge.from[i]) * (edge.to[i] - edge.from[i]);
  }
  edge.length = std::sqrt(edge.length);
  return edge;
}

std::vector<double> between(const Edge& edge, double t) {
  std::vector<double> q(edge.from.size());
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = (1 - t) * edge.from[i] + t * edge.to[i];
  return q;
}

int samples(const Edge& edge, double step) {
  return std::max(1, static_cast<int>(std::ceil(edge.length / step)));
}

void tell(const char* what, long long index, const Edge& edge, double t) {
  fmt::print("{}: edge {} at t = {:.17g}\n  from {:.17g}\n  to   {:.17g}\n", what, index, t,
             fmt::join(edge.from, " "), fmt::join(edge.to, " "));
}

/// Slow twin of DenseWorld::firstCollision(): every pair in every place.
std::optional<double> firstOfAll(DenseWorld& world, const std::vector<std::string>& names,
                                 const Edge& edge, int count) {
  for (int i = 0; i <= count; ++i) {
    const double t = static_cast<double>(i) / count;
    if (world.check(names, between(edge, t)).found) return t;
  }
  return std::nullopt;
}

void check(long long index, const Edge& edge, EdgeCertifier& certifier, DenseWorld& world,
           const std::vector<std::string>& names, const Options& options, Counts& counts) {
  const double step = options.step;
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const EdgeCheck verdict = certifier.certify(edge.from, edge.to);
  const auto end = Clock::now();
  const double seconds = std::chrono::duration<double>(end - begin).count();
  ++counts.edges;
  if (verdict.verdict == Verdict::kUndecided) ++counts.undecided;
  if (options.every_place) {
    const int count = samples(edge, step);
    const auto all = firstOfAll(world, names, edge, count);
    if (all != world.firstCollision(names, edge.from, edge.to, count)) {
      ++counts.differ;
      tell("DIFFERS from every place", index, edge, all.value_or(1));
    }
  }
  if (verdict.verdict == Verdict::kFree) {
    ++counts.free;
    counts.certify_free_s += seconds;
    counts.states += samples(edge, step) + 1;
    if (const auto t = world.firstCollision(names, edge.from, edge.to, samples(edge, step))) {
      ++counts.unsafe;
      tell("UNSAFE", index, edge, *t);
    }
  } else {
    ++counts.rejected;
    counts.certify_rejected_s += seconds;
    const auto close = [&](const auto& q) {
      return world.closerThan(names, q, kCautiousClearance);
    };
    // Tries the certifier's own place first, because it nearly always decides.
    bool found = close(between(edge, verdict.t));
    const int count = samples(edge, step);
    for (int i = 0; i <= count && !found; ++i, ++counts.states)
      found = close(between(edge, static_cast<double>(i) / count));
    ++counts.states;
    if (!found) {
      ++counts.cautious;
      tell(verdict.verdict == Verdict::kUndecided ? "cautious (undecided)" : "cautious (not free)",
           index, edge, verdict.t);
    }
  }
  counts.sampling_s += std::chrono::duration<double>(Clock::now() - end).count();
}

/// One scene with its checkers.
struct Place {
  leeway::planner::Problem problem;
  std::shared_ptr<const leeway::planner::CompiledScene> scene;
  std::unique_ptr<EdgeCertifier> certifier;
  std::unique_ptr<DenseWorld> world;
  std::vector<std::string> names;
};

/// `first`: an existing place of the same robot, or null.
Place load(const std::shared_ptr<const leeway::robots::Model>& model, const std::string& scene,
           const Place* first) {
  Place place;
  place.problem = leeway::planner::loadMoveit(model, scene, requestOf(scene));
  place.scene = std::make_shared<leeway::planner::CompiledScene>(place.problem);
  place.certifier = std::make_unique<EdgeCertifier>(place.scene);
  const std::string request = requestOf(scene);
  place.world = first == nullptr ? std::make_unique<DenseWorld>(model, scene, request)
                                 : std::make_unique<DenseWorld>(*first->world, scene, request);
  for (const int v : place.problem.robot.variables)
    place.names.push_back(model->variables[static_cast<std::size_t>(v)].name);
  return place;
}

/// A shard of the first `count` edges that planning and simplifying request.
void checkAsked(const Options& options, int shard, int shards, std::vector<Place>& places,
                Counts& counts) {
  long long index = 0;
  for (std::uint64_t seed = options.seed; index < options.count; ++seed) {
    const long long before = index;
    for (Place& place : places) {
      place.problem.seed = seed;
      const leeway::bench::AskedEdges asked =
          leeway::bench::askedEdges(place.problem, place.scene, kPlannerLooks);
      for (const auto* ends : {&asked.planning, &asked.simplifying})
        for (std::size_t i = 0; i + 1 < ends->size() && index < options.count; i += 2, ++index) {
          if (index % shards != shard) continue;
          Edge edge{(*ends)[i], (*ends)[i + 1], 0};
          for (std::size_t k = 0; k < edge.from.size(); ++k)
            edge.length = std::hypot(edge.length, edge.to[k] - edge.from[k]);
          check(index, edge, *place.certifier, *place.world, place.names, options, counts);
        }
    }
    if (index == before) throw std::runtime_error("no scene's planner asks for any edge");
  }
}

void checkRandom(const Options& options, int shard, int shards, std::vector<Place>& places,
                 Counts& counts) {
  for (long long i = shard; i < options.count; i += shards) {
    Place& place = places[static_cast<std::size_t>(i) % places.size()];
    Random random(Random(options.seed).bits() ^
                  (static_cast<std::uint64_t>(i) * 0xd1342543de82ef95ull));
    check(i, randomEdge(random, *place.certifier), *place.certifier, *place.world, place.names,
          options, counts);
  }
}

int run(const Options& options) {
  int shard = 0, shards = 1;
  if (std::sscanf(options.shard.c_str(), "%d/%d", &shard, &shards) != 2 || shard < 0 ||
      shards <= shard)
    throw std::runtime_error("--shard " + options.shard + ": i/N with 0 <= i < N is expected");
  const auto model = leeway::robots::loadModel(options.robot, options.srdf);
  std::vector<Place> places;
  for (const std::string& scene : options.scenes)
    places.push_back(load(model, scene, places.empty() ? nullptr : &places.front()));
  Counts c;
  if (options.asked)
    checkAsked(options, shard, shards, places, c);
  else
    checkRandom(options, shard, shards, places, c);
  const double share =
      c.edges > 0 ? static_cast<double>(c.cautious) / static_cast<double>(c.edges) : 0;
  const auto mean = [](double seconds, long long n) {
    return n > 0 ? 1e6 * seconds / static_cast<double>(n) : 0;
  };
  fmt::print("{} edges: {} free, {} rejected ({} undecided); {} unsafe, {} cautious ({:.3f} %)\n",
             c.edges, c.free, c.rejected, c.undecided, c.unsafe, c.cautious, 100 * share);
  fmt::print(
      "certify: {:.1f} us a free edge, {:.1f} us a rejected one; sampling: {} states, {:.1f} s\n",
      mean(c.certify_free_s, c.free), mean(c.certify_rejected_s, c.rejected), c.states,
      c.sampling_s);
  if (options.every_place) fmt::print("{} of them differ from every place\n", c.differ);
  return c.unsafe == 0 && c.differ == 0 && share <= kCautiousShare && c.free > 0 && c.rejected > 0
             ? 0
             : 1;
}

}  // namespace

int main(int argc, char** argv) {
  ompl::msg::noOutputHandler();
  CLI::App app("Certified edges against dense sampling.");
  Options options;
  app.add_option("--robot", options.robot, "URDF")->required();
  app.add_option("--srdf", options.srdf, "SRDF")->required();
  app.add_option("scenes", options.scenes, "sceneNNNN.yaml, with requestNNNN.yaml beside them")
      ->required();
  app.add_flag("--asked", options.asked, "edges that planning and simplifying ask for");
  app.add_flag("--every-place", options.every_place, "compare with all pairs in all places");
  app.add_option("--count", options.count, "edges in all shards")->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed, "seed");
  app.add_option("--shard", options.shard, "i/N: every N-th edge from the i-th");
  app.add_option("--step", options.step, "distance between samples [rad]")
      ->check(CLI::PositiveNumber);
  return leeway::bench::runProgram("edge_check", app, argc, argv, [&] { return run(options); });
}
