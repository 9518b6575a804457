#include "collision/convex/epa/epa.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "collision/convex/epa/facet_cover.h"
#include "collision/convex/epa/support_planes.h"

namespace leeway::collision {

namespace {

class Epa {
 public:
  Epa(Difference<false>& difference, PolytopeBuffers& buffers, Progress& progress)
      : difference_(difference),
        progress_(progress),
        roundoff_(progress.query().roundoff),
        planes_{difference, progress},
        surface_(buffers, roundoff_, planes_.reach),
        cover_(planes_) {}

  int facetCells() const { return cover_.facets().cells(); }
  // False if the difference is flat: only the lower ends found so far are available.
  bool begin(const Simplex& start);
  void search();
  void offerWitness();

 private:
  bool full() const {
    return progress_.iterations >= progress_.query().request.iteration_limit || surface_.full();
  }
  const Vector& w(int vertex) const { return surface_.w(vertex); }
  double mostClaimed() const { return cover_.any() ? cover_.depth() : planes_.reach; }

  template <class Far>
  bool addVertexAlong(const Vector* directions, int count, Far far);
  bool refine(PolytopeFacet& f);
  void offerFacet(const PolytopeFacet& f);
  void claimAll();
  bool hasPlaneOf(const PolytopeFacet& f) const;
  void startNear(const PolytopeFacet& f, const Vector& n);
  bool askBeyond(const PolytopeFacet& f);
  Vector memberClaimed(Vector& a) const;
  void memberAlongNormal(Vector& nearest, Vector& a) const;

  Difference<false>& difference_;
  Progress& progress_;
  const double roundoff_;
  SupportPlanes planes_;
  PolytopeSurface surface_;
  FacetCover cover_;          // covered facets leave the queue
  bool left_facing_ = false;  // a facet that sees the origin was dropped: no depth can be claimed
  double claim_ = 0;          // the largest depth proven; 0: none
  std::int32_t claim_vertex_[3] = {0, 0, 0};
};

// Adds the first support point, along `directions` and their opposites, that is far enough.
template <class Far>
bool Epa::addVertexAlong(const Vector* directions, int count, Far far) {
  for (int i = 0; i < count; ++i) {
    for (const double sign : {1.0, -1.0}) {
      if (full()) return false;
      SupportPoint& s = surface_.nextVertex();
      if (planes_.ask(sign * directions[i], s)) return false;
      if (far(s.w)) {
        surface_.addVertex();
        return true;
      }
    }
  }
  return false;
}

bool Epa::begin(const Simplex& start) {
  planes_.reach = -(progress_.lower() + progress_.query().lower_offset);
  for (int i = 0; i < start.count; ++i) {
    SupportPoint& s = surface_.nextVertex();
    s = start.point(i);
    SupportPlanes::clean(s.w);
    surface_.addVertex();
  }
  // A point this close to the flat spanned so far counts as part of it.
  const double flat = 8 * roundoff_;
  if (surface_.vertexCount() == 1) {
    const Vector axes[3] = {Vector::UnitX(), Vector::UnitY(), Vector::UnitZ()};
    const Vector p = w(0);
    if (!addVertexAlong(axes, 3, [&](const Vector& q) { return (q - p).norm() > flat; }))
      return false;
  }
  if (surface_.vertexCount() == 2) {
    const Vector p = w(0);
    const Vector along = (w(1) - p).normalized();
    int axis = 0;
    along.cwiseAbs().minCoeff(&axis);
    const Vector first = cross(along, Vector::Unit(axis)).normalized();
    const Vector across[2] = {first, cross(along, first)};
    if (!addVertexAlong(across, 2,
                        [&](const Vector& q) { return cross(q - p, along).norm() > flat; })) {
      return false;
    }
  }
  if (surface_.vertexCount() == 3) {
    const Vector p = w(0);
    double longest_squared = 0;
    Vector n = triangleNormal(p, w(1), w(2), longest_squared).normalized();
    // Starts towards the origin, so that the tetrahedron contains it if possible.
    if (n.dot(p) < 0) n = -n;
    if (!addVertexAlong(&n, 1, [&](const Vector& q) { return std::abs(n.dot(q - p)) > flat; })) {
      return false;
    }
  }
  return surface_.makeTetrahedron();
}

// A sliver may have a poor normal and therefore a poor claimed distance. Tries the direction of its
// nearest point. True if that is better.
bool Epa::refine(PolytopeFacet& f) {
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
  const double distance = surface_.leastAlong(f, n);
  // With the origin behind the facet, a plane farther from the origin is a better claim.
  const bool behind = f.distance > 0 || signOfDeterminant(a, b, c) > 0;
  if (!behind || !(distance > std::max(f.distance, 0.0) + 8 * roundoff_)) return false;
  f.distance = distance;
  f.outward = n;
  return true;
}

// Offers the facet's own ends: its distance as a depth (that of the nearest facet is proven), or
// its nearest point as a witness.
void Epa::offerFacet(const PolytopeFacet& f) {
  if (f.distance > 0 && !left_facing_ && surface_.windsAroundOrigin()) {
    // All facets outside the queue are farther out than the nearest plane, or covered.
    const double depth = std::min(f.distance, mostClaimed());
    if (depth > claim_) {
      claim_ = depth;
      std::copy(f.vertex, f.vertex + 3, claim_vertex_);
      progress_.offerUpper(-claim_);
    }
    return;
  }
  Vector a;
  const Vector nearest = surface_.nearestOf(f.vertex, a);
  progress_.offerWitness(nearest.norm(), nearest, a);
}

// The queue is empty: every facet is farther out than the nearest plane, or covered.
void Epa::claimAll() {
  if ((claim_ > 0 || cover_.any()) && !left_facing_ && surface_.windsAroundOrigin()) {
    claim_ = std::max(claim_, mostClaimed());
    progress_.offerUpper(-claim_);
  }
}

// Offers the witness of the claimed depth, once.
void Epa::offerWitness() {
  if (!(claim_ > 0)) return;
  Vector a;
  const Vector nearest = memberClaimed(a);
  progress_.offerWitness(-claim_, nearest, a);
}

// If several facets lie in one plane, the facet that made the claim need not be the one that the
// plane's normal passes through.
Vector Epa::memberClaimed(Vector& a) const {
  Vector nearest = surface_.nearestOf(claim_vertex_, a);
  if (cover_.any() || !(nearest.norm() - claim_ <= progress_.query().request.tolerance)) {
    memberAlongNormal(nearest, a);
  }
  return nearest;
}

// The member along the normal of the nearest plane, on the facet that the normal passes through or
// on the curved surface over it, whichever fits the claim best.
void Epa::memberAlongNormal(Vector& nearest, Vector& a) const {
  const Vector outward = -progress_.normal(), wanted = claim_ * outward;
  double misfit = (nearest - wanted).squaredNorm();
  const auto offer = [&](const Vector& member, const Vector& of_a) {
    const double here = (member - wanted).squaredNorm();
    if (here < misfit) misfit = here, nearest = member, a = of_a;
  };
  for (int i = 0; i < surface_.facetCount(); ++i) {
    const PolytopeFacet& f = surface_.facet(i);
    if (!f.alive) continue;
    const SupportPoint* corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = &surface_.vertex(f.vertex[k]);
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
    if (!cover_.any()) continue;
    cover_.facets().member(corner, weights, member, of_a);
    offer(member, of_a);
  }
}

// Hill climbs start from vertices of the facet: the farthest vertex of A along n and of B against
// n. B's vertex belongs to the lowest of A's, because all three have the same n . (b - a).
void Epa::startNear(const PolytopeFacet& f, const Vector& n) {
  const SupportPoint* lowest = &surface_.vertex(f.vertex[0]);
  const SupportPoint* highest = lowest;
  double least = n.dot(lowest->a), most = least;
  for (int i = 1; i < 3; ++i) {
    const SupportPoint& s = surface_.vertex(f.vertex[i]);
    const double value = n.dot(s.a);
    if (value > most) most = value, highest = &s;
    if (value < least) least = value, lowest = &s;
  }
  difference_.setHints(highest->index_a, lowest->index_b);
}

// True if the reported normal is that of the facet. If several translations separate equally well,
// the plane must belong to the witness.
bool Epa::hasPlaneOf(const PolytopeFacet& f) const {
  return -f.outward.dot(progress_.normal()) >= kSameNormal;
}

// Finds the support point beyond a facet, in the slot of the next vertex. True if the request is
// met.
bool Epa::askBeyond(const PolytopeFacet& f) {
  const DistanceRequest& request = progress_.query().request;
  const Vector outward = f.outward;
  startNear(f, -outward);
  SupportPoint& s = surface_.nextVertex();
  const bool met = planes_.ask(-outward, s);
  const double lower = -outward.dot(s.w) - progress_.query().lower_offset;
  if (f.distance > 0 && lower <= progress_.lower() &&
      progress_.lower() - lower <= 0.25 * request.tolerance &&
      progress_.upper() - lower <= request.tolerance) {
    progress_.preferLower(-outward.dot(s.w), -outward);
  }
  return met && (progress_.decided() || f.distance <= 0 || hasPlaneOf(f));
}

void Epa::search() {
  for (;;) {
    const int index = surface_.pop();
    if (index < 0) return claimAll();
    PolytopeFacet& f = surface_.facet(index);
    if (!f.refined && refine(f)) {
      surface_.push(index, f.distance);
      continue;
    }
    if (cover_.worthTrying() && !left_facing_ && cover_.covers(surface_, f)) continue;
    offerFacet(f);
    if (progress_.enough() &&
        (progress_.decided() || cover_.any() || !(f.distance > 0) || hasPlaneOf(f)))
      return;
    // Once the pair is proven apart, or a facet that sees the origin was dropped, facets with the
    // origin behind them gain nothing.
    if (f.distance > 0 && (left_facing_ || progress_.lower() > 0)) return;
    if (full() || askBeyond(f)) return;
    // The point is not farther out than the facet, up to rounding: this is a facet of the
    // difference itself.
    const Vector& p = surface_.nextVertex().w;
    const double beyond = f.outward.dot(p - w(f.vertex[0]));
    if (!(beyond > 2 * roundoff_) || !surface_.sees(f, p)) {
      if (f.distance > 0) return;
      left_facing_ = true;
      continue;
    }
    surface_.addVertex();
    surface_.expand(index);
  }
}

}  // namespace

void growPolytope(Difference<false>& difference, const Simplex& start, PolytopeBuffers& buffers,
                  Progress& progress) {
  Epa epa(difference, buffers, progress);
  if (!epa.begin(start)) return;
  epa.search();
  progress.facet_cells += epa.facetCells();
  epa.offerWitness();
}

}  // namespace leeway::collision
