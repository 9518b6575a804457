#pragma once

// Private to robots/: work that others cannot ask on behalf of their caller, as a Stop is asked
// from the caller's thread alone.

#include <functional>

#include "leeway/robots/stopped.h"

namespace leeway::robots {

/// Calls work(asked), in a thread of its own, while this one asks `stop` every some hundredths of a
/// second: `asked` says so from then on, in any thread. Returns when work() has ended, and throws
/// Stopped if it was to be. Without
/// `stop`, or a thread, work({}) is called here. Throws what work() or `stop` throws. O(50 us).
void workInterruptibly(const Stop& stop, const std::function<void(const Stop& asked)>& work);

}  // namespace leeway::robots
