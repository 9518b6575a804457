#include "collision/convex/epa/polytope_surface.h"

#include <algorithm>
#include <cmath>

#include "collision/base/exact_predicates.h"
#include "collision/base/tolerances.h"

namespace leeway::collision {

namespace {

constexpr int kVertexCapacity = 1024;
constexpr int kFacetCapacity = 2 * kVertexCapacity;
constexpr int kQueueCapacity = 16 * kVertexCapacity;
// A query adds no more than kVertexCapacity walks, so their numbers do not overflow.
constexpr std::int32_t kLastMark = 1 << 30;

struct Later {
  bool operator()(const PolytopeBuffers::Entry& a, const PolytopeBuffers::Entry& b) const {
    // A heap of the smallest key; ties by the lower slot, for determinism.
    return a.key > b.key || (a.key == b.key && a.facet > b.facet);
  }
};

inline int nextEdge(int e) { return e == 2 ? 0 : e + 1; }

}  // namespace

PolytopeBuffers::PolytopeBuffers() {
  vertices.reserve(kVertexCapacity);
  facets.reserve(kFacetCapacity);
  free_facets.reserve(kFacetCapacity);
  queue.reserve(kQueueCapacity);
  visible.reserve(kFacetCapacity);
  horizon.reserve(3 * kFacetCapacity);
  path.reserve(kFacetCapacity);
  edge_mark.reserve(kVertexCapacity);
}

int signOfDeterminant(const Vector& a, const Vector& b, const Vector& c) {
  const double value = a.dot(cross(b, c));
  const double error =
      16 * kUnitRoundoff * a.cwiseAbs().sum() * b.cwiseAbs().sum() * c.cwiseAbs().sum();
  if (value > error) return 1;
  if (value < -error) return -1;
  return orientation(Vector::Zero(), a, b, c);
}

PolytopeSurface::PolytopeSurface(PolytopeBuffers& buffers, double roundoff, const double& reach)
    : buffers_(buffers), roundoff_(roundoff), reach_(reach), mark_(buffers.mark) {
  buffers_.vertices.clear();
  buffers_.facets.clear();
  buffers_.queue.clear();
  buffers_.free_facets.clear();
  if (mark_ > kLastMark) {
    std::fill(buffers_.edge_mark.begin(), buffers_.edge_mark.end(), 0);
    mark_ = 0;
  }
}

SupportPoint& PolytopeSurface::nextVertex() {
  const auto next = static_cast<std::size_t>(vertex_count_);
  if (next == buffers_.vertices.size()) buffers_.vertices.emplace_back();
  if (next == buffers_.edge_mark.size()) buffers_.edge_mark.push_back(0);
  return buffers_.vertices[next];
}

bool PolytopeSurface::full() const { return vertex_count_ >= kVertexCapacity || room() < 8; }

std::size_t PolytopeSurface::room() const {
  return buffers_.free_facets.size() + static_cast<std::size_t>(kFacetCapacity - facetCount());
}

bool PolytopeSurface::makeTetrahedron() {
  int order[4] = {0, 1, 2, 3};
  const int side = orientation(w(0), w(1), w(2), w(3));
  if (side == 0) return false;
  if (side > 0) std::swap(order[1], order[2]);
  // The last vertex is behind the first three.
  const auto [a, b, c, d] = order;
  const int f0 = newFacet(a, b, c), f1 = newFacet(a, d, b), f2 = newFacet(b, d, c),
            f3 = newFacet(c, d, a);
  const auto join = [this](int f, int n0, int n1, int n2) {
    facet(f).neighbour[0] = n0;
    facet(f).neighbour[1] = n1;
    facet(f).neighbour[2] = n2;
  };
  join(f0, f1, f2, f3);
  join(f1, f3, f2, f0);
  join(f2, f1, f3, f0);
  join(f3, f2, f1, f0);
  winds_ = true;
  for (const int f : {f0, f1, f2, f3}) {
    const PolytopeFacet& t = facet(f);
    winds_ &= signOfDeterminant(w(t.vertex[0]), w(t.vertex[1]), w(t.vertex[2])) > 0;
  }
  return true;
}

Vector PolytopeSurface::nearestOf(const std::int32_t (&corner)[3], Vector& a) const {
  double weights[3];
  const Vector nearest = nearestOnTriangle(w(corner[0]), w(corner[1]), w(corner[2]), weights);
  a.setZero();
  for (int i = 0; i < 3; ++i) {
    a += weights[i] * vertex(corner[i]).a;
  }
  return nearest;
}

inline void PolytopeSurface::insert(int index, double key) {
  std::vector<PolytopeBuffers::Entry>& queue = buffers_.queue;
  if (static_cast<int>(queue.size()) >= kQueueCapacity) {
    // Drops the entries of removed facets; fewer than kFacetCapacity remain.
    std::size_t kept = 0;
    for (const PolytopeBuffers::Entry& e : queue) {
      const PolytopeFacet& f = facet(e.facet);
      if (f.alive && f.stamp == e.stamp) queue[kept++] = e;
    }
    queue.resize(kept);
    std::make_heap(queue.begin(), queue.end(), Later());
  }
  queue.push_back({key, index, facet(index).stamp});
  std::push_heap(queue.begin(), queue.end(), Later());
}

// Facets farther out than a supporting plane cannot be the nearest and stay out of the queue. This
// applies to most facets.
inline void PolytopeSurface::enqueue(int index, double longest_squared) {
  PolytopeFacet& f = facet(index);
  // Subtracts the normal's error over the length of the facet (all of the difference is within L of
  // the origin) and the rounding of the products.
  const double height = f.normal.dot(w(f.vertex[2])) - 32 * roundoff_ * longest_squared;
  const double out = std::max(reach_ + 16 * roundoff_, 0.0);
  // (Strictly, so that squares that overflow compare false.)
  if (height > 0 && height * height > out * out * f.length_squared) return;
  const double length = std::sqrt(f.length_squared);
  f.distance = length > 0 ? leastAlong(f, f.normal) / length : 0;
  Vector a;
  // Facets that see the origin are processed first, the nearest of them foremost: all of the
  // difference is within 4 L.
  insert(index, f.distance > 0 ? f.distance
                               : nearestOf(f.vertex, a).norm() - 4 * (roundoff_ / kUnitRoundoff));
}

inline int PolytopeSurface::newFacet(int a, int b, int c) {
  int index = facetCount();
  if (buffers_.free_facets.empty()) {
    buffers_.facets.emplace_back();
  } else {
    index = buffers_.free_facets.back();
    buffers_.free_facets.pop_back();
  }
  PolytopeFacet& f = facet(index);
  f.vertex[0] = a;
  f.vertex[1] = b;
  f.vertex[2] = c;
  f.alive = true;
  f.refined = false;
  f.mark = 0;
  ++f.stamp;
  double longest_squared = 0;
  f.normal = triangleNormal(w(a), w(b), w(c), longest_squared);
  f.length_squared = f.normal.squaredNorm();
  // In units of roundoff times the product of the edges' lengths: their cross product errs by less
  // than 7, the difference d and the dot product by 8 times the area, which is no larger.
  f.doubt = 16 * kUnitRoundoff * longest_squared;
  enqueue(index, longest_squared);
  return index;
}

void PolytopeSurface::push(int index, double key) { insert(index, key); }

int PolytopeSurface::pop() {
  std::vector<PolytopeBuffers::Entry>& queue = buffers_.queue;
  while (!queue.empty()) {
    std::pop_heap(queue.begin(), queue.end(), Later());
    const PolytopeBuffers::Entry entry = queue.back();
    queue.pop_back();
    const PolytopeFacet& f = facet(entry.facet);
    if (f.alive && f.stamp == entry.stamp) return entry.facet;
  }
  return -1;
}

// Finds the facets seen from p that are connected with `first`, and their horizon in the order of a
// loop. The walk follows a tree of facets, so it meets their rim in order. False if the rim is not
// a single loop without repeated vertices.
bool PolytopeSurface::findHorizon(int first, const Vector& p) {
  ++mark_;
  buffers_.visible.assign(1, first);
  buffers_.horizon.clear();
  buffers_.path.assign(1, {first, 0, 3});
  facet(first).mark = mark_;
  while (!buffers_.path.empty()) {
    PolytopeBuffers::Step& step = buffers_.path.back();
    if (step.left == 0) {
      buffers_.path.pop_back();
      continue;
    }
    const int e = step.edge;
    const PolytopeFacet& f = facet(step.facet);
    const int other = f.neighbour[e];
    PolytopeFacet& g = facet(other);
    step.edge = nextEdge(e);
    --step.left;
    if (g.mark == mark_) continue;
    const std::int32_t from = f.vertex[e], to = f.vertex[nextEdge(e)];
    const int back = g.vertex[0] == to ? 0 : g.vertex[1] == to ? 1 : 2;
    if (g.mark != -mark_ && sees(g, p)) {
      g.mark = mark_;
      buffers_.visible.push_back(other);
      buffers_.path.push_back({other, nextEdge(back), 2});
    } else {
      g.mark = -mark_;
      buffers_.horizon.push_back({from, to, other, back});
    }
  }
  const std::size_t count = buffers_.horizon.size();
  if (count < 3) return false;
  std::int32_t at = buffers_.horizon.back().to;
  for (const HorizonEdge& e : buffers_.horizon) {
    std::int32_t& mark = buffers_.edge_mark[static_cast<std::size_t>(e.from)];
    if (e.from != at || mark == mark_) return false;
    mark = mark_;
    at = e.to;
  }
  return true;
}

// Replaces a single facet, whose three edges always form a loop.
void PolytopeSurface::takeAlone(int first) {
  buffers_.visible.assign(1, first);
  buffers_.horizon.clear();
  const PolytopeFacet& f = facet(first);
  for (int e = 0; e < 3; ++e) {
    const PolytopeFacet& g = facet(f.neighbour[e]);
    const std::int32_t to = f.vertex[nextEdge(e)];
    const int back = g.vertex[0] == to ? 0 : g.vertex[1] == to ? 1 : 2;
    buffers_.horizon.push_back({f.vertex[e], to, f.neighbour[e], back});
  }
}

// Replacing a facet by three over p keeps the winding number if the origin is not in the
// tetrahedron (p, facet). It is not if all four points are strictly on one side of a plane through
// it.
bool PolytopeSurface::keepsWinding(const PolytopeFacet& f, const Vector& p) const {
  const Vector& n = f.refined ? f.outward : f.normal;
  const double rounding = 4 * roundoff_ * (f.refined ? 1.0 : std::sqrt(f.length_squared));
  return leastAlong(f, n) > rounding && n.dot(p) > rounding;
}

void PolytopeSurface::expand(int first) {
  const int apex = vertex_count_ - 1;
  const Vector p = w(apex);
  // (Rounding cannot split the rim into several loops, but the buffers may be full.)
  if (!findHorizon(first, p) || room() + buffers_.visible.size() < buffers_.horizon.size())
    takeAlone(first);
  for (const std::int32_t index : buffers_.visible) {
    PolytopeFacet& f = facet(index);
    winds_ = winds_ && keepsWinding(f, p);
    f.alive = false;
    buffers_.free_facets.push_back(index);
  }
  closeByFan(
      buffers_.horizon, [&](std::int32_t i) -> PolytopeFacet& { return facet(i); },
      [&](const HorizonEdge& e) { return newFacet(e.from, e.to, apex); });
}

// How often a ray from the origin crosses the surface outwards; nullopt if it meets an edge.
std::optional<int> PolytopeSurface::windingAlong(const Vector& ray) const {
  int winding = 0;
  for (int i = 0; i < facetCount(); ++i) {
    const PolytopeFacet& f = facet(i);
    if (!f.alive) continue;
    const Vector &a = w(f.vertex[0]), &b = w(f.vertex[1]), &c = w(f.vertex[2]);
    const int sa = signOfDeterminant(ray, b, c), sb = signOfDeterminant(ray, c, a),
              sc = signOfDeterminant(ray, a, b);
    const bool positive = sa > 0 || sb > 0 || sc > 0, negative = sa < 0 || sb < 0 || sc < 0;
    if (positive && negative) continue;  // the ray's line misses it
    const int side = signOfDeterminant(a, b, c);
    if (sa == 0 || sb == 0 || sc == 0 || side == 0) return std::nullopt;
    if (positive && side > 0) ++winding;  // otherwise the opposite ray crosses it
    if (negative && side < 0) --winding;
  }
  return winding;
}

bool PolytopeSurface::windsAroundOrigin() {
  winds_ = winds_ || computeWinding();
  return winds_;
}

// Tries rays through the middle of facets, until one meets no edge.
bool PolytopeSurface::computeWinding() const {
  int tried = 0;
  for (int i = 0; i < facetCount(); ++i) {
    const PolytopeFacet& f = facet(i);
    if (!f.alive) continue;
    // (Not the centroid: symmetric input often puts that on other facets' edges.)
    const Vector ray = 0.37 * w(f.vertex[0]) + 0.34 * w(f.vertex[1]) + 0.29 * w(f.vertex[2]);
    const std::optional<int> winding = windingAlong(ray);
    if (winding.has_value()) return *winding != 0;
    if (++tried == 4) break;
  }
  return false;
}

}  // namespace leeway::collision
