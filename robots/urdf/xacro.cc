#include "robots/urdf/xacro.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <string_view>

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

/// The lines of a text that are not empty, without the white space around them, as one line.
std::string joinLines(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r";
  std::string joined;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line.remove_prefix(std::min(line.find_first_not_of(kSpace), line.size()));
    line = line.substr(0, line.find_last_not_of(kSpace) + 1);
    if (!line.empty()) joined.append(joined.empty() ? "" : " | ").append(line);
  }
  return joined;
}

/// Whether xacro reads NAME:=VALUE as an argument, and not as an option or a file.
bool isArgumentName(const std::string& name) {
  const auto fits = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  return !name.empty() && std::isdigit(static_cast<unsigned char>(name[0])) == 0 &&
         std::all_of(name.begin(), name.end(), fits);
}

}  // namespace

bool isXacro(const std::string& path) { return path.ends_with(".xacro"); }

std::optional<std::string> expandXacro(
    const std::string& path, const std::vector<std::pair<std::string, std::string>>& arguments,
    const Stop& stop) {
  const auto fail = [&](const std::string& what) {
    throw InputError(
        path, 0,
        "xacro cannot expand it: " + what + "; a file that `xacro` expands would be accepted");
  };
  for (const auto& [name, value] : arguments)
    if (!isArgumentName(name))
      throw InputError(path, 0,
                       "xacro argument \"" + name +
                           "\" is no name; letters, digits and underscores would be "
                           "accepted, a letter or an underscore first");
  Pipe output, messages;
  if (!output.isOpen() || !messages.isOpen()) fail("there are no pipes left");
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, output.writer(), 1);
  ::posix_spawn_file_actions_adddup2(&actions, messages.writer(), 2);
  // A path that begins with a dash would be an option.
  std::vector<std::string> words = {"xacro", path.starts_with("-") ? "./" + path : path};
  for (const auto& [name, value] : arguments) words.push_back(name + ":=" + value);
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  pid_t child = -1;
  const int error = ::posix_spawnp(&child, "xacro", &actions, nullptr, pointers.data(), environ);
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
    fail(joinLines(texts[1]).empty() ? "it fails without a word" : joinLines(texts[1]));
  return std::move(texts[0]);
}

}  // namespace leeway::robots
