#pragma once

#include <cstdint>
#include <vector>

#include "collision/convex/epa/polytope_fan.h"
#include "collision/convex/gjk/progress.h"
#include "collision/convex/gjk/simplex.h"

namespace leeway::collision {

/// A triangle of the polytope's surface: outward counter-clockwise, edge i from vertex[i] to
/// vertex[i + 1], neighbour[i] across it.
struct PolytopeFacet {
  std::int32_t vertex[3];
  std::int32_t neighbour[3];
  Vector normal;              ///< outward, of any length
  double length_squared = 0;  ///< of `normal`; 0: the triangle has no area to speak of
  /// Of the error of normal . d for a vector d, per length of d.
  double doubt = 0;
  /// Unit; the direction of `normal`, or for a sliver a better one. Known when `refined`.
  Vector outward;
  /// Along normal, or outward: all of the triangle is at least that far out. Known for
  /// facets in the queue only.
  double distance = 0;
  std::int32_t stamp = 0;  ///< grows when the slot is used again or its place in the queue changes,
                           ///< so that old queue entries are told
  std::int32_t mark = 0;
  bool alive = false;  ///< on the surface
  bool refined = false;
};

/// Memory of one penetration query; sized once.
struct PolytopeBuffers {
  PolytopeBuffers();

  struct Entry {
    double key;
    std::int32_t facet, stamp;
  };
  struct Step {
    std::int32_t facet, edge;  ///< where the walk came in, and the edge to look across next
    std::int32_t left;         ///< edges still to be looked across
  };
  std::vector<SupportPoint> vertices;
  std::vector<PolytopeFacet> facets;
  std::vector<std::int32_t> free_facets;
  std::vector<Entry> queue;
  std::vector<std::int32_t> visible;    ///< facets that the newest vertex sees
  std::vector<HorizonEdge> loop;        ///< the edges around them, in order
  std::vector<Step> path;               ///< stack of the walk over them
  std::vector<std::int32_t> edge_mark;  ///< per vertex: the last walk with a horizon edge from it
  std::int32_t mark = 0;                ///< number of the last walk, of any query
};

/// Both ends of the signed separation near and below contact, from where runGjk() ended (one to
/// four points). Goes on until the request is met, the iterations are used up or rounding stops it;
/// never throws or allocates.
///
/// A polytope inside the difference is grown where its surface is nearest to the origin (the
/// expanding polytope of van den Bergen, 2001), but its claims do not rest on convexity: the
/// surface is a closed oriented one by construction (facets are only ever exchanged for a fan over
/// the loop that bounds them), and while it winds around the origin once, every point nearer to the
/// origin than all its triangles is in the hull of its vertices, hence in the difference, however
/// rounding bends it. So -(distance of the nearest triangle) is a true upper end, and any support
/// plane a true lower end. An origin slightly outside (GJK stagnated near contact) is treated
/// alike: the facets that see it come first.
void growPolytope(Difference<false>& difference, const Simplex& start, PolytopeBuffers& buffers,
                  Progress& progress);

}  // namespace leeway::collision
