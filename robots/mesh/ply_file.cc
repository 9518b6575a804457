#include "robots/mesh/ply_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "leeway/robots/text.h"
#include "robots/base/read_file.h"
#include "robots/mesh/mesh_source.h"

namespace leeway::robots {
namespace {

const std::vector<std::string> kPlyHeaderWords = {"format",  "comment",  "obj_info",
                                                  "element", "property", "end_header"};

}  // namespace

int PlyElement::find(std::initializer_list<std::string_view> names) const {
  for (std::size_t i = 0; i < properties.size(); ++i)
    for (const std::string_view wanted : names)
      if (properties[i].name == wanted) return static_cast<int>(i);
  return -1;
}

PlyFile::PlyFile(std::string_view text, Fail fail)
    : text_(text), rest_(text), fail_(std::move(fail)) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  readHeader();
  last_ = rest_.data();
}

void PlyFile::failAt(FilePlace place, const std::string& message) const {
  fail_(place, message);
  std::abort();  // fail_ throws
}

void PlyFile::failWord(std::string_view word, const std::string& accepted) const {
  failAt(FilePlace::line(line_), (word.empty() ? "the line ends too early" : shown(word)) + "; " +
                                     accepted + " would be accepted");
}

// ------------------------------------------------------------------------------------------------
// the header

Words PlyFile::nextLine() {
  if (rest_.empty())
    failAt(FilePlace::line(std::max<std::int64_t>(line_, 1)),
           line_ == 0 ? "is empty; \"ply\" would be accepted"
                      : "the file ends within its header; end_header would be accepted");
  return Words(takeLine(rest_), ++line_);
}

void PlyFile::readHeader() {
  if (const std::string_view word = nextLine().next(); word != "ply")
    failAt(FilePlace::line(1), "begins with " + shown(word) + "; \"ply\" would be accepted");
  for (bool has_format = false;;) {
    Words words = nextLine();
    const std::string_view word = words.next();
    if (word == "end_header") {
      if (!has_format) failWord(word, "a format before it");
      return;
    }
    if (word.empty() || word == "comment" || word == "obj_info") continue;
    if (word == "format") {
      if (has_format)
        failAt(FilePlace::line(line_), "format stands twice in the header; one would be accepted");
      readFormat(words);
      has_format = true;
    } else if (word == "element") {
      readElement(words);
    } else if (word == "property") {
      readProperty(words);
    } else if (const std::string* meant = nearestName(word, kPlyHeaderWords)) {
      failWord(word, *meant);
    }  // (Blender 2.4 writes a comment without its keyword.)
  }
}

void PlyFile::expectLineEnd(Words& words) const {
  if (const std::string_view word = words.next(); !word.empty())
    failWord(word, "the end of the line");
}

void PlyFile::readFormat(Words& words) {
  const std::string_view word = words.next();
  if (word == "binary_little_endian")
    order_ = std::endian::little;
  else if (word == "binary_big_endian")
    order_ = std::endian::big;
  else if (word != "ascii")
    failWord(word, "ascii, binary_little_endian or binary_big_endian");
  if (words.next().empty()) failWord("", "a version, 1.0,");
  expectLineEnd(words);
}

void PlyFile::readElement(Words& words) {
  PlyElement element;
  element.name = words.next();
  element.place = FilePlace::line(line_);
  if (element.name == "vertex" &&
      std::any_of(elements_.begin(), elements_.end(),
                  [](const PlyElement& e) { return e.name == "vertex"; }))
    failAt(element.place, "element vertex stands twice in the header; one would be accepted");
  const std::string_view count = words.next();
  const auto [end, error] =
      std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (error != std::errc() || end != count.data() + count.size())
    failWord(count, "the number of elements");
  expectLineEnd(words);
  elements_.push_back(std::move(element));
}

void PlyFile::readProperty(Words& words) {
  if (elements_.empty()) failWord("property", "an element before it");
  const auto typeOf = [&](std::string_view word) {
    const std::optional<NumberType> type = plyType(word);
    if (!type) failWord(word, "char, uchar, short, ushort, int, uint, float or double");
    return *type;
  };
  PlyProperty property;
  const std::string_view word = words.next();
  if (word == "list") property.count = typeOf(words.next());
  property.type = typeOf(property.count ? words.next() : word);
  property.name = words.next();
  if (property.name.empty()) failWord("", "the property's name");
  expectLineEnd(words);
  elements_.back().properties.push_back(std::move(property));
}

std::array<std::size_t, 3> PlyFile::axesOf(const PlyElement& vertices) const {
  std::array<std::size_t, 3> axes{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string_view axis = std::string_view("xyz").substr(k, 1);
    const int found = vertices.find({axis});
    if (found < 0 || vertices.properties[static_cast<std::size_t>(found)].count)
      failAt(vertices.place, "the element vertex has no property " + shown(axis) +
                                 "; one for each of x, y and z would be accepted");
    const auto isAxis = [&](const PlyProperty& property) { return property.name == axis; };
    if (std::count_if(vertices.properties.begin(), vertices.properties.end(), isAxis) > 1)
      failAt(vertices.place, "the element vertex has two properties " + shown(axis) +
                                 "; one for each of x, y and z would be accepted");
    axes[k] = static_cast<std::size_t>(found);
  }
  return axes;
}

// ------------------------------------------------------------------------------------------------
// elements

void PlyFile::fail(const std::string& accepted) const {
  failAt(place(), (order_          ? "the number here cannot be used"
                   : word_.empty() ? "the line ends too early"
                                   : shown(word_) + " cannot be used here") +
                      std::string("; ") + accepted + " would be accepted");
}

void PlyFile::failAtEnd(const PlyElement& element, std::size_t row) const {
  failAt(order_ ? byteOf(rest_.data() + rest_.size()) : FilePlace::line(line_ + 1),
         "the file ends here, after " + std::to_string(row) + " of " +
             std::to_string(element.count) + " rows of the element " + shown(element.name) +
             "; a whole file would be accepted");
}

void PlyFile::expectRoom(const PlyElement& element) const {
  std::size_t size = 0;
  for (const PlyProperty& property : element.properties) {
    if (!order_ || property.count) return;
    size += property.type.size;
  }
  if (size > 0 && element.count > rest_.size() / size) failAtEnd(element, rest_.size() / size);
}

void PlyFile::beginRow() {
  if (order_) return;
  do {
    if (rest_.empty()) failAtEnd(*element_, row_);
    words_ = Words(takeLine(rest_), ++line_);
  } while (words_.atEnd());
}

void PlyFile::endRow() {
  if (order_) return;
  word_ = words_.next();
  if (!word_.empty()) fail("the end of the line, after the last property,");
}

double PlyFile::number(NumberType type) {
  if (!order_) {
    word_ = words_.next();
    const std::optional<double> value = parseNumber(word_);
    if (!value) fail(word_.empty() ? "a line that holds all properties" : "a number");
    return *value;
  }
  if (rest_.size() < type.size) failAtEnd(*element_, row_);
  last_ = rest_.data();
  rest_.remove_prefix(type.size);
  return loadNumber(reinterpret_cast<const std::byte*>(last_), type, *order_);
}

std::size_t PlyFile::count(const PlyProperty& list) {
  const double count = number(*list.count);
  if (!(count >= 0 && count == std::floor(count) && count <= 0x7FFFFFFF))
    fail("the number of entries of a list");
  const auto entries = static_cast<std::size_t>(count);
  if (order_ && entries > rest_.size() / list.type.size)
    failAt(place(), "a list of " + std::to_string(entries) +
                        " entries does not fit into the file; a whole file would be accepted");
  return entries;
}

void PlyFile::skip(const PlyElement& element, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    const PlyProperty& property = element.properties[k];
    const std::size_t numbers = property.count ? count(property) : 1;
    for (std::size_t i = 0; i < numbers; ++i) number(property.type);
  }
}

void PlyFile::finish() const {
  Words rest(rest_, line_ + 1);
  const std::string_view next = rest.next();
  if (order_ ? rest_.empty() || rest_ == "\n" || rest_ == "\r\n" : next.empty()) return;
  failAt(order_ ? byteOf(rest_.data()) : rest.place(),
         (order_ ? std::to_string(rest_.size()) + " bytes follow" : shown(next) + " follows") +
             " the last element; a header that names as many elements as there are would be "
             "accepted");
}

}  // namespace leeway::robots
