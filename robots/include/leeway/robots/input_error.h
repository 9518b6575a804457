#pragma once

#include <stdexcept>
#include <string>

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

}  // namespace leeway::robots
