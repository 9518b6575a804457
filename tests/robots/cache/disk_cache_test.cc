#include "robots/cache/disk_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cfenv>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <thread>

#include "leeway/robots/cache_folder.h"
#include "robots/cache/content_key.h"
#include "tests/support/folder.h"

namespace leeway::robots {
namespace {

namespace fs = std::filesystem;

std::string keyOf(std::string_view text) {
  ContentKey key("test");
  key.add(text);
  return key.finish();
}

std::vector<std::byte> bytesOf(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

std::string textOf(const std::optional<collision::LargeBuffer>& kept) {
  return kept ? std::string(reinterpret_cast<const char*>(kept->data()), kept->size()) : "nothing";
}

int filesIn(const std::string& folder) {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder)) ++count;
  return count;
}

TEST(ContentKey, TellsContentsApart) {
  EXPECT_EQ(keyOf("a").size(), 64U);
  EXPECT_EQ(keyOf("a"), keyOf("a"));
  EXPECT_NE(keyOf("a"), keyOf("b"));
  ContentKey first("test"), second("test"), other("other");
  first.add("ab");
  first.add("c");
  second.add("a");
  second.add("bc");
  other.add("a");
  EXPECT_NE(first.finish(), second.finish());
  EXPECT_NE(other.finish(), keyOf("a"));
}

// Data that is built with another rounding mode differs, and bounds depend on it.
TEST(ContentKey, IsEmptyUnderOtherRounding) {
  ASSERT_EQ(std::fesetround(FE_UPWARD), 0);
  const std::string key = keyOf("a");
  ASSERT_EQ(std::fesetround(FE_TONEAREST), 0);
  EXPECT_EQ(key, "");
  EXPECT_NE(keyOf("a"), "");
}

// Checksums detect damage, not malice.
TEST(DiskCache, BelievesNoFileThatOthersMayWrite) {
  const Folder folder;
  const DiskCache cache(folder.path("new"));
  const std::string key = keyOf("mesh");
  cache.write(key, bytesOf("0123456789"));
  const fs::path file = folder.path("new") + "/" + key + ".leeway";
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(fs::status(folder.path("new")).permissions(), fs::perms::owner_all);
  EXPECT_EQ(textOf(cache.read(key)), "0123456789");
  for (const fs::perms others : {fs::perms::group_write, fs::perms::others_write}) {
    fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write | others);
    EXPECT_FALSE(cache.read(key));
  }
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write | fs::perms::others_read);
  EXPECT_EQ(textOf(cache.read(key)), "0123456789");
}

TEST(DiskCache, ReturnsWhatWasWritten) {
  const Folder folder;
  const DiskCache cache(folder.path("new/folder"));
  EXPECT_FALSE(cache.read(keyOf("mesh")));
  cache.write(keyOf("mesh"), bytesOf("0123456789"));
  cache.write(keyOf("empty"), {});
  EXPECT_EQ(textOf(cache.read(keyOf("mesh"))), "0123456789");
  EXPECT_TRUE(cache.read(keyOf("empty")));
  EXPECT_FALSE(cache.read(keyOf("another")));
  cache.write(keyOf("mesh"), bytesOf("new"));
  EXPECT_EQ(textOf(cache.read(keyOf("mesh"))), "new");
  EXPECT_EQ(filesIn(folder.path("new/folder")), 2);
}

TEST(DiskCache, IsOffWithoutAFolder) {
  const DiskCache cache("");
  EXPECT_FALSE(cache.isOn());
  cache.write(keyOf("mesh"), bytesOf("text"));
  EXPECT_FALSE(cache.read(keyOf("mesh")));
}

TEST(DiskCache, NoticesAnyDamage) {
  const Folder folder;
  const DiskCache cache(folder.path());
  const std::string key = keyOf("mesh");
  cache.write(key, bytesOf("some bytes, of which every single one counts"));
  const std::string file = folder.path(key + ".leeway");
  const std::string whole = readText(file);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      writeText(file, damaged);
      EXPECT_FALSE(cache.read(key)) << i;
    }
    writeText(file, whole.substr(0, i));
    EXPECT_FALSE(cache.read(key)) << i;
  }
  writeText(file, whole + "x");
  EXPECT_FALSE(cache.read(key));
  writeText(file, whole);
  EXPECT_TRUE(cache.read(key));
  // A file with another key, under this key's name.
  cache.write(keyOf("other"), bytesOf("other"));
  fs::rename(folder.path(keyOf("other") + ".leeway"), file);
  EXPECT_FALSE(cache.read(key));
}

TEST(DiskCache, TakesOnlyFilesForFiles) {
  const Folder folder;
  const DiskCache cache(folder.path());
  const std::string file = folder.path(keyOf("mesh") + ".leeway");
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_FALSE(cache.read(keyOf("mesh")));  // and does not wait for a writer
  fs::remove(file);
  fs::create_directory(file);
  EXPECT_FALSE(cache.read(keyOf("mesh")));
  cache.write(keyOf("mesh"), bytesOf("text"));
  EXPECT_FALSE(cache.read(keyOf("mesh")));
}

TEST(DiskCache, DoesNothingWhereItCannotWrite) {
  const Folder folder;
  folder.write("file", "text");
  const DiskCache in_file(folder.path("file/below"));
  in_file.write(keyOf("mesh"), bytesOf("text"));
  EXPECT_FALSE(in_file.read(keyOf("mesh")));
  EXPECT_EQ(readText(folder.path("file")), "text");
  const DiskCache nowhere("/proc/no/such/folder");
  nowhere.write(keyOf("mesh"), bytesOf("text"));
  EXPECT_FALSE(nowhere.read(keyOf("mesh")));
  const DiskCache full("/dev/full");
  full.write(keyOf("mesh"), bytesOf("text"));
  EXPECT_FALSE(full.read(keyOf("mesh")));
}

void makeOlder(const std::string& file, std::chrono::hours age) {
  fs::last_write_time(file, fs::file_time_type::clock::now() - age);
}

TEST(DiskCache, RemovesTheOldestFilesOfItsOwn) {
  const Folder folder;
  const DiskCache cache(folder.path(), 3500);
  folder.write("mine.txt", std::string(9000, 'x'));
  folder.write("notes.leeway", "text");
  for (const char* name : {"a", "b", "c"}) {
    cache.write(keyOf(name), std::vector<std::byte>(1000));
    makeOlder(folder.path(keyOf(name) + ".leeway"), std::chrono::hours(10 - *name + 'a'));
  }
  EXPECT_TRUE(cache.read(keyOf("a")));  // from now on it is the latest
  cache.write(keyOf("d"), std::vector<std::byte>(1000));
  EXPECT_FALSE(cache.read(keyOf("b")));
  EXPECT_TRUE(cache.read(keyOf("a")) && cache.read(keyOf("c")) && cache.read(keyOf("d")));
  cache.write(keyOf("large"), std::vector<std::byte>(4000));
  EXPECT_FALSE(cache.read(keyOf("large")));
  EXPECT_TRUE(cache.read(keyOf("a")));
  EXPECT_TRUE(fs::exists(folder.path("mine.txt")) && fs::exists(folder.path("notes.leeway")));
}

TEST(DiskCache, RemovesWhatAnotherProcessLeftUnfinished) {
  const Folder folder;
  const DiskCache cache(folder.path());
  const std::string old_one = folder.write(keyOf("a") + ".leeway.17.0.tmp", "half"),
                    new_one = folder.write(keyOf("b") + ".leeway.18.0.tmp", "half");
  makeOlder(old_one, std::chrono::hours(5));
  cache.write(keyOf("c"), bytesOf("text"));
  EXPECT_FALSE(fs::exists(old_one));
  EXPECT_TRUE(fs::exists(new_one));
}

TEST(DiskCache, IsSharedByManyWriters) {
  const Folder folder;
  const std::vector<std::byte> bytes(100000, std::byte{7});
  std::vector<std::thread> threads;
  for (int i = 0; i < 6; ++i)
    threads.emplace_back([&] {
      const DiskCache cache(folder.path());
      for (int k = 0; k < 20; ++k) {
        cache.write(keyOf("mesh"), bytes);
        const auto kept = cache.read(keyOf("mesh"));
        ASSERT_TRUE(kept && kept->size() == bytes.size());
        EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), kept->data()));
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(filesIn(folder.path()), 1);
}

/// Sets an environment variable during the lifetime of the object.
class Setting {
 public:
  Setting(const char* name, const char* value) : name_(name) {
    const char* const now = std::getenv(name);
    before_ = now != nullptr ? std::optional<std::string>(now) : std::nullopt;
    value != nullptr ? ::setenv(name, value, 1) : ::unsetenv(name);
  }
  ~Setting() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(CacheFolder, IsChosenByTheEnvironment) {
  const Setting home("HOME", "/home/me");
  {
    const Setting ours("LEEWAY_CACHE_DIR", nullptr), base("XDG_CACHE_HOME", nullptr);
    EXPECT_EQ(cacheFolder(), "/home/me/.cache/leeway");
  }
  const Setting base("XDG_CACHE_HOME", "/caches");
  {
    const Setting ours("LEEWAY_CACHE_DIR", nullptr);
    EXPECT_EQ(cacheFolder(), "/caches/leeway");
    const Setting relative("XDG_CACHE_HOME", "caches");
    EXPECT_EQ(cacheFolder(), "/home/me/.cache/leeway");
    const Setting homeless("HOME", nullptr);
    EXPECT_EQ(cacheFolder(), "");
  }
  const Setting ours("LEEWAY_CACHE_DIR", "/mine");
  EXPECT_EQ(cacheFolder(), "/mine");
  const Setting off("LEEWAY_CACHE_DIR", "");
  EXPECT_EQ(cacheFolder(), "");
}

}  // namespace
}  // namespace leeway::robots
