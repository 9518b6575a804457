#include "robots/base/read_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "leeway/robots/input_error.h"
#include "robots/base/files_read.h"

namespace leeway::robots {
namespace {

constexpr int kPatience = 10000;  // limit on the wait for a silent pipe [ms]

class File {
 public:
  // Opening a pipe without a writer must not block.
  explicit File(const std::string& path)
      : handle_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {}
  ~File() {
    if (handle_ >= 0) ::close(handle_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int handle() const { return handle_; }

 private:
  int handle_;
};

std::size_t sizeInMegabytes(std::size_t bytes) { return bytes >> 20; }

}  // namespace

thread_local FilesRead* FilesRead::of_thread = nullptr;

FilesRead::FilesRead() { of_thread = this; }

FilesRead::~FilesRead() { of_thread = nullptr; }

void FilesRead::note(const std::string& path) {
  if (of_thread != nullptr) of_thread->files_.emplace(path, FileStamp::of(path));
}

void FilesRead::note(const Found& found) {
  note(found.file);
  if (of_thread != nullptr) of_thread->found_.insert(found);
}

FileStamp FileStamp::of(const std::string& path) {
  std::error_code error;
  const auto changed = std::filesystem::last_write_time(path, error);
  return {changed, std::filesystem::file_size(path, error)};
}

std::string readBinaryFile(const std::string& path, std::string_view kind, std::size_t limit) {
  FilesRead::note(path);
  const auto fail = [&](const std::string& what) {
    throw InputError(path, 0, what + "; " + std::string(kind) + " is expected");
  };
  const auto failAs = [&](int error) {
    fail(error == ENOENT || error == ENOTDIR ? "there is no such file"
                                             : "cannot be read: " + std::string(strerror(error)));
  };
  const auto failAsTooLong = [&] {
    fail("holds more than " + std::to_string(sizeInMegabytes(limit)) +
         " MiB, the most that is read");
  };
  const File file(path);
  struct stat status {};
  if (file.handle() < 0 || ::fstat(file.handle(), &status) != 0) failAs(errno);
  const bool is_pipe = S_ISFIFO(status.st_mode);
  if (S_ISDIR(status.st_mode)) fail("is a folder");
  if (!is_pipe && !S_ISREG(status.st_mode)) fail("is a device");
  if (!is_pipe && static_cast<std::size_t>(status.st_size) > limit) failAsTooLong();

  std::string text;
  text.reserve(is_pipe ? 0 : static_cast<std::size_t>(status.st_size) + 1);
  char block[1 << 16];
  while (true) {
    if (is_pipe) {
      pollfd waited{file.handle(), POLLIN, 0};
      const int ready = ::poll(&waited, 1, kPatience);
      if (ready == 0) fail("is a pipe to which nothing was written for 10 s");
      if (ready < 0 && errno != EINTR) failAs(errno);
      if (ready < 0) continue;
    }
    const ssize_t count = ::read(file.handle(), block, sizeof block);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) failAs(errno);
    if (count == 0) break;
    text.append(block, static_cast<std::size_t>(count));
    if (text.size() > limit) failAsTooLong();
  }
  return text;
}

std::string endingOf(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  return ending;
}

std::string_view takeLine(std::string_view& rest) {
  const auto end =
      std::find_if(rest.begin(), rest.end(), [](char c) { return c == '\n' || c == '\r'; });
  const std::string_view line = rest.substr(0, static_cast<std::size_t>(end - rest.begin()));
  rest.remove_prefix(line.size());
  rest.remove_prefix(rest.starts_with("\r\n") ? 2 : rest.empty() ? 0 : 1);
  return line;
}

bool lastLineEnds(std::string_view text) {
  const std::size_t last = text.find_last_not_of(" \t");
  return last == std::string_view::npos || text[last] == '\n' || text[last] == '\r';
}

std::string readTextFile(const std::string& path, std::string_view kind, std::size_t limit) {
  std::string text = readBinaryFile(path, kind, limit);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (const std::size_t zero = text.find('\0'); zero != std::string::npos)
    throw InputError(
        path, 0,
        "is binary, or UTF-16: line " +
            std::to_string(1 +
                           std::count(text.begin(), text.begin() + static_cast<long>(zero), '\n')) +
            " holds a byte of value 0; " + std::string(kind) + " is expected");
  // Some programs take a lone carriage return for the end of a line, others for a blank.
  std::size_t size = std::min(text.find('\r'), text.size());
  for (std::size_t i = size; i < text.size(); ++i)
    if (text[i] != '\r')
      text[size++] = text[i];
    else if (i + 1 == text.size() || text[i + 1] != '\n')
      text[size++] = '\n';
  text.resize(size);
  return text;
}

}  // namespace leeway::robots
