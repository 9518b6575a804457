#include "collision/simd/vertex_gjk.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/simd/vertex_gjk.cc"
#include "collision/simd/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/simd/four_lanes-inl.h"
#include "collision/simd/scan-inl.h"

// A step takes a new point p of the difference and three older ones (the same one several times at
// first). In exact arithmetic the nearest point of their hull is on a triangle that p has with two
// of the others. So lane k looks at one: p, point k and point k + 1 (modulo three), or, where the
// origin is not above its inside, at its edge from p to point k. The older point that the best lane
// does without makes room for p; one without weight may stay, which does no harm.
//
// Nothing here calls code of another target: code without AVX that runs while registers' upper
// halves are in use costs hundreds of cycles, and compilers forget to clear them.
//
// Whatever rounding does here costs steps only: both ends that are offered rest on points and
// support values alone, as everywhere (gjk.cc says how they are rounded; that the direction is
// divided out of its support value, in place of being made a unit vector first, is one rounding
// less). What plain arithmetic cannot settle - flat simplices, the origin inside, ends that
// rounding keeps apart - is left to runGjk().

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {
namespace {

/// The lane of the point that is not on the triangle of lane k.
constexpr int kLeftOut[3] = {2, 0, 1};
alignas(32) constexpr double kLane[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

// Plain numbers: a Vector goes through memory, where reading two coordinates at once after they
// were written one by one costs more than a step's arithmetic.
struct Triple {
  double x, y, z;
};
HWY_INLINE double dot(const Triple& a, const Triple& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
HWY_INLINE Triple operator-(const Triple& a, const Triple& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
HWY_INLINE Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
HWY_INLINE Triple tripleOf(const Vector& v) { return {v.x(), v.y(), v.z()}; }
HWY_INLINE Vector vectorOf(const Triple& v) { return {v.x, v.y, v.z}; }
HWY_INLINE FourPoints fourTimes(const Triple& p) {
  return {allLanes(p.x), allLanes(p.y), allLanes(p.z)};
}

// Squared share of a point's length below which an edge's nearest point has lost digits that count:
// ten are left.
constexpr double kCancelled = 1e-6;

// The farthest vertex of a core along a direction of any length, and its name: as farthest().
HWY_INLINE Triple farthestCorner(const ConvexView& view, const Triple& d, int& name) {
  switch (view.core) {
    case Core::kBox: {
      name =
          (std::signbit(d.x) ? 0 : 1) | (std::signbit(d.y) ? 0 : 2) | (std::signbit(d.z) ? 0 : 4);
      return {std::copysign(view.size.x(), d.x), std::copysign(view.size.y(), d.y),
              std::copysign(view.size.z(), d.z)};
    }
    case Core::kSegment:
      name = d.z >= 0 ? 1 : 0;
      return {0, 0, d.z >= 0 ? view.size.z() : -view.size.z()};
    case Core::kPoints: {
      int found = -1;
      if (view.support != nullptr) found = scanSupport(*view.support, d.x, d.y, d.z, name);
      // Climbing asks for a unit vector: what it takes for equal depends on the length.
      name = found >= 0 ? found : farthestPoint(view, vectorOf(d) / std::sqrt(dot(d, d)), name);
      return tripleOf(view.points[name]);
    }
    default:
      name = 0;
      return {0, 0, 0};
  }
}

// What a step found.
struct Nearest {
  Triple direction;          ///< of the nearest point, any length
  double direction_squared;  ///< its length squared
  double norm_squared;       ///< of the nearest point
  int lane;
  double weight_first, weight_second;  ///< of points `lane` and `lane` + 1; the rest is p's
};

// The difference's member with the smallest w . n.
HWY_INLINE Triple support(const Difference<false>& difference, const Triple& n,
                          VertexNames& names) {
  const Eigen::Matrix3d& R = difference.pose().rotation;
  const Vector& t = difference.pose().translation;
  const Triple back = {R(0, 0) * n.x + R(1, 0) * n.y + R(2, 0) * n.z,
                       R(0, 1) * n.x + R(1, 1) * n.y + R(2, 1) * n.z,
                       R(0, 2) * n.x + R(1, 2) * n.y + R(2, 2) * n.z};
  const Triple a = farthestCorner(difference.viewA(), back, names.a);
  const Triple b = farthestCorner(difference.viewB(), -n, names.b);
  return {b.x - (R(0, 0) * a.x + R(0, 1) * a.y + R(0, 2) * a.z + t.x()),
          b.y - (R(1, 0) * a.x + R(1, 1) * a.y + R(1, 2) * a.z + t.y()),
          b.z - (R(2, 0) * a.x + R(2, 1) * a.y + R(2, 2) * a.z + t.z())};
}

// False when the four points hold the origin.
HWY_INLINE bool step(const Triple& newest, const FourPoints& old, Nearest& nearest) {
  const Lanes zero = allLanes(0), one = allLanes(1);
  const FourPoints p = fourTimes(newest);
  const FourPoints e = old - p, f = nextOfThree(e);
  const Lanes ee = dot(e, e), ef = dot(e, f), ff = nextOfThree(ee);
  const Lanes pe = zero - dot(p, e), pf = nextOfThree(pe);
  const FourPoints n = cross(e, f);
  const Lanes nn = dot(n, n), pn = dot(p, n), inverse = one / nn;
  // Weights of the lane's points, times nn.
  const Lanes area_e = ff * pe - ef * pf, area_f = ee * pf - ef * pe;
  const Mask inside = (area_e > zero) & (area_f > zero) & (nn - area_e > area_f);
  const Lanes along = choose(pe > zero, choose(ee > pe, pe / ee, one), zero);
  const FourPoints on_edge = {p.x + along * e.x, p.y + along * e.y, p.z + along * e.z};
  const Lanes edge_squared = dot(on_edge, on_edge);

  alignas(32) double squared[4], height[4];
  store(choose(inside, pn * (pn * inverse), edge_squared), squared);
  store(pn, height);
  int k = squared[1] < squared[0] ? 1 : 0;
  k = squared[2] < std::min(squared[0], squared[1]) ? 2 : k;

  alignas(32) double x[4], y[4], z[4], length_squared[4], first[4], second[4], nx[4], ny[4], nz[4],
      ex[4], ey[4], ez[4];
  const FourPoints direction = choose(inside, n, on_edge);
  store(direction.x, x);
  store(direction.y, y);
  store(direction.z, z);
  store(choose(inside, nn, edge_squared), length_squared);
  store(choose(inside, area_e * inverse, along), first);
  store(choose(inside, area_f * inverse, zero), second);
  store(n.x, nx);
  store(n.y, ny);
  store(n.z, nz);
  store(e.x, ex);
  store(e.y, ey);
  store(e.z, ez);

  // The origin's weight of the point that lane k leaves out is -height[k] / volume.
  const double volume = nx[0] * ex[2] + ny[0] * ey[2] + nz[0] * ez[2];
  const double sum = height[0] + height[1] + height[2];
  const double least = std::min(height[0], std::min(height[1], height[2]));
  const double most = std::max(height[0], std::max(height[1], height[2]));
  if (volume < 0 ? least > 0 && sum < -volume : most < 0 && sum > -volume) return false;

  // A triangle's normal points away from the origin or towards it.
  const double sign = second[k] > 0 ? std::copysign(1.0, height[k]) : 1.0;
  nearest.direction = {sign * x[k], sign * y[k], sign * z[k]};
  nearest.direction_squared = length_squared[k];
  // Near contact what is left of the edge's point after cancellation is not at a right angle to
  // the edge any more: once more.
  if (squared[k] < kCancelled * dot(newest, newest) && first[k] > 0 && second[k] == 0) {
    const Triple edge = {ex[k], ey[k], ez[k]};
    const double excess = dot(nearest.direction, edge) / dot(edge, edge);
    nearest.direction = {nearest.direction.x - excess * edge.x,
                         nearest.direction.y - excess * edge.y,
                         nearest.direction.z - excess * edge.z};
    nearest.direction_squared = dot(nearest.direction, nearest.direction);
  }
  nearest.norm_squared = squared[k];
  nearest.lane = k;
  nearest.weight_first = first[k];
  nearest.weight_second = second[k];
  return true;
}

GjkEnd run(Difference<false>& difference, const Vector& first, Progress& progress,
           VertexCarrier& carrier) {
  const CoreQuery& query = progress.query();
  const DistanceRequest& request = query.request;
  const int limit = request.iteration_limit;
  ++progress.iterations;
  VertexNames names[3], newest_names = {difference.hintA(), difference.hintB()};
  Triple newest = support(difference, tripleOf(first), newest_names);
  Triple best_direction = tripleOf(first);
  double best = dot(best_direction, newest) / first.norm();
  const double first_squared = dot(newest, newest);
  Nearest nearest{newest, first_squared, first_squared, 0, 0, 0};
  names[0] = names[1] = names[2] = newest_names;
  FourPoints old = fourTimes(newest);
  GjkEnd end = GjkEnd::kStagnated;
  for (;;) {
    // As Progress::enough(), but with an upper end that is not yet made of points.
    const double upper = std::sqrt(nearest.norm_squared) - query.upper_offset;
    double lower = best - query.lower_offset;
    if (lower > request.threshold || upper <= request.threshold || (!request.depth && upper <= 0) ||
        (upper - lower <= request.tolerance && (lower > 0 || upper <= 0))) {
      break;
    }
    if (progress.iterations >= limit) {
      end = GjkEnd::kLimit;
      break;
    }
    ++progress.iterations;
    newest = support(difference, nearest.direction, newest_names);
    const double value = dot(nearest.direction, newest) / std::sqrt(nearest.direction_squared);
    if (value > best) {
      best = value;
      best_direction = nearest.direction;
    }
    lower = best - query.lower_offset;
    if (lower > request.threshold || (upper - lower <= request.tolerance && lower > 0)) break;
    Nearest next;
    // (NaN fails.)
    if (!step(newest, old, next) || !(next.norm_squared < nearest.norm_squared)) break;
    nearest = next;
    const int left_out = kLeftOut[next.lane];
    old = choose(load(kLane[left_out]) > allLanes(0), fourTimes(newest), old);
    names[left_out] = newest_names;
  }
  difference.setHints(newest_names.a, newest_names.b);
  progress.offerLower(best,
                      vectorOf(best_direction) / std::sqrt(dot(best_direction, best_direction)));
  const int k = nearest.lane;
  const int place[3] = {kLeftOut[k], k, (k + 1) % 3};
  for (int i = 0; i < 3; ++i) carrier.names[i] = names[place[i]];
  carrier.weight[0] = 1 - nearest.weight_first - nearest.weight_second;
  carrier.weight[1] = nearest.weight_first;
  carrier.weight[2] = nearest.weight_second;
  return end;
}

}  // namespace

GjkEnd vertexSteps(Difference<false>& difference, const Vector& direction, Progress& progress,
                   VertexCarrier& carrier) {
  return run(difference, direction, progress, carrier);
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(vertexSteps);

GjkEnd runVertexGjk(Difference<false>& difference, const Vector& direction, Progress& progress,
                    Simplex& simplex) {
  if (progress.iterations >= progress.query().request.iteration_limit) return GjkEnd::kLimit;
  VertexCarrier carrier;
  const GjkEnd end = HWY_DYNAMIC_DISPATCH(vertexSteps)(difference, direction, progress, carrier);
  for (int i = 0; i < 3; ++i) {
    if (!(carrier.weight[i] > 0)) continue;
    difference.member(carrier.names[i].a, carrier.names[i].b, simplex.free());
    simplex.lambda[simplex.count++] = carrier.weight[i];
  }
  simplex.nearest = simplex.lambda[0] * simplex.point(0).w;
  for (int i = 1; i < simplex.count; ++i) {
    simplex.nearest += simplex.lambda[i] * simplex.point(i).w;
  }
  simplex.norm_squared = simplex.nearest.squaredNorm();
  progress.offerWitness(std::sqrt(simplex.norm_squared), simplex.nearest, simplex.pointOfA());
  if (progress.enough()) return GjkEnd::kEnough;
  if (end == GjkEnd::kStagnated) reduceAll(simplex, simplex.count);
  return end;
}

}  // namespace leeway::collision
#endif
