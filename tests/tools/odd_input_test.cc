// What is no text, no file, or another file than meant, in every place that takes one: a readable
// line that names it, status 2, at once.

#include <sys/stat.h>

#include <chrono>
#include <functional>
#include <thread>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class OddInput : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("scene.yaml", kScene);
    write("request.yaml", kRequest);
    write("moveit.yaml",
          "leeway: 1\nrobot: {urdf: arm.urdf, srdf: arm.srdf}\n"
          "moveit: {scene: scene.yaml, request: request.yaml}\n");
    EXPECT_EQ(run("plan moveit.yaml").status, 0);
  }

  /// Every command that reads files, with the one that is to be odd.
  static const std::vector<std::pair<std::string, std::string>>& readers() {
    static const std::vector<std::pair<std::string, std::string>> all = {
        {"plan reach.yaml", "reach.yaml"},
        {"plan reach.yaml", "arm.urdf"},
        {"plan reach.yaml", "arm.srdf"},
        {"check --robot arm.urdf --srdf arm.srdf --state right", "arm.srdf"},
        {"info arm.urdf", "arm.urdf"},
        {"info reach.yaml", "reach.yaml"},
        {"plan moveit.yaml", "scene.yaml"},
        {"plan moveit.yaml", "request.yaml"},
        {"plan --robot arm.urdf --srdf arm.srdf --scene room.scene --request request.yaml",
         "room.scene"},
        {"verify reach.yaml path.json", "path.json"},
        {"verify reach.yaml path.yaml", "path.yaml"},
        {"clearance reach.yaml path.csv", "path.csv"},
        {"clearance reach.yaml path.path", "path.path"},
        {"check mesh.yaml", "block.stl"},
        {"check mesh.yaml", "block.obj"},
    };
    return all;
  }

  /// Puts something odd in the place of each file in turn.
  void expectRefusedEverywhere(const std::function<void(const std::string&)>& make,
                               const std::string& word) const {
    for (const auto& [command, file] : readers()) {
      SCOPED_TRACE(command + " with an odd " + file);
      if (file.starts_with("block"))
        write("mesh.yaml",
              "leeway: 1\nbody: {joint: floating, bounds: {lower: [0, 0, 0], upper: [1, 1, 1]}, "
              "shapes: [{mesh: {file: " +
                  file + "}}]}\nstart: [0, 0, 0, 0, 0, 0, 1]\ngoal: [0, 0, 0, 0, 0, 0, 1]\n");
      const fs::path place = folder_ / file, kept = folder_ / "kept";
      const bool was_there = fs::exists(place);
      if (was_there) fs::rename(place, kept);
      make(place.string());
      const auto begin = std::chrono::steady_clock::now();
      const Answer answer = run(command);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      fs::remove_all(place);
      if (was_there) fs::rename(kept, place);
      EXPECT_EQ(answer.status, 2);
      EXPECT_EQ(answer.out, "");
      EXPECT_EQ(std::count(answer.err.begin(), answer.err.end(), '\n'), 1) << answer.err;
      EXPECT_LE(answer.err.size(), 501U) << answer.err;
      EXPECT_EQ(answer.err.find_first_of("\r\t\x01\x1b"), std::string::npos) << answer.err;
      EXPECT_NE(answer.err.find(file), std::string::npos) << answer.err;
      EXPECT_LT(took.count(), 5) << answer.err;
      // Mesh importers have words of their own.
      if (!file.starts_with("block")) {
        EXPECT_NE(answer.err.find(word), std::string::npos) << answer.err;
      }
    }
  }
};

TEST_F(OddInput, IsNoFile) {
  expectRefusedEverywhere([](const std::string& path) { fs::create_directory(path); },
                          "is a folder");
  expectRefusedEverywhere([](const std::string& path) { fs::create_symlink("/dev/zero", path); },
                          "is a device");
  expectRefusedEverywhere([](const std::string& path) { fs::create_symlink(path, path); }, "");
}

TEST_F(OddInput, IsNoText) {
  const auto holding = [this](const std::string& text) {
    return
        [this, text](const std::string& path) { write(fs::path(path).filename().string(), text); };
  };
  expectRefusedEverywhere(holding(std::string("leeway: 1\n\0\x01", 12)), "is binary, or UTF-16");
  expectRefusedEverywhere(holding(""), "");
  expectRefusedEverywhere(holding("\x1b[31m\x01 \r\t x"), "");
  expectRefusedEverywhere(holding(std::string(1000000, 'a')), "");
  expectRefusedEverywhere(holding(std::string(100000, '[')), "");
  std::string nested = "<robot name=\"a\">", header;
  for (int i = 0; i < 100000; ++i) nested += "<link>";
  expectRefusedEverywhere(holding(nested), "");
  for (int i = 0; i < 100000; ++i) header += "column" + std::to_string(i) + ",";
  expectRefusedEverywhere(holding(header + "\n1,2\n"), "");
}

TEST_F(OddInput, IsAnotherFile) {
  write("bad.srdf", kUrdf);
  expectRefused("check --robot arm.urdf --srdf bad.srdf --state right",
                {"bad.srdf:2:", "is a URDF; an SRDF is expected"});
  write("bad.urdf", kSrdf);
  expectRefused("info bad.urdf", {"bad.urdf:1:", "is an SRDF; a URDF is expected"});
  write("bad.urdf", kReach);
  expectRefused("info bad.urdf", {"bad.urdf: is no XML"});
  write("bad.yaml", kUrdf);
  expectRefused("plan bad.yaml", {"bad.yaml: is XML", "a YAML or JSON file is expected"});
  // What pointed there is told.
  write("arm.srdf", kReach);
  expectRefused("plan reach.yaml", {"arm.srdf: is no XML", "(reach.yaml:3 names it)"});
  write("arm.srdf", kSrdf);
  write("request.yaml", "");
  expectRefused("plan moveit.yaml", {"request.yaml: is empty", "(moveit.yaml:3 names it)"});
}

TEST_F(OddInput, IsCutOff) {
  for (const auto& [file, text] :
       {std::pair("arm.urdf", std::string(kUrdf)), std::pair("arm.srdf", std::string(kSrdf)),
        std::pair("reach.yaml", std::string(kReach))}) {
    int refused = 0;
    for (std::size_t size = 0; size + 10 < text.size(); size += 67) {
      write(file, text.substr(0, size));
      const Answer answer = run("check reach.yaml");
      EXPECT_LE(answer.status, 2) << text.substr(0, size);
      if (answer.status != 2) continue;  // some halves of a YAML are problems, too
      ++refused;
      EXPECT_EQ(std::count(answer.err.begin(), answer.err.end(), '\n'), 1) << answer.err;
    }
    EXPECT_GT(refused, 2) << file;
    write(file, text);
  }
}

/// As `<(generate)` gives them.
TEST_F(OddInput, APipeIsRead) {
  fs::remove(folder_ / "reach.yaml");
  ASSERT_EQ(::mkfifo((folder_ / "reach.yaml").c_str(), 0600), 0);
  std::thread writer([&] { write("reach.yaml", kReach); });
  const Answer answer = run("check reach.yaml");
  writer.join();
  EXPECT_EQ(answer.status, 0) << answer.err;
}

}  // namespace
}  // namespace leeway::tools::testing
