#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "leeway/robots/motion_bound.h"
#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

std::string link(const std::string& name, double radius, double x) {
  return "<link name=\"" + name + "\"><collision><origin xyz=\"" + std::to_string(x) +
         " 0 0\"/><geometry><sphere radius=\"" + std::to_string(radius) +
         "\"/></geometry></collision></link>\n";
}

std::string joint(const std::string& parent, const std::string& child, const char* type,
                  const char* axis, double x) {
  return "<joint name=\"to_" + child + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/><origin xyz=\"" + std::to_string(x) +
         " 0 0\"/><axis xyz=\"" + axis +
         "\"/><limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint>\n";
}

/// `hub` is inside `base` at all positions of its two joints; `rest` touches `base` only with all
/// joints at zero; `far` reaches `rest`, but not from zero; `plate` is fixed to `base`.
std::shared_ptr<const Model> robot(const std::string& srdf = "") {
  const Folder folder;
  return loadModel(
      folder.write("touching.urdf",
                   "<robot name=\"touching\">" + link("base", 0.1, 0) + link("neck", 0.05, 0) +
                       link("hub", 0.02, 0) + link("rest", 0.05, -0.06) + link("far", 0.05, 0) +
                       link("plate", 0.05, 0) + joint("base", "neck", "revolute", "0 0 1", 0) +
                       joint("neck", "hub", "revolute", "0 0 1", 0) +
                       joint("hub", "rest", "revolute", "0 0 1", 0.2) +
                       joint("base", "far", "prismatic", "1 0 0", 0.5) +
                       joint("base", "plate", "fixed", "1 0 0", -0.2) + "</robot>"),
      srdf.empty() ? srdf : folder.write("touching.srdf", srdf));
}

std::vector<std::pair<std::string, std::string>> namesOf(const Model& model) {
  std::vector<std::pair<std::string, std::string>> names;
  for (const auto& [a, b] : touchingAtRest(model))
    names.emplace_back(model.links[static_cast<std::size_t>(a)].name,
                       model.links[static_cast<std::size_t>(b)].name);
  return names;
}

using Names = std::vector<std::pair<std::string, std::string>>;

TEST(TouchingAtRest, NeitherNeighboursNorPairsThatMeetElsewhere) {
  EXPECT_EQ(namesOf(*robot()), (Names{{"base", "hub"}, {"base", "rest"}}));
}

TEST(TouchingAtRest, AnSrdfSaysWhichPairsItMeans) {
  const std::string start = "<robot name=\"touching\">";
  EXPECT_EQ(
      namesOf(*robot(start +
                     R"(<disable_collisions link1="hub" link2="base" reason="Always"/></robot>)")),
      (Names{{"base", "rest"}}));
  // Pairs of enable_collisions are never left out, even if they always touch.
  for (const char* link : {"neck", "hub"}) {
    Names others = namesOf(*robot(start + "</robot>"));
    std::erase(others, Names::value_type("base", link));
    EXPECT_EQ(namesOf(*robot(start + "<enable_collisions link1=\"" + link +
                             "\" link2=\"base\"/></robot>")),
              others);
  }
}

TEST(TouchingAtRest, EndsWhereItsCallerSaysSo) {
  EXPECT_THROW(touchingAtRest(*robot(), [] { return true; }), Stopped);
}

}  // namespace
}  // namespace leeway::robots
