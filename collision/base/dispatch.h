#ifndef LEEWAY_COLLISION_BASE_DISPATCH_H
#define LEEWAY_COLLISION_BASE_DISPATCH_H

#include "collision/base/targets.h"
//
#include <hwy/highway.h>

namespace leeway::collision {

/// Highway's record of the target that it chose. HWY_DYNAMIC_DISPATCH fetches it through a library
/// call each time, which spills all arguments and touches a page that nothing else uses.
extern const hwy::ChosenTarget* chosen_target;

}  // namespace leeway::collision

/// HWY_DYNAMIC_DISPATCH() without that call, for hot functions.
#if HWY_IDE || ((HWY_TARGETS & (HWY_TARGETS - 1)) == 0)
#define LEEWAY_DISPATCH(FUNCTION) HWY_DYNAMIC_DISPATCH(FUNCTION)
#else
#define LEEWAY_DISPATCH(FUNCTION) \
  (*(HWY_DISPATCH_TABLE(FUNCTION)[leeway::collision::chosen_target->GetIndex()]))
#endif

#endif

// Compiled once for each target. Plain code, the last of several targets, is for processors from
// before 2008 and for tests. If the compiler decides what to inline there, compiling takes a third
// of the time.
#if HWY_TARGET == HWY_SCALAR && (HWY_TARGETS & (HWY_TARGETS - 1)) != 0
#undef HWY_INLINE
#define HWY_INLINE inline
#endif
