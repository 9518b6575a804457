#include "leeway/planner/path_io.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "collision/base/numbers.h"
#include "leeway/planner/trajectory.h"
#include "leeway/planner/verify.h"
#include "leeway/robots/input_error.h"
#include "planner/search/half_turns.h"
#include "tests/support/build_paths.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"

namespace leeway::planner {
namespace {

const std::string kSource = leeway::sourceFolder();

class PathIo : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder_.path(name); }
  std::string write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text);
  }
  /// Number of files: a failed write must not leave its temporary file.
  std::size_t fileCount() const {
    const std::filesystem::directory_iterator first(folder_.path()), last;
    return static_cast<std::size_t>(std::distance(first, last));
  }
  std::string messageOf(const std::string& path, const Problem& problem) const {
    try {
      readPath(path, problem);
    } catch (const robots::InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  Folder folder_;
};

double signedUnit(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1;
}

PlanResult resultOf(const Problem& problem, std::vector<std::vector<double>> rows) {
  PlanResult result;
  result.status = PlanStatus::kSolved;
  result.certificate.margins = problem.margins;
  for (const int v : problem.robot.variables)
    result.path.names.push_back(problem.robot.model->variables[static_cast<std::size_t>(v)].name);
  result.path.positions = std::move(rows);
  result.certificate.certified = true;
  result.certificate.clearance = {0.0123456789012345678, 0.0234};
  result.certificate.closest_a = "a \"quoted\" name";
  result.certificate.closest_b = "b";
  result.certificate.closest_segment = 0;
  result.certificate.closest_t = 1.0 / 3;
  for (std::size_t i = 1; i < result.path.positions.size(); ++i)
    result.certificate.segments.push_back({0.1 / static_cast<double>(i), 1});
  return result;
}

/// The numbers below a CSV's header.
std::vector<std::vector<double>> csvRows(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  std::string line, cell;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    rows.emplace_back();
    for (std::istringstream cells(line); std::getline(cells, cell, ',');)
      rows.back().push_back(std::stod(cell));
  }
  return rows;
}

Problem armProblem() { return loadProblem(kSource + "/problems/shelf/reach.yaml"); }
Problem bodyProblem() { return loadProblem(kSource + "/problems/bodies/window.yaml"); }

std::vector<std::vector<double>> armRows() {
  std::mt19937_64 random(1);
  std::vector<std::vector<double>> rows(20, std::vector<double>(7));
  for (auto& row : rows)
    for (double& x : row)
      x = 2 * signedUnit(random) * std::pow(10.0, static_cast<double>(random() % 6) - 5);
  rows[3] = {0, -0.0, 1e-300, 5e-324, 0.1, 1.0 / 3, -2};
  return rows;
}

bool sameBits(const std::vector<std::vector<double>>& a,
              const std::vector<std::vector<double>>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].size() != b[i].size() ||
        std::memcmp(a[i].data(), b[i].data(), a[i].size() * sizeof(double)) != 0)
      return false;
  return true;
}

TEST_F(PathIo, EveryFormatComesBackToTheBit) {
  const Problem problem = armProblem();
  const PlanResult result = resultOf(problem, armRows());
  for (const char* ending : {".json", ".yaml", ".yml", ".csv", ".path"}) {
    writePath(file(std::string("arm") + ending), problem, result);
    const Path path = readPath(file(std::string("arm") + ending), problem);
    EXPECT_EQ(path.names, result.path.names) << ending;
    EXPECT_TRUE(sameBits(path.positions, result.path.positions)) << ending;
  }
}

TEST_F(PathIo, BodiesComeBackToTheBit) {
  const Problem problem = bodyProblem();
  std::mt19937_64 random(2);
  std::vector<std::vector<double>> rows;
  for (int i = 0; i < 10; ++i) {
    std::vector<double> row(7);
    for (double& x : row) x = signedUnit(random);
    const double n =
        std::sqrt(row[3] * row[3] + row[4] * row[4] + row[5] * row[5] + row[6] * row[6]);
    for (std::size_t k = 3; k < 7; ++k) row[k] /= n;
    rows.push_back(row);
  }
  const PlanResult result = resultOf(problem, rows);
  for (const char* ending : {".json", ".yaml", ".csv", ".path"}) {
    writePath(file(std::string("body") + ending), problem, result);
    EXPECT_TRUE(sameBits(readPath(file(std::string("body") + ending), problem).positions, rows))
        << ending;
  }
  // Rows are x y z qx qy qz qw, as OMPL prints them.
  std::istringstream first(readText(file("body.path")));
  for (const double expected : rows[0]) {
    double x = 0;
    first >> x;
    EXPECT_EQ(x, expected);
  }
}

TEST_F(PathIo, NumbersDoNotDependOnTheLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    std::string do_grouping() const override { return "\3"; }
    char do_thousands_sep() const override { return '.'; }
  };
  const Problem problem = armProblem();
  const PlanResult result = resultOf(problem, armRows());
  writePath(file("classic.json"), problem, result);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const Problem again = armProblem();
  for (const char* ending : {".json", ".yaml", ".csv", ".path"}) {
    writePath(file(std::string("comma") + ending), problem, result);
    EXPECT_TRUE(sameBits(readPath(file(std::string("comma") + ending), problem).positions,
                         result.path.positions))
        << ending;
  }
  std::locale::global(before);
  EXPECT_EQ(readText(file("comma.json")), readText(file("classic.json")));
  EXPECT_EQ(again.start, problem.start);
}

TEST_F(PathIo, JsonHoldsTrajectoryAndCertificate) {
  const Problem problem = armProblem();
  PlanResult result = resultOf(problem, armRows());
  writePath(file("arm.json"), problem, result);
  const auto json = nlohmann::json::parse(readText(file("arm.json")));
  EXPECT_EQ(json.at("header").at("frame_id"), "base");
  EXPECT_EQ(json.at("joint_names").size(), 7U);
  ASSERT_EQ(json.at("points").size(), 20U);
  EXPECT_EQ(json.at("points")[0].at("time_from_start").at("sec"), 0);
  const auto& certificate = json.at("certificate");
  EXPECT_EQ(certificate.at("certified"), true);
  EXPECT_EQ(certificate.at("interpolation"), "joint-linear");
  EXPECT_EQ(certificate.at("clearance_lower").get<double>(), result.certificate.clearance.lower);
  EXPECT_EQ(certificate.at("closest").at("a"), "a \"quoted\" name");
  EXPECT_EQ(certificate.at("segments").size(), 19U);
  // Half of the clearance above the problem's margin 0.01.
  EXPECT_NEAR(certificate.at("tracking_tolerance").get<double>(),
              (0.0123456789012345678 - 0.01) / 2, 1e-15);

  result.certificate.clearance = {kInfinity, kInfinity};  // no obstacles
  result.certificate.closest_segment = -1;
  writePath(file("arm.json"), problem, result);
  const auto far = nlohmann::json::parse(readText(file("arm.json")));
  EXPECT_TRUE(far.at("certificate").at("clearance_lower").is_null());
  EXPECT_TRUE(far.at("certificate").at("closest").is_null());
}

/// Rows are in the order of the motion, and so are their times.
TEST_F(PathIo, TimesThatDoNotRiseAreRefused) {
  const Problem problem = armProblem();
  const std::string names = "joint1,joint2,joint3,joint4,joint5,joint6,joint7";
  const auto csv = [&](const std::string& second, const std::string& joint1) {
    return messageOf(write("a.csv", "time," + names + "\n1.5,0,0,0,-1,0,1,0\n" + second + "," +
                                        joint1 + ",0,0,-1,0,1,0\n"),
                     problem);
  };
  EXPECT_EQ(csv("2", "0.5"), "accepted");
  EXPECT_EQ(csv("1.5", "0"), "accepted") << "nothing moves";
  EXPECT_EQ(csv("1.25", "0.5"), file("a.csv") +
                                    ":3: the row's time is 1.25 s, no later than the 1.5 s of line "
                                    "2; times that rise are expected");
  EXPECT_EQ(csv("1.25", "0"), file("a.csv") +
                                  ":3: the row's time is 1.25 s, before the 1.5 s of line 2; times "
                                  "that rise are expected");
  EXPECT_EQ(csv("1.5", "0.5"), file("a.csv") +
                                   ":3: the row's time is 1.5 s, no later than the 1.5 s of line "
                                   "2; times that rise are expected");
  const auto yaml = [&](const std::string& first, const std::string& second) {
    return messageOf(write("a.yaml", "joint_names: [" + names +
                                         "]\npoints:\n- positions: [0, 0, 0, "
                                         "-1, 0, 1, 0]\n  time_from_start: " +
                                         first +
                                         "\n- positions: [1, 0, 0, -1, 0, 1, 0]\n  "
                                         "time_from_start: " +
                                         second + "\n"),
                     problem);
  };
  EXPECT_EQ(yaml("0", "0.5"), "accepted");
  EXPECT_EQ(yaml("{sec: 1, nanosec: 5}", "{sec: 1, nanosec: 6}"), "accepted");
  EXPECT_EQ(yaml("{secs: 0, nsecs: 999999999}", "{secs: 1, nsecs: 0}"), "accepted");
  EXPECT_EQ(yaml("", ""), "accepted") << "no times";
  EXPECT_NE(yaml("{secs: 2, nsecs: 0}", "{secs: 1, nsecs: 5}").find("a.yaml:5: the row's time"),
            std::string::npos);
  EXPECT_NE(yaml("2", "-1").find("a.yaml:5: the row's time is -1 s"), std::string::npos);
  EXPECT_NE(yaml("0", "{seconds: 1}").find("a.yaml:6: unknown key 'seconds'"), std::string::npos);
  EXPECT_NE(yaml("0", "soon").find("a.yaml:6:"), std::string::npos);
}

TEST_F(PathIo, TimesHaveASensibleSize) {
  const Problem problem = armProblem();
  std::string names = "time";
  for (int i = 1; i <= 7; ++i) names += ",joint" + std::to_string(i);
  const auto csv = [&](const std::string& time) {
    return messageOf(write("a.csv", names + "\n0,0,0,0,-1,0,1,0\n" + time + ",0.5,0,0,-1,0,1,0\n"),
                     problem);
  };
  EXPECT_EQ(csv("1700000000.5"), "accepted");
  EXPECT_EQ(csv(std::string(300, '9')),
            file("a.csv") +
                ":3: the row's time is 1e+300 s; a number from -1000000000000 to 1000000000000 is "
                "expected");
}

TEST_F(PathIo, AJointMayBeCalledTime) {
  const std::string urdf = write("r.urdf", R"(<robot name="r"><link name="a"/><link name="b"/>
<joint name="time" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>)");
  const Problem problem = problemFromStates(robots::loadModel(urdf, ""), "all", "0.5", "-0.5");
  const auto expect = [&](const Path& path) {
    EXPECT_EQ(path.positions, (std::vector<std::vector<double>>{{0.5}, {-0.5}}));
  };
  expect(readPath(write("a.csv", "time\n0.5\n-0.5\n"), problem));
  expect(readPath(write("b.csv", "time,time\n0,0.5\n2,-0.5\n"), problem));
  EXPECT_NE(messageOf(write("c.csv", "time,time\n1,0.5\n0,-0.5\n"), problem).find("the row's time"),
            std::string::npos);
  EXPECT_NE(messageOf(write("d.csv", "time,time,time\n0,0,0\n"), problem).find("stands twice"),
            std::string::npos);
  const PlanResult planned = resultOf(problem, {{0.5}, {-0.5}});
  writePath(file("e.csv"), problem, planned);
  expect(readPath(file("e.csv"), problem));
}

/// An empty field does not shift the others.
TEST_F(PathIo, EmptyFieldsNameTheirLine) {
  const Problem problem = armProblem();
  const std::string row = "0,0,0,-1,0,1,0\n";
  const auto expect = [&](const std::string& name, const std::string& text) {
    EXPECT_EQ(messageOf(write(name, text), problem),
              file(name) + ":2: a field is empty; a finite number is expected")
        << text;
  };
  expect("a.csv", row + "0,0,,0,-1,0,1,0\n");
  expect("b.csv", row + ",0,0,0,-1,0,1\n");
  expect("c.csv", "joint1,joint2,joint3,joint4,joint5,joint6,joint7\n0,0,0,-1,,1,0\n");
  std::string tabs = row;
  std::replace(tabs.begin(), tabs.end(), ',', '\t');
  EXPECT_EQ(messageOf(write("d.csv", tabs + tabs), problem), "accepted");
  for (const char* name : {"e.csv", "e.path", "e.txt"}) {
    expect(name, tabs + "0\t0\t\t0\t-1\t0\t1\t0\n");
    expect(name, tabs + "\t0\t0\t0\t-1\t0\t1\t0\n");
    expect(name, tabs + "0\t0\t0\t0\t-1\t0\t1\t\n");
  }
  EXPECT_EQ(messageOf(write("f.path", "0 0 0\t-1  0 1 0 \n"), problem), "accepted");
}

TEST_F(PathIo, TimesKeepTheVelocityLimits) {
  const Problem problem = armProblem();
  std::vector<std::vector<double>> rows(2, std::vector<double>(7));
  rows[1][3] = 1.0;  // joint4, at most 75 degrees a second
  rows[1][0] = 0.5;  // joint1, 85
  writePath(file("arm.csv"), problem, resultOf(problem, rows));
  std::istringstream lines(readText(file("arm.csv")));
  std::string header, first, second;
  std::getline(lines, header);
  std::getline(lines, first);
  std::getline(lines, second);
  EXPECT_EQ(header, "time,joint1,joint2,joint3,joint4,joint5,joint6,joint7");
  EXPECT_EQ(first.substr(0, 2), "0,");
  // Plus half a second to reach and leave that speed, half of it lost.
  EXPECT_NEAR(std::stod(second), 1 / (75 * 3.141592653589793 / 180) + 0.5, 1e-4);
}

TEST_F(PathIo, TrajectoriesHaveRatesAndTheirOwnCertificate) {
  Problem problem = armProblem();
  problem.execution.corners = Corners::kBlend;
  std::vector<std::vector<double>> rows(3, std::vector<double>(7));
  rows[1][0] = 0.5;
  rows[2][0] = 0.5;
  rows[2][1] = 0.25;
  PlanResult result = resultOf(problem, rows);
  result.certificate.clearance = {0.03, 0.031};
  const auto space =
      std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  const std::vector<Blend> blends = {{1, 0.1, 0.1}};
  const Trajectory trajectory(space, rows, defaultMotionLimits(*space), {blends});
  for (const char* name : {"t.json", "t.yaml"}) {
    writeTrajectory(file(name), problem, result, trajectory, 0.05);
    const auto read = readPath(file(name), problem);  // its rows form a path again
    EXPECT_TRUE(sameBits({read.positions.front(), read.positions.back()}, {rows[0], rows[2]}));
  }
  const auto json = nlohmann::json::parse(readText(file("t.json")));
  const auto& points = json.at("points");
  double before = -1;
  int sampled = 0;
  for (const auto& point : points) {
    const double time = point.at("time_from_start").at("sec").get<double>() +
                        point.at("time_from_start").at("nanosec").get<double>() * 1e-9;
    EXPECT_GT(time, before);
    before = time;
    std::vector<double> q(7), rate(7), second(7);
    trajectory.configuration(time, q);
    trajectory.velocity(time, rate);
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_NEAR(point.at("positions")[i].get<double>(), q[i], 1e-8);
      EXPECT_NEAR(point.at("velocities")[i].get<double>(), rate[i], 1e-8);
    }
    sampled += std::abs(time / 0.05 - std::round(time / 0.05)) < 1e-6;
  }
  EXPECT_NEAR(before, trajectory.duration(), 1e-9);
  EXPECT_GE(sampled, static_cast<int>(trajectory.duration() / 0.05));
  // Accelerations jump without limits on jerk: quintics through them would leave the motion.
  EXPECT_FALSE(points[0].contains("accelerations"));
  const auto& certificate = json.at("certificate");
  EXPECT_EQ(certificate.at("blended_corners"), nlohmann::json::array({1}));
  EXPECT_EQ(certificate.at("clearance_lower").get<double>(), problem.margins.common);
  EXPECT_EQ(certificate.at("tracking_tolerance").get<double>(), 0);
  EXPECT_FALSE(certificate.contains("segments"));
  // Away from the path, its least clearance is no upper bound.
  EXPECT_EQ(certificate.at("clearance_upper").get<double>(), 0.031);
  for (const double t : {0.7, 0.9}) {
    result.certificate.closest_segment = 0;
    result.certificate.closest_t = t;
    writeTrajectory(file("cut.json"), problem, result, trajectory);
    EXPECT_EQ(nlohmann::json::parse(readText(file("cut.json")))
                  .at("certificate")
                  .at("clearance_upper")
                  .is_null(),
              t > 0.8);
  }

  const Trajectory stopping(space, rows, defaultMotionLimits(*space));
  writeTrajectory(file("stop.json"), problem, result, stopping);
  const auto stop = nlohmann::json::parse(readText(file("stop.json")));
  EXPECT_EQ(stop.at("certificate").at("clearance_lower").get<double>(), 0.03);
  EXPECT_EQ(stop.at("points").size(), stopping.knots().size());
  writeTrajectory(file("stop.csv"), problem, result, stopping);
  const std::vector<std::vector<double>> columns = csvRows(readText(file("stop.csv")));
  ASSERT_EQ(columns.size(), stopping.knots().size());
  for (std::size_t i = 0; i + 1 < columns.size(); ++i) {  // later ones
    std::vector<double> second(7);
    stopping.acceleration((stopping.knots()[i] + stopping.knots()[i + 1]) / 2, second);
    EXPECT_NEAR(columns[i].at(1 + 7 + 7), second[0], 1e-9) << i;
  }
  const std::string csv = readText(file("stop.csv"));
  EXPECT_EQ(csv.substr(0, 12), "time,joint1,");
  const std::string head = csv.substr(0, csv.find('\n'));
  EXPECT_TRUE(head.ends_with(",joint7.acceleration")) << head;
  EXPECT_EQ(std::count(head.begin(), head.end(), ','), 21);
  EXPECT_EQ(readPath(file("stop.csv"), problem).positions.size(), stopping.knots().size());
  try {
    writeTrajectory(file("stop.path"), problem, result, stopping);
    ADD_FAILURE();
  } catch (const robots::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'.path' names no format of trajectories"),
              std::string::npos);
  }
}

/// Files hold the motion exactly: cubics between rows, which verify() proves.
TEST_F(PathIo, BlendedTrajectoriesAreReadAsTheirCubics) {
  Problem problem = loadProblem(kSource + "/problems/shelf/reach.yaml");
  for (const int v : problem.robot.variables)
    problem.execution.jerks[problem.robot.model->variables[static_cast<std::size_t>(v)].name] = 30;
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  const Trajectory trajectory = trajectoryOf(problem, result.path);
  ASSERT_GT(trajectory.cuts().blends.size(), 0U);
  const Path motion = motionOf(trajectory);
  EXPECT_EQ(motion.names, result.path.names);
  EXPECT_EQ(verify(problem, motion).status, VerifyStatus::kCertified);
  std::vector<double> q(motion.names.size());
  for (const char* name : {"t.json", "t.yaml", "t.csv"}) {
    writeTrajectory(file(name), problem, result, trajectory, 0.05);
    std::vector<std::string> warnings;
    const Path read = readPath(file(name), problem, {.cubics = true, .warnings = &warnings});
    EXPECT_TRUE(warnings.empty()) << warnings[0];
    EXPECT_NE(readText(file(name)).find("acceleration"), std::string::npos) << name;
    ASSERT_EQ(read.times.size(), read.positions.size()) << name;
    for (std::size_t k = 1; k < read.times.size(); ++k)
      for (const double t : {0.3, 0.5, 0.9}) {
        const double h = read.times[k] - read.times[k - 1];
        trajectory.configuration(read.times[k - 1] + t * h, q);
        for (std::size_t i = 0; i < q.size(); ++i)
          EXPECT_NEAR(read.positions[k - 1][i] * (1 + 2 * t) * (1 - t) * (1 - t) +
                          h * read.velocities[k - 1][i] * t * (1 - t) * (1 - t) +
                          read.positions[k][i] * t * t * (3 - 2 * t) -
                          h * read.velocities[k][i] * t * t * (1 - t),
                      q[i], 1e-8)
              << name;
      }
    const VerifyResult proof = verify(problem, read);
    EXPECT_EQ(proof.status, VerifyStatus::kCertified) << name << ": " << proof.reason;
    // Elsewhere its rows are a path of lines, and a certificate that speaks of cubics says so.
    const Path lines = readPath(file(name), problem, {.warnings = &warnings});
    EXPECT_TRUE(lines.times.empty() && lines.velocities.empty());
    EXPECT_EQ(warnings.size(), 1U) << name;
    warnings.clear();
  }
  // The cubics of a motion without blends are on the lines of its path, and keep limits as well.
  problem.execution.corners = Corners::kStop;
  for (const char* name : {"stop.json", "stop.csv"}) {
    writeTrajectory(file(name), problem, result, trajectoryOf(problem, result.path));
    std::vector<std::string> warnings;
    const Path read = readPath(file(name), problem, {.cubics = true, .warnings = &warnings});
    EXPECT_EQ(read.velocities.size(), read.positions.size()) << name;
    EXPECT_EQ(verify(problem, read).status, VerifyStatus::kCertified) << name;
    EXPECT_TRUE(warnings.empty()) << name;
    Problem slower = problem;
    for (auto& [joint, jerk] : slower.execution.jerks) jerk = 15;
    const VerifyResult faster = verify(slower, read);
    EXPECT_EQ(faster.status, VerifyStatus::kRefuted) << name;
    EXPECT_NE(faster.reason.find("jerk"), std::string::npos) << faster.reason;
  }
  std::vector<std::string> warnings;
  EXPECT_TRUE(readPath(file("stop.json"), problem, {.warnings = &warnings}).times.empty());
  EXPECT_EQ(warnings.size(), 1U);

  const auto refused = [&](const std::string& rows) {
    std::ofstream(file("bad.json")) << R"({"joint_names": ["joint1", "joint2", "joint3", "joint4",
"joint5", "joint6", "joint7"], "points": [)"
                                    << rows << R"(], "certificate": {"interpolation": "cubic"}})";
    try {
      readPath(file("bad.json"), problem, {.cubics = true});
    } catch (const robots::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto written = [&](const std::string& name, const std::string& text) {
    std::ofstream(file(name)) << text;
    return file(name);
  };
  const std::string zeros = "[0,0,0,0,0,0,0]";
  const std::string first =
      "{\"positions\": " + zeros + ", \"velocities\": " + zeros + ", \"time_from_start\": 1}";
  EXPECT_EQ(refused(first), "");
  EXPECT_NE(refused("{\"positions\": " + zeros + ", \"time_from_start\": 1}").find("velocities"),
            std::string::npos);
  EXPECT_NE(refused("{\"positions\": " + zeros + ", \"velocities\": [0]}")
                .find(":2: 1 velocities; 7 are expected"),
            std::string::npos)
      << refused("{\"positions\": " + zeros + ", \"velocities\": [0]}");
  EXPECT_NE(refused("{\"positions\": " + zeros + ", \"velocities\": " + zeros + "}")
                .find("no time_from_start, which cubics need"),
            std::string::npos);
  EXPECT_NE(refused(first + ",\n" + first).find(":3: the row's time is 1 s, as that of line 2"),
            std::string::npos)
      << refused(first + ",\n" + first);
  // Velocities without a certificate mean cubics. All rows have them, or no row.
  const std::string names = R"({"joint_names": ["joint1", "joint2", "joint3", "joint4", "joint5",
"joint6", "joint7"], "points": [)";
  const std::string last =
      "{\"positions\": " + zeros + ", \"velocities\": " + zeros + ", \"time_from_start\": 2}";
  const std::string bare = "{\"positions\": " + zeros + ", \"time_from_start\": 2}";
  const PathReading cubics{.cubics = true};
  const Path plain =
      readPath(written("plain.json", names + first + ", " + last + "]}"), problem, cubics);
  EXPECT_EQ(plain.times, (std::vector<double>{1, 2}));
  EXPECT_EQ(plain.velocities.size(), 2U);
  robots::expectInputError(
      [&] { readPath(written("part.json", names + first + ",\n" + bare + "]}"), problem, cubics); },
      file("part.json"), 3, {"velocities"});
  EXPECT_TRUE(
      readPath(written("none.json", names + bare + "]}"), problem, cubics).velocities.empty());
  // No other interpolation is taken for lines.
  for (const char* word : {"Cubic", "quintic", "SE(3) geodesic", "5"})
    robots::expectInputError(
        [&] {
          readPath(
              written("word.json",
                      names + bare + "],\n\"certificate\": {\"interpolation\": \"" + word + "\"}}"),
              problem, cubics);
        },
        file("word.json"), 3, {"joint-linear, or cubic for rows", word});
  robots::expectInputError(
      [&] {
        readPath(written("word.json", names + bare + "],\n\"certificate\": \"cubic\"}"), problem,
                 cubics);
      },
      file("word.json"), 3, {"a map is expected"});
  // A table has all velocities and the time, or no velocity.
  std::string heading = "time", velocities, row = "0";
  for (int i = 1; i <= 7; ++i) {
    heading += ",joint" + std::to_string(i);
    velocities += ",joint" + std::to_string(i) + ".velocity";
  }
  for (int i = 0; i < 14; ++i) row += ",0";
  EXPECT_EQ(readPath(written("all.csv", heading + velocities + "\n" + row + "\n"), problem, cubics)
                .times.size(),
            1U);
  const std::string most = velocities.substr(0, velocities.rfind(','));
  robots::expectInputError(
      [&] {
        readPath(written("most.csv", heading + most + "\n" + row.substr(2) + "\n"), problem,
                 cubics);
      },
      file("most.csv"), 1, {"'joint7.velocity' is missing"});
  robots::expectInputError(
      [&] {
        readPath(written("late.csv", heading.substr(5) + velocities + "\n" + row.substr(2) + "\n"),
                 problem, cubics);
      },
      file("late.csv"), 1, {"'time' is missing"});
}

/// Orientations are written with the rate of their four numbers.
TEST_F(PathIo, TrajectoriesOfBodiesHaveTheRatesOfTheirNumbers) {
  const Problem problem = loadProblem(kSource + "/problems/bodies/window.yaml");
  const auto space =
      std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  const std::vector<std::vector<double>> rows = {{0, 0, 1, 0, 0, 0, 1},
                                                 {0.3, 0, 1, 0.6, 0, 0.48, 0.64}};
  const Trajectory trajectory(space, rows, defaultMotionLimits(*space));
  writeTrajectory(file("body.csv"), problem, resultOf(problem, rows), trajectory,
                  trajectory.duration() / 17);
  const double h = 1e-5;
  std::vector<double> before(7), middle(7), after(7);
  int moving = 0;
  for (const std::vector<double>& row : csvRows(readText(file("body.csv")))) {
    ASSERT_EQ(row.size(), 1U + 3 * 7);
    const double time = row[0];
    if (time < 2 * h || time > trajectory.duration() - 2 * h) continue;
    trajectory.configuration(time - h, before);
    trajectory.configuration(time, middle);
    trajectory.configuration(time + h, after);
    const bool smooth = std::abs(std::remainder(time, trajectory.duration() / 17)) <
                        1e-6;  // otherwise a jump within 2 h
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_NEAR(row[8 + i], (after[i] - before[i]) / (2 * h), 1e-4);
      if (smooth) {
        EXPECT_NEAR(row[15 + i], (after[i] - 2 * middle[i] + before[i]) / (h * h), 1e-4);
      }
    }
    moving += smooth;
  }
  EXPECT_GT(moving, 3);
}

/// A waypoint with the negated quaternion: interpolation between the rows would pass through zero.
TEST_F(PathIo, TrajectoriesOfBodiesDoNotChangeTheSignOfOrientations) {
  const Problem problem = loadProblem(kSource + "/problems/bodies/window.yaml");
  const auto space =
      std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  const std::vector<std::vector<double>> rows = {
      {0, 0, 1, 0, 0, 0, 1}, {0.3, 0, 1, -0.6, 0, -0.48, -0.64}, {0.3, 0.2, 1, 0.6, 0, 0.64, 0.48}};
  const Trajectory trajectory(space, rows, defaultMotionLimits(*space));
  writeTrajectory(file("signs.json"), problem, resultOf(problem, rows), trajectory, 0.1);
  const auto json = nlohmann::json::parse(readText(file("signs.json")));
  const auto& points = json.at("points");
  ASSERT_GT(points.size(), 10U);
  for (std::size_t k = 1; k < points.size(); ++k) {
    double product = 0;
    for (std::size_t i = 3; i < 7; ++i)
      product += points[k - 1].at("positions")[i].get<double>() *
                 points[k].at("positions")[i].get<double>();
    EXPECT_GT(product, 0.9) << k;
  }
}

TEST_F(PathIo, TimesThatNoFileCanSayAreRefused) {
  Problem problem = armProblem();
  std::vector<std::vector<double>> rows(2, std::vector<double>(7));
  rows[1][0] = 1;
  const PlanResult result = resultOf(problem, rows);
  const auto space =
      std::make_shared<ConfigurationSpace>(problem.robot.model, problem.robot.variables);
  const auto message = [&](double period) {
    const Trajectory trajectory(space, rows, motionLimits(problem));
    try {
      writeTrajectory(file("t.json"), problem, result, trajectory, period);
    } catch (const robots::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message(0), "");
  EXPECT_NE(message(1e-6).find("the period is 1e-06 s; at least 2e-05 s"), std::string::npos);
  problem.execution.velocities["joint1"] = 1e-9;
  EXPECT_NE(message(2e-5).find("more than 1000000 rows 2e-05 s apart"), std::string::npos);
  EXPECT_EQ(message(0), "");
  problem.execution.speed = 0.1;
  EXPECT_NE(message(0).find("no more than 2147483647 s"), std::string::npos);
  EXPECT_THROW(writePath(file("p.json"), problem, result), robots::InputError);
  EXPECT_THROW(writePath(file("p.csv"), problem, result), robots::InputError);
  EXPECT_NO_THROW(writePath(file("p.path"), problem, result));
}

/// A controller unaware of wrapping must follow the certified way.
TEST_F(PathIo, RowsAreWrittenAndReadAsStraightLines) {
  const Problem problem = loadProblem(kSource + "/problems/bodies/piano.yaml");
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const double pi = 3.14159265358979323846;
  const std::vector<std::vector<double>> rows = {
      {1, 1, 3.0}, {1, 1, -3.0}, {1, 1, -0.5}, {1, 1, 3.1}};
  for (const char* name : {"piano.csv", "piano.json", "piano.yaml", "piano.path"}) {
    writePath(file(name), problem, resultOf(problem, rows));
    EXPECT_TRUE(sameBits(readPath(file(name), problem).positions, rows)) << name;
    EXPECT_TRUE(sameBits(readPath(file(name), problem, {.shortest = true}).positions,
                         unwrapped(space, rows)))
        << name;
  }
  const Path path = readPath(file("piano.csv"), problem, {.shortest = true});
  EXPECT_EQ(path.positions[0][2], 3.0);
  EXPECT_EQ(path.positions[1][2], -3.0 + 2 * pi);
  EXPECT_EQ(path.positions[2][2], -0.5 + 2 * pi);
  EXPECT_EQ(path.positions[3][2], 3.1);
  for (std::size_t i = 1; i < 4; ++i)
    EXPECT_LE(std::abs(path.positions[i][2] - path.positions[i - 1][2]), pi + 1e-12);
  EXPECT_TRUE(sameBits(unwrapped(space, path.positions), path.positions)) << "bit for bit";
}

/// Whole turns are edges of less than half a turn each, and no certifier takes thousands of them.
TEST_F(PathIo, LongTurnsAreEdgesThatGoTheirWay) {
  const Problem problem = loadProblem(kSource + "/problems/bodies/piano.yaml");
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const double pi = 3.14159265358979323846;
  const Path path{{}, {{1, 1, 3.0}, {3, 1, -3.0}, {3, 1, -3.0 + pi}, {3, 2, 40}}, {{"all", 0, 3}}};
  const PathEdges edges = edgesOf(space, path);
  ASSERT_EQ(edges.places.size(), 2U + 1U + 14U);
  ASSERT_EQ(edges.path.positions.size(), edges.places.size() + 1);
  EXPECT_EQ(edges.path.steps[0].last, 17);
  for (std::size_t e = 0; e < edges.places.size(); ++e) {
    const auto &a = edges.path.positions[e], &b = edges.path.positions[e + 1];
    std::vector<double> way(3), from(3), middle(3), expected(3);
    space.difference(a, b, way);
    EXPECT_NEAR(way[2], b[2] - a[2], 1e-13) << "the shorter way is the straight one";
    const PathEdges::Place& place = edges.places[e];
    const auto s = static_cast<std::size_t>(place.segment);
    space.alongLine(path.positions[s], path.positions[s + 1], place.along(0.5), expected);
    space.alongLine(a, b, 0.5, middle);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(middle[i], expected[i], 1e-13);
  }
  EXPECT_THROW(edgesOf(space, {{}, {{1, 1, 0}, {1, 1, 1e6}}}), std::invalid_argument);
  EXPECT_THROW(edgesOf(space, {{}, {{1, 1, 0}, {1, 1}}}), std::invalid_argument);
  writeText(file("far.path"), "1 1 0\n1 1 1e6\n");
  try {
    readPath(file("far.path"), problem);
    ADD_FAILURE();
  } catch (const robots::InputError& error) {
    EXPECT_EQ(error.line(), 2);
    EXPECT_NE(std::string(error.what()).find("more than half a turn, beyond 1000 rad"),
              std::string::npos)
        << error.what();
  }
}

/// An exact half turn follows the certified direction, whatever turns precede it.
TEST_F(PathIo, HalfTurnsAreWrittenAsTheyWereCertified) {
  const Problem problem = loadProblem(kSource + "/problems/bodies/piano.yaml");
  const ConfigurationSpace space(problem.robot.model, problem.robot.variables);
  const double pi = 3.14159265358979323846;
  int cut = 0;
  for (const double last : {-3.0 + pi, 0.0, pi - 3.0, -pi / 2})
    for (const double way : {1.0, -1.0}) {
      std::vector<std::vector<double>> rows = {{1, 1, way * 3.0}, {1, 1, way * -3.0}};
      for (const double x : {way * last, way * (last > 0 ? last - pi : last + pi)})
        rows.push_back({1, 1, x});
      const std::size_t before = rows.size();
      splitHalfTurns(space, rows);
      cut += rows.size() > before;
      writePath(file("turns.csv"), problem, resultOf(problem, unwrapped(space, rows)));
      const Path path = readPath(file("turns.csv"), problem);
      ASSERT_EQ(path.positions.size(), rows.size());
      std::vector<double> certified(3), read(3);
      for (std::size_t i = 1; i < rows.size(); ++i) {
        space.difference(rows[i - 1], rows[i], certified);
        space.difference(path.positions[i - 1], path.positions[i], read);
        EXPECT_NEAR(path.positions[i][2] - path.positions[i - 1][2], certified[2], 1e-9);
        EXPECT_NEAR(read[2], certified[2], 1e-9);
      }
    }
  EXPECT_GT(cut, 0);
}

TEST_F(PathIo, ColumnsAreMatchedByName) {
  const Problem problem = armProblem();
  const Path path =
      readPath(write("path.csv",
                     "joint7,joint1,joint2,joint3, joint4 ,\"joint5\",joint6,finger_joint,time\r\n"
                     "7,1,2,3,4,5,6,0.03,0\r\n\r\n0.7,0.1,0.2,0.3,0.4,0.5,0.6,0.03,1\r\n"),
               problem);
  EXPECT_EQ(path.positions[0], (std::vector<double>{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(path.positions[1], (std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}));
}

/// Regression: a row behind a lone carriage return was part of the comment before it.
TEST_F(PathIo, LinesEndInSeveralWays) {
  const Path path =
      readPath(write("a.csv", "# detour\r7,1,2,3,4,5,6\r\n1,2,3,4,5,6,7\r\r# end\r1,1,1,1,1,1,1\n"),
               armProblem());
  ASSERT_EQ(path.positions.size(), 3U);
  EXPECT_EQ(path.positions[0], (std::vector<double>{7, 1, 2, 3, 4, 5, 6}));
}

/// As other planners write them: in the group's order, with commas or blanks.
TEST_F(PathIo, BareRowsAreRead) {
  const Problem problem = armProblem();
  const std::vector<double> row = {1, 2, 3, 4, 5, 6, 7};
  for (const auto& [name, text] : {std::pair{"a.csv", "1,2,3,4,5,6,7\n1, 2, 3, 4, 5, 6, 7\n"},
                                   std::pair{"a.path", "1,2,3,4,5,6,7\n1 2 3\t4 5 6 7\n"},
                                   std::pair{"a.txt", "1 2 3 4 5 6 7\n1,2,3,4,5,6,7\n"}}) {
    const Path path = readPath(write(name, text), problem);
    EXPECT_EQ(path.positions, (std::vector<std::vector<double>>{row, row})) << name;
  }
}

/// A number that was cut is still a number.
TEST_F(PathIo, ALastLineWithoutItsEndIsTold) {
  const Problem problem = armProblem();
  for (const char* name : {"a.csv", "A.CSV", "a.path", "a.TXT"}) {
    std::vector<std::string> warnings;
    readPath(write(name, "1 2 3 4 5 6 7\n1 2 3 4 5 6 7\n"), problem, {.warnings = &warnings});
    EXPECT_TRUE(warnings.empty()) << name;
    const std::string open = write(name, "1 2 3 4 5 6 7\n1 2 3 4 5 6 7");
    readPath(open, problem, {.warnings = &warnings});
    ASSERT_EQ(warnings.size(), 1U) << name;
    EXPECT_EQ(warnings[0].find(open + ":2: the last line does not end"), 0U) << warnings[0];
  }
}

TEST_F(PathIo, OtherShapesOfTrajectoryAreRead) {
  const Problem problem = armProblem();
  const std::string names =
      "joint_names: [joint1, joint2, joint3, joint4, joint5, joint6, joint7]\n";
  const std::vector<double> row = {1, 2, 3, 4, 5, 6, 7};
  EXPECT_EQ(
      readPath(write("a.yaml",
                     "joint_trajectory:\n  " + names +
                         "  points:\n    - {positions: [1, 2, 3, 4, 5, 6, 7], velocities: []}\n"),
               problem)
          .positions[0],
      row);
  EXPECT_EQ(
      readPath(
          write(
              "b.json",
              R"({"status": "solved", "path": {"joint_names": ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7"],
    "positions": [[1, 2, 3, 4, 5, 6, 7]]}})"),
          problem)
          .positions[0],
      row);
}

/// `ros2 topic echo` ends a message with a line `---`.
TEST_F(PathIo, MessagesMayEndWithTheMarkOfTheNext) {
  const Problem problem = armProblem();
  const std::string message =
      "header: {frame_id: base}\njoint_names: [joint1, joint2, joint3, joint4, joint5, joint6, "
      "joint7]\npoints:\n- positions: [1, 2, 3, 4, 5, 6, 7]\n  velocities: []\n  accelerations: "
      "[]\n  effort: []\n  time_from_start: {sec: 0, nanosec: 0}\n";
  for (const char* end : {"---\n", "---", "--- \n\n", "\n---\r\n"})
    EXPECT_EQ(messageOf(write("echo.yaml", message + end), problem), "accepted") << end;
  EXPECT_NE(messageOf(write("echo.yaml", message + "---\n" + message + "---\n"), problem)
                .find("holds 2 YAML documents or more"),
            std::string::npos);
}

/// Keys that no message has are other questions: rows with `velocity` were joined by lines.
TEST_F(PathIo, UnknownKeysAreRefused) {
  const Problem problem = armProblem();
  const std::string names =
      R"("joint_names": ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7"])";
  const std::string row = R"("positions": [1, 2, 3, 4, 5, 6, 7])";
  const auto message = [&](const std::string& text) {
    return messageOf(write("keys.json", text), problem);
  };
  EXPECT_EQ(message("{" + names + R"(, "points": [{)" + row + "}]}"), "accepted");
  const std::pair<std::string, const char*> texts[] = {
      {"{" + names + R"(, "points": [{)" + row + R"(, "velocity": [1, 1, 1, 1, 1, 1, 1]}]})",
       "unknown key 'velocity'"},
      {"{" + names + R"(, "points": [{)" + row + R"(, "Velocities": []}]})",
       "unknown key 'Velocities'"},
      {"{" + names + R"(, "relative": true, "points": [{)" + row + "}]}", "unknown key 'relative'"},
      {"{" + names + R"(, "positions": [[1, 2, 3, 4, 5, 6, 7]], "velocities": [[]]})",
       "unknown key 'velocities'"},
      {R"({"path": {)" + names + R"(, "positions": [[1, 2, 3, 4, 5, 6, 7]], "times": [0]}})",
       "unknown key 'times'"},
      {R"({"certificat": {}, "joint_trajectory": {)" + names + R"(, "points": [{)" + row + "}]}}",
       "unknown key 'certificat'"},
      {"{" + names + R"(, "points": [{)" + row + R"(}], "certificate": {"interpolated": "cubic"}})",
       "unknown key 'interpolated'"},
      {"{" + names + R"(, "points": [{)" + row +
           R"(}], "steps": [{"name": "a", "first": 0, "last": 0, "place": [1]}]})",
       "unknown key 'place'"}};
  for (const auto& [text, key] : texts)
    EXPECT_NE(message(text).find(key), std::string::npos) << text << "\n" << message(text);
}

/// A controller that gets accelerations goes on quintics, which may leave the cubics that are
/// proven: y = 1.25 at t = 0.5 in the first case, where the cubic stays at 0.
TEST_F(PathIo, AccelerationsThatCubicsDoNotHaveAreNamed) {
  const Problem problem = armProblem();
  const auto named = [&](double acceleration) {
    const std::string zeros = "[0, 0, 0, -1, 0, 1, 0]", rest = "[0, 0, 0, 0, 0, 0, 0]";
    const auto point = [&](int time, double second) {
      return "{\"positions\": " + zeros + ", \"velocities\": " + rest +
             ", \"accelerations\": [0, " + std::to_string(second) +
             ", 0, 0, 0, 0, 0], \"time_from_start\": " + std::to_string(time) + "}";
    };
    std::vector<std::string> warnings;
    readPath(write("a.json", R"({"joint_names": ["joint1", "joint2", "joint3", "joint4",
"joint5", "joint6", "joint7"], "points": [)" +
                                 point(0, 0) + ",\n" + point(1, acceleration) + "]}"),
             problem, {.cubics = true, .warnings = &warnings});
    return warnings;
  };
  EXPECT_TRUE(named(0).empty());
  const std::vector<std::string> warnings = named(40);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("a.json:3: with these accelerations"), std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[0].find("0.69 rad or m at 'joint2'"), std::string::npos) << warnings[0];
}

TEST_F(PathIo, AccelerationsWithoutVelocitiesAreTold) {
  const Problem problem = armProblem();
  const std::string names = "joint1,joint2,joint3,joint4,joint5,joint6,joint7";
  const auto told = [&](const std::string& name, const std::string& text) {
    std::vector<std::string> warnings;
    readPath(write(name, text), problem, {.warnings = &warnings});
    return warnings;
  };
  const auto json = [&](const std::string& second) {
    const std::string zeros = "{\"positions\": [0, 0, 0, -1, 0, 1, 0]";
    return R"({"joint_names": ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6",
"joint7"], "points": [)" +
           zeros + "},\n" + zeros + second + "}]}";
  };
  const std::vector<std::string> warnings =
      told("a.json", json(R"(, "accelerations": [0, 1, 0, 0, 0, 0, 0])"));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("a.json:3: accelerations without velocities are not read"),
            std::string::npos)
      << warnings[0];
  EXPECT_TRUE(told("b.json", json(R"(, "accelerations": [])")).empty());
  EXPECT_EQ(told("c.csv", "time," + names + ",joint2.acceleration\n0,0,0,0,-1,0,1,0,2\n").size(),
            1U);
}

/// A column with a joint's name is that joint's, although it also names another one's velocity.
TEST_F(PathIo, AJointMayBeCalledVelocity) {
  const std::string joint = R"(<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>)";
  const std::string urdf = write("v.urdf",
                                 R"(<robot name="v"><link name="x"/><link name="y"/><link name="z"/>
<joint name="a" type="revolute"><parent link="x"/><child link="y"/>)" +
                                     joint +
                                     R"(<joint name="a.velocity" type="revolute"><parent link="y"/>
<child link="z"/>)" + joint + "</robot>");
  const Problem problem =
      problemFromStates(robots::loadModel(urdf, ""), "all", "0.5 0.25", "-0.5 0");
  const Path path = readPath(write("v.csv", "time,a,a.velocity\n0,0.5,0.25\n1,-0.5,0\n"), problem,
                             {.cubics = true});
  EXPECT_EQ(path.positions, (std::vector<std::vector<double>>{{0.5, 0.25}, {-0.5, 0}}));
  EXPECT_TRUE(path.velocities.empty());
}

/// Recorded states have the joints that follow others, and logs have comments.
TEST_F(PathIo, ColumnsOfFollowersAreCheckedAndCommentsPassedOver) {
  const std::string robot =
      write("grip.urdf",
            "<robot name=\"grip\"><link name=\"palm\"/><link name=\"a\"/><link name=\"b\"/>"
            "<joint name=\"left\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"a\"/>"
            "<limit lower=\"0\" upper=\"1\" velocity=\"1\" effort=\"1\"/></joint>"
            "<joint name=\"right\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"b\"/>"
            "<limit lower=\"-3\" upper=\"3\" velocity=\"9\" effort=\"1\"/>"
            "<mimic joint=\"left\" multiplier=\"-2\" offset=\"0.5\"/></joint></robot>");
  const Problem problem = loadProblem(
      write("grip.yaml", "leeway: 1\nrobot: {urdf: grip.urdf}\nstart: [0.1]\ngoal: [0.2]\n"));
  const auto message = [&](const std::string& text) {
    return messageOf(write("grip.csv", text), problem);
  };
  EXPECT_EQ(message("# recorded\nleft,right\n0.125,0.25\n # half way\n0.25,0\n"), "accepted");
  EXPECT_EQ(message("left,right\n0.125,0.25\n0.25,0.2\n"),
            file("grip.csv") + ":3: joint 'right' is at 0.2, but follows 'left'; 0 is expected");
  EXPECT_NE(message("left,wrong\n0.1,0.3\n").find("unknown joint 'wrong'"), std::string::npos);
}

TEST_F(PathIo, RowsOfACsvMayHaveBlanks) {
  const Problem problem = armProblem();
  const std::vector<std::vector<double>> rows = {{1, 2, 3, 4, 5, 6, 7}, {2, 2, 3, 4, 5, 6, 7}};
  EXPECT_EQ(readPath(write("blanks.csv", "1 2  3 4 5 6 7\n2\t2 3 4 5 6 7 \n"), problem).positions,
            rows);
}

TEST_F(PathIo, MessagesOfBadFiles) {
  const Problem problem = armProblem();
  const std::string header = "time,joint1,joint2,joint3,joint4,joint5,joint6,joint7\n";
  const auto expect = [&](const std::string& path, const std::string& expected) {
    const std::string message = messageOf(path, problem);
    EXPECT_EQ(message.substr(0, path.size() + expected.size()), path + expected);
  };
  expect(file("absent.csv"), ": there is no such file; a path file is expected");
  expect(file("absent.json"), ": there is no such file; a YAML or JSON file is expected");
  expect(write("a.doc", ""),
         ": the ending '.doc' names no format; .json, .yaml, .csv, .path or .txt is expected");
  expect(write("a.csv", ""),
         ": is empty; a header of joint names and rows, or rows alone, are expected");
  expect(write("b.csv", header), ": holds no waypoint; at least one is expected");
  expect(write("c.csv", header + "0,1,2,3,4,5,6\n"), ":2: a row of 7 numbers; 8 are expected");
  for (const std::string line : {"joint1;joint2", "1;2"})
    expect(
        write("semicolons.csv", line + "\n1;2\n"),
        ":1: '" + line + "' has no comma; names or numbers with commas between them are expected");
  expect(write("d.csv", header + "0,1,2,3,4,x,6,7\n"),
         ":2: 'x' stands where a finite number is expected");
  expect(write("e.csv", header + "0,1,2,3,4,nan,6,7\n"),
         ":2: 'nan' stands where a finite number is expected");
  expect(write("f.csv", "time,joint1,joint2,joint3,joint4,joint5,joint6\n0,1,2,3,4,5,6\n"),
         ":1: planned joint 'joint7' is missing; a column for each planned joint is expected");
  expect(write("g.csv", "joint1,joint2,joint3,joint4,joint5,joint6,joint8\n"),
         ":1: unknown joint 'joint8'; did you mean 'joint1'?");
  expect(write("h.csv", "joint1,joint1\n1,1\n"),
         ":1: joint 'joint1' stands twice; once is expected");
  expect(
      write("i.csv",
            "joint1,joint2,joint3,joint4,joint5,joint6,joint7,finger_joint\n1,2,3,4,5,6,7,0.05\n"),
      ":2: joint 'finger_joint' is at 0.05, but not planned; the problem's 0.03 is expected");
  expect(write("j.csv", "time,\"joint1\n"),
         ":1: a quoted field has no end; a closing quote is expected");
  expect(write("a.path", "1 2 3\n"), ":1: a row of 3 numbers; 7 are expected");
  expect(write("b.path", "\n"), ": holds no waypoint; at least one is expected");
  expect(write("a.json", "{\"joint_names\": []}"),
         ":1: key 'points' is missing in the file; a list of waypoints is expected");
  expect(write("b.json", "[1]"),
         ":1: is no map; joint_names and points (trajectory_msgs/JointTrajectory) are expected");
  // If a file has two paths, or a key has two values, another reader may take the other one.
  const std::string row = "[{positions: [1, 2, 3, 4, 5, 6, 7]}]";
  const std::string names =
      "joint_names: [joint1, joint2, joint3, joint4, joint5, joint6, joint7]\n";
  expect(write("c.yaml", names + "points: " + row + "\npoints: " + row + "\n"),
         ":3: key 'points' stands twice in the file, first for line 2; once is expected");
  expect(write("d.yaml", names + "points: [{positions: [1], positions: [2]}]\n"),
         ":2: key 'positions' stands twice in points[0], first for line 2; once is expected");
  expect(write("e.yaml", names + "points: " + row + "\npositions: [[1, 2, 3, 4, 5, 6, 7]]\n"),
         ":2: 'positions' and 'points' each give a path; one of them is expected");
  expect(write("f.yaml", names + "points: " + row + "\njoint_trajectory: {}\n"),
         ":2: 'joint_trajectory' and 'points' each give a path; one of them is expected");
  expect(write("g.yaml", "path: {" + names + "}\n" + names + "points: " + row + "\n"),
         ":4: 'path' and 'points' each give a path; one of them is expected");
  const std::string body = write("c.path", "0 0 1 0 0 0 2\n");
  EXPECT_EQ(messageOf(body, bodyProblem()),
            body + ":1: a quaternion of length 2; unit length is expected");
}

TEST_F(PathIo, UnwritableOutputIsAnInputErrorAndLeavesNothing) {
  const Problem problem = armProblem();
  const PlanResult result = resultOf(problem, armRows());
  const auto messageOfWriting = [&](const std::string& path) -> std::string {
    try {
      writePath(path, problem, result);
    } catch (const robots::InputError& error) {
      return error.what();
    }
    return "written";
  };
  EXPECT_EQ(messageOfWriting(file("no/such/folder.json")),
            file("no/such/folder.json") +
                ": cannot be written: No such file or directory; a writable path is expected");
  std::filesystem::create_directory(file("folder.json"));
  EXPECT_EQ(
      messageOfWriting(file("folder.json")),
      file("folder.json") + ": cannot be written: Is a directory; a writable path is expected");
  EXPECT_EQ(messageOfWriting(file("path.xml")),
            file("path.xml") +
                ": the ending '.xml' names no format; .json, .yaml, .csv or .path is expected");
  EXPECT_EQ(fileCount(), 1U);
}

/// Neither an invalid row nor a full disk changes the existing file.
TEST_F(PathIo, AnExistingFileSurvivesAFailedWrite) {
  const Problem problem = armProblem();
  write("path.json", "precious");
  PlanResult result = resultOf(problem, armRows());
  result.path.positions[1].pop_back();
  EXPECT_THROW(writePath(file("path.json"), problem, result), std::invalid_argument);
  EXPECT_EQ(readText(file("path.json")), "precious");
  // The disk is full after 16 bytes.
  result = resultOf(problem, armRows());
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  struct rlimit small = before;
  small.rlim_cur = 16;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(writePath(file("path.json"), problem, result), robots::InputError);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(readText(file("path.json")), "precious");
  EXPECT_EQ(fileCount(), 1U);
}

TEST_F(PathIo, ALinkStaysAndItsFileIsReplaced) {
  write("old.txt", "old");
  std::filesystem::create_symlink("old.txt", file("link.txt"));
  std::filesystem::create_symlink("fresh.txt", file("dangling.txt"));
  writeFileWhole(file("link.txt"), "new");
  writeFileWhole(file("dangling.txt"), "first");
  EXPECT_TRUE(std::filesystem::is_symlink(file("link.txt")));
  EXPECT_TRUE(std::filesystem::is_symlink(file("dangling.txt")));
  EXPECT_EQ(readText(file("old.txt")), "new");
  EXPECT_EQ(readText(file("fresh.txt")), "first");
}

TEST_F(PathIo, APipeIsWrittenToAndStays) {
  ASSERT_EQ(::mkfifo(file("pipe.json").c_str(), 0600), 0);
  const int end = ::open(file("pipe.json").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(end, 0);
  writeFileWhole(file("pipe.json"), "through");
  char text[16] = {};
  EXPECT_EQ(::read(end, text, sizeof text), 7);
  EXPECT_STREQ(text, "through");
  ::close(end);
  EXPECT_TRUE(std::filesystem::is_fifo(file("pipe.json")));
}

TEST_F(PathIo, AReplacedFileKeepsItsModeAndANewOneTheUsers) {
  const std::string path = write("a.txt", "old");
  std::filesystem::permissions(
      path, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  writeFileWhole(path, "new");
  EXPECT_EQ(readText(path), "new");
  EXPECT_EQ(std::filesystem::status(path).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  write("plain.txt", "");
  writeFileWhole(file("fresh.txt"), "x");
  EXPECT_EQ(std::filesystem::status(file("fresh.txt")).permissions(),
            std::filesystem::status(file("plain.txt")).permissions());
}

}  // namespace
}  // namespace leeway::planner
