// Parses JSON into the nodes that yaml-cpp would make of it, with their lines.

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "planner/yaml/document_builder.h"

namespace leeway::planner {
namespace {

/// How far the parser has read.
struct Reading {
  const char* next = nullptr;
  int line = 1;  // of `next`
};

/// Records in a Reading how far the parser is, because nlohmann's parser does not report it.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* place, Reading* reading) : place_(place), reading_(reading) {}
  reference operator*() const { return *place_; }
  CountingIterator& operator++() {
    if (*place_ == '\n') ++reading_->line;
    reading_->next = ++place_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return place_ == other.place_; }
  bool operator!=(const CountingIterator& other) const { return place_ != other.place_; }

 private:
  const char* place_;
  Reading* reading_;
};

bool isOfNumber(char c) {
  return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'e' || c == 'E';
}

}  // namespace

/// Scalars stay where they are in the text. Strings with escapes are appended to it.
class YamlDocument::JsonEvents : public Builder {
 public:
  using Json = nlohmann::json;

  JsonEvents(YamlDocument& document, const std::string& text, const Reading& reading)
      : Builder(document), text_(text), reading_(reading) {}

  bool null() {
    add(YamlNode::Kind::kNull, reading_.line);
    return true;
  }
  bool boolean(bool value) { return scalar(read() - (value ? 4 : 5), read(), false); }
  bool number_integer(Json::number_integer_t) { return number(); }
  bool number_unsigned(Json::number_unsigned_t) { return number(); }
  bool number_float(Json::number_float_t, const std::string&) { return number(); }
  bool string(std::string& value) {
    const std::size_t end = read() - 1;  // the closing quote
    if (end > value.size() && text_[end - value.size() - 1] == '"' &&
        text_.compare(end - value.size(), value.size(), value) == 0)
      return scalar(end - value.size(), end, true);
    const std::size_t begin = text_.size() + behind.size();
    behind += value;
    return scalar(begin, begin + value.size(), true);
  }
  bool binary(Json::binary_t&) { return false; }
  bool key(std::string& value) { return string(value); }
  bool start_object(std::size_t) { return container(YamlNode::Kind::kMap); }
  bool start_array(std::size_t) { return container(YamlNode::Kind::kList); }
  bool end_object() { return end(); }
  bool end_array() { return end(); }
  bool parse_error(std::size_t, const std::string&, const Json::exception&) { return false; }

  std::string behind;

 private:
  std::size_t read() const { return static_cast<std::size_t>(reading_.next - text_.data()); }

  bool scalar(std::size_t begin, std::size_t end, bool is_quoted) {
    YamlNode& node = add(YamlNode::Kind::kScalar, line_of_token_ ? line_of_token_ : reading_.line);
    node.is_quoted = is_quoted;
    node.text = static_cast<std::int64_t>(begin);
    node.text_size = static_cast<std::int64_t>(end - begin);
    return true;
  }
  /// The parser has read one character after a number, unless the text ends with it.
  bool number() {
    std::size_t end = read();
    if (!isOfNumber(text_[end - 1])) --end;
    std::size_t begin = end;
    while (begin > 0 && isOfNumber(text_[begin - 1])) --begin;
    line_of_token_ = end < read() && text_[end] == '\n' ? reading_.line - 1 : reading_.line;
    const bool taken = scalar(begin, end, false);
    line_of_token_ = 0;
    return taken;
  }
  bool container(YamlNode::Kind kind) {
    add(kind, reading_.line);
    open();
    return true;
  }
  bool end() {
    close();
    return true;
  }

  const std::string& text_;
  const Reading& reading_;
  int line_of_token_ = 0;  // 0: the current line
};

bool YamlDocument::parseJson(std::string& text, int& error_line, int first_line) {
  // At most one entry per sign between them, so the nodes' memory never moves.
  nodes_.reserve(1 + static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
                   return c == ',' || c == ':' || c == '[' || c == '{';
                 })));
  Reading reading{text.data(), first_line};
  JsonEvents events(*this, text, reading);
  const bool is_json =
      nlohmann::json::sax_parse(CountingIterator(text.data(), &reading),
                                CountingIterator(text.data() + text.size(), &reading), &events);
  if (!is_json) {
    error_line = reading.line;
    nodes_ = {};
    return false;
  }
  texts_ = std::move(text);
  texts_ += events.behind;
  return true;
}

YamlDocument YamlDocument::ofJson(std::string file, std::string text, int line) {
  YamlDocument document;
  document.file_ = std::move(file);
  int error_line = 0;
  if (!document.parseJson(text, error_line, line))
    throw robots::InputError(document.file_, error_line,
                             "is not JSON; a JSON document is expected");
  return document;
}

}  // namespace leeway::planner
