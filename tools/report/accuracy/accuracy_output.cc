#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/report/accuracy/accuracy_report.h"
#include "tools/report/base/csv_cell.h"

namespace leeway::tools::report {
namespace {

std::string toleranceCell(double value) {
  return std::isnan(value) ? std::string("default") : fmt::format("{:.0e}", value);
}
std::string countIf(bool applies, int count) {
  return applies ? std::to_string(count) : std::string();
}

/// Failures of one engine, of one row or summed.
struct Tally {
  bool tells_distance = true, claims_bounds = false;
  int cases = 0, wrong = 0, threw = 0, died = 0, endless = 0, not_a_number = 0, verdict = 0,
      unsafe = 0;

  void add(const AccuracyRow& r) {
    tells_distance = r.tells_distance, claims_bounds = r.claims_bounds;
    cases += r.cases, wrong += r.wrong, threw += r.threw, died += r.died, endless += r.endless,
        not_a_number += r.not_a_number, verdict += r.wrong_verdict, unsafe += r.unsafe;
  }
};

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

std::string timeTable(const std::vector<AccuracyRow>& rows,
                      const std::vector<std::string>& engines) {
  std::string text = fmt::format("{:<22}", "ns a query, / FCL");
  for (const std::string& engine : engines) text += fmt::format(" {:>15}", engine);
  text += '\n';
  for (const AccuracyRow* family : familiesOf(rows)) {
    text += fmt::format("{:<22}", family->family);
    const AccuracyRow* yardstick = defaultRow(rows, family->family, kYardstick);
    for (const std::string& engine : engines) {
      const AccuracyRow* row = defaultRow(rows, family->family, engine);
      if (row == nullptr || std::isnan(row->ns)) {
        text += fmt::format(" {:>15}", "-");
      } else if (yardstick == nullptr || std::isnan(yardstick->ns)) {
        text += fmt::format(" {:>9.1f}      ", row->ns);
      } else {
        text += fmt::format(" {:>9.1f} {:>5.3f}", row->ns, row->ns / yardstick->ns);
      }
    }
    text += '\n';
  }
  return text;
}

void appendTally(std::string& text, const std::string& name, const Tally& t) {
  const auto number = [](bool applies, int count) {
    return applies ? fmt::format("{:>9}", count) : fmt::format("{:>9}", "-");
  };
  text += fmt::format("{:<22} {:>7} {} {:>9} {:>9} {:>9} {:>9} {:>9} {}\n", name, t.cases,
                      number(t.tells_distance, t.wrong), t.threw, t.died, t.endless, t.not_a_number,
                      t.verdict, number(t.claims_bounds, t.unsafe));
}

/// Sums by engine over the families of `kinds`; `tightest`: at the last tolerance instead of the
/// default.
std::string wrongTable(const std::vector<AccuracyRow>& rows,
                       const std::vector<std::string>& engines, const char* title,
                       const std::vector<FamilyKind>& kinds) {
  std::string text =
      fmt::format("\n{:<22} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", title, "cases",
                  "wrong", "threw", "died", "endless", "NaN", "verdict", "unsafe");
  for (const std::string& engine : engines) {
    Tally tally;
    for (const AccuracyRow& r : rows)
      if (r.engine == engine && std::isnan(r.tolerance) &&
          std::find(kinds.begin(), kinds.end(), r.kind) != kinds.end())
        tally.add(r);
    if (tally.cases > 0) appendTally(text, engine, tally);
  }
  return text;
}

}  // namespace

std::string accuracyCsv(const std::vector<AccuracyRow>& rows) {
  std::string text =
      "family,kind,engine,tolerance,cases,answered,failures,wrong,wrong_verdict,unsafe,"
      "ns,ns_low,ns_high,error_median,error_95,error_max\n";
  for (const AccuracyRow& r : rows)
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", r.family,
                        toString(r.kind), r.engine, toleranceCell(r.tolerance), r.cases, r.answered,
                        r.failures(), countIf(r.tells_distance, r.wrong), r.wrong_verdict,
                        countIf(r.claims_bounds, r.unsafe), csvCell(r.ns), csvCell(r.ns_low),
                        csvCell(r.ns_high), csvCell(r.error_median), csvCell(r.error_95),
                        csvCell(r.error_max));
  return text;
}

std::string hardCasesCsv(const std::vector<AccuracyRow>& rows) {
  std::string text =
      "family,kind,engine,tolerance,cases,wrong,exceptions,aborts,endless,nan,wrong_verdict,"
      "unsafe\n";
  // The last of several tolerances is the tightest.
  std::map<std::pair<std::string, std::string>, const AccuracyRow*> last;
  for (const AccuracyRow& r : rows) last[{r.family, r.engine}] = &r;
  for (const AccuracyRow& r : rows) {
    if (!std::isnan(r.tolerance) && last.at({r.family, r.engine}) != &r) continue;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", r.family, toString(r.kind),
                        r.engine, toleranceCell(r.tolerance), r.cases,
                        countIf(r.tells_distance, r.wrong), r.threw, r.died, r.endless,
                        r.not_a_number, r.wrong_verdict, countIf(r.claims_bounds, r.unsafe));
  }
  return text;
}

std::string accuracyTable(const std::vector<AccuracyRow>& rows) {
  const std::vector<std::string> engines = enginesOf(rows);
  return timeTable(rows, engines) + wrongTable(rows, engines, "hard cases", {FamilyKind::kHard}) +
         wrongTable(rows, engines, "all other cases",
                    {FamilyKind::kOrdinary, FamilyKind::kOverlap, FamilyKind::kCoherent});
}

Figure accuracyFigure(const std::vector<AccuracyRow>& rows, const std::vector<FamilyKind>& kinds,
                      const std::string& title, const std::string& note) {
  Figure figure;
  figure.title = title;
  figure.note = note;
  figure.columns = 4;
  const bool alone =
      std::all_of(rows.begin(), rows.end(), [](const AccuracyRow& r) { return r.claims_bounds; });
  for (const AccuracyRow* family : familiesOf(rows)) {
    if (std::find(kinds.begin(), kinds.end(), family->kind) == kinds.end()) continue;
    PlotPanel panel;
    panel.title = family->family;
    panel.x = {"largest error / sizes", AxisScale::kLogarithmic, 1e-17, 1};
    panel.y = {"ns a query", AxisScale::kLogarithmic};
    for (const std::string& engine : enginesOf(rows)) {
      PlotSeries series;
      series.name = engine;
      const auto belongs = [&](const AccuracyRow& r) {
        return r.family == family->family && r.engine == engine && r.tells_distance;
      };
      // Engines without tolerances have one point; the others have a point for each decade.
      const bool decades = std::any_of(rows.begin(), rows.end(), [&](const AccuracyRow& r) {
        return belongs(r) && !std::isnan(r.tolerance);
      });
      for (const AccuracyRow& r : rows)
        if (belongs(r) && std::isnan(r.tolerance) != decades)
          series.points.push_back({r.error_max, r.ns, r.ns_low, r.ns_high});
      if (!series.points.empty()) panel.series.push_back(std::move(series));
    }
    // A single engine has no comparison to show; its figures are in the table.
    if (panel.series.size() > 1 || alone) figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace leeway::tools::report
