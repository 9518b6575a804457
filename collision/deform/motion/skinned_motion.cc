#include "collision/deform/motion/skinned_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collision/base/rounding.h"
#include "collision/base/tolerances.h"
#include "collision/deform/motion/motion_input.h"

namespace leeway::collision {
namespace {

using Eigen::Vector3d;

constexpr MotionKind kSkinnedKind = MotionKind::kSkinned;

}  // namespace

// A vertex is a convex combination of its images under the bones, so it is never faster than the
// fastest of these.
SkinnedVertices::SkinnedVertices(std::vector<Vector3d> rest, BoneChain bones,
                                 std::vector<std::int32_t> first_influence,
                                 std::vector<Influence> influences)
    : VertexMotion(kSkinnedKind, static_cast<int>(rest.size()), 12 * bones.count(),
                   {bones.track().times().begin(), bones.track().times().end()}),
      rest_(std::move(rest)),
      bones_(std::move(bones)),
      first_influence_(std::move(first_influence)),
      influences_(std::move(influences)) {
  std::vector<double> reaches(static_cast<std::size_t>(bones_.count()), -1);
  std::size_t most = 0;
  double farthest = 0;
  for (int v = 0; v < vertexCount(); ++v) {
    const Vector3d& r = rest_[static_cast<std::size_t>(v)];
    most = std::max(most, this->influences(v).size());
    farthest = std::max(farthest, roundedUp(std::sqrt(squaredLength(r)), 8));
    for (const Influence& i : this->influences(v)) {
      if (!(i.weight > 0)) continue;
      double& reach = reaches[static_cast<std::size_t>(i.bone)];
      reach = std::max(reach, roundedUp(std::sqrt(squaredLength(bones_.inBone(i.bone, r))), 8));
    }
  }
  rounding_ = bones_.rounding(farthest);
  for (double& reach : reaches)
    if (reach >= 0) reach += rounding_;
  for (std::size_t i = 0; i < bones_.track().segments(); ++i) {
    const BoneChain::Rates rates = bones_.rates(i, reaches);
    speeds_.push_back(rates.speed);
    accelerations_.push_back(rates.acceleration);
  }
  // The blend: three units for each weight, a product and a sum.
  rounding_ = roundedUp(rounding_ * (1 + static_cast<double>(most) / 64), 8);
}

void SkinnedVertices::parameters(double time, std::span<double> out) const {
  bones_.skinningMatrices(time, out);
}

void SkinnedVertices::vertices(std::span<const double> parameters, int first,
                               std::span<Vector3d> out) const {
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::size_t v = static_cast<std::size_t>(first) + i;
    const Vector3d& r = rest_[v];
    double x = 0, y = 0, z = 0;
    for (const Influence& influence : influences(static_cast<int>(v))) {
      const double* X = parameters.data() + 12 * influence.bone;
      x += influence.weight * (X[0] * r.x() + X[1] * r.y() + X[2] * r.z() + X[9]);
      y += influence.weight * (X[3] * r.x() + X[4] * r.y() + X[5] * r.z() + X[10]);
      z += influence.weight * (X[6] * r.x() + X[7] * r.y() + X[8] * r.z() + X[11]);
    }
    out[i] = {x, y, z};
  }
}

double SkinnedVertices::speedBound(double t0, double t1) const {
  return bones_.track().largest(speeds_, t0, t1);
}

double SkinnedVertices::accelerationBound(double t0, double t1) const {
  if (bones_.track().jumps(t0, t1)) return std::numeric_limits<double>::infinity();
  return bones_.track().largest(accelerations_, t0, t1);
}

double SkinnedVertices::rounding(double t0, double t1) const {
  return t0 <= t1 ? rounding_ : std::numeric_limits<double>::infinity();
}

namespace {

void requirePose(const std::string& name, const SkinnedMotion::BonePose& pose) {
  double largest = 0;
  for (int k = 0; k < 3; ++k)
    requireUsable(kSkinnedKind, name + ", translation", pose.translation[k]);
  for (int k = 0; k < 4; ++k) {
    requireUsable(kSkinnedKind, name + ", quaternion", pose.quaternion[k]);
    largest = std::max(largest, std::abs(pose.quaternion[k]));
  }
  if (!(largest > 1e-100)) {
    refuse(kSkinnedKind, name + ", quaternion: " + shown(pose.quaternion[0]) + " " +
                             shown(pose.quaternion[1]) + " " + shown(pose.quaternion[2]) + " " +
                             shown(pose.quaternion[3]) + "; x y z w of a length near 1 are needed");
  }
}

void requireBones(const SkinnedMotion& motion) {
  if (motion.bones.empty()) refuse(kSkinnedKind, "no bones; at least 1 is needed");
  for (std::size_t b = 0; b < motion.bones.size(); ++b) {
    const std::string name = "bone " + std::to_string(b);
    requirePose(name + ", rest", motion.bones[b].rest);
    const int parent = motion.bones[b].parent;
    if (parent < -1 || parent >= static_cast<int>(b)) {
      refuse(kSkinnedKind, name + ": parent " + std::to_string(parent) +
                               "; an earlier bone, or -1 for none, is accepted");
    }
  }
  for (std::size_t i = 0; i < motion.keys.size(); ++i) {
    const std::string name = "key " + std::to_string(i);
    requireCount(kSkinnedKind, name, motion.keys[i].poses.size(), motion.bones.size(), "poses");
    for (std::size_t b = 0; b < motion.bones.size(); ++b)
      requirePose(name + ", bone " + std::to_string(b), motion.keys[i].poses[b]);
  }
}

void requireWeight(const SkinnedMotion& motion, std::size_t number) {
  const SkinnedMotion::Weight& w = motion.weights[number];
  const std::string name = "weight " + std::to_string(number);
  const auto inside = [](int i, std::size_t count) {
    return i >= 0 && static_cast<std::size_t>(i) < count;
  };
  if (!inside(w.vertex, motion.rest.size())) {
    refuse(kSkinnedKind, name + ": vertex " + std::to_string(w.vertex) + "; 0 to " +
                             std::to_string(motion.rest.size() - 1) + " are there");
  }
  if (!inside(w.bone, motion.bones.size())) {
    refuse(kSkinnedKind, name + ": bone " + std::to_string(w.bone) + "; 0 to " +
                             std::to_string(motion.bones.size() - 1) + " are there");
  }
  requireUsable(kSkinnedKind, name, w.weight);
  if (!(w.weight >= 0))
    refuse(kSkinnedKind, name + ": " + shown(w.weight) + "; 0 or more is accepted");
}

// Sorts the weights by vertex, then bone, and divides those of a vertex by their sum.
void normalise(SkinnedMotion& motion, std::vector<std::int32_t>& first_influence,
               std::vector<SkinnedVertices::Influence>& influences) {
  for (std::size_t i = 0; i < motion.weights.size(); ++i) requireWeight(motion, i);
  std::sort(motion.weights.begin(), motion.weights.end(), [](const auto& a, const auto& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.bone < b.bone;
  });
  first_influence.push_back(0);
  std::size_t next = 0;
  for (std::size_t v = 0; v < motion.rest.size(); ++v) {
    const std::size_t begin = next;
    double sum = 0;
    for (; next < motion.weights.size(); ++next) {
      const SkinnedMotion::Weight& w = motion.weights[next];
      if (static_cast<std::size_t>(w.vertex) != v) break;
      if (next > begin && motion.weights[next - 1].bone == w.bone) {
        refuse(kSkinnedKind, "two weights for vertex " + std::to_string(v) + " and bone " +
                                 std::to_string(w.bone) + "; one is accepted");
      }
      sum += w.weight;
    }
    if (!(sum > 1e-100)) {
      refuse(kSkinnedKind, "the weights of vertex " + std::to_string(v) + " add up to " +
                               shown(sum) + "; more than 0 is needed");
    }
    for (std::size_t i = begin; i < next; ++i)
      influences.push_back({motion.weights[i].bone, motion.weights[i].weight / sum});
    first_influence.push_back(static_cast<std::int32_t>(influences.size()));
  }
}

}  // namespace

std::shared_ptr<const VertexMotion> VertexMotion::skinned(SkinnedMotion motion) {
  requireVertices(kSkinnedKind, motion.rest.size());
  requireUsable(kSkinnedKind, "rest vertex", motion.rest);
  std::vector<double> times = timesOf(motion.keys);
  requireKeys(kSkinnedKind, times);
  requireBones(motion);
  MotionSource source = motion;
  std::vector<std::int32_t> first_influence;
  std::vector<SkinnedVertices::Influence> influences;
  normalise(motion, first_influence, influences);
  BoneChain bones(motion, KeyTrack(std::move(times), motion.interpolation));
  return withSource(
      std::make_shared<SkinnedVertices>(std::move(motion.rest), std::move(bones),
                                        std::move(first_influence), std::move(influences)),
      std::move(source));
}

}  // namespace leeway::collision
