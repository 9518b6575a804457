#include "robots/plain_mesh.h"

#include <assimp/fast_atof.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace leeway::robots {
namespace {

using Corner = std::array<float, 3>;

std::optional<std::string> bytesOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return std::nullopt;
  const std::streamoff size = in.tellg();
  if (size < 0) return std::nullopt;
  std::string bytes(static_cast<std::size_t>(size), '\0');
  in.seekg(0);
  if (!in.read(bytes.data(), size)) return std::nullopt;
  return bytes;
}

std::optional<PlainTriangles> readStl(const std::string& bytes) {
  constexpr std::size_t kHeader = 80, kRecord = 50, kNormal = 12;
  if (std::endian::native != std::endian::little || bytes.size() < kHeader + 4) return std::nullopt;
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeader, 4);
  if (count == 0 || bytes.size() != kHeader + 4 + kRecord * std::size_t{count}) return std::nullopt;
  PlainTriangles triangles(count);
  const char* record = bytes.data() + kHeader + 4;
  for (auto& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k)
      std::memcpy(triangle[k].data(), record + kNormal + 12 * k, sizeof(Corner));
    record += kRecord;
  }
  return triangles;
}

/// The words of a line, one by one.
class Words {
 public:
  explicit Words(std::string_view line) : line_(line) {}
  /// Empty at the end.
  std::string_view next() {
    const auto isSpace = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (at_ < line_.size() && isSpace(line_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < line_.size() && !isSpace(line_[at_])) ++at_;
    return line_.substr(begin, at_ - begin);
  }

 private:
  std::string_view line_;
  std::size_t at_ = 0;
};

/// What Assimp's parser throws where it is not pleased; readNumber() asks it for nothing like that.
struct ParseError {
  template <typename... Parts>
  explicit ParseError(Parts&&... /*parts*/) {}
};

/// Digits with a sign, a point, an exponent. By Assimp's own parser, which does not round like
/// others.
bool readNumber(std::string_view word, float& number) {
  std::size_t at = 0;
  const auto digits = [&] {
    const std::size_t begin = at;
    while (at < word.size() && word[at] >= '0' && word[at] <= '9') ++at;
    return at - begin;
  };
  const auto sign = [&] {
    if (at < word.size() && (word[at] == '-' || word[at] == '+')) ++at;
  };
  sign();
  const std::size_t whole = digits();
  if (whole == 0 || whole > 9) return false;
  if (at < word.size() && word[at] == '.') {
    ++at;
    if (digits() == 0) return false;
  }
  if (at < word.size() && (word[at] == 'e' || word[at] == 'E')) {
    ++at;
    sign();
    const std::size_t exponent = digits();
    if (exponent == 0 || exponent > 3) return false;
  }
  std::array<char, 64> text{};  // Assimp's ends with a 0
  if (at != word.size() || word.size() >= text.size()) return false;
  std::copy(word.begin(), word.end(), text.begin());
  try {
    Assimp::fast_atoreal_move<float, ParseError>(text.data(), number);
  } catch (const ParseError&) {
    return false;
  }
  return true;
}

/// Vertex numbers, with whatever follows a slash left out.
bool readIndex(std::string_view word, std::size_t vertices, std::size_t& index) {
  const std::string_view digits = word.substr(0, word.find('/'));
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  if (error != std::errc() || end != digits.data() + digits.size()) return false;
  const auto isPlain = [](char c) { return c == '/' || (c >= '0' && c <= '9'); };
  return index >= 1 && index <= vertices && std::all_of(word.begin(), word.end(), isPlain);
}

class ObjReader {
 public:
  /// False for a line that is not understood.
  bool take(std::string_view line) {
    if (line.find('\\') != std::string_view::npos) return false;
    Words words(line);
    const std::string_view kind = words.next();
    if (kind.empty() || kind.front() == '#' || kind == "vn" || kind == "vt" || kind == "s" ||
        kind == "usemtl" || kind == "mtllib")
      return true;
    if (kind == "o" || kind == "g") return triangles_.empty() && ++objects_ == 1;
    if (kind == "v") return takeVertex(words);
    if (kind == "f") return takeFace(words);
    if (kind == "l") return takeLine(words);
    return false;
  }

  PlainTriangles& triangles() { return triangles_; }

 private:
  bool takeVertex(Words& words) {
    Corner v;
    for (float& number : v)
      if (!readNumber(words.next(), number)) return false;
    vertices_.push_back(v);
    return words.next().empty();
  }

  bool takeFace(Words& words) {
    std::array<Corner, 3> triangle;
    for (Corner& corner : triangle)
      if (!takeCorner(words.next(), corner)) return false;
    triangles_.push_back(triangle);
    return words.next().empty();
  }

  bool takeLine(Words& words) {
    Corner from, to;
    if (!takeCorner(words.next(), from) || !takeCorner(words.next(), to)) return false;
    triangles_.push_back({from, to, to});
    return words.next().empty();
  }

  bool takeCorner(std::string_view word, Corner& corner) const {
    std::size_t index = 0;
    if (!readIndex(word, vertices_.size(), index)) return false;
    corner = vertices_[index - 1];
    return true;
  }

  std::vector<Corner> vertices_;
  PlainTriangles triangles_;
  int objects_ = 0;
};

std::optional<PlainTriangles> readObj(const std::string& bytes) {
  ObjReader reader;
  for (std::size_t begin = 0; begin < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
    if (!reader.take(std::string_view(bytes).substr(begin, end - begin))) return std::nullopt;
    begin = end + 1;
  }
  if (reader.triangles().empty()) return std::nullopt;
  return std::move(reader.triangles());
}

}  // namespace

std::optional<PlainTriangles> readPlainMesh(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".stl" && extension != ".obj") return std::nullopt;
  const std::optional<std::string> bytes = bytesOf(path);
  if (!bytes) return std::nullopt;
  return extension == ".stl" ? readStl(*bytes) : readObj(*bytes);
}

}  // namespace leeway::robots
