#include "tests/support/allocations.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace {
thread_local std::size_t count = 0;

void* allocate(std::size_t size) {
  ++count;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
// Standard algorithms request optional buffers this way.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size > 0 ? size : 1);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size > 0 ? size : 1);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }

namespace leeway::collision::testing {

std::size_t allocationCount() { return count; }

TEST(Allocations, AreCounted) {
  const std::size_t before = allocationCount();
  std::vector<int> v(100);
  const auto p = std::make_unique<double>(v.size());
  EXPECT_EQ(allocationCount(), before + 2);
}

}  // namespace leeway::collision::testing
