#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "planner/search/goal_sampler.h"

namespace leeway::planner {

/// Further points of goals that are poses, drawn when a search requests them. Batch k depends only
/// on k, not on the thread that requests it first. For one search.
class GoalSupply {
 public:
  /// `points` are already known; all must outlive the supply.
  GoalSupply(std::shared_ptr<const CompiledScene> scene, GoalSampler& sampler, GoalPoints& points);

  /// Call it before a search. `apart`: the supply checks its points with its own certifier, because
  /// the sampler's is in use or must not depend on how many batches threads request.
  void open(bool apart);
  /// Appends batch k to `points`; false if there is none. Thread-safe.
  bool add(std::size_t k, std::vector<std::vector<double>>& points);
  /// Call it after the search, which used `batches` batches: their points become known.
  void close(std::size_t batches);
  /// The work of the supply's own certifier, for the batches that counted.
  const EdgeCertifier::Statistics& work() const { return work_; }

 private:
  struct Batch {
    std::size_t first;               ///< of its points among those drawn
    EdgeCertifier::Statistics work;  ///< of its own certifier, up to the batch's end
  };
  std::shared_ptr<const CompiledScene> scene_;
  GoalSampler& sampler_;
  GoalPoints& points_;
  std::unique_ptr<EdgeCertifier> own_;
  std::mutex mutex_;
  GoalPoints drawn_;  ///< the known points, then batch by batch
  std::vector<Batch> batches_;
  EdgeCertifier::Statistics work_;
};

}  // namespace leeway::planner
