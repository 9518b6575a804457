#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "planner/search/goal_sampler.h"

namespace leeway::planner {

/// Further points of goals that are poses, drawn when a search asks for them. What batch k holds
/// depends on k alone, whichever of several threads asks for it first. For one search.
class GoalSupply {
 public:
  /// `points` are known; all must outlive the supply.
  GoalSupply(std::shared_ptr<const CompiledScene> scene, GoalSampler& sampler, GoalPoints& points);

  /// Before a search. `apart`: what it draws is looked at by a certifier of the supply's own, as
  /// the sampler's is in use or must not depend on how many batches threads ask for.
  void open(bool apart);
  /// Appends batch k to `points`; false when there is none. Thread-safe.
  bool add(std::size_t k, std::vector<std::vector<double>>& points);
  /// After the search, of which `batches` count: their points become known.
  void close(std::size_t batches);
  /// Of the supply's own certifier, for the batches that counted.
  const EdgeCertifier::Statistics& work() const { return work_; }

 private:
  struct Batch {
    std::size_t first;               ///< of its points among those drawn
    EdgeCertifier::Statistics work;  ///< of the own certifier, up to its end
  };
  std::shared_ptr<const CompiledScene> scene_;
  GoalSampler& sampler_;
  GoalPoints& points_;
  std::unique_ptr<EdgeCertifier> own_;
  std::mutex mutex_;
  GoalPoints drawn_;  ///< the known ones, then batch by batch
  std::vector<Batch> batches_;
  EdgeCertifier::Statistics work_;
};

}  // namespace leeway::planner
