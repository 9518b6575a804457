#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Poses of a body A in B's frame, over a motion.
class Placements {
 public:
  virtual ~Placements() = default;
  /// False if no pose is available (there is no room for another one); the sweep is then undecided.
  virtual bool at(double t, Pose& X_BA) = 0;
};

struct MeshSweepRequest {
  /// The interval [t0, t0 + h] of the motion. h is a power of two (at most 1, at least 2^-30) and
  /// t0 a multiple of it, so that halves are exact.
  double t0 = 0, h = 1;
  /// Over [t, t + s], no point of A leaves the chord between its positions at t and t + s by more
  /// than s^2 `bend` [m]: an eighth of a bound on accelerations.
  double bend = 0;
  double threshold = 0;  ///< clearance to be kept [m]; not negative
  /// An interval is not halved again if no point moves farther than this [m], or if it is no longer
  /// than least_time.
  double least_motion = 1e-6;
  double least_time = 0;
  /// Limits: steps of GJK for a pair of convex parts; visited boxes and pairs of parts.
  int iteration_limit = 256;
  int node_limit = 1'000'000;
};

enum class MeshSweepStatus : unsigned char {
  kFree,       ///< the surfaces keep more than the threshold over the interval
  kContact,    ///< proven: they do not at the time t
  kUndecided,  ///< a limit, rounding, or a pose that is missing or invalid
};

struct MeshSweepResult {
  MeshSweepStatus status = MeshSweepStatus::kUndecided;
  double t = 0;   ///< of the contact
  int nodes = 0;  ///< boxes and pairs of parts visited
};

/// Whether sweepMesh() accepts this pair: two meshes, or a mesh and a bounded convex shape, within
/// the range of single precision.
bool sweepsMesh(const Shape& a, const Shape& b);

/// Sweeps the surface of a moving body A against that of B: branch and bound over pairs of boxes
/// and intervals of the motion at once.
///
/// Over an interval of length s, a box of A stays in a box that is placed halfway, stretched along
/// its centre's chord and grown by its rotation and by s^2 bend. A convex part or a triangle stays
/// in the hull of its two placements, grown by s^2 bend. A pair that moves farther than its size is
/// halved in time, and any other pair is split in space. Large boxes therefore settle long
/// intervals, and only pairs near each other need short ones. Compare S. Redon, M. C. Lin, D.
/// Manocha, Y. J. Kim, "Fast continuous collision detection for articulated models", 2005; here,
/// second-order bounds replace interval arithmetic.
///
/// Only the surfaces of bodies with an inside are swept: the caller decides containment, as for
/// sweptDistance(). Never throws or allocates and always terminates; O(request.node_limit).
MeshSweepResult sweepMesh(const Shape& a, Placements& motion, const Shape& b,
                          const MeshSweepRequest& request, Scratch& scratch);

}  // namespace leeway::collision
