#pragma once

#include <cstdint>
#include <span>

namespace leeway::collision {

/// An edge around the facets of a polytope that a new vertex sees.
struct HorizonEdge {
  std::int32_t from, to;     ///< vertices, in the order of the facet that goes
  std::int32_t facet, edge;  ///< the facet that stays and its edge
};

/// Closes the surface again by a fan over a loop of such edges, in order: `facet(i)` is the facet
/// of number i, with its neighbours across its three edges; `make(edge)` makes the one over an
/// edge, whose edge 0 is that one and whose edges 1 and 2 meet the next one's and the last one's,
/// and returns its number. False, with the surface open, when that is below 0. O(edges).
template <class FacetOf, class Make>
bool closeByFan(std::span<const HorizonEdge> loop, FacetOf facet, Make make) {
  std::int32_t first = -1, previous = -1;
  for (const HorizonEdge& e : loop) {
    const std::int32_t index = make(e);
    if (index < 0) return false;
    auto& f = facet(index);
    f.neighbour[0] = e.facet;
    facet(e.facet).neighbour[e.edge] = index;
    if (previous < 0) {
      first = index;
    } else {
      f.neighbour[2] = previous;
      facet(previous).neighbour[1] = index;
    }
    previous = index;
  }
  facet(first).neighbour[2] = previous;
  facet(previous).neighbour[1] = first;
  return true;
}

}  // namespace leeway::collision
