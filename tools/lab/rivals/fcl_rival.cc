// FCL 0.7 with its two solvers, as Debian builds it.

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <cmath>
#include <limits>

#include "tools/lab/base/rivals.h"
#include "tools/lab/rivals/fcl_mesh_rival.h"
#include "tools/lab/rivals/fcl_motion_rival.h"
#include "tools/lab/rivals/fcl_shape_rival.h"
#include "tools/lab/rivals/fcl_state_rival.h"

namespace leeway::tools::report {
namespace {

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

/// Signed distance in overlap. FCL's distance queries have no warm start.
class FclQuery : public PairQuery {
 public:
  FclQuery(Geometry a, Geometry b, const PairSpec& spec, fcl::GJKSolverType solver)
      : a_(std::move(a)),
        b_(std::move(b)),
        X_WA_(lab::isometry(spec.X_WA)),
        X_WB_(lab::isometry(spec.X_WB)) {
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
    // FCL's value for a missing function.
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

/// Depth of a contact: the independent solver's only answer in overlap, and libccd's portal
/// refinement (MPR).
class FclContactQuery : public PairQuery {
 public:
  FclContactQuery(Geometry a, Geometry b, const PairSpec& spec, fcl::GJKSolverType solver)
      : a_(std::move(a)),
        b_(std::move(b)),
        X_WA_(lab::isometry(spec.X_WA)),
        X_WB_(lab::isometry(spec.X_WB)),
        request_(1, true) {
    request_.gjk_solver_type = solver;
    default_tolerance_ = request_.gjk_tolerance;
  }

  PairAnswer ask(double tolerance) override {
    request_.gjk_tolerance = std::isnan(tolerance) ? default_tolerance_ : tolerance;
    fcl::CollisionResultd result;
    fcl::collide(a_.get(), X_WA_, b_.get(), X_WB_, request_, result);
    // No contact: apart by an unknown distance.
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
    Geometry a = makeFclShape(*spec.a), b = makeFclShape(*spec.b);
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

extern "C" leeway::tools::report::Rivals* leewayMakeRivals5() {
  using namespace leeway::tools::report;
  auto rivals = std::make_unique<Rivals>();
  const auto add = [&](const char* name, fcl::GJKSolverType solver, FclEngine::Use use) {
    rivals->pairs.push_back(std::make_unique<FclEngine>(name, solver, use));
  };
  add("FCL libccd", fcl::GST_LIBCCD, FclEngine::Use::kDistances);
  add("FCL indep", fcl::GST_INDEP, FclEngine::Use::kDistances);
  add("FCL contact", fcl::GST_LIBCCD, FclEngine::Use::kContacts);
  rivals->meshes = makeFclMeshEngines();
  rivals->motions = makeFclMotionEngines();
  rivals->states.push_back(makeFclStateEngine());
  return rivals.release();
}
