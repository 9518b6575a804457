#pragma once

// Private to collision/: a pool of snapshots.

#include <atomic>
#include <cstddef>
#include <memory>
#include <new>
#include <vector>

#include "collision/deform/snapshot.h"

namespace leeway::collision {

/// Snapshots are handed out as shared pointers and return when the last pointer is released. The
/// control block of the shared pointer is also in the slot, so nothing is allocated once there are
/// enough slots. One thread takes slots; any thread gives them back.
class SnapshotPool : public std::enable_shared_from_this<SnapshotPool> {
 public:
  struct Slot {
    DeformableSnapshotImpl snapshot;
    alignas(std::max_align_t) std::byte control[128];
    std::atomic<bool> free{true};
  };

  /// A free slot; allocates one if there is none.
  Slot& take() {
    for (const std::unique_ptr<Slot>& slot : slots_) {
      // Pairs with the release in Allocator::deallocate(): all reads have ended.
      if (slot->free.load(std::memory_order_acquire)) return *slot;
    }
    slots_.push_back(std::make_unique<Slot>());
    return *slots_.back();
  }

  /// The slot's snapshot for readers. It keeps the pool alive.
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
    std::shared_ptr<SnapshotPool> pool;
    Slot* slot;

    Allocator(std::shared_ptr<SnapshotPool> p, Slot* s) : pool(std::move(p)), slot(s) {}
    template <class U>
    Allocator(const Allocator<U>& other) : pool(other.pool), slot(other.slot) {}

    T* allocate(std::size_t n) {
      static_assert(sizeof(T) <= sizeof(Slot::control),
                    "a slot is too small for the control block");
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
