#include "tests/fuzz/text_input.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/support/build_paths.h"
#include "tests/support/folder.h"

namespace leeway::fuzz {

const std::string& scratchFolder() {
  static const Folder folder;
  static const std::string path = folder.path();
  return path;
}

std::string writeInput(const std::string& name, std::span<const std::uint8_t> bytes) {
  const std::string path = scratchFolder() + "/" + name;
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  return path;
}

std::vector<std::string> sourceTexts(const std::vector<std::string>& paths) {
  std::vector<std::string> texts;
  for (const std::string& path : paths) {
    std::string text = readText(leeway::sourceFolder() + "/" + path);
    if (!text.empty()) texts.push_back(std::move(text));
  }
  return texts;
}

std::vector<std::string> sourceTextsUnder(const std::string& folder, const std::string& ending) {
  const std::filesystem::path root = leeway::sourceFolder();
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder, error))
    if (entry.path().string().ends_with(ending))
      paths.push_back(entry.path().lexically_relative(root).string());
  std::sort(paths.begin(), paths.end());
  return sourceTexts(paths);
}

}  // namespace leeway::fuzz
