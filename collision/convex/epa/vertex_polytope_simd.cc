#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "collision/convex/epa/vertex_polytope.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/convex/epa/vertex_polytope_simd.cc"
#include "collision/base/targets.h"
//
#include <hwy/foreach_target.h>
//
#include "collision/base/dispatch.h"
#include "collision/convex/gjk/vertex_cores-inl.h"

// The polytope of epa.h in plain arithmetic. It checks the conditions of its claims on the way, and
// claims nothing if one is in doubt.
//
// The surface is closed. It starts as a tetrahedron. A set of triangles is only ever replaced by
// one triangle over each of their directed edges whose reverse is not removed, and every directed
// edge exists at most once. The surface winds around the origin: every triangle, and the point that
// replaces it, is farther out along its normal than rounding, so their tetrahedron does not hold
// the origin. Rounding may misjudge which triangles a point sees if it is in their planes. That
// folds the surface, but opens nothing.
//
// Rounding: a normal's length is 1 within 4 units of roundoff, and products with it err by 3 units
// of L (see gjk.cc). With the error of the members, kSupportRounding covers it.

HWY_BEFORE_NAMESPACE();
namespace leeway::collision::HWY_NAMESPACE {
namespace {

template <int n>
HWY_INLINE Lanes<n> leastOf(const Lanes<n>& a, const Lanes<n>& b) {
  return eachLane<n>([&](int i) HWY_ATTR { return hn::Min(a.v[i], b.v[i]); });
}
template <int n>
HWY_INLINE Lanes<n> mostOf(const Lanes<n>& a, const Lanes<n>& b) {
  return eachLane<n>([&](int i) HWY_ATTR { return hn::Max(a.v[i], b.v[i]); });
}

class VertexPolytope {
 public:
  HWY_INLINE VertexPolytope(const PlacedCores& cores, const CoreQuery& query, int iterations)
      : cores_(cores), query_(query), iterations_(iterations), rounding_(8 * query.roundoff) {}

  /// Starts from four points; false if they do not hold the origin by more than rounding.
  HWY_INLINE bool begin(const Simplex& start);
  HWY_INLINE void grow(VertexPolytopeAnswer& answer);
  HWY_INLINE int iterations() const { return iterations_; }
  HWY_INLINE const VertexIndices& lastIndices() const { return indices_[vertex_count_ - 1]; }

 private:
  static constexpr int kVertices = 32, kFacets = 64, kEight = 8;
  // (Limits on the facets that one point removes, and on their edges.)
  static constexpr int kMostSeen = 20, kEdges = 64;

  HWY_INLINE Triple vertex(int i) const { return {x_[i], y_[i], z_[i]}; }
  HWY_INLINE void addVertex(const Triple& p, const VertexIndices& indices) {
    x_[vertex_count_] = p.x;
    y_[vertex_count_] = p.y;
    z_[vertex_count_] = p.z;
    indices_[vertex_count_++] = indices;
  }
  HWY_INLINE Points<kEight> verticesAt(const std::int64_t* places) const {
    const Widest d;
    const auto gather = [&](const double* coordinates) HWY_ATTR {
      return eachLane<kEight>([&](int i) HWY_ATTR {
        const auto at = hn::Load(hn::RebindToSigned<Widest>(),
                                 places + static_cast<std::size_t>(i) * hn::MaxLanes(d));
        return gathered(coordinates, at);
      });
    };
    return {gather(x_), gather(y_), gather(z_)};
  }
  HWY_INLINE bool place(const Points<kEight>& a, const Points<kEight>& b, const Points<kEight>& c,
                        const std::int64_t* indices_a, const std::int64_t* indices_b,
                        const std::int64_t* indices_c, const std::int32_t* slots, int count);
  HWY_INLINE int nearest() const;
  HWY_INLINE std::uint64_t seenFrom(const Triple& p) const;
  HWY_INLINE bool expand(std::uint64_t seen);
  HWY_INLINE void clearEight(int from) {
    const Lanes<kEight> none = allLanes<kEight>(0.0),
                        far = allLanes<kEight>(std::numeric_limits<double>::infinity());
    store(none, nx_ + from);
    store(none, ny_ + from);
    store(none, nz_ + from);
    store(far, least_ + from);
    store(far, most_ + from);
  }
  // Returns a slot for a new facet; slots are cleared one register at a time.
  HWY_INLINE std::int32_t newSlot() {
    if (facet_count_ % kEight == 0) clearEight(facet_count_);
    return facet_count_++;
  }
  HWY_INLINE void report(int facet, double within, VertexPolytopeAnswer& answer) const;

  const PlacedCores& cores_;
  const CoreQuery& query_;
  int iterations_;
  const double rounding_;
  int vertex_count_ = 0, facet_count_ = 0;
  // For each facet: the outward unit normal, and the least and greatest distance of its corners
  // along it.
  alignas(64) double nx_[kFacets], ny_[kFacets], nz_[kFacets], least_[kFacets], most_[kFacets];
  alignas(64) double x_[kVertices], y_[kVertices], z_[kVertices];
  std::uint8_t corner_[kFacets][4];
  VertexIndices indices_[kVertices];
};

// Makes facets with corners a, b, c, counter-clockwise from outside. False if one is not farther
// out than rounding, or has no normal. (Written so that NaN fails.)
HWY_INLINE bool VertexPolytope::place(const Points<kEight>& a, const Points<kEight>& b,
                                      const Points<kEight>& c, const std::int64_t* indices_a,
                                      const std::int64_t* indices_b, const std::int64_t* indices_c,
                                      const std::int32_t* slots, int count) {
  // The cross product of the two shorter edges has the least rounding.
  const Points<kEight> u = a - c, v = b - c, w = b - a;
  const Lanes<kEight> uu = dot(u, u), vv = dot(v, v), ww = dot(w, w);
  const Mask<kEight> u_longer = uu > vv;
  const Points<kEight> shorter = choose(u_longer, v, u);
  const Mask<kEight> base_longest = ww > mostOf(uu, vv);
  const Points<kEight> normal = cross(choose(base_longest, u, shorter), choose(base_longest, v, w));
  const Lanes<kEight> squared_length = dot(normal, normal);
  const Lanes<kEight> per = eachLane<kEight>([&](int i) HWY_ATTR {
    return hn::Div(hn::Set(Widest(), 1.0), hn::Sqrt(squared_length.v[i]));
  });
  const Points<kEight> n = per * normal;
  const Lanes<kEight> at_a = dot(n, a), at_b = dot(n, b), at_c = dot(n, c);
  const Lanes<kEight> least = leastOf(leastOf(at_a, at_b), at_c);
  if (HWY_UNLIKELY(bitsOf(least > allLanes<kEight>(rounding_)) != 0xffU)) return false;
  const Lanes<kEight> most = mostOf(mostOf(at_a, at_b), at_c);
  alignas(64) double nx[kEight], ny[kEight], nz[kEight], low[kEight], high[kEight];
  store(n.x, nx);
  store(n.y, ny);
  store(n.z, nz);
  store(least, low);
  store(most, high);
  for (int i = 0; i < count; ++i) {
    const std::int32_t slot = slots[i];
    nx_[slot] = nx[i];
    ny_[slot] = ny[i];
    nz_[slot] = nz[i];
    least_[slot] = low[i];
    most_[slot] = high[i];
    corner_[slot][0] = static_cast<std::uint8_t>(indices_a[i]);
    corner_[slot][1] = static_cast<std::uint8_t>(indices_b[i]);
    corner_[slot][2] = static_cast<std::uint8_t>(indices_c[i]);
  }
  return true;
}

HWY_INLINE bool VertexPolytope::begin(const Simplex& start) {
  for (int i = 0; i < 4; ++i) {
    const SupportPoint& s = start.point(i);
    addVertex(tripleOf(s.w), {s.index_a, s.index_b});
  }
  // Orders a, b, c counter-clockwise from outside, with the origin and d behind them.
  const Triple a = vertex(0), b = vertex(1), c = vertex(2);
  const bool outwards = dot(cross(b - a, c - a), a) > 0;
  const std::int64_t j = outwards ? 1 : 2, k = 3 - j;
  alignas(64) const std::int64_t first[kEight] = {0, 0, j, k, 0, 0, 0, 0},
                                 second[kEight] = {j, 3, 3, 3, j, j, j, j},
                                 third[kEight] = {k, j, k, 0, k, k, k, k};
  // The proof that the origin is inside must not depend on normals, because slivers have none.
  for (int i = 0; i < 4; ++i) {
    const Triple p = vertex(static_cast<int>(first[i])), q = vertex(static_cast<int>(second[i])),
                 r = vertex(static_cast<int>(third[i]));
    const auto size = [](const Triple& v)
                          HWY_ATTR { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
    const double error = 16 * kUnitRoundoff * size(p) * size(q) * size(r);
    if (!(dot(p, cross(q, r)) > error)) return false;
  }
  const std::int32_t slots[4] = {newSlot(), newSlot(), newSlot(), newSlot()};
  return place(verticesAt(first), verticesAt(second), verticesAt(third), first, second, third,
               slots, 4);
}

// The first of the nearest facets.
HWY_INLINE int VertexPolytope::nearest() const {
  const Widest d;
  constexpr int kStep = static_cast<int>(hn::MaxLanes(Widest()));
  Same least = hn::Load(d, least_);
  for (int i = kStep; i < facet_count_; i += kStep) least = hn::Min(least, hn::Load(d, least_ + i));
  const Lanes<kEight> value = allLanes<kEight>(leastLane(least));
  for (int i = 0; i < facet_count_; i += kEight) {
    const unsigned farther = bitsOf(load<kEight>(least_ + i) > value);
    if (farther != 0xffU) return i + std::countr_one(farther);
  }
  return 0;
}

HWY_INLINE std::uint64_t VertexPolytope::seenFrom(const Triple& p) const {
  const Points<kEight> all = allLanes<kEight>(p);
  const Lanes<kEight> rounding = allLanes<kEight>(rounding_);
  std::uint64_t seen = 0;
  for (int i = 0; i < facet_count_; i += kEight) {
    const Points<kEight> n = {load<kEight>(nx_ + i), load<kEight>(ny_ + i), load<kEight>(nz_ + i)};
    const Mask<kEight> here = dot(n, all) > load<kEight>(most_ + i) + rounding;
    seen |= static_cast<std::uint64_t>(bitsOf(here)) << static_cast<unsigned>(i);
  }
  return seen;
}

// Replaces the facets that the newest vertex sees by a fan over it.
HWY_INLINE bool VertexPolytope::expand(std::uint64_t seen) {
  const int seen_count = std::popcount(seen);
  if (HWY_UNLIKELY(seen_count > kMostSeen)) return false;
  std::uint32_t edges_from[kVertices] = {};  // bit j of i: an edge goes from i to j
  std::int32_t slots[kEdges];
  int slot_count = 0;
  for (std::uint64_t rest = seen; rest != 0; rest &= rest - 1) {
    const int i = std::countr_zero(rest);
    const std::uint8_t* c = corner_[i];
    slots[slot_count++] = i;
    edges_from[c[0]] |= 1U << c[1];
    edges_from[c[1]] |= 1U << c[2];
    edges_from[c[2]] |= 1U << c[0];
  }
  alignas(64) std::int64_t from[kEdges], to[kEdges], apex[kEdges];
  std::uint32_t all_from = 0, all_to = 0;
  bool once = true;
  int count = 0;
  const std::int64_t newest = vertex_count_ - 1;
  for (int i = 0; i < slot_count; ++i) {
    const std::uint8_t* c = corner_[slots[i]];
    for (int k = 0; k < 3; ++k) {
      const unsigned p = c[k], q = c[k == 2 ? 0 : k + 1];
      from[count] = p;
      to[count] = q;
      // (Branch-free: which edges are on the horizon is unpredictable.)
      const std::uint32_t on_horizon = ~(edges_from[q] >> p) & 1U;
      once &= (((all_from >> p) | (all_to >> q)) & on_horizon) == 0;
      all_from |= on_horizon << p;
      all_to |= on_horizon << q;
      count += static_cast<int>(on_horizon);
    }
  }
  if (HWY_UNLIKELY(!once || count < 3 || count > kEdges - kEight)) return false;
  while (slot_count < count) {
    if (HWY_UNLIKELY(facet_count_ == kFacets)) return false;
    slots[slot_count++] = newSlot();
  }
  // Pads the last eight with copies of the first.
  for (int i = count; i % kEight != 0; ++i) from[i] = from[0], to[i] = to[0];
  for (int i = 0; i < (count + kEight - 1) / kEight * kEight; ++i) apex[i] = newest;
  const Points<kEight> top = allLanes<kEight>(vertex(vertex_count_ - 1));
  for (int i = 0; i < count; i += kEight) {
    if (!place(verticesAt(from + i), verticesAt(to + i), top, from + i, to + i, apex + i, slots + i,
               std::min(kEight, count - i))) {
      return false;
    }
  }
  for (int i = count; i < slot_count; ++i) {
    nx_[slots[i]] = ny_[slots[i]] = nz_[slots[i]] = 0;
    least_[slots[i]] = most_[slots[i]] = std::numeric_limits<double>::infinity();
  }
  return true;
}

// Reports a facet's depth and its corners, then those of facets that are about as close.
HWY_INLINE void VertexPolytope::report(int facet, double within,
                                       VertexPolytopeAnswer& answer) const {
  const auto add = [&](int i) HWY_ATTR {
    for (int k = 0; k < 3; ++k) {
      const VertexIndices& indices = indices_[corner_[i][k]];
      answer.near_a[answer.near_count][k] = indices.a;
      answer.near_b[answer.near_count][k] = indices.b;
    }
    ++answer.near_count;
  };
  answer.depth = least_[facet];
  add(facet);
  for (int i = 0; i < facet_count_ && answer.near_count < VertexPolytopeAnswer::kMostNear; ++i) {
    if (i != facet && least_[i] <= answer.depth + within) add(i);
  }
}

HWY_INLINE void VertexPolytope::grow(VertexPolytopeAnswer& answer) {
  using End = VertexPolytopeAnswer::End;
  const DistanceRequest& request = query_.request;
  for (;;) {
    const int i = nearest();
    const double upper = -least_[i] - query_.upper_offset;
    if (upper <= request.threshold || (!request.depth && upper <= 0)) {
      answer.end = End::kDecided;
      report(i, 0, answer);
      return;
    }
    if (iterations_ >= request.iteration_limit || vertex_count_ == kVertices) {
      report(i, 0, answer);
      return;
    }
    ++iterations_;
    const Triple outward = {nx_[i], ny_[i], nz_[i]};
    VertexIndices indices = indices_[corner_[i][0]];
    const Triple p = cores_.support(-outward, indices);
    const double reach = dot(outward, p);
    const double lower = -reach - query_.lower_offset;
    const bool met = upper - lower <= request.tolerance && upper <= 0;
    // If several translations separate equally well, the plane must belong to the facet.
    if (met || reach < answer.reach) answer.outward = outward, answer.reach = reach;
    if (met || lower > request.threshold) {
      answer.end = lower > request.threshold ? End::kDecided : End::kMet;
      report(i, request.tolerance, answer);
      return;
    }
    const std::uint64_t seen = seenFrom(p);
    if (HWY_UNLIKELY(((seen >> static_cast<unsigned>(i)) & 1U) == 0)) return;
    addVertex(p, indices);
    if (HWY_UNLIKELY(!expand(seen))) return;
  }
}

}  // namespace

void vertexPolytope(Difference<false>& difference, const Simplex& start, Progress& progress,
                    VertexPolytopeAnswer& answer) {
  const PlacedCores cores(difference, true);
  VertexPolytope polytope(cores, progress.query(), progress.iterations);
  if (!polytope.begin(start)) return;
  polytope.grow(answer);
  progress.iterations = polytope.iterations();
  difference.setHints(polytope.lastIndices().a, polytope.lastIndices().b);
}

}  // namespace leeway::collision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace leeway::collision {

HWY_EXPORT(vertexPolytope);

bool growVertexPolytope(Difference<false>& difference, const Simplex& start, Progress& progress) {
  using End = VertexPolytopeAnswer::End;
  const CoreQuery& query = progress.query();
  // A tolerance close to the width that rounding and excess leave is left to the robust steps.
  const double narrow = query.lower_offset - query.upper_offset + 16 * query.roundoff;
  if (query.request.depth && !(query.request.tolerance > narrow)) return false;
  VertexPolytopeAnswer answer;
  const int before = progress.iterations;
  LEEWAY_DISPATCH(vertexPolytope)(difference, start, progress, answer);
  const Vector outward(answer.outward.x, answer.outward.y, answer.outward.z);
  // Selects, among several facets in one plane, the one that the normal passes through.
  double least = std::numeric_limits<double>::infinity();
  Vector nearest = Vector::Zero(), a = Vector::Zero();
  for (int i = 0; i < answer.near_count && !(least - answer.depth <= query.roundoff); ++i) {
    SupportPoint corner[3];
    for (int k = 0; k < 3; ++k)
      difference.member(answer.near_a[i][k], answer.near_b[i][k], corner[k]);
    double weights[3];
    const Vector here = nearestOnTriangle(corner[0].w, corner[1].w, corner[2].w, weights);
    const double norm = here.norm();
    if (!(norm < least)) continue;
    least = norm;
    nearest = here;
    a = weights[0] * corner[0].a + weights[1] * corner[1].a + weights[2] * corner[2].a;
  }
  if (answer.end == End::kMet) {
    return least - answer.depth <= query.request.tolerance &&
           progress.offerTogether(-answer.depth, nearest, a, -answer.reach, -outward);
  }
  progress.offerLower(-answer.reach, -outward);
  if (answer.near_count > 0) progress.offerWitness(-answer.depth, nearest, a);
  // The robust steps start again, with all iterations.
  if (answer.end == End::kOpen && progress.iterations < query.request.iteration_limit) {
    progress.iterations = before;
  }
  return progress.enough();
}

}  // namespace leeway::collision
#endif
