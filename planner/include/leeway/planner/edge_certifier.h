#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "leeway/planner/compiled_scene.h"

namespace leeway::planner {

using collision::Interval;
using collision::Verdict;

/// One configuration, against the margins.
struct StateCheck {
  Verdict verdict = Verdict::kUndecided;
  Interval clearance;                 ///< [m]
  int pair = -1;                      ///< the closest one, in collision::Scene::pairs()
  collision::DistanceResult closest;  ///< in world coordinates
};

/// What is asked of an edge's cost.
struct CostRequest {
  Nearness nearness;
  /// Width of the interval that is good enough, as a share of its upper end; kLeast of 1 always is.
  double tolerance = 0.01;
  /// Stops as soon as the mean is known to be above it.
  double cutoff = std::numeric_limits<double>::infinity();
  std::int64_t work_limit = 0;  ///< as EdgeRequest's; 0: about 20 ms
  static constexpr double kLeast = 1e-5;
};

/// What it costs to be near along an edge: certified intervals.
struct EdgeCost {
  /// Of nearness, over the edge, every t counting alike: times the edge's length, its integral.
  Interval mean{0, 1};
  /// Of the greatest value along the edge.
  Interval worst{0, 1};
  /// Of the least clearance, as near as that needed [m]: an upper end of infinity was not looked
  /// for.
  Interval clearance{-std::numeric_limits<double>::infinity(),
                     std::numeric_limits<double>::infinity()};
};

struct EdgeRequest {
  bool last_valid = false;       ///< find the largest t up to which the edge is certified
  double smallest_interval = 0;  ///< in t; 0: the default of tolerances (by motion, not by t)
  /// The most it may cost, in units of collision::Work, of which there are about a thousand a
  /// microsecond; beyond, the edge is undecided. 0: about 100 us, half a millisecond where a body
  /// flies freely among triangles. `last_valid` may cost as much again.
  std::int64_t work_limit = 0;

  /// A hundred times the default work: for proofs that no other edge can replace.
  static EdgeRequest persistent();
};

struct EdgeCheck {
  Verdict verdict = Verdict::kUndecided;
  double last_valid = 0;  ///< the edge is certified on [0, last_valid]; 1 when free
  double t = 0;           ///< not free or undecided: where
  int pair = -1;          ///< and which pair; -1: none in particular
};

/// What is asked of an edge's clearance.
struct ClearanceRequest {
  double tolerance = 1e-4;  ///< width of an interval that is good enough [m]
  /// Stops as soon as the minimum is known to be below it (upper < cutoff) [m].
  double cutoff = -std::numeric_limits<double>::infinity();
  /// Stops as soon as the minimum is known to be at least that [m]; the upper end is infinity where
  /// no distance was needed to know.
  double wanted = std::numeric_limits<double>::infinity();
  std::int64_t work_limit = 0;  ///< as EdgeRequest's; 0: about 0.1 s
  Pairs pairs = Pairs::kAll;    ///< all others are left out
};

/// Where along an edge the least clearance is, as a certified interval.
struct EdgeClearance {
  Interval clearance;  ///< of the minimum over edge and pairs [m]; (inf, inf) without pairs
  double t = 0;        ///< where the upper end was found
  int pair = -1;
  collision::DistanceResult closest;
  /// By roughClearance() and proveClearance(): all pairs that were asked are proven to keep their
  /// margins.
  bool keeps_margins = false;
};

/// Decides states and whole edges of one compiled scene: no step size, bounds only. Adaptive
/// bisection as in Schwarzer, Saha and Latombe ("Adaptive dynamic collision checking for single and
/// multiple articulated robots in complex environments", 2005), but an interval of an edge is
/// decided by the hull of a body's two placements, grown by h^2 / 8 times a bound on its
/// acceleration, instead of by path lengths, which shrink only with h. One per thread; allocates in
/// the constructor only; queries never throw. Points have the size of the scene's space; of any
/// other size, or with a number that is not finite, they are undecided.
///
/// Answers and history. Free is a proof whatever was asked before; not free is one to within the
/// rounding that margins are charged with. But which queries look for the proof depends on earlier
/// calls: on planes that parted a pair last, pairs last in contact, growths at which a sweep
/// failed. So an edge whose proof just fits into the work limit, the smallest interval or rounding
/// may be decided after some calls and undecided after others. As a rule such an edge grazes
/// something within micrometres of its margin; where a negative margin lets bodies overlap, whose
/// depths are dear, it may stay millimetres off. Of an edge that is not free, the reported pair and
/// place may differ. The same calls in the same order give the same answers.
class EdgeCertifier {
 public:
  /// Throws std::invalid_argument without a scene.
  explicit EdgeCertifier(std::shared_ptr<const CompiledScene> scene);
  ~EdgeCertifier();

  const CompiledScene& scene() const;
  /// Answers for `scene` from now on, a variant of the scene before with other shapes or margins.
  /// O(bodies + pairs), far cheaper than a new certifier. Throws std::invalid_argument for a scene
  /// with other pairs (see CompiledScene::hasPairsOf()).
  void rebind(std::shared_ptr<const CompiledScene> scene);

  /// Whether a point keeps its margins, as fast as possible.
  Verdict decide(std::span<const double> point);
  /// Clearance of a point to within tolerance [m], closest pair, witnesses.
  StateCheck clearance(std::span<const double> point, double tolerance);
  /// Certifies the edge from a to b as the space interpolates it.
  EdgeCheck certify(std::span<const double> a, std::span<const double> b,
                    const EdgeRequest& request = {});
  /// For searches: the default work, doubled for every kEscalation edges that it has left
  /// undecided, up to persistent(). So an edge that a planner cannot do without is decided in the
  /// end, and few wait for it.
  EdgeRequest searching() const;
  /// The minimum clearance along the edge, as near as the request's work limit allows.
  EdgeClearance edgeClearance(std::span<const double> a, std::span<const double> b,
                              const ClearanceRequest& request);
  EdgeClearance edgeClearance(std::span<const double> a, std::span<const double> b,
                              double tolerance, double cutoff) {
    return edgeClearance(a, b, {.tolerance = tolerance, .cutoff = cutoff});
  }

  /// A quick upper end at a point: the distance of one of the pairs that are asked, mostly of the
  /// nearest. Where none is within a few centimetres it may be that of another. Only pairs below
  /// `known` [m] are looked at, and without one the upper end is that. The lower end is -infinity.
  EdgeClearance nearest(std::span<const double> point, Pairs pairs, double known);

  /// Bounds on that minimum from a few passes of lanes and distances: some 10 us. The lower end is
  /// at least `most` [m], or mostly above a quarter of the upper one; -infinity where the passes
  /// prove nothing. The upper end is infinity where nothing nearer than `most` was met.
  /// `once`: after one pass, which proves `most` or names a place, near the nearest, or tells
  /// nothing.
  EdgeClearance roughClearance(std::span<const double> a, std::span<const double> b, double most,
                               Pairs pairs = Pairs::kAll, bool once = false);

  /// Proves that the edge keeps more than `request.wanted` [m], as certify() proves margins: that
  /// is the lower end then, otherwise -infinity. Where a place is found that does not keep it, the
  /// upper end is the least distance near that place; otherwise infinity. The proof costs little
  /// more than that of the margins, far less than edgeClearance(). Ignores `cutoff`; a work limit
  /// of 0 is that of certify().
  EdgeClearance proveClearance(std::span<const double> a, std::span<const double> b,
                               const ClearanceRequest& request);

  /// Integral and greatest value of nearness along the edge, of all pairs. The edge is halved where
  /// that narrows the interval most: over a part, a plane that parts a pair in the middle bounds
  /// its distance from below, its two nearest points from above, both by a line in t and how far
  /// points leave their chords. So the width falls with the square of the parts. Where a body is
  /// far from convex and its hull is nearer than itself, speeds are the bound, and the width falls
  /// with the parts.
  EdgeCost edgeCost(std::span<const double> a, std::span<const double> b,
                    const CostRequest& request);

  struct Statistics {
    std::uint64_t states = 0, edges = 0, distance_queries = 0, intervals = 0;
    std::int64_t work = 0;  ///< of certify() and proveClearance() [units of collision::Work]
    std::uint64_t undecided_edges = 0;  ///< of certify(), mostly by its work limit
    Statistics& operator+=(const Statistics& more);
  };
  Statistics statistics;
  /// When set, certify() appends both ends of every edge, for measurements to replay. It allocates
  /// then.
  std::vector<std::vector<double>>* trace = nullptr;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace leeway::planner
