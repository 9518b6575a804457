#pragma once

// Private to collision/: memory for arrays that queries read at scattered places.

#include <cstddef>
#include <memory_resource>
#include <utility>

namespace leeway::collision {

/// Memory on large pages where the system provides them on request (Linux, transparent huge pages);
/// elsewhere, and under sanitizers, plain memory. A query of a mesh reads from about a hundred
/// small pages. Each page that is no longer in the TLB costs a walk through page tables that are
/// evicted, too. Use this for arrays of constant size: freed memory is reused only after all arrays
/// of the same 2 MB are freed. Any thread; O(1); throws std::bad_alloc, like new.
std::pmr::memory_resource* largePages();

/// Memory for arrays of megabytes that are filled as a whole, such as those of a large mesh. On
/// separate large pages they are filled in half the time, because the system takes long to provide
/// small pages. Any thread; throws std::bad_alloc.
std::pmr::memory_resource* largeArrays();

/// Bytes of largeArrays() that are not initialized to zero. Files of hundreds of megabytes are read
/// into them. Aligned to 16.
class LargeBuffer {
 public:
  LargeBuffer() = default;
  explicit LargeBuffer(std::size_t size)
      : data_(static_cast<std::byte*>(largeArrays()->allocate(size, kAlignment))), size_(size) {}
  LargeBuffer(LargeBuffer&& other) noexcept { *this = std::move(other); }
  LargeBuffer& operator=(LargeBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~LargeBuffer() {
    if (data_ != nullptr) largeArrays()->deallocate(data_, size_, kAlignment);
  }

  std::byte* data() { return data_; }
  const std::byte* data() const { return data_; }
  std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t kAlignment = 16;
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace leeway::collision
