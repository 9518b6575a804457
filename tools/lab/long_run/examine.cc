#include "tools/lab/long_run/examine.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace leeway::accuracy {

using collision::DistanceRequest;
using collision::DistanceResult;
using collision::DistanceStatus;
using collision::Pose;
using collision::Shape;
using collision::ShapeType;
using Eigen::Vector3d;

namespace {

constexpr double kUnit = 0x1p-53;
/// Rounding of transforming normals and points into the world frame, and of the second opinion.
constexpr double kAllowed = 16 * kUnit;
constexpr int kMostSaid = 40;

bool honest(const DistanceRequest& request, double default_tolerance, const DistanceResult& r) {
  const auto& d = r.distance;
  switch (r.status) {
    case DistanceStatus::kConverged:
      return d.upper - d.lower <=
             (std::isnan(request.tolerance) ? default_tolerance : request.tolerance);
    case DistanceStatus::kAboveThreshold:
      return d.lower > request.threshold;
    case DistanceStatus::kNotAboveThreshold:
      return d.upper <= request.threshold;
    case DistanceStatus::kOverlap:
      return !request.depth && d.upper <= 0;
    case DistanceStatus::kLimit:
      return true;
    case DistanceStatus::kInvalid:
      return false;
  }
  return false;
}

}  // namespace

void Tally::add(const Tally& t) {
  cases += t.cases, answers += t.answers, overlapping += t.overlapping, unsafe += t.unsafe,
      failures += t.failures, open += t.open, oracle += t.oracle, unproven += t.unproven;
}

void Examiner::say(const char* what, const Ask& ask, const DistanceResult& r, Real value,
                   std::int64_t& count) {
  ++count;
  if (++said_ > kMostSaid && !verbose) return;
  std::fprintf(stderr,
               "%s: %s (%s, tolerance %.17g, threshold %.17g, iterations at most %d): [%.17g, "
               "%.17g] status %d, found %.20Lg\n  A %s\n    %s\n  B %s\n    %s\n",
               says_->c_str(), what, ask.how, ask.request.tolerance, ask.request.threshold,
               ask.request.iteration_limit, r.distance.lower, r.distance.upper,
               static_cast<int>(r.status), value, oracle::replay(*case_->a).c_str(),
               oracle::replay(case_->X_WA).c_str(), oracle::replay(*case_->b).c_str(),
               oracle::replay(case_->X_WB).c_str());
}

DistanceResult Examiner::ask(const Ask& ask) {
  const Case& c = *case_;
  DistanceResult r =
      ask.swapped
          ? collision::distance(*c.b, c.X_WB, *c.a, c.X_WA, ask.request, scratch_, ask.cache)
          : collision::distance(*c.a, c.X_WA, *c.b, c.X_WB, ask.request, scratch_, ask.cache);
  if (ask.swapped) {
    std::swap(r.point_a, r.point_b);
    r.normal = -r.normal;
  }
  ++tally_->answers;
  judge(ask, r);
  if (truth_) holdAgainstOracle(ask, r);
  return r;
}

// The separation that n proves: no point of B is closer to A than this along n.
Real Examiner::provenAlong(const Vector3d& n) const {
  const Vector3d& origin = case_->X_WA.translation;
  const Real apart = -farthestAlong(*case_->b, case_->X_WB, -n, origin) -
                     farthestAlong(*case_->a, case_->X_WA, n, origin);
  const Real x = static_cast<Real>(n.x()), y = static_cast<Real>(n.y()),
             z = static_cast<Real>(n.z());
  return apart / std::sqrt(x * x + y * y + z * z);
}

void Examiner::judge(const Ask& ask, const DistanceResult& r) {
  const bool ordered = r.distance.lower <= r.distance.upper;  // false for NaN
  if (!ordered || !r.point_a.allFinite() || !r.point_b.allFinite() ||
      !(std::abs(r.normal.norm() - 1) < 1e-6)) {
    return say("not numbers, or the ends exchanged", ask, r, 0, tally_->failures);
  }
  if (!honest(ask.request, default_tolerance_, r)) say("status", ask, r, 0, tally_->failures);
  if (half_space_) {
    judgeHalfSpace(ask, r);
  } else {
    judgePlane(ask, r);
  }
  judgeWitness(ask, r);
}

void Examiner::judgePlane(const Ask& ask, const DistanceResult& r) {
  const Real proven = provenAlong(r.normal);
  const Real allowed = static_cast<Real>(kAllowed * size_);
  if (static_cast<Real>(r.distance.upper) < proven - allowed) {
    say("a plane proves more than the upper end", ask, r, proven, tally_->unsafe);
  }
  // For a point and a shape, the closed form's distance is more precise than its direction.
  const bool point =
      case_->a->type() == ShapeType::kSphere || case_->b->type() == ShapeType::kSphere;
  const auto rounded = [](const Shape& s) {
    return s.type() == ShapeType::kSphere || s.type() == ShapeType::kCapsule ? s.radius() : 0;
  };
  const double core = r.distance.upper + rounded(*case_->a) + rounded(*case_->b);
  const Real turned = point ? static_cast<Real>(1 + size_ / std::abs(core)) : 1;
  if (static_cast<Real>(r.distance.lower) > proven + turned * allowed) {
    say("the normal does not prove the lower end", ask, r, proven, tally_->unsafe);
  }
}

void Examiner::judgeHalfSpace(const Ask& ask, const DistanceResult& r) {
  const bool first = case_->a->type() == ShapeType::kHalfSpace;
  const Pose& plane = first ? case_->X_WA : case_->X_WB;
  const Shape& other = first ? *case_->b : *case_->a;
  const Pose& pose = first ? case_->X_WB : case_->X_WA;
  const Vector3d up = plane.rotation.col(2);
  const Real truth = -farthestAlong(other, pose, -up, plane.translation);
  const Real allowed = static_cast<Real>(kAllowed * size_);
  if (static_cast<Real>(r.distance.lower) > truth + allowed ||
      static_cast<Real>(r.distance.upper) < truth - allowed) {
    say("the lowest point is elsewhere", ask, r, truth, tally_->unsafe);
  }
}

// Witness points bound the distance from above.
void Examiner::judgeWitness(const Ask& ask, const DistanceResult& r) {
  // Infinite if a separating plane decided before any witnesses existed.
  if (!(r.distance.lower > 0) || !std::isfinite(r.distance.upper)) return;
  const Real apart = static_cast<Real>((r.point_b - r.point_a).norm());
  const Real out_a = outsideBy(*case_->a, case_->X_WA, r.point_a),
             out_b = outsideBy(*case_->b, case_->X_WB, r.point_b);
  const Real allowed = static_cast<Real>(kAllowed * (size_ + coordinate_));
  if (out_a > allowed || out_b > allowed) {
    say("a witness point is not of its body", ask, r, std::max(out_a, out_b), tally_->failures);
  }
  if (static_cast<Real>(r.distance.lower) > apart + 2 * allowed) {
    say("witness points are nearer than the lower end", ask, r, apart, tally_->unsafe);
  }
  if (std::abs(apart - static_cast<Real>(r.distance.upper)) >
      static_cast<Real>(r.distance.width()) + 2 * allowed) {
    say("witness points are not as far apart as they should be", ask, r, apart, tally_->failures);
  }
}

// Tries directions that a wrong depth would have missed; none may prove more than the upper end.
void Examiner::tryPlanes(const Ask& ask, const DistanceResult& r, oracle::Random& random) {
  if (half_space_) return;
  const Pose& pose = random.chance(0.5) ? case_->X_WA : case_->X_WB;
  const Vector3d axis = pose.rotation.col(random.below(3));
  const double tilt = random.logUniform(1e-8, 1);
  const Real allowed = static_cast<Real>(kAllowed * size_);
  for (const Vector3d& n : {axis, Vector3d(-axis), random.direction(),
                            Vector3d(r.normal + tilt * random.direction())}) {
    const Real proven = provenAlong(n);
    if (static_cast<Real>(r.distance.upper) < proven - allowed) {
      say("another plane proves more than the upper end", ask, r, proven, tally_->unsafe);
    }
  }
}

// Checks that two intervals that contain the truth intersect.
void Examiner::meet(const Ask& ask, const DistanceResult& r) {
  if (r.distance.lower > exact_.distance.upper || r.distance.upper < exact_.distance.lower) {
    say("does not meet the plain answer", ask, r,
        static_cast<Real>(r.distance.lower > exact_.distance.upper ? exact_.distance.upper
                                                                   : exact_.distance.lower),
        tally_->unsafe);
  }
}

void Examiner::threshold(oracle::Random& random) {
  Ask above;
  above.how = "threshold";
  above.request.depth = random.chance(0.5);
  const double offset = random.chance(0.1) ? 0 : size_ * random.logUniform(1e-17, 1);
  above.request.threshold = exact_.distance.upper + (random.chance(0.5) ? offset : -offset);
  const double t = above.request.threshold;
  const DistanceResult r = ask(above);
  meet(above, r);
  const bool wrong = (r.status == DistanceStatus::kAboveThreshold && exact_.distance.upper <= t) ||
                     (r.status == DistanceStatus::kNotAboveThreshold && exact_.distance.lower > t);
  if (wrong) say("wrong verdict", above, r, static_cast<Real>(t), tally_->unsafe);
  // An overlap may be answered without its depth.
  const bool decided = r.distance.lower > t || r.distance.upper <= t ||
                       (r.status == DistanceStatus::kOverlap && r.distance.upper <= 0);
  const bool clear = exact_.distance.lower > t || exact_.distance.upper <= t;
  if (!decided && clear && exact_.status == DistanceStatus::kConverged &&
      std::abs(t - exact_.distance.upper) > 2e-9 + 1e-13 * size_) {
    // The limit leaves a few wide, in other pairs than for the plain query.
    say("no verdict", above, r, static_cast<Real>(t),
        r.status == DistanceStatus::kLimit ? tally_->open : tally_->failures);
  }
}

/// Whether the oracle proves `answer`: it searches only as far as that requires, and once to its
/// end.
bool Examiner::proves(const collision::Interval& answer) {
  const auto holds = [&] {
    return truth_ && truth_->lower >= answer.lower && truth_->upper <= answer.upper;
  };
  if (holds() || truth_is_final_) return holds();
  const Case& c = *case_;
  truth_ = oracle::convexSeparation(*c.a, c.X_WA, *c.b, c.X_WB, {answer.lower, answer.upper});
  truth_is_final_ = !holds();
  return holds();
}

void Examiner::holdAgainstOracle(const Ask& ask, const DistanceResult& r) {
  ++(proves(r.distance) ? tally_->oracle : tally_->unproven);
  if (r.distance.lower > truth_->upper) {
    say("above the truth", ask, r, static_cast<Real>(truth_->upper), tally_->unsafe);
  }
  if (r.distance.upper < truth_->lower) {
    say("below the truth", ask, r, static_cast<Real>(truth_->lower), tally_->unsafe);
  }
}

void Examiner::examine(const Case& c, oracle::Random& random, bool with_oracle,
                       const std::string& says, Tally& tally) {
  case_ = &c;
  says_ = &says;
  tally_ = &tally;
  half_space_ = c.a->type() == ShapeType::kHalfSpace || c.b->type() == ShapeType::kHalfSpace;
  size_ = oracle::sizeOf(*c.a) + oracle::sizeOf(*c.b) +
          (c.X_WB.translation - c.X_WA.translation).norm();
  default_tolerance_ = collision::defaultTolerance(*c.a, c.X_WA, *c.b, c.X_WB);
  coordinate_ = c.X_WA.translation.norm() + c.X_WB.translation.norm();
  ++tally.cases;
  truth_.reset();
  truth_is_final_ = false;
  const Ask plain;
  exact_ = ask(plain);
  if (with_oracle) {
    holdAgainstOracle(plain, exact_);
  }
  if (exact_.distance.upper < 0) {
    ++tally.overlapping;
    tryPlanes(plain, exact_, random);
  }
  if (exact_.status == DistanceStatus::kLimit) {
    ++tally.open;
    if (verbose) {
      std::int64_t uncounted = 0;
      say("open", plain, exact_, static_cast<Real>(exact_.distance.width()), uncounted);
    }
  }
  Ask swapped;
  swapped.swapped = true;
  swapped.how = "swapped";
  meet(swapped, ask(swapped));
  threshold(random);
  // The cache is that of the previous case; the second query finds it warm.
  Ask warm;
  warm.cache = &cache_;
  warm.how = "foreign cache";
  meet(warm, ask(warm));
  if (random.chance(0.3)) {
    warm.how = "warm cache";
    meet(warm, ask(warm));
  }
  if (random.chance(0.25)) {
    Ask limited;
    limited.how = "limited";
    limited.request.iteration_limit = random.below(12);
    meet(limited, ask(limited));
  }
}

}  // namespace leeway::accuracy
