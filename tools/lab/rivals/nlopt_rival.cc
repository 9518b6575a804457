// NLopt's sequential quadratic programming (SLSQP) within the joints' limits, as TRAC-IK runs it in
// parallel with KDL. It minimises the squared error of the pose, from the given start, then from
// random ones. Beeson and Ames, "TRAC-IK: An open-source library for improved solving of generic
// inverse kinematics", 2015, section III.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlopt.hpp>
#include <span>
#include <stdexcept>
#include <vector>

#include "tools/lab/base/rivals.h"

namespace leeway::tools::report {
namespace {

using collision::Pose;

/// Squared error below which a search ends: 1e-10 m and rad, below the report's tolerance.
constexpr double kGoodEnough = 1e-20;

/// Limit on the evaluations of one search.
constexpr int kMostEvaluations = 200;

class NloptSolver : public IkSolver {
 public:
  explicit NloptSolver(const IkChain& chain)
      : chain_(chain), search_(nlopt::LD_SLSQP, static_cast<unsigned>(chain.joints.size())) {
    std::vector<double> lower, upper;
    for (const IkChain::Joint& joint : chain.joints) {
      lower.push_back(joint.lower);
      upper.push_back(joint.upper);
    }
    search_.set_lower_bounds(lower);
    search_.set_upper_bounds(upper);
    search_.set_min_objective(cost, this);
    search_.set_stopval(kGoodEnough);
    search_.set_xtol_abs(1e-14);
    search_.set_maxeval(kMostEvaluations);
    axes_W_.resize(chain.joints.size());
    origins_W_.resize(chain.joints.size());
  }

  bool solve(const Pose& X_WF, std::span<const double> start, std::span<double> values) override {
    X_WF_ = X_WF;
    std::vector<double> q(start.begin(), start.end());
    for (int attempt = 0; attempt < kIkStarts; ++attempt) {
      double error = 0;
      try {
        search_.optimize(q, error);
      } catch (const nlopt::roundoff_limited&) {  // q is the best so far
        error = squaredError(q, nullptr);
      } catch (const std::runtime_error&) {
        error = 1;
      }
      if (error <= kGoodEnough) {
        std::copy(q.begin(), q.end(), values.begin());
        return true;
      }
      for (std::size_t i = 0; i < q.size(); ++i)
        q[i] = random_.uniform(chain_.joints[i].lower, chain_.joints[i].upper);
    }
    return false;
  }

 private:
  static double cost(const std::vector<double>& q, std::vector<double>& gradient, void* self) {
    return static_cast<NloptSolver*>(self)->squaredError(q, gradient.empty() ? nullptr : &gradient);
  }

  /// Squared distance of the origins and squared angle of the rotations, and its exact gradient:
  /// the derivative of the squared angle along a rotation is twice the rotation vector.
  double squaredError(const std::vector<double>& q, std::vector<double>* gradient) {
    Pose X;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const IkChain::Joint& joint = chain_.joints[i];
      X = X * joint.X_PJ;
      axes_W_[i] = X.rotation * joint.axis;
      origins_W_[i] = X.translation;
      if (joint.slides)
        X.translation += q[i] * axes_W_[i];
      else
        X.rotation *= Eigen::AngleAxisd(q[i], joint.axis).toRotationMatrix();
    }
    X = X * chain_.X_JF;
    const Eigen::Vector3d offset = X.translation - X_WF_.translation;
    Eigen::Quaterniond turn(Eigen::Matrix3d(X.rotation * X_WF_.rotation.transpose()));
    if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
    const double sine = turn.vec().norm();
    const Eigen::Vector3d angle =
        sine > 0 ? Eigen::Vector3d(turn.vec() * (2 * std::atan2(sine, turn.w()) / sine))
                 : Eigen::Vector3d::Zero();
    if (gradient != nullptr)
      for (std::size_t i = 0; i < q.size(); ++i) {
        const bool slides = chain_.joints[i].slides;
        const Eigen::Vector3d moves =
            slides ? axes_W_[i] : axes_W_[i].cross(X.translation - origins_W_[i]);
        (*gradient)[i] = 2 * offset.dot(moves) + (slides ? 0 : 2 * angle.dot(axes_W_[i]));
      }
    return offset.squaredNorm() + angle.squaredNorm();
  }

  IkChain chain_;
  nlopt::opt search_;
  Pose X_WF_;
  std::vector<Eigen::Vector3d> axes_W_, origins_W_;
  IkRandom random_;
};

class NloptEngine : public IkEngine {
 public:
  const char* name() const override { return "NLopt SQP"; }
  std::unique_ptr<IkSolver> prepare(const IkChain& chain) const override {
    return std::make_unique<NloptSolver>(chain);
  }
};

}  // namespace
}  // namespace leeway::tools::report

extern "C" leeway::tools::report::Rivals* leewayMakeRivals5() {
  using namespace leeway::tools::report;
  auto rivals = std::make_unique<Rivals>();
  rivals->kinematics.push_back(std::make_unique<NloptEngine>());
  return rivals.release();
}
