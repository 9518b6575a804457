#include "tools/leeway/view/profile_svg.h"

#include <cmath>
#include <limits>

#include "tools/leeway/view/plot.h"

namespace leeway::tools {
namespace {

constexpr double kMillimetres = 1e3;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// Adds a step from `begin` to `end`. A value that is not finite becomes NaN, which breaks the
/// line.
void addStep(PlotSeries& series, const ProfileStretch& stretch, double value) {
  const double y = std::isfinite(value) ? value * kMillimetres : kNothing;
  series.points.push_back({stretch.begin, y});
  series.points.push_back({stretch.end, y});
}

}  // namespace

std::string profileSvg(const std::string& title, const std::string& note, const std::string& axis,
                       const std::vector<ProfileStretch>& stretches, double margin) {
  PlotSeries lower{.name = "proven on the whole stretch", .points = {}, .marker = false};
  PlotSeries upper{.name = "met on the stretch", .points = {}, .marker = false};
  PlotSeries margins{.name = "margin", .points = {}, .marker = false, .dashed = true};
  double lowest = 0;  // the axis includes 0, so that small changes look small
  for (const ProfileStretch& stretch : stretches) {
    addStep(lower, stretch, stretch.lower);
    addStep(upper, stretch, stretch.upper);
    if (std::isfinite(stretch.lower)) lowest = std::min(lowest, stretch.lower * kMillimetres);
  }
  if (!stretches.empty() && std::isfinite(margin)) {
    const ProfileStretch whole{stretches.front().begin, stretches.back().end, margin, margin};
    addStep(margins, whole, margin);
    lowest = std::min(lowest, margin * kMillimetres);
  }
  Figure figure;
  figure.title = title;
  figure.note = note;
  figure.columns = 1;
  figure.panel_width = 680;
  figure.panels.push_back(
      {.title = "",
       .x = {.label = axis, .scale = AxisScale::kLinear},
       .y = {.label = "clearance [mm]", .scale = AxisScale::kLinear, .lower = lowest},
       .series = {lower, upper, margins}});
  return toSvg(figure);
}

}  // namespace leeway::tools
