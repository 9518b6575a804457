#pragma once

// Private to collision/: where sweeps of two meshes have ended, for SweepFronts.

#include <array>
#include <cstddef>
#include <cstdint>

#include "collision/mesh/mesh_tree.h"

namespace leeway::collision {

/// Pairs of nodes that between them hold all pairs of triangles of two bodies, and what parted
/// each.
struct SweepFront {
  struct Entry {
    std::int32_t a, b;  ///< nodes; -1: a convex shape as a whole, whichever it is
    Eigen::Vector3d direction_B;
    int vertex_a, vertex_b;
  };
  /// More are not kept: looking at them would cost more than a descent.
  static constexpr std::size_t kMost = 96;

  const MeshTree* a = nullptr;  ///< null: a convex shape
  const MeshTree* b = nullptr;
  std::size_t count = 0;
  std::array<Entry, kMost> entries;
};

/// The last of some pairs of meshes, and room for the next.
struct SweepFrontScratch {
  static constexpr std::size_t kFronts = 4;

  bool active = false;
  std::size_t next = 0;  ///< whose place is taken
  std::array<SweepFront, kFronts> kept;
  SweepFront found;

  SweepFront* of(const MeshTree* a, const MeshTree* b) {
    for (SweepFront& front : kept)
      if (front.count > 0 && front.a == a && front.b == b) return &front;
    return nullptr;
  }
  void clear() {
    for (SweepFront& front : kept) front.count = 0;
  }
};

}  // namespace leeway::collision
