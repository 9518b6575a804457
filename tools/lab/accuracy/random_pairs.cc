#include "tools/lab/accuracy/random_pairs.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "leeway/collision/distance.h"

namespace leeway::tools::report {

using collision::Pose;
using collision::Shape;
using Eigen::Vector3d;

double sizeOfPair(const Shape& a, const Shape& b) {
  double size = 0;
  for (const Shape* shape : {&a, &b})
    if (std::isfinite(shape->boundingRadius())) size += shape->boundingRadius();
  return size > 0 ? size : 1;
}

namespace random_pairs {

ReportShape plain(Shape shape) { return {std::move(shape), {}}; }
ReportShape hullOf(std::vector<Vector3d> points) {
  Shape shape = Shape::convexHull(std::span<const Vector3d>(points));
  return {std::move(shape), std::move(points)};
}

double length(Random& random) { return random.uniform(0.2, 1); }
Vector3d lengths(Random& random) { return {length(random), length(random), length(random)}; }

ReportShape sphere(Random& r) { return plain(Shape::sphere(length(r))); }
ReportShape capsule(Random& r) {
  const double radius = 0.5 * length(r);
  return plain(Shape::capsule(radius, length(r)));
}
ReportShape box(Random& r) { return plain(Shape::box(lengths(r))); }
ReportShape cylinder(Random& r) {
  const double radius = length(r);
  return plain(Shape::cylinder(radius, length(r)));
}
ReportShape cone(Random& r) {
  const double radius = length(r);
  return plain(Shape::cone(radius, length(r)));
}
ReportShape ellipsoid(Random& r) { return plain(Shape::ellipsoid(lengths(r))); }
ReportShape halfSpace(Random&) { return plain(Shape::halfSpace()); }

ReportShape roundHull(Random& r, int vertices) {
  const Vector3d axes = lengths(r);
  std::vector<Vector3d> points;
  points.reserve(static_cast<std::size_t>(vertices));
  for (int i = 0; i < vertices; ++i) points.push_back(axes.cwiseProduct(r.direction()));
  return hullOf(std::move(points));
}

namespace {
double radiusOf(const Shape& shape) {
  return std::isfinite(shape.boundingRadius()) ? shape.boundingRadius() : 1;
}
}  // namespace

Placed placeAnyhow(Random& r, ReportShape a, ReportShape b) {
  Placed p{std::move(a), std::move(b), {}, {}};
  p.X_WA = {r.rotation(), r.uniform(-1, 1) * r.direction()};
  const double reach = radiusOf(p.a.shape) + radiusOf(p.b.shape);
  p.X_WB = {r.rotation(), p.X_WA.translation + r.uniform(1.1, 2) * reach * r.direction()};
  return p;
}

void setGap(Placed& p, double gap) {
  collision::Scratch scratch;
  for (int i = 0; i < 2; ++i) {
    const auto d = collision::distance(p.a.shape, p.X_WA, p.b.shape, p.X_WB, {}, scratch);
    if (!std::isfinite(d.distance.lower)) return;
    p.X_WB.translation += (gap - d.distance.lower) * d.normal;
  }
}

Placed placeApart(Random& r, ReportShape a, ReportShape b) {
  Placed p = placeAnyhow(r, std::move(a), std::move(b));
  setGap(p, r.logUniform(0.01, 1) * sizeOfPair(p.a.shape, p.b.shape));
  return p;
}

Placed placeOverlapping(Random& r, ReportShape a, ReportShape b, double least, double most) {
  Placed p = placeAnyhow(r, std::move(a), std::move(b));
  collision::Scratch scratch;
  const auto ask = [&]() {
    return collision::distance(p.a.shape, p.X_WA, p.b.shape, p.X_WB, {}, scratch);
  };
  const auto apart = ask();
  const Vector3d contact = p.X_WB.translation - apart.distance.upper * apart.normal;
  double depth = r.logUniform(least, most) * std::min(radiusOf(p.a.shape), radiusOf(p.b.shape));
  do {
    p.X_WB.translation = contact - depth * apart.normal;
    depth /= 2;
  } while (depth > 0 && ask().distance.upper >= 0);
  return p;
}

}  // namespace random_pairs
}  // namespace leeway::tools::report
