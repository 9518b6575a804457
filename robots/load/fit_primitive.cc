#include "robots/load/fit_primitive.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/base/rounding.h"
#include "robots/urdf/xml_reader.h"

namespace leeway::robots {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Inertia = MeshFit::Inertia;

/// Least volume, area and doubled area of a triangle that count, in MuJoCo (mjMINVAL).
constexpr double kLeast = 1e-15;
/// MuJoCo's end of the search for axes [m^5]. It is absolute: of parts of some centimetres the axes
/// stay a little off the principal ones, and a greater or smaller number finds others.
constexpr double kLeastProduct = 1e-12;

struct Triangle {
  Vector3d a, b, c;

  Vector3d center() const { return (a + b + c) / 3; }
  /// Twice the area, along the normal; zero if MuJoCo leaves the triangle out.
  Vector3d normal() const {
    const Vector3d n = (b - a).cross(c - a);
    return n.norm() < kLeast ? Vector3d::Zero() : n;
  }
  double area() const { return normal().norm() / 2; }
  /// Returns the triangle's share of the mesh: the volume of its pyramid with apex `from`, or its
  /// area.
  double weight(const Vector3d& from, Inertia inertia) const {
    if (inertia == Inertia::kShell) return area();
    const double volume = (center() - from).dot(normal()) / 6;
    return inertia == Inertia::kLegacy ? std::abs(volume) : volume;
  }
};

/// A mesh as MuJoCo reads it: vertices in single precision, then scaled and placed on the geom.
std::vector<Triangle> trianglesOf(const UrdfCollision& geometry, const IndexedMesh& mesh) {
  const bool is_mirrored = geometry.mesh_scale.prod() < 0;
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  const auto vertex = [&](std::int32_t index) -> Vector3d {
    Vector3d v = mesh.vertices[static_cast<std::size_t>(index)];
    for (double& x : v) x = collision::roundedToSingle(x);
    return geometry.fit->X_GM * geometry.mesh_scale.cwiseProduct(v);
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    triangles.push_back({vertex(a), vertex(b), vertex(c)});
    if (is_mirrored) std::swap(triangles.back().b, triangles.back().c);
  }
  return triangles;
}

/// The sum of x x^T over the solid or surface, about the origin [m^5 or m^4].
Matrix3d products(const std::vector<Triangle>& triangles, const Vector3d& center, Inertia inertia,
                  double& total) {
  Matrix3d sum = Matrix3d::Zero();
  total = 0;
  for (const Triangle& t : triangles) {
    const Triangle at{t.a - center, t.b - center, t.c - center};
    const double weight = at.weight(Vector3d::Zero(), inertia);
    const Vector3d corners = at.a + at.b + at.c;
    total += weight;
    // The corners' own products, and those of all pairs of them.
    sum += weight / (inertia == Inertia::kShell ? 12 : 20) *
           (at.a * at.a.transpose() + at.b * at.b.transpose() + at.c * at.c.transpose() +
            corners * corners.transpose());
  }
  return sum;
}

/// MuJoCo's axes of a moment of inertia, which fall, by turns about one axis at a time
/// (mjuu_eig3()).
Matrix3d axesOf(const Matrix3d& moment, Vector3d& moments) {
  constexpr int kMostTurns = 500;
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  const auto turnBy = [&](const Eigen::Quaterniond& by) { q = (q * by.normalized()).normalized(); };
  for (int turns = 0; turns < kMostTurns; ++turns) {
    const Matrix3d R = q.toRotationMatrix(), D = R.transpose() * moment * R;
    moments = D.diagonal();
    const double xy = std::abs(D(0, 1)), xz = std::abs(D(0, 2)), yz = std::abs(D(1, 2));
    int row = 1, column = 2, axis = 0;
    if (xy > xz && xy > yz) {
      row = 0, column = 1, axis = 2;
    } else if (xz > yz) {
      row = 0, axis = 1;
    }
    const double product = D(row, column);
    if (std::abs(product) < kLeastProduct) break;
    const double tau = (D(column, column) - D(row, row)) / (2 * product);
    const double t = (tau >= 0 ? 1 : -1) / (std::abs(tau) + std::sqrt(1 + tau * tau));
    const double c = 1 / std::sqrt(1 + t * t);
    if (c > 1 - kLeastProduct) break;
    double half = std::sqrt(0.5 - 0.5 * c) * (tau >= 0 ? -1 : 1);
    if (axis == 1) half = -half;
    Eigen::Quaterniond turn(std::sqrt(1 - half * half), 0, 0, 0);
    turn.vec()[axis] = half;
    turnBy(turn);
  }
  for (const int i : {0, 1, 0}) {
    if (!(moments[i] + kLeastProduct < moments[i + 1])) continue;
    std::swap(moments[i], moments[i + 1]);
    Eigen::Quaterniond turn(std::sqrt(0.5), 0, 0, 0);
    turn.vec()[(i + 2) % 3] = std::sqrt(0.5);
    turnBy(turn);
  }
  return q.toRotationMatrix();
}

/// Half the edges of the box with these moments.
Vector3d boxOf(const Vector3d& moments, double total) {
  const double all = moments.sum();
  return (0.5 * (6 * (all - 2 * moments.array()) / total).sqrt()).matrix();
}

/// The primitive around a box: `size` as in a geom.
Vector3d sizeAround(UrdfCollision::Kind kind, const Vector3d& half) {
  using Kind = UrdfCollision::Kind;
  const double across = std::max(half.x(), half.y());
  if (kind == Kind::kSphere) return Vector3d::Constant(half.maxCoeff());
  if (kind == Kind::kCapsule) return {across, half.z() - across, 0};
  if (kind == Kind::kCylinder) return {across, half.z(), 0};
  return half;
}

/// The primitive of about the inertia of a box.
Vector3d sizeLike(UrdfCollision::Kind kind, const Vector3d& half) {
  using Kind = UrdfCollision::Kind;
  const double across = (half.x() + half.y()) / 2;
  if (kind == Kind::kSphere) return Vector3d::Constant(half.sum() / 3);
  if (kind == Kind::kCapsule) return {across, std::max(0.0, half.z() - across / 2), 0};
  if (kind == Kind::kCylinder) return {across, half.z(), 0};
  return half;
}

}  // namespace

UrdfCollision fittedPrimitive(const UrdfCollision& geometry, const IndexedMesh& mesh) {
  const MeshFit& fit = *geometry.fit;
  const std::vector<Triangle> triangles = trianglesOf(geometry, mesh);
  Vector3d middle = Vector3d::Zero(), center = Vector3d::Zero();
  double area = 0, total = 0;
  for (const Triangle& t : triangles) {
    middle += t.area() * t.center();
    area += t.area();
  }
  middle /= area;
  for (const Triangle& t : triangles) {
    const double weight = t.weight(middle, fit.inertia);
    center +=
        weight *
        (fit.inertia == Inertia::kShell ? t.center() : Vector3d(0.75 * t.center() + 0.25 * middle));
    total += weight;
  }
  const auto fail = [&] {
    throw InputError(geometry.file, geometry.line,
                     "a primitive that is fitted to mesh " + inQuotes(geometry.mesh_file) +
                         " would have no size; its own size, or another mesh, would be accepted");
  };
  if (!(area >= kLeast && total >= kLeast)) fail();
  center /= total;
  const Matrix3d P = products(triangles, center, fit.inertia, total);
  Vector3d moments;
  Pose X_GF;
  X_GF.translation = center;
  X_GF.rotation = axesOf(P.trace() * Matrix3d::Identity() - P, moments);
  Vector3d size;
  if (fit.to_bounds) {
    Eigen::AlignedBox3d bounds;
    for (const Triangle& t : triangles)
      for (const Vector3d& corner : {t.a, t.b, t.c}) bounds.extend(X_GF.inverse() * corner);
    size = sizeAround(geometry.kind, bounds.sizes() / 2);
    X_GF.translation = X_GF * bounds.center();
  } else {
    size = sizeLike(geometry.kind, boxOf(moments, total));
  }
  size *= fit.scale;
  using Kind = UrdfCollision::Kind;
  const bool is_round = geometry.kind == Kind::kCapsule || geometry.kind == Kind::kCylinder;
  if (!size.allFinite() || !((is_round ? size.head<2>().minCoeff() : size.minCoeff()) > 0)) fail();
  UrdfCollision primitive = geometry;
  primitive.fit.reset();
  primitive.X_LG = geometry.X_LG * X_GF;
  primitive.radius = size.x();
  primitive.length = 2 * size.y();
  primitive.size = 2 * size;
  return primitive;
}

}  // namespace leeway::robots
