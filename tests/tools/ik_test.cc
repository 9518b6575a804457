#include <cmath>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Ik : public CommandTest {};

TEST_F(Ik, AllBranchesAndBackByFk) {
  const Answer answer = run("ik arm.urdf --srdf arm.srdf --link lower --position 0.4 0.3 0 --json");
  // The frame of `lower` is at the elbow: 0.5 m from the shoulder.
  ASSERT_EQ(answer.status, 0) << answer.err;
  const json document = answer.document();
  EXPECT_EQ(document["status"], "found");
  EXPECT_EQ(document["joint_names"], json({"shoulder", "elbow"}));
  ASSERT_GE(document["solutions"].size(), 1u);
  for (const json& solution : document["solutions"]) {
    EXPECT_NEAR(solution["positions"][0].get<double>(), std::atan2(0.3, 0.4), 1e-9);
    EXPECT_LT(solution["position_error"], 1e-9);
  }
}

TEST_F(Ik, LimitsOfOtherJointsDoNotMatter) {
  write("limits.yaml", std::string(kReach) + "execution: {velocities: {elbow: 1}}\n");
  const Answer answer = run("ik limits.yaml --link upper --position 0 0 0");
  EXPECT_EQ(answer.status, 0) << answer.err;
}

TEST_F(Ik, ClearanceAndWhatIsInTheWay) {
  const std::string question = "--link lower --position 0.5 0 0 --rpy 0 0 0 --json";
  const json blocked = run("ik reach.yaml " + question).document();
  EXPECT_EQ(blocked["status"], "colliding");
  ASSERT_EQ(blocked["solutions"].size(), 1u);
  EXPECT_EQ(blocked["solutions"][0]["free"], false);
  EXPECT_LT(blocked["solutions"][0]["clearance_upper"], 0);
  EXPECT_EQ(blocked["solutions"][0]["closest"]["b"], "post");
  EXPECT_EQ(run("ik reach.yaml " + question).status, 1);
  const json free = run("ik empty.yaml " + question).document();
  EXPECT_EQ(free["status"], "found");
  EXPECT_EQ(free["solutions"][0]["clearance_lower"], nullptr);

  const Answer by_clearance = run(
      "ik reach.yaml --link lower --position -1:1 -1:1 0 --order clearance --solutions 5 --json");
  EXPECT_EQ(by_clearance.status, 0);
  const json document = by_clearance.document();
  double last = 1e9;
  for (const json& solution : document["solutions"]) {
    if (!solution["free"].get<bool>()) break;
    EXPECT_LE(solution["clearance_lower"].get<double>(), last);
    last = solution["clearance_lower"].get<double>();
  }
  EXPECT_LT(last, 1e9);
}

TEST_F(Ik, NoMeansNo) {
  const Answer far = run("ik arm.urdf --link lower --position 0.6 0 0 --json");
  EXPECT_EQ(far.status, 1);
  EXPECT_EQ(far.document()["status"], "unreachable");
  EXPECT_EQ(far.document()["proven"], true);
  EXPECT_NEAR(far.document()["nearest"]["position_error"].get<double>(), 0.1, 1e-6);
  const std::string text = run("ik arm.urdf --link lower --position 0.6 0 0").out;
  EXPECT_NE(text.find("unreachable: proven"), std::string::npos) << text;
  EXPECT_NE(text.find("100.00 mm"), std::string::npos) << text;
  // The shoulder turns by at most 3 rad: proven, too.
  EXPECT_EQ(
      run("ik arm.urdf --link upper --position 0 0 0 --rpy 0 0 3.1 --json").document()["status"],
      "unreachable");
}

TEST_F(Ik, SameBytes) {
  const std::string question =
      "ik reach.yaml --link lower --position -0.5:0.5 -0.5:0.5 0 --seed 3 --json";
  const std::string first = run(question).out;
  EXPECT_NE(first.find("\"seed\":3"), std::string::npos) << first;
  EXPECT_EQ(first, run(question).out);
}

TEST_F(Ik, Fk) {
  const json document =
      run("fk arm.urdf --link lower --state shoulder=1.5707963267948966 --json").document();
  EXPECT_NEAR(document["links"][0]["position"][1].get<double>(), 0.5, 1e-15);
  EXPECT_NEAR(document["links"][0]["rpy"][2].get<double>(), 1.5707963267948966, 1e-15);
  EXPECT_NEAR(document["links"][0]["quaternion"][3].get<double>(), std::sqrt(0.5), 1e-15);
  EXPECT_EQ(run("fk reach.yaml --state left --json").document()["links"].size(), 3u);
  EXPECT_EQ(run("fk reach.yaml --state left --json").document()["configuration"],
            json({1.0, 0.25}));
  const std::string table = run("fk reach.yaml --state 0,0").out;
  EXPECT_NE(table.find("lower  0.500000"), std::string::npos) << table;
}

TEST_F(Ik, BadInput) {
  const std::string good = "ik arm.urdf --link lower --position 0.4 0.3 0 ";
  expectRefused("ik arm.urdf --position 0 0 0", {"--link"});
  expectRefused("ik arm.urdf --link lower", {"--position"});
  expectRefused("ik arm.urdf --link hand --position 0 0 0", {"hand", "base, upper, lower"});
  expectRefused("ik arm.urdf --link base --position 0 0 0", {"base", "no planned joint moves it"});
  expectRefused("ik arm.urdf --link lower --position 0 0 any", {"--position", "any"});
  expectRefused("ik arm.urdf --link lower --position 0 0 nan", {"--position", "nan"});
  expectRefused("ik arm.urdf --link lower --position 0 0 2:1", {"2:1", "greater end"});
  expectRefused(good + "--rpy 0 0 1e999", {"--rpy", "1e999"});
  expectRefused(good + "--quaternion 0 0 0 2", {"--quaternion", "length is 2"});
  expectRefused(good + "--quaternion 0 0 0 1 --rpy 0 0 0", {"--rpy and --quaternion"});
  expectRefused(good + "--group legs", {"legs"});
  expectRefused(good + "--srdf arm.srdf --group amr", {"'amr'", "did you mean 'arm'?"});
  expectRefused(good + "--state up", {"'up'"});
  expectRefused(good + "--state knee=1", {"knee=1"});
  expectRefused(good + "--state elbow=1,elbow=2", {"'elbow' twice"});
  expectRefused(good + "--solutions 0", {"--solutions 0"});
  expectRefused(good + "--starts 0", {"--starts 0"});
  expectRefused(good + "--order best", {"--order"});
  expectRefused("fk arm.urdf --link hand", {"hand"});
  expectRefused("fk arm.txt", {"arm.txt"});
}

}  // namespace
}  // namespace leeway::tools::testing
