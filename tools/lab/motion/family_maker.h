#pragma once

// Helpers for the families of `report motion`: bodies in the engine's and the truth's form, simple
// motions, and cases with their truth.

#include <Eigen/Geometry>
#include <deque>
#include <functional>

#include "tools/lab/motion/contact_family.h"
#include "tools/lab/motion/motion_truth.h"
#include "tools/truth/oracle/generate.h"

namespace leeway::tools::report::motion_families {

using collision::Pose;
using collision::Shape;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using oracle::Random;

/// A shape in the engine's and the truth's form.
struct Body {
  const ReportShape* shape = nullptr;
  const SlowPolytope* slow = nullptr;
};

/// From `start`, the origin moves straight while the body turns about a fixed world axis.
struct Move {
  Pose start;
  Vector3d travel = Vector3d::Zero(), axis = Vector3d::UnitZ();  // [m], unit
  double angle = 0;                                              // [rad], up to half a turn

  Pose at(double t) const {
    return {slowTurn(axis, t * angle) * start.rotation, start.translation + t * travel};
  }
};

/// Three uniform numbers, drawn in order.
inline Vector3d sizes(Random& random, double least, double most) {
  const double x = random.uniform(least, most), y = random.uniform(least, most);
  return {x, y, random.uniform(least, most)};
}

/// Random direction and length.
inline Vector3d vector(Random& random, double least, double most) {
  const double length = random.uniform(least, most);
  return length * random.direction();
}

inline Pose placed(const Vector3d& p, const Matrix3d& R = Matrix3d::Identity()) { return {R, p}; }

/// Builds one family.
class FamilyMaker {
 public:
  FamilyMaker(const std::string& name, std::uint64_t seed) : random(seed) { family.name = name; }

  Random random;
  ContactFamily family;

  Body box(const Vector3d& half) { return add({Shape::box(half), {}}, slowBox(half)); }
  Body boxMesh(const Vector3d& half) {
    return add({Shape::mesh(oracle::boxMesh(half)), {}}, slowBox(half));
  }
  /// A shape whose truth is known by construction.
  const ReportShape* known(const Shape& shape) { return add({shape, {}}, {}).shape; }
  /// Eight points on an ellipsoid.
  Body hull() {
    std::vector<Vector3d> points(8);
    const Vector3d size = sizes(random, 0.1, 0.5);
    for (Vector3d& p : points) p = size.cwiseProduct(random.direction());
    return add({Shape::convexHull(points), points}, slowHull(points));
  }
  Body box(double least, double most) { return box(sizes(random, least, most)); }

  /// Properties that the construction guarantees.
  enum class Known { kNothing, kApartAtStart, kFree };

  /// Adds the pair if its truth is clear and, where required, it starts apart. A random change of
  /// frame breaks alignment with the axes.
  void keep(const Body& a, Move move_a, const Body& b, Move move_b, Known known = Known::kNothing);

  void keep(ContactCase c, const TimeTruth& truth) {
    if (!truth.clear) return;
    c.contact = truth.contact, c.lower = truth.lower, c.upper = truth.upper;
    family.cases.push_back(std::move(c));
  }

  /// Reuses one of up to 64 bodies, for shapes that are expensive to make.
  Body pooled(const std::function<Body(FamilyMaker&)>& make) {
    if (pool_.size() < 64) {
      pool_.push_back(make(*this));
      return pool_.back();
    }
    return pool_[static_cast<std::size_t>(random.below(64))];
  }

 private:
  Body add(ReportShape shape, SlowPolytope polytope) {
    family.shapes.push_back(std::make_unique<ReportShape>(std::move(shape)));
    slow_.push_back(std::move(polytope));
    return {family.shapes.back().get(), &slow_.back()};
  }

  std::deque<SlowPolytope> slow_;
  std::vector<Body> pool_;
};

}  // namespace leeway::tools::report::motion_families
