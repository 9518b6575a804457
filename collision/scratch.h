#pragma once

#include <memory>

#include "collision/deform_snapshot.h"
#include "collision/mesh_sweep_scratch.h"
#include "collision/penetration.h"
#include "collision/sharp_polytope.h"
#include "collision/sweep_front.h"
#include "leeway/collision/distance.h"
#include "leeway/collision/work.h"

namespace leeway::collision {

/// What the parts of the engine keep in a Scratch: one member each, sized once.
struct Scratch::Impl {
  PolytopeBuffers polytope;
  SharpPolytopeBuffers sharp_polytope;
  DeformScratch deform;
  SweepScratch sweep;
  SweepFrontScratch fronts;
  Work own;
  Work* work = &own;  ///< what is counted
};

}  // namespace leeway::collision
