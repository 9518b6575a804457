#pragma once

// What the library itself reads of a Scene and a Workspace besides their public interface.

#include <cstddef>
#include <functional>

#include "collision/scene/geometry_bounds.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

struct SceneAccess {
  /// Geometries of all bodies are numbered through: the number of one of them.
  static int geometryIndex(const Scene& scene, int body, int geometry) {
    return scene.first_geometry_[static_cast<std::size_t>(body)] + geometry;
  }
  static const GeometryBounds& bounds(const Scene& scene, int geometry_index) {
    return scene.bounds_[static_cast<std::size_t>(geometry_index)];
  }
  /// Where a moving body stands until a workspace moves it.
  static void place(Scene& scene, int body, const Pose& X_WB) {
    scene.bodies_[static_cast<std::size_t>(body)].X_WB = X_WB;
  }
  /// Scene::raiseMargins() for some pairs.
  static void raiseMargins(Scene& scene, double margin,
                           const std::function<bool(const ScenePair&)>& raises) {
    for (ScenePair& pair : scene.pairs_)
      if (raises(pair) && pair.margin < margin) pair.margin = margin;
  }
  /// Removes all pairs but those of which keep(pair) is true; asks each once, in their order.
  static void keepPairs(Scene& scene, const std::function<bool(const ScenePair&)>& keep) {
    std::erase_if(scene.pairs_, [&](const ScenePair& pair) { return !keep(pair); });
  }

  static Scratch& scratch(Workspace& workspace);
  static PairCache& cache(Workspace& workspace, int pair);
  static Workspace::Impl& impl(Workspace& workspace) { return *workspace.impl_; }
};

/// A lower bound on the separation of one pair [m], as the workspace places its bodies, from balls
/// and stand-ins alone. Never throws or allocates. O(1).
double coarseLowerBound(const Scene& scene, const Workspace& workspace, int pair);

}  // namespace leeway::collision
