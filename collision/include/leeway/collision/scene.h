#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
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

/// A rigid thing with one pose. A body that does not move has its pose here; a moving one has it in
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

struct GeometryBounds;  // private to the library: cheap bounds of one geometry
class SceneBuilder;

/// What must not touch what: constant while it is queried. Static-static pairs are never kept.
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

  /// Geometries of all bodies are numbered through: the number of one of them.
  int geometryIndex(int body, int geometry) const {
    return first_geometry_[static_cast<std::size_t>(body)] + geometry;
  }
  const GeometryBounds& bounds(int geometry_index) const;
  std::size_t bytes() const;  ///< of the bounds and pairs; shared meshes are not counted

  /// Another shape for one geometry: the next snapshot of a deforming obstacle. Nobody may query
  /// the scene meanwhile; pairs and margins stay. O(1) for a snapshot.
  void setShape(int body, int geometry, const Shape& shape);

  /// Every pair must keep at least this margin [m] from now on; what it had beyond stays.
  void raiseMargins(double margin) {
    for (ScenePair& pair : pairs_) pair.margin = std::max(pair.margin, margin);
  }

  /// Every pair of that geometry must keep `growth` >= 0 [m] from now on besides its margin, and
  /// none less than that, since depth does not change slowly with a mesh's vertices. A growth of 0
  /// leaves margins as they are; with NaN such a pair is never free.
  void growMargins(int body, int geometry, double growth);

  /// Leaves out all pairs but those of which keep(pair) is true.
  void keepPairs(const std::function<bool(const ScenePair&)>& keep) {
    std::erase_if(pairs_, [&](const ScenePair& pair) { return !keep(pair); });
  }

 private:
  friend class SceneBuilder;
  std::vector<Body> bodies_;
  std::vector<ScenePair> pairs_;
  std::vector<int> first_geometry_;  // one a body
  std::vector<GeometryBounds> bounds_;
};

/// Collects bodies, allowed pairs and margins; build() makes the pairs.
class SceneBuilder {
 public:
  int add(Body body);                    ///< the new body's index
  void allow(int body_a, int body_b);    ///< that pair may touch and is left out
  void setDefaultMargin(double margin);  ///< [m]; default 0; may be negative (allowed depth)
  void setMargin(int body_a, int body_b, double margin);
  /// All pairs with a moving body that are not allowed, each with the margin said last. Throws
  /// std::invalid_argument for a margin or a pose that is not finite, for a rotation that is not
  /// orthogonal within kRotationTolerance, and for two half-spaces, by the names of their bodies.
  /// O(bodies (bodies + allowed) + pairs margins).
  Scene build() const;

 private:
  std::vector<Body> bodies_;
  std::vector<std::pair<int, int>> allowed_;
  struct PairMargin {
    int a, b;
    double margin;
  };
  std::vector<PairMargin> margins_;
  double default_margin_ = 0;
};

/// Everything that one thread changes while it asks: poses of moving bodies, caches per pair,
/// scratch, statistics.
class Workspace {
 public:
  explicit Workspace(const Scene& scene);
  /// Places a moving body; a body that does not move stays where the scene has it.
  void setPose(int body, const Pose& X_WB);
  const Pose& pose(int body) const;
  /// Makes room for what queries of the scene's deforming shapes fill on demand (see prepare() in
  /// deformable_mesh.h). The constructor does it; call it when a snapshot may have more nodes than
  /// before (strategies that rebuild need no room). May allocate.
  void prepare(const Scene& scene);

  /// How far any point of a moving body may be from where its pose has it [m]: widens every
  /// interval.
  double pose_error = 0;

  struct Statistics {
    std::uint64_t queries = 0, pairs = 0, coarse_decided = 0, exact = 0, iterations = 0;
  };
  Statistics statistics;

  // For the functions below and for edge certification.
  struct Impl;
  Impl& impl() { return *impl_; }
  Scratch& scratch();
  PairCache& cache(int pair);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

 private:
  std::unique_ptr<Impl> impl_;
};

/// What is known of pairs and their margins. Whoever must be safe takes kUndecided for kNotFree.
enum class Verdict : unsigned char {
  kFree,       ///< every pair is proven to keep more than its margin
  kNotFree,    ///< some pair is proven not to
  kUndecided,  ///< a limit or rounding left it open
};

/// The answer of decide() and clearance().
struct SceneResult {
  Verdict verdict = Verdict::kUndecided;  ///< against the margins; undecided is never free
  Interval clearance;      ///< minimum over the pairs of the signed separation [m]; (inf, inf) when
                           ///< there is no pair
  int pair = -1;           ///< the pair that carries the upper end
  DistanceResult closest;  ///< its result, in world coordinates
};

/// Decides every pair against its margin; stops at the first that is not free. Coarse bounds first.
/// Clearance is what is known at the stop. Never throws or allocates. O(pairs).
SceneResult decide(const Scene& scene, Workspace& workspace);

/// The clearance to within `tolerance` [m], with the closest pair and its witness points. Verdict
/// as decide(). Never throws or allocates. O(pairs log pairs).
SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance);

/// The distance of one pair of the scene as the workspace has its bodies placed, in world
/// coordinates, widened by the workspace's pose_error. Never throws or allocates.
DistanceResult pairDistance(const Scene& scene, Workspace& workspace, int pair,
                            const DistanceRequest& request);

/// A lower bound on the separation of one pair [m], as the workspace has its bodies placed, from
/// balls and stand-ins alone. Never throws or allocates. O(1).
double coarseLowerBound(const Scene& scene, const Workspace& workspace, int pair);

}  // namespace leeway::collision
