#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// A shape placed in the world. Borrows the shape.
struct PlacedShape {
  const Shape* shape = nullptr;
  Pose X_WS;
};

/// The parameters of separation().
struct SeparationRequest {
  /// After the translation every pair must be proven farther apart than this [m]; finite, >= 0.
  double clearance = 0;
  /// Stop shortening within this of a length that is proven necessary, or of a length that was
  /// found too short along the same direction [m]; > 0.
  double tolerance = 1e-6;
  /// Longer translations are rejected [m].
  double longest = std::numeric_limits<double>::infinity();
  /// Limit on distance queries of single pairs, without those of the last proof. A lower limit
  /// gives longer translations, or none.
  int query_limit = 20'000;
  /// Limits of each query, as in DistanceRequest.
  int iteration_limit = 256;
  int node_limit = 10'000'000;
};

enum class SeparationStatus : unsigned char {
  kApart,      ///< already farther apart than the clearance: the translation is 0
  kSeparated,  ///< the translation is proven to separate them
  kNotFound,   ///< no translation was found within the limits, but one may exist
  kInvalid,  ///< a shape is missing, a pose is not finite or not a rotation, both are half-spaces,
             ///< or a request is out of its range
};

struct SeparationResult {
  SeparationStatus status = SeparationStatus::kInvalid;
  /// The translation of the body, in W [m]; 0 unless kSeparated.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  /// Proven lower end of the distances of all pairs after the translation [m]: above the request's
  /// clearance for kApart and kSeparated, -infinity otherwise.
  double clearance = -std::numeric_limits<double>::infinity();
  /// Proven: no shorter translation separates the shapes [m].
  double least = 0;
  int queries = 0;  ///< distance queries made
};

/// Returns a short translation of `body`, all its shapes together, after which each shape is
/// farther than request.clearance from each of `obstacles`. Use: collision response by pushing out.
///
/// Any plane between two shapes defines a half-space of translations that separate this pair; for
/// convex pairs the shortest translation crosses such a plane. One plane for each pair gives an
/// intersection of half-spaces, whose point nearest to the origin is a candidate. Choices of planes
/// are searched depth first, shorter candidates first, and pruned by the best verified translation.
/// The planes tried are the deepest pair's own (that of its depth) and those of both frames' axes.
/// The best translation is then turned and shortened in small steps, each verified.
///
/// For one convex pair the result is the shortest within the tolerance. Otherwise it is short but
/// not proven shortest, and `least` is a proven lower bound on the shortest. Never throws or
/// allocates and always terminates: at most request.query_limit distance queries, plus one or two
/// for each pair in the proof. Compare S. Redon, M. C. Lin, "A fast method for local penetration
/// depth computation", 2006; L. Zhang, Y. J. Kim, G. Varadhan, D. Manocha, "Generalized penetration
/// depth computation", 2007.
SeparationResult separation(std::span<const PlacedShape> body,
                            std::span<const PlacedShape> obstacles,
                            const SeparationRequest& request, Scratch& scratch);

/// separation() of two shapes: moves B away from A.
SeparationResult separation(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                            const SeparationRequest& request, Scratch& scratch);

}  // namespace leeway::collision
