#include "collision/convex/round_depth/tilted_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collision/base/pose_check.h"
#include "collision/base/sine_cosine.h"
#include "collision/base/tolerances.h"
#include "collision/convex/round_depth/parallel_axes.h"

namespace leeway::collision {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Cells of both circles [count]: some hundred microseconds. Most queries look at a tenth of them.
constexpr int kTiltedCells = 2048;
// Halvings of an eighth of a circle.
constexpr int kTiltedHalvings = 40;

// The two rims of a body of revolution: where along its axis, the upper one first, and how wide.
struct Rims {
  double along[2], radius[2];
};

Rims rimsOf(const ConvexView& view) {
  const double r = view.size.x(), h = view.size.z();
  switch (view.core) {
    case Core::kSegment:
      return {{h, -h}, {0, 0}};
    case Core::kCylinder:
      return {{h, -h}, {r, r}};
    default:
      return {{h, -h}, {0, r}};
  }
}

// Upside down.
Rims turnedOver(const Rims& rims) {
  return {{-rims.along[1], -rims.along[0]}, {rims.radius[1], rims.radius[0]}};
}

// The directions in which both rims are equally far, by their parts along and across the axis.
struct Kink {
  double along = 0, across = 0;
};

Kink kinkOf(const Rims& rims) {
  const double height = rims.along[0] - rims.along[1], wider = rims.radius[1] - rims.radius[0];
  const double length = std::sqrt(height * height + wider * wider);
  return length > 0 ? Kink{wider / length, height / length} : Kink{};
}

// h on a circle of directions around one axis, by the angle from `first` to `second`: what is
// constant of it, what goes with the cosine and the sine, and the farther of the other body's two
// rims, by the part along that body's axis: middle + along_cosine cos + along_sine sin.
struct Circle {
  Vector center, first, second;
  double constant = 0, cosine = 0, sine = 0;
  double middle = 0, along_cosine = 0, along_sine = 0;
  Rims rims;
  double bend[2] = {0, 0};  // bounds of the second derivatives
  double steepest = 0;      // how much the rims' part grows with an error of that along the axis
};

// center, first and second: the kink's direction along the axis, and across it to two sides.
// Nothing when the other axis comes too near to be across.
bool makeCircle(const Vector& axis, const Vector& first, const Vector& second, const Rims& rims,
                const Kink& kink, const Vector& other_axis, const Rims& other, const Vector& t,
                Circle& circle) {
  circle.center = kink.along * axis;
  circle.first = kink.across * first;
  circle.second = kink.across * second;
  circle.constant = std::max(rims.along[0] * kink.along + rims.radius[0] * kink.across,
                             rims.along[1] * kink.along + rims.radius[1] * kink.across) -
                    circle.center.dot(t);
  circle.cosine = -circle.first.dot(t);
  circle.sine = -circle.second.dot(t);
  circle.middle = circle.center.dot(other_axis);
  circle.along_cosine = circle.first.dot(other_axis);
  circle.along_sine = circle.second.dot(other_axis);
  circle.rims = other;
  const double swing = std::hypot(circle.along_cosine, circle.along_sine);
  const double most = std::abs(circle.middle) + swing;
  const double across_squared = 1 - most * most;
  if (!(across_squared > kTiltedAcross)) return false;
  const double across = std::sqrt(across_squared);
  circle.steepest = std::max(other.radius[0], other.radius[1]) * most / across;
  for (int i = 0; i < 2; ++i) {
    // Of z s + r sqrt(1 - s^2), s the part along the axis: s and its derivatives are at most the
    // swing, and the root's derivatives s / across and 1 / across^3.
    circle.bend[i] =
        kGrowthOutwards * (std::hypot(circle.cosine, circle.sine) +
                           swing * (std::abs(other.along[i]) + other.radius[i] * most / across) +
                           swing * swing * other.radius[i] / (across * across_squared));
  }
  return true;
}

// h with either rim of the other body, and the derivatives.
struct AtAngle {
  double value[2], slope[2];
  int farther() const { return value[1] > value[0] ? 1 : 0; }
};

AtAngle at(const Circle& circle, double angle) {
  double sine = 0, cosine = 1;
  sineCosine(angle, sine, cosine);
  const double s = circle.middle + circle.along_cosine * cosine + circle.along_sine * sine;
  const double across = std::sqrt(1 - s * s);
  const double turn = circle.along_sine * cosine - circle.along_cosine * sine;
  const double rest = circle.constant + circle.cosine * cosine + circle.sine * sine;
  const double rest_turn = circle.sine * cosine - circle.cosine * sine;
  AtAngle result;
  for (int i = 0; i < 2; ++i) {
    result.value[i] = rest + circle.rims.along[i] * s + circle.rims.radius[i] * across;
    result.slope[i] =
        rest_turn + turn * (circle.rims.along[i] - circle.rims.radius[i] * s / across);
  }
  return result;
}

// The least of h on circles: proven, and met at an angle in a cell.
struct Least {
  double proven = kInfinity, met = kInfinity;
  const Circle* circle = nullptr;
  double angle = 0, half_width = 0;
};

// Looks on until nothing is left that is more than `gap` below what was met and below
// `of_interest`, or `cells` are used up.
void search(const Circle& circle, double gap, double of_interest, int& cells, Least& least) {
  struct Cell {
    double middle;
    int halvings;
  };
  // Depth first: two cells a halving, and the first eight.
  Cell stack[kTiltedHalvings + 9];
  int count = 0;
  for (int k = 0; k < 8; ++k) stack[count++] = {(2 * k + 1) * (std::numbers::pi / 8), 0};
  while (count > 0) {
    const Cell cell = stack[--count];
    const double half_width = std::ldexp(std::numbers::pi / 8, -cell.halvings);
    const AtAngle here = at(circle, cell.middle);
    double lower = -kInfinity;
    for (int i = 0; i < 2; ++i) {
      lower = std::max(lower, here.value[i] - half_width * (std::abs(here.slope[i]) +
                                                            0.5 * circle.bend[i] * half_width));
    }
    const double value = here.value[here.farther()];
    if (value < least.met) {
      least.met = value;
      least.circle = &circle;
      least.angle = cell.middle;
      least.half_width = half_width;
    }
    if (lower >= std::min(least.met - gap, of_interest) || cell.halvings == kTiltedHalvings ||
        cells == 0) {
      least.proven = std::min(least.proven, lower);
      continue;
    }
    --cells;
    for (const double side : {-0.5, 0.5}) {
      stack[count++] = {cell.middle + side * half_width, cell.halvings + 1};
    }
  }
}

// Downhill from where the least value was met, by halves: the value is good enough there, but the
// member that carries it lies across by its slope.
double settledAngle(const Least& least) {
  double angle = least.angle;
  for (double step = least.half_width; step > kSettledAngle; step *= 0.5) {
    const AtAngle here = at(*least.circle, angle);
    angle -= std::copysign(step, here.slope[here.farther()]);
  }
  return angle;
}

// How far the planes next to a cap, up to an angle of that sine and cosine from B's axis, are at
// least; the other cap is that of the rims turned over.
double leastOfCap(const Rims& a, const Rims& b, double along, double across, double p, double sine,
                  double cosine) {
  const double cap = b.along[0] + a.along[0] - along;
  const double margin = b.radius[0] + a.radius[0] - across - std::abs(a.along[0]) * p;
  // (a . b is less than 1 by less than p^2.)
  return cosine * (cap - std::abs(a.along[0]) * p * p) + sine * std::min(margin, 0.0) -
         1.01 * p * a.radius[0];
}

// The member of the difference next to depth * n on what is farthest along n: a point of B's side
// less one of A's.
void memberAlong(const Vector& n, double depth, const Vector& axis_a, const Rims& a,
                 const Vector& t, const Rims& b, Vector& w, Vector& point_a) {
  const auto across = [](const Vector& axis, const Vector& v) {
    const Vector part = v - v.dot(axis) * axis;
    const double length = part.norm();
    return length > 0 ? Vector(part / length) : Vector::Zero();
  };
  const Vector out_a = across(axis_a, n), out_b = across(Vector::UnitZ(), n);
  Vector of_a[2], of_b[2];
  for (int i = 0; i < 2; ++i) {
    of_a[i] = t - (a.along[i] * axis_a + a.radius[i] * out_a);
    of_b[i] = b.along[i] * Vector::UnitZ() + b.radius[i] * out_b;
  }
  // |start + l e + m g| least for l and m in [0, 1].
  const Vector start = of_b[0] - of_a[0] - depth * n, e = of_b[1] - of_b[0], g = of_a[0] - of_a[1];
  const double ee = e.dot(e), eg = e.dot(g), gg = g.dot(g), se = start.dot(e), sg = start.dot(g);
  double best = kInfinity, l_best = 0, m_best = 0;
  const auto offer = [&](double l, double m) {
    const double squared = (start + l * e + m * g).squaredNorm();
    if (squared < best) best = squared, l_best = l, m_best = m;
  };
  const auto clamped = [](double value, double by) {
    return by > 0 ? std::clamp(value / by, 0.0, 1.0) : 0.0;
  };
  for (const double end : {0.0, 1.0}) {
    offer(end, clamped(-sg - end * eg, gg));
    offer(clamped(-se - end * eg, ee), end);
  }
  const double determinant = ee * gg - eg * eg;
  if (determinant > 0) {
    offer(clamped(eg * sg - gg * se, determinant), clamped(eg * se - ee * sg, determinant));
  }
  point_a = of_a[0] - m_best * g;
  w = of_b[0] + l_best * e - point_a;
}

}  // namespace

// Rounding, in units of u L with L = extent A + extent B + |t|: the constant of a circle errs by 8,
// the parts that go with the angle by 8 each, a value by 8 more, directions of the circle around A
// by 4 that are not across its axis; the angle's by 4 of what bends, below L; kTiltedRounding in
// all. The part along the other axis errs by 6 u besides, which the root beside it magnifies. A's
// columns may depart from a rotation: the body meant is within one and a half of that of one whose
// axis is exactly as used here (half of it the points, all of it the axis).
bool offerTiltedAxes(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                     Difference<false>& difference, Progress& progress) {
  const Vector column = X_BA.rotation.col(2);
  const double p = kGrowthOutwards * std::sqrt(column.x() * column.x() + column.y() * column.y()) /
                   column.norm();
  if (!(p <= kTiltedAxes)) return false;
  const bool against = column.z() < 0;
  const Vector axis_a = (against ? -column : column) / column.norm();
  const Vector axis_b = Vector::UnitZ();
  const Vector& t = X_BA.translation;
  // What A takes off: its points, negated.
  const Rims of_b = rimsOf(b), of_a = against ? rimsOf(a) : turnedOver(rimsOf(a));
  const Kink kink_a = kinkOf(of_a), kink_b = kinkOf(of_b);

  const double unit = progress.query().roundoff;
  const DistanceRequest& request = progress.query().request;
  const double allowed =
      request.tolerance - (progress.query().lower_offset - progress.query().upper_offset);
  const double gap = std::max(0.25 * allowed, 2 * unit);
  const double across = std::sqrt(t.x() * t.x() + t.y() * t.y());
  const auto leastOfCaps = [&](double sine, double cosine) {
    return std::min(
        leastOfCap(of_a, of_b, t.z(), across, p, sine, cosine),
        leastOfCap(turnedOver(of_a), turnedOver(of_b), -t.z(), across, p, sine, cosine));
  };
  const double caps = leastOfCaps(0, 1);
  Circle around_a, around_b;
  Least least;
  int cells = kTiltedCells;
  if (kink_b.across > 0) {
    if (!makeCircle(axis_b, Vector::UnitX(), Vector::UnitY(), of_b, kink_b, axis_a, of_a, t,
                    around_b)) {
      return false;
    }
    search(around_b, gap, caps, cells, least);
  }
  if (kink_a.across > 0) {
    Vector first(1 - axis_a.x() * axis_a.x(), -axis_a.x() * axis_a.y(), -axis_a.x() * axis_a.z());
    first /= first.norm();
    if (!makeCircle(axis_a, first, cross(axis_a, first), of_a, kink_a, axis_b, of_b, t, around_a)) {
      return false;
    }
    search(around_a, gap, caps, cells, least);
  }
  if (least.circle == nullptr) return false;
  double sine = 0, cosine = 1;
  sineCosine(settledAngle(least), sine, cosine);
  const Vector outward =
      (least.circle->center + cosine * least.circle->first + sine * least.circle->second)
          .normalized();
  SupportPoint lowest;
  ++progress.iterations;
  difference.support(-outward, lowest);
  const double plane = -outward.dot(lowest.w);
  progress.offerLower(plane, -outward);

  const double depth = least.proven - kTiltedRounding * unit -
                       6 * kUnitRoundoff * std::max(around_a.steepest, around_b.steepest) -
                       1.5 * kFirstOrderOutwards * departureOf(X_BA.rotation) * a.extent;
  if (!(depth > 0)) return false;
  // How far from across the axes the sides alone decide.
  const double widest = std::max(of_a.radius[0], of_a.radius[1]);
  double reach = 0;
  for (const double far : kTiltedReaches) {
    const double root = std::sqrt(1 + far * far);
    if (!(widest * p * p * root * root * root <= depth * (1 - (far + 2) * p))) break;
    reach = far;
  }
  if (!(reach > 0)) return false;
  cosine = reach / std::sqrt(1 + reach * reach);
  sine = cosine / reach;
  if (!(leastOfCaps(sine, cosine) - kTiltedRounding * unit >= depth)) return false;
  Vector w, point_a;
  memberAlong(outward, depth, axis_a, of_a, t, of_b, w, point_a);
  // The offset of an upper end has kSupportRounding units of the rounding once more.
  const double upper = -(depth + kSupportRounding * unit);
  if (!progress.offerTogether(upper, w, point_a, plane, -outward)) {
    progress.offerWitness(upper, w, point_a);
  }
  return true;
}

}  // namespace leeway::collision
