#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "leeway/robots/input_error.h"
#include "leeway/robots/model.h"
#include "tests/build_paths.h"

namespace leeway::robots::test {

/// A folder for one test, removed afterwards.
class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("leeway_robots_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file.string();
  }
  std::string path(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// Expects a message that begins with FILE:LINE: (FILE: for line 0) and contains all of the words.
template <typename Call>
void expectInputError(const Call& call, const std::string& file, int line,
                      std::initializer_list<std::string> words) {
  try {
    call();
  } catch (const InputError& error) {
    const std::string message = error.what();
    const std::string begin = file + (line > 0 ? ":" + std::to_string(line) : "") + ": ";
    EXPECT_EQ(message.substr(0, begin.size()), begin) << message;
    EXPECT_EQ(error.file(), file);
    EXPECT_EQ(error.line(), line) << message;
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << "no \"" << word << "\" in: " << message;
    return;
  }
  FAIL() << "no InputError; expected one with \"" << (words.size() > 0 ? *words.begin() : "")
         << '"';
}

/// Folder of real robots and problems beside the project; LEEWAY_DATA overrides.
inline std::string dataFolder() {
  const char* chosen = std::getenv("LEEWAY_DATA");
  return chosen != nullptr ? chosen : leeway::sourceFolder() + "/../shared/data";
}

#define LEEWAY_NEEDS_DATA(file)                                                      \
  if (!std::filesystem::exists(::leeway::robots::test::dataFolder() + "/" + (file))) \
  GTEST_SKIP() << "needs " << ::leeway::robots::test::dataFolder() << "/" << (file)

}  // namespace leeway::robots::test
