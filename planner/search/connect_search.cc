#include "planner/search/connect_search.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

#include "planner/base/random.h"
#include "planner/base/tolerances.h"
#include "planner/constraint/constrained_way.h"
#include "planner/contact/contact_slide.h"
#include "planner/search/run_seed.h"
#include "planner/space/ompl_planners.h"

namespace leeway::planner {
namespace {

/// Difference between the first runs of two workers, in runs; no worker makes more runs.
constexpr std::uint64_t kRunsApart = 1ULL << 32;
/// Difference between a worker's first run and its first narrow one.
constexpr std::uint64_t kToNarrowRuns = kRunsApart / 2;

/// The n-th term of 1, 1, 2, 1, 1, 2, 4, 1, 1, 2, ..., n >= 1.
std::uint64_t luby(std::uint64_t n) {
  for (;;) {
    const auto whole = std::bit_ceil(n + 1);
    if (whole == n + 1) return whole / 2;
    n -= whole / 2 - 1;
  }
}

/// The settings of a worker. The needs of a problem are not known in advance: shorter edges suit
/// narrow passages, longer ones wide spaces, and a dynamic domain is a hindrance if the nearest
/// node is always the wrong one.
ConnectSettings settingsOf(const ConnectChoice& choice, std::uint64_t worker) {
  constexpr double kRangeShares[] = {1, 0.6, 1.5, 1};
  ConnectSettings settings = choice.settings;
  if (choice.own_range) settings.range *= kRangeShares[worker % 4];
  if (choice.own_domain && worker % 4 == 3) settings.dynamic_domain = false;
  if (choice.own_balance && worker % 8 == 7) settings.balance = false;
  return settings;
}

/// One search, a few iterations at a time.
class Worker {
 public:
  Worker(const ConnectQuery& query, const ConnectSettings& settings, std::uint64_t index,
         EdgeCertifier& certifier)
      : query_(query),
        settings_(settings),
        index_(index),
        certifier_(certifier),
        goals_(query.goals),
        check_([this](std::span<const double> a, std::span<const double> b) {
          // One iteration may check many edges.
          if (++asked_ % kConnectTurn == 0) over_ = over_ || query_.limits.over();
          if (over_) return EdgeCheck{};
          EdgeCertifier& own = narrow_ ? narrow_->certifier : certifier_;
          const EdgeCheck check = own.certify(a, b, own.searching());
          if (check.verdict != Verdict::kFree && check.pair >= 0) ++hindrance_.blocked[check.pair];
          if (check.verdict == Verdict::kFree && index_ == 0 && query_.on_edge)
            query_.on_edge(a, b);
          return check;
        }),
        keeps_margins_([this](std::span<const double> a, std::span<const double> b) {
          return check_(a, b).verdict == Verdict::kFree;
        }),
        is_free_([this](std::span<const double> a, std::span<const double> b) {
          return way_ ? way_->isFree(a, b) : keeps_margins_(a, b);
        }),
        slide_([this](std::span<const double> from, std::span<const double> target,
                      std::vector<double>& points) {
          if (way_)
            way_->go(from, target, points);
          else
            narrow_->slide.slide(from, target, points);
        }),
        is_body_(isBody(query.scene->space())) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Runs up to `count` iterations; fewer, and returns true, once a path is found.
  bool advance(std::uint64_t count) {
    for (; count > 0; --count) {
      if (!trees_) begin();
      ++iterations_;
      if (has_more_goals_ && iterations_ % kGoalTurn == 0) {
        has_more_goals_ = query_.more_goals(goal_batches_, goals_);
        ++goal_batches_;
        trees_->takeGoals();
      }
      scanned_ += trees_->nodes();
      const bool met = trees_->iterate();
      // Slides check their edges from the tree's root outwards, which is backwards in the goals'
      // tree.
      const bool is_certified = !narrow_ && !way_;
      if (met) path_ = trees_->path();
      if (met || (--left_ == 0 && !goesOn())) end();
      if (met && query_.accept(path_, certifier_, is_certified)) return true;
    }
    return false;
  }

  std::uint64_t iterations() const { return iterations_; }
  std::size_t goalBatches() const { return goal_batches_; }
  Waypoints takePath() { return std::move(path_); }
  /// The hindrance of all runs, including the present one.
  Hindrance hindrance() const {
    Hindrance all = hindrance_;
    if (trees_) all += {{}, trees_->gap()};
    return all;
  }
  const EdgeCertifier::Statistics& work() const { return certifier_.statistics; }
  /// The statistics of narrow runs' certifiers, which work() does not include.
  EdgeCertifier::Statistics narrowWork() const {
    EdgeCertifier::Statistics work = narrow_work_;
    if (narrow_) work += narrow_->certifier.statistics;
    return work;
  }

 private:
  /// The additional data of a narrow run. Its certifier is new and used by nothing else, so its
  /// answers about contacts, which depend on history, are the same after any other searches.
  struct Narrow {
    Narrow(const std::shared_ptr<const CompiledScene>& scene, const ContactSlide::Edge& check,
           double range)
        : certifier(scene), slide(certifier, check, range) {}
    EdgeCertifier certifier;
    ContactSlide slide;
  };

  /// After the first run every other run is narrow; the two kinds have separate series and seeds. A
  /// search for shorter paths has no narrow runs, because its paths already pass the narrow places.
  /// With constraints, all runs slide along these.
  void begin() {
    ConnectTask task{query_.scene->space(), query_.start, goals_, is_free_, query_.bound};
    ConnectSettings settings = settings_;
    if (query_.constrained != nullptr) {
      way_.emplace(*query_.scene, *query_.constrained, keeps_margins_, settings.range);
      task.slide = &slide_;
      settings.dynamic_domain = false;
    }
    const bool is_narrow = !way_ && narrow_runs_ < runs_ && std::isinf(query_.bound);
    std::uint64_t& runs = is_narrow ? narrow_runs_ : runs_;
    if (is_narrow) {
      narrow_.emplace(query_.scene, check_, settings.range);
      task.slide = &slide_;
      settings.dynamic_domain = false;  // slides leave the nodes that it holds back
    }
    trees_.emplace(
        task, settings,
        runSeed(query_.seed, index_ * kRunsApart + (is_narrow ? kToNarrowRuns : 0) + runs));
    left_ = query_.run * luby(++runs);
  }

  /// Whether the first run has more iterations. A slide costs hundreds of an arm's edges, so narrow
  /// runs wait while the edges are few. Counts decide, not times, and no count depends on earlier
  /// queries of the certifier.
  bool goesOn() {
    const bool is_first = runs_ == 1 && !narrow_ && std::isinf(query_.bound);
    if (!is_first || is_body_ || iterations_ >= kLongestFirstRun * query_.run ||
        asked_ >= kFirstRunEdges || scanned_ >= kFirstRunScans)
      return false;
    left_ = kConnectTurn;
    return true;
  }

  void end() {
    hindrance_ += {{}, trees_->gap()};
    trees_.reset();
    narrow_work_ = narrowWork();
    narrow_.reset();
    way_.reset();
  }

  const ConnectQuery& query_;
  ConnectSettings settings_;
  std::uint64_t index_;
  EdgeCertifier& certifier_;
  Waypoints goals_;
  bool has_more_goals_ = static_cast<bool>(query_.more_goals);
  std::size_t goal_batches_ = 0;
  ContactSlide::Edge check_;
  ConstrainedWay::IsFree keeps_margins_, is_free_;
  ConnectSlide slide_;
  std::optional<Narrow> narrow_;
  std::optional<ConstrainedWay> way_;
  std::optional<ConnectTrees> trees_;
  EdgeCertifier::Statistics narrow_work_;  ///< of runs that have ended
  Hindrance hindrance_;                    ///< gaps: of runs that have ended
  std::uint64_t runs_ = 0, narrow_runs_ = 0, left_ = 0, iterations_ = 0;
  bool is_body_;
  std::uint64_t asked_ = 0;    ///< edges
  std::uint64_t scanned_ = 0;  ///< nodes that existed, summed over iterations
  bool over_ = false;
  Waypoints path_;
};

ConnectResult searchAlone(const ConnectQuery& query, const ConnectSettings& settings,
                          EdgeCertifier& certifier) {
  Limits& limits = query.limits;
  Worker worker(query, settings, 0, certifier);
  bool is_over = limits.searchOver();
  while (!is_over && worker.iterations() < query.most) {
    const std::uint64_t before = worker.iterations();
    const bool found = worker.advance(std::min({kConnectTurn, limits.left(), query.most - before}));
    is_over = limits.iterate(worker.iterations() - before);
    if (found) return {worker.takePath(), worker.narrowWork(), worker.goalBatches(), {}};
  }
  return {std::nullopt, worker.narrowWork(), worker.goalBatches(), worker.hindrance()};
}

/// Parallel workers, which take turns of kConnectTurn iterations. All of them make all turns up to
/// the one in which the winner ends, for any number of threads. So an earlier path is never missed.
class Portfolio {
 public:
  Portfolio(const ConnectQuery& query, const ConnectChoice& choice)
      : query_(query),
        choice_(choice),
        most_(std::min(query.most, query.limits.left())),
        members_(static_cast<std::size_t>(choice.workers)) {}

  ConnectResult search() {
    // A query of the number of cores costs as much time as a few hundred edges, so it is skipped
    // for one worker.
    const int wanted = choice_.threads > 0
                           ? choice_.threads
                           : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const int threads = std::clamp(wanted, 1, choice_.workers);
    std::vector<std::thread> others;
    // Even if starting some threads fails, the running ones are joined.
    try {
      for (int t = 1; t < threads; ++t)
        others.emplace_back([this, t, threads] { runOrFail(t, threads); });
    } catch (...) {
      fail();
    }
    runOrFail(0, threads);
    for (std::thread& thread : others) thread.join();
    if (failure_) std::rethrow_exception(failure_);
    return result();
  }

 private:
  struct Member {
    std::unique_ptr<EdgeCertifier> certifier;
    std::unique_ptr<Worker> worker;
    std::vector<EdgeCertifier::Statistics> work;  ///< after each turn
    bool found = false;
  };

  void fail() {
    const std::lock_guard<std::mutex> lock(mutex_);
    failure_ = std::current_exception();
    last_turn_ = 0;
  }

  void runOrFail(int first, int step) {
    try {
      run(first, step);
    } catch (...) {
      fail();
    }
  }

  /// The turns of every step-th member, starting with `first`.
  void run(int first, int step) {
    for (std::uint64_t turn = 0; turn <= last_turn_ && turn * kConnectTurn < most_; ++turn) {
      const std::uint64_t count = std::min(kConnectTurn, most_ - turn * kConnectTurn);
      for (int i = first; i < choice_.workers; i += step) {
        Member& member = members_[static_cast<std::size_t>(i)];
        if (member.found || turn > last_turn_) continue;
        if (query_.limits.searchOver()) return;
        if (!member.worker) {
          const auto index = static_cast<std::uint64_t>(i);
          member.certifier = std::make_unique<EdgeCertifier>(query_.scene);
          member.worker = std::make_unique<Worker>(query_, settingsOf(choice_, index), index,
                                                   *member.certifier);
        }
        member.found = member.worker->advance(count);
        member.work.push_back(member.worker->work());
        member.work.back() += member.worker->narrowWork();
        if (!member.found) continue;
        std::uint64_t last = last_turn_;
        while (turn < last && !last_turn_.compare_exchange_weak(last, turn)) {
        }
      }
    }
  }

  ConnectResult result() {
    ConnectResult result;
    Member* winner = nullptr;
    std::uint64_t iterations = 0;
    for (Member& member : members_) {
      if (!member.worker) continue;
      if (member.found &&
          (winner == nullptr || member.worker->iterations() < winner->worker->iterations()))
        winner = &member;
      iterations = std::max(iterations, member.worker->iterations());
      result.goal_batches = std::max(result.goal_batches, member.worker->goalBatches());
      if (!member.work.empty())
        result.work += member.work[std::min<std::uint64_t>(last_turn_, member.work.size() - 1)];
    }
    if (winner != nullptr) {
      iterations = winner->worker->iterations();
      result.goal_batches = winner->worker->goalBatches();
      result.path = winner->worker->takePath();
    } else {
      for (const Member& member : members_)
        if (member.worker) result.hindrance += member.worker->hindrance();
    }
    query_.limits.iterate(iterations);
    return result;
  }

  const ConnectQuery& query_;
  const ConnectChoice& choice_;
  std::uint64_t most_;  ///< iterations of each worker
  std::vector<Member> members_;
  /// The turn in which the earliest path so far was found.
  std::atomic<std::uint64_t> last_turn_{std::numeric_limits<std::uint64_t>::max()};
  std::mutex mutex_;
  std::exception_ptr failure_;
};

}  // namespace

Hindrance& Hindrance::operator+=(const Hindrance& more) {
  for (const auto& [pair, edges] : more.blocked) blocked[pair] += edges;
  if (more.gap.distance < gap.distance) gap = more.gap;
  return *this;
}

ConnectChoice connectChoice(const std::map<std::string, std::string>& parameters,
                            const ConfigurationSpace& space) {
  const auto number = [&](const char* key, double otherwise) {
    const auto found = parameters.find(key);
    return found == parameters.end() ? otherwise
                                     : parameterNumber(found->second).value_or(otherwise);
  };
  ConnectChoice choice;
  choice.settings.range = number("range", 0);
  choice.own_range = !(choice.settings.range > 0);
  if (choice.own_range) choice.settings.range = defaultRange(space);
  choice.settings.balance = number("balance", 1) != 0;
  choice.own_balance = parameters.count("balance") == 0;
  choice.settings.dynamic_domain = number("dynamic_domain", 1) != 0;
  choice.own_domain = parameters.count("dynamic_domain") == 0;
  choice.settings.low_discrepancy = number("low_discrepancy", isBody(space) ? 0 : 1) != 0;
  choice.workers = static_cast<int>(number("workers", 1));
  choice.threads = static_cast<int>(number("threads", 0));
  choice.improve = number("improve", 0);
  return choice;
}

ConnectResult searchConnect(const ConnectQuery& query, const ConnectChoice& choice,
                            EdgeCertifier& certifier) {
  if (choice.workers <= 1) return searchAlone(query, choice.settings, certifier);
  return Portfolio(query, choice).search();
}

}  // namespace leeway::planner
