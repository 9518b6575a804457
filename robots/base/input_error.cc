#include "leeway/robots/input_error.h"

#include <utility>

namespace leeway::robots {

namespace {

std::string compose(const std::string& file, int line, const std::string& message) {
  if (file.empty()) return message;
  if (line <= 0) return file + ": " + message;
  return file + ":" + std::to_string(line) + ": " + message;
}

}  // namespace

InputError::InputError(std::string file, int line, const std::string& message)
    : std::runtime_error(compose(file, line, message)), file_(std::move(file)), line_(line) {}

}  // namespace leeway::robots
