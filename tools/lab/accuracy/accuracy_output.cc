#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/lab/accuracy/accuracy_report.h"

namespace leeway::tools::report {
namespace {

Table::Cell toleranceCell(double value) {
  return std::isnan(value) ? std::string("default") : fmt::format("{:.0e}", value);
}

std::vector<std::string> enginesOf(const std::vector<AccuracyRow>& rows) {
  std::vector<std::string> names;
  for (const AccuracyRow& r : rows)
    if (std::find(names.begin(), names.end(), r.engine) == names.end()) names.push_back(r.engine);
  return names;
}

/// A family's row for an engine at default tolerance; null if the engine lacks the pair of types.
const AccuracyRow* defaultRow(const std::vector<AccuracyRow>& rows, const std::string& family,
                              const std::string& engine) {
  for (const AccuracyRow& r : rows)
    if (r.family == family && r.engine == engine && std::isnan(r.tolerance)) return &r;
  return nullptr;
}

std::vector<const AccuracyRow*> familiesOf(const std::vector<AccuracyRow>& rows) {
  std::vector<const AccuracyRow*> first;
  for (const AccuracyRow& r : rows)
    if (first.empty() || first.back()->family != r.family) first.push_back(&r);
  return first;
}

constexpr const char* kYardstick = "FCL libccd";

/// Failures of each engine at default tolerance, summed over the families of `kinds`.
Table failures(const std::vector<AccuracyRow>& rows, const char* title,
               const std::vector<FamilyKind>& kinds) {
  Table table({title, "cases", "wrong", "threw", "died", "endless", "NaN", "verdict", "unsafe"});
  for (const std::string& engine : enginesOf(rows)) {
    AccuracyRow sum;
    for (const AccuracyRow& r : rows) {
      if (r.engine != engine || !std::isnan(r.tolerance) ||
          std::find(kinds.begin(), kinds.end(), r.kind) == kinds.end())
        continue;
      sum.tells_distance = r.tells_distance, sum.claims_bounds = r.claims_bounds;
      sum.cases += r.cases, sum.wrong += r.wrong, sum.threw += r.threw, sum.died += r.died,
          sum.endless += r.endless, sum.not_a_number += r.not_a_number,
          sum.wrong_verdict += r.wrong_verdict, sum.unsafe += r.unsafe;
    }
    if (sum.cases == 0) continue;
    table.add({engine, sum.cases, Table::Cell::onlyIf(sum.tells_distance, sum.wrong), sum.threw,
               sum.died, sum.endless, sum.not_a_number, sum.wrong_verdict,
               Table::Cell::onlyIf(sum.claims_bounds, sum.unsafe)});
  }
  return table;
}

}  // namespace

Table accuracyRows(const std::vector<AccuracyRow>& rows) {
  Table table({"family", "kind", "engine", "tolerance", "cases", "answered", "failures", "wrong",
               "wrong_verdict", "unsafe", "ns", "ns_low", "ns_high", "error_median", "error_95",
               "error_max"});
  for (const AccuracyRow& r : rows)
    table.add({r.family, toString(r.kind), r.engine, toleranceCell(r.tolerance), r.cases,
               r.answered, r.failures(), Table::Cell::onlyIf(r.tells_distance, r.wrong),
               r.wrong_verdict, Table::Cell::onlyIf(r.claims_bounds, r.unsafe), r.ns, r.ns_low,
               r.ns_high, r.error_median, r.error_95, r.error_max});
  return table;
}

Table hardCaseRows(const std::vector<AccuracyRow>& rows) {
  Table table({"family", "kind", "engine", "tolerance", "cases", "wrong", "exceptions", "aborts",
               "endless", "nan", "wrong_verdict", "unsafe"});
  // The last of several tolerances is the tightest.
  std::map<std::pair<std::string, std::string>, const AccuracyRow*> last;
  for (const AccuracyRow& r : rows) last[{r.family, r.engine}] = &r;
  for (const AccuracyRow& r : rows) {
    if (!std::isnan(r.tolerance) && last.at({r.family, r.engine}) != &r) continue;
    table.add({r.family, toString(r.kind), r.engine, toleranceCell(r.tolerance), r.cases,
               Table::Cell::onlyIf(r.tells_distance, r.wrong), r.threw, r.died, r.endless,
               r.not_a_number, r.wrong_verdict, Table::Cell::onlyIf(r.claims_bounds, r.unsafe)});
  }
  return table;
}

std::vector<Table> accuracyTables(const std::vector<AccuracyRow>& rows) {
  const std::vector<std::string> engines = enginesOf(rows);
  std::vector<Table::Column> columns = {"ns a query"};
  for (const std::string& engine : engines) {
    columns.emplace_back(engine, ".1f");
    columns.emplace_back("/ FCL", ".3f");
  }
  Table times(std::move(columns));
  for (const AccuracyRow* family : familiesOf(rows)) {
    std::vector<Table::Cell> cells = {family->family};
    const AccuracyRow* yardstick = defaultRow(rows, family->family, kYardstick);
    for (const std::string& engine : engines) {
      const AccuracyRow* row = defaultRow(rows, family->family, engine);
      const double ns = row == nullptr ? std::nan("") : row->ns;
      cells.emplace_back(ns);
      cells.emplace_back(yardstick == nullptr ? std::nan("") : ns / yardstick->ns);
    }
    times.add(std::move(cells));
  }
  return {times, failures(rows, "hard cases", {FamilyKind::kHard}),
          failures(rows, "all other cases",
                   {FamilyKind::kOrdinary, FamilyKind::kOverlap, FamilyKind::kCoherent})};
}

}  // namespace leeway::tools::report
