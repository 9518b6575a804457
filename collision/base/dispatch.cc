#include "collision/base/dispatch.h"

namespace leeway::collision {

namespace {

// No target is chosen yet: functions that are called before this file is initialized choose their
// own.
constinit const hwy::ChosenTarget unknown;

}  // namespace

constinit const hwy::ChosenTarget* chosen_target = &unknown;

namespace {

[[maybe_unused]] const bool known = (chosen_target = &hwy::GetChosenTarget(), true);

}  // namespace

}  // namespace leeway::collision
