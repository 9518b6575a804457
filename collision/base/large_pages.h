#pragma once

// Private to collision/: memory for the arrays that queries read at scattered places.

#include <memory_resource>

namespace leeway::collision {

/// Memory on large pages, where the system grants them on request (Linux, transparent huge pages).
/// A query of a mesh reads from some hundred small pages; each that has dropped out of the TLB
/// costs a walk through page tables that are evicted, too. Elsewhere, and under sanitizers, plain
/// memory. For arrays that keep their size: freed memory is used again only once all arrays of the
/// same 2 MB are freed. Any thread; O(1); throws std::bad_alloc, as new does.
std::pmr::memory_resource* largePages();

}  // namespace leeway::collision
