#pragma once

#include <limits>
#include <string>
#include <vector>

namespace leeway::tools::report {

/// One measured point. `low` and `high` draw a bar over y from one to the other; NaN: none.
struct PlotPoint {
  double x = 0, y = 0;
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// Points that belong together. Series of the same name share colour, marker and legend entry over
/// all panels of a figure, in order of first appearance.
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
  bool line = true;     ///< joins the points in the order given
  bool marker = true;   ///< draws a marker at each of them
  bool dashed = false;  ///< and grey: for limits and models rather than measurements
};

enum class AxisScale { kLogarithmic, kLinear };

/// An axis. Where `lower` or `upper` is NaN the data decide. Points outside (on a logarithmic axis
/// also those that are 0 or negative) are drawn on the border, hollow, so that none is missing.
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
  std::string note;  ///< one line below the title: machine, date, what was measured how
  int columns = 3;
  double panel_width = 300, panel_height = 210;  ///< of the plotting area [px]
  std::vector<PlotPanel> panels;
};

/// Positions of labelled and of unlabelled ticks between two ends, ascending. O(ticks).
struct PlotTicks {
  std::vector<double> labelled, unlabelled;
};
/// Decades where there are many, 1-2-5 where there are few (at least two labels as long as
/// upper > lower > 0).
PlotTicks logarithmicTicks(double lower, double upper);
/// Multiples of 1, 2 or 5 times a power of ten, about five of them.
PlotTicks linearTicks(double lower, double upper);

/// A whole SVG 1.1 document, UTF-8, the same bytes for the same figure. Readable on light and dark
/// pages: it has a background of its own, and another one where the reader prefers dark.
/// Points that are NaN are left out and break the line. O(points).
std::string toSvg(const Figure& figure);

}  // namespace leeway::tools::report
