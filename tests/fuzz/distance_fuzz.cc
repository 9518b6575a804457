// Any two shapes at any poses: the interval is ordered and agrees with the oracle, swapped
// arguments agree, and refusals have a reason.

#include <cmath>

#include "leeway/collision/distance.h"
#include "tests/fuzz/shapes.h"
#include "tests/fuzz/target.h"
#include "tools/truth/oracle/generate.h"
#include "tools/truth/oracle/oracle.h"

namespace {

using namespace leeway;
using collision::DistanceRequest;
using collision::DistanceResult;
using collision::DistanceStatus;
using collision::Pose;
using collision::Shape;
using collision::ShapeType;

/// More lenient than the engine: it must refuse poses that fail this, and accept those well within.
double departure(const Pose& X) {
  if (!X.rotation.allFinite() || !X.translation.allFinite()) return HUGE_VAL;
  const double value =
      (X.rotation.transpose() * X.rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  return std::isfinite(value) && X.rotation.determinant() > 0 ? value : HUGE_VAL;
}

void describe(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  std::fprintf(stderr, "A %s\n  %s\nB %s\n  %s\n", oracle::replay(a).c_str(),
               oracle::replay(X_WA).c_str(), oracle::replay(b).c_str(),
               oracle::replay(X_WB).c_str());
}

void checkStatus(const DistanceResult& r, const DistanceRequest& request,
                 double default_tolerance) {
  const collision::Interval& d = r.distance;
  if (!(d.lower <= d.upper)) fuzz::fail("interval [%.17g, %.17g]", d.lower, d.upper);
  const double tolerance = std::isnan(request.tolerance) ? default_tolerance : request.tolerance;
  const bool honest =
      r.status == DistanceStatus::kConverged           ? d.width() <= tolerance
      : r.status == DistanceStatus::kAboveThreshold    ? d.lower > request.threshold
      : r.status == DistanceStatus::kNotAboveThreshold ? d.upper <= request.threshold
      : r.status == DistanceStatus::kOverlap           ? !request.depth && d.upper <= 0
      : r.status == DistanceStatus::kInvalid           ? d.lower == -HUGE_VAL && d.upper == HUGE_VAL
                                                       : true;
  if (!honest)
    fuzz::fail("status %d with [%.17g, %.17g]", static_cast<int>(r.status), d.lower, d.upper);
}

}  // namespace

namespace leeway::fuzz {
std::vector<std::string> seedInputs() { return {}; }
std::vector<std::string> dictionary() { return {}; }
}  // namespace leeway::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static collision::Scratch scratch;
  fuzz::ByteReader bytes({data, size});
  const Pose X_WA = bytes.pose();
  Pose X_WB = bytes.pose();
  if (bytes.below(8) == 0) X_WB = X_WA;  // concentric
  DistanceRequest request;
  if (bytes.below(3) == 0) request.threshold = bytes.number();
  if (bytes.below(4) == 0) request.iteration_limit = bytes.below(8);
  if (bytes.below(4) == 0) request.node_limit = bytes.below(8);
  if (bytes.below(8) == 0) request.tolerance = bytes.number();
  request.depth = bytes.below(4) != 0;
  const std::optional<Shape> a = fuzz::readShape(bytes), b = fuzz::readShape(bytes);
  if (!a || !b) return 0;

  const DistanceResult r = collision::distance(*a, X_WA, *b, X_WB, request, scratch);
  const DistanceResult swapped = collision::distance(*b, X_WB, *a, X_WA, request, scratch);
  collision::PairCache cache;
  cache.direction_B = Eigen::Vector3d(bytes.number(), bytes.number(), bytes.number());
  cache.vertex_a = bytes.byte() - 128;
  cache.vertex_b = 1 << bytes.below(31);
  cache.triangle_a = bytes.byte();
  const DistanceResult cached = collision::distance(*a, X_WA, *b, X_WB, request, scratch, &cache);

  const bool halves = a->type() == ShapeType::kHalfSpace && b->type() == ShapeType::kHalfSpace;
  const double off = std::max(departure(X_WA), departure(X_WB));
  for (const DistanceResult& each : {r, swapped, cached}) {
    bool wrong = false;
    // Refused without reason, or accepted without being a rotation.
    if (each.status == DistanceStatus::kInvalid && !halves && off < 1e-12 &&
        (X_WA.translation - X_WB.translation).lpNorm<1>() < 0.999e10)
      wrong = true;
    if (each.status != DistanceStatus::kInvalid && (halves || off > 1e-2)) wrong = true;
    if (wrong) {
      describe(*a, X_WA, *b, X_WB);
      fuzz::fail("status %d, departure from a rotation %g", static_cast<int>(each.status), off);
    }
    checkStatus(each, request, collision::defaultTolerance(*a, X_WA, *b, X_WB));
  }
  if (r.status == DistanceStatus::kInvalid || off > 1e-12) return 0;

  const oracle::Truth truth = oracle::signedSeparation(*a, X_WA, *b, X_WB);
  for (const DistanceResult& each : {r, swapped, cached}) {
    if (each.distance.lower <= truth.upper && each.distance.upper >= truth.lower) continue;
    if (!std::isfinite(truth.lower) || !std::isfinite(truth.upper))
      continue;  // beyond double: nothing to check
    describe(*a, X_WA, *b, X_WB);
    fuzz::fail("truth [%.17g, %.17g] is outside [%.17g, %.17g]", truth.lower, truth.upper,
               each.distance.lower, each.distance.upper);
  }
  return 0;
}
