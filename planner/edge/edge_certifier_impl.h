#pragma once

// Private to planner/: the state of an EdgeCertifier, and the order of its stages.
//
// A task is a pair that is still open over an interval of the edge. A stage takes tasks, settles
// some, and leaves the others open; it ends the proof if it finds a contact. Stage 1 makes the
// tasks: up to stage 5 they are bits in EdgeLanes::open(), from EdgeParts::begin() on they are in
// the EdgeQueue. See docs/architecture.md, "How do I add a stage of the proof?".
//
// clang-format off
//   stage of the proof, cheapest first              here
//   1. balls; known planes and points               EdgeLanes::sweep
//   2. gaps between links, by joint angles          EdgeLanes::closeGaps
//   3. contacts, where they are likely              ContactSearch::searchLikely
//   4. new planes                                   EdgeLanes::searchPlanes
//   5. contacts in the middle of open intervals     ContactSearch::search
//   6. planes again, over finer parts               EdgeParts
//   7. containment at the edge's end                checkContainment         edge_verdict.cc
//   8. exact sweeps of the remaining tasks, halved  PairQueries, by EdgeQueue::subdivide
//
//   question about an edge                          its rule for EdgeQueue::subdivide
//   do all pairs keep their margins?                VerdictRule              edge_verdict.cc
//   ... or a separation?                            the same, with Asking    edge_clearance.cc
//   up to which t do they?                          LastValidRule            edge_verdict.cc
//   what is the least clearance?                    ClearanceSearch          edge_clearance.cc
//   ... among more obstacles than can be listed?    its RowRule, by WorldSearch over their boxes
//   what does it cost to be near?                   CostSearch (the widest part first)  objective/edge_cost.cc
//   is one configuration free?                      decideByLanes, checkState           edge_state.cc
// clang-format on

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "collision/base/numbers.h"
#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "leeway/planner/edge_certifier.h"
#include "planner/base/tolerances.h"
#include "planner/edge/contact_search.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_lanes.h"
#include "planner/edge/edge_parts.h"
#include "planner/edge/edge_queue.h"
#include "planner/edge/pair_queries.h"
#include "planner/edge/world_search.h"

namespace leeway::planner {

/// Configurations of one edge. An edge that needs more stays undecided.
inline constexpr int kEdgeSlots = 1024;

/// A part of an edge's cost.
struct CostPart {
  EdgeInterval interval;
  int middle;                 ///< the slot of its middle configuration; -1: no slot was left
  double lower, upper;        ///< of the integral over it, in t
  double clearance, nearest;  ///< bounds on its least clearance [m]
};

struct EdgeCertifier::Impl {
  explicit Impl(std::shared_ptr<const CompiledScene> scene);

  /// Resets the count of work; beyond `limit` the edge stays undecided.
  void startWork(std::int64_t limit = std::numeric_limits<std::int64_t>::max()) {
    work = {0, limit};
  }

  /// The work limit of an edge that names none.
  std::int64_t defaultWork() const;

  // The order of the stages (certify_edge.cc).

  /// Decides the edge that frames have begun, within the limit of `work`.
  EdgeCheck decideEdge();
  PairVerdict certifyByLanes();
  /// Without lanes: exact sweeps only, starting with the whole edge.
  PairVerdict certifyByBisection();
  /// Records a pair that is not free.
  EdgeCheck checkOf(const PairVerdict& verdict);

  // The question; by default, of certify(), that all pairs keep their margins.

  /// Sets the question for its lifetime; after it, the question is the default one.
  class Asking;
  double leastMargin() const { return frames.edges().leastMargin(asked.pairs); }
  /// How far above its margin any pair's separation must be at most [m].
  double beyondMargins() const {
    return std::max(0.0, asked.separation - leastMargin()) + asked.beyond;
  }

  // One configuration (edge_state.cc).

  /// The pairs, in order, that may not keep their thresholds, or may be within `reach` >= 0 [m];
  /// valid until the next call. Some are missing if the list is full.
  struct Near {
    std::span<const int> pairs;
    bool are_all;
  };
  Near nearPairs(int slot, double reach);
  /// For an edge without length that frames have begun: stages 1, 2 and 4, which usually decide.
  std::optional<Verdict> decideByLanes();
  /// All pairs at t, placed in `slot`. `offender`: the pair that is not free or undecided.
  Verdict checkState(int slot, double t, int& offender);

  // Tasks (edge_verdict.cc).

  /// Makes one interval of the edge, with all pairs in question. Pairs with the world are included
  /// if they may come as near as their thresholds plus `reach` >= 0 [m]. False if the queue is
  /// full.
  bool takeWholeEdge(int start, int end, double reach);
  /// The same with the pairs of EdgeScene::near_anywhere only.
  void takeListed(int start, int end);
  /// Sweeps an interval's tasks, and keeps those that stay open. Stops at a pair that is not free
  /// and returns it.
  std::optional<PairVerdict> sweepTasks(EdgeInterval& interval);
  /// Checks, at the edge's end, pairs of meshes with tasks on the whole edge, because a body may be
  /// inside another although their surfaces never meet.
  std::optional<PairVerdict> checkContainment();
  class VerdictRule;
  /// Sweeps all tasks, and the halves of those that stay open, level by level.
  PairVerdict sweepAll();
  class LastValidRule;
  /// Up to which t the edge is certified from its start.
  double lastValid();

  // The least clearance of an edge (edge_clearance.cc).

  class ClearanceSearch;

  // The cost of an edge (objective/edge_cost.cc).

  class CostSearch;

  // The scene, its placements, the question, and the stages.

  std::shared_ptr<const CompiledScene> scene;
  EdgeFrames frames;
  collision::Workspace workspace;
  collision::Work work;  ///< spent on the current edge or state
  EdgeLanes lanes;
  /// For the clearance from more obstacles than are listed; otherwise null.
  struct World {
    World(EdgeFrames& frames, collision::Workspace& workspace)
        : search(frames, workspace), rows(frames, kIntervalRows * frames.pairs().rows().size()) {}
    static constexpr std::size_t kIntervalRows = 2048;
    WorldSearch search;
    EdgeQueue rows;  ///< its tasks are rows of EdgePairs
  };
  std::unique_ptr<World> world;
  Asked asked;
  EdgeMemory memory;  ///< of earlier edges
  EdgeQueue queue;
  PairQueries queries;
  ContactSearch contacts;
  EdgeParts parts;

  std::uint64_t edge = 0;  ///< the number of the current edge

  // Lists.

  collision::SpareVector<int> near_pairs, asked_pairs;  ///< of nearPairs(); of checkState()
  std::vector<std::pair<double, int>> order;            ///< pairs by coarse distance
  std::vector<CostPart> cost_parts;                     ///< a heap by their width

  int last_contact = -1;  ///< the pair that was last not free; -1: none
  int last_named = -1;    ///< the pair that the last verdict named

  Statistics* statistics = nullptr;
};

class EdgeCertifier::Impl::Asking {
 public:
  Asking(Impl& impl, const Asked& asked) : impl_(impl) {
    impl.asked = asked;
    impl.lanes.demandBeyond(impl.beyondMargins());
  }
  Asking(const Asking&) = delete;
  Asking& operator=(const Asking&) = delete;
  ~Asking() {
    impl_.asked = {};
    impl_.lanes.demandBeyond(0);
  }

 private:
  Impl& impl_;
};

}  // namespace leeway::planner
