#include "tools/lab/accuracy/accuracy_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "tools/lab/base/guard.h"
#include "tools/lab/base/statistics.h"

namespace leeway::tools::report {
namespace {

using Clock = std::chrono::steady_clock;

/// One engine's queries of a family; empty if it lacks the pair of types.
struct Prepared {
  const PairEngine* engine = nullptr;
  std::vector<std::unique_ptr<PairQuery>> queries;
  std::vector<double> tolerances;
};

bool isWarm(const AccuracyFamily& family) { return family.kind == FamilyKind::kCoherent; }

Prepared prepare(const PairEngine& engine, const AccuracyFamily& family,
                 const std::vector<double>& tolerances) {
  Prepared result;
  result.engine = &engine;
  result.tolerances = tolerances;
  if (!engine.hasTolerance()) result.tolerances = {std::numeric_limits<double>::quiet_NaN()};
  for (const AccuracyCase& c : family.cases) {
    std::unique_ptr<PairQuery> query;
    try {
      query = engine.prepare(c.spec, isWarm(family));
    } catch (const std::exception&) {
      // A shape that the engine rejects counts as a missing type.
    }
    if (!query) return {&engine, {}, {}};
    result.queries.push_back(std::move(query));
  }
  return result;
}

/// Warm-starts case i from the previous case of the track.
void beginWarm(const Prepared& p, const AccuracyFamily& family, std::size_t i) {
  if (!isWarm(family)) return;
  const bool follows = i > 0 && family.cases[i].track == family.cases[i - 1].track;
  p.queries[i]->follow(follows ? p.queries[i - 1].get() : nullptr);
}

double absoluteTolerance(double relative, const AccuracyCase& c) { return relative * c.spec.size; }

/// Answers of one prepared engine at one tolerance, in case order.
struct Outcome {
  std::vector<PairAnswer> answers;
  std::vector<Fate> fates;
};

/// One outcome for each tolerance.
std::vector<Outcome> askAll(const Prepared& p, const AccuracyFamily& family, double seconds) {
  const std::size_t cases = family.cases.size(), count = cases * p.tolerances.size();
  const SharedArray<PairAnswer> answers(count);
  const std::vector<Fate> fates = runGuarded(count, seconds, [&](std::size_t k) {
    const std::size_t i = k % cases;
    beginWarm(p, family, i);
    answers[k] = p.queries[i]->ask(absoluteTolerance(p.tolerances[k / cases], family.cases[i]));
  });
  std::vector<Outcome> outcomes(p.tolerances.size());
  for (std::size_t k = 0; k < count; ++k) {
    outcomes[k / cases].answers.push_back(answers[k]);
    outcomes[k / cases].fates.push_back(fates[k]);
  }
  return outcomes;
}

bool isAnswer(const Outcome& o, std::size_t i) {
  return o.fates[i] == Fate::kDone && !std::isnan(o.answers[i].lower) &&
         !std::isnan(o.answers[i].upper);
}

/// Distance of the farther end from the truth's interval.
double errorOf(const PairAnswer& answer, const AccuracyCase& c) {
  const double off =
      std::max(std::abs(answer.lower - c.spec.distance), std::abs(answer.upper - c.spec.distance));
  return std::max(0.0, off - (c.truth_upper - c.truth_lower));
}

bool isWrongVerdict(const PairAnswer& answer, const AccuracyCase& c, bool interval) {
  const double decided = kDecided * c.extent;
  if (c.truth_upper < -decided) return answer.lower > 0;
  if (c.truth_lower > decided) return interval ? answer.upper < 0 : answer.upper <= 0;
  return false;
}

bool isUnsafe(const PairAnswer& answer, const AccuracyCase& c) {
  if (!(answer.lower <= answer.upper)) return true;
  return answer.lower > c.truth_upper || answer.upper < c.truth_lower;
}

AccuracyRow judge(const Prepared& p, const AccuracyFamily& family, double tolerance,
                  const Outcome& outcome) {
  AccuracyRow row;
  row.family = family.name;
  row.kind = family.kind;
  row.engine = p.engine->name();
  row.tells_distance = p.engine->tellsDistance();
  row.claims_bounds = p.engine->claimsBounds();
  row.tolerance = tolerance;
  std::vector<double> errors;
  for (std::size_t i = 0; i < family.cases.size(); ++i) {
    const AccuracyCase& c = family.cases[i];
    ++row.cases;
    row.threw += outcome.fates[i] == Fate::kThrew;
    row.died += outcome.fates[i] == Fate::kDied;
    row.endless += outcome.fates[i] == Fate::kTimedOut;
    if (outcome.fates[i] != Fate::kDone) continue;
    if (!isAnswer(outcome, i)) {
      ++row.not_a_number;
      continue;
    }
    ++row.answered;
    const PairAnswer& answer = outcome.answers[i];
    row.wrong_verdict += isWrongVerdict(answer, c, row.claims_bounds);
    row.unsafe += row.claims_bounds && isUnsafe(answer, c);
    if (!row.tells_distance || !c.has_value) continue;
    errors.push_back(errorOf(answer, c) / c.spec.size);
    row.wrong += errors.back() > kWrong;
  }
  row.error_median = quantile(errors, 0.5);
  row.error_95 = quantile(errors, 0.95);
  row.error_max = quantile(errors, 1);
  return row;
}

/// The answered cases of a row; only those are timed.
std::vector<std::size_t> timedCases(const Outcome& outcome) {
  std::vector<std::size_t> cases;
  for (std::size_t i = 0; i < outcome.answers.size(); ++i)
    if (isAnswer(outcome, i)) cases.push_back(i);
  return cases;
}

volatile double sink;  // keeps answers from being optimised away

/// Mean time of a query [ns], with each case queried once, in order. For warm families, the first
/// case of each track is not timed.
double timePass(const Prepared& p, const AccuracyFamily& family, double tolerance,
                const std::vector<std::size_t>& cases) {
  double sum = 0;
  if (!isWarm(family)) {
    const auto begin = Clock::now();
    for (const std::size_t i : cases)
      sum += p.queries[i]->ask(absoluteTolerance(tolerance, family.cases[i])).lower;
    const auto end = Clock::now();
    sink = sum;
    return std::chrono::duration<double, std::nano>(end - begin).count() /
           static_cast<double>(cases.size());
  }
  double nanoseconds = 0;
  std::size_t asked = 0;
  for (std::size_t k = 0; k < cases.size();) {
    const int track = family.cases[cases[k]].track;
    beginWarm(p, family, cases[k]);
    sum += p.queries[cases[k]]->ask(absoluteTolerance(tolerance, family.cases[cases[k]])).lower;
    std::size_t previous = cases[k++];
    const std::size_t first = k;
    const auto begin = Clock::now();
    for (; k < cases.size() && family.cases[cases[k]].track == track; previous = cases[k++]) {
      p.queries[cases[k]]->follow(p.queries[previous].get());
      sum += p.queries[cases[k]]->ask(absoluteTolerance(tolerance, family.cases[cases[k]])).lower;
    }
    nanoseconds += std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
    asked += k - first;
  }
  sink = sum;
  return asked == 0 ? std::numeric_limits<double>::quiet_NaN()
                    : nanoseconds / static_cast<double>(asked);
}

/// A row that is being measured, with its queries.
struct Measurement {
  const Prepared* prepared;
  AccuracyRow row;
  std::vector<std::size_t> timed;
};

/// Shorter passes are repeated up to this length, which hides the clock's resolution.
constexpr double kShortestPass = 10e3;  // [ns]
constexpr double kMostRepeats = 50;

double timeRepeatedPass(const Prepared& prepared, const Measurement& m,
                        const AccuracyFamily& family, int repeats) {
  double sum = 0;
  for (int r = 0; r < repeats; ++r) sum += timePass(prepared, family, m.row.tolerance, m.timed);
  return sum / repeats;
}

/// Times all rows of a family, interleaved, in one child process.
void timeFamily(const AccuracyFamily& family, int passes, std::vector<Measurement>& measurements) {
  const auto count = static_cast<std::size_t>(passes);
  const SharedArray<double> nanoseconds(measurements.size() * count);
  const std::vector<Fate> fate = runGuarded(1, 3600, [&](std::size_t) {
    std::vector<int> repeats;
    for (const Measurement& m : measurements) {
      // Warms caches and branch predictors, and measures a pass's length.
      const double pass = m.timed.empty()
                              ? 0
                              : timePass(*m.prepared, family, m.row.tolerance, m.timed) *
                                    static_cast<double>(m.timed.size());
      repeats.push_back(static_cast<int>(
          std::clamp(std::ceil(kShortestPass / std::max(1.0, pass)), 1.0, kMostRepeats)));
    }
    for (std::size_t pass = 0; pass < count; ++pass) {
      const Measurement* previous = nullptr;
      for (std::size_t k = 0; k < measurements.size(); ++k) {
        const Measurement& m = measurements[k];
        if (m.timed.empty()) continue;
        // Untimed: the previous engine evicted this one's code and data.
        if (previous == nullptr || previous->prepared != m.prepared) {
          timePass(*m.prepared, family, m.row.tolerance, m.timed);
        }
        previous = &m;
        nanoseconds[k * count + pass] = timeRepeatedPass(*m.prepared, m, family, repeats[k]);
      }
    }
  });
  for (std::size_t k = 0; k < measurements.size(); ++k) {
    if (measurements[k].timed.empty() || fate[0] != Fate::kDone) continue;
    const auto first = nanoseconds.span().begin() + static_cast<std::ptrdiff_t>(k * count);
    const std::vector<double> values(first, first + passes);
    AccuracyRow& row = measurements[k].row;
    row.ns = quantile(values, 0.5);
    row.ns_low = quantile(values, 0.25);
    row.ns_high = quantile(values, 0.75);
  }
}

}  // namespace

std::vector<double> accuracyTolerances() {
  std::vector<double> tolerances = {std::numeric_limits<double>::quiet_NaN()};
  for (int k = 1; k <= 15; ++k) tolerances.push_back(std::pow(10.0, -k));
  return tolerances;
}

std::vector<AccuracyRow> measureAccuracy(const AccuracySet& set,
                                         const std::vector<const PairEngine*>& engines,
                                         const AccuracyOptions& options) {
  std::vector<AccuracyRow> rows;
  for (const AccuracyFamily& family : set.families) {
    if (options.progress) options.progress(family.name);
    std::vector<Prepared> prepared;
    prepared.reserve(engines.size());
    for (const PairEngine* engine : engines)
      prepared.push_back(prepare(*engine, family, options.tolerances));
    std::vector<Measurement> measurements;
    for (const Prepared& p : prepared) {
      const std::vector<Outcome> outcomes = askAll(p, family, options.query_seconds);
      for (std::size_t t = 0; t < outcomes.size(); ++t)
        measurements.push_back(
            {&p, judge(p, family, p.tolerances[t], outcomes[t]), timedCases(outcomes[t])});
    }
    timeFamily(family, options.passes, measurements);
    std::vector<AccuracyRow> added;
    added.reserve(measurements.size());
    for (Measurement& m : measurements) added.push_back(std::move(m.row));
    if (options.on_rows) options.on_rows(added);
    rows.insert(rows.end(), added.begin(), added.end());
  }
  return rows;
}

}  // namespace leeway::tools::report
