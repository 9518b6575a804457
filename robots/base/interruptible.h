#pragma once

// Private to robots/: interruptible work in another thread. A Stop may only be called from the
// caller's thread, so the work cannot call it directly.

#include <functional>

#include "leeway/robots/stopped.h"

namespace leeway::robots {

/// Calls work(asked) in a separate thread. Meanwhile this thread calls `stop` every 20 ms. Once it
/// returns true, `asked` returns true in any thread, and `stop` is not called again. Returns when
/// work() has ended. Throws what work() or `stop` throws, and Stopped if work() did not notice in
/// time. Without `stop`, or if no thread is available, work({}) is called in this thread. The
/// thread takes about 50 us.
void workInterruptibly(const Stop& stop, const std::function<void(const Stop& asked)>& work);

}  // namespace leeway::robots
