#include "collision/convex/gjk/simplex.h"

#include <algorithm>
#include <limits>

namespace leeway::collision {

namespace {

// The best face so far and its point nearest to the origin.
struct Candidate {
  Vector nearest;
  double norm_squared = std::numeric_limits<double>::infinity();
  int count = 0;
  int index[3];
  double lambda[3];
  Vector normal;
  bool has_normal = false;
};

inline void offerVertex(const Vector& p, int i, Candidate& best) {
  const double norm_squared = p.squaredNorm();
  if (!(norm_squared < best.norm_squared)) return;
  best.nearest = p;
  best.norm_squared = norm_squared;
  best.count = 1;
  best.index[0] = i;
  best.lambda[0] = 1;
  best.has_normal = false;
}

// The edge from point i to point j, its ends included.
inline void offerEdge(const Vector* const w[4], int i, int j, Candidate& best) {
  const Vector& p = *w[i];
  const Vector edge = *w[j] - p;
  const double length_squared = edge.squaredNorm();
  const double along = -p.dot(edge);
  // (Also taken when length_squared is 0.)
  if (!(along > 0)) return offerVertex(p, i, best);
  if (along >= length_squared) return offerVertex(*w[j], j, best);
  const double t = along / length_squared;
  const Vector nearest = p + t * edge;
  const double norm_squared = nearest.squaredNorm();
  if (!(norm_squared < best.norm_squared)) return;
  best.nearest = nearest;
  best.norm_squared = norm_squared;
  best.count = 2;
  best.index[0] = i;
  best.index[1] = j;
  best.lambda[0] = 1 - t;
  best.lambda[1] = t;
  // Near contact, cancellation leaves a part along the edge, which is projected out.
  best.normal = nearest - (nearest.dot(edge) / length_squared) * edge;
  best.has_normal = true;
}

// The triangle of points i, j, k, or those of its edges beyond which the origin's projection lies.
inline void offerTriangle(const Vector* const w[4], int i, int j, int k, Candidate& best) {
  const Vector& p = *w[k];
  const Vector to_i = *w[i] - p;
  const Vector to_j = *w[j] - p;
  const Vector normal = cross(to_i, to_j);
  const double normal_squared = normal.squaredNorm();
  // Barycentric weights of the origin's projection, times |normal|^2:
  // area_i = normal . (to_j x p), area_j = normal . (p x to_i).
  const Vector turned = cross(p, normal);
  const double area_i = to_j.dot(turned);
  const double area_j = -to_i.dot(turned);
  const double area_k = normal_squared - area_i - area_j;
  if (area_i > 0 && area_j > 0 && area_k > 0) {
    const double inverse = 1 / normal_squared;
    const double lambda_i = area_i * inverse;
    const double lambda_j = area_j * inverse;
    const double lambda_k = 1 - lambda_i - lambda_j;
    if (lambda_k >= 0) {
      const Vector nearest = p + lambda_i * to_i + lambda_j * to_j;
      const double norm_squared = nearest.squaredNorm();
      if (!(norm_squared < best.norm_squared)) return;
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
      // Points err by about u L. The normal's direction errs by that divided by the triangle's
      // height, and the direction of the nearest point by that divided by its length. The better
      // one is kept.
      const double longest_squared = std::max(to_i.squaredNorm(), to_j.squaredNorm());
      best.has_normal = normal_squared > norm_squared * longest_squared;
      return;
    }
    return offerEdge(w, j, i, best);  // lambda_k is below 0 by rounding only
  }
  // A degenerate triangle, whose areas are 0 or rounding, tries all its edges.
  if (!(area_j > 0)) offerEdge(w, k, i, best);
  if (!(area_i > 0)) offerEdge(w, k, j, best);
  if (!(area_k > 0)) offerEdge(w, j, i, best);
}

inline double sizeOf(const Vector& v) {
  return std::abs(v.x()) + std::abs(v.y()) + std::abs(v.z());
}

// Offers the faces of the tetrahedron beyond which the origin is, or may be. True if there are
// none.
bool tetrahedronHoldsOrigin(const Vector* const w[4], Candidate& best) {
  const Vector& d = *w[3];
  const Vector a = *w[0] - d, b = *w[1] - d, c = *w[2] - d;
  const Vector bc = cross(b, c), ad = cross(a, d);
  // The origin's barycentric weights, times volume: -d in the basis a, b, c.
  double volume = a.dot(bc);
  double weight_a = -d.dot(bc), weight_b = -c.dot(ad), weight_c = b.dot(ad);
  double weight_d = volume - weight_a - weight_b - weight_c;
  // A determinant of three vectors errs by less than 8 units of roundoff times the product of their
  // lengths.
  const double aa = sizeOf(a), bb = sizeOf(b), cc = sizeOf(c), dd = sizeOf(d);
  const double unit = 16 * kUnitRoundoff;
  const double error_a = unit * dd * bb * cc, error_b = unit * dd * aa * cc,
               error_c = unit * dd * aa * bb, error_volume = unit * aa * bb * cc;
  const double error_d = error_a + error_b + error_c + error_volume;
  if (volume < 0) {
    volume = -volume;
    weight_a = -weight_a;
    weight_b = -weight_b;
    weight_c = -weight_c;
    weight_d = -weight_d;
  }
  const bool flat = !(volume > error_volume);
  bool inside = true;
  if (flat || !(weight_a > error_a)) {
    offerTriangle(w, 1, 2, 3, best);
    inside = false;
  }
  if (flat || !(weight_b > error_b)) {
    offerTriangle(w, 0, 2, 3, best);
    inside = false;
  }
  if (flat || !(weight_c > error_c)) {
    offerTriangle(w, 0, 1, 3, best);
    inside = false;
  }
  if (flat || !(weight_d > error_d)) {
    offerTriangle(w, 0, 1, 2, best);
    inside = false;
  }
  return inside;
}

// Reduces the simplex to the candidate: its slots come first, in their old order.
void keep(Simplex& s, const Candidate& best) {
  int place[4] = {-1, -1, -1, -1};  // position in the candidate, by point
  for (int n = 0; n < best.count; ++n) place[best.index[n]] = n;
  int kept = 0;
  int dropped[4], dropped_count = 0;
  for (int i = 0; i < 4; ++i) {
    if (place[i] >= 0) {
      s.lambda[kept] = best.lambda[place[i]];
      s.slot[kept++] = s.slot[i];
    } else {
      dropped[dropped_count++] = s.slot[i];
    }
  }
  for (int i = 0; i < dropped_count; ++i) s.slot[kept + i] = dropped[i];
  s.count = kept;
  s.nearest = best.nearest;
  s.norm_squared = best.norm_squared;
  s.has_normal = best.has_normal;
  if (best.has_normal) s.feature_normal = best.normal;
}

// Offers the faces of the first count + 1 points; false if these hold the origin.
bool offerFaces(const Vector* const w[4], int count, Candidate& best) {
  switch (count) {
    case 0:
      offerVertex(*w[0], 0, best);
      return true;
    case 1:
      offerEdge(w, 1, 0, best);
      return true;
    case 2:
      offerTriangle(w, 0, 1, 2, best);
      return true;
    default:
      return !tetrahedronHoldsOrigin(w, best);
  }
}

}  // namespace

Reduction addAndReduce(Simplex& s) {
  const Vector* const w[4] = {&s.points[s.slot[0]].w, &s.points[s.slot[1]].w,
                              &s.points[s.slot[2]].w, &s.points[s.slot[3]].w};
  Candidate best;
  if (!offerFaces(w, s.count, best)) return Reduction::kHoldsOrigin;
  if (best.count == 0 || (s.count > 0 && !(best.norm_squared < s.norm_squared))) {
    return Reduction::kNoProgress;
  }
  keep(s, best);
  return Reduction::kReduced;
}

Reduction addAndReduceScaled(Simplex& s, const Vector rows[3]) {
  Vector scaled[4];
  const Vector* w[4];
  for (int i = 0; i < 4; ++i) {
    w[i] = &scaled[i];
    if (i > s.count) continue;
    const Vector& p = s.points[s.slot[i]].w;
    scaled[i] = Vector(rows[0].dot(p), rows[1].dot(p), rows[2].dot(p));
  }
  Candidate best;
  if (!offerFaces(w, s.count, best)) return Reduction::kHoldsOrigin;
  if (best.count == 0) offerVertex(*w[s.count], s.count, best);
  if (best.count == 0) return Reduction::kHoldsOrigin;  // not finite: GJK ends
  keep(s, best);
  const Vector toward = best.has_normal ? best.normal : best.nearest;
  s.feature_normal = toward.x() * rows[0] + toward.y() * rows[1] + toward.z() * rows[2];
  s.has_normal = true;
  s.nearest = s.lambda[0] * s.point(0).w;
  for (int i = 1; i < s.count; ++i) s.nearest += s.lambda[i] * s.point(i).w;
  s.norm_squared = s.nearest.squaredNorm();
  return Reduction::kReduced;
}

void reduceAll(Simplex& s, int count) {
  const Vector* const w[4] = {&s.points[s.slot[0]].w, &s.points[s.slot[1]].w,
                              &s.points[s.slot[2]].w, &s.points[s.slot[3]].w};
  Candidate best;
  if (count == 1) offerVertex(*w[0], 0, best);
  if (count == 2) offerEdge(w, 1, 0, best);
  if (count == 3) offerTriangle(w, 0, 1, 2, best);
  if (best.count > 0) keep(s, best);
}

Vector nearestOnTriangle(const Vector& a, const Vector& b, const Vector& c, double weights[3]) {
  const Vector* const w[4] = {&a, &b, &c, &c};
  Candidate best;
  offerTriangle(w, 0, 1, 2, best);
  weights[0] = weights[1] = weights[2] = 0;
  for (int i = 0; i < best.count; ++i) weights[best.index[i]] = best.lambda[i];
  return best.nearest;
}

}  // namespace leeway::collision
