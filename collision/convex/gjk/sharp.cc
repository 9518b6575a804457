#include "collision/convex/gjk/sharp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/tolerances.h"
#include "leeway/collision/convex_hull.h"

namespace leeway::collision {

namespace {

using Number = DoubleDouble;
using Wide = DoubleDoubleVector;

Wide column(const Eigen::Matrix3d& R, int i) { return Wide(Vector(R.col(i))); }

Wide rotated(const Eigen::Matrix3d& R, const Wide& v) {
  return v.x * column(R, 0) + v.y * column(R, 1) + v.z * column(R, 2);
}

Wide rotatedBack(const Eigen::Matrix3d& R, const Wide& v) {
  return {dot(column(R, 0), v), dot(column(R, 1), v), dot(column(R, 2), v)};
}

// max of p . d over vertices: those that rounding does not tell from the best are compared in twice
// the precision. A dot product errs by 3 units, dropping the low part of d by one more.
Number mostOfPoints(const ConvexView& view, const Wide& d, int& farthest) {
  const Vector direction = d.rounded();
  double best = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < view.count; ++i) best = std::max(best, direction.dot(view.points[i]));
  const double doubt = 16 * kUnitRoundoff * direction.norm() * view.extent;
  Number most = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < view.count; ++i) {
    if (direction.dot(view.points[i]) < best - doubt) continue;
    const Number value = dot(d, Wide(view.points[i]));
    if (most < value) most = value, farthest = i;
  }
  return most;
}

Number mostOfPoints(const ConvexView& view, const Wide& d) {
  int farthest = 0;
  return mostOfPoints(view, d, farthest);
}

Number mostOfCore(const ConvexView& view, const Wide& d) {
  const Number r = view.size.x(), h = view.size.z();
  switch (view.core) {
    case Core::kPoint:
      return 0;
    case Core::kSegment:
      return h * absolute(d.z);
    case Core::kPoints:
      return mostOfPoints(view, d);
    case Core::kBox:
      return view.size.x() * absolute(d.x) + view.size.y() * absolute(d.y) + h * absolute(d.z);
    case Core::kCylinder:
      return r * squareRoot(d.x * d.x + d.y * d.y) + h * absolute(d.z);
    case Core::kCone: {
      const Number apex = h * d.z, rim = r * squareRoot(d.x * d.x + d.y * d.y) - h * d.z;
      return apex < rim ? rim : apex;
    }
    case Core::kEllipsoid:
      return norm({view.size.x() * d.x, view.size.y() * d.y, view.size.z() * d.z});
    case Core::kHalfSpace:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

// The point p of a piece of a round core (see farthestOfRound()), rounded off it, put back where
// that can be done without moving it by more.
Vector ontoPiece(const ConvexView& view, int piece, Vector p) {
  if (view.core == Core::kEllipsoid) return p;
  const double r = view.size.x(), h = view.size.z();
  if (view.core == Core::kCone && piece == 1) return {0, 0, h};
  p.z() = piece == 1 ? h : -h;
  const double across = std::sqrt(p.x() * p.x() + p.y() * p.y());
  if (across > r) {
    p.x() *= r / across;
    p.y() *= r / across;
  }
  return p;
}

// How far such a point may stand out: on a rim by the 4 units of its radius; on an ellipsoid by
// what it lost on its way into B and back, less than 16 units of L.
double defectOf(const ConvexView& view, double size) {
  if (view.core == Core::kEllipsoid) return 16 * kUnitRoundoff * size;
  return isRound(view.core) ? 6 * kUnitRoundoff * view.extent : 0;
}

}  // namespace

Wide farthestOfCore(const ConvexView& view, const Wide& d) {
  const Number r = view.size.x(), h = view.size.z(), zero = 0;
  const auto rim = [&](const Number& z) -> Wide {
    const Number across = squareRoot(d.x * d.x + d.y * d.y);
    if (!(across.high > 0)) return {zero, zero, z};
    return {r * d.x / across, r * d.y / across, z};
  };
  const auto towards = [](const Number& along, double size) -> Number {
    return along.high < 0 ? -size : size;
  };
  switch (view.core) {
    case Core::kSegment:
      return {zero, zero, towards(d.z, view.size.z())};
    case Core::kPoints: {
      int farthest = 0;
      mostOfPoints(view, d, farthest);
      return Wide(view.points[farthest]);
    }
    case Core::kBox:
      return {towards(d.x, view.size.x()), towards(d.y, view.size.y()),
              towards(d.z, view.size.z())};
    case Core::kCylinder:
      return rim(towards(d.z, view.size.z()));
    case Core::kCone:
      if (r * squareRoot(d.x * d.x + d.y * d.y) - h * d.z < h * d.z) return {zero, zero, h};
      return rim(-h);
    case Core::kEllipsoid: {
      const Vector& m = view.size;
      const Wide scaled = {m.x() * d.x, m.y() * d.y, m.z() * d.z};
      const Number length = norm(scaled);
      if (!(length.high > 0)) return {};
      return Number(1) / length * Wide(m.x() * scaled.x, m.y() * scaled.y, m.z() * scaled.z);
    }
    case Core::kPoint:
    case Core::kHalfSpace:
      break;
  }
  return {};
}

double departureOf(const Eigen::Matrix3d& R) {
  Number squares = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const Number e = dot(column(R, i), column(R, j)) - Number(i == j ? 1 : 0);
      squares = squares + (i == j ? e * e : 2 * (e * e));
    }
  }
  return std::sqrt(squares.high) * kOutwards;
}

SharpDifference::SharpDifference(const ConvexView& a, const Pose& X_WA, const ConvexView& b,
                                 const Pose& X_WB)
    : a_(a), b_(b), X_WA_(X_WA), X_WB_(X_WB), t_(Wide(X_WA.translation) - Wide(X_WB.translation)) {
  for (int j = 0; j < 3; ++j) {
    X_BA_.rotation.col(j) = rotatedBack(X_WB.rotation, column(X_WA.rotation, j)).rounded();
  }
  X_BA_.translation = rotatedBack(X_WB.rotation, t_).rounded();
  const double departure_a = departureOf(X_WA.rotation), departure_b = departureOf(X_WB.rotation);
  const double extent_a = a.core == Core::kHalfSpace ? 0 : a.extent;
  const double extent_b = b.core == Core::kHalfSpace ? 0 : b.extent;
  slack_ = 0.5 * (departure_a * extent_a + departure_b * extent_b) * kFirstOrderOutwards;
  // With R = Q (1 + F) and |F| <= departure / 2 for both. In B's frame Q_B^T R_B moves points of B
  // by |F_B|, and R_B^T in place of Q_B^T those of A by |F_B| (extent A + |t|). In A's frame, which
  // X_BA's inverse leads to, it is |F_A| for extent A and (extent B + |t|), and t is turned by R_B
  // R_B^T besides. The rotations that were meant move either body by |F| of its extent once more.
  // Entries of X_BA and t err by one unit each. The plane of a half-space is moved by what its
  // normal turns, anywhere within L.
  const double t = X_BA_.translation.norm(), size = extent_a + extent_b + t;
  const bool planes = a.core == Core::kHalfSpace || b.core == Core::kHalfSpace;
  const double turned = planes ? (departure_a + departure_b) * size
                               : departure_a * (extent_a + 0.5 * (extent_b + t)) +
                                     departure_b * (extent_b + 0.5 * extent_a + t);
  pose_slack_ = (turned + 2 * kUnitRoundoff * size) * kFirstOrderOutwards;
  // X_BA makes points of the difference that are off those of the world by as much.
  moved_ = 1.01 * (departure_a + 2 * departure_b) * size;
  member_defect_ = defectOf(a, size) + defectOf(b, size);
  // (Its points are left where a transpose that is no inverse puts them.)
  if (a.core == Core::kEllipsoid) member_defect_ += 1.01 * (departure_a + departure_b) * size;
}

// max over b - a - (T_A - T_B).
Number SharpDifference::mostAlong(const Wide& n) const {
  return mostOfCore(b_, rotatedBack(X_WB_.rotation, n)) +
         mostOfCore(a_, -rotatedBack(X_WA_.rotation, n)) - dot(n, t_);
}

Wide SharpDifference::member(const SupportPoint& s, const Pose& X_BA) const {
  Vector p_a, p_b;
  if (!vertex(a_, s.index_a, p_a)) {
    p_a = ontoPiece(a_, s.index_a, rotatedBack(X_BA.rotation, s.a - X_BA.translation));
  }
  if (!vertex(b_, s.index_b, p_b)) p_b = ontoPiece(b_, s.index_b, s.w + s.a);
  return memberOf(Wide(p_a), Wide(p_b));
}

Wide SharpDifference::memberOf(const Wide& p_a, const Wide& p_b) const {
  return rotated(X_WB_.rotation, p_b) - rotated(X_WA_.rotation, p_a) - t_;
}

Wide SharpDifference::inWorld(const Vector& direction_b) const {
  return rotated(X_WB_.rotation, Wide(direction_b));
}

Wide SharpDifference::inA(const Wide& direction) const {
  return rotatedBack(X_WA_.rotation, direction);
}

Wide SharpDifference::inB(const Wide& direction) const {
  return rotatedBack(X_WB_.rotation, direction);
}

void offerSharpPlane(const SharpDifference& difference, const Wide& n, Progress& progress) {
  const Number length = norm(n);
  if (!(length.high > 0)) return;
  const CoreQuery& query = progress.query();
  const Number radii = exactSum(query.radius_a, query.radius_b);
  const Number apart = -difference.mostAlong(-n) / length - radii;
  const double excess = difference.a().excess + difference.b().excess;
  // One rounding to double, and room for the 2^-100 of all that came before.
  const double lower = apart.high - 2 * kUnitRoundoff * std::abs(apart.high) -
                       0.01 * query.roundoff - excess * kOutwards - difference.slack();
  Vector normal = rotatedBack(difference.X_WB().rotation, n.rounded());
  normal /= normal.norm();
  progress.offerEnd(lower, normal);
}

void offerSharpWitness(const SharpDifference& difference, const Number& distance, double defect,
                       const Vector& w, const Vector& a, Progress& progress) {
  const CoreQuery& query = progress.query();
  const Number apart = distance - exactSum(query.radius_a, query.radius_b);
  progress.offerUpperEnd(apart.high + 2 * kUnitRoundoff * std::abs(apart.high) +
                             0.01 * query.roundoff + defect + difference.slack(),
                         w, a);
}

// The plane is where its own pose's third column and translation say, the column's length divided
// out. The rotation that was meant turns it by half the departure, and the affine map that the
// matrix is by all of it, about a point within L.
void sharpenHalfSpace(const SharpDifference& difference, Progress& progress) {
  const bool first = difference.a().core == Core::kHalfSpace;
  const ConvexView& body = first ? difference.b() : difference.a();
  const Pose &plane = first ? difference.X_WA() : difference.X_WB(),
             &pose = first ? difference.X_WB() : difference.X_WA();
  const Wide up = column(plane.rotation, 2);
  const Wide t = Wide(pose.translation) - Wide(plane.translation);
  const Number height =
      (dot(up, t) - mostOfCore(body, rotatedBack(pose.rotation, -up))) / norm(up) -
      Number(body.radius);
  const double size = body.extent + t.rounded().norm();
  const double departures =
      0.5 * departureOf(pose.rotation) * body.extent + departureOf(plane.rotation) * size;
  const double slack = departures * kFirstOrderOutwards +
                       2 * kUnitRoundoff * std::abs(height.high) + 0.01 * kUnitRoundoff * size;
  progress.offerEnd(height.high - slack - body.excess * kOutwards, progress.normal());
  progress.offerUpperEnd(height.high + slack, progress.witnessW(), progress.witnessA());
}

void sharpenPoint(const SharpDifference& difference, bool outside, const Vector& nearest,
                  const Vector& normal, Progress& progress) {
  const bool first = difference.a().core == Core::kPoint;
  const ConvexView& body = first ? difference.b() : difference.a();
  const Pose &pose = first ? difference.X_WB() : difference.X_WA(),
             &point = first ? difference.X_WA() : difference.X_WB();
  const CoreQuery& query = progress.query();
  const Number radii = exactSum(query.radius_a, query.radius_b);
  const Wide t = Wide(point.translation) - Wide(pose.translation);
  const Wide out = rotated(pose.rotation, Wide(normal));
  const Number lower =
      (dot(out, t) - mostOfCore(body, rotatedBack(pose.rotation, out))) / norm(out) - radii;
  const double slack = difference.slack() + 0.01 * query.roundoff;
  progress.offerEnd(lower.high - 2 * kUnitRoundoff * std::abs(lower.high) - slack -
                        (difference.a().excess + difference.b().excess) * kOutwards,
                    progress.normal());
  if (!outside) return;
  const Number upper = norm(t - rotated(pose.rotation, Wide(nearest))) - radii;
  progress.offerUpperEnd(upper.high + 2 * kUnitRoundoff * std::abs(upper.high) + slack +
                             8 * kUnitRoundoff * body.extent,
                         progress.witnessW(), progress.witnessA());
}

void sharpenApart(const SharpDifference& difference, const Simplex& simplex, const Pose& X_BA,
                  Progress& progress) {
  if (simplex.count < 1 || simplex.count > 3) return;
  Wide points[3], sum;
  Number weights = 0;
  for (int i = 0; i < simplex.count; ++i) {
    points[i] = difference.member(simplex.point(i), X_BA);
    sum = sum + simplex.lambda[i] * points[i];
    weights = weights + simplex.lambda[i];
  }
  const Wide w = (Number(1) / weights) * sum;
  offerSharpWitness(difference, norm(w), difference.memberDefect(),
                    rotatedBack(difference.X_WB().rotation, w.rounded()), simplex.pointOfA(),
                    progress);
  offerSharpPlane(difference, Wide(rotated(difference.X_WB().rotation, progress.normal())),
                  progress);
  // The direction that belongs to these points, without what cancellation left along the feature.
  Wide n = w;
  if (simplex.count == 2) {
    const Wide edge = points[1] - points[0];
    const Number squared = dot(edge, edge);
    if (squared.high > 0) n = w - (dot(w, edge) / squared) * edge;
  } else if (simplex.count == 3) {
    n = cross(points[1] - points[0], points[2] - points[0]);
    if (dot(n, w).high < 0) n = -n;
  }
  offerSharpPlane(difference, n, progress);
}

}  // namespace leeway::collision
