#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "leeway/robots/input_error.h"
#include "tools/lab/accuracy/own_engine.h"
#include "tools/lab/accuracy/random_pairs.h"
#include "tools/lab/report/report.h"
#include "tools/lab/report/rival_report.h"
#include "tools/leeway/support/case_file.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {
namespace {

using report::AccuracyCase;
using report::AccuracyFamily;
using report::AccuracyRow;
using report::AccuracySet;
using report::FamilyKind;

/// Families of a file: `seq-*` are coherent, others split by SUB unless that is a track.
AccuracyFamily& familyOf(AccuracySet& set, std::map<std::string, std::size_t>& index,
                         const Case& c) {
  const bool coherent = c.family.rfind("seq-", 0) == 0;
  const std::string name = coherent ? c.family : c.family + " " + c.part;
  const auto [place, fresh] = index.emplace(name, set.families.size());
  if (fresh)
    set.families.push_back({name, coherent ? FamilyKind::kCoherent : FamilyKind::kHard, {}});
  return set.families[place->second];
}

AccuracyCase caseOf(const AccuracySet& set, const Case& c, const Reference& r) {
  const report::ReportShape* a = set.shapes[c.shape_a].get();
  const report::ReportShape* b = set.shapes[c.shape_b].get();
  AccuracyCase result;
  result.spec = {
      a, b, c.X_WA, c.X_WB, report::sizeOfPair(a->shape, b->shape), r.distance, r.verdict < 0};
  // Known to the reference's own width and to the last of its 17 digits.
  const double slack = r.gap + 0x1p-53 * std::abs(r.distance);
  result.truth_lower = r.distance - slack;
  result.truth_upper = r.distance + slack;
  if (!r.has_value) {
    // Only the side of zero is known, or not even that.
    result.truth_lower = r.verdict > 0 ? 0 : -HUGE_VAL;
    result.truth_upper = r.verdict < 0 ? 0 : HUGE_VAL;
  }
  result.extent = r.extent;
  result.has_value = r.has_value;
  return result;
}

AccuracySet readSet(const std::string& cases, const std::string& reference) {
  CaseFile file = readCaseFile(cases);
  const auto references = readReferenceFile(reference);
  AccuracySet set;
  for (std::size_t i = 0; i < file.shapes.size(); ++i)
    set.shapes.push_back(std::make_unique<report::ReportShape>(
        report::ReportShape{std::move(file.shapes[i]), std::move(file.points[i])}));
  std::map<std::string, std::size_t> index;
  std::map<std::string, int> tracks;
  for (const Case& c : file.cases) {
    const auto found = references.find(c.id);
    if (found == references.end())
      throw robots::InputError(
          reference, 0, fmt::format("has no line for case {}; one line a case is expected", c.id));
    AccuracyFamily& family = familyOf(set, index, c);
    family.cases.push_back(caseOf(set, c, found->second));
    family.cases.back().track =
        tracks.emplace(c.family + " " + c.part, static_cast<int>(tracks.size())).first->second;
  }
  return set;
}

/// Only the families whose names hold one of `words`; none given: all. Throws robots::InputError
/// when there is none.
void keepFamilies(AccuracySet& set, const std::vector<std::string>& words) {
  if (words.empty()) return;
  std::vector<std::string> names;
  for (const AccuracyFamily& family : set.families) names.push_back(family.name);
  const auto unwanted = [&](const AccuracyFamily& f) {
    return std::none_of(words.begin(), words.end(), [&](const std::string& word) {
      return f.name.find(word) != std::string::npos;
    });
  };
  set.families.erase(std::remove_if(set.families.begin(), set.families.end(), unwanted),
                     set.families.end());
  if (set.families.empty())
    throw robots::InputError(
        "--family", 0,
        fmt::format("'{}' is in no family's name; a part of one of these is expected: {}",
                    words.front(), fmt::join(names, ", ")));
}

/// Interval errors of ours: what the exit status is about.
int ownErrors(const std::vector<AccuracyRow>& rows) {
  int errors = 0;
  for (const AccuracyRow& r : rows)
    if (r.claims_bounds) errors += r.unsafe + r.failures() + r.wrong_verdict;
  return errors;
}

}  // namespace

int runReportAccuracy(report::AccuracyOptions options) {
  RivalReport out(options);
  const bool is_file = !options.cases.empty();
  if (!is_file) {
    // The families, without cases: what is asked for is known before minutes are spent on truth.
    AccuracySet names = report::makeAccuracySet(0, options.seed);
    keepFamilies(names, options.families);
  }
  AccuracySet set = is_file ? readSet(options.cases, options.reference)
                            : report::makeAccuracySet(options.per_family, options.seed,
                                                      [](const std::string& family) {
                                                        showProgress("truth of " + family);
                                                      });
  keepFamilies(set, options.families);

  const auto own = report::makeOwnEngines();
  const auto engines = out.engines(own, &report::Rivals::pairs);
  options.progress = out.begin(set.families.size());
  options.on_rows = out.keep("accuracy", report::accuracyRows);
  const std::vector<AccuracyRow> rows = report::measureAccuracy(set, engines, options);

  out.note(
      fmt::format("{}; one pinned core, medians of {} passes; each line: tolerances 1e-1 to 1e-15; "
                  "errors against "
                  "quadruple precision",
                  is_file ? options.cases : fmt::format("{} cases a family", options.per_family),
                  options.passes));
  out.write("accuracy", report::accuracyRows(rows));
  out.write("hard_cases", report::hardCaseRows(rows));
  out.draw({"accuracy.svg", "hard_cases.svg"});
  RivalReport::End end{report::accuracyTables(rows)};
  end.counted = "families";
  end.count = set.families.size();
  end.own_errors = ownErrors(rows);
  return out.end(end);
}

}  // namespace leeway::tools
