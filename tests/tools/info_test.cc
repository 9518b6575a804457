#include <fmt/format.h>

#include <sstream>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Info : public CommandTest {};

/// A tetrahedron, complete or without one side.
std::string tetrahedron(bool closed) {
  return std::string("v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n") +
         (closed ? "f 2 3 4\n" : "");
}

TEST_F(Info, Urdf) {
  const Answer answer = run("info arm.urdf --srdf arm.srdf --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["robot"]["name"], "twolink");
  EXPECT_EQ(document["robot"]["links"], 3);
  EXPECT_EQ(document["robot"]["variables"].size(), 2u);
  EXPECT_EQ(document["robot"]["variables"][0]["lower"], -3);
  EXPECT_EQ(document["robot"]["disabled_pairs"], 1);
  EXPECT_EQ(document["geometries"].size(), 2u);
  EXPECT_EQ(document["compiled"]["pairs_kept"], 0);
  const std::string text = run("info arm.urdf --srdf arm.srdf").out;
  for (const char* word : {"twolink", "shoulder", "group arm", "right, left", "box", "compiled"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  }
}

/// As for plan.
TEST_F(Info, ProblemsMayBeJson) {
  write(
      "flow.json",
      R"({"leeway": 1, "robot": {"urdf": "arm.urdf", "srdf": "arm.srdf", "group": "arm"}, "start": [0, 0], "goal": [1, 0.5]})");
  for (const char* call : {"info flow.json", "fk flow.json", "lint flow.json",
                           "ik flow.json --link lower --position 0.6 0.4 0"})
    EXPECT_NE(run(call).status, 2) << call;
}

TEST_F(Info, AShippedRobotFitsOnOneScreen) {
  for (const char* robot : {"arm6", "arm7", "dual_arm", "snake10"}) {
    const std::string file = fmt::format("{0}/robots/{1}/{1}", leeway::sourceFolder(), robot);
    const std::string text = run(fmt::format("info {0}.urdf --srdf {0}.srdf", file)).out;
    std::istringstream lines(text);
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) EXPECT_LE(line.size(), 80u) << line;
    EXPECT_LE(count, 24) << text;
    // --all prints the rest.
    const std::string all = run(fmt::format("info {0}.urdf --srdf {0}.srdf --all", file)).out;
    EXPECT_EQ(all.find("--all"), std::string::npos) << all;
    EXPECT_NE(all.find("size [mm]"), std::string::npos) << all;
  }
}

TEST_F(Info, ShapesHaveDimensions) {
  std::string text = kReach;
  text.insert(text.find("limits"),
              "  - {name: ball, position: [0, -2, 0], sphere: {radius: 0.25}}\n"
              "  - {name: pill, position: [0, -3, 0], capsule: {radius: 0.1, length: 0.3}}\n"
              "  - {name: floor, position: [0, 0, -5], half_space: {}}\n");
  write("sizes.yaml", text);
  const json document = run("info sizes.yaml --json").document();
  int found = 0;
  for (const json& geometry : document["geometries"]) {
    const json& size = geometry["size"];
    if (geometry["of"] == "floor") {
      found += size.is_null() ? 1 : 0;
    } else if (geometry["of"] == "ball") {
      for (const json& edge : size) EXPECT_DOUBLE_EQ(edge.get<double>(), 0.5);
      ++found;
    } else if (geometry["of"] == "pill") {
      EXPECT_DOUBLE_EQ(size[0].get<double>(), 0.2);
      EXPECT_DOUBLE_EQ(size[2].get<double>(), 0.5);
      ++found;
    }
  }
  EXPECT_EQ(found, 3) << document["geometries"];
  EXPECT_NE(run("info sizes.yaml").out.find("500 x 500 x 500"), std::string::npos);
}

TEST_F(Info, SrdfFindsItsUrdf) {
  EXPECT_EQ(run("info arm.srdf --json").document()["robot"]["group_states"].size(), 2u);
  fs::remove(path("arm.urdf"));
  write("elsewhere/robot.urdf", kUrdf);
  expectRefused("info arm.srdf", {"arm.srdf", "twolink", "--robot"});
  EXPECT_EQ(run("info arm.srdf --robot elsewhere/robot.urdf").status, 0);
}

TEST_F(Info, Problem) {
  const json document = run("info reach.yaml --json").document();
  EXPECT_EQ(document["problem"]["objects"], json({"post"}));
  EXPECT_EQ(document["problem"]["goals"][0]["name"], "left");
  EXPECT_EQ(document["compiled"]["pairs_kept"], 2);
  EXPECT_GT(document["compiled"]["pairs_dropped"], 0);
  const std::string text = run("info reach.yaml").out;
  for (const char* word : {"around the post", "post", "cylinder", "left out"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  }
}

TEST_F(Info, ACloudIsOneEntry) {
  std::string points = "nan 0 0\n";
  for (int i = 0; i < 100; ++i) points += "0 " + std::to_string(0.001 * i) + " 0\n";
  write("scan.xyz", points);
  std::string text = kReach;
  text.replace(text.find("limits"), 0,
               "  - {name: seen, position: [0, -2, 0], cloud: {file: scan.xyz, radius: 0.01, thin: "
               "0.01}}\n");
  write("cloud.yaml", text);
  const Answer answer = run("info cloud.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.err.find("note: cloud 'seen' leaves out 1 points that are not numbers"),
            std::string::npos)
      << answer.err;
  const json cloud = answer.document()["problem"]["clouds"][0];
  EXPECT_EQ(cloud["name"], "seen");
  EXPECT_EQ(cloud["balls"], 10);
  EXPECT_TRUE(cloud["complete_within"].is_null());
  EXPECT_EQ(cloud["filters"][0]["removed"], 1);
  EXPECT_EQ(cloud["filters"][1]["name"], "thin");
  EXPECT_EQ(cloud["filters"][1]["removed"], 90);
  EXPECT_EQ(answer.document()["geometries"].size(),
            run("info reach.yaml --json").document()["geometries"].size());
  EXPECT_NE(run("info cloud.yaml").out.find("cloud seen: 10 balls of up to 14.5"),
            std::string::npos)
      << run("info cloud.yaml").out;
  // Answers say what filters left out, too.
  const Answer planned = run("plan cloud.yaml --output path.json --json");
  ASSERT_EQ(planned.status, 0) << planned.err;
  EXPECT_EQ(planned.document()["certificate"]["clouds"], json::array({cloud}));
  for (const char* verb : {"verify", "clearance"})
    EXPECT_EQ(run(std::string(verb) + " cloud.yaml path.json --json").document()["clouds"],
              json::array({cloud}))
        << verb;
  EXPECT_EQ(run("check cloud.yaml --state start --json").document()["clouds"],
            json::array({cloud}));
  write("wide.yaml", text + "margin: 9\n");  // no state is valid
  EXPECT_EQ(run("plan wide.yaml --json").document()["clouds"], json::array({cloud}));
  EXPECT_EQ(run("replan cloud.yaml --json").lines().back()["clouds"], json::array({cloud}));
  for (const char* verb : {"check", "plan", "lint"})
    EXPECT_LE(run(std::string(verb) + " cloud.yaml").status, 1) << verb;
  EXPECT_EQ(run("lint cloud.yaml").status, 0) << run("lint cloud.yaml").out;
  write("scan.xyz", "1 2 3\n1 2\n");
  expectRefused("plan cloud.yaml", {"scan.xyz:2", "2 columns"});
  fs::remove(path("scan.xyz"));
  expectRefused("plan cloud.yaml", {"scan.xyz", "no such file"});
}

TEST_F(Info, NamesComponentsThatAreNotClosed) {
  write("open.obj", tetrahedron(false));
  write("closed.obj", tetrahedron(true));
  std::string text = kReach;
  text.replace(text.find("limits"), 0,
               "  - {name: shell, position: [0, -2, 0], mesh: {file: open.obj}}\n"
               "  - {name: solid, position: [0, -3, 0], mesh: {file: closed.obj}}\n");
  write("mesh.yaml", text);
  const Answer answer = run("info mesh.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  int open = 0;
  for (const json& geometry : document["geometries"]) {
    if (geometry["type"] != "mesh") {
      continue;
    }
    EXPECT_EQ(geometry["components"], 1);
    EXPECT_EQ(geometry["closed_components"], geometry["of"] == "solid" ? 1 : 0);
    EXPECT_EQ(geometry["triangles"], geometry["of"] == "solid" ? 4 : 3);
    EXPECT_GT(geometry["bytes"], 100);
    open += static_cast<int>(geometry["open"].size());
  }
  EXPECT_EQ(open, 1);
  const std::string out = run("info mesh.yaml").out;
  const std::size_t section = out.find("not closed, so surfaces");
  ASSERT_NE(section, std::string::npos) << out;
  EXPECT_NE(out.find("shell", section), std::string::npos) << out;
  EXPECT_EQ(out.find("solid", section), std::string::npos) << out;
  // Twelve of them are cut short.
  text = text.substr(0, text.find("  - {name: shell"));
  for (char c = 'a'; c < 'm'; ++c)
    text += std::string("  - {name: ") + c + ", position: [0, -2, 0], mesh: {file: open.obj}}\n";
  write("many.yaml", text);
  const std::string few = run("info many.yaml").out, all = run("info many.yaml --all").out;
  EXPECT_NE(few.find("of i: component 0, 3 triangles\nand 3 more (--all)\n"), std::string::npos)
      << few;
  EXPECT_NE(all.find("of l: component 0, 3 triangles\n"), std::string::npos) << all;
}

TEST_F(Info, SamplesSuggestAndDropNothing) {
  // Without an SRDF and with the elbow's boxes set back, upper and lower never collide within the
  // limits, yet are adjacent.
  const json document = run("info arm.urdf --json --samples 100 --seed 4").document();
  EXPECT_EQ(document["compiled"]["samples"], 100);
  EXPECT_EQ(document["compiled"]["seed"], 4);
  expectRefused("info arm.urdf --samples -1", {"--samples: -1"});
}

TEST_F(Info, FilesThatItCannotRead) {
  expectRefused("info missing.urdf", {"missing.urdf"});
  write("robot.xacro", "<robot/>");
  expectRefused("info robot.xacro", {"xacro"});
  write("notes.txt", "hello");
  expectRefused("info notes.txt", {"notes.txt", ".urdf"});
}

}  // namespace
}  // namespace leeway::tools::testing
