// KDL's numeric solvers as its users run them: from the given start, then from random ones until a
// solution is within the limits.

#include <algorithm>
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <memory>
#include <numbers>

#include "tools/lab/base/rivals.h"

namespace leeway::tools::report {
namespace {

KDL::Vector toKdl(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame toKdl(const collision::Pose& X) {
  const Eigen::Matrix3d& R = X.rotation;
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                        R(2, 2)),
          toKdl(X.translation)};
}

/// KDL's segment: its joint, followed by a fixed frame, here that of the next joint.
KDL::Chain toKdl(const IkChain& chain) {
  KDL::Chain result;
  if (chain.joints.empty()) return result;
  result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), toKdl(chain.joints.front().X_PJ)));
  for (std::size_t i = 0; i < chain.joints.size(); ++i) {
    const IkChain::Joint& joint = chain.joints[i];
    const bool last = i + 1 == chain.joints.size();
    result.addSegment(
        KDL::Segment(KDL::Joint("", KDL::Vector::Zero(), toKdl(joint.axis),
                                joint.slides ? KDL::Joint::TransAxis : KDL::Joint::RotAxis),
                     toKdl(last ? chain.X_JF : chain.joints[i + 1].X_PJ)));
  }
  return result;
}

enum class Method { kLma, kNewtonRaphson };

class KdlSolver : public IkSolver {
 public:
  KdlSolver(const IkChain& chain, Method method)
      : joints_(chain.joints), chain_(toKdl(chain)), forward_(chain_), velocity_(chain_) {
    const auto n = static_cast<unsigned>(joints_.size());
    KDL::JntArray lower(n), upper(n);
    for (unsigned i = 0; i < n; ++i) {
      lower(i) = joints_[i].lower;
      upper(i) = joints_[i].upper;
    }
    const Eigen::Matrix<double, 6, 1> weights = Eigen::Matrix<double, 6, 1>::Ones();
    if (method == Method::kLma)
      solver_ = std::make_unique<KDL::ChainIkSolverPos_LMA>(chain_, weights, 1e-10, 500);
    else
      solver_ = std::make_unique<KDL::ChainIkSolverPos_NR_JL>(chain_, lower, upper, forward_,
                                                              velocity_, 100, 1e-10);
  }

  bool solve(const collision::Pose& X_WF, std::span<const double> start,
             std::span<double> values) override {
    const auto n = static_cast<unsigned>(joints_.size());
    const KDL::Frame target = toKdl(X_WF);
    KDL::JntArray from(n), found(n);
    for (unsigned i = 0; i < n; ++i) from(i) = start[i];
    for (int attempt = 0; attempt < kIkStarts; ++attempt) {
      if (solver_->CartToJnt(from, target, found) >= 0 && inLimits(found, values)) return true;
      for (unsigned i = 0; i < n; ++i)
        from(i) = random_.uniform(joints_[i].lower, joints_[i].upper);
    }
    return false;
  }

 private:
  /// Angles may be reduced by whole turns.
  bool inLimits(const KDL::JntArray& found, std::span<double> values) const {
    for (unsigned i = 0; i < joints_.size(); ++i) {
      double value = found(i);
      if (!joints_[i].slides) {
        const double turn = 2 * std::numbers::pi;
        value -= turn * std::floor((value - joints_[i].lower) / turn);
      }
      if (!(value >= joints_[i].lower && value <= joints_[i].upper)) return false;
      values[i] = value;
    }
    return true;
  }

  std::vector<IkChain::Joint> joints_;
  KDL::Chain chain_;
  KDL::ChainFkSolverPos_recursive forward_;
  KDL::ChainIkSolverVel_pinv velocity_;
  std::unique_ptr<KDL::ChainIkSolverPos> solver_;
  IkRandom random_;
};

class KdlEngine : public IkEngine {
 public:
  explicit KdlEngine(Method method) : method_(method) {}
  const char* name() const override { return method_ == Method::kLma ? "KDL LMA" : "KDL NR_JL"; }
  std::unique_ptr<IkSolver> prepare(const IkChain& chain) const override {
    return std::make_unique<KdlSolver>(chain, method_);
  }

 private:
  Method method_;
};

}  // namespace
}  // namespace leeway::tools::report

extern "C" leeway::tools::report::Rivals* leewayMakeRivals5() {
  using namespace leeway::tools::report;
  auto rivals = std::make_unique<Rivals>();
  rivals->kinematics.push_back(std::make_unique<KdlEngine>(Method::kLma));
  rivals->kinematics.push_back(std::make_unique<KdlEngine>(Method::kNewtonRaphson));
  return rivals.release();
}
