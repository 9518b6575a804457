#include "collision/deform/update/strategy.h"

#include "collision/deform/update/snapshot_box.h"

namespace leeway::collision {

bool follow(UpdateState& state, StrategyChoice& choice, DeformableSnapshotImpl& next,
            const KnownVertices& known) {
  UpdateStatistics& statistics = state.statistics;
  statistics.nodes_touched = statistics.vertices_touched = statistics.triangles_rebuilt = 0;
  statistics.decay = 0;
  next.bounds = nullptr;
  bool good = true;
  switch (choice.strategy) {
    case DeformStrategy::kRebuild:
      good = followByRebuild(state, next, DeformMethod::kBinned, known.bounded);
      break;
    case DeformStrategy::kRebuildLinear:
      good = followByRebuild(state, next, DeformMethod::kLinear, known.bounded);
      break;
    case DeformStrategy::kRestructure:
      good = followByRestructure(state, next);
      break;
    case DeformStrategy::kHybrid:
      good = followByHybrid(state, next, known);
      if (good && state.options.strategy == DeformStrategy::kAuto)
        good = rebuildIfDecayed(state, choice, next, known);
      break;
    case DeformStrategy::kLazy:
      good = followOnDemand(state, next, Demand::kVertices, known.bounded);
      break;
    case DeformStrategy::kOctree:
      good = followOnDemand(state, next, Demand::kNoTree, known.bounded);
      break;
    case DeformStrategy::kMorph:
    case DeformStrategy::kSkinned:
    case DeformStrategy::kReduced:
      good = followByMotion(state, next);
      break;
    case DeformStrategy::kRefit:
    case DeformStrategy::kAuto:  // chooseStrategy() never returns it
      good = followByRefit(state, next);
      break;
  }
  return good && isWithinLimits(next);
}

}  // namespace leeway::collision
