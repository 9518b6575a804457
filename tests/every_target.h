#pragma once

#include "collision/simd/targets.h"
//
#include <hwy/highway.h>

#include <cstdint>

namespace leeway {

/// Calls run(name) with each instruction set in turn that this machine has and this compiler made
/// code for (a call of another would go nowhere): all that dispatches at run time takes it. Returns
/// how many there are, at least 1. Not for threads side by side.
template <class Run>
int onEveryTarget(const Run& run) {
  int count = 0;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();  // chosen once otherwise
    run(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(0);
    ++count;
  }
  hwy::GetChosenTarget().DeInit();
  return count;
}

}  // namespace leeway
