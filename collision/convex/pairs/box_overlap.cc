#include "collision/convex/pairs/box_overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/convex/pairs/closed_form.h"

namespace leeway::collision {

// clang-format off
// Rounding, in units of u L (see gjk.cc). X_BA is taken as the affine map that it is, and A as the
// parallelepiped that it makes.
//
//   axes of B                           exact
//   cross products with them            exact except for their length, 3
//   normals of A's faces                7
//   the overlap along a unit axis       3 |t|, 11 extent A and 6 extent B, and as many units of L as the axis errs by
//
// In sum less than 22, within kSupportRounding. A cross product whose square leaves the range of double
// belongs to edges that are parallel to within 1e-150: without it the box is another one by as much.
// clang-format on

namespace {

struct Boxes {
  Vector axis_a[3];  // A's half edges
  Vector t;          // A's centre
  Vector half_b;
};

struct Axis {
  Vector n = Vector::UnitX();  // unit, from A to B
  double apart = -std::numeric_limits<double>::infinity();
};

// The gap of the boxes along an axis of any length, times that length, and the length squared.
struct Gap {
  double apart, length_squared;
};

Gap gapAlong(const Boxes& boxes, double x, double y, double z) {
  const auto along = [&](const Vector& v) { return std::abs(x * v.x() + y * v.y() + z * v.z()); };
  const double reach = std::abs(x) * boxes.half_b.x() + std::abs(y) * boxes.half_b.y() +
                       std::abs(z) * boxes.half_b.z();
  const double apart = along(boxes.t) - along(boxes.axis_a[0]) - along(boxes.axis_a[1]) -
                       along(boxes.axis_a[2]) - reach;
  return {apart, x * x + y * y + z * z};
}

// The axis of least overlap; the first of equals.
Axis bestAxis(const Boxes& boxes, const Eigen::Matrix3d& R) {
  Vector axes[15];
  for (int i = 0; i < 3; ++i) {
    axes[i] = Vector::Unit(i);
    axes[3 + i] = cross(R.col((i + 1) % 3), R.col((i + 2) % 3));
    const double x = R(0, i), y = R(1, i), z = R(2, i);
    axes[6 + 3 * i] = {0, -z, y};
    axes[7 + 3 * i] = {z, 0, -x};
    axes[8 + 3 * i] = {-y, x, 0};
  }
  // One loop without dependencies, so that roots and quotients overlap.
  double apart[15], length[15];
  for (int i = 0; i < 15; ++i) {
    const Gap gap = gapAlong(boxes, axes[i].x(), axes[i].y(), axes[i].z());
    length[i] = std::sqrt(gap.length_squared);
    apart[i] =
        gap.length_squared > 0 ? gap.apart / length[i] : -std::numeric_limits<double>::infinity();
  }
  int best = 0;
  for (int i = 1; i < 15; ++i) best = apart[i] > apart[best] ? i : best;
  const double side = axes[best].dot(boxes.t) > 0 ? -1 : 1;
  return {side / length[best] * axes[best], apart[best]};
}

// The feature of a box that is farthest along a direction: a corner, edge or face. It includes
// edges that are perpendicular to the direction within kPerpendicularEdge.
struct Feature {
  Vector center;
  Vector half[2];  // half edges
  int dimension = 0;
};

Feature farthestFeature(const Vector& center, const Vector half[3], const Vector& n) {
  Feature f;
  f.center = center;
  for (int k = 0; k < 3; ++k) {
    const double along = n.dot(half[k]), length_squared = half[k].squaredNorm();
    if (length_squared == 0) continue;
    if (f.dimension < 2 &&
        along * along <= kPerpendicularEdge * kPerpendicularEdge * length_squared) {
      f.half[f.dimension++] = half[k];
    } else {
      f.center += along < 0 ? Vector(-half[k]) : half[k];
    }
  }
  return f;
}

// The coordinate of p - center along a half edge, as a fraction of that half edge.
double coordinate(const Feature& f, int i, const Vector& p) {
  const double squared = f.half[i].squaredNorm();
  return squared > 0 ? f.half[i].dot(p - f.center) / squared : 0;
}

Vector clamped(const Feature& f, const Vector& p) {
  Vector q = f.center;
  for (int i = 0; i < f.dimension; ++i) {
    q += std::clamp(coordinate(f, i, p), -1.0, 1.0) * f.half[i];
  }
  return q;
}

// Clips a convex polygon to sign * coordinate <= 1 (Sutherland and Hodgman 1974). Each cut adds at
// most one vertex.
int cut(const Feature& f, int i, double sign, Vector polygon[12], int count) {
  Vector result[12];
  int kept = 0;
  for (int k = 0; k < count; ++k) {
    const Vector &p = polygon[k], &q = polygon[(k + 1) % count];
    const double at_p = 1 - sign * coordinate(f, i, p), at_q = 1 - sign * coordinate(f, i, q);
    if (at_p >= 0) result[kept++] = p;
    if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0)) {
      result[kept++] = p + (at_p / (at_p - at_q)) * (q - p);
    }
  }
  std::copy(result, result + kept, polygon);
  return kept;
}

// The middle of the intersection of f with `of`, which touches f or misses it by rounding; the
// point is on f.
Vector shared(const Feature& f, const Feature& of) {
  Vector polygon[12];
  int count = 0;
  if (of.dimension == 2) {
    polygon[0] = of.center - of.half[0] - of.half[1];
    polygon[1] = of.center + of.half[0] - of.half[1];
    polygon[2] = of.center + of.half[0] + of.half[1];
    polygon[3] = of.center - of.half[0] + of.half[1];
    count = 4;
  } else {
    polygon[0] = of.center - of.half[0];
    polygon[1] = of.center + of.half[0];
    count = 2;
  }
  for (int i = 0; i < f.dimension; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      Vector before[12];
      std::copy(polygon, polygon + count, before);
      const int kept = cut(f, i, sign, polygon, count);
      // Rounding may leave nothing; the polygon before the cut is then close enough.
      if (kept > 0) {
        count = kept;
      } else {
        std::copy(before, before + count, polygon);
      }
    }
  }
  Vector middle = polygon[0];
  for (int k = 1; k < count; ++k) middle += (1.0 / (k + 1)) * (polygon[k] - middle);
  return clamped(f, middle);
}

// A point of A's feature that, moved by w, is on B's.
Vector touching(Feature of_a, const Feature& of_b, const Vector& w) {
  of_a.center += w;
  Vector p;
  if (of_a.dimension == 0) {
    p = of_a.center;
  } else if (of_b.dimension == 0) {
    p = clamped(of_a, of_b.center);
  } else if (of_a.dimension == 1 && of_b.dimension == 1) {
    double s_a = 0, s_b = 0;
    nearestOnSegments(tripleOf(of_a.center), tripleOf(of_a.half[0]), tripleOf(of_b.center),
                      tripleOf(of_b.half[0]), s_a, s_b);
    p = of_a.center + s_a * of_a.half[0];
  } else if (of_b.dimension == 2) {
    p = clamped(of_a, shared(of_b, of_a));
  } else {
    p = shared(of_a, of_b);
  }
  return p - w;
}

}  // namespace

bool offerBoxOverlap(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                     Progress& progress) {
  const Eigen::Matrix3d& R = X_BA.rotation;
  const Boxes boxes{{R.col(0) * a.size.x(), R.col(1) * a.size.y(), R.col(2) * a.size.z()},
                    X_BA.translation,
                    b.size};
  const Axis best = bestAxis(boxes, R);
  progress.offerLower(best.apart, best.n);
  if (best.apart > 0) return false;
  const Vector half_b[3] = {Vector(b.size.x(), 0, 0), Vector(0, b.size.y(), 0),
                            Vector(0, 0, b.size.z())};
  const Vector w = best.apart * best.n;
  const Vector point_a = touching(farthestFeature(boxes.t, boxes.axis_a, best.n),
                                  farthestFeature(Vector::Zero(), half_b, -best.n), w);
  progress.offerWitness(best.apart, w, point_a);
  return true;
}

}  // namespace leeway::collision
