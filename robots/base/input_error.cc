#include "leeway/robots/input_error.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace leeway::robots {

namespace {

constexpr std::size_t kLongest = 500;  // longest message that a person still reads
constexpr std::size_t kHead = 300;     // its first part, if the middle is omitted

bool continuesCharacter(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

/// Converts the text to one line, because names in files may contain any character.
std::string readable(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }, ' ');
  if (text.size() <= kLongest) return text;
  constexpr std::string_view kGap = " ... ";
  std::size_t head = kHead, tail = text.size() - (kLongest - kHead - kGap.size());
  while (head > 0 && continuesCharacter(text[head])) --head;
  while (tail < text.size() && continuesCharacter(text[tail])) ++tail;
  return text.substr(0, head) + std::string(kGap) + text.substr(tail);
}

std::string compose(const std::string& file, int line, const std::string& message) {
  if (file.empty()) return readable(message);
  return readable(line <= 0 ? file + ": " + message
                            : file + ":" + std::to_string(line) + ": " + message);
}

}  // namespace

InputError::InputError(std::string file, int line, const std::string& message)
    : std::runtime_error(compose(file, line, message)), file_(std::move(file)), line_(line) {}

std::size_t InputErrors::placeOf(const InputError& error) {
  const std::string_view text = error.what();
  const auto found = std::find_if(list_.begin(), list_.end(),
                                  [&](const InputError& other) { return other.what() == text; });
  const auto place = static_cast<std::size_t>(found - list_.begin());
  if (place < kMost && found == list_.end()) list_.push_back(error);
  return place;
}

bool InputErrors::keep(const InputError& error) {
  const std::size_t place = placeOf(error);
  if (place == kMost) return false;
  kept_.push_back(place);
  return true;
}

bool InputErrors::note(const InputError& error) { return placeOf(error) < kMost; }

}  // namespace leeway::robots
