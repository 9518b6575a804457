#pragma once

#include "leeway/collision/pose.h"
#include "leeway/collision/query.h"
#include "leeway/collision/shape.h"

namespace leeway::collision {

/// While one lives, sweptDistance() of meshes with its scratch begins with the pairs of nodes that
/// settled the last sweep of the same meshes, each along the direction that settled it: sweeps over
/// one motion part by part look at the same parts of both. It costs or saves time and never truth.
/// No mesh that is asked about may be destroyed before it. One at a time for a scratch; O(1).
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
