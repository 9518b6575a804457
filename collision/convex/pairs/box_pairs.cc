#include "collision/convex/pairs/box_pairs.h"

#include <bit>
#include <cstdint>

#include "collision/base/tolerances.h"
#include "collision/convex/pairs/closed_form.h"

namespace leeway::collision {

namespace {

// Limits on the cosine: above the first a face, below the second an edge, is tried for a cached
// direction. Any value is correct.
constexpr double kCachedAligned = 0.99;
constexpr double kCachedAcross = 0.1;

Triple halfOf(const Shape& box) { return tripleOf(box.halfExtents()); }

}  // namespace

bool nearestOfSphereAndBox(const Pose& X_WS, const Shape& box, const Pose& X_WB, Nearest& nearest) {
  const Triple c =
      rotatedBack(X_WB.rotation, tripleOf(X_WS.translation) - tripleOf(X_WB.translation));
  const Triple w = within(c, halfOf(box)) - c;
  const double apart = std::sqrt(squared(w));
  // The clamped point is the nearest one: both ends are the same.
  nearest.apart = nearest.plane = apart;
  nearest.point_a = c;
  nearest.normal = (1 / apart) * w;
  toWorld(X_WB.rotation, nearest);
  return apart > 0;
}

bool nearestOfCapsuleAndBox(const Shape& capsule, const Pose& X_WC, const Shape& box,
                            const Pose& X_WB, Nearest& nearest) {
  const Triple half = halfOf(box);
  const Triple c =
      rotatedBack(X_WB.rotation, tripleOf(X_WC.translation) - tripleOf(X_WB.translation));
  const Triple h = capsule.halfLength() * rotatedBack(X_WB.rotation, column(X_WC.rotation, 2));
  const Triple p = c + nearestToBox(c, h, half) * h;
  const Triple w = within(p, half) - p;
  const double apart = std::sqrt(squared(w));
  const Triple n = (1 / apart) * w;
  nearest.apart = apart;
  nearest.plane = -dot(n, c) - std::abs(dot(n, h)) - reach(n, half);
  nearest.point_a = p;
  nearest.normal = n;
  toWorld(X_WB.rotation, nearest);
  return apart > 0;
}

namespace {

// Two boxes in B's frame; B's centre is the origin.
struct Boxes {
  Triple c;        // A's centre
  Triple axis[3];  // A's axes
  double half_a[3], half_b[3];
};

double sizeOf(const Boxes& boxes) {
  return boxes.half_a[0] + boxes.half_a[1] + boxes.half_a[2] + boxes.half_b[0] + boxes.half_b[1] +
         boxes.half_b[2];
}

// The gap between A and B along n, a unit vector from A to B.
double planeAlong(const Boxes& boxes, const Triple& n) {
  return -dot(n, boxes.c) - std::abs(dot(n, boxes.axis[0])) * boxes.half_a[0] -
         std::abs(dot(n, boxes.axis[1])) * boxes.half_a[1] -
         std::abs(dot(n, boxes.axis[2])) * boxes.half_a[2] - std::abs(n.x) * boxes.half_b[0] -
         std::abs(n.y) * boxes.half_b[1] - std::abs(n.z) * boxes.half_b[2];
}

// A box in the frame of another box: its centre c and its axes m[.][k].
struct Placement {
  double c[3];
  double m[3][3];
};

// The vector from a box to a point.
Triple beyond(const double p[3], const double half[3]) {
  return {p[0] - within(p[0], -half[0], half[0]), p[1] - within(p[1], -half[1], half[1]),
          p[2] - within(p[2], -half[2], half[2])};
}

// The corner of the other box that is nearest to this box's face across axis i. True if it is above
// that face.
bool cornerAboveFace(const Placement& other, const double half[3], const double other_half[3],
                     int i, double corner[3]) {
  for (int j = 0; j < 3; ++j) corner[j] = other.c[j];
  for (int k = 0; k < 3; ++k) {
    const double s = -std::copysign(other_half[k], other.c[i] * other.m[i][k]);
    for (int j = 0; j < 3; ++j) corner[j] += s * other.m[j][k];
  }
  const int j = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
  return std::abs(corner[j]) <= half[j] && std::abs(corner[k]) <= half[k];
}

// The gap between a box and another one across the first one's face i.
double gapAcross(const Placement& other, const double half[3], const double other_half[3], int i) {
  return std::abs(other.c[i]) - half[i] - std::abs(other.m[i][0]) * other_half[0] -
         std::abs(other.m[i][1]) * other_half[1] - std::abs(other.m[i][2]) * other_half[2];
}

// The face with the largest gap.
int widestFace(const Placement& other, const double half[3], const double other_half[3],
               double& gap) {
  const double gaps[3] = {gapAcross(other, half, other_half, 0),
                          gapAcross(other, half, other_half, 1),
                          gapAcross(other, half, other_half, 2)};
  const int i = gaps[1] > gaps[0] ? 1 : 0;
  const int k = gaps[2] > gaps[i] ? 2 : i;
  gap = gaps[k];
  return k;
}

// Two edges: one parallel to B's axis i, the other to A's axis k.
struct EdgePair {
  int i = -1, k = -1;
};

// The pair of edges with the largest gap, if that is larger than `gap`. Branch-free, because the
// best pair is unpredictable.
EdgePair widestEdges(const Placement& a, const double half_a[3], const double half_b[3],
                     double gap) {
  double r[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) r[i][k] = std::abs(a.m[i][k]);
  }
  // Doubles >= 0 have the order of their bits.
  std::int64_t best = std::bit_cast<std::int64_t>(gap > 0 ? gap * gap : 0.0);
  int which = -1;
  for (int i = 0; i < 3; ++i) {
    const int j = i == 2 ? 0 : i + 1, m = i == 0 ? 2 : i - 1;
    for (int k = 0; k < 3; ++k) {
      const int p = k == 2 ? 0 : k + 1, q = k == 0 ? 2 : k - 1;
      // e_i x a_k = (0, -a_k[m], a_k[j]) in the order i, j, m; its products with A's other axes are
      // entries of the rotation. (A matrix that is not quite a rotation only selects another pair.)
      const double across = std::abs(a.m[j][k] * a.c[m] - a.m[m][k] * a.c[j]) -
                            (half_b[j] * r[m][k] + half_b[m] * r[j][k]) -
                            (half_a[p] * r[i][q] + half_a[q] * r[i][p]);
      const double sine_squared = r[j][k] * r[j][k] + r[m][k] * r[m][k];
      const double positive = std::max(across, 0.0) * (sine_squared > kParallelEdgesSquared);
      const double gap_squared =
          positive * positive / std::max(sine_squared, kParallelEdgesSquared);
      const std::int64_t bits = std::bit_cast<std::int64_t>(gap_squared);
      which = bits > best ? 3 * i + k : which;
      best = bits > best ? bits : best;
    }
  }
  return which < 0 ? EdgePair{} : EdgePair{which / 3, which % 3};
}

// The nearest points of two edges. False if one of them is beyond an end.
bool edgesMeet(const Boxes& boxes, const Placement& a, const EdgePair& edges, Nearest& nearest) {
  const int i = edges.i, k = edges.k;
  const int j = i == 2 ? 0 : i + 1, m = i == 0 ? 2 : i - 1;
  const int p = k == 2 ? 0 : k + 1, q = k == 0 ? 2 : k - 1;
  const double sine_squared = a.m[j][k] * a.m[j][k] + a.m[m][k] * a.m[m][k];
  // (Below this, the square has lost digits, and the normal would not be of unit length.)
  if (!(sine_squared > kParallelEdgesSquared)) return false;
  double n_j = -a.m[m][k], n_m = a.m[j][k];
  // From A to B.
  const double length = std::copysign(std::sqrt(sine_squared), -(n_j * a.c[j] + n_m * a.c[m]));
  n_j /= length;
  n_m /= length;
  const double s_p = std::copysign(boxes.half_a[p], n_j * a.m[j][p] + n_m * a.m[m][p]);
  const double s_q = std::copysign(boxes.half_a[q], n_j * a.m[j][q] + n_m * a.m[m][q]);
  // From a point of B's edge to one of A's.
  const double from_i = a.c[i] + s_p * a.m[i][p] + s_q * a.m[i][q];
  const double from_j =
      a.c[j] + s_p * a.m[j][p] + s_q * a.m[j][q] + std::copysign(boxes.half_b[j], n_j);
  const double from_m =
      a.c[m] + s_p * a.m[m][p] + s_q * a.m[m][q] + std::copysign(boxes.half_b[m], n_m);
  const double s = -(a.m[j][k] * from_j + a.m[m][k] * from_m) / sine_squared;
  const double t = from_i + s * a.m[i][k];
  if (!(std::abs(s) <= boxes.half_a[k] && std::abs(t) <= boxes.half_b[i])) return false;
  const double w_j = from_j + s * a.m[j][k], w_m = from_m + s * a.m[m][k];
  nearest.apart = std::sqrt(w_j * w_j + w_m * w_m);
  double n[3], point[3];
  n[i] = 0;
  n[j] = n_j;
  n[m] = n_m;
  point[i] = t;
  point[j] = w_j - std::copysign(boxes.half_b[j], n_j);
  point[m] = w_m - std::copysign(boxes.half_b[m], n_m);
  nearest.normal = {n[0], n[1], n[2]};
  nearest.point_a = {point[0], point[1], point[2]};
  nearest.plane = planeAlong(boxes, nearest.normal);
  return true;
}

// Coordinate descent from A's corner farthest along n: Newton steps along the axis of A with the
// largest possible gain. The squared distance from B is convex, and quadratic between the planes of
// B's faces. True once the points are nearest to within a share of kPairNarrow, or after the last
// step.
bool descend(const Boxes& boxes, const Triple& n, Nearest& nearest) {
  constexpr int kSteps = 16;
  const double narrow = 0.1 * kPairNarrow * sizeOf(boxes);
  double s[3];
  Triple p = boxes.c;
  for (int k = 0; k < 3; ++k) {
    s[k] = std::copysign(boxes.half_a[k], dot(n, boxes.axis[k]));
    p = p + s[k] * boxes.axis[k];
  }
  const Triple half_b = {boxes.half_b[0], boxes.half_b[1], boxes.half_b[2]};
  int last = -1;  // axis of the previous step; its coordinate and the slope before that step
  double last_s = 0, last_slope = 0;
  for (int step = 0;; ++step) {
    const Triple w = within(p, half_b) - p;
    const double squares = squared(w);
    // The possible gain of a move along each axis, to first order. Their sum is the gap between
    // both ends.
    double slope[3], gain[3], sum = 0;
    for (int k = 0; k < 3; ++k) {
      slope[k] = dot(w, boxes.axis[k]);
      gain[k] = std::abs(slope[k]) * boxes.half_a[k] - slope[k] * s[k];
      sum += gain[k];
    }
    if (!(squares > 0)) return false;
    if (sum * sum <= narrow * narrow * squares || step == kSteps) {
      nearest.apart = std::sqrt(squares);
      nearest.normal = (1 / nearest.apart) * w;
      nearest.point_a = p;
      nearest.plane = planeAlong(boxes, nearest.normal);
      return true;
    }
    const int i = gain[1] > gain[0] ? 1 : 0;
    const int k = gain[2] > gain[i] ? 2 : i;
    const Triple& axis = boxes.axis[k];
    const double curvature = (w.x != 0) * (axis.x * axis.x) + (w.y != 0) * (axis.y * axis.y) +
                             (w.z != 0) * (axis.z * axis.z);
    const double before = s[k];
    // A Newton step, or a secant step if the previous step overshot, because Newton steps might
    // alternate for ever.
    const bool beyond_it = k == last && last_slope * slope[k] < 0;
    const double way =
        beyond_it ? slope[k] * (before - last_s) / (last_slope - slope[k]) : slope[k] / curvature;
    s[k] = within(before + way, -boxes.half_a[k], boxes.half_a[k]);
    p = p + (s[k] - before) * axis;
    last = k;
    last_s = before;
    last_slope = slope[k];
  }
}

// Each box in the other's frame.
struct Views {
  Placement a_in_b, b_in_a;
};

Views viewsOf(const Boxes& boxes) {
  const Triple* axis = boxes.axis;
  return {{{boxes.c.x, boxes.c.y, boxes.c.z},
           {{axis[0].x, axis[1].x, axis[2].x},
            {axis[0].y, axis[1].y, axis[2].y},
            {axis[0].z, axis[1].z, axis[2].z}}},
          {{-dot(axis[0], boxes.c), -dot(axis[1], boxes.c), -dot(axis[2], boxes.c)},
           {{axis[0].x, axis[0].y, axis[0].z},
            {axis[1].x, axis[1].y, axis[1].z},
            {axis[2].x, axis[2].y, axis[2].z}}}};
}

// Handles a face of B (or of A) with a gap of `gap` to the other box. True if the other box's
// nearest corner is above the face, or if the goal is decided.
bool faceMeets(const Boxes& boxes, const Views& views, bool on_b, int face, double gap,
               const Goal& goal, Nearest& nearest) {
  double corner[3];
  const bool above = on_b ? cornerAboveFace(views.a_in_b, boxes.half_b, boxes.half_a, face, corner)
                          : cornerAboveFace(views.b_in_a, boxes.half_a, boxes.half_b, face, corner);
  // The vector to the corner, in the frame of the face's box; above the face it is parallel to the
  // normal.
  const Triple w = beyond(corner, on_b ? boxes.half_b : boxes.half_a);
  const bool meets = above && gap > 0;
  if (!meets && !(gap > goal.above) && !(goal.below > 0 && squared(w) < goal.below * goal.below)) {
    return false;
  }
  const Triple p = {corner[0], corner[1], corner[2]};
  const Triple* axis = boxes.axis;
  if (on_b) {
    const double side = std::copysign(1.0, -views.a_in_b.c[face]);
    nearest.settle(p, -w, {face == 0 ? side : 0, face == 1 ? side : 0, face == 2 ? side : 0}, gap);
  } else {
    const auto toB = [&](const Triple& v) { return v.x * axis[0] + v.y * axis[1] + v.z * axis[2]; };
    nearest.settle(boxes.c + toB(p - w), toB(w),
                   std::copysign(1.0, views.b_in_a.c[face]) * axis[face], gap);
  }
  nearest.early = !meets;
  return true;
}

// For a pair that has hardly moved since the cache was written: the cached direction selects the
// face, the edges, or the corner to start from. Any content is valid.
bool nearestFromCache(const Boxes& boxes, const Views& views, const PairCache& cache,
                      const Goal& goal, Nearest& nearest) {
  const Triple n = tripleOf(cache.direction_B);
  const double squares = squared(n);
  if (!(squares > 0.25 && squares < 4)) return false;  // NaN fails
  const double cosines[6] = {
      n.x, n.y, n.z, dot(n, boxes.axis[0]), dot(n, boxes.axis[1]), dot(n, boxes.axis[2])};
  for (int i = 0; i < 6; ++i) {
    if (!(std::abs(cosines[i]) > kCachedAligned)) continue;
    const bool on_b = i < 3;
    const int face = on_b ? i : i - 3;
    const double gap = on_b ? gapAcross(views.a_in_b, boxes.half_b, boxes.half_a, face)
                            : gapAcross(views.b_in_a, boxes.half_a, boxes.half_b, face);
    if (faceMeets(boxes, views, on_b, face, gap, goal, nearest)) return true;
  }
  const auto leastOf = [&](const double* c) {
    const int i = std::abs(c[1]) < std::abs(c[0]) ? 1 : 0;
    return std::abs(c[2]) < std::abs(c[i]) ? 2 : i;
  };
  const EdgePair edges = {leastOf(cosines), leastOf(cosines + 3)};
  const bool across =
      std::abs(cosines[edges.i]) < kCachedAcross && std::abs(cosines[3 + edges.k]) < kCachedAcross;
  if (!(across && edgesMeet(boxes, views.a_in_b, edges, nearest)) && !descend(boxes, n, nearest)) {
    return false;
  }
  // (If the vector is too short to have a direction, the separating axes are better.)
  return nearest.apart - nearest.plane <= kPairNarrow * sizeOf(boxes) || nearest.plane > goal.above;
}

bool nearestInB(const Boxes& boxes, const Views& views, const Goal& goal, Nearest& nearest) {
  double gap_b = 0, gap_a = 0;
  const int face_b = widestFace(views.a_in_b, boxes.half_b, boxes.half_a, gap_b);
  const int face_a = widestFace(views.b_in_a, boxes.half_a, boxes.half_b, gap_a);
  const bool on_b = gap_b >= gap_a;
  const double gap = on_b ? gap_b : gap_a;
  const int face = on_b ? face_b : face_a;
  if (faceMeets(boxes, views, on_b, face, gap, goal, nearest)) return true;
  const EdgePair edges = widestEdges(views.a_in_b, boxes.half_a, boxes.half_b, gap);
  // No axis separates them, except perhaps across nearly parallel edges, so there is no start for a
  // descent.
  if (edges.i < 0 && !(gap > 0)) return false;
  if (edges.i >= 0 && edgesMeet(boxes, views.a_in_b, edges, nearest)) return true;
  const Triple n = on_b ? Triple{face == 0 ? -boxes.c.x : 0, face == 1 ? -boxes.c.y : 0,
                                 face == 2 ? -boxes.c.z : 0}
                        : views.b_in_a.c[face] * boxes.axis[face];
  return descend(boxes, n, nearest);
}

}  // namespace

bool nearestOfBoxes(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                    const Goal& goal, const PairCache* cache, Nearest& nearest) {
  Boxes boxes;
  const Eigen::Matrix3d& R = X_WB.rotation;
  const Triple d = tripleOf(X_WA.translation) - tripleOf(X_WB.translation);
  boxes.c = rotatedBack(R, d);
  for (int k = 0; k < 3; ++k) {
    boxes.axis[k] = rotatedBack(R, column(X_WA.rotation, k));
    boxes.half_a[k] = a.halfExtents()[k];
    boxes.half_b[k] = b.halfExtents()[k];
  }
  const Views views = viewsOf(boxes);
  if (!(cache != nullptr && nearestFromCache(boxes, views, *cache, goal, nearest)) &&
      !nearestInB(boxes, views, goal, nearest)) {
    return false;
  }
  toWorld(R, nearest);
  return true;
}

}  // namespace leeway::collision
