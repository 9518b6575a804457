#include "collision/base/dispatch.h"

namespace leeway::collision {

namespace {

// Chooses none: functions that are called before this file is initialized find out themselves.
constinit const hwy::ChosenTarget unknown;

}  // namespace

constinit const hwy::ChosenTarget* chosen_target = &unknown;

namespace {

[[maybe_unused]] const bool known = (chosen_target = &hwy::GetChosenTarget(), true);

}  // namespace

}  // namespace leeway::collision
