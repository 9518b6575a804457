#include "leeway/robots/prepared_store.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace leeway::robots {
namespace {

struct Number final : PreparedStore::Entry {
  explicit Number(int n) : number(n) {}
  int number;
};

PreparedStore::Fits is(int n) {
  return [n](const PreparedStore::Entry& entry) {
    return dynamic_cast<const Number&>(entry).number == n;
  };
}

TEST(PreparedStore, KeepsTheFewThatWereUsedLast) {
  const PreparedStore store;
  const int most = static_cast<int>(PreparedStore::kMost);
  EXPECT_EQ(store.find(is(0)), nullptr);
  for (int n = 0; n < most; ++n) store.keep(std::make_shared<Number>(n), is(n));
  EXPECT_NE(store.find(is(0)), nullptr);  // used again, so 1 is the oldest now
  store.keep(std::make_shared<Number>(most), is(most));
  EXPECT_EQ(store.find(is(1)), nullptr);
  for (int n = 0; n <= most; ++n) {
    if (n != 1) {
      EXPECT_NE(store.find(is(n)), nullptr) << n;
    }
  }
}

TEST(PreparedStore, TheFirstOfTwoStays) {
  const PreparedStore store;
  const auto first = std::make_shared<Number>(7);
  EXPECT_EQ(store.keep(first, is(7)), first);
  EXPECT_EQ(store.keep(std::make_shared<Number>(7), is(7)), first);
}

TEST(PreparedStore, CopiesBeginEmpty) {
  PreparedStore store;
  store.keep(std::make_shared<Number>(1), is(1));
  const PreparedStore copy(store);
  EXPECT_EQ(copy.find(is(1)), nullptr);
  PreparedStore other;
  other.keep(std::make_shared<Number>(2), is(2));
  store = other;  // its content belonged to something else
  EXPECT_EQ(store.find(is(1)), nullptr);
  EXPECT_EQ(store.find(is(2)), nullptr);
}

TEST(PreparedStore, ThreadsShareIt) {
  const PreparedStore store;
  std::vector<std::shared_ptr<const PreparedStore::Entry>> got(4);
  std::vector<std::thread> threads;
  for (auto& entry : got)
    threads.emplace_back([&] {
      for (int round = 0; round < 100; ++round)
        for (int n = 0; n < 4; ++n) {
          entry = store.find(is(n));
          if (!entry) entry = store.keep(std::make_shared<Number>(n), is(n));
        }
    });
  for (std::thread& thread : threads) thread.join();
  for (const auto& entry : got) EXPECT_EQ(entry, got[0]);
}

}  // namespace
}  // namespace leeway::robots
