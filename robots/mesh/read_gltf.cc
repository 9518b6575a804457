#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/robots/input_error.h"
#include "leeway/robots/text.h"
#include "robots/base/read_file.h"
#include "robots/mesh/number_type.h"
#include "robots/mesh/readers.h"
#include "robots/mesh/scan.h"

namespace leeway::robots {
namespace {

using Json = nlohmann::json;
using Placement = MeshContents::Placement;

/// A value of the file, and the path to it that messages show.
struct Entry {
  const Json* value = nullptr;  // null if it is not there
  std::string path;

  bool exists() const { return value != nullptr; }
};

/// A type of component, by its number in the file.
std::optional<NumberType> componentType(std::size_t number) {
  using Kind = NumberType::Kind;
  switch (number) {
    case 5120:
      return NumberType{Kind::kSigned, 1};
    case 5121:
      return NumberType{Kind::kUnsigned, 1};
    case 5122:
      return NumberType{Kind::kSigned, 2};
    case 5123:
      return NumberType{Kind::kUnsigned, 2};
    case 5125:
      return NumberType{Kind::kUnsigned, 4};
    case 5126:
      return NumberType{Kind::kFloat, 4};
    default:
      return std::nullopt;
  }
}

/// Whether a file that requires the extension is read correctly without knowing more of it.
bool changesNoShape(std::string_view extension) {
  for (const std::string_view prefix :
       {"KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_"})
    if (extension.starts_with(prefix)) return true;
  return extension == "KHR_mesh_quantization";
}

/// Numbers of one accessor, in the bytes of a buffer.
struct Numbers {
  const std::byte* begin = nullptr;
  std::size_t count = 0, stride = 0;
  NumberType type;
  bool is_normalized = false;
  std::string path;

  double at(std::size_t element, std::size_t component) const {
    const double value =
        loadNumber(begin + element * stride + component * type.size, type, std::endian::little);
    if (!is_normalized) return value;
    // Section 3.11 (animations) of the specification has these scales.
    const bool has_sign = type.kind == NumberType::Kind::kSigned;
    const double most = std::ldexp(1, static_cast<int>(8 * type.size) - (has_sign ? 1 : 0)) - 1;
    return std::max(value / most, -1.0);
  }
};

class GltfReader {
 public:
  GltfReader(const MeshSource& source, bool& reads_others)
      : source_(source), reads_others_(reads_others) {}

  MeshContents run() {
    parse();
    requireVersion();
    requireKnownExtensions();
    const Entry scenes = list(root(), "scenes");
    if (scenes.exists() && !scenes.value->empty()) {
      const Entry scene = element(scenes, indexIn(root(), "scene", scenes).value_or(0));
      const Entry nodes = list(scene, "nodes");
      for (std::size_t i = 0; nodes.exists() && i < nodes.value->size(); ++i)
        roots_.push_back(index(element(nodes, i), all("nodes")));
    } else {
      addNodesWithoutParent();
    }
    placeNodes();
    if (member(root(), "animations").exists()) contents_.notes.push_back({{}, kAnimated});
    return std::move(contents_);
  }

 private:
  // ----------------------------------------------------------------------------------------------
  // JSON

  Entry root() const { return {&json_, ""}; }

  [[noreturn]] void fail(const Entry& at, const std::string& accepted) const {
    const auto kindOf = [](const Json& value) -> std::string {
      return value.is_array()    ? "a list"
             : value.is_object() ? "an object"
                                 : shown(value.dump(-1, ' ', true, Json::error_handler_t::replace));
    };
    source_.fail((at.path.empty() ? "the file" : at.path) +
                 (at.exists() ? " is " + kindOf(*at.value) : " is missing") + "; " + accepted +
                 " would be accepted");
  }

  Entry member(const Entry& of, const char* key) const {
    if (!of.value->is_object()) fail(of, "an object");
    const auto found = of.value->find(key);
    return {found == of.value->end() ? nullptr : &*found,
            of.path.empty() ? key : of.path + '.' + key};
  }
  Entry element(const Entry& of, std::size_t index) const {
    return {&(*of.value)[index], of.path + '[' + std::to_string(index) + ']'};
  }
  /// A member that is a list, or nothing.
  Entry list(const Entry& of, const char* key) const {
    const Entry entry = member(of, key);
    if (entry.exists() && !entry.value->is_array()) fail(entry, "a list");
    return entry;
  }
  /// One of the file's lists, which has to be there.
  Entry all(const char* key) const {
    const Entry entry = list(root(), key);
    if (!entry.exists()) fail(entry, "a list");
    return entry;
  }
  std::size_t whole(const Entry& entry) const {
    constexpr double kMost = 0x1p53;
    if (entry.exists() && entry.value->is_number()) {
      const double value = entry.value->get<double>();
      if (value >= 0 && value <= kMost && value == std::floor(value))
        return static_cast<std::size_t>(value);
    }
    fail(entry, "a whole number");
  }
  std::size_t whole(const Entry& of, const char* key, std::size_t otherwise) const {
    const Entry entry = member(of, key);
    return entry.exists() ? whole(entry) : otherwise;
  }
  std::size_t index(const Entry& entry, const Entry& in) const {
    if (in.value->empty()) fail(in, "a list with an entry for each number that names one");
    const std::size_t value = whole(entry);
    if (value >= in.value->size()) fail(entry, "0 to " + std::to_string(in.value->size() - 1));
    return value;
  }
  std::optional<std::size_t> indexIn(const Entry& of, const char* key, const Entry& in) const {
    const Entry entry = member(of, key);
    if (!entry.exists()) return std::nullopt;
    return index(entry, in);
  }
  std::string text(const Entry& entry) const {
    if (!entry.exists() || !entry.value->is_string()) fail(entry, "a text");
    return entry.value->get<std::string>();
  }
  template <std::size_t Size>
  std::optional<std::array<double, Size>> numbers(const Entry& of, const char* key) const {
    const Entry entry = list(of, key);
    if (!entry.exists()) return std::nullopt;
    std::array<double, Size> values;
    const std::string accepted = std::to_string(Size) + " finite numbers";
    if (entry.value->size() != Size) fail(entry, accepted);
    for (std::size_t i = 0; i < Size; ++i) {
      const Json& value = (*entry.value)[i];
      if (!value.is_number()) fail(entry, accepted);
      values[i] = value.get<double>();
      if (!(std::abs(values[i]) <= kGreatestCoordinate)) fail(entry, accepted);
    }
    return values;
  }

  // ----------------------------------------------------------------------------------------------
  // the file

  /// Section 4.4 of the specification: a header of 12 bytes, and chunks of JSON and of binary data.
  void parse() {
    std::string_view text = source_.text();
    const std::span<const std::byte> bytes = source_.bytes();
    is_binary_ = text.starts_with("glTF");
    if (is_binary_) {
      const auto word = [&](std::size_t at) {
        if (at + 4 > bytes.size())
          source_.failAt(FilePlace::byte(bytes.size()),
                         "the file ends here, within a header; a whole file would be accepted");
        return static_cast<std::size_t>(loadNumber<std::uint32_t>(&bytes[at]));
      };
      const auto chunk = [&](std::size_t at) {
        const std::size_t size = word(at);
        if (size > bytes.size() - (at + 8))
          source_.failAt(FilePlace::byte(at),
                         "a part of " + std::to_string(size) +
                             " bytes begins here, and the file ends before it does; a whole file "
                             "would be accepted");
        return bytes.subspan(at + 8, size);
      };
      if (word(4) != 2)
        source_.failAt(FilePlace::byte(4),
                       "the version is " + std::to_string(word(4)) + "; 2 would be accepted");
      if (word(8) != bytes.size())
        source_.failAt(FilePlace::byte(8),
                       "the header names " + std::to_string(word(8)) + " bytes, and the file has " +
                           std::to_string(bytes.size()) + "; a whole file would be accepted");
      constexpr std::size_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
      if (word(16) != kJsonChunk)
        source_.failAt(FilePlace::byte(16), "the first part is not JSON; JSON would be accepted");
      const std::span<const std::byte> json = chunk(12);
      text = {reinterpret_cast<const char*>(json.data()), json.size()};
      const std::size_t next = 20 + json.size();
      if (next < bytes.size() && word(next + 4) == kBinaryChunk) binary_ = chunk(next);
    }
    try {
      json_ = Json::parse(text);
    } catch (const Json::exception& error) {
      std::size_t at = text.size();
      if (const auto* parse = dynamic_cast<const Json::parse_error*>(&error))
        at = std::min(parse->byte == 0 ? 0 : parse->byte - 1, at);
      source_.failAt(
          is_binary_ ? FilePlace::byte(20 + at)
                     : FilePlace::line(
                           1 + std::count(text.begin(),
                                          text.begin() + static_cast<std::ptrdiff_t>(at), '\n')),
          "is not JSON here; an intact glTF file would be accepted");
    }
    if (!json_.is_object()) fail(root(), "an object");
  }

  void requireVersion() const {
    const Entry asset = member(root(), "asset");
    if (!asset.exists()) fail({nullptr, "asset.version"}, "\"2.0\"");
    // A later 2.x adds what a reader of 2.0 may leave out, unless minVersion needs it (3.2).
    const Entry version = member(asset, "version"), least = member(asset, "minVersion");
    if (!version.exists() || !isVersion2(text(version))) fail(version, "\"2.0\"");
    if (least.exists() && text(least) != "2.0") fail(least, "\"2.0\"");
  }

  static bool isVersion2(std::string_view version) {
    return version.size() > 2 && version.starts_with("2.") &&
           version.find_first_not_of("0123456789", 2) == std::string_view::npos;
  }

  /// A reader has to refuse a file that requires an extension unknown to it (section 3.12).
  void requireKnownExtensions() const {
    const Entry required = list(root(), "extensionsRequired");
    for (std::size_t i = 0; required.exists() && i < required.value->size(); ++i)
      if (!changesNoShape(text(element(required, i))))
        fail(element(required, i),
             "KHR_mesh_quantization, and extensions of materials, textures and lights,");
  }

  // ----------------------------------------------------------------------------------------------
  // numbers

  std::span<const std::byte> buffer(std::size_t number) {
    const Entry buffers = all("buffers");
    loaded_.resize(buffers.value->size());
    const Entry given = element(buffers, number);
    std::optional<std::string>& loaded = loaded_[number];
    const Entry uri = member(given, "uri");
    if (!loaded && uri.exists()) loaded = load(uri);
    if (!uri.exists() && !(is_binary_ && number == 0))
      fail(uri, "the name of a file, or data in base64,");
    const std::span<const std::byte> bytes =
        loaded ? std::as_bytes(std::span<const char>(*loaded)) : binary_;
    const Entry length = member(given, "byteLength");
    const std::size_t size = whole(length);
    if (size > bytes.size())
      fail(length, "at most the " + std::to_string(bytes.size()) + " bytes that are there");
    return bytes.first(size);
  }

  std::string load(const Entry& uri) {
    const std::string given = text(uri);
    const std::size_t colon = given.find_first_of(":/");
    if (colon != std::string::npos && given[colon] == ':') {
      constexpr std::string_view kMark = ";base64,";
      const std::size_t mark = given.find(kMark);
      if (!given.starts_with("data:") || mark == std::string::npos)
        source_.fail(uri.path + " is " + shown(given.substr(0, given.find(','))) +
                     "; the name of a file, or data in base64, would be accepted");
      return decoded(uri, unescaped(given.substr(mark + kMark.size())));
    }
    reads_others_ = true;
    const std::string name = unescaped(given);
    if (name.find('\0') != std::string::npos) fail(uri, "the name of a file");
    const std::filesystem::path path = std::filesystem::path(source_.path()).parent_path() / name;
    try {
      return readBinaryFile(path, "the numbers of a glTF file", std::size_t{1} << 31);
    } catch (const InputError& error) {
      source_.fail("names the file " + shown(given) + " in " + uri.path + ": " + error.what() +
                   "; a file that is there would be accepted");
    }
  }

  /// A part of a URI without its percent-encoding (RFC 3986, section 2.1).
  static std::string unescaped(const std::string& part) {
    std::string text;
    for (std::size_t i = 0; i < part.size(); ++i) {
      unsigned code = 0;
      if (part[i] == '%' && i + 2 < part.size() &&
          std::from_chars(&part[i + 1], &part[i + 3], code, 16).ptr == &part[i + 3]) {
        text += static_cast<char>(code);
        i += 2;
      } else {
        text += part[i];
      }
    }
    return text;
  }

  std::string decoded(const Entry& uri, std::string_view text) const {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    while (text.ends_with('=')) text.remove_suffix(1);
    std::array<int, 256> values;
    values.fill(-1);
    for (std::size_t i = 0; i < kDigits.size(); ++i)
      values[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3 + 3);
    unsigned bits = 0;
    int count = 0;
    for (const char c : text) {
      const int value = values[static_cast<unsigned char>(c)];
      if (value < 0)
        source_.fail(uri.path + " has " + shown({&c, 1}) + "; base64 would be accepted");
      bits = bits << 6 | static_cast<unsigned>(value);
      count += 6;
      if (count < 8) continue;
      count -= 8;
      bytes += static_cast<char>(bits >> count & 0xFF);
    }
    return bytes;
  }

  /// The numbers of an accessor with `components` of them an element.
  Numbers accessor(const Entry& named, const char* type, std::size_t components) {
    const Entry accessors = all("accessors");
    const Entry given = element(accessors, index(named, accessors));
    Numbers result;
    result.path = given.path;
    if (text(member(given, "type")) != type)
      fail(member(given, "type"), '"' + std::string(type) + '"');
    const Entry component = member(given, "componentType");
    const std::optional<NumberType> number = componentType(whole(component));
    if (!number) fail(component, "5120 to 5126, the numbers of types,");
    result.type = *number;
    const Entry normalized = member(given, "normalized");
    if (normalized.exists() && !normalized.value->is_boolean()) fail(normalized, "true or false");
    result.is_normalized = normalized.exists() && normalized.value->get<bool>() &&
                           number->kind != NumberType::Kind::kFloat;
    result.count = whole(member(given, "count"));
    if (member(given, "sparse").exists())
      source_.fail(given.path + " is sparse; numbers in one piece would be accepted");
    const Entry views = all("bufferViews");
    const Entry view = element(views, index(member(given, "bufferView"), views));
    const std::span<const std::byte> bytes = buffer(index(member(view, "buffer"), all("buffers")));
    const std::size_t begin = whole(view, "byteOffset", 0),
                      size = whole(member(view, "byteLength"));
    if (begin > bytes.size() || size > bytes.size() - begin)
      fail(member(view, "byteLength"),
           "a part of the " + std::to_string(bytes.size()) + " bytes of its buffer");
    const std::size_t element_size = components * number->size;
    result.stride = whole(view, "byteStride", element_size);
    if (result.stride < element_size)
      fail(member(view, "byteStride"), std::to_string(element_size));
    const std::size_t offset = whole(given, "byteOffset", 0);
    if (result.count > 0 && (offset > size || size - offset < element_size ||
                             (size - offset - element_size) / result.stride < result.count - 1))
      fail(member(given, "count"),
           "as many as the " + std::to_string(size) + " bytes of " + view.path + " hold");
    result.begin = bytes.data() + begin + offset;
    return result;
  }

  // ----------------------------------------------------------------------------------------------
  // meshes

  /// Where the meshes of a file's mesh stand in the contents.
  struct Range {
    std::size_t begin, end;
  };

  Range meshesOf(std::size_t number) {
    const Entry meshes = all("meshes");
    ranges_.resize(meshes.value->size());
    std::optional<Range>& range = ranges_[number];
    if (range) return *range;
    const Entry mesh = element(meshes, number);
    requireNoMorph(mesh);
    range = {contents_.meshes.size(), contents_.meshes.size()};
    const Entry parts = list(mesh, "primitives");
    if (!parts.exists()) fail(parts, "a list");
    for (std::size_t i = 0; i < parts.value->size(); ++i) readPart(element(parts, i));
    range->end = contents_.meshes.size();
    return *range;
  }

  void requireNoMorph(const Entry& of) const {
    const Entry weights = list(of, "weights");
    for (std::size_t i = 0; weights.exists() && i < weights.value->size(); ++i)
      if ((*weights.value)[i] != 0)
        fail(weights, "a mesh without morph targets, or with weights of 0,");
  }

  void readPart(const Entry& part) {
    const Entry position =
        member(member(part, "attributes").exists() ? member(part, "attributes") : part, "POSITION");
    const std::size_t mode = whole(part, "mode", 4);
    if (mode > 6) fail(member(part, "mode"), "0 to 6");
    const Numbers vertices =
        accessor({position.value, part.path + ".attributes.POSITION"}, "VEC3", 3);
    std::optional<Numbers> indices;
    if (const Entry named = member(part, "indices"); named.exists()) {
      indices = accessor(named, "SCALAR", 1);
      if (indices->type.kind != NumberType::Kind::kUnsigned || indices->is_normalized)
        source_.fail(indices->path +
                     " has the indices of a mesh; whole numbers without a sign (5121, 5123, 5125) "
                     "would be accepted");
    }
    const std::size_t count = indices ? indices->count : vertices.count;
    NotSolid& left_out = contents_.not_solid;
    if (mode == 0) return leaveOut(left_out.points, count);
    if (mode < 4) return leaveOut(left_out.lines, mode == 1 ? count / 2 : count);
    if (mode == 4 ? count % 3 != 0 : count < 3)
      source_.fail(part.path + " has " + std::to_string(count) + " corners; " +
                   (mode == 4 ? "three for each triangle" : "at least three") +
                   " would be accepted");
    FileMesh mesh;
    requireCountable(source_, vertices.count, {});
    requireCountable(source_, mode == 4 ? count : 3 * (count - 2), {});
    const auto corner = [&](std::size_t i) {
      const double vertex = indices ? indices->at(i, 0) : static_cast<double>(i);
      if (!(vertex < static_cast<double>(vertices.count)))
        source_.fail(indices->path + " names vertex " +
                     std::to_string(static_cast<std::int64_t>(vertex)) + " of " +
                     std::to_string(vertices.count) + "; smaller numbers would be accepted");
      return static_cast<std::int32_t>(vertex);
    };
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      if (a % MeshSource::kLinesBetweenStops == 0) source_.pause();
      const std::int32_t corners[3] = {corner(a), corner(b), corner(c)};
      mesh.addFace(corners, {});
    };
    if (mode == 4)
      for (std::size_t i = 0; i < count; i += 3) add(i, i + 1, i + 2);
    else
      for (std::size_t i = 2; i < count; ++i)
        mode == 6 ? add(0, i - 1, i) : i % 2 == 0 ? add(i - 2, i - 1, i) : add(i - 1, i - 2, i);
    takeVertices(vertices, mesh);
    contents_.meshes.push_back(std::move(mesh));
  }

  /// Gives a mesh the vertices that its corners name: parts may share many of them.
  void takeVertices(const Numbers& vertices, FileMesh& mesh) const {
    std::vector<std::int32_t> places(vertices.count, -1);
    for (const std::int32_t corner : mesh.corners) places[static_cast<std::size_t>(corner)] = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i % MeshSource::kLinesBetweenStops == 0) source_.pause();
      if (places[i] < 0) continue;
      const Eigen::Vector3d v(vertices.at(i, 0), vertices.at(i, 1), vertices.at(i, 2));
      if (!v.allFinite())
        source_.fail(vertices.path +
                     " has a coordinate that is not finite; finite numbers would "
                     "be accepted");
      places[i] = static_cast<std::int32_t>(mesh.vertices.size());
      mesh.vertices.push_back(v);
    }
    for (std::int32_t& corner : mesh.corners) corner = places[static_cast<std::size_t>(corner)];
  }

  void leaveOut(std::int64_t& kind, std::size_t count) {
    kind += static_cast<std::int64_t>(std::min<std::size_t>(count, 0x7FFFFFFF));
  }

  // ----------------------------------------------------------------------------------------------
  // nodes

  void addNodesWithoutParent() {
    const Entry nodes = list(root(), "nodes");
    if (!nodes.exists()) return;
    std::vector<bool> is_child(nodes.value->size(), false);
    for (std::size_t i = 0; i < nodes.value->size(); ++i) {
      const Entry children = list(element(nodes, i), "children");
      for (std::size_t k = 0; children.exists() && k < children.value->size(); ++k)
        is_child[index(element(children, k), nodes)] = true;
    }
    for (std::size_t i = 0; i < is_child.size(); ++i)
      if (!is_child[i]) roots_.push_back(i);
  }

  void placeNodes() {
    std::vector<std::pair<std::size_t, Eigen::Matrix4d>> open;
    for (auto node = roots_.rbegin(); node != roots_.rend(); ++node)
      open.emplace_back(*node, Eigen::Matrix4d::Identity());
    if (open.empty()) return;
    const Entry nodes = all("nodes");
    std::vector<bool> is_placed(nodes.value->size(), false);
    while (!open.empty()) {
      const auto [number, parent] = open.back();
      open.pop_back();
      const Entry node = element(nodes, number);
      if (is_placed[number])
        source_.fail(node.path +
                     " has two parents, or is below itself; one parent would be accepted");
      is_placed[number] = true;
      const Eigen::Matrix4d X = parent * transformOf(node);
      if (!X.allFinite()) source_.fail(node.path + " is placed too far away for finite numbers");
      placeMesh(node, X);
      const Entry children = list(node, "children");
      for (std::size_t k = children.exists() ? children.value->size() : 0; k-- > 0;)
        open.emplace_back(index(element(children, k), nodes), X);
    }
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < is_placed.size(); ++i)
      if (!is_placed[i] && member(element(nodes, i), "mesh").exists()) ++left_out;
    if (left_out > 0)
      contents_.notes.push_back(
          {{},
           "left out, as they are not in the file's scene: " + std::to_string(left_out) +
               (left_out == 1 ? " node" : " nodes") + " with a mesh"});
  }

  void placeMesh(const Entry& node, const Eigen::Matrix4d& X) {
    const Entry mesh = member(node, "mesh");
    if (!mesh.exists()) return;
    if (const Entry skin = member(node, "skin"); skin.exists()) fail(skin, "a mesh without a skin");
    if (const Entry extensions = member(node, "extensions"); extensions.exists())
      if (const Entry copies = member(extensions, "EXT_mesh_gpu_instancing"); copies.exists())
        fail(copies, "a node for each copy of a mesh");
    requireNoMorph(node);
    const Range range = meshesOf(index(mesh, all("meshes")));
    for (std::size_t i = range.begin; i < range.end; ++i)
      contents_.instances.push_back({i, X.topRows<3>()});
  }

  /// A misspelt transformation would leave the mesh elsewhere.
  void expectTransform(const Entry& node) const {
    static const std::vector<std::string> kKnown = {
        "matrix", "rotation", "scale",      "translation", "camera", "children",
        "mesh",   "name",     "extensions", "extras",      "skin",   "weights"};
    for (const auto& [key, value] : node.value->items()) {
      if (std::find(kKnown.begin(), kKnown.end(), key) != kKnown.end()) continue;
      const std::string* meant = nearestName(key, std::span(kKnown).first(4));
      for (std::size_t i = 0; i < 4 && meant == nullptr && key.size() > 2; ++i)
        if (kKnown[i].starts_with(key)) meant = &kKnown[i];
      if (meant != nullptr)
        source_.fail(node.path + " has the unknown key " + shown(key) + "; " + *meant +
                     " would be accepted");
    }
  }

  Eigen::Matrix4d transformOf(const Entry& node) const {
    expectTransform(node);
    if (const auto matrix = numbers<16>(node, "matrix")) {
      for (const char* other : {"translation", "rotation", "scale"})
        if (const Entry beside = member(node, other); beside.exists())
          source_.fail(beside.path + " stands beside a matrix; one of them would be accepted");
      const Eigen::Matrix4d X = Eigen::Map<const Eigen::Matrix4d>(matrix->data());  // by columns
      if (X.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
        fail(member(node, "matrix"), "0, 0, 0 and 1 as the last row, numbers 4, 8, 12 and 16,");
      return X;
    }
    Eigen::Matrix4d X = Eigen::Matrix4d::Identity();
    if (const auto turn = numbers<4>(node, "rotation")) {
      const Eigen::Quaterniond q(Eigen::Vector4d(turn->data()));
      if (!(std::abs(q.norm() - 1) <= 1e-3)) fail(member(node, "rotation"), "a unit quaternion");
      X.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
    }
    if (const auto scale = numbers<3>(node, "scale"))
      X.topLeftCorner<3, 3>() *= Eigen::Vector3d(scale->data()).asDiagonal();
    if (const auto move = numbers<3>(node, "translation"))
      X.topRightCorner<3, 1>() = Eigen::Vector3d(move->data());
    return X;
  }

  const MeshSource& source_;
  bool& reads_others_;
  Json json_;
  bool is_binary_ = false;
  std::span<const std::byte> binary_;
  std::vector<std::optional<std::string>> loaded_;  // buffers
  std::vector<std::optional<Range>> ranges_;        // by the file's meshes
  std::vector<std::size_t> roots_;
  MeshContents contents_;
};

}  // namespace

MeshContents readGltf(const MeshSource& source, bool& reads_others) {
  return GltfReader(source, reads_others).run();
}

}  // namespace leeway::robots
