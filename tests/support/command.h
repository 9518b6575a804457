#pragma once

// Runs the built command as a user would, in a folder with a small robot and problems for it.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::tools::testing {

namespace fs = std::filesystem;
using nlohmann::json;

/// Adds the keys of a document and of all that is nested in it.
inline void collectKeys(const json& value, std::set<std::string>& keys) {
  if (value.is_array())
    for (const json& entry : value) collectKeys(entry, keys);
  if (!value.is_object()) return;
  for (const auto& [key, below] : value.items()) {
    keys.insert(key);
    collectKeys(below, keys);
  }
}

struct Answer {
  int status = -1;
  std::string out, err;

  /// stdout with a space for each line break: prose is broken where it fits.
  std::string flat() const {
    std::string text = out;
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
  }
  /// The JSON document on stdout; empty, with a test failure, if there is none.
  json document() const {
    const json parsed = json::parse(out, nullptr, false);
    EXPECT_TRUE(parsed.is_object()) << out << err;
    return parsed.is_object() ? parsed : json::object();
  }
  std::vector<json> lines() const {
    std::vector<json> all;
    std::istringstream in(out);
    for (std::string line; std::getline(in, line);) {
      all.push_back(json::parse(line, nullptr, false));
      EXPECT_TRUE(all.back().is_object()) << line;
    }
    return all;
  }
};

/// Two 0.5 m links in the plane, turning about z. The second link can collide with the world, and
/// with the first when folded.
inline const char* const kUrdf = R"(<robot name="twolink">
  <link name="base"/>
  <link name="upper">
    <collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision>
  </link>
  <link name="lower">
    <collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2.5" upper="2.5" velocity="1" effort="1"/>
  </joint>
</robot>
)";

inline const char* const kSrdf = R"(<robot name="twolink">
  <group name="arm"><joint name="shoulder"/><joint name="elbow"/></group>
  <group_state name="right" group="arm"><joint name="shoulder" value="-1"/><joint name="elbow" value="0"/></group_state>
  <group_state name="left" group="arm"><joint name="shoulder" value="1"/><joint name="elbow" value="0.25"/></group_state>
  <disable_collisions link1="upper" link2="lower" reason="Adjacent"/>
</robot>
)";

/// A post in front of the arm: it must fold or take a short arc to pass.
inline const char* const kReach = R"(leeway: 1
name: around the post
robot: {urdf: arm.urdf, srdf: arm.srdf, group: arm}
start: right
goal: left
objects:
  - {name: post, position: [0.85, 0, 0], cylinder: {radius: 0.05, length: 1}}
limits: {time: 20}
seed: 7
)";

/// No obstacles.
inline const char* const kEmpty = R"(leeway: 1
robot: {urdf: arm.urdf, srdf: arm.srdf, group: arm}
start: right
goal: left
)";

/// The start is in contact with the post.
inline const char* const kInvalidStart = R"(leeway: 1
robot: {urdf: arm.urdf, srdf: arm.srdf, group: arm}
start: {shoulder: 0, elbow: 0}
goal: left
objects:
  - {name: post, position: [0.85, 0, 0], cylinder: {radius: 0.05, length: 1}}
)";

/// The same scene and request in MoveIt's format.
inline const char* const kScene = R"(name: post
robot_model_name: twolink
world:
  collision_objects:
    - id: post
      primitives:
        - {type: cylinder, dimensions: [1, 0.05]}
      primitive_poses:
        - {position: [0.85, 0, 0], orientation: [0, 0, 0, 1]}
)";
inline const char* const kRequest = R"(group_name: arm
start_state:
  joint_state: {name: [elbow, shoulder], position: [0, -1]}
goal_constraints:
  - joint_constraints:
      - {joint_name: shoulder, position: 1}
      - {joint_name: elbow, position: 0.25}
)";

class CommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    // Two builds may be tested at the same time.
    std::string name = std::string("leeway_") + info->test_suite_name() + "_" + info->name() + "_" +
                       std::to_string(::getpid());
    std::replace(name.begin(), name.end(), '/', '_');
    folder_ = fs::path(::testing::TempDir()) / name;
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("arm.urdf", kUrdf);
    write("arm.srdf", kSrdf);
    write("reach.yaml", kReach);
    write("empty.yaml", kEmpty);
  }
  void TearDown() override {
    if (!HasFailure()) {
      fs::remove_all(folder_);
    }
  }

  fs::path path(const std::string& name) const { return folder_ / name; }
  void write(const std::string& name, const std::string& text) const {
    writeText(path(name), text);
  }
  std::string read(const std::string& name) const { return readText(path(name)); }

  /// Runs `leeway ARGUMENTS` in a shell in the test's folder.
  Answer run(const std::string& arguments) const {
    return shell("'" + leeway::commandFile() + "' " + arguments);
  }

  Answer shell(const std::string& line) const {
    const std::string out = path("stdout.txt").string();
    const std::string err = path("stderr.txt").string();
    // Tests do not share a cache, unless the line itself sets one.
    const std::string command = "export LEEWAY_CACHE_DIR=; cd '" + folder_.string() + "' && { " +
                                line + "; } >'" + out + "' 2>'" + err + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(out), readText(err)};
  }

  /// Expects bad input: status 2, one line on stderr with all of `words`, and nothing on stdout or,
  /// with --json, a document that contains that line.
  void expectRefused(const std::string& arguments, const std::vector<std::string>& words) const {
    const Answer answer = run(arguments);
    EXPECT_EQ(answer.status, 2) << arguments << "\n" << answer.out << answer.err;
    if (arguments.find("--json") == std::string::npos) {
      EXPECT_EQ(answer.out, "") << arguments;
    } else {
      EXPECT_EQ(answer.document()["status"], "error") << arguments;
      EXPECT_EQ(answer.document()["error"].get<std::string>() + "\n", answer.err) << arguments;
    }
    EXPECT_EQ(std::count(answer.err.begin(), answer.err.end(), '\n'), 1) << answer.err;
    for (const std::string& word : words) {
      EXPECT_NE(answer.err.find(word), std::string::npos)
          << "no '" << word << "' in: " << answer.err;
    }
  }

  /// Runs the examples of `VERB --help` as written, from the source tree's top.
  void expectExamplesRun(const std::string& verb) const {
    const Answer help = run(verb + " --help");
    EXPECT_EQ(help.status, 0);
    for (const char* name : {"problems", "robots", "tests"})
      fs::create_directory_symlink(fs::path(leeway::sourceFolder()) / name, path(name));
    std::istringstream in(help.out.substr(std::min(help.out.find("Example"), help.out.size())));
    int examples = 0;
    for (std::string line; std::getline(in, line);) {
      if (!line.starts_with("  leeway ")) continue;
      for (std::string more; line.ends_with("\\") && std::getline(in, more);)
        line = line.substr(0, line.size() - 1) + more;
      ++examples;
      const Answer answer = shell("PATH=$(dirname '" + leeway::commandFile() + "'):$PATH; " + line);
      EXPECT_EQ(answer.status, 0) << line << "\n" << answer.err;
      EXPECT_NE(answer.out + read("lines.json"), "") << line;
    }
    EXPECT_GT(examples, 0) << help.out;
  }

  fs::path folder_;
};

}  // namespace leeway::tools::testing
