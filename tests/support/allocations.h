#pragma once

#include <cstddef>

namespace leeway::collision::testing {

/// The number of calls of operator new by this thread so far. A query that allocates nothing leaves
/// it unchanged.
std::size_t allocationCount();

}  // namespace leeway::collision::testing
