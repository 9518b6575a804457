#include "planner/problem/yaml_reader.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "leeway/robots/text.h"
#include "planner/base/nearest_name.h"

namespace leeway::planner {
namespace {

using robots::InputError;

std::string readFile(const std::string& path) {
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  // A directory opens, but cannot be read.
  if (!stream || stream.bad() || errno == EISDIR)
    throw InputError(path, 0,
                     fmt::format("cannot be read: {}; a readable file is expected",
                                 errno != 0 ? std::strerror(errno) : "input error"));
  return text.str();
}

std::string elided(std::string text) {
  constexpr std::size_t kLongest = 60;
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (text.size() > kLongest) text.replace(kLongest, std::string::npos, "...");
  return text;
}

bool quoted(const YAML::Node& node) { return node.Tag() == "!"; }

/// Parses without building a document.
class IgnoreEvents : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

/// 0, 1, or 2 for more. Not by YAML::LoadAll: after a stray comma behind a document, that of
/// yaml-cpp 0.7 returns empty documents without end.
int countDocuments(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  IgnoreEvents events;
  int documents = 0;
  while (documents < 2 && parser.HandleNextDocument(events)) ++documents;
  return documents;
}

}  // namespace

YamlReader::YamlReader(std::shared_ptr<const std::string> file, const YAML::Node& node,
                       std::string where, int parent_line)
    : file_(std::move(file)), node_(node), where_(std::move(where)) {
  // The mark of an empty value is that of the next token: take its key's line.
  const YAML::Mark mark = node_.Mark();
  line_ = mark.is_null() || node_.IsNull() ? parent_line : mark.line + 1;
}

YamlReader YamlReader::load(const std::string& path) {
  const std::string text = readFile(path);
  YAML::Node document;
  try {
    if (countDocuments(text) > 1)
      throw InputError(path, 0,
                       "holds 2 YAML documents or more, or text that belongs to none; exactly one "
                       "is expected");
    document = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(path, error.mark.is_null() ? 0 : error.mark.line + 1,
                     fmt::format("YAML syntax error: {}; well-formed YAML is expected", error.msg));
  }
  if (document.IsNull())
    throw InputError(path, 0, "holds 0 YAML documents; exactly one is expected");
  return {std::make_shared<const std::string>(path), document, "the file", 1};
}

void YamlReader::fail(const std::string& message) const {
  throw InputError(*file_, line_, message);
}

std::string YamlReader::shown() const {
  if (node_.IsMap()) return "a map";
  if (node_.IsSequence()) return fmt::format("a list of {}", node_.size());
  if (!node_.IsScalar()) return "nothing";
  return quoted(node_) ? fmt::format("the text \"{}\"", elided(node_.Scalar()))
                       : fmt::format("'{}'", elided(node_.Scalar()));
}

/// Fails unless this is a map with keys of plain text, each once.
void YamlReader::expectMap() const {
  if (!isMap()) fail(fmt::format("{} is {}; a map (key: value) is expected", where_, shown()));
  for (auto entry = node_.begin(); entry != node_.end(); ++entry) {
    const int line = entry->first.Mark().line + 1;
    if (!entry->first.IsScalar())
      throw InputError(
          *file_, line,
          fmt::format("a key of {} is no plain text; 'key: value' is expected", where_));
    const std::string& key = entry->first.Scalar();
    for (auto other = node_.begin(); other != entry; ++other)
      if (other->first.Scalar() == key)
        throw InputError(
            *file_, line,
            fmt::format("key '{}' stands twice in {}, first for line {}; once is expected", key,
                        where_, valueOf(*other).line()));
  }
}

YamlReader YamlReader::valueOf(const YAML::detail::iterator_value& entry) const {
  const std::string& key = entry.first.Scalar();
  return {file_, entry.second, where_ == "the file" ? key : where_ + "." + key,
          entry.first.Mark().line + 1};
}

std::vector<std::pair<std::string, YamlReader>> YamlReader::entries() const {
  expectMap();
  std::vector<std::pair<std::string, YamlReader>> result;
  result.reserve(node_.size());
  for (const auto& entry : node_) result.emplace_back(entry.first.Scalar(), valueOf(entry));
  return result;
}

void YamlReader::expectKeys(std::span<const std::string_view> known) const {
  expectMap();
  for (const auto& entry : node_) {
    const std::string& key = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw InputError(
          *file_, entry.first.Mark().line + 1,
          fmt::format("unknown key '{}' in {}{}", key, where_,
                      nearestName(key, std::vector<std::string>(known.begin(), known.end()))));
  }
}

std::optional<YamlReader> YamlReader::find(std::string_view key) const {
  if (!isMap()) fail(fmt::format("{} is {}; a map (key: value) is expected", where_, shown()));
  for (const auto& entry : node_)
    if (entry.first.IsScalar() && entry.first.Scalar() == key) return valueOf(entry);
  return std::nullopt;
}

YamlReader YamlReader::at(std::string_view key, std::string_view accepted) const {
  std::optional<YamlReader> value = find(key);
  if (!value) fail(fmt::format("key '{}' is missing in {}; {} is expected", key, where_, accepted));
  return *value;
}

std::vector<YamlReader> YamlReader::items() const {
  if (!isList()) fail(fmt::format("{} is {}; a list is expected", where_, shown()));
  std::vector<YamlReader> result;
  result.reserve(node_.size());
  for (const auto& item : node_)
    result.push_back(YamlReader(file_, item, fmt::format("{}[{}]", where_, result.size()), line_));
  return result;
}

std::string YamlReader::text() const {
  if (!isScalar() || node_.Scalar().empty())
    fail(fmt::format("{} is {}; a text is expected", where_, shown()));
  return node_.Scalar();
}

double YamlReader::number() const {
  if (!isScalar() || quoted(node_))
    fail(fmt::format("{} is {}; a number is expected", where_, shown()));
  const std::string& text = node_.Scalar();
  const std::size_t sign = text.find_first_of("+-") == 0 ? 1 : 0;
  const std::string special = text.substr(std::min(sign, text.size()));
  const bool not_finite = special == ".inf" || special == ".Inf" || special == ".INF" ||
                          special == ".nan" || special == ".NaN" || special == ".NAN";
  const std::optional<double> parsed = robots::parseNumber(text);
  if (!not_finite && !parsed) fail(fmt::format("{} is {}; a number is expected", where_, shown()));
  const double value = parsed.value_or(std::numeric_limits<double>::infinity());
  if (!std::isfinite(value))
    fail(fmt::format("{} is {}; a finite number is expected", where_, shown()));
  return value;
}

double YamlReader::sizeNumber() const {
  const double value = number();
  if (value < 0) fail(fmt::format("{} is {}; zero or more is expected", where_, value));
  return value;
}

namespace {

template <class Integer>
std::optional<Integer> parseInteger(const std::string& text) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::int64_t YamlReader::integer(std::int64_t lowest) const {
  std::optional<std::int64_t> value;
  if (isScalar() && !quoted(node_)) value = parseInteger<std::int64_t>(node_.Scalar());
  if (!value || *value < lowest)
    fail(fmt::format("{} is {}; a whole number of at least {} is expected", where_, shown(),
                     lowest));
  return *value;
}

std::uint64_t YamlReader::seed() const {
  std::optional<std::uint64_t> value;
  if (isScalar() && !quoted(node_)) value = parseInteger<std::uint64_t>(node_.Scalar());
  if (!value)
    fail(fmt::format("{} is {}; a whole number from 0 to {} is expected", where_, shown(),
                     std::numeric_limits<std::uint64_t>::max()));
  return *value;
}

bool YamlReader::boolean() const {
  if (isScalar() && !quoted(node_)) {
    if (node_.Scalar() == "true") return true;
    if (node_.Scalar() == "false") return false;
  }
  fail(fmt::format("{} is {}; true or false is expected", where_, shown()));
}

std::vector<double> YamlReader::numbers() const {
  std::vector<double> result;
  for (const YamlReader& item : items()) result.push_back(item.number());
  return result;
}

Eigen::Vector3d YamlReader::vector3() const {
  if (!isList() || size() != 3)
    fail(fmt::format("{} is {}; a list of three numbers is expected", where_, shown()));
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
