#pragma once

#include <stdexcept>
#include <string>

namespace leeway::robots {

/// Bad input, told once and whole: `FILE:LINE: what is wrong, with the offending value; what would
/// be accepted`. Thrown by loaders only; nothing is half-loaded. The command turns it into exit
/// status 2.
class InputError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0 when no line can be named.
  InputError(std::string file, int line, const std::string& message);
  const std::string& file() const { return file_; }
  int line() const { return line_; }

 private:
  std::string file_;
  int line_;
};

}  // namespace leeway::robots
