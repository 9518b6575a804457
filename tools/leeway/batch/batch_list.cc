#include "tools/leeway/batch/batch_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "leeway/robots/input_error.h"
#include "planner/yaml/yaml_reader.h"
#include "robots/base/read_file.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {
namespace {

namespace fs = std::filesystem;

bool isYaml(const fs::path& path) {
  const std::string ending = robots::endingOf(path.string());
  return ending == ".yaml" || ending == ".yml";
}

/// All files below a folder for which `isOf` holds, sorted by path. Names links that lead to none.
std::vector<fs::path> filesBelow(const fs::path& folder, bool (*isOf)(const fs::path&)) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    std::error_code error;  // of a link that leads to itself
    if (entry.is_regular_file(error) && isOf(entry.path()))
      files.push_back(entry.path());
    else if (entry.is_symlink() && entry.is_directory(error))
      printMessage(entry.path().string() + ": left out, links to folders are not followed");
    else if (entry.is_symlink() && !entry.exists(error) && isOf(entry.path()))
      printMessage(entry.path().string() + ": left out, it is a link to " +
                   fs::read_symlink(entry.path()).string() + ", which does not exist");
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool isJson(const fs::path& path) { return robots::endingOf(path.string()) == ".json"; }

bool mayBeProblem(const fs::path& path) { return isProblemName(path.string()); }

/// Whether a file in a folder is a problem: it has the key `leeway`, or the section [problem] of a
/// file of OMPL.app. Of a file that is no YAML, which planning will tell, a line has to begin so.
bool isProblemFile(const fs::path& file) {
  const bool is_cfg = !isYaml(file) && !isJson(file);
  if (!is_cfg) try {
      const planner::YamlReader root = planner::YamlReader::load(file.string());
      return root.isMap() && root.has("leeway");
    } catch (const robots::InputError&) {
    }
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  std::string_view rest = text;
  while (!rest.empty())
    if (robots::takeLine(rest).starts_with(is_cfg ? "[problem]" : "leeway:")) return true;
  return false;
}

void requireExists(const std::string& input) {
  if (fs::exists(input)) return;
  throw robots::InputError(input, 0,
                           fs::is_symlink(input)
                               ? "is a link to " + fs::read_symlink(input).string() +
                                     ", which does not exist; a file or folder is expected"
                               : "there is no such file or folder");
}

/// The kind and number in a file name: "scene0042.yaml" is scene 42.
struct NumberedName {
  enum class Kind { kScene, kRequest, kOther } kind = Kind::kOther;
  long number = -1;
};

NumberedName parseName(const fs::path& path) {
  const std::string stem = path.stem().string();
  NumberedName name;
  if (stem.starts_with("scene")) {
    name.kind = NumberedName::Kind::kScene;
  } else if (stem.starts_with("request")) {
    name.kind = NumberedName::Kind::kRequest;
  }
  std::size_t first = stem.size();
  while (first > 0 && std::isdigit(static_cast<unsigned char>(stem[first - 1])) != 0) {
    --first;
  }
  const char* end = stem.data() + stem.size();
  if (std::from_chars(stem.data() + first, end, name.number).ec != std::errc()) {
    name.kind = NumberedName::Kind::kOther;
  }
  return name;
}

/// The pairs of one folder, by number.
using Folder = std::map<long, BatchItem>;

void addToFolder(Folder& folder, const fs::path& file, const NumberedName& name) {
  BatchItem& item = folder[name.number];
  std::string& place = name.kind == NumberedName::Kind::kScene ? item.problem : item.request;
  if (!place.empty() && place != file.string()) {
    item.error = fmt::format("{} and {} have the same number", place, file.string());
    return;
  }
  place = file.string();
}

void appendFolder(const Folder& folder, std::vector<BatchItem>& items) {
  for (const auto& [number, pair] : folder) {
    BatchItem item = pair;
    if (item.problem.empty()) {
      item.problem = item.request;
      item.error =
          fmt::format("{}: there is no scene with number {} beside it", item.request, number);
    } else if (item.request.empty()) {
      item.error =
          fmt::format("{}: there is no request with number {} beside it", item.problem, number);
    }
    items.push_back(item);
  }
}

/// Pairs a scene that was given by name with the request of its number in its folder.
BatchItem pairScene(const fs::path& scene) {
  const NumberedName wanted = parseName(scene);
  if (wanted.kind != NumberedName::Kind::kScene) {
    throw robots::InputError(scene.string(), 0,
                             "is not named like a scene; sceneNNNN.yaml files and folders of them "
                             "are accepted with --robot");
  }
  const fs::path parent = scene.has_parent_path() ? scene.parent_path() : fs::path(".");
  Folder folder;
  addToFolder(folder, scene, wanted);
  for (const auto& entry : fs::directory_iterator(parent)) {
    const NumberedName name = parseName(entry.path());
    if (isYaml(entry.path()) && name.kind == NumberedName::Kind::kRequest &&
        name.number == wanted.number) {
      addToFolder(folder, entry.path(), name);
    }
  }
  std::vector<BatchItem> items;
  appendFolder(folder, items);
  return items.front();
}

/// Parses "i/N" with 0 <= i <= N. Returns false for any other text.
bool parseShard(const std::string& text, std::size_t& index, std::size_t& count) {
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, index);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '/') {
    return false;
  }
  const auto second = std::from_chars(first.ptr + 1, end, count);
  return second.ec == std::errc() && second.ptr == end && count > 0 && index <= count;
}

/// Keeps each problem once, even if its file is given several times or under several names.
std::vector<BatchItem> withoutRepeats(std::vector<BatchItem> items) {
  std::set<fs::path> seen;
  std::erase_if(items, [&](const BatchItem& item) {
    const bool repeated = !seen.insert(fs::weakly_canonical(item.problem)).second;
    if (repeated) {
      printMessage(item.problem + ": left out, it is in the list already");
    }
    return repeated;
  });
  return items;
}

}  // namespace

std::vector<BatchItem> listProblems(const std::vector<std::string>& inputs) {
  std::vector<BatchItem> items;
  for (const std::string& input : inputs) {
    requireExists(input);
    if (!fs::is_directory(input)) {
      items.push_back({input, "", ""});
      continue;
    }
    const auto files = filesBelow(input, mayBeProblem);
    if (files.empty()) {
      throw robots::InputError(input, 0, "there is no .yaml, .json or .cfg file in this folder");
    }
    for (const fs::path& file : files) {
      if (isProblemFile(file)) {
        items.push_back({file.string(), "", ""});
      } else if (!isJson(file)) {  // most of these are results
        printMessage(fmt::format("{}: left out, it has no {} and so is no problem file",
                                 file.string(), isYaml(file) ? "key 'leeway'" : "[problem]"));
      }
    }
  }
  return withoutRepeats(std::move(items));
}

std::vector<BatchItem> listMoveitProblems(const std::vector<std::string>& inputs) {
  std::vector<BatchItem> items;
  for (const std::string& input : inputs) {
    requireExists(input);
    if (!fs::is_directory(input)) {
      items.push_back(pairScene(input));
      continue;
    }
    std::map<fs::path, Folder> folders;
    for (const fs::path& file : filesBelow(input, isYaml)) {
      const NumberedName name = parseName(file);
      if (name.kind != NumberedName::Kind::kOther) {
        addToFolder(folders[file.parent_path()], file, name);
      }
    }
    if (folders.empty()) {
      throw robots::InputError(
          input, 0, "there is no sceneNNNN.yaml with its requestNNNN.yaml in this folder");
    }
    for (const auto& [path, folder] : folders) {
      appendFolder(folder, items);
    }
  }
  return withoutRepeats(std::move(items));
}

std::vector<BatchItem> selectShard(const std::vector<BatchItem>& items, const std::string& shard) {
  std::size_t index = 0;
  std::size_t count = 0;
  if (!parseShard(shard, index, count)) {
    throw robots::InputError("command line", 0,
                             fmt::format("--shard '{}' is not i/N, such as 1/4 to 4/4", shard));
  }
  std::vector<BatchItem> selected;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if ((i + 1) % count == index % count) {
      selected.push_back(items[i]);
    }
  }
  return selected;
}

}  // namespace leeway::tools
