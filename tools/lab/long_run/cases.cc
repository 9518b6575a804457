#include "tools/lab/long_run/cases.h"

#include <cmath>
#include <span>

#include "leeway/collision/convex_hull.h"

namespace leeway::accuracy {

using collision::DistanceResult;
using collision::Pose;
using collision::Scratch;
using collision::Shape;
using collision::ShapeType;
using Eigen::Vector3d;
using oracle::Flavour;
using oracle::Random;

namespace {

constexpr std::array<ShapeType, 8> kConvexTypes = {
    ShapeType::kSphere, ShapeType::kCapsule,   ShapeType::kBox,       ShapeType::kCylinder,
    ShapeType::kCone,   ShapeType::kEllipsoid, ShapeType::kHalfSpace, ShapeType::kConvexHull};
constexpr std::size_t kHalfSpaceIndex = 6;
constexpr double kQuarter = 1.5707963267948966;

Eigen::Matrix3d turned(const Vector3d& axis, double angle) {
  Eigen::Matrix3d K;
  K << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Eigen::Matrix3d::Identity() + std::sin(angle) * K + (1 - std::cos(angle)) * K * K;
}

/// An exact rotation by a multiple of a right angle.
Eigen::Matrix3d quarterTurn(Random& random) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
  const int first = random.below(3);
  const double s = random.chance(0.5) ? 1 : -1, t = random.chance(0.5) ? 1 : -1;
  const int second = (first + 1 + random.below(2)) % 3, third = 3 - first - second;
  R(first, 0) = s;
  R(second, 1) = t;
  R(third, 2) = (second == (first + 1) % 3 ? 1 : -1) * s * t;
  return R;
}

double hair(Random& random) { return random.chance(0.4) ? 0 : random.logUniform(1e-17, 1e-3); }

double reach(const Case& c) { return oracle::sizeOf(*c.a) + oracle::sizeOf(*c.b); }

double fraction(Random& random) {
  constexpr std::array<double, 7> kRound = {0, 0.25, 0.5, 1, -0.5, -1, 2};
  return random.chance(0.6) ? kRound[static_cast<std::size_t>(random.below(7))]
                            : random.uniform(-1.2, 1.2);
}

std::vector<Shape> degenerateShapes(ShapeType type) {
  const std::array<Vector3d, 1> point = {Vector3d(0.1, 0.2, 0.3)};
  const std::array<Vector3d, 2> segment = {Vector3d(-0.5, 0, 0), Vector3d(0.5, 0.25, 0)};
  const std::array<Vector3d, 3> triangle = {Vector3d(0, 0, 0), Vector3d(1, 0, 0),
                                            Vector3d(0, 1, 0)};
  // Tiny, and flat or nearly so.
  const std::array<Vector3d, 3> speck = {Vector3d(0, 0, 0), Vector3d(1e-6, 0, 0),
                                         Vector3d(0, 1e-6, 1e-6)};
  switch (type) {
    case ShapeType::kSphere:
      return {Shape::sphere(0), Shape::sphere(1e-9)};
    case ShapeType::kCapsule:
      return {Shape::capsule(0, 0.5), Shape::capsule(0.5, 0), Shape::capsule(0, 0)};
    case ShapeType::kBox:
      return {Shape::box({0, 0, 0}), Shape::box({0.5, 0, 0}), Shape::box({0.5, 0.25, 0})};
    case ShapeType::kCylinder:
      return {Shape::cylinder(0, 0.5), Shape::cylinder(0.5, 0), Shape::cylinder(0, 0)};
    case ShapeType::kCone:
      return {Shape::cone(0, 0.5), Shape::cone(0.5, 0), Shape::cone(0, 0)};
    case ShapeType::kEllipsoid:
      return {Shape::ellipsoid({0, 0, 0}), Shape::ellipsoid({0.5, 0, 0}),
              Shape::ellipsoid({0.5, 0.25, 0})};
    case ShapeType::kConvexHull:
      return {Shape::convexHull(point), Shape::convexHull(segment), Shape::convexHull(triangle),
              Shape::convexHull(speck)};
    default:
      return {Shape::halfSpace()};
  }
}

Shape largeHull(Random& random, int count) {
  const Vector3d axes(random.uniform(0.1, 1), random.uniform(0.1, 1), random.uniform(0.1, 1));
  std::vector<Vector3d> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.push_back(random.direction().cwiseProduct(axes));
  return Shape::convexHull(std::span<const Vector3d>(points));
}

// A body of revolution about z (for ellipsoids: about any axis): needles, plates, and one in six
// with equal length and width, exactly or nearly (for ellipsoids: balls).
Shape revolvedShape(Random& random) {
  const auto size = [&] { return random.chance(0.15) ? 1e-3 : random.uniform(0.05, 1); };
  const double r = size(), h = random.chance(0.17) ? r * (1 + hair(random)) : size();
  switch (random.below(6)) {
    case 0:
      return Shape::cylinder(r, h);
    case 1:
      return Shape::cone(r, h);
    case 2:
      return Shape::capsule(r, h);
    default: {
      Vector3d axes(r, r, r);
      axes[random.below(3)] = h;
      return Shape::ellipsoid(axes);
    }
  }
}

// Shapes with rims and apexes, and ellipsoids, some with equal length and width.
Shape roundShape(Random& random) {
  const double r = random.logUniform(0.02, 1);
  const double h = random.chance(0.15) ? r : random.logUniform(0.02, 1);
  switch (random.below(7)) {
    case 0:
    case 1:
      return Shape::cone(r, h);
    case 2:
    case 3:
      return Shape::cylinder(r, h);
    case 4:
      return Shape::capsule(r, h);
    case 5:
      return Shape::ellipsoid({r, r, h});
    default:
      return Shape::ellipsoid({r, random.logUniform(0.02, 1), h});
  }
}

// Boxes, and hulls of few vertices, right-angled or not.
Shape corneredShape(Random& random) {
  const double size = random.logUniform(0.05, 2);
  std::vector<Vector3d> points = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
  switch (random.below(5)) {
    case 0:
      break;
    case 1:
      for (Vector3d& p : points) p = random.uniform(0, size) * random.direction();
      break;
    case 2:
      for (int i = random.below(20); i >= 0; --i) points.push_back(size * random.direction());
      break;
    case 3:
      for (int i = 0; i < 3; ++i) {
        points.push_back(size * (Vector3d(1, 1, 1) - Vector3d::Unit(i)));
      }
      points.push_back(Vector3d(size, size, size));
      break;
    default:
      return Shape::box({size, random.uniform(0, size), random.uniform(0, size)});
  }
  return Shape::convexHull(std::span<const Vector3d>(points));
}

// A corner, or a point on an edge or face; for round bodies also a point on the axis, a rim or a
// cap. In the shape's frame.
Vector3d markedPoint(Random& random, const Shape& shape) {
  const double r = shape.radius(), h = shape.halfLength();
  switch (shape.type()) {
    case ShapeType::kConvexHull: {
      const auto vertices = shape.hull()->vertices();
      const int count = static_cast<int>(vertices.size());
      const auto any = [&] { return vertices[static_cast<std::size_t>(random.below(count))]; };
      Vector3d point = any();
      for (int i = random.below(3); i > 0; --i) point += random.unit() * (any() - point);
      return point;
    }
    case ShapeType::kBox: {
      Vector3d point = shape.halfExtents();
      for (int i = 0; i < 3; ++i) point[i] *= random.below(3) - 1;
      return point;
    }
    case ShapeType::kCylinder:
    case ShapeType::kCone: {
      const double along = random.chance(0.3) ? 0 : random.chance(0.5) ? h : -h;
      return {random.chance(0.3) ? r : 0, 0, along};
    }
    case ShapeType::kCapsule:
      return {0, 0, h * (random.below(3) - 1)};
    default:
      return Vector3d::Zero();
  }
}

// The centre, or another point on the axis.
Vector3d middlePoint(Random& random, const Shape& shape) {
  const double h =
      shape.type() == ShapeType::kEllipsoid ? shape.halfExtents().z() : shape.halfLength();
  return {0, 0, random.chance(0.5) ? 0 : random.chance(0.3) ? h : h * random.uniform(-1, 1)};
}

const Shape& anyOf(Random& random, const std::vector<Shape>& shapes) {
  return shapes[static_cast<std::size_t>(random.below(static_cast<int>(shapes.size())))];
}

}  // namespace

Pool::Pool(Random& random) {
  for (const ShapeType type : kConvexTypes) {
    for (const Flavour flavour : oracle::kFlavours) {
      for (std::size_t i = 0; i < kEach; ++i) {
        shapes_.push_back(oracle::randomShape(random, type, flavour));
      }
    }
  }
  for (std::size_t i = 0; i < kTypes; ++i) degenerate_[i] = degenerateShapes(kConvexTypes[i]);
  for (const int count : {64, 128, 256, 512}) large_.push_back(largeHull(random, count));
  for (int i = 0; i < 24; ++i) revolved_.push_back(revolvedShape(random));
  for (int i = 0; i < 24; ++i) round_.push_back(roundShape(random));
  for (int i = 0; i < 24; ++i) cornered_.push_back(corneredShape(random));
}

const Shape& Pool::pick(Random& random, std::size_t type, Flavour flavour) const {
  const std::size_t number = static_cast<std::size_t>(random.below(kEach));
  return shapes_[(type * oracle::kFlavours.size() + static_cast<std::size_t>(flavour)) * kEach +
                 number];
}

const Shape& Pool::pick(Random& random, std::size_t type, Family family, bool second) const {
  switch (family) {
    case Family::kSliver:
      return pick(random, type, Flavour::kThin);
    case Family::kFlat:
      return pick(random, type, second && random.chance(0.5) ? Flavour::kPlain : Flavour::kZero);
    case Family::kRatio:
      return pick(random, type,
                  second               ? Flavour::kHuge
                  : random.chance(0.5) ? Flavour::kTiny
                                       : Flavour::kPlain);
    case Family::kDuplicates:
      return pick(random, type, Flavour::kDuplicates);
    case Family::kDegenerate: {
      if (second && random.chance(0.5)) return pick(random, type, Flavour::kPlain);
      const std::vector<Shape>& some = degenerate_[type];
      return some[static_cast<std::size_t>(random.below(static_cast<int>(some.size())))];
    }
    case Family::kLarge:
      if (type == kTypes - 1) return large_[static_cast<std::size_t>(random.below(4))];
      return pick(random, type, Flavour::kPlain);
    default:
      return pick(random, type, Flavour::kPlain);
  }
}

void Pool::place(Random& random, Case& c) const {
  const double size = reach(c);
  switch (c.family) {
    case Family::kParallel: {
      const Vector3d axis = random.chance(0.5) ? Vector3d(Vector3d::Unit(random.below(3)))
                                               : Vector3d(random.direction());
      c.X_WB.rotation = c.X_WA.rotation * quarterTurn(random) * turned(axis, hair(random));
      const double unit = random.chance(0.5) ? oracle::sizeOf(*c.a) : oracle::sizeOf(*c.b);
      const Vector3d along(fraction(random), fraction(random), fraction(random));
      c.X_WB.translation = c.X_WA.translation + c.X_WA.rotation * (unit * along);
      return;
    }
    case Family::kCoaxial: {
      const double angle = random.uniform(0, 4 * kQuarter);
      c.X_WB.rotation = c.X_WA.rotation * turned(Vector3d::UnitZ(), angle) *
                        turned(random.direction(), hair(random));
      const Vector3d beside = hair(random) * size * random.direction();
      const double along = random.chance(0.3) ? 0 : random.uniform(-1, 1) * size;
      c.X_WB.translation =
          c.X_WA.translation + c.X_WA.rotation * (along * Vector3d::UnitZ() + beside);
      return;
    }
    case Family::kRevolved: {
      c.X_WB.rotation = c.X_WA.rotation;
      if (random.chance(0.5)) c.X_WB.rotation *= quarterTurn(random);
      c.X_WB.rotation *= turned(random.direction(), hair(random));
      const Vector3d beside = hair(random) * size * random.direction();
      const double along = random.chance(0.5) ? 0 : random.uniform(-0.3, 0.3) * size;
      c.X_WB.translation =
          c.X_WA.translation + c.X_WA.rotation * (along * Vector3d::Unit(random.below(3)) + beside);
      return;
    }
    case Family::kDeep:
      c.X_WB.rotation = random.rotation();
      c.X_WB.translation = c.X_WA.translation;
      if (random.chance(0.7)) {
        const double least = std::min(oracle::sizeOf(*c.a), oracle::sizeOf(*c.b));
        c.X_WB.translation += least * random.logUniform(1e-9, 1) * random.direction();
      }
      return;
    case Family::kTwin: {
      c.X_WB = c.X_WA;
      if (random.chance(0.5)) c.X_WB.rotation *= quarterTurn(random);
      const Vector3d along = Vector3d::Unit(random.below(3));
      c.X_WB.translation += c.X_WA.rotation * (fraction(random) * size * along);
      return;
    }
    default:
      c.X_WB.rotation = random.rotation();
      c.X_WB.translation = c.X_WA.translation + size * random.uniform(0, 1.2) * random.direction();
  }
}

// Puts a marked point of B at A's centre.
Case Pool::drawMiddle(Random& random) const {
  Case c;
  c.family = Family::kMiddle;
  c.a = &anyOf(random, round_);
  c.b = random.chance(0.7) ? &anyOf(random, cornered_) : &anyOf(random, round_);
  if (random.chance(0.5)) c.X_WA = {random.rotation(), random.direction()};
  Eigen::Matrix3d R_AB = random.rotation();
  if (random.chance(0.5)) {
    const Vector3d axis = Vector3d::Unit(random.below(3));
    R_AB = random.chance(0.3) ? quarterTurn(random) : turned(axis, random.uniform(0, 4 * kQuarter));
  }
  c.X_WB.rotation = c.X_WA.rotation * R_AB;
  const Vector3d place =
      middlePoint(random, *c.a) + hair(random) * oracle::sizeOf(*c.a) * random.direction();
  c.X_WB.translation = c.X_WA * place - c.X_WB.rotation * markedPoint(random, *c.b);
  if (random.chance(0.5)) {
    std::swap(c.a, c.b);
    std::swap(c.X_WA, c.X_WB);
  }
  return c;
}

Case Pool::draw(Random& random, Family family, Scratch& scratch) const {
  if (family == Family::kMiddle) return drawMiddle(random);
  std::size_t type_a = 0, type_b = 0;
  do {
    type_a = static_cast<std::size_t>(random.below(kTypes));
    type_b = family == Family::kTwin ? type_a : static_cast<std::size_t>(random.below(kTypes));
  } while (type_a == kHalfSpaceIndex && type_b == kHalfSpaceIndex);
  Case c;
  c.family = family;
  c.a = &pick(random, type_a, family, false);
  c.b = family == Family::kTwin ? c.a : &pick(random, type_b, family, true);
  if (family == Family::kRevolved) {
    c.a = &anyOf(random, revolved_);
    c.b = &anyOf(random, revolved_);
  }
  if (random.chance(0.5)) std::swap(c.a, c.b);
  const double far = family == Family::kFar ? random.logUniform(1e3, 1e9) : 1;
  c.X_WA = {random.rotation(), far * random.direction()};
  place(random, c);
  if (family != Family::kNear && !random.chance(0.2)) return c;
  const DistanceResult r = collision::distance(*c.a, c.X_WA, *c.b, c.X_WB, {}, scratch);
  if (!std::isfinite(r.distance.upper)) return c;
  const double sign = random.chance(0.5) ? 1 : -1;
  const double wanted = random.chance(0.2) ? 0 : sign * reach(c) * random.logUniform(1e-17, 1e-4);
  c.X_WB.translation += (wanted - r.distance.upper) * r.normal;
  return c;
}

}  // namespace leeway::accuracy
