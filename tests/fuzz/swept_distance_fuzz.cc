// Any sweep: at every intermediate time, with matrix and translation blended (a placement inside
// the hull of both ends), the body is no nearer than the proven lower bound.

#include <cmath>

#include "leeway/collision/distance.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tools/truth/oracle/generate.h"
#include "tools/truth/oracle/oracle.h"

namespace leeway::fuzz {
std::vector<std::string> seedInputs() { return {}; }
std::vector<std::string> dictionary() { return {}; }
}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leeway;
  using collision::DistanceStatus;
  using collision::Pose;
  using collision::Shape;
  using collision::ShapeType;
  static collision::Scratch scratch;
  fuzz::ByteReader bytes({data, size});
  const Pose X_BA0 = bytes.pose();
  const Pose X_BA1 = bytes.below(8) == 0 ? X_BA0 : bytes.pose();
  const double growth = bytes.size();
  collision::DistanceRequest request;
  if (bytes.below(3) == 0) request.threshold = bytes.number();
  if (bytes.below(4) == 0) request.iteration_limit = bytes.below(8);
  const std::optional<Shape> a = fuzz::readShape(bytes), b = fuzz::readShape(bytes);
  if (!a || !b) return 0;
  const auto r = collision::sweptDistance(*a, X_BA0, X_BA1, growth, *b, request, scratch);
  if (!(r.distance.lower <= r.distance.upper))
    fuzz::fail("interval [%.17g, %.17g]", r.distance.lower, r.distance.upper);
  if (r.status == DistanceStatus::kInvalid || !(growth >= 0)) return 0;
  const auto rotationLike = [](const Pose& X) {
    return (X.rotation.transpose() * X.rotation - Eigen::Matrix3d::Identity())
               .cwiseAbs()
               .maxCoeff() < 1e-12;
  };
  if (!rotationLike(X_BA0) || !rotationLike(X_BA1)) return 0;
  // A rotating half-space sweeps everything, and its blends are not half-spaces.
  if (a->type() == ShapeType::kHalfSpace) return 0;

  const auto describe = [&] {
    std::fprintf(stderr, "A %s\n  from %s\n  to %s\n  growth %.17g\nB %s\n",
                 oracle::replay(*a).c_str(), oracle::replay(X_BA0).c_str(),
                 oracle::replay(X_BA1).c_str(), growth, oracle::replay(*b).c_str());
  };
  double best_end = HUGE_VAL;
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    // Powers of two: the blend is exact up to rounding of its entries.
    const Pose X{(1 - t) * X_BA0.rotation + t * X_BA1.rotation,
                 (1 - t) * X_BA0.translation + t * X_BA1.translation};
    const oracle::Truth truth = oracle::signedSeparation(*a, X, *b, Pose{});
    if (t == 0 || t == 1) best_end = std::min(best_end, truth.lower);
    // Surfaces are swept: containment is out of scope.
    if (!a->isConvex() && truth.upper < 0) continue;
    if (!b->isConvex() && truth.upper < 0) continue;
    const double rounding = 1e-15 * (oracle::sizeOf(*a) + X.translation.norm());
    if (!(r.distance.lower > truth.upper - growth + rounding) || !std::isfinite(truth.upper))
      continue;
    describe();
    fuzz::fail("at t = %g the truth [%.17g, %.17g] is below the bound %.17g", t, truth.lower,
               truth.upper, r.distance.lower);
  }
  if (r.distance.upper < best_end && std::isfinite(best_end)) {
    describe();
    fuzz::fail("upper end %.17g, but both ends of the sweep are at least %.17g away",
               r.distance.upper, best_end);
  }
  return 0;
}
