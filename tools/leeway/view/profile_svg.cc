#include "tools/leeway/view/profile_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tools/view/picture.h"

namespace leeway::tools {
namespace {

using view::escaped;

constexpr double kMillimetres = 1e3;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// Lengths in px: the plotting area, and what is left around it for ticks and names of axes.
constexpr double kWidth = 680, kHeight = 210;
constexpr double kLeft = 64, kBottom = 52, kTop = 28, kRight = 18, kMargin = 14;
constexpr double kTickLabel = 11, kLabel = 12, kTitle = 17, kNote = 11.5, kLegend = 12.5;
/// Mean width of a character relative to the font size, slightly generous.
constexpr double kCharacter = 0.58;

constexpr const char* kStyle = R"(<style>
.page { fill: #ffffff } .area { fill: #fafafa; stroke: #9a9aa2 } .grid { stroke: #dedee4 }
.text { fill: #24242a } .soft { fill: #5c5c66 }
text { font-family: "DejaVu Sans", "Liberation Sans", Arial, sans-serif }
@media (prefers-color-scheme: dark) {
.page { fill: #17171b } .area { fill: #1e1e24; stroke: #6f6f7a } .grid { stroke: #34343d }
.text { fill: #ececf2 } .soft { fill: #a9a9b5 }
}
</style>
)";

struct Series {
  const char* name;
  const char* stroke;  ///< colour and width; eyes that confuse colours tell neighbours apart
  std::vector<std::array<double, 2>> points;  ///< NaN breaks the line
};

constexpr const char* kStrokes[] = {
    "stroke=\"#1f78d1\" stroke-width=\"1.8\" stroke-linejoin=\"round\"",
    "stroke=\"#e07b00\" stroke-width=\"1.8\" stroke-linejoin=\"round\"",
    "stroke=\"#139a6b\" stroke-width=\"1.8\" stroke-linejoin=\"round\"",
    "stroke=\"#7c7c86\" stroke-width=\"1.5\" stroke-linejoin=\"round\" stroke-dasharray=\"5 4\""};

/// A clearance in millimetres; NaN for one that is not finite.
double shown(double clearance) {
  return std::isfinite(clearance) ? clearance * kMillimetres : kNothing;
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

std::string lineElement(double x1, double y1, double x2, double y2) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"grid\"/>\n", x1, y1,
      x2, y2);
}

std::string pathElement(const std::string& path, const char* stroke) {
  return fmt::format("<path d=\"{}\" fill=\"none\" {}/>\n", path, stroke);
}

/// Maps values to shares of an axis.
struct Axis {
  double lower, upper;

  /// Adds space above, and below where `widen_lower`, so that no line lies on the border by chance.
  static Axis around(double lower, double upper, bool widen_lower) {
    if (!(lower < upper)) {
      const double middle = lower == upper ? lower : 1;
      lower = middle - 1, upper = middle + 1;
    }
    if (widen_lower) lower = lower >= 0 && lower < 0.3 * upper ? 0 : lower - 0.05 * (upper - lower);
    return {lower, upper + 0.05 * (upper - lower)};
  }
  double share(double value) const {
    return std::clamp((value - lower) / (upper - lower), 0.0, 1.0);
  }
  /// Multiples of 1, 2 or 5 times a power of ten, about five of them.
  std::vector<double> ticks() const {
    std::vector<double> ticks;
    if (!std::isfinite(upper - lower)) return ticks;
    const double rough = (upper - lower) / 5;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double step = power * (rough / power < 1.5   ? 1
                                 : rough / power < 3.5 ? 2
                                 : rough / power < 7.5 ? 5
                                                       : 10);
    for (double k = std::ceil(lower / step - 1e-9); k * step <= upper + 1e-9 * step; k += 1)
      ticks.push_back(k == 0 ? 0 : k * step);
    return ticks;
  }
};

class Drawing {
 public:
  Drawing(const std::vector<Series>& series, double lowest, double top) : top_(top) {
    double ends[2][2] = {{HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, -HUGE_VAL}};
    for (const Series& one : series)
      for (const auto& point : one.points)
        for (std::size_t k = 0; k < 2; ++k) {
          if (!std::isfinite(point[k])) continue;
          ends[k][0] = std::min(ends[k][0], point[k]);
          ends[k][1] = std::max(ends[k][1], point[k]);
        }
    x_ = Axis::around(ends[0][0], ends[0][1], true);
    y_ = Axis::around(lowest, ends[1][1], false);
  }

  std::string text(const std::vector<Series>& series) const {
    std::string svg = fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" class=\"area\"/>\n",
        kArea, top_, kWidth, kHeight);
    const double bottom = top_ + kHeight;
    for (const double x : x_.ticks()) {
      svg += lineElement(toX(x), top_, toX(x), bottom);
      svg += textElement(toX(x), bottom + 16, "middle", kTickLabel, "text", fmt::format("{:g}", x));
    }
    for (const double y : y_.ticks()) {
      svg += lineElement(kArea, toY(y), kArea + kWidth, toY(y));
      svg += textElement(kArea - 6, toY(y) + 4, "end", kTickLabel, "text", fmt::format("{:g}", y));
    }
    svg += textElement(kArea + kWidth / 2, bottom + 36, "middle", kLabel, "soft", "time [s]");
    svg += textElement(0, 0, "middle", kLabel, "soft", "clearance [mm]",
                       fmt::format(" transform=\"translate({:.1f} {:.1f}) rotate(-90)\"",
                                   kArea - 48, top_ + kHeight / 2));
    // Backwards, so that the first one is drawn on top.
    for (std::size_t i = series.size(); i-- > 0;) svg += line(series[i]);
    return svg;
  }

 private:
  static constexpr double kArea = kMargin + kLeft;  // left end of the plotting area

  double toX(double value) const { return kArea + kWidth * x_.share(value); }
  double toY(double value) const { return top_ + kHeight * (1 - y_.share(value)); }

  std::string line(const Series& series) const {
    std::string path;
    bool pen_down = false;
    for (const auto& [x, y] : series.points) {
      const bool usable = std::isfinite(x) && std::isfinite(y);
      if (usable) path += fmt::format("{}{:.1f} {:.1f}", pen_down ? " L" : "M", toX(x), toY(y));
      pen_down = usable;
    }
    return path.empty() ? "" : pathElement(path, series.stroke);
  }

  double top_;
  Axis x_{}, y_{};
};

/// All series in one row, at a baseline.
std::string legend(const std::vector<Series>& series, double y) {
  constexpr double kKey = 30, kGap = 22;
  std::string svg;
  double x = kMargin;
  for (const Series& one : series) {
    svg += pathElement(fmt::format("M{:.1f} {:.1f} L{:.1f} {:.1f}", x, y - 4, x + 22, y - 4),
                       one.stroke);
    svg += textElement(x + kKey, y, "start", kLegend, "text", one.name);
    x += kKey + textWidth(one.name, kLegend) + kGap;
  }
  return svg;
}

}  // namespace

std::string profileSvg(const std::string& title, const std::string& note,
                       const view::Timeline& timeline, const std::set<double>& margins) {
  std::vector<Series> series = {{"proven", kStrokes[0], {}},
                                {"from the world", kStrokes[1], {}},
                                {"from itself", kStrokes[2], {}},
                                {margins.size() > 1 ? "margins" : "margin", kStrokes[3], {}}};
  double lowest = 0;  // the axis holds 0, so that no small change looks like a large one
  const auto add = [&](std::size_t which, double time, double clearance) {
    series[which].points.push_back({time, shown(clearance)});
    if (std::isfinite(clearance)) lowest = std::min(lowest, shown(clearance));
  };
  const auto& moments = timeline.moments;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    add(1, moments[i].time, moments[i].world.clearance.upper);
    add(2, moments[i].time, moments[i].self.clearance.upper);
    if (i >= timeline.stretches.size()) continue;
    for (const std::size_t end : {i, i + 1}) add(0, moments[end].time, timeline.stretches[i].lower);
  }
  for (const double margin : margins) {
    for (const view::Moment* end : {&moments.front(), &moments.back()}) add(3, end->time, margin);
    add(3, kNothing, kNothing);  // ends the line
  }

  const double width =
      2 * kMargin +
      std::max({kLeft + kWidth + kRight, textWidth(title, kTitle * 1.1), textWidth(note, kNote)});
  std::string body;
  double y = kMargin;
  if (!title.empty()) {
    body +=
        textElement(kMargin, y + kTitle, "start", kTitle, "text", title, " font-weight=\"bold\"");
    y += kTitle + 8;
  }
  body += textElement(kMargin, y + kNote + 1, "start", kNote, "soft", note);
  y += kNote + 10;
  body += legend(series, y + 14);
  y += 28 + kTop;
  body += Drawing(series, lowest, y).text(series);
  const double height = y + kHeight + kBottom + kMargin;
  return fmt::format(
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
             "viewBox=\"0 0 {0:.0f} {1:.0f}\">\n<title>{2}</title>\n{3}"
             "<rect width=\"{0:.0f}\" height=\"{1:.0f}\" class=\"page\"/>\n",
             width, height, escaped(title), kStyle) +
         body + "</svg>\n";
}

}  // namespace leeway::tools
