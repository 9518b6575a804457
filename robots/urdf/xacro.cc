#include "robots/urdf/xacro.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>

#include "leeway/robots/input_error.h"
#include "robots/base/read_file.h"

extern char** environ;

namespace leeway::robots {
namespace {

constexpr int kPatience = 60000;  // with a program that is silent [ms]
constexpr int kAsk = 50;          // between two questions whether to stop [ms]

/// The end of a pipe that this process reads.
class Pipe {
 public:
  Pipe() { is_open_ = ::pipe2(ends_.data(), O_CLOEXEC) == 0; }
  ~Pipe() {
    if (!is_open_) return;
    ::close(ends_[0]);
    closeWriter();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  bool isOpen() const { return is_open_; }
  int reader() const { return ends_[0]; }
  int writer() const { return ends_[1]; }
  void closeWriter() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  std::array<int, 2> ends_ = {-1, -1};
  bool is_open_ = false;
};

std::string lastLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  const std::size_t end = text.rfind('\n');
  return end == std::string::npos ? text : text.substr(end + 1);
}

}  // namespace

std::optional<std::string> expandXacro(const std::string& path, const Stop& stop) {
  const auto fail = [&](const std::string& what) {
    throw InputError(
        path, 0,
        "xacro cannot expand it: " + what + "; a file that `xacro` expands would be accepted");
  };
  Pipe output, messages;
  if (!output.isOpen() || !messages.isOpen()) fail("there are no pipes left");
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, output.writer(), 1);
  ::posix_spawn_file_actions_adddup2(&actions, messages.writer(), 2);
  std::string program = "xacro", file = path;
  // A path that begins with a dash is none of its options.
  if (file.starts_with("-")) file = "./" + file;
  char* arguments[] = {program.data(), file.data(), nullptr};
  pid_t child = -1;
  const int error = ::posix_spawnp(&child, "xacro", &actions, nullptr, arguments, environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) return std::nullopt;
  if (error != 0) fail("it does not start");
  output.closeWriter();
  messages.closeWriter();

  std::string texts[2];
  std::string why;
  bool stopped = false;
  int silent = 0;  // [ms]
  pollfd waited[] = {{output.reader(), POLLIN, 0}, {messages.reader(), POLLIN, 0}};
  while (why.empty() && !stopped && (waited[0].fd >= 0 || waited[1].fd >= 0)) {
    stopped = stop && stop();
    const int ready = ::poll(waited, 2, kAsk);
    if (ready < 0 && errno == EINTR) continue;
    silent = ready == 0 ? silent + kAsk : 0;
    if (ready < 0 || silent >= kPatience) why = "it is silent for a minute";
    for (std::size_t i = 0; i < 2 && ready > 0; ++i) {
      if (waited[i].fd < 0 || waited[i].revents == 0) continue;
      char block[1 << 16];
      const ssize_t count = ::read(waited[i].fd, block, sizeof block);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0)
        waited[i].fd = -1;
      else
        texts[i].append(block, static_cast<std::size_t>(count));
      if (texts[i].size() > kLongestText) why = "it writes without end";
    }
  }
  if (!why.empty() || stopped) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (stopped) throw Stopped("stopped while xacro expanded " + path);
  if (!why.empty()) fail(why);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    fail(texts[1].empty() ? "it fails without a word" : lastLine(texts[1]));
  return std::move(texts[0]);
}

}  // namespace leeway::robots
