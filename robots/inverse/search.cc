#include "robots/inverse/search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/base/numbers.h"
#include "robots/base/tolerances.h"

namespace leeway::robots {

namespace {

/// Limit on the steps of one search. Most that succeed need fewer than 20.
constexpr int kSteps = 60;

/// A search ends after this many steps that each leave more than this share of the error.
constexpr int kSlowSteps = 6;
constexpr double kSlowShare = 0.8;

/// Damping as a share of the squared error: the first value, and the least. Rejected steps increase
/// it.
constexpr double kFirstDamping = 0.1, kLeastDamping = 1e-4;
/// Added damping: far below the squared singular values except at a singular pose.
constexpr double kAddedDamping = 1e-15;

/// Solves the symmetric positive definite system in place (Cholesky); a: n by n, its lower half.
void solvePositive(std::vector<double>& a, std::vector<double>& b, std::size_t n) {
  for (std::size_t j = 0; j < n; ++j) {
    double diagonal = a[j * n + j];
    for (std::size_t k = 0; k < j; ++k) diagonal -= a[j * n + k] * a[j * n + k];
    diagonal = std::sqrt(std::max(diagonal, 1e-300));
    a[j * n + j] = diagonal;
    for (std::size_t i = j + 1; i < n; ++i) {
      double sum = a[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
      a[i * n + j] = sum / diagonal;
    }
    double sum = b[j];
    for (std::size_t k = 0; k < j; ++k) sum -= a[j * n + k] * b[k];
    b[j] = sum / diagonal;
  }
  for (std::size_t j = n; j-- > 0;) {
    double sum = b[j];
    for (std::size_t k = j + 1; k < n; ++k) sum -= a[k * n + j] * b[k];
    b[j] = sum / a[j * n + j];
  }
}

}  // namespace

Search::Search(std::vector<Chain> chains, std::vector<std::optional<Chain>> bases,
               std::vector<PreparedRegion> regions, std::vector<int> variables,
               std::vector<double> lower, std::vector<double> upper)
    : chains_(std::move(chains)),
      bases_(std::move(bases)),
      regions_(std::move(regions)),
      variables_(std::move(variables)),
      lower_(std::move(lower)),
      upper_(std::move(upper)),
      rows_(6 * chains_.size()),
      columns_(variables_.size()) {
  for (std::size_t r = 0; r < chains_.size(); ++r) {
    const double reach = chains_[r].reach + (bases_[r] ? bases_[r]->reach : 0);
    weights_.push_back(reach > 0 ? 1 / reach : 1);
  }
  const std::size_t smaller = std::min(rows_, columns_);
  error_.resize(rows_);
  kept_error_.resize(rows_);
  jacobian_.resize(rows_ * columns_);
  gram_.resize(smaller * smaller);
  solution_.resize(smaller);
  step_.resize(columns_);
  held_.resize(columns_);
}

void Search::addTwists(std::size_t r, const RegionError& error) {
  for (const Twist& twist : twists_) {
    double* column = jacobian_.data() + at(twist.column) * rows_ + 6 * r;
    Eigen::Vector3d angular = twist.angular;
    for (int i = 0; i < error.free_turns; ++i) {
      const Eigen::Vector3d& axis = error.free_axis[at(i)];
      angular -= axis.dot(angular) * axis;
    }
    for (int k = 0; k < 3; ++k) {
      if (!error.free_position[at(k)]) column[k] += weights_[r] * twist.linear(k);
      column[3 + k] += angular(k);
    }
  }
}

void Search::turnTwists(double sign, const Eigen::Matrix3d& R_RW) {
  for (Twist& twist : twists_) {
    twist.linear = sign * (R_RW * twist.linear);
    twist.angular = sign * (R_RW * twist.angular);
  }
}

double Search::evaluate(const double* q, bool jacobian) {
  if (jacobian) std::fill(jacobian_.begin(), jacobian_.end(), 0);
  double squared = 0;
  for (std::size_t r = 0; r < chains_.size(); ++r) {
    // If the region has no base, the chain begins at R.
    const Pose X_WF = place(chains_[r], q, X_RC_);
    Pose X_WR;
    if (bases_[r]) X_WR = place(*bases_[r], q, X_BC_);
    const RegionError e = regionError(regions_[r], bases_[r] ? X_WR.inverse() * X_WF : X_WF);
    const double w = weights_[r];
    double* rows = error_.data() + 6 * r;
    for (int k = 0; k < 3; ++k) {
      rows[k] = w * e.position(k);
      rows[3 + k] = e.turn(k);
    }
    for (int k = 0; k < 6; ++k) squared += rows[k] * rows[k];
    if (!jacobian) continue;
    findTwists(chains_[r], q, X_RC_, X_WF, twists_);
    if (bases_[r]) turnTwists(1, X_WR.rotation.transpose());
    addTwists(r, e);
    if (!bases_[r]) continue;
    // Seen from R, its own joints move F as they move the point of R that is at F, backwards.
    findTwists(*bases_[r], q, X_BC_, X_WF, twists_);
    turnTwists(-1, X_WR.rotation.transpose());
    addTwists(r, e);
  }
  return squared;
}

/// Computes step_ of the solved variables; variables at a limit that they would leave are held.
void Search::step(double damping, double squared_error, const double* q) {
  const double lambda = damping * squared_error + kAddedDamping;
  for (std::size_t c = 0; c < columns_; ++c) {
    const double* column = jacobian_.data() + c * rows_;
    double gradient = 0;
    for (std::size_t i = 0; i < rows_; ++i) gradient += column[i] * error_[i];
    const double value = q[variables_[c]];
    held_[c] = (value <= lower_[c] && gradient > 0) || (value >= upper_[c] && gradient < 0);
    step_[c] = gradient;
  }
  std::fill(gram_.begin(), gram_.end(), 0);
  if (rows_ <= columns_) {  // step = -J^T (J J^T + lambda)^-1 e
    for (std::size_t c = 0; c < columns_; ++c) {
      if (held_[c]) continue;
      const double* column = jacobian_.data() + c * rows_;
      for (std::size_t i = 0; i < rows_; ++i)
        for (std::size_t j = 0; j <= i; ++j) gram_[i * rows_ + j] += column[i] * column[j];
    }
    for (std::size_t i = 0; i < rows_; ++i) gram_[i * rows_ + i] += lambda;
    solution_ = error_;
    solvePositive(gram_, solution_, rows_);
    for (std::size_t c = 0; c < columns_; ++c) {
      const double* column = jacobian_.data() + c * rows_;
      double sum = 0;
      if (!held_[c])
        for (std::size_t i = 0; i < rows_; ++i) sum += column[i] * solution_[i];
      step_[c] = -sum;
    }
    return;
  }
  for (std::size_t c = 0; c < columns_; ++c) {  // (J^T J + lambda) step = -J^T e
    if (held_[c]) step_[c] = 0;
    for (std::size_t d = 0; d <= c && !held_[c]; ++d) {
      if (held_[d]) continue;
      double sum = 0;
      for (std::size_t i = 0; i < rows_; ++i)
        sum += jacobian_[c * rows_ + i] * jacobian_[d * rows_ + i];
      gram_[c * columns_ + d] = sum;
    }
    gram_[c * columns_ + c] += held_[c] ? 1 : lambda;
  }
  solution_ = step_;
  solvePositive(gram_, solution_, columns_);
  for (std::size_t c = 0; c < columns_; ++c) step_[c] = -solution_[c];
}

double Search::descend(std::span<double> q) {
  trial_.assign(q.begin(), q.end());
  double squared = evaluate(q.data(), true);
  double damping = kFirstDamping;
  int slow = 0;
  for (int i = 0; i < kSteps && squared > kSearchRoundingSquared; ++i) {
    ++iterations_;
    step(damping, squared, q.data());
    for (std::size_t c = 0; c < columns_; ++c) {
      const std::size_t v = at(variables_[c]);
      trial_[v] = std::clamp(q[v] + step_[c], lower_[c], upper_[c]);
    }
    kept_error_ = error_;
    const double tried = evaluate(trial_.data(), false);
    if (!(tried < squared)) {
      error_ = kept_error_;
      if (squared < kNearSolutionSquared && ++slow > 2) break;  // rounding, or a singular pose
      damping *= 16;
      if (++slow >= kSlowSteps) break;
      continue;
    }
    slow = tried > kSlowShare * squared ? slow + 1 : 0;
    for (std::size_t c = 0; c < columns_; ++c) q[at(variables_[c])] = trial_[at(variables_[c])];
    damping = std::max(damping / 4, kLeastDamping);
    squared = evaluate(q.data(), true);
    if (slow >= kSlowSteps) break;
  }
  return squared;
}

}  // namespace leeway::robots
