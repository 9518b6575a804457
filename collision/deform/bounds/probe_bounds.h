#pragma once

// Private to collision/: lower bounds on how far a body is from the children of a node.

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "collision/deform/tree/deform_tree.h"

namespace leeway::collision {

/// A body as it is compared with the boxes of a mesh, in their frame B and in single precision,
/// rounded outwards: intervals along B's axes and along three other orthonormal ones. The body lies
/// within all of them, grown by `radius`. Intervals may be infinite. Made by makeProbe()
/// (query/probe.h).
struct Probe {
  float low[3], high[3];            ///< along x, y, z of B
  float axis[3][3];                 ///< three unit vectors
  float axis_low[3], axis_high[3];  ///< along them
  bool turned;  ///< the body is clearly smaller along its own axes than along B's, so both are
                ///< tested
  float radius;
  float slack;  ///< bound on the rounding of all of the above [m]
};

/// Lower bounds on the signed separation of a body and each of eight boxes or triangles [m].
struct WideBounds {
  alignas(64) float lower[kWidth];  ///< infinity for empty columns of a node
  unsigned open;                    ///< a bit for each column at or below the bar
  float closed;                     ///< the least bound of the other columns
};

/// Function pointers for one instruction set. Every set yields the same bytes. `vertices` as in
/// DeformKernels.
struct ProbeKernels {
  /// Bounds for the children of several nodes, by their boxes. Leaves whose bound is then at or
  /// below `bar` are tightened by a plane for each leaf, because a box around a tilted surface is
  /// loose.
  void (*childBounds)(const Probe& probe, const DeformTree& tree, const Eigen::Vector3d* vertices,
                      std::span<const std::int32_t> nodes, const WideBox* const* boxes, float bar,
                      WideBounds* bounds);
  /// Bounds for the triangles in slots [begin, end), at most eight: by their boxes, and by a plane
  /// for each triangle. Fills only `lower`; columns without a triangle repeat the last one.
  void (*triangleBounds)(const Probe& probe, const DeformTree& tree,
                         const Eigen::Vector3d* vertices, std::int32_t begin, std::int32_t end,
                         WideBounds& bounds);
  /// The least scalar product of `n` and each of these vertices, at least one. False if a vertex is
  /// not finite.
  bool (*leastAlong)(const double* n, const Eigen::Vector3d* vertices,
                     std::span<const std::int32_t> of, double& least);
};

/// The kernels for the best instruction set of this machine. Takes about 3 ns, so call it once for
/// each query.
const ProbeKernels& probeKernels();

}  // namespace leeway::collision
