#include "collision/mesh/descent/sweep_fronts.h"

#include "collision/base/scratch.h"
#include "collision/mesh/descent/sweep_front.h"

namespace leeway::collision {

SweepFronts::SweepFronts(Scratch& scratch) : scratch_(scratch) {
  scratch_.impl().fronts.clear();
  scratch_.impl().fronts.active = true;
}
SweepFronts::~SweepFronts() { scratch_.impl().fronts.active = false; }

}  // namespace leeway::collision
