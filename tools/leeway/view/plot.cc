#include "tools/leeway/view/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace leeway::tools {
namespace {

// Lengths in px. Gaps leave room for tick labels and axis names.
constexpr double kLeft = 64, kBottom = 52, kTop = 28, kRight = 18, kMargin = 14;
constexpr double kTickLabel = 11, kLabel = 12, kTitle = 13, kFigureTitle = 17, kNote = 11.5;
constexpr double kLegendRow = 20, kLegendText = 12.5, kLegendKey = 30, kLegendGap = 22;
constexpr double kTitleLine = 16;  // of a title in several
/// Bold text is as much wider.
constexpr double kBold = 1.1;
/// Mean width of a character relative to the font size, slightly generous.
constexpr double kCharacter = 0.58;

/// Eight colours of medium lightness, legible on white and near-black. Neighbours differ for
/// colour-blind readers; markers differ as well.
constexpr std::array<const char*, 8> kColours = {"#1f78d1", "#e07b00", "#139a6b", "#c04f9c",
                                                 "#d6403f", "#17a0b8", "#9a8400", "#7c7c86"};

/// For limits and models.
constexpr const char* kNeutral = "#7c7c86";

constexpr const char* kStyle = R"(<style>
.page { fill: #ffffff } .area { fill: #fafafa; stroke: #9a9aa2 } .grid { stroke: #dedee4 }
.minor { stroke: #ededf1 } .text { fill: #24242a } .soft { fill: #5c5c66 } .hollow { fill: #fafafa }
text { font-family: "DejaVu Sans", "Liberation Sans", Arial, sans-serif }
@media (prefers-color-scheme: dark) {
.page { fill: #17171b } .area { fill: #1e1e24; stroke: #6f6f7a } .grid { stroke: #34343d }
.minor { stroke: #292930 } .text { fill: #ececf2 } .soft { fill: #a9a9b5 } .hollow { fill: #1e1e24 }
}
</style>
)";

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

/// Counts characters: continuation bytes of UTF-8 are skipped.
double textWidth(const std::string& text, double size) {
  const auto letters = std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  });
  return kCharacter * size * static_cast<double>(letters);
}

std::string textElement(double x, double y, const char* anchor, double size, const char* css,
                        const std::string& content, const std::string& attributes = "") {
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{}\" class=\"{}\"{}>{}"
      "</text>\n",
      x, y, anchor, size, css, attributes, escaped(content));
}

/// Attributes that squeeze a text into a length, where it is longer.
std::string squeezed(const std::string& text, double size, double length) {
  if (textWidth(text, size) <= length) return {};
  return fmt::format(" textLength=\"{:.1f}\" lengthAdjust=\"spacingAndGlyphs\"", length);
}

/// A text in lines of at most `length`, broken between words.
std::vector<std::string> linesOf(const std::string& text, double size, double length) {
  std::vector<std::string> lines;
  std::string line;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string longer = line + (line.empty() ? "" : " ") + text.substr(at, end - at);
    if (!line.empty() && textWidth(longer, size) > length) {
      lines.push_back(line);
      line = text.substr(at, end - at);
    } else {
      line = longer;
    }
    at = end + 1;
  }
  lines.push_back(line);
  return lines;
}

std::string lineElement(double x1, double y1, double x2, double y2, const char* css) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1, x2,
      y2, css);
}

std::string superscript(int exponent) {
  static constexpr std::array<const char*, 10> kDigits = {"⁰", "¹", "²", "³", "⁴",
                                                          "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string result;
  for (const char c : std::to_string(exponent))
    result += c == '-' ? "⁻" : kDigits[static_cast<std::size_t>(c - '0')];
  return result;
}

/// 0.01 to 10000 in plain digits, the rest as powers of ten.
std::string tickLabel(double value, AxisScale scale) {
  if (value == 0) return "0";
  const double exponent = std::floor(std::log10(std::abs(value)) + 1e-9);
  if (scale == AxisScale::kLinear || (exponent >= -2 && exponent <= 4))
    return fmt::format("{:g}", value);
  const double factor = value / std::pow(10.0, exponent);
  const std::string power = "10" + superscript(static_cast<int>(exponent));
  return std::abs(factor - 1) < 1e-6 ? power : fmt::format("{:g}·{}", std::round(factor), power);
}

/// An axis with final ends: maps a value to a share of its length.
class Ruler {
 public:
  Ruler(const PlotAxis& axis, double data_lower, double data_upper) : scale_(axis.scale) {
    const bool logarithmic = scale_ == AxisScale::kLogarithmic;
    lower_ = std::isnan(axis.lower) ? data_lower : axis.lower;
    upper_ = std::isnan(axis.upper) ? data_upper : axis.upper;
    if (!(lower_ < upper_)) {
      // Without values or with a single value: adds room around it.
      const double middle = lower_ == upper_ ? lower_ : 1;
      lower_ = logarithmic ? middle / 2 : middle - 1;
      upper_ = logarithmic ? middle * 2 : middle + 1;
    }
    if (std::isnan(axis.lower)) lower_ = widened(lower_, -1);
    if (std::isnan(axis.upper)) upper_ = widened(upper_, +1);
  }

  bool usable(double value) const {
    return scale_ == AxisScale::kLinear ? std::isfinite(value) : !std::isnan(value);
  }
  /// 0 at the lower end, 1 at the upper; clamped.
  double share(double value) const { return std::clamp(unclamped(value), 0.0, 1.0); }
  bool inside(double value) const {
    const double s = unclamped(value);
    return s >= -1e-9 && s <= 1 + 1e-9;
  }
  PlotTicks ticks() const {
    return scale_ == AxisScale::kLinear ? linearTicks(lower_, upper_)
                                        : logarithmicTicks(lower_, upper_);
  }
  AxisScale scale() const { return scale_; }

 private:
  /// Adds space, so that no marker lies on the border by chance.
  double widened(double value, int side) const {
    if (scale_ == AxisScale::kLogarithmic) return side < 0 ? value / 1.25 : value * 1.25;
    if (side < 0 && value >= 0 && value < 0.3 * upper_) return 0;
    return value + side * 0.05 * (upper_ - lower_);
  }
  double unclamped(double value) const {
    if (scale_ == AxisScale::kLinear) return (value - lower_) / (upper_ - lower_);
    if (value <= 0) return -1;
    return std::log(value / lower_) / std::log(upper_ / lower_);
  }

  AxisScale scale_;
  double lower_, upper_;
};

Ruler rulerFor(const PlotPanel& panel, bool vertical) {
  const PlotAxis& axis = vertical ? panel.y : panel.x;
  double lower = HUGE_VAL, upper = -HUGE_VAL;
  const auto take = [&](double value) {
    if (!std::isfinite(value)) return;
    if (axis.scale == AxisScale::kLogarithmic && value <= 0) return;
    lower = std::min(lower, value), upper = std::max(upper, value);
  };
  for (const PlotSeries& series : panel.series) {
    for (const PlotPoint& p : series.points) {
      take(vertical ? p.y : p.x);
      if (vertical) take(p.low), take(p.high);
    }
  }
  return {axis, lower, upper};
}

/// One of six outlines around (x, y); hollow: a value beyond the border.
std::string markerElement(std::size_t style, double x, double y, bool hollow) {
  const char* colour = kColours[style % kColours.size()];
  const std::string paint =
      hollow ? fmt::format("class=\"hollow\" stroke=\"{}\" stroke-width=\"1.4\"", colour)
             : fmt::format("fill=\"{}\"", colour);
  const auto polygon = [&](std::initializer_list<std::array<double, 2>> corners) {
    std::string points;
    for (const auto& c : corners) points += fmt::format("{:.1f},{:.1f} ", x + c[0], y + c[1]);
    points.pop_back();
    return fmt::format("<polygon points=\"{}\" {}/>\n", points, paint);
  };
  switch (style % 6) {
    case 0:
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.4\" {}/>\n", x, y, paint);
    case 1:
      return polygon({{-3.1, -3.1}, {3.1, -3.1}, {3.1, 3.1}, {-3.1, 3.1}});
    case 2:
      return polygon({{0, -4.2}, {3.9, 2.9}, {-3.9, 2.9}});
    case 3:
      return polygon({{0, -4.4}, {4.4, 0}, {0, 4.4}, {-4.4, 0}});
    case 4:
      return polygon({{0, 4.2}, {3.9, -2.9}, {-3.9, -2.9}});
    default:
      return polygon({{-1.4, -4},
                      {1.4, -4},
                      {1.4, -1.4},
                      {4, -1.4},
                      {4, 1.4},
                      {1.4, 1.4},
                      {1.4, 4},
                      {-1.4, 4},
                      {-1.4, 1.4},
                      {-4, 1.4},
                      {-4, -1.4},
                      {-1.4, -1.4}});
  }
}

/// When the colours run out, dashes distinguish the following series.
std::string strokeAttributes(std::size_t style, bool dashed) {
  static constexpr std::array<const char*, 3> kBreaks = {"", "8 3", "2 3"};
  const std::string breaks = dashed ? "5 4" : kBreaks[style / kColours.size() % kBreaks.size()];
  return fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{}",
                     dashed ? kNeutral : kColours[style % kColours.size()], dashed ? 1.5 : 1.8,
                     breaks.empty() ? "" : " stroke-dasharray=\"" + breaks + "\"");
}

/// All series by name, in order of first appearance; the index is the style.
std::vector<const PlotSeries*> legendOf(const Figure& figure) {
  std::vector<const PlotSeries*> legend;
  for (const PlotPanel& panel : figure.panels)
    for (const PlotSeries& series : panel.series)
      if (std::none_of(legend.begin(), legend.end(),
                       [&](const PlotSeries* s) { return s->name == series.name; }))
        legend.push_back(&series);
  return legend;
}

class PanelDrawing {
 public:
  PanelDrawing(const Figure& figure, const PlotPanel& panel, double left, double top)
      : panel_(panel),
        left_(left),
        top_(top),
        width_(figure.panel_width),
        height_(figure.panel_height),
        x_(rulerFor(panel, false)),
        y_(rulerFor(panel, true)) {}

  /// A panel's title in lines that its column has room for.
  static std::vector<std::string> titleLines(const PlotPanel& panel, double width) {
    return linesOf(panel.title, kTitle * kBold, width + kRight);
  }

  std::string draw(const std::vector<const PlotSeries*>& legend) const {
    std::string svg = fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" class=\"area\"/>\n",
        left_, top_, width_, height_);
    svg += drawTicks();
    const std::vector<std::string> title = titleLines(panel_, width_);
    for (std::size_t i = 0; i < title.size(); ++i)
      svg += textElement(left_, top_ - 9 - kTitleLine * static_cast<double>(title.size() - 1 - i),
                         "start", kTitle, "text", title[i],
                         " font-weight=\"bold\"" + squeezed(title[i], kTitle, width_ + kRight));
    svg += textElement(left_ + width_ / 2, top_ + height_ + 36, "middle", kLabel, "soft",
                       panel_.x.label, squeezed(panel_.x.label, kLabel, width_ + kRight));
    svg += textElement(
        0, 0, "middle", kLabel, "soft", panel_.y.label,
        fmt::format(" transform=\"translate({:.1f} {:.1f}) rotate(-90)\"{}", left_ - 48,
                    top_ + height_ / 2, squeezed(panel_.y.label, kLabel, height_ + kTop)));
    // Backwards, so that the first series, the report's subject, is drawn on top.
    for (std::size_t i = panel_.series.size(); i-- > 0;) {
      const PlotSeries& series = panel_.series[i];
      const auto same = std::find_if(legend.begin(), legend.end(),
                                     [&](const PlotSeries* s) { return s->name == series.name; });
      svg += drawSeries(series, static_cast<std::size_t>(same - legend.begin()));
    }
    return svg;
  }

 private:
  double toX(double value) const { return left_ + width_ * x_.share(value); }
  double toY(double value) const { return top_ + height_ * (1 - y_.share(value)); }

  std::string drawTicks() const {
    std::string svg;
    const PlotTicks across = x_.ticks(), up = y_.ticks();
    const double bottom = top_ + height_;
    for (const double v : across.unlabelled)
      svg += lineElement(toX(v), top_, toX(v), bottom, "minor");
    for (const double v : up.unlabelled)
      svg += lineElement(left_, toY(v), left_ + width_, toY(v), "minor");
    // Labels that would overlap the previous one are omitted; their grid lines stay.
    double free_from = -HUGE_VAL;
    for (const double v : across.labelled) {
      svg += lineElement(toX(v), top_, toX(v), bottom, "grid");
      const std::string label = tickLabel(v, x_.scale());
      const double half = textWidth(label, kTickLabel) / 2;
      if (toX(v) - half < free_from) continue;
      free_from = toX(v) + half + 3;
      svg += textElement(toX(v), bottom + 16, "middle", kTickLabel, "text", label);
    }
    double free_below = HUGE_VAL;
    for (const double v : up.labelled) {
      svg += lineElement(left_, toY(v), left_ + width_, toY(v), "grid");
      if (toY(v) > free_below) continue;
      free_below = toY(v) - kTickLabel - 1;
      svg +=
          textElement(left_ - 6, toY(v) + 4, "end", kTickLabel, "text", tickLabel(v, y_.scale()));
    }
    return svg;
  }

  std::string drawSeries(const PlotSeries& series, std::size_t style) const {
    std::string svg, path;
    bool pen_down = false;
    for (const PlotPoint& p : series.points) {
      if (!x_.usable(p.x) || !y_.usable(p.y)) {
        pen_down = false;
        continue;
      }
      path += fmt::format("{}{:.1f} {:.1f}", pen_down ? " L" : "M", toX(p.x), toY(p.y));
      pen_down = true;
      if (!std::isnan(p.low) && !std::isnan(p.high))
        svg += fmt::format(
            "<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{0:.1f}\" y2=\"{2:.1f}\" {3} "
            "opacity=\"0.55\"/>\n",
            toX(p.x), toY(p.low), toY(p.high), strokeAttributes(style, false));
    }
    if (series.line && !path.empty())
      svg += fmt::format("<path d=\"{}\" {}/>\n", path, strokeAttributes(style, series.dashed));
    if (!series.marker) return svg;
    for (const PlotPoint& p : series.points) {
      if (!x_.usable(p.x) || !y_.usable(p.y)) continue;
      svg += markerElement(style, toX(p.x), toY(p.y), !x_.inside(p.x) || !y_.inside(p.y));
    }
    return svg;
  }

  const PlotPanel& panel_;
  double left_, top_, width_, height_;
  Ruler x_, y_;
};

/// Draws the legend with the required number of rows; returns its height.
double drawLegend(const std::vector<const PlotSeries*>& legend, double width, double top,
                  std::string& svg) {
  double x = kMargin, y = top + kLegendRow - 6;
  for (std::size_t i = 0; i < legend.size(); ++i) {
    const PlotSeries& series = *legend[i];
    const double needed = kLegendKey + textWidth(series.name, kLegendText);
    if (x > kMargin && x + needed > width - kMargin) x = kMargin, y += kLegendRow;
    if (series.line)
      svg += fmt::format("<path d=\"M{:.1f} {:.1f} L{:.1f} {:.1f}\" {}/>\n", x, y - 4, x + 22,
                         y - 4, strokeAttributes(i, series.dashed));
    if (series.marker) svg += markerElement(i, x + 11, y - 4, false);
    svg += textElement(x + kLegendKey, y, "start", kLegendText, "text", series.name);
    x += needed + kLegendGap;
  }
  return y - top + 14;
}

}  // namespace

PlotTicks logarithmicTicks(double lower, double upper) {
  PlotTicks ticks;
  if (!(lower > 0) || !(upper > lower) || !std::isfinite(upper)) return ticks;
  // The slack absorbs rounding, so that an end at a power of ten gets its tick.
  const int first = static_cast<int>(std::floor(std::log10(lower) + 1e-9));
  const int last = static_cast<int>(std::ceil(std::log10(upper) - 1e-9));
  const auto within = [&](double v) { return v >= lower * (1 - 1e-9) && v <= upper * (1 + 1e-9); };
  const int decades = last - first;
  const int step = decades > 24 ? 4 : decades > 9 ? 2 : 1;
  for (int k = first; k <= last; ++k) {
    const double power = std::pow(10.0, k);
    // Whole multiples of the step carry labels, independent of the first decade.
    if (within(power)) (k % step == 0 ? ticks.labelled : ticks.unlabelled).push_back(power);
    if (decades > 6) continue;
    for (int m = 2; m <= 9; ++m)
      if (within(m * power))
        ((m == 2 || m == 5) && decades <= 3 ? ticks.labelled : ticks.unlabelled)
            .push_back(m * power);
  }
  if (ticks.labelled.size() < 2) {
    // Less than a decade: label all of them, or the ends.
    ticks.labelled.insert(ticks.labelled.end(), ticks.unlabelled.begin(), ticks.unlabelled.end());
    ticks.unlabelled.clear();
    if (ticks.labelled.size() < 2) ticks.labelled = {lower, upper};
  }
  std::sort(ticks.labelled.begin(), ticks.labelled.end());
  return ticks;
}

PlotTicks linearTicks(double lower, double upper) {
  PlotTicks ticks;
  if (!(upper > lower) || !std::isfinite(lower) || !std::isfinite(upper)) return ticks;
  const double rough = (upper - lower) / 5;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = power * (rough / power < 1.5   ? 1
                               : rough / power < 3.5 ? 2
                               : rough / power < 7.5 ? 5
                                                     : 10);
  for (double k = std::ceil(lower / step - 1e-9); k * step <= upper + 1e-9 * step; k += 1)
    ticks.labelled.push_back(k == 0 ? 0 : k * step);
  return ticks;
}

std::string toSvg(const Figure& figure) {
  const auto columns = static_cast<std::size_t>(std::max(1, figure.columns));
  const std::size_t used = std::max<std::size_t>(1, std::min(columns, figure.panels.size()));
  const std::size_t rows = (figure.panels.size() + columns - 1) / columns;
  const double cell_width = kLeft + figure.panel_width + kRight;
  std::size_t title_lines = 1;
  for (const PlotPanel& panel : figure.panels)
    title_lines = std::max(title_lines, PanelDrawing::titleLines(panel, figure.panel_width).size());
  const double title_height = kTitleLine * static_cast<double>(title_lines - 1);
  const double cell_height = kTop + title_height + figure.panel_height + kBottom;
  const double width = 2 * kMargin + std::max({cell_width * static_cast<double>(used),
                                               textWidth(figure.title, kFigureTitle * 1.1),
                                               textWidth(figure.note, kNote)});

  std::string body;
  double y = kMargin;
  if (!figure.title.empty()) {
    body += textElement(kMargin, y + kFigureTitle, "start", kFigureTitle, "text", figure.title,
                        " font-weight=\"bold\"");
    y += kFigureTitle + 8;
  }
  if (!figure.note.empty()) {
    body += textElement(kMargin, y + kNote + 1, "start", kNote, "soft", figure.note);
    y += kNote + 10;
  }
  const std::vector<const PlotSeries*> legend = legendOf(figure);
  if (!legend.empty()) y += drawLegend(legend, width, y, body);
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const std::size_t row = i / columns, column = i % columns;
    const double left = kMargin + kLeft + cell_width * static_cast<double>(column);
    const double top = y + kTop + title_height + cell_height * static_cast<double>(row);
    body += PanelDrawing(figure, figure.panels[i], left, top).draw(legend);
  }
  const double height = y + cell_height * static_cast<double>(rows) + kMargin;
  return fmt::format(
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
             "viewBox=\"0 0 {0:.0f} {1:.0f}\">\n<title>{2}</title>\n",
             width, height, escaped(figure.title)) +
         kStyle +
         fmt::format("<rect width=\"{:.0f}\" height=\"{:.0f}\" class=\"page\"/>\n", width, height) +
         body + "</svg>\n";
}

}  // namespace leeway::tools
