#include "collision/deform/query/point_in_snapshot.h"

#include <array>
#include <cmath>

#include "collision/base/scratch.h"
#include "collision/base/tolerances.h"
#include "collision/mesh/winding.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

bool boxesMeet(const WideBox& box, int column, const Vector3d& low, const Vector3d& high) {
  for (int k = 0; k < 3; ++k) {
    if (!(static_cast<double>(box.low[k][column]) <= high[k] &&
          low[k] <= static_cast<double>(box.high[k][column])))
      return false;
  }
  return true;
}

// Counts crossings of the segment from p to q with a component, with their signs. False if one
// cannot be counted (Crossing::kIrregular).
bool windingNumber(const DeformableSnapshotImpl& snapshot, const BoxSource& boxes, int component,
                   const Vector3d& p, const Vector3d& q, Winding& winding) {
  const DeformTree& tree = *snapshot.tree;
  const Vector3d low = p.cwiseMin(q), high = p.cwiseMax(q);
  std::array<int, (kWidth - 1) * DeformTree::kMaxDepth + kWidth> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  WideBox room;
  while (size > 0) {
    const int id = stack[--size];
    if (!DeformTree::isLeaf(id)) {
      const WideBox& box = boxes.boxes(id, room);
      const DeformTree::Node& node = tree.node(id);
      for (int column = 0; column < kWidth && node.child[column] != DeformTree::kNone; ++column) {
        if (boxesMeet(box, column, low, high)) stack[size++] = node.child[column];
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
      winding.add(c, snapshot.mesh->windingWeight(tree.triangleOf(slot)));
    }
  }
  return true;
}

}  // namespace

Side sideOf(const DeformableSnapshotImpl& snapshot, int component, const Vector3d& point,
            Scratch& scratch) {
  const BoxSource boxes(snapshot, scratch.impl().deform);
  return sideByWinding(snapshot.low, snapshot.high, point,
                       [&](const Vector3d& q, Winding& winding) {
                         return windingNumber(snapshot, boxes, component, point, q, winding);
                       });
}

}  // namespace leeway::collision
