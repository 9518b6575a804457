// Depth images: what their balls cover, and what is refused.

#include "leeway/planner/depth_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "collision/base/numbers.h"
#include "leeway/collision/distance.h"
#include "leeway/planner/plan.h"
#include "leeway/planner/problem.h"
#include "leeway/planner/save_problem.h"
#include "leeway/planner/verify.h"
#include "planner/save/problem_text.h"
#include "tests/support/folder.h"
#include "tests/support/input_errors.h"
#include "tests/support/png.h"

namespace leeway::planner {
namespace {

using Eigen::Vector3d;
using Number = DepthImage::Number;

DepthImage imageOf(const std::vector<double>& depths, std::size_t width) {
  return {depths.data(), width, depths.size() / width, 8 * width, Number::kDouble};
}

Vector3d rayAt(const DepthCamera& camera, double column, double row) {
  return {(column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy, 1};
}

/// Planes in front of random cameras. Brute force looks at many points of what each pixel shows.
TEST(DepthImage, BallsCoverSurfacesUpToTheSlant) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  double fullest = 0;
  int seen = 0;
  for (int round = 0; round < 300; ++round) {
    DepthCamera camera{3 + 200 * unit(random), 3 + 200 * unit(random), 12 * unit(random) - 2,
                       8 * unit(random) - 2};
    camera.slant = 1.35 * unit(random);
    try {
      depthSpread(camera);
    } catch (const std::invalid_argument&) {
      continue;  // wide pixels
    }
    constexpr std::size_t kWidth = 8, kHeight = 5;
    const Vector3d normal =
        Vector3d(unit(random) - 0.5, unit(random) - 0.5, -0.7 * unit(random)).normalized();
    const double offset = normal.z() * (0.2 + 3 * unit(random));
    const auto depthOf = [&](const Vector3d& ray) { return offset / normal.dot(ray); };
    std::vector<double> depths;
    for (std::size_t r = 0; r < kHeight; ++r)
      for (std::size_t c = 0; c < kWidth; ++c) {
        const Vector3d ray = rayAt(camera, static_cast<double>(c), static_cast<double>(r));
        const double slant = std::acos(std::abs(normal.dot(ray)) / ray.norm());
        // More slanted surfaces are not promised to be covered: leave them out.
        const double depth = depthOf(ray);
        depths.push_back(slant <= camera.slant && depth > 0 && depth < 100 ? depth : 0);
      }
    const PointCloud cloud = makeCloud(imageOf(depths, kWidth), camera, 1e-9);
    std::size_t b = 0;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      if (depths[i] == 0) continue;
      const PointCloud::Ball& ball = cloud.balls.at(b++);
      ++seen;
      for (int k = 0; k < 40; ++k) {
        // Corners first.
        const double dc = k < 4 ? k % 2 - 0.5 : unit(random) - 0.5;
        const double dr = k < 4 ? k / 2 - 0.5 : unit(random) - 0.5;
        const Vector3d ray = rayAt(camera, static_cast<double>(i % kWidth) + dc,
                                   static_cast<double>(i / kWidth) + dr);
        const double share = (ray * depthOf(ray) - ball.center).norm() / ball.radius;
        ASSERT_GT(depthOf(ray), 0);
        ASSERT_LE(share, 1) << "row " << i / kWidth << ", column " << i % kWidth;
        fullest = std::max(fullest, share);
      }
    }
    EXPECT_EQ(b, cloud.size());
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(fullest, 0.9);  // the radius is not much larger than needed
}

TEST(DepthImage, ThePixelsOfAllTypesBecomeTheSamePoints) {
  const std::uint16_t millimetres[] = {1000, 0, 2500, 65535, 7, 7};  // two of the last row's end
  const float metres_f[] = {1, NAN, 2.5F, 65.535F};
  const double metres_d[] = {1, double(INFINITY), 2.5, 65.535};
  const DepthCamera camera{500, 400, 0.5, 0.25};
  const PointCloud a = makeCloud({millimetres, 2, 2, 4, Number::kUint16}, camera, 0.01);
  const PointCloud b = makeCloud({metres_f, 2, 2, 8, Number::kFloat}, camera, 0.01);
  const PointCloud c = makeCloud({metres_d, 2, 2, 16, Number::kDouble}, camera, 0.01);
  ASSERT_EQ(a.size(), 3U);
  ASSERT_EQ(b.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR((a.balls[i].center - c.balls[i].center).norm(), 0, 1e-12);
    EXPECT_NEAR((b.balls[i].center - c.balls[i].center).norm(), 0, 1e-5);
    EXPECT_NEAR(a.balls[i].radius, 0.01 + a.balls[i].center.z() * depthSpread(camera), 1e-9);
  }
  EXPECT_NEAR(a.balls[1].center.x(), 2.5 * -0.5 / 500, 1e-12);
  EXPECT_NEAR(a.balls[1].center.y(), 2.5 * 0.75 / 400, 1e-12);
  ASSERT_EQ(a.filters.size(), 1U);
  EXPECT_EQ(a.filters[0].name, "drop");
  EXPECT_EQ(a.filters[0].removed, 1U);
  // Rows may be longer than the picture, and begin at any byte.
  std::vector<std::byte> odd(1 + 2 * 7);
  std::memcpy(odd.data() + 1, millimetres, 4);
  std::memcpy(odd.data() + 8, millimetres + 2, 4);
  const PointCloud d = makeCloud({odd.data() + 1, 2, 2, 7, Number::kUint16}, camera, 0.01);
  ASSERT_EQ(d.size(), 3U);
  EXPECT_EQ(d.balls[2].center, a.balls[2].center);
  // 0: rows without a gap. Rows that overlap are refused.
  const PointCloud e = makeCloud({millimetres, 2, 2, 0, Number::kUint16}, camera, 0.01);
  ASSERT_EQ(e.size(), 3U);
  EXPECT_EQ(e.balls[2].center, a.balls[2].center);
  EXPECT_THROW(makeCloud({millimetres, 2, 2, 3, Number::kUint16}, camera, 0.01),
               std::invalid_argument);
  EXPECT_THROW(makeCloud({metres_d, 2, 2, 8, Number::kDouble}, camera, 0.01),
               std::invalid_argument);
  EXPECT_THROW(makeCloud({nullptr, 2, 2, 0, Number::kUint16}, camera, 0.01), std::invalid_argument);
  // The half diagonal of a pixel at 1 m, at 60 degrees.
  const double half = std::hypot(1.0 / 500, 1.0 / 400) / 2;
  EXPECT_NEAR(depthSpread(camera), half / (0.5 - half), 1e-12);
}

/// Points of each pixel's middle ray: those that the camera did not see are in a part, and with
/// parts enough no other.
TEST(DepthImage, UnseenSpaceContainsWhatWasNotSeen) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr std::size_t kWidth = 9, kHeight = 7;
  constexpr double kRange = 2;
  const DepthCamera camera{10, 11, 4.5, 2.5};
  int hidden = 0, seen = 0;
  for (int round = 0; round < 20; ++round) {
    std::vector<double> depths;
    std::vector<std::uint8_t> mask;
    const double wall = 0.5 + unit(random);
    for (std::size_t i = 0; i < kWidth * kHeight; ++i) {
      const double kind = unit(random);
      depths.push_back(kind < 0.1 ? kNaN : kind < 0.2 ? 0 : kind < 0.3 ? 5 * unit(random) : wall);
      mask.push_back(unit(random) < 0.1 ? 0 : 1);
    }
    DepthImage image = imageOf(depths, kWidth);
    image.mask = mask.data();
    for (const std::size_t parts : {std::size_t{1}, std::size_t{9}, kWidth * kHeight}) {
      const auto shapes = unseenShapes(image, camera, {kRange, parts});
      ASSERT_LE(shapes.size(), parts);
      for (int k = 0; k < 200; ++k) {
        const std::size_t pixel = static_cast<std::size_t>(unit(random) * kWidth * kHeight);
        const double z = 0.01 + (kRange - 0.02) * unit(random);
        const double depth = mask[pixel] != 0 && depths[pixel] > 0 ? depths[pixel] : 0;
        if (std::abs(z - depth) < 1e-3) continue;
        const Vector3d p = z * rayAt(camera, static_cast<double>(pixel % kWidth),
                                     static_cast<double>(pixel / kWidth));
        const bool is_inside = std::any_of(shapes.begin(), shapes.end(), [&](const auto& part) {
          return collision::distance(part.shape, {}, collision::Shape::sphere(1e-6),
                                     {Eigen::Matrix3d::Identity(), p})
                     .distance.upper <= 0;
        });
        EXPECT_TRUE(is_inside || z < depth) << z << " behind " << depth;
        EXPECT_TRUE(!is_inside || z > depth || parts <= 9) << z << " before " << depth;
        (z > depth ? hidden : seen) += 1;
      }
    }
  }
  EXPECT_GT(hidden, 2000);
  EXPECT_GT(seen, 2000);
  EXPECT_THROW((void)unseenShapes(imageOf({1.0}, 1), camera, {0, 5}), std::invalid_argument);
  EXPECT_THROW((void)unseenShapes(imageOf({1.0}, 1), camera, {1, 0}), std::invalid_argument);
  EXPECT_TRUE(unseenShapes(imageOf({3.0}, 1), camera, {2, 5}).empty());
}

TEST(DepthImage, MasksLeaveOutPixels) {
  const std::vector<double> depths = {1, 2, 0, 4};
  const std::uint8_t mask[] = {0, 1, 1, 255};
  DepthImage image = imageOf(depths, 2);
  image.mask = mask;
  const PointCloud cloud = makeCloud(image, {500, 500, 0, 0}, 0.01);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_EQ(cloud.balls[0].center.z(), 2);
  ASSERT_EQ(cloud.filters.size(), 2U);
  EXPECT_EQ(cloud.filters[0].what, "pixels that the mask leaves out");
  EXPECT_EQ(cloud.filters[0].removed, 1U);
  EXPECT_EQ(cloud.filters[1].what, "pixels without a measurement");
  EXPECT_EQ(cloud.filters[1].removed, 1U);
}

TEST(DepthImage, BadCamerasAndDepthsAreRefused) {
  const auto refused = [](const std::vector<double>& depths, const DepthCamera& camera,
                          double radius) {
    try {
      makeCloud(imageOf(depths, depths.size()), camera, radius);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused({1, 2}, {500, 500, 0, 0}, 0.01), "");
  const auto expect = [&](const DepthCamera& camera, const std::string& word) {
    EXPECT_EQ(refused({1}, camera, 0.01).find(word), 0U) << refused({1}, camera, 0.01);
  };
  for (const double f : {0.0, -500.0, double(NAN), double(INFINITY), 1e7}) {
    expect({f, 500, 0, 0}, "fx ");
    expect({500, f, 0, 0}, "fy ");
  }
  for (const double c : {double(NAN), -double(INFINITY), 1e7}) {
    expect({500, 500, c, 0}, "cx ");
    expect({500, 500, 0, c}, "cy ");
  }
  for (const double slant : {-0.1, double(NAN), 1.6}) expect({500, 500, 0, 0, {}, slant}, "slant ");
  expect({3, 3, 0, 0, {}, 1.4}, "slant 1.4 with pixels");
  for (const double scale : {0.0, -1.0, double(NAN), double(INFINITY)})
    expect({500, 500, 0, 0, scale}, "scale ");
  for (const double radius : {0.0, -1.0, double(NAN), 1e10})
    EXPECT_EQ(refused({1}, {500, 500, 0, 0}, radius).find("radius "), 0U) << radius;
  EXPECT_NE(refused({1, -2}, {500, 500, 0, 0}, 0.01).find("row 0, column 1 has the depth -2"),
            std::string::npos);
  EXPECT_NE(refused({2e9}, {500, 500, 0, 0}, 0.01).find("depth 2000000000 m"), std::string::npos);
  EXPECT_NE(refused({1e300}, {500, 500, 0, 0, 1e9}, 0.01).find("depth inf"), std::string::npos);
  // Far pixels beside the axis are farther than their depth.
  EXPECT_NE(refused({9e8}, {2, 500, 10, 0, {}, 0}, 0.01).find("up to 1000000000 m"),
            std::string::npos);
}

// Problem files.

const std::string kFlyingBall =
    "leeway: 1\n"
    "body:\n"
    "  name: ball\n"
    "  joint: floating\n"
    "  bounds: {lower: [-2, -1, -1], upper: [2, 1, 1]}\n"
    "  shapes: [{sphere: {radius: 0.1}}]\n"
    "start: {position: [-0.9, 0, 0]}\n"
    "goal: {position: [1, 0, 0]}\n"
    "objects:\n";

class DepthProblems : public testing::Test {
 protected:
  /// A wall 1 m before the camera, with a hole in its right half, and pixels that saw nothing.
  DepthProblems() {
    std::vector<std::uint16_t> depths, mask;
    for (std::size_t r = 0; r < kHeight; ++r)
      for (std::size_t c = 0; c < kWidth; ++c) {
        const double x = static_cast<double>(c) - 47, y = static_cast<double>(r) - 24;
        depths.push_back(std::hypot(x, y) < 13 ? 0 : 1000);
        mask.push_back(r == 0 ? 0 : 1);
      }
    folder_.write("depth.png", PngWriter{kWidth, kHeight, 16}.write(depths));
    folder_.write("mask.png", PngWriter{kWidth, kHeight, 1}.write(mask));
    folder_.write("small.pgm", "P2\n1 1\n1\n1\n");
    folder_.write("gray8.png", PngWriter{1, 1, 8}.write({9}));
    folder_.write("black.png", PngWriter{2, 1, 16}.write({0, 0}));
    folder_.write("scan.xyz", "0 0 0\n");
  }
  static constexpr std::uint32_t kWidth = 64, kHeight = 48;

  /// The camera looks along the world's x.
  static std::string seen(const std::string& cloud) {
    return kFlyingBall +
           " - name: wall\n   position: [-1, 0, 0]\n   orientation: [-0.5, 0.5, -0.5, 0.5]\n" +
           "   cloud: " + cloud + "\n";
  }
  Problem load(const std::string& text) { return loadProblem(folder_.write("problem.yaml", text)); }
  void expectError(const std::string& cloud, std::initializer_list<std::string> words) {
    SCOPED_TRACE(cloud);
    const std::string path = folder_.write("problem.yaml", seen(cloud));
    robots::expectInputError([&] { loadProblem(path); }, path, 13, words);
  }
  void expectFileError(const std::string& cloud, const std::string& file,
                       std::initializer_list<std::string> words) {
    SCOPED_TRACE(cloud);
    const std::string path = folder_.write("problem.yaml", seen(cloud));
    robots::expectInputError([&] { loadProblem(path); }, folder_.path(file), 0, words);
  }
  Folder folder_;
};

const std::string kCamera = "camera: {fx: 30, fy: 30, cx: 31.5, cy: 23.5}";

TEST_F(DepthProblems, APathThroughWhatWasSeenIsFoundAndVerified) {
  Problem problem = load(seen("{file: depth.png, radius: 0.01, " + kCamera + "}") +
                         "margin: 0.01\nlimits: {time: 60}\n");
  const PointCloud& cloud = *problem.world.objects[0].cloud;
  EXPECT_GT(cloud.size(), 2000U);
  EXPECT_EQ(cloud.size() + cloud.filters.at(0).removed, std::size_t{kWidth} * kHeight);
  const DepthCamera camera{30, 30, 31.5, 23.5};
  EXPECT_NEAR(cloud.balls[0].radius, 0.01 + depthSpread(camera), 1e-9);
  const PlanResult result = plan(problem);
  ASSERT_EQ(result.status, PlanStatus::kSolved);
  EXPECT_TRUE(result.certificate.certified);
  const VerifyResult verified = verify(problem, result.path);
  EXPECT_EQ(verified.status, VerifyStatus::kCertified) << verified.reason;
  // Where the path crosses the wall, it is in the hole, right of the camera: at y < 0.
  for (std::size_t i = 1; i < result.path.positions.size(); ++i) {
    const auto &p = result.path.positions[i - 1], &q = result.path.positions[i];
    if (p[0] > 0 || q[0] <= 0) continue;
    const double t = p[0] / (p[0] - q[0]), y = p[1] + t * (q[1] - p[1]),
                 z = p[2] + t * (q[2] - p[2]);
    EXPECT_TRUE(std::abs(y) > 0.95 || std::abs(z) > 0.7 || std::hypot(y + 15.5 / 30, z) < 0.43)
        << y << ' ' << z;
  }
  // With larger balls in place of most.
  Problem thin = load(seen("{file: depth.png, radius: 0.01, most_balls: 900, " + kCamera + "}") +
                      "margin: 0.01\nlimits: {time: 60}\n");
  EXPECT_EQ(thin.world.objects[0].cloud->size(), 900U);
  const PlanResult among = plan(thin);
  ASSERT_EQ(among.status, PlanStatus::kSolved);
  EXPECT_EQ(verify(problem, among.path).status, VerifyStatus::kCertified);
}

TEST_F(DepthProblems, WhatTheCameraDidNotSeeIsOccupiedIfAskedFor) {
  std::vector<std::uint16_t> depths;
  for (std::size_t r = 0; r < kHeight; ++r)
    for (std::size_t c = 0; c < kWidth; ++c)
      depths.push_back(
          std::hypot(static_cast<double>(c) - 47, static_cast<double>(r) - 24) < 13 ? 9000 : 1000);
  folder_.write("hole.png", PngWriter{kWidth, kHeight, 16}.write(depths));
  const auto planned = [&](const std::string& unseen, const std::string& range,
                           const Vector3d& goal) {
    Problem problem = load(seen("{file: hole.png, radius: 0.01, unseen: " + unseen +
                                ", camera: {fx: 30, fy: 30, cx: 31.5, cy: 23.5" + range + "}}") +
                           "margin: 0.01\nlimits: {time: 60}\n");
    for (std::size_t k = 0; k < 3; ++k)
      problem.goals[0].ranges[k] = {goal[static_cast<Eigen::Index>(k)],
                                    goal[static_cast<Eigen::Index>(k)]};
    const PlanResult result = plan(problem);
    if (result.status == PlanStatus::kSolved) {
      EXPECT_EQ(verify(problem, result.path).status, VerifyStatus::kCertified);
    }
    return result.status;
  };
  const Vector3d behind(0.6, 0, 0), in_the_hole(0.6, -0.83, 0);
  EXPECT_EQ(planned("free", "", behind), PlanStatus::kSolved);
  EXPECT_EQ(planned("occupied", ", range: 3", behind), PlanStatus::kInvalidGoal);
  EXPECT_EQ(planned("occupied", ", range: 3", in_the_hole), PlanStatus::kSolved);
  EXPECT_EQ(planned("occupied", ", range: 1.2", behind), PlanStatus::kSolved);
  // One part holds what was seen through the hole, too.
  EXPECT_EQ(planned("occupied", ", range: 3, parts: 1", in_the_hole), PlanStatus::kInvalidGoal);
  // What is carved out takes the parts with it that it touches.
  const Problem cut = load(
      seen("{file: hole.png, radius: 0.01, unseen: occupied, carve: [post], camera: {fx: 30, fy: "
           "30, cx: 31.5, cy: 23.5, range: 3}}") +
      " - {name: post, sphere: {radius: 0.2}, position: [0.6, 0, 0]}\n");
  const Object& wall = cut.world.objects[0];
  EXPECT_EQ(wall.cloud->filters.back().name, "carve");
  EXPECT_GT(wall.cloud->filters.back().removed, 0u);
  EXPECT_FALSE(wall.geometries.empty());
  // Files of saved problems have the parts as shapes beside the balls.
  saveProblem(cut, folder_.path("saved.yaml"));
  EXPECT_EQ(problemDifference(cut, loadProblem(folder_.path("saved.yaml"))), "");
}

TEST_F(DepthProblems, KeysAreThoseOfTheLibrary) {
  const Problem problem = load(seen(
      "{file: depth.png, radius: 0.02, unseen: free, camera: {fx: 30, fy: 31, cx: 31.5, cy: 23.5, "
      "scale: 0.002, slant: 0.5, mask: mask.png}}"));
  DepthCamera camera{30, 31, 31.5, 23.5, 0.002, 0.5};
  const PointCloud twin =
      loadDepthImage(folder_.path("depth.png"), folder_.path("mask.png"), camera, 0.02);
  const PointCloud& cloud = *problem.world.objects[0].cloud;
  ASSERT_EQ(cloud.size(), twin.size());
  for (std::size_t i = 0; i < twin.size(); ++i) {
    EXPECT_EQ(cloud.balls[i].center, twin.balls[i].center);
    EXPECT_EQ(cloud.balls[i].radius, twin.balls[i].radius);
  }
  EXPECT_EQ(cloud.filters.at(0).removed, kWidth);
  EXPECT_EQ(cloud.balls[0].center.z(), 2);
}

TEST_F(DepthProblems, BadKeysNameTheirLine) {
  const auto camera = [](const std::string& keys) {
    return "{file: depth.png, radius: 0.01, camera: {" + keys + "}}";
  };
  expectError("{file: depth.png, radius: 0.01}", {"cloud.file", "'depth.png', a picture", "fx"});
  expectError("{file: scan.xyz, radius: 0.01, " + kCamera + "}", {"no depth image", "scan.xyz"});
  expectError("{file: depth.png, " + kCamera + "}", {"'radius'"});
  expectError("{file: depth.png, radius: 0, " + kCamera + "}", {"cloud.radius", "radius 0"});
  expectError("{file: depth.png, radius: 0.01, unseen: occupied, " + kCamera + "}",
              {"no 'range' beside 'unseen: occupied'"});
  expectError("{file: depth.png, radius: 0.01, unseen: maybe, " + kCamera + "}",
              {"unseen is 'maybe'; free or occupied"});
  expectError("{file: scan.xyz, radius: 0.01, unseen: occupied}",
              {"unseen is 'occupied'", "only 'free'", "without a camera"});
  expectError(camera("fx: 30, fy: 30, cx: 1, cy: 1, range: 2"), {"without 'unseen: occupied'"});
  expectError(
      "{file: depth.png, radius: 0.01, unseen: occupied, camera: {fx: 30, fy: 30, cx: 1, cy: 1, "
      "range: 0}}",
      {"range 0"});
  expectError("{file: depth.png, radius: 0.01, most_balls: 0, " + kCamera + "}", {"most_balls"});
  expectError("{file: depth.png, radius: 0.01, most_balls: 2.5, " + kCamera + "}", {"most_balls"});
  expectError(camera("fx: 30, fy: 30, cx: 1"), {"'cy'"});
  expectError(camera("fx: 0, fy: 30, cx: 1, cy: 1"), {"cloud.camera", "fx 0"});
  expectError(camera("fx: .inf, fy: 30, cx: 1, cy: 1"), {"fx"});
  expectError(camera("fx: 30, fy: 30, cx: 1, cy: 1, skale: 1"), {"'skale'", "'scale'"});
  expectError(camera("fx: 30, fy: 30, cx: 1, cy: 1, slant: 2"), {"slant 2"});
  expectError(camera("fx: 30, fy: 30, cx: 1, cy: 1, scale: 0"), {"scale 0"});
  expectError(camera("fx: 30, fy: 30, cx: 1, cy: 1, scale: 1e7"),
              {"row 0, column 0", "depth 10000000000 m"});
  const std::string rest = ", radius: 0.01, " + kCamera + "}";
  expectFileError("{file: gray8.png" + rest, "gray8.png", {"8 bits", "16 bits is expected"});
  expectFileError("{file: black.png" + rest, "black.png", {"none of its 2 x 1 pixels"});
  expectError("{file: gone.png" + rest, {"gone.png', and there is no such file"});
  expectFileError(camera("fx: 30, fy: 30, cx: 1, cy: 1, mask: small.pgm"), "small.pgm",
                  {"1 x 1 pixels; a mask of 64 x 48"});
}

}  // namespace
}  // namespace leeway::planner
