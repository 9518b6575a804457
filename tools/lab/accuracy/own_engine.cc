#include "tools/lab/accuracy/own_engine.h"

#include <cmath>

#include "leeway/collision/distance.h"

namespace leeway::tools::report {
namespace {

using collision::DistanceRequest;
using collision::PairCache;
using collision::Scratch;

Scratch& scratch() {
  thread_local Scratch instance;
  return instance;
}

class OwnQuery : public PairQuery {
 public:
  OwnQuery(const PairSpec& spec, const DistanceRequest& request, bool warm)
      : a_(spec.a->shape),
        b_(spec.b->shape),
        X_WA_(spec.X_WA),
        X_WB_(spec.X_WB),
        request_(request),
        warm_(warm) {}

  PairAnswer ask(double tolerance) override {
    request_.tolerance = tolerance;
    const collision::DistanceResult result =
        collision::distance(a_, X_WA_, b_, X_WB_, request_, scratch(), warm_ ? &cache_ : nullptr);
    return {result.distance.lower, result.distance.upper};
  }

  void follow(const PairQuery* previous) override {
    cache_ = previous == nullptr ? PairCache{} : static_cast<const OwnQuery*>(previous)->cache_;
  }

 private:
  collision::Shape a_, b_;
  collision::Pose X_WA_, X_WB_;
  DistanceRequest request_;
  PairCache cache_;
  bool warm_;
};

class DistanceEngine : public PairEngine {
 public:
  const char* name() const override { return "leeway"; }
  bool hasTolerance() const override { return true; }
  bool claimsBounds() const override { return true; }
  std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool warm) const override {
    return std::make_unique<OwnQuery>(spec, DistanceRequest{}, warm);
  }
};

class ThresholdEngine : public PairEngine {
 public:
  const char* name() const override { return "leeway d > t?"; }
  bool hasTolerance() const override { return false; }
  bool claimsBounds() const override { return true; }
  bool tellsDistance() const override { return false; }
  std::unique_ptr<PairQuery> prepare(const PairSpec& spec, bool warm) const override {
    DistanceRequest request;
    request.threshold = (farther_ ? 0.5 : 1.5) * spec.distance;
    request.depth = spec.overlap;
    farther_ = !farther_;
    return std::make_unique<OwnQuery>(spec, request, warm);
  }

 private:
  mutable bool farther_ = true;
};

}  // namespace

std::vector<std::unique_ptr<PairEngine>> makeOwnEngines() {
  std::vector<std::unique_ptr<PairEngine>> engines;
  engines.push_back(std::make_unique<DistanceEngine>());
  engines.push_back(std::make_unique<ThresholdEngine>());
  return engines;
}

}  // namespace leeway::tools::report
