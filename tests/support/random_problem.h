#pragma once

// Random problems of primitives: arms, free bodies and trees among obstacles of all shapes.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "leeway/collision/triangle_mesh.h"
#include "leeway/planner/problem.h"
#include "tests/support/random_model.h"

namespace leeway::planner::testing {

using robots::testing::Random;

inline collision::Shape randomHull(Random& random, double size) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 12; ++i) points.push_back(random.vector(size));
  return collision::Shape::convexHull(points);
}

/// A shape of about the given size [m], of any bounded convex type.
inline collision::Shape randomShape(Random& random, double size) {
  const double r = size * random.uniform(0.2, 1), h = size * random.uniform(0.2, 1);
  switch (random.integer(7)) {
    case 0:
      return collision::Shape::sphere(r);
    case 1:
      return collision::Shape::capsule(r / 2, h);
    case 2:
      return collision::Shape::box({r, h, size * random.uniform(0.05, 1)});
    case 3:
      return collision::Shape::cylinder(r, h);
    case 4:
      return collision::Shape::cone(r, h);
    case 5:
      return collision::Shape::ellipsoid({r, h, size * random.uniform(0.2, 1)});
    default:
      return randomHull(random, size);
  }
}

/// Adds a closed box with these half edges around a centre to a mesh.
inline void appendBox(const Eigen::Vector3d& center, const Eigen::Vector3d& half,
                      std::vector<Eigen::Vector3d>& vertices,
                      std::vector<collision::TriangleMesh::Triangle>& triangles) {
  static constexpr std::int32_t kFaces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                                 {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                                 {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const auto first = static_cast<std::int32_t>(vertices.size());
  for (int i = 0; i < 8; ++i)
    vertices.emplace_back(center + half.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1,
                                                                     i & 4 ? 1 : -1)));
  for (const auto& f : kFaces) triangles.push_back({first + f[0], first + f[1], first + f[2]});
}

/// A closed bumpy ring, 0.3 m radius, about 0.24 m thick: a mesh whose depths are expensive.
inline collision::Shape bumpyRing() {
  constexpr int kAround = 40, kAcross = 20;
  constexpr double kPi = 3.14159265358979323846;
  std::vector<Eigen::Vector3d> vertices;
  std::vector<collision::TriangleMesh::Triangle> triangles;
  const auto place = [](int i, int j) { return i % kAround * kAcross + j % kAcross; };
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAcross; ++j) {
      const double a = 2 * kPi * i / kAround, b = 2 * kPi * j / kAcross,
                   r = 0.12 * (1 + 0.2 * std::sin(7 * a) * std::cos(3 * b)),
                   out = 0.3 + r * std::cos(b);
      vertices.emplace_back(out * std::cos(a), out * std::sin(a), r * std::sin(b));
      triangles.push_back({place(i, j), place(i + 1, j), place(i + 1, j + 1)});
      triangles.push_back({place(i, j), place(i + 1, j + 1), place(i, j + 1)});
    }
  }
  return collision::Shape::mesh(collision::TriangleMesh::make(vertices, triangles));
}

/// Three boxes in one mesh: closed, concave, often intersecting or nested.
inline collision::Shape randomMesh(Random& random, double size) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<collision::TriangleMesh::Triangle> triangles;
  for (int part = 0; part < 3; ++part) {
    const Eigen::Vector3d center = random.vector(size);
    const double x = size * random.uniform(0.05, 0.6), y = size * random.uniform(0.05, 0.6),
                 z = size * random.uniform(0.05, 0.6);
    appendBox(center, {x, y, z}, vertices, triangles);
  }
  return collision::Shape::mesh(collision::TriangleMesh::make(vertices, triangles));
}

/// Seven joints, links of 0.25 m; the fourth is continuous, the last carries a mimic finger.
inline std::shared_ptr<const robots::Model> randomArm(Random& random) {
  auto robot = robots::testing::chain(
      9, robots::JointType::kRevolute, 2.6, [&](int i, robots::Link& link, robots::Joint& joint) {
        collision::Pose X_LG = random.pose(0.03);
        X_LG.translation.z() += 0.12;
        link.geometries.push_back({randomShape(random, 0.08), X_LG, link.name});
        if (i == 4) joint.type = robots::JointType::kContinuous;
        joint.axis = i % 2 == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
        if (i > 0) joint.X_PJ.translation = {0, 0, 0.25};
        if (i == 8) {
          joint.mimic = 7;
          joint.multiplier = -0.5;
          joint.offset = 0.2;
        }
      });
  for (int i = 0; i + 2 < 9; ++i) robot.disabled_pairs.push_back({i, i + 2, "near"});
  robot.has_srdf = true;
  return std::make_shared<robots::Model>(std::move(robot));
}

inline std::shared_ptr<const robots::Model> randomFreeBody(Random& random, robots::JointType type) {
  std::vector<robots::Geometry> geometries;
  for (int i = 0; i < 2; ++i)
    geometries.push_back(
        {randomShape(random, 0.25), random.pose(0.25), "part" + std::to_string(i)});
  return robots::freeBody("body", std::move(geometries), type, Eigen::Vector3d::Constant(-1.5),
                          Eigen::Vector3d::Constant(1.5));
}

/// A random tree with a ball, box or other shape on each link.
inline std::shared_ptr<const robots::Model> randomTreeWithShapes(Random& random) {
  const auto model = robots::testing::randomTree(random, 6);
  for (robots::Link& link : model->links)
    link.geometries.push_back({randomShape(random, 0.1), random.pose(0.1), link.name});
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j)
      if (random.integer(2) == 0) model->disabled_pairs.push_back({i, j, "drawn"});
  model->has_srdf = true;
  return model;
}

/// The model among `obstacles` random shapes within `room` metres; all variables are planned.
inline Problem randomProblem(Random& random, std::shared_ptr<const robots::Model> model,
                             int obstacles, double room) {
  Problem problem;
  problem.robot.model = std::move(model);
  problem.start = robots::testing::randomConfiguration(random, *problem.robot.model);
  for (std::size_t v = 0; v < problem.robot.model->variables.size(); ++v)
    problem.robot.variables.push_back(static_cast<int>(v));
  for (int i = 0; i < obstacles; ++i) {
    Object object;
    object.name = "object" + std::to_string(i);
    object.geometries.push_back({randomShape(random, 0.2), random.pose(0.05), object.name});
    object.X_WO = random.pose(room);
    problem.world.objects.push_back(object);
  }
  if (random.integer(2) == 0) {
    Object floor;
    floor.name = "floor";
    floor.geometries.push_back({collision::Shape::halfSpace(), {}, "floor"});
    floor.X_WO.translation = {0, 0, -0.8 * room};
    problem.world.objects.push_back(floor);
  }
  problem.margins.common = random.integer(2) == 0 ? 0.0 : 0.01;
  return problem;
}

}  // namespace leeway::planner::testing
