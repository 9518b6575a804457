#include "tools/report/accuracy/accuracy_cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "leeway/collision/distance.h"
#include "tools/truth/oracle/generate.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::tools::report {
namespace {

using collision::Pose;
using collision::Shape;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using oracle::Random;

ReportShape plain(Shape shape) { return {std::move(shape), {}}; }
ReportShape hullOf(std::vector<Vector3d> points) {
  Shape shape = Shape::convexHull(std::span<const Vector3d>(points));
  return {std::move(shape), std::move(points)};
}

// Sizes are 0.2 to 1 m unless a family says otherwise.
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

/// All points on an ellipsoid, hence all vertices.
template <int kVertices>
ReportShape hull(Random& r) {
  const Vector3d axes = lengths(r);
  std::vector<Vector3d> points;
  points.reserve(kVertices);
  for (int i = 0; i < kVertices; ++i) points.push_back(axes.cwiseProduct(r.direction()));
  return hullOf(std::move(points));
}

using MakeShape = ReportShape (*)(Random&);
struct Pairing {
  const char* name;
  MakeShape a, b;
};

/// Every pair of convex types; the first twelve are the ones published elsewhere.
constexpr std::array<Pairing, 38> kPairings = {{
    {"box-box", box, box},
    {"box-sphere", box, sphere},
    {"sphere-capsule", sphere, capsule},
    {"capsule-capsule", capsule, capsule},
    {"box-capsule", box, capsule},
    {"box-cylinder", box, cylinder},
    {"cylinder-cylinder", cylinder, cylinder},
    {"hull 8", hull<8>, hull<8>},
    {"hull 32", hull<32>, hull<32>},
    {"hull 128", hull<128>, hull<128>},
    {"hull 512", hull<512>, hull<512>},
    {"sphere-sphere", sphere, sphere},
    {"sphere-cylinder", sphere, cylinder},
    {"sphere-cone", sphere, cone},
    {"sphere-ellipsoid", sphere, ellipsoid},
    {"sphere-hull", sphere, hull<32>},
    {"capsule-cylinder", capsule, cylinder},
    {"capsule-cone", capsule, cone},
    {"capsule-ellipsoid", capsule, ellipsoid},
    {"capsule-hull", capsule, hull<32>},
    {"box-cone", box, cone},
    {"box-ellipsoid", box, ellipsoid},
    {"box-hull", box, hull<32>},
    {"cylinder-cone", cylinder, cone},
    {"cylinder-ellipsoid", cylinder, ellipsoid},
    {"cylinder-hull", cylinder, hull<32>},
    {"cone-cone", cone, cone},
    {"cone-ellipsoid", cone, ellipsoid},
    {"cone-hull", cone, hull<32>},
    {"ellipsoid-ellipsoid", ellipsoid, ellipsoid},
    {"ellipsoid-hull", ellipsoid, hull<32>},
    {"half-space-sphere", halfSpace, sphere},
    {"half-space-capsule", halfSpace, capsule},
    {"half-space-box", halfSpace, box},
    {"half-space-cylinder", halfSpace, cylinder},
    {"half-space-cone", halfSpace, cone},
    {"half-space-ellipsoid", halfSpace, ellipsoid},
    {"half-space-hull", halfSpace, hull<32>},
}};

/// Closed-form pairs behave alike in contact; these cover every kind of core.
constexpr std::array<Pairing, 13> kOverlaps = {{
    {"overlap box-box", box, box},
    {"overlap box-sphere", box, sphere},
    {"overlap sphere-capsule", sphere, capsule},
    {"overlap capsule-capsule", capsule, capsule},
    {"overlap box-capsule", box, capsule},
    {"overlap box-cylinder", box, cylinder},
    {"overlap cylinder-cylinder", cylinder, cylinder},
    {"overlap cone-ellipsoid", cone, ellipsoid},
    {"overlap half-space-box", halfSpace, box},
    {"overlap hull 8", hull<8>, hull<8>},
    {"overlap hull 32", hull<32>, hull<32>},
    {"overlap hull 128", hull<128>, hull<128>},
    {"overlap hull 512", hull<512>, hull<512>},
}};

struct Placed {
  ReportShape a, b;
  Pose X_WA, X_WB;
};

double radiusOf(const Shape& shape) {
  return std::isfinite(shape.boundingRadius()) ? shape.boundingRadius() : 1;
}

/// Random orientations, centres 1.1 to 2 bounding radii apart.
Placed placeAnyhow(Random& r, ReportShape a, ReportShape b) {
  Placed p{std::move(a), std::move(b), {}, {}};
  p.X_WA = {r.rotation(), r.uniform(-1, 1) * r.direction()};
  const double reach = radiusOf(p.a.shape) + radiusOf(p.b.shape);
  p.X_WB = {r.rotation(), p.X_WA.translation + r.uniform(1.1, 2) * reach * r.direction()};
  return p;
}

/// Moves B along the separating direction until about `gap` remains. Approximate: the oracle
/// supplies the truth.
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

/// Moves B into contact, then deeper by a share of the smaller body, less where that is thinner.
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

// Hard families.

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

/// Types that every rival has: all face the same cases.
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

/// Flat regular polygons, at times parallel, against one another and solids.
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

/// Two triangles nearly in one plane, beside or above one another.
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

struct HardFamily {
  const char* name;
  Placed (*make)(Random&);
};
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

constexpr std::array<Pairing, 4> kCoherent = {{
    {"coherent box", box, box},
    {"coherent hull 32", hull<32>, hull<32>},
    {"coherent hull 128", hull<128>, hull<128>},
    {"coherent hull 512", hull<512>, hull<512>},
}};
/// A frame of coherent motion: a robot's link at 1 m/s and 1 rad/s, 200 frames/s.
constexpr double kStep = 0.005;  // [m] and [rad]

class SetBuilder {
 public:
  SetBuilder(int per_family, std::uint64_t seed,
             const std::function<void(const std::string&)>& progress)
      : per_family_(per_family), seed_(seed), progress_(progress) {}

  template <typename Make>
  void family(const char* name, FamilyKind kind, const Make& make) {
    Random random = begin(name, kind);
    for (int i = 0; i < per_family_; ++i) add(make(random), 0);
  }

  /// Tracks of at most 16 cases, each with its own pair and motion.
  void coherent(const Pairing& pairing) {
    constexpr int kTrack = 16;
    Random random = begin(pairing.name, FamilyKind::kCoherent);
    for (int i = 0; i < per_family_;) {
      ReportShape a = pairing.a(random);
      Placed p = placeApart(random, std::move(a), pairing.b(random));
      const Vector3d velocity = kStep * random.direction();
      const Matrix3d turn = aboutAxis(random.direction(), kStep);
      const ReportShape* first_a = keep(p.a);
      const ReportShape* first_b = keep(p.b);
      for (int k = 0; k < kTrack && i < per_family_; ++k, ++i) {
        addCase(first_a, first_b, p.X_WA, p.X_WB, i / kTrack);
        p.X_WB.translation += velocity;
        p.X_WB.rotation = turn * p.X_WB.rotation;
      }
    }
  }

  AccuracySet take() { return std::move(set_); }

 private:
  /// Seeds by family, so that a family's cases do not depend on the others.
  Random begin(const char* name, FamilyKind kind) {
    if (progress_) progress_(name);
    set_.families.push_back({name, kind, {}});
    return Random(seed_ * 1000003 + set_.families.size());
  }
  const ReportShape* keep(ReportShape shape) {
    set_.shapes.push_back(std::make_unique<ReportShape>(std::move(shape)));
    return set_.shapes.back().get();
  }
  void add(Placed p, int track) {
    const ReportShape* a = keep(std::move(p.a));
    const ReportShape* b = keep(std::move(p.b));
    addCase(a, b, p.X_WA, p.X_WB, track);
  }
  void addCase(const ReportShape* a, const ReportShape* b, const Pose& X_WA, const Pose& X_WB,
               int track) {
    const oracle::Truth truth = oracle::signedSeparation(a->shape, X_WA, b->shape, X_WB);
    AccuracyCase c;
    c.spec = {a, b, X_WA, X_WB, sizeOfPair(a->shape, b->shape), 0, false};
    c.spec.distance = truth.lower + 0.5 * (truth.upper - truth.lower);
    c.spec.overlap = c.spec.distance < 0;
    c.truth_lower = truth.lower, c.truth_upper = truth.upper;
    c.extent = c.spec.size + std::max(X_WA.translation.norm(), X_WB.translation.norm());
    c.track = track;
    set_.families.back().cases.push_back(c);
  }

  int per_family_;
  std::uint64_t seed_;
  const std::function<void(const std::string&)>& progress_;
  AccuracySet set_;
};

}  // namespace

const char* toString(FamilyKind kind) {
  switch (kind) {
    case FamilyKind::kOrdinary:
      return "ordinary";
    case FamilyKind::kOverlap:
      return "overlap";
    case FamilyKind::kHard:
      return "hard";
    case FamilyKind::kCoherent:
      return "coherent";
  }
  return "";
}

double sizeOfPair(const Shape& a, const Shape& b) {
  double size = 0;
  for (const Shape* shape : {&a, &b})
    if (std::isfinite(shape->boundingRadius())) size += shape->boundingRadius();
  return size > 0 ? size : 1;
}

AccuracySet makeAccuracySet(int per_family, std::uint64_t seed,
                            const std::function<void(const std::string&)>& progress) {
  SetBuilder builder(per_family, seed, progress);
  for (const Pairing& pairing : kPairings)
    builder.family(pairing.name, FamilyKind::kOrdinary, [&](Random& r) {
      ReportShape a = pairing.a(r);
      return placeApart(r, std::move(a), pairing.b(r));
    });
  for (const Pairing& pairing : kOverlaps)
    builder.family(pairing.name, FamilyKind::kOverlap, [&](Random& r) {
      ReportShape a = pairing.a(r);
      return placeOverlapping(r, std::move(a), pairing.b(r), 1e-3, 0.5);
    });
  for (const HardFamily& family : kHard)
    builder.family(family.name, FamilyKind::kHard, family.make);
  for (const Pairing& pairing : kCoherent) builder.coherent(pairing);
  return builder.take();
}

}  // namespace leeway::tools::report
