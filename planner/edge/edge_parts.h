#pragma once

// Private to planner/: pairs that a pass of lanes leaves open.

#include <optional>
#include <vector>

#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "planner/edge/contact_search.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/edge_queue.h"
#include "planner/edge/pair_queries.h"

namespace leeway::planner {

/// Finer passes of lanes. A plane can separate two hulls over a part of the edge although no plane
/// separates them over a whole interval. The next pass checks only pairs that a pass leaves open
/// but apart, over parts of their intervals. All other pairs become tasks of the queue.
class EdgeParts {
 public:
  /// Refers to all of these. A pass leaves at most `pairs` pairs open, in `tasks` intervals.
  EdgeParts(EdgeFrames& frames, EdgeLanes& lanes, ContactSearch& contacts, EdgeQueue& queue,
            const collision::Work& work, std::size_t pairs, std::size_t tasks);

  /// Takes the pairs that the pass over the whole edge left open, and replaces all tasks. Pairs
  /// whose hulls are apart become parts; the others become tasks over as many intervals as one
  /// sweep covers. False if full.
  bool begin();
  /// Searches planes over the listed parts, each divided again, until no part is left or planes no
  /// longer pay. The remaining parts become tasks. kNotFree: a contact was found; kUndecided: no
  /// room or work is left.
  std::optional<PairVerdict> certify();
  /// Turns the remaining parts into tasks. False if full.
  bool addTasks();

 private:
  /// A part of the edge; its pairs are [begin, end) of part_pairs_.
  struct Part {
    double from, width;
    int begin, end;
  };

  /// Whether finer passes may separate the pair: it is apart in the middle of its intervals.
  bool isForParts(const collision::LaneSweep::Open& pair) const {
    return pair.apart && !frames_.pair(pair.id).by_surfaces;
  }
  /// Adds tasks of pairs that finer passes cannot separate. False if full.
  bool addOpenIntervals();
  /// Whether addOpenIntervals() takes `width` intervals, starting at `interval`, as one.
  bool isSweptOver(const collision::LaneSweep::Open& pair, int interval, int width) const;
  /// The largest number of intervals over which a sweep of the pair keeps its growth below
  /// kMergedGrowth.
  int intervalsPerSweep(const collision::LaneSweep::Open& pair) const;

  /// Lists the pairs that a pass over `parts` left open. False if full.
  bool list(const EdgeLanes::Parts& parts);
  bool listWideOpen(const EdgeLanes::Parts& parts, int first);
  bool listInterval(const EdgeLanes::Parts& parts, int interval, int first);
  /// True for a pair that a finer pass left open in more than half of the `share` intervals from
  /// `first` on. These are one part of the previous pass; one exact sweep is tried over all of it.
  static bool isWideOpen(const collision::LaneSweep::Open& pair, int first, int share);
  /// Takes the parts that one pass divides, starting at next_; pass_pairs_ are their pairs.
  EdgeLanes::Parts take();

  EdgeFrames& frames_;
  EdgeLanes& lanes_;
  ContactSearch& contacts_;
  EdgeQueue& queue_;
  const collision::Work& work_;
  std::vector<Part> parts_;
  std::size_t next_ = 0;  // into parts_
  collision::SpareVector<int> part_pairs_;
  std::vector<collision::LaneSweep::Open> pass_pairs_;
};

}  // namespace leeway::planner
