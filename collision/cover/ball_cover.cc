#include "collision/cover/ball_cover.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/tolerances.h"
#include "collision/cover/face_parts.h"
#include "leeway/collision/convex_hull.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

void addPrism(Polygons& faces, std::span<const Vector3d> base, const Vector3d& up) {
  std::vector<Vector3d> top(base.begin(), base.end());
  for (Vector3d& p : top) p += up;
  for (std::size_t i = 0; i < base.size(); ++i) {
    const std::size_t next = (i + 1) % base.size();
    faces.add(std::array<Vector3d, 4>{base[i], base[next], top[next], top[i]});
  }
  faces.add(base);
  faces.add(top);
}

void addBox(Polygons& faces, const Vector3d& half) {
  const std::array<Vector3d, 4> base = {
      Vector3d(-half.x(), -half.y(), -half.z()), Vector3d(half.x(), -half.y(), -half.z()),
      Vector3d(half.x(), half.y(), -half.z()), Vector3d(-half.x(), half.y(), -half.z())};
  addPrism(faces, base, Vector3d(0, 0, 2 * half.z()));
}

/// The prism over a regular octagon around the circle; its corners are 8 % outside the circle.
void addCylinder(Polygons& faces, double radius, double half_length) {
  const double a = radius * (1 + 1e-12), b = a * 0.41421356237309515;  // tan(pi / 8), rounded up
  std::array<Vector3d, 8> base;
  const double x[8] = {a, b, -b, -a, -a, -b, b, a}, y[8] = {b, a, a, b, -b, -a, -a, -b};
  for (std::size_t i = 0; i < 8; ++i) base[i] = {x[i], y[i], -half_length};
  addPrism(faces, base, Vector3d(0, 0, 2 * half_length));
}

Polygons facesOf(const Shape& shape) {
  Polygons faces;
  switch (shape.type()) {
    case ShapeType::kBox:
    case ShapeType::kEllipsoid:
      addBox(faces, shape.halfExtents());
      break;
    case ShapeType::kCapsule:
      addCylinder(faces, shape.radius(), shape.halfLength() + shape.radius());
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      addCylinder(faces, shape.radius(), shape.halfLength());
      break;
    case ShapeType::kConvexHull: {
      const std::span<const Vector3d> v = shape.hull()->vertices();
      for (const auto& f : shape.hull()->facets())
        faces.add(std::array<Vector3d, 3>{v[static_cast<std::size_t>(f[0])],
                                          v[static_cast<std::size_t>(f[1])],
                                          v[static_cast<std::size_t>(f[2])]});
      break;
    }
    case ShapeType::kMesh:
      faces = polygonsOf(*shape.mesh());
      break;
    case ShapeType::kSphere:
    case ShapeType::kHalfSpace:
    case ShapeType::kDeformable:  // a new cover at every step would be needed: one ball
      break;
  }
  return faces;
}

struct Part {
  Polygons faces;
  Ball ball;
};

std::pair<Part, Part> bisect(const Part& part, Eigen::Index axis) {
  double low = kInfinity, high = -kInfinity;
  for (const Vector3d& p : part.faces.corners()) {
    low = std::min(low, p[axis]);
    high = std::max(high, p[axis]);
  }
  const double at = low + (high - low) / 2;
  std::pair<Part, Part> halves;
  for (const auto& [half, side] :
       {std::pair(&halves.first, -1.0), std::pair(&halves.second, 1.0)}) {
    half->faces = clipped(part.faces, axis, at, side);
    if (!half->faces.empty()) half->ball = ballAround(half->faces.corners());
  }
  return halves;
}

/// Bisects by the axis whose larger half is smaller.
std::pair<Part, Part> bisectBest(const Part& part, const std::array<Eigen::Index, 2>& axes) {
  std::pair<Part, Part> first = bisect(part, axes[0]), second = bisect(part, axes[1]);
  const auto worst = [](const std::pair<Part, Part>& halves) {
    return std::max(halves.first.ball.radius, halves.second.ball.radius);
  };
  return worst(second) < worst(first) ? std::move(second) : std::move(first);
}

/// Radius of the largest ball inside the shape around that centre [m]; not positive if the centre
/// is outside.
double roomAt(const Shape& shape, const Vector3d& center, Scratch& scratch) {
  const Shape point = Shape::sphere(0);
  Pose X_GP;
  X_GP.translation = center;
  DistanceRequest request;
  request.tolerance = 1e-6;
  const DistanceResult r = distance(point, X_GP, shape, Pose{}, request, scratch);
  return -r.distance.upper;
}

std::vector<Ball> outerBalls(const Shape& shape, int count) {
  std::vector<Ball> outer;
  if (shape.type() == ShapeType::kHalfSpace || count < 1) return outer;
  const Ball whole{
      shape.boundingCenter(),
      shape.boundingRadius() +
          kTransferRounding * (shape.boundingCenter().lpNorm<1>() + shape.boundingRadius())};
  std::vector<Part> parts(1);
  parts[0].faces = facesOf(shape);
  if (shape.type() == ShapeType::kSphere || !(whole.radius > 0) || parts[0].faces.empty()) {
    outer.push_back(whole);
  } else {
    parts[0].ball = ballAround(parts[0].faces.corners());
    Vector3d low = Vector3d::Constant(kInfinity), high = -low;
    for (const Vector3d& p : parts[0].faces.corners()) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    Eigen::Index shortest = 0;
    (high - low).minCoeff(&shortest);
    const std::array<Eigen::Index, 2> axes = {(shortest + 1) % 3, (shortest + 2) % 3};
    while (static_cast<int>(parts.size()) < count) {
      const auto largest = std::max_element(
          parts.begin(), parts.end(),
          [](const Part& x, const Part& y) { return x.ball.radius < y.ball.radius; });
      std::pair<Part, Part> halves = bisectBest(*largest, axes);
      if (halves.first.faces.empty() || halves.second.faces.empty()) break;
      *largest = std::move(halves.first);
      parts.push_back(std::move(halves.second));
    }
    for (const Part& part : parts) outer.push_back(part.ball);
  }
  return outer;
}

}  // namespace

void addInnerBalls(const Shape& shape, BallCover& cover) {
  if (shape.type() == ShapeType::kDeformable) return;
  Scratch scratch;
  for (const Ball& ball : cover.outer) {
    const double room = roomAt(shape, ball.center, scratch) * (1 - kInnerBallSlack);
    if (room > 0 && std::isfinite(room)) cover.inner.push_back({ball.center, room});
  }
  // Sorts the largest first, because it proves most contacts.
  std::stable_sort(cover.inner.begin(), cover.inner.end(),
                   [](const Ball& x, const Ball& y) { return x.radius > y.radius; });
}

BallCover coverWithBalls(const Shape& shape, int count) {
  BallCover cover;
  cover.outer = outerBalls(shape, count);
  addInnerBalls(shape, cover);
  return cover;
}

BallCover coverWithoutInnerBalls(const Shape& shape) {
  BallCover cover;
  cover.outer = outerBalls(shape, kCoverBalls);
  cover.points = coverWithPoints(shape, kCoverPoints);
  cover.parts = coverWithParts(shape, kCoverParts);
  return cover;
}

std::shared_ptr<const BallCover> coverOf(const Shape& shape) {
  const auto make = [&] {
    BallCover cover = coverWithoutInnerBalls(shape);
    addInnerBalls(shape, cover);
    return std::make_shared<const BallCover>(std::move(cover));
  };
  if (shape.type() != ShapeType::kMesh) return make();
  const TriangleMesh& mesh = *shape.mesh();
  std::call_once(mesh.cover_once_, [&] { mesh.cover_ = make(); });
  return mesh.cover_;
}

}  // namespace leeway::collision
