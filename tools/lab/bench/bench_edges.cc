// bench_edges: certified edges against stepping, on the edges that planning and simplifying
// request.
//   bench_edges PROBLEM.yaml...                                     problems of this project
//   bench_edges --robot R.urdf --srdf R.srdf SCENE.yaml...          MoveIt scenes with requests
//   bench_edges --bodies                                            a body among bodies
// --bodies: a free body of 2k triangles among twelve of 2k triangles, closed ones and sheets.
// Edges: a seeded RRTConnect plans each problem and simplify() shortens its path; the edges that
// both request are replayed. Results cover either source and the mix as requested.
// Stepping checks states at most 1/32 (rad or m, in the space's distance) apart, and nothing
// between them. Sixteen states share the certifier's lanes, with its balls and bounds; distance()
// with warm caches settles the other states.
// Times: CPU time of this thread. Both checkers process all edges once, in the order requested.
// Then each kind of edge is timed as a whole, the checkers alternately, five times: medians [us for
// each edge]. Only ratios are comparable between machines. Per-edge figures (median, 99 %, 99.9 %,
// maximum, share above 100 us) are computed from the median of three runs of each edge.

#include <fmt/format.h>
#include <ompl/util/Console.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "leeway/planner/edge_certifier.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/bench/asked_edges.h"
#include "tools/lab/bench/bodies.h"
#include "tools/lab/bench/cpu_time.h"
#include "tools/lab/bench/edge_stepper.h"
#include "tools/lab/bench/problem_files.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/bench/splitmix.h"

namespace {

using leeway::tools::report::median;
using leeway::tools::report::quantile;
using namespace leeway::planner;

constexpr double kStep = 1.0 / 32;

/// Target: no edge takes longer [us].
constexpr double kSlowMicroseconds = 100;

double cpuMicroseconds() { return 1e-3 * leeway::bench::cpuNanoseconds(); }

/// One kind of edge, summed over problems.
struct Kind {
  std::string name;
  long long edges = 0;
  double certify_us = 0, step_us = 0;
  std::vector<double> each_us{};  // certified, one by one
  long long exact = 0;            // queries
};

constexpr int kRounds = 5;

void measure(const std::shared_ptr<const CompiledScene>& scene,
             const std::vector<std::vector<double>>& ends, std::vector<Kind>& kinds) {
  if (ends.empty()) return;
  EdgeCertifier certifier(scene);
  leeway::bench::Stepper stepper(scene, kStep);
  // free by balls alone, free with exact queries, not free, undecided
  std::vector<std::vector<std::size_t>> edges(4);
  std::vector<long long> queries(4, 0);
  for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
    const auto before = certifier.statistics.distance_queries;
    const Verdict verdict = certifier.certify(ends[i], ends[i + 1]).verdict;
    stepper.isFree(ends[i], ends[i + 1]);  // fills the caches for this edge
    const auto asked = static_cast<long long>(certifier.statistics.distance_queries - before);
    const std::size_t k = verdict == Verdict::kFree      ? (asked == 0 ? 0 : 1)
                          : verdict == Verdict::kNotFree ? 2
                                                         : 3;
    edges[k].push_back(i);
    queries[k] += asked;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    if (edges[k].empty()) continue;
    std::vector<double> certify_us, step_us;
    for (int round = 0; round < kRounds; ++round) {
      const double begin = cpuMicroseconds();
      for (const std::size_t i : edges[k]) certifier.certify(ends[i], ends[i + 1]);
      const double middle = cpuMicroseconds();
      for (const std::size_t i : edges[k]) stepper.isFree(ends[i], ends[i + 1]);
      certify_us.push_back(middle - begin);
      step_us.push_back(cpuMicroseconds() - middle);
    }
    kinds[k].edges += static_cast<long long>(edges[k].size());
    kinds[k].certify_us += median(certify_us);
    kinds[k].step_us += median(step_us);
    kinds[k].exact += queries[k];
    for (const std::size_t i : edges[k]) {
      std::vector<double> us;
      for (int round = 0; round < 3; ++round) {
        const double begin = cpuMicroseconds();
        certifier.certify(ends[i], ends[i + 1]);
        us.push_back(cpuMicroseconds() - begin);
      }
      kinds[k].each_us.push_back(median(us));
    }
  }
}

std::vector<Kind> kinds() {
  return {{"free, balls alone"}, {"free, exact"}, {"not free"}, {"undecided"}};
}

void add(Kind& sum, const Kind& k) {
  sum.edges += k.edges, sum.certify_us += k.certify_us, sum.step_us += k.step_us,
      sum.exact += k.exact;
  sum.each_us.insert(sum.each_us.end(), k.each_us.begin(), k.each_us.end());
}

void print(const std::string& title, std::vector<Kind> rows) {
  Kind free{"free"}, all{"all"};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (k < 2) add(free, rows[k]);
    add(all, rows[k]);
  }
  rows.insert(rows.begin() + 2, free);
  rows.push_back(all);
  fmt::print("{:<41} {:>7} {:>10} {:>10} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n", title,
             "edges", "certify us", "step us", "ratio", "50 %", "99 %", "99.9 %", "worst us",
             ">100 us %", "queries");
  for (const Kind& k : rows) {
    if (k.edges == 0) continue;
    const auto n = static_cast<double>(k.edges);
    const auto slow = std::count_if(k.each_us.begin(), k.each_us.end(),
                                    [](double us) { return us > kSlowMicroseconds; });
    fmt::print(
        "  {:<39} {:>7} {:>10.2f} {:>10.2f} {:>6.2f} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.2f} "
        "{:>8.2f}\n",
        k.name, k.edges, k.certify_us / n, k.step_us / n, k.certify_us / k.step_us,
        quantile(k.each_us, 0.5), quantile(k.each_us, 0.99), quantile(k.each_us, 0.999),
        quantile(k.each_us, 1), 100 * static_cast<double>(slow) / n,
        static_cast<double>(k.exact) / n);
  }
}

/// Edges that planning and simplifying request, mixed.
struct Mix {
  std::vector<Kind> planning = kinds(), simplifying = kinds();

  void add(const Problem& problem, unsigned long long iterations) {
    const auto scene = std::make_shared<const CompiledScene>(problem);
    const leeway::bench::AskedEdges asked = leeway::bench::askedEdges(problem, scene, iterations);
    if (asked.planning.empty()) fmt::print("{}: nothing asked\n", problem.name);
    measure(scene, asked.planning, planning);
    measure(scene, asked.simplifying, simplifying);
  }
  void print(const std::string& prefix = {}) const {
    ::print(prefix + "planning", planning);
    ::print(prefix + "simplifying", simplifying);
    std::vector<Kind> both = planning;
    for (std::size_t k = 0; k < both.size(); ++k) ::add(both[k], simplifying[k]);
    ::print(prefix + "planning and simplifying", both);
  }
};

constexpr double kRoom = 0.7;  // [m], to either side

leeway::collision::Pose somewhere(leeway::bench::SplitMix& random) {
  const double u = random.uniform(), v = random.uniform(), w = random.uniform();
  const double x = random.uniform(-kRoom, kRoom), y = random.uniform(-kRoom, kRoom),
               z = random.uniform(-kRoom, kRoom);
  // Uniform over rotations (Shoemake, "Uniform random rotations", 1992).
  const double a = 2 * std::numbers::pi * v, b = 2 * std::numbers::pi * w;
  const Eigen::Quaterniond q(std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
                             std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b));
  return {q.toRotationMatrix(), {x, y, z}};
}

std::vector<double> pointAt(const leeway::collision::Pose& X) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(X.rotation).normalized();
  const Eigen::Vector3d& p = X.translation;
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

/// A free body of about 2k triangles among twelve such, from one free pose to another.
Problem bodies(const std::vector<leeway::bench::Soup>& soups, std::uint64_t seed) {
  using leeway::collision::Shape;
  leeway::bench::SplitMix random(seed);
  std::vector<Shape> shapes;
  shapes.reserve(soups.size());
  for (const leeway::bench::Soup& soup : soups)
    shapes.push_back(
        Shape::mesh(leeway::collision::TriangleMesh::make(soup.vertices, soup.triangles)));
  Problem problem;
  problem.name = fmt::format("bodies {}", seed);
  problem.seed = seed;
  problem.robot.model = leeway::robots::freeBody(
      "body", {{shapes[seed % shapes.size()], {}, "body"}}, leeway::robots::JointType::kFloating,
      Eigen::Vector3d::Constant(-kRoom), Eigen::Vector3d::Constant(kRoom));
  for (int v = 0; v < 7; ++v) problem.robot.variables.push_back(v);
  for (std::size_t i = 0; i < 12; ++i) {
    const std::string name = fmt::format("obstacle{}", i);
    problem.world.objects.push_back(
        {name, {{shapes[i % shapes.size()], {}, name}}, somewhere(random)});
  }
  problem.start = pointAt(somewhere(random));
  problem.goals.push_back({"goal", {}});  // a valid one, until a free point is found
  for (const double x : problem.start) problem.goals[0].ranges.emplace_back(x, x);
  EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
  const auto freePoint = [&] {
    for (;;) {
      const std::vector<double> point = pointAt(somewhere(random));
      if (certifier.decide(point) == Verdict::kFree) return point;
    }
  };
  problem.start = freePoint();
  const std::vector<double> goal = freePoint();
  for (std::size_t i = 0; i < goal.size(); ++i) problem.goals[0].ranges[i] = {goal[i], goal[i]};
  return problem;
}

void measureBodies(std::uint64_t seed, unsigned long long iterations) {
  using namespace leeway::bench;
  Mix closed, sheets;
  for (std::uint64_t i = 0; i < 8; ++i) {
    closed.add(bodies({link(32, 32), torus(32, 32), bumpyBall(32, 32), dumbbell(32, 32)}, seed + i),
               iterations);
    sheets.add(bodies({cloth(32, 32)}, seed + i), iterations);
  }
  closed.print("closed bodies, ");
  sheets.print("sheets, ");
}

}  // namespace

int main(int argc, char** argv) {
  ompl::msg::noOutputHandler();
  CLI::App app("Certified edges against stepping.");
  leeway::bench::ProblemFiles files;
  unsigned long long iterations = 2000;
  std::uint64_t seed = 1;
  bool bodies_too = false;
  files.addTo(app);
  app.add_option("--iterations", iterations, "of the planner, a problem");
  app.add_option("--seed", seed, "seed");
  app.add_flag("--bodies", bodies_too, "a body of triangles among bodies");
  return leeway::bench::runProgram("bench_edges", app, argc, argv, [&] {
    if (bodies_too) measureBodies(seed, iterations);
    if (files.names().empty() && !bodies_too)
      throw std::runtime_error("files or --bodies are expected");
    if (files.names().empty()) return 0;
    Mix mix;
    for (const std::string& file : files.names()) {
      Problem problem = files.load(file);
      problem.seed = seed;
      mix.add(problem, iterations);
    }
    mix.print();
    return 0;
  });
}
