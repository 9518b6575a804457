#include <algorithm>
#include <limits>

#include "tools/lab/motion/motion_report.h"

namespace leeway::tools::report {
namespace {

/// One series for each engine; x is the family's place in the rows' order, from 1.
template <typename Point>
PlotPanel byFamily(const std::vector<MotionRow>& rows, const std::string& title, const PlotAxis& y,
                   const Point& point) {
  PlotPanel panel;
  panel.title = title;
  panel.x = {"family, in the order of the table", AxisScale::kLinear};
  panel.y = y;
  std::vector<std::string> families;
  for (const MotionRow& r : rows) {
    if (families.empty() || families.back() != r.family) families.push_back(r.family);
    auto series = std::find_if(panel.series.begin(), panel.series.end(),
                               [&](const PlotSeries& s) { return s.name == r.engine; });
    if (series == panel.series.end()) {
      panel.series.push_back({r.engine, {}});
      series = panel.series.end() - 1;
      series->line = false;
    }
    series->points.push_back(point(static_cast<double>(families.size()), r));
  }
  return panel;
}

}  // namespace

Table motionRows(const std::vector<MotionRow>& rows) {
  Table table({"family", "engine", "cases", "hits", "misses", "false_hits", "wrong_starts",
               "unsafe", "undecided", "threw", "died", "endless", "time_error_median",
               "time_error_max", "ns_median", "ns_95", "ns_max"});
  for (const MotionRow& r : rows)
    table.add({r.family, r.engine, r.cases, r.hits, r.misses, r.false_hits, r.wrong_starts,
               Table::Cell::onlyIf(r.claims_bounds, r.unsafe), r.undecided, r.threw, r.died,
               r.endless, r.error_median, r.error_max, r.ns_median, r.ns_95, r.ns_max});
  return table;
}

Table motionTable(const std::vector<MotionRow>& rows) {
  Table table({"family", "engine", "cases", "hits", "misses", "false", "start", "unsafe", "open",
               "failed", "error 50 %:.3g", "max:.3g", "us 50 %:.3g", "95 %:.3g"},
              2);
  for (const MotionRow& r : rows)
    table.add({r.family, r.engine, r.cases, r.hits, r.misses, r.false_hits, r.wrong_starts,
               Table::Cell::onlyIf(r.claims_bounds, r.unsafe), r.undecided, r.failures(),
               r.error_median, r.error_max, r.ns_median / 1000, r.ns_95 / 1000});
  return table;
}

Figure motionFigure(const std::vector<MotionRow>& rows, const std::string& note) {
  Figure figure;
  figure.title = "Time of contact: cost and errors by family";
  figure.note = note;
  figure.columns = 2;
  figure.panels.push_back(
      byFamily(rows, "a query, median and 95 %", {"us"}, [](double x, const MotionRow& r) {
        return PlotPoint{x, r.ns_median / 1000, r.ns_median / 1000, r.ns_95 / 1000};
      }));
  const auto share = [](int part, int whole) {
    return whole == 0 ? std::numeric_limits<double>::quiet_NaN()
                      : 100.0 * part / static_cast<double>(whole);
  };
  figure.panels.push_back(byFamily(rows, "misses", {"% of hits", AxisScale::kLinear, 0, 100},
                                   [&](double x, const MotionRow& r) {
                                     return PlotPoint{x, share(r.misses, r.hits)};
                                   }));
  figure.panels.push_back(byFamily(rows, "false hits", {"% of frees", AxisScale::kLinear, 0, 100},
                                   [&](double x, const MotionRow& r) {
                                     return PlotPoint{x, share(r.false_hits, r.cases - r.hits)};
                                   }));
  figure.panels.push_back(
      byFamily(rows, "error of the time of contact, median and largest", {"share of the motion"},
               [](double x, const MotionRow& r) {
                 return PlotPoint{x, r.error_median, r.error_median, r.error_max};
               }));
  return figure;
}

}  // namespace leeway::tools::report
