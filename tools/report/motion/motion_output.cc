#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/report/base/csv_cell.h"
#include "tools/report/motion/motion_report.h"

namespace leeway::tools::report {
namespace {

/// Three digits; "-" for NaN.
std::string digits(double value) {
  return std::isnan(value) ? std::string("-") : fmt::format("{:.3g}", value);
}

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

std::string motionCsv(const std::vector<MotionRow>& rows) {
  std::string text =
      "family,engine,cases,hits,misses,false_hits,wrong_starts,unsafe,undecided,threw,died,endless,"
      "time_error_median,time_error_max,ns_median,ns_95,ns_max\n";
  for (const MotionRow& r : rows)
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", r.family, r.engine,
                        r.cases, r.hits, r.misses, r.false_hits, r.wrong_starts,
                        r.claims_bounds ? std::to_string(r.unsafe) : std::string(), r.undecided,
                        r.threw, r.died, r.endless, csvCell(r.error_median), csvCell(r.error_max),
                        csvCell(r.ns_median), csvCell(r.ns_95), csvCell(r.ns_max));
  return text;
}

std::string motionTable(const std::vector<MotionRow>& rows) {
  std::string text;
  const MotionRow* previous = nullptr;
  for (const MotionRow& r : rows) {
    if (previous == nullptr || previous->family != r.family)
      text += fmt::format(
          "\n{:<24} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>9} {:>9} {:>9} {:>9}\n",
          fmt::format("{}, {} hits", r.family, r.hits), "cases", "misses", "false", "start",
          "unsafe", "open", "failed", "error 50%", "max", "us 50%", "95%");
    previous = &r;
    text +=
        fmt::format("{:<24} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>9} {:>9} {:>9} {:>9}\n",
                    r.engine, r.cases, r.misses, r.false_hits, r.wrong_starts,
                    r.claims_bounds ? std::to_string(r.unsafe) : "-", r.undecided, r.failures(),
                    digits(r.error_median), digits(r.error_max), digits(r.ns_median / 1000),
                    digits(r.ns_95 / 1000));
  }
  return text;
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
