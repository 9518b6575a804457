#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "leeway/collision/distance.h"
#include "leeway/collision/scene_pairs.h"

namespace leeway::collision {

/// One shape of a body, placed in the body's frame.
struct Geometry {
  Shape shape;
  Pose X_BG;
  std::string name;  // for messages; may be empty
};

/// A rigid thing with one pose. A body that stands still has its pose here, a moving one has it in
/// the Workspace.
struct Body {
  std::string name;
  std::vector<Geometry> geometries;
  bool moving = false;
  Pose X_WB;
};

/// The bodies of a scene, by number: those that it was built with, and those that a change added.
class Bodies {
 public:
  Bodies(std::span<const Body> built, std::span<const Body> added) : built_(built), added_(added) {}
  std::size_t size() const { return built_.size() + added_.size(); }
  bool empty() const { return size() == 0; }
  const Body& operator[](std::size_t i) const {
    return i < built_.size() ? built_[i] : added_[i - built_.size()];
  }
  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = Body;
    using difference_type = std::ptrdiff_t;
    using pointer = const Body*;
    using reference = const Body&;
    reference operator*() const { return Bodies(built_, added_)[i_]; }
    pointer operator->() const { return &**this; }
    Iterator& operator++() {
      ++i_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return i_ == other.i_; }

   private:
    friend class Bodies;
    Iterator(const Bodies& of, std::size_t i) : built_(of.built_), added_(of.added_), i_(i) {}
    std::span<const Body> built_, added_;
    std::size_t i_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }

 private:
  std::span<const Body> built_, added_;
};

class ObstacleBoxes;    // private to the library
struct GeometryBounds;  // private to the library
struct SceneAccess;     // private to the library
class SceneBuilder;

/// What must not touch what: constant while it is queried, shared by any number of Workspaces.
/// Made by SceneBuilder, or from another by SceneChange. Has no pair of two bodies that stand
/// still. A copy shares the bodies until one of both changes a shape.
class Scene {
 public:
  Scene();
  ~Scene();
  Scene(const Scene&);
  Scene& operator=(const Scene&);
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  Bodies bodies() const {
    return {things_->bodies,
            added_ ? std::span<const Body>(added_->bodies) : std::span<const Body>()};
  }
  const ScenePairs& pairs() const { return pairs_; }
  /// Index of the first body with that name that no change has removed, -1 when there is none.
  /// O(bodies).
  int find(const std::string& name) const;
  /// Whether a change has removed it. O(log removed).
  bool isRemoved(int body) const {
    return std::binary_search(removed_.begin(), removed_.end(), body);
  }

  /// Another shape for one geometry: the next snapshot of a deforming obstacle. No query may run
  /// meanwhile; pairs and margins stay. O(1) for a snapshot; O(bodies) for the first after this
  /// scene was copied or is a copy, for a body of the world that does not deform, and for one that
  /// a change added.
  void setShape(int body, int geometry, const Shape& shape);

  /// Raises every pair's margin to at least this [m].
  void raiseMargins(double margin) { pairs_.raise(margin, 0); }

  /// Adds `growth` >= 0 [m] to the margin of every pair of that geometry, negative margins raised
  /// to 0 first: a bound on how far vertices of a mesh move bounds its distances, not its depths. A
  /// growth of 0 leaves margins as they are; with NaN such a pair is never free.
  void growMargins(int body, int geometry, double growth);

 private:
  friend class SceneBuilder;
  friend class SceneChange;
  friend struct SceneAccess;
  struct Things {
    std::vector<Body> bodies;
    std::vector<int> first_geometry;  // of each body, in the numbering of all geometries
    std::vector<GeometryBounds> bounds;
    void add(Body body, int first);  // the number of its first geometry
  };
  static const std::shared_ptr<Things>& nothing();
  /// To change: no other scene has them from now on.
  Things& own();
  std::shared_ptr<Things> things_;
  std::shared_ptr<const Things> added_;  // by changes, after those; null: none
  std::vector<int> removed_;             // by changes; ascending
  // Set, for good, in both where one is a copy of the other: counting owners would not order their
  // reads before a change.
  mutable std::atomic<bool> is_shared_ = true;
  ScenePairs pairs_;
  // Bounds of the geometries in places.
  struct Still {
    std::shared_ptr<const ObstacleBoxes> boxes;  // around each; a deforming one may be anywhere
    std::shared_ptr<const std::vector<std::int32_t>> added;  // see SceneAccess::added()
    double scale = 0;  // sums of their coordinates are at most this, see SceneAccess [m]
  };
  // Of all that is in places. O(n log n).
  void findStill();
  // Again, of what changes added. O(n log n) in that.
  void findAddedStill();
  Still still_;
};

/// Collects bodies, allowed pairs and margins; build() makes the pairs.
class SceneBuilder {
 public:
  SceneBuilder() = default;
  /// Begins with the bodies of `base` and, among them, with its pairs, but for their margins: a
  /// robot is prepared once, and worlds are added. What is known of its geometries is not computed
  /// again. O(bodies + pairs of base).
  explicit SceneBuilder(const Scene& base) : base_(base) {}
  /// Lists all pairs (see ScenePairs), also those with bodies that stand still: for a robot, to
  /// which builders add worlds.
  void listAll() { lists_all_ = true; }

  void reserve(std::size_t bodies);  ///< room for so many that are added, in all
  /// The new body's index.
  int add(Body body);
  void allow(int body_a, int body_b);    ///< the two may touch: no pair of theirs is kept
  void setDefaultMargin(double margin);  ///< [m]; default 0; may be negative (allowed depth)
  void setMargin(int body_a, int body_b, double margin);  ///< [m]; the last call for a pair counts
  /// All pairs with a moving body that are not allowed, each with its margin. Throws
  /// std::invalid_argument for a margin or a pose that is not finite, for a rotation that is not
  /// orthogonal within kRotationTolerance, and for two half-spaces, naming their bodies; and where
  /// moving geometries times those that stand still are more than an int numbers. Bodies after the
  /// last one that moves and after those of `base` get places. The places of `base` stay, if
  /// nothing is added that moves. O(listed pairs + allowed + margins), and O(n log n) in what
  /// stands still.
  Scene build() const& { return SceneBuilder(*this).build(); }
  Scene build() &&;

 private:
  void addTable(std::span<const Body> bodies, int first_still, ScenePairs& pairs) const;
  static void addTableOf(const ScenePairs& base, ScenePairs& pairs);

  Scene base_;                // what build() begins with
  std::vector<Body> bodies_;  // added to those
  std::vector<std::pair<int, int>> allowed_;
  struct PairMargin {
    int a, b;
    double margin;
  };
  std::vector<PairMargin> margins_;
  double default_margin_ = 0;
  bool lists_all_ = false;
};

/// What comes and goes in a world of which most stays: makes a scene from the one before, with more
/// bodies that stand still and without the pairs of some. Bodies are shared.
class SceneChange {
 public:
  explicit SceneChange(Scene before) : scene_(std::move(before)) {}

  /// A body that stands still has no pairs any more. It stays in bodies(), which keep their
  /// numbers.
  void remove(int body);
  /// The new body's index. It has pairs with all that moves.
  int add(Body body);
  /// A body that moves and one that is added, in either order, may touch.
  void allow(int body_a, int body_b);
  void setDefaultMargin(double margin);  ///< of pairs of what is added [m]; default 0
  /// Of a body that moves and one that is added, in either order [m]; the last call counts.
  void setMargin(int body_a, int body_b, double margin);
  /// Pairs change their numbers. Throws std::invalid_argument as SceneBuilder::build() does, and
  /// for other bodies than those above. O(m log m), m being listed pairs, pairs that are left out
  /// or have margins of their own, meshes and hulls, and all that changes have added and removed,
  /// times what moves. Where some body of the world has not exactly one geometry, it also copies
  /// eight bytes for each geometry.
  Scene build() &&;

 private:
  bool isAdded(int body) const;
  std::pair<int, int> movingAndAdded(int body_a, int body_b) const;
  /// None: the two may touch.
  std::optional<double> marginOf(int moving, std::size_t added) const;
  void removePairs();
  void addPairs(std::size_t first);
  void addPlaces(std::size_t first);
  Scene scene_;
  std::vector<int> removed_;
  std::vector<Body> bodies_;
  std::map<std::pair<int, int>, double> margins_;  // of a moving and an added body
  std::set<std::pair<int, int>> allowed_;
  double default_margin_ = 0;
};

/// What one thread changes while it queries a Scene: poses of moving bodies, caches of as many
/// pairs as it has room for, scratch memory, statistics. For that scene only, and those with the
/// same bodies and pairs.
class Workspace {
 public:
  explicit Workspace(const Scene& scene);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  /// Places a moving body. (A body that stands still is where the scene has it.)
  void setPose(int body, const Pose& X_WB);
  /// Where a body stands. Throws std::out_of_range for a body in the table (see ScenePairs), which
  /// stands where the scene has it.
  const Pose& pose(int body) const;
  /// Makes room for what queries of the scene's deforming shapes fill on demand (see prepare() in
  /// deformable_mesh.h). The constructor does it; call it when a snapshot may have more nodes than
  /// before (strategies that rebuild need no room). May allocate.
  void prepare(const Scene& scene);

  /// How far any point of a moving body may be from where its pose places it [m]: widens every
  /// interval.
  double pose_error = 0;

  struct Statistics {
    std::uint64_t queries = 0, pairs = 0, coarse_decided = 0, exact = 0, iterations = 0;
  };
  Statistics statistics;

 private:
  friend struct SceneAccess;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What is known of pairs and their margins. For safety treat kUndecided as kNotFree.
enum class Verdict : unsigned char {
  kFree,       ///< every pair is proven to keep more than its margin
  kNotFree,    ///< some pair is proven not to
  kUndecided,  ///< a limit or rounding left it open
};

/// The answer of decide() and clearance().
struct SceneResult {
  Verdict verdict = Verdict::kUndecided;
  Interval clearance;      ///< minimum over the pairs of the signed separation [m]; (inf, inf) when
                           ///< there is no pair
  int pair = -1;           ///< the pair that carries the upper end
  DistanceResult closest;  ///< that pair's result, in world coordinates
};

/// Decides every pair against its margin, coarse bounds first, and stops at the first pair that is
/// not free: `clearance` is what is known by then. Never throws or allocates. O(listed pairs)
/// queries, and of others, those of the pairs that are near.
SceneResult decide(const Scene& scene, Workspace& workspace);

/// The clearance to within `tolerance` [m], with the closest pair and its witness points, and the
/// verdict of all pairs. Never throws or allocates. O(n log n) in listed pairs and others that are
/// near.
SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance);

/// The distance of one pair, in world coordinates, as the workspace places its bodies; widened by
/// the workspace's pose_error. Never throws or allocates.
DistanceResult pairDistance(const Scene& scene, Workspace& workspace, int pair,
                            const DistanceRequest& request);

}  // namespace leeway::collision
