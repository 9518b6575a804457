#include "collision/convex/convex_distance.h"

#include <algorithm>
#include <cmath>

#include "collision/base/scratch.h"
#include "collision/base/status.h"
#include "collision/base/tolerances.h"
#include "collision/base/work.h"
#include "collision/convex/epa/epa.h"
#include "collision/convex/epa/vertex_polytope.h"
#include "collision/convex/gjk/gjk.h"
#include "collision/convex/gjk/support.h"
#include "collision/convex/gjk/swept_gjk.h"
#include "collision/convex/gjk/vertex_gjk.h"
#include "collision/convex/hull_pairs.h"
#include "collision/convex/pairs/box_overlap.h"
#include "collision/convex/pairs/closed_form.h"
#include "collision/convex/pairs/segment_pairs.h"
#include "collision/convex/round_depth/curved_depth.h"
#include "collision/convex/round_depth/curved_facet.h"
#include "collision/convex/round_depth/parallel_axes.h"

namespace leeway::collision {

namespace {

DistanceResult resultOf(const Progress& progress) {
  const CoreQuery& query = progress.query();
  DistanceResult result;
  result.distance = {progress.lower(), progress.upper()};
  result.status = progress.status();
  result.normal = progress.normal();
  result.iterations = progress.iterations;
  // When apart, radii are laid off along the witnesses, because the plane may be poor (the plane of
  // a stale cache alone may meet a threshold). Where the witnesses (nearly) coincide or overlap,
  // radii are laid off along the plane's normal.
  const Vector& w = progress.witnessW();
  const double norm = w.norm(), doubt = 16 * query.roundoff;
  const bool apart =
      norm > doubt && (w.dot(result.normal) > 0 || progress.upper() + query.upper_offset > doubt);
  const Vector towards_b = apart ? Vector(w / norm) : result.normal;
  result.point_a = progress.witnessA() + query.radius_a * towards_b;
  result.point_b = progress.witnessA() + w - query.radius_b * towards_b;
  return result;
}

CoreQuery coreQuery(const ConvexView& a, const ConvexView& b, double translation,
                    const DistanceRequest& request, double slack, double rounding_units) {
  CoreQuery query;
  query.request = request;
  query.radius_a = a.radius;
  query.radius_b = b.radius;
  query.roundoff = kUnitRoundoff * (a.extent + b.extent + translation + kLeastSum);
  // Sums of radii and their subtraction: a few roundings each.
  const double radii = a.radius + b.radius;
  const double rounding = rounding_units * query.roundoff + 4 * kUnitRoundoff * radii + slack;
  query.lower_offset = radii + a.excess + b.excess + rounding;
  query.upper_offset = radii - rounding;
  return query;
}

// B is the half-space z <= 0 of its frame: the result is the height of A's lowest point, apart or
// overlapping.
DistanceResult fromHalfSpace(const ConvexView& a, const Pose& X_BA, const DistanceRequest& request,
                             double slack) {
  const double translation = X_BA.translation.norm();
  const CoreQuery query = [&] {
    ConvexView plane;
    return coreQuery(a, plane, translation, request, slack, kClosedFormRounding);
  }();
  Progress progress(query);
  progress.iterations = 1;
  int hint = 0;
  const Vector down = -X_BA.rotation.row(2).transpose();
  const Vector lowest = placed(X_BA, farthest(a, down, hint));
  const Vector w(0, 0, -lowest.z());
  const double height = lowest.z();
  progress.offerLower(height, -Vector::UnitZ());
  progress.offerWitness(height, w, lowest);
  return resultOf(progress);
}

// Transforms the result of the pair (B, A) back into B's frame. X_BA's inverse is its transpose
// only up to its departure from orthogonality, which the caller's `slack` covers.
DistanceResult exchanged(DistanceResult result, const Pose& X_BA) {
  const Vector point_a = placed(X_BA, result.point_b);
  result.point_b = placed(X_BA, result.point_a);
  result.point_a = point_a;
  result.normal = -rotated(X_BA.rotation, result.normal);
  return result;
}

// A is a point at p in B's frame.
DistanceResult fromPoint(const ConvexView& a, const Vector& p, const ConvexView& b,
                         const DistanceRequest& request, double slack) {
  const CoreQuery query = coreQuery(a, b, p.norm(), request, slack, kClosedFormRounding);
  Progress progress(query);
  progress.iterations = 1;
  const PointDistance d = pointDistance(b, p);
  progress.offerLower(d.distance, -d.normal);
  progress.offerWitness(d.distance, d.nearest - p, p);
  return resultOf(progress);
}

// A direction from two ellipsoids that approximate the hulls. The normal n at their nearest points
// solves (A / reach A + B / reach B + distance) n = c, where c is the vector from A's middle to
// B's, A and B are the matrices of HullSupport, and reach is along n. This is one step of the
// iteration from c. NaN if it gives no direction.
Vector directionOfEllipsoids(const HullSupport& a, const Pose& X_BA, const HullSupport& b) {
  // Overlapping ellipsoids count as apart by this share of their reach, so that flat ones have a
  // direction, too. (Any direction is valid.)
  constexpr double kLeastGap = 1e-3;
  const Vector c = b.middle() - placed(X_BA, a.middle());
  const double apart = c.norm();
  const Vector u = c / apart;
  const Eigen::Matrix3d A = X_BA.rotation * a.spread() * X_BA.rotation.transpose();
  const double reach_a = std::sqrt(u.dot(A * u)), reach_b = std::sqrt(u.dot(b.spread() * u));
  const double reach = reach_a + reach_b, distance = std::max(apart - reach, kLeastGap * reach);
  const double size = reach + distance;
  Eigen::Matrix3d M = (1 / (reach_a * size)) * A + (1 / (reach_b * size)) * b.spread();
  M.diagonal().array() += distance / size;
  const Vector x = M.col(0), y = M.col(1), z = M.col(2);
  // (The adjugate of a positive matrix is its inverse, times a positive number.)
  const Vector n(cross(y, z).dot(u), cross(z, x).dot(u), cross(x, y).dot(u));
  return n / n.norm();
}

// GJK's first direction: the cached one if it is valid, otherwise from A's middle to B's.
Vector firstDirection(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                      const PairCache* cache) {
  if (cache != nullptr) {
    const double norm_squared = cache->direction_B.squaredNorm();
    if (norm_squared > 0.25 && norm_squared < 4) {  // NaN fails
      return cache->direction_B / std::sqrt(norm_squared);
    }
  }
  if (haveTables(a, b)) {
    const Vector n = directionOfEllipsoids(*a.support, X_BA, *b.support);
    if (n.squaredNorm() > 0.25) return n;  // NaN fails
  }
  const Vector middle = b.center - placed(X_BA, a.center);
  const double norm = middle.norm();
  return norm > 0 ? Vector(middle / norm) : Vector::UnitX();
}

void remember(const Progress& progress, const Simplex& simplex, bool vertices, int vertex_a,
              int vertex_b, PairCache* cache) {
  if (cache == nullptr) return;
  cache->direction_B = progress.normal();
  cache->vertex_a = vertex_a;
  cache->vertex_b = vertex_b;
  cache->simplex_count = vertices && simplex.count <= 3 ? simplex.count : 0;
  for (int i = 0; i < cache->simplex_count; ++i) {
    cache->simplex_a[i] = simplex.point(i).index_a;
    cache->simplex_b[i] = simplex.point(i).index_b;
  }
}

// Continues the search of answerHullPair() as if runVertexGjk() had made it.
GjkEnd resume(Difference<false>& difference, const VertexStart& start, Progress& progress,
              Simplex& simplex) {
  progress.iterations = start.iterations;
  for (int i = 0; i < start.count; ++i) {
    difference.member(start.vertex_a[i], start.vertex_b[i], simplex.points[simplex.slot[i]]);
    simplex.lambda[i] = 1.0 / start.count;
  }
  simplex.count = start.count;
  difference.setHints(start.vertex_a[start.count - 1], start.vertex_b[start.count - 1]);
  const SupportPoint& first = simplex.point(0);
  progress.offerWitness(first.w.norm(), first.w, first.a);
  if (start.end != GjkEnd::kInside) reduceAll(simplex, simplex.count);
  return start.end;
}

Vector anyPoint(const ConvexView& view) {
  return view.core == Core::kPoints ? view.points[0] : Vector::Zero();
}

// Offers any valid ends, however wide, without a search.
void offerAnything(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress) {
  const Vector p = X_BA * anyPoint(a);
  const Vector w = anyPoint(b) - p;
  progress.offerWitness(w.norm(), w, p);
  const double translation = X_BA.translation.norm();
  if (translation > 0) {
    progress.offerLower(translation - a.extent - b.extent, -X_BA.translation / translation);
  } else {
    progress.offerLower(-a.extent - b.extent, Vector::UnitX());
  }
}

// Pairs with a closed form. False if it does not suffice; the offered ends stay.
bool tryClosedForms(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress,
                    PairCache* cache, DistanceResult& result) {
  const auto met = [&](bool enough) {
    if (enough) result = resultOf(progress);
    return enough;
  };
  const auto metExchanged = [&](const auto& attempt) {
    CoreQuery query = progress.query();
    std::swap(query.radius_a, query.radius_b);
    Progress other(query);
    if (!attempt(b, X_BA.inverse(), a, other)) return false;
    result = exchanged(resultOf(other), X_BA);
    return true;
  };
  if (a.core == Core::kSegment && b.core == Core::kSegment) {
    if (met(offerSegments(a, X_BA, b, progress))) return true;
  }
  if (progress.query().request.iteration_limit <= 0) return false;
  if (a.core == Core::kSegment && b.core == Core::kBox) {
    return met(offerSegmentAndBox(a, X_BA, b, progress));
  }
  if (a.core == Core::kBox && b.core == Core::kSegment) return metExchanged(offerSegmentAndBox);
  // (answerBoxPair() has already answered most boxes that are apart.)
  if (a.core == Core::kBox && b.core == Core::kBox) {
    ++progress.iterations;
    if (!offerBoxOverlap(a, X_BA, b, progress) || !progress.enough()) return false;
    remember(progress, {}, false, -1, -1, cache);
    return met(true);
  }
  const auto thin = [](const ConvexView& view) {
    return view.core == Core::kPoint || view.core == Core::kSegment;
  };
  const auto isTriangle = [](const ConvexView& view) {
    return view.core == Core::kPoints && view.count == 3;
  };
  if (thin(a) && isTriangle(b)) return met(offerTriangle(a, X_BA, b, progress));
  if (isTriangle(a) && thin(b)) return metExchanged(offerTriangle);
  return false;
}

// GJK on vertices if both cores have finitely many, otherwise on support functions.
GjkEnd runAnyGjk(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                 Difference<false>& difference, const VertexStart* start, const PairCache* cache,
                 Progress& progress, Simplex& simplex) {
  Vector first;
  GjkEnd end = GjkEnd::kStagnated;
  if (start != nullptr && start->count > 0) {
    end = resume(difference, *start, progress, simplex);
  } else if (difference.countsVertices()) {
    // (The cached direction alone decides most thresholds.)
    const bool carried = cache != nullptr && std::isnan(progress.query().request.threshold) &&
                         fits(difference, *cache);
    if (!carried) first = firstDirection(a, X_BA, b, cache);
    end = runVertexGjk(difference, first, carried ? cache : nullptr, progress, simplex);
  }
  if (end == GjkEnd::kStagnated) {
    if (simplex.count == 0) first = firstDirection(a, X_BA, b, cache);
    end = runGjk(difference, first, progress, simplex);
  }
  return end;
}

// Near and below contact, from the end of GJK, in the order of cost: the closed form for parallel
// axes, an expanding polytope, the search over directions for round bodies. `narrow` [m]: the width
// that rounding leaves.
void searchDepth(const ConvexView& a, const Pose& X_BA, const ConvexView& b, bool inside,
                 double narrow, Difference<false>& difference, const Simplex& simplex,
                 Scratch::Impl& scratch, Progress& progress) {
  const DistanceRequest& request = progress.query().request;
  if (haveAxes(a, b)) offerParallelAxes(a, X_BA, b, difference, progress);
  const bool found = inside && simplex.count == 4 && difference.countsVertices() &&
                     !progress.enough() && growVertexPolytope(difference, simplex, progress);
  if (!found && !progress.enough() && progress.upper() - progress.lower() > narrow) {
    growPolytope(difference, simplex, scratch.polytope, progress);
  }
  if ((inside || progress.upper() < 0) && request.depth && !progress.enough() &&
      request.iteration_limit >= kLeastIterations && haveCurvedDepth(a, b)) {
    const int before = progress.iterations;
    offerCurvedDepth(difference, progress);
    scratch.work->add((progress.iterations - before) * kCurvedStepWork);
  }
}

// Finds interval and witnesses by search: GJK, then the stages for contact or near contact.
void search(const ConvexView& a, const Pose& X_BA, const ConvexView& b, const VertexStart* start,
            const PairCache* cache, Difference<false>& difference, Scratch::Impl& scratch,
            Progress& progress, Simplex& simplex) {
  const CoreQuery& query = progress.query();
  const GjkEnd end = runAnyGjk(a, X_BA, b, difference, start, cache, progress, simplex);
  // Rounding keeps the ends at least this far apart.
  const double narrow = query.lower_offset - query.upper_offset + 8 * query.roundoff;
  const bool inside = end == GjkEnd::kInside;
  if ((inside || end == GjkEnd::kStagnated) && !progress.enough() &&
      (inside || progress.upper() - progress.lower() > narrow)) {
    searchDepth(a, X_BA, b, inside, narrow, difference, simplex, scratch, progress);
  }
  if (!inside && progress.upper() > 0 && !progress.enough() &&
      query.request.iteration_limit >= kLeastIterations && haveCurvedDepth(a, b)) {
    offerCurvedNearest(difference, progress);
  }
}

// The separation of B from a half-space swept between two placements, or of a half-space B from a
// swept body: the smaller separation of the two placements.
DistanceResult sweptHalfSpace(const ConvexView& a, const Pose& X_BA0, const Pose& X_BA1,
                              double growth, const ConvexView& b, const DistanceRequest& request,
                              Scratch& scratch, double slack) {
  DistanceResult first = convexDistance(a, X_BA0, b, request, scratch, nullptr, slack);
  const DistanceResult second = convexDistance(a, X_BA1, b, request, scratch, nullptr, slack);
  if (first.status == DistanceStatus::kInvalid) return first;
  const double lower = std::min(first.distance.lower, second.distance.lower);
  if (second.distance.upper < first.distance.upper) first = second;
  // The hull of two half-spaces is the whole space unless they are parallel, which rounding hides.
  first.distance.lower = a.core == Core::kHalfSpace
                             ? -std::numeric_limits<double>::infinity()
                             : lower - growth - kUnitRoundoff * (std::abs(lower) + growth);
  const Interval& d = first.distance;
  first.status = d.lower > request.threshold    ? DistanceStatus::kAboveThreshold
                 : d.upper <= request.threshold ? DistanceStatus::kNotAboveThreshold
                 : d.upper - growth - d.lower <= request.tolerance ? DistanceStatus::kConverged
                                                                   : DistanceStatus::kLimit;
  return first;
}

}  // namespace

DistanceResult convexDistance(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                              const DistanceRequest& request, Scratch& scratch, PairCache* cache,
                              double slack, const VertexStart* start) {
  scratch.impl().work->add(kPairWork);
  if (a.core == Core::kHalfSpace) {
    if (b.core == Core::kHalfSpace) return {};
    return exchanged(fromHalfSpace(b, X_BA.inverse(), request, slack), X_BA);
  }
  if (b.core == Core::kHalfSpace) return fromHalfSpace(a, X_BA, request, slack);
  const double translation = X_BA.translation.norm();
  if (a.core == Core::kPoint && hasPointDistance(b.core)) {
    return fromPoint(a, X_BA.translation, b, request, slack);
  }
  if (b.core == Core::kPoint && hasPointDistance(a.core)) {
    return exchanged(fromPoint(b, X_BA.inverse().translation, a, request, slack), X_BA);
  }

  const CoreQuery query = coreQuery(a, b, translation, request, slack, kSupportRounding);
  Progress progress(query);
  DistanceResult result;
  if (tryClosedForms(a, X_BA, b, progress, cache, result)) return result;
  Difference<false> difference(a, b, X_BA, X_BA);
  if (cache != nullptr) difference.setHints(cache->vertex_a, cache->vertex_b);
  if (request.iteration_limit <= 0) {
    offerAnything(a, X_BA, b, progress);
    return resultOf(progress);
  }
  Simplex simplex;
  search(a, X_BA, b, start, cache, difference, scratch.impl(), progress, simplex);
  remember(progress, simplex, difference.countsVertices(), difference.hintA(), difference.hintB(),
           cache);
  scratch.impl().work->add(progress.iterations * kStepWork + progress.facet_cells * kFacetCellWork);
  return resultOf(progress);
}

DistanceResult convexSweptDistance(const ConvexView& a, const Pose& X_BA0, const Pose& X_BA1,
                                   double growth, const ConvexView& b,
                                   const DistanceRequest& request, Scratch& scratch,
                                   PairCache* cache, double slack) {
  // (growth reduces the lower end only, because the placements themselves do not grow.)
  DistanceRequest swept_request = request;
  swept_request.depth = true;
  if (a.core == Core::kHalfSpace || b.core == Core::kHalfSpace) {
    return sweptHalfSpace(a, X_BA0, X_BA1, growth, b, swept_request, scratch, slack);
  }
  const double translation = std::max(X_BA0.translation.norm(), X_BA1.translation.norm());
  CoreQuery query = coreQuery(a, b, translation, swept_request, slack, kSupportRounding);
  query.growth = growth;
  query.lower_offset += growth * kOutwards;
  Progress progress(query);
  Difference<true> difference(a, b, X_BA0, X_BA1);
  if (cache != nullptr) difference.setHints(cache->vertex_a, cache->vertex_b);
  const Pose middle{X_BA0.rotation, 0.5 * (X_BA0.translation + X_BA1.translation)};
  Simplex simplex;
  const bool in_lanes = isForSweptLanes(difference);
  if (request.iteration_limit > 0) {
    const Vector first = firstDirection(a, middle, b, cache);
    const GjkEnd end =
        in_lanes ? runSweptVertexGjk(difference, first, progress, simplex) : GjkEnd::kStagnated;
    if (end != GjkEnd::kInside && !progress.enough()) runGjk(difference, first, progress, simplex);
  }
  remember(progress, simplex, false, difference.hintA(), difference.hintB(), cache);
  scratch.impl().work->add(in_lanes ? kSweptLanePairWork + progress.iterations * kSweptLaneStepWork
                                    : kSweptPairWork + progress.iterations * kSweptStepWork);
  return resultOf(progress);
}

}  // namespace leeway::collision
