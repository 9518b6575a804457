#include "collision/distance/round_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/prefetch.h"
#include "collision/base/scratch.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "collision/convex/convex_distance.h"
#include "collision/deform/query/round_body.h"
#include "collision/solids/contains_at.h"
#include "leeway/collision/deformable_mesh.h"

namespace leeway::collision {

bool roundDistance(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB,
                   const DistanceRequest& request, Scratch& scratch, PairCache& cache, bool swapped,
                   DistanceResult& result, int& visited) {
  visited = 0;
  const DeformableSnapshotImpl& mesh = b.deformable()->impl();
  const DeformTree& tree = *mesh.tree;
  // The last nearest triangle is tried first; its corners are probably out of cache.
  const int triangle = swapped ? cache.triangle_a : cache.triangle_b;
  std::int32_t first = -1;
  if (cache.hierarchy == tree.id() && cache.place >= 0 && cache.place < tree.triangleCount()) {
    first = cache.place;
  } else if (triangle >= 0 && triangle < tree.triangleCount()) {
    first = tree.slotOf(triangle);
  }
  if (first >= 0) __builtin_prefetch(&tree.corners(first));

  // At the first query after an update, the code is probably out of cache, too.
  DeformScratch& scratch_of_meshes = scratch.impl().deform;
  if (scratch_of_meshes.asked != mesh.id) {
    scratch_of_meshes.asked = mesh.id;
    prefetchCode(roundDistance, 2304);
    fetchNearestCode();
  }

  const RelativePose relative = relativePose(X_WA, X_WB);
  const bool is_segment = a.type() == ShapeType::kCapsule;
  const double half_length = is_segment ? a.halfLength() : 0;
  if (!relative.valid || !hasNearest(is_segment, half_length, mesh)) return false;
  const RoundBody body = roundBody(a.radius(), half_length, relative.X_BA);
  const double slack = relative.slack * (half_length + body.radius + b.extent() +
                                         relative.X_BA.translation.norm() + kLeastSum);
  NearestSearch search = nearestSearch(body, mesh, slack, request);
  const double root = boxLower(body, mesh, search);
  // A threshold of NaN (no threshold) decides nothing.
  if (root > std::max(request.threshold, 0.0)) {
    result.distance = {root, kInfinity};
    result.status = statusOf(result.distance, request);
    if (swapped) result.normal = -result.normal;
    return true;
  }
  if (scratch.impl().work->isSpent()) return false;
  search.limit = request.node_limit;
  search.first = first;
  const NearestFound found = findNearest(search, mesh, BoxSource(mesh, scratch.impl().deform));
  visited = found.visited;
  double bar =
      request.threshold == request.threshold ? std::max(request.threshold, 0.0) : kInfinity;
  double lower = found.lower - body.radius;
  bool near = false;
  result.distance.upper = kInfinity;
  if (found.slot >= 0) {
    cache.hierarchy = tree.id();
    cache.place = found.slot;
    const bool answered = answerNearest(body, found, tree, request, result);
    (swapped ? cache.triangle_a : cache.triangle_b) = tree.triangleOf(found.slot);
    (swapped ? cache.triangle_b : cache.triangle_a) = -1;
    if (!answered) return false;
    result.iterations = 1;
    bar = std::min(bar, result.distance.upper - request.tolerance);
    near = result.distance.upper <= request.threshold;
    lower = std::min(near ? root : lower, result.distance.lower);
  }
  // Contact, and bodies whose boxes meet, are left to the caller, which computes their depth. This
  // does not apply if the limit ended the search, because the caller would have no nodes left.
  const bool over = visited >= request.node_limit && !near;
  if (!over && !(near ? root > 0 : found.lower - body.radius > bar)) return false;
  result.distance.lower = std::max(lower, root);
  if (!(root > 0) &&
      (!(lower > 0) || containsAt(a, X_WA, b, X_WB, lower, scratch) != Containment::kNo))
    return false;
  result.status = statusOf(result.distance, request);
  if (found.slot >= 0) {
    result.point_a = X_WB * result.point_a;
    result.point_b = X_WB * result.point_b;
    result.normal = X_WB.rotation * result.normal;
  }
  if (swapped) {
    std::swap(result.point_a, result.point_b);
    std::swap(result.triangle_a, result.triangle_b);
    result.normal = -result.normal;
  }
  return true;
}

}  // namespace leeway::collision
