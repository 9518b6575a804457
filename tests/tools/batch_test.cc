#include <chrono>
#include <filesystem>
#include <regex>
#include <set>

#include "tests/support/build_paths.h"
#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

class Batch : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    write("set/a/scene0001.yaml", kScene);
    write("set/a/request0001.yaml", kRequest);
    write("set/a/scene0010.yaml", kScene);
    write("set/a/request0010.yaml", kRequest);
    write("set/b/scene0002.yaml", kScene);
    write("set/b/request0002.yaml", kRequest);
  }
  const std::string robot_ = "--robot arm.urdf --srdf arm.srdf ";
};

std::vector<std::string> problemsOf(const std::vector<json>& lines) {
  std::vector<std::string> names;
  for (const json& line : lines) {
    names.push_back(line["problem"]);
  }
  return names;
}

/// A line without its times.
json withoutTimes(json line) {
  line.erase("time_s");
  if (line.contains("verify") && line["verify"].is_object()) {
    line["verify"].erase("time_s");
  }
  return line;
}

/// The table and the summary of stderr without the times in them and the blanks that align these.
std::string withoutMilliseconds(const std::string& text) {
  // Columns are as wide as their numbers.
  return std::regex_replace(text, std::regex(" *[0-9]+\\.[0-9]+|--+| {2,}"), "");
}

/// OMPL.app's files are problems like any other.
TEST_F(Batch, TakesOmplAppProblems) {
  write("app/body.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const std::string problem =
      "[problem]\nrobot = body.obj\nworld = body.obj\nstart.x = -3\nstart.y = 0\nstart.theta = 0\n"
      "goal.x = 3\ngoal.y = 0\ngoal.theta = 1\nvolume.min.x = -4\nvolume.min.y = -4\n"
      "volume.max.x = 4\nvolume.max.y = 4\n";
  write("app/slide.cfg", problem);
  write("app/other.cfg", "[main]\n");
  const Answer answer = run("batch app --verify");
  EXPECT_EQ(answer.status, 0) << answer.err;
  ASSERT_EQ(answer.lines().size(), 1U);
  EXPECT_EQ(answer.lines()[0]["problem"], "app/slide.cfg");
  EXPECT_EQ(answer.lines()[0]["verify"]["status"], "certified");
  EXPECT_NE(answer.err.find("other.cfg: left out"), std::string::npos) << answer.err;
  EXPECT_EQ(run("info app/slide.cfg").status, 0);
  EXPECT_EQ(run("lint app/slide.cfg").status, 0);
  write("app/bad.cfg", problem + "goal.x = 4\n");
  expectRefused("plan app/bad.cfg", {"app/bad.cfg:14", "goal.x", "line 7"});
}

TEST_F(Batch, PairsByNumberAndWalksIntoFolders) {
  const Answer answer = run("batch " + robot_ + "set");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const auto lines = answer.lines();
  EXPECT_EQ(problemsOf(lines),
            (std::vector<std::string>{"set/a/scene0001.yaml", "set/a/scene0010.yaml",
                                      "set/b/scene0002.yaml"}));
  for (const json& line : lines) {
    EXPECT_EQ(line["status"], "solved");
    EXPECT_TRUE(line.contains("certificate") && line.contains("time_s") && line.contains("seed"));
    EXPECT_FALSE(line.contains("verify"));
  }
  // `problem` comes first in the line.
  EXPECT_TRUE(
      answer.out.starts_with(R"({"problem":"set/a/scene0001.yaml","version":1,"options":{)"))
      << answer.out.substr(0, 80);
  EXPECT_NE(answer.err.find("3 solved"), std::string::npos);
  for (const char* row : {"\nset/a     2       2", "\nset/b     1       1"})
    EXPECT_NE(("\n" + answer.err).find(row), std::string::npos) << answer.err;
}

TEST_F(Batch, AProblemGivenTwiceIsSolvedOnce) {
  const Answer answer = run("batch reach.yaml ./reach.yaml empty.yaml");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(problemsOf(answer.lines()), (std::vector<std::string>{"reach.yaml", "empty.yaml"}));
  EXPECT_NE(answer.err.find("./reach.yaml: left out, it is in the list already"), std::string::npos)
      << answer.err;
}

TEST_F(Batch, LineIsWhatPlanPrints) {
  const json line = run("batch " + robot_ + "set/b --seed 5").lines().at(0);
  json plan = run("plan " + robot_ +
                  "--scene set/b/scene0002.yaml --request set/b/request0002.yaml --seed 5 --json")
                  .document();
  json same = withoutTimes(line);
  same.erase("problem");
  EXPECT_EQ(same["files"].size(), 4U) << same["files"];
  for (const char* own : {"files", "found"}) same.erase(own);
  same.erase("options");  // a line of plan is no list that goes on
  plan.erase("time_s");
  EXPECT_EQ(same, plan);
}

TEST_F(Batch, RepeatedPlansGiveTheSameLine) {
  const json once = run("batch " + robot_ + "set/b --seed 5").lines().at(0);
  json often = run("batch " + robot_ + "set/b --seed 5 --repeat 3").lines().at(0);
  EXPECT_EQ(often["options"].value("repeat", 0), 3);
  often["options"].erase("repeat");
  EXPECT_EQ(withoutTimes(often), withoutTimes(once));
  EXPECT_EQ(run("batch reach.yaml --repeat 0").status, 2);
}

TEST_F(Batch, JobsGiveTheLinesOfOne) {
  write("set/a/scene0003.yaml", "no: scene\n");
  write("set/a/request0003.yaml", kRequest);
  const std::string batch = "batch " + robot_ + "set --seed 5 --jobs ";
  const Answer one = run(batch + "1");
  for (const char* jobs : {"2", "8"}) {
    const Answer more = run(batch + jobs);
    EXPECT_EQ(more.status, one.status);
    ASSERT_EQ(more.lines().size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(withoutTimes(more.lines()[i]).dump(), withoutTimes(one.lines()[i]).dump());
    }
    EXPECT_EQ(withoutMilliseconds(more.err), withoutMilliseconds(one.err));
  }
}

TEST_F(Batch, ProblemFilesAndVerify) {
  const Answer answer = run("batch reach.yaml empty.yaml --verify");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const auto lines = answer.lines();
  EXPECT_EQ(problemsOf(lines), (std::vector<std::string>{"reach.yaml", "empty.yaml"}));
  for (const json& line : lines) {
    EXPECT_EQ(line["verify"]["status"], "certified") << line;
  }
}

TEST_F(Batch, GoesOnAfterBadInput) {
  write("list/1.yaml", "leeway: 1\nrobot: {urdf: nowhere.urdf}\n");
  write("list/2.yaml",
        std::string(kReach).replace(std::string(kReach).find("arm.urdf"), 8, "../arm.urdf"));
  const Answer answer = run("batch list reach.yaml");
  EXPECT_EQ(answer.status, 2);
  const auto lines = answer.lines();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0]["status"], "error");
  EXPECT_NE(lines[0]["error"].get<std::string>().find("nowhere.urdf"), std::string::npos);
  EXPECT_NE(answer.err.find("nowhere.urdf"), std::string::npos);
  EXPECT_EQ(lines[1]["status"], "error");  // its SRDF is missing
  EXPECT_EQ(lines[2]["status"], "solved");
  std::string summary = answer.err;
  std::replace(summary.begin(), summary.end(), '\n', ' ');
  EXPECT_NE(summary.find("2 with bad input"), std::string::npos) << answer.err;
}

TEST_F(Batch, FoldersMayHoldOtherYaml) {
  write("mixed/notes.yaml", "colour: red\n");
  write("mixed/arm.urdf", kUrdf);
  write("mixed/arm.srdf", kSrdf);
  write("mixed/reach.yaml", kReach);
  const Answer answer = run("batch mixed");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(problemsOf(answer.lines()), std::vector<std::string>{"mixed/reach.yaml"});
  EXPECT_NE(answer.err.find("mixed/notes.yaml"), std::string::npos);
  // Requested by name, it is an error.
  EXPECT_EQ(run("batch mixed/notes.yaml").status, 2);
}

/// Regression: problems were found by the text of their lines, and others left out.
TEST_F(Batch, FoldersMayHoldProblemsInAnyNotation) {
  write("mixed/arm.urdf", kUrdf);
  write("mixed/arm.srdf", kSrdf);
  const std::string reach = kReach;
  const std::string rest = reach.substr(reach.find('\n') + 1);
  ASSERT_EQ(reach.substr(0, reach.find('\n')), "leeway: 1");
  write("mixed/quoted.yaml", "\"leeway\": 1\n" + rest);
  write("mixed/spaced.yml", "leeway : 1\n" + rest);
  write("mixed/result.json", "{\"joint_names\": [], \"points\": []}");
  write(
      "mixed/flow.json",
      R"({"leeway": 1, "robot": {"urdf": "arm.urdf", "srdf": "arm.srdf", "group": "arm"}, "start": [0, 0], "goal": [1, 0.5]})");
  write("mixed/broken.yaml", "leeway: 1\nrobot: [\n");
  // Regression: where carriage returns alone end lines, only the first line was looked at.
  write("mixed/returns.yaml", "# broken\rleeway: 1\rrobot: [\r");
  write("mixed/returns.cfg", "# of OMPL.app\r[problem]\rrobot = gone.obj\r");
  const Answer answer = run("batch mixed");
  EXPECT_EQ(
      problemsOf(answer.lines()),
      (std::vector<std::string>{"mixed/broken.yaml", "mixed/flow.json", "mixed/quoted.yaml",
                                "mixed/returns.cfg", "mixed/returns.yaml", "mixed/spaced.yml"}))
      << answer.err;
  EXPECT_EQ(answer.err.find("result.json"), std::string::npos) << answer.err;
}

TEST_F(Batch, LinksThatLeadToNoFileAreNamed) {
  write("mixed/arm.urdf", kUrdf);
  write("mixed/arm.srdf", kSrdf);
  write("mixed/reach.yaml", kReach);
  fs::create_symlink("gone.yaml", path("mixed/late.yaml"));
  fs::create_symlink("self.yaml", path("mixed/self.yaml"));
  fs::create_directory_symlink("../set", path("mixed/more"));
  const Answer answer = run("batch mixed");
  EXPECT_EQ(problemsOf(answer.lines()), std::vector<std::string>{"mixed/reach.yaml"});
  for (const char* words : {"mixed/late.yaml: left out, it is a link to gone.yaml",
                            "mixed/self.yaml: left out", "mixed/more: left out, links to folders"})
    EXPECT_NE(answer.err.find(words), std::string::npos) << words << answer.err;
  expectRefused("batch mixed/late.yaml", {"mixed/late.yaml: is a link to gone.yaml"});
}

TEST_F(Batch, SceneWithoutRequestIsReported) {
  fs::remove(path("set/a/request0010.yaml"));
  write("set/b/request0003.yaml", kRequest);
  const Answer answer = run("batch " + robot_ + "set");
  EXPECT_EQ(answer.status, 2);
  const auto lines = answer.lines();
  EXPECT_EQ(problemsOf(lines),
            (std::vector<std::string>{"set/a/scene0001.yaml", "set/a/scene0010.yaml",
                                      "set/b/scene0002.yaml", "set/b/request0003.yaml"}));
  EXPECT_EQ(lines[1]["status"], "error");
  EXPECT_EQ(lines[2]["status"], "solved");
  EXPECT_EQ(lines[3]["status"], "error");
}

/// Number of occurrences of `text`.
std::size_t countOf(const std::string& all, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = all.find(text); at != std::string::npos; at = all.find(text, at + 1)) {
    ++count;
  }
  return count;
}

TEST_F(Batch, WarningsThatComeAgainAreCounted) {
  const std::string matrix = R"(allowed_collision_matrix:
  entry_names: [ghost, post]
  entry_values: [[false, true], [true, false]]
)";
  write("set/a/scene0001.yaml", kScene + matrix);
  write("set/a/scene0010.yaml", kScene + matrix);
  const std::string text = "the matrix names 'ghost', which is no link and no object";
  const Answer one = run("batch " + robot_ + "set/a/scene0010.yaml set/b");
  EXPECT_EQ(one.status, 0) << one.err;
  EXPECT_EQ(countOf(one.err, text), 1U) << one.err;
  EXPECT_NE(one.err.find("warning: set/a/scene0010.yaml:"), std::string::npos) << one.err;

  write("set/b/scene0002.yaml", kScene + matrix);
  const Answer answer = run("batch " + robot_ + "set");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(countOf(answer.err, text), 2U) << answer.err;
  EXPECT_NE(answer.err.find("warning: set/a/scene0001.yaml:"), std::string::npos) << answer.err;
  EXPECT_NE(answer.err.find("warning: in 2 more places, last set/b/scene0002.yaml:"),
            std::string::npos)
      << answer.err;
}

TEST_F(Batch, InvalidStartIsAnAnswer) {
  write("bad.yaml", kInvalidStart);
  const Answer answer = run("batch bad.yaml reach.yaml");
  EXPECT_EQ(answer.status, 1);
  EXPECT_EQ(answer.lines()[0]["status"], "invalid_start");
  EXPECT_EQ(answer.lines()[0]["offending"]["b"], "post");
  EXPECT_EQ(answer.lines()[1]["status"], "solved");
}

TEST_F(Batch, ShardsAreAPartition) {
  std::multiset<std::string> seen;
  for (const char* shard : {"1/2", "2/2"}) {
    for (const std::string& problem :
         problemsOf(run("batch " + robot_ + "set --shard " + shard).lines())) {
      seen.insert(problem);
    }
  }
  EXPECT_EQ(seen, (std::multiset<std::string>{"set/a/scene0001.yaml", "set/a/scene0010.yaml",
                                              "set/b/scene0002.yaml"}));
  EXPECT_EQ(problemsOf(run("batch " + robot_ + "set --shard 0/2").lines()),
            problemsOf(run("batch " + robot_ + "set --shard 2/2").lines()));
}

TEST_F(Batch, OutputFileIsWholeAndInOrder) {
  const Answer answer = run("batch " + robot_ + "set --output lines.json");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.out, "");
  Answer file;
  file.out = read("lines.json");
  EXPECT_EQ(file.lines().size(), 3u);
  EXPECT_FALSE(fs::exists(path("lines.json.partial")));
  expectRefused("batch reach.yaml --output nowhere/lines.json", {"nowhere/lines.json"});
}

TEST_F(Batch, ResumesAnInterruptedRun) {
  ASSERT_EQ(run("batch " + robot_ + "set --output lines.json").status, 0);
  const std::string whole = read("lines.json");
  const std::size_t first = whole.find('\n') + 1;
  const std::size_t second = whole.find('\n', first) + 1;
  // Truncated within the third line; the first is marked to show whether it is kept.
  std::string partial = whole.substr(0, second) + whole.substr(second, 20);
  partial.replace(partial.find("solved"), 6, "SOLVED");
  fs::remove(path("lines.json"));
  write("lines.json.partial", partial);
  const Answer answer = run("batch " + robot_ + "set --output lines.json --resume");
  EXPECT_NE(answer.err.find("2 kept"), std::string::npos) << answer.err;
  Answer file;
  file.out = read("lines.json");
  const auto lines = file.lines();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0]["status"], "SOLVED");
  Answer before;
  before.out = whole;
  EXPECT_EQ(withoutTimes(lines[2]), withoutTimes(before.lines()[2]));
  EXPECT_FALSE(fs::exists(path("lines.json.partial")));
}

/// Regression: the time of looking for shorter paths was left out of the whole.
TEST_F(Batch, TheWholeCountsEveryStage) {
  write(
      "lines.json",
      R"({"problem":"reach.yaml","version":1,"options":{},"files":{},"found":[],"status":"solved","certificate":)"
      R"({"certified":true},"time_s":{"load":9,"compile":0.001,"plan":0.01,"simplify":0.1,)"
      R"("improve":1,"push":0.1,"certify":0.01}})"
      "\n");
  const Answer answer = run("batch reach.yaml --output lines.json --resume");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.err.find("median 10.00 ms of planning, 1221.00 ms with"), std::string::npos)
      << answer.err;
}

TEST_F(Batch, PoseGoalsMoveAllArms) {
  const std::string problems = sourceFolder() + "/problems/";
  Answer answer = run("batch " + problems + "dual_arm/swap.yaml --pose-goals");
  ASSERT_EQ(answer.status, 0) << answer.err;
  const json rows = answer.lines()[0]["path"]["positions"];
  for (std::size_t joint = 0; joint < 12; joint += 6)
    EXPECT_GT(std::abs(rows.back()[joint].get<double>() - rows[0][joint].get<double>()), 0.1);
  answer = run("batch " + problems + "pick_place/can.yaml --pose-goals");
  EXPECT_EQ(answer.status, 2);
  EXPECT_NE(answer.err.find("--pose-goals is for problems with goals"), std::string::npos);
}

TEST_F(Batch, ResumeTriesBadInputAgain) {
  write("late/1.yaml", "leeway: 1\n");
  write("late/arm.urdf", kUrdf);
  write("late/arm.srdf", kSrdf);
  EXPECT_EQ(run("batch late reach.yaml --output lines.json").status, 2);
  write("late/1.yaml", kReach);
  const Answer answer = run("batch late reach.yaml --output lines.json --resume");
  EXPECT_EQ(answer.status, 0) << answer.err;
  Answer file;
  file.out = read("lines.json");
  EXPECT_EQ(problemsOf(file.lines()), (std::vector<std::string>{"late/1.yaml", "reach.yaml"}));
  EXPECT_EQ(file.lines()[0]["status"], "solved");
}

TEST_F(Batch, ResumePlansChangedProblemsAgain) {
  ASSERT_EQ(run("batch reach.yaml empty.yaml --output lines.json").status, 0);
  std::string changed = kReach;
  write("reach.yaml", changed.replace(changed.find("goal: left"), 10, "goal: [0.5, 0.5]"));
  // Contents count, not times.
  const auto before = fs::last_write_time(folder_ / "lines.json") - std::chrono::hours(1);
  fs::last_write_time(folder_ / "reach.yaml", before);
  fs::last_write_time(folder_ / "empty.yaml", before + std::chrono::hours(2));
  const Answer answer = run("batch reach.yaml empty.yaml --output lines.json --resume");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.err.find("1 kept from the run before"), std::string::npos) << answer.err;
  EXPECT_NE(read("lines.json").find("0.5,0.5]"), std::string::npos) << read("lines.json");
}

TEST_F(Batch, ResumePlansAgainWhereTheRobotHasChanged) {
  ASSERT_EQ(run("batch reach.yaml empty.yaml --output lines.json").status, 0);
  write("arm.urdf", std::string(kUrdf) + "<!-- changed -->\n");
  const Answer answer = run("batch reach.yaml empty.yaml --output lines.json --resume");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_EQ(answer.err.find("kept from the run before"), std::string::npos) << answer.err;
  const Answer again = run("batch reach.yaml empty.yaml --output lines.json --resume");
  EXPECT_NE(again.err.find("2 kept from the run before"), std::string::npos) << again.err;
}

/// The same URI may lead to another mesh: another package has the name, or is found first.
TEST_F(Batch, ResumePlansAgainWhereAPackageIsElsewhere) {
  const std::string facet =
      "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex .01 0 0\nvertex 0 .01 0\n"
      "endloop\nendfacet\nendsolid\n";
  const auto name = [&](const std::string& folder, const std::string& package) {
    write(folder + "/package.xml", "<package><name>" + package + "</name></package>");
  };
  for (const char* folder : {"first", "other"}) write(std::string(folder) + "/m.stl", facet);
  name("first", "parts");
  name("other", "else");
  std::string urdf = kUrdf;
  const std::size_t box = urdf.find("<box");
  urdf.replace(box, urdf.find("/>", box) + 2 - box, "<mesh filename=\"package://parts/m.stl\"/>");
  write("parts.urdf", urdf);
  std::string text = kReach;
  write("parts.yaml", text.replace(text.find("arm.urdf"), 8, "parts.urdf"));
  const auto batch = [&](const std::string& path, const std::string& more) {
    const Answer answer = shell("ROS_PACKAGE_PATH=" + path + " '" + leeway::commandFile() +
                                "' batch parts.yaml --output lines.json" + more);
    EXPECT_NE(answer.status, 2) << answer.err;
    const bool is_kept = answer.err.find("1 kept from the run before") != std::string::npos;
    return (is_kept ? "kept " : "") +
           json::parse(read("lines.json"))["found"][0]["file"].get<std::string>();
  };
  EXPECT_EQ(batch("first:other", ""), "first/m.stl");
  EXPECT_EQ(batch("first:other", " --resume"), "kept first/m.stl");
  name("first", "else");
  name("other", "parts");
  EXPECT_EQ(batch("first:other", " --resume"), "other/m.stl");
  name("first", "parts");
  EXPECT_EQ(batch("other:first", " --resume"), "kept other/m.stl");
  EXPECT_EQ(batch("first:other", " --resume"), "first/m.stl");
}

/// Options of --robot have no meaning without it, and lines that were made with others are refused.
TEST_F(Batch, OptionsOfTheRobot) {
  for (const char* option : {"--srdf arm.srdf", "--joint-limits l.yaml", "--bounds elbow 0 1"})
    expectRefused(std::string("batch reach.yaml ") + option, {"go with --robot"});
  ASSERT_EQ(run("batch " + robot_ + "set/b --output lines.json").status, 0);
  expectRefused("batch " + robot_ + "set/b --output lines.json --resume --bounds elbow -2 2",
                {"lines.json:1", "bounds"});
}

TEST_F(Batch, ResumeRefusesAnotherRunsFile) {
  ASSERT_EQ(run("batch reach.yaml --output lines.json --seed 1").status, 0);
  const std::string before = read("lines.json");
  expectRefused("batch reach.yaml --output lines.json --resume --seed 2", {"lines.json:1", "seed"});
  for (const char* options : {"", "--seed 1 --time 3", "--seed 1 --planner RRTConnect"})
    expectRefused(std::string("batch reach.yaml --output lines.json --resume ") + options,
                  {"lines.json:1", R"({"seed":1})"});
  expectRefused("batch reach.yaml --output lines.json --resume --seed 1 --pose-goals",
                {"lines.json:1", "pose_goals"});
  expectRefused("batch empty.yaml --output lines.json --resume", {"lines.json:1", "reach.yaml"});
  EXPECT_EQ(read("lines.json"), before);
}

/// A digest of other bytes than those that were planned would make --resume keep a wrong line.
TEST_F(Batch, AFileThatChangesWhileItIsReadIsAnError) {
  std::string text = kReach;
  write("late.yaml", text.replace(text.find("arm.srdf"), 8, "pipe.srdf"));
  const Answer answer = shell(
      "mkfifo pipe.srdf; (exec 3>pipe.srdf; echo '# more' >> late.yaml; cat arm.srdf >&3) & '" +
      leeway::commandFile() + "' batch late.yaml");
  EXPECT_EQ(answer.status, 2);
  EXPECT_EQ(answer.lines()[0]["error"],
            "late.yaml: was changed while it was read; a file that stays is expected");
}

TEST_F(Batch, NoProblemIsOverwritten) {
  expectRefused("batch reach.yaml --output ./reach.yaml", {"./reach.yaml", "overwritten"});
  EXPECT_EQ(read("reach.yaml"), kReach);
}

TEST_F(Batch, InterruptLeavesWhatIsDone) {
  // Caged: it would otherwise run for 20 s.
  std::string text = kReach;
  text.replace(text.find("  - {name: post"), text.find("limits") - text.find("  - {name: post"),
               "  - {name: wall, position: [0.3, 0, 0], box: {size: [0.2, 0.02, 1]}}\n");
  write("wall.yaml", text);
  const Answer answer = shell("'" + leeway::commandFile() +
                              "' batch reach.yaml wall.yaml --output lines.json & pid=$!; "
                              "while ! grep -q reach lines.json.partial 2>/dev/null; do sleep "
                              "0.01; done; sleep 0.1; kill -INT $pid; wait $pid");
  EXPECT_EQ(answer.status, 1) << answer.err;
  EXPECT_FALSE(fs::exists(path("lines.json")));
  Answer partial;
  partial.out = read("lines.json.partial");
  EXPECT_EQ(problemsOf(partial.lines()), (std::vector<std::string>{"reach.yaml"}));
  EXPECT_NE(answer.err.find("--resume"), std::string::npos) << answer.err;
}

/// Regression: all problems of a mixed batch had the status error.
TEST_F(Batch, ImproveIsLeftOutWhereItHasNoEffect) {
  std::string text = kReach;
  for (const char* file : {"arm.urdf", "arm.srdf"}) text.replace(text.find(file), 0, "../");
  write("mixed/length.yaml", text);
  write("mixed/clear.yaml", text + "objective: clearance\n");
  write("mixed/hinge.yaml", text + "objective: {integral: {hinge: 0.1}}\n");
  write("mixed/wish.yaml", text + "margins: [{between: [robot, post], margin: 0, wish: 0.05}]\n");
  write("mixed/star.yaml", text + "planner: {name: RRTstar}\n");
  const Answer answer = run("batch mixed --improve 0.01 --time 0.3");
  EXPECT_EQ(answer.status, 0) << answer.err;
  const std::vector<json> lines = answer.lines();
  ASSERT_EQ(lines.size(), 5U);
  for (const json& line : lines) {
    EXPECT_EQ(line["status"], "solved") << line["problem"];
    EXPECT_EQ(line["warnings"].dump().find("--improve 0.01 is left out") == std::string::npos,
              line["problem"] == "mixed/length.yaml")
        << line["problem"];
  }
  const std::regex told("warning: --improve 0.01 is left out: only paths of the objective length");
  EXPECT_EQ(std::distance(std::sregex_iterator(answer.err.begin(), answer.err.end(), told),
                          std::sregex_iterator()),
            1)
      << answer.err;
}

}  // namespace
}  // namespace leeway::tools::testing
