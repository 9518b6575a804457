#include "planner/contact/distance_gradient.h"

#include <algorithm>
#include <cmath>

#include "collision/base/numbers.h"
#include "collision/base/work.h"
#include "leeway/robots/kinematics.h"
#include "planner/base/tolerances.h"

namespace leeway::planner {

DistanceGradient::DistanceGradient(const CompiledScene& scene)
    : scene_(scene),
      gradient_(static_cast<std::size_t>(scene.space().size())),
      direction_(gradient_.size()),
      near_(gradient_.size()),
      q_(scene.model().variables.size()),
      near_q_(q_.size()),
      X_WL_(scene.model().links.size()),
      moved_(scene.model().links.size()) {
  for (const ConfigurationSpace::Part& part : scene.space().parts())
    for (std::size_t k = 0; k < (part.kind == ConfigurationSpace::Kind::kRotation ? 3 : 1); ++k)
      directions_.push_back(static_cast<std::size_t>(part.first) + k);
}

std::int64_t DistanceGradient::work() const {
  return static_cast<std::int64_t>((gradient_.size() + 1) * X_WL_.size()) * collision::kPlacingWork;
}

/// Index in the chain of the first joint whose value in near_q_ differs from q_; the chain's size
/// if there is none.
std::size_t DistanceGradient::firstMoved() const {
  const auto stands = [this](int link) {
    const robots::KinematicStep& step = scene_.model().steps[at(link)];
    if (step.variable < 0) return true;
    const int count = step.type == robots::JointType::kFloating ? 7
                      : step.type == robots::JointType::kPlanar ? 3
                                                                : 1;
    const auto* variables = &q_[at(step.variable)];
    return std::equal(variables, variables + count, &near_q_[at(step.variable)]);
  };
  return static_cast<std::size_t>(std::find_if_not(chain_.begin(), chain_.end(), stands) -
                                  chain_.begin());
}

std::span<const double> DistanceGradient::find(std::span<const double> place,
                                               const EdgeClearance& found,
                                               const CompiledScene& pairs) {
  const collision::ScenePair& pair = pairs.scene().pairs()[static_cast<std::size_t>(found.pair)];
  const Eigen::Vector3d a = found.closest.point_a, b = found.closest.point_b;
  const double gap = (b - a).norm();
  const Eigen::Vector3d normal = gap > kPushGap ? ((b - a) / gap).eval() : found.closest.normal;
  if (!(std::abs(normal.squaredNorm() - 1) < 0.5)) return {};
  const int link_a = scene_.bodyLink(pair.body_a), link_b = scene_.bodyLink(pair.body_b);
  const int links[] = {link_a, link_b};
  robots::findChain(scene_.model(), links, chain_);
  scene_.expand(place, q_);
  robots::chainKinematics(scene_.model(), q_, chain_, X_WL_);
  std::fill(gradient_.begin(), gradient_.end(), 0.0);
  for (const std::size_t k : directions_) {
    direction_[k] = 1;
    scene_.space().advance(place, direction_, kPushDifference, near_);
    direction_[k] = 0;
    scene_.expand(near_, near_q_);
    const std::size_t moved = firstMoved();
    if (moved == chain_.size()) continue;
    for (std::size_t i = 0; i < moved; ++i) moved_[at(chain_[i])] = X_WL_[at(chain_[i])];
    robots::chainKinematics(scene_.model(), near_q_, std::span(chain_).subspan(moved), moved_);
    const auto way = [&](int link, const Eigen::Vector3d& p_W) -> Eigen::Vector3d {
      if (link < 0) return Eigen::Vector3d::Zero();
      const auto l = static_cast<std::size_t>(link);
      return moved_[l] * (X_WL_[l].inverse() * p_W) - p_W;
    };
    gradient_[k] = normal.dot(way(link_b, b) - way(link_a, a)) / kPushDifference;
  }
  return gradient_;
}

}  // namespace leeway::planner
