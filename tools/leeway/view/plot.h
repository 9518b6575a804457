#pragma once

#include <limits>
#include <string>
#include <vector>

namespace leeway::tools {

/// One measured point. `low` and `high` are the ends of an error bar in y; NaN if there is none.
struct PlotPoint {
  double x = 0, y = 0;
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// Points that belong together. Series of one name share colour, marker and legend entry in all
/// panels of a figure, in order of first appearance.
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
  bool line = true;     ///< joins the points in the order given
  bool marker = true;   ///< draws a marker at each of them
  bool dashed = false;  ///< and grey: limits and models, not measurements
};

enum class AxisScale { kLogarithmic, kLinear };

/// An axis. With `lower` or `upper` NaN, the end is taken from the data. Points outside (on a
/// logarithmic axis also those <= 0) are drawn hollow on the border, so that none is lost.
struct PlotAxis {
  std::string label;  ///< with the unit
  AxisScale scale = AxisScale::kLogarithmic;
  double lower = std::numeric_limits<double>::quiet_NaN();
  double upper = std::numeric_limits<double>::quiet_NaN();
};

struct PlotPanel {
  std::string title;
  PlotAxis x, y;
  std::vector<PlotSeries> series;
};

/// Panels in rows of `columns`, one legend above them all.
struct Figure {
  std::string title;
  std::string note;  ///< one line below the title: machine, date, method
  int columns = 3;
  double panel_width = 300, panel_height = 210;  ///< of the plotting area [px]
  std::vector<PlotPanel> panels;
};

/// Positions of labelled and of unlabelled ticks between two ends, ascending. O(ticks).
struct PlotTicks {
  std::vector<double> labelled, unlabelled;
};
/// Decades over a wide range, 1-2-5 over a narrow one; at least two labels if upper > lower > 0.
PlotTicks logarithmicTicks(double lower, double upper);
/// Multiples of 1, 2 or 5 times a power of ten, about five of them.
PlotTicks linearTicks(double lower, double upper);

/// A complete SVG 1.1 document in UTF-8; equal figures give equal bytes. It is legible on light and
/// dark pages, because it draws its own background, a dark one if the reader prefers that. Points
/// that are NaN are omitted and break the line. O(points).
std::string toSvg(const Figure& figure);

}  // namespace leeway::tools
