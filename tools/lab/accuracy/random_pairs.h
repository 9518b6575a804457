#pragma once

// Random convex shapes and placed pairs of them, for the families of `report accuracy`.

#include "leeway/collision/pose.h"
#include "tools/lab/base/engine.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::tools::report {

/// Sum of the finite bounding radii [m]; 1 if that is 0.
double sizeOfPair(const collision::Shape& a, const collision::Shape& b);

namespace random_pairs {

using oracle::Random;

ReportShape plain(collision::Shape shape);
ReportShape hullOf(std::vector<Eigen::Vector3d> points);

/// Sizes are 0.2 to 1 m.
double length(Random& r);
Eigen::Vector3d lengths(Random& r);
ReportShape sphere(Random& r);
ReportShape capsule(Random& r);
ReportShape box(Random& r);
ReportShape cylinder(Random& r);
ReportShape cone(Random& r);
ReportShape ellipsoid(Random& r);
ReportShape halfSpace(Random& r);
/// All points lie on an ellipsoid, so all are vertices.
ReportShape roundHull(Random& r, int vertices);
template <int kVertices>
ReportShape hull(Random& r) {
  return roundHull(r, kVertices);
}
using MakeShape = ReportShape (*)(Random&);

struct Placed {
  ReportShape a, b;
  collision::Pose X_WA, X_WB;
};

/// Random orientations, centres 1.1 to 2 bounding radii apart.
Placed placeAnyhow(Random& r, ReportShape a, ReportShape b);
/// Moves B along the separating direction until about `gap` remains. This is approximate; the
/// oracle supplies the truth.
void setGap(Placed& p, double gap);
/// Apart by 1 to 100 % of the sizes.
Placed placeApart(Random& r, ReportShape a, ReportShape b);
/// Moves B into contact, then deeper by a share of the smaller body, or less if that body is thin
/// there.
Placed placeOverlapping(Random& r, ReportShape a, ReportShape b, double least, double most);

}  // namespace random_pairs
}  // namespace leeway::tools::report
