#pragma once

// Private to planner/: the search for contacts along an edge. Most edges in a search are not free.
// One configuration in contact proves that at far less cost than bounds, which fail everywhere near
// it.

#include <optional>
#include <vector>

#include "collision/base/work.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/pair_queries.h"

namespace leeway::planner {

/// Checks pairs that a pass of lanes left open, in the middle of their open intervals.
/// PairMemory::contact_score, learned from earlier edges, selects the pairs. Returns kNotFree if a
/// pair is in contact, kUndecided if a configuration could not be placed, otherwise nullopt.
class ContactSearch {
 public:
  /// Refers to all of these.
  ContactSearch(EdgeFrames& frames, EdgeLanes& lanes, PairQueries& queries,
                const collision::Work& work, EdgeMemory& memory);

  /// Call it before the searches of an edge.
  void begin();
  /// Runs before the search for planes, which costs more. It checks between the middles of
  /// intervals, for pairs whose lane_contact_score allows it, and exactly, for pairs that the last
  /// exact check found in contact.
  std::optional<PairVerdict> searchLikely(const EdgeLanes::Parts& parts);
  /// Runs after planes, on open pairs whose hulls are not apart.
  std::optional<PairVerdict> search(const EdgeLanes::Parts& parts);
  /// Records a pair that is not free, found by any stage.
  void remember(int pair);

 private:
  /// distance() of a pair at t; updates its contact_score.
  std::optional<PairVerdict> checkAt(int p, double t);

  EdgeFrames& frames_;
  EdgeLanes& lanes_;
  PairQueries& queries_;
  const collision::Work& work_;
  EdgeMemory& memory_;
  /// A check of searchLikely() that found no contact.
  struct Look {
    int pair;
    EdgeLanes::Parts::Range range;
    bool exact;  // also by distance()
  };
  std::vector<Look> likely_looks_;
  int looks_ = 0;  // checks of search()
};

}  // namespace leeway::planner
