#pragma once

// Mesh files for tests of their readers.

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "leeway/robots/input_error.h"
#include "robots/mesh/readers.h"
#include "tests/support/folder.h"

namespace leeway::robots::mesh_texts {

using Reader = MeshContents (*)(const MeshSource&);

/// The result of a reader for a file with that content.
inline MeshContents readAs(Reader reader, const std::string& content,
                           const std::string& name = "mesh") {
  static const Stop never;
  const Folder folder;
  return reader(MeshSource(folder.write(name, content), "r.urdf", 7, never));
}

using Corners = std::vector<std::int32_t>;
inline Corners cornersOf(const FileMesh& mesh, std::size_t face) {
  const auto corners = mesh.cornersOf(mesh.faces.at(face));
  return {corners.begin(), corners.end()};
}

/// A file that must be rejected, where ("", ":12" or ", byte 84"), and words of the message.
struct Damaged {
  std::string content, place;
  std::initializer_list<std::string> words;
};

/// Expects "r.urdf:7: mesh PATHplace..." with all words.
inline void expectRefused(Reader reader, const Damaged& damaged) {
  const Folder folder;
  static const Stop never;
  const std::string path = folder.write("mesh", damaged.content);
  const std::string begin =
      "r.urdf:7: mesh " + path + damaged.place + (damaged.place.empty() ? " " : ": ");
  try {
    reader(MeshSource(path, "r.urdf", 7, never));
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.substr(0, begin.size()), begin) << damaged.content.substr(0, 300);
    for (const std::string& word : damaged.words)
      EXPECT_NE(message.find(word), std::string::npos) << "no \"" << word << "\" in: " << message;
    return;
  }
  ADD_FAILURE() << "accepted: " << damaged.content.substr(0, 300);
}

/// Numbers in the form of a binary file.
class Bytes {
 public:
  explicit Bytes(bool big_endian = false) : big_endian_(big_endian) {}
  template <class T>
  Bytes& add(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (big_endian_) std::reverse(bytes, bytes + sizeof(T));
    text_.append(bytes, sizeof(T));
    return *this;
  }
  Bytes& add(const std::string& text) {
    text_ += text;
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  bool big_endian_;
  std::string text_;
};

/// A binary STL file of triangles with nine coordinates each, with `count` in its header.
inline std::string binaryStl(const std::vector<std::vector<float>>& triangles, std::uint32_t count,
                             const std::string& header = "binary") {
  Bytes bytes;
  bytes.add(header + std::string(80 - header.size(), '\0')).add(count);
  for (const std::vector<float>& triangle : triangles) {
    for (int k = 0; k < 3; ++k) bytes.add(0.0F);
    for (const float value : triangle) bytes.add(value);
    bytes.add(std::uint16_t{0});
  }
  return bytes.text();
}

}  // namespace leeway::robots::mesh_texts
