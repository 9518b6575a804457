#include "planner/contact/contact_slide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "planner/base/random.h"
#include "tests/support/random_model.h"
#include "tests/support/small_problems.h"

namespace leeway::planner {
namespace {

using Point = std::vector<double>;

/// Slides of a given range among a problem's objects, each with its own certifier.
class Slides {
 public:
  Slides(const Problem& problem, double range)
      : scene_(std::make_shared<const CompiledScene>(problem)), range_(range) {}

  const ConfigurationSpace& space() const { return scene_->space(); }

  /// Returns the points of a slide. Each must be nearer to the target and within limits, and each
  /// edge free.
  std::vector<Point> slide(const Point& from, const Point& target) {
    EdgeCertifier certifier(scene_), judge(scene_);
    const ContactSlide::Edge check = [&](std::span<const double> a, std::span<const double> b) {
      ++edges;
      return allowed-- > 0 ? certifier.certify(a, b) : EdgeCheck{};
    };
    ContactSlide slide(certifier, check, range_);
    std::vector<double> flat;
    slide.slide(from, target, flat);
    std::vector<Point> points;
    Point before = from;
    for (std::size_t i = 0; i < flat.size(); i += from.size()) {
      const auto first = flat.begin() + static_cast<std::ptrdiff_t>(i);
      points.emplace_back(first, first + static_cast<std::ptrdiff_t>(from.size()));
      const Point& point = points.back();
      EXPECT_TRUE(space().withinLimits(point));
      EXPECT_LT(space().distance(point, target), space().distance(before, target));
      EXPECT_EQ(judge.certify(before, point, EdgeRequest::persistent()).verdict, Verdict::kFree);
      before = point;
    }
    return points;
  }

  int edges = 0, allowed = 1'000'000;  ///< edges that may be free

 private:
  std::shared_ptr<const CompiledScene> scene_;
  double range_;
};

/// One joint that carries a ball, 1 m from its axis when it turns.
std::shared_ptr<const robots::Model> oneJoint(robots::JointType type) {
  const bool turns = type != robots::JointType::kPrismatic;
  robots::RobotDescription robot =
      robots::testing::chain(2, type, 2, [&](int i, robots::Link& link, robots::Joint& joint) {
        if (i == 0) return;
        joint.axis = turns ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
        link.geometries = {{collision::Shape::sphere(0.1), test::at(turns ? 1 : 0, 0, 0), "ball"}};
      });
  return std::make_shared<robots::Model>(std::move(robot));
}

TEST(ContactSlide, OneJointStopsBeforeAWall) {
  Problem problem = test::problemOf(oneJoint(robots::JointType::kPrismatic), {0}, {0.1});
  problem.world.objects.push_back(test::box("wall", {0.05, 1, 1}, 1, 0, 0));
  Slides slides(problem, 0.3);
  const std::vector<Point> points = slides.slide({0}, {1.9});
  ASSERT_FALSE(points.empty());
  EXPECT_GT(points.back()[0], 0.8);
  EXPECT_LT(points.back()[0], 0.85);
  EXPECT_LE(slides.edges, 15);
  // In contact, the body cannot move on.
  EXPECT_TRUE(slides.slide(points.back(), {1.9}).empty());
  // And from the wall all the way to the limit.
  EXPECT_EQ(slides.slide(points.back(), {-2}).back(), (Point{-2}));
}

TEST(ContactSlide, ContinuousJointsGoTheShorterWay) {
  Problem problem = test::problemOf(oneJoint(robots::JointType::kContinuous), {0}, {0.1});
  problem.world.objects.push_back(test::box("post", {0.05, 0.05, 1}, -1, 0, 0));
  Slides blocked(problem, 0.3);
  const std::vector<Point> points = blocked.slide({2.5}, {-2.5});
  ASSERT_FALSE(points.empty());
  EXPECT_GT(points.back()[0], 2.9);
  EXPECT_LT(points.back()[0], 3.0);
  problem.world.objects.back() = test::box("post", {0.05, 0.05, 1}, 1, 0, 0);
  EXPECT_EQ(Slides(problem, 0.3).slide({2.5}, {-2.5}).back(), (Point{-2.5}));
}

TEST(ContactSlide, FindsTheGapInAWall) {
  Slides slides(test::wallProblem(), 0.5);
  // The straight way meets the lower wall; the slide goes along it and through the gap.
  EXPECT_NE(EdgeCertifier(std::make_shared<const CompiledScene>(test::wallProblem()))
                .certify(Point{-1, 0.6, 0}, Point{1, 1.2, 1})
                .verdict,
            Verdict::kFree);
  const std::vector<Point> through = slides.slide({-1, 0.6, 0}, {1, 1.2, 1});
  ASSERT_FALSE(through.empty());
  EXPECT_EQ(through.back(), (Point{1, 1.2, 1}));
  // Next to the gap the slide ends at the wall, as near as it gets.
  const std::vector<Point> beside = slides.slide({-1, -1, 0}, {1, 0, 1});
  ASSERT_FALSE(beside.empty());
  EXPECT_NEAR(beside.back()[0], -0.15, 0.03);
  EXPECT_NEAR(beside.back()[1], 0, 0.25);
}

TEST(ContactSlide, StepsBeyondALimitAreNone) {
  // A slope leads out of the limits.
  Problem problem = test::problemOf(test::disc(), {-1, 1.5, 0}, {1, 1.9, 0});
  problem.world.objects.push_back(test::box("slope", {2, 0.05, 0.5}, 0.7, 1.7, 0));
  problem.world.objects.back().X_WO.rotation =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Slides slides(problem, 0.5);
  const std::vector<Point> points = slides.slide({-1.9, 1.9, 0}, {1.9, 1.5, 0});
  ASSERT_FALSE(points.empty());
  EXPECT_LT(points.back()[0], 1.5);
  EXPECT_LE(slides.edges, 41);
}

TEST(ContactSlide, ABodyGetsThroughATube) {
  Problem problem =
      test::problemOf(test::flyingBox(), {-0.8, 0, 0, 0, 0, 0, 1}, {0.8, 0, 0, 0, 0, 0, 1});
  // 0.14 high and wide inside; the box is 0.2 long, 0.1 wide, 0.04 high.
  for (const double side : {-1.0, 1.0}) {
    problem.world.objects.push_back(
        test::box(side < 0 ? "left" : "right", {0.3, 0.5, 1}, 0, side * 0.57, 0));
    problem.world.objects.push_back(
        test::box(side < 0 ? "below" : "above", {0.3, 0.07, 0.5}, 0, 0, side * 0.57));
  }
  Slides slides(problem, 0.15);
  Random random(5);
  int through = 0, moved = 0;
  for (int i = 0; i < 100; ++i) {
    Point from{-0.5, random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0, 0, 0, 1};
    Point target{0.6, random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 0, 0, 0, 1};
    target[5] = random.uniform(-0.5, 0.5);
    target[6] = std::sqrt(1 - target[5] * target[5]);
    const std::vector<Point> points = slides.slide(from, target);
    moved += !points.empty();
    through += !points.empty() && points.back()[0] > 0.3;
    if (i < 10) {
      EXPECT_EQ(points, slides.slide(from, target));
    }
  }
  EXPECT_EQ(moved, 100);
  EXPECT_GE(through, 50);
}

TEST(ContactSlide, EndsSoonWhenTimeIsOver) {
  Slides slides(test::wallProblem(), 0.5);
  slides.allowed = 0;
  EXPECT_TRUE(slides.slide({-1, 0.6, 0}, {1, 1.2, 1}).empty());
  EXPECT_LE(slides.edges, 5);
}

}  // namespace
}  // namespace leeway::planner
