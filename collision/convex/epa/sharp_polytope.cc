#include "collision/convex/epa/sharp_polytope.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"

namespace leeway::collision {

namespace {

using Number = DoubleDouble;
using Wide = DoubleDoubleVector;
using Corner = SharpPolytopeBuffers::Corner;
using Facet = SharpPolytopeBuffers::Facet;

constexpr int kMostCorners = 192;
constexpr int kMostFacets = 2 * kMostCorners;
// Members of a flat difference that all triangles are made of [count].
constexpr int kMostFlat = 12;
// Rays along which the surface is looked at for winding around the origin [count].
constexpr int kRays = 6;

int next(int i) { return i == 2 ? 0 : i + 1; }

Wide unit(const Wide& v) { return Number(1) / norm(v) * v; }

// The nearest point of a triangle to the origin (Ericson 2005), with its weights.
Wide nearestOf(const Wide& a, const Wide& b, const Wide& c, Number (&weight)[3]) {
  const Number zero = 0, one = 1;
  const Wide ab = b - a, ac = c - a;
  // (A point of the triangle whatever rounding made of the weights; NaN fails.)
  const auto at = [&](Number v, Number w) {
    if (!(zero <= v)) v = zero;
    if (!(zero <= w)) w = zero;
    if (!(v <= one)) v = one;
    if (!(w <= one - v)) w = one - v;
    weight[0] = one - v - w, weight[1] = v, weight[2] = w;
    return a + v * ab + w * ac;
  };
  const Number d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= zero && d2 <= zero) return at(zero, zero);
  const Number d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (zero <= d3 && d4 <= d3) return at(one, zero);
  const Number vc = d1 * d4 - d3 * d2;
  if (vc <= zero && zero <= d1 && d3 <= zero) return at(d1 / (d1 - d3), zero);
  const Number d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (zero <= d6 && d5 <= d6) return at(zero, one);
  const Number vb = d5 * d2 - d1 * d6;
  if (vb <= zero && zero <= d2 && d6 <= zero) return at(zero, d2 / (d2 - d6));
  const Number va = d3 * d6 - d5 * d4;
  if (va <= zero && zero <= d4 - d3 && zero <= d5 - d6) {
    const Number w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return at(one - w, w);
  }
  const Number per = one / (va + vb + vc);
  return at(vb * per, vc * per);
}

class SharpPolytope {
 public:
  SharpPolytope(const SharpDifference& difference, SharpPolytopeBuffers& buffers,
                Progress& progress)
      : difference_(difference),
        buffers_(buffers),
        progress_(progress),
        size_(progress.query().roundoff / kUnitRoundoff) {}

  bool begin();
  void grow();
  /// The same where all members are in one plane and there are few of them: all of their triangles.
  void offerFlat();

 private:
  const Wide& w(int corner) const { return buffers_.corners[static_cast<std::size_t>(corner)].w; }
  Facet& facet(int i) { return buffers_.facets[static_cast<std::size_t>(i)]; }
  bool full() const {
    return corner_count_ >= kMostCorners ||
           progress_.iterations >= 2 * progress_.query().request.iteration_limit;
  }
  Corner support(const Wide& outward);
  bool isKnown(const Wide& p) const;
  int seenFrom(int first, const Wide& p) const;
  bool addFacet(int a, int b, int c, int& index);
  int worst() const;
  bool sees(const Facet& f, const Wide& p) const;
  bool walk(int first, const Wide& p);
  bool expand(int first);
  int windingAlong(const Wide& ray) const;
  bool windsAroundOrigin() const;
  void claim(const Facet& f);
  void offerMember(const Facet& f);

  const SharpDifference& difference_;
  SharpPolytopeBuffers& buffers_;
  Progress& progress_;
  const double size_;
  int corner_count_ = 0, facet_count_ = 0, mark_ = 0;
};

// The member that is farthest along `outward`, a unit vector; the plane across it is offered.
Corner SharpPolytope::support(const Wide& outward) {
  ++progress_.iterations;
  const Wide p_a = farthestOfCore(difference_.a(), -difference_.inA(outward)),
             p_b = farthestOfCore(difference_.b(), difference_.inB(outward));
  offerSharpPlane(difference_, -outward, progress_);
  Corner corner;
  corner.w = difference_.memberOf(p_a, p_b);
  corner.a = placed(difference_.X_BA(), p_a.rounded());
  return corner;
}

// False where it has no area to speak of.
bool SharpPolytope::addFacet(int a, int b, int c, int& index) {
  if (buffers_.free.empty()) {
    if (facet_count_ == kMostFacets) return false;
    index = facet_count_++;
  } else {
    index = buffers_.free.back();
    buffers_.free.pop_back();
  }
  Facet& f = facet(index);
  f.corner[0] = a, f.corner[1] = b, f.corner[2] = c;
  f.mark = 0;
  f.alive = true;
  const Wide normal = cross(w(b) - w(a), w(c) - w(a));
  const Number length = norm(normal);
  if (!(length.high > 0)) return false;
  f.outward = Number(1) / length * normal;
  f.height = dot(f.outward, w(a));
  for (const int other : {b, c}) {
    const Number here = dot(f.outward, w(other));
    if (here < f.height) f.height = here;
  }
  f.nearest = std::numeric_limits<double>::infinity();
  if (!(f.height.high > 0)) {
    Number weight[3];
    f.nearest = norm(nearestOf(w(a), w(b), w(c), weight));
  }
  return true;
}

// Four members: two that are far apart, one far from their line, and one far from the plane.
bool SharpPolytope::begin() {
  buffers_.free.clear();
  Corner found[4];
  // The member among those along `directions` and against them that spans most.
  const auto choose = [&](int slot, const Wide* directions, int count, const auto& spans) {
    double most = 0;
    for (int i = 0; i < 2 * count; ++i) {
      const Wide& d = directions[i / 2];
      const Corner here = support(i % 2 == 0 ? d : -d);
      const double spanned = spans(here.w);
      if (spanned > most) most = spanned, found[slot] = here;
    }
    return most;
  };
  const auto from = [&](const Wide& p) { return Wide(p - found[0].w); };
  const auto across = [&](const Vector& v) {
    const Vector helper = std::abs(v.x()) < 0.6 * v.norm() ? Vector::UnitX() : Vector::UnitY();
    return Vector(cross(v, helper));
  };
  const Vector n = progress_.normal(), u = across(n);
  const Wide axes[3] = {unit(difference_.inWorld(n)), unit(difference_.inWorld(u)),
                        unit(difference_.inWorld(cross(n, u)))};
  found[0] = support(axes[0]);
  if (!(choose(1, axes, 3, [&](const Wide& p) { return norm(from(p)).high; }) > 0)) return false;
  const Wide along = from(found[1].w);
  const Wide first = unit(cross(along, Wide(across(along.rounded())))),
             beside[2] = {first, unit(cross(along, first))};
  if (!(choose(2, beside, 2, [&](const Wide& p) { return norm(cross(along, from(p))).high; }) >
        0)) {
    return false;
  }
  const Wide normal = cross(along, from(found[2].w)), up = unit(normal);
  const double volume =
      choose(3, &up, 1, [&](const Wide& p) { return std::abs(dot(up, from(p)).high); });
  if (!(volume > kSharpRounding * size_)) return false;
  int order[4] = {0, 1, 2, 3};
  if (dot(up, from(found[3].w)).high > 0) std::swap(order[1], order[2]);
  // Now the last is behind the first three.
  for (const Corner& corner : found) {
    buffers_.corners[static_cast<std::size_t>(corner_count_++)] = corner;
  }
  const auto [a, b, c, d] = order;
  const int corners[4][3] = {{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}};
  constexpr int kNeighbours[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  for (int i = 0; i < 4; ++i) {
    int index = 0;
    if (!addFacet(corners[i][0], corners[i][1], corners[i][2], index)) return false;
    std::copy(kNeighbours[i], kNeighbours[i] + 3, facet(index).neighbour);
  }
  return true;
}

// The facet that is nearest of those that the origin is not behind, or else of all.
int SharpPolytope::worst() const {
  int best = -1, best_outside = -1;
  for (int i = 0; i < facet_count_; ++i) {
    const Facet& f = buffers_.facets[static_cast<std::size_t>(i)];
    if (!f.alive) continue;
    const auto& facets = buffers_.facets;
    if (!(f.height.high > 0)) {
      if (best_outside < 0 || f.nearest < facets[static_cast<std::size_t>(best_outside)].nearest) {
        best_outside = i;
      }
    } else if (best < 0 || f.height < facets[static_cast<std::size_t>(best)].height) {
      best = i;
    }
  }
  return best_outside >= 0 ? best_outside : best;
}

// (Any answer leaves the surface closed; the right one keeps it convex.)
bool SharpPolytope::sees(const Facet& f, const Wide& p) const {
  return dot(f.outward, p - w(f.corner[0])).high > kSharpRounding * size_;
}

// A corner already: planes of narrow facets are not told from it by rounding.
bool SharpPolytope::isKnown(const Wide& p) const {
  for (int i = 0; i < corner_count_; ++i) {
    if (!(norm(p - w(i)).high > kSharpRounding * size_)) return true;
  }
  return false;
}

// The facet from which p is farthest out; `first` where it sees p.
int SharpPolytope::seenFrom(int first, const Wide& p) const {
  if (sees(buffers_.facets[static_cast<std::size_t>(first)], p)) return first;
  int best = -1;
  double most = 0;
  for (int i = 0; i < facet_count_; ++i) {
    const Facet& f = buffers_.facets[static_cast<std::size_t>(i)];
    if (!f.alive || !sees(f, p)) continue;
    const double here = dot(f.outward, p - w(f.corner[0])).high;
    if (here > most) most = here, best = i;
  }
  return best;
}

// The facets seen from p that hang together with the first, and the edges around them; false where
// these are not one loop.
bool SharpPolytope::walk(int first, const Wide& p) {
  ++mark_;
  buffers_.visible.assign(1, first);
  buffers_.rim.clear();
  facet(first).mark = mark_;
  for (std::size_t i = 0; i < buffers_.visible.size(); ++i) {
    const int index = buffers_.visible[i];
    for (int side = 0; side < 3; ++side) {
      const int other = facet(index).neighbour[side];
      Facet& g = facet(other);
      if (g.mark == mark_) continue;
      if (sees(g, p)) {
        g.mark = mark_;
        buffers_.visible.push_back(other);
      }
    }
  }
  for (const int index : buffers_.visible) {
    const Facet& f = facet(index);
    for (int side = 0; side < 3; ++side) {
      const int other = f.neighbour[side];
      const Facet& g = facet(other);
      if (g.mark == mark_) continue;
      const int from = f.corner[side], to = f.corner[next(side)];
      const int back = g.corner[0] == to ? 0 : g.corner[1] == to ? 1 : 2;
      buffers_.rim.push_back({from, to, other, back});
    }
  }
  // In the order of a loop.
  std::vector<HorizonEdge>& rim = buffers_.rim;
  for (std::size_t i = 0; i + 1 < rim.size(); ++i) {
    std::size_t found = rim.size();
    for (std::size_t j = i + 1; j < rim.size(); ++j) {
      if (rim[j].from != rim[i].to) continue;
      if (found < rim.size()) return false;  // a corner twice
      found = j;
    }
    if (found == rim.size()) return false;
    std::swap(rim[i + 1], rim[found]);
  }
  return rim.size() >= 3 && rim.back().to == rim.front().from;
}

// Exchanges the facets seen from the newest corner for a fan over it.
bool SharpPolytope::expand(int first) {
  const int apex = corner_count_ - 1;
  if (!walk(first, w(apex))) {
    buffers_.visible.assign(1, first);
    buffers_.rim.clear();
    const Facet& f = facet(first);
    for (int side = 0; side < 3; ++side) {
      const Facet& g = facet(f.neighbour[side]);
      const int to = f.corner[next(side)];
      const int back = g.corner[0] == to ? 0 : g.corner[1] == to ? 1 : 2;
      buffers_.rim.push_back({f.corner[side], to, f.neighbour[side], back});
    }
  }
  for (const int index : buffers_.visible) {
    facet(index).alive = false;
    buffers_.free.push_back(index);
  }
  return closeByFan(
      buffers_.rim, [&](std::int32_t i) -> Facet& { return facet(i); },
      [&](const HorizonEdge& e) {
        int index = 0;
        return addFacet(e.from, e.to, apex, index) ? index : -1;
      });
}

// How often the surface is crossed outwards along a ray from the origin; -1000 where rounding
// leaves that open.
int SharpPolytope::windingAlong(const Wide& ray) const {
  const double doubt = kSharpDeterminant * size_ * size_;
  int winding = 0;
  for (int i = 0; i < facet_count_; ++i) {
    const Facet& f = buffers_.facets[static_cast<std::size_t>(i)];
    if (!f.alive) continue;
    const Wide &a = w(f.corner[0]), &b = w(f.corner[1]), &c = w(f.corner[2]);
    const double side[3] = {dot(ray, cross(b, c)).high, dot(ray, cross(c, a)).high,
                            dot(ray, cross(a, b)).high};
    bool positive = false, negative = false, open = false;
    for (const double s : side) {
      positive |= s > doubt;
      negative |= s < -doubt;
      open |= !(std::abs(s) > doubt);
    }
    if (positive && negative) continue;  // the ray's line passes beside it
    const double height = dot(a, cross(b, c)).high;
    if (open || !(std::abs(height) > doubt * size_)) return -1000;
    if (positive && height > 0) ++winding;  // else the opposite ray crosses it
    if (negative && height < 0) --winding;
  }
  return winding;
}

bool SharpPolytope::windsAroundOrigin() const {
  int tried = 0;
  for (int i = 0; i < facet_count_ && tried < kRays; ++i) {
    const Facet& f = buffers_.facets[static_cast<std::size_t>(i)];
    if (!f.alive) continue;
    const Wide middle = Number(0.37) * w(f.corner[0]) + Number(0.34) * w(f.corner[1]) +
                        Number(0.29) * w(f.corner[2]);
    const Number length = norm(middle);
    if (!(length.high > 0)) continue;
    ++tried;
    const int winding = windingAlong(Number(1) / length * middle);
    if (winding != -1000) return winding == 1;
  }
  return false;
}

// The nearest point of a facet that the origin is not behind.
void SharpPolytope::offerMember(const Facet& f) {
  Number weight[3];
  const Wide nearest = nearestOf(w(f.corner[0]), w(f.corner[1]), w(f.corner[2]), weight);
  Vector a = Vector::Zero();
  for (int i = 0; i < 3; ++i) {
    a += weight[i].high * buffers_.corners[static_cast<std::size_t>(f.corner[i])].a;
  }
  offerSharpWitness(difference_, norm(nearest), 0, difference_.inB(nearest).rounded(), a,
                    progress_);
}

// The depth, where all facets are farther out than the nearest of them.
void SharpPolytope::claim(const Facet& f) {
  if (!windsAroundOrigin()) return;
  Number weight[3];
  const Wide nearest = nearestOf(w(f.corner[0]), w(f.corner[1]), w(f.corner[2]), weight);
  Vector a = Vector::Zero();
  for (int i = 0; i < 3; ++i) {
    a += weight[i].high * buffers_.corners[static_cast<std::size_t>(f.corner[i])].a;
  }
  offerSharpWitness(difference_, -f.height, kSharpRounding * size_,
                    difference_.inB(nearest).rounded(), a, progress_);
}

void SharpPolytope::offerFlat() {
  const ConvexView &a = difference_.a(), &b = difference_.b();
  const int count_a = vertexCount(a), count_b = vertexCount(b);
  if (count_a * count_b == 0 || count_a * count_b > kMostFlat) return;
  for (int i = 0; i < count_a; ++i) {
    for (int j = 0; j < count_b; ++j) {
      Vector p_a = Vector::Zero(), p_b = Vector::Zero();
      vertex(a, i, p_a);
      vertex(b, j, p_b);
      Corner& corner = buffers_.corners[static_cast<std::size_t>(i * count_b + j)];
      corner.w = difference_.memberOf(Wide(p_a), Wide(p_b));
      corner.a = placed(difference_.X_BA(), p_a);
    }
  }
  Facet f = {};
  Wide nearest;
  Number least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count_a * count_b; ++i) {
    for (int j = 0; j <= i; ++j) {
      for (int k = 0; k <= j; ++k) {
        Number weight[3];
        const Wide p = nearestOf(w(i), w(j), w(k), weight);
        const Number apart = norm(p);
        if (!(apart < least)) continue;
        least = apart, nearest = p;
        f.corner[0] = i, f.corner[1] = j, f.corner[2] = k;
      }
    }
  }
  offerMember(f);
  if (least.high > 0) offerSharpPlane(difference_, nearest, progress_);
}

void SharpPolytope::grow() {
  for (;;) {
    const int index = worst();
    if (index < 0) return;
    const Facet f = facet(index);
    const bool outside = !(f.height.high > 0);
    // Outside of the facet towards the origin, from its nearest point where that is on its rim.
    Wide outward = f.outward;
    const bool on_rim = outside && f.nearest.high > kSharpRounding * size_ &&
                        f.nearest.high > -f.height.high * (1 + kOnRim);
    if (outside) offerMember(f);
    if (on_rim) {
      Number weight[3];
      outward = -unit(nearestOf(w(f.corner[0]), w(f.corner[1]), w(f.corner[2]), weight));
    }
    if (progress_.enough() || full()) break;
    int seen = -1;
    for (int i = on_rim ? 0 : 1; i < 2 && seen < 0; ++i) {
      if (i == 1) outward = f.outward;
      Corner& fresh = buffers_.corners[static_cast<std::size_t>(corner_count_)];
      fresh = support(outward);
      if (!isKnown(fresh.w)) seen = seenFrom(index, fresh.w);
    }
    if (progress_.enough() || seen < 0) break;
    ++corner_count_;
    if (!expand(seen)) return;
    // What is as near as asked is claimed once: looking around is as much as a few steps.
    const int nearest = worst();
    if (nearest < 0) return;
    const Facet& g = facet(nearest);
    if (g.height.high > 0 && -g.height.high - progress_.lower() - progress_.query().radius_a -
                                     progress_.query().radius_b <=
                                 progress_.query().request.tolerance) {
      claim(g);
      if (progress_.enough()) return;
    }
  }
  const int index = worst();
  if (index >= 0 && facet(index).height.high > 0) claim(facet(index));
}

}  // namespace

SharpPolytopeBuffers::SharpPolytopeBuffers() {
  corners.resize(kMostCorners);
  facets.resize(kMostFacets);
  free.reserve(kMostFacets);
  visible.reserve(kMostFacets);
  rim.reserve(3 * kMostFacets);
}

void growSharpPolytope(const SharpDifference& difference, SharpPolytopeBuffers& buffers,
                       Progress& progress) {
  SharpPolytope polytope(difference, buffers, progress);
  if (polytope.begin()) {
    polytope.grow();
  } else {
    polytope.offerFlat();
  }
}

}  // namespace leeway::collision
