#include "collision/convex/pairs/cylinder_pairs.h"

#include "collision/base/tolerances.h"
#include "collision/convex/pairs/closed_form.h"

namespace leeway::collision {

// clang-format off
// Rounding, in units of u L as in simple_answer.h:
//
//   rim point: centre 1, cap 2, radial direction 4 in length and 2 out of the rim's plane,
//     1 or 2 more for each of at most 8 rotations; g 5 and its norm 3                             < 32
//   plane: products with the centre and with the axis 3, the rest across the axis 6, norms 3,
//     the normal's own length 4                                                                   < 24
// clang-format on

namespace {

struct Cylinder {
  Triple c;  // centre
  Triple u;  // axis
  double radius = 0, half = 0;
};

double norm(const Triple& v) { return std::sqrt(squared(v)); }

// A column of a rotation (within kRotationTolerance), normalized, because projections onto the axis
// depend on its length.
Triple unitAxis(const Triple& v) {
  const double squares = squared(v);
  return std::abs(squares - 1) <= 8 * kUnitRoundoff ? v : (1 / std::sqrt(squares)) * v;
}

Cylinder cylinderOf(const Shape& shape, const Triple& center, const Triple& axis) {
  return {center, unitAxis(axis), shape.radius(), shape.halfLength()};
}

// The unit vector along v's part across u; 0 if only rounding is left. Orthogonalized twice,
// because if v is nearly along u, the first pass leaves rounding of v's size.
Triple unitAcross(const Triple& v, const Triple& u) {
  const Triple once = v - dot(v, u) * u, twice = once - dot(once, u) * u;
  const double squares = squared(twice);
  return squares > 64 * kUnitRoundoff * kUnitRoundoff * squared(v)
             ? (1 / std::sqrt(squares)) * twice
             : Triple{};
}

// How far the cylinder reaches from its centre along a unit vector.
double reachOf(const Cylinder& a, const Triple& n) {
  const double along = dot(n, a.u);
  return a.half * std::abs(along) + a.radius * norm(n - along * a.u);
}

// Solids with a closed form for the point nearest to p. project() returns three things: the vector
// g from that point to p; the vector `pull` to p from a point, line or solid whose distance differs
// by a constant; and `bend` = t . dpull/dt, the rate at which `pull` grows with p along the unit
// vector t.
struct SegmentSolid {
  Triple c, h;
  double reachAlong(const Triple& n) const { return std::abs(dot(n, h)); }
  Triple center() const { return c; }
  void project(const Triple& p, const Triple& t, Triple& g, Triple& pull, double& bend) const {
    const Triple from = p - c;
    const double s = nearestOnSegment(from, h);
    g = pull = from - s * h;
    const double along = dot(t, h), squares = squared(h);
    bend = std::abs(s) < 1 && squares > 0 ? 1 - along * along / squares : 1;
  }
};

struct BoxSolid {
  Triple half;
  double reachAlong(const Triple& n) const { return reach(n, half); }
  Triple center() const { return {}; }
  void project(const Triple& p, const Triple& t, Triple& g, Triple& pull, double& bend) const {
    g = pull = p - within(p, half);
    bend = (g.x != 0) * (t.x * t.x) + (g.y != 0) * (t.y * t.y) + (g.z != 0) * (t.z * t.z);
  }
};

struct CylinderSolid {
  const Cylinder& body;
  double reachAlong(const Triple& n) const { return reachOf(body, n); }
  Triple center() const { return body.c; }
  void project(const Triple& p, const Triple& t, Triple& g, Triple& pull, double& bend) const {
    const Triple from = p - body.c;
    const double z = dot(from, body.u), up = z - within(z, -body.half, body.half);
    const Triple radial = from - z * body.u;
    const double from_axis = norm(radial);
    const double out = from_axis > body.radius ? from_axis - body.radius : 0;
    const double per = 1 / (from_axis > 0 ? from_axis : 1);
    g = (out * per) * radial + up * body.u;
    const double along_z = dot(t, body.u), along_radial = dot(t, radial) * per;
    const double z_squared = along_z * along_z, radial_squared = along_radial * along_radial;
    // Next to the side, the distance from the axis has the same minimum, and its square is curved
    // even where the bodies nearly touch.
    pull = up == 0 ? radial : g;
    bend = up == 0 ? 1 - z_squared
                   : z_squared + (out > 0) * (radial_squared +
                                              out * per * (1 - z_squared - radial_squared));
  }
};

// The gap along nearest.normal.
template <class Solid>
void planeOf(const Cylinder& a, const Solid& solid, Nearest& nearest) {
  const Triple& n = nearest.normal;
  nearest.plane = dot(n, solid.center() - a.c) - reachOf(a, n) - solid.reachAlong(n);
}

// Newton steps along the rim, from its point in the direction `radial` to the one nearest to the
// solid. With p = m + r rho and the tangent t, half the square of `pull` has the derivatives
// r pull . t and r^2 (t . dpull/dt) - r pull . rho.
template <class Solid>
inline bool nearestOfRim(const Cylinder& a, double side, Triple radial, const Solid& solid,
                         const Goal& goal, Nearest& nearest) {
  constexpr int kSteps = 8;
  const Triple middle = a.c + (side * a.half) * a.u;
  Triple g, pull;
  for (int i = 0;; ++i) {
    nearest.point_a = middle + a.radius * radial;
    const Triple t = cross(a.u, radial);
    double bend = 0;
    solid.project(nearest.point_a, t, g, pull, bend);
    const double along = dot(pull, t), inwards = -dot(pull, radial);
    // To second order, the rim protrudes from the plane by at most half this share of its radius.
    if (along * along <= kRimNarrow * (inwards * inwards) || i == kSteps) break;
    if (goal.below > 0 && squared(g) < goal.below * goal.below) break;
    const double curvature = a.radius * bend + inwards;
    const double step = -along / curvature;
    if (!(std::abs(step) < 1)) return false;
    const Triple turned = radial + step * t;
    radial = (1 / norm(turned)) * turned;
  }
  nearest.apart = norm(g);
  nearest.normal = (-1 / nearest.apart) * g;
  planeOf(a, solid, nearest);
  return nearest.apart > 0;
}

// The unit vector across A's axis towards p; an arbitrary one if p is on the axis.
Triple radialTowards(const Cylinder& a, const Triple& p) {
  const Triple v = unitAcross(p - a.c, a.u);
  if (squared(v) > 0) return v;
  return unitAcross(std::abs(a.u.x) < 0.6 ? Triple{1, 0, 0} : Triple{0, 1, 0}, a.u);
}

// The distance by which p + radius n misses the side of a cylinder with axis u, for p on the axis
// but not at an end, and n nearly across u. Moving it along the axis by at most this distance is
// enough.
double tiltOf(const Triple& n, const Triple& u, double radius) {
  return std::abs(dot(n, u)) * radius;
}

// Two sides are nearest where their axes are nearest: p is on A's axis, p + w on the other's (or on
// a box).
bool sidesMeet(const Cylinder& a, const Triple& p, const Triple& w, double other_radius,
               Nearest& nearest) {
  const double length = norm(w);
  nearest.normal = (1 / length) * w;
  nearest.apart = length - a.radius - other_radius + tiltOf(nearest.normal, a.u, a.radius);
  nearest.point_a = p + a.radius * nearest.normal;
  return nearest.apart > 0;
}

// The point of a cylinder that is farthest along a unit vector.
Triple farthestPoint(const Cylinder& a, const Triple& n) {
  return a.c + std::copysign(a.half, dot(n, a.u)) * a.u + a.radius * unitAcross(n, a.u);
}

// The farthest point along the axis, where the whole cap is equally far: the one nearest to
// `towards`.
Triple farthestOfCap(const Cylinder& a, const Triple& n, const Triple& towards) {
  const Triple end = a.c + std::copysign(a.half, dot(n, a.u)) * a.u;
  const Triple v = towards - end, w = v - dot(v, a.u) * a.u;
  const double length = norm(w);
  return length <= a.radius ? end + w : end + (a.radius / length) * w;
}

// A's cap and p, the other body's point nearest to the cap's plane. True if p is above the cap.
bool capMeets(const Cylinder& a, const Triple& p, Nearest& nearest) {
  const Triple from = p - a.c;
  const double z = dot(from, a.u);
  const Triple radial = from - z * a.u;
  nearest.apart = std::abs(z) - a.half;
  nearest.normal = std::copysign(1.0, z) * a.u;
  nearest.point_a = a.c + std::copysign(a.half, z) * a.u + radial;
  return nearest.apart > 0 && squared(radial) <= a.radius * a.radius;
}

}  // namespace

bool nearestOfCylinderAndPoint(const Shape& cylinder, const Pose& X_WC, const Pose& X_WP,
                               Nearest& nearest) {
  // In the world's axes, with the point at the origin.
  const Triple from = tripleOf(X_WP.translation) - tripleOf(X_WC.translation);
  const Cylinder a = cylinderOf(cylinder, -from, column(X_WC.rotation, 2));
  const Triple& u = a.u;
  const double z = dot(from, u), half = a.half, radius = a.radius;
  const double up = z - within(z, -half, half);
  const Triple radial = from - z * u;
  const double from_axis = norm(radial);
  const double out = from_axis > radius ? from_axis - radius : 0;
  const Triple g = (out / (from_axis > 0 ? from_axis : 1)) * radial + up * u;
  nearest.apart = norm(g);
  nearest.normal = (1 / nearest.apart) * g;
  nearest.plane = dot(nearest.normal, from) - reachOf(a, nearest.normal);
  nearest.point_a = -g;
  return nearest.apart > 0;
}

bool nearestOfCylinderAndCapsule(const Shape& cylinder, const Pose& X_WC, const Shape& capsule,
                                 const Pose& X_WB, Nearest& nearest) {
  const Cylinder a = cylinderOf(cylinder, tripleOf(X_WC.translation) - tripleOf(X_WB.translation),
                                column(X_WC.rotation, 2));
  const SegmentSolid b = {{}, capsule.halfLength() * column(X_WB.rotation, 2)};
  const double height = -dot(a.c, a.u), rise = dot(b.h, a.u);
  const double gap = std::abs(height) - a.half - std::abs(rise);
  if (gap > 0) {
    const Triple end = std::copysign(1.0, -height * rise) * b.h;
    if (capMeets(a, end, nearest)) {
      planeOf(a, b, nearest);
      return true;
    }
  }
  double s_a = 0, s_b = 0;
  const Triple v = column(X_WB.rotation, 2);
  nearestOnAxes(dot(a.u, v), dot(a.c, a.u), dot(a.c, v), a.half, capsule.halfLength(), s_a, s_b);
  const Triple q = s_b * v, p = a.c + s_a * a.u;
  if (std::abs(s_a) < a.half) {
    if (!sidesMeet(a, p, q - p, 0, nearest)) return false;
    planeOf(a, b, nearest);
    return true;
  }
  return nearestOfRim(a, std::copysign(1.0, s_a), radialTowards(a, q), b, {}, nearest);
}

bool nearestOfCylinders(const Shape& shape_a, const Pose& X_WA, const Shape& shape_b,
                        const Pose& X_WB, const Goal& goal, Nearest& nearest) {
  const Cylinder a = cylinderOf(shape_a, tripleOf(X_WA.translation) - tripleOf(X_WB.translation),
                                column(X_WA.rotation, 2));
  const Cylinder b = cylinderOf(shape_b, {}, column(X_WB.rotation, 2));
  const double cosine = dot(a.u, b.u), sine = norm(a.u - cosine * b.u);
  const double along_a = dot(a.c, a.u), along_b = dot(a.c, b.u);
  const double gap_a = std::abs(along_a) - a.half - b.half * std::abs(cosine) - b.radius * sine;
  const double gap_b = std::abs(along_b) - b.half - a.half * std::abs(cosine) - a.radius * sine;
  const double gap = std::max(gap_a, gap_b);
  // Ends early if a cap's plane or two points of the axes decide the threshold.
  const auto settle = [&](const Triple& p, const Triple& w) {
    nearest.settle(
        p, w,
        gap_a >= gap_b ? std::copysign(1.0, -along_a) * a.u : std::copysign(1.0, -along_b) * b.u,
        gap);
    return true;
  };
  if (gap > goal.above) {
    const Triple p = farthestPoint(a, -a.c), q = farthestPoint(b, p);
    return settle(p, q - p);
  }
  if (gap_a > 0 && gap_a >= gap_b) {
    const Triple towards_a = std::copysign(1.0, along_a) * a.u;
    if (capMeets(a, farthestPoint(b, towards_a), nearest) ||
        (sine * sine <= kSameDirectionSquared &&
         capMeets(a, farthestOfCap(b, towards_a, a.c), nearest))) {
      planeOf(a, CylinderSolid{b}, nearest);
      return true;
    }
  } else if (gap_b > 0) {
    const Triple towards_b = std::copysign(1.0, -along_b) * b.u;
    if (capMeets(b, farthestPoint(a, towards_b), nearest) ||
        (sine * sine <= kSameDirectionSquared &&
         capMeets(b, farthestOfCap(a, towards_b, b.c), nearest))) {
      planeOf(b, CylinderSolid{a}, nearest);
      nearest.point_a = nearest.point_a + nearest.apart * nearest.normal;
      nearest.normal = -nearest.normal;
      return true;
    }
  }
  double s_a = 0, s_b = 0;
  nearestOnAxes(cosine, along_a, along_b, a.half, b.half, s_a, s_b);
  const Triple p = a.c + s_a * a.u, q = s_b * b.u;
  if (goal.below > 0 && squared(q - p) < goal.below * goal.below) return settle(p, q - p);
  const bool inner_a = std::abs(s_a) < a.half, inner_b = std::abs(s_b) < b.half;
  if (inner_a && inner_b) {
    if (!sidesMeet(a, p, q - p, b.radius, nearest)) return false;
    nearest.apart += tiltOf(nearest.normal, b.u, b.radius);
    planeOf(a, CylinderSolid{b}, nearest);
    return true;
  }
  // Tries the rims at the axes' nearest points first, then those nearest to inner points.
  const double narrow = kPairNarrow * (a.radius + a.half + b.radius + b.half);
  const auto enough = [&] {
    return nearest.apart - nearest.plane <= narrow || nearest.apart < goal.below;
  };
  for (const bool inner : {false, true}) {
    if (inner_a == inner) {
      const double side = std::copysign(1.0, inner ? dot(q - a.c, a.u) : s_a);
      if (nearestOfRim(a, side, radialTowards(a, q), CylinderSolid{b}, goal, nearest) && enough()) {
        return true;
      }
    }
    if (inner_b == inner) {
      const double side = std::copysign(1.0, inner ? dot(p, b.u) : s_b);
      if (nearestOfRim(b, side, radialTowards(b, p), CylinderSolid{a}, goal, nearest) && enough()) {
        nearest.point_a = nearest.point_a + nearest.apart * nearest.normal;
        nearest.normal = -nearest.normal;
        return true;
      }
    }
  }
  return false;
}

bool nearestOfCylinderAndBox(const Shape& cylinder, const Pose& X_WC, const Shape& box,
                             const Pose& X_WB, const Goal& goal, Nearest& nearest) {
  const Eigen::Matrix3d& R = X_WB.rotation;
  const Triple d = tripleOf(X_WC.translation) - tripleOf(X_WB.translation);
  const Cylinder a =
      cylinderOf(cylinder, rotatedBack(R, d), rotatedBack(R, column(X_WC.rotation, 2)));
  const BoxSolid b = {tripleOf(box.halfExtents())};
  const Triple& half = b.half;
  const auto done = [&] {
    toWorld(R, nearest);
    return true;
  };
  const Triple& u = a.u;
  const Triple squares = {u.x * u.x, u.y * u.y, u.z * u.z};
  const double gap_x = std::abs(a.c.x) - half.x - a.half * std::abs(u.x) -
                       a.radius * std::sqrt(squares.y + squares.z);
  const double gap_y = std::abs(a.c.y) - half.y - a.half * std::abs(u.y) -
                       a.radius * std::sqrt(squares.z + squares.x);
  const double gap_z = std::abs(a.c.z) - half.z - a.half * std::abs(u.z) -
                       a.radius * std::sqrt(squares.x + squares.y);
  const double along = dot(a.c, u);
  const double gap_cap = std::abs(along) - a.half - reach(u, half);
  const double gap_face = std::max(gap_x, std::max(gap_y, gap_z));
  const bool on_cap = gap_cap >= gap_face;
  const double gap = on_cap ? gap_cap : gap_face;
  // The widest gap's normal, from A to the box.
  const Triple n = on_cap              ? std::copysign(1.0, -along) * u
                   : gap_face == gap_x ? Triple{std::copysign(1.0, -a.c.x), 0, 0}
                   : gap_face == gap_y ? Triple{0, std::copysign(1.0, -a.c.y), 0}
                                       : Triple{0, 0, std::copysign(1.0, -a.c.z)};
  if (gap > goal.above) {
    const Triple p = farthestPoint(a, n);
    nearest.settle(p, within(p, half) - p, n, gap);
    return done();
  }
  if (gap > 0 && on_cap) {
    const Triple corner = {std::copysign(half.x, -n.x), std::copysign(half.y, -n.y),
                           std::copysign(half.z, -n.z)};
    if (capMeets(a, corner, nearest)) {
      nearest.plane = gap;
      return done();
    }
  } else if (gap > 0) {
    nearest.normal = n;
    nearest.plane = gap;
    // True if only the face's coordinate of p is outside the box.
    const auto faceMeets = [&](const Triple& p) {
      const Triple w = within(p, half) - p;
      nearest.point_a = p;
      nearest.apart = dot(w, n);
      return (w.x != 0) + (w.y != 0) + (w.z != 0) == 1 && nearest.apart > 0;
    };
    if (faceMeets(farthestPoint(a, n))) return done();
    const double cosine = dot(n, u);
    if (squared(n - cosine * u) <= kSameDirectionSquared) {
      const Triple end = a.c + std::copysign(a.half, cosine) * u;
      if (faceMeets(farthestOfCap(a, n, within(end, half)))) return done();
    }
  }
  const Triple h = a.half * u;
  const double s = nearestToBox(a.c, h, half);
  const Triple p = a.c + s * h, q = within(p, half);
  if (goal.below > 0 && squared(q - p) < goal.below * goal.below) {
    nearest.settle(p, q - p, n, gap);
    return done();
  }
  if (std::abs(s) < 1 && a.half > 0) {
    if (!sidesMeet(a, p, q - p, 0, nearest)) return false;
    planeOf(a, b, nearest);
    return done();
  }
  return nearestOfRim(a, s, radialTowards(a, q), b, goal, nearest) && done();
}

}  // namespace leeway::collision
