#pragma once

#include <fcl/fcl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "leeway/collision/pose.h"
#include "leeway/collision/shape.h"
#include "tools/lab/dense/dense_world.h"
#include "tools/lab/fcl/fcl_shape.h"

namespace leeway::dense {

using lab::FclGeometry;
using lab::FclSurface;
using lab::isometry;
using lab::toFcl;

/// Bounding volumes of a shape: FCL's hierarchy over a mesh, one box around anything else.
struct DenseWorld::Bounds {
  /// A box in the shape's frame and, for part of a mesh, FCL's rectangle swept sphere (rss).
  /// `reach`: largest distance from the link's origin [m]. Children are adjacent; -1: none.
  struct Node {
    Eigen::Vector3d center, half_extents;
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    double radius = 0, reach = 0;
    int child = -1, triangle = -1;
    const fcl::RSSd* rss = nullptr;
  };
  std::shared_ptr<const FclSurface> mesh;
  std::vector<Node> nodes;

  Bounds(const FclGeometry& geometry, const Eigen::Isometry3d& X_LG)
      : mesh(std::dynamic_pointer_cast<const FclSurface>(geometry)) {
    if (mesh != nullptr) {
      for (int i = 0; i < mesh->getNumBVs(); ++i) {
        const fcl::BVNode<fcl::OBBRSSd>& node = mesh->getBV(i);
        add(node.bv.obb.To, node.bv.obb.extent, X_LG);
        nodes.back().axes = node.bv.obb.axis;
        if (node.isLeaf())
          nodes.back().triangle = node.primitiveId();
        else
          nodes.back().child = node.leftChild();
        nodes.back().rss = &node.bv.rss;
      }
      return;
    }
    geometry->computeLocalAABB();
    add(geometry->aabb_local.center(),
        0.5 * (geometry->aabb_local.max_ - geometry->aabb_local.min_), X_LG);
  }
  void add(const Eigen::Vector3d& center, const Eigen::Vector3d& half_extents,
           const Eigen::Isometry3d& X_LG) {
    nodes.emplace_back();
    nodes.back().center = center;
    nodes.back().half_extents = half_extents;
    nodes.back().radius = half_extents.norm();
    nodes.back().reach = (X_LG * center).norm() + nodes.back().radius;
  }
  /// The corners of a node's triangle.
  std::array<Eigen::Vector3d, 3> corners(const Node& leaf) const {
    const fcl::Triangle& t = mesh->tri_indices[leaf.triangle];
    return {mesh->vertices[t[0]], mesh->vertices[t[1]], mesh->vertices[t[2]]};
  }
  /// Lower bound of the distance between two nodes' contents [m]; meaningless below 0.
  static double gap(const Node& a, const Node& b, const Eigen::Isometry3d& X_AB) {
    const Eigen::Vector3d to_b = X_AB * b.center - a.center;
    const double balls = to_b.norm() - a.radius - b.radius;
    if (balls > a.radius + b.radius) return balls;  // bounding spheres suffice
    if (a.rss != nullptr && b.rss != nullptr)
      return std::max(balls, fcl::distance(fcl::Matrix3d(X_AB.linear()),
                                           fcl::Vector3d(X_AB.translation()), *a.rss, *b.rss));
    // Half extents of an axis-parallel (in A) box around b.
    const Eigen::Vector3d around =
        (a.axes.transpose() * (X_AB.linear() * b.axes)).cwiseAbs() * b.half_extents;
    const Eigen::Vector3d apart = (a.axes.transpose() * to_b).cwiseAbs() - a.half_extents - around;
    return std::max(balls, apart.cwiseMax(0).norm());
  }
};

struct DenseWorld::Body {
  std::string name;
  int link = -1;  // -1: the world
  std::vector<Eigen::Isometry3d> X_LG;
  std::vector<FclGeometry> geometries;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  std::vector<std::shared_ptr<const Bounds>> bounds;
  std::vector<collision::Shape> shapes;
  std::vector<collision::Pose> X_WG;

  void add(const collision::Shape& shape, const Eigen::Isometry3d& X) {
    const FclGeometry geometry = toFcl(shape);
    add(shape, X, geometry, std::make_shared<const Bounds>(geometry, X));
  }
  void add(const collision::Shape& shape, const Eigen::Isometry3d& X, const FclGeometry& geometry,
           std::shared_ptr<const Bounds> of_shape) {
    shapes.push_back(shape);
    geometries.push_back(geometry);
    bounds.push_back(std::move(of_shape));
    X_WG.push_back({X.linear(), X.translation()});
    X_LG.push_back(X);
    objects.push_back(std::make_unique<fcl::CollisionObjectd>(geometry, X));
    objects.back()->computeAABB();
  }
};

}  // namespace leeway::dense
