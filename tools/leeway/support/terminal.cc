#include "tools/leeway/support/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <limits>

#include "planner/base/tolerances.h"

namespace leeway::tools {
namespace {

volatile std::sig_atomic_t is_interrupted = 0;
timespec first_interrupt{};
bool progress_shown = false;
bool quiet = false;

constexpr double kQuietReading = 1;       // what is read sooner is not shown [s]
constexpr double kRedraw = 0.1;           // from one progress line to the next, where many come [s]
constexpr std::size_t kManyUnits = 1000;  // of more, not each one redraws the line

/// The first interrupt ends planning with the best path so far; one more ends the program. What
/// follows within a quarter of a second is the same interrupt: timeout(1) signals its child and
/// then the child's group, a shell may do as much.
void onInterrupt(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);  // may be called in a handler, unlike std::chrono's clocks
  if (is_interrupted == 0) {
    first_interrupt = now;
    is_interrupted = 1;
    return;
  }
  const double since = static_cast<double>(now.tv_sec - first_interrupt.tv_sec) +
                       1e-9 * static_cast<double>(now.tv_nsec - first_interrupt.tv_nsec);
  if (since < 0.25) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Both signals wait while one is handled.
void handleInterrupts() {
  struct sigaction action {};
  action.sa_handler = onInterrupt;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaddset(&action.sa_mask, SIGINT);
  sigaddset(&action.sa_mask, SIGTERM);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool showsProgress() {
  static const bool is_terminal = isatty(STDERR_FILENO) == 1;
  return is_terminal && !quiet;
}

std::string formatRounded(double value, int digits, double (*round)(double)) {
  if (!std::isfinite(value)) {
    return "-";
  }
  const double scale = std::pow(10.0, digits);
  // + 0.0 turns -0 into 0.
  return fmt::format("{:.{}f}", round(value * scale) / scale + 0.0, digits);
}

std::string formatDuration(double seconds) {
  if (seconds < 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 100 * 60) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

planner::PlanOptions interactivePlanOptions(std::optional<double> time_limit,
                                            double planning_limit) {
  using Clock = std::chrono::steady_clock;
  handleInterrupts();
  planner::PlanOptions options;
  options.stop = [] { return interrupted(); };
  if (time_limit) {
    options.stop = [start = Clock::now(), limit = std::chrono::duration<double>(*time_limit)] {
      return interrupted() || Clock::now() - start > limit;
    };
  }
  if (showsProgress()) {
    const bool is_limited = planning_limit > 0 && std::isfinite(planning_limit);
    const std::string most = is_limited ? fmt::format(" of at most {:g}", planning_limit) : "";
    options.progress = [most](const std::string& phase, double elapsed) {
      showProgress(fmt::format("{:.1f}{} s: {}", elapsed, most, phase));
    };
  }
  return options;
}

bool interrupted() { return is_interrupted != 0; }

struct InterruptibleReading::Before {
  struct sigaction interrupt, terminate;
};

InterruptibleReading::InterruptibleReading(std::optional<double> time_limit)
    : before_(std::make_unique<Before>()) {
  using Clock = std::chrono::steady_clock;
  sigaction(SIGINT, nullptr, &before_->interrupt);
  sigaction(SIGTERM, nullptr, &before_->terminate);
  handleInterrupts();
  const double limit = time_limit ? std::max(*time_limit, planner::kLeastReading)
                                  : std::numeric_limits<double>::infinity();
  stop_ = [start = Clock::now(), limit, shown = kQuietReading]() mutable {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
    if (elapsed >= shown) {
      showProgress(fmt::format("{:.1f} s: reading", elapsed));
      shown = elapsed + kRedraw;
    }
    return interrupted() || elapsed > limit;
  };
}

InterruptibleReading::~InterruptibleReading() {
  endProgress();
  sigaction(SIGINT, &before_->interrupt, nullptr);
  sigaction(SIGTERM, &before_->terminate, nullptr);
}

void setQuiet() { quiet = true; }
bool isQuiet() { return quiet; }

void showProgress(const std::string& text) {
  if (!showsProgress()) return;
  // A line that wraps around could not be rewritten.
  winsize window{};
  std::size_t width = 79;
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 1)
    width = window.ws_col - 1;
  fmt::print(stderr, "\r\x1b[K{:.{}}", text, width);
  std::fflush(stderr);
  progress_shown = true;
}

void endProgress() {
  if (progress_shown) {
    fmt::print(stderr, "\r\x1b[K");
    progress_shown = false;
  }
}

void UnitProgress::next(const std::string& unit) {
  if (!showsProgress()) return;
  const double elapsed =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  if (total_ > kManyUnits && begun_ > 0 && elapsed < shown_ + kRedraw) {
    ++begun_;
    return;
  }
  shown_ = elapsed;
  std::string left;
  if (begun_ > 0) {
    const std::size_t rest = total_ - std::min(total_, kept_ + begun_);
    left = ", about " +
           formatDuration(elapsed / static_cast<double>(begun_) * static_cast<double>(rest)) +
           " left";
  }
  ++begun_;
  const std::size_t now = kept_ + begun_;
  showProgress(fmt::format("{} of {}{}: {}", now, std::max(now, total_), left, unit));
}

std::string formatTable(const std::vector<std::string>& heading,
                        const std::vector<std::vector<std::string>>& rows,
                        const std::vector<std::size_t>& left) {
  const auto is_left = [&](std::size_t c) {
    return c == 0 || std::find(left.begin(), left.end(), c) != left.end();
  };
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < heading.size(); ++c) {
    std::size_t width = heading[c].size();
    for (const auto& row : rows) {
      width = std::max(width, row[c].size());
    }
    widths.push_back(width);
  }
  std::string text;
  const auto append = [&](const std::vector<std::string>& row) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      line += c == 0 ? "" : "  ";
      line += is_left(c) ? fmt::format("{:<{}}", row[c], widths[c])
                         : fmt::format("{:>{}}", row[c], widths[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  };
  append(heading);
  std::size_t total = 0;
  for (std::size_t c = 0; c < widths.size(); ++c) {
    total += widths[c] + (c == 0 ? 0 : 2);
  }
  text += std::string(total, '-') + "\n";
  for (const auto& row : rows) {
    append(row);
  }
  return text;
}

std::string formatLower(double value, int digits) {
  return formatRounded(value, digits, std::floor);
}
std::string formatUpper(double value, int digits) {
  return formatRounded(value, digits, std::ceil);
}

std::string formatBytes(std::size_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (bytes < 1024) {
    return fmt::format("{} B", bytes);
  }
  return bytes < 1024 * 1024 ? fmt::format("{:.1f} KiB", value / 1024)
                             : fmt::format("{:.1f} MiB", value / (1024 * 1024));
}

}  // namespace leeway::tools
