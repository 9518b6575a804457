// --waypoints of the command: whole lines, lines that end early, and what is refused.
#include <string>

#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Waypoints : public CommandTest {
 protected:
  const std::string robot_ = "--robot " + leeway::sourceFolder() +
                             "/robots/arm7/arm7.urdf --srdf " + leeway::sourceFolder() +
                             "/robots/arm7/arm7.srdf --group arm --start ready ";
};

TEST_F(Waypoints, ALineIsPlannedVerifiedAndSeen) {
  write("way.csv", "x,y,z\n0.5,0.1,0.45\n0.5,-0.1,0.45\n");
  const std::string way = robot_ + "--waypoints way.csv --frame hand ";
  const Answer planned = run("plan " + way + "--json --output path.json");
  ASSERT_EQ(planned.status, 0) << planned.err;
  const json document = planned.document();
  EXPECT_EQ(document["status"], "solved");
  EXPECT_FALSE(document.contains("line_end"));
  EXPECT_EQ(document["path"]["steps"][0]["places"].back(), 2);
  EXPECT_LE(document["path"]["steps"][0]["deviation"], 1e-3);
  EXPECT_EQ(run("verify " + way + "path.json").status, 0);
  EXPECT_EQ(run("clearance " + way + "path.json").status, 0);
  EXPECT_EQ(run("view " + way + "path.json --output page.html").status, 0);

  // The same from a map that names its frame, in JSON and YAML.
  write("way.json", R"({"frame": "hand", "poses": [{"position": [0.5, 0.1, 0.45]}]})");
  EXPECT_EQ(run("plan " + robot_ + "--waypoints way.json").status, 0);
  write("way.yaml", "- {position: [0.5, 0.1, 0.45], rpy: [3, 0, 3]}\n");
  EXPECT_EQ(run("plan " + robot_ + "--waypoints way.yaml --frame hand").status, 0);
}

TEST_F(Waypoints, APartIsReturnedWithTheReason) {
  write("way.csv", "0.5 0.1 0.45\n0.5 0.1 2\n");
  const std::string way = robot_ + "--waypoints way.csv --frame hand ";
  const Answer planned = run("plan " + way + "--json --output path.json");
  EXPECT_EQ(planned.status, 1) << planned.err;
  const json document = planned.document();
  EXPECT_EQ(document["status"], "partial");
  EXPECT_EQ(document["line_end"]["step"], "waypoints");
  EXPECT_EQ(document["line_end"]["waypoint"], 1);
  EXPECT_GT(document["line_end"]["share"], 0);
  EXPECT_LT(document["line_end"]["share"], 1);
  EXPECT_TRUE(document["certificate"]["certified"]);
  const std::string reason = document["reason"];
  EXPECT_NE(reason.find("of the way to pose 2 of 2"), std::string::npos) << reason;
  const Answer text = run("plan " + way);
  EXPECT_EQ(text.status, 1);
  EXPECT_NE(
      text.out.find("Only a part of it, which is certified: step 1 (waypoints): it ends after"),
      std::string::npos)
      << text.out;
  const Answer verified = run("verify " + way + "path.json --json");
  EXPECT_EQ(verified.status, 1);
  EXPECT_EQ(verified.document()["status"], "refuted");
  EXPECT_EQ(run("clearance " + way + "path.json").status, 0);
  // As `verify`, the page says that the path is not the whole answer.
  const Answer seen = run("view " + way + "path.json --output page.html");
  EXPECT_EQ(seen.status, 1);
  EXPECT_NE(seen.out.find("what there is of it is certified"), std::string::npos) << seen.out;
}

TEST_F(Waypoints, WhatIsRefused) {
  write("way.csv", "0.5 0.1 0.45\n");
  write("bad.csv", "x,y,z\n0.5,0.1\n");
  const std::string with = "--waypoints way.csv ";
  const struct {
    std::string arguments;
    const char* message;
  } bad[] = {
      {with, "does not say which frame goes through its poses"},
      {with + "--frame hnd", "did you mean 'hand'?"},
      {with + "--frame base", "is not moved by the planned joints"},
      {with + "--frame hand --goal ready", "--goal and --waypoints both say where to go"},
      {with + "--frame hand --goal-pose hand 0 0 0 0 0 0 1", "both say where to go"},
      {"--waypoints bad.csv --frame hand", "bad.csv:2: the line has 2 columns; 3"},
      {"--waypoints none.csv --frame hand", "none.csv"},
      {"--frame hand --goal ready", "--waypoints"},
      {with + "--frame hand --upright hand z 0.1", "constraints beside steps"},
  };
  for (const auto& c : bad) {
    const Answer answer = run("plan " + robot_ + c.arguments);
    EXPECT_EQ(answer.status, 2) << c.arguments;
    EXPECT_NE(answer.err.find(c.message), std::string::npos) << answer.err;
  }
  // Steps say where to go already.
  const Answer task = run("plan " + leeway::sourceFolder() +
                          "/problems/pick_place/can.yaml --waypoints way.csv --frame grip");
  EXPECT_EQ(task.status, 2);
  EXPECT_NE(task.err.find("the problem has steps"), std::string::npos) << task.err;
}

}  // namespace
}  // namespace leeway::tools::testing
