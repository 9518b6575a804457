// Pages and pictures, as far as no browser is needed. tests/view/browse opens pages.

#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <sstream>

#include "tests/support/command.h"
#include "tests/support/small_problems.h"
#include "tools/view/display_mesh.h"
#include "tools/view/subject.h"

namespace leeway::tools::testing {
namespace {

/// A sphere of 1 m with bumps of 5 cm.
view::DisplayMesh bumpySphere(int rings) {
  view::DisplayMesh mesh;
  for (int i = 0; i <= rings; ++i) {
    for (int k = 0; k < rings; ++k) {
      const double a = M_PI * i / rings, b = 2 * M_PI * k / rings;
      const double r = 1 + 0.05 * std::sin(9 * a) * std::cos(7 * b);
      mesh.vertices.emplace_back(r * std::sin(a) * std::cos(b), r * std::sin(a) * std::sin(b),
                                 r * std::cos(a));
      if (i == rings) continue;
      const int at = i * rings + k, next = i * rings + (k + 1) % rings;
      mesh.triangles.push_back({at, next, next + rings});
      mesh.triangles.push_back({at, next + rings, at + rings});
    }
  }
  return mesh;
}

TEST(DisplayMesh, IsWithinItsError) {
  const view::DisplayMesh fine = bumpySphere(120);
  for (const std::size_t most : {20'000U, 4'000U, 300U}) {
    const view::DisplayMesh coarse = view::decimated(fine.vertices, fine.triangles, most);
    EXPECT_LE(coarse.triangles.size(), most);
    EXPECT_GT(coarse.triangles.size(), most / 8);
    // A few cells' sides for each triangle's share of the surface.
    EXPECT_LT(coarse.error, 6 * std::sqrt(4 * M_PI / static_cast<double>(most)));
    for (std::size_t i = 0; i < fine.vertices.size(); i += 13) {
      double nearest = 1e9;
      for (const Eigen::Vector3d& w : coarse.vertices)
        nearest = std::min(nearest, (fine.vertices[i] - w).norm());
      ASSERT_LE(nearest, coarse.error);
    }
    const auto count = static_cast<std::int32_t>(coarse.vertices.size());
    for (const view::Triangle& t : coarse.triangles)
      for (const std::int32_t i : t) ASSERT_TRUE(i >= 0 && i < count);
  }
  // What is small enough stays as it is.
  const view::DisplayMesh same = view::decimated(fine.vertices, fine.triangles, 1'000'000);
  EXPECT_EQ(same.triangles, fine.triangles);
  EXPECT_EQ(same.error, 0);
}

TEST(DisplayMesh, QuantisedIsWithinItsError) {
  std::mt19937 random(1);
  for (const double extent : {1e-3, 0.3, 40.0, 1e5}) {
    std::uniform_real_distribution<double> uniform(-extent, extent);
    std::vector<Eigen::Vector3d> points(500);
    for (Eigen::Vector3d& p : points) p = {uniform(random), uniform(random), uniform(random)};
    const view::Quantised q = view::quantised(points);
    double largest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d shown =
          q.low +
          q.step * Eigen::Vector3d(q.numbers[3 * i], q.numbers[3 * i + 1], q.numbers[3 * i + 2]);
      largest = std::max(largest, (shown - points[i]).norm());
    }
    EXPECT_LE(largest, view::quantisationError(q) * (1 + 1e-9));
    EXPECT_GT(largest, 0.3 * view::quantisationError(q));
    EXPECT_LE(view::quantisationError(q), 2e-3 * extent);
  }
}

TEST(DisplayMesh, SameMeshIsStoredOnce) {
  view::Pack pack;
  view::MeshStore store(pack, 100'000);
  const view::DisplayMesh mesh = bumpySphere(10);
  EXPECT_EQ(store.add(mesh, 200), 0);
  EXPECT_EQ(store.add(bumpySphere(12), 288), 1);
  EXPECT_EQ(store.add(mesh, 200), 0);
  EXPECT_EQ(store.document().size(), 2u);
}

/// A disc between a post, and a person that needs more room than there is.
planner::Problem betweenTwo() {
  using namespace planner::test;
  planner::Problem problem = problemOf(disc(), {-1, 0, 0}, {1, 0, 0});
  problem.world.objects = {box("post", {0.05, 0.05, 0.5}, 0, 0.17, 0),
                           box("person", {0.05, 0.05, 0.5}, 0, -0.25, 0)};
  problem.margins.common = 0.002;
  problem.margins.pairs = {{"disc", "person", 0.12}};
  return problem;
}

std::set<std::string> namesOf(const view::Subject& subject, const view::PairCurve& curve) {
  const auto bodies = subject.scene->scene().bodies();
  return {bodies[static_cast<std::size_t>(curve.pair.a)].name,
          bodies[static_cast<std::size_t>(curve.pair.b)].name};
}

TEST(Page, GoesToThePairThatIsBelowItsMargin) {
  planner::Problem problem = betweenTwo();
  const planner::Path path{{}, {{-1, 0, 0}, {1, 0, 0}}};
  const view::Subject subject = view::subjectOfPath(problem, "between.yaml", path);
  EXPECT_FALSE(subject.good);
  const view::Timeline& timeline = subject.timeline;
  ASSERT_GE(timeline.failing, 0);
  const view::PairCurve& failing = timeline.pairs.at(static_cast<std::size_t>(timeline.failing));
  EXPECT_EQ(namesOf(subject, failing), (std::set<std::string>{"disc", "person"}));
  EXPECT_EQ(failing.pair.margin, 0.12);
  EXPECT_NEAR(*std::min_element(failing.distance.begin(), failing.distance.end()), 0.1, 1e-5);
  EXPECT_NEAR(subject.least.all.clearance.upper, 0.02, 1e-5) << "the post";
  // The place where the proof fails is a moment, also of a pair that is near for a short time.
  problem.margins.pairs[0].margin = 0.1000001;
  EXPECT_GE(view::subjectOfPath(problem, "between.yaml", path).timeline.failing, 0);
  // If all keep their margins, or the nearest one does not, there is none.
  problem.margins.pairs[0].margin = 0.09;
  EXPECT_EQ(view::subjectOfPath(problem, "between.yaml", path).timeline.failing, -1);
  problem.margins.pairs[0].margin = 0.12;
  problem.margins.common = 0.03;
  EXPECT_EQ(view::subjectOfPath(problem, "between.yaml", path).timeline.failing, -1);
}

TEST(Page, OfAStateHasAllPairsThatAreTooNear) {
  planner::Problem problem = betweenTwo();
  problem.margins.common = 0.03;
  problem.start = {0, 0, 0};
  const view::Subject subject = view::subjectOfStart(problem, "between.yaml");
  EXPECT_FALSE(subject.good);
  ASSERT_EQ(subject.timeline.pairs.size(), 2u);
  std::set<std::string> names;
  for (const view::PairCurve& curve : subject.timeline.pairs) {
    ASSERT_EQ(curve.distance.size(), 1u);
    EXPECT_LE(curve.distance[0], curve.pair.margin);
    names.merge(namesOf(subject, curve));
  }
  EXPECT_EQ(names, (std::set<std::string>{"disc", "person", "post"}));
  bool says_both = false;
  for (const std::string& note : subject.notes)
    says_both = says_both || note.find("Both pairs that are too near") != std::string::npos;
  EXPECT_TRUE(says_both);
}

class View : public CommandTest {
 protected:
  /// Problem names that would be markup.
  void writeHostile() const {
    std::string text = kReach;
    text.replace(text.find("around the post"), 15,
                 "\"</script><script>alert(1)</script><svg onload=alert(1)>&\\u2028\"");
    text.replace(text.find("name: post"), 10, "name: \"<img src=x>\"");
    write("hostile.yaml", text);
  }
};

TEST_F(View, DrawsThreeViews) {
  writeHostile();
  const Answer answer = run("view hostile.yaml --svg picture.svg");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.out.find("certified"), std::string::npos) << answer.out;
  tinyxml2::XMLDocument picture;
  ASSERT_EQ(picture.LoadFile(path("picture.svg").c_str()), tinyxml2::XML_SUCCESS);
  int views = 0;
  for (const auto* view = picture.RootElement()->FirstChildElement("svg"); view != nullptr;
       view = view->NextSiblingElement("svg")) {
    ++views;
    EXPECT_NE(view->FirstChildElement("polyline"), nullptr);  // the trail
    EXPECT_NE(view->FirstChildElement("line"), nullptr);      // the nearest pair
    int robots = 0;                                           // five on the way, start, goal
    for (const auto* g = view->FirstChildElement("g"); g != nullptr; g = g->NextSiblingElement("g"))
      ++robots;
    EXPECT_EQ(robots, 7);
  }
  EXPECT_EQ(views, 3);
  EXPECT_EQ(read("picture.svg").find("<script"), std::string::npos);
  EXPECT_EQ(run("view hostile.yaml --svg again.svg").status, 0);
  EXPECT_EQ(read("again.svg"), read("picture.svg"));
}

/// The corners of all parts of the world in a picture, as shares of the width of their panel.
std::pair<double, double> worldRange(const std::string& svg) {
  tinyxml2::XMLDocument picture;
  EXPECT_EQ(picture.Parse(svg.c_str()), tinyxml2::XML_SUCCESS);
  double low = 1, high = 0;
  for (const auto* view = picture.RootElement()->FirstChildElement("svg"); view != nullptr;
       view = view->NextSiblingElement("svg")) {
    const double x = view->DoubleAttribute("x"), y = view->DoubleAttribute("y"),
                 width = view->DoubleAttribute("width");
    for (const auto* part = view->FirstChildElement("path"); part != nullptr;
         part = part->NextSiblingElement("path")) {
      if (std::string(part->Attribute("class")).find("world") != 0) continue;
      std::string numbers = part->Attribute("d");
      for (char& c : numbers)
        if (c == 'M' || c == 'L' || c == 'Z') c = ' ';
      std::istringstream in(numbers);
      for (double px = 0, py = 0; in >> px >> py;) {
        low = std::min({low, (px - x) / width, (py - y) / width});
        high = std::max({high, (px - x) / width, (py - y) / width});
      }
    }
  }
  return {low, high};
}

TEST_F(View, ShowsTheWholeWorldUpToALimit) {
  // A long shelf next to the robot.
  const std::string box =
      "  - {name: aside, position: [2.6, 1, 0.4], box: {size: [2, 0.3, 1.5]}}\n";
  std::string text = kReach;
  text.insert(text.find("limits:"), box);
  write("aside.yaml", text);
  ASSERT_EQ(run("view aside.yaml --svg aside.svg").status, 0);
  const auto [low, high] = worldRange(read("aside.svg"));
  EXPECT_GE(low, 0);
  EXPECT_LE(high, 1);
  EXPECT_EQ(read("aside.svg").find("goes on beyond"), std::string::npos);
  // A hall of a hundred metres would make the robot a dot: the picture says that it is cut.
  const std::string hall =
      "  - {name: floor, position: [0, 0, -1.2], box: {size: [100, 100, 0.1]}}\n";
  text.insert(text.find("limits:"), hall);
  write("hall.yaml", text);
  ASSERT_EQ(run("view hall.yaml --svg hall.svg").status, 0);
  EXPECT_NE(read("hall.svg").find("The world goes on beyond the picture."), std::string::npos);
  EXPECT_GT(worldRange(read("hall.svg")).second, 1);
}

TEST_F(View, DrawsHalfSpacesThatAreSeenEdgeOn) {
  std::string text = kReach;
  text.insert(text.find("limits:"), "  - {name: ground, position: [0, 0, -1], half_space: {}}\n");
  write("ground.yaml", text);
  const Answer answer = run("view ground.yaml --svg ground.svg");
  ASSERT_EQ(answer.status, 0) << answer.err;
  const std::string svg = read("ground.svg"), mark = "class=\"world\" fill-opacity=\"0.35\"";
  int planes = 0;
  for (std::size_t at = svg.find(mark); at != std::string::npos; at = svg.find(mark, at + 1))
    ++planes;
  EXPECT_EQ(planes, 2) << "from the front and from the right, not from above";
}

/// The outline of the first part that is drawn in this role.
std::string firstRobot(const std::string& svg, const std::string& role) {
  const std::size_t at = svg.find(" d=", svg.find("<path class=\"" + role));
  return svg.substr(at, svg.find('/', at) - at);
}

TEST_F(View, DrawsAFailure) {
  write("inside.yaml", kInvalidStart);
  const Answer answer = run("view inside.yaml --svg inside.svg");
  EXPECT_EQ(answer.status, 1) << answer.err;
  for (const char* word : {"start not valid", "lower and post", "70.00 mm deep", "way out"})
    EXPECT_NE(answer.out.find(word), std::string::npos) << word << "\n" << answer.out;
  const std::string svg = read("inside.svg");
  EXPECT_NE(svg.find("start not valid"), std::string::npos);
  for (const char* undrawn : {">trail<", ">on the way<"})
    EXPECT_EQ(svg.find(undrawn), std::string::npos) << undrawn;
  // As check does, the note names all pairs.
  write("two.yaml", std::string(kInvalidStart) +
                        "  - {name: pillar, position: [0.3, 0, 0], box: {size: [0.1, 0.1, 1]}}\n");
  const Answer two = run("view two.yaml --svg two.svg");
  for (const char* word : {"pairs that are too near: ", "and pillar", "and post"})
    EXPECT_NE(two.flat().find(word), std::string::npos) << word << "\n" << two.out;
  // With an invalid goal, the start is still the start.
  std::string text = kReach;
  text.replace(text.find("goal: left"), 10, "goal: {shoulder: 0, elbow: 0}");
  write("goal.yaml", text);
  ASSERT_EQ(run("view goal.yaml --svg goal.svg").status, 1);
  EXPECT_NE(firstRobot(read("goal.svg"), "start"), firstRobot(read("goal.svg"), "goal"));
}

/// "certified" covers the start and the goal, as it does for verify.
TEST_F(View, APathBetweenOtherPlacesIsNotCertified) {
  ASSERT_EQ(run("plan reach.yaml --output path.csv").status, 0);
  const auto replaced = [](const char* from, const char* to) {
    std::string text = kReach;
    return text.replace(text.find(from), std::string(from).size(), to);
  };
  write("goal.yaml", replaced("goal: left", "goal: {shoulder: 1.1, elbow: 0.25}"));
  write("start.yaml", replaced("start: right", "start: {shoulder: -1.1, elbow: 0}"));
  for (const auto& [problem, reason] :
       {std::pair("goal.yaml", "in none of the problem's goals"), {"start.yaml", "start"}}) {
    const std::string files = std::string(problem) + " path.csv";
    const Answer proven = run("verify " + files), seen = run("view " + files + " --svg seen.svg");
    EXPECT_EQ(proven.status, 1) << proven.out;
    EXPECT_EQ(seen.status, 1) << seen.out;
    for (const Answer* answer : {&proven, &seen})
      EXPECT_NE(answer->flat().find(reason), std::string::npos) << answer->out;
    EXPECT_NE(seen.out.find("not certified"), std::string::npos) << seen.out;
  }
  const Answer seen = run("view reach.yaml path.csv --svg seen.svg");
  EXPECT_EQ(seen.status, 0) << seen.out;
  EXPECT_NE(seen.flat().find("begins at the start and ends in a goal"), std::string::npos)
      << seen.out;
}

TEST_F(View, VisualShapesArePartOfThePage) {
  expectRefused("view reach.yaml --visual --svg picture.svg", {"--visual", "--output"});
  expectRefused("plan reach.yaml --visual", {"--view"});
  const Answer bare = run("view reach.yaml --visual --output bare.html");
  if (bare.err.find("without node") != std::string::npos)
    GTEST_SKIP() << "the command was built without node";
  EXPECT_EQ(bare.status, 0) << bare.err;
  EXPECT_NE(bare.err.find("arm.urdf: the robot has no visual shapes"), std::string::npos)
      << bare.err;
  std::string urdf = kUrdf;
  urdf.insert(urdf.find("</link>"),
              "<visual><geometry><mesh filename=\"skin.obj\"/></geometry></visual>\n"
              "<visual><geometry><mesh filename=\"skin.unknown\"/></geometry></visual>\n");
  write("arm.urdf", urdf);
  write("skin.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  const Answer plain = run("view reach.yaml --output plain.html");
  EXPECT_EQ(plain.err.find("skin"), std::string::npos) << "visual shapes are read when asked for";
  const Answer dressed = run("view reach.yaml --visual --output dressed.html");
  EXPECT_EQ(dressed.status, 0) << dressed.err;
  EXPECT_NE(dressed.err.find("skin.unknown"), std::string::npos) << dressed.err;
  EXPECT_NE(dressed.err.find("arm.urdf:"), std::string::npos) << dressed.err;
  EXPECT_EQ(dressed.out.substr(0, dressed.out.rfind('\n', dressed.out.size() - 2)),
            plain.out.substr(0, plain.out.rfind('\n', plain.out.size() - 2)))
      << "what is checked is the same";
  EXPECT_GT(read("dressed.html").size(), read("plain.html").size());
  const Answer batch = run("batch reach.yaml --visual --view pages");
  EXPECT_EQ(batch.status, 0) << batch.err;
  EXPECT_NE(batch.err.find("skin.unknown"), std::string::npos) << batch.err;
  EXPECT_GT(read("pages/0001.html").size(), read("plain.html").size());
  expectRefused("batch reach.yaml --visual", {"--view"});
}

TEST_F(View, SaysWhatBlockedASearchAndWhatNoSensorSaw) {
  const auto with = [](const std::string& object) {
    std::string text = kReach;
    text.insert(text.find("limits:"), "  - " + object + "\n");
    return text.replace(text.find("time: 20"), 8, "iterations: 300");
  };
  write("walled.yaml", with("{name: wall, position: [0.55, 0, 0], box: {size: [0.9, 0.02, 1]}}"));
  const Answer plan = run("plan walled.yaml");
  const Answer view = run("view walled.yaml --svg walled.svg");
  EXPECT_EQ(view.status, 1) << view.out << view.err;
  for (const Answer* answer : {&plan, &view})
    EXPECT_NE(answer->flat().find("Most edges were blocked by: "), std::string::npos)
        << answer->out;
  write("seen.xyz", "0.9 0.9 0\n0.9 1 0\n");
  write("cloud.yaml", with("{name: scan, cloud: {file: seen.xyz, radius: 0.01}}"));
  const Answer cloud = run("view cloud.yaml --svg cloud.svg");
  EXPECT_NE(cloud.flat().find("cloud 'scan': space that was not seen counts as free."),
            std::string::npos)
      << cloud.out << cloud.err;
}

TEST_F(View, RefusesWhatItCannotWrite) {
  expectRefused("view reach.yaml --svg picture.png", {"picture.png", ".svg"});
  expectRefused("view reach.yaml --svg missing/picture.svg", {"missing"});
  expectRefused("view reach.yaml --output page.txt", {"page.txt", ".html"});
  expectRefused("plan reach.yaml --view page.txt", {"page.txt", ".html"});
  expectRefused("view missing.yaml --svg picture.svg", {"missing.yaml"});
}

/// Where the command has the page. What a user names is in base64, so that no byte of it is markup.
TEST_F(View, PageHoldsNothingOfTheUser) {
  writeHostile();
  const Answer answer = run("view hostile.yaml --output page.html");
  if (answer.err.find("without node") != std::string::npos) {
    EXPECT_EQ(answer.status, 2);
    EXPECT_NE(answer.err.find("tools/setup --view"), std::string::npos);
    GTEST_SKIP() << "the command was built without node";
  }
  ASSERT_EQ(answer.status, 0) << answer.err;
  ASSERT_EQ(run("view empty.yaml --output empty.html").status, 0);
  const auto split = [](const std::string& page) {
    const std::string mark = "application/octet-stream\">";
    const std::size_t begin = page.find(mark) + mark.size();
    const std::size_t end = page.find('<', begin);
    return std::pair(page.substr(begin, end - begin), page.substr(0, begin) + page.substr(end));
  };
  const auto [data, frame] = split(read("page.html"));
  const auto [other, same] = split(read("empty.html"));
  EXPECT_EQ(frame, same);
  EXPECT_NE(data, other);
  EXPECT_EQ(data.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                   "0123456789+/="),
            std::string::npos);
  EXPECT_NE(frame.find("Content-Security-Policy"), std::string::npos);
  EXPECT_NE(frame.find("Permission is hereby granted"), std::string::npos);  // three.js's licence
  // The same command line, the same bytes.
  ASSERT_EQ(run("view hostile.yaml --output again.html").status, 0);
  EXPECT_EQ(read("again.html"), read("page.html"));
}

TEST_F(View, OtherVerbsWritePages) {
  if (run("view reach.yaml --output page.html").status == 2) GTEST_SKIP() << "built without node";
  EXPECT_EQ(run("plan reach.yaml --output path.json --view plan.html --json").status, 0);
  EXPECT_EQ(run("clearance reach.yaml path.json --view clearance.html").status, 0);
  EXPECT_EQ(run("batch reach.yaml empty.yaml --view pages").status, 0);
  for (const char* page : {"plan.html", "clearance.html", "pages/0001.html", "pages/0002.html"})
    EXPECT_GT(read(page).size(), 100'000u) << page;
  const std::string index = read("pages/index.html");
  EXPECT_NE(index.find("around the post"), std::string::npos);
  EXPECT_NE(index.find("href=\"0002.html\""), std::string::npos);
  EXPECT_NE(index.find("<div class=\"place\">lower and post,<br><a href=\"0001.html#t="),
            std::string::npos)
      << index;
}

}  // namespace
}  // namespace leeway::tools::testing
