// Bullet 3 in double precision, as Debian builds it. Margins are 0, except for spheres and
// capsules, whose margin is their radius.

#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btPointCollector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include <limits>

#include "tools/lab/base/rivals.h"
#include "tools/lab/rivals/bullet_mesh_rival.h"
#include "tools/lab/rivals/bullet_motion_rival.h"
#include "tools/lab/rivals/bullet_shape_rival.h"

namespace leeway::tools::report {
namespace {

using collision::Shape;
using collision::ShapeType;
using BulletShape = std::unique_ptr<btConvexShape>;

constexpr double kFailed = std::numeric_limits<double>::quiet_NaN();

/// Radius around the shape's core.
double roundness(const Shape& shape) {
  return shape.type() == ShapeType::kSphere || shape.type() == ShapeType::kCapsule ? shape.radius()
                                                                                   : 0;
}

/// btGjkEpaSolver2: GJK between cores, EPA where they overlap.
class Epa2Query : public PairQuery {
 public:
  Epa2Query(BulletShape a, BulletShape b, const PairSpec& spec)
      : a_(std::move(a)),
        b_(std::move(b)),
        X_WA_(toBullet(spec.X_WA)),
        X_WB_(toBullet(spec.X_WB)),
        radii_(roundness(spec.a->shape) + roundness(spec.b->shape)) {}

  PairAnswer ask(double) override {
    btGjkEpaSolver2::sResults results;
    const btVector3 guess = X_WB_.getOrigin() - X_WA_.getOrigin();
    if (btGjkEpaSolver2::Distance(a_.get(), X_WA_, b_.get(), X_WB_, guess, results))
      return {results.distance - radii_, results.distance - radii_};
    if (btGjkEpaSolver2::Penetration(a_.get(), X_WA_, b_.get(), X_WB_, guess, results, true))
      return {results.distance, results.distance};
    return {kFailed, kFailed};
  }

 private:
  BulletShape a_, b_;
  btTransform X_WA_, X_WB_;
  double radii_;
};

/// btGjkPairDetector over that EPA: the combination in Bullet's own narrow phase.
class DetectorQuery : public PairQuery {
 public:
  DetectorQuery(BulletShape a, BulletShape b, const PairSpec& spec)
      : a_(std::move(a)), b_(std::move(b)) {
    input_.m_transformA = toBullet(spec.X_WA);
    input_.m_transformB = toBullet(spec.X_WB);
  }

  PairAnswer ask(double) override {
    btVoronoiSimplexSolver simplex;
    btGjkEpaPenetrationDepthSolver depth;
    btGjkPairDetector detector(a_.get(), b_.get(), &simplex, &depth);
    btPointCollector result;
    detector.getClosestPoints(input_, result, nullptr);
    if (!result.m_hasResult) return {kFailed, kFailed};
    return {result.m_distance, result.m_distance};
  }

 private:
  BulletShape a_, b_;
  btDiscreteCollisionDetectorInterface::ClosestPointInput input_;
};

template <typename Query>
class BulletEngine : public PairEngine {
 public:
  explicit BulletEngine(const char* name) : name_(name) {}
  const char* name() const override { return name_; }
  bool hasTolerance() const override { return false; }
  std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool) const override {
    BulletShape a = makeBulletShape(*spec.a), b = makeBulletShape(*spec.b);
    if (!a || !b) return nullptr;
    return std::make_unique<Query>(std::move(a), std::move(b), spec);
  }

 private:
  const char* name_;
};

}  // namespace
}  // namespace leeway::tools::report

extern "C" leeway::tools::report::Rivals* leewayMakeRivals5() {
  using namespace leeway::tools::report;
  auto rivals = std::make_unique<Rivals>();
  rivals->pairs.push_back(std::make_unique<BulletEngine<Epa2Query>>("Bullet epa2"));
  rivals->pairs.push_back(std::make_unique<BulletEngine<DetectorQuery>>("Bullet detector"));
  rivals->meshes = makeBulletMeshEngines();
  rivals->motions = makeBulletMotionEngines();
  return rivals.release();
}
