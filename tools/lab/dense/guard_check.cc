// guard_check: what a Guard lets pass of a noisy policy, looked at with FCL.
//   guard_check --robot R.urdf --srdf R.srdf SCENE.yaml...     MoveIt scenes with requests
// With --polynomials each chunk is one polynomial a joint, which comes to rest where a chunk of
// setpoints ends.
// Each scene is planned; a policy goes to and fro along the path with noise, in chunks, and the
// robot executes what the guard lets pass. FCL looks at every millisecond of all that passed and of
// the stop after it, and of what the policy wanted. Counts, over all scenes:
//   contacts       of what the guard let pass, or of its stops: must be 0
//   collide        chunks that would collide if they were executed as they are
//   safe           chunks that do not, and stay within the joints' limits, with the stop after
//                  them; and how many of these pass whole
// Exit status 1 after a contact, and where fewer than --least of the safe chunks pass whole.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "planner/guard/brake.h"
#include "tools/lab/bench/noisy_policy.h"
#include "tools/lab/bench/problem_files.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/dense/dense_world.h"

namespace {

using namespace leeway::planner;

constexpr double kLook = 1e-3;  // [s]

/// Looks at motions through setpoints.
class Looks {
 public:
  Looks(leeway::dense::DenseWorld& world, std::vector<std::string> names, double period)
      : world_(world),
        names_(std::move(names)),
        count_(std::max(1, static_cast<int>(std::ceil(period / kLook)))) {}

  bool collides(std::span<const double> start, std::span<const double> rows) {
    const std::size_t n = start.size();
    std::vector<double> a(start.begin(), start.end()), b(n);
    for (std::size_t k = 0; k * n < rows.size(); ++k) {
      std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(k * n), n, b.begin());
      if (world_.firstCollision(names_, a, b, count_)) return true;
      a = b;
    }
    return false;
  }

 private:
  leeway::dense::DenseWorld& world_;
  std::vector<std::string> names_;
  int count_;
};

struct Counts {
  long chunks = 0, contacts = 0, uncertified = 0, collide = 0, safe = 0, whole = 0, safe_whole = 0;
};

/// The stop after the last of some setpoints.
std::vector<double> stopAfter(const Brake& brake, double period, std::span<const double> before,
                              std::span<const double> rows) {
  const std::size_t n = before.size(), count = rows.size() / n;
  std::vector<double> velocity(n), rest(n);
  const std::span<const double> last = rows.subspan((count - 1) * n, n);
  const std::span<const double> previous = count > 1 ? rows.subspan((count - 2) * n, n) : before;
  for (std::size_t i = 0; i < n; ++i) velocity[i] = (last[i] - previous[i]) / period;
  std::vector<double> stop(static_cast<std::size_t>(brake.mostRows()) * n);
  stop.resize(static_cast<std::size_t>(std::max(0, brake.stop(last, velocity, rest, stop))) * n);
  return stop;
}

bool staysWithin(const ConfigurationSpace& space, std::span<const double> rows) {
  const auto n = static_cast<std::size_t>(space.size());
  for (std::size_t k = 0; k < rows.size(); k += n)
    if (!space.withinLimits(rows.subspan(k, n))) return false;
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What a Guard lets pass of a noisy policy, looked at with FCL.");
  std::string robot, srdf;
  std::vector<std::string> files;
  int chunks = 200, setpoints = 50;
  bool polynomials = false;
  double period = 0.02, noise = 0.08, least = 0.95;
  std::uint64_t seed = 1;
  app.add_option("--robot", robot)->required();
  app.add_option("--srdf", srdf)->required();
  app.add_option("--chunks", chunks, "of each scene")->capture_default_str();
  app.add_option("--setpoints", setpoints, "of a chunk, at most")->capture_default_str();
  app.add_flag("--polynomials", polynomials, "in place of setpoints");
  app.add_option("--period", period, "[s]")->capture_default_str();
  app.add_option("--noise", noise, "of velocities, as a share of their limits")
      ->capture_default_str();
  app.add_option("--least", least, "share of safe chunks that must pass whole")
      ->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  app.add_option("scenes", files)->required();
  return leeway::bench::runProgram("guard_check", app, argc, argv, [&] {
    const auto model = leeway::robots::loadModel(robot, srdf);
    std::unique_ptr<leeway::dense::DenseWorld> first;
    Counts sum;
    for (const std::string& file : files) {
      const std::string request = leeway::bench::requestOf(file);
      Problem problem = loadMoveit(model, file, request);
      problem.limits = {5, 100'000};
      const PlanResult planned = plan(problem);
      if (planned.status != PlanStatus::kSolved) continue;
      auto world = first ? std::make_unique<leeway::dense::DenseWorld>(*first, file, request)
                         : std::make_unique<leeway::dense::DenseWorld>(model, file, request);
      Looks looks(*world, planned.path.names, period), fine(*world, planned.path.names, kLook);
      GuardOptions options;
      options.period = period;
      options.most_setpoints = setpoints;
      Guard guard(problem, options);
      const Brake brake(guard.options().limits, period);
      leeway::bench::NoisyPolicy policy(guard.options(), planned.path.positions, noise, seed);
      leeway::bench::GuardedRun run(guard, policy, planned.path.positions.front());
      for (int c = 0; c < chunks; ++c) {
        const int most = polynomials ? setpoints / 2 : setpoints;
        const std::vector<double> chunk = run.next(most - c % (most / 2));
        const leeway::bench::RestingQuintics curves(run.place(), run.velocity(), chunk, period);
        const GuardAnswer& answer =
            guard.check(polynomials ? GuardRequest{.polynomials = curves.coefficients,
                                                   .duration = curves.duration,
                                                   .time = run.time()}
                                    : GuardRequest{.setpoints = chunk, .time = run.time()});
        ++sum.chunks;
        sum.uncertified += answer.certified ? 0 : 1;
        const auto on = static_cast<std::size_t>(polynomials ? answer.passed : 0) * curves.size;
        const bool touches =
            fine.collides(answer.start,
                          curves.rows(kLook, polynomials ? answer.passed * period : 0)) ||
            looks.collides(
                on > 0 ? answer.motion.subspan(on - curves.size, curves.size) : answer.start,
                answer.motion.subspan(on));
        if (touches && answer.certified) {
          ++sum.contacts;
          fmt::print("contact: {} chunk {}\n", file, c);
        }
        const bool is_whole = answer.reason == GuardReason::kPassed;
        const bool collides = polynomials
                                  ? fine.collides(run.place(), curves.rows(kLook, curves.duration))
                                  : looks.collides(run.place(), chunk);
        const std::vector<double> stop =
            polynomials ? std::vector<double>() : stopAfter(brake, period, run.place(), chunk);
        const bool is_safe =
            !collides && staysWithin(guard.scene()->space(), chunk) &&
            staysWithin(guard.scene()->space(), stop) &&
            !looks.collides(std::span<const double>(chunk).last(curves.size), stop);
        sum.collide += collides ? 1 : 0;
        sum.safe += is_safe ? 1 : 0;
        sum.whole += is_whole ? 1 : 0;
        sum.safe_whole += is_safe && is_whole ? 1 : 0;
        run.execute();
      }
      if (!first) first = std::move(world);
    }
    const double share =
        static_cast<double>(sum.safe_whole) / std::max(1.0, static_cast<double>(sum.safe));
    const double of = 100 / std::max(1.0, static_cast<double>(sum.chunks));
    fmt::print(
        "{} chunks: {} contacts, {} answers not certified; {:.1f} % would collide, {:.1f} % are "
        "safe with their stop, of which {:.2f} % pass whole\n",
        sum.chunks, sum.contacts, sum.uncertified, of * static_cast<double>(sum.collide),
        of * static_cast<double>(sum.safe), 100 * share);
    return sum.contacts == 0 && share >= least ? 0 : 1;
  });
}
