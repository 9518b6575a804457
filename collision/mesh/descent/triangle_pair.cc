#include "collision/mesh/descent/triangle_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"

namespace leeway::collision {
namespace {

double ratio(double numerator, double denominator) {
  return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
}

struct Search {
  const Vector *p, *q;
  TrianglePair best;
  double squared = std::numeric_limits<double>::infinity();
  bool has_normal = false;  // best.normal is set, from a triangle's plane

  // Accepts two points if they are closer. True if the planes through them, across their connecting
  // line, have both triangles on their far sides: no points are closer in that case.
  bool offer(const Vector& a, const Vector& b) {
    const Vector d = b - a;
    const double now = d.squaredNorm();
    if (!(now < squared)) return false;
    squared = now;
    best.p = a;
    best.q = b;
    if (!(now > 0)) return false;
    const double top = std::max({d.dot(p[0]), d.dot(p[1]), d.dot(p[2])});
    const double bottom = std::min({d.dot(q[0]), d.dot(q[1]), d.dot(q[2])});
    return bottom - top >= now * kTrianglesApart;
  }

  // A corner of one triangle above the interior of the other, `t`.
  bool corners(const Vector* t, const Vector* points, bool t_is_p) {
    const Vector e0 = t[1] - t[0], e1 = t[2] - t[0], n = cross(e0, e1);
    const double squared_n = n.squaredNorm();
    if (!(squared_n > kLeastSquare)) return false;
    const double h[3] = {n.dot(points[0] - t[0]), n.dot(points[1] - t[0]), n.dot(points[2] - t[0])};
    // Only the corner nearest to the plane can be nearest, and none if corners are on both sides.
    int k = 0;
    if (h[0] > 0 && h[1] > 0 && h[2] > 0) {
      k = h[1] < h[0] ? 1 : 0;
      if (h[2] < h[k]) k = 2;
    } else if (h[0] < 0 && h[1] < 0 && h[2] < 0) {
      k = h[1] > h[0] ? 1 : 0;
      if (h[2] > h[k]) k = 2;
    } else {
      return false;
    }
    const Vector foot = points[k] - (h[k] / squared_n) * n;
    double weight[3], sum = 0;  // of the corner opposite to each edge
    for (int i = 0; i < 3; ++i) {
      const Vector& from = t[i];
      const Vector edge = t[(i + 1) % 3] - from;
      weight[i] = cross(n, edge).dot(foot - from);
      if (weight[i] < 0) return false;
      sum += weight[i];
    }
    if (!(sum > 0)) return false;
    // A sliver's normal is mostly rounding, and the foot may miss the triangle. A point of the
    // triangle is used instead, with the same plane.
    const Vector inside = t[0] + (weight[2] / sum) * e0 + (weight[0] / sum) * e1;
    const double before = squared;
    const bool nearest = t_is_p ? offer(inside, points[k]) : offer(points[k], inside);
    if (squared < before) {
      best.normal = ((h[k] > 0) == t_is_p ? 1 : -1) / std::sqrt(squared_n) * n;
      has_normal = true;
    }
    return nearest;
  }

  bool edges() {
    Vector e[3], f[3];
    double ee[3], ff[3];
    for (int i = 0; i < 3; ++i) {
      e[i] = p[(i + 1) % 3] - p[i];
      f[i] = q[(i + 1) % 3] - q[i];
      ee[i] = e[i].squaredNorm();
      ff[i] = f[i].squaredNorm();
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        // V. J. Lumelsky, "On fast computation of distance between line segments", 1985.
        const Vector r = q[j] - p[i];
        const double ef = e[i].dot(f[j]), er = e[i].dot(r), fr = f[j].dot(r);
        double s = ratio(er * ff[j] - fr * ef, ee[i] * ff[j] - ef * ef);
        const double t = ratio(s * ef - fr, ff[j]);
        s = ratio(t * ef + er, ee[i]);
        if (offer(p[i] + s * e[i], q[j] + t * f[j])) return true;
      }
    }
    return false;
  }
};

}  // namespace

TrianglePair trianglePair(const Vector* p, const Vector* q) {
  Search search{p, q, {}};
  if (!search.edges() && !search.corners(p, q, true)) search.corners(q, p, false);
  TrianglePair& best = search.best;
  best.above = std::sqrt(search.squared);
  if (!(best.above > 0)) {
    best.normal = Vector::UnitX();
  } else if (!search.has_normal) {
    best.normal = (best.q - best.p) / best.above;
  }
  const Vector& n = best.normal;
  best.below = std::min({n.dot(q[0]), n.dot(q[1]), n.dot(q[2])}) -
               std::max({n.dot(p[0]), n.dot(p[1]), n.dot(p[2])});
  return best;
}

}  // namespace leeway::collision
