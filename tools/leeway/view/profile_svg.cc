#include "tools/leeway/view/profile_svg.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/leeway/view/plot.h"

namespace leeway::tools {
namespace {

constexpr double kMillimetres = 1e3;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// A clearance in millimetres; NaN, which breaks the line, for one that is not finite.
double shown(double clearance) {
  return std::isfinite(clearance) ? clearance * kMillimetres : kNothing;
}

}  // namespace

std::string profileSvg(const std::string& title, const std::string& note,
                       const view::Timeline& timeline, double margin) {
  const auto series = [](const char* name) {
    PlotSeries made{.name = name, .points = {}, .marker = false};
    return made;
  };
  PlotSeries proven = series("proven"), world = series("from the world"),
             self = series("from itself"), margins = series("margin");
  margins.dashed = true;
  double lowest = 0;  // the axis holds 0, so that no small change looks like a large one
  const auto& moments = timeline.moments;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    world.points.push_back({moments[i].time, shown(moments[i].world.clearance.upper)});
    self.points.push_back({moments[i].time, shown(moments[i].self.clearance.upper)});
    for (const PlotSeries* measured : {&world, &self})
      if (std::isfinite(measured->points.back().y))
        lowest = std::min(lowest, measured->points.back().y);
    if (i >= timeline.stretches.size()) continue;
    const double lower = shown(timeline.stretches[i].lower);
    proven.points.push_back({moments[i].time, lower});
    proven.points.push_back({moments[i + 1].time, lower});
    if (std::isfinite(lower)) lowest = std::min(lowest, lower);
  }
  if (std::isfinite(margin)) {
    for (const view::Moment* end : {&moments.front(), &moments.back()})
      margins.points.push_back({end->time, shown(margin)});
    lowest = std::min(lowest, shown(margin));
  }
  Figure figure;
  figure.title = title;
  figure.note = note;
  figure.columns = 1;
  figure.panel_width = 680;
  figure.panels.push_back(
      {.title = "",
       .x = {.label = "time [s]", .scale = AxisScale::kLinear},
       .y = {.label = "clearance [mm]", .scale = AxisScale::kLinear, .lower = lowest},
       .series = {proven, world, self, margins}});
  return toSvg(figure);
}

}  // namespace leeway::tools
