#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include "planner/problem/read_motion.h"
#include "planner/problem/read_shapes.h"
#include "planner/problem/vertex_cache.h"
#include "planner/validate/format_keys.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

using collision::VertexMotion;
using Vertices = std::vector<Eigen::Vector3d>;

/// Frames per second of a PC2 if the problem gives none: the rate of film. (Blender's default is
/// 24, 3ds Max's 30.)
constexpr double kFrameRate = 25;

std::vector<char> fileBytes(const YamlReader& file, const std::string& path) {
  // Opening a folder succeeds, but reading it throws.
  std::ifstream stream;
  if (std::filesystem::is_regular_file(path)) stream.open(path, std::ios::binary);
  std::vector<char> text;
  if (stream.is_open()) text.assign(std::istreambuf_iterator<char>(stream), {});
  if (!stream.is_open() || !stream)
    file.fail(fmt::format("{} names '{}', which cannot be read; a readable file is expected",
                          file.where(), path));
  return text;
}

}  // namespace

std::shared_ptr<const VertexMotion> readCache(const YamlReader& cache, const Vertices& rest) {
  cache.expectKeys(keysOf("cache"));
  if (const auto times = cache.find("times"))
    times->fail(fmt::format("{} goes with 'frames' only", times->where()));
  const YamlReader file = cache.at("file", "a PC2 or MDD file");
  const std::string path = resolvedPath(file);
  const std::string ending = robots::endingOf(path);
  if (ending != ".pc2" && ending != ".mdd")
    file.fail(
        fmt::format("{} has the ending '{}'; .pc2 or .mdd is expected", file.where(), ending));
  const std::vector<char> text = fileBytes(file, path);
  const std::span<const std::byte> bytes = std::as_bytes(std::span<const char>(text));
  const double scale = optionalNumber(cache, "scale", 1);
  const auto rate = cache.find("rate");
  if (rate && ending == ".mdd")
    rate->fail(fmt::format("{} goes with PC2 only: an MDD has times", rate->where()));
  const double frames_per_second = rate ? rate->number() : kFrameRate;
  // Errors in the cache name its file, and the place in the problem file that refers to it.
  const auto namingFile = [&](const auto& read) {
    try {
      return read();
    } catch (const collision::InvalidMotion& error) {
      file.fail(fmt::format("{} names '{}': {}", file.where(), path, error.what()));
    }
  };
  collision::CacheMotion motion = namingFile([&] {
    return ending == ".pc2" ? parsePc2(bytes, frames_per_second, scale) : parseMdd(bytes, scale);
  });
  if (motion.vertex_count != static_cast<int>(rest.size()))
    file.fail(fmt::format("{} has {} vertices; the mesh's {} are expected", file.text(),
                          motion.vertex_count, rest.size()));
  if (const auto start = cache.find("start"); start && !motion.times.empty()) {
    const double shift = start->number() - motion.times.front();
    for (double& time : motion.times) time += shift;
  }
  return namingFile([&] { return VertexMotion::cache(std::move(motion)); });
}

}  // namespace leeway::planner
