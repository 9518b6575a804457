#pragma once

#include <ompl/base/StateValidityChecker.h>

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <unordered_map>
#include <vector>

#include "leeway/planner/edge_certifier.h"

namespace leeway::planner {

/// One EdgeCertifier per thread for one compiled scene, because the threads of a planner share
/// OMPL's checkers and cannot share a certifier. The thread that made the pool gets its certifier
/// without a lock.
class CertifierPool {
 public:
  struct Slot {
    explicit Slot(const std::shared_ptr<const CompiledScene>& scene);
    EdgeCertifier certifier;
    std::vector<double> point;  ///< scratch of the space's size
    /// Motions that were not proven free, by the pair in the way (collision::Scene::pairs()).
    std::unordered_map<int, std::uint64_t> blocked;
  };

  explicit CertifierPool(std::shared_ptr<const CompiledScene> scene);
  const CompiledScene& scene() const { return *scene_; }
  /// Throws std::invalid_argument unless the states of an OMPL space are those of the scene.
  /// `call` begins the message.
  void requireSpace(const ompl::base::SpaceInformationPtr& space_information,
                    const char* call) const;
  /// The calling thread's certifier. Allocates at a thread's first call.
  Slot& local();
  /// Sums over all threads. Call it only while no thread uses a certifier.
  EdgeCertifier::Statistics statistics() const;
  /// The sum of Slot::blocked over all threads. Call it when none of them is in a certifier.
  std::unordered_map<int, std::uint64_t> blocked() const;

 private:
  std::shared_ptr<const CompiledScene> scene_;
  std::thread::id owner_;
  Slot own_;
  mutable std::mutex mutex_;
  std::map<std::thread::id, std::unique_ptr<Slot>> others_;
};

/// A state is valid if it is within the limits and proven to keep the scene's margins. clearance()
/// is a lower bound on the signed distance of the checked pairs [m], at most `tolerance` below it
/// (declared as OMPL's BOUNDED_APPROXIMATE), or infinity if no pair is checked. States are those of
/// OmplStateSpace. Thread-safe. The constructor throws std::invalid_argument for a pool of another
/// space, and without one.
class OmplValidityChecker : public ompl::base::StateValidityChecker {
 public:
  OmplValidityChecker(const ompl::base::SpaceInformationPtr& space_information,
                      std::shared_ptr<CertifierPool> pool, double tolerance = 1e-3);

  bool isValid(const ompl::base::State* state) const override;
  double clearance(const ompl::base::State* state) const override;
  double tolerance() const { return tolerance_; }

 private:
  std::shared_ptr<CertifierPool> pool_;
  double tolerance_;
};

}  // namespace leeway::planner
