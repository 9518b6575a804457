#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "leeway/collision/distance.h"
#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "tools/lab/base/statistics.h"
#include "tools/lab/base/table.h"
#include "tools/lab/report/report.h"
#include "tools/leeway/support/case_file.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {
namespace {

using collision::DistanceRequest;
using collision::DistanceResult;
using collision::DistanceStatus;
using collision::PairCache;

struct Answer {
  DistanceResult result;
  std::int64_t nanoseconds = 0;
  double tolerance = 0;  // that was asked for [m]
};

const char* word(DistanceStatus status) {
  switch (status) {
    case DistanceStatus::kConverged:
      return "converged";
    case DistanceStatus::kAboveThreshold:
      return "above";
    case DistanceStatus::kNotAboveThreshold:
      return "not_above";
    case DistanceStatus::kOverlap:
      return "overlap";
    case DistanceStatus::kLimit:
      return "limit";
    case DistanceStatus::kInvalid:
      return "invalid";
  }
  return "invalid";
}

/// Every case in file order; the cases of a track warm one another.
std::vector<Answer> answer(const CaseFile& file) {
  using Clock = std::chrono::steady_clock;
  collision::Scratch scratch;
  std::map<std::pair<std::string, std::string>, PairCache> caches;
  std::vector<Answer> answers;
  answers.reserve(file.cases.size());
  for (const Case& c : file.cases) {
    PairCache* cache = c.family.rfind("seq-", 0) == 0 ? &caches[{c.family, c.part}] : nullptr;
    const auto begin = Clock::now();
    const DistanceResult result =
        collision::distance(file.shapes[c.shape_a], c.X_WA, file.shapes[c.shape_b], c.X_WB,
                            DistanceRequest{}, scratch, cache);
    const auto end = Clock::now();
    answers.push_back({result,
                       std::chrono::duration_cast<std::chrono::nanoseconds>(end - begin).count(),
                       collision::defaultTolerance(file.shapes[c.shape_a], c.X_WA,
                                                   file.shapes[c.shape_b], c.X_WB)});
  }
  return answers;
}

/// How the answers of one family stand against the truth.
struct Tally {
  std::size_t cases = 0;
  std::size_t unsafe = 0;  // the interval does not hold the truth
  std::size_t limits = 0;  // stopped short of the tolerance
  std::size_t invalid = 0;
  std::size_t wrong = 0;  // sign proven, and wrong
  std::size_t open = 0;   // sign left open although the truth is farther from 0 than the tolerance
  std::vector<double> widths;  // [m]
  std::vector<double> nanoseconds;

  void add(const Tally& t) {
    cases += t.cases, unsafe += t.unsafe, limits += t.limits, invalid += t.invalid,
        wrong += t.wrong, open += t.open;
    widths.insert(widths.end(), t.widths.begin(), t.widths.end());
    nanoseconds.insert(nanoseconds.end(), t.nanoseconds.begin(), t.nanoseconds.end());
  }
};

/// Holds one answer against its reference; says so on stderr when the truth is outside.
void judge(const Case& c, const Answer& a, const Reference& r, Tally& tally) {
  const collision::Interval& d = a.result.distance;
  ++tally.cases;
  tally.nanoseconds.push_back(static_cast<double>(a.nanoseconds));
  if (a.result.status == DistanceStatus::kInvalid) ++tally.invalid;
  if (a.result.status == DistanceStatus::kLimit) ++tally.limits;
  tally.widths.push_back(d.width());
  // The reference is known to its own width and to the last of its 17 digits.
  const double slack = r.gap + 0x1p-53 * std::abs(r.distance);
  const bool unsafe =
      !(d.lower <= d.upper) ||
      (r.has_value ? d.lower > r.distance + slack || d.upper < r.distance - slack
                   : (r.verdict < 0 && d.lower > 0) || (r.verdict > 0 && d.upper < 0));
  if (unsafe) {
    ++tally.unsafe;
    fmt::print(stderr,
               "case {} ({}): [{:.17g}, {:.17g}] does not hold {:.17g} +- {:.3g}; rounding of the "
               "input {:.3g}\n",
               c.id, c.family, d.lower, d.upper, r.distance, slack, 1e-16 * r.extent);
  }
  if ((r.verdict < 0 && d.lower > 0) || (r.verdict > 0 && d.upper < 0)) ++tally.wrong;
  if (r.has_value && std::abs(r.distance) > a.tolerance && d.lower <= 0 && d.upper > 0)
    ++tally.open;
}

void addRow(report::Table& table, const std::string& family, const Tally& t) {
  table.add({family, t.cases, t.unsafe, t.limits, t.invalid, t.wrong, t.open,
             report::quantile(t.widths, 0.5), report::quantile(t.widths, 0.95),
             report::quantile(t.widths, 1), report::median(t.nanoseconds)});
}

}  // namespace

int runReportCases(const std::string& file, const std::string& raw_output) {
  const CaseFile cases = readCaseFile(file);
  const std::vector<Answer> answers = answer(cases);
  std::string text;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const DistanceResult& r = answers[i].result;
    text += fmt::format("{} {} {:.17g} {:.17g} {}\n", cases.cases[i].id, word(r.status),
                        r.distance.lower, r.distance.upper, answers[i].nanoseconds);
  }
  if (raw_output == "-") {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else {
    planner::writeFileWhole(raw_output, text);
  }
  return kYes;
}

int runReportCasesAgainst(const std::string& file, const std::string& reference) {
  const CaseFile cases = readCaseFile(file);
  const auto references = readReferenceFile(reference);
  const std::vector<Answer> answers = answer(cases);
  std::map<std::string, Tally> families;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const Case& c = cases.cases[i];
    const auto found = references.find(c.id);
    if (found == references.end())
      throw robots::InputError(
          reference, 0, fmt::format("has no line for case {}; one line a case is expected", c.id));
    judge(c, answers[i], found->second, families[c.family]);
  }
  report::Table table({"family", "cases", "unsafe", "limit", "invalid", "wrong", "open",
                       "width [m]:.2e", "95 %:.2e", "most:.2e", "ns:.0f"});
  Tally all;
  for (const auto& [name, tally] : families) {
    addRow(table, name, tally);
    all.add(tally);
  }
  addRow(table, "all", all);
  fmt::print("{}", formatTable(table.heading(), table.rows(), table.textColumns()));
  return all.unsafe + all.wrong + all.invalid == 0 ? kYes : kNo;
}

}  // namespace leeway::tools
