#include "collision/simplex.h"

#include <algorithm>
#include <limits>

namespace leeway::collision {

namespace {

// A face of the simplex with its nearest point.
struct Candidate {
  Vector nearest;
  double norm_squared = std::numeric_limits<double>::infinity();
  int count = 0;
  int index[3];
  double lambda[3];
  Vector normal = Vector::Zero();
};

// Edge from point i to point j. The better of a vertex is covered by clamping.
void tryEdge(const Simplex& s, int i, int j, Candidate& best) {
  const Vector& p = s.points[i].w;
  const Vector edge = s.points[j].w - p;
  const double length_squared = edge.squaredNorm();
  const double along = -p.dot(edge);
  // Also taken when length_squared is 0 or NaN.
  if (!(along > 0)) {
    const double norm_squared = p.squaredNorm();
    if (norm_squared < best.norm_squared) {
      best.nearest = p;
      best.norm_squared = norm_squared;
      best.count = 1;
      best.index[0] = i;
      best.lambda[0] = 1;
      best.normal.setZero();
    }
    return;
  }
  if (along >= length_squared) {
    const Vector& q = s.points[j].w;
    const double norm_squared = q.squaredNorm();
    if (norm_squared < best.norm_squared) {
      best.nearest = q;
      best.norm_squared = norm_squared;
      best.count = 1;
      best.index[0] = j;
      best.lambda[0] = 1;
      best.normal.setZero();
    }
    return;
  }
  const double t = along / length_squared;
  const Vector nearest = p + t * edge;
  const double norm_squared = nearest.squaredNorm();
  if (norm_squared < best.norm_squared) {
    best.nearest = nearest;
    best.norm_squared = norm_squared;
    best.count = 2;
    best.index[0] = i;
    best.index[1] = j;
    best.lambda[0] = 1 - t;
    best.lambda[1] = t;
    // Near contact the nearest point keeps a part along the edge, by cancellation: taken off, in
    // proportion to what is left.
    best.normal = nearest - (nearest.dot(edge) / length_squared) * edge;
  }
}

// Triangle of points i, j, k; k is the newest or any. Falls back to the edges that the origin's
// projection is beyond.
void tryTriangle(const Simplex& s, int i, int j, int k, Candidate& best) {
  const Vector& p = s.points[k].w;
  const Vector to_i = s.points[i].w - p;
  const Vector to_j = s.points[j].w - p;
  const Vector normal = cross(to_i, to_j);
  const double normal_squared = normal.squaredNorm();
  // Weights of i and j times normal_squared: areas of the triangles that the origin's projection
  // makes with the edges.
  const double area_i = normal.dot(cross(to_j, p));
  const double area_j = normal.dot(cross(p, to_i));
  const double area_k = normal_squared - area_i - area_j;
  if (area_i > 0 && area_j > 0 && area_k > 0) {
    const double lambda_i = area_i / normal_squared;
    const double lambda_j = area_j / normal_squared;
    const double lambda_k = 1 - lambda_i - lambda_j;
    if (lambda_k >= 0) {
      const Vector nearest = p + lambda_i * to_i + lambda_j * to_j;
      const double norm_squared = nearest.squaredNorm();
      if (norm_squared < best.norm_squared) {
        best.nearest = nearest;
        best.norm_squared = norm_squared;
        best.count = 3;
        best.index[0] = i;
        best.index[1] = j;
        best.index[2] = k;
        best.lambda[0] = lambda_i;
        best.lambda[1] = lambda_j;
        best.lambda[2] = lambda_k;
        best.normal = normal;
        // Points err by about u * L each: the normal by that over the triangle's height, the
        // nearest point's direction by that over its length. Keep the normal where it is the
        // better.
        const double longest_squared = std::max(to_i.squaredNorm(), to_j.squaredNorm());
        if (normal_squared <= norm_squared * longest_squared) best.normal.setZero();
      }
      return;
    }
  }
  // Written so that a degenerate triangle, where all areas are rounding or 0, tries all its edges.
  if (!(area_j > 0)) tryEdge(s, k, i, best);
  if (!(area_i > 0)) tryEdge(s, k, j, best);
  if (!(area_k > 0)) tryEdge(s, j, i, best);
  if (area_i > 0 && area_j > 0 && area_k > 0) {  // only lambda_k was below 0 by rounding
    tryEdge(s, j, i, best);
  }
}

void keep(Simplex& s, const Candidate& best) {
  // Slots in ascending order, so that nothing is overwritten before it is moved.
  int to = 0;
  for (int from = 0; from < s.count; ++from) {
    for (int n = 0; n < best.count; ++n) {
      if (best.index[n] != from) continue;
      if (to != from) s.points[to] = s.points[from];
      s.lambda[to++] = best.lambda[n];
    }
  }
  s.count = best.count;
  s.nearest = best.nearest;
  s.norm_squared = best.norm_squared;
  s.feature_normal = best.normal;
}

// The faces of the tetrahedron that the origin is beyond, or may be. True when there is none.
bool tetrahedronHoldsOrigin(const Simplex& s, Candidate& best) {
  const Vector& d = s.points[3].w;
  const Vector a = s.points[0].w - d, b = s.points[1].w - d, c = s.points[2].w - d;
  const Vector bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
  const double volume = a.dot(bc);
  // -d in the basis a, b, c, times volume.
  double weight_a = -d.dot(bc), weight_b = -d.dot(ca), weight_c = -d.dot(ab);
  double weight_d = volume - weight_a - weight_b - weight_c;
  // A determinant of three vectors errs by less than 8 units of roundoff times the product of their
  // lengths.
  const double aa = a.norm(), bb = b.norm(), cc = c.norm(), dd = d.norm();
  const double unit = 16 * kUnitRoundoff;
  const double error_a = unit * dd * bb * cc, error_b = unit * dd * aa * cc,
               error_c = unit * dd * aa * bb;
  const double error_volume = unit * aa * bb * cc;
  const double error_d = error_a + error_b + error_c + error_volume;
  if (volume < 0) {
    weight_a = -weight_a;
    weight_b = -weight_b;
    weight_c = -weight_c;
    weight_d = -weight_d;
  }
  const bool flat = !(std::abs(volume) > error_volume);
  bool inside = !flat;
  if (flat || !(weight_a > error_a)) {
    tryTriangle(s, 1, 2, 3, best);
    inside = false;
  }
  if (flat || !(weight_b > error_b)) {
    tryTriangle(s, 0, 2, 3, best);
    inside = false;
  }
  if (flat || !(weight_c > error_c)) {
    tryTriangle(s, 0, 1, 3, best);
    inside = false;
  }
  if (flat || !(weight_d > error_d)) {
    tryTriangle(s, 0, 1, 2, best);
    inside = false;
  }
  return inside;
}

}  // namespace

bool reduceToNearest(Simplex& s) {
  Candidate best;
  switch (s.count) {
    case 1:
      s.lambda[0] = 1;
      s.nearest = s.points[0].w;
      s.norm_squared = s.nearest.squaredNorm();
      s.feature_normal.setZero();
      return true;
    case 2:
      tryEdge(s, 0, 1, best);
      break;
    case 3:
      tryTriangle(s, 0, 1, 2, best);
      break;
    default:
      if (tetrahedronHoldsOrigin(s, best)) return false;
      break;
  }
  // No candidate (everything NaN) cannot happen for finite points; keep the newest then.
  if (best.count == 0) {
    best.count = 1;
    best.index[0] = s.count - 1;
    best.nearest = s.points[s.count - 1].w;
    best.norm_squared = best.nearest.squaredNorm();
  }
  keep(s, best);
  return true;
}

Vector nearestOnTriangle(const Vector& a, const Vector& b, const Vector& c, double weights[3]) {
  Simplex s;
  s.count = 3;
  s.points[0].w = a;
  s.points[1].w = b;
  s.points[2].w = c;
  for (int i = 0; i < 3; ++i) s.points[i].index_a = i;
  reduceToNearest(s);
  weights[0] = weights[1] = weights[2] = 0;
  for (int i = 0; i < s.count; ++i) weights[s.points[i].index_a] = s.lambda[i];
  return s.nearest;
}

}  // namespace leeway::collision
