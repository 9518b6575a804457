#include "collision/point_in_solid.h"

#include <array>

#include "collision/exact.h"
#include "collision/mesh_tree.h"
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

}  // namespace

Side sideOf(const TriangleMesh& mesh, int component, const Vector3d& point) {
  const MeshTree::Component& c = mesh.tree().components()[static_cast<std::size_t>(component)];
  if (!((c.low.array() <= point.array()).all() && (point.array() <= c.high.array()).all()))
    return Side::kOutside;
  Vector3d p = point;
  for (int k = 0; k < 3; ++k) {
    if (p[k] != 0 && std::abs(p[k]) < kSmallestExact)
      return Side::kUnknown;  // the predicates would not be exact
  }
  const Vector3d size = c.high - c.low;
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
        const double length = way % 2 == 0 ? c.high[axis] - p[axis] : p[axis] - c.low[axis];
        if (best >= 0 && length >= shortest) continue;
        best = way;
        shortest = length;
      }
      tried[static_cast<std::size_t>(best)] = true;
      const int axis = best / 2;
      Vector3d q = p;
      q[axis] = best % 2 == 0 ? c.high[axis] + tilt : c.low[axis] - tilt;
      q[(axis + 1) % 3] += tilt * (0.37 + attempt);
      q[(axis + 2) % 3] += tilt * (0.71 + attempt * attempt);
      int winding = 0;
      if (windingNumber(mesh, component, p, q, winding))
        return winding != 0 ? Side::kInside : Side::kOutside;
    }
  }
  return Side::kUnknown;
}

}  // namespace leeway::collision
