#include "tools/lab/growth/growth_worlds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/point_cloud.h"

namespace leeway::tools::report {
namespace {

using collision::Shape;
using Eigen::Vector3d;

constexpr double kTurn = 2 * M_PI;
constexpr double kReach = 1.4;  // of the arm [m]
constexpr int kUsualJoints = 7;
constexpr std::int64_t kNearBoxes = 8;

/// Joints alternately turn about the arm's length and across it. The first joint turns the arm
/// around its foot. The combined motion of the others does not grow with their number.
std::shared_ptr<const robots::Model> makeArm(int joints, bool touches_itself) {
  robots::RobotDescription robot;
  robot.name = "arm";
  robot.has_srdf = true;  // the pairs below are the only ones that need no check
  const double length = kReach / joints;
  const double radius = std::min(0.05, 0.3 * length);
  for (int i = 0; i <= joints; ++i) {
    robots::Joint joint;
    joint.name = fmt::format("joint_{}", i);
    joint.parent_link = i - 1;
    joint.child_link = i;
    robots::Link link;
    link.name = fmt::format("link_{}", i);
    link.joint = i;
    if (i > 0) {
      joint.type = robots::JointType::kRevolute;
      joint.X_PJ.translation = Vector3d(0, 0, i == 1 ? 0 : length);
      joint.axis = i % 2 == 1 ? Vector3d::UnitZ() : Vector3d::UnitY();
      joint.first_variable = i - 1;
      joint.variable_count = 1;
      const double limit = i == 1 ? 2.8 : std::min(2.5, 14.0 / joints);
      robot.variables.push_back({joint.name, i, -limit, limit, 1});
      collision::Pose X_LG;
      X_LG.translation = Vector3d(0, 0, length / 2);
      link.geometries.push_back({Shape::capsule(radius, length / 2 - radius), X_LG, link.name});
    }
    // Neighbours touch at their joint, and links two apart touch where the arm bends.
    for (int k = touches_itself ? 0 : std::max(0, i - 2); k < i; ++k)
      robot.disabled_pairs.push_back({k, i, "neighbours"});
    robot.joints.push_back(joint);
    robot.links.push_back(link);
  }
  return std::make_shared<const robots::Model>(std::move(robot));
}

/// The arm leans by `lean` in total, to the side of `turn`.
std::vector<double> leaning(const robots::Model& model, double turn, double lean) {
  std::vector<double> q(model.variables.size(), 0.0);
  const std::size_t bends = q.size() / 2;
  q[0] = turn;
  for (std::size_t i = 1; i < q.size(); i += 2) q[i] = lean / static_cast<double>(bends);
  return q;
}

void addBox(planner::Problem& problem, const Vector3d& half_extents, const Vector3d& middle) {
  planner::Object box;
  box.name = fmt::format("box_{}", problem.world.objects.size());
  box.geometries.push_back({Shape::box(half_extents), {}, box.name});
  box.X_WO.translation = middle;
  problem.world.objects.push_back(std::move(box));
}

/// Adds a post in the way, three more posts, and four boxes above.
void addNear(planner::Problem& problem) {
  for (const double side : {0.0, 2.1, 3.1, 4.2})
    addBox(problem, {0.06, 0.06, 0.45}, {0.6 * std::cos(side), 0.6 * std::sin(side), 0.45});
  for (int k = 0; k < 4; ++k)
    addBox(problem, {0.1, 0.1, 0.05},
           {0.6 * std::cos(kTurn * k / 4 + 0.8), 0.6 * std::sin(kTurn * k / 4 + 0.8), 1.7});
}

/// Adds boxes on a grid of half a metre, from 3 m away on.
void addFar(planner::Problem& problem, std::int64_t count) {
  const auto side = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(std::cbrt(static_cast<double>(count)))));
  problem.world.objects.reserve(problem.world.objects.size() + static_cast<std::size_t>(count));
  for (std::int64_t k = 0; k < count; ++k) {
    const auto place = [](std::int64_t cell) { return 0.5 * static_cast<double>(cell); };
    addBox(problem, {0.1, 0.05 + 0.01 * static_cast<double>(k % 7), 0.05},
           {3 + place(k % side), 3 + place(k / side % side), place(k / side / side)});
  }
}

/// Points of a wavy ring, in circles across it.
std::vector<Vector3d> pointsOfRing(int around, int across) {
  std::vector<Vector3d> points;
  for (int i = 0; i < around; ++i)
    for (int k = 0; k < across; ++k) {
      const double a = kTurn * i / around, b = kTurn * k / across;
      const double r = 0.08 + 0.01 * std::sin(8 * a + 5 * b) + 0.001 * std::sin(71 * a);
      points.emplace_back((0.8 + r * std::cos(b)) * std::cos(a),
                          (0.8 + r * std::cos(b)) * std::sin(a), r * std::sin(b));
    }
  return points;
}

int rootOf(double square) { return std::max(3, static_cast<int>(std::lround(std::sqrt(square)))); }

Shape makeRing(std::int64_t triangles) {
  const int around = rootOf(static_cast<double>(triangles)), across = std::max(3, around / 2);
  const std::vector<Vector3d> vertices = pointsOfRing(around, across);
  std::vector<std::array<std::int32_t, 3>> faces;
  const auto vertex = [&](int i, int k) { return i % around * across + k % across; };
  for (int i = 0; i < around; ++i)
    for (int k = 0; k < across; ++k) {
      faces.push_back({vertex(i, k), vertex(i + 1, k), vertex(i + 1, k + 1)});
      faces.push_back({vertex(i, k), vertex(i + 1, k + 1), vertex(i, k + 1)});
    }
  return Shape::mesh(collision::TriangleMesh::make(vertices, faces));
}

/// Replaces the boxes of the world by one cloud of points on square grids on their faces.
void seeBoxes(planner::Problem& problem, std::int64_t count) {
  const auto eachFace = [&](const auto& visit) {
    for (const planner::Object& box : problem.world.objects)
      for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
          const Vector3d& half = box.geometries.front().shape.halfExtents();
          Vector3d middle = box.X_WO.translation, u = Vector3d::Zero(), v = Vector3d::Zero();
          middle[axis] += side * half[axis];
          u[(axis + 1) % 3] = half[(axis + 1) % 3];
          v[(axis + 2) % 3] = half[(axis + 2) % 3];
          visit(middle, u, v);
        }
  };
  double area = 0;
  eachFace([&](const Vector3d&, const Vector3d& u, const Vector3d& v) {
    area += 4 * u.norm() * v.norm();
  });
  const double spacing = std::sqrt(area / static_cast<double>(count));
  auto cloud = std::make_shared<planner::PointCloud>();
  eachFace([&](const Vector3d& middle, const Vector3d& u, const Vector3d& v) {
    const int n = std::max(1, static_cast<int>(std::lround(2 * u.norm() / spacing)));
    const int m = std::max(1, static_cast<int>(std::lround(2 * v.norm() / spacing)));
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < m; ++k)
        cloud->balls.push_back(
            {middle + ((2 * i + 1.0) / n - 1) * u + ((2 * k + 1.0) / m - 1) * v, kSeenRadius});
  });
  planner::Object seen;
  seen.name = "seen";
  seen.cloud = std::move(cloud);
  problem.world.objects = {std::move(seen)};
}

}  // namespace

const std::vector<std::string>& growthFamilies() {
  static const std::vector<std::string> families = {"boxes", "triangles", "joints"};
  return families;
}

std::pair<std::int64_t, std::int64_t> growthRange(const std::string& family) {
  if (family == "joints") return {2, 100};
  if (family == "points") return {100, 10'000'000};
  return {family == "boxes" ? kNearBoxes : 18, 10'000'000};
}

planner::Problem growthProblem(const std::string& family, std::int64_t count) {
  const auto [least, most] = growthRange(family);
  count = std::clamp(count, least, most);
  planner::Problem problem;
  problem.name = fmt::format("{} {}", count, family);
  problem.robot.model =
      makeArm(family == "joints" ? static_cast<int>(count) : kUsualJoints, family == "points");
  const robots::Model& model = *problem.robot.model;
  planner::Goal goal{"goal", {}};
  problem.start = leaning(model, -1, 1.2);
  for (const double q : leaning(model, 1, 1.2)) {
    problem.robot.variables.push_back(static_cast<int>(goal.ranges.size()));
    goal.ranges.emplace_back(q, q);
  }
  problem.goals.push_back(std::move(goal));
  addNear(problem);
  if (family == "boxes") addFar(problem, count - kNearBoxes);
  if (family == "points") seeBoxes(problem, count);
  if (family == "triangles") {
    planner::Object ring;
    ring.name = "ring";
    ring.geometries.push_back({makeRing(count), {}, ring.name});
    problem.world.objects.push_back(std::move(ring));
  }
  return problem;
}

}  // namespace leeway::tools::report
