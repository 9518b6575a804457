#include "robots/cache/disk_cache.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>
#include <vector>

#include "leeway/robots/cache_folder.h"

namespace leeway::robots {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnding = ".leeway", kUnfinished = ".tmp";
constexpr std::size_t kKeyLength = 64;
// A file that was used within this time need not be marked as used again; an unfinished one that is
// older is left of a process that died.
constexpr auto kRecent = std::chrono::hours(1);

struct Header {
  std::array<char, 8> magic;
  std::uint64_t byte_order;
  std::uint64_t size;      // of what follows [B]
  std::uint64_t checksum;  // of what follows
  std::array<char, kKeyLength> key;
};
static_assert(sizeof(Header) == 32 + kKeyLength, "no padding: it goes to files");
constexpr std::array<char, 8> kMagic = {'l', 'e', 'e', 'w', 'a', 'y', '1', '\n'};
constexpr std::uint64_t kByteOrder = 0x0102030405060708;

// Against damage, not malice. Four lanes of words, each a chain of steps that are one-to-one: no
// change of a single word goes unnoticed, and any other by a chance of 2^-64. As fast as memory;
// the CRC of zlib would take as long as all else.
std::uint64_t checksumOf(std::span<const std::byte> bytes) {
  constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15;
  std::array<std::uint64_t, 4> lane = {1, 2, 3, 4};
  const auto step = [](std::uint64_t state, std::uint64_t word) {
    state = (state ^ word) * kOdd;
    return state ^ (state >> 32U);
  };
  constexpr std::size_t kBlock = 4 * sizeof(std::uint64_t);
  std::array<std::uint64_t, 4> words{};
  std::size_t at = 0;
  for (; at + kBlock <= bytes.size(); at += kBlock) {
    std::memcpy(words.data(), bytes.data() + at, kBlock);
    for (std::size_t k = 0; k < 4; ++k) lane[k] = step(lane[k], words[k]);
  }
  words = {};
  if (at < bytes.size()) std::memcpy(words.data(), bytes.data() + at, bytes.size() - at);
  std::uint64_t sum = bytes.size();
  for (std::size_t k = 0; k < 4; ++k) sum = step(sum, step(lane[k], words[k]));
  return sum;
}

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  int number() const { return number_; }
  bool close() {
    const int number = number_;
    number_ = -1;
    return number >= 0 && ::close(number) == 0;
  }

 private:
  int number_;
};

bool readAll(int descriptor, void* to, std::size_t size) {
  auto* at = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t count = ::read(descriptor, at, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

bool writeAll(int descriptor, const void* from, std::size_t size) {
  const auto* at = static_cast<const char*>(from);
  while (size > 0) {
    const ssize_t count = ::write(descriptor, at, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

Header headerOf(const std::string& key, std::span<const std::byte> bytes) {
  Header header{kMagic, kByteOrder, bytes.size(), checksumOf(bytes), {}};
  std::copy(key.begin(), key.end(), header.key.begin());
  return header;
}

bool isOurs(const std::string& name) {
  const auto isDigit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (name.size() < kKeyLength + kEnding.size() ||
      !std::all_of(name.begin(), name.begin() + kKeyLength, isDigit) ||
      !std::string_view(name).substr(kKeyLength).starts_with(kEnding))
    return false;
  std::string_view rest = std::string_view(name).substr(kKeyLength + kEnding.size());
  if (rest.empty()) return true;
  // An unfinished one: .process.attempt.tmp
  if (!rest.ends_with(kUnfinished)) return false;
  rest.remove_suffix(kUnfinished.size());
  return std::count(rest.begin(), rest.end(), '.') == 2 && rest.front() == '.' &&
         std::all_of(rest.begin(), rest.end(),
                     [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
}

/// Whether nobody but this user, or root, can have written a file: checksums tell damage, not
/// malice.
bool isTrusted(const struct stat& status) {
  return (status.st_uid == ::geteuid() || status.st_uid == 0) &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Whether this process may write a file of that size: beyond, a signal would end it.
bool maySize(std::size_t bytes) {
  struct rlimit limit {};
  return ::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ||
         bytes <= limit.rlim_cur;
}

}  // namespace

fs::path DiskCache::fileOf(const std::string& key) const {
  return folder_ / (key + std::string(kEnding));
}

std::optional<collision::LargeBuffer> DiskCache::read(const std::string& key) const {
  if (!isOn() || key.size() != kKeyLength) return std::nullopt;
  // Not blocking: what stands there may be a pipe.
  const Descriptor file(::open(fileOf(key).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (file.number() < 0 || ::fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode) ||
      !isTrusted(status) || status.st_size < static_cast<off_t>(sizeof(Header)))
    return std::nullopt;
  Header header{};
  if (!readAll(file.number(), &header, sizeof(header))) return std::nullopt;
  const std::uint64_t rest = static_cast<std::uint64_t>(status.st_size) - sizeof(Header);
  if (header.size != rest || rest > most_bytes_) return std::nullopt;
  collision::LargeBuffer kept(static_cast<std::size_t>(rest));
  if (!readAll(file.number(), kept.data(), kept.size())) return std::nullopt;
  const Header expected = headerOf(key, {kept.data(), kept.size()});
  if (std::memcmp(&header, &expected, sizeof(header)) != 0) return std::nullopt;
  const auto age =
      std::chrono::system_clock::now() - std::chrono::system_clock::from_time_t(status.st_mtime);
  if (age > kRecent) static_cast<void>(::futimens(file.number(), nullptr));
  return kept;
}

void DiskCache::write(const std::string& key, std::span<const std::byte> bytes) const {
  const std::size_t size = sizeof(Header) + bytes.size();
  if (!isOn() || key.size() != kKeyLength || size > most_bytes_ || !maySize(size)) return;
  std::error_code error;
  if (fs::create_directories(folder_, error))
    fs::permissions(folder_, fs::perms::owner_all, error);  // as the XDG specification asks
  const std::string file = fileOf(key).string();
  std::string unfinished;
  int number = -1;
  // A name may be taken by another thread that writes this file, or by one that died while it did.
  for (int attempt = 0; number < 0 && attempt < 100; ++attempt) {
    unfinished = file + '.' + std::to_string(::getpid()) + '.' + std::to_string(attempt) +
                 std::string(kUnfinished);
    number = ::open(unfinished.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
    if (number < 0 && errno != EEXIST) return;
  }
  Descriptor descriptor(number);
  const Header header = headerOf(key, bytes);
  // Not flushed to the disk: the checksum tells what a crash leaves.
  const bool written =
      writeAll(number, &header, sizeof(header)) && writeAll(number, bytes.data(), bytes.size());
  if (!descriptor.close() || !written || ::rename(unfinished.c_str(), file.c_str()) != 0) {
    ::unlink(unfinished.c_str());
    return;
  }
  removeOldest();
}

void DiskCache::removeOldest() const {
  struct File {
    fs::path path;
    fs::file_time_type used;
    std::uintmax_t bytes;
  };
  std::vector<File> files;
  std::uintmax_t total = 0;
  const auto now = fs::file_time_type::clock::now();
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::error_code gone;  // another process may have removed it
    if (!isOurs(name) || entry->is_symlink(gone) || !entry->is_regular_file(gone)) continue;
    const fs::file_time_type used = entry->last_write_time(gone);
    const std::uintmax_t bytes = gone ? 0 : entry->file_size(gone);
    if (gone) continue;
    if (name.ends_with(kUnfinished)) {
      if (now - used > kRecent) fs::remove(entry->path(), gone);
      continue;
    }
    total += bytes;
    files.push_back({entry->path(), used, bytes});
  }
  if (total <= most_bytes_) return;
  std::sort(files.begin(), files.end(), [](const File& l, const File& r) {
    return l.used != r.used ? l.used < r.used : l.path < r.path;
  });
  for (const File& file : files) {
    if (total <= most_bytes_) break;
    fs::remove(file.path, error);
    total -= file.bytes;
  }
}

std::string cacheFolder() {
  const auto valueOf = [](const char* name) -> std::string {
    const char* const value = std::getenv(name);
    return value != nullptr ? value : "";
  };
  if (std::getenv("LEEWAY_CACHE_DIR") != nullptr) return valueOf("LEEWAY_CACHE_DIR");
  // By its specification a relative path in this variable is to be ignored.
  if (const fs::path base = valueOf("XDG_CACHE_HOME"); base.is_absolute())
    return (base / "leeway").string();
  if (const fs::path home = valueOf("HOME"); home.is_absolute())
    return (home / ".cache" / "leeway").string();
  return {};
}

}  // namespace leeway::robots
