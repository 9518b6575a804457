#include "collision/mesh/point_in_solid.h"

#include <array>

#include "collision/mesh/mesh_tree.h"
#include "collision/mesh/winding.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

bool boxesMeet(const MeshNode& node, const Vector3d& low, const Vector3d& high) {
  return (node.low.array() <= high.array()).all() && (low.array() <= node.high.array()).all();
}

// The winding number around p from the crossings of a segment to q, outside the component; false if
// one of them is irregular.
bool windingNumber(const TriangleMesh& mesh, int component, const Vector3d& p, const Vector3d& q,
                   Winding& winding) {
  const MeshTree& tree = mesh.tree();
  const Vector3d low = p.cwiseMin(q), high = p.cwiseMax(q);
  std::array<int, 2 * MeshTree::kMaxDepth> stack;
  std::size_t size = 0;
  stack[size++] = 0;
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
      winding.add(c, mesh.windingWeight(tree.triangleOf(slot)));
    }
  }
  return true;
}

}  // namespace

Side sideOf(const TriangleMesh& mesh, int component, const Vector3d& point) {
  const MeshTree::Component& c = mesh.tree().components()[static_cast<std::size_t>(component)];
  return sideByWinding(c.low, c.high, point, [&](const Vector3d& q, Winding& winding) {
    return windingNumber(mesh, component, point, q, winding);
  });
}

}  // namespace leeway::collision
