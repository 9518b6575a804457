// Height fields: the solid that they are, beside a union of prisms, and what is refused.

#include "leeway/planner/height_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "leeway/collision/distance.h"
#include "leeway/collision/invalid_shape.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/verify.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/png.h"

namespace leeway::planner {
namespace {

using collision::Shape;
using Eigen::Vector3d;

HeightField randomField(std::mt19937& random, std::size_t columns, std::size_t rows) {
  std::uniform_real_distribution<double> unit(0, 1);
  HeightField field{columns, rows, {}, 0.05 + 0.2 * unit(random), 0.05 + 0.2 * unit(random), -0.3};
  if (unit(random) < 0.3) field.step_x *= -1;
  if (unit(random) < 0.3) field.step_y *= -1;
  // Flat stretches as well, as grounds have them.
  const double steps = unit(random) < 0.5 ? 4 : 1e6;
  for (std::size_t i = 0; i < columns * rows; ++i)
    field.heights.push_back(0.3 * std::round(steps * unit(random)) / steps - 0.1);
  return field;
}

/// The two prisms of each cell: convex, and their union is the field's solid.
std::vector<Shape> prismsOf(const HeightField& field) {
  std::vector<Shape> prisms;
  const auto corner = [&](std::size_t c, std::size_t r) {
    return Vector3d(static_cast<double>(c) * field.step_x, static_cast<double>(r) * field.step_y,
                    field.heights[r * field.columns + c]);
  };
  for (std::size_t r = 0; r + 1 < field.rows; ++r)
    for (std::size_t c = 0; c + 1 < field.columns; ++c)
      for (const Vector3d& third : {corner(c + 1, r), corner(c, r + 1)}) {
        std::vector<Vector3d> points = {corner(c, r), corner(c + 1, r + 1), third};
        for (std::size_t k = 0; k < 3; ++k)
          points.emplace_back(points[k].x(), points[k].y(), field.floor);
        prisms.push_back(Shape::convexHull(points));
      }
  return prisms;
}

TEST(HeightField, IsTheUnionOfPrismsUnderItsTriangles) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  collision::Scratch scratch;
  int apart = 0, touching = 0, inside = 0;
  for (const auto& [columns, rows] : {std::pair{2U, 2U}, {2U, 7U}, {5U, 2U}, {6U, 5U}, {9U, 8U}}) {
    const HeightField field = randomField(random, columns, rows);
    const Shape shape = heightFieldShape(field);
    const std::vector<Shape> prisms = prismsOf(field);
    EXPECT_EQ(shape.mesh()->closedComponentCount(), 1);
    EXPECT_EQ(shape.mesh()->componentCount(), 1);
    EXPECT_EQ(shape.mesh()->openEdgeCount(), 0U);
    for (int i = 0; i < 400; ++i) {
      const Vector3d size(field.step_x * columns, field.step_y * rows, 1);
      const Vector3d p((1.4 * unit(random) - 0.3) * size.x(), (1.4 * unit(random) - 0.3) * size.y(),
                       unit(random) - 0.5);
      const Shape ball = Shape::sphere(0.001 + 0.05 * unit(random));
      const collision::Pose X_WB{Eigen::Matrix3d::Identity(), p};
      collision::DistanceRequest request;
      request.depth = false;
      const auto of_field = collision::distance(shape, {}, ball, X_WB, request, scratch).distance;
      double lower = std::numeric_limits<double>::infinity(), upper = lower;
      for (const Shape& prism : prisms) {
        const auto of_prism = collision::distance(prism, {}, ball, X_WB, request, scratch).distance;
        lower = std::min(lower, of_prism.lower);
        upper = std::min(upper, of_prism.upper);
      }
      if (upper <= 0) {
        EXPECT_LE(of_field.upper, 0);
        ++(upper < -0.02 ? inside : touching);
        continue;
      }
      EXPECT_LE(of_field.lower, upper);
      EXPECT_GE(of_field.upper, lower);
      EXPECT_LT(of_field.upper - of_field.lower, 1e-6);
      ++apart;
    }
  }
  EXPECT_GT(apart, 500);
  EXPECT_GT(touching + inside, 200);
}

TEST(HeightField, ABallInTheMiddleOfTheGroundIsInContact) {
  HeightField field{4, 4, std::vector<double>(16, 1.0), 1, -1, -5};
  const Shape shape = heightFieldShape(field);
  collision::Scratch scratch;
  const auto at = [&](const Vector3d& p) {
    return collision::distance(shape, {}, Shape::sphere(0.1), {Eigen::Matrix3d::Identity(), p}, {},
                               scratch)
        .distance;
  };
  EXPECT_LT(at({1.3, -1.6, -2}).upper, -1);  // far from every surface
  EXPECT_NEAR(at({1.3, -1.6, 1.3}).lower, 0.2, 1e-6);
  EXPECT_NEAR(at({1.3, -1.6, -5.3}).lower, 0.2, 1e-6);
  EXPECT_NEAR(at({1.3, 0.5, 0}).lower, 0.4, 1e-6);  // rows go towards -y
}

TEST(HeightField, WhatIsNotAcceptedIsNamed) {
  const auto refused = [](HeightField field) {
    try {
      heightFieldShape(field);
    } catch (const collision::InvalidShape& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const HeightField good{2, 3, {1, 2, 3, 4, 5, 6}, 0.1, 0.1, 0};
  EXPECT_EQ(refused(good), "");
  const auto expect = [&](const auto& change, const std::string& words) {
    HeightField field = good;
    change(field);
    EXPECT_NE(refused(field).find(words), std::string::npos) << refused(field);
  };
  expect([](HeightField& f) { f.columns = 1; }, "1 columns and 3 rows; at least 2 of each");
  expect([](HeightField& f) { f.rows = 1; }, "at least 2 of each");
  expect([](HeightField& f) { f.rows = f.columns = std::size_t{1} << 33U; }, "1048576 samples");
  expect([](HeightField& f) { f.heights.pop_back(); }, "5 heights for 2 columns and 3 rows; 6");
  for (const double step : {0.0, double(NAN), 1e-10, 1e9}) {
    expect([&](HeightField& f) { f.step_x = step; }, "m apart in x");
    expect([&](HeightField& f) { f.step_y = -step; }, "m apart in y");
  }
  expect([](HeightField& f) { f.floor = double(NAN); }, "floor nan");
  expect([](HeightField& f) { f.floor = 1; }, "row 0, column 0 is 1; numbers above the floor, 1");
  expect([](HeightField& f) { f.heights[3] = double(NAN); }, "row 1, column 1 is nan");
  expect([](HeightField& f) { f.heights[5] = 2e9; }, "row 2, column 1 is 2");
}

class HeightFiles : public testing::Test {
 protected:
  HeightField load(const std::string& name, const std::string& contents, const HeightFile& file) {
    return loadHeightField(folder_.write(name, contents), file, warnings_);
  }
  void expectError(const std::string& name, const std::string& contents, int line,
                   std::initializer_list<std::string> words, const HeightFile& file = {}) {
    SCOPED_TRACE(name + ": " + contents);
    const std::string path = folder_.write(name, contents);
    robots::expectInputError([&] { loadHeightField(path, file, warnings_); }, path, line, words);
  }
  Folder folder_;
  std::vector<std::string> warnings_;
};

TEST_F(HeightFiles, AllFormatsHoldTheSameHeights) {
  const std::vector<std::uint16_t> values = {1, 2, 3, 40, 50, 60};
  const std::vector<double> heights = {-0.75, -0.5, -0.25, 9, 11.5, 14};
  const HeightFile file{0.25, -1, {}};
  const std::string forms[][2] = {{"a.csv", "1,2,3\n40, 50,60\n"},
                                  {"a.csv", "# x\n1;2;3\r\n\r\n40;50;60\n"},
                                  {"a.txt", "1 2 3\n 40\t50 60\n"},
                                  {"a.txt", "1\t2\t3\n\n 40\t50 \t60\n \n"},
                                  {"a.pgm", "P2 3 2 65535 1 2 3 40 50 60\n"},
                                  {"a.pgm", std::string("P5 3 2 255 \1\2\3\x28\x32\x3C", 17)},
                                  {"a.png", PngWriter{3, 2, 8}.write(values)},
                                  {"a.png", PngWriter{3, 2, 16}.write(values)}};
  for (const auto& [name, contents] : forms) {
    const HeightField field = load(name, contents, file);
    EXPECT_EQ(field.columns, 3U) << name;
    EXPECT_EQ(field.rows, 2U) << name;
    EXPECT_EQ(field.heights, heights) << name;
  }
  EXPECT_TRUE(warnings_.empty());
  EXPECT_EQ(load("a.csv", "1.5,2\n3,-4e-1", {}).heights, (std::vector<double>{1.5, 2, 3, -0.4}));
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("a.csv:2: the last line does not end"), std::string::npos);
}

TEST_F(HeightFiles, MissingHeightsAreNamedOrFilled) {
  expectError("a.csv", "1,2\n3,nan\n", 2, {"column 1 is missing", "'missing'"});
  expectError("a.csv", "1,2\n,3\n", 2, {"column 0 is missing"});
  // Cells between tabs stay where they are.
  expectError("a.txt", "1\t\t2\n3\t\t4\n", 1, {"column 1 is missing"});
  expectError("a.txt", "1\t2\n\t4\n", 2, {"column 0 is missing"});
  expectError("a.txt", "1\t2\n3\t\n", 2, {"column 1 is missing"});
  expectError("a.txt", "1\t2\n\t\n3\t4\n", 2, {"column 0 is missing"});
  EXPECT_EQ(load("a.txt", "\t1\n2\t\n", {1, 0, -7}).heights, (std::vector<double>{-7, 1, 2, -7}));
  warnings_.clear();
  const HeightField field = load("a.csv", "1,,2\n3,nan,4\n", {2, 1, -7});
  EXPECT_EQ(field.heights, (std::vector<double>{3, -7, 5, 7, -7, 9}));
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_NE(warnings_[0].find("2 heights are missing and taken as -7 m"), std::string::npos);
}

/// A line of a form feed alone was a row without columns.
TEST_F(HeightFiles, LinesOfWhiteSpaceAreNoRows) {
  const HeightField one = load("one.csv", "\n\f\r2\n", {});
  EXPECT_EQ(one.columns * one.rows, 1U);
  EXPECT_EQ(one.heights, std::vector<double>{2});
  const HeightField four = load("four.csv", "\v\n1,2\n\f\r\n3,4\n", {});
  EXPECT_EQ(four.columns, 2U);
  EXPECT_EQ(four.rows, 2U);
  EXPECT_EQ(four.heights, (std::vector<double>{1, 2, 3, 4}));
}

TEST_F(HeightFiles, BadFilesNameTheLine) {
  expectError("a.csv", "1,2\n3,4,5\n", 2, {"3 columns; 2"});
  expectError("a.csv", "1,2\n3,x\n", 2, {"'x'"});
  expectError("a.csv", "1,inf\n", 1, {"infinite"});
  expectError("a.csv", "1,1e400\n", 1, {"too large"});
  expectError("a.csv", "\n# nothing\n", 0, {"holds no height"});
  expectError("a.csv", std::string("1,2\0", 4), 0, {"byte 3", "value 0"});
  expectError("a.stl", "1 2", 0, {"'.stl'", ".csv, .txt, .png and .pgm"});
  expectError("a.csv", "version https://git-lfs.github.com/spec/v1\n", 0, {"Git LFS"});
  expectError("a.pgm", "P2 2 2 9 1 2 3", 1, {"ends where pixel 3"}, {1, 0, {}});
  EXPECT_THROW(load("a.pgm", "P2 1 1 9 1", {}), std::invalid_argument);
  EXPECT_THROW(load("a.pgm", "P2 1 1 9 1", {1, 0, 0.5}), std::invalid_argument);
}

// Problem files.

const std::string kBallOverGround =
    "leeway: 1\n"
    "body:\n"
    "  name: ball\n"
    "  joint: floating\n"
    "  bounds: {lower: [-1, -1, 0], upper: [1, 1, 0.6]}\n"
    "  shapes: [{sphere: {radius: 0.1}}]\n"
    "start: {position: [-0.8, 0, 0.3]}\n"
    "goal: {position: [0.8, 0, 0.3]}\n"
    "margin: 0.01\n"
    "objects:\n - name: ground\n   position: [-1, -1, 0]\n   height_field: ";

TEST_F(HeightFiles, AProblemIsPlannedOverAGroundAndVerified) {
  // A ridge across, 0.5 m high, with a saddle of 0.1 m.
  std::string text;
  for (int r = 0; r <= 40; ++r)
    for (int c = 0; c <= 40; ++c) {
      const double x = c / 20.0 - 1, y = r / 20.0 - 1;
      const double ridge = std::abs(y - 0.5) < 0.2 ? 0.1 : 0.8;
      text += std::to_string(std::abs(x) < 0.21 ? ridge : 0.02 * std::sin(9 * x)) +
              (c < 40 ? "," : "\n");
    }
  folder_.write("ground.csv", text);
  const Problem problem = loadProblem(folder_.write(
      "problem.yaml",
      kBallOverGround + "{file: ground.csv, step: 0.05, floor: -0.2}\nlimits: {time: 60}\n"));
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  const VerifyResult verified = verify(problem, result.path);
  EXPECT_EQ(verified.status, VerifyStatus::kCertified) << verified.reason;
  EXPECT_GE(verified.clearance_lower, 0.01);
  Path straight = result.path;
  straight.positions = {result.path.positions.front(), result.path.positions.back()};
  const VerifyResult through = verify(problem, straight);
  EXPECT_EQ(through.status, VerifyStatus::kRefuted);
  EXPECT_EQ(through.b, "ground");
  // A start in the middle of the ridge.
  Problem buried = problem;
  buried.start[0] = 0;
  EXPECT_EQ(plan(buried).status, PlanStatus::kInvalidStart);
}

TEST_F(HeightFiles, BadKeysNameTheirLine) {
  folder_.write("h.csv", "1,2\n3,4\n");
  folder_.write("h.pgm", "P2 2 2 9 1 2 3 4\n");
  const auto expect = [&](const std::string& keys, std::initializer_list<std::string> words,
                          int line = 13) {
    SCOPED_TRACE(keys);
    const std::string path = folder_.write("problem.yaml", kBallOverGround + keys + "\n");
    robots::expectInputError([&] { loadProblem(path); }, path, line, words);
  };
  expect("{step: 1, floor: 0}", {"'file'"});
  expect("{file: h.csv, floor: 0}", {"'step'"});
  expect("{file: h.csv, step: 1}", {"'floor'"});
  expect("{file: h.csv, step: [1, 1, 1], floor: 0}", {"list of 3"});
  expect("{file: h.csv, step: 0, floor: 0}", {"height_field", "m apart in x"});
  expect("{file: h.csv, step: 1, floor: 2}", {"row 0, column 0 is 1", "the floor, 2"});
  expect("{file: h.csv, step: 1, floor: 0, flor: 1}", {"'flor'", "'floor'"});
  expect("{file: h.pgm, step: 1, floor: 0}", {"without a scale"});
  expect("{file: h.pgm, step: 1, floor: 0, scale: 1, missing: 1}", {"'missing'"});
  expect("{file: h.csv, step: 1, floor: 0}\n   box: {size: [1, 1, 1]}",
         {"both 'box' and 'height_field'"}, 11);
}

}  // namespace
}  // namespace leeway::planner
