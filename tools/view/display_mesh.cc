#include "tools/view/display_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "collision/base/numbers.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"
#include "tools/view/base/json_text.h"

namespace leeway::tools::view {
namespace {

using collision::Shape;
using collision::ShapeType;
using Eigen::Vector3d;

struct Box {
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
};

Box boxOf(std::span<const Vector3d> points) {
  if (points.empty()) return {};
  Box box{points[0], points[0]};
  for (const Vector3d& p : points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

/// Clusters the vertices once, with cells of the given side.
DisplayMesh clustered(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                      double side) {
  DisplayMesh mesh;
  mesh.error = side * std::sqrt(3.0);
  const Vector3d low = boxOf(vertices).low;
  std::map<std::array<std::int64_t, 3>, std::int32_t> cells;
  std::vector<std::int32_t> renamed(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::array<std::int64_t, 3> cell{};
    for (int k = 0; k < 3; ++k) {
      cell[static_cast<std::size_t>(k)] =
          static_cast<std::int64_t>((vertices[i][k] - low[k]) / side);
    }
    const auto [found, is_new] =
        cells.emplace(cell, static_cast<std::int32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(vertices[i]);
    renamed[i] = found->second;
  }
  std::set<Triangle> seen;
  for (const Triangle& triangle : triangles) {
    Triangle t{renamed[at(triangle[0])], renamed[at(triangle[1])], renamed[at(triangle[2])]};
    if (t[0] == t[1] || t[1] == t[2] || t[0] == t[2]) continue;
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    if (seen.insert(t).second) mesh.triangles.push_back(t);
  }
  return mesh;
}

/// A ring of points around z. Rings are joined to a closed surface. A ring of radius 0 is a point.
struct Ring {
  double radius, z;
};
DisplayMesh lathe(const std::vector<Ring>& rings, int sides) {
  DisplayMesh mesh;
  for (const Ring& ring : rings) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.vertices.emplace_back(ring.radius * std::cos(angle), ring.radius * std::sin(angle),
                                 ring.z);
    }
  }
  for (int r = 0; r + 1 < static_cast<int>(rings.size()); ++r) {
    for (int i = 0; i < sides; ++i) {
      const int a = r * sides + i, b = r * sides + (i + 1) % sides;
      mesh.triangles.push_back({a, b, b + sides});
      mesh.triangles.push_back({a, b + sides, a + sides});
    }
  }
  return mesh;
}

DisplayMesh roundMesh(double radius, double half_length) {
  constexpr int kSides = 24, kRings = 12;
  std::vector<Ring> rings;
  for (int i = 0; i <= kRings; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) / kRings - 0.5);
    const double z = radius * std::sin(angle);
    const Ring ring{radius * std::cos(angle), z + (2 * i < kRings ? -half_length : half_length)};
    if (2 * i == kRings && half_length > 0) rings.push_back({radius, -half_length});
    rings.push_back(ring);
  }
  return lathe(rings, kSides);
}

DisplayMesh boxMesh(const Vector3d& half) {
  DisplayMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) != 0 ? half.x() : -half.x(),
                               (i & 2) != 0 ? half.y() : -half.y(),
                               (i & 4) != 0 ? half.z() : -half.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

DisplayMesh exact(std::span<const Vector3d> vertices, std::span<const Triangle> triangles) {
  return {{vertices.begin(), vertices.end()}, {triangles.begin(), triangles.end()}, 0};
}

}  // namespace

DisplayMesh decimated(std::span<const Vector3d> vertices, std::span<const Triangle> triangles,
                      std::size_t most) {
  DisplayMesh mesh = exact(vertices, triangles);
  if (triangles.size() <= most) return mesh;
  const Box box = boxOf(vertices);
  const double extent = (box.high - box.low).maxCoeff();
  if (!(extent > 0)) return mesh;
  constexpr double kFinest = 1.0 / 1024, kGrowth = 1.5;
  for (double side = extent * kFinest; mesh.triangles.size() > most; side *= kGrowth) {
    DisplayMesh coarser = clustered(vertices, triangles, side);
    if (coarser.triangles.empty()) break;
    mesh = std::move(coarser);
  }
  return mesh;
}

DisplayMesh displayMesh(const Shape& shape, std::size_t most) {
  switch (shape.type()) {
    case ShapeType::kSphere:
      return roundMesh(shape.radius(), 0);
    case ShapeType::kCapsule:
      return roundMesh(shape.radius(), shape.halfLength());
    case ShapeType::kBox:
      return boxMesh(shape.halfExtents());
    case ShapeType::kCylinder: {
      const double r = shape.radius(), h = shape.halfLength();
      return lathe({{0, -h}, {r, -h}, {r, h}, {0, h}}, 24);
    }
    case ShapeType::kCone: {
      const double r = shape.radius(), h = shape.halfLength();
      return lathe({{0, -h}, {r, -h}, {0, h}}, 24);
    }
    case ShapeType::kEllipsoid: {
      DisplayMesh mesh = roundMesh(1, 0);
      for (Vector3d& v : mesh.vertices) v = v.cwiseProduct(shape.halfExtents());
      return mesh;
    }
    case ShapeType::kHalfSpace:
      return {};
    case ShapeType::kConvexHull:
      return decimated(shape.hull()->vertices(), shape.hull()->facets(), most);
    case ShapeType::kMesh:
      return decimated(shape.mesh()->vertices(), shape.mesh()->triangles(), most);
    case ShapeType::kDeformable:
      return decimated(shape.deformable()->vertices(), shape.deformable()->mesh().triangles(),
                       most);
  }
  return {};
}

Quantised quantised(std::span<const Vector3d> points) {
  constexpr double kFineStep = 1e-4;  // [m]: screens do not show half of it
  const Box box = boxOf(points);
  Quantised result{box.low, 0, {}};
  result.step = std::max((box.high - box.low).maxCoeff() / 65535, kFineStep);
  // Small objects keep their shape.
  if (const double extent = (box.high - box.low).maxCoeff(); extent > 0 && extent < 0.1)
    result.step = extent / 1023;
  result.numbers.reserve(3 * points.size());
  for (const Vector3d& p : points) {
    for (int k = 0; k < 3; ++k) {
      const double number = std::round((p[k] - box.low[k]) / result.step);
      result.numbers.push_back(static_cast<std::uint16_t>(std::clamp(number, 0.0, 65535.0)));
    }
  }
  return result;
}

double quantisationError(const Quantised& q) { return 0.5 * std::sqrt(3.0) * q.step; }

int MeshStore::add(const Shape& shape) {
  const void* owner = shape.mesh() != nullptr   ? static_cast<const void*>(shape.mesh())
                      : shape.hull() != nullptr ? static_cast<const void*>(shape.hull())
                                                : shape.deformable();
  if (const auto found = by_owner_.find(owner); owner != nullptr && found != by_owner_.end())
    return found->second;
  const std::size_t before = shape.mesh() != nullptr   ? shape.mesh()->triangles().size()
                             : shape.hull() != nullptr ? shape.hull()->facets().size()
                             : shape.deformable() != nullptr
                                 ? shape.deformable()->mesh().triangles().size()
                                 : 0;
  // A mesh gets at most half of the remaining budget, but always a thousand triangles.
  const std::size_t left = budget_ > triangles_ ? budget_ - triangles_ : 0;
  const int index = add(displayMesh(shape, std::max<std::size_t>(left / 2, 1000)), before);
  if (owner != nullptr) by_owner_[owner] = index;
  return index;
}

int MeshStore::add(const DisplayMesh& mesh, std::size_t triangles_before) {
  const Quantised q = quantised(mesh.vertices);
  std::vector<std::uint32_t> indices;
  for (const Triangle& t : mesh.triangles)
    for (const std::int32_t i : t) indices.push_back(static_cast<std::uint32_t>(i));
  std::string content(std::bit_cast<const char*>(q.numbers.data()), q.numbers.size() * 2);
  content.append(std::bit_cast<const char*>(indices.data()), indices.size() * 4);
  content.append(std::bit_cast<const char*>(&q.step), sizeof q.step);
  content.append(std::bit_cast<const char*>(q.low.data()), 3 * sizeof(double));
  const auto [found, is_new] = by_content_.emplace(content, static_cast<int>(meshes_.size()));
  if (!is_new) return found->second;
  const double error = mesh.error + quantisationError(q);
  const std::size_t by_vertex[] = {3}, by_index[] = {1};
  meshes_.push_back({{"low", jsonVector(q.low)},
                     {"step", q.step},
                     {"vertices", pack_.add(q.numbers, by_vertex)},
                     {"triangles", pack_.add(indices, by_index)},
                     {"error", error},
                     {"triangles_before", triangles_before}});
  triangles_ += mesh.triangles.size();
  error_ = std::max(error_, error);
  return found->second;
}

}  // namespace leeway::tools::view
