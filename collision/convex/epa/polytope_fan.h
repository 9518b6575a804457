#pragma once

#include <cstdint>
#include <span>

namespace leeway::collision {

/// An edge of the horizon: the border of the facets of a polytope that a new vertex sees (Barber,
/// Dobkin and Huhdanpaa 1996).
struct HorizonEdge {
  std::int32_t from, to;     ///< vertices, in the order of the facet that is removed
  std::int32_t facet, edge;  ///< the facet that stays, and its edge
};

/// Closes the surface by a fan over the horizon, whose edges form a loop in order. `facet(i)` is
/// facet i, with its neighbours across its three edges. `make(edge)` makes the facet over an edge
/// and returns its index: that edge is its edge 0, and its edges 1 and 2 meet the next facet of the
/// fan and the previous one. Returns false, with the surface open, if an index is below 0.
/// O(edges).
template <class FacetOf, class Make>
bool closeByFan(std::span<const HorizonEdge> horizon, FacetOf facet, Make make) {
  std::int32_t first = -1, previous = -1;
  for (const HorizonEdge& e : horizon) {
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
