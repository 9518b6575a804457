#pragma once

// The library's access to a Scene and a Workspace beyond their public interface.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "collision/lanes/obstacle_boxes.h"
#include "collision/scene/geometry_bounds.h"
#include "leeway/collision/scene.h"

namespace leeway::collision {

struct SceneAccess {
  /// The number of a geometry, in a consecutive numbering of the geometries of all bodies.
  static int geometryIndex(const Scene& scene, int body, int geometry) {
    const auto b = static_cast<std::size_t>(body), built = scene.things_->bodies.size();
    return (b < built ? scene.things_->first_geometry[b]
                      : scene.added_->first_geometry[b - built]) +
           geometry;
  }
  /// By geometryIndex(), in a scene without balls.
  static const GeometryBounds& bounds(const Scene& scene, int geometry_index) {
    const auto i = static_cast<std::size_t>(geometry_index), built = scene.things_->bounds.size();
    return i < built ? scene.things_->bounds[i] : scene.added_->bounds[i - built];
  }
  /// The bounds of a geometry that is not a ball.
  static const GeometryBounds& bounds(const Scene& scene, int body, int geometry) {
    const auto b = static_cast<std::size_t>(body), built = scene.things_->bodies.size();
    const Scene::Things& things = b < built ? *scene.things_ : *scene.added_;
    return things.bounds[things.first_bounds[b < built ? b : b - built] +
                         static_cast<std::size_t>(geometry)];
  }
  static SceneGeometry geometry(const Scene& scene, int body, int geometry) {
    const Body& of = scene.bodies()[static_cast<std::size_t>(body)];
    const auto number = static_cast<std::size_t>(geometry);
    if (number >= of.geometries.size()) return {of, number};
    return {of.geometries[number], bounds(scene, body, geometry)};
  }
  static std::size_t geometryCount(const Scene& scene) {
    return scene.things_->size + (scene.added_ ? scene.added_->size : 0);
  }
  /// Sets the pose of a moving body until a workspace moves it.
  static void place(Scene& scene, int body, const Pose& X_WB) {
    scene.own().bodies[static_cast<std::size_t>(body)].X_WB = X_WB;
  }
  /// Scene::raiseMargins() for pairs with a body from `first_body` on, which is no more than
  /// ScenePairs::firstStill().
  static void raiseMargins(Scene& scene, double margin, int first_body) {
    scene.pairs_.raise(margin, first_body);
  }
  /// Removes all pairs for which keep(pair) is false; keep() is called once for each pair, in their
  /// order. A geometry that keeps no pair with a place loses its row: a SceneChange adds no pairs
  /// for it.
  static void keepPairs(Scene& scene, const std::function<bool(const ScenePair&)>& keep) {
    scene.pairs_.keep(keep);
    if (scene.pairs_.rows().empty()) scene.still_ = {};
  }
  /// The boxes around fixed geometries, one for each place; null if there are no places.
  static const ObstacleBoxes* boxes(const Scene& scene) { return scene.still_.boxes.get(); }
  /// The geometry in a place.
  static SceneGeometry geometryIn(const Scene& scene, int place) {
    const auto of = scene.pairs_.geometryIn(static_cast<std::size_t>(place));
    return geometry(scene, of.body, of.geometry);
  }
  static const std::shared_ptr<const ObstacleBoxes>& sharedBoxes(const Scene& scene) {
    return scene.still_.boxes;
  }
  /// The places of the shapes for which LaneSweep::needsObstacle() is true, ascending. There must
  /// be places.
  static std::span<const std::int32_t> added(const Scene& scene) { return *scene.still_.added; }
  /// An upper bound, for every geometry in a place, on two numbers [m]: the sum of the coordinates
  /// of its pose's inverse and of its ball's centre, and LaneSweep::scaleOf().
  static double scaleOfStill(const Scene& scene) { return scene.still_.scale; }

  static Scratch& scratch(Workspace& workspace);
  static PairCache& cache(Workspace& workspace, int pair);
  static Workspace::Impl& impl(Workspace& workspace) { return *workspace.impl_; }
};

/// A lower bound on the separation of one pair [m], at the workspace's poses, from balls and coarse
/// shapes alone. Never throws or allocates. O(1).
double coarseLowerBound(const Scene& scene, const Workspace& workspace, int pair);

/// The box around the geometry of a row, at the workspace's pose, grown by `reach` [m]: fixed
/// geometries that do not intersect it are farther away than `reach`. NaN, which intersects
/// everything, if it is too large for a box or not finite.
ObstacleBoxes::Box boxOfRow(const Scene& scene, const Workspace& workspace, std::size_t row,
                            double reach);

/// Calls visit(pair) for the pairs of a row that may be closer than `reach` [m], in an order that
/// depends only on the scene, until it returns false. O(near + log of all) on average.
template <class Visit>
void forEachNearInRow(const Scene& scene, const Workspace& workspace, std::size_t row, double reach,
                      const Visit& visit) {
  if (scene.pairs().rows()[row].count == 0) return;
  const ObstacleBoxes& boxes = *SceneAccess::boxes(scene);
  boxes.forEachNear(boxOfRow(scene, workspace, row, reach), [&](std::size_t slot) {
    const std::int32_t place = boxes.obstacle(slot);
    const std::int32_t pair =
        place < 0 ? -1 : scene.pairs().numberOf(row, static_cast<std::size_t>(place));
    return pair < 0 || visit(static_cast<int>(pair));
  });
}

}  // namespace leeway::collision
