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

#include "leeway/collision/ball.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/scene_pairs.h"

namespace leeway::collision {

/// One shape of a body, placed in the body's frame.
struct Geometry {
  Shape shape;
  Pose X_BG;
  std::string name;  // for messages; may be empty
};

/// A rigid thing with one pose. The pose of a fixed body is stored here; the pose of a moving body
/// is in the Workspace.
struct Body {
  std::string name;
  std::vector<Geometry> geometries;
  bool moving = false;
  Pose X_WB;
  /// Balls in the body's frame, such as those of a point cloud; null if there are none. They are
  /// geometries, too, and have the numbers after `geometries`. A scene shares them, and stores
  /// nothing else about each one. Only a fixed body can have balls.
  std::shared_ptr<const std::vector<Ball>> balls = nullptr;

  /// The number of geometries and balls.
  std::size_t size() const { return geometries.size() + (balls ? balls->size() : 0); }
  /// The geometry with a number below size(); of a ball, a sphere. O(1).
  Geometry geometry(std::size_t number) const;
};

/// The bodies of a scene, by number: those of the SceneBuilder and those that a SceneChange added.
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

/// The pairs of bodies that must not touch. A scene is constant during queries and shared by any
/// number of Workspaces. It is made by a SceneBuilder, or from another scene by a SceneChange. Two
/// fixed bodies never form a pair. Copies share their bodies until one of them changes a shape.
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
  /// Index of the first body with that name that no change has removed; -1 if there is none.
  /// O(bodies).
  int find(const std::string& name) const;
  /// Whether a change has removed the body. O(log removed).
  bool isRemoved(int body) const {
    return std::binary_search(removed_.begin(), removed_.end(), body);
  }

  /// Replaces the shape of one geometry, for example by the next snapshot of a deforming obstacle.
  /// No query may run meanwhile; pairs and margins stay. O(1) for a snapshot. O(bodies) for the
  /// first call after this scene was copied or is a copy, for a fixed body that does not deform,
  /// and for a body that a change added. Throws std::out_of_range for a ball.
  void setShape(int body, int geometry, const Shape& shape);

  /// Moves bodies that a change added; pairs and margins stay. No query may run meanwhile. Throws
  /// std::invalid_argument, and changes nothing, for another body, and for a pose that is not
  /// finite or whose rotation is not orthogonal. O(m log m) in the bodies that changes added.
  void setPoses(std::span<const std::pair<int, Pose>> X_WB);

  /// Raises every pair's margin to at least this [m].
  void raiseMargins(double margin) { pairs_.raise(margin, 0); }

  /// Adds `growth` >= 0 [m] to the margin of every pair of that geometry. Negative margins are
  /// raised to 0 first, because a bound on how far vertices of a mesh move bounds its distances,
  /// not its depths. A growth of 0 leaves margins as they are; with NaN such a pair is never free.
  void growMargins(int body, int geometry, double growth);

 private:
  friend class SceneBuilder;
  friend class SceneChange;
  friend struct SceneAccess;
  struct Things {
    std::vector<Body> bodies;
    std::vector<int> first_geometry;  // of each body, in the numbering of all geometries and balls
    std::vector<std::size_t> first_bounds;   // of each body, in `bounds`
    std::vector<GeometryBounds> bounds;      // of geometries; those of a ball are made when needed
    std::size_t size = 0;                    // the number of geometries and balls
    void add(Body body, std::size_t first);  // first: the number of the body's first geometry
    // Another body with as many geometries and as many balls.
    void replace(std::size_t body, Body by);
  };
  static const std::shared_ptr<Things>& nothing();
  /// Returns the bodies for modification, no longer shared with other scenes.
  Things& own();
  std::shared_ptr<Things> things_;
  std::shared_ptr<const Things> added_;  // added by changes, after those of the builder; null: none
  std::vector<int> removed_;             // removed by changes; ascending
  // Set permanently in both scenes when one is a copy of the other. A count of owners would not
  // order their reads before a change.
  mutable std::atomic<bool> is_shared_ = true;
  ScenePairs pairs_;
  // Bounds of the geometries in the table (see ScenePairs).
  struct Still {
    std::shared_ptr<const ObstacleBoxes> boxes;  // around each; a deforming one may be anywhere
    std::shared_ptr<const std::vector<std::int32_t>> added;  // see SceneAccess::added()
    // Sums of their coordinates are at most this, see SceneAccess; those of bodies that the scene
    // was built with [m].
    double scale = 0, built_scale = 0;
  };
  // Computes them for all geometries in the table. O(n log n).
  void findStill();
  // Computes them again for the bodies that changes added. There must be places. O(n log n) in the
  // number of those.
  void findAddedStill();
  Still still_;
};

/// Collects bodies, allowed pairs and margins; build() makes the pairs.
class SceneBuilder {
 public:
  SceneBuilder() = default;
  /// Starts with the bodies of `base` and with its pairs, but not with their margins. This way a
  /// robot is prepared once, and worlds are added. The bounds of its geometries are not computed
  /// again. O(bodies + pairs of base).
  explicit SceneBuilder(const Scene& base) : base_(base) {}
  /// Lists all pairs (see ScenePairs), including those with fixed bodies: for a robot to which
  /// other builders add worlds.
  void listAll() { lists_all_ = true; }

  void reserve(std::size_t bodies);  ///< reserves room for this many added bodies in total
  /// Adds a body and returns its index.
  int add(Body body);
  void allow(int body_a, int body_b);    ///< the two bodies may touch: no pair of theirs is kept
  void setDefaultMargin(double margin);  ///< [m]; default 0; may be negative (allowed depth)
  void setMargin(int body_a, int body_b, double margin);  ///< [m]; the last call for a pair counts
  /// Makes the scene with all pairs that have a moving body and are not allowed, each with its
  /// margin. Throws std::invalid_argument if a margin or a pose is not finite, if a rotation is not
  /// orthogonal within kRotationTolerance, if a ball is not finite, has a radius that
  /// Shape::sphere() refuses or belongs to a moving body, if a pair has two half-spaces (the
  /// message names the bodies), or if the number of moving geometries times the number of fixed
  /// ones exceeds an int.
  /// Bodies after the last moving one and after those of `base` get places in the table. The places
  /// of `base` stay if no moving body is added. O(listed pairs + allowed + margins), plus O(n log
  /// n) in the fixed bodies.
  Scene build() const& { return SceneBuilder(*this).build(); }
  Scene build() &&;

 private:
  void addTable(std::span<const Body> bodies, int first_still, ScenePairs& pairs) const;
  static void addTableOf(const ScenePairs& base, ScenePairs& pairs);

  Scene base_;                // build() starts with it
  std::vector<Body> bodies_;  // bodies added to those of base_
  std::vector<std::pair<int, int>> allowed_;
  struct PairMargin {
    int a, b;
    double margin;
  };
  std::vector<PairMargin> margins_;
  double default_margin_ = 0;
  bool lists_all_ = false;
};

/// A change to a world that mostly stays the same: makes a scene from a previous one, with
/// additional fixed bodies and without the pairs of removed ones. The bodies are shared.
class SceneChange {
 public:
  explicit SceneChange(Scene before) : scene_(std::move(before)) {}

  /// Removes the pairs of a fixed body. The body stays in bodies(), so other bodies keep their
  /// numbers, until add() uses its number again.
  void remove(int body);
  /// Removes the pairs of some balls of a fixed body. `balls` are their places in Body::balls;
  /// they stay there, so other geometries keep their numbers.
  void removeBalls(int body, std::span<const std::int32_t> balls);
  /// Adds a fixed body and returns its index. That is the number of a removed body with as many
  /// geometries and balls that an earlier change had added, or else the next one, so an object that
  /// moves again and again leaves one body behind. The new body has pairs with all moving bodies.
  /// O(removed bodies).
  int add(Body body);
  /// A moving body and an added one, in either order, may touch.
  void allow(int body_a, int body_b);
  void setDefaultMargin(double margin);  ///< of pairs of added bodies [m]; default 0
  /// The margin of a moving body and an added one, in either order [m]; the last call counts.
  void setMargin(int body_a, int body_b, double margin);
  /// Makes the scene. Pairs change their numbers. Throws std::invalid_argument as
  /// SceneBuilder::build() does, and for bodies other than those described above. O(m log m), where
  /// m is the number of listed pairs, of pairs that are left out or have margins of their own, of
  /// meshes and hulls, and of all bodies that changes have added and removed, times the number of
  /// moving bodies. If some fixed body does not have exactly one geometry, it also copies eight
  /// bytes for each geometry.
  Scene build() &&;

 private:
  bool isAdded(int body) const;
  int numberToUse(const Body& like) const;
  void useAgain();
  std::pair<int, int> movingAndAdded(int body_a, int body_b) const;
  /// nullopt: the two may touch.
  std::optional<double> marginOf(int moving, std::size_t added) const;
  void requireNoHalfSpaces(std::size_t body) const;
  void requireStill(int body) const;
  void removePairs();
  void addPairs(std::size_t first);
  void addPlaces(std::size_t first);
  Scene scene_;
  std::vector<int> removed_;
  std::map<int, std::vector<std::int32_t>> removed_balls_;  // geometries by body
  std::vector<Body> bodies_;
  std::map<int, Body> used_again_;                 // bodies by the numbers of removed ones
  std::map<std::pair<int, int>, double> margins_;  // of a moving and an added body
  std::set<std::pair<int, int>> allowed_;
  double default_margin_ = 0;
};

/// The state of one thread that queries a Scene: poses of moving bodies, a fixed number of pair
/// caches, scratch memory and statistics. It is valid for that scene and for scenes with the same
/// bodies and pairs.
class Workspace {
 public:
  explicit Workspace(const Scene& scene);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  /// Sets the pose of a moving body. The pose of a fixed body is in the scene.
  void setPose(int body, const Pose& X_WB);
  /// The pose of a body. Throws std::out_of_range for a body in the table (see ScenePairs), whose
  /// pose is in the scene.
  const Pose& pose(int body) const;
  /// Makes room for data that queries of the scene's deforming shapes fill on demand (see prepare()
  /// in deformable_mesh.h). The constructor calls it; call it when a snapshot may have more nodes
  /// than before (strategies that rebuild need no room). May allocate.
  void prepare(const Scene& scene);

  /// The largest distance of any point of a moving body from its place by the body's pose [m]. It
  /// widens every interval.
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

/// The verdict on pairs and their margins. For safety, treat kUndecided as kNotFree.
enum class Verdict : unsigned char {
  kFree,       ///< every pair is proven to keep more than its margin
  kNotFree,    ///< some pair is proven not to keep more than its margin
  kUndecided,  ///< a limit or rounding left it open
};

/// The answer of decide() and clearance().
struct SceneResult {
  Verdict verdict = Verdict::kUndecided;
  Interval clearance;      ///< minimum over the pairs of the signed separation [m]; (inf, inf) if
                           ///< there is no pair
  int pair = -1;           ///< the pair that determines the upper end
  DistanceResult closest;  ///< that pair's result, in world coordinates
};

/// Decides for every pair whether it keeps its margin, coarse bounds first. Stops at the first pair
/// that is not free; `clearance` is then only the interval found so far. Never throws or allocates.
/// At most one query for each listed pair, and for each pair in the table that is near.
SceneResult decide(const Scene& scene, Workspace& workspace);

/// Computes the clearance to within `tolerance` [m], with the closest pair and its witness points,
/// and the verdict for all pairs. Never throws or allocates. O(n log n) in the number of listed
/// pairs and of near pairs in the table.
SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance);

/// The distance of one pair in world coordinates, at the workspace's poses; widened by the
/// workspace's pose_error. Never throws or allocates.
DistanceResult pairDistance(const Scene& scene, Workspace& workspace, int pair,
                            const DistanceRequest& request);

}  // namespace leeway::collision
