#pragma once

// Private to robots/: work that others cannot ask on behalf of their caller, as a Stop is asked
// from the caller's thread alone.

#include <functional>

#include "leeway/robots/stopped.h"

namespace leeway::robots {

/// Calls work(asked) in a thread of its own. Meanwhile this thread asks `stop`, every 20 ms; once
/// that is true, so is `asked`, in any thread, and nobody asks again. Returns when work() has
/// ended. Throws what work() or `stop` throws, and Stopped where work() did not notice in time.
/// Without `stop`, or where no thread is to be had, work({}) is called here. The thread takes some
/// 50 us.
void workInterruptibly(const Stop& stop, const std::function<void(const Stop& asked)>& work);

}  // namespace leeway::robots
