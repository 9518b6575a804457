#pragma once

// Private to collision/: patches of a mesh's surface, for the search for convex pieces.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "collision/base/vector.h"
#include "collision/mesh/mesh_tree.h"
#include "leeway/collision/triangle_mesh.h"

namespace leeway::collision {

/// A mesh with the planes of its triangles.
class Surface {
 public:
  explicit Surface(const TriangleMesh& mesh) : mesh_(mesh) {
    for (const TriangleMesh::Triangle& t : mesh.triangles()) {
      const Vector &a = vertex(t[0]), &b = vertex(t[1]), &c = vertex(t[2]);
      const Vector normal = cross(b - a, c - a);
      const double length = normal.norm();
      // A sliver's normal is arbitrary, but the planes through it are still valid.
      normal_.push_back(length > 0 ? Vector(normal / length) : Vector::UnitX());
      offset_.push_back(normal_.back().dot(a));
    }
  }

  const TriangleMesh& mesh() const { return mesh_; }
  const MeshTree& tree() const { return mesh_.tree(); }
  std::int32_t triangleCount() const { return static_cast<std::int32_t>(normal_.size()); }
  const Vector& vertex(std::int32_t v) const {
    return mesh_.vertices()[static_cast<std::size_t>(v)];
  }
  const TriangleMesh::Triangle& corners(std::int32_t t) const {
    return mesh_.triangles()[static_cast<std::size_t>(t)];
  }
  bool isInClosedComponent(std::int32_t t) const { return mesh_.isClosed(mesh_.component(t)); }
  /// The plane of a triangle: normal(t) . x = offset(t), with a unit normal, outwards.
  const Vector& normal(std::int32_t t) const { return normal_[static_cast<std::size_t>(t)]; }
  double offset(std::int32_t t) const { return offset_[static_cast<std::size_t>(t)]; }

 private:
  const TriangleMesh& mesh_;
  std::vector<Vector> normal_;
  std::vector<double> offset_;
};

/// A set of numbers below `size`, emptied in O(1).
class Marks {
 public:
  explicit Marks(std::size_t size) : stamp_(size, 0) {}
  void clear() { ++now_; }
  bool has(std::int32_t i) const { return stamp_[static_cast<std::size_t>(i)] == now_; }
  void remove(std::int32_t i) { stamp_[static_cast<std::size_t>(i)] = now_ - 1; }
  void add(std::int32_t i) { stamp_[static_cast<std::size_t>(i)] = now_; }

 private:
  std::vector<std::int32_t> stamp_;
  std::int32_t now_ = 1;
};

/// Counts of marked slots in a range, in O(log n): a Fenwick tree.
class SlotCount {
 public:
  explicit SlotCount(std::size_t slots) : sum_(slots + 1, 0) {}
  void add(std::int32_t slot, std::int32_t change) {
    for (std::size_t i = static_cast<std::size_t>(slot) + 1; i < sum_.size(); i += i & (~i + 1))
      sum_[i] += change;
  }
  std::int32_t in(std::int32_t begin, std::int32_t end) const { return upTo(end) - upTo(begin); }

 private:
  std::int32_t upTo(std::int32_t end) const {
    std::int32_t sum = 0;
    for (std::size_t i = static_cast<std::size_t>(end); i > 0; i -= i & (~i + 1)) sum += sum_[i];
    return sum;
  }
  std::vector<std::int32_t> sum_;
};

/// Numbered vectors (planes, or points), stored as columns.
class Columns {
 public:
  void clear() {
    for (auto& column : column_) column.clear();
  }
  void push(const Vector& v, double offset) {
    for (Eigen::Index k = 0; k < 3; ++k) column_[static_cast<std::size_t>(k)].push_back(v[k]);
    column_[3].push_back(offset);
  }
  void pop() {
    for (auto& column : column_) column.pop_back();
  }
  std::size_t size() const { return column_[3].size(); }
  /// Whether v . w - offset > limit for any of them.
  bool above(const Vector& w, double limit) const {
    const double wx = w.x(), wy = w.y(), wz = w.z();
    const double *x = column_[0].data(), *y = column_[1].data(), *z = column_[2].data(),
                 *d = column_[3].data();
    constexpr std::size_t kBlock = 256;
    for (std::size_t begin = 0; begin < size(); begin += kBlock) {
      const std::size_t end = std::min(begin + kBlock, size());
      std::int64_t count = 0;
      for (std::size_t i = begin; i < end; ++i) {
        count += x[i] * wx + y[i] * wy + z[i] * wz - d[i] > limit ? 1 : 0;
      }
      if (count > 0) return true;
    }
    return false;
  }

 private:
  std::array<std::vector<double>, 4> column_;
};

/// A set of triangles of one component that grows and shrinks at its end.
class SurfacePatch {
 public:
  explicit SurfacePatch(const Surface& surface)
      : surface_(surface),
        marks_(surface.mesh().triangles().size()),
        slots_(surface.mesh().triangles().size()) {}

  void clear() {
    for (const std::int32_t t : triangles_) slots_.add(surface_.tree().slotOf(t), -1);
    triangles_.clear();
    marks_.clear();
    planes_.clear();
    points_.clear();
  }
  void add(std::int32_t t) {
    triangles_.push_back(t);
    marks_.add(t);
    slots_.add(surface_.tree().slotOf(t), 1);
    planes_.push(surface_.normal(t), surface_.offset(t));
    for (const std::int32_t v : surface_.corners(t)) points_.push(surface_.vertex(v), 0);
  }
  void removeLast() {
    const std::int32_t t = triangles_.back();
    triangles_.pop_back();
    marks_.remove(t);
    slots_.add(surface_.tree().slotOf(t), -1);
    planes_.pop();
    for (int k = 0; k < 3; ++k) points_.pop();
  }

  std::size_t size() const { return triangles_.size(); }
  const std::vector<std::int32_t>& triangles() const { return triangles_; }
  bool has(std::int32_t t) const { return marks_.has(t); }
  /// Whether all triangles of a node are in the patch.
  bool holds(const MeshNode& node) const {
    return slots_.in(node.triangle_begin, node.triangle_end) ==
           node.triangle_end - node.triangle_begin;
  }
  const Columns& planes() const { return planes_; }  ///< of the triangles
  const Columns& points() const { return points_; }  ///< their corners

 private:
  const Surface& surface_;
  std::vector<std::int32_t> triangles_;
  Marks marks_;
  SlotCount slots_;
  Columns planes_, points_;
};

}  // namespace leeway::collision
