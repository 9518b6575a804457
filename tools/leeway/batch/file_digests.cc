#include "tools/leeway/batch/file_digests.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "leeway/robots/input_error.h"
#include "leeway/robots/model.h"
#include "robots/base/fnv.h"
#include "robots/base/read_file.h"
#include "robots/mesh/mesh_path.h"

namespace leeway::tools {

namespace fs = std::filesystem;

std::string FileDigests::ofBytes(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  const robots::FileStamp stamp = robots::FileStamp::of(path);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known = known_.find(path);
    if (known != known_.end() && known->second.stamp == stamp) return known->second.digest;
  }
  std::ifstream in(path, std::ios::binary);
  std::uint64_t sum = robots::fnv1a({});
  std::array<char, 1U << 16U> part;
  while (in.read(part.data(), part.size()) || in.gcount() > 0)
    sum = robots::fnv1a({part.data(), static_cast<std::size_t>(in.gcount())}, sum);
  std::string digest = fmt::format("{:016x}", sum);
  const std::lock_guard<std::mutex> lock(mutex_);
  known_[path] = {stamp, digest};
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

Json FileDigests::of(const robots::FilesRead& read) {
  Json digests = Json::object();
  for (const auto& [path, stamp] : read.files()) {
    std::string digest = of(path);
    if (digest.empty()) continue;
    if (robots::FileStamp::of(path) != stamp)
      throw robots::InputError(path, 0,
                               "was changed while it was read; a file that stays is expected");
    digests[path] = std::move(digest);
  }
  return digests;
}

namespace {

bool isStillFound(const Json& entry) {
  try {
    const auto textAt = [&](const char* key) { return entry.at(key).get<std::string>(); };
    robots::LoadOptions options;
    entry.at("packages").get_to(options.packages);
    return robots::resolveFile(textAt("uri"), "file", textAt("from"), 0, options) == textAt("file");
  } catch (const robots::InputError&) {
    return false;
  } catch (const Json::exception&) {
    return false;
  }
}

}  // namespace

bool FileDigests::areStillFound(const Json& found) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return found.is_array() && std::all_of(found.begin(), found.end(), [&](const Json& entry) {
           const auto [known, is_new] = found_.try_emplace(entry.dump());
           if (is_new) known->second = isStillFound(entry);
           return known->second;
         });
}

Json foundJson(const robots::FilesRead& read) {
  Json all = Json::array();
  for (const robots::FilesRead::Found& found : read.found())
    all.push_back({{"uri", found.uri},
                   {"from", found.from},
                   {"packages", found.packages},
                   {"file", found.file}});
  return all;
}

}  // namespace leeway::tools
