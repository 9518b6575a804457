#include "tools/leeway/view/plot.h"

#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <cmath>
#include <string>
#include <vector>

#include "collision/base/numbers.h"

namespace leeway::tools {
namespace {

/// Elements of one name at any depth.
int count(const tinyxml2::XMLElement* element, const std::string& name) {
  int found = 0;
  for (const auto* e = element->FirstChildElement(); e != nullptr; e = e->NextSiblingElement())
    found += (e->Name() == name) + count(e, name);
  return found;
}

int occurrences(const std::string& text, const std::string& part) {
  int found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

Figure twoPanels() {
  Figure figure;
  figure.title = "a < b & \"c\"";
  figure.note = "note";
  figure.columns = 2;
  PlotSeries first{"one", {{1, 10, 8, 12}, {10, 100}, {100, 1000}}};
  PlotSeries second{"two", {{1, 20}, {10, 200}}};
  PlotSeries limit{"limit", {{1, 5}, {100, 500}}};
  limit.marker = false;
  limit.dashed = true;
  figure.panels.push_back({"left", {"x [m]"}, {"y [s]"}, {first, second}});
  figure.panels.push_back({"right", {"x [m]"}, {"y [s]"}, {second, limit}});
  return figure;
}

TEST(Plot, IsWellFormedAndHoldsEveryPoint) {
  const std::string svg = toSvg(twoPanels());
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.Parse(svg.c_str()), tinyxml2::XML_SUCCESS) << document.ErrorStr();
  const auto* root = document.RootElement();
  EXPECT_STREQ(root->Name(), "svg");
  // Style 0 has circles, style 1 squares (polygons); the legend adds one of each.
  EXPECT_EQ(count(root, "circle"), 3 + 1);
  EXPECT_EQ(count(root, "polygon"), 2 + 2 + 1);
  // Four series in panels, three names in the legend.
  EXPECT_EQ(count(root, "path"), 4 + 3);
  EXPECT_EQ(occurrences(svg, ">two</text>"), 1);
  EXPECT_EQ(occurrences(svg, "opacity=\"0.55\""), 1) << "one bar";
  EXPECT_STREQ(root->FirstChildElement("title")->GetText(), "a < b & \"c\"");
  EXPECT_EQ(svg, toSvg(twoPanels()));
}

TEST(Plot, SameNameSameColourInEveryPanel) {
  Figure figure = twoPanels();
  const std::string both = toSvg(figure);
  // Series `two` is second in the legend, though first in its panel.
  const std::string colour = "fill=\"#e07b00\"";
  EXPECT_EQ(occurrences(both, colour), 2 + 2 + 1);
}

TEST(Plot, PointsBeyondTheBorderAreHollowAndNanIsLeftOut) {
  Figure figure;
  PlotPanel panel{"p", {"x"}, {"y"}, {{"s", {{1, 1}, {0, 2}, {kNaN, 3}, {3, kNaN}, {9, 9}}}}};
  panel.x.lower = 0.1, panel.x.upper = 5;
  figure.panels.push_back(panel);
  const std::string svg = toSvg(figure);
  // A logarithmic axis has no 0, and 9 is beyond its end; the legend adds one.
  EXPECT_EQ(occurrences(svg, "<circle"), 3 + 1) << svg;
  EXPECT_EQ(occurrences(svg, "class=\"hollow\""), 2) << svg;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Plot, DrawsEmptyAndDegenerateFigures) {
  Figure figure;
  tinyxml2::XMLDocument document;
  EXPECT_EQ(document.Parse(toSvg(figure).c_str()), tinyxml2::XML_SUCCESS);
  figure.panels.push_back({"empty", {"x"}, {"y"}, {}});
  figure.panels.push_back({"one point", {"x"}, {"y"}, {{"s", {{3, 4}}}}});
  figure.panels.push_back({"linear",
                           {"x", AxisScale::kLinear},
                           {"y", AxisScale::kLinear},
                           {{"s", {{-3, -4}, {5, 0}}}}});
  const std::string svg = toSvg(figure);
  EXPECT_EQ(document.Parse(svg.c_str()), tinyxml2::XML_SUCCESS);
  for (const char* word : {"nan", "inf"}) EXPECT_EQ(svg.find(word), std::string::npos) << word;
}

TEST(Plot, LogarithmicTicksLieWithinAndAreEnough) {
  for (const auto& [lower, upper] : std::vector<std::pair<double, double>>{
           {1, 10}, {0.3, 7e4}, {1e-17, 1}, {4, 4.5}, {90, 1100}}) {
    const PlotTicks ticks = logarithmicTicks(lower, upper);
    EXPECT_GE(ticks.labelled.size(), 2u) << lower;
    EXPECT_LE(ticks.labelled.size(), 14u) << lower;
    for (const auto* list : {&ticks.labelled, &ticks.unlabelled})
      for (const double v : *list) {
        EXPECT_GE(v, lower * (1 - 1e-6));
        EXPECT_LE(v, upper * (1 + 1e-6));
      }
    EXPECT_TRUE(std::is_sorted(ticks.labelled.begin(), ticks.labelled.end()));
  }
  EXPECT_EQ(logarithmicTicks(1, 1000).labelled.front(), 1);
  EXPECT_TRUE(logarithmicTicks(0, 1).labelled.empty());
  EXPECT_TRUE(logarithmicTicks(1, HUGE_VAL).labelled.empty());
}

TEST(Plot, LinearTicksAreRound) {
  EXPECT_EQ(linearTicks(0, 10).labelled, (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(linearTicks(-1, 1).labelled.size(), 5u);
  EXPECT_TRUE(linearTicks(1, 1).labelled.empty());
}

}  // namespace
}  // namespace leeway::tools
