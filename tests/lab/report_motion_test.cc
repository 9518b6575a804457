// `leeway report motion`: small runs; times are not tested.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <stdexcept>

#include "tests/lab/pictures.h"
#include "tests/support/command.h"
#include "tools/lab/motion/motion_cases.h"
#include "tools/lab/motion/motion_report.h"
#include "tools/lab/motion/motion_truth.h"
#include "tools/lab/motion/own_motion_engine.h"

namespace leeway::tools::testing {
namespace {

using namespace report;
using collision::Pose;
using Eigen::Vector3d;

Pose shifted(double x, double y, double z) { return {Eigen::Matrix3d::Identity(), {x, y, z}}; }

TEST(ReportMotion, TheSlowSearchFindsWhatCanBeWorkedOut) {
  const SlowPolytope box = slowBox({0.1, 0.2, 0.3});
  std::vector<Vector3d> corners = box.vertices;
  for (Vector3d& corner : corners) corner *= 1 + 1e-9;  // no four in a plane
  corners[0].x() -= 1e-10, corners[3].y() += 1e-10;
  const SlowPolytope hull = slowHull(corners);
  EXPECT_GE(hull.normals.size(), 6u);
  const std::vector<std::array<std::size_t, 2>> pair = {{0, 1}};
  const auto first = [&](const SlowPolytope& a, double height) {
    const SlowBody bodies[] = {{&a, [=](double t) { return shifted(-1 + 2 * t, 0, height); }, 2},
                               {&box, [](double) { return Pose{}; }, 0}};
    return slowFirstContact(bodies, pair, 0);
  };
  for (const SlowPolytope* a : {&box, &hull}) {
    const TimeTruth hit = first(*a, 0.5999);
    ASSERT_TRUE(hit.clear && hit.contact);
    EXPECT_LE(hit.lower, 0.4 + 1e-9);
    EXPECT_GE(hit.upper, 0.4 - 1e-9);
    EXPECT_LE(hit.upper - hit.lower, 1e-8);
    const TimeTruth free = first(*a, 0.6001);
    EXPECT_TRUE(free.clear && !free.contact);
  }
  // A corner on a circle reaches a wall at the angle whose cosine is the wall's distance.
  const double reach = std::hypot(0.1, 0.2), start = std::atan2(0.2, 0.1);
  for (const double gap : {-1e-4, 1e-4}) {
    const SlowBody bodies[] = {
        {&box,
         [](double t) {
           return Pose{slowTurn(Vector3d::UnitZ(), -3 * t), Vector3d::Zero()};
         },
         3 * reach},
        {&box, [=](double) { return shifted(reach + 0.1 + gap, 0, 0); }, 0}};
    const TimeTruth truth = slowFirstContact(bodies, pair, 0);
    ASSERT_TRUE(truth.clear);
    EXPECT_EQ(truth.contact, gap < 0);
    if (gap < 0) {
      EXPECT_NEAR(truth.upper, (start - std::acos(1 + gap / reach)) / 3, 1e-9);
    }
  }
  // Coplanar.
  const collision::MovingTriangle still{{Vector3d(0, -1, 2), Vector3d(1, 0, 2), Vector3d(0, 1, 2)},
                                        {Vector3d(0, -1, 2), Vector3d(1, 0, 2), Vector3d(0, 1, 2)}};
  collision::MovingTriangle sliding = still;
  for (Vector3d& p : sliding.from) p.x() -= 3;
  const TimeTruth slide = slowFirstContact(sliding, still, 0);
  EXPECT_TRUE(slide.clear && slide.contact);
  EXPECT_NEAR(slide.upper, 2.0 / 3, 1e-9);
  for (Vector3d& p : sliding.to) p.z() += 1e-6;
  for (Vector3d& p : sliding.from) p.z() += 1e-6;
  EXPECT_FALSE(slowFirstContact(sliding, still, 0).contact);
}

/// Poses of a case, for comparison.
std::vector<double> numbersOf(const ContactCase& c) {
  std::vector<double> numbers = {c.lower, c.upper};
  for (const MovingBody& body : c.spec.bodies)
    for (const double t : {0.0, 1.0}) {
      const Pose X = body.motion->pose(t);
      numbers.insert(numbers.end(), X.translation.data(), X.translation.data() + 3);
    }
  for (const collision::MovingTriangle& t : c.spec.triangles)
    for (const Vector3d& p : t.to) numbers.insert(numbers.end(), p.data(), p.data() + 3);
  return numbers;
}

TEST(ReportMotion, FamiliesAreWhatTheirNamesSay) {
  for (const std::string& name : contactFamilies()) {
    const ContactFamily family = makeContactFamily(name, 40, 3),
                        again = makeContactFamily(name, 40, 3);
    ASSERT_EQ(family.cases.size(), 40u) << name;
    int hits = 0;
    for (std::size_t i = 0; i < 40; ++i) {
      const ContactCase& c = family.cases[i];
      EXPECT_EQ(numbersOf(c), numbersOf(again.cases[i])) << name << " " << i;
      hits += c.contact;
      EXPECT_LE(c.lower, c.upper) << name;
      EXPECT_EQ(c.contact && c.upper == 0, name == "start in contact") << name << " " << i;
    }
    const bool all = name == "grazing hits" || name == "start in contact" || name == "flush meshes";
    const bool none = name == "grazing frees";
    EXPECT_GE(hits, all ? 40 : none ? 0 : 3) << name;
    EXPECT_LE(hits, all ? 40 : none ? 0 : 37) << name;
  }
  EXPECT_THROW(makeContactFamily("boiling", 1, 1), std::invalid_argument);
}

MotionReportOptions smallMotions() {
  MotionReportOptions options;
  options.families = {"ordinary"};
  options.cases = 20;
  options.passes = 1;
  options.query_seconds = 0.02;
  return options;
}

TEST(ReportMotion, OursIsNeverWrong) {
  const auto own = makeOwnMotionEngines();
  MotionReportOptions options = smallMotions();
  options.families = contactFamilies();
  options.cases = 200;
  options.query_seconds = 5;
  for (const MotionRow& r : measureMotion({own[0].get()}, options)) {
    EXPECT_EQ(r.cases, 200) << r.family;
    EXPECT_EQ(r.wrong(), 0) << r.family << ": " << r.misses << " misses, " << r.false_hits
                            << " false hits, " << r.wrong_starts << " wrong starts, " << r.unsafe
                            << " unsafe";
    EXPECT_EQ(r.undecided + r.failures(), 0) << r.family;
    if (r.hits > 0) {
      EXPECT_LE(r.error_max, 1.1e-6) << r.family;
    }
  }
}

/// Regression: refused input counted as a motion without contact.
TEST(ReportMotion, RefusedMotionsAreNotFree) {
  const double nan = std::nan("");
  ContactSpec triangles;
  triangles.triangles.resize(2);
  for (collision::MovingTriangle& t : triangles.triangles) {
    t.from = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
    t.to = t.from;
  }
  triangles.triangles[0].from[1].z() = nan;
  const ReportShape box{collision::Shape::box({1, 1, 1}), {}};
  const auto still = [](const Pose& X) { return std::make_shared<collision::Still>(X); };
  ContactSpec bodies;  // two that are apart, and one at NaN
  bodies.bodies = {{&box, still(shifted(0, 0, 0))},
                   {&box, still(shifted(9, 0, 0))},
                   {&box, still(shifted(nan, 0, 0))}};
  bodies.pairs = {{0, 1}};
  const auto own = makeOwnMotionEngines();
  EXPECT_FALSE(own[0]->prepare(bodies)->ask().undecided);
  bodies.pairs.push_back({0, 2});
  for (const ContactSpec* spec : {&triangles, &bodies}) {
    const ContactAnswer answer = own[0]->prepare(*spec)->ask();
    EXPECT_FALSE(answer.contact);
    EXPECT_TRUE(answer.undecided);
    EXPECT_EQ(answer.lower, 0);
  }
}

/// Always gives one answer, or throws.
class Fake : public ContactEngine {
 public:
  enum class Kind { kFree, kAtStart, kThrows, kAborts, kLoops };
  Fake(const char* name, Kind kind) : name_(name), kind_(kind) {}
  const char* name() const override { return name_; }
  bool claimsBounds() const override { return true; }
  std::unique_ptr<ContactQuery> prepare(const ContactSpec&) const override {
    return std::make_unique<Query>(kind_);
  }

 private:
  class Query : public ContactQuery {
   public:
    explicit Query(Kind kind) : kind_(kind) {}
    ContactAnswer ask() override {
      if (kind_ == Kind::kThrows) throw std::runtime_error("no");
      if (kind_ == Kind::kAborts) std::abort();
      for (volatile bool forever = kind_ == Kind::kLoops; forever;) continue;
      return {kind_ == Kind::kAtStart, false, 0, 0};
    }

   private:
    Kind kind_;
  };
  const char* name_;
  Kind kind_;
};

TEST(ReportMotion, CountsWhatGoesWrong) {
  const Fake free("free", Fake::Kind::kFree), start("start", Fake::Kind::kAtStart);
  const Fake throws("throws", Fake::Kind::kThrows), aborts("aborts", Fake::Kind::kAborts);
  const Fake loops("loops", Fake::Kind::kLoops);
  const auto rows = measureMotion({&free, &start, &throws, &aborts, &loops}, smallMotions());
  ASSERT_EQ(rows.size(), 5u);
  const int hits = rows[0].hits;
  EXPECT_GT(hits, 5);
  EXPECT_LT(hits, 20);
  EXPECT_EQ(rows[0].misses, hits);
  EXPECT_EQ(rows[0].false_hits, 0);
  EXPECT_EQ(rows[1].misses, 0);
  EXPECT_EQ(rows[1].false_hits, 20 - hits);
  EXPECT_EQ(rows[1].wrong_starts, hits);
  EXPECT_EQ(rows[1].unsafe, hits);
  EXPECT_GT(rows[1].error_max, 0.05);
  EXPECT_EQ(rows[2].threw, 20);
  EXPECT_EQ(rows[3].died, 20);
  EXPECT_EQ(rows[4].endless, 20);
  EXPECT_TRUE(std::isnan(rows[4].ns_median));
  MotionReportOptions starts = smallMotions();
  starts.families = {"start in contact"};
  EXPECT_EQ(measureMotion({&start}, starts)[0].wrong(), 0);
  EXPECT_EQ(measureMotion({&free}, starts)[0].misses, 20);
}

class ReportMotionVerb : public CommandTest {};

/// Every family, with the rivals of this build.
TEST_F(ReportMotionVerb, WritesEveryRow) {
  const Answer answer = run("report motion --cases 5 --passes 1 --output out --json");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  const json told = answer.document();
  EXPECT_EQ(told["own_errors"], 0);
  std::istringstream csv(read("out/motion.csv"));
  std::string header, line;
  std::getline(csv, header);
  EXPECT_EQ(header.rfind("family,engine,cases,hits,misses,false_hits,wrong_starts", 0), 0u)
      << header;
  std::set<std::string> families;
  std::size_t rows = 0;
  for (; std::getline(csv, line); ++rows) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
    if (line.find(",leeway,5,") != std::string::npos)
      families.insert(line.substr(0, line.find(',')));
  }
  EXPECT_EQ(rows, told["rows"]);
  EXPECT_EQ(families, std::set<std::string>(contactFamilies().begin(), contactFamilies().end()));
  if (hasPictures(told)) expectPicture(read("out/motion.svg"), 4);
}

/// Certified edges never miss what the verifier refutes; rows of one problem and kind cover the
/// same edges.
TEST_F(ReportMotionVerb, EdgesOfAProblem) {
  const Answer answer =
      run("report motion --cases 1 --passes 0 --family translation --no-rivals --edges 25 "
          "--output out --json --problem reach.yaml");
  ASSERT_EQ(answer.status, 0) << answer.out << answer.err;
  std::istringstream csv(read("out/edges.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "problem,kind,method,edges,missed,cautious,undecided,us");
  std::map<std::string, std::set<std::string>> counts, methods;
  int edges = 0;
  while (std::getline(csv, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    ASSERT_EQ(cells.size(), 8u) << line;
    counts[cells[0] + cells[1]].insert(cells[3]);
    methods[cells[0] + cells[1]].insert(cells[2]);
    if (cells[2] != "certified") continue;
    edges += std::stoi(cells[3]);
    EXPECT_EQ(cells[4], "0") << line;
  }
  EXPECT_GT(edges, 20);
  for (const auto& [kind, numbers] : counts) EXPECT_EQ(numbers.size(), 1u) << kind;
  for (const auto& [kind, names] : methods) EXPECT_EQ(names.size(), 5u) << kind;
  if (hasPictures(answer.document())) expectPicture(read("out/edges.svg"), 3);
}

constexpr const char* kOneCase =
    "report motion --cases 1 --passes 0 --family translation --no-rivals --output out --json";

TEST_F(ReportMotionVerb, DrawsWithMatplotlib) {
  const Answer answer = run(kOneCase);
  ASSERT_EQ(answer.status, 0) << answer.err;
  if (!hasPictures(answer.document())) GTEST_SKIP() << "matplotlib is missing: " << answer.err;
  const std::string first = read("out/motion.svg");
  EXPECT_NE(first.find("Time of contact"), std::string::npos);
  EXPECT_NE(answer.document()["files"].dump().find("motion.svg"), std::string::npos);
  EXPECT_EQ(first.find("<dc:date>"), std::string::npos);
}

TEST_F(ReportMotionVerb, GoesOnWithoutMatplotlib) {
  fs::create_directory(folder_ / "none");
  write("none/matplotlib.py", "raise ImportError('none')\n");
  ::setenv("PYTHONPATH", path("none").c_str(), 1);
  const Answer answer = run(kOneCase);
  ::unsetenv("PYTHONPATH");
  EXPECT_EQ(answer.status, 0) << answer.err;
  EXPECT_NE(answer.err.find("without motion.svg"), std::string::npos) << answer.err;
  EXPECT_NE(answer.err.find("python3-matplotlib"), std::string::npos) << answer.err;
  const json told = answer.document();
  EXPECT_EQ(told["missing"], json({"matplotlib"}));
  EXPECT_EQ(told["files"], json({"out/motion.csv", "out/motion.json"}));
  EXPECT_FALSE(fs::exists(folder_ / "out/motion.svg"));
  // The rows of the CSV file, with the conditions.
  const json table = json::parse(read("out/motion.json"));
  EXPECT_EQ(table["seed"], 1);
  EXPECT_NE(table["note"].dump().find("1 cases a family"), std::string::npos) << table["note"];
  ASSERT_EQ(table["rows"].size(), 1U);
  EXPECT_EQ(table["rows"][0]["family"], "translation");
  EXPECT_TRUE(table["rows"][0]["ns_median"].is_null()) << "nothing is timed";
}

TEST_F(ReportMotionVerb, RefusesWhatItCannotUse) {
  expectRefused("report motion --problem nowhere.yaml", {"nowhere.yaml"});
  expectRefused("report motion --srdf a.srdf", {"--robot"});
  expectRefused("report motion --family boiling", {"boiling", "ordinary"});
  expectRefused("report motion --cases 0", {"cases"});
  expectRefused("report motion --passes -1", {"passes"});
  write("file", "");
  expectRefused("report motion --full --output file", {"file", "Not a directory"});
}

}  // namespace
}  // namespace leeway::tools::testing
