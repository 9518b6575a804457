#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "leeway/robots/text.h"
#include "planner/sensed/cloud_source.h"
#include "robots/base/read_file.h"
#include "robots/mesh/mesh_source.h"

namespace leeway::planner {
namespace {

using robots::NumberType;

struct PlyProperty {
  std::string_view name;
  NumberType type;
  std::optional<NumberType> count;  // of a list
};

struct PlyElement {
  std::string_view name;
  std::size_t count = 0;
  CloudPlace place;
  std::vector<PlyProperty> properties;
};

class PlyPoints {
 public:
  PlyPoints(const CloudSource& source, std::vector<std::string>& warnings, PointSink& sink)
      : source_(source), rest_(source.text()), warnings_(warnings), sink_(sink) {}

  void run() {
    readHeader();
    const auto vertices = std::find_if(elements_.begin(), elements_.end(),
                                       [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertices == elements_.end()) fail("has no element vertex; one is expected");
    for (auto e = elements_.begin(); e != vertices; ++e) readElement(*e, {});
    std::array<std::size_t, 3> axes;
    for (std::size_t k = 0; k < 3; ++k)
      axes[k] = axisOf(*vertices, std::string_view("xyz").substr(k, 1));
    readElement(*vertices, axes);
    for (const PlyElement& e : elements_)
      if ((e.name == "face" || e.name == "tristrips") && e.count > 0)
        warnings_.push_back(fmt::format(
            "{}:{}: the element '{}' ({}) is left out: a cloud has balls at vertices, and its "
            "surface is free between them; 'mesh' takes the surface",
            source_.path(), e.place.line, e.name, e.count));
    // Elements behind the vertices are read as well: rows that the header does not count show then.
    for (auto e = vertices + 1; e != elements_.end(); ++e) readElement(*e, {});
    expectEnd();
  }

 private:
  CloudPlace place() const {
    return order_ ? CloudPlace{0, source_.text().size() - rest_.size()} : CloudPlace{line_, 0};
  }
  [[noreturn]] void fail(const std::string& message) const {
    source_.fail({std::max<std::size_t>(line_, 1), 0}, message);
  }

  std::string_view nextLine() {
    ++line_;
    return robots::takeLine(rest_);
  }

  void readHeader() {
    if (nextLine() != "ply") fail("does not begin with a line 'ply'; a PLY file is expected");
    bool has_format = false;
    for (;;) {
      if (rest_.empty()) fail("the file ends within its header; end_header is expected");
      const std::vector<std::string_view> words = wordsOf(nextLine());
      const std::string_view word = words.empty() ? "comment" : words[0];
      if (word == "end_header") break;
      if (word == "comment" || word == "obj_info") continue;
      if (word == "format" && words.size() == 3) {
        if (has_format) fail("format stands twice in the header; once is expected");
        readFormat(words[1]);
        has_format = true;
      } else if (word == "element" && words.size() == 3) {
        const auto isVertex = [](const PlyElement& e) { return e.name == "vertex"; };
        if (words[1] == "vertex" && std::any_of(elements_.begin(), elements_.end(), isVertex))
          fail("element vertex stands twice in the header; once is expected");
        elements_.push_back({words[1],
                             readCount(source_, words[2], "the number of elements", {line_, 0}),
                             {line_, 0},
                             {}});
      } else if (word == "property" && !elements_.empty()) {
        addProperty(words);
      } else {
        fail(
            fmt::format("the header's line {} is not known; format, element, property, comment, "
                        "obj_info and end_header are accepted",
                        robots::shown(word)));
      }
    }
    if (!has_format) fail("the header has no format; ascii or binary is expected");
    order_ = format_;
  }

  void readFormat(std::string_view word) {
    if (word == "binary_little_endian")
      format_ = std::endian::little;
    else if (word == "binary_big_endian")
      format_ = std::endian::big;
    else if (word != "ascii")
      fail(
          fmt::format("the format is {}; ascii, binary_little_endian and binary_big_endian are "
                      "accepted",
                      robots::shown(word)));
  }

  void addProperty(const std::vector<std::string_view>& words) {
    const bool is_list = words.size() == 5 && words[1] == "list";
    if (!is_list && words.size() != 3)
      fail("the property is not a type and a name; both are expected");
    const auto type = [&](std::string_view word) {
      const auto known = robots::plyType(word);
      if (!known)
        fail(
            fmt::format("the type {} is not known; char, uchar, short, ushort, int, uint, float "
                        "and double are accepted",
                        robots::shown(word)));
      return *known;
    };
    PlyProperty property{words.back(), type(words[words.size() - 2]), {}};
    if (is_list) property.count = type(words[2]);
    elements_.back().properties.push_back(property);
  }

  std::size_t axisOf(const PlyElement& vertices, std::string_view axis) const {
    const auto isAxis = [&](const PlyProperty& property) {
      return property.name == axis && !property.count;
    };
    const auto begin = vertices.properties.begin(), end = vertices.properties.end();
    const auto found = std::find_if(begin, end, isAxis);
    if (std::count_if(begin, end, isAxis) > 1)
      source_.fail(
          vertices.place,
          fmt::format("the element vertex has two properties '{}'; one is expected", axis));
    if (found != end) return static_cast<std::size_t>(found - begin);
    source_.fail(
        vertices.place,
        fmt::format("the element vertex has no property '{}'; x, y and z are expected", axis));
  }

  [[noreturn]] void failEnded(const PlyElement& element, std::size_t i) const {
    source_.fail(place(),
                 fmt::format("the file ends after {} of {} rows of the element '{}'; all are "
                             "expected",
                             i, element.count, element.name));
  }

  /// `axes`: places of x, y and z among the properties; none: the element is passed over.
  void readElement(const PlyElement& element, std::optional<std::array<std::size_t, 3>> axes) {
    if (element.properties.empty()) return;
    std::size_t size = 0;
    bool has_list = false;
    for (const PlyProperty& property : element.properties) {
      size += property.type.size;
      has_list |= property.count.has_value();
    }
    if (order_ && !has_list && element.count > rest_.size() / size)
      failEnded(element, rest_.size() / size);
    for (std::size_t i = 0; i < element.count; ++i) {
      source_.pause(i);
      double p[3] = {0, 0, 0};
      CloudPlace at = place();
      if (order_) {
        readBinary(element, i, axes, p);
      } else {
        at.line = line_ + 1;
        readLine(element, i, axes, p);
      }
      if (axes) sink_.add(p, at);
    }
  }

  void readBinary(const PlyElement& element, std::size_t i,
                  const std::optional<std::array<std::size_t, 3>>& axes, double (&p)[3]) {
    const auto take = [&](NumberType type) {
      if (rest_.size() < type.size) failEnded(element, i);
      const char* const from = rest_.data();
      rest_.remove_prefix(type.size);
      return from;
    };
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      const PlyProperty& property = element.properties[k];
      if (property.count) {
        const double count = loadNumber(take(*property.count), *property.count, *order_);
        if (!(count >= 0) ||
            !(count * static_cast<double>(property.type.size) <= static_cast<double>(rest_.size())))
          source_.fail(place(), fmt::format("a list of {} entries does not fit into the file; a "
                                            "smaller count is expected",
                                            count));
        rest_.remove_prefix(static_cast<std::size_t>(count) * property.type.size);
        continue;
      }
      const char* const from = take(property.type);
      for (std::size_t axis = 0; axes && axis < 3; ++axis)
        if ((*axes)[axis] == k) p[axis] = loadNumber(from, property.type, *order_);
    }
  }

  /// An element of a text has a line of its own.
  void readLine(const PlyElement& element, std::size_t i,
                const std::optional<std::array<std::size_t, 3>>& axes, double (&p)[3]) {
    if (rest_.empty()) {
      ++line_;
      failEnded(element, i);
    }
    const std::vector<std::string_view> words = wordsOf(nextLine());
    std::size_t at = 0;
    const auto next = [&]() {
      if (at == words.size())
        fail(fmt::format("the line has {} numbers; all {} properties of '{}' are expected",
                         words.size(), element.properties.size(), element.name));
      return words[at++];
    };
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      const std::string_view word = next();
      if (element.properties[k].count) {
        const std::size_t count = readCount(source_, word, "the length of a list", {line_, 0});
        for (std::size_t n = 0; n < count; ++n) next();
        continue;
      }
      for (std::size_t axis = 0; axes && axis < 3; ++axis)
        if ((*axes)[axis] == k) p[axis] = readCoordinate(source_, word, {line_, 0});
    }
    if (at != words.size())
      fail(fmt::format("{} follows the last property of '{}'; the end of the line is expected",
                       robots::shown(words[at]), element.name));
  }

  void expectEnd() {
    if (!order_)
      while (!rest_.empty() && wordsOf(rest_.substr(0, rest_.find_first_of("\r\n"))).empty())
        nextLine();
    if (rest_.empty()) return;
    CloudPlace at = place();
    if (!order_) ++at.line;
    source_.fail(at,
                 "more follows the last element; a header that counts all elements is expected");
  }

  const CloudSource& source_;
  std::string_view rest_;
  std::vector<std::string>& warnings_;
  PointSink& sink_;
  std::size_t line_ = 0;
  std::optional<std::endian> format_, order_;  // of binary data; order_ is set behind the header
  std::vector<PlyElement> elements_;
};

}  // namespace

void readPly(const CloudSource& source, std::vector<std::string>& warnings, PointSink& sink) {
  PlyPoints(source, warnings, sink).run();
}

}  // namespace leeway::planner
