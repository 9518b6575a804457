#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// Where a body A is, seen from B, at the times of a motion.
class Placements {
 public:
  virtual ~Placements() = default;
  /// False when that cannot be told (no room for another placement): the sweep is undecided then.
  virtual bool at(double t, Pose& X_BA) = 0;
};

struct MeshSweepRequest {
  /// The part [t0, t0 + h] of the motion; h a power of two (at most 1, at least 2^-30) and t0 a
  /// multiple of it, so that halves are exact.
  double t0 = 0, h = 1;
  /// Over [t, t + s] of that part no point of A leaves the chord between its placements at t and
  /// t + s by more than s^2 `bend` [m]: an eighth of a bound on accelerations.
  double bend = 0;
  double threshold = 0;  ///< separations above it are asked for [m]; not negative
  /// A part of the motion over which nothing moves farther than this [m] is not halved again.
  double least_motion = 1e-6;
  double least_time = 0;  ///< nor one that is as short as this
  /// Steps of GJK for a pair of convex parts, and boxes and pairs of parts looked at.
  int iteration_limit = 256;
  int node_limit = 1'000'000;
};

enum class MeshSweepStatus : unsigned char {
  kFree,       ///< the surfaces keep more than the threshold over all of the part
  kContact,    ///< proven not to at the time t
  kUndecided,  ///< a limit, rounding, or a pose that is none or cannot be told
};

struct MeshSweepResult {
  MeshSweepStatus status = MeshSweepStatus::kUndecided;
  double t = 0;   ///< of the contact
  int nodes = 0;  ///< boxes and pairs of parts looked at
};

/// Whether sweepMesh() takes this pair: two meshes, or a mesh and a bounded convex shape, within
/// the range of single precision.
bool sweepsMesh(const Shape& a, const Shape& b);

/// Surfaces of two bodies, of which A moves, against a threshold: branch and bound over pairs of
/// boxes and parts of the motion at once. Over a part of the motion a point of A stays within
/// `bend` times its square of the chord between its two placements; a box stays in a box that is
/// placed halfway, stretched along its centre's chord and grown by what it turns; and a convex
/// part or a triangle in the hull of its two placements. What moves farther than its size is halved
/// in time, everything else comes apart in space, so that large boxes settle long parts and only
/// what is near each other is looked at in short ones. (A continuous sweep in the manner of S.
/// Redon, M. C. Lin, D. Manocha, Y. J. Kim, "Fast continuous collision detection for articulated
/// models", 2005, with second-order bounds in place of interval arithmetic.) Of bodies with an
/// inside, surfaces are swept: containment is the caller's to decide, as for sweptDistance().
/// Never throws, allocates or loops without end.
MeshSweepResult sweepMesh(const Shape& a, Placements& motion, const Shape& b,
                          const MeshSweepRequest& request, Scratch& scratch);

}  // namespace leeway::collision
