#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "tools/report/growth/growth_report.h"
#include "tools/report/growth/growth_worlds.h"

namespace leeway::tools::report {
namespace {

struct Quantity {
  const char* label;
  double (*of)(const GrowthRow&);
};

constexpr std::array<Quantity, 5> kQuantities = {{
    {"making [ms]", [](const GrowthRow& r) { return 1e3 * r.make_s; }},
    {"a change [ms]", [](const GrowthRow& r) { return 1e3 * r.change_s; }},
    {"memory [MB]", [](const GrowthRow& r) { return 1e-6 * r.bytes; }},
    {"an edge [us]", [](const GrowthRow& r) { return r.edge_us; }},
    {"planning [ms]", [](const GrowthRow& r) { return 1e3 * r.plan_s; }},
}};

}  // namespace

std::string growthCsv(const std::vector<GrowthRow>& rows) {
  std::string text = "family,count,engine,status,make_s,change_s,bytes,edges,edge_us,plan_s\n";
  for (const GrowthRow& r : rows)
    text += fmt::format("{},{},\"{}\",{},{:.6g},{:.6g},{:.0f},{},{:.6g},{:.6g}\n", r.family,
                        r.count, r.engine, r.status, r.make_s, r.change_s, r.bytes, r.edges,
                        r.edge_us, r.plan_s);
  return text;
}

std::string growthTable(const std::vector<GrowthRow>& rows) {
  std::string text = fmt::format("{:<10} {:>9} {:<8}", "", "count", "engine");
  for (const Quantity& quantity : kQuantities) text += fmt::format(" {:>13}", quantity.label);
  text += "  status\n";
  for (const GrowthRow& r : rows) {
    text += fmt::format("{:<10} {:>9} {:<8}", r.family, r.count, r.engine);
    for (const Quantity& quantity : kQuantities) {
      const double value = quantity.of(r);
      text += fmt::format(" {:>13}", value > 0 ? fmt::format("{:.3f}", value) : "-");
    }
    text += fmt::format("  {}\n", r.status);
  }
  return text;
}

Figure growthFigure(const std::vector<GrowthRow>& rows, const std::string& note) {
  Figure figure;
  figure.title = "Growth of worlds and robots";
  figure.note = note;
  figure.columns = static_cast<int>(kQuantities.size());
  for (const std::string& family : growthFamilies()) {
    for (const Quantity& quantity : kQuantities) {
      PlotPanel panel;
      panel.title = family;
      panel.x.label = family;
      panel.y.label = quantity.label;
      for (const GrowthRow& r : rows) {
        if (r.family != family || !(quantity.of(r) > 0)) continue;
        const auto same = [&](const PlotSeries& series) { return series.name == r.engine; };
        auto series = std::find_if(panel.series.begin(), panel.series.end(), same);
        if (series == panel.series.end())
          series = panel.series.insert(series, PlotSeries{r.engine, {}});
        series->points.push_back({static_cast<double>(r.count), quantity.of(r)});
      }
      if (!panel.series.empty()) figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

}  // namespace leeway::tools::report
