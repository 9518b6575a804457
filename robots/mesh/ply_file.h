#pragma once

// Private to the layers above collision/: PLY files, whose elements are vertices of meshes and
// points of clouds.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "robots/mesh/file_mesh.h"
#include "robots/mesh/number_type.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {

struct PlyProperty {
  std::string name;
  NumberType type;
  std::optional<NumberType> count;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  FilePlace place;
  std::vector<PlyProperty> properties;

  /// The first property with one of the names; -1 if there is none.
  int find(std::initializer_list<std::string_view> names) const;
};

/// The header of a file, then the numbers of its elements in their order. In text files, each row
/// of an element has its own line.
class PlyFile {
 public:
  /// Reports an error at a place; must throw.
  using Fail = std::function<void(FilePlace, const std::string&)>;

  /// Reads the header. `text`, the whole file, must outlive this object.
  PlyFile(std::string_view text, Fail fail);

  const std::vector<PlyElement>& elements() const { return elements_; }
  bool isText() const { return !order_; }
  /// The places of x, y and z among the properties of the vertices. Fails unless each of them is a
  /// number and stands once.
  std::array<std::size_t, 3> axesOf(const PlyElement& vertices) const;

  /// Calls read(row) for each row of an element. It must read or skip all properties.
  template <class Read>
  void forEach(const PlyElement& element, const Read& read) {
    if (element.properties.empty()) return;
    expectRoom(element);
    element_ = &element;
    for (row_ = 0; row_ < element.count; ++row_) {
      beginRow();
      read(row_);
      endRow();
    }
  }
  double number(NumberType type);
  /// The number of entries of a list.
  std::size_t count(const PlyProperty& list);
  /// Skips the properties from `begin` to before `end`.
  void skip(const PlyElement& element, std::size_t begin, std::size_t end);
  /// Call this after the last element. Fails if more than blanks follow, in a binary file more than
  /// one line end.
  void finish() const;

  /// Reports that the last number is not as expected.
  [[noreturn]] void fail(const std::string& accepted) const;
  /// The place of the last number.
  FilePlace place() const { return order_ ? byteOf(last_) : FilePlace::line(line_); }
  /// The last number in a text.
  std::string_view word() const { return word_; }
  /// Upper bound on the number of rows that follow, because each has at least a byte.
  std::size_t left() const { return rest_.size(); }

 private:
  void readHeader();
  Words nextLine();
  void readFormat(Words& words);
  void readElement(Words& words);
  void readProperty(Words& words);
  void expectLineEnd(Words& words) const;
  /// Fails if rows of one size do not fit into the file.
  void expectRoom(const PlyElement& element) const;
  void beginRow();
  void endRow();

  FilePlace byteOf(const char* at) const {
    return FilePlace::byte(static_cast<std::size_t>(at - text_.data()));
  }
  [[noreturn]] void failAt(FilePlace place, const std::string& message) const;
  [[noreturn]] void failWord(std::string_view word, const std::string& accepted) const;
  [[noreturn]] void failAtEnd(const PlyElement& element, std::size_t row) const;

  std::string_view text_, rest_;
  Fail fail_;
  std::int64_t line_ = 0;
  std::optional<std::endian> order_;  // of binary data
  std::vector<PlyElement> elements_;
  const PlyElement* element_ = nullptr;
  std::size_t row_ = 0;
  Words words_{""};
  std::string_view word_;
  const char* last_ = nullptr;
};

}  // namespace leeway::robots
