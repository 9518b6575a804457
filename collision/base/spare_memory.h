#pragma once

// Private to the library: memory that goes from one certifier to the next.

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

namespace leeway::collision {

/// At least `bytes` bytes, aligned to 64; what a thread gave back last is taken first. Planning
/// makes a certifier a problem, each with a megabyte of which few pages are touched: given back to
/// the system, these would cost a fault each the next time. A thread keeps a few megabytes of it
/// until it ends. Throws std::bad_alloc.
void* takeMemory(std::size_t bytes);
/// Of takeMemory(), from any thread.
void giveBackMemory(void* memory) noexcept;

/// For containers that are large and made once a certifier.
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

/// Memory without content.
struct GiveBack {
  void operator()(void* memory) const { giveBackMemory(memory); }
};
template <class T>
using SpareArray = std::unique_ptr<T[], GiveBack>;
/// `T` needs no constructor or destructor: what is there before it is set means nothing.
template <class T>
SpareArray<T> spareArray(std::size_t count) {
  static_assert(std::is_trivially_default_constructible_v<T> &&
                std::is_trivially_destructible_v<T> && alignof(T) <= 64);
  return SpareArray<T>(static_cast<T*>(takeMemory(count * sizeof(T))));
}

}  // namespace leeway::collision
