#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

const char* const kVerbs[] = {"plan", "check", "verify", "clearance", "replan", "batch",
                              "info", "ik",    "fk",     "view",      "report"};

class Usage : public CommandTest {};

TEST_F(Usage, HelpNamesEveryVerb) {
  const Answer answer = run("--help");
  EXPECT_EQ(answer.status, 0);
  EXPECT_EQ(answer.err, "");
  for (const char* verb : kVerbs) {
    EXPECT_NE(answer.out.find(std::string("  ") + verb), std::string::npos) << verb;
  }
}

TEST_F(Usage, VersionIsTheProjects) {
  const Answer answer = run("--version");
  EXPECT_EQ(answer.status, 0);
  EXPECT_EQ(answer.out, "leeway 0.1.0\n");
}

TEST_F(Usage, WrongUseIsStatus2) {
  expectRefused("", {"--help"});
  expectRefused("dance", {"--help"});
  expectRefused("plan reach.yaml --fast", {"leeway plan", "--fast"});
  expectRefused("plan reach.yaml --seed many", {"--seed"});
  expectRefused("plan reach.yaml --seed -1", {"--seed", "'-1'"});
  expectRefused("plan reach.yaml --seed 18446744073709551616", {"18446744073709551616"});
  expectRefused("info reach.yaml --seed -1", {"--seed", "'-1'"});
  expectRefused("plan reach.yaml --output ''", {"--output", "empty"});
  expectRefused("plan reach.yaml --planner ''", {"--planner", "empty"});
  expectRefused("plan ''", {"problem", "empty"});
  expectRefused("check reach.yaml --tolerance inf", {"--tolerance inf"});
  expectRefused("plan", {"problem file", "--robot"});
  expectRefused("plan reach.yaml --time 0", {"--time 0"});
  expectRefused("plan reach.yaml --time nan", {"--time nan"});
  expectRefused("plan reach.yaml --iterations -3", {"--iterations -3"});
  expectRefused("plan reach.yaml --objective beauty", {"beauty", "length", "clearance"});
  expectRefused("plan reach.yaml --group arm", {"reach.yaml"});
  expectRefused("plan --robot arm.urdf --srdf arm.srdf --group arm", {"--goal"});
  expectRefused("plan --robot arm.urdf --scene scene.yaml", {"--request"});
  expectRefused("plan reach.yaml --package nonsense", {"NAME=DIR", "nonsense"});
  expectRefused("plan reach.yaml --package a=/nowhere", {"/nowhere"});
  expectRefused("verify reach.yaml", {"path file"});
  expectRefused("batch reach.yaml --resume", {"--output"});
  expectRefused("batch reach.yaml --shard 5/4", {"5/4"});
  expectRefused("batch reach.yaml --shard x", {"'x'"});
  expectRefused("batch nowhere", {"nowhere"});
  expectRefused("check reach.yaml --tolerance 0", {"--tolerance 0"});
  expectRefused("report", {"--help"});
}

/// A script must notice when its answer could not be written.
TEST_F(Usage, AnswerThatCannotBeWrittenIsStatus2) {
  if (!fs::exists("/dev/full")) {
    GTEST_SKIP() << "there is no /dev/full";
  }
  for (const char* arguments :
       {"plan reach.yaml", "plan reach.yaml --json", "check reach.yaml", "batch reach.yaml",
        "info reach.yaml --json", "--help", "plan --help", "--version"}) {
    for (const char* nowhere : {">/dev/full", ">&-"}) {
      const Answer answer = shell(("'" + leeway::commandFile() + "' ") + arguments + " " + nowhere);
      EXPECT_EQ(answer.status, 2) << arguments << nowhere << answer.err;
      EXPECT_NE(answer.err.find("standard output: cannot be written"), std::string::npos)
          << arguments << nowhere << answer.err;
    }
  }
}

/// Lines under "Example" that begin with the command.
std::vector<std::string> examplesOf(const std::string& help) {
  std::vector<std::string> examples;
  std::istringstream in(help.substr(std::min(help.find("Example"), help.size())));
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("  leeway ")) {
      examples.push_back(line);
    }
  }
  return examples;
}

/// Each runs as written, from the source tree's top; output goes elsewhere.
class Examples : public CommandTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(Examples, Run) {
  const Answer help = run(std::string(GetParam()) + " --help");
  EXPECT_EQ(help.status, 0);
  const std::vector<std::string> examples = examplesOf(help.out);
  EXPECT_FALSE(examples.empty()) << help.out;
  const fs::path source(leeway::sourceFolder());
  for (const char* name : {"problems", "robots", "tests"}) {
    fs::create_directory_symlink(source / name, path(name));
  }
  for (const std::string& example : examples) {
    const Answer answer =
        shell("PATH=$(dirname '" + leeway::commandFile() + "'):$PATH; " + example);
    EXPECT_EQ(answer.status, 0) << example << "\n" << answer.err;
    EXPECT_NE(answer.out + read("lines.json"), "") << example;
  }
}

// gtest names the test's folder by the suffix, without the '/'.
INSTANTIATE_TEST_SUITE_P(Verbs, Examples, ::testing::ValuesIn(kVerbs),
                         [](const auto& verb) { return std::string(verb.param); });

}  // namespace
}  // namespace leeway::tools::testing
