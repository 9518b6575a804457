#include "tools/lab/long_run/independent.h"

#include <algorithm>
#include <cmath>

#include "leeway/collision/convex_hull.h"

namespace leeway::accuracy {

using collision::Pose;
using collision::Shape;
using collision::ShapeType;

namespace {

struct Point {
  Real x = 0, y = 0, z = 0;
};

Point wide(const Eigen::Vector3d& v) {
  return {static_cast<Real>(v.x()), static_cast<Real>(v.y()), static_cast<Real>(v.z())};
}
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Real dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Real norm(const Point& a) { return std::sqrt(dot(a, a)); }

/// R^T v.
Point back(const Pose& X, const Point& v) {
  return {dot(wide(X.rotation.col(0)), v), dot(wide(X.rotation.col(1)), v),
          dot(wide(X.rotation.col(2)), v)};
}

Real positive(Real x) { return std::max(x, static_cast<Real>(0)); }

Real outsideOfHull(const collision::ConvexHull& hull, const Point& p) {
  Real most = 0;
  for (const auto& f : hull.facets()) {
    const auto corner = [&](std::size_t i) {
      return wide(hull.vertices()[static_cast<std::size_t>(f[i])]);
    };
    const Point a = corner(0), n = cross(corner(1) - a, corner(2) - a);
    const Real length = norm(n);
    // A sliver's normal is unreliable far from it.
    const Real longest = std::max({norm(corner(1) - a), norm(corner(2) - a)});
    if (length > static_cast<Real>(1e-6) * longest * longest) {
      most = std::max(most, dot(n, p - a) / length);
    }
  }
  return most;
}

}  // namespace

Real farthestAlong(const Shape& shape, const Pose& X_WS, const Eigen::Vector3d& n,
                   const Eigen::Vector3d& origin) {
  const Point wide_n = wide(n), d = back(X_WS, wide_n);
  const Real at = dot(wide_n, wide(X_WS.translation) - wide(origin));
  const Real r = static_cast<Real>(shape.radius()), h = static_cast<Real>(shape.halfLength());
  const Point e = wide(shape.halfExtents());
  switch (shape.type()) {
    case ShapeType::kSphere:
      return at + r * norm(wide_n);
    case ShapeType::kCapsule:
      return at + h * std::abs(d.z) + r * norm(wide_n);
    case ShapeType::kBox:
      return at + e.x * std::abs(d.x) + e.y * std::abs(d.y) + e.z * std::abs(d.z);
    case ShapeType::kCylinder:
      return at + r * std::sqrt(d.x * d.x + d.y * d.y) + h * std::abs(d.z);
    case ShapeType::kCone:
      return at + std::max(h * d.z, r * std::sqrt(d.x * d.x + d.y * d.y) - h * d.z);
    case ShapeType::kEllipsoid:
      return at + norm({e.x * d.x, e.y * d.y, e.z * d.z});
    default:
      break;
  }
  Real most = -HUGE_VALL;
  for (const Eigen::Vector3d& v : shape.hull()->vertices()) most = std::max(most, dot(d, wide(v)));
  return at + most;
}

Real outsideBy(const Shape& shape, const Pose& X_WS, const Eigen::Vector3d& p_W) {
  const Point p = back(X_WS, wide(p_W) - wide(X_WS.translation));
  const Real r = static_cast<Real>(shape.radius()), h = static_cast<Real>(shape.halfLength());
  const Point e = wide(shape.halfExtents());
  const Real across = std::sqrt(p.x * p.x + p.y * p.y), beyond = positive(std::abs(p.z) - h);
  switch (shape.type()) {
    case ShapeType::kSphere:
      return norm(p) - r;
    case ShapeType::kCapsule:
      return std::sqrt(across * across + beyond * beyond) - r;
    case ShapeType::kBox:
      return std::max({std::abs(p.x) - e.x, std::abs(p.y) - e.y, std::abs(p.z) - e.z});
    case ShapeType::kCylinder:
      return std::max(across - r, beyond);
    case ShapeType::kCone: {
      const Real slant = std::sqrt(4 * h * h + r * r);
      const Real beside = slant > 0 ? (across * 2 * h + (p.z - h) * r) / slant : 0;
      return std::max({beside, beyond, across - r});
    }
    case ShapeType::kEllipsoid: {
      const Real least = std::min({e.x, e.y, e.z});
      if (!(least > 0))
        return std::max({std::abs(p.x) - e.x, std::abs(p.y) - e.y, std::abs(p.z) - e.z});
      return (norm({p.x / e.x, p.y / e.y, p.z / e.z}) - 1) * least;
    }
    case ShapeType::kHalfSpace:
      return p.z;
    default:
      return outsideOfHull(*shape.hull(), p);
  }
}

}  // namespace leeway::accuracy
