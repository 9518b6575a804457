// Every message for a bad problem file: file, line, what is wrong with the value, what would be
// accepted.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "leeway/planner/problem.h"
#include "leeway/robots/input_error.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::planner {
namespace {

/// Lines 1 to 7: a complete problem apart from the case's addition. Joints: pan, lift, elbow,
/// wrist1, wrist2, wrist3 (with _joint).
std::string withRobot(const std::string& more,
                      const std::string& start = "[0, -1.5, 0, -1.5, 0, 0]",
                      const std::string& goal = "[1, -1.5, 0, -1.5, 0, 0]") {
  return "leeway: 1\nrobot:\n  urdf: " + sourceFolder() +
         "/robots/arm6/arm6.urdf\n  srdf: " + sourceFolder() +
         "/robots/arm6/arm6.srdf\n  group: arm\nstart: " + start + "\ngoal: " + goal + "\n" + more;
}

/// Lines 1 to 7, with a planar body.
std::string withBody(const std::string& more,
                     const std::string& start = "{position: [0, 0], angle: 0}") {
  return "leeway: 1\nbody:\n  joint: planar\n  bounds: {lower: [-1, -1], upper: [1, 1]}\n"
         "  shapes: [{box: {size: [0.1, 0.1, 0.1]}}]\nstart: " +
         start + "\ngoal: {position: [0.5, 0]}\n" + more;
}

struct Case {
  std::string text;
  int line;
  std::string message;  ///< text after FILE:LINE:
};

void expectMessages(const std::vector<Case>& cases) {
  const Folder folder;
  folder.write("empty.obj", "# nothing\n");
  folder.write("broken.stl", "solid broken\n facet normal 0 0\n");
  for (const Case& c : cases) {
    const std::string file = folder.write("problem.yaml", c.text);
    try {
      loadProblem(file);
      ADD_FAILURE() << "accepted, but expected: " << c.message << "\n" << c.text;
    } catch (const robots::InputError& error) {
      const std::string place = file + ":" + (c.line > 0 ? std::to_string(c.line) + ":" : "");
      EXPECT_EQ(std::string(error.what()).substr(0, place.size()), place) << error.what() << "\n"
                                                                          << c.text;
      EXPECT_EQ(error.line(), c.line) << error.what();
      const std::string what = error.what();
      EXPECT_NE(what.find(c.message), std::string::npos)
          << "got      " << what << "\nexpected " << c.message;
    }
  }
}

TEST(ProblemMessages, WhatTheCasesChangeIsAGoodProblem) {
  const Folder folder;
  EXPECT_NO_THROW(loadProblem(folder.write("robot.yaml", withRobot(""))));
  EXPECT_NO_THROW(loadProblem(folder.write("body.yaml", withBody(""))));
}

/// An object may not be named by the word for all links; a link of the robot may.
TEST(ProblemMessages, TheWordForTheWholeRobot) {
  const Folder folder;
  folder.write("r.urdf",
               "<robot name=\"r\"><link name=\"base\"/><link name=\"robot\"><collision><geometry>"
               "<sphere radius=\"0.1\"/></geometry></collision></link><joint name=\"x\" "
               "type=\"prismatic\"><parent link=\"base\"/><child link=\"robot\"/><axis xyz=\"1 0 "
               "0\"/><limit lower=\"0\" upper=\"3\" effort=\"1\" velocity=\"1\"/></joint></robot>");
  const auto withLink = [&](const std::string& more) {
    return "leeway: 1\nrobot: {urdf: " + folder.path("r.urdf") +
           "}\nstart: [0]\ngoal: [1]\nobjects: [{name: post, position: [0, 1, 0], sphere: {radius: "
           "0.1}}]\n" +
           more;
  };
  expectMessages(
      {{withRobot("objects:\n  - {name: robot, sphere: {radius: 0.1}, position: [9, 0, 0]}\n"), 9,
        "objects[0].name 'robot' stands for all links and what they hold; another name is "
        "expected"},
       {withLink("margins: [{between: [robot, post], margin: 0.1}]\n"), 6,
        "margins[0].between: 'robot' is the name of a link, and stands for all links and what they "
        "hold; a group of the links that are meant is expected"},
       {withLink("groups: {world: [post]}\n"), 6,
        "group 'world' stands for the world and for all objects; another name is expected"},
       {withRobot("groups: {it: [robot]}\n"), 8,
        "groups.it: 'robot' is a group; names of links or objects are expected"},
       {withLink("groups: {a: [post], it: [a]}\n"), 6,
        "groups.it: 'a' is a group; names of links or objects are expected"}});
  const Problem problem = loadProblem(folder.write(
      "group.yaml",
      withLink("groups: {it: [robot]}\nmargins: [{between: [it, post], margin: 0.1}]\n")));
  ASSERT_EQ(problem.margins.pairs.size(), 1U);
  EXPECT_EQ(problem.margins.pairs[0].a, "robot");
  // All links of a body are one.
  EXPECT_NO_THROW(loadProblem(folder.write(
      "body.yaml",
      "leeway: 1\nbody: {name: robot, joint: planar, bounds: {lower: [-1, -1], upper: [1, 1]}, "
      "shapes: [{sphere: {radius: 0.1}}]}\nstart: {position: [0, 0], angle: 0}\ngoal: {position: "
      "[0.5, 0], angle: 0}\nobjects: [{name: post, position: [0, 1, 0], sphere: {radius: "
      "0.1}}]\nmargins: [{between: [robot, post], margin: 0.1}]\n")));
}

TEST(ProblemMessages, Files) {
  const Folder folder;
  try {
    loadProblem(folder.path("absent.yaml"));
    FAIL();
  } catch (const robots::InputError& error) {
    EXPECT_EQ(
        std::string(error.what()),
        (folder.path("absent.yaml")) + ": there is no such file; a YAML or JSON file is expected");
  }
  try {
    loadProblem(folder.path() + "/");
    FAIL();
  } catch (const robots::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("is a folder; a YAML or JSON file is expected"),
              std::string::npos)
        << error.what();
  }
}

TEST(ProblemMessages, Syntax) {
  expectMessages({
      {"leeway: 1\nobjects: [1, 2\n", 3, "YAML syntax error: "},
      {"leeway: 1\nname: @x\n", 2, "YAML syntax error: "},
      {"leeway: 1\n  name: x\n", 2, "YAML syntax error: "},
      {"", 0, "is empty; a YAML or JSON file is expected"},
      {"  leeway: 1\nobjects:\n  - name: wall\n", 0, "holds 2 YAML documents or more"},
      {"leeway: 1\n---\nleeway: 1\n", 0, "holds 2 YAML documents or more"},
      // yaml-cpp's own loop over all documents never ends here.
      {"[1], x\n", 0, "exactly one is expected"},
      {"[1, 2]\n", 1, "is no map; a problem file (leeway: 1, ...) is expected"},
  });
}

TEST(ProblemMessages, Version) {
  expectMessages({
      {"name: x\n", 1,
       "key 'leeway' is missing: no problem file of this program; 'leeway: 1' is expected"},
      {"name: x\nrobot_model_name: arm\n", 1,
       "key 'leeway' is missing: as MoveIt writes scenes and requests; a problem file that names "
       "both under 'moveit' is expected, or --robot with `leeway batch` or `leeway lint`"},
      {"name: x\nleeway: 2\n", 2,
       "problem format version '2' is not known; 'leeway: 1' is expected"},
      {"leeway: [1]\n", 1, "problem format version '?' is not known; 'leeway: 1' is expected"},
  });
}

TEST(ProblemMessages, Keys) {
  expectMessages({
      {withRobot("objekts: []\n"), 8, "unknown key 'objekts' in the file; did you mean 'objects'?"},
      {withRobot("zzzzzzzzzz: 1\n"), 8,
       "unknown key 'zzzzzzzzzz' in the file; known: leeway, name, robot, "},
      {withRobot("margin: 0.1\nseed: 3\nmargin: 0.2\n"), 10,
       "key 'margin' stands twice in the file, first for line 8; once is expected"},
      {withRobot("objects:\n  - name: a\n    box: {size: [1, 1, 1]}\n    positon: [0, 0, 0]\n"), 11,
       "unknown key 'positon' in objects[0]; did you mean 'position'?"},
      {withRobot("objects:\n  - name: a\n    box: {sise: [1, 1, 1]}\n"), 10,
       "unknown key 'sise' in objects[0].box; did you mean 'size'?"},
      {withRobot("limits: {tim: 1}\n"), 8, "unknown key 'tim' in limits; did you mean 'time'?"},
      {withRobot("? [1]\n: 2\n"), 8,
       "a key of the file is no plain text; 'key: value' is expected"},
  });
}

TEST(ProblemMessages, Types) {
  expectMessages({
      {withRobot("margin: wide\n"), 8, "margin is 'wide'; a number is expected"},
      {withRobot("margin: \"1\"\n"), 8, "margin is the text \"1\"; a number is expected"},
      {withRobot("margin: 1,5\n"), 8, "margin is '1,5'; a number is expected"},
      {withRobot("margin: 0x10\n"), 8, "margin is '0x10'; a number is expected"},
      {withRobot("margin:\n"), 8, "margin is nothing; a number is expected"},
      {withRobot("margin: [1]\n"), 8, "margin is a list of 1; a number is expected"},
      {withRobot("objects: 3\n"), 8, "objects is '3'; a list is expected"},
      {withRobot("objects: [3]\n"), 8, "objects[0] is '3'; a map (key: value) is expected"},
      {withRobot("simplify: yes\n"), 8, "simplify is 'yes'; true or false is expected"},
      {withRobot("seed: -1\n"), 8,
       "seed is '-1'; a whole number from 0 to 18446744073709551615 is expected"},
      {withRobot("limits: {iterations: 1.5}\n"), 8,
       "limits.iterations is '1.5'; a whole number of at least 0 is expected"},
      {withRobot("name: [a]\n"), 8, "name is a list of 1; a text is expected"},
      {withRobot("planner: RRTConnect\n"), 8,
       "planner is 'RRTConnect'; a map (key: value) is expected"},
      {withRobot("objective: speed\n"), 8,
       "objective 'speed' is not known; length, clearance, or a map with integral or weighted is "
       "expected"},
  });
}

TEST(ProblemMessages, NumbersThatAreNone) {
  const auto box = [](const std::string& size) {
    return withRobot("objects:\n  - {name: a, box: {size: " + size + "}}\n");
  };
  expectMessages({
      {withRobot("margin: .nan\n"), 8, "margin is '.nan'; a finite number is expected"},
      {withRobot("margin: nan\n"), 8, "margin is 'nan'; a finite number is expected"},
      {withRobot("margin: -.inf\n"), 8, "margin is '-.inf'; a finite number is expected"},
      {withRobot("margin: 1e999\n"), 8, "margin is '1e999'; a finite number is expected"},
      {withRobot("", "[0, .inf, 0, 0, 0, 0]"), 6,
       "start[1] is '.inf'; a finite number is expected"},
      {box("[1, .nan, 1]"), 9, "objects[0].box.size[1] is '.nan'; a finite number is expected"},
      {box("[1, -2, 1]"), 9, "objects[0].box.size[1] is -2; zero or more is expected"},
      {box("[1, 2]"), 9, "objects[0].box.size is a list of 2; a list of three numbers is expected"},
      {withRobot("limits: {time: -1}\n"), 8, "limits.time is -1; zero or more is expected"},
      {withRobot("objects:\n  - name: a\n    sphere: {radius: -0.1}\n"), 10,
       "objects[0].sphere.radius is -0.1; zero or more is expected"},
      {withRobot("objects:\n  - name: a\n    sphere: {radius: 1e10}\n"), 10,
       "objects[0].sphere: sphere: radius is 10000000000, but must be a number that is not "
       "negative and at most 1e+09 [m]"},
      {withRobot("objects:\n  - name: a\n    cylinder: {radius: 0, length: 1e-9}\n"), 10,
       "objects[0].cylinder: cylinder: half length is 5.0000000000000003e-10; the largest size "
       "must be 0 or from 1e-09 to 1e+09 [m]"},
      {withRobot("objects:\n  - name: a\n    convex_hull: {points: [[0, 0, 0], [0, 2e9, 0]]}\n"),
       10,
       "objects[0].convex_hull: convex hull: point 1 has the coordinate 2000000000; finite numbers "
       "up to 1e+09 are accepted [m]"},
      {withRobot("objects:\n  - name: a\n    mesh: {file: m.obj, scale: [1, 0, 1]}\n"), 10,
       "objects[0].mesh.scale holds a zero; other factors are expected"},
  });
}

TEST(ProblemMessages, Poses) {
  const auto posed = [](const std::string& pose) {
    return withRobot("objects:\n  - name: a\n    sphere: {radius: 1}\n    " + pose + "\n");
  };
  expectMessages({
      {posed("orientation: [0, 0, 0, 1.01]"), 11,
       "objects[0].orientation is a quaternion of length 1.01; unit length (within 0.001) is "
       "expected"},
      {posed("orientation: [0, 0, 0, 0]"), 11,
       "objects[0].orientation is a quaternion of length 0; unit length"},
      {posed("orientation: [0, 0, 1]"), 11,
       "objects[0].orientation is a list of 3; a quaternion [x, y, z, w] is expected"},
      {posed("rpy: [0, 0, 0]\n    orientation: [0, 0, 0, 1]"), 11,
       "objects[0] has both 'orientation' and 'rpy'; one is expected"},
      {posed("rpy: [0, 0, 1e7]"), 11,
       "objects[0].rpy holds an angle of 10000000; at most 1000 rad is expected"},
  });
}

TEST(ProblemMessages, NearlyUnitQuaternionsAreMendedWithAWarning) {
  const Folder folder;
  const std::string text = withRobot(
      "objects:\n  - {name: a, sphere: {radius: 0.1}, position: [9, 9, 9], orientation: [0, 0, "
      "0.7071, 0.7071]}\n");
  const Problem problem = loadProblem(folder.write("problem.yaml", text));
  ASSERT_EQ(problem.warnings.size(), 1U);
  EXPECT_EQ(problem.warnings[0].substr(0, (folder.path("problem.yaml")).size() + 4),
            (folder.path("problem.yaml")) + ":9: ");
  EXPECT_NE(problem.warnings[0].find("objects[0].orientation is a quaternion of length 0.9999"),
            std::string::npos);
  const Eigen::Matrix3d& rotation = problem.world.objects[0].X_WO.rotation;
  EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-15);
}

TEST(ProblemMessages, Shapes) {
  const auto object = [](const std::string& shape) {
    return withRobot("objects:\n  - name: a\n" + shape);
  };
  expectMessages({
      {object(""), 9,
       "objects[0] has no shape; box, sphere, cylinder, capsule, cone, ellipsoid, half_space, "
       "mesh, "
       "convex_hull or height_field or 'shapes' is expected"},
      {object("    box: {size: [1, 1, 1]}\n    sphere: {radius: 1}\n"), 9,
       "objects[0] has both 'box' and 'sphere'; one shape is expected (several go under 'shapes')"},
      {object("    box: {size: [1, 1, 1]}\n    shapes: []\n"), 9,
       "objects[0] has both 'shapes' and 'box'; one is expected"},
      {object("    shapes: []\n"), 10,
       "objects[0].shapes is empty; at least one shape is expected"},
      {object("    shapes: [{position: [0, 0, 0]}]\n"), 10,
       "objects[0].shapes[0] has no shape; box, "},
      {object("    cylinder: {radius: 1}\n"), 10,
       "key 'length' is missing in objects[0].cylinder; a number [m] is expected"},
      {object("    box:\n"), 10, "objects[0].box is nothing; a map (key: value) is expected"},
      {object("    convex_hull: {points: []}\n"), 10,
       "objects[0].convex_hull.points is empty; at least one point is expected"},
      {object("    convex_hull: {}\n"), 10,
       "objects[0].convex_hull has neither 'points' nor 'file'; either is expected"},
      {object("    convex_hull: {points: [[0, 0, 0]], file: m.obj}\n"), 10,
       "objects[0].convex_hull has both 'points' and 'file'; either is expected"},
      {object("    convex_hull: {points: [[0, 0, 0]], scale: 2}\n"), 10,
       "objects[0].convex_hull.scale goes with 'file' only"},
      {object("    half_space: {normal: [0, 0, 1]}\n"), 10,
       "unknown key 'normal' in objects[0].half_space"},
  });
}

TEST(ProblemMessages, Meshes) {
  const auto mesh = [](const std::string& file) {
    return withRobot("objects:\n  - name: a\n    mesh: {file: " + file + "}\n");
  };
  expectMessages({
      {mesh("absent.stl"), 10, "absent.stl"},
      {mesh("empty.obj"), 10, "empty.obj"},
      {mesh("broken.stl"), 10, "broken.stl"},
  });
}

TEST(ProblemMessages, Names) {
  expectMessages({
      {withRobot("objects:\n  - {name: forearm, sphere: {radius: 0.1}}\n"), 9,
       "objects[0].name 'forearm' is the name of another object or link; a name of its own is "
       "expected"},
      {withRobot("objects:\n  - {name: a, sphere: {radius: 0.1}}\n  - {name: a, sphere: {radius: "
                 "0.1}}\n"),
       10,
       "objects[1].name 'a' is the name of another object or link; a name of its own is expected"},
      {withRobot("objects:\n  - {sphere: {radius: 0.1}}\n"), 9,
       "key 'name' is missing in objects[0]; a name of its own is expected"},
      {withRobot("objects:\n  - {name: a, sphere: {radius: 0.1}, attach: {link: tol}}\n"), 9,
       "unknown link 'tol' in objects[0].attach.link; did you mean 'tool'?"},
      {withRobot("objects:\n  - {name: a, sphere: {radius: 0.1}, attach: {link: tool, touch: "
                 "[wrist_3]}}\n"),
       9, "unknown link 'wrist_3' in objects[0].attach.touch[0]; did you mean 'wrist3'?"},
      {withRobot("allowed:\n  - [base, formarm]\n"), 9,
       "allowed[0]: no link or object is named 'formarm'; did you mean 'forearm'?"},
      {withRobot("allowed:\n  - [base]\n"), 9,
       "allowed[0] is no pair; two different names of links or objects are expected"},
      {withRobot("allowed:\n  - [base, base]\n"), 9,
       "allowed[0]: 'base' stands twice; two different names of links or objects are expected"},
      {withRobot("margins:\n  - {between: [base, tabel], margin: 1}\n"), 9,
       "margins[0].between: no link or object is named 'tabel'"},
      {withRobot("margins:\n  - {between: [base, forearm]}\n"), 9,
       "key 'margin' is missing in margins[0]; a number [m] is expected"},
  });
}

TEST(ProblemMessages, Robots) {
  const std::string states = "start: [0]\ngoal: [0]\n";
  const std::string urdf = sourceFolder() + "/robots/arm6/arm6.urdf";
  expectMessages({
      {"leeway: 1\n" + states, 1,
       "the file has neither 'robot' nor 'body'; one of them is expected"},
      {withBody("robot: {urdf: x}\n"), 1,
       "the file has both 'robot' and 'body'; one of them is expected"},
      {"leeway: 1\nrobot: {srdf: x}\n" + states, 2,
       "key 'urdf' is missing in robot; the path of a URDF is expected"},
      {"leeway: 1\nrobot:\n  urdf: absent.urdf\n" + states, 3,
       "absent.urdf', which does not exist; an existing file is expected"},
      {"leeway: 1\nrobot:\n  urdf: " + urdf + "\n  srdf: absent.srdf\n" + states, 4,
       "absent.srdf', which does not exist; an existing file is expected"},
      {"leeway: 1\nrobot:\n  urdf: " + urdf + "\n  packages: {a: nowhere}\n" + states, 4,
       "nowhere'; an existing folder is expected"},
      {"leeway: 1\nrobot:\n  urdf: " + urdf + "\n  srdf: " + sourceFolder() +
           "/robots/arm6/arm6.srdf\n  group: amr\n" + states,
       5, "robot 'arm6' has no group or joint 'amr'; did you mean 'arm'?"},
      {"leeway: 1\nbody: {joint: flying}\n" + states, 2,
       "body.joint is 'flying'; planar or floating is expected"},
      {"leeway: 1\nbody: {joint: planar, bounds: {lower: [0, 0, 0], upper: [1, 1]}, shapes: "
       "[{sphere: {radius: 1}}]}\n" +
           states,
       2, "body.bounds.lower is a list of 3; [x, y] is expected"},
      {"leeway: 1\nbody: {joint: planar, bounds: {lower: [2, 0], upper: [1, 1]}, shapes: [{sphere: "
       "{radius: 1}}]}\n" +
           states,
       2, "body.bounds has lower above upper; lower <= upper is expected"},
      {"leeway: 1\nbody: {joint: planar, bounds: {lower: [0, 0], upper: [1, 1]}}\n" + states, 2,
       "key 'shapes' is missing in body; a list of shapes is expected"},
  });
}

TEST(ProblemMessages, Starts) {
  const std::string names =
      "pan_joint, lift_joint, elbow_joint, wrist1_joint, wrist2_joint, wrist3_joint";
  expectMessages({
      {withRobot("", "[0, 0]"), 6, "start is a list of 2; 6 values are expected: " + names},
      {withRobot("", "hoem"), 6,
       "no group state 'hoem' for the planned joints; did you mean 'home'?"},
      {withRobot("", "{pan_joint: 0}"), 6,
       "start says nothing of joint 'lift_joint'; a value for every planned joint is expected: " +
           names},
      {withRobot("", "{pan_jiont: 0}"), 6,
       "unknown joint 'pan_jiont' in start; did you mean 'pan_joint'?"},
      {withRobot("", "[0, 0, 3.5, 0, 0, 0]"), 6,
       "start has joint 'elbow_joint' at 3.5, outside its limits; -3.14159 to 3.14159 is expected"},
      {withRobot("", "[[0, 1], 0, 0, 0, 0, 0]"), 6,
       "start[0] is a list of 2; a number is expected"},
      {withRobot("", "any"), 6,
       "no group state 'any' for the planned joints; known: home, ready, stretched"},
      {withRobot("", ""), 6,
       "start is empty; a group state, a list of values or a map by joint is expected"},
      {withRobot("joints: {pan_joint: 1}\n"), 8,
       "joint 'pan_joint' is planned; its value belongs under 'start'"},
      {withBody("", "{position: [0, 0, 0]}"), 6,
       "start.position is a list of 3; [x, y] is expected"},
      {withBody("", "{position: [0, 3]}"), 6,
       "start has joint 'body/y' at 3, outside its limits; -1 to 1 is expected"},
      {withBody("", "{position: [0, 0], angle: 1e6}"), 6,
       "start has joint 'body/theta' at 1000000; at most 1000 rad is expected"},
      {withBody("", "{position: [0, 0], rpy: [0, 0, 0]}"), 6, "unknown key 'rpy' in start"},
  });
}

TEST(ProblemMessages, Goals) {
  const std::string start = "[0, 0, 0, 0, 0, 0]";
  expectMessages({
      {withRobot("goals: [home]\n"), 1,
       "the file has both 'goal' and 'goals'; one of them is expected"},
      {"leeway: 1\nbody: {joint: planar, bounds: {lower: [0, 0], upper: [1, 1]}, shapes: [{sphere: "
       "{radius: 1}}]}\nstart: [0, 0, 0]\n",
       1, "the file has neither 'goal' nor 'goals'; one of them is expected"},
      {withRobot("", start, "[0, 0, 0, 0, 0, [1, 0]]"), 7,
       "goal[5] is no range; [from, to] with from <= to is expected"},
      {withRobot("", start, "[0, 0, 0, 0, 0, [1, 7]]"), 7,
       "goal has joint 'wrist3_joint' at 7, outside its limits; -6.28319 to 6.28319 is expected"},
      {withRobot("", start, "{base_joint: 1}"), 7, "unknown joint 'base_joint' in goal"},
      {withRobot("", start, "{tool_joint: 1}"), 7,
       "joint 'tool_joint' in goal is fixed; a planned joint is expected: pan_joint, "},
  });
}

TEST(ProblemMessages, GoalPoses) {
  const std::string start = "[0, 0, 0, 0, 0, 0]";
  const auto withGoal = [&](const std::string& pose, const std::string& more = "") {
    return withRobot(more, start, "{pose: " + pose + "}");
  };
  expectMessages({
      {withGoal("{frame: tol, position: [1, 0, 0]}"), 7,
       "goal.pose: no frame, link or attached object 'tol'; did you mean 'tool'?"},
      {withGoal("{frame: base, position: [1, 0, 0]}"), 7,
       "'base' is not moved by the planned joints; a frame that they move is expected"},
      {withGoal("{frame: tool}"), 7, "goal.pose says nothing of where"},
      {withGoal("{frame: tool, position: [1, 0]}"), 7, "goal.pose.position is a list of 2; three"},
      {withGoal("{frame: tool, position: [1, 0, [1, 0]]}"), 7, "goal.pose.position[2] is no range"},
      {withGoal("{frame: tool, relative_to: can, position: [1, 0, 0]}"), 7,
       "no object, link or frame 'can' to be relative to"},
      {withGoal("{frame: tool, relative_to: forearm, position: [1, 0, 0]}"), 7,
       "'forearm' moves with the planned joints; something at rest"},
      {withGoal("{frame: tool, orientation: [1, 0, 0, 1]}"), 7,
       "goal.pose.orientation is a quaternion of length 1.414"},
      {withGoal("{frame: tool, rpy: [0, 0, 0], orientation: [0, 0, 0, 1]}"), 7,
       "goal.pose has both 'orientation' and 'rpy'; one is expected"},
      {withGoal("{frame: tool, position: [1, 0, 0], position_tolerance: 1e-13}"), 7,
       "goal.pose: position_tolerance is 1e-13; at least 1e-12, which rounding comes near"},
      {withRobot("", start, "{poses: []}"), 7, "goal.poses is empty; a pose is expected"},
      {withRobot("frames: {tip: {link: tol}}\n"), 8, "unknown link 'tol' in frames.tip"},
      {withRobot("frames: {base: {link: tool}}\n"), 8,
       "frame 'base' has the name of a link or object; a name of its own is expected"},
      {withRobot("frames:\n  tip:\n    link: tool\n    orientation: [0, 0, 0, 2]\n"), 11,
       "is a quaternion of length 2"},
  });
}

TEST(ProblemMessages, Moveit) {
  const std::string robot = "leeway: 1\nrobot: {urdf: " + sourceFolder() +
                            "/robots/arm7/arm7.urdf, srdf: " + sourceFolder() +
                            "/robots/arm7/arm7.srdf}\n";
  const std::string moveit = "moveit: {scene: " + sourceFolder() +
                             "/problems/moveit/scene0001.yaml, request: " + sourceFolder() +
                             "/problems/moveit/request0001.yaml}\n";
  const Folder folder;
  EXPECT_NO_THROW(loadProblem(folder.write("good.yaml", robot + moveit)));
  expectMessages({
      {robot + moveit + "start: home\n", 4,
       "key 'start' stands beside 'moveit', whose request says it; one of them is expected"},
      {robot + "moveit: {scene: x}\n", 3,
       "key 'request' is missing in moveit; the path of a motion plan request is expected"},
      {"leeway: 1\n" + moveit, 1, "key 'robot' is missing in the file; urdf and srdf is expected"},
      {"leeway: 1\nrobot: {urdf: x, group: arm}\n" + moveit, 2,
       "key 'group' stands beside 'moveit', whose request names the group"},
  });
}

}  // namespace
}  // namespace leeway::planner
