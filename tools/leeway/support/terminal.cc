#include "tools/leeway/support/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <set>
#include <span>
#include <sstream>
#include <string_view>

#include "planner/base/tolerances.h"

namespace leeway::tools {
namespace {

volatile std::sig_atomic_t is_interrupted = 0;
timespec first_interrupt{};
bool progress_shown = false;
bool quiet = false;

constexpr double kQuietReading = 1;       // faster reading is not shown [s]
constexpr double kRedraw = 0.1;           // least time between two progress lines [s]
constexpr std::size_t kManyUnits = 1000;  // above this, not every unit redraws the line

/// The first interrupt ends planning with the best path so far. Another one ends the program.
/// Signals within a quarter of a second are the same interrupt, because timeout(1), and perhaps a
/// shell, signals its child and then the child's group.
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

/// Blocks both signals while one is handled.
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

/// The number of columns of a UTF-8 text, one per character.
std::size_t lengthOf(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) >> 6) != 2; }));
}

/// Returns a text with its control characters as \xNN, because names in files may contain those
/// that terminals obey. `kept`: sequences that stay.
std::string escaped(const std::string& text, std::span<const std::string_view> kept) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = std::string_view(text).substr(i);
    const auto found = std::find_if(kept.begin(), kept.end(), [&](std::string_view sequence) {
      return rest.starts_with(sequence);
    });
    const auto byte = static_cast<unsigned char>(text[i]);
    // C1 controls are two bytes in UTF-8.
    const bool is_c1 = byte == 0xC2 && rest.size() > 1 &&
                       static_cast<unsigned char>(rest[1]) >= 0x80 &&
                       static_cast<unsigned char>(rest[1]) < 0xA0;
    if (found != kept.end()) {
      result += *found;
      i += found->size() - 1;
    } else if (is_c1) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(rest[1]));
      ++i;
    } else if (byte < 0x20 || byte == 0x7F) {
      result += fmt::format("\\x{:02x}", byte);
    } else {
      result += text[i];
    }
  }
  return result;
}

constexpr std::string_view kGood = "\x1b[1;32m", kBad = "\x1b[1;31m", kPlain = "\x1b[0m";
/// printable() keeps newlines and the colours of verdictText().
constexpr std::string_view kOfTexts[] = {"\n", kGood, kBad, kPlain};

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
  // A line that wraps around cannot be rewritten.
  winsize window{};
  std::size_t width = 79;
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 1)
    width = window.ws_col - 1;
  fmt::print(stderr, "\r\x1b[K{:.{}}", escaped(text, {}), width);
  std::fflush(stderr);
  progress_shown = true;
}

void endProgress() {
  if (progress_shown) {
    fmt::print(stderr, "\r\x1b[K");
    progress_shown = false;
  }
}

void printMessage(const std::string& text) {
  endProgress();
  static const bool is_terminal = isatty(STDERR_FILENO) == 1;
  fmt::print(stderr, "{}\n", is_terminal ? wrapped(text) : printable(text));
}

double UnitProgress::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void UnitProgress::after(const std::string& work) {
  const double now = elapsed();
  if (now < shown_ + kRedraw) return;
  shown_ = now;
  showProgress(fmt::format("{:.1f} s: {}", now, work));
}

void UnitProgress::next(const std::string& unit) {
  if (!showsProgress()) return;
  const double elapsed = this->elapsed();
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

namespace {

/// The length of a space and a unit that follow a number which ends at `end`; 0: none do.
std::size_t unitBehind(const std::string& text, std::size_t end) {
  if (end == 0 || end >= text.size() || text[end] != ' ') return 0;
  if (std::isdigit(static_cast<unsigned char>(text[end - 1])) == 0) return 0;
  const std::size_t unit = std::min(text.find_first_of(" \n.,;:)", end + 1), text.size());
  const std::string_view word = std::string_view(text).substr(end + 1, unit - end - 1);
  for (const std::string_view known : {"mm", "m", "s", "ms", "rad", "mrad", "%"})
    if (word == known) return unit - end;
  return 0;
}

/// Breaks lines at spaces, but not between a number and its unit, with `mark` at the end of each
/// broken line. `column`: where the text begins.
std::string broken(const std::string& text, std::size_t indent, const std::string& mark,
                   std::size_t column = 0) {
  std::string result;
  const auto roomAt = [&](std::size_t end) {
    // The last word of a line needs no room for the mark.
    return end == text.size() || text[end] == '\n' ? kColumns : kColumns - mark.size();
  };
  bool line_begins = true;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '\n') {
      result += '\n';
      column = 0;
      line_begins = true;
      ++i;
      continue;
    }
    std::size_t end = std::min(text.find_first_of(" \n", i + 1), text.size());
    if (unitBehind(text, end) > 0) end += unitBehind(text, end);
    const std::string word = text.substr(i, end - i);  // with the space before it
    const std::size_t length = lengthOf(word);
    if (!line_begins && column + length > roomAt(end)) {
      const std::size_t bare = word[0] == ' ' ? 1 : 0;
      result += mark + "\n" + std::string(indent, ' ') + word.substr(bare);
      column = indent + length - bare;
    } else {
      result += word;
      column += length;
    }
    line_begins = line_begins && word == " ";
    i = end;
  }
  return result;
}

}  // namespace

std::string printable(const std::string& text) { return escaped(text, kOfTexts); }

std::string wrapped(const std::string& text, std::size_t indent) {
  return broken(printable(text), indent, "");
}

namespace {

/// The column of a line's text: behind its key, or behind its blanks if it has no key.
std::size_t textColumn(const std::string& line) {
  // An option that nearly fills its column has one blank behind it.
  constexpr std::size_t kOfOptions = 30;
  const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
  if (first > 0 && line.size() > kOfOptions && line[first] == '-' && line[kOfOptions - 1] == ' ' &&
      line[kOfOptions] != ' ')
    return kOfOptions;
  const std::size_t gap = line.find("  ", first);
  return first == 0 || gap == std::string::npos ? first : line.find_first_not_of(' ', gap);
}

}  // namespace

std::string wrappedHelp(const std::string& help) {
  constexpr std::size_t kLeastColumn = 20;  // lines from here continue the text above them
  std::vector<std::string> lines;
  std::istringstream in(help);
  std::size_t above = 0;  // the column of the line before
  for (std::string line; std::getline(in, line);) {
    const std::size_t column = textColumn(line);
    const bool goes_on = column == above && column >= kLeastColumn &&
                         line.find_first_not_of(' ') == column && column < line.size();
    if (goes_on)
      lines.back() += " " + line.substr(column);
    else
      lines.push_back(line);
    above = column;
  }
  std::string result;
  for (const std::string& line : lines) {
    if (&line != lines.data()) result += '\n';
    const std::size_t column = textColumn(line);
    result += line.starts_with("  leeway ")
                  ? broken(line, 6, " \\")
                  : line.substr(0, column) + broken(line.substr(column), column, "", column);
  }
  return help.ends_with('\n') ? result + '\n' : result;
}

std::string verdictText(const std::string& words, bool good) {
  const char* no_colour = std::getenv("NO_COLOR");
  const bool colours = isatty(STDOUT_FILENO) == 1 && (no_colour == nullptr || no_colour[0] == '\0');
  return colours ? fmt::format("{}{}{}", good ? kGood : kBad, words, kPlain) : words;
}

namespace {

/// Columns of a table that fit side by side, and their widths.
class Table {
 public:
  Table(const std::vector<std::string>& heading, const std::vector<std::vector<std::string>>& rows,
        const std::vector<std::size_t>& left)
      : heading_(heading), rows_(rows), left_(left) {
    for (auto& row : rows_)
      for (std::string& cell : row) cell = escaped(cell, {});
    for (std::size_t c = 0; c < heading.size(); ++c) {
      std::size_t width = lengthOf(heading[c]);
      for (const auto& row : rows) width = std::max(width, lengthOf(row[c]));
      widths_.push_back(width);
    }
  }

  /// Whether the columns have room side by side.
  bool fits() {
    wrapLast();
    std::size_t width = 0;
    for (const std::size_t column : widths_) width += column + 2;
    return width <= kColumns + 2;
  }

  std::string text() {
    wrapLast();
    std::string text;
    for (std::size_t first = 1; first == 1 || first < widths_.size();) {
      std::vector<std::size_t> columns = {0};
      std::size_t width = widths_[0];
      while (first < widths_.size() &&
             (columns.size() == 1 || width + 2 + widths_[first] <= kColumns)) {
        width += 2 + widths_[first];
        columns.push_back(first++);
      }
      if (!text.empty()) text += '\n';
      text += line(heading_, columns) + std::string(width, '-') + "\n";
      for (const auto& row : rows_) text += line(row, columns);
      if (first == 1) break;  // there is one column
    }
    return text;
  }

 private:
  static constexpr std::size_t kLeastWords = 16;

  bool isLeft(std::size_t c) const {
    return c == 0 || std::find(left_.begin(), left_.end(), c) != left_.end();
  }

  /// Wraps words in the last column if that makes the table fit.
  void wrapLast() {
    const std::size_t last = widths_.size() - 1;
    std::size_t before = 0;
    for (std::size_t c = 0; c < last; ++c) before += widths_[c] + 2;
    if (last == 0 || !isLeft(last) || before + widths_[last] <= kColumns ||
        before + std::max(kLeastWords, lengthOf(heading_[last])) > kColumns)
      return;
    widths_[last] = kColumns - before;
    indent_ = before;
  }

  std::string line(const std::vector<std::string>& row,
                   const std::vector<std::size_t>& columns) const {
    std::string line;
    for (const std::size_t c : columns) {
      line += c == 0 ? "" : "  ";
      if (c + 1 == row.size() && indent_ > 0) {
        line += inParts(row[c]);
        continue;
      }
      const std::string room(widths_[c] - std::min(widths_[c], lengthOf(row[c])), ' ');
      line += isLeft(c) ? row[c] + room : room + row[c];
    }
    line.erase(line.find_last_not_of(' ') + 1);
    return line + "\n";
  }

  std::string inParts(const std::string& words) const {
    std::string result;
    std::size_t column = 0;
    for (std::size_t i = 0; i < words.size();) {
      const std::size_t end = std::min(words.find(' ', i), words.size());
      const std::string word = words.substr(i, end - i);
      if (column > 0 && column + 1 + lengthOf(word) > widths_.back()) {
        result += "\n" + std::string(indent_, ' ');
        column = 0;
      }
      result += (column > 0 ? " " : "") + word;
      column += (column > 0 ? 1 : 0) + lengthOf(word);
      i = end + 1;
    }
    return result;
  }

  const std::vector<std::string>& heading_;
  std::vector<std::vector<std::string>> rows_;
  const std::vector<std::size_t>& left_;
  std::vector<std::size_t> widths_;
  std::size_t indent_ = 0;  ///< of further lines of the last column; 0 if it does not wrap
};

}  // namespace

std::string formatTable(const std::vector<std::string>& heading,
                        const std::vector<std::vector<std::string>>& rows,
                        const std::vector<std::size_t>& left) {
  Table table(heading, rows, left);
  std::set<std::string> keys;
  for (const auto& row : rows) keys.insert(row.front());
  if (keys.size() == rows.size() || table.fits()) return table.text();
  // Numbers tell rows apart in the parts of the table.
  std::vector<std::string> numbered_heading = {"row"};
  numbered_heading.insert(numbered_heading.end(), heading.begin(), heading.end());
  std::vector<std::vector<std::string>> numbered_rows;
  for (const auto& row : rows) {
    numbered_rows.push_back({fmt::format("{}", numbered_rows.size() + 1)});
    numbered_rows.back().insert(numbered_rows.back().end(), row.begin(), row.end());
  }
  std::vector<std::size_t> numbered_left = {1};
  for (const std::size_t column : left) numbered_left.push_back(column + 1);
  return Table(numbered_heading, numbered_rows, numbered_left).text();
}

}  // namespace leeway::tools
