#include "tools/lab/motion/motion_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <memory>
#include <utility>

#include "tools/lab/base/guard.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/motion/motion_cases.h"

namespace leeway::tools::report {
namespace {

using Clock = std::chrono::steady_clock;

/// Cases are made, queried and released in chunks, which limits memory for large counts.
constexpr int kChunk = 2000;
/// Shorter passes are repeated up to this length, which hides the clock's resolution.
constexpr double kShortestPass = 5e3;  // [ns]

/// One engine's answer to one case, in shared memory.
struct Asked {
  ContactAnswer answer;
  double nanoseconds = std::numeric_limits<double>::quiet_NaN();
};

/// One engine's queries of a chunk; null entries: unsupported.
using Queries = std::vector<std::unique_ptr<ContactQuery>>;

Queries prepare(const ContactEngine& engine, const ContactFamily& family) {
  Queries queries;
  for (const ContactCase& c : family.cases) {
    std::unique_ptr<ContactQuery> query = engine.prepare(c.spec);
    if (!query) return {};
    queries.push_back(std::move(query));
  }
  return queries;
}

volatile double sink;  // keeps answers from being optimised away

double timeOnce(ContactQuery& query, int repeats) {
  double sum = 0;
  const auto begin = Clock::now();
  for (int r = 0; r < repeats; ++r) sum += query.ask().lower;
  const auto end = Clock::now();
  sink = sum;
  return std::chrono::duration<double, std::nano>(end - begin).count() / repeats;
}

/// A row that is being measured, summed over chunks.
struct Tally {
  MotionRow row;
  std::vector<double> errors, nanoseconds;
};

void judge(const ContactCase& c, Fate fate, const Asked& asked, Tally& tally) {
  MotionRow& row = tally.row;
  ++row.cases;
  row.hits += c.contact;
  row.threw += fate == Fate::kThrew;
  row.died += fate == Fate::kDied;
  row.endless += fate == Fate::kTimedOut;
  if (fate != Fate::kDone) return;
  const ContactAnswer& answer = asked.answer;
  if (!std::isnan(asked.nanoseconds)) tally.nanoseconds.push_back(asked.nanoseconds);
  if (answer.undecided) {
    ++row.undecided;
    row.unsafe += row.claims_bounds && c.contact && answer.lower > c.upper;
    return;
  }
  row.misses += c.contact && !answer.contact;
  row.false_hits += !c.contact && answer.contact;
  if (!c.contact || !answer.contact) return;
  const bool starts = c.upper == 0;
  row.wrong_starts +=
      starts ? answer.upper > kStartTime : answer.upper <= 0 && c.lower > kStartTime;
  row.unsafe += row.claims_bounds && !(answer.lower <= c.upper && answer.upper >= c.lower);
  tally.errors.push_back(
      std::max({0.0, std::abs(answer.lower - c.upper), std::abs(answer.upper - c.lower)}));
}

/// Queries all cases in guarded items, then times the answered ones in one guarded item.
void measureChunk(const ContactFamily& family, const std::vector<const ContactEngine*>& engines,
                  const MotionReportOptions& options, std::vector<Tally>& tallies) {
  const std::size_t cases = family.cases.size();
  std::vector<Queries> queries;
  queries.reserve(engines.size());
  for (const ContactEngine* engine : engines) queries.push_back(prepare(*engine, family));
  const SharedArray<Asked> asked(engines.size() * cases);
  std::vector<std::vector<Fate>> fates(engines.size());
  for (std::size_t e = 0; e < engines.size(); ++e)
    fates[e] = runGuarded(queries[e].size(), options.query_seconds, [&](std::size_t i) {
      asked[e * cases + i].answer = queries[e][i]->ask();
    });
  runGuarded(options.passes > 0 ? 1 : 0, 24 * 3600, [&](std::size_t) {
    std::vector<std::vector<double>> passes(engines.size());
    std::vector<int> repeats(engines.size());
    for (std::size_t i = 0; i < cases; ++i) {
      for (int pass = -1; pass < options.passes; ++pass)
        for (std::size_t e = 0; e < engines.size(); ++e) {
          if (queries[e].empty() || fates[e][i] != Fate::kDone) continue;
          if (pass < 0) {
            // Warms caches and branch predictors, and measures a query's length.
            repeats[e] = static_cast<int>(std::ceil(
                kShortestPass / std::max(kShortestPass / 50, timeOnce(*queries[e][i], 1))));
            passes[e].clear();
          } else {
            passes[e].push_back(timeOnce(*queries[e][i], repeats[e]));
          }
        }
      for (std::size_t e = 0; e < engines.size(); ++e)
        if (!queries[e].empty() && fates[e][i] == Fate::kDone)
          asked[e * cases + i].nanoseconds = quantile(passes[e], 0.5);
    }
  });
  for (std::size_t e = 0; e < engines.size(); ++e)
    for (std::size_t i = 0; i < queries[e].size(); ++i)
      judge(family.cases[i], fates[e][i], asked[e * cases + i], tallies[e]);
}

}  // namespace

std::vector<MotionRow> measureMotion(const std::vector<const ContactEngine*>& engines,
                                     const MotionReportOptions& options) {
  std::vector<MotionRow> rows;
  for (const std::string& name : options.families) {
    if (options.progress) options.progress(name);
    std::vector<Tally> tallies(engines.size());
    for (std::size_t e = 0; e < engines.size(); ++e) {
      tallies[e].row.family = name;
      tallies[e].row.engine = engines[e]->name();
      tallies[e].row.claims_bounds = engines[e]->claimsBounds();
    }
    std::uint64_t chunk = 0;
    for (int done = 0; done < options.cases; done += kChunk, ++chunk) {
      const int count = std::min(kChunk, options.cases - done);
      const ContactFamily family =
          makeContactFamily(name, count, options.seed + chunk * 0x9e3779b97f4a7c15u);
      measureChunk(family, engines, options, tallies);
    }
    std::vector<MotionRow> added;
    for (Tally& tally : tallies) {
      if (tally.row.cases == 0) continue;
      tally.row.error_median = quantile(tally.errors, 0.5);
      tally.row.error_max = quantile(tally.errors, 1);
      tally.row.ns_median = quantile(tally.nanoseconds, 0.5);
      tally.row.ns_95 = quantile(tally.nanoseconds, 0.95);
      tally.row.ns_max = quantile(tally.nanoseconds, 1);
      added.push_back(std::move(tally.row));
    }
    if (options.on_rows) options.on_rows(added);
    rows.insert(rows.end(), added.begin(), added.end());
  }
  return rows;
}

}  // namespace leeway::tools::report
