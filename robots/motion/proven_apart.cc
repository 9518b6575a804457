#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "collision/base/numbers.h"
#include "collision/base/sine_cosine.h"
#include "leeway/collision/distance.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/motion_bound.h"
#include "robots/base/tolerances.h"
#include "robots/motion/kept_proofs.h"

namespace leeway::robots {
namespace {

/// The claim about two links.
enum class Wanted { kApart, kTouching };

/// The proof for one pair of links: interval subdivision. At the middle of a box of configurations
/// the links are farther apart, or overlap deeper, than the whole box can move them; else the box
/// is halved.
class PairProof {
 public:
  PairProof(const Model& model, int link_a, int link_b, Wanted wanted)
      : model_(model),
        wanted_(wanted),
        a_(model.links[at(link_a)]),
        b_(model.links[at(link_b)]),
        link_a_(link_a),
        link_b_(link_b) {}

  bool run() {
    if (!prepare()) return false;
    std::vector<Box> stack{{center_, half_, 1}};
    double proven = 0;  // share of the first box
    for (int work = 0; !stack.empty(); ++work) {
      if (work >= kApartBoxes) return false;
      if (work == kApartTrial && proven < kApartTrialShare) return false;
      const Box box = stack.back();
      stack.pop_back();
      const Finding found = look(box);
      if (found == Finding::kRefuted) return false;
      if (found == Finding::kProven) {
        proven += box.share;
        continue;
      }
      const std::size_t v = widest(box);
      if (box.half[v] < kApartSmallest) return false;
      Box low = box, high = box;
      low.share = high.share = box.share / 2;
      low.half[v] = high.half[v] = box.half[v] / 2 * (1 + kBoundRounding);
      low.center[v] -= box.half[v] / 2;
      high.center[v] += box.half[v] / 2;
      stack.push_back(low);
      stack.push_back(high);
    }
    return true;
  }

 private:
  struct Box {
    std::vector<double> center, half;  // one a variable
    double share;                      // of the first box
  };
  enum class Finding { kProven, kRefuted, kOpen };

  /// False when this proof cannot treat the pair: without shapes, with joints of several variables,
  /// unlimited, or without any motion between the two.
  bool prepare() {
    std::vector<VariableRange> ranges = limitRanges(model_);
    if (wanted_ == Wanted::kTouching)
      for (std::size_t v = 0; v < ranges.size(); ++v) {
        const auto [lower, upper] = model_.variables[v].touchRange();
        ranges[v] = {lower, upper};
      }
    for (const Geometry& g : a_.geometries) {
      const Eigen::Vector3d center_L = g.X_BG * g.shape.boundingCenter();
      motions_.push_back(
          relativeMotion(model_, link_a_, link_b_, center_L, g.shape.boundingRadius(), ranges));
    }
    if (motions_.empty() || b_.geometries.empty()) return false;
    center_ = model_.defaultConfiguration();
    half_.assign(model_.variables.size(), 0);
    for (const RelativeMotion::Term& term : motions_.front().terms)
      if (!addRange(model_.joints[at(term.joint)])) return false;
    std::sort(moving_.begin(), moving_.end());
    moving_.erase(std::unique(moving_.begin(), moving_.end()), moving_.end());
    // The proof takes one turn of a continuous joint; a mimic is not periodic in its master.
    for (const RelativeMotion::Term& term : motions_.front().terms) {
      const Joint& j = model_.joints[at(term.joint)];
      if (j.mimic >= 0 && turnsEndlessly(model_.joints[at(j.mimic)])) return false;
    }
    poses_.resize(model_.links.size());
    joint_motion_.resize(model_.joints.size());
    return !moving_.empty();
  }

  /// Whether the joint turns without limits. withBounds() makes such a joint revolute; what touches
  /// everywhere is still proven for whole turns.
  bool turnsEndlessly(const Joint& joint) const {
    if (joint.type == JointType::kContinuous) return true;
    return wanted_ == Wanted::kTouching && joint.type == JointType::kRevolute &&
           std::isinf(model_.variables[at(joint.first_variable)].touchRange().second);
  }

  /// Adds the range of the joint's variable, or its master's, to the box. False when it has none
  /// that is finite.
  bool addRange(const Joint& joint) {
    const Joint* j = &joint;
    while (j->mimic >= 0) j = &model_.joints[at(j->mimic)];
    if (j->type == JointType::kFloating || j->type == JointType::kPlanar || j->first_variable < 0)
      return false;
    const std::size_t variable = at(j->first_variable);
    const Variable& v = model_.variables[variable];
    double middle = 0, half = 3.141592653589794;  // above pi: the whole circle
    const auto [lower, upper] =
        wanted_ == Wanted::kTouching ? v.touchRange() : std::pair(v.lower, v.upper);
    if (std::isfinite(lower) && std::isfinite(upper)) {
      middle = lower + (upper - lower) / 2;
      half = std::max(upper - middle, middle - lower);
    } else if (!turnsEndlessly(*j)) {
      return false;
    }
    center_[variable] = middle;
    half_[variable] = half;
    moving_.push_back(variable);
    return true;
  }

  /// Proven over the whole box, or refuted in its middle.
  Finding look(const Box& box) {
    forwardKinematics(model_, box.center, poses_);
    jointMotion(model_, box.half, joint_motion_);
    return wanted_ == Wanted::kApart ? lookApart() : lookTouching();
  }

  /// A bound on how far the points of geometry i of a move within the box [m]: an edge from the
  /// middle to any point of the box moves no joint farther than half_.
  double motionOf(std::size_t i) {
    return localMotionBound(model_, motions_[i], joint_motion_, poses_, 1).speed + kApartSlack;
  }

  Finding lookApart() {
    const Pose& X_WA = poses_[at(link_a_)];
    const Pose& X_WB = poses_[at(link_b_)];
    for (std::size_t i = 0; i < a_.geometries.size(); ++i) {
      const Geometry& a = a_.geometries[i];
      const double motion = motionOf(i);
      for (const Geometry& b : b_.geometries) {
        const Eigen::Vector3d d =
            X_WA * (a.X_BG * a.shape.boundingCenter()) - X_WB * (b.X_BG * b.shape.boundingCenter());
        if (d.norm() - a.shape.boundingRadius() - b.shape.boundingRadius() > motion) continue;
        collision::DistanceRequest request;
        request.threshold = motion;
        request.depth = false;
        const collision::DistanceResult result =
            collision::distance(a.shape, X_WA * a.X_BG, b.shape, X_WB * b.X_BG, request, scratch_);
        if (result.distance.upper <= 0) return Finding::kRefuted;
        if (!(result.distance.lower > motion)) return Finding::kOpen;
      }
    }
    return Finding::kProven;
  }

  /// One geometry of each is enough. The depth of convex ones changes no faster than their points
  /// move; of others nothing is proven.
  Finding lookTouching() {
    bool are_apart = true;
    for (std::size_t i = 0; i < a_.geometries.size(); ++i)
      for (const Geometry& b : b_.geometries) {
        const Geometry& a = a_.geometries[i];
        const bool convex = a.shape.isConvex() && b.shape.isConvex();
        collision::DistanceRequest request;
        request.depth = convex;
        const collision::Interval found =
            collision::distance(a.shape, poses_[at(link_a_)] * a.X_BG, b.shape,
                                poses_[at(link_b_)] * b.X_BG, request, scratch_)
                .distance;
        if (convex && found.upper <= -motionOf(i)) return Finding::kProven;
        are_apart = are_apart && found.lower > 0;
      }
    return are_apart ? Finding::kRefuted : Finding::kOpen;
  }

  /// The variable whose half width moves the body most.
  std::size_t widest(const Box& box) {
    std::size_t best = moving_.front();
    double most = -1;
    std::vector<double> one(box.half.size(), 0);
    for (const std::size_t v : moving_) {
      one[v] = box.half[v];
      jointMotion(model_, one, joint_motion_);
      one[v] = 0;
      double speed = 0;
      for (const RelativeMotion& m : motions_)
        speed = std::max(speed, localMotionBound(model_, m, joint_motion_, poses_, 1).speed);
      if (speed > most) {
        most = speed;
        best = v;
      }
    }
    return best;
  }

  const Model& model_;
  Wanted wanted_;
  const Link& a_;
  const Link& b_;
  int link_a_, link_b_;
  std::vector<RelativeMotion> motions_;  // one a geometry of a
  std::vector<double> center_, half_;
  std::vector<std::size_t> moving_;
  std::vector<Pose> poses_;
  std::vector<JointMotion> joint_motion_;
  collision::Scratch scratch_;
};

/// Where each variable of a sample stands: over its limits, each in steps of its own.
void sample(const Model& model, int number, std::vector<double>& q) {
  for (std::size_t v = 0; v < q.size(); ++v) {
    const Variable& variable = model.variables[v];
    const JointType type = model.joints[at(variable.joint)].type;
    if (type != JointType::kRevolute && type != JointType::kPrismatic &&
        type != JointType::kContinuous)
      continue;
    const bool whole_turn = type == JointType::kContinuous;
    const double lower = whole_turn ? -3.14 : variable.lower;
    const double upper = whole_turn ? 3.14 : variable.upper;
    if (!std::isfinite(upper - lower)) continue;
    const double steps = (number + 1) * kGoldenSection * static_cast<double>(v + 1);
    q[v] = lower + (upper - lower) * (steps - std::floor(steps));
  }
}

bool meet(const Link& a, const Pose& X_WA, const Link& b, const Pose& X_WB,
          collision::Scratch& scratch) {
  collision::DistanceRequest request;
  request.threshold = 0;
  request.depth = false;
  for (const Geometry& g : a.geometries)
    for (const Geometry& h : b.geometries) {
      const Pose X_WG = X_WA * g.X_BG, X_WH = X_WB * h.X_BG;
      const double reach = g.shape.boundingRadius() + h.shape.boundingRadius();
      if ((X_WG * g.shape.boundingCenter() - X_WH * h.shape.boundingCenter()).norm() > reach)
        continue;
      if (collision::distance(g.shape, X_WG, h.shape, X_WH, request, scratch).distance.upper <= 0)
        return true;
    }
  return false;
}

/// Where all links stand in some configurations: a pair that meets in one of them needs no proof.
std::vector<std::vector<Pose>> samplePoses(const Model& model) {
  std::vector<double> q = model.defaultConfiguration();
  std::vector<std::vector<Pose>> looks(kApartSamples, std::vector<Pose>(model.links.size()));
  for (int i = 0; i < kApartSamples; ++i) {
    sample(model, i, q);
    forwardKinematics(model, q, looks[at(i)]);
  }
  return looks;
}

std::vector<std::pair<int, int>> thoseThatHold(const Model& model,
                                               std::span<const std::pair<int, int>> pairs,
                                               const DecidePair& question, const Stop& stop) {
  const std::vector<unsigned char> holds = decidePairs(model, pairs, question, stop);
  std::vector<std::pair<int, int>> proven;
  for (std::size_t i = 0; i < holds.size(); ++i)
    if (holds[i] == 1) proven.push_back(pairs[i]);
  return proven;
}

}  // namespace

std::vector<std::pair<int, int>> provenApart(const Model& model,
                                             std::span<const std::pair<int, int>> candidates,
                                             const Stop& stop) {
  std::once_flag once;
  std::vector<std::vector<Pose>> looks;
  const auto decide = [&](const std::pair<int, int>& pair) -> unsigned char {
    const auto [a, b] = pair;
    std::call_once(once, [&] { looks = samplePoses(model); });
    collision::Scratch scratch;  // of this pair: answers do not depend on what else was asked
    for (const std::vector<Pose>& X_WL : looks)
      if (meet(model.links[at(a)], X_WL[at(a)], model.links[at(b)], X_WL[at(b)], scratch)) return 0;
    return PairProof(model, a, b, Wanted::kApart).run() ? 1 : 0;
  };
  return thoseThatHold(model, candidates, {"apart", "links were proven apart", decide}, stop);
}

std::vector<std::pair<int, int>> provenTouching(const Model& model,
                                                std::span<const std::pair<int, int>> candidates,
                                                const Stop& stop) {
  const auto decide = [&](const std::pair<int, int>& pair) -> unsigned char {
    return PairProof(model, pair.first, pair.second, Wanted::kTouching).run() ? 1 : 0;
  };
  return thoseThatHold(model, candidates, {"touching", "links were proven to touch", decide}, stop);
}

}  // namespace leeway::robots
