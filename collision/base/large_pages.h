#pragma once

// Private to collision/: where the arrays stand that queries read here and there.

#include <memory_resource>

namespace leeway::collision {

/// Memory on large pages, where the system gives them to who asks (Linux, transparent huge pages):
/// what a query reads of a mesh stands on some hundred small ones, and a page that was not used
/// lately is looked up in tables that have gone far, too. Elsewhere, and under sanitizers, plain
/// memory. For arrays of a lasting size: what is given back is used again only when all else of the
/// same 2 MB has been. Any thread; O(1); throws std::bad_alloc, as new does.
std::pmr::memory_resource* largePages();

}  // namespace leeway::collision
