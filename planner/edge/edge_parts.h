#pragma once

// Private to planner/: what becomes of pairs that a pass of lanes leaves open.

#include <optional>
#include <vector>

#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "planner/edge/contact_search.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/edge_queue.h"
#include "planner/edge/pair_queries.h"

namespace leeway::planner {

/// Finer passes of lanes. A plane parts two hulls over a part of the edge where none parts them
/// over all of a lane: pairs that a pass leaves open but apart are divided among the lanes of the
/// next pass, which looks at nothing else. All others become tasks of the queue.
class EdgeParts {
 public:
  /// Refers to all of these. A pass leaves at most `pairs` pairs open, in `tasks` lanes.
  EdgeParts(EdgeFrames& frames, EdgeLanes& lanes, ContactSearch& contacts, EdgeQueue& queue,
            const collision::Work& work, std::size_t pairs, std::size_t tasks);

  /// Takes what the pass over the whole edge left open, in place of all tasks: pairs whose hulls
  /// are apart as parts, the others as tasks over as many lanes at once as a sweep is tried on.
  /// False when full.
  bool begin();
  /// Planes over the listed parts, each divided again, until none is left or they no longer pay;
  /// what remains becomes tasks. kNotFree: a contact was found; kUndecided: no room or work is
  /// left.
  std::optional<PairVerdict> certify();
  /// What remains becomes tasks. False when full.
  bool addTasks();

 private:
  /// A part of the edge; its pairs are [begin, end) of part_pairs_.
  struct Part {
    double from, width;
    int begin, end;
  };

  /// Finer passes may part what is apart in the middle of its lanes.
  bool isForParts(const collision::LaneSweep::Open& pair) const {
    return pair.apart && !frames_.pair(pair.id).by_surfaces;
  }
  /// Adds tasks of pairs that finer passes will not part. False when full.
  bool addOpenLanes();
  /// Whether addOpenLanes() takes the `width` lanes from `lane` on as one interval.
  bool isSweptOver(const collision::LaneSweep::Open& pair, int lane, int width) const;
  /// The most lanes over which a sweep of the pair keeps its growth below kMergedGrowth.
  int lanesPerSweep(const collision::LaneSweep::Open& pair) const;

  /// Lists what a pass over `parts` left open. False when full.
  bool list(const EdgeLanes::Parts& parts);
  bool listWideOpen(const EdgeLanes::Parts& parts, int first);
  bool listLane(const EdgeLanes::Parts& parts, int lane, int first);
  /// True for a pair that a finer pass left open in more than half of the `share` lanes from
  /// `first` on, which are one part of the pass before: one exact sweep is tried over all of it.
  static bool isWideOpen(const collision::LaneSweep::Open& pair, int first, int share);
  /// As many parts, from next_ on, as one pass divides; pass_pairs_ are their pairs.
  EdgeLanes::Parts take();

  EdgeFrames& frames_;
  EdgeLanes& lanes_;
  ContactSearch& contacts_;
  EdgeQueue& queue_;
  const collision::Work& work_;
  std::vector<Part> parts_;
  std::size_t next_ = 0;  // of parts_
  collision::SpareVector<int> part_pairs_;
  std::vector<collision::LaneSweep::Open> pass_pairs_;
};

}  // namespace leeway::planner
