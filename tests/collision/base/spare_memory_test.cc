#include "collision/base/spare_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <thread>
#include <vector>

namespace leeway::collision {
namespace {

TEST(SpareMemory, WhatWasGivenBackIsTakenAgainWhereItFits) {
  void* const first = takeMemory(100'000);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(first) % 64, 0U);
  giveBackMemory(first);
  void* const again = takeMemory(90'000);
  EXPECT_EQ(again, first);
  giveBackMemory(again);
  void* const small = takeMemory(1'000);  // a block that is far too large is not used
  EXPECT_NE(small, first);
  giveBackMemory(small);
  giveBackMemory(nullptr);
}

/// Like a certifier that lives as long as its thread, or a static one in main's thread.
struct Holder {
  ~Holder() {
    void* const last = takeMemory(5'000);
    std::memset(last, 1, 5'000);
    giveBackMemory(last);
    for (void* memory : held) giveBackMemory(memory);
  }
  std::vector<void*> held;
};

/// Regression: blocks that the thread had kept were freed twice.
TEST(SpareMemory, IsGivenBackAfterTheThreadHasNoneOfItsOwn) {
  for (int run = 0; run < 4; ++run) {
    std::thread thread([] {
      thread_local Holder holder;  // constructed before the thread's spare memory, and so destroyed
                                   // after it
      std::vector<void*> kept;
      holder.held.reserve(40);
      for (int i = 0; i < 40; ++i) holder.held.push_back(takeMemory(5'000));
      for (int i = 0; i < 8; ++i) kept.push_back(takeMemory(5'000));
      for (void* memory : kept) giveBackMemory(memory);
    });
    thread.join();
  }
}

}  // namespace
}  // namespace leeway::collision
