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

/// One configuration, compared with the margins.
struct StateCheck {
  Verdict verdict = Verdict::kUndecided;
  Interval clearance;                 ///< [m]
  int pair = -1;                      ///< the closest one, in collision::Scene::pairs()
  collision::DistanceResult closest;  ///< in world coordinates
};

/// A request for an edge's cost.
struct CostRequest {
  Nearness nearness;
  /// Sufficient width of the interval, as a share of its upper end. A width of kLeast always
  /// suffices, because nearness is at most 1.
  double tolerance = 0.01;
  /// Stops as soon as the mean is proven to be above it.
  double cutoff = std::numeric_limits<double>::infinity();
  std::int64_t work_limit = 0;  ///< as in EdgeRequest; 0: about 20 ms
  static constexpr double kLeast = 1e-5;
};

/// The cost of being near along an edge: certified intervals.
struct EdgeCost {
  /// The mean of nearness over t. Its product with the edge's length is the integral.
  Interval mean{0, 1};
  /// The greatest nearness along the edge.
  Interval worst{0, 1};
  /// The least clearance, to the accuracy that the costs needed [m]. An upper end of infinity means
  /// that it was not computed.
  Interval clearance{-std::numeric_limits<double>::infinity(),
                     std::numeric_limits<double>::infinity()};
};

struct EdgeRequest {
  bool last_valid = false;       ///< find the largest t up to which the edge is certified
  double smallest_interval = 0;  ///< in t; 0: the default of tolerances (by motion, not by t)
  /// The most that the edge may cost, in units of collision::Work, about a thousand per
  /// microsecond; beyond that, the edge is undecided. 0: about 100 us, or half a millisecond for a
  /// body that flies freely among triangles. `last_valid` may cost the same again.
  std::int64_t work_limit = 0;
  /// Every pair keeps its margin and that >= 0 [m]: so an edge also proves what stays near it. Any
  /// other number leaves the edge undecided.
  double beyond = 0;

  /// A hundred times the default work: for proofs that no other edge can replace.
  static EdgeRequest persistent();
};

struct EdgeCheck {
  Verdict verdict = Verdict::kUndecided;
  double last_valid = 0;  ///< the edge is certified on [0, last_valid]; 1 when free
  double t = 0;           ///< if not free or undecided: the place
  int pair = -1;          ///< and the pair; -1: no single pair
};

/// A request for an edge's clearance.
struct ClearanceRequest {
  double tolerance = 1e-4;  ///< sufficient width of the interval [m]
  /// Stops as soon as the minimum is proven to be below it (upper < cutoff) [m].
  double cutoff = -std::numeric_limits<double>::infinity();
  /// Stops as soon as the minimum is proven to be at least this [m]. The upper end is infinity if
  /// the proof needed no distance.
  double wanted = std::numeric_limits<double>::infinity();
  std::int64_t work_limit = 0;  ///< as in EdgeRequest; 0: about 0.1 s
  Pairs pairs = Pairs::kAll;    ///< all other pairs are ignored
};

/// The least clearance along an edge as a certified interval, and its place.
struct EdgeClearance {
  Interval clearance;  ///< of the minimum over edge and pairs [m]; (inf, inf) without pairs
  double t = 0;        ///< where the upper end was found
  int pair = -1;
  collision::DistanceResult closest;
  /// Set by roughClearance() and proveClearance(): all pairs in question are proven to keep their
  /// margins.
  bool keeps_margins = false;
};

/// Decides states and whole edges of one compiled scene by bounds, without a step size. It uses
/// adaptive bisection as in Schwarzer, Saha and Latombe ("Adaptive dynamic collision checking for
/// single and multiple articulated robots in complex environments", 2005), with another bound: an
/// interval of an edge is decided by the hull of a body's two placements, grown by h^2 / 8 times a
/// bound on its acceleration. The paper uses path lengths, whose slack is proportional to h only.
/// Use one per thread. It allocates only in the constructor; queries never throw. Points have the
/// size of the scene's space. Points of any other size, or with a number that is not finite, are
/// undecided.
///
/// Answers and history. Free is always a proof. Not free is a proof to within the rounding that
/// margins include. But the queries that search for the proof depend on earlier calls: on planes
/// that separated a pair last, pairs last in contact, growths at which a sweep failed. So an edge
/// whose proof just fits into the work limit, the smallest interval or rounding may be decided
/// after some calls and undecided after others. Typically such an edge comes within micrometres of
/// its margin. If a negative margin lets bodies overlap, whose depths are expensive, it may stay
/// millimetres away. The reported pair and place of an edge that is not free may also differ. The
/// same calls in the same order give the same answers.
class EdgeCertifier {
 public:
  /// Throws std::invalid_argument without a scene.
  explicit EdgeCertifier(std::shared_ptr<const CompiledScene> scene);
  ~EdgeCertifier();

  const CompiledScene& scene() const;
  /// Answers for `scene` from now on, a variant of the previous scene with other shapes or margins.
  /// O(bodies + pairs), far cheaper than a new certifier. Throws std::invalid_argument for a scene
  /// with other pairs (see CompiledScene::hasPairsOf()).
  void rebind(std::shared_ptr<const CompiledScene> scene);

  /// Whether a point keeps its margins, as fast as possible.
  Verdict decide(std::span<const double> point);
  /// Clearance of a point to within tolerance [m], closest pair, witnesses.
  StateCheck clearance(std::span<const double> point, double tolerance);
  /// The same, but of a pair that does not keep its margin if there is one. It need not be the
  /// closest pair, because margins differ.
  StateCheck tooNear(std::span<const double> point, double tolerance);
  /// Certifies the edge from a to b as the space interpolates it.
  EdgeCheck certify(std::span<const double> a, std::span<const double> b,
                    const EdgeRequest& request = {});
  /// A request for searches: the default work, doubled after every kEscalation edges that this
  /// certifier has left undecided, up to persistent(). So an edge that a planner needs is decided
  /// in the end, and few edges wait for it.
  EdgeRequest searching() const;
  /// The minimum clearance along the edge, as narrow as the request's work limit allows.
  EdgeClearance edgeClearance(std::span<const double> a, std::span<const double> b,
                              const ClearanceRequest& request);
  EdgeClearance edgeClearance(std::span<const double> a, std::span<const double> b,
                              double tolerance, double cutoff) {
    return edgeClearance(a, b, {.tolerance = tolerance, .cutoff = cutoff});
  }

  /// A quick upper end at a point: the distance of one of the pairs in question, usually of the
  /// nearest. If no pair is within a few centimetres, it may be that of another pair. Only pairs
  /// below `known` [m] are considered, and without one the upper end is `known`. The lower end is
  /// -infinity.
  EdgeClearance nearest(std::span<const double> point, Pairs pairs, double known);

  /// Bounds on that minimum from a few passes of lanes and distances, in about 10 us. The lower end
  /// is at least `most` [m], or usually above a quarter of the upper end; it is -infinity if the
  /// passes prove nothing. The upper end is infinity if no pair nearer than `most` was found.
  /// `once`: stops after one pass, which proves `most`, names a place near the nearest one, or
  /// gives no result.
  EdgeClearance roughClearance(std::span<const double> a, std::span<const double> b, double most,
                               Pairs pairs = Pairs::kAll, bool once = false);

  /// Proves that the edge keeps more than `request.wanted` [m], as certify() proves margins. The
  /// lower end is then that value, otherwise -infinity. If a place violates it, the upper end is
  /// the least distance near that place, otherwise infinity. The proof costs little more than that
  /// of the margins, far less than edgeClearance(). Ignores `cutoff`; a work limit of 0 is that of
  /// certify().
  EdgeClearance proveClearance(std::span<const double> a, std::span<const double> b,
                               const ClearanceRequest& request);

  /// Integral and greatest value of nearness along the edge, over all pairs. The edge is halved
  /// where that narrows the interval most. Over a part, a plane that separates a pair in the middle
  /// bounds its distance from below, and its two nearest points from above. Both bounds are a line
  /// in t, corrected by how far points leave their chords. So the width falls with the square of
  /// the length of the parts. If a body is far from convex and its hull is nearer than itself,
  /// speeds are the bound, and the width falls with the length of the parts.
  EdgeCost edgeCost(std::span<const double> a, std::span<const double> b,
                    const CostRequest& request);

  struct Statistics {
    std::uint64_t states = 0, edges = 0, distance_queries = 0, intervals = 0;
    std::int64_t work = 0;  ///< of certify() and proveClearance() [units of collision::Work]
    std::uint64_t undecided_edges = 0;  ///< of certify(), usually by its work limit
    Statistics& operator+=(const Statistics& more);
  };
  Statistics statistics;
  /// If set, certify() appends both ends of every edge, so that measurements can replay them. It
  /// then allocates.
  std::vector<std::vector<double>>* trace = nullptr;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace leeway::planner
