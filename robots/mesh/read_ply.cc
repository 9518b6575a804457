#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "robots/base/read_file.h"
#include "robots/mesh/number_type.h"
#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {
namespace {

struct Property {
  std::string name;
  NumberType type;
  std::optional<NumberType> count;  // of a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  FilePlace place;
  std::vector<Property> properties;

  /// The first property with one of the names; -1 if there is none.
  int find(std::initializer_list<std::string_view> names) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
      for (const std::string_view wanted : names)
        if (properties[i].name == wanted) return static_cast<int>(i);
    return -1;
  }
};

/// The numbers of the elements, in their order. In text files, each element has its own line.
class Body {
 public:
  /// `text` begins after the header; `line` is that of its first byte. Without an order, it is a
  /// text file.
  Body(const MeshSource& source, std::string_view text, std::int64_t line,
       std::optional<std::endian> order)
      : source_(source), rest_(text), line_(line - 1), order_(order) {}

  void beginElement() {
    if (order_) return;
    do {
      if (rest_.empty()) failAtEnd();
      words_ = Words(takeLine(rest_), ++line_);
    } while (words_.atEnd());
  }

  double number(NumberType type) {
    if (!order_) {
      word_ = words_.next();
      const std::optional<double> value = parseNumber(word_);
      if (!value) fail(word_.empty() ? "a line that holds all properties" : "a number");
      return *value;
    }
    if (rest_.size() < type.size) failAtEnd();
    last_ = rest_.data();
    rest_.remove_prefix(type.size);
    return loadNumber(reinterpret_cast<const std::byte*>(last_), type, *order_);
  }

  void endElement() {
    if (order_) return;
    word_ = words_.next();
    if (!word_.empty()) fail("the end of the line, after the last property,");
  }

  /// Call this after the last element.
  void finish() const {
    Words rest(rest_, line_ + 1);
    const std::string_view next = rest.next();
    if (next.empty()) return;
    source_.failAt(
        order_ ? byteOf(rest_.data()) : rest.place(),
        (order_ ? std::to_string(rest_.size()) + " bytes follow" : shown(next) + " follows") +
            " the last element; a header that names as many elements as there are would "
            "be accepted");
  }

  /// Reports that the last number is not as expected.
  [[noreturn]] void fail(const std::string& accepted) const {
    source_.failAt(place(), (order_          ? "the number here cannot be used"
                             : word_.empty() ? "the line ends too early"
                                             : shown(word_) + " cannot be used here") +
                                std::string("; ") + accepted + " would be accepted");
  }
  /// The place of the last number.
  FilePlace place() const { return order_ ? byteOf(last_) : FilePlace::line(line_); }
  /// Upper bound on the number of elements that follow, because each has at least a byte.
  std::size_t left() const { return rest_.size(); }

 private:
  FilePlace byteOf(const char* at) const {
    const char* const begin = reinterpret_cast<const char*>(source_.bytes().data());
    return FilePlace::byte(static_cast<std::size_t>(at - begin));
  }
  [[noreturn]] void failAtEnd() const {
    source_.failAt(order_ ? byteOf(rest_.data() + rest_.size()) : FilePlace::line(line_ + 1),
                   "the file ends here, before the last element that its header names; a whole "
                   "file would be accepted");
  }

  const MeshSource& source_;
  std::string_view rest_;
  std::int64_t line_;
  std::optional<std::endian> order_;
  Words words_{""};
  std::string_view word_;
  const char* last_ = rest_.data();
};

const std::vector<std::string> kHeaderWords = {"format",  "comment",  "obj_info",
                                               "element", "property", "end_header"};

class PlyReader {
 public:
  explicit PlyReader(const MeshSource& source) : source_(source), rest_(source.text()) {}

  MeshContents run() {
    readHeader();
    Body body(source_, rest_, line_ + 1, order_);
    for (const Element& element : elements_) {
      if (element.name == "vertex") {
        readVertices(element, body);
      } else if (element.name == "face" || element.name == "tristrips") {
        readFaces(element, body);
      } else {
        for (const auto& property : element.properties)
          if (property.name == "vertex_indices" || property.name == "vertex_index")
            source_.failAt(element.place, "element " + shown(element.name) + " has " +
                                              property.name + "; element face would be accepted");
        if (element.name == "edge" && element.count > 0) {
          contents_.not_solid.count(contents_.not_solid.lines, element.place);
          contents_.not_solid.lines += static_cast<std::int64_t>(element.count) - 1;
        }
        forEach(element, body,
                [&](std::size_t) { skip(element, 0, element.properties.size(), body); });
      }
    }
    body.finish();
    if (!order_ && !lastLineEnds(source_.text()))
      contents_.notes.push_back({body.place(), std::string(kLastLineOpen)});
    const auto count = static_cast<std::int32_t>(mesh_.vertices.size());
    for (const FileMesh::Face& face : mesh_.faces)
      for (const std::int32_t corner : mesh_.cornersOf(face))
        if (corner >= count)
          source_.failAt(face.place, "the face names vertex " + std::to_string(corner) + "; 0 to " +
                                         std::to_string(count - 1) + " would be accepted");
    contents_.meshes.push_back(std::move(mesh_));
    contents_.instances.push_back({0, MeshContents::Placement::Identity()});
    return std::move(contents_);
  }

 private:
  // ----------------------------------------------------------------------------------------------
  // the header

  FilePlace place() const { return FilePlace::line(line_); }
  [[noreturn]] void fail(std::string_view word, const std::string& accepted) const {
    source_.failAt(place(), (word.empty() ? "the line ends too early" : shown(word)) + "; " +
                                accepted + " would be accepted");
  }

  /// The next line of the header, without its end; the body begins after it.
  Words nextLine() {
    if (rest_.empty())
      source_.failAt(place(), "the file ends within its header; end_header would be accepted");
    return Words(takeLine(rest_), ++line_);
  }

  void readHeader() {
    if (nextLine().next() != "ply")
      source_.failAt(place(), "begins with " + shown(Words(source_.text()).next()) +
                                  "; \"ply\" would be accepted");
    bool has_format = false;
    for (;;) {
      Words words = nextLine();
      const std::string_view word = words.next();
      if (word == "end_header") break;
      if (word.empty() || word == "comment" || word == "obj_info") continue;
      if (word == "format") {
        readFormat(words.next());
        has_format = true;
      } else if (word == "element") {
        readElement(words);
      } else if (word == "property") {
        readProperty(words);
      } else if (const std::string* meant = nearestName(word, kHeaderWords)) {
        fail(word, *meant);
      }  // (Blender 2.4 writes a comment without its keyword.)
    }
    if (!has_format) fail("end_header", "a format before it");
  }

  void readFormat(std::string_view word) {
    if (word == "binary_little_endian")
      order_ = std::endian::little;
    else if (word == "binary_big_endian")
      order_ = std::endian::big;
    else if (word != "ascii")
      fail(word, "ascii, binary_little_endian or binary_big_endian");
  }

  void readElement(Words& words) {
    Element element;
    element.name = words.next();
    element.place = place();
    const std::string_view count = words.next();
    const auto [end, error] =
        std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (error != std::errc() || end != count.data() + count.size())
      fail(count, "the number of elements");
    elements_.push_back(std::move(element));
  }

  void readProperty(Words& words) {
    if (elements_.empty()) fail("property", "an element before it");
    const auto next = [&](std::string_view word) {
      const std::optional<NumberType> type = plyType(word);
      if (!type) fail(word, "char, uchar, short, ushort, int, uint, float or double");
      return *type;
    };
    Property property;
    const std::string_view word = words.next();
    if (word == "list") property.count = next(words.next());
    property.type = next(property.count ? words.next() : word);
    property.name = words.next();
    if (property.name.empty()) fail("", "the property's name");
    elements_.back().properties.push_back(std::move(property));
  }

  // ----------------------------------------------------------------------------------------------
  // elements

  template <class Read>
  void forEach(const Element& element, Body& body, const Read& read) {
    if (element.properties.empty()) return;
    for (std::size_t i = 0; i < element.count; ++i) {
      if (i % MeshSource::kLinesBetweenStops == 0) source_.pause();
      body.beginElement();
      read(i);
      body.endElement();
    }
  }

  std::size_t readCount(const Property& list, Body& body) const {
    const double count = body.number(*list.count);
    if (!(count >= 0 && count == std::floor(count) && count <= 0x7FFFFFFF))
      body.fail("the number of entries of a list");
    return static_cast<std::size_t>(count);
  }

  /// Skips the properties from `begin` to before `end`.
  void skip(const Element& element, std::size_t begin, std::size_t end, Body& body) const {
    for (std::size_t k = begin; k < end; ++k) {
      const Property& property = element.properties[k];
      const std::size_t count = property.count ? readCount(property, body) : 1;
      for (std::size_t i = 0; i < count; ++i) body.number(property.type);
    }
  }

  void readVertices(const Element& element, Body& body) {
    const int axes[3] = {element.find({"x"}), element.find({"y"}), element.find({"z"})};
    for (const int axis : axes)
      if (axis < 0 || element.properties[static_cast<std::size_t>(axis)].count)
        source_.failAt(element.place,
                       "a vertex without x, y and z; a property for each would be accepted");
    for (const int axis : axes)
      if (std::count_if(
              element.properties.begin(), element.properties.end(), [&](const Property& property) {
                return property.name == element.properties[static_cast<std::size_t>(axis)].name;
              }) > 1)
        source_.failAt(element.place,
                       "a vertex with two properties of one name; one of each of x, y and z would "
                       "be accepted");
    mesh_.vertices.reserve(mesh_.vertices.size() + std::min(element.count, body.left()));
    forEach(element, body, [&](std::size_t) {
      Eigen::Vector3d& v = mesh_.vertices.emplace_back();
      requireCountable(source_, mesh_.vertices.size(), element.place);
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const Property& property = element.properties[k];
        if (property.count) {
          skip(element, k, k + 1, body);
          continue;
        }
        const double value = body.number(property.type);
        for (int axis = 0; axis < 3; ++axis) {
          if (axes[axis] != static_cast<int>(k)) continue;
          if (!(std::abs(value) <= kGreatestCoordinate))
            body.fail("a finite coordinate of up to 1e60");
          v[axis] = value;
        }
      }
    });
  }

  void readFaces(const Element& element, Body& body) {
    const int list = element.find({"vertex_indices", "vertex_index"});
    if (list < 0 || !element.properties[static_cast<std::size_t>(list)].count)
      source_.failAt(element.place, "the element " + element.name +
                                        " has no list of its vertices; a property list with the "
                                        "name vertex_indices would be accepted");
    const auto place_of_list = static_cast<std::size_t>(list);
    const Property& indices = element.properties[place_of_list];
    std::vector<std::int32_t> corners;
    forEach(element, body, [&](std::size_t) {
      skip(element, 0, place_of_list, body);
      corners.clear();
      const std::size_t count = readCount(indices, body);
      const FilePlace place = body.place();
      for (std::size_t i = 0; i < count; ++i) corners.push_back(readCorner(element, indices, body));
      if (element.name == "face")
        addFace(corners, place);
      else
        addStrips(corners, place);
      skip(element, place_of_list + 1, element.properties.size(), body);
    });
  }

  /// Returns a corner; -1 ends a strip.
  std::int32_t readCorner(const Element& element, const Property& indices, Body& body) const {
    const double index = body.number(indices.type);
    const double least = element.name == "face" ? 0 : -1;
    if (!(index >= least && index == std::floor(index) && index <= 0x7FFFFFFE))
      body.fail("the number of a vertex, from 0,");
    return static_cast<std::int32_t>(index);
  }

  void addFace(const std::vector<std::int32_t>& corners, FilePlace place) {
    NotSolid& left_out = contents_.not_solid;
    if (corners.size() < 2) return left_out.count(left_out.points, place);
    if (corners.size() == 2) return left_out.count(left_out.lines, place);
    requireCountable(source_, mesh_.corners.size() + corners.size(), place);
    mesh_.addFace(corners, place);
  }

  /// Adds strips of triangles; every second triangle of a strip is reversed.
  void addStrips(const std::vector<std::int32_t>& corners, FilePlace place) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i] < 0) begin = i + 1;
      if (i < begin + 2) continue;
      const bool odd = (i - begin) % 2 == 1;
      const std::int32_t triangle[3] = {corners[i - (odd ? 1 : 2)], corners[i - (odd ? 2 : 1)],
                                        corners[i]};
      requireCountable(source_, mesh_.corners.size() + 3, place);
      mesh_.addFace(triangle, place);
    }
  }

  const MeshSource& source_;
  std::string_view rest_;
  std::int64_t line_ = 0;
  std::optional<std::endian> order_;
  std::vector<Element> elements_;
  FileMesh mesh_;
  MeshContents contents_;
};

}  // namespace

MeshContents readPly(const MeshSource& source) { return PlyReader(source).run(); }

}  // namespace leeway::robots
