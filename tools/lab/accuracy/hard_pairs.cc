#include "tools/lab/accuracy/hard_pairs.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "leeway/collision/distance.h"

namespace leeway::tools::report {
namespace {

using collision::Shape;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using namespace random_pairs;

Matrix3d aboutAxis(const Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

/// Faces (angle 0 about z) or edges (45 degrees about y) of both bodies parallel, exactly or tilted
/// by 1e-16 to 1e-6.
Placed parallel(Random& r, bool edges) {
  const auto solid = [&]() {
    switch (edges ? 0 : r.below(3)) {
      case 0:
        return box(r);
      case 1:
        return cylinder(r);
      default: {
        // A prism over a random polygon.
        std::vector<Vector3d> points;
        const Vector3d half = lengths(r);
        for (int i = 0; i < 8; ++i) {
          const double t = r.uniform(0, 2 * std::numbers::pi);
          for (const double z : {-1.0, 1.0})
            points.push_back(half.cwiseProduct(Vector3d(std::cos(t), std::sin(t), z)));
        }
        return hullOf(std::move(points));
      }
    }
  };
  Placed p{solid(), solid(), {}, {}};
  const Matrix3d R = r.chance(0.5) ? Matrix3d(Matrix3d::Identity()) : r.rotation();
  const double tilt = r.chance(0.4) ? 0 : r.logUniform(1e-16, 1e-6);
  const Matrix3d corner = edges ? aboutAxis(Vector3d::UnitY(), std::numbers::pi / 4)
                                : aboutAxis(Vector3d::UnitZ(), r.uniform(0, 3));
  p.X_WA = {edges ? Matrix3d(R * corner) : R, Vector3d::Zero()};
  p.X_WB.rotation = R * aboutAxis(Vector3d::UnitX(), tilt) * corner;
  // B above A, shifted sideways so that faces or edges overlap in part.
  const Vector3d aside(edges ? 0 : r.uniform(-0.2, 0.2), r.uniform(-0.2, 0.2), 4);
  p.X_WB.translation = R * aside;
  const double gap = r.logUniform(1e-4, 1);
  collision::Scratch scratch;
  const auto d = collision::distance(p.a.shape, p.X_WA, p.b.shape, p.X_WB, {}, scratch);
  p.X_WB.translation -= (d.distance.lower - gap) * (R * Vector3d::UnitZ());
  return p;
}
Placed parallelFaces(Random& r) { return parallel(r, false); }
Placed parallelEdges(Random& r) { return parallel(r, true); }

/// Types that every rival supports, so that all face the same cases.
ReportShape anySolid(Random& r) {
  constexpr std::array<MakeShape, 5> kAny = {box, cylinder, cone, hull<8>, hull<32>};
  return kAny[static_cast<std::size_t>(r.below(5))](r);
}

Placed nearlyTouching(Random& r) {
  ReportShape a = r.chance(0.6) ? hull<32>(r) : anySolid(r);
  ReportShape b = r.chance(0.6) ? hull<32>(r) : anySolid(r);
  Placed p = placeAnyhow(r, std::move(a), std::move(b));
  setGap(p, r.logUniform(1e-12, 1e-6));
  return p;
}

/// Needles and blades: one or two sizes of 1e-6 to 1e-2.
ReportShape sliver(Random& r) {
  const double thin = r.logUniform(1e-6, 1e-2);
  const Vector3d stretch(1, r.chance(0.5) ? thin : 1, thin);
  if (r.chance(0.3)) return plain(Shape::box(lengths(r).cwiseProduct(stretch)));
  std::vector<Vector3d> points;
  const int count = 4 + r.below(16);
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.push_back(stretch.cwiseProduct(r.direction()));
  return hullOf(std::move(points));
}
Placed slivers(Random& r) {
  ReportShape a = sliver(r);
  return placeApart(r, std::move(a), r.chance(0.5) ? sliver(r) : box(r));
}

/// Flat regular polygons, sometimes parallel, against each other and against solids.
ReportShape polygon(Random& r) {
  const int corners = 3 + r.below(10);
  const double radius = length(r);
  std::vector<Vector3d> points;
  for (int i = 0; i < corners; ++i) {
    const double t = 2 * std::numbers::pi * i / corners;
    points.emplace_back(radius * std::cos(t), radius * std::sin(t), 0);
  }
  return hullOf(std::move(points));
}
Placed flatPolygons(Random& r) {
  ReportShape a = polygon(r);
  const bool both = r.chance(0.7);
  Placed p = placeApart(r, std::move(a), both ? polygon(r) : anySolid(r));
  if (!both || r.chance(0.7)) return p;
  p.X_WB.rotation = p.X_WA.rotation;  // parallel
  p.X_WB.translation =
      p.X_WA.translation +
      p.X_WA.rotation * Vector3d(r.uniform(-0.3, 0.3), r.uniform(-0.3, 0.3), r.logUniform(1e-3, 1));
  return p;
}

ReportShape scaled(ReportShape s, double factor) {
  if (!s.points.empty()) {
    for (Vector3d& p : s.points) p *= factor;
    return hullOf(std::move(s.points));
  }
  const double radius = factor * s.shape.radius(), half = factor * s.shape.halfLength();
  switch (s.shape.type()) {
    case collision::ShapeType::kBox:
      return plain(Shape::box(factor * s.shape.halfExtents()));
    case collision::ShapeType::kCylinder:
      return plain(Shape::cylinder(radius, half));
    default:
      return plain(Shape::cone(radius, half));
  }
}

/// One body 1e3 to 1e6 times smaller; gaps from the smaller's size to the larger's.
Placed sizeRatio(Random& r) {
  const double ratio = r.logUniform(1e3, 1e6);
  ReportShape large = anySolid(r);
  ReportShape small = scaled(anySolid(r), 1 / ratio);
  Placed p = placeAnyhow(r, std::move(large), std::move(small));
  setGap(p, r.logUniform(1 / ratio, 1));
  return p;
}

/// An ordinary pair 1e3 to 1e6 m from the world's origin.
Placed farFromOrigin(Random& r) {
  ReportShape a = anySolid(r);
  Placed p = placeApart(r, std::move(a), anySolid(r));
  const Vector3d away = r.logUniform(1e3, 1e6) * r.direction();
  p.X_WA.translation += away;
  p.X_WB.translation += away;
  return p;
}

/// Two triangles nearly in one plane, next to or above one another.
Placed nearlyCoplanar(Random& r) {
  const auto triangle = [&]() {
    std::vector<Vector3d> points;
    const double start = r.uniform(0, 6);
    for (int i = 0; i < 3; ++i) {
      const double t = start + 2.1 * i + r.uniform(-0.6, 0.6);
      points.emplace_back(std::cos(t), std::sin(t), 0);
    }
    return hullOf(std::move(points));
  };
  Placed p{triangle(), triangle(), {}, {}};
  const Matrix3d R = r.rotation();
  const double tilt = r.logUniform(1e-12, 1e-3);
  p.X_WA = {R, Vector3d::Zero()};
  p.X_WB.rotation = R * aboutAxis(r.direction(), tilt);
  const Vector3d beside(r.uniform(2.1, 3), r.uniform(-0.3, 0.3), r.logUniform(1e-9, 1e-3));
  const Vector3d above(r.uniform(-0.3, 0.3), r.uniform(-0.3, 0.3), r.logUniform(1e-2, 0.3));
  p.X_WB.translation = R * (r.chance(0.5) ? beside : above);
  return p;
}

/// Hulls of duplicated points, exact or up to 1e-7 apart.
ReportShape duplicated(Random& r) {
  const Vector3d axes = lengths(r);
  std::vector<Vector3d> points;
  for (int i = 0; i < 12; ++i) {
    points.push_back(axes.cwiseProduct(r.direction()));
    points.push_back(points.back());
    if (r.chance(0.7)) points.back() += r.logUniform(1e-17, 1e-7) * r.direction();
  }
  return hullOf(std::move(points));
}
Placed duplicatedVertices(Random& r) {
  ReportShape a = duplicated(r);
  return placeApart(r, std::move(a), duplicated(r));
}

Placed shallowOverlap(Random& r) {
  ReportShape a = anySolid(r);
  return placeOverlapping(r, std::move(a), anySolid(r), 1e-9, 1e-4);
}
Placed deepOverlap(Random& r) {
  ReportShape a = anySolid(r);
  return placeOverlapping(r, std::move(a), anySolid(r), 0.3, 0.9);
}
constexpr std::array<HardFamily, 11> kHard = {{
    {"parallel faces", parallelFaces},
    {"parallel edges", parallelEdges},
    {"nearly touching", nearlyTouching},
    {"slivers", slivers},
    {"flat polygons", flatPolygons},
    {"size ratio 1e3..1e6", sizeRatio},
    {"far from the origin", farFromOrigin},
    {"nearly coplanar", nearlyCoplanar},
    {"duplicated vertices", duplicatedVertices},
    {"shallow overlap", shallowOverlap},
    {"deep overlap", deepOverlap},
}};

}  // namespace

std::span<const HardFamily> hardFamilies() { return kHard; }

}  // namespace leeway::tools::report
