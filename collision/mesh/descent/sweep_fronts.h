#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// While this object lives, sweptDistance() of meshes with its scratch starts from the pairs of
/// nodes at which the last sweep of the same meshes ended, each with the direction that separated
/// it. Sweeps over consecutive parts of a motion end at the same pairs. Answers hold in either
/// case. Queried meshes must outlive this object. Only one at a time for each scratch; O(1).
class SweepFronts {
 public:
  explicit SweepFronts(Scratch& scratch);
  ~SweepFronts();
  SweepFronts(const SweepFronts&) = delete;
  SweepFronts& operator=(const SweepFronts&) = delete;

 private:
  Scratch& scratch_;
};

}  // namespace leeway::collision
