#include "collision/convex/convex_distance.h"

#include <algorithm>
#include <cmath>

#include "collision/base/pose_check.h"
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
#include "collision/convex/round_depth/curved_depth.h"
#include "collision/convex/round_depth/parallel_axes.h"
#include "collision/shapes/point_triangle.h"

namespace leeway::collision {

ConvexView viewOf(const Shape& shape) {
  ConvexView view;
  view.extent = shape.extent();
  switch (shape.type()) {
    case ShapeType::kSphere:
      view.core = Core::kPoint;
      view.radius = shape.radius();
      view.extent = 0;
      break;
    case ShapeType::kCapsule:
      view.core = Core::kSegment;
      view.radius = shape.radius();
      view.size.z() = shape.halfLength();
      view.extent = shape.halfLength();
      break;
    case ShapeType::kBox:
      view.core = Core::kBox;
      view.size = shape.halfExtents();
      break;
    case ShapeType::kCylinder:
    case ShapeType::kCone:
      view.core = shape.type() == ShapeType::kCylinder ? Core::kCylinder : Core::kCone;
      view.size = Vector(shape.radius(), 0, shape.halfLength());
      break;
    case ShapeType::kEllipsoid:
      view.core = Core::kEllipsoid;
      view.size = shape.halfExtents();
      break;
    case ShapeType::kHalfSpace:
      view.core = Core::kHalfSpace;
      break;
    case ShapeType::kConvexHull:
      view.core = Core::kPoints;
      view.points = shape.hull()->vertices().data();
      view.count = static_cast<int>(shape.hull()->vertices().size());
      view.hull = shape.hull();
      view.support = &shape.hull()->support();
      view.excess = shape.hull()->excess();
      view.center = shape.boundingCenter();
      break;
    case ShapeType::kMesh:
    case ShapeType::kDeformable:
      break;  // not convex: never asked
  }
  return view;
}

ConvexView viewOfPoints(const Vector* points, int count, double radius) {
  ConvexView view;
  view.core = Core::kPoints;
  view.points = points;
  view.count = count;
  view.radius = radius;
  double extent_squared = 0;
  Vector lowest = points[0], highest = points[0];
  for (int i = 0; i < count; ++i) {
    extent_squared = std::max(extent_squared, points[i].squaredNorm());
    lowest = lowest.cwiseMin(points[i]);
    highest = highest.cwiseMax(points[i]);
  }
  // What squares lose to the numbers below the normal ones is far below kSmallestScale.
  view.extent = std::sqrt(extent_squared + 0x1p-1000) * kOutwards;
  view.center = 0.5 * (lowest + highest);
  return view;
}

// Rounding of X_BA, in units of roundoff (Frobenius norms; rows and columns of a rotation have
// length 1):
//   R_B^T R_A: each entry errs by 3, the matrix by 9; R_B^T (t_A - t_B): 1 + 3 sqrt(3) of |t|
//   the departure E = R^T R - 1 of each rotation is itself computed with an error of 9.
// R_B^T stands for the inverse of R_B: with R_B = Q (1 + F) and |F| <= |E|/2 (1 + small), using it
// instead of Q^T moves points of A by |F| (extent A + |t|) and points of B by |E| extent B. R_A is
// taken as the matrix that it is, but a caller may have meant the rotation next to it: |E_A| extent
// A. In sum departures plus at most 9 + 9/2 + 9 units.
RelativePose relativePose(const Pose& X_WA, const Pose& X_WB) {
  RelativePose result;
  const PoseCheck check = checkRotations(X_WA.rotation, X_WB.rotation);
  const Vector &a = X_WA.translation, &b = X_WB.translation;
  // x - x is 0 for finite x only.
  const double zero = (a.x() - a.x()) + (a.y() - a.y()) + (a.z() - a.z()) + (b.x() - b.x()) +
                      (b.y() - b.y()) + (b.z() - b.z());
  if (!(check.rotations && zero == 0)) return result;
  result.valid = true;
  result.slack = check.departure + kPoseRounding * kUnitRoundoff;
  // Rows 0 and 1 of a column side by side, row 2 alone.
  using Pair = double __attribute__((vector_size(16)));
  const Eigen::Matrix3d &A = X_WA.rotation, &B = X_WB.rotation;
  const Pair x = {B(0, 0), B(0, 1)}, y = {B(1, 0), B(1, 1)}, z = {B(2, 0), B(2, 1)};
  for (int j = 0; j < 3; ++j) {
    const double p = A(0, j), q = A(1, j), r = A(2, j);
    const Pair above = x * Pair{p, p} + y * Pair{q, q} + z * Pair{r, r};
    result.X_BA.rotation(0, j) = above[0];
    result.X_BA.rotation(1, j) = above[1];
    result.X_BA.rotation(2, j) = B(0, 2) * p + B(1, 2) * q + B(2, 2) * r;
  }
  result.X_BA.translation = rotatedBack(B, a - b);
  return result;
}

namespace {

DistanceResult resultOf(const Progress& progress) {
  const CoreQuery& query = progress.query();
  DistanceResult result;
  result.distance = {progress.lower(), progress.upper()};
  result.status = progress.status();
  result.normal = progress.normal();
  result.iterations = progress.iterations;
  // Along the witnesses when apart, however poor the plane still is (a threshold may have been met
  // before any other than a stale cache's was tried); the plane's normal where they (nearly)
  // coincide or are inside.
  const Vector& w = progress.witnessW();
  const double norm = w.norm(), doubt = 16 * query.roundoff;
  const bool apart =
      norm > doubt && (w.dot(result.normal) > 0 || progress.upper() + query.upper_offset > doubt);
  const Vector towards_b = apart ? Vector(w / norm) : result.normal;
  result.point_a = progress.witnessA() + query.radius_a * towards_b;
  result.point_b = progress.witnessA() + w - query.radius_b * towards_b;
  return result;
}

// Everything between which rounding is known; outside, spheres around the frames' origins answer.
bool withinScale(double size) { return size >= kSmallestScale && size <= kLargestScale; }

// From spheres around the frames' origins: at least |t| - extents, and no two points are farther
// than |t| + extents.
DistanceResult coarseDistance(const ConvexView& a, const Vector& t, const ConvexView& b,
                              const DistanceRequest& request, double slack) {
  const double apart = std::hypot(t.x(), t.y(), t.z());
  const double size = a.extent + b.extent;
  const double radii = a.radius + b.radius;
  const double rounding = 16 * kUnitRoundoff * (apart + size + radii + a.excess + b.excess) + slack;
  DistanceResult result;
  result.distance.lower = apart - size - radii - a.excess - b.excess - rounding;
  result.distance.upper = apart + size - radii + rounding;
  if (std::isnan(result.distance.lower) || result.distance.lower > 1e308) {
    result.distance.lower = -std::numeric_limits<double>::infinity();
  }
  if (std::isnan(result.distance.upper)) {
    result.distance.upper = std::numeric_limits<double>::infinity();
  }
  result.normal = apart > 0 && apart <= 1e308 ? Vector(-t / apart) : Vector::UnitX();
  if (!(std::abs(result.normal.squaredNorm() - 1) < kUnitNormal)) result.normal = Vector::UnitX();
  result.point_a = apart <= 1e308 ? t : Vector::Zero();
  result.point_b = Vector::Zero();
  result.status = statusOf(result.distance, request);
  return result;
}

CoreQuery coreQuery(const ConvexView& a, const ConvexView& b, double translation,
                    const DistanceRequest& request, double slack, double rounding_units) {
  CoreQuery query;
  query.request = request;
  query.radius_a = a.radius;
  query.radius_b = b.radius;
  query.roundoff = kUnitRoundoff * (a.extent + b.extent + translation);
  // Sums of radii and their subtraction: a few roundings of each.
  const double radii = a.radius + b.radius;
  const double rounding = rounding_units * query.roundoff + 4 * kUnitRoundoff * radii + slack;
  query.lower_offset = radii + a.excess + b.excess + rounding;
  query.upper_offset = radii - rounding;
  return query;
}

// B is the half-space z <= 0 of its frame: the lowest point of A decides, apart or overlapping.
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

// The same with A and B exchanged, brought back into B's frame. X_BA's inverse is its transpose
// only to within its departure from orthogonality, which `slack` must hold.
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

// Two segments: candidate points and direction are offered and certified like any others. False
// when they do not suffice.
bool trySegments(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress) {
  const Vector half_a = X_BA.rotation.col(2) * a.size.z();
  const Vector half_b(0, 0, b.size.z());
  double s_a = 0, s_b = 0;
  nearestOnSegments(tripleOf(X_BA.translation), tripleOf(half_a), {}, tripleOf(half_b), s_a, s_b);
  const Vector p = X_BA.translation + s_a * half_a;
  const Vector w = s_b * half_b - p;
  const double norm = w.norm();
  ++progress.iterations;
  progress.offerWitness(norm, w, p);
  // Lowest point of the difference along n: its centre less what the halves can add.
  const auto offer = [&](const Vector& n) {
    const double value =
        -n.dot(X_BA.translation) - std::abs(n.dot(half_a)) - std::abs(n.dot(half_b));
    progress.offerLower(value, n);
  };
  if (norm > 0) offer(w / norm);
  if (progress.enough()) return true;
  // (Nearly) crossing: the common perpendicular is the better direction.
  Vector across = cross(half_a, half_b);
  const double across_squared = across.squaredNorm();
  // (Smaller, it is among the numbers that have lost digits.)
  if (!(across_squared > kLeastSquare)) return false;
  across /= std::sqrt(across_squared);
  offer(across.dot(w) < 0 ? Vector(-across) : across);
  return progress.enough();
}

// A segment and a box, in the box's frame, offered and certified alike. False when that does not
// suffice: nearly or really in contact.
bool trySegmentAndBox(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                      Progress& progress) {
  const Vector half_a = X_BA.rotation.col(2) * a.size.z();
  const double s = nearestToBox(tripleOf(X_BA.translation), tripleOf(half_a), tripleOf(b.size));
  const Vector p = X_BA.translation + s * half_a;
  const Vector w = p.cwiseMin(b.size).cwiseMax(-b.size) - p;
  const double norm = w.norm();
  if (!(norm > 0)) return false;
  ++progress.iterations;
  progress.offerWitness(norm, w, p);
  const Vector n = w / norm;
  progress.offerLower(-n.dot(X_BA.translation) - std::abs(n.dot(half_a)) - n.cwiseAbs().dot(b.size),
                      n);
  return progress.enough();
}

bool isTriangle(const ConvexView& view) { return view.core == Core::kPoints && view.count == 3; }

// A point or a segment and a triangle, in the triangle's frame: its ends and the triangle, then the
// segment and the triangle's edges, until the plane across the way between two points proves that
// none are nearer. False when that does not suffice: nearly or really in contact.
bool tryTriangle(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress) {
  const Vector* t = b.points;
  const bool segment = a.core == Core::kSegment;
  const Vector center = X_BA.translation,
               half = segment ? Vector(X_BA.rotation.col(2) * a.size.z()) : Vector(0, 0, 0);
  double least_squared = std::numeric_limits<double>::infinity();
  ++progress.iterations;
  const auto offer = [&](const Vector& p, const Vector& q) {
    const Vector w = q - p;
    const double squared = w.squaredNorm();
    if (!(squared < least_squared)) return false;
    least_squared = squared;
    if (!(squared > 0)) return false;
    const double norm = std::sqrt(squared);
    const Vector n = w / norm;
    progress.offerWitness(norm, w, p);
    const double lowest = std::min(n.dot(t[0]), std::min(n.dot(t[1]), n.dot(t[2])));
    progress.offerLower(lowest - n.dot(center) - std::abs(n.dot(half)), n);
    return progress.enough();
  };
  const auto offerEnd = [&](const Vector& p) {
    return offer(p, closestPointOnTriangle(p, t[0], t[1], t[2]));
  };
  if (!segment) return offerEnd(center);
  // The end that is nearer to the triangle first.
  const Vector away = center - b.center;
  const double sign = away.dot(half) > 0 ? -1 : 1;
  if (offerEnd(center + sign * half)) return true;
  for (int i = 0; i < 3; ++i) {
    const Vector middle = 0.5 * (t[i] + t[(i + 1) % 3]), half_edge = 0.5 * (t[(i + 1) % 3] - t[i]);
    double s = 0, s_edge = 0;
    nearestOnSegments(tripleOf(center), tripleOf(half), tripleOf(middle), tripleOf(half_edge), s,
                      s_edge);
    if (offer(center + s * half, middle + s_edge * half_edge)) return true;
  }
  return offerEnd(center - sign * half);
}

// Where two ellipsoids that are about as the hulls are have their nearest points: the normal n
// there solves (A / reach A + B / reach B + distance) n = c, with c from A's middle to B's, the
// matrices of HullSupport, and how far they reach along n. One step of iteration from c. NaN when
// there is none.
Vector directionOfEllipsoids(const HullSupport& a, const Pose& X_BA, const HullSupport& b) {
  // Ellipsoids that overlap are taken to be apart by this share of their reach, so that flat ones
  // have a direction, too. (Any one is right.)
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
  // (Symmetric and positive: the adjugate is the inverse, times a positive number.)
  const Vector n(cross(y, z).dot(u), cross(z, x).dot(u), cross(x, y).dot(u));
  return n / n.norm();
}

// Where GJK looks first: the cached direction if it is one, else from A's middle to B's.
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

// As runVertexGjk() would have left the search.
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

// Ends that need no search, however wide.
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

// Pairs that have a closed form. False when it does not suffice; what it found stays offered.
bool tryClosedForms(const ConvexView& a, const Pose& X_BA, const ConvexView& b, Progress& progress,
                    PairCache* cache, DistanceResult& result) {
  const auto met = [&](bool enough) {
    if (enough) result = resultOf(progress);
    return enough;
  };
  // The same with A and B exchanged.
  const auto metExchanged = [&](const auto& attempt) {
    CoreQuery query = progress.query();
    std::swap(query.radius_a, query.radius_b);
    Progress other(query);
    if (!attempt(b, X_BA.inverse(), a, other)) return false;
    result = exchanged(resultOf(other), X_BA);
    return true;
  };
  if (a.core == Core::kSegment && b.core == Core::kSegment) {
    if (met(trySegments(a, X_BA, b, progress))) return true;
  }
  if (progress.query().request.iteration_limit <= 0) return false;
  if (a.core == Core::kSegment && b.core == Core::kBox) {
    return met(trySegmentAndBox(a, X_BA, b, progress));
  }
  if (a.core == Core::kBox && b.core == Core::kSegment) return metExchanged(trySegmentAndBox);
  // Boxes that are apart have been answered before in closed form but for a few.
  if (a.core == Core::kBox && b.core == Core::kBox) {
    ++progress.iterations;
    if (!offerBoxOverlap(a, X_BA, b, progress) || !progress.enough()) return false;
    remember(progress, {}, false, -1, -1, cache);
    return met(true);
  }
  const auto thin = [](const ConvexView& view) {
    return view.core == Core::kPoint || view.core == Core::kSegment;
  };
  if (thin(a) && isTriangle(b)) return met(tryTriangle(a, X_BA, b, progress));
  if (isTriangle(a) && thin(b)) return metExchanged(tryTriangle);
  return false;
}

// GJK on vertices where both cores have only these, else on support functions.
GjkEnd runAnyGjk(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                 Difference<false>& difference, const VertexStart* start, const PairCache* cache,
                 Progress& progress, Simplex& simplex) {
  Vector first;
  GjkEnd end = GjkEnd::kStagnated;
  if (start != nullptr && start->count > 0) {
    end = resume(difference, *start, progress, simplex);
  } else if (difference.countsVertices()) {
    // A threshold is most often decided by the last direction alone.
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

// Near and below contact, from where GJK ended, by and by dearer: closed forms of parallel axes, an
// expanding polytope, the search over directions for round bodies. `narrow` [m]: what rounding
// leaves.
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
  if (!withinScale(a.extent + b.extent + translation + a.radius + b.radius)) {
    return coarseDistance(a, X_BA.translation, b, request, slack);
  }
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
  const GjkEnd end = runAnyGjk(a, X_BA, b, difference, start, cache, progress, simplex);
  // Rounding alone keeps the ends this far apart.
  const double narrow = query.lower_offset - query.upper_offset + 8 * query.roundoff;
  const bool inside = end == GjkEnd::kInside;
  if ((inside || end == GjkEnd::kStagnated) && !progress.enough() &&
      (inside || progress.upper() - progress.lower() > narrow)) {
    searchDepth(a, X_BA, b, inside, narrow, difference, simplex, scratch.impl(), progress);
  }
  if (!inside && progress.upper() > 0 && !progress.enough() &&
      request.iteration_limit >= kLeastIterations && haveCurvedDepth(a, b)) {
    offerCurvedNearest(difference, progress);
  }
  remember(progress, simplex, difference.countsVertices(), difference.hintA(), difference.hintB(),
           cache);
  scratch.impl().work->add(progress.iterations * kStepWork);
  return resultOf(progress);
}

DistanceResult convexSweptDistance(const ConvexView& a, const Pose& X_BA0, const Pose& X_BA1,
                                   double growth, const ConvexView& b,
                                   const DistanceRequest& request, Scratch& scratch,
                                   PairCache* cache, double slack) {
  // The sweep's own slack is taken off the lower end only: the placements themselves have no
  // growth.
  DistanceRequest swept_request = request;
  swept_request.depth = true;
  if (a.core == Core::kHalfSpace || b.core == Core::kHalfSpace) {
    DistanceResult first = convexDistance(a, X_BA0, b, swept_request, scratch, nullptr, slack);
    const DistanceResult second =
        convexDistance(a, X_BA1, b, swept_request, scratch, nullptr, slack);
    if (first.status == DistanceStatus::kInvalid) return first;
    const double lower = std::min(first.distance.lower, second.distance.lower);
    if (second.distance.upper < first.distance.upper) first = second;
    // The hull of two half-spaces is everything unless they are parallel, which rounding hides.
    first.distance.lower = a.core == Core::kHalfSpace
                               ? -std::numeric_limits<double>::infinity()
                               : lower - growth - kUnitRoundoff * (std::abs(lower) + growth);
    // The sweep's separation is the lesser of the two placements'.
    const Interval& d = first.distance;
    first.status = d.lower > request.threshold    ? DistanceStatus::kAboveThreshold
                   : d.upper <= request.threshold ? DistanceStatus::kNotAboveThreshold
                   : d.upper - growth - d.lower <= request.tolerance ? DistanceStatus::kConverged
                                                                     : DistanceStatus::kLimit;
    return first;
  }
  const double translation = std::max(X_BA0.translation.norm(), X_BA1.translation.norm());
  if (!withinScale(a.extent + b.extent + translation + a.radius + b.radius)) {
    // The middle of the chord, with its half length for a radius.
    ConvexView grown = a;
    const Vector half = 0.5 * X_BA1.translation - 0.5 * X_BA0.translation;
    grown.radius += growth + std::hypot(half.x(), half.y(), half.z()) * kOutwards;
    DistanceResult result = coarseDistance(grown, 0.5 * X_BA0.translation + 0.5 * X_BA1.translation,
                                           b, swept_request, slack);
    result.distance.upper = std::numeric_limits<double>::infinity();
    if (!(result.distance.lower > request.threshold)) result.status = DistanceStatus::kLimit;
    return result;
  }
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
