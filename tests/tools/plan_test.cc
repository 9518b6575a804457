#include <limits>
#include <regex>

#include "leeway/planner/settings.h"
#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Plan : public CommandTest {};

void expectPlanFields(const json& document) {
  for (const char* key : {"status", "seed", "planner", "objective", "deterministic", "time_s",
                          "counts", "goal", "path", "length", "certificate"}) {
    EXPECT_TRUE(document.contains(key)) << key;
  }
  for (const char* key : {"load", "compile", "plan", "simplify", "push", "certify"}) {
    EXPECT_TRUE(document["time_s"].contains(key) && document["time_s"][key].is_number()) << key;
  }
  for (const char* key : {"iterations", "states", "edges", "distance_queries", "undecided_edges"}) {
    EXPECT_TRUE(document["counts"].contains(key) && document["counts"][key].is_number_unsigned())
        << key;
  }
}

TEST_F(Plan, ReachesAPose) {
  const std::string pose =
      "lower 0.27015115293406988 0.42073549240394825"
      " 0 0 0 0.58509727294046221 0.81096311950521793";
  const Answer answer = run("plan reach.yaml --json --goal-pose " + pose);
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["goal"], "--goal-pose");
  EXPECT_NEAR(document["path"]["positions"].back()[0], 1, 1e-8);
  EXPECT_NEAR(document["path"]["positions"].back()[1], 0.25, 1e-8);

  const Answer beyond = run("plan reach.yaml --json --goal-pose lower 3 0 0 0 0 0 1");
  EXPECT_EQ(beyond.status, 1) << beyond.err;
  EXPECT_EQ(beyond.document()["status"], "invalid_goal");
  EXPECT_EQ(beyond.document()["unreachable"], true);

  EXPECT_EQ(run("check reach.yaml --goal-pose " + pose).status, 0);
  EXPECT_EQ(run("check reach.yaml --goal-pose lower 3 0 0 0 0 0 1").status, 1);
  for (const char* bad : {"lowr 0 0 0 0 0 0 1", "lower 0 0 0 0 0 0 2", "lower 0 0 x 0 0 0 1",
                          "lower 0 0 0 0 0 0", "base 0 0 0 0 0 0 1"})
    EXPECT_EQ(run(std::string("plan reach.yaml --goal-pose ") + bad).status, 2) << bad;
}

TEST_F(Plan, SolvesAndCertifies) {
  const Answer answer = run("plan reach.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  expectPlanFields(document);
  EXPECT_EQ(document["status"], "solved");
  EXPECT_EQ(document["seed"], 7);
  EXPECT_EQ(document["planner"], "Connect");
  EXPECT_EQ(document["goal"], "left");
  const json& path = document["path"];
  EXPECT_EQ(path["joint_names"], json({"shoulder", "elbow"}));
  EXPECT_EQ(path["positions"].front(), json({-1, 0}));
  EXPECT_EQ(path["positions"].back(), json({1, 0.25}));
  const json& certificate = document["certificate"];
  EXPECT_EQ(certificate["certified"], true);
  EXPECT_EQ(certificate["segments"].size() + 1, path["positions"].size());
  double least = certificate["segments"][0]["clearance_lower"];
  for (const json& segment : certificate["segments"]) {
    least = std::min(least, segment["clearance_lower"].get<double>());
    EXPECT_GE(segment["clearance_lower"], 0);
    // Null: not looked for.
    EXPECT_TRUE(segment["clearance_upper"].is_null() ||
                segment["clearance_upper"] >= segment["clearance_lower"]);
  }
  EXPECT_EQ(certificate["clearance_lower"], least);
  double parts = std::numeric_limits<double>::infinity();
  for (const char* part : {"world", "self"})
    if (!certificate[part]["clearance_lower"].is_null())
      parts = std::min(parts, certificate[part]["clearance_lower"].get<double>());
  EXPECT_EQ(certificate["clearance_lower"], parts);
  EXPECT_EQ(certificate["world"]["closest"]["b"], "post");
  EXPECT_EQ(certificate["closest"]["b"], "post");
  EXPECT_TRUE(certificate["closest"].contains("a") && certificate["closest"].contains("segment") &&
              certificate["closest"].contains("t"));
  // Where: the points' distance is the certificate's. When: within the motion.
  const json &a = certificate["closest"]["point_a"], &b = certificate["closest"]["point_b"];
  double squared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double difference = a[i].get<double>() - b[i].get<double>();
    squared += difference * difference;
  }
  EXPECT_NEAR(std::sqrt(squared), certificate["clearance_upper"].get<double>(), 1e-4);
  // A blend may leave the place out; the motion that stops at corners passes it.
  const json stops = run("plan reach.yaml --json --corners stop").document();
  EXPECT_GE(stops["certificate"]["closest"]["time"], 0);
  EXPECT_LE(stops["certificate"]["closest"]["time"], stops["trajectory"]["duration"]);
  if (!certificate["closest"]["time"].is_null()) {
    EXPECT_LE(certificate["closest"]["time"], document["trajectory"]["duration"]);
  }
}

TEST_F(Plan, AFullCertificateHasEachEdge) {
  const json path = run("plan reach.yaml --json").document();
  const json full = run("plan reach.yaml --json --certificate full").document();
  EXPECT_EQ(full["path"], path["path"]);
  for (const json& segment : full["certificate"]["segments"]) {
    const double lower = segment["clearance_lower"], upper = segment["clearance_upper"];
    EXPECT_GE(upper, lower);
    EXPECT_LE(upper, lower + 1e-4 + 1e-12);
  }
  EXPECT_LE(path["certificate"]["clearance_lower"], full["certificate"]["clearance_upper"]);
  EXPECT_GE(path["certificate"]["clearance_upper"], full["certificate"]["clearance_lower"]);
  EXPECT_EQ(run("plan reach.yaml --certificate some").status, 2);
}

TEST_F(Plan, PushesUnlessToldNotToAndKeepsAFloor) {
  const std::string pick = "plan '" + leeway::sourceFolder() + "/problems/bin/pick.yaml' --json ";
  const json pushed = run(pick).document();
  const json plain = run(pick + "--no-push").document();
  EXPECT_EQ(plain["time_s"]["push"].get<double>() < 1e-4, true);
  EXPECT_LE(pushed["length"].get<double>(), 1.0301 * plain["length"].get<double>());
  EXPECT_GT(pushed["certificate"]["world"]["clearance_lower"],
            plain["certificate"]["world"]["clearance_lower"]);
  const json kept = run("plan reach.yaml --json --keep 0.03").document();
  EXPECT_GE(kept["certificate"]["world"]["clearance_lower"], 0.03);
  EXPECT_EQ(run("plan reach.yaml --keep -1").status, 2);
  EXPECT_EQ(run("plan reach.yaml --keep 0.03 --objective clearance").status, 2);
}

/// Every setting that has an option can be given, and is explained.
TEST_F(Plan, TakesEverySettingThatHasAnOption) {
  const std::string help = run("plan --help").out;
  for (const planner::Setting& setting : planner::settings()) {
    if (setting.option.empty()) continue;
    const std::string option(setting.option);
    EXPECT_NE(help.find(option + " "), std::string::npos) << option;
    std::string value = "1";
    if (setting.name == "planner") value = "RRTConnect";
    if (setting.name == "objective") value = "clearance --time 0.2";
    if (setting.name == "corners") value = "stop";
    if (setting.unit == "m" || setting.name == "at_most_longer") value = "0.01 --time 0.5";
    if (std::holds_alternative<planner::SettingPlace<bool>>(setting.value)) value = "";
    EXPECT_NE(run("plan reach.yaml " + option + " " + value).status, 2) << option;
    if (!value.empty()) {
      EXPECT_EQ(run("plan reach.yaml " + option + " ''").status, 2) << option;
    }
  }
}

TEST_F(Plan, IsAsSafeAsItsLengthAllows) {
  const std::string pick = "plan '" + leeway::sourceFolder() + "/problems/bin/pick.yaml' --json ";
  const json plain = run(pick).document();
  EXPECT_TRUE(plain["shortest_length"].is_null());
  const json safe = run(pick + "--at-most-longer 0.2 --time 1").document();
  EXPECT_EQ(safe["objective"], "clearance");
  EXPECT_LE(safe["length"].get<double>(), 1.2 * safe["shortest_length"].get<double>() + 1e-9);
  EXPECT_GE(safe["certificate"]["world"]["clearance_lower"],
            plain["certificate"]["world"]["clearance_lower"]);
  for (const char* wrong : {"--at-most-longer -1", "--at-most-longer 0.2 --objective length",
                            "--at-most-longer 0.2 --keep 0.03"}) {
    EXPECT_EQ(run(pick + wrong).status, 2) << wrong;
  }
}

TEST_F(Plan, TellsCostsAndWishes) {
  const json plain = run("plan reach.yaml --json").document();
  EXPECT_TRUE(plain["cost"].is_null());
  EXPECT_EQ(plain["wishes"], json::array());
  const json cost =
      run("plan reach.yaml --json --hinge 0.2 --length-weight 0.5 --time 0.5").document();
  EXPECT_EQ(cost["objective"], "weighted");
  EXPECT_GT(cost["cost"]["lower"], 0);
  EXPECT_LE(cost["cost"]["upper"].get<double>(), 1.02 * cost["cost"]["lower"].get<double>());
  EXPECT_EQ(run("plan reach.yaml --json --inverse 0.02 --time 0.2").document()["objective"],
            "integral");
  for (const char* wrong :
       {"--hinge 0", "--hinge 0.1 --inverse 0.1", "--length-weight 1", "--hinge 0.1 --keep 0.1",
        "--hinge 0.1 --objective length", "--hinge 0.1 --planner LBTRRT"})
    EXPECT_EQ(run(std::string("plan reach.yaml ") + wrong).status, 2) << wrong;
  write("wish.yaml",
        std::string(kReach) + "margins: [{between: [robot, post], wish: 0.05, weight: 2}]\n");
  const json wished = run("plan wish.yaml --json --time 0.5").document();
  ASSERT_EQ(wished["wishes"].size(), 1U);
  const json& wish = wished["wishes"][0];
  EXPECT_EQ(wish["between"], "robot and post");
  EXPECT_EQ(wish["wish"], 0.05);
  ASSERT_TRUE(wish["kept"].is_boolean());
  EXPECT_EQ(wish["kept"].get<bool>(), wish["clearance_lower"].get<double>() >= 0.05);
  const Answer text = run("plan wish.yaml --time 0.5");
  EXPECT_NE(text.out.find("Wish of 50 mm between robot and post: "), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("Cost between "), std::string::npos);
  EXPECT_EQ(run("plan wish.yaml --objective clearance").status, 2);
}

TEST_F(Plan, WritesTrajectories) {
  const Answer stop = run("plan reach.yaml --json --corners stop --trajectory stop.json");
  EXPECT_EQ(stop.status, 0) << stop.err;
  write("blend.yaml", std::string(kReach) + "execution: {accelerations: 5, jerks: 50}\n");
  const Answer blend = run("plan blend.yaml --json --trajectory blend.json --period 0.01");
  EXPECT_EQ(blend.status, 0) << blend.err;
  const json stopping = stop.document()["trajectory"], blending = blend.document()["trajectory"];
  EXPECT_EQ(stopping["blended_corners"], json::array());
  EXPECT_GE(blending["blended_corners"].size(), 1U);
  const json points = json::parse(readText(path("blend.json")))["points"];
  const json& last = points.back()["time_from_start"];
  EXPECT_NEAR(last["sec"].get<double>() + last["nanosec"].get<double>() * 1e-9,
              blending["duration"].get<double>(), 1e-9);
  EXPECT_EQ(points[0]["velocities"].size(), 2U);
  // The verifier proves its cubics.
  EXPECT_EQ(run("verify blend.yaml blend.json").status, 0);
  EXPECT_EQ(json::parse(readText(path("blend.json")))["certificate"]["interpolation"], "cubic");
  const auto takes = [&](const std::string& options) {
    const Answer answer = run("plan blend.yaml --json " + options);
    EXPECT_EQ(answer.status, 0) << answer.err;
    return answer.document()["trajectory"]["duration"].get<double>();
  };
  EXPECT_GT(takes("--corners stop"), takes(""));
  EXPECT_GT(takes("--speed 0.2"), takes("") * 1.2);
  EXPECT_GT(takes("--acceleration-scale 0.1"), takes("") * 1.2);
  EXPECT_GT(takes("--jerk-scale 0.01"), takes("") * 1.2);
  for (const char* wrong :
       {"--speed 2", "--acceleration-scale 0", "--jerk-scale -1", "--corners round"})
    EXPECT_EQ(run(std::string("plan blend.yaml ") + wrong).status, 2) << wrong;
  EXPECT_NE(run("plan blend.yaml").out.find("corners blended"), std::string::npos);
  for (const char* wrong : {"plan reach.yaml --trajectory x.path", "plan reach.yaml --period 0.1",
                            "plan reach.yaml --trajectory none/x.csv"})
    EXPECT_EQ(run(wrong).status, 2) << wrong;
}

TEST_F(Plan, NothingToBeNearIsNull) {
  const Answer answer = run("plan empty.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_TRUE(document["certificate"]["clearance_lower"].is_null());
  EXPECT_TRUE(document["certificate"]["clearance_upper"].is_null());
  EXPECT_TRUE(document["certificate"]["closest"].is_null());
  EXPECT_EQ(answer.out.find("inf"), std::string::npos);
  EXPECT_EQ(run("plan empty.yaml").out.find("inf"), std::string::npos);
}

TEST_F(Plan, SameSeedSamePath) {
  const auto path = [&](const std::string& arguments) {
    return run("plan reach.yaml --json " + arguments).document()["path"];
  };
  EXPECT_EQ(path("--seed 3"), path("--seed 3"));
  EXPECT_EQ(run("plan reach.yaml --json --seed 3").document()["seed"], 3);
}

TEST_F(Plan, TextHasPathCertificateAndTimes) {
  const Answer answer = run("plan reach.yaml");
  EXPECT_EQ(answer.status, 0);
  EXPECT_EQ(answer.err, "");  // no progress when stderr is not a terminal
  for (const char* word :
       {"around the post: certified, least clearance", "Solved with", "seed 7", "shoulder", "elbow",
        ">= ", "Nearest to the world", "post", "Time [ms]", "distance queries"}) {
    EXPECT_NE(answer.out.find(word), std::string::npos) << word << "\n" << answer.out;
  }
}

TEST_F(Plan, RobotAndGroupStatesNeedNoYaml) {
  const Answer answer =
      run("plan --robot arm.urdf --srdf arm.srdf --group arm --start right --goal left --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.document()["status"], "solved");
  expectRefused("plan --robot arm.urdf --srdf arm.srdf --group leg --start right --goal left",
                {"leg", "arm"});
  expectRefused("plan --robot arm.urdf --srdf arm.srdf --group arm --start rigt --goal left",
                {"rigt", "right"});
}

TEST_F(Plan, MoveitSceneAndRequest) {
  write("scene.yaml", kScene);
  write("request.yaml", kRequest);
  const Answer answer =
      run("plan --robot arm.urdf --srdf arm.srdf --scene scene.yaml --request request.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["path"]["positions"].front(), json({-1, 0}));
  EXPECT_EQ(document["certificate"]["closest"]["b"], "post");
}

TEST_F(Plan, InvalidStartNamesPairDepthAndPlace) {
  write("bad.yaml", kInvalidStart);
  const Answer answer = run("plan bad.yaml --json");
  EXPECT_EQ(answer.status, 1);
  const json document = answer.document();
  expectPlanFields(document);
  EXPECT_EQ(document["status"], "invalid_start");
  EXPECT_TRUE(document["path"].is_null());
  const json& offending = document["offending"];
  EXPECT_EQ(offending["a"], "lower");
  EXPECT_EQ(offending["b"], "post");
  // The box ends at x = 0.95, the post's near side is at x = 0.8, their half widths sum to 0.07.
  EXPECT_NEAR(offending["depth"], 0.07, 1e-6);
  EXPECT_EQ(offending["point_a"].size(), 3u);
  const std::string text = run("plan bad.yaml").out;
  for (const char* word : {"start", "collision", "lower", "post", "mm deep", "at ("}) {
    EXPECT_NE(text.find(word), std::string::npos) << word << "\n" << text;
  }
}

TEST_F(Plan, InvalidGoalIsStatus1) {
  std::string text = kInvalidStart;
  text.replace(text.find("start: {shoulder: 0, elbow: 0}\ngoal: left"), 41,
               "start: left\ngoal: {shoulder: 0, elbow: 0}");
  write("bad.yaml", text);
  const Answer answer = run("plan bad.yaml --json");
  EXPECT_EQ(answer.status, 1) << answer.err;
  EXPECT_EQ(answer.document()["status"], "invalid_goal");
  EXPECT_EQ(answer.document()["offending"]["b"], "post");
}

/// Margins differ: the pair that breaks its own is not the closest one.
TEST_F(Plan, NamesThePairThatBreaksItsMargin) {
  const std::string robot = leeway::sourceFolder() + "/robots/arm7/arm7";
  write(
      "margins.yaml",
      "leeway: 1\nrobot: {urdf: " + robot + ".urdf, srdf: " + robot +
          ".srdf, group: arm}\nstart: [-0.8, 0.4, 0, -1.6, 0, 1.1416, 0]\n"
          "goal: [0.8, 0.4, 0, -1.6, 0, 1.1416, 0]\n"
          "objects: [{name: post, position: [0.5, 0, 0.5], cylinder: {radius: 0.05, length: 1}}]\n"
          "margin: 0.01\nmargins: [{between: [hand, post], margin: 0.3}]\n");
  const Answer answer = run("plan margins.yaml --json");
  const json offending = answer.document()["offending"];
  EXPECT_EQ(offending["a"], "hand");
  EXPECT_EQ(offending["b"], "post");
  const std::string told = run("plan margins.yaml").out + run("lint margins.yaml").out;
  EXPECT_NE(told.find("hand and post"), std::string::npos) << told;
  EXPECT_EQ(told.find("link2 and link4"), std::string::npos) << told;
}

TEST_F(Plan, NoPathWithinTheLimitsIsStatus1) {
  // A wall without a way around: the arm is caged between two planes.
  std::string text = kReach;
  text.replace(text.find("  - {name: post"), text.find("limits") - text.find("  - {name: post"),
               "  - {name: wall, position: [0.3, 0, 0], box: {size: [0.2, 0.02, 1]}}\n");
  write("wall.yaml", text);
  const Answer answer = run("plan wall.yaml --time 0.2 --json");
  EXPECT_EQ(answer.status, 1) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["status"], "unsolved");
  EXPECT_TRUE(document["path"].is_null());
  EXPECT_TRUE(document["certificate"].is_null());
  ASSERT_FALSE(document["blocked"].empty());
  EXPECT_EQ(document["blocked"][0]["b"], "wall");
  EXPECT_EQ(document["gap"]["from"].size(), 2u);
  EXPECT_TRUE(document["long_turns"].empty());
  std::set<std::pair<std::string, std::string>> told_pairs;
  for (const auto& pair : document["blocked"])
    EXPECT_TRUE(told_pairs.emplace(pair["a"], pair["b"]).second) << document["blocked"];
  const std::string told = run("plan wall.yaml --time 0.2").out;
  for (const char* words :
       {"Most edges were blocked by: ", " and wall (", "Start and goal came within "})
    EXPECT_NE(told.find(words), std::string::npos) << told;
  EXPECT_TRUE(std::regex_search(
      run("plan wall.yaml --time 0.2").flat(),
      std::regex("of each other \\(distance of configurations\\), most of it in '[a-z]+' "
                 "\\([0-9.]+ rad\\)\\.")))
      << told;
}

TEST_F(Plan, LimitsOfJointsFromFilesAndOptions) {
  write("joint_limits.yaml",
        "joint_limits: {shoulder: {max_velocity: 0.25, min_position: -1, max_position: 2}}\n");
  const std::string info = "info arm.urdf --srdf arm.srdf --json";
  const auto variable = [&](const std::string& options) {
    const Answer answer = run(info + options);
    EXPECT_EQ(answer.status, 0) << answer.err;
    return answer.document()["robot"]["variables"][0];
  };
  json shoulder = variable(" --joint-limits joint_limits.yaml");
  EXPECT_EQ(shoulder["lower"], -1);
  EXPECT_EQ(shoulder["velocity"], 0.25);
  EXPECT_NE(shoulder["narrowed_by"].get<std::string>().find("joint_limits.yaml:1"),
            std::string::npos);
  shoulder = variable(" --joint-limits joint_limits.yaml --bounds shoulder -0.5 1.5");
  EXPECT_EQ(shoulder["lower"], -0.5);
  shoulder = variable(" --bounds shoulder -6 6 --widen shoulder");
  EXPECT_EQ(shoulder["upper"], 6);
  EXPECT_EQ(shoulder["narrowed_by"], "");
  EXPECT_NE(shoulder["widened_by"], "");
  EXPECT_NE(run("info arm.urdf --srdf arm.srdf --bounds shoulder -6 6 --widen shoulder")
                .out.find("shoulder: widened by "),
            std::string::npos);
  expectRefused(info + " --bounds shoulder -6 6",
                {"--bounds", "'shoulder'", "outside its own limits"});
  expectRefused(info + " --bounds shoulder -1 x", {"--bounds shoulder", "'x' is no finite number"});
  expectRefused(info + " --bounds shouldre -1 1", {"did you mean 'shoulder'"});
  expectRefused(info + " --bounds shoulder -1 1 --bounds shoulder 0 1", {"names 'shoulder' twice"});
  expectRefused(info + " --widen shoulder", {"--widen shoulder stands without its bounds"});
  expectRefused("plan reach.yaml --bounds shoulder -1 1", {"reach.yaml", "leave --bounds out"});
  // A path is verified within the same limits.
  const std::string robot =
      "--robot arm.urdf --srdf arm.srdf --group arm --start right --goal left";
  const Answer planned = run("plan " + robot + " --output path.json");
  EXPECT_EQ(planned.status, 0) << planned.err << planned.out;
  EXPECT_EQ(run("verify path.json " + robot).status, 0);
  const Answer narrow = run("verify path.json " + robot + " --bounds shoulder -0.1 0.1");
  EXPECT_NE(narrow.status, 0) << narrow.out;
}

TEST_F(Plan, WritesEveryFormat) {
  for (const std::string ending : {"yaml", "json", "csv", "path"}) {
    const Answer answer = run("plan reach.yaml --output out." + ending);
    EXPECT_EQ(answer.status, 0) << answer.err;
    EXPECT_NE(read("out." + ending), "");
    EXPECT_EQ(run("verify reach.yaml out." + ending).status, 0) << ending;
  }
}

TEST_F(Plan, ExistingOutputSurvivesFailure) {
  write("out.json", "precious");
  write("bad.yaml", kInvalidStart);
  EXPECT_EQ(run("plan bad.yaml --output out.json").status, 1);
  EXPECT_EQ(read("out.json"), "precious");
  expectRefused("plan missing.yaml --output out.json", {"missing.yaml"});
  EXPECT_EQ(read("out.json"), "precious");
}

TEST_F(Plan, OutputThatCannotBeWritten) {
  expectRefused("plan reach.yaml --output nowhere/out.json", {"nowhere"});
  expectRefused("plan reach.yaml --output out.doc", {"out.doc", ".json"});
  fs::create_directory(path("folder.json"));
  expectRefused("plan reach.yaml --output folder.json", {"folder.json"});
}

TEST_F(Plan, NoLeftoversBesideTheOutput) {
  EXPECT_EQ(run("plan reach.yaml --output out.json").status, 0);
  int others = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    others += entry.path().string().find("out.json") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(others, 1);
}

TEST_F(Plan, AGoalLeftOutIsToldOf) {
  std::string text = kReach;
  text.replace(text.find("goal: left"), 10, "goals: [left, [0, 0]]");
  write("goals.yaml", text);
  const Answer answer = run("plan goals.yaml --json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.err.find("warning: goal 'goal 2' is left out: lower and post collide there"),
            std::string::npos)
      << answer.err;
  EXPECT_EQ(answer.document()["warnings"].size(), 1U);
}

TEST_F(Plan, ListsPlanners) {
  const Answer answer = run("plan --planners");
  EXPECT_EQ(answer.status, 0) << answer.err;
  for (const char* name :
       {"RRTConnect", "PRMstar", "BITstar", "KPIECE1", "AnytimePathShortening"}) {
    EXPECT_NE(answer.out.find(name), std::string::npos) << name;
  }
  const json list = run("plan --planners --json").document()["planners"];
  EXPECT_GT(list.size(), 30u);
  expectRefused("plan reach.yaml --planner RRTConect", {"RRTConect", "RRTConnect"});
}

/// SIGTERM is what timeout(1) sends.
TEST_F(Plan, AnInterruptLeavesTheBestPathSoFar) {
  for (const char* signal : {"INT", "TERM"}) {
    const Answer answer =
        shell(std::string("timeout -s ") + signal + " 1 '" + leeway::commandFile() +
              "' plan reach.yaml --planner RRTstar --json --output out.json");
    const json document = answer.document();
    EXPECT_EQ(document["status"], "solved") << signal << answer.err;
    EXPECT_EQ(document["interrupted"], true);
    EXPECT_EQ(document["certificate"]["certified"], true);
    EXPECT_GT(document["time_s"]["simplify"], 0);
    EXPECT_LT(document["time_s"]["plan"], 10);
    EXPECT_EQ(run("verify reach.yaml out.json").status, 0);
    fs::remove(path("out.json"));
  }
}

/// timeout(1) signals its child, and then its group with the child in it: that is one interrupt.
TEST_F(Plan, ASignalSentTwiceAtOnceIsOneInterrupt) {
  const Answer answer = shell("'" + leeway::commandFile() +
                              "' plan reach.yaml --planner RRTstar --json --output out.json & "
                              "pid=$!; sleep 1; kill -INT $pid; sleep 0.05; kill -INT $pid; "
                              "wait $pid");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.document()["interrupted"], true);
  EXPECT_EQ(run("verify reach.yaml out.json").status, 0);
}

/// A file that takes seconds to read: nothing is done, and nothing written.
TEST_F(Plan, AnInterruptEndsReading) {
  std::string text = kReach;
  std::string objects = "objects:\n";
  for (int i = 0; i < 200'000; ++i)
    objects += "  - {name: b" + std::to_string(i) + ", position: [9, 9, 9], sphere: {radius: 1}}\n";
  write("big.yaml", text.replace(text.find("objects:\n"), 9, objects));
  // As soon as the command catches SIGINT (2, the second bit of the mask). Before it begins, the
  // process is a copy of the shell, and a signal ends it.
  const Answer answer = shell("'" + leeway::commandFile() +
                              "' plan big.yaml --output out.json --json & pid=$!; "
                              "for i in $(seq 1000); do "
                              "grep -qx leeway /proc/$pid/comm && "
                              "grep -q '^SigCgt:.*[2367abef]$' /proc/$pid/status && break; "
                              "sleep 0.01; done; kill -INT $pid; wait $pid");
  EXPECT_EQ(answer.status, 1) << answer.out << answer.err;
  EXPECT_NE(answer.err.find("interrupted; nothing was done"), std::string::npos) << answer.err;
  EXPECT_EQ(answer.document()["status"], "error");
  EXPECT_FALSE(fs::exists(path("out.json")));
}

TEST_F(Plan, NoPathTellsTheTimeThatPassed) {
  std::string text = kReach;
  text.replace(text.find("  - {name: post"), text.find("limits") - text.find("  - {name: post"),
               "  - {name: wall, position: [0.3, 0, 0], box: {size: [0.2, 0.02, 1]}}\n");
  write("wall.yaml", text);
  const Answer stopped = shell("timeout -s INT 2 '" + leeway::commandFile() + "' plan wall.yaml");
  EXPECT_NE(stopped.out.find("interrupted"), std::string::npos) << stopped.out;
  EXPECT_EQ(stopped.out.find("20 s"), std::string::npos) << stopped.out;
  const Answer answer = run("plan wall.yaml --iterations 10");
  EXPECT_EQ(answer.status, 1);
  EXPECT_NE(answer.flat().find("10 iterations (limits: 20 s, 10 iterations)"), std::string::npos)
      << answer.out;
}

TEST_F(Plan, NothingThatIsReadIsOverwritten) {
  fs::create_symlink("reach.yaml", path("link.yaml"));
  for (const char* file : {"reach.yaml", "./reach.yaml", "link.yaml"})
    expectRefused(std::string("plan reach.yaml --output ") + file, {file, "overwritten"});
  expectRefused("plan reach.yaml --output a.json --trajectory ./a.json", {"./a.json", "twice"});
  EXPECT_EQ(read("reach.yaml"), kReach);
  EXPECT_FALSE(fs::exists(path("a.json")));
  ASSERT_EQ(run("plan reach.yaml --output path.csv").status, 0);
  const std::string before = read("path.csv");
  expectRefused("clearance reach.yaml path.csv --csv path.csv", {"path.csv", "overwritten"});
  EXPECT_EQ(read("path.csv"), before);
}

TEST_F(Plan, AFolderThatMayNotBeWrittenIsToldAtOnce) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::create_directory(path("kept"));
  fs::permissions(path("kept"), fs::perms::owner_read | fs::perms::owner_exec);
  expectRefused("plan reach.yaml --output kept/a.json", {"kept/a.json", "Permission denied"});
}

/// One warning names it where it has no effect.
TEST_F(Plan, ImproveIsLeftOutWhereItHasNoEffect) {
  const std::pair<const char*, const char*> kinds[] = {
      {"--planner RRTstar", "RRTstar has no such time"},
      {"--objective clearance", "the objective length"},
      {"--at-most-longer 1.1", "the objective length"},
      {"--hinge 0.1", "the objective length"},
      {"--upright upper z 3", "it keeps no constraints"}};
  for (const auto& [options, why] : kinds) {
    const Answer answer =
        run("plan reach.yaml --improve 1 --time 0.1 --json " + std::string(options));
    EXPECT_LE(answer.status, 1) << answer.err;
    const std::string told = "--improve 1 is left out: ";
    const std::size_t at = answer.err.find("warning: " + told);
    EXPECT_NE(at, std::string::npos) << answer.err;
    EXPECT_NE(answer.err.find(why), std::string::npos) << answer.err;
    EXPECT_EQ(answer.err.find(told, at + told.size() + 9), std::string::npos) << answer.err;
    EXPECT_NE(answer.document()["warnings"].dump().find(told), std::string::npos);
  }
  EXPECT_EQ(run("plan reach.yaml --improve 0.01").err, "");
}

/// The moves of a task become shorter.
TEST_F(Plan, ImproveIsOfTasksToo) {
  const std::string carton =
      "plan " + leeway::sourceFolder() + "/problems/pick_place/carton.yaml --json --improve ";
  EXPECT_LT(run(carton + "2").document()["length"], run(carton + "0").document()["length"]);
}

// A file's, too.
TEST_F(Plan, ImproveOfAFileIsOfTheObjectiveLength) {
  const std::string improve = "planner: {parameters: {improve: 0.01}}\n";
  write("improve.yaml", kReach + improve);
  EXPECT_EQ(run("plan improve.yaml").status, 0);
  const std::vector<std::string> expected = {"'improve' is 0.01", "objective length"};
  const auto expectRefusedFile = [&](const std::string& text) {
    write("odd.yaml", text);
    expectRefused("plan odd.yaml", expected);
    expectRefused("check odd.yaml", {"odd.yaml:10:"});
  };
  expectRefusedFile(kReach + improve + "objective: clearance\n");
  expectRefusedFile(kReach + improve + "objective: {integral: {hinge: 0.1}}\n");
  expectRefusedFile(kReach + improve +
                    "margins: [{between: [robot, post], margin: 0.01, wish: 0.05}]\n");
  expectRefused("plan improve.yaml --objective clearance", expected);
  EXPECT_EQ(run("plan improve.yaml --objective clearance --improve 0 --time 0.1").status, 0);
}

}  // namespace
}  // namespace leeway::tools::testing
