#include "collision/convex/pairs/closed_form.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "collision/base/pose_check.h"

namespace leeway::collision {

// clang-format off
// Rounding, in units of extent + |p|. Every result below is a chain of
//
//   clamps                                                     exact
//   one difference a coordinate                                1
//   a norm (a root of squares amplifies no absolute errors)    3
//   of cylinders and cones, a distance from the axis           3
//     and a product with a unit vector                         4
//
// Less than 16 in all; kClosedFormRounding doubles that.
// clang-format on

namespace {

Vector unitOr(const Vector& v, double norm, const Vector& otherwise) {
  return norm > 0 ? Vector(v / norm) : otherwise;
}

PointDistance fromPoint(const Vector& p, const Vector& nearest) {
  const Vector d = p - nearest;
  const double norm = d.norm();
  return {norm, nearest, unitOr(d, norm, Vector::UnitX())};
}

PointDistance fromSegment(double half_length, const Vector& p) {
  const Vector d(p.x(), p.y(), p.z() - std::clamp(p.z(), -half_length, half_length));
  const double norm = d.norm();
  // The norm is 0 only for a point on the segment, which leaves it sideways.
  return {norm, Vector(0, 0, std::clamp(p.z(), -half_length, half_length)),
          unitOr(d, norm, Vector::UnitX())};
}

PointDistance fromBox(const Vector& half, const Vector& p) {
  const Vector nearest = p.cwiseMin(half).cwiseMax(-half);
  const Vector d = p - nearest;
  const double norm_squared = d.squaredNorm();
  if (norm_squared > 0) {
    const double norm = std::sqrt(norm_squared);
    return {norm, nearest, d / norm};
  }
  // Inside: the way out is through the nearest face. (Also if the square of d underflows: an error
  // of 1e-160.)
  int axis = 0;
  const double depth = (half - p.cwiseAbs()).minCoeff(&axis);
  PointDistance result{-std::max(depth, 0.0), nearest, Vector::Zero()};
  result.normal[axis] = std::copysign(1.0, p[axis]);
  result.nearest[axis] = std::copysign(half[axis], p[axis]);
  return result;
}

// A body of revolution: the half plane through the axis and p, with coordinates (across, along).
struct HalfPlane {
  double across;
  Vector radial;  // unit

  explicit HalfPlane(const Vector& p) {
    across = std::sqrt(p.x() * p.x() + p.y() * p.y());
    radial = across > 0 ? Vector(p.x() / across, p.y() / across, 0) : Vector(1, 0, 0);
  }
  Vector point(double r, double z) const { return {r * radial.x(), r * radial.y(), z}; }
};

PointDistance fromCylinder(double radius, double half_length, const Vector& p) {
  const HalfPlane plane(p);
  const double out = plane.across - radius, above = std::abs(p.z()) - half_length;
  const double end = std::copysign(half_length, p.z());
  const Vector up(0, 0, std::copysign(1.0, p.z()));
  if (out <= 0 && above <= 0) {
    if (out > above) return {out, plane.point(radius, p.z()), plane.radial};
    return {above, plane.point(plane.across, end), up};
  }
  if (above <= 0) return {out, plane.point(radius, p.z()), plane.radial};
  if (out <= 0) return {above, plane.point(plane.across, end), up};
  const double norm = std::sqrt(out * out + above * above);
  return {norm, plane.point(radius, end), (out / norm) * plane.radial + (above / norm) * up};
}

PointDistance fromCone(double radius, double half_length, const Vector& p) {
  const HalfPlane plane(p);
  // The slant runs from the rim (radius, -half_length) to the apex (0, half_length); its outward
  // normal is (2 half_length, radius).
  const double slant = std::hypot(2 * half_length, radius);
  if (!(slant > 0)) return fromPoint(p, Vector::Zero());
  const double normal_across = 2 * half_length / slant, normal_along = radius / slant;
  const double from_slant = plane.across * normal_across + (p.z() - half_length) * normal_along;
  const double from_base = -half_length - p.z();
  // (A point inside both planes may still be outside: of a flat cone beyond the rim, of a thin one
  // beyond the apex.)
  if (from_slant <= 0 && from_base <= 0 && plane.across <= radius && p.z() <= half_length) {
    if (from_base > from_slant) {
      return {from_base, plane.point(plane.across, -half_length), -Vector::UnitZ()};
    }
    return {
        from_slant,
        plane.point(plane.across - from_slant * normal_across, p.z() - from_slant * normal_along),
        normal_across * plane.radial + normal_along * Vector::UnitZ()};
  }
  // Outside. Above the base or the slant, the direction is their normal, because a difference of
  // two points would lose it near contact.
  if (from_base > 0 && plane.across <= radius) {
    return {from_base, plane.point(plane.across, -half_length), -Vector::UnitZ()};
  }
  // The distances of the point, along the slant, beyond the apex and the rim. They are computed
  // from differences to apex and rim, which keep the point's accuracy nearby. As a share of the
  // slant they would lose it: next to the apex the direction would point across the axis, along
  // which the cone reaches farther.
  const double rise = 2 * half_length;
  const double over_apex = ((p.z() - half_length) * rise - plane.across * radius) / slant;
  const double over_rim = ((plane.across - radius) * radius - (p.z() + half_length) * rise) / slant;
  if (over_apex < 0 && over_rim < 0) {
    const double t = -over_rim / slant;
    return {from_slant, plane.point(radius * (1 - t), half_length * (2 * t - 1)),
            normal_across * plane.radial + normal_along * Vector::UnitZ()};
  }
  const bool rim = over_rim > over_apex;
  const double across = rim ? radius : 0, along = rim ? -half_length : half_length;
  const double norm = std::hypot(plane.across - across, p.z() - along);
  const Vector d = (plane.across - across) * plane.radial + (p.z() - along) * Vector::UnitZ();
  return {norm, plane.point(across, along),
          unitOr(d, norm, normal_across * plane.radial + normal_along * Vector::UnitZ())};
}

// Lane by lane: y, or 0 where x is 0.
BodyLanes whereNotZero(BodyLanes x, BodyLanes y) {
  using Bits = std::int64_t __attribute__((vector_size(16)));
  return reinterpret_cast<BodyLanes>((x != BodyLanes{0, 0}) & reinterpret_cast<Bits>(y));
}

// nearestToBox() by bisection over all breakpoints of the derivative.
double breakpointsNearestToBox(const Triple& c, const Triple& h, const Triple& half) {
  const auto derivative = [&](double s) {
    const Triple p = c + s * h;
    return dot(h, p - within(p, half));
  };
  double low = -1, high = 1;
  double at_low = derivative(low), at_high = derivative(high);
  if (at_low >= 0) return low;
  if (at_high <= 0) return high;
  const double c_i[3] = {c.x, c.y, c.z}, h_i[3] = {h.x, h.y, h.z},
               half_i[3] = {half.x, half.y, half.z};
  for (int i = 0; i < 3; ++i) {
    if (h_i[i] == 0) continue;
    for (const double side : {-half_i[i], half_i[i]}) {
      const double s = (side - c_i[i]) / h_i[i];
      if (!(s > low && s < high)) continue;
      const double value = derivative(s);
      if (value <= 0) {
        low = s;
        at_low = value;
      } else {
        high = s;
        at_high = value;
      }
    }
  }
  return std::clamp(low - at_low * ((high - low) / (at_high - at_low)), low, high);
}

}  // namespace

// No default, so that the compiler lists the cases that a new core must add.
bool hasPointDistance(Core core) {
  switch (core) {
    case Core::kPoint:
    case Core::kSegment:
    case Core::kBox:
    case Core::kCylinder:
    case Core::kCone:
    case Core::kHalfSpace:
      return true;
    case Core::kPoints:
    case Core::kEllipsoid:
      break;
  }
  return false;
}

PointDistance pointDistance(const ConvexView& view, const Vector& p) {
  switch (view.core) {
    case Core::kPoint:
      return fromPoint(p, Vector::Zero());
    case Core::kSegment:
      return fromSegment(view.size.z(), p);
    case Core::kBox:
      return fromBox(view.size, p);
    case Core::kCylinder:
      return fromCylinder(view.size.x(), view.size.z(), p);
    case Core::kCone:
      return fromCone(view.size.x(), view.size.z(), p);
    case Core::kHalfSpace:
      return {p.z(), Vector(p.x(), p.y(), 0), Vector::UnitZ()};
    case Core::kPoints:
    case Core::kEllipsoid:
      break;
  }
  return {std::numeric_limits<double>::quiet_NaN(), Vector::Zero(), Vector::Zero()};
}

double nearestToBox(const Triple& c, const Triple& h, const Triple& half) {
  // The squared distance is convex in s. Its derivative increases and is linear between the
  // breakpoints where a coordinate enters or leaves the box. Newton's step is exact once it is on
  // the root's piece, in most cases after two or three steps.
  constexpr int kSteps = 6;
  const Triple squares = {h.x * h.x, h.y * h.y, h.z * h.z};
  double s = nearestOnSegment(within(c, half) - c, h);
  for (int i = 0; i < kSteps; ++i) {
    const Triple p = c + s * h;
    const Triple out = p - within(p, half);
    const double slope = dot(h, out);
    // (0 if the point is inside; then the slope is 0, too.)
    const BodyLanes x_y = whereNotZero(BodyLanes{out.x, out.y}, BodyLanes{squares.x, squares.y});
    const BodyLanes z = whereNotZero(BodyLanes{out.z, 0}, BodyLanes{squares.z, 0});
    const double curvature = std::max(x_y[0] + x_y[1] + z[0], kInsteadOfZero);
    const double next = within(s - slope / curvature, -1, 1);
    const double size = std::abs(h.x * out.x) + std::abs(h.y * out.y) + std::abs(h.z * out.z);
    if (!(std::abs(slope) > 4 * kUnitRoundoff * size) || next == s) return s;
    s = next;
  }
  return breakpointsNearestToBox(c, h, half);
}

}  // namespace leeway::collision
