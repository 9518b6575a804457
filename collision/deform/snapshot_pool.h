#pragma once

// Private to collision/: snapshots whose memory is used again.

#include <atomic>
#include <cstddef>
#include <memory>
#include <new>
#include <vector>

#include "collision/deform/snapshot.h"

namespace leeway::collision {

/// Snapshots that are handed out as shared pointers, and come back when the last of these goes. The
/// shared pointer's own bookkeeping stands in the slot, too, so that nothing is allocated once
/// there are slots enough. One thread takes; any thread gives back.
class DeformPool : public std::enable_shared_from_this<DeformPool> {
 public:
  struct Slot {
    DeformableSnapshotImpl snapshot;
    alignas(std::max_align_t) std::byte control[128];
    std::atomic<bool> free{true};
  };

  /// A slot that nobody holds; a new one when there is none.
  Slot& take() {
    for (const std::unique_ptr<Slot>& slot : slots_) {
      // Pairs with the release in Allocator::deallocate(): what readers did is over.
      if (slot->free.load(std::memory_order_acquire)) return *slot;
    }
    slots_.push_back(std::make_unique<Slot>());
    return *slots_.back();
  }

  /// The slot's snapshot as what readers hold; it keeps the pool alive.
  std::shared_ptr<const DeformableSnapshot> publish(Slot& slot) {
    slot.free.store(false, std::memory_order_relaxed);
    return {&slot.snapshot.face, [](const DeformableSnapshot*) {},
            Allocator<std::byte>{shared_from_this(), &slot}};
  }

  std::size_t slotCount() const { return slots_.size(); }
  const Slot& slot(std::size_t i) const { return *slots_[i]; }

 private:
  template <class T>
  struct Allocator {
    using value_type = T;
    std::shared_ptr<DeformPool> pool;
    Slot* slot;

    Allocator(std::shared_ptr<DeformPool> p, Slot* s) : pool(std::move(p)), slot(s) {}
    template <class U>
    Allocator(const Allocator<U>& other) : pool(other.pool), slot(other.slot) {}

    T* allocate(std::size_t n) {
      static_assert(sizeof(T) <= sizeof(Slot::control), "a slot is too small for its bookkeeping");
      if (n != 1) throw std::bad_alloc();
      return reinterpret_cast<T*>(slot->control);
    }
    void deallocate(T*, std::size_t) { slot->free.store(true, std::memory_order_release); }
    template <class U>
    bool operator==(const Allocator<U>& other) const {
      return slot == other.slot;
    }
  };

  std::vector<std::unique_ptr<Slot>> slots_;
};

}  // namespace leeway::collision
