#include "tools/lab/rivals/fcl_motion_rival.h"

#include <fcl/narrowphase/continuous_collision.h>
#include <fcl/narrowphase/detail/traversal/collision/intersect.h>

#include <algorithm>

#include "leeway/collision/triangle_mesh.h"
#include "tools/lab/rivals/fcl_shape_rival.h"

namespace leeway::tools::report {
namespace {

using collision::MovingTriangle;
using Motion = fcl::InterpMotion<double>;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

/// Null if FCL has no motion of this shape.
Geometry geometryOf(const ReportShape& s) {
  if (s.shape.type() != collision::ShapeType::kMesh) return makeFclShape(s);
  return lab::fclMesh(s.shape.mesh()->vertices(), s.shape.mesh()->triangles());
}

/// Sets the point that travels straight, because FCL's default reads uninitialised memory.
Motion motionOf(const collision::Pose& X0, const collision::Pose& X1) {
  return Motion(X0.rotation, X0.translation, X1.rotation, X1.translation, fcl::Vector3d::Zero());
}

class FclContactQuery : public ContactQuery {
 public:
  FclContactQuery(const ContactSpec& spec, std::vector<Geometry> geometries,
                  const fcl::ContinuousCollisionRequestd& request)
      : spec_(spec), geometries_(std::move(geometries)), request_(request) {
    // The step count covers the whole motion, so curved motions are unsupported.
    if (std::any_of(spec.bodies.begin(), spec.bodies.end(),
                    [](const MovingBody& body) { return !body.straight; }))
      request_.num_max_iterations /= kMotionPieces;
  }

  ContactAnswer ask() override {
    return firstOfPieces(spec_, [&](std::size_t pair, const collision::Pose& a0,
                                    const collision::Pose& a1, const collision::Pose& b0,
                                    const collision::Pose& b1) {
      fcl::ContinuousCollisionResultd result;
      const Motion motion_a = motionOf(a0, a1), motion_b = motionOf(b0, b1);
      fcl::continuousCollide(geometries_[spec_.pairs[pair][0]].get(), &motion_a,
                             geometries_[spec_.pairs[pair][1]].get(), &motion_b, request_, result);
      return result.is_collide ? result.time_of_contact : -1;
    });
  }

 private:
  ContactSpec spec_;
  std::vector<Geometry> geometries_;
  fcl::ContinuousCollisionRequestd request_;
};

class FclEngine : public ContactEngine {
 public:
  FclEngine(const char* name, fcl::CCDSolverType solver, std::size_t iterations)
      : name_(name), request_(iterations, 1e-6, fcl::CCDM_LINEAR, fcl::GST_LIBCCD, solver) {}
  const char* name() const override { return name_; }
  std::unique_ptr<ContactQuery> prepare(const ContactSpec& spec) const override {
    if (spec.bodies.empty()) return nullptr;
    std::vector<Geometry> geometries;
    for (const MovingBody& body : spec.bodies) {
      geometries.push_back(geometryOf(*body.shape));
      if (!geometries.back()) return nullptr;
    }
    return std::make_unique<FclContactQuery>(spec, std::move(geometries), request_);
  }

 private:
  const char* name_;
  fcl::ContinuousCollisionRequestd request_;
};

/// All corners against the other triangle, all pairs of edges.
class PolynomialQuery : public ContactQuery {
 public:
  explicit PolynomialQuery(const ContactSpec& spec)
      : a_(spec.triangles[0]), b_(spec.triangles[1]) {}

  ContactAnswer ask() override {
    using Intersect = fcl::detail::Intersect<double>;
    ContactAnswer first;
    double time = 0;
    fcl::Vector3d point;
    const auto offer = [&](bool found) {
      if (found && (!first.contact || time < first.upper)) first = {true, false, time, time};
    };
    const auto corners = [&](const MovingTriangle& t, const MovingTriangle& p) {
      for (std::size_t i = 0; i < 3; ++i)
        offer(Intersect::intersect_VF(t.from[0], t.from[1], t.from[2], p.from[i], t.to[0], t.to[1],
                                      t.to[2], p.to[i], &time, &point));
    };
    corners(a_, b_);
    corners(b_, a_);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const std::size_t k = (i + 1) % 3, l = (j + 1) % 3;
        offer(Intersect::intersect_EE(a_.from[i], a_.from[k], b_.from[j], b_.from[l], a_.to[i],
                                      a_.to[k], b_.to[j], b_.to[l], &time, &point));
      }
    return first;
  }

 private:
  MovingTriangle a_, b_;
};

class PolynomialEngine : public ContactEngine {
 public:
  const char* name() const override { return "FCL polynomial"; }
  std::unique_ptr<ContactQuery> prepare(const ContactSpec& spec) const override {
    if (spec.triangles.empty()) return nullptr;
    return std::make_unique<PolynomialQuery>(spec);
  }
};

}  // namespace

std::vector<std::unique_ptr<ContactEngine>> makeFclMotionEngines() {
  std::vector<std::unique_ptr<ContactEngine>> engines;
  engines.push_back(
      std::make_unique<FclEngine>("FCL advancement", fcl::CCDC_CONSERVATIVE_ADVANCEMENT, 1000));
  engines.push_back(std::make_unique<FclEngine>("FCL 1000 steps", fcl::CCDC_NAIVE, 1000));
  engines.push_back(std::make_unique<PolynomialEngine>());
  return engines;
}

}  // namespace leeway::tools::report
