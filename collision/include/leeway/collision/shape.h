#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "leeway/collision/invalid_shape.h"

namespace leeway::collision {

class ConvexHull;          // convex_hull.h
class DeformableSnapshot;  // deformable_mesh.h
class TriangleMesh;        // triangle_mesh.h

enum class ShapeType : unsigned char {
  kSphere,
  kCapsule,
  kBox,
  kCylinder,
  kCone,
  kEllipsoid,
  kHalfSpace,
  kConvexHull,
  kMesh,
  kDeformable,
};

/// "sphere", "capsule", ...: the name used in files and messages.
const char* toString(ShapeType type);

/// A body in its own frame G: immutable, cheap to copy (vertices are shared). Sizes may be 0: a
/// sphere of radius 0 is a point, a box with one half extent of 0 is a rectangle. The largest size
/// is 0 or from 1e-9 to 1e9 m; otherwise the factories throw InvalidShape.
class Shape {
 public:
  /// Centre at the origin. radius >= 0 [m].
  static Shape sphere(double radius);
  /// All points within `radius` of the segment from -half_length to +half_length on z [m].
  static Shape capsule(double radius, double half_length);
  /// |x| <= half_extents, per coordinate [m].
  static Shape box(const Eigen::Vector3d& half_extents);
  /// Axis z, centre at the origin [m].
  static Shape cylinder(double radius, double half_length);
  /// Axis z, base disc of `radius` at z = -half_length, apex at z = +half_length [m].
  static Shape cone(double radius, double half_length);
  /// (x/a)^2 + (y/b)^2 + (z/c)^2 <= 1 [m].
  static Shape ellipsoid(const Eigen::Vector3d& semi_axes);
  /// All points with z <= 0. Unbounded.
  static Shape halfSpace();
  /// The convex hull of one or more `vertices` [m]; duplicates and flat sets are allowed. Same cost
  /// as ConvexHull::compute().
  static Shape convexHull(std::span<const Eigen::Vector3d> vertices);
  static Shape convexHull(std::shared_ptr<const ConvexHull> hull);
  /// A triangle mesh; its closed components are solids.
  static Shape mesh(std::shared_ptr<const TriangleMesh> mesh);
  /// A deforming mesh at one time; its closed components are solids. O(1), so make a new shape for
  /// every snapshot.
  static Shape deformable(std::shared_ptr<const DeformableSnapshot> snapshot);

  ShapeType type() const { return type_; }
  /// True for all types except kMesh and kDeformable.
  bool isConvex() const { return type_ != ShapeType::kMesh && type_ != ShapeType::kDeformable; }
  double radius() const { return radius_; }           // sphere, capsule, cylinder, cone
  double halfLength() const { return half_length_; }  // capsule, cylinder, cone
  const Eigen::Vector3d& halfExtents() const { return half_extents_; }  // box; ellipsoid: semi-axes
  /// The hull of a kConvexHull, the mesh of a kMesh, the snapshot of a kDeformable; null for every
  /// other type. They live as long as any copy of this shape.
  const ConvexHull* hull() const { return hull_.get(); }
  const TriangleMesh* mesh() const { return mesh_.get(); }
  const DeformableSnapshot* deformable() const { return deformable_.get(); }

  /// Centre [m, frame G] and radius [m] of a sphere that contains the whole shape, rounded
  /// outwards; the radius is infinite for a half-space.
  const Eigen::Vector3d& boundingCenter() const { return bounding_center_; }
  double boundingRadius() const { return bounding_radius_; }
  /// No point of the shape is farther from the origin of G than this [m]; infinite for a
  /// half-space.
  double extent() const { return extent_; }
  /// The shape's contribution to defaultTolerance() (distance.h) [m]; 0 for a half-space.
  double defaultTolerance() const { return default_tolerance_; }

 private:
  Shape() = default;
  void setReach(double bounding_radius, double extent);
  ShapeType type_ = ShapeType::kSphere;
  double radius_ = 0;
  double half_length_ = 0;
  Eigen::Vector3d half_extents_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d bounding_center_ = Eigen::Vector3d::Zero();
  double bounding_radius_ = 0;
  double extent_ = 0;
  double default_tolerance_ = 0;
  std::shared_ptr<const ConvexHull> hull_;
  std::shared_ptr<const TriangleMesh> mesh_;
  std::shared_ptr<const DeformableSnapshot> deformable_;
};

}  // namespace leeway::collision
