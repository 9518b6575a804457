#include "robots/mesh/mesh_import.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "collision/base/byte_stream.h"
#include "collision/cover/mesh_bytes.h"
#include "collision/mesh/mesh_file.h"
#include "leeway/collision/triangle_mesh.h"
#include "leeway/robots/input_error.h"
#include "leeway/robots/model.h"
#include "robots/base/interruptible.h"
#include "robots/cache/content_key.h"
#include "robots/cache/disk_cache.h"
#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"
#include "robots/mesh/triangulate.h"

namespace leeway::robots {

namespace {

using collision::TriangleMesh;

// Smaller files take about as long to read as a file from the cache [B].
constexpr std::size_t kLeastKept = 4096;

/// A file's triangles in metres, and the messages about them.
struct Soup {
  std::pmr::vector<Eigen::Vector3d> vertices{collision::largeArrays()};
  std::pmr::vector<TriangleMesh::Triangle> triangles{collision::largeArrays()};
  std::vector<MeshNote> notes;
};

/// The format of a file: by its ending; if the ending is unknown, by its first bytes.
enum class Format { kStl, kObj, kPly, kDae, kGltf, kOther };

Format formatOf(const MeshSource& source) {
  const std::string ending = source.ending();
  if (ending == ".stl") return Format::kStl;
  if (ending == ".obj") return Format::kObj;
  if (ending == ".ply") return Format::kPly;
  if (ending == ".dae") return Format::kDae;
  if (ending == ".gltf" || ending == ".glb") return Format::kGltf;
  const std::string_view begin = source.text().substr(0, 4096);
  if (begin.find("<COLLADA") != std::string_view::npos) return Format::kDae;
  if (begin.starts_with("ply\n") || begin.starts_with("ply\r")) return Format::kPly;
  if (begin.starts_with("solid")) return Format::kStl;
  return Format::kOther;
}

MeshContents readContents(const MeshSource& source, bool& reads_others) {
  switch (formatOf(source)) {
    case Format::kStl:
      return readStl(source);
    case Format::kObj:
      return readObj(source);
    case Format::kPly:
      return readPly(source);
    case Format::kDae:
      return readDae(source);
    case Format::kGltf:
      return readGltf(source, reads_others);
    case Format::kOther:
      break;
  }
  const std::string ending = source.ending();
  source.fail((ending.empty() ? "has no ending" : "has the ending " + shown(ending)) +
              ", which no format that is read has; an STL, OBJ, PLY, DAE, glTF or GLB file would "
              "be accepted");
}

std::string counted(std::int64_t count, const std::string& thing) {
  return std::to_string(count) + ' ' + thing + (count == 1 ? "" : "s");
}

void noteWhatIsNotSolid(const NotSolid& left_out, std::vector<MeshNote>& notes) {
  std::string text;
  for (const auto& [count, thing] :
       {std::pair(left_out.lines, "line"), {left_out.points, "point"}, {left_out.curves, "curve"}})
    if (count > 0) text += (text.empty() ? "" : " and ") + counted(count, thing);
  if (!text.empty()) notes.push_back({left_out.first, "left out, as they have no area: " + text});
}

/// Vertices without a face indicate a file that was truncated between two lines.
void noteUnusedVertices(const FileMesh& mesh, std::vector<MeshNote>& notes) {
  std::vector<std::uint8_t> is_used(mesh.vertices.size(), 0);
  for (const std::int32_t corner : mesh.corners) is_used[static_cast<std::size_t>(corner)] = 1;
  for (const std::int32_t other : mesh.others)
    if (other >= 0 && static_cast<std::size_t>(other) < is_used.size())
      is_used[static_cast<std::size_t>(other)] = 1;
  const auto unused = std::count(is_used.begin(), is_used.end(), 0);
  if (unused > 0)
    notes.push_back({{},
                     "has " + std::to_string(unused) + (unused == 1 ? " vertex" : " vertices") +
                         " that no face uses; faces may be missing from the file"});
}

std::string inMetres(double length) {
  char text[32];
  const auto result =
      std::to_chars(text, text + sizeof(text), length, std::chars_format::general, 2);
  return std::string(text, result.ptr) + " m";
}

/// Counts the faces of all meshes of a file together.
struct FaceNote {
  std::int64_t count = 0;
  FilePlace first;
  double largest = 0;  // [m]

  /// Adds the faces of a mesh; `linear` maps it to metres.
  void add(const FaceCount& faces, const Eigen::Matrix3d& linear) {
    if (faces.count == 0) return;
    if (count == 0) first = faces.first;
    count += faces.count;
    largest = std::max(largest, (linear * faces.largest).norm());
  }
  void tell(const std::string& one, const std::string& several, const std::string& consequence,
            std::vector<MeshNote>& notes) const {
    if (count == 0) return;
    notes.push_back({first, (count == 1 ? "a face " + one + ", by " + inMetres(largest)
                                        : std::to_string(count) + " faces, the first one here, " +
                                              several + ", by up to " + inMetres(largest)) +
                                consequence});
  }
};

/// Triangulates polygons in the file's coordinates, and places the triangles. `turn` is applied
/// last.
Soup makeSoup(MeshContents contents, const Eigen::Vector3d& scale, const Eigen::Matrix3d& turn,
              const MeshSource& source) {
  Soup soup;
  soup.notes = std::move(contents.notes);
  noteWhatIsNotSolid(contents.not_solid, soup.notes);
  // (A truncated DAE file is not valid XML. The vertices of a PLY file's edges are not read.)
  const NotSolid& others = contents.not_solid;
  const Format format = formatOf(source);
  if (format == Format::kObj ||
      (format == Format::kPly && others.lines + others.points + others.curves == 0))
    for (const FileMesh& mesh : contents.meshes) noteUnusedVertices(mesh, soup.notes);
  std::vector<std::optional<CutMesh>> cuts(contents.meshes.size());
  FaceNote bent, crossing;
  for (const MeshContents::Instance& instance : contents.instances) {
    FileMesh& mesh = contents.meshes[instance.mesh];
    std::optional<CutMesh>& cut = cuts[instance.mesh];
    const bool is_first = !cut;
    if (is_first) {
      source.pause();
      cut = triangulate(mesh, Bent::kCovered);
    }
    const MeshContents::Placement X = turn * instance.placement;
    const Eigen::Matrix3d linear = scale.asDiagonal() * X.leftCols<3>();
    FaceCount unmoved;
    bent.add(is_first ? cut->bent : unmoved, linear);
    crossing.add(is_first ? cut->crossing : unmoved, linear);
    const bool is_only = contents.instances.size() == 1;
    const std::size_t first = soup.vertices.size();
    requireCountable(source, first + mesh.vertices.size(), {});
    if (is_only)
      soup.vertices = std::move(mesh.vertices);
    else
      soup.vertices.insert(soup.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    const bool is_placed = X != MeshContents::Placement::Identity();
    for (std::size_t i = first; i < soup.vertices.size(); ++i) {
      Eigen::Vector3d& v = soup.vertices[i];
      if (is_placed) v = X.leftCols<3>() * v + X.col(3);
      v = v.cwiseProduct(scale);
    }
    if (is_only) {
      soup.triangles = std::move(cut->triangles);
      break;
    }
    const auto base = static_cast<std::int32_t>(first);
    for (const CutMesh::Triangle& t : cut->triangles)
      soup.triangles.push_back({base + t[0], base + t[1], base + t[2]});
  }
  bent.tell("is not planar", "are not planar", "; every surface between the corners is covered",
            soup.notes);
  crossing.tell("crosses itself", "cross themselves",
                "; the triangles cover the inside, and perhaps more", soup.notes);
  return soup;
}

Soup readSoup(const MeshSource& source, const Eigen::Vector3d& scale, bool& reads_others,
              const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
  Soup soup = makeSoup(readContents(source, reads_others), scale, turn, source);
  if (soup.triangles.empty())
    source.fail("holds no triangles or polygons; at least one would be accepted");
  return soup;
}

// ------------------------------------------------------------------------------------------------
// the cache

/// The key of a mesh that depends only on this file.
std::string keyOf(const MeshSource& source, const Eigen::Vector3d& scale) {
  ContentKey key("mesh");
  key.add(std::string_view(source.ending()));
  for (const double factor : scale) key.add(factor);
  key.add(source.bytes());
  return key.finish();
}

/// The content of a file in the cache: the mesh's bytes, the notes, and the notes' number of bytes.
std::vector<std::byte> withNotes(std::vector<std::byte> mesh, const std::vector<MeshNote>& notes) {
  collision::ByteWriter to;
  for (const MeshNote& note : notes) {
    to.value(note.place.code());
    to.array(std::span<const char>(note.text));
  }
  const std::vector<std::byte> told = to.take();
  mesh.insert(mesh.end(), told.begin(), told.end());
  collision::ByteWriter size;
  size.value(static_cast<std::uint64_t>(told.size()));
  const std::vector<std::byte> last = size.take();
  mesh.insert(mesh.end(), last.begin(), last.end());
  return mesh;
}

std::optional<std::pair<collision::Shape, std::vector<MeshNote>>> kept(const DiskCache& cache,
                                                                       const std::string& key) {
  const auto file = cache.read(key);
  std::uint64_t size = 0;
  if (!file || file->size() < sizeof(size)) return std::nullopt;
  const std::size_t end = file->size() - sizeof(size);
  std::memcpy(&size, file->data() + end, sizeof(size));
  if (size > end) return std::nullopt;
  const std::size_t begin = end - static_cast<std::size_t>(size);
  auto mesh = collision::meshFromBytes({file->data(), begin});
  if (!mesh) return std::nullopt;
  std::vector<std::byte> told(file->data() + begin, file->data() + end);
  std::vector<MeshNote> notes;
  collision::ByteReader from(told);
  while (!from.failed() && !from.atEnd()) {
    const auto place = FilePlace::fromCode(from.value<std::int64_t>());
    const std::span<const char> text = from.view<char>();
    notes.push_back({place, std::string(text.begin(), text.end())});
  }
  if (from.failed()) return std::nullopt;
  return std::pair(collision::Shape::mesh(std::move(mesh)), std::move(notes));
}

std::vector<std::string> warningsOf(const MeshSource& source, const std::vector<MeshNote>& notes) {
  std::vector<std::string> warnings;
  for (const MeshNote& note : notes) warnings.push_back(source.warning(note));
  return warnings;
}

}  // namespace

IndexedMesh importIndexed(const std::string& path, const Eigen::Vector3d& scale,
                          const std::string& referrer, int line) {
  const Stop never;
  const MeshSource source(path, referrer, line, never);
  MeshContents contents = readObj(source);
  FileMesh& mesh = contents.meshes.front();
  const CutMesh cut = triangulate(mesh, Bent::kCut);
  if (cut.triangles.empty()) source.fail("holds no faces; at least one would be accepted");
  for (Eigen::Vector3d& v : mesh.vertices) v = v.cwiseProduct(scale);
  std::vector<MeshNote> notes = std::move(contents.notes), of_faces;
  noteWhatIsNotSolid(contents.not_solid, notes);
  noteUnusedVertices(mesh, notes);
  FaceNote bent, crossing;
  bent.add(cut.bent, scale.asDiagonal());
  bent.tell("is not planar", "are not planar", "; taken as triangles", of_faces);
  crossing.add(cut.crossing, scale.asDiagonal());
  crossing.tell("crosses itself", "cross themselves",
                "; the triangles cover the inside, and perhaps more", of_faces);
  return {{mesh.vertices.begin(), mesh.vertices.end()},
          {cut.triangles.begin(), cut.triangles.end()},
          warningsOf(source, notes),
          warningsOf(source, of_faces)};
}

IndexedMesh importTriangles(const std::string& path, const Eigen::Vector3d& scale,
                            const std::string& referrer, int line, const Stop& stop) {
  const MeshSource source(path, referrer, line, stop);
  bool reads_others = false;
  const Soup soup = readSoup(source, scale, reads_others);
  return {{soup.vertices.begin(), soup.vertices.end()},
          {soup.triangles.begin(), soup.triangles.end()},
          warningsOf(source, soup.notes)};
}

ImportedMesh importForOmplApp(const std::string& path, const std::string& referrer, int line) {
  const Stop never;
  const MeshSource source(path, referrer, line, never);
  bool reads_others = false;
  const Soup soup =
      readSoup(source, Eigen::Vector3d::Ones(), reads_others,
               formatOf(source) == Format::kDae ? upAxisToY(source) : Eigen::Matrix3d::Identity());
  try {
    return {collision::Shape::mesh(TriangleMesh::make(soup.vertices, soup.triangles)),
            {},
            warningsOf(source, soup.notes)};
  } catch (const collision::InvalidShape& invalid) {
    source.fail("cannot be used: " + std::string(invalid.what()));
  }
}

ImportedMesh importMesh(const std::string& path, const Eigen::Vector3d& scale,
                        const std::string& referrer, int line, const DiskCache& cache,
                        const Stop& stop) {
  throwIfStopped(stop, "meshes were read");
  if (!scale.allFinite() || (scale.array() == 0).any())
    throw InputError(referrer, line,
                     "mesh " + path +
                         " has a scale that is zero or not finite; three other numbers would be "
                         "accepted");
  const MeshSource source(path, referrer, line, stop);
  std::string key;
  const bool is_kept = source.bytes().size() >= kLeastKept;
  if (cache.isOn()) {
    key = keyOf(source, scale);
    if (is_kept)
      if (auto found = kept(cache, key))
        return {std::move(found->first), std::move(key), warningsOf(source, found->second)};
  }
  bool reads_others = false;
  const Soup soup = readSoup(source, scale, reads_others);
  if (reads_others) key.clear();
  source.pause();
  const auto checkpoint = [&] { source.pause(); };
  const auto result = [&](std::shared_ptr<const TriangleMesh> mesh) -> ImportedMesh {
    return {collision::Shape::mesh(std::move(mesh)), std::move(key),
            warningsOf(source, soup.notes)};
  };
  const auto alone = [&] {
    return result(
        collision::MeshFile::build(soup.vertices, soup.triangles, {}, {}, checkpoint).mesh);
  };
  try {
    if (key.empty() || !is_kept) return alone();
    try {
      collision::MeshAndBytes made =
          collision::makeMeshAndBytes(soup.vertices, soup.triangles, {}, checkpoint);
      cache.write(key, withNotes(std::move(made.bytes), soup.notes));
      return result(std::move(made.mesh));
    } catch (const std::bad_alloc&) {  // storing takes more memory than the mesh itself
      return alone();
    }
  } catch (const collision::InvalidShape& invalid) {
    source.fail("cannot be used: " + std::string(invalid.what()));
  }
}

collision::Shape loadMesh(const std::string& path, const Eigen::Vector3d& scale,
                          const std::string& referrer, int line, const LoadOptions& options,
                          std::vector<std::string>* warnings) {
  const DiskCache cache(options.cache);
  std::optional<ImportedMesh> mesh;
  const auto import = [&](const Stop& asked) {
    mesh = importMesh(path, scale, referrer, line, cache, asked);
  };
  std::error_code error;
  if (const std::uintmax_t bytes = std::filesystem::file_size(path, error);
      error || bytes < kWorthAsking) {
    throwIfStopped(options.stop, "meshes were read");
    import({});
  } else {
    workInterruptibly(options.stop, import);
  }
  if (warnings != nullptr)
    warnings->insert(warnings->end(), mesh->warnings.begin(), mesh->warnings.end());
  return std::move(mesh->shape);
}

}  // namespace leeway::robots
