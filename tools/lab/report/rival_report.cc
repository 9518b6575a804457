#include "tools/lab/report/rival_report.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "tools/lab/base/machine.h"
#include "tools/leeway/support/exit_status.h"

namespace leeway::tools {
namespace {

std::string within(const std::string& folder, const std::string& name) {
  return std::filesystem::path(folder) / name;
}

/// `folder`, or what of its path is there already, takes new files and folders.
void requireWritable(const std::string& folder) {
  std::filesystem::path there = folder.empty() ? "." : std::filesystem::absolute(folder);
  // Also a link that leads nowhere is there: nothing can be made in its place.
  const auto isThere = [](const std::filesystem::path& path) {
    std::error_code error;
    return std::filesystem::exists(std::filesystem::symlink_status(path, error));
  };
  while (!isThere(there) && there.has_relative_path()) there = there.parent_path();
  std::error_code error;
  const int reason = !std::filesystem::is_directory(there, error) ? ENOTDIR
                     : ::access(there.c_str(), W_OK | X_OK) != 0  ? errno
                                                                  : 0;
  if (reason != 0)
    throw robots::InputError(folder, 0,
                             fmt::format("cannot be written: {}: {}; a folder for CSV and pictures "
                                         "is expected",
                                         there.string(), std::strerror(reason)));
}

// What an interrupt prints: made before, since little may be called in a signal's handler.
char partial_note[4096] = "";
volatile std::sig_atomic_t partial_note_size = 0;
pid_t reporter = 0;

/// An interrupt ends a report at once: its rows so far are written. Of the children that measure
/// it says nothing.
void onInterrupt(int signal) {
  if (getpid() == reporter &&
      ::write(STDERR_FILENO, partial_note, static_cast<std::size_t>(partial_note_size)) < 0)
    _exit(1);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void setNote(const std::string& text) {
  partial_note_size = 0;
  const std::size_t size = std::min(text.size(), sizeof partial_note);
  std::copy_n(text.data(), size, partial_note);
  partial_note_size = static_cast<int>(size);
}

void tellOfPartial(const std::string& file) {
  setNote(fmt::format("\ninterrupted: {} holds the rows so far\n", file));
}

/// Runs a program; returns its exit status, or -1 if it cannot be started or dies.
int statusOf(const char* program, std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  int status = 0;
  if (::posix_spawnp(&child, program, nullptr, nullptr, arguments.data(), environ) != 0) return -1;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

RivalReport::RivalReport(const report::ReportOptions& options) : options_(options) {
  requireWritable(options_.output);
  reporter = getpid();
  setNote("\ninterrupted before there were rows\n");
  std::signal(SIGINT, onInterrupt);
  std::signal(SIGTERM, onInterrupt);
}

void RivalReport::loadRivals() {
  if (is_loaded_ || options_.no_rivals) return;
  is_loaded_ = true;
  modules_ = report::loadRivals();
  for (const report::RivalModule& module : modules_) {
    if (module.problem.empty()) continue;
    fmt::print(stderr, "without {}: {}\n", module.library, module.problem);
    missing_.push_back(module.library);
  }
}

std::function<void(const std::string&)> RivalReport::begin(std::size_t units) {
  processor_ = report::pinToOneProcessor();
  progress_.emplace(units);
  return [this](const std::string& unit) { progress_->next(unit); };
}

void RivalReport::note(const std::string& text) {
  note_ = fmt::format("{}; {}", report::machineName(), text);
}

void RivalReport::addRows(const std::string& name, const report::Table& table) {
  const std::string csv = table.csv();
  const std::string file = within(options_.output, name + ".csv.partial");
  const bool is_new = partial_.insert(name).second;
  std::error_code error;  // what is wrong shows when the file is written
  std::filesystem::create_directories(options_.output, error);
  const std::string rows = is_new ? csv : csv.substr(csv.find('\n') + 1);
  std::FILE* out = std::fopen(file.c_str(), is_new ? "wb" : "ab");
  const bool is_open = out != nullptr;
  const bool is_written = is_open && std::fwrite(rows.data(), 1, rows.size(), out) == rows.size();
  if ((is_open && std::fclose(out) != 0) || !is_written)
    throw robots::InputError(file, 0, fmt::format("cannot be written: {}", std::strerror(errno)));
  tellOfPartial(file);
}

void RivalReport::write(const std::string& name, const report::Table& table) {
  std::error_code error;  // what is wrong shows when the file is written
  std::filesystem::create_directories(options_.output, error);
  const std::string csv = within(options_.output, name + ".csv");
  planner::writeFileWhole(csv, table.csv());
  const nlohmann::ordered_json document = {
      {"note", note_}, {"seed", options_.seed}, {"rows", table.json()}};
  planner::writeFileWhole(
      within(options_.output, name + ".json"),
      document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  names_.insert(names_.end(), {name + ".csv", name + ".json"});
  if (partial_.count(name) != 0) {
    std::filesystem::remove(csv + ".partial", error);
    setNote(fmt::format("\ninterrupted: {} is whole\n", csv));
  }
}

void RivalReport::draw(const std::vector<std::string>& pictures) {
  constexpr int kNoMatplotlib = 3;  // of draw_report
  std::vector<std::string> words = {"python3", report::moduleFolder() / "draw_report",
                                    options_.output};
  words.insert(words.end(), pictures.begin(), pictures.end());
  // The first one of PATH may belong to an environment; Debian's matplotlib belongs to Debian's.
  int status = kNoMatplotlib;
  for (const char* python : {"python3", "/usr/bin/python3"})
    if (status == kNoMatplotlib || status < 0) status = statusOf(python, words);
  if (status == 0) {
    names_.insert(names_.end(), pictures.begin(), pictures.end());
    return;
  }
  fmt::print(stderr, "without {}: {}\n", fmt::join(pictures, ", "),
             status == kNoMatplotlib || status < 0
                 ? "python3 and matplotlib draw them (python3-matplotlib)"
                 : "draw_report failed");
  missing_.emplace_back(status == kNoMatplotlib || status < 0 ? "matplotlib" : "draw_report");
}

int RivalReport::end(const End& end) const {
  endProgress();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  if (options_.json) {
    std::vector<std::string> files;
    for (const std::string& name : names_) files.push_back(within(options_.output, name));
    fmt::print("{}\n", nlohmann::json{{"seed", options_.seed},
                                      {end.counted, end.count},
                                      {"missing", missing_},
                                      {"own_errors", end.own_errors},
                                      {"processor", processor_},
                                      {"time_s", seconds},
                                      {"files", files}}
                           .dump());
  } else {
    fmt::print("{}\n", note_);
    for (const report::Table& table : end.tables)
      if (!table.rows().empty())
        fmt::print("\n{}", formatTable(table.heading(), table.rows(), table.textColumns()));
    fmt::print("\n{}seed {}, {} {}, {:.0f} s; in {}: {}\n", end.words, options_.seed, end.count,
               end.counted, seconds, options_.output, fmt::join(names_, ", "));
  }
  return end.own_errors == 0 ? kYes : kNo;
}

}  // namespace leeway::tools
