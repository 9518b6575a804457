// The pairs of links that are checked in a robot without an SRDF. The verifier must find the same
// pairs.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/compiled_scene.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/motion_bound.h"
#include "leeway/robots/placed_model.h"
#include "planner/verify/pairs.h"
#include "robots/model/model_builder.h"
#include "tests/support/folder.h"
#include "tests/support/random_model.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using robots::JointType;

std::string link(const std::string& name, const std::string& shape, const std::string& xyz) {
  return "<link name=\"" + name + "\"><collision><origin xyz=\"" + xyz + "\"/><geometry>" + shape +
         "</geometry></collision></link>\n";
}
std::string box(const std::string& size) { return "<box size=\"" + size + "\"/>"; }
std::string fixed(const std::string& parent, const std::string& child, const std::string& xyz) {
  return "<joint name=\"" + child + "_joint\" type=\"fixed\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/><origin xyz=\"" + xyz + "\"/></joint>\n";
}
/// A joint that turns about z.
std::string turning(const std::string& parent, const std::string& child, const std::string& type,
                    const std::string& rest = "") {
  return "<joint name=\"" + child + "_joint\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/><axis xyz=\"0 0 1\"/>" + rest + "</joint>\n";
}
std::string limits(const std::string& lower, const std::string& upper) {
  return "<limit lower=\"" + lower + "\" upper=\"" + upper + "\" effort=\"1\" velocity=\"1\"/>";
}

/// A boom on a turret, and a mast on the same base that is as tall as the boom is high.
std::string mastAndBoom(const std::string& mast_xyz, const std::string& type,
                        const std::string& rest) {
  return "<robot name=\"mast_boom\">" + link("base", box("0.2 0.2 0.1"), "0 0 0") +
         link("mast", box("0.05 0.05 1"), "0 0 0.5") + fixed("base", "mast", mast_xyz) +
         link("turret", box("0.1 0.1 0.1"), "0 0 0.15") + turning("base", "turret", type, rest) +
         link("boom", box("1 0.05 0.05"), "0.5 0 0") + fixed("turret", "boom", "0 0 0.4") +
         "</robot>";
}

const char* const kAlways = "touching in every configuration";
const char* const kSampled = "touching at every sampled configuration";

class NeighbourPairs : public ::testing::Test {
 protected:
  std::shared_ptr<const robots::Model> load(const std::string& urdf, const std::string& srdf = "") {
    return robots::loadModel(folder_.write("r.urdf", urdf),
                             srdf.empty() ? "" : folder_.write("r.srdf", srdf));
  }
  static Problem problemOf(const std::shared_ptr<const robots::Model>& model) {
    const std::vector<double> q = model->defaultConfiguration();
    return test::problemOf(model, q, q);
  }
  /// The reason why a pair is left out; empty: it is checked. The verifier must agree, although it
  /// has no proofs for pairs that always touch.
  static std::string why(const std::shared_ptr<const robots::Model>& model, const std::string& a,
                         const std::string& b) {
    const Problem problem = problemOf(model);
    const auto reasonIn = [&](const std::vector<CompiledScene::Dropped>& dropped) {
      for (const CompiledScene::Dropped& d : dropped)
        if ((d.a == a && d.b == b) || (d.a == b && d.b == a)) return std::string(toString(d.why));
      return std::string();
    };
    const std::string ours = reasonIn(CompiledScene(problem).dropped());
    const std::string theirs = reasonIn(
        verification::collectPairs(problem, verification::collectBodies(problem)).unchecked);
    const std::string expected = ours == kAlways ? kSampled : ours;
    EXPECT_EQ(theirs, expected) << a << " and " << b;
    return ours;
  }
  Folder folder_;
};

/// Regression: all links of the two rigid blocks counted as adjacent, and the boom swept through
/// the mast, certified.
TEST_F(NeighbourPairs, WhatAJointCarriesThroughAPartOfTheRobotIsChecked) {
  const auto model = load(mastAndBoom("0.6 0 0", "revolute", limits("-1.5", "1.5")));
  EXPECT_EQ(why(model, "mast", "boom"), "") << "they overlap at zero, and are apart on either side";
  EXPECT_EQ(why(model, "base", "turret"), "adjacent");
  EXPECT_EQ(why(model, "base", "mast"), "rigidly attached to each other");
  EXPECT_EQ(why(model, "turret", "boom"), "rigidly attached to each other");
  Problem problem = problemOf(model);
  problem.start = {-1};
  problem.goals = {test::pointGoal("goal", {1})};
  problem.limits.time = 0.2;
  EXPECT_EQ(plan(problem).status, PlanStatus::kUnsolved);
  const VerifyResult swept = verify(problem, {{"turret_joint"}, {{-1}, {1}}});
  EXPECT_EQ(swept.status, VerifyStatus::kRefuted);
  EXPECT_EQ(swept.a + swept.b, "mastboom");
  // The pair is checked for every kind of joint, and if the mast is not in the way at zero.
  EXPECT_EQ(why(load(mastAndBoom("0.6 0 0", "continuous", "")), "mast", "boom"), "");
  EXPECT_EQ(why(load(mastAndBoom("0.4 0.4 0", "revolute", limits("-1.5", "1.5"))), "mast", "boom"),
            "");
  EXPECT_EQ(why(load(mastAndBoom("-0.6 0 0", "revolute", limits("-1.5", "1.5"))), "mast", "boom"),
            "")
      << "though they never meet";
  // The boom is the link that the joint moves, or is mounted on a frame; the mast is on another
  // part.
  EXPECT_EQ(
      why(load("<robot name=\"r\"><link name=\"base\"/>" +
               link("mast", box("0.05 0.05 1"), "0 0 0.5") + fixed("base", "mast", "0.6 0 0") +
               link("boom", box("1 0.05 0.05"), "0.5 0 0.4") +
               turning("base", "boom", "revolute", limits("-1.5", "1.5")) + "</robot>"),
          "mast", "boom"),
      "");
  EXPECT_EQ(why(load("<robot name=\"r\"><link name=\"base\"/><link name=\"plate\"/><link "
                     "name=\"frame\"/>" +
                     fixed("base", "plate", "0.6 0 0") +
                     link("mast", box("0.05 0.05 1"), "0 0 0.5") + fixed("plate", "mast", "0 0 0") +
                     turning("base", "frame", "revolute", limits("-1.5", "1.5")) +
                     link("boom", box("1 0.05 0.05"), "0.5 0 0") +
                     fixed("frame", "boom", "0 0 0.4") + "</robot>"),
                "mast", "boom"),
            "");
}

/// Regression: even steps over 2 n turns met the same few angles, at which boom and mast overlap.
TEST_F(NeighbourPairs, RangesOfManyTurnsAreLookedAtOverOne) {
  for (const char* range : {"3.141592653589793", "50.26548245743669", "100.53096491487338",
                            "201.06192982974676", "402.1238596594935", "804.247719318987"})
    EXPECT_EQ(why(load(mastAndBoom("0.6 0 0", "revolute", limits(std::string("-") + range, range))),
                  "mast", "boom"),
              "")
        << range;
}

TEST_F(NeighbourPairs, ASliderThatPassesAStopIsChecked) {
  const auto rail = [&](const std::string& lower, const std::string& upper) {
    return load("<robot name=\"r\">" + link("rail", box("2 0.1 0.1"), "0 0 0") +
                link("stop", box("0.1 0.1 0.3"), "0 0 0") + fixed("rail", "stop", "0 0 0.2") +
                link("slide", box("0.2 0.1 0.1"), "0 0 0.1") +
                link("head", box("0.1 0.1 0.1"), "0 0 0.2") + fixed("slide", "head", "0 0 0") +
                "<joint name=\"x\" type=\"prismatic\"><parent link=\"rail\"/><child "
                "link=\"slide\"/><axis xyz=\"1 0 0\"/>" +
                limits(lower, upper) + "</joint></robot>");
  };
  EXPECT_EQ(why(rail("-0.8", "0.8"), "stop", "head"), "");
  // Regression: if zero is an end of the range, they counted as parts that meet.
  EXPECT_EQ(why(rail("0", "0.8"), "stop", "head"), "");
  EXPECT_EQ(why(rail("-0.8", "0"), "stop", "head"), "");
  // The range is too short to separate them.
  EXPECT_EQ(why(rail("-0.02", "0.03"), "stop", "head"), kAlways);
  EXPECT_EQ(why(rail("0", "0.1"), "stop", "head"), kSampled) << "they still touch at its end";
}

TEST_F(NeighbourPairs, PartsThatTouchAtTheJointAreLeftOut) {
  // A round cover about the joint, and a ring that turns in it, overlap at any angle.
  const std::string round = "<cylinder radius=\"0.1\" length=\"0.1\"/>";
  const auto model =
      load("<robot name=\"r\">" + link("base", box("0.2 0.2 0.1"), "0 0 0") +
           link("cover", round, "0 0 0.1") + fixed("base", "cover", "0 0 0") +
           link("arm", box("1 0.05 0.05"), "0.5 0 0.3") + turning("base", "arm", "continuous") +
           link("ring", round, "0 0 0.15") + fixed("arm", "ring", "0 0 0") + "</robot>");
  EXPECT_EQ(why(model, "cover", "ring"), kAlways);
  EXPECT_EQ(why(model, "cover", "arm"), "");
  const std::vector<UncheckedPairs> counted =
      countUnchecked(CompiledScene(problemOf(model)).dropped());
  std::map<std::string, int> counts;
  for (const UncheckedPairs& group : counted) counts[toString(group.why)] = group.count;
  EXPECT_EQ(counts[kAlways], 1);
  EXPECT_EQ(counts["adjacent"], 1);
}

/// Meshes have no proof: pairs that touch at every sample are left out by name.
TEST_F(NeighbourPairs, PartsThatTouchWhereverTheyAreSeenAreLeftOutByName) {
  folder_.write("tip.obj",
                "v -0.2 -0.2 0\nv 0.2 -0.2 0\nv 0 0.2 0\nv 0 0 0.2\nf 1 3 2\nf 1 2 4\nf 2 3 4\n"
                "f 3 1 4\n");
  const std::string mesh = "<mesh filename=\"tip.obj\"/>";
  const auto model = load("<robot name=\"r\"><link name=\"base\"/>" + link("cover", mesh, "0 0 0") +
                          fixed("base", "cover", "0 0 0") + "<link name=\"axle\"/>" +
                          turning("base", "axle", "continuous") + link("arm", mesh, "0 0 0.05") +
                          fixed("axle", "arm", "0 0 0") + "</robot>");
  EXPECT_EQ(why(model, "cover", "arm"), kSampled);
  const Problem problem = problemOf(model);
  const CompiledScene scene(problem);
  EXPECT_EQ(toString(countUnchecked(scene.dropped())),
            "1 pair is not checked: 1 touching at every sampled configuration (cover and arm)");
  EXPECT_EQ(verify(problem, {{"axle_joint"}, {{0}}}).unchecked.at(0).names.at(0),
            std::make_pair(std::string("cover"), std::string("arm")));
}

/// Parts that touch at zero and separate: an arm on a rest, face to face within the digits of a
/// URDF, or slightly inside it.
TEST_F(NeighbourPairs, ARestIsCheckedWithAWarning) {
  const auto resting = [&](const std::string& height, const std::string& lower,
                           const std::string& upper) {
    return load("<robot name=\"r\">" + link("base", box("0.2 0.2 0.1"), "0 0 0") +
                link("rest", box("0.1 0.1 0.1"), "0.5 0 0") + fixed("base", "rest", "0 0 0") +
                link("arm", box("0.8 0.05 0.1"), "0.4 0 " + height) +
                turning("base", "arm", "revolute", limits(lower, upper)) + "</robot>");
  };
  for (const char* height : {"0.1", "0.1000001", "0.0995", "0.05", "0.101"})
    for (const auto& [lower, upper] : {std::pair("-1", "1"), {"0", "1"}, {"-1", "0"}}) {
      const auto model = resting(height, lower, upper);
      const std::string reason = why(model, "rest", "arm");
      const std::vector<std::string> warnings = CompiledScene(problemOf(model)).warnings();
      if (std::string(height) == "0.101") {
        EXPECT_EQ(reason, "");
        EXPECT_TRUE(warnings.empty());
        continue;
      }
      EXPECT_EQ(reason, "") << height;
      ASSERT_EQ(warnings.size(), 1U) << height;
      EXPECT_EQ(warnings[0],
                "links 'rest' and 'arm' touch at the zero configuration, but not at others: the "
                "pair is checked; 'allowed: [[rest, arm]]' or an SRDF would leave it out");
      Problem problem = problemOf(model);
      problem.contacts.allowed.emplace_back("arm", "rest");
      EXPECT_TRUE(CompiledScene(problem).warnings().empty());
    }
  // The arm stays on the rest within its limits.
  EXPECT_EQ(why(resting("0.1", "-0.05", "0.05"), "rest", "arm"), kSampled);
}

/// Regression: parts that overlapped by less than 1 mm at zero, or were at a limit there, were
/// swept through each other and certified.
TEST_F(NeighbourPairs, WhatGrazesAtZeroAndSinksInLaterIsChecked) {
  for (const char* y : {"0.05", "0.0500001", "0.0495"})
    for (const auto& [lower, upper] : {std::pair("-1.5", "1.5"), {"0", "1.5"}}) {
      const auto model =
          load(mastAndBoom("0.6 " + std::string(y) + " 0", "revolute", limits(lower, upper)));
      EXPECT_EQ(why(model, "mast", "boom"), "") << y;
      EXPECT_EQ(verify(problemOf(model), {{"turret_joint"}, {{0.08}}}).status,
                VerifyStatus::kRefuted);
    }
  EXPECT_EQ(why(load(mastAndBoom("0.6 0.05 0", "continuous", "")), "mast", "boom"), "");
}

/// The joint is a mimic joint; a whole turn of its master is only a part of its own.
TEST_F(NeighbourPairs, AMimicIsLookedAtOverItsOwnTurn) {
  const auto geared = [&](const std::string& multiplier) {
    return load("<robot name=\"r\"><link name=\"base\"/>" +
                link("mast", box("0.05 0.05 1"), "0.6 0 0") + fixed("base", "mast", "0 0 0") +
                "<link name=\"wheel\"/>" + turning("base", "wheel", "continuous") +
                link("boom", box("1.3 0.4 0.05"), "0 0 0") +
                turning("base", "boom", "continuous",
                        "<mimic joint=\"wheel_joint\" multiplier=\"" + multiplier + "\"/>") +
                "</robot>");
  };
  for (const char* multiplier : {"0.01", "-0.01", "1", "30"})
    EXPECT_EQ(why(geared(multiplier), "mast", "boom"), "") << multiplier;
}

/// Links without shapes between consecutive joints: the nearest links with shapes are checked.
std::shared_ptr<const robots::Model> within(const std::shared_ptr<const robots::Model>& model,
                                            double lower, double upper, bool widens = false) {
  return robots::withBounds(*model, {{"turret_joint", {{"", {lower, upper, widens}}}}});
}

/// Regression: within narrower limits the boom is in the mast wherever it stands, and the pair was
/// left out as one that touches everywhere.
TEST_F(NeighbourPairs, NarrowerLimitsMakeNoPairTouchEverywhere) {
  const auto revolute = load(mastAndBoom("0.6 0 0", "revolute", limits("-1.5", "1.5")));
  const auto continuous = load(mastAndBoom("0.6 0 0", "continuous", ""));
  for (const auto& model : {revolute, continuous})
    for (const auto& [lower, upper] :
         {std::pair(-0.02, 0.02), std::pair(0.0, 0.01), std::pair(0.01, 0.02)}) {
      const auto narrow = within(model, lower, upper);
      EXPECT_EQ(why(narrow, "mast", "boom"), "") << lower << " to " << upper;
      EXPECT_EQ(why(within(narrow, 0.012, 0.013, true), "mast", "boom"), "") << "narrowed twice";
    }
  Problem problem = problemOf(within(revolute, -0.02, 0.02));
  problem.start = {-0.02};
  problem.goals = {test::pointGoal("goal", {0.02})};
  EXPECT_EQ(plan(problem).status, PlanStatus::kInvalidStart);
  EXPECT_EQ(verify(problem, {{"turret_joint"}, {{-0.02}, {0.02}}}).status, VerifyStatus::kRefuted);
}

TEST_F(NeighbourPairs, WiderLimitsAreLookedAt) {
  const auto model = load(mastAndBoom("0.6 0 0", "revolute", limits("-0.02", "0.02")));
  EXPECT_EQ(why(model, "mast", "boom"), kAlways);
  EXPECT_EQ(why(within(model, -1.5, 1.5, true), "mast", "boom"), "");
  // The part that holds the boom touches it however far it turns.
  const auto hub = [&](const std::string& type, const std::string& rest) {
    return load("<robot name=\"r\">" + link("base", box("0.2 0.2 0.2"), "0 0 0") +
                link("pin", box("0.1 0.1 0.5"), "0 0 0.2") + fixed("base", "pin", "0 0 0") +
                link("turret", box("0.3 0.3 0.1"), "0 0 0.3") +
                turning("base", "turret", type, rest) + "</robot>");
  };
  const auto limited = hub("revolute", limits("-1", "1")), endless = hub("continuous", "");
  EXPECT_EQ(why(limited, "pin", "turret"), kAlways);
  EXPECT_EQ(why(within(limited, 0.1, 0.2), "pin", "turret"), kAlways);
  EXPECT_EQ(why(within(limited, -6, 6, true), "pin", "turret"), kAlways);
  EXPECT_EQ(why(within(endless, 0.1, 0.2), "pin", "turret"), kAlways);
}

/// Paths keep the limits of the problem, and the verifier refutes one that does not.
TEST_F(NeighbourPairs, PathsKeepNarrowerLimits) {
  const auto model = load(mastAndBoom("-0.6 0 0", "continuous", ""));
  Problem problem = problemOf(within(model, -1.6, 2.1));
  problem.start = {-1.5};
  problem.goals = {test::pointGoal("goal", {2})};
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_EQ(result.path.positions.size(), 2U) << "the shorter turn, across the mast, is outside";
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
  const VerifyResult beyond = verify(problem, {{"turret_joint"}, {{-1.5}, {-1.7}, {2}}});
  EXPECT_EQ(beyond.status, VerifyStatus::kRefuted);
  EXPECT_NE(beyond.reason.find("outside its limits"), std::string::npos) << beyond.reason;
}

TEST_F(NeighbourPairs, TwoJointsApartIsNoNeighbour) {
  const auto model = load("<robot name=\"r\">" + link("base", box("0.2 0.2 0.2"), "0 0 0") +
                          "<link name=\"cross\"/>" + turning("base", "cross", "continuous") +
                          link("arm", box("0.2 0.2 0.2"), "0 0 0") +
                          turning("cross", "arm", "continuous") + "</robot>");
  EXPECT_EQ(why(model, "base", "arm"), "");
}

TEST_F(NeighbourPairs, AnSrdfSaysWhatIsNotChecked) {
  const std::string urdf = mastAndBoom("0.6 0 0", "revolute", limits("-1.5", "1.5"));
  const auto plain = load(urdf, "<robot name=\"mast_boom\"/>");
  EXPECT_EQ(why(plain, "mast", "boom"), "");
  EXPECT_EQ(why(plain, "base", "boom"), "") << "nothing is derived, not even a proof";
  EXPECT_EQ(why(plain, "base", "turret"), "adjacent");
  const auto disabled = load(urdf,
                             "<robot name=\"mast_boom\"><disable_collisions link1=\"mast\" "
                             "link2=\"boom\" reason=\"Never\"/></robot>");
  EXPECT_EQ(why(disabled, "mast", "boom"), "disabled by the SRDF");
  // MoveIt's default for a link: the boom may touch everything except the mast.
  const auto by_default = load(
      urdf,
      "<robot name=\"mast_boom\"><disable_default_collisions link=\"boom\"/><enable_collisions "
      "link1=\"mast\" link2=\"boom\"/><enable_collisions link1=\"turret\" "
      "link2=\"base\"/></robot>");
  EXPECT_EQ(why(by_default, "mast", "boom"), "");
  EXPECT_EQ(why(by_default, "base", "boom"), "disabled by the SRDF");
  EXPECT_EQ(why(by_default, "base", "turret"), "") << "enabled by name, though they are neighbours";
  // It may also touch objects of the world, including later and held ones.
  Problem problem = problemOf(by_default);
  problem.world.objects.push_back(test::box("post", {0.1, 0.1, 1}, 0.5, 0.5, 0));
  Attachment held;
  held.object = {"cup", {{collision::Shape::sphere(0.05), {}, "cup"}}, {}};
  held.link = by_default->findLink("turret");
  held.X_LO = test::at(0, 0, 2);
  problem.robot.attachments.push_back(held);
  const CompiledScene scene(problem);
  const Object later = test::box("later", {0.1, 0.1, 1}, 0.5, -0.5, 0);
  const auto changed = scene.withObjects({&later, 1});
  const auto reasons = [](const std::vector<CompiledScene::Dropped>& dropped,
                          const std::string& other) {
    std::set<std::string> links;
    for (const CompiledScene::Dropped& d : dropped)
      if (d.why == Unchecked::kSrdf && (d.a == other || d.b == other))
        links.insert(d.a == other ? d.b : d.a);
    return links;
  };
  const auto theirs =
      verification::collectPairs(problem, verification::collectBodies(problem)).unchecked;
  for (const char* other : {"post", "base"}) {
    EXPECT_EQ(reasons(scene.dropped(), other), std::set<std::string>{"boom"}) << other;
    EXPECT_EQ(reasons(changed->dropped(), other), std::set<std::string>{"boom"}) << other;
    EXPECT_EQ(reasons(theirs, other), std::set<std::string>{"boom"}) << other;
  }
  EXPECT_EQ(reasons(changed->dropped(), "later"), std::set<std::string>{"boom"});
  const int added = changed->scene().find("later");
  const auto gone = changed->withObjects({}, {&added, 1});
  EXPECT_EQ(reasons(gone->dropped(), "later"), std::set<std::string>{});
  EXPECT_EQ(gone->dropped().size(), scene.dropped().size());
}

TEST_F(NeighbourPairs, ARobotWithoutShapesProvesNothing) {
  const std::string arm = "<link name=\"arm\"/>" + turning("base", "arm", "continuous");
  const auto bare = load("<robot name=\"r\"><link name=\"base\"/>" + arm + "</robot>");
  // The shapes of the second robot stand still.
  const auto still =
      load("<robot name=\"r\">" + link("base", box("1 1 1"), "0 0 0") + arm + "</robot>");
  for (const auto& model : {bare, still}) {
    ASSERT_EQ(model->warnings.size(), 1U);
    EXPECT_NE(model->warnings[0].find("neither link \"arm\" nor any other that moves"),
              std::string::npos)
        << model->warnings[0];
    Problem problem = problemOf(model);
    for (const bool room : {false, true}) {
      if (room) problem.world.objects.push_back(test::box("room", {5, 5, 5}, 0, 0, 0));
      const PlanResult result = plan(problem);
      EXPECT_EQ(result.status, PlanStatus::kNothingChecked);
      EXPECT_STREQ(toString(result.status), "nothing_checked");
      EXPECT_EQ(result.reason, kNothingMoves);
      EXPECT_TRUE(result.path.positions.empty());
      const VerifyResult verified = verify(problem, {{"arm_joint"}, {{0}}});
      EXPECT_EQ(verified.status, VerifyStatus::kNothingChecked);
      EXPECT_EQ(verified.reason, kNothingMoves);
      EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
      EXPECT_FALSE(certify(certifier, {{"arm_joint"}, {{0}, {1}}}, 1e-4).certified);
    }
    // A held object has a shape.
    Attachment cup;
    cup.object = {"cup", {{collision::Shape::sphere(0.1), {}, "cup"}}, {}};
    cup.link = model->findLink("arm");
    cup.X_LO = test::at(9, 0, 0);
    problem.robot.attachments.push_back(cup);
    EXPECT_EQ(plan(problem).status, PlanStatus::kSolved);
  }
}

TEST_F(NeighbourPairs, AWorldThatMayAllBeTouchedProvesNothing) {
  const auto model =
      load("<robot name=\"r\"><link name=\"base\"/>" + link("arm", box("1 0.1 0.1"), "0.5 0 0") +
           turning("base", "arm", "continuous") + "</robot>");
  Problem problem = problemOf(model);
  // A robot with shapes that is alone cannot collide.
  EXPECT_EQ(plan(problem).status, PlanStatus::kSolved);
  EXPECT_EQ(verify(problem, {{"arm_joint"}, {{0}}}).status, VerifyStatus::kCertified);
  problem.world.objects.push_back(test::box("fog", {5, 5, 5}, 0, 0, 0));
  EXPECT_EQ(plan(problem).status, PlanStatus::kInvalidStart);
  problem.contacts.allowed.emplace_back("fog", "arm");
  const PlanResult result = plan(problem);
  EXPECT_EQ(result.status, PlanStatus::kNothingChecked);
  EXPECT_EQ(result.reason,
            "no pair with the world is checked; 1 pair is not checked: 1 allowed by the problem");
  const VerifyResult verified = verify(problem, {{"arm_joint"}, {{0}}});
  EXPECT_EQ(verified.status, VerifyStatus::kNothingChecked);
  EXPECT_EQ(verified.reason, result.reason);
  // A world that has become empty behaves like one that was empty.
  const CompiledScene scene(problem);
  const int fog = scene.scene().find("fog");
  EXPECT_EQ(scene.withObjects({}, {&fog, 1})->nothingChecked(), "");
  EXPECT_NE(scene.nothingChecked(), "");
}

/// A mesh about the origin.
collision::Shape tetrahedron(double size) {
  const std::vector<Eigen::Vector3d> corners = {
      {-size, -size, -size}, {size, -size, -size}, {0, size, -size}, {0, 0, size}};
  const std::vector<collision::TriangleMesh::Triangle> facets = {
      {0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return collision::Shape::mesh(collision::TriangleMesh::make(corners, facets));
}

/// Trees of boxes, balls and meshes, most of them near their joints.
std::shared_ptr<const robots::Model> randomRobot(robots::testing::Random& random) {
  robots::RobotDescription robot;
  const int count = 4 + random.integer(6);
  for (int i = 0; i < count; ++i) {
    robots::Link link;
    link.name = "link" + std::to_string(i);
    link.joint = i;
    if (random.integer(4) > 0) {
      const int kind = random.integer(3);
      link.geometries.push_back({kind == 0   ? collision::Shape::sphere(random.uniform(0.01, 0.1))
                                 : kind == 1 ? collision::Shape::box(random.vector(0.1).cwiseAbs())
                                             : tetrahedron(random.uniform(0.05, 0.2)),
                                 random.pose(0.1), link.name});
    }
    robots::Joint joint;
    joint.name = "joint" + std::to_string(i);
    joint.child_link = i;
    joint.parent_link = i == 0 ? -1 : random.integer(i);
    const JointType types[] = {JointType::kFixed, JointType::kFixed, JointType::kRevolute,
                               JointType::kContinuous, JointType::kPrismatic};
    joint.type = i == 0 ? JointType::kFixed : types[random.integer(5)];
    joint.axis = random.direction();
    joint.X_PJ = random.pose(0.15);
    robot.links.push_back(std::move(link));
    robot.joints.push_back(std::move(joint));
    robots::appendVariables(robot, i, Eigen::Vector3d::Constant(-random.uniform(0, 1.5)),
                            Eigen::Vector3d::Constant(random.uniform(0, 1.5)));
  }
  return std::make_shared<const robots::Model>(std::move(robot));
}

/// Narrower limits of half the joints, or any.
std::shared_ptr<const robots::Model> withRandomBounds(const robots::Model& model,
                                                      robots::testing::Random& random,
                                                      bool only_narrower) {
  robots::JointBounds bounds;
  for (const robots::Variable& v : model.variables) {
    if (random.uniform(0, 1) < 0.5) continue;
    const bool is_limited = std::isfinite(v.upper - v.lower);
    const double from = is_limited ? v.lower : -3, to = is_limited ? v.upper : 3;
    double lower = random.uniform(from, to), upper = random.uniform(from, to);
    if (lower > upper) std::swap(lower, upper);
    if (!only_narrower) upper += 0.5;
    bounds[v.name].emplace("", robots::JointBound{lower, upper, !only_narrower});
  }
  return robots::withBounds(model, bounds);
}

/// Pairs that count as touching everywhere within narrower limits do so within the robot's own.
TEST_F(NeighbourPairs, NarrowerLimitsLeaveOutNoMoreThatTouch) {
  robots::testing::Random random(49);
  const auto touching = [](const std::shared_ptr<const robots::Model>& model) {
    std::set<std::pair<std::string, std::string>> pairs;
    for (const CompiledScene::Dropped& d : CompiledScene(problemOf(model)).dropped())
      if (d.why == Unchecked::kTouchAlways || d.why == Unchecked::kTouchSampled)
        pairs.insert(std::minmax(d.a, d.b));
    return pairs;
  };
  std::size_t met = 0;
  for (int k = 0; k < 300; ++k) {
    const auto model = randomRobot(random);
    if (model->variables.empty()) continue;
    const auto own = touching(model);
    const auto narrow = touching(withRandomBounds(*model, random, true));
    // (A joint whose range is a point makes its pairs rigid.)
    EXPECT_TRUE(std::includes(own.begin(), own.end(), narrow.begin(), narrow.end())) << k;
    met += narrow.size();
  }
  EXPECT_GT(met, 20U);
}

/// The verifier determines independently which pairs the planner leaves out. A pair that only the
/// planner leaves out is proven apart.
TEST_F(NeighbourPairs, PlannerAndVerifierLeaveOutTheSame) {
  robots::testing::Random random(46);
  std::map<Unchecked, int> met;
  int checked = 0;
  for (int k = 0; k < 1000; ++k) {
    const auto own = randomRobot(random);
    const auto model = k % 2 == 0 ? own : withRandomBounds(*own, random, k % 4 == 1);
    Problem problem = problemOf(model);
    if (problem.robot.variables.empty()) continue;
    const CompiledScene scene(problem);
    const verification::Pairs theirs =
        verification::collectPairs(problem, verification::collectBodies(problem));
    std::map<std::pair<std::string, std::string>, Unchecked> found;
    for (const CompiledScene::Dropped& d : theirs.unchecked) found[std::minmax(d.a, d.b)] = d.why;
    std::size_t expected = 0;
    for (const CompiledScene::Dropped& d : scene.dropped()) {
      ++met[d.why];
      ++expected;
      const auto place = found.find(std::minmax(d.a, d.b));
      ASSERT_NE(place, found.end()) << k << ": " << d.a << " and " << d.b << ", " << d.reason;
      EXPECT_EQ(place->second, d.why == Unchecked::kTouchAlways ? Unchecked::kTouchSampled : d.why)
          << k << ": " << d.a << " and " << d.b;
    }
    EXPECT_EQ(found.size(), expected) << k;
    EXPECT_EQ(scene.nothingChecked(), theirs.nothing_checked) << k;
    checked += static_cast<int>(scene.scene().pairs().size());
  }
  EXPECT_GT(met[Unchecked::kTouchSampled], 20);
  EXPECT_GT(met[Unchecked::kTouchAlways], 20);
  EXPECT_GT(met[Unchecked::kAdjacent], 100);
  EXPECT_GT(checked, 500);
}

/// Links that are proven to touch do touch in random configurations.
TEST_F(NeighbourPairs, ProvenTouchIsEverywhere) {
  robots::testing::Random random(47);
  int proven = 0;
  for (int k = 0; k < 1000; ++k) {
    const auto model = randomRobot(random);
    std::vector<std::pair<int, int>> candidates;
    for (int a = 0; a < static_cast<int>(model->links.size()); ++a)
      for (int b = 0; b < a; ++b)
        if (robots::onlyJointBetween(*model, a, b) >= 0) candidates.emplace_back(a, b);
    Problem problem = problemOf(model);
    if (problem.robot.variables.empty()) continue;
    problem.contacts.replace_srdf = true;  // all pairs except neighbours are checked
    EdgeCertifier certifier(std::make_shared<const CompiledScene>(problem));
    const CompiledScene& scene = certifier.scene();
    for (const auto& [a, b] : robots::provenTouching(*model, candidates)) {
      const int body_a = scene.scene().find(model->links[static_cast<std::size_t>(a)].name),
                body_b = scene.scene().find(model->links[static_cast<std::size_t>(b)].name);
      const auto only = scene.withPairs([&](const collision::ScenePair& pair) {
        return std::minmax({pair.body_a, pair.body_b}) == std::minmax({body_a, body_b});
      });
      if (only->scene().pairs().empty()) continue;  // neighbours
      ++proven;
      EdgeCertifier of_pair(only);
      for (int i = 0; i < 20; ++i) {
        std::vector<double> q;
        for (const robots::Variable& v : model->variables)
          q.push_back(random.uniform(std::max(v.lower, -3.1), std::min(v.upper, 3.1)));
        EXPECT_EQ(of_pair.decide(q), Verdict::kNotFree) << k;
      }
    }
  }
  EXPECT_GT(proven, 20);
}

}  // namespace
}  // namespace leeway::planner
