#include "collision/convex/epa/epa.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/exact_predicates.h"
#include "collision/base/tolerances.h"
#include "collision/convex/round_depth/curved_facet.h"

namespace leeway::collision {

namespace {

constexpr int kVertexCapacity = 1024;
constexpr int kFacetCapacity = 2 * kVertexCapacity;
constexpr int kQueueCapacity = 16 * kVertexCapacity;
// A query adds no more than kVertexCapacity walks: numbers of walks do not overflow.
constexpr std::int32_t kLastMark = 1 << 30;
// Curved parts are looked at from this iteration on: most polytopes are done by then. [count]
constexpr int kCoverFrom = 48;
// Depths that one facet is tried with, Newton's steps towards each, and facets without any after
// many steps that found nothing [count]: a few of each gain most.
constexpr int kCoverTries = 4;
constexpr int kDescentSteps = 10;
constexpr int kLongestRest = 63;

}  // namespace

PolytopeBuffers::PolytopeBuffers() {
  vertices.resize(kVertexCapacity);
  facets.resize(kFacetCapacity);
  free_facets.reserve(kFacetCapacity);
  queue.reserve(kQueueCapacity);
  visible.reserve(kFacetCapacity);
  loop.reserve(3 * kFacetCapacity);
  path.reserve(kFacetCapacity);
  edge_mark.resize(kVertexCapacity);
}

namespace {

struct Later {
  bool operator()(const PolytopeBuffers::Entry& a, const PolytopeBuffers::Entry& b) const {
    // Heap of the smallest key; the lower slot first among equals, for determinism.
    return a.key > b.key || (a.key == b.key && a.facet > b.facet);
  }
};

inline int nextEdge(int e) { return e == 2 ? 0 : e + 1; }

// Normal of a triangle, not normalised, from its two shorter edges: the cross product's rounding is
// in proportion to them.
inline Vector triangleNormal(const Vector& a, const Vector& b, const Vector& c,
                             double& longest_squared) {
  const Vector ab = b - a, bc = c - b, ca = a - c;
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  longest_squared = std::max({ab2, bc2, ca2});
  if (longest_squared == ab2) return cross(bc, ca);
  if (longest_squared == bc2) return cross(ca, ab);
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
        roundoff_(progress.query().roundoff),
        curved_(difference, roundoff_) {}

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
  void enqueue(int index, double longest_squared);
  void push(int index, double key);
  int pop();
  double leastAlong(const PolytopeFacet& f, const Vector& n) const;
  bool refine(PolytopeFacet& f);
  void offerFacet(const PolytopeFacet& f);
  double tolerance() const;
  double coverRounding() const;
  bool mayCover() const;
  double coveredDepth() const;
  double mostClaimed() const { return covers_ ? coveredDepth() : reach_; }
  bool cover(const PolytopeFacet& f);
  void descend(Vector outward);
  void settle();
  Vector memberClaimed(Vector& a) const;
  void memberAlongNormal(Vector& nearest, Vector& a) const;
  bool sees(const PolytopeFacet& f, const Vector& p) const;
  bool walk(int first, const Vector& p);
  void takeAlone(int first);
  bool keepsWinding(const PolytopeFacet& f, const Vector& p) const;
  void expand(int first);
  void startNear(const PolytopeFacet& f, const Vector& n);
  bool windsAroundOrigin();
  int windingAlong(const Vector& ray);
  Vector nearestOf(const std::int32_t vertex[3], Vector& a) const;
  void search();

  Difference<false>& difference_;
  PolytopeBuffers& buffers_;
  Progress& progress_;
  const double roundoff_;
  int vertex_count_ = 0;
  int facet_count_ = 0;  // slots of buffers_.facets in use or free
  std::int32_t& mark_ = buffers_.mark;
  bool winds_ = false;  // proven: the surface winds around the origin
  bool left_facing_ =
      false;  // a facet that sees the origin was given up: no claim of depth can be made
  // The least n . w of all supporting planes asked, negated: the origin is no deeper in the
  // difference. Facets farther out than this are never looked at again.
  double reach_ = std::numeric_limits<double>::infinity();
  double claim_ = 0;  // the largest depth proven; 0: none
  std::int32_t claim_vertex_[3] = {0, 0, 0};
  // Facets that curved parts keep farther out than their triangles are (in all directions at least
  // coveredDepth(), which only shrinks) leave the queue.
  CurvedFacets curved_;
  bool covers_ = false;
  // Descents that found nothing nearer, and for how many facets to do without.
  int idle_ = 0, rest_ = 0;
};

// The support point along n, its plane offered; true when the request is met by it. (The normal of
// what has next to no size may be 0 or no number: that is no plane.)
inline bool Polytope::ask(const Vector& n, SupportPoint& found) {
  ++progress_.iterations;
  difference_.support(n, found);
  clean(found.w);
  const double value = n.dot(found.w);
  if (!(n.squaredNorm() > 0.5)) return false;
  reach_ = std::min(reach_, -value);
  progress_.offerLower(value, n);
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
  if (mark_ > kLastMark) {
    std::fill(buffers_.edge_mark.begin(), buffers_.edge_mark.end(), 0);
    mark_ = 0;
  }
  reach_ = -(progress_.lower() + progress_.query().lower_offset);
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
    double longest_squared = 0;
    Vector n = triangleNormal(p, w(1), w(2), longest_squared).normalized();
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
  }
  return true;
}

inline int Polytope::newFacet(int a, int b, int c) {
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
  double longest_squared = 0;
  f.normal = triangleNormal(w(a), w(b), w(c), longest_squared);
  f.length_squared = f.normal.squaredNorm();
  // The cross product of two edges errs by less than 7 units of roundoff times their lengths, the
  // difference d and the dot product by 8 more, in proportion to the area, which is at most the
  // product of the lengths.
  f.doubt = 16 * kUnitRoundoff * longest_squared;
  enqueue(index, longest_squared);
  return index;
}

// Facets that cannot be nearest, because they are farther out than a supporting plane, stay out of
// the queue: most do.
inline void Polytope::enqueue(int index, double longest_squared) {
  PolytopeFacet& f = facet(index);
  // What the normal's error can do over the length of the facet (all of the difference is within L
  // of the origin), and the rounding of the products.
  const double height = f.normal.dot(w(f.vertex[2])) - 32 * roundoff_ * longest_squared;
  const double out = std::max(reach_ + 16 * roundoff_, 0.0);
  // (Strictly, so that squares beyond the range of double compare false.)
  if (height > 0 && height * height > out * out * f.length_squared) return;
  const double length = std::sqrt(f.length_squared);
  f.distance = length > 0 ? leastAlong(f, f.normal) / length : 0;
  Vector a;
  // Facets that see the origin come first, the nearest of them foremost; all of the difference is
  // within 4 L.
  push(index, f.distance > 0 ? f.distance
                             : nearestOf(f.vertex, a).norm() - 4 * (roundoff_ / kUnitRoundoff));
}

inline double Polytope::leastAlong(const PolytopeFacet& f, const Vector& n) const {
  return std::min({n.dot(w(f.vertex[0])), n.dot(w(f.vertex[1])), n.dot(w(f.vertex[2]))});
}

// The nearest point of a triangle, and of A's part in it.
Vector Polytope::nearestOf(const std::int32_t vertex[3], Vector& a) const {
  double weights[3];
  const Vector nearest = nearestOnTriangle(w(vertex[0]), w(vertex[1]), w(vertex[2]), weights);
  a.setZero();
  for (int i = 0; i < 3; ++i) {
    a += weights[i] * buffers_.vertices[static_cast<std::size_t>(vertex[i])].a;
  }
  return nearest;
}

// A sliver's normal may be poor, and with it the claimed distance: try the direction of its nearest
// point. True when that is better: it is back in the queue then.
bool Polytope::refine(PolytopeFacet& f) {
  f.refined = true;
  f.outward =
      f.length_squared > 0 ? Vector(f.normal / std::sqrt(f.length_squared)) : Vector::UnitX();
  const Vector &a = w(f.vertex[0]), &b = w(f.vertex[1]), &c = w(f.vertex[2]);
  const double highest = std::max({f.outward.dot(a), f.outward.dot(b), f.outward.dot(c)});
  if (f.distance > 0 && highest - f.distance <= 8 * roundoff_) return false;
  double weights[3];
  const Vector nearest = nearestOnTriangle(a, b, c, weights);
  const double norm = nearest.norm();
  if (!(norm > 0)) return false;
  const Vector n = nearest / norm;
  const double distance = leastAlong(f, n);
  // For a facet that the origin is behind, a plane that keeps farther from it is a better claim.
  const bool behind = f.distance > 0 || signOfDeterminant(a, b, c) > 0;
  if (!behind || !(distance > std::max(f.distance, 0.0) + 8 * roundoff_)) return false;
  f.distance = distance;
  f.outward = n;
  return true;
}

inline void Polytope::push(int index, double key) {
  std::vector<PolytopeBuffers::Entry>& queue = buffers_.queue;
  if (static_cast<int>(queue.size()) >= kQueueCapacity) {
    // Drop the entries of facets that are gone; fewer than kFacetCapacity remain.
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

// The facet on the surface with the smallest key; -1 when none is left.
int Polytope::pop() {
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

// The facet's own ends: how far it proves the origin inside (nearest of all facets), or its nearest
// point as a witness.
void Polytope::offerFacet(const PolytopeFacet& f) {
  if (f.distance > 0 && !left_facing_) {
    if (!winds_) winds_ = windsAroundOrigin();
    if (winds_) {
      // All facets that are not in the queue are farther out than reach_, or covered.
      const double depth = std::min(f.distance, mostClaimed());
      if (depth > claim_) {
        claim_ = depth;
        std::copy(f.vertex, f.vertex + 3, claim_vertex_);
        progress_.offerUpper(-claim_);
      }
      return;
    }
  }
  Vector a;
  const Vector nearest = nearestOf(f.vertex, a);
  progress_.offerWitness(nearest.norm(), nearest, a);
}

// The part of the width asked for that rounding leaves to the search.
inline double Polytope::tolerance() const {
  const CoreQuery& query = progress_.query();
  return query.request.tolerance - (query.lower_offset - query.upper_offset);
}

// Four times the rounding of a bound of CurvedFacets where the surface is nearest.
inline double Polytope::coverRounding() const {
  return 1024 * roundoff_ * (roundoff_ / kUnitRoundoff) / reach_;
}

// An interval narrower than their rounding is a matter of the polytope while it can.
inline bool Polytope::mayCover() const {
  const int limit = progress_.query().request.iteration_limit;
  return curved_.any() &&
         progress_.iterations >=
             (0.75 * tolerance() > coverRounding() ? kCoverFrom : limit - limit / 8);
}

// A depth near enough to the nearest supporting plane (a quarter of the width is left for the plane
// and the rounding of what was subtracted), and far enough from it for rounding. It only shrinks
// with reach_, so that what is covered once stays so.
double Polytope::coveredDepth() const {
  return reach_ - std::min(std::max(0.75 * tolerance(), coverRounding()), 0.25 * reach_);
}

// True when a facet's curved parts keep it far enough out.
bool Polytope::cover(const PolytopeFacet& f) {
  if (!(f.distance > 0) || left_facing_ || f.distance >= coveredDepth()) return false;
  const auto corner = [&](int i) -> const SupportPoint& {
    return buffers_.vertices[static_cast<std::size_t>(f.vertex[i])];
  };
  for (int i = 0; i < kCoverTries; ++i) {
    if (curved_.covers(corner(0), corner(1), corner(2), coveredDepth())) {
      covers_ = true;
      return true;
    }
    if (rest_ > 0) {
      --rest_;
      return false;
    }
    const double reach = reach_;
    descend(curved_.leastDirection());
    if (progress_.decided()) return false;
    if (!(reach_ < reach)) {
      idle_ = std::min(2 * idle_ + 1, kLongestRest);
      rest_ = idle_;
      return false;
    }
    idle_ = 0;
  }
  return false;
}

// Newton's steps on the sphere for a plane that is nearer to the origin: the support h has the
// gradient w less its part along n, and the second derivatives K - h, K the curvatures' sum.
void Polytope::descend(Vector outward) {
  outward /= outward.norm();
  double before = reach_;
  for (int i = 0;
       i < kDescentSteps && progress_.iterations < progress_.query().request.iteration_limit; ++i) {
    SupportPoint s;
    if (ask(-outward, s) || !(reach_ < before)) return;
    before = reach_;
    Curvature a, b;
    difference_.curvatures(-outward, a, b);
    const Vector helper = std::abs(outward.x()) < 0.6 ? Vector::UnitX() : Vector::UnitY();
    Vector u = cross(outward, helper);
    u /= u.norm();
    const Vector v = cross(outward, u);
    double uu = -reach_, uv = 0, vv = -reach_;
    for (const Curvature* k : {&a, &b}) {
      for (int j = 0; j < 2; ++j) {
        const double along_u = k->axis[j].dot(u), along_v = k->axis[j].dot(v);
        uu += k->strength[j] * along_u * along_u;
        uv += k->strength[j] * along_u * along_v;
        vv += k->strength[j] * along_v * along_v;
      }
    }
    const double gu = s.w.dot(u), gv = s.w.dot(v), determinant = uu * vv - uv * uv;
    if (!(uu > 0 && determinant > 0)) return;
    outward += ((uv * gv - vv * gu) / determinant) * u + ((uv * gu - uu * gv) / determinant) * v;
    const double length = outward.norm();
    if (!(length > 0 && length < 4)) return;
    outward /= length;
  }
}

// The witness of the depth claimed, written down once.
void Polytope::settle() {
  if (!(claim_ > 0)) return;
  Vector a;
  const Vector nearest = memberClaimed(a);
  progress_.offerWitness(-claim_, nearest, a);
}

// Where several facets lie in one plane, the one that claimed need not be the one that the plane's
// normal passes through.
Vector Polytope::memberClaimed(Vector& a) const {
  Vector nearest = nearestOf(claim_vertex_, a);
  if (covers_ || !(nearest.norm() - claim_ <= progress_.query().request.tolerance)) {
    memberAlongNormal(nearest, a);
  }
  return nearest;
}

// The member in the direction of the nearest plane, of the facet that it passes through: of the
// flat facet, or of the curved surface over it. Kept is what fits the claim best.
void Polytope::memberAlongNormal(Vector& nearest, Vector& a) const {
  const Vector outward = -progress_.normal(), wanted = claim_ * outward;
  double misfit = (nearest - wanted).squaredNorm();
  const auto offer = [&](const Vector& member, const Vector& of_a) {
    const double here = (member - wanted).squaredNorm();
    if (here < misfit) misfit = here, nearest = member, a = of_a;
  };
  for (int i = 0; i < facet_count_; ++i) {
    const PolytopeFacet& f = buffers_.facets[static_cast<std::size_t>(i)];
    if (!f.alive) continue;
    const SupportPoint* corner[3];
    for (int k = 0; k < 3; ++k) {
      corner[k] = &buffers_.vertices[static_cast<std::size_t>(f.vertex[k])];
    }
    double weights[3];
    for (int k = 0; k < 3; ++k) {
      weights[k] = outward.dot(cross(corner[(k + 1) % 3]->w, corner[(k + 2) % 3]->w));
    }
    const double sum = weights[0] + weights[1] + weights[2];
    if (!(sum > 0)) continue;
    for (double& weight : weights) weight /= sum;
    if (!(std::min({weights[0], weights[1], weights[2]}) > -kBesideFacet)) continue;
    Vector member = Vector::Zero(), of_a = Vector::Zero();
    for (int k = 0; k < 3; ++k) {
      weights[k] = std::max(weights[k], 0.0);
      member += weights[k] * corner[k]->w;
      of_a += weights[k] * corner[k]->a;
    }
    offer(member, of_a);
    if (!covers_) continue;
    curved_.member(corner, weights, member, of_a);
    offer(member, of_a);
  }
}

// Exact, so that the surface is the convex hull of its vertices as they were rounded, and what p
// sees is one patch. Two predicates that contradict each other would make the surface fold.
inline bool Polytope::sees(const PolytopeFacet& f, const Vector& p) const {
  const Vector d = p - w(f.vertex[0]);
  const double height = f.normal.dot(d);
  if (height * height > f.doubt * f.doubt * d.squaredNorm()) return height > 0;
  return orientation(w(f.vertex[0]), w(f.vertex[1]), w(f.vertex[2]), p) > 0;
}

// The facets seen from p that hang together with `first`, and the edges around them in the order of
// a loop: the walk follows a tree of facets, whose rim it meets in order, and edges between two
// facets seen are met twice, one nested in the other. False when the rim is not one loop without
// repeated vertices.
bool Polytope::walk(int first, const Vector& p) {
  ++mark_;
  buffers_.visible.assign(1, first);
  buffers_.loop.clear();
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
      buffers_.loop.push_back({from, to, other, back});
    }
  }
  const std::size_t count = buffers_.loop.size();
  if (count < 3) return false;
  std::int32_t at = buffers_.loop.back().to;
  for (const HorizonEdge& e : buffers_.loop) {
    std::int32_t& mark = buffers_.edge_mark[static_cast<std::size_t>(e.from)];
    if (e.from != at || mark == mark_) return false;
    mark = mark_;
    at = e.to;
  }
  return true;
}

// One facet only, whose three edges always are a loop.
void Polytope::takeAlone(int first) {
  buffers_.visible.assign(1, first);
  buffers_.loop.clear();
  const PolytopeFacet& f = facet(first);
  for (int e = 0; e < 3; ++e) {
    const PolytopeFacet& g = facet(f.neighbour[e]);
    const std::int32_t to = f.vertex[nextEdge(e)];
    const int back = g.vertex[0] == to ? 0 : g.vertex[1] == to ? 1 : 2;
    buffers_.loop.push_back({f.vertex[e], to, f.neighbour[e], back});
  }
}

// Exchanging a facet for three over p keeps the winding number if the origin is not in the
// tetrahedron (p, facet), and it is not if all four points are strictly on one side of a plane
// through it.
bool Polytope::keepsWinding(const PolytopeFacet& f, const Vector& p) const {
  const Vector& n = f.refined ? f.outward : f.normal;
  const double rounding = 4 * roundoff_ * (f.refined ? 1.0 : std::sqrt(f.length_squared));
  return leastAlong(f, n) > rounding && n.dot(p) > rounding;
}

// Exchanges the facets seen from the newest vertex for a fan over it.
void Polytope::expand(int first) {
  const int apex = vertex_count_ - 1;
  const Vector p = w(apex);
  // (Rounding cannot make the rim of several loops, but the buffers can be full.)
  if (!walk(first, p) || room() + buffers_.visible.size() < buffers_.loop.size()) takeAlone(first);
  for (const std::int32_t index : buffers_.visible) {
    PolytopeFacet& f = facet(index);
    winds_ = winds_ && keepsWinding(f, p);
    f.alive = false;
    buffers_.free_facets.push_back(index);
  }
  closeByFan(
      buffers_.loop, [&](std::int32_t i) -> PolytopeFacet& { return facet(i); },
      [&](const HorizonEdge& e) { return newFacet(e.from, e.to, apex); });
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

// Climbs start from what made the facet: A's farthest point along n among its vertices, and B's
// against n, which goes with the least of A's because all have the same n . (b - a).
void Polytope::startNear(const PolytopeFacet& f, const Vector& n) {
  const SupportPoint* lowest = &buffers_.vertices[static_cast<std::size_t>(f.vertex[0])];
  const SupportPoint* highest = lowest;
  double least = n.dot(lowest->a), most = least;
  for (int i = 1; i < 3; ++i) {
    const SupportPoint& s = buffers_.vertices[static_cast<std::size_t>(f.vertex[i])];
    const double value = n.dot(s.a);
    if (value > most) most = value, highest = &s;
    if (value < least) least = value, lowest = &s;
  }
  difference_.setHints(highest->index_a, lowest->index_b);
}

void Polytope::search() {
  for (;;) {
    const int index = pop();
    if (index < 0) {
      // Every facet is farther out than the nearest supporting plane.
      if ((claim_ > 0 || covers_) && !left_facing_ && (winds_ || windsAroundOrigin())) {
        claim_ = std::max(claim_, mostClaimed());
        progress_.offerUpper(-claim_);
      }
      return;
    }
    PolytopeFacet& f = facet(index);
    if (!f.refined && refine(f)) {
      push(index, f.distance);
      continue;
    }
    if (mayCover() && cover(f)) continue;
    offerFacet(f);
    if (progress_.enough()) {
      // Where several translations separate equally well, the plane must be that of the witness.
      const bool other_plane = f.distance > 0 && -f.outward.dot(progress_.normal()) < kSameNormal;
      if (progress_.decided() || covers_ || !other_plane) return;
    }
    // Once the pair is known to be apart, or a facet that sees the origin was given up, the others
    // have nothing to say.
    if (f.distance > 0 && (left_facing_ || progress_.lower() > 0)) return;
    if (full()) return;
    SupportPoint& s = buffers_.vertices[static_cast<std::size_t>(vertex_count_)];
    const Vector outward = f.outward;
    startNear(f, -outward);
    const bool met = ask(-outward, s);
    const double lower_here = -outward.dot(s.w) - progress_.query().lower_offset;
    if (f.distance > 0 && lower_here <= progress_.lower() &&
        progress_.lower() - lower_here <= 0.25 * progress_.query().request.tolerance &&
        progress_.upper() - lower_here <= progress_.query().request.tolerance) {
      progress_.preferLower(-outward.dot(s.w), -outward);
    }
    if (met && (progress_.decided() || f.distance <= 0 ||
                -outward.dot(progress_.normal()) >= kSameNormal)) {
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
    expand(index);
  }
}

void Polytope::grow() {
  search();
  settle();
}

}  // namespace

void growPolytope(Difference<false>& difference, const Simplex& start, PolytopeBuffers& buffers,
                  Progress& progress) {
  Polytope polytope(difference, buffers, progress);
  if (polytope.begin(start)) polytope.grow();
}

}  // namespace leeway::collision
