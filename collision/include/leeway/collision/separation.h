#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A shape somewhere in the world. Borrows the shape.
struct PlacedShape {
  const Shape* shape = nullptr;
  Pose X_WS;
};

/// What is asked of separation().
struct SeparationRequest {
  /// After the translation every pair must be proven farther apart than this [m]; finite, >= 0.
  double clearance = 0;
  /// Stop shortening within this of a length that is proven necessary, or of one that was found too
  /// short along the same direction [m]; > 0.
  double tolerance = 1e-6;
  /// Longer translations are not taken [m].
  double longest = std::numeric_limits<double>::infinity();
  /// Distance queries of single pairs, the last proof's not counted. A lower limit gives longer
  /// translations, or none.
  int query_limit = 20'000;
  /// Limits of each query, as in DistanceRequest.
  int iteration_limit = 256;
  int node_limit = 10'000'000;
};

enum class SeparationStatus : unsigned char {
  kApart,      ///< farther apart than the clearance as they are: the translation is 0
  kSeparated,  ///< the translation separates, proven
  kNotFound,   ///< no translation was found within the limits; there may be one
  kInvalid,  ///< a shape is missing, a pose that is not finite or not a rotation, two half-spaces,
             ///< or a request out of its range
};

struct SeparationResult {
  SeparationStatus status = SeparationStatus::kInvalid;
  /// What moves the body away, in W [m]; 0 unless kSeparated.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  /// Proven lower end of the distances of all pairs after the translation [m]: above the request's
  /// clearance for kApart and kSeparated, -infinity otherwise.
  double clearance = -std::numeric_limits<double>::infinity();
  /// Proven: no translation shorter than this separates [m].
  double least = 0;
  int queries = 0;  ///< distance queries made
};

/// A short translation of `body`, all its shapes together, after which each of them is farther than
/// request.clearance from each of `obstacles`: collision response by pushing out.
///
/// Any plane between two shapes leaves a half-space of translations that separate this pair; for
/// convex pairs the shortest one crosses such a plane. One plane a pair makes an intersection of
/// half-spaces, whose point nearest to the origin is a candidate. Choices of planes are searched
/// depth first, shorter candidates first, pruned by the best translation that is verified; the
/// planes tried are the deepest pair's own (its depth's) and those of both frames' axes. The best
/// translation is then turned and shortened in small steps, each verified.
///
/// For one convex pair the result is the smallest within the tolerance; else it is small, not
/// proven smallest, and `least` bounds what it could lose. Never throws, allocates or loops without
/// end; at most request.query_limit distance queries, and one or two more a pair for the proof.
/// Compare S. Redon, M. C. Lin, "A fast method for local penetration depth computation", 2006;
/// L. Zhang, Y. J. Kim, G. Varadhan, D. Manocha, "Generalized penetration depth computation", 2007.
SeparationResult separation(std::span<const PlacedShape> body,
                            std::span<const PlacedShape> obstacles,
                            const SeparationRequest& request, Scratch& scratch);

/// separation() of two shapes: moves B away from A.
SeparationResult separation(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                            const SeparationRequest& request, Scratch& scratch);

}  // namespace leeway::collision
