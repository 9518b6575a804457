#pragma once

// Private to planner/: the search for contacts along an edge. Most edges that a planner asks are
// not free, and one configuration in contact proves that for far less than bounds that fail
// everywhere near it.

#include <optional>
#include <vector>

#include "collision/base/work.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/pair_queries.h"

namespace leeway::planner {

/// Looks at pairs that a pass of lanes left open, in the middle of where they are open. Which pairs
/// are looked at is learned from edges before: PairMemory::contact_score. Answers kNotFree where a
/// pair is in contact, kUndecided where a configuration could not be placed, otherwise nothing.
class ContactSearch {
 public:
  /// Refers to all of these.
  ContactSearch(EdgeFrames& frames, EdgeLanes& lanes, PairQueries& queries,
                const collision::Work& work, EdgeMemory& memory);

  /// Comes before the searches of an edge.
  void begin();
  /// Before planes are searched, which costs more: between the middles of lanes, for pairs whose
  /// lane_contact_score allows it; exactly, for those that the last exact look found in contact.
  std::optional<PairVerdict> searchLikely(const EdgeLanes::Parts& parts);
  /// After planes: open pairs whose hulls are not apart.
  std::optional<PairVerdict> search(const EdgeLanes::Parts& parts);
  /// A pair that is not free, however that was found.
  void remember(int pair);

 private:
  /// distance() of a pair at t; updates its contact_score.
  std::optional<PairVerdict> checkAt(int p, double t);

  EdgeFrames& frames_;
  EdgeLanes& lanes_;
  PairQueries& queries_;
  const collision::Work& work_;
  EdgeMemory& memory_;
  /// Where searchLikely() found no contact.
  struct Look {
    int pair;
    EdgeLanes::Parts::Range range;
    bool exact;  // by distance(), too
  };
  std::vector<Look> likely_looks_;
  int looks_ = 0;  // of search()
};

}  // namespace leeway::planner
