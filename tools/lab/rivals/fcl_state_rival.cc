#include "tools/lab/rivals/fcl_state_rival.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/config.h>
#if FCL_HAVE_OCTOMAP
#include <fcl/geometry/octree/octree.h>
#endif
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_set>
#include <utility>
#include <vector>

#include "leeway/collision/convex_hull.h"
#include "leeway/collision/triangle_mesh.h"
#include "tools/lab/rivals/fcl_shape_rival.h"

namespace leeway::tools::report {
namespace {

using collision::Shape;
using collision::ShapeType;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

Geometry makeGeometry(const Shape& shape) {
  if (shape.type() != ShapeType::kConvexHull) return lab::toFcl(shape);
  const auto vertices = shape.hull()->vertices();
  return makeFclShape({shape, {vertices.begin(), vertices.end()}});
}

/// See makeFclStateEngine().
Geometry makeOctree(const std::vector<collision::Ball>& balls) {
#if FCL_HAVE_OCTOMAP
  double radius = std::numeric_limits<double>::infinity();
  for (const collision::Ball& ball : balls) radius = std::min(radius, ball.radius);
  const auto cells = std::make_shared<octomap::OcTree>(2 * radius / std::sqrt(3.0));
  for (const collision::Ball& ball : balls)
    cells->updateNode(ball.center.x(), ball.center.y(), ball.center.z(), true, true);
  cells->updateInnerOccupancy();
  return std::make_shared<fcl::OcTreed>(cells);
#else
  return nullptr;
#endif
}

/// Number of fixed bodies above which FCL's dynamic tree finds the near ones; fewer are faster to
/// test one by one.
constexpr std::size_t kTree = 64;

class FclChecker : public StateChecker {
 public:
  explicit FclChecker(const collision::Scene& scene) : scene_(scene) {
    std::vector<std::size_t> still;
    for (const collision::Body& body : scene.bodies()) {
      first_.push_back(parts_.size());
      for (const collision::Geometry& geometry : body.geometries) {
        parts_.push_back({makeGeometry(geometry.shape), fcl::Transform3d::Identity(),
                          Eigen::Vector3d::Zero(), geometry.shape.boundingRadius()});
        complete_ = complete_ && parts_.back().shape;
        // A half-space has no box.
        if (!body.moving && std::isfinite(parts_.back().radius)) still.push_back(parts_.size() - 1);
      }
      if (body.balls) addOctree(makeOctree(*body.balls), still);
      if (body.moving)
        moving_.push_back(first_.size() - 1);
      else
        place(first_.back(), body, body.X_WB);
    }
    if (complete_ && still.size() > kTree) makeTree(still);
    listPairs();
  }

  bool complete() const { return complete_; }

  bool isFree(std::span<const collision::Pose> X_WB) override {
    for (const std::size_t b : moving_) place(first_[b], scene_.bodies()[b], X_WB[b]);
    for (const auto& [a, b] : listed_)
      if (touch(a, b)) return false;
    for (const std::size_t i : asks_tree_) {
      fcl::CollisionObjectd object(parts_[i].shape, parts_[i].X_WG);
      Query query{this, i};
      tree_.collide(&object, &query, &FclChecker::meets);
      if (query.found) return false;
    }
    return true;
  }

  double distance(std::span<const collision::Pose> X_WB) override {
    for (const std::size_t b : moving_) place(first_[b], scene_.bodies()[b], X_WB[b]);
    double least = std::numeric_limits<double>::infinity();
    for (const collision::ScenePair& pair : scene_.pairs()) {
      const Part& a = parts_[partOf(pair.body_a, pair.geometry_a)];
      const Part& b = parts_[partOf(pair.body_b, pair.geometry_b)];
      // FCL has no distances of half-spaces, and cells are not the balls.
      if (!std::isfinite(a.radius + b.radius) || b.is_octree)
        return std::numeric_limits<double>::quiet_NaN();
      if ((a.p_WC - b.p_WC).norm() - a.radius - b.radius >= least) continue;
      fcl::DistanceResultd result;
      fcl::distance(a.shape.get(), a.X_WG, b.shape.get(), b.X_WG, distance_request_, result);
      least = std::min(least, result.min_distance);
    }
    return least;
  }

 private:
  struct Part {
    Geometry shape;
    fcl::Transform3d X_WG;
    Eigen::Vector3d p_WC;  ///< centre of the bounding sphere
    double radius;
    bool in_tree = false, is_octree = false;
  };
  struct Query {
    FclChecker* checker;
    std::size_t part;
    bool found = false;
  };

  /// All balls of a body are its last part.
  std::size_t partOf(int body, int geometry) const {
    const std::size_t stored = scene_.bodies()[static_cast<std::size_t>(body)].geometries.size();
    return first_[static_cast<std::size_t>(body)] +
           std::min(static_cast<std::size_t>(geometry), stored);
  }
  void addOctree(const Geometry& octree, std::vector<std::size_t>& still) {
    complete_ = complete_ && octree;
    if (!octree) return;
    octree->computeLocalAABB();
    still.push_back(parts_.size());
    parts_.push_back({octree, fcl::Transform3d::Identity(), Eigen::Vector3d::Zero(),
                      octree->aabb_radius, false, true});
  }
  std::size_t keyOf(std::size_t a, std::size_t b) const {
    return std::min(a, b) * parts_.size() + std::max(a, b);
  }

  void makeTree(const std::vector<std::size_t>& still) {
    objects_.reserve(still.size());
    std::vector<fcl::CollisionObjectd*> all;
    for (const std::size_t i : still) {
      parts_[i].in_tree = true;
      objects_.emplace_back(parts_[i].shape, parts_[i].X_WG);
      objects_.back().setUserData(&parts_[i]);  // null: not in the tree
      all.push_back(&objects_.back());
    }
    tree_.registerObjects(all);
    tree_.setup();
  }

  void listPairs() {
    std::set<std::size_t> asks;
    const collision::ScenePairs& pairs = scene_.pairs();
    for (std::size_t number = 0; number < pairs.numbers(); ++number) {
      if (!pairs.has(number)) continue;
      const collision::ScenePair pair = pairs[number];
      const std::size_t a = partOf(pair.body_a, pair.geometry_a);
      const std::size_t b = partOf(pair.body_b, pair.geometry_b);
      // A body's balls are one part, and their numbers follow each other.
      if (parts_[b].is_octree)
        number += scene_.bodies()[static_cast<std::size_t>(pair.body_b)].size() - 1 -
                  static_cast<std::size_t>(pair.geometry_b);
      if (!parts_[a].in_tree && !parts_[b].in_tree) {
        listed_.emplace_back(a, b);
        continue;
      }
      checked_.insert(keyOf(a, b));
      asks.insert(parts_[a].in_tree ? b : a);
    }
    asks_tree_.assign(asks.begin(), asks.end());
  }

  bool touch(std::size_t i, std::size_t k) {
    const Part &a = parts_[i], &b = parts_[k];
    const double reach = a.radius + b.radius;  // infinite for half-spaces
    if ((a.p_WC - b.p_WC).squaredNorm() > reach * reach) return false;
    fcl::CollisionResultd result;
    return fcl::collide(a.shape.get(), a.X_WG, b.shape.get(), b.X_WG, request_, result) > 0;
  }

  /// FCL's callback; true ends the query. One of the two objects is in the tree.
  static bool meets(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data) {
    Query& query = *static_cast<Query*>(data);
    const fcl::CollisionObjectd* still = a->getUserData() != nullptr ? a : b;
    FclChecker& checker = *query.checker;
    const auto part = static_cast<std::size_t>(static_cast<const Part*>(still->getUserData()) -
                                               checker.parts_.data());
    if (checker.checked_.count(checker.keyOf(query.part, part)) > 0)
      query.found = checker.touch(query.part, part);
    return query.found;
  }

  void place(std::size_t first, const collision::Body& body, const collision::Pose& X_WB) {
    for (std::size_t i = 0; i < body.geometries.size(); ++i) {
      const collision::Pose X_WG = X_WB * body.geometries[i].X_BG;
      parts_[first + i].X_WG = lab::isometry(X_WG);
      parts_[first + i].p_WC = X_WG * body.geometries[i].shape.boundingCenter();
    }
    if (!body.balls || !complete_) return;
    Part& octree = parts_[first + body.geometries.size()];
    octree.X_WG = lab::isometry(X_WB);
    octree.p_WC = X_WB * octree.shape->aabb_center;
  }

  const collision::Scene& scene_;
  std::vector<Part> parts_;
  std::vector<std::size_t> first_;   ///< first part of each body
  std::vector<std::size_t> moving_;  ///< bodies
  std::vector<std::pair<std::size_t, std::size_t>> listed_;
  fcl::DynamicAABBTreeCollisionManagerd tree_;
  std::vector<fcl::CollisionObjectd> objects_;  ///< those in the tree
  std::vector<std::size_t> asks_tree_;          ///< moving parts
  std::unordered_set<std::size_t> checked_;     ///< keys of pairs with the tree
  fcl::CollisionRequestd request_;
  fcl::DistanceRequestd distance_request_;
  bool complete_ = true;
};

class FclStateEngine : public StateEngine {
 public:
  const char* name() const override { return "FCL"; }
  std::unique_ptr<StateChecker> prepare(const collision::Scene& scene) const override {
    auto checker = std::make_unique<FclChecker>(scene);
    if (!checker->complete()) return nullptr;
    return checker;
  }
};

}  // namespace

std::unique_ptr<StateEngine> makeFclStateEngine() { return std::make_unique<FclStateEngine>(); }

}  // namespace leeway::tools::report
