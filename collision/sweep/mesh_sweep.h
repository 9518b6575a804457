#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Poses of a body A, seen from B, over a motion.
class Placements {
 public:
  virtual ~Placements() = default;
  /// False when there is no pose (no room for another one): the sweep is undecided then.
  virtual bool at(double t, Pose& X_BA) = 0;
};

struct MeshSweepRequest {
  /// The interval [t0, t0 + h] of the motion. h is a power of two (at most 1, at least 2^-30) and
  /// t0 a multiple of it, so that halves are exact.
  double t0 = 0, h = 1;
  /// Over [t, t + s] no point of A leaves the chord between its positions at t and t + s by more
  /// than s^2 `bend` [m]: an eighth of a bound on accelerations.
  double bend = 0;
  double threshold = 0;  ///< to be kept [m]; not negative
  /// An interval is not halved again where nothing moves farther than this [m], or where it is no
  /// longer than least_time.
  double least_motion = 1e-6;
  double least_time = 0;
  /// Steps of GJK for a pair of convex parts; boxes and pairs of parts visited.
  int iteration_limit = 256;
  int node_limit = 1'000'000;
};

enum class MeshSweepStatus : unsigned char {
  kFree,       ///< the surfaces keep more than the threshold over the interval
  kContact,    ///< proven: not so at the time t
  kUndecided,  ///< a limit, rounding, or a pose that is missing or invalid
};

struct MeshSweepResult {
  MeshSweepStatus status = MeshSweepStatus::kUndecided;
  double t = 0;   ///< of the contact
  int nodes = 0;  ///< boxes and pairs of parts visited
};

/// Whether sweepMesh() takes this pair: two meshes, or a mesh and a bounded convex shape, within
/// the range of single precision.
bool sweepsMesh(const Shape& a, const Shape& b);

/// Sweeps the surface of a moving body A against that of B: branch and bound over pairs of boxes
/// and intervals of the motion at once.
///
/// Over an interval of length s a box of A stays in a box that is placed halfway, stretched along
/// its centre's chord and grown by its rotation and by s^2 bend; a convex part or a triangle stays
/// in the hull of its two placements, grown by s^2 bend. A pair that moves farther than its size is
/// halved in time, any other is split in space: large boxes settle long intervals, and only pairs
/// near each other need short ones. Compare S. Redon, M. C. Lin, D. Manocha, Y. J. Kim, "Fast
/// continuous collision detection for articulated models", 2005; here with second-order bounds in
/// place of interval arithmetic.
///
/// Of bodies with an inside the surfaces are swept: the caller decides containment, as for
/// sweptDistance(). Never throws, allocates or loops without end; O(request.node_limit).
MeshSweepResult sweepMesh(const Shape& a, Placements& motion, const Shape& b,
                          const MeshSweepRequest& request, Scratch& scratch);

}  // namespace leeway::collision
