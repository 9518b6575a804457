#pragma once

// Edge checks by discrete steps, for comparison with certified ones. Not part of the product.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "collision/scene/scene_access.h"
#include "leeway/planner/compiled_scene.h"
#include "planner/edge/edge_frames.h"
#include "planner/edge/edge_lanes.h"

namespace leeway::bench {

/// Checks states along an edge, at most `step` apart in the space's distance, and nothing between
/// them. Sixteen states at a time share the certifier's lanes, with its balls and bounds.
class Stepper {
 public:
  Stepper(const std::shared_ptr<const planner::CompiledScene>& scene, double step)
      : step_(step),
        frames_(scene, kLanes),
        workspace_(scene->scene()),
        lanes_(frames_, collision::SceneAccess::scratch(workspace_), work_) {}

  /// True if no state collides; `a` is not checked. Allocates nothing.
  bool isFree(const std::vector<double>& a, const std::vector<double>& b) {
    const double length = frames_.scene().space().distance(a, b);
    const int states = std::max(1, static_cast<int>(std::ceil(length / step_)));
    if (!frames_.begin(a, b) || !lanes_.begin(frames_)) return false;
    const int blocks = (states + kLanes - 1) / kLanes;
    for (int block = 0; block < blocks; ++block) {
      collision::LaneValues places;
      double t[kLanes];
      for (int i = 0; i < kLanes; ++i) {
        t[i] = std::min(block + i * blocks + 1, states) / static_cast<double>(states);
        places.at[i] = static_cast<float>(t[i] - 0.5);
      }
      if (lanes_.checkStates(places).id >= 0 || lanes_.isFull() || !isOpenFree(t)) return false;
    }
    return true;
  }

 private:
  static constexpr int kLanes = collision::kLanes;

  bool isOpenFree(const double* t) {
    frames_.release(0);
    int slots[kLanes];
    std::fill(slots, slots + kLanes, -1);
    for (const auto& open : lanes_.open()) {
      const planner::EdgePair pair = frames_.pair(open.id);
      for (int i = 0; i < kLanes; ++i) {
        if ((open.intervals >> i & 1U) == 0) continue;
        if (i > 0 && t[i] == t[i - 1]) continue;  // past the last state
        if (frames_.keepsGap(pair, pair.threshold, t[i], t[i])) continue;
        if (slots[i] < 0) slots[i] = frames_.place(t[i]);
        if (slots[i] < 0) return false;
        const planner::Piece& a = frames_.piece(pair.a);
        const planner::Piece& b = frames_.piece(pair.b);
        const double coarse = b.bounds().coarse.lower(frames_.inFrameOf(
                                  slots[i], pair.b, frames_.center(slots[i], pair.a))) -
                              a.bounds().outer.radius;
        if (coarse > pair.threshold) continue;
        collision::DistanceRequest request;
        request.threshold = pair.threshold;
        request.depth = pair.threshold < 0;
        if (!(collision::distance(a.shape(), frames_.piecePose(slots[i], pair.a), b.shape(),
                                  frames_.piecePose(slots[i], pair.b), request,
                                  collision::SceneAccess::scratch(workspace_),
                                  &collision::SceneAccess::cache(workspace_, pair.scene_pair))
                  .distance.lower > pair.threshold))
          return false;
      }
    }
    return true;
  }

  double step_;
  planner::EdgeFrames frames_;
  collision::Workspace workspace_;
  collision::Work work_;
  planner::EdgeLanes lanes_;
};

}  // namespace leeway::bench
