#pragma once

#include "collision/base/targets.h"
//
#include <hwy/highway.h>

namespace leeway::collision {

/// Where Highway keeps which target it chose. HWY_DYNAMIC_DISPATCH asks its library each time: a
/// call, for which all arguments have to be put aside, in a page that nothing else uses.
extern const hwy::ChosenTarget* chosen_target;

}  // namespace leeway::collision

/// HWY_DYNAMIC_DISPATCH() without that call. For what is called so often that it counts.
#if HWY_IDE || ((HWY_TARGETS & (HWY_TARGETS - 1)) == 0)
#define LEEWAY_DISPATCH(FUNCTION) HWY_DYNAMIC_DISPATCH(FUNCTION)
#else
#define LEEWAY_DISPATCH(FUNCTION) \
  (*(HWY_DISPATCH_TABLE(FUNCTION)[leeway::collision::chosen_target->GetIndex()]))
#endif
