#pragma once

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

/// A rigid thing with one pose. A body that does not move has its pose here; a moving one has it in the Workspace.
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

class SceneBuilder;

/// What must not touch what: constant while it is queried. Static-static pairs are never kept.
class Scene {
 public:
  std::span<const Body> bodies() const { return bodies_; }
  std::span<const ScenePair> pairs() const { return pairs_; }
  /// Index of the body with that name, -1 when there is none. O(bodies).
  int find(const std::string& name) const;

 private:
  friend class SceneBuilder;
  std::vector<Body> bodies_;
  std::vector<ScenePair> pairs_;
};

/// Collects bodies, allowed pairs and margins; build() makes the pairs.
class SceneBuilder {
 public:
  int add(Body body);                             ///< the new body's index
  void allow(int body_a, int body_b);             ///< that pair may touch and is left out
  void setDefaultMargin(double margin);           ///< [m]; default 0; may be negative (allowed depth)
  void setMargin(int body_a, int body_b, double margin);
  Scene build() const;

 private:
  std::vector<Body> bodies_;
  std::vector<std::pair<int, int>> allowed_;
  struct PairMargin { int a, b; double margin; };
  std::vector<PairMargin> margins_;
  double default_margin_ = 0;
};

/// Everything that one thread changes while it asks: poses of moving bodies, caches per pair, scratch, statistics.
class Workspace {
 public:
  explicit Workspace(const Scene& scene);
  void setPose(int body, const Pose& X_WB);
  const Pose& pose(int body) const;

  struct Statistics {
    std::uint64_t queries = 0, pairs = 0, coarse_decided = 0, exact = 0, iterations = 0;
  };
  Statistics statistics;

  // For the functions below and for edge certification; see scene.cc.
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

enum class Verdict : unsigned char { kFree, kNotFree, kUndecided };

struct SceneResult {
  Verdict verdict = Verdict::kUndecided;  ///< against the margins; undecided is never free
  Interval clearance;   ///< minimum over the pairs of the signed separation; (inf, inf) when there is no pair
  int pair = -1;        ///< the pair that carries the upper end
  DistanceResult closest;  ///< its result, in world coordinates
};

/// Decides every pair against its margin; stops at the first that is not free. Coarse bounds first. Clearance is
/// what is known at the stop.
SceneResult decide(const Scene& scene, Workspace& workspace);

/// The clearance to within `tolerance` [m], with the closest pair and its witness points. Verdict as decide().
SceneResult clearance(const Scene& scene, Workspace& workspace, double tolerance);

}  // namespace leeway::collision
