// FCL 0.7 with its two solvers, as Debian builds it.

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "leeway/collision/convex_hull.h"
#include "tools/report/fcl_mesh_rival.h"
#include "tools/report/rivals.h"

namespace leeway::tools::report {
namespace {

using collision::Shape;
using collision::ShapeType;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

/// The points as given; facets by the first point that equals each vertex. A set without facets is
/// one polygon: FCL looks at faces only above 32 vertices.
Geometry makeConvex(const ReportShape& s) {
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

Geometry makeGeometry(const ReportShape& s) {
  const Shape& shape = s.shape;
  const double radius = shape.radius(), length = 2 * shape.halfLength();
  switch (shape.type()) {
    case ShapeType::kSphere:
      return std::make_shared<fcl::Sphered>(radius);
    case ShapeType::kCapsule:
      return std::make_shared<fcl::Capsuled>(radius, length);
    case ShapeType::kBox:
      return std::make_shared<fcl::Boxd>(fcl::Vector3d(2 * shape.halfExtents()));
    case ShapeType::kCylinder:
      return std::make_shared<fcl::Cylinderd>(radius, length);
    case ShapeType::kCone:
      return std::make_shared<fcl::Coned>(radius, length);
    case ShapeType::kEllipsoid:
      return std::make_shared<fcl::Ellipsoidd>(fcl::Vector3d(shape.halfExtents()));
    case ShapeType::kConvexHull:
      return makeConvex(s);
    default:  // half-spaces (FCL has no distances from half-spaces, only contacts) and meshes
      break;
  }
  return nullptr;
}

fcl::Transform3d makeTransform(const collision::Pose& pose) {
  fcl::Transform3d X = fcl::Transform3d::Identity();
  X.linear() = pose.rotation;
  X.translation() = pose.translation;
  return X;
}

/// Signed where the case overlaps. FCL's distance queries take no warm start.
class FclQuery : public PairQuery {
 public:
  FclQuery(Geometry a, Geometry b, const PairSpec& spec, fcl::GJKSolverType solver)
      : a_(std::move(a)),
        b_(std::move(b)),
        X_WA_(makeTransform(spec.X_WA)),
        X_WB_(makeTransform(spec.X_WB)) {
    request_.gjk_solver_type = solver;
    request_.enable_signed_distance = spec.overlap;
    request_.enable_nearest_points = true;
    default_tolerance_ = request_.distance_tolerance;
  }

  PairAnswer ask(double tolerance) override {
    request_.distance_tolerance = std::isnan(tolerance) ? default_tolerance_ : tolerance;
    fcl::DistanceResultd result;
    fcl::distance(a_.get(), X_WA_, b_.get(), X_WB_, request_, result);
    const double d = result.min_distance;
    // What it returns where it has no such function at all.
    if (d == std::numeric_limits<double>::max())
      return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    return {d, d};
  }

 private:
  Geometry a_, b_;
  fcl::Transform3d X_WA_, X_WB_;
  fcl::DistanceRequestd request_;
  double default_tolerance_ = 0;
};

/// The depth of a contact: what the independent solver has for overlaps instead of a signed
/// distance, and what libccd answers by portal refinement when asked for contacts.
class FclContactQuery : public PairQuery {
 public:
  FclContactQuery(Geometry a, Geometry b, const PairSpec& spec, fcl::GJKSolverType solver)
      : a_(std::move(a)),
        b_(std::move(b)),
        X_WA_(makeTransform(spec.X_WA)),
        X_WB_(makeTransform(spec.X_WB)),
        request_(1, true) {
    request_.gjk_solver_type = solver;
    default_tolerance_ = request_.gjk_tolerance;
  }

  PairAnswer ask(double tolerance) override {
    request_.gjk_tolerance = std::isnan(tolerance) ? default_tolerance_ : tolerance;
    fcl::CollisionResultd result;
    fcl::collide(a_.get(), X_WA_, b_.get(), X_WB_, request_, result);
    // Without a contact it says that they are apart, not how far.
    if (result.numContacts() == 0)
      return {std::numeric_limits<double>::min(), std::numeric_limits<double>::min()};
    const double depth = std::abs(result.getContact(0).penetration_depth);
    return {-depth, -depth};
  }

 private:
  Geometry a_, b_;
  fcl::Transform3d X_WA_, X_WB_;
  fcl::CollisionRequestd request_;
  double default_tolerance_ = 0;
};

class FclEngine : public PairEngine {
 public:
  enum class Use { kDistances, kContacts };
  FclEngine(const char* name, fcl::GJKSolverType solver, Use use)
      : name_(name), solver_(solver), use_(use) {}
  const char* name() const override { return name_; }
  bool hasTolerance() const override { return true; }
  std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool) const override {
    Geometry a = makeGeometry(*spec.a), b = makeGeometry(*spec.b);
    if (!a || !b || (use_ == Use::kContacts && !spec.overlap)) return nullptr;
    const bool contact = use_ == Use::kContacts || (spec.overlap && solver_ == fcl::GST_INDEP);
    if (contact)
      return std::make_unique<FclContactQuery>(std::move(a), std::move(b), spec, solver_);
    return std::make_unique<FclQuery>(std::move(a), std::move(b), spec, solver_);
  }

 private:
  const char* name_;
  fcl::GJKSolverType solver_;
  Use use_;
};

}  // namespace
}  // namespace leeway::tools::report

extern "C" leeway::tools::report::Rivals* leewayMakeRivals2() {
  using namespace leeway::tools::report;
  auto rivals = std::make_unique<Rivals>();
  const auto add = [&](const char* name, fcl::GJKSolverType solver, FclEngine::Use use) {
    rivals->pairs.push_back(std::make_unique<FclEngine>(name, solver, use));
  };
  add("FCL libccd", fcl::GST_LIBCCD, FclEngine::Use::kDistances);
  add("FCL indep", fcl::GST_INDEP, FclEngine::Use::kDistances);
  add("FCL contact", fcl::GST_LIBCCD, FclEngine::Use::kContacts);
  rivals->meshes = makeFclMeshEngines();
  return rivals.release();
}
