#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "tools/report/base/statistics.h"
#include "tools/report/clearance/clearance_report.h"

namespace leeway::tools::report {
namespace {

/// Objective, planner, limit.
using Key = std::tuple<std::string, std::string, double>;
using Groups = std::map<Key, std::vector<const ClearanceRow*>>;

Groups grouped(const std::vector<ClearanceRow>& rows) {
  Groups groups;
  for (const ClearanceRow& row : rows)
    groups[{row.objective, row.planner, row.time}].push_back(&row);
  return groups;
}

double medianOf(const std::vector<const ClearanceRow*>& rows, double ClearanceRow::*value) {
  std::vector<double> values;
  for (const ClearanceRow* row : rows)
    if (row->solved() && row->*value == row->*value) values.push_back(row->*value);
  return median(values);
}

}  // namespace

std::string clearanceCsv(const std::vector<ClearanceRow>& rows) {
  std::string text =
      "problem,planner,objective,seed,time_s,status,took_s,least_m,integral,length,colliding,"
      "unsound\n";
  for (const ClearanceRow& r : rows)
    text += fmt::format("\"{}\",\"{}\",{},{},{:g},{},{:.9f},{:.17g},{:.17g},{:.17g},{},{}\n",
                        r.problem, r.planner, r.objective, r.seed, r.time, r.status, r.took,
                        r.least, r.integral, r.length, r.colliding ? 1 : 0, r.unsound ? 1 : 0);
  return text;
}

std::string clearanceTable(const std::vector<ClearanceRow>& rows) {
  std::string text = fmt::format("{:<9} {:<20} {:>8} {:>5} {:>6} {:>8} {:>9} {:>9} {:>9} {:>8}\n",
                                 "objective", "planner", "limit s", "runs", "solved", "left out",
                                 "colliding", "least mm", "integral", "length");
  for (const auto& [key, group] : grouped(rows)) {
    const auto count = [&of = group](auto&& what) {  // (clang 14 cannot capture structured
                                                     // bindings)
      return std::count_if(of.begin(), of.end(),
                           [&](const ClearanceRow* row) { return what(*row); });
    };
    text += fmt::format("{:<9} {:<20} {:>8g} {:>5} {:>6} {:>8} {:>9} {:>9.2f} {:>9.4f} {:>8.3f}\n",
                        std::get<0>(key), std::get<1>(key), std::get<2>(key), group.size(),
                        count([](const ClearanceRow& r) { return r.solved(); }),
                        count([](const ClearanceRow& r) { return r.status == "left out"; }),
                        count([](const ClearanceRow& r) { return r.colliding; }),
                        1e3 * medianOf(group, &ClearanceRow::least),
                        medianOf(group, &ClearanceRow::integral),
                        medianOf(group, &ClearanceRow::length));
  }
  return text;
}

Figure clearanceFigure(const std::vector<ClearanceRow>& rows, const std::string& note) {
  Figure figure;
  figure.title = "Clearance from the world against time";
  figure.note = note;
  figure.columns = 2;
  const Groups groups = grouped(rows);
  for (const bool integral : {false, true}) {
    PlotPanel panel;
    panel.title = integral ? "integral of the hinge, median (less is better)"
                           : "least clearance, median (more is better)";
    panel.x.label = "limit [s]";
    panel.y.label = integral ? "integral" : "least clearance [mm]";
    panel.y.scale = AxisScale::kLinear;
    panel.y.lower = 0;
    for (const auto& [key, group] : groups) {
      if (std::get<0>(key) != (integral ? "integral" : "least")) continue;
      if (panel.series.empty() || panel.series.back().name != std::get<1>(key)) {
        panel.series.emplace_back();
        panel.series.back().name = std::get<1>(key);
      }
      const double value = integral ? medianOf(group, &ClearanceRow::integral)
                                    : 1e3 * medianOf(group, &ClearanceRow::least);
      panel.series.back().points.push_back({std::get<2>(key), value});
    }
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

}  // namespace leeway::tools::report
