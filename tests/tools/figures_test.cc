// Figures and text for people: all verbs show the same clearance, and everything fits a terminal.

#include "tools/view/base/figures.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <iterator>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

#include "tests/support/command.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools::testing {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(Figures, AreTheNumberThatBothEndsRoundTo) {
  EXPECT_EQ(clearanceText({0.0105671, 0.0105674}), "10.57 mm");
  EXPECT_EQ(clearanceText({0.0599996, 0.06}), "60.00 mm");  // was 59.99
  EXPECT_EQ(clearanceText({0.06, 0.0600004}), "60.00 mm");
  EXPECT_EQ(figureOf({0.0105671, 0.0105674}), "10.57");
  EXPECT_EQ(figureOf({0.010564, 0.010566}), std::nullopt);
  EXPECT_EQ(figureOf({0.010565 - 1e-9, 0.010565 + 1e-9}), "10.56") << "one number: the lower";
  EXPECT_EQ(figureOf({0.01, kInf}), std::nullopt);
}

TEST(Figures, AreBoundsWhereTheyAreNotKnownBetter) {
  EXPECT_EQ(clearanceText({0.0100001, 0.0107466}), "between 10.00 and 10.75 mm");
  EXPECT_EQ(clearanceText({0.012348, kInf}), "at least 12.34 mm");
  EXPECT_EQ(clearanceText({-kInf, 0.012341}), "at most 12.35 mm");
  EXPECT_EQ(clearanceText({-kInf, kInf}), "not known");
  EXPECT_EQ(clearanceText({kInf, kInf}), "nothing near");
  EXPECT_EQ(clearanceText({-0.0123411, -0.0123409}), "12.34 mm deep");
  EXPECT_EQ(clearanceText({0, 0}), "0.00 mm");
}

std::size_t longestLine(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) longest = std::max(longest, line.size());
  return longest;
}

TEST(Terminal, ProseBreaksAtSpaces) {
  const std::string words = "a sentence of some words that goes on and on, ";
  const std::string text = wrapped(words + words + words + "end\nnext line\n");
  EXPECT_LE(longestLine(text), kColumns);
  EXPECT_EQ(text.substr(text.size() - 11), "\nnext line\n");
  std::string joined = text;
  std::replace(joined.begin(), joined.end(), '\n', ' ');
  EXPECT_NE(joined.find("on, end next line"), std::string::npos) << text;
  EXPECT_EQ(joined.find("  "), std::string::npos) << text;
  EXPECT_NE(joined.find("goes on and on, a sentence"), std::string::npos);
  const std::string path(200, 'x');
  EXPECT_NE(wrapped("a " + path + " b").find(path), std::string::npos);
}

TEST(Terminal, TablesFit) {
  const std::vector<std::string> heading = {"name", "one", "two", "three", "four", "words"};
  const std::string number(12, '1');
  std::vector<std::string> row = {"a", number, number, number, number, ""};
  for (int i = 0; i < 12; ++i) row[5] += "word ";
  const std::string wraps = formatTable(heading, {row}, {5});
  EXPECT_LE(longestLine(wraps), kColumns) << wraps;
  EXPECT_NE(wraps.find("\n                      "), std::string::npos) << wraps;
  // Numbers that find no room follow below, each with its row's name.
  const std::vector<std::string> many(12, number);
  std::vector<std::string> long_row = {"row"};
  long_row.insert(long_row.end(), many.begin(), many.end());
  std::vector<std::string> long_heading = {""};
  for (int i = 0; i < 12; ++i) long_heading.push_back("q" + std::to_string(i));
  const std::string blocks = formatTable(long_heading, {long_row});
  EXPECT_LE(longestLine(blocks), kColumns) << blocks;
  std::size_t rows = 0, columns = 0;
  for (std::size_t at = 0; (at = blocks.find("row", at)) != std::string::npos; ++at) ++rows;
  for (std::size_t at = 0; (at = blocks.find(number, at)) != std::string::npos; at += 12) ++columns;
  EXPECT_EQ(rows, 3u);
  EXPECT_EQ(columns, 12u) << blocks;
}

/// Where the first column names several rows alike, the parts of a table have the rows' numbers.
TEST(Terminal, PartsOfTablesCanBeMatched) {
  const std::string wide(40, 'w');
  const std::vector<std::vector<std::string>> rows = {
      {"0", wide, wide, "a - b"}, {"0", wide, wide, "c - d"}, {"1", wide, wide, "e - f"}};
  const std::string text = formatTable({"edge", "x", "y", "between"}, rows, {3});
  EXPECT_LE(longestLine(text), kColumns) << text;
  std::vector<std::string> firsts;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line[0] >= '0' && line[0] <= '9')
      firsts.push_back(line.substr(0, line.find(' ')));
  EXPECT_EQ(firsts, (std::vector<std::string>{"1", "2", "3", "1", "2", "3"})) << text;
  // Tables that fit, and those whose first column names the rows, stay as they are.
  EXPECT_EQ(formatTable({"edge", "x"}, {{"0", "a"}, {"0", "b"}}).find("row"), std::string::npos);
  EXPECT_EQ(formatTable({"edge", "x", "y", "between"}, {rows[0], rows[2]}, {3}).find("row"),
            std::string::npos);
}

TEST(Terminal, HelpBreaksInItsColumns) {
  const std::string words = "some words of a description that is far too long for a single line";
  const std::string help =
      wrappedHelp("Usage: x\n  --option TEXT               " + words + " " + words +
                  "\n\nExamples:\n  leeway plan " + words + " " + words + " --last");
  EXPECT_LE(longestLine(help), kColumns) << help;
  EXPECT_NE(help.find("\n                              "), std::string::npos) << help;
  EXPECT_NE(help.find(" \\\n      "), std::string::npos) << help;
  EXPECT_EQ(help.substr(help.size() - 6), "--last");
  // Lines that continue a description are one text with it; those of another column are not.
  const std::string gap(26, ' ');
  EXPECT_EQ(wrappedHelp("  key                     text that ends at\n" + gap + "two lines\n" +
                        gap + "  and more\n  long, longer keys\n" + gap + "text\n"),
            "  key                     text that ends at two lines\n" + gap +
                "  and more\n  long, longer keys\n" + gap + "text\n");
}

TEST(Terminal, LinesDoNotBreakBeforeUnits) {
  const std::string words(76, 'x');
  EXPECT_EQ(wrapped(words + " 10 mm"), words + "\n10 mm");
  EXPECT_EQ(wrapped(words + " 10 mm.", 2), words + "\n  10 mm.");
  EXPECT_EQ(wrapped(words + " 10 models"), words + " 10\nmodels");
}

TEST(Terminal, CountsSaySingularAndPlural) {
  EXPECT_EQ(counted(1, "edge"), "1 edge");
  EXPECT_EQ(counted(0, "edge"), "0 edges");
  EXPECT_EQ(counted(2, "edge"), "2 edges");
}

/// The command on a terminal, which stdout and stderr share.
class OnTerminal : public CommandTest {
 protected:
  /// The text that the terminal receives.
  std::string shown(const std::string& arguments) const {
    return shell("script -qec \"'" + leeway::commandFile() + "' " + arguments + "\" /dev/null").out;
  }
  void SetUp() override {
    CommandTest::SetUp();
    if (shell("script -qec true /dev/null").status != 0)
      GTEST_SKIP() << "script(1), which makes a terminal, is not there";
  }
};

TEST_F(OnTerminal, ProgressNeverGluesToOutput) {
  const std::pair<const char*, const char*> verbs[] = {
      {"plan reach.yaml --json", "{\r\n  \"version\""},
      {"replan reach.yaml --json", "{\"version\""}};
  for (const auto& [verb, begin] : verbs) {
    const std::string text = shown(verb);
    int documents = 0;
    for (std::size_t at = text.find(begin); at != std::string::npos;
         at = text.find(begin, at + 1)) {
      ++documents;
      EXPECT_TRUE(at == 0 || text[at - 1] == '\n' || (at > 2 && text.substr(at - 3, 3) == "\x1b[K"))
          << verb << ": " << text.substr(at < 80 ? 0 : at - 80, 120);
    }
    EXPECT_GE(documents, 1) << verb << "\n" << text;
  }
  // A batch has a verdict in place of each document.
  for (const char* verb : {"batch reach.yaml empty.yaml", "batch reach.yaml empty.yaml --jobs 2"}) {
    const std::string text = shown(verb);
    const std::regex verdict("(^|\n|\x1b\\[K)(reach|empty).yaml: \x1b\\[1;32mcertified");
    EXPECT_EQ(std::distance(std::sregex_iterator(text.begin(), text.end(), verdict), {}), 2)
        << text;
    EXPECT_EQ(text.find('{'), std::string::npos) << text;
  }
}

TEST_F(OnTerminal, VerifyCountsItsEdgesOnly) {
  ASSERT_EQ(run("plan reach.yaml --output path.json").status, 0);
  const std::size_t edges =
      run("clearance reach.yaml path.json --json").document()["segments"].size();
  const std::string text = shown("verify reach.yaml path.json");
  const std::string last = std::to_string(edges) + " of " + std::to_string(edges);
  EXPECT_NE(text.find(last), std::string::npos) << text;
  EXPECT_EQ(text.find(std::to_string(edges + 1) + " of "), std::string::npos) << text;
}

TEST_F(OnTerminal, MessagesBreakAtSpaces) {
  const std::string missing = "plan nowhere.yaml --seed 3 --planner Connect --time 1";
  const Answer piped = run(missing);
  EXPECT_EQ(std::count(piped.err.begin(), piped.err.end(), '\n'), 1) << "one line for programs";
  write("far.yaml",
        std::string(kReach) +
            "margins: [{between: [hand_that_is_not_there_at_all, post], margin: 0.01}]\n");
  std::string text = shown("plan far.yaml");
  EXPECT_NE(text.find("hand_that_is_not_there_at_all"), std::string::npos) << text;
  text.erase(std::remove(text.begin(), text.end(), '\r'), text.end());
  EXPECT_LE(longestLine(text), kColumns) << text;
}

TEST_F(OnTerminal, HelpFits) {
  for (const char* verb : {"", "plan", "check", "verify", "clearance", "replan", "guard", "batch",
                           "info", "lint", "srdf", "ik", "fk", "view", "manual"}) {
    const Answer help = run(std::string(verb) + " --help");
    for (const char* raw : {"x)]", "auto:{auto}"})
      EXPECT_EQ(help.out.find(raw), std::string::npos) << verb << ": " << raw;
    std::istringstream in(help.out);
    for (std::string line; std::getline(in, line);) {
      // A single word may fit no line.
      const bool is_word =
          line.find_first_of(' ', line.find_first_not_of(' ')) == std::string::npos;
      EXPECT_TRUE(is_word || line.size() <= kColumns) << verb << ": " << line;
    }
  }
}

TEST_F(OnTerminal, SrdfFits) {
  const Answer answer = run("srdf '" + leeway::sourceFolder() + "/robots/arm7/arm7.urdf'");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_LE(longestLine(answer.out), kColumns) << answer.out;
}

std::vector<std::string> shippedProblems() {
  std::vector<std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(leeway::sourceFolder() + "/problems"))
    if (entry.path().extension() == ".yaml" && entry.path().parent_path().filename() != "moveit")
      all.push_back(entry.path().string());
  std::sort(all.begin(), all.end());
  return all;
}

using Shipped = CommandTest;

/// "least clearance 10.57 mm" of an answer; empty: it has none, or a bound alone.
std::string figureIn(const Answer& answer) {
  const std::string text = answer.flat(), words = "least clearance ";
  const std::size_t at = text.find(words);
  if (at == std::string::npos) return "";
  const std::string rest = text.substr(at + words.size());
  return rest.substr(0, rest.find(" mm"));
}

/// The figures of the waypoints' table of `plan` that stand for a value, not for a bound.
std::vector<std::string> keptWithoutBound(const Answer& planned) {
  std::vector<std::string> found;
  std::istringstream in(planned.out.substr(planned.out.find("keeps [mm]")));
  std::string line;
  std::getline(in, line);
  for (int row = 0; std::getline(in, line) && !line.empty(); ++row) {
    static const std::regex value("[^=] ([0-9]+\\.[0-9][0-9])$");
    std::smatch match;
    if (std::regex_search(line, match, value)) found.push_back(match[1]);
  }
  return found;
}

TEST_F(Shipped, AllVerbsShowOneFigureAndOnePair) {
  int solved = 0;
  for (const std::string& file : shippedProblems()) {
    const std::string problem = "'" + file + "' ";
    const Answer planned = run("plan " + problem + "--output path.json");
    if (planned.status != 0) continue;
    ++solved;
    const Answer verified = run("verify " + problem + "path.json"),
                 measured = run("clearance " + problem + "path.json"),
                 seen = run("view " + problem + "path.json --svg path.svg");
    const std::string figure = figureIn(planned);
    ASSERT_FALSE(figure.empty()) << planned.out;
    EXPECT_EQ(figure.find_first_not_of("0123456789."), std::string::npos) << file << figure;
    for (const Answer* answer : {&verified, &measured, &seen})
      EXPECT_EQ(figureIn(*answer), figure) << file << "\n" << answer->out << answer->err;
    // The place and the pair of the world and of the robot, word for word.
    const auto nearest = [](const Answer& answer) {
      const std::string text = answer.flat();
      const std::size_t begin = text.find("Nearest to "), end = text.rfind(" at t = ");
      return text.substr(begin, end + 13 - begin);
    };
    EXPECT_EQ(nearest(measured), nearest(planned)) << file;
    EXPECT_EQ(nearest(seen), nearest(planned)) << file;
    EXPECT_EQ(verified.out.substr(0, verified.out.find(',')),
              planned.out.substr(0, planned.out.find(',')))
        << "name and verdict";
    EXPECT_EQ(verified.out.find("Constraint '") == std::string::npos,
              planned.out.find("Constraint '") == std::string::npos)
        << file << verified.out;
    // No row of a table is below the least clearance, and its own row shows it.
    static const std::regex bound(">= ([0-9.]+)"),
        place("Nearest to [^:]*: .*?, ([0-9.]+ mm), edge ([0-9]+) at");
    for (std::sregex_iterator row(planned.out.begin(), planned.out.end(), bound), end; row != end;
         ++row)
      EXPECT_GE(std::stod((*row)[1]), std::stod(figure) - 0.0101)  // bounds are rounded down
          << file << "\n"
          << planned.out;
    EXPECT_EQ(keptWithoutBound(planned), std::vector<std::string>{figure}) << file << planned.out;
    const std::string sentences = measured.flat();
    for (std::sregex_iterator found(sentences.begin(), sentences.end(), place), end; found != end;
         ++found)
      EXPECT_TRUE(std::regex_search(
          measured.out, std::regex("\n" + (*found)[2].str() + " .*" + (*found)[1].str())))
          << file << found->str() << "\n"
          << measured.out;
    // The pairs that are not checked, of a task in some step.
    const auto unchecked = [](const Answer& answer) {
      static const std::regex words("[0-9]+ pairs? (is|are) not checked: [^.]*");
      const std::string text = answer.flat();
      std::smatch match;
      return std::regex_search(text, match, words) ? match.str() : std::string();
    };
    for (const Answer* answer : {&verified, &measured, &seen})
      EXPECT_EQ(unchecked(*answer), unchecked(planned)) << file << "\n" << answer->out;
    for (const Answer* answer : {&planned, &verified, &measured, &seen}) {
      EXPECT_LE(longestLine(answer->out.substr(0, answer->out.find("path.svg"))), kColumns)
          << file << "\n"
          << answer->out;
      EXPECT_EQ(answer->out.find('\x1b'), std::string::npos) << "no colour without a terminal";
    }
    // A figure is within 0.005 mm of what the certificate holds.
    const json whole = run("clearance " + problem + "path.json --tolerance 1e-6 --json").document();
    EXPECT_GE(std::stod(figure) / 1e3, whole["clearance_lower"].get<double>() - 5.1e-6) << file;
    EXPECT_LE(std::stod(figure) / 1e3, whole["clearance_upper"].get<double>() + 5.1e-6) << file;
  }
  EXPECT_GE(solved, 15);
}

TEST_F(Shipped, VerifyNamesTheNearestPairAndViewTheLengthOfThePlan) {
  const Answer planned = run("plan reach.yaml --output path.json");
  EXPECT_NE(run("verify reach.yaml path.json").out.find("\nNearest: lower and post.\n"),
            std::string::npos)
      << run("verify reach.yaml path.json").out;
  const std::string text = planned.flat(), words = text.substr(text.find("length "));
  const std::string length = words.substr(0, words.find(". "));
  EXPECT_NE(run("view reach.yaml").flat().find(length), std::string::npos) << length;
}

TEST_F(Shipped, NotesOfCloudsComeOnce) {
  const Answer answer =
      run("view '" + leeway::sourceFolder() + "/problems/sensed/shelf.yaml' --svg shelf.svg");
  const std::string text = answer.err + answer.flat(), note = "space that was not seen";
  EXPECT_EQ(text.find(note), text.rfind(note)) << text;
  EXPECT_NE(text.find(note), std::string::npos) << text;
}

TEST_F(Shipped, VerbsAgreeWhereExecutionsAreNearest) {
  for (const char* name : {"moving/conveyor", "moving/walker"}) {
    const std::string problem = fmt::format("'{}/problems/{}.yaml'", leeway::sourceFolder(), name);
    const Answer replanned = run("replan " + problem + " --text --output log.jsonl"),
                 verified = run("verify " + problem + " --log log.jsonl"),
                 seen = run("view " + problem);
    const std::string figure = figureIn(verified);
    EXPECT_EQ(figureIn(replanned), figure) << replanned.out;
    EXPECT_EQ(figureIn(seen), figure) << seen.out;
    static const std::regex place(
        "Nearest: ([a-z0-9_]+) and ([a-z0-9_]+), ([0-9.]+) mm, at "
        "([0-9.]+) s\\.");
    const std::string text = replanned.flat(), page = seen.flat(), proof = verified.flat();
    std::smatch of_text, of_page;
    ASSERT_TRUE(std::regex_search(text, of_text, place)) << text;
    ASSERT_TRUE(std::regex_search(page, of_page, place)) << page;
    EXPECT_EQ(of_text[0], of_page[0]);
    EXPECT_EQ(of_text[3], figure);
    const std::string a = of_text[1], b = of_text[2];
    EXPECT_TRUE(proof.find("Nearest: " + a + " and " + b + ".") != std::string::npos ||
                proof.find("Nearest: " + b + " and " + a + ".") != std::string::npos)
        << text << proof;
    // The log names that pair in the step in which it is nearest.
    std::istringstream log(read("log.jsonl"));
    json nearest;
    for (std::string line; std::getline(log, line);)
      if (json step = json::parse(line);
          step.contains("step") && step["time"].get<double>() <= std::stod(of_text[4]) + 0.005)
        nearest = std::move(step);
    EXPECT_EQ((std::set<std::string>{nearest["closest"]["a"], nearest["closest"]["b"]}),
              (std::set<std::string>{a, b}))
        << nearest["closest"];
    EXPECT_LE(nearest["clearance_lower"].get<double>(), std::stod(figure) / 1e3 + 1e-5);
    EXPECT_GE(nearest["clearance_upper"].get<double>(), std::stod(figure) / 1e3 - 1e-5);
  }
}

TEST_F(Shipped, PicturesOfClearanceHaveAllMarginsAndTheMoment) {
  const std::string figure = "'" + leeway::sourceFolder() + "/problems/deforming/figure.yaml' ";
  run("plan " + figure + "--output path.json");
  run("clearance " + figure + "path.json --svg profile.svg");
  const std::string svg = read("profile.svg");
  EXPECT_NE(svg.find(">margins</text>"), std::string::npos);
  EXPECT_NE(svg.find("; the obstacles stand as at 0 s"), std::string::npos);
}

TEST_F(Shipped, PlansAmongMovingObstaclesSayForWhichMoment) {
  const std::string curtain = "'" + leeway::sourceFolder() + "/problems/deforming/curtain.yaml' ";
  const Answer planned = run("plan " + curtain + "--output path.json");
  EXPECT_NE(planned.flat().find("; the obstacles stand as at 0 s"), std::string::npos)
      << planned.out;
  EXPECT_NE(run("verify " + curtain + "path.json").flat().find("stand as at 0 s"),
            std::string::npos);
  const Answer batch = run("batch " + curtain);
  EXPECT_EQ(batch.lines()[0]["obstacles_at"], 0.0);
  EXPECT_NE(batch.err.find("1 with moving obstacles as they stand"), std::string::npos)
      << batch.err;
  EXPECT_EQ(run("plan reach.yaml --json").document()["obstacles_at"], nullptr);
}

TEST_F(Shipped, TextFitsATerminal) {
  const std::string root = leeway::sourceFolder() + "/problems/";
  for (const std::string& words :
       {std::string("plan --planners"), "replan '" + root + "deforming/curtain.yaml' --text",
        "info '" + root + "dual_arm/swap.yaml'", "check '" + root + "dual_arm/swap.yaml'",
        "fk '" + root + "dual_arm/swap.yaml'",
        "ik '" + root + "shelf/reach.yaml' --link hand --position 0.55 0.25 0.45:0.5"}) {
    const Answer answer = run(words);
    EXPECT_LE(longestLine(answer.out), kColumns) << words << "\n" << answer.out;
  }
  const Answer batch = run("batch '" + root + "shelf' '" + root + "table' --output lines.json");
  EXPECT_EQ(batch.err.find("1 problems"), std::string::npos);
}

}  // namespace
}  // namespace leeway::tools::testing
