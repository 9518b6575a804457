// Several arms in one problem: groups that are planned together, with starts and goals of their
// own.

#include "leeway/robots/groups.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/save_problem.h"
#include "leeway/planner/task.h"
#include "leeway/planner/verify.h"
#include "planner/problem/read_states.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

/// A column with two arms of two joints, and a gripper on the left one.
constexpr const char* kTwoArms = R"(<robot name="two">
<link name="column"/>
<link name="l1"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="l2"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="r1"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="r2"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.05 0.05"/></geometry></collision></link>
<link name="finger"/>
<joint name="l_a" type="revolute"><parent link="column"/><child link="l1"/><origin xyz="0 0.3 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="l_b" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.42 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="r_a" type="revolute"><parent link="column"/><child link="r1"/><origin xyz="0 -0.3 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="r_b" type="revolute"><parent link="r1"/><child link="r2"/><origin xyz="0.42 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="grip" type="prismatic"><parent link="l2"/><child link="finger"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>
</robot>
)";
constexpr const char* kTwoArmsSrdf = R"(<robot name="two">
<group name="left"><joint name="l_a"/><joint name="l_b"/></group>
<group name="right"><joint name="r_a"/><joint name="r_b"/></group>
<group name="both"><group name="left"/><group name="right"/></group>
<group name="hand"><joint name="grip"/></group>
<group_state name="ahead" group="both"><joint name="l_a" value="0.5"/><joint name="l_b" value="0"/><joint name="r_a" value="-0.5"/><joint name="r_b" value="0"/></group_state>
<group_state name="ahead" group="left"><joint name="l_a" value="0.25"/><joint name="l_b" value="0"/></group_state>
<group_state name="out" group="right"><joint name="r_a" value="-1.5"/><joint name="r_b" value="0.5"/></group_state>
<group_state name="open" group="hand"><joint name="grip" value="0.03"/></group_state>
</robot>
)";

class Groups : public testing::Test {
 protected:
  Groups() {
    folder_.write("two.urdf", kTwoArms);
    folder_.write("two.srdf", kTwoArmsSrdf);
  }
  /// `group` is in line 2, `start` in line 3, `goal` in line 4.
  std::string write(const std::string& start, const std::string& goal, const std::string& more = "",
                    const std::string& group = "[right, left]") const {
    return folder_.write("problem.yaml",
                         "leeway: 1\nrobot: {urdf: two.urdf, srdf: two.srdf, group: " + group +
                             "}\nstart: " + start + "\ngoal: " + goal + "\n" + more);
  }
  void expect(const std::string& start, const std::string& goal, int line,
              const std::string& message, const std::string& group = "[right, left]") const {
    SCOPED_TRACE(start + " " + goal + " " + group);
    const std::string file = write(start, goal, "", group);
    robots::expectInputError([&] { loadProblem(file); }, file, line, {message});
  }

  Folder folder_;
  const std::string kStart = "{left: [0.5, 0], right: [-0.5, 0]}";
};

TEST_F(Groups, ArePlannedTogetherWithGoalsOfTheirOwn) {
  const Problem problem =
      loadProblem(write(kStart, "{left: [[0.9, 1], any], right: out}", "margin: 0.01\n"));
  ASSERT_EQ(problem.robot.variables.size(), 4U);
  const robots::Model& model = *problem.robot.model;
  std::vector<std::string> names;
  for (const int v : problem.robot.variables)
    names.push_back(model.variables[static_cast<std::size_t>(v)].name);
  EXPECT_EQ(names, (std::vector<std::string>{"r_a", "r_b", "l_a", "l_b"})) << "in the list's order";
  EXPECT_EQ(robots::groupsOf(model, problem.robot.variables),
            (std::vector<std::string>{"right", "left"}));
  const std::vector<std::pair<double, double>> goal = {{-1.5, -1.5}, {0.5, 0.5}, {0.9, 1}, {-2, 2}};
  EXPECT_EQ(problem.goals[0].ranges, goal);
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  EXPECT_EQ(result.path.names, names);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
}

TEST_F(Groups, AStateOfTheGroupComesFirst) {
  const auto left = [&](const std::string& goal) {
    return loadProblem(write(kStart, goal)).goals[0].ranges[2].first;
  };
  EXPECT_EQ(left("{left: ahead, right: out}"), 0.25);
  EXPECT_EQ(left("ahead"), 0.5);
  EXPECT_EQ(left("{both: ahead}"), 0.5);
  EXPECT_EQ(left("{left: {l_b: 0, l_a: 0.75}, r_a: 0, r_b: 1}"), 0.75);
  const Problem any = loadProblem(write(kStart, "{right: any, left: zero}"));
  EXPECT_EQ(any.goals[0].ranges[0], std::pair(-3.0, 3.0));
}

/// The command's --goal takes the same word.
TEST_F(Groups, StatedGoalsTakeAny) {
  Problem problem = loadProblem(write(kStart, "ahead"));
  problem.goals.clear();
  takeStates("left=0.5 0, right=-0.5 0", "left=any, right=out", problem);
  const std::vector<std::pair<double, double>> goal = {{-1.5, -1.5}, {0.5, 0.5}, {-3, 3}, {-2, 2}};
  EXPECT_EQ(problem.goals[0].ranges, goal);
  EXPECT_THROW(takeStates("left=any, right=out", "ahead", problem), robots::InputError);
}

TEST_F(Groups, SetJointsThatAreNotPlanned) {
  const Problem problem =
      loadProblem(write("{both: ahead, hand: open}", "{both: ahead}", "", "both"));
  EXPECT_EQ(problem.start[static_cast<std::size_t>(problem.robot.model->findVariable("grip"))],
            0.03);
  EXPECT_EQ(loadProblem(write("ahead", "ahead", "joints: {hand: open}\n", "both")).start,
            problem.start);
}

TEST_F(Groups, HavePosesOfTheirOwn) {
  const std::string left = "left: {pose: {frame: l2, position: [[0.2, 0.25], [0.6, 0.7], 0]}}",
                    right =
                        "right: {poses: [{frame: r2, position: [[0.2, 0.25], [-0.7, -0.6], 0]}]}";
  const Problem problem = loadProblem(write(kStart, "{" + left + ", " + right + "}"));
  ASSERT_EQ(problem.goals[0].poses.size(), 2U);
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
  EXPECT_EQ(loadProblem(write(kStart, "{right: any, " + left + "}")).goals[0].poses.size(), 1U);
  EXPECT_EQ(loadProblem(write("{" + left + ", " + right + "}", "ahead")).start_poses.size(), 2U);
  // A start says where both arms are.
  for (const std::string& one : {"{" + left + "}", "{" + left + ", right: any}"})
    robots::expectInputError(
        [&] { loadProblem(write(one, "ahead")); }, folder_.path("problem.yaml"), 0,
        {"start says nothing of joint 'r_a', which moves none of the frames that have a pose"});
  expect(kStart, "{" + left + ", right: out}", 4, "goal.right gives joint values");
  expect(kStart, "{right: {pose: {frame: l2, position: [[0.2, 0.25], [0.6, 0.7], 0]}}}", 4,
         "no joint of group 'right' moves 'l2'");
  const Problem task = loadProblem(folder_.write(
      "task.yaml",
      "leeway: 1\nrobot: {urdf: two.urdf, srdf: two.srdf, group: [right, left]}\nstart: ahead\n"
      "steps:\n- move: {left: ahead, right: out}\n- move: {" +
          left + ", " + right + "}\n"));
  EXPECT_EQ(planTask(task).status, PlanStatus::kSolved);
}

TEST_F(Groups, MistakesAreNamed) {
  expect("ahead", "ahead", 2, "groups 'left' and 'both' both have joint 'l_a'", "[left, both]");
  expect("ahead", "ahead", 2, "group 'left' stands twice", "[left, left]");
  expect("ahead", "ahead", 2, "no group is named", "[]");
  expect("ahead", "ahead", 2, "has no group or joint 'lft'; did you mean 'left'?", "[lft, right]");
  expect(kStart, "{left: ahead}", 4, "goal says nothing of joint 'r_a'");
  expect("{left: ahead}", "ahead", 3, "start says nothing of joint 'r_a'");
  expect(kStart, "{both: ahead, hand: open}", 4, "goal names joint 'grip', which is not planned");
  expect(kStart, "{left: ahead, right: aheadd}", 4,
         "no group state 'aheadd' for group 'right'; did you mean 'ahead'?");
  expect(kStart, "{left: out, right: out}", 4,
         "group state 'out' lacks joints 'l_a' and 'l_b'; a state with a value for each joint of "
         "group 'left' is expected");
  expect(kStart, "{left: [1], right: out}", 4, "goal.left is a list of 1; 2 values are expected");
  expect(kStart, "{left: {r_a: 1, l_a: 0}, right: out}", 4,
         "goal.left names joint 'r_a', which group 'left' does not have");
  expect(kStart, "{both: ahead, l_a: 1}", 4, "gives joint 'l_a' again");
  expect(kStart, "{left: [9, 0], right: out}", 4, "goal has joint 'l_a' at 9, outside its limits");
  expect(kStart, "{lft: ahead, right: out}", 4,
         "unknown joint 'lft' in goal; did you mean 'left'?");
  expect("{left: any, right: out}", "ahead", 3, "no group state 'any' for group 'left'");
  expect(kStart, "open", 4,
         "group state 'open' lacks joints 'r_a', 'r_b', 'l_a' and 'l_b'; a state with");
}

TEST_F(Groups, AreJointsOrTheChainBetweenTwoLinks) {
  const auto planned = [](const Problem& problem) {
    std::vector<std::string> names;
    for (const int v : problem.robot.variables)
      names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(planned(loadProblem(write("[0, 0.1]", "[1, 0.1]", "", "[r_b, l_a]"))),
            (Names{"r_b", "l_a"}));
  EXPECT_EQ(planned(loadProblem(write("[0]", "[1]", "", "l_a"))), Names{"l_a"});
  EXPECT_EQ(planned(loadProblem(
                write("{left: ahead, r_b: 0}", "{left: [1, 1], r_b: 1}", "", "[left, r_b]"))),
            (Names{"l_a", "l_b", "r_b"}));
  expect("[0, 0]", "[1, 1]", 2, "group 'left' and joint 'l_a' both have joint 'l_a'",
         "[left, l_a]");
  expect("[0, 0]", "[1, 1]", 2, "joint 'l_a' stands twice", "[l_a, l_a]");
  // A chain plans its joints, and no group of the SRDF, whatever joints and groups are called.
  const auto chain = [&](const std::string& ends, const std::string& more = "") {
    return folder_.write(
        "chain.yaml", "leeway: 1\nrobot: {urdf: two.urdf, srdf: two.srdf, chain: " + ends + more +
                          "}\nstart: zero\ngoal: middle\n");
  };
  EXPECT_EQ(planned(loadProblem(chain("[l1, r2]"))), (Names{"l_a", "r_a", "r_b"}));
  EXPECT_EQ(planned(loadProblem(chain("[column, finger]"))), (Names{"l_a", "l_b", "grip"}));
  const auto refused = [&](const std::string& file, const char* words) {
    SCOPED_TRACE(words);
    robots::expectInputError([&] { loadProblem(file); }, file, 2, {words});
  };
  refused(chain("[column, fingr]"), "has no link 'fingr'; did you mean 'finger'?");
  refused(chain("[column]"), "is not a pair of links; [BASE, TIP] is expected");
  refused(chain("[l1, l1]"), "no joint between 'l1' and 'l1' can move");
  refused(chain("[l1, r2]", ", group: left"), "keys 'group' and 'chain' both say what is planned");
}

TEST_F(Groups, AreSavedByName) {
  for (const char* group : {"[right, left]", "[r_b, l_a]", "[hand, r_a]", "l_b"}) {
    const std::string none = std::string(group) == "[right, left]" ? "ahead" : "zero";
    const Problem problem = loadProblem(write(none, "zero", "", group));
    const std::string file = folder_.path("saved.yaml");
    saveProblem(problem, file);
    EXPECT_EQ(loadProblem(file).robot.variables, problem.robot.variables) << group;
  }
}

TEST_F(Groups, AreNamedInOneTextWithoutAFile) {
  const auto model = robots::loadModel(folder_.path("two.urdf"), folder_.path("two.srdf"));
  const Problem problem =
      problemFromStates(model, "left, right", "left=ahead, right=0 1", "right=out left=0.5,-1");
  const auto value = [&](const char* name) {
    return problem.start[static_cast<std::size_t>(model->findVariable(name))];
  };
  EXPECT_EQ(value("l_a"), 0.25);
  EXPECT_EQ(value("r_b"), 1);
  const std::vector<std::pair<double, double>> goal = {
      {0.5, 0.5}, {-1, -1}, {-1.5, -1.5}, {0.5, 0.5}};
  EXPECT_EQ(problem.goals[0].ranges, goal);
  EXPECT_EQ(problemFromStates(model, "l_a,right", "l_a=0.125, right=out", "zero").robot.variables,
            (std::vector<int>{model->findVariable("l_a"), model->findVariable("r_a"),
                              model->findVariable("r_b")}));
  EXPECT_EQ(problemFromStates(model, "left,right", "ahead", "0 0 0 0").robot.variables,
            problem.robot.variables);
  const auto message = [&](const char* group, const char* start) -> std::string {
    try {
      problemFromStates(model, group, start, "ahead");
    } catch (const robots::InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message("left,both", "ahead"),
            "groups 'left' and 'both' both have joint 'l_a'; groups without a common joint are "
            "expected");
  EXPECT_EQ(message("left,rihgt", "ahead"),
            "robot 'two' has no group or joint 'rihgt'; did you mean 'right'?");
  EXPECT_EQ(message("left,right", "lft=0 0, right=out"),
            "start 'lft=0 0, right=out' names 'lft', which is not a group or joint; did you mean "
            "'left'?");
  EXPECT_EQ(message("left,right", "left=0 0, left=1 1"),
            "start 'left=0 0, left=1 1' gives joint 'l_a' twice; once is expected");
  EXPECT_EQ(message("left,right", "left=0, right=out"),
            "start of left '0' is 1 numbers; 2 are expected, of l_a, l_b");
  EXPECT_EQ(message("left,right", "left=0 0"),
            "start says nothing of joint 'r_a'; a value for every planned joint is expected: l_a, "
            "l_b, r_a, r_b");
}

}  // namespace
}  // namespace leeway::planner
