#pragma once

#include <cstddef>

namespace leeway::collision::testing {

/// How often this thread has called operator new so far: a query that allocates nothing leaves it
/// as it was.
std::size_t allocationCount();

}  // namespace leeway::collision::testing
