#pragma once

// Damped least squares for one set of regions. A search has buffers, so only one thread may use it
// at a time.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "robots/inverse/chain.h"
#include "robots/inverse/region.h"

namespace leeway::robots {

class Search {
 public:
  /// `bases`: the chain to R of each region that has a base.
  Search(std::vector<Chain> chains, std::vector<std::optional<Chain>> bases,
         std::vector<PreparedRegion> regions, std::vector<int> variables, std::vector<double> lower,
         std::vector<double> upper);

  /// Moves the solved variables of q (one number for each variable of the model, with solved ones
  /// within their limits) until the frames are in their regions as closely as rounding allows, or
  /// until the steps gain too little. Returns the sum of squared errors, with positions in units of
  /// the chain's reach.
  double descend(std::span<double> q);
  /// Returns that sum at q.
  double squaredError(std::span<const double> q) { return evaluate(q.data(), false); }

  const std::vector<Chain>& chains() const { return chains_; }
  const std::vector<PreparedRegion>& regions() const { return regions_; }
  std::int64_t iterations() const { return iterations_; }

 private:
  double evaluate(const double* q, bool jacobian);
  /// Adds twists_ of F in R to the rows of region r.
  void addTwists(std::size_t r, const RegionError& error);
  /// Takes twists_ from the world into R, times `sign`.
  void turnTwists(double sign, const Eigen::Matrix3d& R_RW);
  void step(double damping, double squared_error, const double* q);

  std::vector<Chain> chains_;
  std::vector<std::optional<Chain>> bases_;
  std::vector<PreparedRegion> regions_;
  std::vector<int> variables_;
  std::vector<double> lower_, upper_;
  std::vector<double> weights_;  // of positions, one for each region
  std::size_t rows_, columns_;
  std::vector<Pose> X_RC_, X_BC_;
  std::vector<Twist> twists_;
  std::vector<double> error_, jacobian_, gram_, solution_, step_, trial_, kept_error_;
  std::vector<char> held_;
  std::int64_t iterations_ = 0;
};

}  // namespace leeway::robots
