#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "leeway/collision/pose.h"

namespace leeway::tools::report {

/// A serial chain of single joints, in the form that other solvers use.
struct IkChain {
  struct Joint {
    collision::Pose X_PJ;  ///< in the frame of the previous joint, after that joint's motion
    Eigen::Vector3d axis;
    bool slides = false;
    double lower, upper;  ///< finite
  };
  std::vector<Joint> joints;
  collision::Pose X_JF;  ///< the tip in the last joint's frame
};

/// One engine's form of one chain, prepared off the clock.
class IkSolver {
 public:
  virtual ~IkSolver() = default;
  /// Finds values that place the tip at X_WF, within the limits, from `start` and then from the
  /// engine's own starts. False if none was found. May throw, abort or loop.
  virtual bool solve(const collision::Pose& X_WF, std::span<const double> start,
                     std::span<double> values) = 0;
};

class IkEngine {
 public:
  virtual ~IkEngine() = default;
  virtual const char* name() const = 0;
  virtual std::unique_ptr<IkSolver> prepare(const IkChain& chain) const = 0;
};

/// Limit on an engine's starts.
inline constexpr int kIkStarts = 200;

/// Random starts for rivals: uniform numbers, the same in every run and on every machine.
class IkRandom {
 public:
  double uniform(double low, double high) {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return low + (high - low) * static_cast<double>(state_ >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 1;
};

}  // namespace leeway::tools::report
