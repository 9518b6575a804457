// `leeway report accuracy`: small runs; times are not tested.

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <map>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "tests/lab/pictures.h"
#include "tests/support/command.h"
#include "tools/lab/accuracy/accuracy_report.h"
#include "tools/lab/accuracy/own_engine.h"
#include "tools/lab/base/guard.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::tools::testing {
namespace {

using namespace report;

std::vector<std::vector<std::string>> readCsv(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::size_t begin = 0;
    for (std::size_t end; (end = line.find(',', begin)) != std::string::npos; begin = end + 1)
      rows.back().push_back(line.substr(begin, end - begin));
    rows.back().push_back(line.substr(begin));
  }
  return rows;
}

std::size_t column(const std::vector<std::vector<std::string>>& csv, const std::string& name) {
  const auto found = std::find(csv[0].begin(), csv[0].end(), name);
  EXPECT_NE(found, csv[0].end()) << name;
  return static_cast<std::size_t>(found - csv[0].begin());
}

TEST(ReportGuard, OutlivesEverythingThatItemsDo) {
  const SharedArray<int> results(7);
  const std::vector<Fate> fates = runGuarded(7, 0.05, [&](std::size_t i) {
    if (i == 1) throw std::runtime_error("no");
    if (i == 2) std::abort();
    if (i == 3)
      for (volatile int forever = 1; forever != 0;) continue;
    if (i == 4) _exit(0);
    if (i == 5) kill(getpid(), SIGKILL);
    results[i] = static_cast<int>(10 + i);
  });
  EXPECT_EQ(fates, (std::vector<Fate>{Fate::kDone, Fate::kThrew, Fate::kDied, Fate::kTimedOut,
                                      Fate::kDied, Fate::kDied, Fate::kDone}));
  EXPECT_EQ(results[0], 10);
  EXPECT_EQ(results[3], 0);
  EXPECT_EQ(results[6], 16);
}

/// Knows the truth and distorts it by the case's number.
class Clown : public PairEngine {
 public:
  class Query : public PairQuery {
   public:
    Query(int number, double truth) : number_(number), truth_(truth) {}
    PairAnswer ask(double) override {
      switch (number_) {
        case 0:
          throw std::runtime_error("no");
        case 1:
          std::abort();
        case 2:
          return {kNaN, kNaN};
        case 3:
          return {truth_ + 1, truth_ + 1};
        case 4:
          return {-truth_, -truth_};
        default:
          return {truth_, truth_};
      }
    }

   private:
    int number_;
    double truth_;
  };
  const char* name() const override { return "clown"; }
  bool hasTolerance() const override { return false; }
  bool claimsBounds() const override { return true; }
  std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool) const override {
    return std::make_unique<Query>(number_++, spec.distance);
  }

 private:
  mutable int number_ = 0;
};

TEST(ReportAccuracy, CountsWhatAnEngineGetsWrong) {
  AccuracySet set = makeAccuracySet(6, 3);
  set.families.resize(1);
  ASSERT_EQ(set.families[0].name, "box-box");
  const Clown clown;
  AccuracyOptions options;
  options.tolerances = {kNaN};
  options.passes = 1;
  const auto rows = measureAccuracy(set, {&clown}, options);
  ASSERT_EQ(rows.size(), 1u);
  const AccuracyRow& r = rows[0];
  EXPECT_EQ(r.cases, 6);
  EXPECT_EQ(r.threw, 1);
  EXPECT_EQ(r.died, 1);
  EXPECT_EQ(r.not_a_number, 1);
  EXPECT_EQ(r.endless, 0);
  EXPECT_EQ(r.answered, 3);
  EXPECT_EQ(r.wrong, 2);
  EXPECT_EQ(r.wrong_verdict, 1);
  EXPECT_EQ(r.unsafe, 2);
  EXPECT_GT(r.error_max, 0);
  EXPECT_GT(r.ns, 0);
}

TEST(ReportAccuracy, CasesAreWhatTheirFamilySaysAndRepeat) {
  const AccuracySet set = makeAccuracySet(3, 5), again = makeAccuracySet(3, 5);
  ASSERT_EQ(set.families.size(), again.families.size());
  EXPECT_GE(set.families.size(), 60u);
  std::map<FamilyKind, int> kinds;
  for (std::size_t f = 0; f < set.families.size(); ++f) {
    const AccuracyFamily& family = set.families[f];
    ++kinds[family.kind];
    ASSERT_EQ(family.cases.size(), 3u) << family.name;
    for (std::size_t i = 0; i < family.cases.size(); ++i) {
      const AccuracyCase& c = family.cases[i];
      EXPECT_EQ(c.truth_lower, again.families[f].cases[i].truth_lower) << family.name;
      EXPECT_LE(c.truth_lower, c.truth_upper);
      EXPECT_LE(c.truth_upper - c.truth_lower, 1e-14 * c.extent) << family.name;
      if (family.kind == FamilyKind::kOrdinary || family.kind == FamilyKind::kCoherent) {
        EXPECT_GT(c.truth_lower, 0) << family.name;
      }
      if (family.kind == FamilyKind::kOverlap) {
        EXPECT_LT(c.truth_upper, 0) << family.name;
      }
    }
    if (family.name == "nearly touching") {
      EXPECT_LT(std::abs(family.cases[0].truth_upper), 1e-5);
    }
  }
  EXPECT_EQ(kinds[FamilyKind::kHard], 11);
  EXPECT_NE(makeAccuracySet(1, 6).families[0].cases[0].truth_lower,
            set.families[0].cases[0].truth_lower);
}

class ReportAccuracyVerb : public CommandTest {};

/// Every family, engine and tolerance, with the rivals of this build.
TEST_F(ReportAccuracyVerb, WritesEveryRow) {
  const Answer answer = run("report accuracy --per-family 1 --passes 1 --output out --json");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  const json told = answer.document();
  EXPECT_EQ(told["seed"], 1);
  EXPECT_EQ(told["own_errors"], 0);
  const auto csv = readCsv(read("out/accuracy.csv"));
  const std::size_t engine = column(csv, "engine"), tolerance = column(csv, "tolerance"),
                    answered = column(csv, "answered"), unsafe = column(csv, "unsafe"),
                    ns = column(csv, "ns");
  std::map<std::string, std::size_t> rows;
  for (std::size_t i = 1; i < csv.size(); ++i) {
    ASSERT_EQ(csv[i].size(), csv[0].size());
    ++rows[csv[i][engine]];
    if (csv[i][engine] != "leeway") continue;
    EXPECT_EQ(csv[i][answered], "1");
    EXPECT_EQ(csv[i][unsafe], "0");
    EXPECT_FALSE(csv[i][tolerance].empty());
    // Coherent families of one case have no warm query to time.
    EXPECT_EQ(csv[i][ns].empty(), csv[i][0].rfind("coherent", 0) == 0) << csv[i][0];
  }
  const std::size_t families = told["families"];
  EXPECT_EQ(rows["leeway"], 16 * families);
  EXPECT_EQ(rows["leeway d > t?"], families);
  const std::string missing = told["missing"].dump();
  if (missing.find("FCL") == std::string::npos) {
    EXPECT_GE(rows["FCL libccd"], 16 * 50u);
    EXPECT_GE(rows["FCL indep"], 16 * 50u);
  }
  if (missing.find("Bullet") == std::string::npos) {
    EXPECT_GE(rows["Bullet epa2"], 45u);
    EXPECT_EQ(rows["Bullet epa2"], rows["Bullet detector"]);
  }
  if (hasPictures(told)) {
    expectPicture(read("out/accuracy.svg"), 30);
    expectPicture(read("out/hard_cases.svg"), 20);
  }
  EXPECT_EQ(readCsv(read("out/hard_cases.csv"))[0].size(), 12u);
}

/// Our rows are independent of rivals, and everything but times is reproducible.
TEST_F(ReportAccuracyVerb, SameSeedSameErrors) {
  const std::string small = "report accuracy --per-family 2 --passes 1 --no-rivals --family sphere";
  const auto withoutTimes = [&](const std::string& seed, const std::string& folder) {
    EXPECT_EQ(run(small + " --seed " + seed + " --output " + folder).status, 0);
    auto csv = readCsv(read(folder + "/accuracy.csv"));
    const std::size_t ns = column(csv, "ns");
    for (auto& row : csv)
      row.erase(row.begin() + static_cast<long>(ns), row.begin() + static_cast<long>(ns) + 3);
    return csv;
  };
  const auto first = withoutTimes("4", "a");
  EXPECT_EQ(first, withoutTimes("4", "b"));
  EXPECT_NE(first, withoutTimes("5", "c"));
}

TEST_F(ReportAccuracyVerb, BitesOnAWrongReference) {
  write("cases.txt",
        "shape 0 sphere 1\ncase 0 pair far 0 0 1 0 0 0 1 0 0 0 1 0 0 0  1 0 0 0 1 0 0 0 1 3 0 0\n");
  write("right.txt", "0 1 1 0 1 3\n");
  write("wrong.txt", "0 1 1.000001 0 1 3\n");
  const std::string common =
      "report accuracy --cases cases.txt --passes 1 --output out --reference ";
  EXPECT_EQ(run(common + "right.txt").status, 0);
  const Answer wrong = run(common + "wrong.txt --json");
  EXPECT_EQ(wrong.status, 1);
  EXPECT_GT(wrong.document()["own_errors"], 0);
  const auto csv = readCsv(read("out/hard_cases.csv"));
  EXPECT_EQ(csv[1][column(csv, "unsafe")], "1");
  EXPECT_EQ(csv[1][0], "pair far");
}

TEST_F(ReportAccuracyVerb, RefusesWhatItCannotUse) {
  expectRefused("report accuracy --cases none.txt --reference none.txt", {"none.txt"});
  expectRefused("report accuracy --cases none.txt", {"--reference"});
  expectRefused("report accuracy --per-family 0", {"per-family"});
  expectRefused("report accuracy --per-family 1 --no-rivals --family teapot",
                {"teapot", "box-box, box-sphere"});
  write("file", "");
  expectRefused(
      "report accuracy --per-family 1 --passes 1 --no-rivals --family box-box --output file",
      {"file", "Not a directory"});
}

}  // namespace
}  // namespace leeway::tools::testing
