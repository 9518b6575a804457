#include "tools/truth/oracle/generate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "leeway/collision/convex_hull.h"

namespace leeway::oracle {

using collision::Pose;
using collision::Shape;
using collision::ShapeType;
using collision::TriangleMesh;
using Eigen::Vector3d;

std::uint64_t Random::bits() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

double Random::logUniform(double lower, double upper) {
  return lower * std::exp2(std::log2(upper / lower) * unit());
}

Vector3d Random::direction() {
  for (;;) {
    const Vector3d v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    const double length = v.norm();
    if (length > 0.1 && length <= 1) return v / length;
  }
}

Eigen::Matrix3d Random::rotation() {
  Eigen::Vector4d q;
  do {
    for (int i = 0; i < 4; ++i) q[i] = uniform(-1, 1);
  } while (q.norm() < 0.1 || q.norm() > 1);
  q /= q.norm();
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  Eigen::Matrix3d R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),   //
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  return R;
}

namespace {

using Triangle = TriangleMesh::Triangle;

/// The eight corners of a box; bit k of i: corner i has the upper end of axis k.
void appendBox(const Vector3d& lower, const Vector3d& upper, std::vector<Vector3d>& vertices,
               std::vector<Triangle>& triangles) {
  const std::int32_t first = static_cast<std::int32_t>(vertices.size());
  for (int i = 0; i < 8; ++i)
    vertices.emplace_back(i & 1 ? upper.x() : lower.x(), i & 2 ? upper.y() : lower.y(),
                          i & 4 ? upper.z() : lower.z());
  constexpr std::int32_t kFaces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                          {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                          {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const auto& f : kFaces) triangles.push_back({first + f[0], first + f[1], first + f[2]});
}

std::vector<Vector3d> randomPoints(Random& random, Flavour flavour, double size) {
  const int count = flavour == Flavour::kPlain ? 4 + random.below(40) : 1 + random.below(12);
  std::vector<Vector3d> points;
  points.reserve(static_cast<std::size_t>(count));
  Vector3d stretch(1, 1, 1);
  if (flavour == Flavour::kThin) stretch = {1, random.chance(0.5) ? 1e-6 : 1, 1e-6};
  if (flavour == Flavour::kZero) stretch = {1, random.chance(0.3) ? 0.0 : 1.0, 0};
  for (int i = 0; i < count; ++i) points.push_back(size * random.direction().cwiseProduct(stretch));
  if (flavour != Flavour::kDuplicates) return points;
  const std::size_t given = points.size();
  for (std::size_t i = 0; i < given; ++i) {
    const double apart = random.chance(0.5) ? 0 : random.logUniform(1e-17, 1e-7);
    // Two points alone would be smaller than shapes may be.
    const double off = given > 1 ? apart : 0;
    points.push_back(points[i] + off * random.direction());
  }
  return points;
}

std::shared_ptr<const TriangleMesh> randomMesh(Random& random, Flavour flavour, double size) {
  Vector3d half =
      size * Vector3d(random.uniform(0.2, 1), random.uniform(0.2, 1), random.uniform(0.2, 1));
  if (flavour == Flavour::kThin) half.z() *= 1e-6;
  if (flavour == Flavour::kZero) half.z() = 0;
  if (flavour == Flavour::kDuplicates) return sheetMesh(random, size, 3);
  switch (random.below(3)) {
    case 0:
      return boxMesh(half);
    case 1:
      return ellMesh(size);
    default:
      return sheetMesh(random, size, 2);
  }
}

}  // namespace

std::shared_ptr<const TriangleMesh> boxMesh(const Vector3d& half_extents) {
  std::vector<Vector3d> vertices;
  std::vector<Triangle> triangles;
  appendBox(-half_extents, half_extents, vertices, triangles);
  return TriangleMesh::make(vertices, triangles);
}

std::shared_ptr<const TriangleMesh> ellMesh(double size) {
  // The L's outline, counter-clockwise from above, extruded along z.
  const double s = size, t = size / 3;
  const double outline[6][2] = {{0, 0}, {s, 0}, {s, t}, {t, t}, {t, s}, {0, s}};
  std::vector<Vector3d> vertices;
  for (const double z : {-t, t})
    for (const auto& p : outline) vertices.emplace_back(p[0], p[1], z);
  std::vector<Triangle> triangles;
  // The reflex corner 3 sees all others, so a fan from it fills both ends.
  for (const auto& [i, j] : {std::pair{4, 5}, {5, 0}, {0, 1}, {1, 2}}) {
    triangles.push_back({9, i + 6, j + 6});
    triangles.push_back({3, j, i});
  }
  for (std::int32_t i = 0; i < 6; ++i) {
    const std::int32_t j = (i + 1) % 6;
    triangles.push_back({i, j, j + 6});
    triangles.push_back({i, j + 6, i + 6});
  }
  return TriangleMesh::make(vertices, triangles);
}

std::shared_ptr<const TriangleMesh> sheetMesh(Random& random, double size, int cells) {
  std::vector<Vector3d> vertices;
  const double step = 2 * size / cells;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j)
      vertices.emplace_back(i * step - size, j * step - size, random.uniform(-0.2, 0.2) * size);
  std::vector<Triangle> triangles;
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      const std::int32_t a = i * (cells + 1) + j, b = a + cells + 1;
      triangles.push_back({a, b, a + 1});
      triangles.push_back({a + 1, b, b + 1});
    }
  }
  return TriangleMesh::make(vertices, triangles);
}

Shape randomShape(Random& random, ShapeType type, Flavour flavour) {
  double size = random.uniform(0.2, 1);
  if (flavour == Flavour::kTiny) size *= random.logUniform(1e-6, 1e-3);
  if (flavour == Flavour::kHuge) size *= 1e3;
  double first = size * random.uniform(0.1, 1), second = size * random.uniform(0.1, 1);
  if (flavour == Flavour::kThin) (random.chance(0.5) ? first : second) *= 1e-6;
  if (flavour == Flavour::kZero) (random.chance(0.5) ? first : second) = 0;
  Vector3d three(first, second, size * random.uniform(0.1, 1));
  if (flavour == Flavour::kThin && random.chance(0.5)) three.z() *= 1e-6;
  switch (type) {
    case ShapeType::kSphere:
      return Shape::sphere(flavour == Flavour::kZero ? 0 : size);
    case ShapeType::kCapsule:
      return Shape::capsule(first, second);
    case ShapeType::kBox:
      return Shape::box(three);
    case ShapeType::kCylinder:
      return Shape::cylinder(first, second);
    case ShapeType::kCone:
      return Shape::cone(first, second);
    case ShapeType::kEllipsoid:
      return Shape::ellipsoid(three);
    case ShapeType::kHalfSpace:
      return Shape::halfSpace();
    case ShapeType::kConvexHull:
      return Shape::convexHull(std::span<const Vector3d>(randomPoints(random, flavour, size)));
    case ShapeType::kMesh:
    case ShapeType::kDeformable:
      break;
  }
  return Shape::mesh(randomMesh(random, flavour, size));
}

double sizeOf(const Shape& shape) {
  return shape.type() == ShapeType::kHalfSpace
             ? 1
             : shape.boundingCenter().norm() + shape.boundingRadius();
}

namespace {

std::string numbers(std::initializer_list<double> values) {
  std::string result;
  char buffer[40];
  for (const double v : values) {
    std::snprintf(buffer, sizeof buffer, "%s%.17g", result.empty() ? "" : ", ", v);
    result += buffer;
  }
  return result;
}

template <typename Points>
std::string list(const Points& points) {
  std::string result;
  for (const Vector3d& p : points)
    result += (result.empty() ? "{" : ", {") + numbers({p.x(), p.y(), p.z()}) + "}";
  return "{" + result + "}";
}

}  // namespace

std::string replay(const Shape& shape) {
  const std::string two = numbers({shape.radius(), shape.halfLength()});
  const Vector3d& e = shape.halfExtents();
  const std::string three = numbers({e.x(), e.y(), e.z()});
  switch (shape.type()) {
    case ShapeType::kSphere:
      return "sphere(" + numbers({shape.radius()}) + ")";
    case ShapeType::kCapsule:
      return "capsule(" + two + ")";
    case ShapeType::kCylinder:
      return "cylinder(" + two + ")";
    case ShapeType::kCone:
      return "cone(" + two + ")";
    case ShapeType::kBox:
      return "box({" + three + "})";
    case ShapeType::kEllipsoid:
      return "ellipsoid({" + three + "})";
    case ShapeType::kHalfSpace:
      return "halfSpace()";
    case ShapeType::kConvexHull:
      return "convexHull(" + list(shape.hull()->vertices()) + ")";
    case ShapeType::kMesh:
    case ShapeType::kDeformable:
      break;
  }
  std::string triangles;
  for (const Triangle& t : shape.mesh()->triangles())
    triangles += (triangles.empty() ? "{" : ", {") + std::to_string(t[0]) + ", " +
                 std::to_string(t[1]) + ", " + std::to_string(t[2]) + "}";
  return "mesh(" + list(shape.mesh()->vertices()) + ", {" + triangles + "})";
}

std::string replay(const Pose& pose) {
  const auto& R = pose.rotation;
  const auto& t = pose.translation;
  return "R " +
         numbers(
             {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)}) +
         " T " + numbers({t.x(), t.y(), t.z()});
}

}  // namespace leeway::oracle
