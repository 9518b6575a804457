#include "planner/yaml/yaml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "leeway/robots/text.h"
#include "planner/base/did_you_mean.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

using robots::InputError;

std::string elided(std::string text) {
  constexpr std::size_t kLongest = 60;
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (text.size() > kLongest) text.replace(kLongest, std::string::npos, "...");
  return text;
}

}  // namespace

YamlReader::YamlReader(std::shared_ptr<const YamlDocument> document, YamlIndex place,
                       int parent_line)
    : document_(std::move(document)), place_(place) {
  // The line of an empty value is that of the next token: take its key's.
  line_ = isNull() ? parent_line : document_->node(place).line;
}

YamlReader YamlReader::load(const std::string& path, const robots::Stop& stop,
                            robots::InputErrors* errors) {
  robots::throwIfStopped(stop, "files were read");
  std::string text = robots::readTextFile(path, "a YAML or JSON file");
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos)
    throw InputError(path, 0, "is empty; a YAML or JSON file is expected");
  if (text[first] == '<')
    throw InputError(path, 0, "is XML, as it begins with '<'; a YAML or JSON file is expected");
  YamlReader root(std::make_shared<const YamlDocument>(path, std::move(text), stop, errors), 0, 1);
  if (root.isNull()) throw InputError(path, 0, "holds 0 YAML documents; exactly one is expected");
  return root;
}

YamlReader YamlReader::ofJson(const std::string& path, std::string text, int line) {
  return {std::make_shared<const YamlDocument>(YamlDocument::ofJson(path, std::move(text), line)),
          0, line};
}

void YamlReader::fail(const std::string& message) const {
  throw InputError(file(), line_, message);
}

std::string YamlReader::shown() const {
  if (isMap()) return "a map";
  if (isList()) return fmt::format("a list of {}", size());
  if (!isScalar()) return "nothing";
  const std::string text = elided(std::string(document_->text(node())));
  return node().is_quoted ? fmt::format("the text \"{}\"", text) : fmt::format("'{}'", text);
}

template <class Visit>
void YamlReader::forEachKey(const Visit& visit) const {
  for (YamlIndex key = node().first; key >= 0;) {
    if (!visit(key)) return;
    key = document_->node(document_->node(key).next).next;  // behind its value
  }
}

/// Fails unless this is a map with keys of plain text, each once.
void YamlReader::expectMap() const {
  if (!isMap()) fail(fmt::format("{} is {}; a map (key: value) is expected", where(), shown()));
  // Nearly all maps are short: looked through where they are, without an allocation.
  constexpr std::size_t kFew = 16;
  std::unordered_map<std::string_view, YamlIndex> many;
  const auto before = [&](std::string_view text, YamlIndex key) {
    if (size() > kFew) return many.emplace(text, key).first->second;
    YamlIndex found = key;
    forEachKey([&](YamlIndex other) {
      if (other != key && document_->text(keyNode(other)) != text) return true;
      found = other;
      return false;
    });
    return found;
  };
  forEachKey([&](YamlIndex key) {
    if (keyNode(key).kind != YamlNode::Kind::kScalar)
      throw InputError(
          file(), keyLine(key),
          fmt::format("a key of {} is no plain text; 'key: value' is expected", where()));
    const std::string_view text = document_->text(keyNode(key));
    const YamlIndex first = before(text, key);
    if (first != key) failTwice(key, valueOf(first));
    return true;
  });
}

void YamlReader::failTwice(YamlIndex key, const YamlReader& first) const {
  throw InputError(file(), keyLine(key),
                   fmt::format("key '{}' stands twice in {}, first for line {}; once is expected",
                               document_->text(keyNode(key)), where(), first.line()));
}

YamlReader YamlReader::valueOf(YamlIndex key) const {
  return {document_, document_->node(key).next, keyLine(key)};
}

std::vector<std::pair<std::string, YamlReader>> YamlReader::entries() const {
  expectMap();
  std::vector<std::pair<std::string, YamlReader>> result;
  result.reserve(size());
  forEachKey([&](YamlIndex key) {
    result.emplace_back(document_->text(keyNode(key)), valueOf(key));
    return true;
  });
  return result;
}

void YamlReader::expectKeys(std::span<const std::string_view> known) const {
  expectMap();
  forEachKey([&](YamlIndex key) {
    const std::string text(document_->text(keyNode(key)));
    if (std::find(known.begin(), known.end(), text) == known.end())
      robots::throwOrKeep(
          InputError(
              file(), keyLine(key),
              fmt::format("unknown key '{}' in {}{}", text, where(),
                          didYouMean(text, std::vector<std::string>(known.begin(), known.end())))),
          document_->errors());
    return true;
  });
}

std::optional<YamlReader> YamlReader::find(std::string_view key) const {
  if (!isMap()) fail(fmt::format("{} is {}; a map (key: value) is expected", where(), shown()));
  std::optional<YamlReader> found;
  forEachKey([&](YamlIndex k) {
    const YamlNode& node = keyNode(k);
    if (node.kind != YamlNode::Kind::kScalar || document_->text(node) != key) return true;
    if (found) failTwice(k, *found);
    found = valueOf(k);
    return true;
  });
  return found;
}

YamlReader YamlReader::at(std::string_view key, std::string_view accepted) const {
  std::optional<YamlReader> value = find(key);
  if (!value)
    fail(fmt::format("key '{}' is missing in {}; {} is expected", key, where(), accepted));
  return *value;
}

std::vector<YamlReader> YamlReader::items() const {
  if (!isList()) fail(fmt::format("{} is {}; a list is expected", where(), shown()));
  std::vector<YamlReader> result;
  result.reserve(size());
  for (YamlIndex item = node().first; item >= 0; item = document_->node(item).next)
    result.push_back({document_, item, line_});
  return result;
}

std::string_view YamlReader::scalar() const {
  if (node().is_tagged)
    fail(fmt::format("{} is {} with a tag; a value without one is expected", where(), shown()));
  return document_->text(node());
}

std::string YamlReader::text() const {
  if (!isScalar() || isEmpty()) fail(fmt::format("{} is {}; a text is expected", where(), shown()));
  return std::string(scalar());
}

std::string YamlReader::anyText() const {
  return isScalar() && isEmpty() && node().is_quoted ? std::string() : text();
}

double YamlReader::number() const {
  if (!isScalar() || node().is_quoted)
    fail(fmt::format("{} is {}; a number is expected", where(), shown()));
  const std::string text(scalar());
  const std::size_t sign = text.find_first_of("+-") == 0 ? 1 : 0;
  const std::string special = text.substr(std::min(sign, text.size()));
  const bool not_finite = special == ".inf" || special == ".Inf" || special == ".INF" ||
                          special == ".nan" || special == ".NaN" || special == ".NAN";
  const std::optional<double> parsed = robots::parseNumber(text);
  if (!not_finite && !parsed) fail(fmt::format("{} is {}; a number is expected", where(), shown()));
  const double value = parsed.value_or(std::numeric_limits<double>::infinity());
  if (!std::isfinite(value))
    fail(fmt::format("{} is {}; a finite number is expected", where(), shown()));
  return value;
}

double YamlReader::sizeNumber() const {
  const double value = number();
  if (value < 0) fail(fmt::format("{} is {}; zero or more is expected", where(), value));
  return value;
}

namespace {

template <class Integer>
std::optional<Integer> parseInteger(std::string_view text) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::int64_t YamlReader::integer(std::int64_t lowest) const {
  std::optional<std::int64_t> value;
  if (isScalar() && !node().is_quoted) value = parseInteger<std::int64_t>(scalar());
  if (!value || *value < lowest)
    fail(fmt::format("{} is {}; a whole number of at least {} is expected", where(), shown(),
                     lowest));
  return *value;
}

std::uint64_t YamlReader::seed() const {
  std::optional<std::uint64_t> value;
  if (isScalar() && !node().is_quoted) value = parseInteger<std::uint64_t>(scalar());
  if (!value)
    fail(fmt::format("{} is {}; a whole number from 0 to {} is expected", where(), shown(),
                     std::numeric_limits<std::uint64_t>::max()));
  return *value;
}

bool YamlReader::boolean() const {
  if (isScalar() && !node().is_quoted) {
    if (scalar() == "true") return true;
    if (scalar() == "false") return false;
  }
  fail(fmt::format("{} is {}; true or false is expected", where(), shown()));
}

std::vector<double> YamlReader::numbers() const {
  std::vector<double> result;
  for (const YamlReader& item : items()) result.push_back(item.number());
  return result;
}

Eigen::Vector3d YamlReader::vector3() const {
  if (!isList() || size() != 3)
    fail(fmt::format("{} is {}; a list of three numbers is expected", where(), shown()));
  const std::vector<double> v = numbers();
  return {v[0], v[1], v[2]};
}

Eigen::Vector3d YamlReader::sizeVector3() const {
  Eigen::Vector3d v = vector3();
  const std::vector<YamlReader> entries = items();
  for (const YamlReader& entry : entries) entry.sizeNumber();
  return v;
}

}  // namespace leeway::planner
