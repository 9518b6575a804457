#include "planner/execute/blend.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/planner/edge_certifier.h"
#include "leeway/planner/trajectory.h"
#include "planner/base/tolerances.h"
#include "planner/compiled/edge_model.h"

namespace leeway::planner {
namespace {

/// Proves blends of one path.
class Blending {
 public:
  explicit Blending(const std::shared_ptr<const CompiledScene>& scene)
      : scene_(*scene),
        space_(scene->space()),
        certifier_(scene->withMarginsGrown(kBlendDeviation)),
        size_(at(space_.size())),
        bend_(size_),
        point_(size_),
        next_(size_),
        dq_(scene->model().variables.size()),
        motion_(scene->model().joints.size()) {}

  /// Whether the cut is proven to keep the margins.
  bool holds(std::span<const double> corner, std::span<const double> before,
             std::span<const double> after, double length) {
    const double a = length / norm(before), b = length / norm(after);
    for (std::size_t i = 0; i < size_; ++i) bend_[i] = b * after[i] - a * before[i];
    if (wraps(corner, before, after, a, b)) return false;
    // The curve's second derivative is 2 bend_. Over 1/n of the parameter the curve stays within an
    // eighth of it, over n^2, of its chord.
    const double deviation = displacement() / 4;
    int chords = 1;
    while (chords <= kBlendChords && !(deviation / (chords * chords) <= kBlendDeviation))
      chords *= 2;
    if (chords > kBlendChords) return false;
    for (int k = 0; k <= chords; ++k) {
      blendPoint(space_, corner, before, after, length, static_cast<double>(k) / chords, next_);
      if (!space_.withinLimits(next_)) return false;
      if (k > 0 &&
          certifier_.certify(point_, next_, EdgeRequest::persistent()).verdict != Verdict::kFree)
        return false;
      std::swap(point_, next_);
    }
    return true;
  }

 private:
  /// Whether a circle passes from pi to -pi within the cut, where a mimic might jump between chord
  /// and curve, or turns by about half a turn, where rounding might reverse the chord.
  bool wraps(std::span<const double> corner, std::span<const double> before,
             std::span<const double> after, double a, double b) const {
    for (const ConfigurationSpace::Part& part : space_.parts()) {
      if (part.kind != ConfigurationSpace::Kind::kCircle) continue;
      const std::size_t i = at(part.first);
      const double middle = std::remainder(corner[i], collision::kTwoPi);
      const double reach = std::max(std::abs(a * before[i]), std::abs(b * after[i]));
      if (!(std::abs(middle) + reach < std::numbers::pi && reach < kBlendReach)) return true;
    }
    return false;
  }

  /// Bounds the motion of any body's points for a joint motion of bend_, as seen from any body that
  /// it is checked against [m].
  double displacement() {
    expandDifference(space_, bend_, dq_);
    robots::jointMotion(scene_.model(), dq_, motion_);
    double most = 0;
    for (const robots::RelativeMotion& motion : scene_.edgeModel().motions)
      most = std::max(most, robots::speedBound(scene_.model(), motion, motion_));
    return most;
  }

  const CompiledScene& scene_;
  const ConfigurationSpace& space_;
  EdgeCertifier certifier_;
  std::size_t size_;
  std::vector<double> bend_, point_, next_, dq_;
  std::vector<robots::JointMotion> motion_;
};

}  // namespace

double norm(std::span<const double> v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

bool inLine(std::span<const double> first, std::span<const double> second) {
  const double a = norm(first), b = norm(second);
  if (a == 0 || b == 0) return true;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (std::abs(first[i] / a - second[i] / b) > kInLine) return false;
  return true;
}

bool hasRotation(const ConfigurationSpace& space) {
  return std::any_of(space.parts().begin(), space.parts().end(), [](const auto& part) {
    return part.kind == ConfigurationSpace::Kind::kRotation;
  });
}

void blendPoint(const ConfigurationSpace& space, std::span<const double> corner,
                std::span<const double> before, std::span<const double> after, double length,
                double t, std::span<double> result) {
  const double a = length * (1 - t) * (1 - t) / norm(before), b = length * t * t / norm(after);
  // Each number of the result depends only on the same number of the inputs, without rotations.
  for (std::size_t i = 0; i < corner.size(); ++i) result[i] = b * after[i] - a * before[i];
  space.advance(corner, result, 1, result);
}

std::vector<Blend> certifiedBlends(const std::shared_ptr<const CompiledScene>& scene,
                                   std::span<const std::vector<double>> waypoints) {
  if (!scene) throw std::invalid_argument("certifiedBlends(): a compiled scene is expected");
  const ConfigurationSpace& space = scene->space();
  space.requirePath(waypoints, "certifiedBlends()");
  std::vector<Blend> blends;
  if (hasRotation(space) || waypoints.size() < 3) return blends;
  Blending blending(scene);
  std::vector<double> before(at(space.size())), after(before);
  space.difference(waypoints[0], waypoints[1], before);
  for (std::size_t corner = 1; corner + 1 < waypoints.size(); ++corner) {
    space.difference(waypoints[corner], waypoints[corner + 1], after);
    double length = std::min(norm(before), norm(after)) / 2;
    if (!inLine(before, after)) {
      for (int attempt = 0; attempt < kBlendTries; ++attempt, length /= 2) {
        if (!blending.holds(waypoints[corner], before, after, length)) continue;
        blends.push_back({static_cast<int>(corner), length});
        break;
      }
    }
    std::swap(before, after);
  }
  return blends;
}

}  // namespace leeway::planner
