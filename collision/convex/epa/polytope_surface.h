#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "collision/base/exact_predicates.h"
#include "collision/convex/epa/polytope_fan.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

/// A triangle of the polytope's surface: counter-clockwise from outside, edge i from vertex[i] to
/// vertex[i + 1], neighbour[i] across it.
struct PolytopeFacet {
  std::int32_t vertex[3];
  std::int32_t neighbour[3];
  Vector normal;              ///< outward, of any length
  double length_squared = 0;  ///< of `normal`; 0: the triangle has no significant area
  double doubt = 0;           ///< error of normal . d for a vector d, divided by the length of d
  /// A unit vector: the direction of `normal`, or a better one for a sliver. Set when `refined`.
  Vector outward;
  /// All of the triangle is at least this far out, along normal or outward. Set only for facets in
  /// the queue.
  double distance = 0;
  /// Incremented when the slot is reused or its place in the queue changes, which marks old queue
  /// entries.
  std::int32_t stamp = 0;
  std::int32_t mark = 0;
  bool alive = false;  ///< on the surface
  bool refined = false;
};

/// Memory of one penetration query, sized once. It is reserved but not initialized until a query
/// uses it, because filling half a megabyte takes longer than finding many paths.
struct PolytopeBuffers {
  PolytopeBuffers();

  struct Entry {
    double key;
    std::int32_t facet, stamp;
  };
  struct Step {
    std::int32_t facet, edge;  ///< the facet that the walk entered, and the edge to cross next
    std::int32_t left;         ///< edges that are still to be crossed
  };
  std::vector<SupportPoint> vertices;
  std::vector<PolytopeFacet> facets;
  std::vector<std::int32_t> free_facets;
  std::vector<Entry> queue;
  std::vector<std::int32_t> visible;    ///< facets that the newest vertex sees
  std::vector<HorizonEdge> horizon;     ///< the edges around them, in order
  std::vector<Step> path;               ///< stack of the walk over them
  std::vector<std::int32_t> edge_mark;  ///< per vertex: the last walk with a horizon edge from it
  std::int32_t mark = 0;                ///< number of the last walk, of any query
};

/// The surface of a polytope whose vertices are members of a difference. It is closed and oriented
/// by construction, with a queue of its facets ordered by their distance from the origin.
class PolytopeSurface {
 public:
  /// `reach` [m]: facets farther out stay out of the queue; it may decrease.
  PolytopeSurface(PolytopeBuffers& buffers, double roundoff, const double& reach);

  /// True if there is no room for another vertex and its facets.
  bool full() const;
  int vertexCount() const { return vertex_count_; }
  const SupportPoint& vertex(int i) const { return buffers_.vertices[static_cast<std::size_t>(i)]; }
  const Vector& w(int i) const { return vertex(i).w; }
  /// The slot of the next vertex; addVertex() then makes it a vertex.
  SupportPoint& nextVertex();
  void addVertex() { ++vertex_count_; }

  /// Makes the surface of the tetrahedron of the first four vertices; false if they are flat.
  bool makeTetrahedron();
  /// Replaces the facets that the newest vertex sees, `first` among them, by a fan over it.
  void expand(int first);

  /// Slots of facets, alive or not.
  int facetCount() const { return static_cast<int>(buffers_.facets.size()); }
  PolytopeFacet& facet(int i) { return buffers_.facets[static_cast<std::size_t>(i)]; }
  const PolytopeFacet& facet(int i) const { return buffers_.facets[static_cast<std::size_t>(i)]; }
  /// Removes the facet with the smallest key from the queue; -1 if the queue is empty.
  int pop();
  void push(int index, double key);

  /// True if p is beyond the facet's plane. The test is exact, so that the surface is the convex
  /// hull of its rounded vertices and p sees one patch: two contradicting predicates would fold the
  /// surface.
  bool sees(const PolytopeFacet& f, const Vector& p) const;
  double leastAlong(const PolytopeFacet& f, const Vector& n) const;
  /// The point of a triangle nearest to the origin; `a` becomes A's part of it.
  Vector nearestOf(const std::int32_t (&vertex)[3], Vector& a) const;
  /// True when the surface is proven to wind around the origin.
  bool windsAroundOrigin();

 private:
  std::size_t room() const;
  int newFacet(int a, int b, int c);
  void insert(int index, double key);
  void enqueue(int index, double longest_squared);
  bool findHorizon(int first, const Vector& p);
  void takeAlone(int first);
  bool keepsWinding(const PolytopeFacet& f, const Vector& p) const;
  bool computeWinding() const;
  std::optional<int> windingAlong(const Vector& ray) const;

  PolytopeBuffers& buffers_;
  const double roundoff_;
  const double& reach_;
  std::int32_t& mark_;
  int vertex_count_ = 0;
  bool winds_ = false;  // proven
};

inline double PolytopeSurface::leastAlong(const PolytopeFacet& f, const Vector& n) const {
  return std::min({n.dot(w(f.vertex[0])), n.dot(w(f.vertex[1])), n.dot(w(f.vertex[2]))});
}

inline bool PolytopeSurface::sees(const PolytopeFacet& f, const Vector& p) const {
  const Vector d = p - w(f.vertex[0]);
  const double height = f.normal.dot(d);
  if (height * height > f.doubt * f.doubt * d.squaredNorm()) return height > 0;
  return orientation(w(f.vertex[0]), w(f.vertex[1]), w(f.vertex[2]), p) > 0;
}

/// Sign of the determinant of three vectors, exact.
int signOfDeterminant(const Vector& a, const Vector& b, const Vector& c);

/// The normal of a triangle, not normalised, from its two shorter edges: rounding of the cross
/// product is proportional to them.
inline Vector triangleNormal(const Vector& a, const Vector& b, const Vector& c,
                             double& longest_squared) {
  const Vector ab = b - a, bc = c - b, ca = a - c;
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  longest_squared = std::max({ab2, bc2, ca2});
  if (longest_squared == ab2) return cross(bc, ca);
  if (longest_squared == bc2) return cross(ca, ab);
  return cross(ab, bc);
}

}  // namespace leeway::collision
