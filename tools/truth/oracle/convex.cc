#include "tools/truth/oracle/convex.h"

#include <algorithm>

#include "leeway/collision/convex_hull.h"

namespace leeway::oracle {

using collision::Shape;
using collision::ShapeType;

ConvexBody::ConvexBody(std::vector<Vector> points_W) : points_(std::move(points_W)) {}

ConvexBody::ConvexBody(const Shape& shape, const collision::Pose& X_WS, const Vector& origin) {
  for (int c = 0; c < 3; ++c) column_[c] = toVector(X_WS.rotation.col(c));
  translation_ = toVector(X_WS.translation) - origin;
  const Quad r = wide(shape.radius()), h = wide(shape.halfLength());
  const Vector e = toVector(shape.halfExtents());
  switch (shape.type()) {
    case ShapeType::kSphere:
      radius_ = r;
      points_ = {translation_};
      break;
    case ShapeType::kCapsule:
      radius_ = r;
      points_ = {place({0, 0, h}), place({0, 0, -h})};
      break;
    case ShapeType::kBox:
      for (int i = 0; i < 8; ++i)
        points_.push_back(place({i & 1 ? e.x : -e.x, i & 2 ? e.y : -e.y, i & 4 ? e.z : -e.z}));
      break;
    case ShapeType::kConvexHull:
      for (const Eigen::Vector3d& p : shape.hull()->vertices())
        points_.push_back(place(toVector(p)));
      break;
    case ShapeType::kCylinder:
      core_ = Core::kCylinder;
      break;
    case ShapeType::kCone:
      core_ = Core::kCone;
      break;
    case ShapeType::kEllipsoid:
      core_ = Core::kEllipsoid;
      axes_ = e;
      break;
    case ShapeType::kHalfSpace:
    case ShapeType::kMesh:
    case ShapeType::kDeformable:
      break;  // handled by the caller
  }
  core_radius_ = r;
  half_length_ = h;
}

Vector ConvexBody::place(const Vector& p) const {
  return p.x * column_[0] + (p.y * column_[1] + (p.z * column_[2] + translation_));
}

Vector ConvexBody::support(const Vector& d) const {
  if (core_ == Core::kPoints) {
    std::size_t best = 0;
    Quad best_value = dot(points_[0], d);
    for (std::size_t i = 1; i < points_.size(); ++i) {
      const Quad value = dot(points_[i], d);
      if (value > best_value) {
        best = i;
        best_value = value;
      }
    }
    return points_[best];
  }
  // Support of an affine image: R s(R^T d) + T, exact for any matrix R.
  const Vector l{dot(column_[0], d), dot(column_[1], d), dot(column_[2], d)};
  if (core_ == Core::kEllipsoid) {
    const Vector scaled{axes_.x * l.x, axes_.y * l.y, axes_.z * l.z};
    const Quad length = norm(scaled);
    if (!(length > 0)) return translation_;
    const Vector unit = (1 / length) * scaled;
    return place({axes_.x * unit.x, axes_.y * unit.y, axes_.z * unit.z});
  }
  const Quad rho = norm({l.x, l.y, 0});
  Vector rim{0, 0, 0};
  if (rho > 0) rim = {core_radius_ * (l.x / rho), core_radius_ * (l.y / rho), 0};
  if (core_ == Core::kCylinder)
    return place({rim.x, rim.y, l.z >= 0 ? half_length_ : -half_length_});
  if (half_length_ * l.z >= core_radius_ * rho - half_length_ * l.z)
    return place({0, 0, half_length_});
  return place({rim.x, rim.y, -half_length_});
}

Quad ConvexBody::extent() const {
  Quad result = 0;
  for (const Vector& d : {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}})
    result = std::max({result, absolute(dot(support(d), d)), absolute(dot(support(-d), d))});
  return result;
}

}  // namespace leeway::oracle
