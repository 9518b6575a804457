#include "collision/penetration.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/exact.h"

namespace leeway::collision {

namespace {

constexpr int kVertexCapacity = 1024;
constexpr int kFacetCapacity = 2 * kVertexCapacity;
constexpr int kQueueCapacity = 16 * kVertexCapacity;

}  // namespace

PolytopeBuffers::PolytopeBuffers() {
  vertices.resize(kVertexCapacity);
  facets.resize(kFacetCapacity);
  free_facets.reserve(kFacetCapacity);
  queue.reserve(kQueueCapacity);
  visible.reserve(kFacetCapacity);
  horizon.reserve(3 * kFacetCapacity);
  loop.reserve(3 * kFacetCapacity);
  edge_from.resize(kVertexCapacity);
}

namespace {

bool later(const PolytopeBuffers::Entry& a, const PolytopeBuffers::Entry& b) {
  // Heap of the smallest key; the lower slot first among equals, for determinism.
  return a.key > b.key || (a.key == b.key && a.facet > b.facet);
}

// Normal of a triangle, not normalised, from its two shorter edges: the cross product's rounding is
// in proportion to them.
Vector triangleNormal(const Vector& a, const Vector& b, const Vector& c) {
  const Vector ab = b - a, bc = c - b, ca = a - c;
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return cross(bc, ca);
  if (bc2 >= ca2) return cross(ca, ab);
  return cross(ab, bc);
}

// Coordinates too small for exact arithmetic become 0: far below the rounding that all vertices
// carry (see kSmallestScale).
void clean(Vector& w) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(w[i]) < kSmallestExact) w[i] = 0;
  }
}

// Sign of the determinant of three vectors.
int signOfDeterminant(const Vector& a, const Vector& b, const Vector& c) {
  const double value = a.dot(cross(b, c));
  const double error =
      16 * kUnitRoundoff * a.cwiseAbs().sum() * b.cwiseAbs().sum() * c.cwiseAbs().sum();
  if (value > error) return 1;
  if (value < -error) return -1;
  return orientation(Vector::Zero(), a, b, c);
}

class Polytope {
 public:
  Polytope(Difference<false>& difference, PolytopeBuffers& buffers, Progress& progress)
      : difference_(difference),
        buffers_(buffers),
        progress_(progress),
        roundoff_(progress.query().roundoff) {}

  // False when the difference is flat: the lower ends found on the way are all there is.
  bool begin(const Simplex& start);
  void grow();

 private:
  bool full() const {
    return progress_.iterations >= progress_.query().request.iteration_limit ||
           vertex_count_ >= kVertexCapacity || room() < 8;
  }
  std::size_t room() const {
    return buffers_.free_facets.size() + static_cast<std::size_t>(kFacetCapacity - facet_count_);
  }
  const Vector& w(int vertex) const {
    return buffers_.vertices[static_cast<std::size_t>(vertex)].w;
  }
  PolytopeFacet& facet(int i) { return buffers_.facets[static_cast<std::size_t>(i)]; }

  bool ask(const Vector& n, SupportPoint& found);
  template <class Far>
  bool complete(const Vector* directions, int count, Far far);
  int newFacet(int a, int b, int c);
  void measure(PolytopeFacet& f);
  void push(int index);
  void refine(PolytopeFacet& f);
  void offerFacet(const PolytopeFacet& f);
  bool sees(const PolytopeFacet& f, const Vector& p) const;
  bool collect(int first, const Vector& p);
  bool orderHorizon();
  void expand(int first);
  bool windsAroundOrigin();
  int windingAlong(const Vector& ray);
  double triangleDistance(const PolytopeFacet& f) const;

  Difference<false>& difference_;
  PolytopeBuffers& buffers_;
  Progress& progress_;
  const double roundoff_;
  int vertex_count_ = 0;
  int facet_count_ = 0;  // slots of buffers_.facets in use or free
  int mark_ = 0;
  bool winds_ = false;  // proven: the surface winds around the origin
  bool left_facing_ =
      false;  // a facet that sees the origin was given up: no claim of depth can be made
};

// The support point along n, its plane offered; true when the request is met by it.
bool Polytope::ask(const Vector& n, SupportPoint& found) {
  ++progress_.iterations;
  difference_.support(n, found);
  clean(found.w);
  progress_.offerLower(n.dot(found.w), n);
  return progress_.enough();
}

// Adds the first support point among `directions` and their opposites that is far enough.
template <class Far>
bool Polytope::complete(const Vector* directions, int count, Far far) {
  for (int i = 0; i < count; ++i) {
    for (const double sign : {1.0, -1.0}) {
      if (full()) return false;
      SupportPoint& s = buffers_.vertices[static_cast<std::size_t>(vertex_count_)];
      if (ask(sign * directions[i], s)) return false;
      if (far(s.w)) {
        ++vertex_count_;
        return true;
      }
    }
  }
  return false;
}

bool Polytope::begin(const Simplex& start) {
  buffers_.queue.clear();
  buffers_.free_facets.clear();
  vertex_count_ = start.count;
  for (int i = 0; i < start.count; ++i) {
    SupportPoint& s = buffers_.vertices[static_cast<std::size_t>(i)];
    s = start.point(i);
    clean(s.w);
  }
  // Nearer than this to the flat spanned so far is the same as in it.
  const double flat = 8 * roundoff_;
  if (vertex_count_ == 1) {
    const Vector axes[3] = {Vector::UnitX(), Vector::UnitY(), Vector::UnitZ()};
    const Vector p = w(0);
    if (!complete(axes, 3, [&](const Vector& q) { return (q - p).norm() > flat; })) return false;
  }
  if (vertex_count_ == 2) {
    const Vector p = w(0);
    const Vector along = (w(1) - p).normalized();
    int axis = 0;
    along.cwiseAbs().minCoeff(&axis);
    const Vector first = cross(along, Vector::Unit(axis)).normalized();
    const Vector across[2] = {first, cross(along, first)};
    if (!complete(across, 2, [&](const Vector& q) { return cross(q - p, along).norm() > flat; })) {
      return false;
    }
  }
  if (vertex_count_ == 3) {
    const Vector p = w(0);
    Vector n = triangleNormal(p, w(1), w(2)).normalized();
    // Towards the origin first, so that the tetrahedron holds it if it can.
    if (n.dot(p) < 0) n = -n;
    if (!complete(&n, 1, [&](const Vector& q) { return std::abs(n.dot(q - p)) > flat; })) {
      return false;
    }
  }
  int order[4] = {0, 1, 2, 3};
  const int side = orientation(w(0), w(1), w(2), w(3));
  if (side == 0) return false;
  if (side > 0) std::swap(order[1], order[2]);
  // Now the last vertex is behind the first three.
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
    push(f);
  }
  return true;
}

int Polytope::newFacet(int a, int b, int c) {
  int index = facet_count_;
  if (buffers_.free_facets.empty()) {
    ++facet_count_;
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
  measure(f);
  return index;
}

double Polytope::triangleDistance(const PolytopeFacet& f) const {
  double weights[3];
  return nearestOnTriangle(w(f.vertex[0]), w(f.vertex[1]), w(f.vertex[2]), weights).norm();
}

void Polytope::measure(PolytopeFacet& f) {
  const Vector &a = w(f.vertex[0]), &b = w(f.vertex[1]), &c = w(f.vertex[2]);
  const Vector n = triangleNormal(a, b, c);
  const double length = n.norm();
  if (length > 0) {
    f.normal = f.plane_normal = n / length;
    // The cross product of two edges errs by less than 7 units of roundoff times their lengths, its
    // normalisation, the difference d and the dot product by 8 more; the area is at most the
    // product of the lengths.
    const double longest_squared =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    const double doubt = 16 * kUnitRoundoff * longest_squared / length;
    f.doubt_squared = doubt * doubt;
    f.distance = std::min({f.normal.dot(a), f.normal.dot(b), f.normal.dot(c)});
  } else {
    // No area: the direction of its nearest point is as good as any.
    f.normal = f.plane_normal = Vector::UnitX();
    f.doubt_squared = std::numeric_limits<double>::infinity();
    f.distance = 0;
    refine(f);
  }
  // Facets that see the origin come first, the nearest of them foremost; all of the difference is
  // within 4 L.
  f.key = f.distance > 0 ? f.distance : triangleDistance(f) - 4 * (roundoff_ / kUnitRoundoff);
}

// A sliver's normal may be poor, and with it the claimed distance: try the direction of its nearest
// point.
void Polytope::refine(PolytopeFacet& f) {
  f.refined = true;
  double weights[3];
  const Vector &a = w(f.vertex[0]), &b = w(f.vertex[1]), &c = w(f.vertex[2]);
  const Vector nearest = nearestOnTriangle(a, b, c, weights);
  const double norm = nearest.norm();
  if (!(norm > 0)) return;
  const Vector n = nearest / norm;
  const double distance = std::min({n.dot(a), n.dot(b), n.dot(c)});
  // For a facet that the origin is behind, a plane that keeps farther from it is a better claim.
  const bool behind = f.distance > 0 || signOfDeterminant(a, b, c) > 0;
  if (behind && distance > std::max(f.distance, 0.0) + 8 * roundoff_) {
    f.distance = distance;
    f.normal = n;
    f.key = distance;
  }
}

void Polytope::push(int index) {
  std::vector<PolytopeBuffers::Entry>& queue = buffers_.queue;
  if (static_cast<int>(queue.size()) >= kQueueCapacity) {
    // Drop the entries of facets that are gone; fewer than kFacetCapacity remain.
    std::size_t kept = 0;
    for (const PolytopeBuffers::Entry& e : queue) {
      const PolytopeFacet& f = facet(e.facet);
      if (f.alive && f.stamp == e.stamp && f.key == e.key) queue[kept++] = e;
    }
    queue.resize(kept);
    std::make_heap(queue.begin(), queue.end(), later);
  }
  queue.push_back({facet(index).key, index, facet(index).stamp});
  std::push_heap(queue.begin(), queue.end(), later);
}

// The facet's own ends: how far it proves the origin inside (nearest of all facets), or its nearest
// point as a witness.
void Polytope::offerFacet(const PolytopeFacet& f) {
  double weights[3];
  const Vector nearest = nearestOnTriangle(w(f.vertex[0]), w(f.vertex[1]), w(f.vertex[2]), weights);
  Vector a = Vector::Zero();
  for (int i = 0; i < 3; ++i) {
    a += weights[i] * buffers_.vertices[static_cast<std::size_t>(f.vertex[i])].a;
  }
  progress_.offerWitness(nearest.norm(), nearest, a);
  if (f.distance > 0 && !left_facing_) {
    if (!winds_) winds_ = windsAroundOrigin();
    if (winds_) progress_.offerWitness(-f.distance, nearest, a);
  }
}

// Exact, so that the surface is the convex hull of its vertices as they were rounded, and what p
// sees is one patch. Two predicates that contradict each other would make the surface fold.
bool Polytope::sees(const PolytopeFacet& f, const Vector& p) const {
  const Vector &a = w(f.vertex[0]), &b = w(f.vertex[1]), &c = w(f.vertex[2]);
  const Vector d = p - a;
  const double height = f.plane_normal.dot(d);
  if (height * height > f.doubt_squared * d.squaredNorm()) return height > 0;
  return orientation(a, b, c, p) > 0;
}

// The facets seen from p, connected to `first`, and the edges around them. False when it is all of
// the surface.
bool Polytope::collect(int first, const Vector& p) {
  ++mark_;
  buffers_.visible.clear();
  buffers_.horizon.clear();
  buffers_.visible.push_back(first);
  facet(first).mark = mark_;
  for (std::size_t next = 0; next < buffers_.visible.size(); ++next) {
    const std::int32_t index = buffers_.visible[next];
    const PolytopeFacet& f = facet(index);
    for (int e = 0; e < 3; ++e) {
      PolytopeFacet& g = facet(f.neighbour[e]);
      if (g.mark != mark_ && sees(g, p)) {
        g.mark = mark_;
        buffers_.visible.push_back(f.neighbour[e]);
      }
    }
  }
  for (const std::int32_t index : buffers_.visible) {
    const PolytopeFacet& f = facet(index);
    for (int e = 0; e < 3; ++e) {
      const std::int32_t other = f.neighbour[e];
      const PolytopeFacet& g = facet(other);
      if (g.mark == mark_) continue;
      int back = 0;
      while (back < 2 && g.neighbour[back] != index) ++back;
      // Two facets may share two edges only in a surface of two facets, which a fan never makes;
      // still take the edge that runs opposite.
      for (int k = 0; k < 3; ++k) {
        if (g.neighbour[k] == index && g.vertex[k] == f.vertex[(e + 1) % 3]) back = k;
      }
      buffers_.horizon.push_back({f.vertex[e], f.vertex[(e + 1) % 3], other, back});
    }
  }
  return !buffers_.horizon.empty();
}

// Brings the horizon into the order of a loop. False when it is not a single loop without repeated
// vertices.
bool Polytope::orderHorizon() {
  buffers_.loop.clear();
  for (const PolytopeBuffers::HorizonEdge& e : buffers_.horizon) {
    buffers_.edge_from[static_cast<std::size_t>(e.from)] = -1;
  }
  for (std::size_t i = 0; i < buffers_.horizon.size(); ++i) {
    std::int32_t& slot = buffers_.edge_from[static_cast<std::size_t>(buffers_.horizon[i].from)];
    if (slot >= 0) return false;
    slot = static_cast<std::int32_t>(i);
  }
  const std::int32_t start = buffers_.horizon[0].from;
  std::int32_t at = start;
  do {
    const PolytopeBuffers::HorizonEdge& e =
        buffers_
            .horizon[static_cast<std::size_t>(buffers_.edge_from[static_cast<std::size_t>(at)])];
    buffers_.loop.push_back(e);
    at = e.to;
  } while (at != start && buffers_.loop.size() < buffers_.horizon.size());
  return at == start && buffers_.loop.size() == buffers_.horizon.size();
}

// Exchanges the facets seen from the newest vertex for a fan over it.
void Polytope::expand(int first) {
  const int apex = vertex_count_ - 1;
  const Vector p = w(apex);
  const bool simple = collect(first, p) && orderHorizon() &&
                      room() + buffers_.visible.size() > buffers_.loop.size();
  if (!simple) {
    // Rounding made a patch with holes: exchange one facet only, whose three edges always are a
    // loop.
    ++mark_;
    facet(first).mark = mark_;
    buffers_.visible.assign(1, first);
    buffers_.loop.clear();
    const PolytopeFacet& f = facet(first);
    for (int e = 0; e < 3; ++e) {
      const PolytopeFacet& g = facet(f.neighbour[e]);
      int back = 0;
      for (int k = 0; k < 3; ++k) {
        if (g.neighbour[k] == first && g.vertex[k] == f.vertex[(e + 1) % 3]) back = k;
      }
      buffers_.loop.push_back({f.vertex[e], f.vertex[(e + 1) % 3], f.neighbour[e], back});
    }
  }
  for (const std::int32_t index : buffers_.visible) {
    PolytopeFacet& f = facet(index);
    // The exchange keeps the winding number if the origin is in none of the tetrahedra (apex,
    // facet), and it is not if all four points are strictly on one side of a plane through it.
    winds_ = winds_ && f.distance > 4 * roundoff_ && f.normal.dot(p) > 4 * roundoff_;
    f.alive = false;
    buffers_.free_facets.push_back(index);
  }
  const std::size_t count = buffers_.loop.size();
  std::int32_t first_new = -1, previous = -1;
  for (std::size_t i = 0; i < count; ++i) {
    const PolytopeBuffers::HorizonEdge e = buffers_.loop[i];
    const int index = newFacet(e.from, e.to, apex);
    PolytopeFacet& f = facet(index);
    f.neighbour[0] = e.facet;
    facet(e.facet).neighbour[e.edge] = index;
    if (i == 0) {
      first_new = index;
    } else {
      f.neighbour[2] = previous;
      facet(previous).neighbour[1] = index;
    }
    previous = index;
    push(index);
  }
  facet(first_new).neighbour[2] = previous;
  facet(previous).neighbour[1] = first_new;
}

// How often the surface is crossed outwards along a ray from the origin; -1000 when rounding leaves
// a crossing open.
int Polytope::windingAlong(const Vector& ray) {
  int winding = 0;
  for (int i = 0; i < facet_count_; ++i) {
    const PolytopeFacet& f = facet(i);
    if (!f.alive) continue;
    const Vector &a = w(f.vertex[0]), &b = w(f.vertex[1]), &c = w(f.vertex[2]);
    const int sa = signOfDeterminant(ray, b, c), sb = signOfDeterminant(ray, c, a),
              sc = signOfDeterminant(ray, a, b);
    const bool positive = sa > 0 || sb > 0 || sc > 0, negative = sa < 0 || sb < 0 || sc < 0;
    if (positive && negative) continue;  // the ray's line passes beside it
    const int side = signOfDeterminant(a, b, c);
    if (sa == 0 || sb == 0 || sc == 0 || side == 0) return -1000;
    if (positive && side > 0) ++winding;  // else the opposite ray crosses it
    if (negative && side < 0) --winding;
  }
  return winding;
}

// Looked at afresh, along rays through the middle of facets, until one meets no edge.
bool Polytope::windsAroundOrigin() {
  int tried = 0;
  for (int i = 0; i < facet_count_; ++i) {
    const PolytopeFacet& f = facet(i);
    if (!f.alive) continue;
    // Not the very centroid, which symmetric input likes to put on other facets' edges.
    const Vector ray = 0.37 * w(f.vertex[0]) + 0.34 * w(f.vertex[1]) + 0.29 * w(f.vertex[2]);
    const int winding = windingAlong(ray);
    if (winding != -1000) return winding != 0;
    if (++tried == 4) break;
  }
  return false;
}

void Polytope::grow() {
  for (;;) {
    // The live facet with the smallest key.
    std::vector<PolytopeBuffers::Entry>& queue = buffers_.queue;
    if (queue.empty()) return;
    std::pop_heap(queue.begin(), queue.end(), later);
    const PolytopeBuffers::Entry entry = queue.back();
    queue.pop_back();
    PolytopeFacet& f = facet(entry.facet);
    if (!f.alive || f.stamp != entry.stamp || f.key != entry.key) continue;
    if (!f.refined) {
      refine(f);
      if (f.key != entry.key) {
        push(entry.facet);
        continue;
      }
    }
    offerFacet(f);
    if (progress_.enough()) {
      // Where several translations separate equally well, the plane must be that of the witness.
      const bool other_plane = f.distance > 0 && -f.plane_normal.dot(progress_.normal()) < 1 - 1e-6;
      if (progress_.decided() || !other_plane) return;
    }
    // Once the pair is known to be apart, or a facet that sees the origin was given up, the others
    // have nothing to say.
    if (f.distance > 0 && (left_facing_ || progress_.lower() > 0)) return;
    if (full()) return;
    SupportPoint& s = buffers_.vertices[static_cast<std::size_t>(vertex_count_)];
    const Vector outward = f.normal;
    const bool met = ask(-outward, s);
    const double lower_here = -outward.dot(s.w) - progress_.query().lower_offset;
    if (f.distance > 0 && lower_here <= progress_.lower() &&
        progress_.lower() - lower_here <= 0.25 * progress_.query().request.tolerance &&
        progress_.upper() - lower_here <= progress_.query().request.tolerance) {
      progress_.preferLower(-outward.dot(s.w), -outward);
    }
    if (met &&
        (progress_.decided() || f.distance <= 0 || -outward.dot(progress_.normal()) >= 1 - 1e-6)) {
      return;
    }
    // No farther out than the facet itself, to within rounding: this is the difference's own facet.
    const double reach = outward.dot(s.w - w(f.vertex[0]));
    if (!(reach > 2 * roundoff_) || !sees(f, s.w)) {
      if (f.distance > 0) return;
      left_facing_ = true;
      continue;
    }
    ++vertex_count_;
    expand(entry.facet);
  }
}

}  // namespace

void growPolytope(Difference<false>& difference, const Simplex& start, PolytopeBuffers& buffers,
                  Progress& progress) {
  Polytope polytope(difference, buffers, progress);
  if (polytope.begin(start)) polytope.grow();
}

}  // namespace leeway::collision
