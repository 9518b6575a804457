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
  /// Further errors tell little: reading ends with the next one.
  static constexpr std::size_t kMost = 100;

  /// Each message once, in the order of reading.
  const std::vector<InputError>& list() const { return list_; }
  void add(const InputError& error);

 private:
  std::vector<InputError> list_;
};

}  // namespace leeway::robots
