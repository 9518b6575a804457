#include <regex>

#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

const char* const kVerbs[] = {"plan", "check", "verify", "clearance", "replan", "guard", "batch",
                              "info", "lint",  "srdf",   "ik",        "fk",     "view",  "manual"};

class Usage : public CommandTest {};

TEST_F(Usage, HelpNamesEveryVerb) {
  const Answer answer = run("--help");
  EXPECT_EQ(answer.status, 0);
  EXPECT_EQ(answer.err, "");
  for (const char* verb : kVerbs) {
    EXPECT_NE(answer.out.find(std::string("  ") + verb), std::string::npos) << verb;
  }
  EXPECT_NE(answer.out.find("\n  report "), std::string::npos);
  EXPECT_NE(answer.out.find("\n  help "), std::string::npos);
}

TEST_F(Usage, VersionIsTheProjects) {
  const Answer answer = run("--version");
  EXPECT_EQ(answer.status, 0);
  EXPECT_EQ(answer.out, "leeway 0.1.0\n");
}

TEST_F(Usage, WrongUseIsStatus2) {
  expectRefused("", {"--help"});
  expectRefused("dance", {"--help", "'dance'"});
  expectRefused("help dance", {"--help", "'dance'"});
  expectRefused("paln reach.yaml", {"'paln'", "did you mean plan?"});
  expectRefused("plan reach.yaml --sed 3", {"did you mean --seed?"});
  expectRefused("plan reach.yaml --output=", {"--output"});
  expectRefused("plan reach.yaml --iterations 99999999999999999999", {"--iterations"});
  expectRefused("plan reach.yaml --trajectory t.csv --period nan", {"--period: nan", "2e-05"});
  expectRefused("clearance reach.yaml path.json --parts 0", {"--parts: 0", "1 to 100000"});
  expectRefused("clearance reach.yaml path.json --tolerance nan", {"--tolerance: nan"});
  expectRefused("plan reach.yaml --start 0.2", {"names its robot, start and goal itself; leave "
                                                "--start out"});
  expectRefused("plan reach.yaml --chain lower upper", {"itself; leave --chain out"});
  expectRefused("plan reach.yaml --fast", {"leeway plan", "--fast"});
  for (const char* verb : {"verify", "clearance", "view"})
    expectRefused(std::string(verb) + " reach.yaml path.json --fast 3",
                  {"there is no option '--fast'"});
  expectRefused("plan reach.yaml --seed many", {"--seed"});
  expectRefused("plan reach.yaml --seed -1", {"--seed", "'-1'"});
  expectRefused("plan reach.yaml --seed 18446744073709551616", {"18446744073709551616"});
  expectRefused("info reach.yaml --seed -1", {"--seed", "'-1'"});
  expectRefused("plan reach.yaml --output ''", {"--output", "empty"});
  expectRefused("plan reach.yaml --planner ''", {"--planner", "empty"});
  expectRefused("plan ''", {"problem", "empty"});
  expectRefused("check reach.yaml --tolerance inf", {"--tolerance: inf"});
  expectRefused("plan", {"problem file", "--robot"});
  expectRefused("plan reach.yaml --time 0", {"--time: 0"});
  expectRefused("plan reach.yaml --time nan", {"--time: nan"});
  expectRefused("plan reach.yaml --iterations -3", {"--iterations: -3"});
  expectRefused("plan reach.yaml --objective beauty", {"beauty", "length", "clearance"});
  expectRefused("plan reach.yaml --group arm", {"reach.yaml"});
  expectRefused("plan --robot arm.urdf --srdf arm.srdf --group arm", {"--goal"});
  expectRefused("plan --robot arm.urdf --scene scene.yaml", {"--request"});
  for (const char* verb : {"plan", "view", "check"})
    expectRefused(std::string(verb) + " arm.urdf", {"arm.urdf is a robot; --robot arm.urdf with"});
  expectRefused("plan arm.srdf", {"arm.srdf is an SRDF, which goes after --srdf"});
  expectRefused("view reach.yaml --output p.svg", {"--svg p.svg writes a picture"});
  expectRefused("plan reach.yaml --upright lower -z 0.1", {"'-z' is no axis", "here nz"});
  expectRefused("plan reach.yaml --upright lowr z 0.1", {"did you mean 'lower'?"});
  expectRefused("guard reach.yaml --waypoints w.csv", {"there is no option '--waypoints'"});
  EXPECT_EQ(run("guard --help").out.find("--goal-pose"), std::string::npos);
  expectRefused("plan reach.yaml --package nonsense", {"NAME=DIR", "nonsense"});
  expectRefused("plan reach.yaml --package a=/nowhere", {"/nowhere"});
  expectRefused("verify reach.yaml", {"path file"});
  expectRefused("batch reach.yaml --resume", {"--output"});
  expectRefused("batch reach.yaml --shard 5/4", {"5/4"});
  expectRefused("batch reach.yaml --shard x", {"'x'"});
  expectRefused("batch nowhere", {"nowhere"});
  expectRefused("check reach.yaml --tolerance 0", {"--tolerance: 0"});
}

TEST_F(Usage, HelpOfAVerbIsItsHelpOption) {
  EXPECT_EQ(run("help").out, run("--help").out);
  for (const char* verb : kVerbs) {
    const Answer answer = run(std::string("help ") + verb);
    EXPECT_EQ(answer.status, 0) << verb << answer.err;
    EXPECT_EQ(answer.out, run(std::string(verb) + " --help").out) << verb;
  }
}

TEST_F(Usage, QuietLeavesErrorsAlone) {
  write("warn.yaml", std::string(kReach) + "margin: -0.01\n");
  EXPECT_NE(run("check warn.yaml").err, "");
  EXPECT_EQ(run("check warn.yaml --quiet").err, "");
  EXPECT_EQ(run("check warn.yaml --quiet").out, run("check warn.yaml").out);
  EXPECT_EQ(run("batch warn.yaml --quiet").err, "");
  expectRefused("check nowhere.yaml --quiet", {"nowhere.yaml"});
}

/// What long work shows on a terminal, which `script` is; never elsewhere.
TEST_F(Usage, ProgressIsForTerminals) {
  const auto shown = [&](const std::string& arguments) {
    const Answer answer = shell("script -qec \"stty cols 60; '" + leeway::commandFile() + "' " +
                                arguments + "\" log");
    EXPECT_EQ(answer.status, 0) << arguments << answer.out;
    return read("log");
  };
  const std::string improve = "plan reach.yaml --improve 0.4 --time 9";
  const std::string log = shown(improve);
  EXPECT_NE(log.find(" of at most 9 s: improve, length "), std::string::npos) << log;
  EXPECT_NE(log.find(", none is below "), std::string::npos) << log;
  // The verdict has a colour, unless the user wants none.
  const std::string silent = shown(improve + " --quiet");
  EXPECT_EQ(silent.find("\x1b[K"), std::string::npos) << silent;
  EXPECT_NE(silent.find("\x1b[1;32mcertified\x1b[0m, least"), std::string::npos) << silent;
  ::setenv("NO_COLOR", "1", 1);
  EXPECT_EQ(shown(improve + " --quiet").find("\x1b"), std::string::npos);
  ::unsetenv("NO_COLOR");
  EXPECT_EQ(run(improve).err, "");
  EXPECT_NE(shown("plan reach.yaml --planner RRTstar --time 0.4").find("plan, length "),
            std::string::npos);
  const std::string climb = shown("plan reach.yaml --objective clearance --time 0.6");
  EXPECT_TRUE(std::regex_search(climb, std::regex(", keeps [0-9]+\\.[0-9] mm, none keeps ab")))
      << climb;
  run("plan reach.yaml --output path.csv");
  EXPECT_NE(shown("verify reach.yaml path.csv").find("1 of "), std::string::npos);
  EXPECT_NE(shown("batch reach.yaml empty.yaml").find("2 of 2, about 0 s left: empty.yaml"),
            std::string::npos);
  // Cut at the width of the terminal, so that the line can be rewritten.
  const std::string name(80, 'x');
  write(name + ".yaml", kEmpty);
  const std::string cut =
      shown("batch " + name + ".yaml --quiet --output lines.json; '" + leeway::commandFile() +
            "' batch " + name + ".yaml --output b.json");
  EXPECT_NE(cut.find("1 of 1: " + std::string(51, 'x') + "\r"), std::string::npos) << cut;
}

/// What completes words is made from the options, so each of them must be in it, and the script
/// must work in its shell.
TEST_F(Usage, CompletionsKnowVerbsOptionsAndChoices) {
  const std::string complete =
      "leeway() { '" + leeway::commandFile() +
      "' \"$@\"; }; . <(leeway manual bash); "
      "ask() { COMP_WORDS=(leeway \"$@\"); COMP_CWORD=$#; _leeway; echo \"${COMPREPLY[@]}\"; }; ";
  const auto ask = [&](const std::string& words) {
    write("ask.sh", complete + "ask " + words);
    return shell("bash ask.sh").out;
  };
  EXPECT_EQ(ask("cle"), "clearance\n");
  EXPECT_EQ(ask("help cle"), "clearance\n");
  EXPECT_EQ(ask("plan --obj"), "--objective\n");
  EXPECT_EQ(ask("plan --objective cl"), "clearance\n");
  EXPECT_EQ(ask("plan --planner BITs"), "BITstar\n");
  EXPECT_EQ(ask("plan --quiet arm.u"), "arm.urdf\n");
  EXPECT_EQ(ask("plan --robot arm.u"), "arm.urdf\n");
  EXPECT_EQ(ask("manual zs"), "zsh\n");
  for (const char* name : {"zsh", "fish"}) {
    const Answer answer = run(std::string("manual ") + name + " >script");
    EXPECT_EQ(answer.status, 0);
    for (const char* word : {"clearance", "--objective", "-l objective", "length clearance"}) {
      if (*word != '-' || (word[1] == 'l') == (*name == 'f')) {
        EXPECT_NE(read("script").find(word), std::string::npos) << name << word;
      }
    }
    if (shell(std::string("command -v ") + name).status != 0) continue;  // the shell is not here
    EXPECT_EQ(shell(std::string(name) + " -n script").status, 0) << name;
  }
}

TEST_F(Usage, ManPageHasEveryVerbAndNoFaults) {
  if (shell("command -v groff").status != 0) GTEST_SKIP() << "groff is not installed";
  const Answer answer =
      shell("'" + leeway::commandFile() + "' manual man | groff -man -ww -Tascii -P-cbou");
  EXPECT_EQ(answer.err, "");
  for (const char* verb : kVerbs)
    EXPECT_NE(answer.out.find(std::string("leeway ") + verb), std::string::npos) << verb;
  EXPECT_NE(answer.out.find("leeway report"), std::string::npos);
  EXPECT_NE(answer.out.find("--objective length|clearance"), std::string::npos);
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

/// Each runs as written, from the source tree's top; output goes elsewhere.
class Examples : public CommandTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(Examples, Run) { expectExamplesRun(GetParam()); }

// gtest names the test's folder by the suffix, without the '/'.
INSTANTIATE_TEST_SUITE_P(Verbs, Examples, ::testing::ValuesIn(kVerbs),
                         [](const auto& verb) { return std::string(verb.param); });

}  // namespace
}  // namespace leeway::tools::testing
