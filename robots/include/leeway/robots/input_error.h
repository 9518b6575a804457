#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace leeway::robots {

/// Bad input: `FILE:LINE: what is wrong, with the offending value; what would be accepted`. Nothing
/// is half-loaded. The command exits with status 2.
class InputError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0: none. Without a file the message stands alone.
  InputError(std::string file, int line, const std::string& message);
  const std::string& file() const { return file_; }
  int line() const { return line_; }

 private:
  std::string file_;
  int line_;
};

/// What is wrong with one file and all that it names, where reading goes on after an error. For one
/// reading in one thread.
class InputErrors {
 public:
  /// More tell little: reading ends with the first that has no room.
  static constexpr std::size_t kMost = 100;

  /// Each message once, in the order of reading.
  const std::vector<InputError>& list() const { return list_; }
  /// False, and nothing done, where there is no room.
  bool keep(const InputError& error);
  /// Lists an error that does not make the reading fail: of an entry that is left out. Returns
  /// false, and does nothing, where there is no room.
  bool note(const InputError& error);
  /// How often an error was kept, and the n-th of them.
  std::size_t count() const { return kept_.size(); }
  const InputError& kept(std::size_t n) const { return list_[kept_[n]]; }

 private:
  /// The place of `error` in the list; kMost where there is no room.
  std::size_t placeOf(const InputError& error);

  std::vector<InputError> list_;
  std::vector<std::size_t> kept_;  // places in the list
};

}  // namespace leeway::robots
