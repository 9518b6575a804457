#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "leeway/planner/configuration_space.h"
#include "planner/base/random.h"
#include "planner/space/nearest_nodes.h"
#include "robots/base/low_discrepancy.h"

namespace leeway::planner {

/// Appends points of a way from the first point towards the second, each joined to the previous one
/// by a free edge; no points if it finds no way.
using ConnectSlide = std::function<void(std::span<const double>, std::span<const double>,
                                        std::vector<double>& points)>;

/// The problem that ConnectTrees searches. All must outlive it.
struct ConnectTask {
  const ConfigurationSpace& space;
  std::span<const double> start;
  const std::vector<std::vector<double>>& goals;  ///< at least one; a path to any of them is enough
  /// Whether the edge between two points is free.
  const std::function<bool(std::span<const double>, std::span<const double>)>& isFree;
  /// Only shorter paths are searched, in the space's distance.
  double bound = std::numeric_limits<double>::infinity();
  /// For narrow places: continues where an edge is not free. Half of the samples are then drawn
  /// from the region of both trees, or between them.
  const ConnectSlide* slide = nullptr;
};

/// The space's extent with each joint's turn counted up to half a turn. Beyond that a turn repeats,
/// and steps should not grow with it. O(parts).
double usefulExtent(const ConfigurationSpace& space);

/// The default range, in the space's distance. It is shorter with more joints, because fewer of the
/// long edges are then free; for a free body it is the distance by which kBodyTurn moves it, within
/// limits. O(parts).
double defaultRange(const ConfigurationSpace& space);

/// Whether the planned variables are those of one planar or floating joint. O(variables).
bool isBody(const ConfigurationSpace& space);

struct ConnectSettings {
  /// The longest edge, in the space's distance; at least kShortestRange of its extent.
  double range = 1;
  /// If true, both trees grow to about the same size; otherwise they take turns.
  bool balance = true;
  /// A node whose edge has failed is extended only towards samples within its radius, which shrinks
  /// with each failure and grows with each success: Yershova, Jaillet, Simeon, LaValle,
  /// "Dynamic-domain RRTs", 2005; the adaptive radius is that of Jaillet et al. 2005.
  bool dynamic_domain = true;
  /// If true, samples come from a low-discrepancy sequence, shifted by the seed, instead of random
  /// numbers, so that no region is left out for long. Plans of arms check 3 to 14 % fewer edges in
  /// the mean, those of bodies the same number.
  bool low_discrepancy = false;
};

/// RRT-Connect (Kuffner, LaValle, "RRT-Connect: an efficient approach to single-query path
/// planning", 2000): a tree from the start and one from the goals, which grow towards each other.
/// Points are stored flat; the search allocates only as its trees grow. It can be interrupted and
/// continued: the same calls find the same path.
///
/// With a bound it is the search of AO-RRT-Connect (Wilson, Thomason, Kingston, Kavraki, Gammell,
/// "AORRTC: almost-surely asymptotically optimal planning with RRT-Connect", 2025): nodes store the
/// cost of reaching them, and samples and nodes that no shorter path can visit are omitted.
class ConnectTrees {
 public:
  /// The start and the goals of `task` must be valid. O(goals).
  ConnectTrees(const ConnectTask& task, const ConnectSettings& settings, std::uint64_t seed);

  /// Takes one sample, adds an edge towards it, and tries to connect it to the other tree. True if
  /// the trees have met; then do not call it again. O(nodes), plus its edges.
  bool iterate();
  /// The nodes of both trees. O(1).
  std::size_t nodes() const { return trees_[0].nearest.size() + trees_[1].nearest.size(); }
  /// Adds the goals that were appended to the task's goals since the last call. O(goals).
  void takeGoals();
  /// After iterate() returned true: the path from the start to a goal, each edge in the direction
  /// in which isFree() checked it; edges of slides in the goals' tree were checked in reverse.
  std::vector<std::vector<double>> path() const;

  /// Two points of the trees that an edge did not join, the nearest that were tried.
  struct Gap {
    double distance = std::numeric_limits<double>::infinity();
    std::vector<double> of_start, of_goals;  ///< empty: none was tried
  };
  const Gap& gap() const { return gap_; }

 private:
  /// Notes that a node of the growing tree and `to`, of the other one, were not joined.
  void noteGap(std::uint32_t node, std::span<const double> to);
  struct Tree {
    explicit Tree(const ConfigurationSpace& space) : nearest(space) {}
    NearestNodes nearest;
    std::vector<double> lower, upper;   ///< the box of all points, per number
    std::vector<double> points;         ///< node by node
    std::vector<std::uint32_t> parent;  ///< for a root, itself
    std::vector<float> radius;          ///< of the dynamic domain
    std::vector<double> cost;           ///< length of the way from the root
  };
  std::span<const double> pointOf(const Tree& tree, std::uint32_t node) const;
  std::uint32_t add(Tree& tree, std::span<const double> point, std::uint32_t parent, double step);
  void sample();
  bool isBounded() const { return task_.bound < std::numeric_limits<double>::infinity(); }
  /// A lower bound on the length of every path from a tree's root to a point.
  double toRoot(int tree, std::span<const double> point) const;
  /// Moves a sample that no path below the bound visits to a place where one may: towards a point
  /// of the straight way from the start to a goal.
  void pullSample();
  /// Adds the points that a slide from a node towards `target` reaches; returns its last node.
  std::uint32_t slideTowards(Tree& tree, std::uint32_t node, std::span<const double> target);
  /// A number in [0, 1) for a dimension of the current sample.
  double draw(std::size_t dimension);
  /// A number of a sample in the region where the trees' boxes meet, or between them, for `drawn`
  /// in [0, 1).
  double between(std::size_t i, double weight, double drawn) const;
  /// A unit quaternion for three dimensions of the current sample.
  void drawRotation(std::size_t dimension, double* xyzw);
  /// Steps from a node towards `target`, to the point at most `range` away; false if the edge is
  /// not free. `next_` is its end.
  bool stepTowards(const Tree& tree, std::uint32_t node, std::span<const double> target,
                   double distance);
  /// Checks the edge between a point of the tree and next_, in the direction of a path.
  bool isFree(const Tree& tree, std::span<const double> from) const;

  ConnectTask task_;
  ConnectSettings settings_;
  Random random_;
  std::optional<robots::LowDiscrepancy> sequence_;
  std::uint64_t samples_ = 0;
  std::size_t size_;
  std::size_t goals_ = 0;  ///< taken so far
  float domain_ = 0;       ///< the unit of radii of the dynamic domain
  Tree trees_[2];          ///< of the start, and of the goals
  int growing_ = 1;
  std::vector<double> sample_, next_, from_, focus_, drawn_, slid_;
  Gap gap_;
  std::uint32_t met_[2] = {0, 0};  ///< nodes of both trees with the same point
};

}  // namespace leeway::planner
