#include "tools/lab/rivals/fcl_shape_rival.h"

#include <fcl/geometry/shape/convex.h>

#include <array>
#include <map>

#include "leeway/collision/convex_hull.h"

namespace leeway::tools::report {

using lab::FclGeometry;

namespace {

/// Uses the points as given; facets refer to the first point equal to each vertex. A set without
/// facets becomes one polygon, because FCL reads faces only above 32 vertices.
FclGeometry makeConvex(const ReportShape& s) {
  const auto vertices = std::make_shared<std::vector<fcl::Vector3d>>(s.points);
  const auto faces = std::make_shared<std::vector<int>>();
  std::map<std::array<double, 3>, int> first;
  for (std::size_t i = 0; i < s.points.size(); ++i)
    first.insert({{s.points[i].x(), s.points[i].y(), s.points[i].z()}, static_cast<int>(i)});
  const auto index = [&](std::int32_t i) {
    const Eigen::Vector3d& v = s.shape.hull()->vertices()[static_cast<std::size_t>(i)];
    return first.at({v.x(), v.y(), v.z()});
  };
  int count = 0;
  for (const auto& facet : s.shape.hull()->facets()) {
    faces->insert(faces->end(), {3, index(facet[0]), index(facet[1]), index(facet[2])});
    ++count;
  }
  if (count == 0) {
    faces->push_back(static_cast<int>(s.points.size()));
    for (std::size_t i = 0; i < s.points.size(); ++i) faces->push_back(static_cast<int>(i));
    count = 1;
  }
  return std::make_shared<fcl::Convexd>(vertices, count, faces);
}

}  // namespace

FclGeometry makeFclShape(const ReportShape& s) {
  switch (s.shape.type()) {
    case collision::ShapeType::kConvexHull:
      return makeConvex(s);
    case collision::ShapeType::kHalfSpace:
    case collision::ShapeType::kMesh:
    case collision::ShapeType::kDeformable:
      return nullptr;
    default:
      return lab::toFcl(s.shape);
  }
}

}  // namespace leeway::tools::report
