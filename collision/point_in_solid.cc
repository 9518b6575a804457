#include "collision/point_in_solid.h"

#include <array>
#include <cmath>

#include "collision/deform_snapshot.h"
#include "collision/exact.h"
#include "collision/mesh_tree.h"
#include "collision/scratch.h"
#include "leeway/collision/tolerances.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

enum class Crossing : signed char { kIn = -1, kNone = 0, kOut = 1, kIrregular = 2 };

// Whether the segment from p to a point q that is not on the triangle crosses it, and in which
// direction.
Crossing crossing(const Vector3d& p, const Vector3d& q, const Vector3d* v) {
  const int side_p = orientation(v[0], v[1], v[2], p), side_q = orientation(v[0], v[1], v[2], q);
  if (side_p == side_q && side_p != 0) return Crossing::kNone;
  if (side_p == 0 && side_q == 0) {
    // In the triangle's plane, or the triangle has no area and bounds nothing (its neighbours
    // tell).
    return collinear(v[0], v[1], v[2]) ? Crossing::kNone : Crossing::kIrregular;
  }
  int positive = 0, negative = 0;
  for (int k = 0; k < 3; ++k) {
    const int side = orientation(p, q, v[k], v[(k + 1) % 3]);
    positive += side > 0 ? 1 : 0;
    negative += side < 0 ? 1 : 0;
  }
  if (positive > 0 && negative > 0) return Crossing::kNone;
  if (positive + negative < 3) return Crossing::kIrregular;
  if (side_q == 0)
    return Crossing::kNone;  // q is not on the triangle, and the line meets its plane in q
  if (side_p == 0) return Crossing::kIrregular;  // p is on it
  return side_p < 0 ? Crossing::kOut : Crossing::kIn;
}

bool boxesMeet(const MeshNode& node, const Vector3d& low, const Vector3d& high) {
  return (node.low.array() <= high.array()).all() && (low.array() <= node.high.array()).all();
}

// The winding number by one segment that ends outside of the component; false when the segment is
// irregular.
bool windingNumber(const TriangleMesh& mesh, int component, const Vector3d& p, const Vector3d& q,
                   int& winding) {
  const MeshTree& tree = mesh.tree();
  const Vector3d low = p.cwiseMin(q), high = p.cwiseMax(q);
  std::array<int, 2 * MeshTree::kMaxDepth> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  winding = 0;
  while (size > 0) {
    const int id = stack[--size];
    const MeshNode& node = tree.node(id);
    if ((node.component >= 0 && node.component != component) || !boxesMeet(node, low, high))
      continue;
    if (!node.isLeaf()) {
      stack[size++] = node.right;
      stack[size++] = id + 1;
      continue;
    }
    for (int slot = node.triangle_begin; slot < node.triangle_end; ++slot) {
      if (mesh.component(tree.triangleOf(slot)) != component) continue;
      const Crossing c = crossing(p, q, tree.corners(slot));
      if (c == Crossing::kIrregular) return false;
      winding += static_cast<int>(c);
    }
  }
  return true;
}

bool boxesMeet(const WideBox& box, int lane, const Vector3d& low, const Vector3d& high) {
  for (int k = 0; k < 3; ++k) {
    if (!(static_cast<double>(box.low[k][lane]) <= high[k] &&
          low[k] <= static_cast<double>(box.high[k][lane])))
      return false;
  }
  return true;
}

bool windingNumber(const DeformableSnapshotImpl& snapshot, const BoxSource& boxes, int component,
                   const Vector3d& p, const Vector3d& q, int& winding) {
  const DeformTree& tree = *snapshot.tree;
  const Vector3d low = p.cwiseMin(q), high = p.cwiseMax(q);
  std::array<int, (kWidth - 1) * DeformTree::kMaxDepth + kWidth> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  winding = 0;
  WideBox room;
  while (size > 0) {
    const int id = stack[--size];
    if (!DeformTree::isLeaf(id)) {
      const WideBox& box = boxes.boxes(id, room);
      const DeformTree::Node& node = tree.node(id);
      for (int lane = 0; lane < kWidth && node.child[lane] != DeformTree::kNone; ++lane) {
        if (boxesMeet(box, lane, low, high)) stack[size++] = node.child[lane];
      }
      continue;
    }
    const DeformTree::Leaf& leaf = tree.leaf(DeformTree::leafOf(id));
    for (int slot = leaf.slot_begin; slot < leaf.slot_end; ++slot) {
      if (snapshot.mesh->component(tree.triangleOf(slot)) != component) continue;
      Vector3d corners[3];
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = snapshot.vertices[static_cast<std::size_t>(tree.corners(slot)[k])];
        for (Eigen::Index i = 0; i < 3; ++i) {
          if (std::abs(corners[k][i]) < kSmallestExact) corners[k][i] = 0;
        }
      }
      const Crossing c = crossing(p, q, corners);
      if (c == Crossing::kIrregular) return false;
      winding += static_cast<int>(c);
    }
  }
  return true;
}

// `winding_number(q, winding)` is asked for segments from the point to places q outside of the box.
template <class WindingNumber>
Side sideOf(const Vector3d& low, const Vector3d& high, const Vector3d& point,
            const WindingNumber& winding_number) {
  if (!((low.array() <= point.array()).all() && (point.array() <= high.array()).all()))
    return Side::kOutside;
  Vector3d p = point;
  for (int k = 0; k < 3; ++k) {
    if (p[k] != 0 && std::abs(p[k]) < kSmallestExact)
      return Side::kUnknown;  // the predicates would not be exact
  }
  const Vector3d size = high - low;
  const double tilt = kSegmentTilt * size.maxCoeff();
  // Segments nearly along an axis have thin boxes and so meet few nodes. The way out that is
  // shortest comes first.
  for (int attempt = 0; attempt < 4; ++attempt) {
    std::array<bool, 6> tried{};
    for (int turn = 0; turn < 6; ++turn) {
      int best = -1;
      double shortest = 0;
      for (int way = 0; way < 6; ++way) {
        if (tried[static_cast<std::size_t>(way)]) continue;
        const int axis = way / 2;
        const double length = way % 2 == 0 ? high[axis] - p[axis] : p[axis] - low[axis];
        if (best >= 0 && length >= shortest) continue;
        best = way;
        shortest = length;
      }
      tried[static_cast<std::size_t>(best)] = true;
      const int axis = best / 2;
      Vector3d q = p;
      q[axis] = best % 2 == 0 ? high[axis] + tilt : low[axis] - tilt;
      q[(axis + 1) % 3] += tilt * (0.37 + attempt);
      q[(axis + 2) % 3] += tilt * (0.71 + attempt * attempt);
      int winding = 0;
      if (winding_number(q, winding)) return winding != 0 ? Side::kInside : Side::kOutside;
    }
  }
  return Side::kUnknown;
}

}  // namespace

Side sideOf(const TriangleMesh& mesh, int component, const Vector3d& point) {
  const MeshTree::Component& c = mesh.tree().components()[static_cast<std::size_t>(component)];
  return sideOf(c.low, c.high, point, [&](const Vector3d& q, int& winding) {
    return windingNumber(mesh, component, point, q, winding);
  });
}

Side sideOf(const DeformableSnapshotImpl& snapshot, int component, const Vector3d& point,
            Scratch& scratch) {
  const BoxSource boxes(snapshot, scratch.impl().deform);
  return sideOf(snapshot.low, snapshot.high, point, [&](const Vector3d& q, int& winding) {
    return windingNumber(snapshot, boxes, component, point, q, winding);
  });
}

}  // namespace leeway::collision
