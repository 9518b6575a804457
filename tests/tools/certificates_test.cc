// Answers about pairs that are not checked, paths with nothing near, and rows between which a
// continuous joint turns.

#include <gtest/gtest.h>

#include <string>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

using Certificates = CommandTest;

const char* const kSpin =
    "<robot name=\"spin\"><link name=\"base\"/>"
    "<link name=\"bar\"><collision><origin xyz=\"0.5 0 0\"/><geometry><box size=\"1 0.05 0.05\"/>"
    "</geometry></collision></link><joint name=\"j\" type=\"continuous\"><parent link=\"base\"/>"
    "<child link=\"bar\"/><axis xyz=\"0 0 1\"/></joint></robot>";

std::string spinning(const std::string& more) {
  return "leeway: 1\nrobot: {urdf: spin.urdf}\nstart: [3.0]\ngoal: [-3.0]\n" + more;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Regression: a path was certified by the shorter way, and a controller that interpolates its rows
/// goes the longer one.
TEST_F(Certificates, RowsAreStraightLinesUnlessTheShorterWayIsAskedFor) {
  write("spin.urdf", kSpin);
  write("spin.yaml",
        spinning("objects: [{name: o, position: [0.9, 0, 0], box: {size: [0.1, 0.1, 0.1]}}]\n"));
  write("direct.csv", "3.0\n-3.0\n");
  const Answer straight = run("verify spin.yaml direct.csv --json");
  EXPECT_EQ(straight.status, 1);
  EXPECT_EQ(straight.document()["status"], "refuted");
  EXPECT_EQ(straight.document()["where"]["segment"], 0);
  EXPECT_NEAR(straight.document()["where"]["t0"].get<double>(), 0.5, 0.05);
  EXPECT_EQ(run("verify spin.yaml direct.csv --shortest --json").document()["status"], "certified");
  EXPECT_EQ(run("verify spin.yaml direct.csv --shortest").status, 0);

  const json along = run("clearance spin.yaml direct.csv --json").document();
  EXPECT_EQ(along["status"], "not_certified");
  EXPECT_LT(along["clearance_upper"].get<double>(), 0);
  ASSERT_EQ(along["segments"].size(), 2U) << "an edge is at most half a turn";
  EXPECT_EQ(along["segments"][1]["segment"], 0);
  EXPECT_EQ(along["segments"][1]["t0"], 0.5);
  const json shorter = run("clearance spin.yaml direct.csv --shortest --json").document();
  EXPECT_EQ(shorter["status"], "certified");
  EXPECT_EQ(shorter["segments"].size(), 1U);

  EXPECT_EQ(run("view spin.yaml direct.csv --svg v.svg").status, 1);
  EXPECT_EQ(run("view spin.yaml direct.csv --svg v.svg --shortest").status, 0);
  EXPECT_TRUE(has(run("view spin.yaml direct.csv --svg v.svg").out, "Edge 0 does not keep"));
  // Plans and their files name their interpolation.
  const json planned = run("plan spin.yaml --output p.json --json").document();
  EXPECT_EQ(planned["certificate"]["interpolation"], "joint-linear");
  EXPECT_NEAR(planned["path"]["positions"].back()[0].get<double>(), 3.2831853, 1e-6);
  const json file = json::parse(read("p.json"));
  EXPECT_EQ(file["certificate"]["interpolation"], "joint-linear");
  EXPECT_EQ(file["points"].back()["positions"], planned["path"]["positions"].back());
  EXPECT_EQ(run("verify spin.yaml p.json").status, 0);
  write("doc.json", run("plan spin.yaml --json").out);
  EXPECT_EQ(run("verify spin.yaml doc.json").status, 0);
}

/// Regression: "between 100.000 and - mm, from  to  on edge -1".
TEST_F(Certificates, NothingNearIsASentence) {
  write("spin.urdf", kSpin);
  write("far.yaml",
        spinning("objects: [{name: post, position: [0.8, 0, 0], cylinder: {radius: 0.01, length: "
                 "1}}]\n"));
  write("alone.yaml", spinning(""));
  const Answer far = run("plan far.yaml --output far.csv");
  EXPECT_EQ(far.status, 0);
  EXPECT_TRUE(has(far.out, "far: certified, least clearance ") && has(far.out, " 786.86\n1 "))
      << far.out;
  const Answer alone = run("plan alone.yaml --output alone.csv");
  EXPECT_EQ(alone.status, 0);
  EXPECT_TRUE(has(alone.out, "alone: certified, there is nothing else that it could touch"))
      << alone.out;
  for (const std::string name : {"far", "alone"})
    for (const std::string verb : {"plan X.yaml", "verify X.yaml X.csv", "clearance X.yaml X.csv",
                                   "check X.yaml", "view X.yaml X.csv --svg v.svg",
                                   "batch X.yaml --verify", "clearance X.yaml X.csv --svg c.svg"}) {
      std::string command = verb;
      for (std::size_t at = 0; (at = command.find('X', at)) != std::string::npos;)
        command.replace(at, 1, name);
      const Answer answer = run(command);
      EXPECT_EQ(answer.status, 0) << command << answer.err;
      for (const char* odd : {"inf", "nan", " - mm", "edge -1", "from  to"})
        EXPECT_FALSE(has(answer.out, odd)) << command << "\n" << answer.out;
    }
  const json none = run("clearance alone.yaml alone.csv --json").document();
  EXPECT_EQ(none["clearance_lower"], nullptr);
  EXPECT_EQ(none["clearance_upper"], nullptr);
  EXPECT_EQ(none["closest"], nullptr);
  const json least = run("plan far.yaml --json").document()["certificate"];
  EXPECT_NEAR(least["clearance_lower"].get<double>(), 0.1, 1e-3);
  EXPECT_EQ(least["clearance_upper"], nullptr);
  EXPECT_EQ(least["closest"], nullptr);
}

const char* const kMast =
    "<robot name=\"mast_boom\">"
    "<link name=\"base\"><collision><geometry><box size=\"0.2 0.2 "
    "0.1\"/></geometry></collision></link>"
    "<link name=\"mast\"><collision><origin xyz=\"0 0 0.5\"/><geometry><box size=\"0.05 0.05 1\"/>"
    "</geometry></collision></link>"
    "<joint name=\"mast_fixed\" type=\"fixed\"><parent link=\"base\"/><child link=\"mast\"/>"
    "<origin xyz=\"MAST 0 0\"/></joint>"
    "<link name=\"turret\"><collision><origin xyz=\"0 0 0.15\"/><geometry><box size=\"0.1 0.1 "
    "0.1\"/>"
    "</geometry></collision></link>"
    "<joint name=\"turn\" type=\"revolute\"><parent link=\"base\"/><child link=\"turret\"/>"
    "<axis xyz=\"0 0 1\"/><limit lower=\"-1.5\" upper=\"1.5\" effort=\"1\" velocity=\"1\"/></joint>"
    "<link name=\"boom\"><collision><origin xyz=\"0.5 0 0\"/><geometry><box size=\"1 0.05 0.05\"/>"
    "</geometry></collision></link>"
    "<joint name=\"boom_fixed\" type=\"fixed\"><parent link=\"turret\"/><child link=\"boom\"/>"
    "<origin xyz=\"0 0 HEIGHT\"/></joint></robot>";

std::string mastAndBoom(const std::string& mast_x, const std::string& height) {
  std::string urdf = kMast;
  urdf.replace(urdf.find("MAST"), 4, mast_x);
  return urdf.replace(urdf.find("HEIGHT"), 6, height);
}

/// Regression: a boom was swept through a mast of its own robot, and certified.
TEST_F(Certificates, ARobotIsNotSweptThroughItself) {
  write("mast.urdf", mastAndBoom("0.6", "0.4"));
  write("mast.yaml", "leeway: 1\nrobot: {urdf: mast.urdf}\nstart: [-1]\ngoal: [1]\n");
  write("sweep.csv", "-1\n1\n");
  EXPECT_EQ(run("plan mast.yaml --iterations 2000").status, 1);
  const json swept = run("verify mast.yaml sweep.csv --json").document();
  EXPECT_EQ(swept["status"], "refuted");
  EXPECT_EQ(swept["where"]["a"].get<std::string>() + swept["where"]["b"].get<std::string>(),
            "mastboom");
  const json state = run("check mast.yaml --state 0 --depth --json").document()["states"][0];
  EXPECT_NEAR(state["penetration"]["depth_lower"].get<double>(), 0.05, 1e-5);
}

TEST_F(Certificates, PairsThatAreNotCheckedAreCountedWithReasons) {
  // The boom turns on the mast, face to face.
  write("mast.urdf", mastAndBoom("0", "1.025"));
  write("mast.yaml", "leeway: 1\nrobot: {urdf: mast.urdf}\nstart: [-1]\ngoal: [1]\n");
  const Answer text = run("plan mast.yaml --output p.json");
  EXPECT_EQ(text.status, 0) << text.out;
  EXPECT_TRUE(has(text.flat(),
                  " 5 pairs are not checked: 2 rigidly attached to each other, 1 adjacent, 1 "
                  "touching in every configuration, 1 touching at every sampled configuration "
                  "(mast and boom). "))
      << text.out;
  const json expected = {
      {"pairs", 5},
      {"reasons", json::array({{{"reason", "rigidly attached to each other"}, {"pairs", 2}},
                               {{"reason", "adjacent"}, {"pairs", 1}},
                               {{"reason", "touching in every configuration"}, {"pairs", 1}},
                               {{"reason", "touching at every sampled configuration"},
                                {"pairs", 1},
                                {"names", json::array({json::array({"mast", "boom"})})}}})}};
  EXPECT_EQ(run("plan mast.yaml --json").document()["certificate"]["not_checked"], expected);
  EXPECT_EQ(json::parse(read("p.json"))["certificate"]["not_checked"], expected);
  EXPECT_EQ(run("clearance mast.yaml p.json --json").document()["not_checked"], expected);
  EXPECT_EQ(run("check mast.yaml --json").document()["not_checked"], expected);
  EXPECT_EQ(run("batch mast.yaml").lines().at(0)["certificate"]["not_checked"], expected);
  EXPECT_EQ(run("replan mast.yaml --json").lines().back()["not_checked"], expected);
  EXPECT_TRUE(has(run("replan mast.yaml --text").flat(), " 5 pairs are not checked: 2 rigidly "));
  // The verifier finds them for itself, and takes no proof for granted.
  const json verified = run("verify mast.yaml p.json --json").document()["not_checked"];
  EXPECT_EQ(verified["pairs"], 5);
  EXPECT_EQ(verified["reasons"][2],
            json({{"reason", "touching at every sampled configuration"},
                  {"pairs", 2},
                  {"names", json::array({json::array({"mast", "turret"}),
                                         json::array({"mast", "boom"})})}}));
  EXPECT_TRUE(has(run("info mast.urdf").out,
                  "1 left out: touching at every sampled configuration\n    mast with boom\n"));
  EXPECT_TRUE(has(run("view mast.yaml p.json --svg v.svg").out, "5 pairs are not checked"));
  // With an SRDF, too.
  EXPECT_EQ(
      run("plan reach.yaml --json").document()["certificate"]["not_checked"],
      json({{"pairs", 1}, {"reasons", json::array({{{"reason", "adjacent"}, {"pairs", 1}}})}}));
}

/// Regression: a boom that grazed the mast at zero counted as a part that rests on it, and was
/// swept deep into it, certified.
TEST_F(Certificates, PartsThatTouchAtZeroOnlyAreCheckedWithAWarning) {
  // The mast's side and the boom's are together at zero, and the boom turns into the mast.
  std::string urdf = mastAndBoom("0.6", "0.4");
  const std::string aside = "<origin xyz=\"0.6 0.0499 0\"/>";
  urdf.replace(urdf.find("<origin xyz=\"0.6 0 0\"/>"), 23, aside);
  write("mast.urdf", urdf);
  write("mast.yaml", "leeway: 1\nrobot: {urdf: mast.urdf}\nstart: [-1]\ngoal: [-0.5]\n");
  write("sweep.csv", "-1\n1\n");
  const std::string warning = "links 'mast' and 'boom' touch at the zero configuration";
  for (const char* command : {"plan mast.yaml", "verify mast.yaml sweep.csv", "info mast.yaml",
                              "check mast.yaml --state start", "lint mast.yaml"}) {
    const Answer answer = run(command);
    EXPECT_TRUE(has(answer.err + answer.out, warning)) << command << answer.err << answer.out;
  }
  EXPECT_EQ(run("verify mast.yaml sweep.csv --json").document()["status"], "refuted");
  EXPECT_EQ(run("check mast.yaml --state 0").status, 1);
  // Where the zero configuration is the start, the warning says why it is not valid.
  write("zero.yaml", "leeway: 1\nrobot: {urdf: mast.urdf}\nstart: [0]\ngoal: [-0.5]\n");
  for (const char* command : {"plan zero.yaml", "batch zero.yaml", "replan zero.yaml"}) {
    const Answer answer = run(command);
    EXPECT_EQ(answer.status, 1) << command;
    EXPECT_TRUE(has(answer.err, warning)) << command << answer.err;
  }
  // Allowed by name, nothing is said.
  write("mast.yaml",
        "leeway: 1\nrobot: {urdf: mast.urdf}\nstart: [-1]\ngoal: [-0.5]\n"
        "allowed: [[mast, boom]]\n");
  EXPECT_FALSE(has(run("check mast.yaml --state 0").err, warning));
  EXPECT_EQ(run("check mast.yaml --state 0").status, 0);
}

/// Regression: a robot without collision shapes was certified, with exit status 0.
TEST_F(Certificates, NothingCheckedIsNeverCertified) {
  const std::string joint =
      "<joint name=\"turn\" type=\"revolute\"><parent link=\"base\"/><child link=\"arm\"/><axis "
      "xyz=\"0 0 1\"/><limit lower=\"-1.5\" upper=\"1.5\" effort=\"1\" velocity=\"1\"/></joint>";
  const std::string visual = "<visual><geometry><box size=\"1 1 1\"/></geometry></visual>";
  write("visual.urdf", "<robot name=\"r\"><link name=\"base\">" + visual +
                           "</link><link name=\"arm\">" + visual + "</link>" + joint + "</robot>");
  write("bare.urdf",
        "<robot name=\"r\"><link name=\"base\"/><link name=\"arm\"/>" + joint + "</robot>");
  write(
      "base.urdf",
      "<robot name=\"r\"><link name=\"base\"><collision><geometry><box size=\"1 1 1\"/></geometry>"
      "</collision></link><link name=\"arm\"/>" +
          joint + "</robot>");
  write("path.csv", "-1\n1\n");
  for (const std::string name : {"visual", "bare", "base"})
    for (const std::string objects : {"", "objects: [{name: room, box: {size: [10, 10, 10]}}]\n"}) {
      write("p.yaml",
            "leeway: 1\nrobot: {urdf: " + name + ".urdf}\nstart: [-1]\ngoal: [1]\n" + objects);
      for (const char* verb : {"plan p.yaml", "verify p.yaml path.csv", "check p.yaml",
                               "clearance p.yaml path.csv", "replan p.yaml"}) {
        const Answer answer = run(std::string(verb) + " --json");
        EXPECT_EQ(answer.status, 1) << verb;
        EXPECT_EQ(answer.lines().back()["status"], "nothing_checked") << verb << answer.out;
        const Answer text = run(std::string(verb) + (verb[0] == 'r' ? " --text" : ""));
        EXPECT_EQ(text.status, 1) << verb;
        EXPECT_TRUE(has(text.out, "othing was checked") || has(text.out, "nothing checked"))
            << verb << text.out;
        EXPECT_FALSE(has(text.out, "ertified")) << verb << text.out;
        EXPECT_TRUE(has(text.err, "neither link \"arm\" nor any other that moves")) << text.err;
      }
      const json state = run("check p.yaml --json").document()["states"][0];
      EXPECT_EQ(state["valid"], false);
      EXPECT_EQ(state["verdict"], "nothing_checked");
      const json planned = run("plan p.yaml --json").document();
      EXPECT_EQ(planned["path"], nullptr);
      EXPECT_EQ(planned["certificate"], nullptr);
      EXPECT_TRUE(has(planned["reason"], "has a collision shape"));
      const Answer batch = run("batch p.yaml --verify");
      EXPECT_EQ(batch.status, 1);
      EXPECT_EQ(batch.lines().at(0)["status"], "nothing_checked");
      EXPECT_TRUE(has(batch.err, "1 with nothing to check")) << batch.err;
      for (const char* view : {"view p.yaml --svg v.svg", "view p.yaml path.csv --svg v.svg"}) {
        EXPECT_EQ(run(view).status, 1);
        EXPECT_TRUE(has(run(view).out, ": nothing checked\n")) << run(view).out;
      }
      const Answer solutions = run("ik p.yaml --link arm --position 0 0 0 --json");
      EXPECT_EQ(solutions.status, 1);
      EXPECT_EQ(solutions.document()["status"], "nothing_checked");
      EXPECT_EQ(solutions.document()["solutions"][0]["free"], false);
      const Answer lint = run("lint p.yaml");
      EXPECT_EQ(lint.status, 1);
      EXPECT_TRUE(has(lint.out, "nothing is checked: no link that moves")) << lint.out;
      EXPECT_TRUE(has(run("info p.yaml").out, "nothing is checked: no link that moves"));
    }
  for (const char* urdf : {"visual.urdf", "bare.urdf", "base.urdf"}) {
    const Answer lint = run(std::string("lint ") + urdf);
    EXPECT_EQ(lint.status, 1) << urdf;
    EXPECT_TRUE(has(lint.out, ".urdf:1: warning: neither link \"arm\" nor any other that moves"))
        << lint.out;
  }
}

}  // namespace
}  // namespace leeway::tools::testing
