// Private to collision/: nearest points of a point or a segment and of one triangle in each vector
// lane (C. Ericson, "Real-Time Collision Detection", 2005). Included once for each of Highway's
// targets, so it has no #pragma once.

#if defined(LEEWAY_COLLISION_DEFORM_NEAREST_POINTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef LEEWAY_COLLISION_DEFORM_NEAREST_POINTS_INL_H
#undef LEEWAY_COLLISION_DEFORM_NEAREST_POINTS_INL_H
#else
#define LEEWAY_COLLISION_DEFORM_NEAREST_POINTS_INL_H
#endif

#include <hwy/highway.h>

#include "collision/deform/tree/node_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace leeway::collision {
namespace HWY_NAMESPACE {
namespace {

// Eight doubles, one for each triangle, or as many of them as a vector holds.
const hn::CappedTag<double, kWidth> kMany;
using Many = hn::Vec<decltype(kMany)>;
constexpr std::size_t kManyLanes = hn::MaxLanes(decltype(kMany)());

// Three coordinates.
struct Triple {
  Many x[3];
};
// A point of the core, the vector from it to a point of the triangle, and the squared length of
// that vector.
struct PointPair {
  Triple from, way;
  Many squared;
};

// x clamped to [0, most].
HWY_INLINE Many clampTo(Many x, Many most) { return hn::Min(hn::Max(x, hn::Zero(kMany)), most); }
// Vertices relative to p.
HWY_INLINE Triple verticesFrom(const double* const* vertices, const double* p) {
  Triple t;
  loadMany(kMany, vertices, t.x);
  for (int k = 0; k < 3; ++k) t.x[k] = hn::Sub(t.x[k], hn::Set(kMany, p[k]));
  return t;
}
HWY_INLINE Triple setTriple(const double* x) {
  Triple t;
  for (int k = 0; k < 3; ++k) t.x[k] = hn::Set(kMany, x[k]);
  return t;
}
HWY_INLINE Triple negative(const Triple& a) {
  Triple t;
  for (int k = 0; k < 3; ++k) t.x[k] = hn::Neg(a.x[k]);
  return t;
}
HWY_INLINE Triple difference(const Triple& a, const Triple& b) {
  Triple t;
  for (int k = 0; k < 3; ++k) t.x[k] = hn::Sub(a.x[k], b.x[k]);
  return t;
}
HWY_INLINE Many sizeOf(const Triple& a) {
  return hn::Add(hn::Add(hn::Abs(a.x[0]), hn::Abs(a.x[1])), hn::Abs(a.x[2]));
}
HWY_INLINE Many dot(const Triple& a, const Triple& b) {
  return hn::Add(hn::Add(hn::Mul(a.x[0], b.x[0]), hn::Mul(a.x[1], b.x[1])),
                 hn::Mul(a.x[2], b.x[2]));
}

// The point p, the same in all lanes, and the nearest point of each triangle, by its Voronoi
// regions (Ericson, section 5.1.5). Without kSegment, p is the origin.
template <bool kSegment>
HWY_INLINE PointPair nearestTo(const Triple& p, const Triple& from_a, const Triple& from_b,
                               const Triple& from_c) {
  const Triple a = kSegment ? difference(from_a, p) : from_a,
               b = kSegment ? difference(from_b, p) : from_b,
               c = kSegment ? difference(from_c, p) : from_c;
  const Triple ab = difference(b, a), ac = difference(c, a);
  const Many zero = hn::Zero(kMany), one = hn::Set(kMany, 1.0);
  const Many d1 = hn::Neg(dot(ab, a)), d2 = hn::Neg(dot(ac, a)), d3 = hn::Neg(dot(ab, b)),
             d4 = hn::Neg(dot(ac, b)), d5 = hn::Neg(dot(ab, c)), d6 = hn::Neg(dot(ac, c));
  const Many va = hn::Sub(hn::Mul(d3, d6), hn::Mul(d5, d4)),
             vb = hn::Sub(hn::Mul(d5, d2), hn::Mul(d1, d6)),
             vc = hn::Sub(hn::Mul(d1, d4), hn::Mul(d3, d2));
  const Many along_bc = hn::Sub(d4, d3), back_bc = hn::Sub(d5, d6);
  const auto at_a = hn::And(hn::Le(d1, zero), hn::Le(d2, zero)),
             at_b = hn::And(hn::Ge(d3, zero), hn::Le(d4, d3)),
             at_c = hn::And(hn::Ge(d6, zero), hn::Le(d5, d6));
  const auto on_ab = hn::And(hn::Le(vc, zero), hn::And(hn::Ge(d1, zero), hn::Le(d3, zero))),
             on_ac = hn::And(hn::Le(vb, zero), hn::And(hn::Ge(d2, zero), hn::Le(d6, zero))),
             on_bc =
                 hn::And(hn::Le(va, zero), hn::And(hn::Ge(along_bc, zero), hn::Ge(back_bc, zero)));
  // The point is a + (v / all) ab + (w / all) ac. Ericson's cases are applied in reverse: the first
  // that holds is written last.
  Many v = vb, w = vc, all = hn::Add(hn::Add(va, vb), vc);
  const auto put = [&](auto mask, Many weight_b, Many weight_c, Many sum) HWY_ATTR {
    v = hn::IfThenElse(mask, weight_b, v);
    w = hn::IfThenElse(mask, weight_c, w);
    all = hn::IfThenElse(mask, sum, all);
  };
  put(on_bc, back_bc, along_bc, hn::Add(along_bc, back_bc));
  put(on_ac, zero, d2, hn::Sub(d2, d6));
  put(at_c, zero, one, one);
  put(on_ab, d1, zero, hn::Sub(d1, d3));
  put(at_b, one, zero, one);
  put(at_a, zero, zero, one);
  // The result is a convex combination in spite of rounding, also for degenerate triangles.
  const Many safe = hn::IfThenElse(hn::Gt(all, zero), all, one);
  v = clampTo(hn::Div(v, safe), one);
  w = clampTo(hn::Div(w, safe), hn::Sub(one, v));
  PointPair pair;
  pair.from = p;
  for (int k = 0; k < 3; ++k)
    pair.way.x[k] = hn::Add(a.x[k], hn::Add(hn::Mul(v, ab.x[k]), hn::Mul(w, ac.x[k])));
  pair.squared = dot(pair.way, pair.way);
  return pair;
}

// The segment from -half to half and the edge from a to b (Ericson, section 5.1.9): the point where
// the two lines are nearest, clamped to the segment; the edge's point nearest to it; and the
// segment's point nearest to that.
HWY_INLINE PointPair nearestOnEdge(const Triple& half, const Triple& a, const Triple& b) {
  const Many zero = hn::Zero(kMany), one = hn::Set(kMany, 1.0);
  const Triple edge = difference(b, a);
  const Many hh = dot(half, half), he = dot(half, edge), ee = dot(edge, edge), ha = dot(half, a),
             ea = dot(edge, a);
  const auto positive = [&](Many x) HWY_ATTR { return hn::IfThenElse(hn::Gt(x, zero), x, one); };
  const auto along = [&](Many t) HWY_ATTR {
    const Many s = hn::Div(hn::Add(ha, hn::Mul(t, he)), positive(hh));
    return hn::Max(hn::Min(s, one), hn::Neg(one));
  };
  // On the two lines s hh - t he = ha and s he - t ee = ea.
  const Many across = hn::Sub(hn::Mul(hh, ee), hn::Mul(he, he));
  const Many s_lines =
      hn::Max(hn::Min(hn::Div(hn::Sub(hn::Mul(ha, ee), hn::Mul(ea, he)), positive(across)), one),
              hn::Neg(one));
  const Many t = clampTo(hn::Div(hn::Sub(hn::Mul(s_lines, he), ea), positive(ee)), one);
  const Many s = along(t);
  PointPair pair;
  for (int k = 0; k < 3; ++k) {
    pair.from.x[k] = hn::Mul(s, half.x[k]);
    pair.way.x[k] = hn::Sub(hn::Add(a.x[k], hn::Mul(t, edge.x[k])), pair.from.x[k]);
  }
  pair.squared = dot(pair.way, pair.way);
  return pair;
}

HWY_INLINE void keepNearer(const PointPair& pair, PointPair& best) {
  const auto nearer = hn::Lt(pair.squared, best.squared);
  best.squared = hn::IfThenElse(nearer, pair.squared, best.squared);
  for (int k = 0; k < 3; ++k) {
    best.from.x[k] = hn::IfThenElse(nearer, pair.from.x[k], best.from.x[k]);
    best.way.x[k] = hn::IfThenElse(nearer, pair.way.x[k], best.way.x[k]);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace leeway::collision
HWY_AFTER_NAMESPACE();

#endif
