#include "tools/lab/rivals/bullet_motion_rival.h"

#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkConvexCast.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include "tools/lab/rivals/bullet_shape_rival.h"

namespace leeway::tools::report {
namespace {

using BulletShapes = std::vector<std::unique_ptr<btConvexShape>>;

struct Continuous {
  static constexpr const char* kName = "Bullet continuous";
  static constexpr bool kTurns = true;
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth;
  btContinuousConvexCollision cast;
  Continuous(const btConvexShape* a, const btConvexShape* b) : cast(a, b, &simplex, &depth) {}
};

struct GjkCast {
  static constexpr const char* kName = "Bullet GJK cast";
  static constexpr bool kTurns = false;
  btVoronoiSimplexSolver simplex;
  btGjkConvexCast cast;
  GjkCast(const btConvexShape* a, const btConvexShape* b) : cast(a, b, &simplex) {}
};

template <typename Cast>
class BulletQuery : public ContactQuery {
 public:
  BulletQuery(const ContactSpec& spec, BulletShapes shapes)
      : spec_(spec), shapes_(std::move(shapes)) {}

  ContactAnswer ask() override {
    return firstOfPieces(
        spec_, [&](std::size_t pair, const collision::Pose& a0, const collision::Pose& a1,
                   const collision::Pose& b0, const collision::Pose& b1) {
          Cast cast(shapes_[spec_.pairs[pair][0]].get(), shapes_[spec_.pairs[pair][1]].get());
          btConvexCast::CastResult result;
          result.m_fraction = 1;
          const bool hit = cast.cast.calcTimeOfImpact(toBullet(a0), toBullet(a1), toBullet(b0),
                                                      toBullet(b1), result);
          return hit ? result.m_fraction : -1;
        });
  }

 private:
  ContactSpec spec_;
  BulletShapes shapes_;
};

bool turns(const ContactSpec& spec) {
  for (const MovingBody& body : spec.bodies)
    if (!body.straight || body.motion->bound(0, 1).angular_speed > 1e-12) return true;
  return false;
}

template <typename Cast>
class BulletEngine : public ContactEngine {
 public:
  const char* name() const override { return Cast::kName; }
  std::unique_ptr<ContactQuery> prepare(const ContactSpec& spec) const override {
    if (spec.bodies.empty() || (!Cast::kTurns && turns(spec))) return nullptr;
    BulletShapes shapes;
    for (const MovingBody& body : spec.bodies) {
      shapes.push_back(makeBulletShape(*body.shape));
      if (!shapes.back()) return nullptr;
    }
    return std::make_unique<BulletQuery<Cast>>(spec, std::move(shapes));
  }
};

}  // namespace

std::vector<std::unique_ptr<ContactEngine>> makeBulletMotionEngines() {
  std::vector<std::unique_ptr<ContactEngine>> engines;
  engines.push_back(std::make_unique<BulletEngine<Continuous>>());
  engines.push_back(std::make_unique<BulletEngine<GjkCast>>());
  return engines;
}

}  // namespace leeway::tools::report
