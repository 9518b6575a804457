#include <cctype>

#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {
namespace {

constexpr std::size_t kHeader = 84, kFacet = 50, kNormal = 12;  // of a binary file [B]

bool isWord(std::string_view word, std::string_view lower_case) {
  return std::equal(
      word.begin(), word.end(), lower_case.begin(), lower_case.end(),
      [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

/// Whether the file is text. Text begins with `solid`, but so may the header of a binary file. A
/// binary file has a byte of value 0 soon after, in its header's padding, its count or a normal.
bool isText(const MeshSource& source) {
  constexpr std::size_t kLooked = 1024;
  Words words(source.text().substr(0, kLooked));
  return isWord(words.next(), "solid") &&
         source.text().substr(0, kLooked).find('\0') == std::string_view::npos;
}

class TextStl {
 public:
  explicit TextStl(const MeshSource& source) : source_(source), words_(source.text()) {}

  FileMesh run() {
    next();  // solid
    do {
      skipName();
      while (isWord(next(), "facet")) readFacet();
      expectEnd("solid", "facet or endsolid");
      skipName();
    } while (isWord(next(), "solid"));
    if (!word_.empty()) fail("solid, or the file's end,");
    return std::move(mesh_);
  }

 private:
  std::string_view next() { return word_ = words_.next(); }

  [[noreturn]] void fail(const std::string& accepted) const {
    source_.failAt(words_.place(),
                   (word_.empty() ? "the file ends here, within a solid" : shown(word_)) + "; " +
                       accepted + " would be accepted");
  }
  void expect(std::string_view lower_case) {
    if (!isWord(next(), lower_case)) fail(std::string(lower_case));
  }
  /// Expects that the last word is `endKIND`, or `end` followed by KIND.
  void expectEnd(const std::string& kind, const std::string& accepted) {
    if (isWord(word_, "end" + kind)) return;
    if (!isWord(word_, "end")) fail(accepted);
    expect(kind);
  }

  /// Skips the name of a solid, to the end of its line. A facet there would be lost.
  void skipName() {
    Words name(words_.restOfLine(), words_.line());
    bool is_facet = false;
    while (!(word_ = name.next()).empty()) {
      if (is_facet && isWord(word_, "vertex")) fail("a new line after the name of a solid");
      is_facet = is_facet || isWord(word_, "facet") || isWord(word_, "loop");
    }
  }

  /// Reads from after `facet` to `endfacet`. The text for the normal is ignored, because it may be
  /// anything, most often nan.
  void readFacet() {
    if (++facets_ % MeshSource::kLinesBetweenStops == 0) source_.pause();
    const FilePlace place = words_.place();
    while (!isWord(next(), "outer"))
      if (word_.empty() || isWord(word_, "vertex") || isWord(word_, "endfacet") ||
          isWord(word_, "facet"))
        fail("outer loop");
    expect("loop");
    const auto first = static_cast<std::int32_t>(mesh_.vertices.size());
    std::int32_t count = 0;
    for (; isWord(next(), "vertex"); ++count) {
      Eigen::Vector3d& v = mesh_.vertices.emplace_back();
      for (int k = 0; k < 3; ++k) {
        next();
        v[k] = coordinate(source_, word_, words_.place());
      }
      mesh_.corners.push_back(first + count);
    }
    expectEnd("loop", "vertex or endloop");
    if (count < 3)
      source_.failAt(words_.place(), "a facet of " + std::to_string(count) +
                                         " vertices ends here; at least three would be accepted");
    next();
    expectEnd("facet", "endfacet");
    requireCountable(source_, mesh_.vertices.size(), place);
    mesh_.faces.push_back({first, count, place});
  }

  const MeshSource& source_;
  Words words_;
  std::string_view word_;
  std::size_t facets_ = 0;
  FileMesh mesh_;
};

bool isPrintable(std::byte byte) {
  const char c = static_cast<char>(byte);
  return isBlank(c) || (c >= ' ' && c <= '~');
}

/// Whether the 50 bytes after the last declared triangle are a triangle, as far as can be
/// determined; if so, the count is wrong. (Other data there belongs to other programs.)
bool isTriangleOf(const FileMesh& mesh, const std::byte* bytes) {
  double largest = 0;
  for (const Eigen::Vector3d& v : mesh.vertices)
    largest = std::max(largest, v.cwiseAbs().maxCoeff());
  double most = 0;
  for (std::size_t k = 0; k < 12; ++k) {
    const double value = std::abs(static_cast<double>(loadNumber<float>(bytes + 4 * k)));
    if (!std::isfinite(value)) return false;
    if (k < 3 && value > 2) return false;  // a normal
    if (k < 3) continue;
    most = std::max(most, value);
    if (value != 0 && value < 1e-12 * largest) return false;
  }
  return most > 0 && most <= 100 * largest;
}

FileMesh readBinary(const MeshSource& source, std::vector<MeshNote>& notes) {
  const std::span<const std::byte> bytes = source.bytes();
  if (bytes.size() < kHeader)
    source.fail(
        "is no STL: it neither begins with \"solid\" nor has the 84 bytes of a binary "
        "header; an intact STL file would be accepted");
  const std::size_t count = loadNumber<std::uint32_t>(&bytes[kHeader - 4]);
  const std::size_t room = (bytes.size() - kHeader) / kFacet;
  if (const std::size_t zero = source.text().find('\0');
      isWord(Words(source.text()).next(), "solid") && zero >= kHeader && count > room)
    source.failAt(FilePlace::byte(bytes.size() - source.text().size() + zero),
                  "a byte of value 0 stands in a text file; text without it, or a binary file, "
                  "would be accepted");
  if (count > room && std::all_of(bytes.begin(), bytes.begin() + kHeader, isPrintable))
    source.failAt(FilePlace::line(1), "begins with " + shown(Words(source.text()).next()) +
                                          "; \"solid\", or a binary file, would be accepted");
  if (count > room)
    source.failAt(FilePlace::byte(bytes.size()),
                  "the file ends here, after " + std::to_string(room) + " of " +
                      std::to_string(count) + " triangles; " + "a file of " +
                      std::to_string(kHeader + count * kFacet) + " bytes would be accepted");
  requireCountable(source, 3 * count, FilePlace::byte(kHeader - 4));
  FileMesh mesh;
  mesh.vertices.resize(3 * count);
  mesh.corners.resize(3 * count);
  mesh.faces.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (i % MeshSource::kLinesBetweenStops == 0) source.pause();
    const std::size_t offset = kHeader + i * kFacet;
    mesh.faces[i] = {static_cast<std::int32_t>(3 * i), 3, FilePlace::byte(offset)};
    for (std::size_t k = 0; k < 9; ++k) {
      const std::size_t place = offset + kNormal + 4 * k;
      const double value = static_cast<double>(loadNumber<float>(&bytes[place]));
      if (!std::isfinite(value))
        source.failAt(FilePlace::byte(place),
                      "a coordinate is not finite; a finite number would be accepted");
      mesh.vertices[3 * i + k / 3][static_cast<Eigen::Index>(k % 3)] = value;
    }
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) mesh.corners[k] = static_cast<std::int32_t>(k);
  }
  const std::size_t end = kHeader + count * kFacet;
  const bool fits = (bytes.size() - end) % kFacet == 0;
  // A whole number of facets counts as triangles unless it is one byte, repeated.
  const auto isFilled = [&] {
    return std::all_of(bytes.begin() + static_cast<std::ptrdiff_t>(end), bytes.end(),
                       [&](std::byte byte) { return byte == bytes[end]; });
  };
  if (room > count && (count == 0 || (fits ? !isFilled() : isTriangleOf(mesh, &bytes[end]))))
    source.failAt(FilePlace::byte(kHeader - 4),
                  "the count is " + std::to_string(count) + ", but more triangles follow, up to " +
                      std::to_string(room) + "; their number would be accepted");
  if (end < bytes.size())
    notes.push_back({FilePlace::byte(end), std::to_string(bytes.size() - end) +
                                               " bytes after the last triangle are not read"});
  return mesh;
}

}  // namespace

MeshContents readStl(const MeshSource& source) {
  MeshContents contents;
  const bool is_text = isText(source);
  const std::size_t size = source.bytes().size();
  // The header of a binary file may also begin with "solid".
  const bool fits =
      size >= kHeader &&
      size ==
          kHeader + kFacet * std::size_t{loadNumber<std::uint32_t>(&source.bytes()[kHeader - 4])};
  contents.meshes.push_back(is_text && !fits ? TextStl(source).run()
                                             : readBinary(source, contents.notes));
  contents.instances.push_back({0, MeshContents::Placement::Identity()});
  return contents;
}

}  // namespace leeway::robots
