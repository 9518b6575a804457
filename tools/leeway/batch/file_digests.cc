#include "tools/leeway/batch/file_digests.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "robots/base/read_file.h"

namespace leeway::tools {

namespace fs = std::filesystem;

std::string FileDigests::ofBytes(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  const fs::file_time_type changed = fs::last_write_time(path, error);
  const std::uintmax_t size = fs::file_size(path, error);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known = known_.find(path);
    if (known != known_.end() && known->second.changed == changed && known->second.size == size)
      return known->second.digest;
  }
  std::ifstream in(path, std::ios::binary);
  std::uint64_t hash = 0xcbf29ce484222325U;
  std::array<char, 1U << 16U> part;
  while (in.read(part.data(), part.size()) || in.gcount() > 0)
    for (std::streamsize i = 0; i < in.gcount(); ++i)
      hash =
          (hash ^ static_cast<unsigned char>(part[static_cast<std::size_t>(i)])) * 0x100000001b3U;
  std::string digest = fmt::format("{:016x}", hash);
  const std::lock_guard<std::mutex> lock(mutex_);
  known_[path] = {changed, size, digest};
  return digest;
}

std::string FileDigests::of(const std::string& path) {
  std::string digest = ofBytes(path);
  if (robots::endingOf(path) != ".gltf" || digest.empty()) return digest;
  const fs::path folder = fs::path(path).parent_path();
  std::set<std::string> buffers;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error))
    if (robots::endingOf(entry.path().string()) == ".bin") buffers.insert(entry.path().string());
  for (const std::string& buffer : buffers) digest += " " + ofBytes(buffer);
  return digest;
}

Json FileDigests::of(const std::set<std::string>& paths) {
  Json digests = Json::object();
  for (const std::string& path : paths)
    if (std::string digest = of(path); !digest.empty()) digests[path] = std::move(digest);
  return digests;
}

}  // namespace leeway::tools
