// `leeway batch --ompl-log`: read back by the grammar that OMPL documents for its benchmark logs.

#include <map>

#include "tests/support/command.h"

namespace leeway::tools::testing {
namespace {

/// A log, read strictly; a failure of the test where a line is not what the grammar has there.
class LogReader {
 public:
  struct Planner {
    std::string name;
    std::vector<std::string> properties;  // "name TYPE"
    std::vector<std::vector<std::string>> runs;

    std::string value(std::size_t run, const std::string& property) const {
      const auto place = std::find(properties.begin(), properties.end(), property);
      EXPECT_NE(place, properties.end()) << property;
      return place == properties.end()
                 ? std::string()
                 : runs.at(run)[static_cast<std::size_t>(place - properties.begin())];
    }
  };
  std::string experiment, setup;
  std::map<std::string, std::vector<std::string>> enums;
  double time_limit = 0;
  int runs_per_planner = 0;
  std::vector<Planner> planners;

  explicit LogReader(const std::string& text) : in_(text) {
    EXPECT_EQ(line().rfind("Leeway version ", 0), 0U);  // library "version" number
    experiment = after("Experiment ");
    EXPECT_EQ(experiment.find(' '), std::string::npos) << "the last word is taken";
    EXPECT_NE(after("Running on "), "");
    EXPECT_EQ(after("Starting at ").size(), std::string("2024-01-01T00:00:00").size());
    EXPECT_EQ(line(), "<<<|");
    for (std::string next = line(); next != "|>>>" && in_; next = line()) setup += next + "\n";
    std::stoull(before(" is the random seed"));
    time_limit = std::stod(before(" seconds per run"));
    std::stod(before(" MB per run"));
    runs_per_planner = std::stoi(before(" runs per planner"));
    EXPECT_GT(std::stod(before(" seconds spent to collect the data")), 0);
    for (int left = std::stoi(before(" enum type")); left > 0; --left) {
      std::vector<std::string> words = split(line(), "|");
      enums[words[0]].assign(words.begin() + 1, words.end());
    }
    for (int left = std::stoi(before(" planners")); left > 0; --left) readPlanner();
    std::string rest;
    EXPECT_FALSE(std::getline(in_, rest)) << rest;
  }

 private:
  std::string line() {
    std::string text;
    EXPECT_TRUE(std::getline(in_, text)) << "ends too early";
    return text;
  }
  std::string after(const std::string& words) {
    const std::string text = line();
    EXPECT_EQ(text.rfind(words, 0), 0U) << text << ", not " << words;
    return text.substr(std::min(words.size(), text.size()));
  }
  std::string before(const std::string& words) {
    const std::string text = line();
    EXPECT_TRUE(text.ends_with(words)) << text << ", not " << words;
    return text.ends_with(words) ? text.substr(0, text.size() - words.size()) : "0";
  }
  static std::vector<std::string> split(const std::string& text, const std::string& separator) {
    std::vector<std::string> parts;
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find(separator, begin)) != std::string::npos;
         begin = end + separator.size())
      parts.push_back(text.substr(begin, end - begin));
    parts.push_back(text.substr(begin));
    return parts;
  }
  void readPlanner() {
    Planner planner;
    planner.name = line();
    for (int left = std::stoi(before(" common properties")); left > 0; --left)
      EXPECT_NE(line().find(" = "), std::string::npos);
    for (int left = std::stoi(before(" properties for each run")); left > 0; --left) {
      planner.properties.push_back(line());
      const std::string type = split(planner.properties.back(), " ").back();
      EXPECT_TRUE(type == "REAL" || type == "INTEGER" || type == "BOOLEAN" || type == "ENUM")
          << planner.properties.back();
    }
    for (int left = std::stoi(before(" runs")); left > 0; --left) {
      // Each value is followed by "; ".
      std::vector<std::string> values = split(line(), "; ");
      EXPECT_EQ(values.back(), "");
      values.pop_back();
      EXPECT_EQ(values.size(), planner.properties.size());
      values.resize(planner.properties.size());
      for (const std::string& value : values) {
        if (!value.empty()) {
          std::size_t used = 0;
          std::stod(value, &used);
          EXPECT_EQ(used, value.size()) << value;
        }
      }
      planner.runs.push_back(values);
    }
    EXPECT_EQ(line(), ".");
    planners.push_back(std::move(planner));
  }

  std::istringstream in_;
};

class OmplLog : public CommandTest {};

TEST_F(OmplLog, HasARunForEachProblemOfAPlanner) {
  write("invalid.yaml", kInvalidStart);
  write("other.yaml", std::string(kReach) + "planner: {name: RRTConnect}\n");
  write("broken.yaml", "leeway: 1\nstart: here\n");
  const Answer answer =
      run("batch reach.yaml broken.yaml invalid.yaml other.yaml empty.yaml --time 7 --ompl-log "
          "'my log.log'");
  EXPECT_EQ(answer.status, 2);  // bad input
  const std::vector<json> lines = answer.lines();
  const LogReader log(read("my log.log"));
  EXPECT_EQ(log.experiment, "my_log");
  EXPECT_NE(log.setup.find("invalid.yaml\n"), std::string::npos);
  EXPECT_EQ(log.time_limit, 7);
  EXPECT_EQ(log.runs_per_planner, 3);
  ASSERT_EQ(log.planners.size(), 2U);
  const LogReader::Planner &connect = log.planners[0], &other = log.planners[1];
  EXPECT_EQ(connect.name, "Connect");
  EXPECT_EQ(other.name, "RRTConnect");
  ASSERT_EQ(connect.runs.size(), 3U);
  ASSERT_EQ(other.runs.size(), 1U);
  const auto status = [&](std::size_t run) {
    return log.enums.at("status").at(std::stoul(connect.value(run, "status ENUM")));
  };
  EXPECT_EQ(status(0), "Exact solution");
  EXPECT_EQ(status(1), "Invalid start");
  EXPECT_EQ(status(2), "Exact solution");
  EXPECT_EQ(connect.value(1, "solved BOOLEAN"), "0");
  EXPECT_EQ(connect.value(1, "solution length REAL"), "");
  EXPECT_EQ(std::stod(connect.value(0, "solution length REAL")), lines[0]["length"]);
  EXPECT_EQ(std::stod(connect.value(0, "time REAL")), lines[0]["time_s"]["plan"]);
  EXPECT_EQ(std::stod(connect.value(0, "minimum clearance REAL")),
            lines[0]["certificate"]["clearance_lower"]);
  EXPECT_EQ(std::stod(other.value(0, "solution segments INTEGER")),
            lines[3]["certificate"]["segments"].size());
  EXPECT_EQ(other.value(0, "correct solution BOOLEAN"), "1");
}

/// Lines that an earlier run left count as well.
TEST_F(OmplLog, ResumesAndRefuses) {
  ASSERT_EQ(run("batch reach.yaml empty.yaml --output lines.json").status, 0);
  ASSERT_EQ(run("batch reach.yaml empty.yaml --output lines.json --resume --ompl-log b.log").status,
            0);
  const LogReader log(read("b.log"));
  ASSERT_EQ(log.planners.size(), 1U);
  EXPECT_EQ(log.planners[0].runs.size(), 2U);
  expectRefused("batch reach.yaml --ompl-log b.csv", {"b.csv", ".log"});
  expectRefused("batch reach.yaml --ompl-log nowhere/b.log", {"nowhere"});
}

}  // namespace
}  // namespace leeway::tools::testing
