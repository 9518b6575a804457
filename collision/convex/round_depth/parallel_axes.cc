#include "collision/convex/round_depth/parallel_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/base/pose_check.h"
#include "collision/base/tolerances.h"

namespace leeway::collision {

namespace {

// In the half plane through the axis: (across, along).
struct Point {
  double across = 0, along = 0;
};
double dot(const Point& p, const Point& q) { return p.across * q.across + p.along * q.along; }

// A section of a body of revolution through its axis: a convex polygon, and the outward normals of
// the sides on one side of the axis.
struct Section {
  Point corner[4];
  int corners = 0;
  Point normal[3];
  int normals = 0;
};

Section sectionOf(const ConvexView& view) {
  const double r = view.size.x(), h = view.size.z();
  switch (view.core) {
    case Core::kSegment:
      return {{{0, h}, {0, -h}}, 2, {{1, 0}}, 1};
    case Core::kCylinder:
      return {{{r, h}, {r, -h}, {-r, -h}, {-r, h}}, 4, {{1, 0}, {0, 1}, {0, -1}}, 3};
    default: {
      const double slant = std::hypot(2 * h, r);
      const Point beside = slant > 0 ? Point{2 * h / slant, r / slant} : Point{1, 0};
      return {{{0, h}, {r, -h}, {-r, -h}}, 3, {beside, {0, -1}}, 2};
    }
  }
}

// The section upside down.
Section turnedOver(Section s) {
  for (Point& p : s.corner) p.along = -p.along;
  for (Point& n : s.normal) n.along = -n.along;
  return s;
}

double support(const Section& s, const Point& n) {
  double most = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < s.corners; ++i) most = std::max(most, dot(n, s.corner[i]));
  return most;
}

// The side of a section that is farthest along n: its range along `tangent`, and its height along
// n.
struct Side {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  double height = 0;
};

Side farthestSide(const Section& s, const Point& n, const Point& tangent, double extent) {
  Side side;
  side.height = support(s, n);
  for (int i = 0; i < s.corners; ++i) {
    if (dot(n, s.corner[i]) < side.height - kSideTogether * extent) continue;
    side.least = std::min(side.least, dot(tangent, s.corner[i]));
    side.most = std::max(side.most, dot(tangent, s.corner[i]));
  }
  return side;
}

}  // namespace

bool haveAxes(const ConvexView& a, const ConvexView& b) {
  const auto has = [](const ConvexView& view) {
    return view.core == Core::kSegment || view.core == Core::kCylinder || view.core == Core::kCone;
  };
  return has(a) && has(b);
}

// Let A' be A turned so that its axis is parallel to B's. Each of A and A' lies in the other one
// grown by the largest distance of corresponding points, so the signed separation changes by at
// most that distance: extent A times the angle between the axes (less than 1.01 times its sine, the
// part of A's axis across z) plus the departure from a rotation.
//
// Rounding of the closed form: the normal 3 units, the supports 6 of their extents, t's length and
// dot product 6 of |t|; in all less than 16 of L.
bool offerParallelAxes(const ConvexView& a, const Pose& X_BA, const ConvexView& b,
                       Difference<false>& difference, Progress& progress) {
  const Vector axis = X_BA.rotation.col(2);
  const double sine = std::sqrt(axis.x() * axis.x() + axis.y() * axis.y());
  if (!(sine <= kNearlyParallelAxes)) return false;
  const Section of_b = sectionOf(b);
  // A's part of the difference: its points, negated.
  const Section of_a = axis.z() > 0 ? turnedOver(sectionOf(a)) : sectionOf(a);
  const Vector& t = X_BA.translation;
  const double across = std::sqrt(t.x() * t.x() + t.y() * t.y());
  const Vector radial = across > 0 ? Vector(t.x() / across, t.y() / across, 0) : Vector::UnitX();
  const Point origin{across, t.z()};
  double depth = std::numeric_limits<double>::infinity();
  Point out;
  for (const Section* section : {&of_b, &of_a}) {
    for (int i = 0; i < section->normals; ++i) {
      const Point& n = section->normal[i];
      const double here = support(of_b, n) + support(of_a, n) - dot(n, origin);
      if (here < depth) depth = here, out = n;
    }
  }
  const Vector outward = out.across * radial + out.along * Vector::UnitZ();
  SupportPoint lowest;
  difference.support(-outward, lowest);
  const double plane = -outward.dot(lowest.w);
  const double moved = (1.01 * sine + departureOf(X_BA.rotation)) * a.extent;
  if (!(depth > moved)) return false;
  // The point of the difference's surface nearest to the origin, as a sum of a point of each.
  const Point tangent{-out.along, out.across};
  const Side side_a = farthestSide(of_a, out, tangent, a.extent);
  const Side side_b = farthestSide(of_b, out, tangent, b.extent);
  const double along = dot(tangent, origin);
  const double along_b =
      std::clamp(along - 0.5 * (side_a.least + side_a.most), side_b.least, side_b.most);
  const double along_a = std::clamp(along - along_b, side_a.least, side_a.most);
  const auto point = [&](const Side& side, double s, const Vector& beside, const Vector& upright) {
    return Vector((side.height * out.across + s * tangent.across) * beside +
                  (side.height * out.along + s * tangent.along) * upright);
  };
  // The point of A itself, not of A'.
  const Vector upright = axis.z() > 0 ? axis : -axis;
  const Vector beside = (radial - radial.dot(upright) * upright).normalized();
  const Vector point_a = t - point(side_a, along_a, beside, upright);
  const Vector w = point(side_b, along_b, radial, Vector::UnitZ()) - point_a;
  const double upper = -(depth - moved);
  if (progress.offerTogether(upper, w, point_a, plane, -outward)) return true;
  // Too wide for the depth, but may be narrow enough to prove the overlap.
  const CoreQuery& query = progress.query();
  if (!isDecided({plane - query.lower_offset, upper - query.upper_offset}, query.request))
    return false;
  progress.offerWitness(upper, w, point_a);
  return true;
}

}  // namespace leeway::collision
