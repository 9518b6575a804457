#pragma once

// Private to the library: memory that is passed from one certifier to the next.

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

namespace leeway::collision {

/// Returns at least `bytes` bytes, aligned to 64, preferably the block that the thread gave back
/// last. Planning makes a certifier for each problem, each with a megabyte of which few pages are
/// used. If these were returned to the system, each would cost a page fault the next time. A thread
/// keeps a few megabytes until it ends. Throws std::bad_alloc.
void* takeMemory(std::size_t bytes);
/// Frees memory of takeMemory(), from any thread.
void giveBackMemory(void* memory) noexcept;

/// For large containers that are made once for each certifier.
template <class T>
struct SpareAllocator {
  using value_type = T;
  SpareAllocator() = default;
  template <class U>
  SpareAllocator(const SpareAllocator<U>&) {}  // NOLINT(google-explicit-constructor): as all are
  T* allocate(std::size_t count) { return static_cast<T*>(takeMemory(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t) { giveBackMemory(memory); }
  template <class U>
  bool operator==(const SpareAllocator<U>&) const {
    return true;
  }
};
template <class T>
using SpareVector = std::vector<T, SpareAllocator<T>>;

/// Deleter of memory that has no content to destroy.
struct GiveBack {
  void operator()(void* memory) const { giveBackMemory(memory); }
};
template <class T>
using SpareArray = std::unique_ptr<T[], GiveBack>;
/// `T` needs no constructor or destructor: a value is undefined until it is set.
template <class T>
SpareArray<T> spareArray(std::size_t count) {
  static_assert(std::is_trivially_default_constructible_v<T> &&
                std::is_trivially_destructible_v<T> && alignof(T) <= 64);
  return SpareArray<T>(static_cast<T*>(takeMemory(count * sizeof(T))));
}

}  // namespace leeway::collision
