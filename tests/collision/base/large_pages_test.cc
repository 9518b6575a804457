#include "collision/base/large_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

namespace leeway::collision {
namespace {

// Arrays in large pages, each filled with its own byte.
class Arrays {
 public:
  explicit Arrays(std::uint32_t seed) : random_(seed) {}

  void add() {
    // Small ones, several for each page, and some too large for one page.
    const std::size_t most = std::size_t{1} << (6 + random_() % 16);
    Array array;
    array.bytes = 1 + random_() % most;
    array.alignment = std::size_t{1} << (random_() % 8);
    array.fill = static_cast<std::byte>(random_());
    array.data = static_cast<std::byte*>(largePages()->allocate(array.bytes, array.alignment));
    std::memset(array.data, static_cast<int>(array.fill), array.bytes);
    arrays_.push_back(array);
  }

  // Frees a random array after checking that its fill is intact.
  bool takeOne() {
    std::swap(arrays_[random_() % arrays_.size()], arrays_.back());
    const Array array = arrays_.back();
    arrays_.pop_back();
    const bool good = reinterpret_cast<std::uintptr_t>(array.data) % array.alignment == 0 &&
                      std::all_of(array.data, array.data + array.bytes,
                                  [&](std::byte b) { return b == array.fill; });
    largePages()->deallocate(array.data, array.bytes, array.alignment);
    return good;
  }

  int run(int steps) {
    int bad = 0;
    for (int i = 0; i < steps; ++i) {
      add();
      // Occasionally frees all, so that pages are returned and reused.
      if (random_() % 64 == 0)
        while (!arrays_.empty()) bad += takeOne() ? 0 : 1;
      if (arrays_.size() > 32) bad += takeOne() ? 0 : 1;
    }
    while (!arrays_.empty()) bad += takeOne() ? 0 : 1;
    return bad;
  }

 private:
  struct Array {
    std::byte* data;
    std::size_t bytes, alignment;
    std::byte fill;
  };
  std::mt19937 random_;
  std::vector<Array> arrays_;
};

TEST(LargePages, ArraysKeepWhatIsWrittenToThem) { EXPECT_EQ(Arrays(1).run(1000), 0); }

TEST(LargePages, ThreadsShareThem) {
  int bad[2] = {-1, -1};
  std::thread other([&] { bad[1] = Arrays(2).run(300); });
  bad[0] = Arrays(3).run(300);
  other.join();
  EXPECT_EQ(bad[0], 0);
  EXPECT_EQ(bad[1], 0);
}

TEST(LargeBuffer, IsMovedAndHeldOnce) {
  LargeBuffer small(3), large(std::size_t{9} << 20);
  large.data()[large.size() - 1] = std::byte{5};
  small = std::move(large);
  ASSERT_EQ(small.size(), std::size_t{9} << 20);
  EXPECT_EQ(small.data()[small.size() - 1], std::byte{5});
  const LargeBuffer last(std::move(small));
  EXPECT_EQ(last.data()[last.size() - 1], std::byte{5});
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(last.data()) % 16, 0U);
}

}  // namespace
}  // namespace leeway::collision
