#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "leeway/collision/distance.h"

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

/// Two geometries that must keep more than `margin` apart.
struct ScenePair {
  std::int32_t body_a, geometry_a;  // geometry index within its body
  std::int32_t body_b, geometry_b;  // a is always moving; b may be
  double margin;                    // [m]
};

struct GeometryBounds;  // private to the library
struct SceneAccess;     // private to the library
class SceneBuilder;

/// What must not touch what: constant while it is queried, shared by any number of Workspaces.
/// Made by SceneBuilder. Has no pair of two bodies that stand still.
class Scene {
 public:
  Scene();
  ~Scene();
  Scene(const Scene&);
  Scene& operator=(const Scene&);
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  std::span<const Body> bodies() const { return bodies_; }
  std::span<const ScenePair> pairs() const { return pairs_; }
  /// Index of the body with that name, -1 when there is none. O(bodies).
  int find(const std::string& name) const;

  /// Another shape for one geometry: the next snapshot of a deforming obstacle. No query may run
  /// meanwhile; pairs and margins stay. O(1) for a snapshot.
  void setShape(int body, int geometry, const Shape& shape);

  /// Raises every pair's margin to at least this [m].
  void raiseMargins(double margin) {
    for (ScenePair& pair : pairs_) pair.margin = std::max(pair.margin, margin);
  }

  /// Adds `growth` >= 0 [m] to the margin of every pair of that geometry, negative margins raised
  /// to 0 first: a bound on how far vertices of a mesh move bounds its distances, not its depths. A
  /// growth of 0 leaves margins as they are; with NaN such a pair is never free.
  void growMargins(int body, int geometry, double growth);

 private:
  friend class SceneBuilder;
  friend struct SceneAccess;
  std::vector<Body> bodies_;
  std::vector<ScenePair> pairs_;
  std::vector<int> first_geometry_;  // of each body, in the numbering of all geometries
  std::vector<GeometryBounds> bounds_;
};

/// Collects bodies, allowed pairs and margins; build() makes the pairs.
class SceneBuilder {
 public:
  SceneBuilder() = default;
  /// Begins with the bodies of `base` and, among them, with its pairs, but for their margins: a
  /// robot is prepared once, and worlds are added. What is known of its geometries is not computed
  /// again. O(bodies + pairs of base).
  explicit SceneBuilder(const Scene& base) : base_(base) {}

  /// The new body's index.
  int add(Body body);
  void allow(int body_a, int body_b);    ///< the two may touch: no pair of theirs is kept
  void setDefaultMargin(double margin);  ///< [m]; default 0; may be negative (allowed depth)
  void setMargin(int body_a, int body_b, double margin);  ///< [m]; the last call for a pair counts
  /// All pairs with a moving body that are not allowed, each with its margin. Throws
  /// std::invalid_argument for a margin or a pose that is not finite, for a rotation that is not
  /// orthogonal within kRotationTolerance, and for two half-spaces, naming their bodies.
  /// O(bodies + pairs + allowed + margins).
  Scene build() const& { return SceneBuilder(*this).build(); }
  Scene build() &&;

 private:
  Scene base_;                // what build() begins with
  std::vector<Body> bodies_;  // added to those
  std::vector<std::pair<int, int>> allowed_;
  struct PairMargin {
    int a, b;
    double margin;
  };
  std::vector<PairMargin> margins_;
  double default_margin_ = 0;
};

/// What one thread changes while it queries a Scene: poses of moving bodies, a cache per pair,
/// scratch memory, statistics. For that scene only, and those with the same bodies and pairs.
class Workspace {
 public:
  explicit Workspace(const Scene& scene);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  /// Places a moving body. (A body that stands still is where the scene has it.)
  void setPose(int body, const Pose& X_WB);
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
/// not free: `clearance` is what is known by then. Never throws or allocates. O(pairs) queries.
SceneResult decide(const Scene& scene, Workspace& workspace);

/// The clearance to within `tolerance` [m], with the closest pair and its witness points, and the
/// verdict of all pairs. Never throws or allocates. O(pairs log pairs).
SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance);

/// The distance of one pair, in world coordinates, as the workspace places its bodies; widened by
/// the workspace's pose_error. Never throws or allocates.
DistanceResult pairDistance(const Scene& scene, Workspace& workspace, int pair,
                            const DistanceRequest& request);

}  // namespace leeway::collision
