#include "collision/base/large_pages.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <new>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer)
#define LEEWAY_PLAIN_MEMORY
#endif
#elif defined(__SANITIZE_ADDRESS__)
// Within a shared page, the sanitizer would miss reads past an array's end.
#define LEEWAY_PLAIN_MEMORY
#endif

namespace leeway::collision {

#if defined(MADV_HUGEPAGE) && !defined(LEEWAY_PLAIN_MEMORY)

namespace {

constexpr std::size_t kPage = std::size_t{2} << 20;
constexpr std::align_val_t kPageAlignment{kPage};
// Smaller arrays gain nothing, and neither do larger ones. (Measured: with separate pages for the
// arrays of 200k triangles, queries were no faster, and distances after `restructure` took 1.4
// times as long.)
constexpr std::size_t kLeast = 4096, kMost = kPage / 2;
// Alignment of arrays that share a page: a cache line.
constexpr std::size_t kAlignment = 64;

class LargePages final : public std::pmr::memory_resource {
 private:
  // The header of a page that arrays share.
  struct Shared {
    std::size_t used, arrays;
  };

  static bool isShared(std::size_t bytes, std::size_t alignment) {
    return bytes >= kLeast && bytes <= kMost && alignment <= kAlignment;
  }

  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    if (!isShared(bytes, alignment))
      return std::pmr::new_delete_resource()->allocate(bytes, alignment);
    const std::lock_guard<std::mutex> lock(mutex_);
    bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
    if (open_ == nullptr || open_->used + bytes > kPage) open_ = newPage();
    void* const result = reinterpret_cast<std::byte*>(open_) + open_->used;
    open_->used += bytes;
    ++open_->arrays;
    return result;
  }

  void do_deallocate(void* p, std::size_t bytes, std::size_t alignment) override {
    if (!isShared(bytes, alignment))
      return std::pmr::new_delete_resource()->deallocate(p, bytes, alignment);
    const std::lock_guard<std::mutex> lock(mutex_);
    auto* const shared = reinterpret_cast<Shared*>(static_cast<std::byte*>(p) -
                                                   reinterpret_cast<std::uintptr_t>(p) % kPage);
    if (--shared->arrays > 0) return;
    if (shared == open_) {
      open_->used = kAlignment;
    } else {
      ::operator delete(shared, kPageAlignment);
    }
  }

  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  static Shared* newPage() {
    void* const page = ::operator new(kPage, kPageAlignment);
    // This is only a hint: without a large page, small pages back the same memory.
    static_cast<void>(madvise(page, kPage, MADV_HUGEPAGE));
    return new (page) Shared{kAlignment, 0};
  }

  std::mutex mutex_;
  Shared* open_ = nullptr;  // the page that takes the next array
};

}  // namespace

std::pmr::memory_resource* largePages() {
  // Never destroyed, because arrays may outlive any static object.
  static LargePages* const pages = new LargePages;
  return pages;
}

namespace {

class LargeArrays final : public std::pmr::memory_resource {
  static constexpr std::size_t kLeastArray = 2 * kPage;

  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    void* const result = std::pmr::new_delete_resource()->allocate(bytes, alignment);
    if (bytes >= kLeastArray) {
      // The whole pages within the array. This is only a hint.
      const std::size_t before = (kPage - reinterpret_cast<std::uintptr_t>(result) % kPage) % kPage;
      const std::size_t whole = (bytes - before) / kPage * kPage;
      static_cast<void>(madvise(static_cast<std::byte*>(result) + before, whole, MADV_HUGEPAGE));
    }
    return result;
  }
  void do_deallocate(void* p, std::size_t bytes, std::size_t alignment) override {
    std::pmr::new_delete_resource()->deallocate(p, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
};

}  // namespace

std::pmr::memory_resource* largeArrays() {
  static LargeArrays* const arrays = new LargeArrays;
  return arrays;
}

#else

std::pmr::memory_resource* largePages() { return std::pmr::new_delete_resource(); }
std::pmr::memory_resource* largeArrays() { return std::pmr::new_delete_resource(); }

#endif

}  // namespace leeway::collision
