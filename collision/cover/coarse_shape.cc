#include "collision/cover/coarse_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/deformable_mesh.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

/// The shape's vertices; for a mesh, only those of its hull. A mesh is placed in many scenes, and
/// its other vertices have no effect on what is computed from these.
std::span<const Eigen::Vector3d> cornersOf(const Shape& shape) {
  if (shape.type() == ShapeType::kDeformable) return shape.deformable()->vertices();
  if (shape.type() == ShapeType::kConvexHull) return shape.hull()->vertices();
  const ConvexView hull = shape.mesh()->tree().hullView();
  return {hull.points, static_cast<std::size_t>(hull.count)};
}

}  // namespace

AxisBox boxOf(const Shape& shape) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(kInfinity), high = -low;
  if (shape.type() == ShapeType::kMesh) {
    low = shape.mesh()->tree().node(0).low;
    high = shape.mesh()->tree().node(0).high;
  } else if (shape.type() == ShapeType::kDeformable) {
    low = shape.deformable()->low();
    high = shape.deformable()->high();
  } else {
    for (const Eigen::Vector3d& v : cornersOf(shape)) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
  }
  AxisBox box;
  box.center = low + (high - low) / 2;
  box.half = (high - box.center).cwiseMax(box.center - low);
  return box;
}

CoarseShape::CoarseShape(const Shape& shape, const Pose& X_FG) {
  Eigen::Vector3d center_G = Eigen::Vector3d::Zero();
  exact_ = true;
  switch (shape.type()) {
    case ShapeType::kSphere:
      kind_ = Kind::kBall;
      half_.setConstant(shape.radius());
      break;
    case ShapeType::kCapsule:
      kind_ = Kind::kSegment;
      half_ = {shape.radius(), shape.radius(), shape.halfLength()};
      break;
    case ShapeType::kCylinder:
      kind_ = Kind::kCylinder;
      half_ = {shape.radius(), shape.radius(), shape.halfLength()};
      break;
    case ShapeType::kBox:
      kind_ = Kind::kBox;
      half_ = shape.halfExtents();
      break;
    case ShapeType::kHalfSpace:
      kind_ = Kind::kHalfSpace;
      break;
    case ShapeType::kCone:
      kind_ = Kind::kCylinder;
      exact_ = false;
      half_ = {shape.radius(), shape.radius(), shape.halfLength()};
      break;
    case ShapeType::kEllipsoid:
      kind_ = Kind::kBox;
      exact_ = false;
      half_ = shape.halfExtents();
      break;
    case ShapeType::kDeformable: {
      kind_ = Kind::kBox;
      exact_ = false;
      const DeformableSnapshot& snapshot = *shape.deformable();
      center_G = snapshot.low() + (snapshot.high() - snapshot.low()) / 2;
      half_ = (snapshot.high() - center_G).cwiseMax(center_G - snapshot.low());
      break;
    }
    case ShapeType::kConvexHull:
    case ShapeType::kMesh: {
      kind_ = Kind::kBox;
      exact_ = false;
      const AxisBox box = boxOf(shape);
      center_G = box.center;
      half_ = box.half;
      break;
    }
  }
  rotation_GF_ = X_FG.rotation.transpose();
  center_F_ = X_FG * center_G;
  slack_ = kCoarseRounding * (center_F_.lpNorm<1>() + center_G.lpNorm<1>() + half_.lpNorm<1>());
}

CoarseShape::CoarseShape(const Ball& ball_F) : exact_(true), center_F_(ball_F.center) {
  half_.setConstant(ball_F.radius);
  slack_ = kCoarseRounding * (center_F_.lpNorm<1>() + half_.lpNorm<1>());
}

double CoarseShape::signedDistance(const Eigen::Vector3d& p_F) const {
  const Eigen::Vector3d p = rotation_GF_ * (p_F - center_F_);
  switch (kind_) {
    case Kind::kBall:
      return p.norm() - half_.x();
    case Kind::kSegment: {
      const double along = std::max(std::abs(p.z()) - half_.z(), 0.0);
      return std::sqrt(p.x() * p.x() + p.y() * p.y() + along * along) - half_.x();
    }
    case Kind::kBox: {
      const double x = std::abs(p.x()) - half_.x(), y = std::abs(p.y()) - half_.y(),
                   z = std::abs(p.z()) - half_.z();
      const double inside = std::max(x, std::max(y, z));
      if (inside <= 0) return inside;
      const double ox = std::max(x, 0.0), oy = std::max(y, 0.0), oz = std::max(z, 0.0);
      return std::sqrt(ox * ox + oy * oy + oz * oz);
    }
    case Kind::kCylinder: {
      const double across = std::sqrt(p.x() * p.x() + p.y() * p.y()) - half_.x(),
                   along = std::abs(p.z()) - half_.z();
      if (across <= 0 || along <= 0) return std::max(across, along);
      return std::sqrt(across * across + along * along);
    }
    case Kind::kHalfSpace:
      return p.z();
  }
  return -kInfinity;
}

double CoarseShape::lower(const Eigen::Vector3d& p_F) const {
  const double d = signedDistance(p_F);
  // Rounding is relative to the point's coordinates, which are at most the shape's (in slack_) plus
  // the distance. A half-space has no size, so the coordinates themselves are used.
  const double far = kind_ == Kind::kHalfSpace ? p_F.lpNorm<1>() : std::abs(d);
  return d - slack_ - kCoarseRounding * far;
}

double CoarseShape::upper(const Eigen::Vector3d& p_F) const {
  if (!exact_) return kInfinity;
  const double d = signedDistance(p_F);
  const double far = kind_ == Kind::kHalfSpace ? p_F.lpNorm<1>() : std::abs(d);
  return d + slack_ + kCoarseRounding * far;
}

namespace {

/// Balls of `radius` along z from -reach to +reach, the middle first.
void addRow(std::vector<Ball>& balls, const Eigen::Vector3d& axis, double reach, double radius) {
  balls.push_back({Eigen::Vector3d::Zero(), radius});
  if (!(reach > 0)) return;
  const double step = std::max(radius, reach / 3);  // at most three on each side
  for (double s = step; s < reach + step / 2; s += step)
    for (const double sign : {1.0, -1.0})
      balls.push_back({axis * (sign * std::min(s, reach)), radius});
}

/// Vertices far from each other: first the farthest from the bounding centre, then always the
/// farthest from those chosen.
void addVertices(std::vector<Ball>& balls, const Shape& shape) {
  const std::span<const Eigen::Vector3d> vertices = cornersOf(shape);
  std::vector<double> squared(vertices.size(), kInfinity);
  // The first of the vertices farthest from `p` and from the previous ones, in one pass.
  const auto farthestFrom = [&](const Eigen::Vector3d& p) {
    std::size_t farthest = 0;
    double most = -1;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      squared[i] = std::min(squared[i], (vertices[i] - p).squaredNorm());
      if (!(squared[i] > most)) continue;
      most = squared[i];
      farthest = i;
    }
    return farthest;
  };
  std::size_t next = farthestFrom(shape.boundingCenter());
  std::fill(squared.begin(), squared.end(), kInfinity);  // the centre is not one of the chosen
                                                         // vertices
  for (int k = 0; k < kVertexProbes; ++k) {
    balls.push_back({vertices[next], 0});
    if (k + 1 == kVertexProbes) break;
    next = farthestFrom(vertices[next]);
    if (squared[next] == 0) break;
  }
}

/// Adds the ball around the mean of the vertices that stays behind the planes of all facets.
void addHullMiddle(std::vector<Ball>& balls, const ConvexHull& hull) {
  if (hull.facets().empty()) return;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : hull.vertices()) middle += v;
  middle /= static_cast<double>(hull.vertices().size());
  double radius = kInfinity;
  for (const std::array<std::int32_t, 3>& f : hull.facets()) {
    const Eigen::Vector3d& p = hull.vertices()[static_cast<std::size_t>(f[0])];
    const Eigen::Vector3d n = (hull.vertices()[static_cast<std::size_t>(f[1])] - p)
                                  .cross(hull.vertices()[static_cast<std::size_t>(f[2])] - p);
    const double norm = n.norm();
    if (!(norm > 0)) continue;  // a sliver: its neighbours bound the ball there
    radius = std::min(radius, n.dot(p - middle) / norm);
  }
  // Facets may miss the hull of the vertices by the slivers' rounding.
  radius -= kInnerBallSlack * (1 + middle.lpNorm<1>());
  if (radius > 0 && std::isfinite(radius)) balls.push_back({middle, radius});
}

}  // namespace

std::vector<Ball> innerBalls(const Shape& shape, const Pose& X_FG) {
  std::vector<Ball> balls;
  const double r = shape.radius(), h = shape.halfLength();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  switch (shape.type()) {
    case ShapeType::kSphere:
      balls.push_back({Eigen::Vector3d::Zero(), r});
      break;
    case ShapeType::kCapsule:
      addRow(balls, z, h, r);
      break;
    case ShapeType::kCylinder:
      addRow(balls, z, h - std::min(r, h), std::min(r, h));
      break;
    case ShapeType::kBox:
    case ShapeType::kEllipsoid: {
      const Eigen::Vector3d& size = shape.halfExtents();
      Eigen::Index longest = 0;
      size.maxCoeff(&longest);
      const double least = size.minCoeff();
      const double reach = shape.type() == ShapeType::kBox ? size[longest] - least : 0;
      addRow(balls, Eigen::Vector3d::Unit(longest), reach, least);
      break;
    }
    case ShapeType::kCone: {
      // The incircle of the triangle with base 2 r and height 2 h.
      const double side = std::sqrt(r * r + 4 * h * h);
      const double inner = r + side > 0 ? 2 * h * r / (r + side) : 0;
      balls.push_back({Eigen::Vector3d(0, 0, inner - h), inner * (1 - kInnerBallSlack)});
      break;
    }
    case ShapeType::kHalfSpace:
      break;
    case ShapeType::kConvexHull:
      addHullMiddle(balls, *shape.hull());
      addVertices(balls, shape);
      break;
    case ShapeType::kMesh:
      addVertices(balls, shape);
      break;
    case ShapeType::kDeformable: {
      // A new snapshot arrives at every step, so a few vertices of triangles are taken without a
      // search.
      const DeformableSnapshot& snapshot = *shape.deformable();
      const std::size_t count = snapshot.mesh().triangles().size();
      for (std::size_t k = 0; k < static_cast<std::size_t>(kVertexProbes) && k < count; ++k) {
        const std::size_t t = k * count / static_cast<std::size_t>(kVertexProbes);
        const std::int32_t v = snapshot.mesh().triangles()[std::min(t, count - 1)][0];
        balls.push_back({snapshot.vertices()[static_cast<std::size_t>(v)], 0});
      }
      break;
    }
  }
  for (Ball& ball : balls) ball.center = X_FG * ball.center;
  return balls;
}

}  // namespace leeway::collision
