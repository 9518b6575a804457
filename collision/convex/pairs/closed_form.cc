#include "collision/convex/pairs/closed_form.h"

#include <algorithm>
#include <cstdint>

#include "collision/base/pose_check.h"

namespace leeway::collision {

// Rounding: every result below is a chain of clamps (exact), one difference per coordinate (1 unit
// of extent + |p|), a norm (3 units) and, for cylinder and cone, a distance from the axis (3 units)
// and a product with a unit vector (4 units). A square root of a sum of squares does not amplify
// absolute errors. Less than 16 units in all; kClosedFormRounding doubles that.

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
  // A point on the segment leaves it sideways; off its ends that cannot be (norm is 0 there only).
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
  // Inside: out through the nearest face. (Also when d is so small that its square is 0: an error
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
  // (The planes of a flat cone do not end at its rim, nor those of a thin one at its apex.)
  if (from_slant <= 0 && from_base <= 0 && plane.across <= radius && p.z() <= half_length) {
    if (from_base > from_slant) {
      return {from_base, plane.point(plane.across, -half_length), -Vector::UnitZ()};
    }
    return {
        from_slant,
        plane.point(plane.across - from_slant * normal_across, p.z() - from_slant * normal_along),
        normal_across * plane.radial + normal_along * Vector::UnitZ()};
  }
  // Outside. Over the base or the slant the direction is theirs: as a difference of two points it
  // would be lost near contact.
  if (from_base > 0 && plane.across <= radius) {
    return {from_base, plane.point(plane.across, -half_length), -Vector::UnitZ()};
  }
  // Way along the slant beyond the apex and the rim, each by differences from there: next to them
  // they are known as well as the point is. (As a share of the slant they would not be, and beside
  // the apex any direction across the axis would be taken, along which the cone is farther out.)
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

// y, lane by lane 0 where x is.
BodyLanes whereNotZero(BodyLanes x, BodyLanes y) {
  using Bits = std::int64_t __attribute__((vector_size(16)));
  return reinterpret_cast<BodyLanes>((x != BodyLanes{0, 0}) & reinterpret_cast<Bits>(y));
}

// nearestToBox() by looking at all places where the derivative bends.
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

bool hasPointDistance(Core core) { return core != Core::kPoints && core != Core::kEllipsoid; }

PointDistance pointDistance(const ConvexView& view, const Vector& p) {
  switch (view.core) {
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
    default:
      return fromPoint(p, Vector::Zero());
  }
}

double nearestToBox(const Triple& c, const Triple& h, const Triple& half) {
  // The squared distance is convex in s, its derivative increasing and linear between the places
  // where a coordinate enters or leaves the box. Newton's steps end on the root as soon as they
  // meet its piece: after two or three, mostly.
  constexpr int kSteps = 6;
  const Triple squares = {h.x * h.x, h.y * h.y, h.z * h.z};
  double s = nearestOnSegment(within(c, half) - c, h);
  for (int i = 0; i < kSteps; ++i) {
    const Triple p = c + s * h;
    const Triple out = p - within(p, half);
    const double slope = dot(h, out);
    // (None where all of h is inside: no slope, either.)
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
