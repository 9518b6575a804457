#include "leeway/planner/save_problem.h"

#include <fmt/format.h>
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): mkdtemp()

#include <filesystem>
#include <system_error>

#include "leeway/planner/path_io.h"
#include "planner/save/problem_text.h"
#include "robots/base/read_file.h"

namespace leeway::planner {
namespace {

namespace fs = std::filesystem;
using robots::InputError;

/// A folder that is gone at the end.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const fs::path& beside) : path_((beside / ".leeway-XXXXXX").string()) {
    if (::mkdtemp(path_.data()) == nullptr)
      throw InputError(beside.string(), 0,
                       "is no folder that files can be written into; one is expected");
  }
  ~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path path() const { return path_; }

 private:
  std::string path_;
};

/// How a file in `folder` names a path: relative below the folder, so that both can be moved.
std::string nameIn(const fs::path& folder, const std::string& path) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  const fs::path relative = whole.lexically_relative(folder);
  const bool is_below = !relative.empty() && *relative.begin() != "..";
  return (is_below ? relative : whole).string();
}

void writeAll(const fs::path& folder, const std::string& name, const ProblemText& text,
              const std::string& files_folder) {
  if (!text.files.empty()) {
    std::error_code error;
    fs::create_directories(folder / files_folder, error);
    if (error)
      throw InputError(
          (folder / files_folder).string(), 0,
          fmt::format("cannot be made: {}; a writable folder is expected", error.message()));
  }
  for (const auto& [file, content] : text.files)
    writeFileWhole((folder / files_folder / file).string(), content);
  writeFileWhole((folder / name).string(), text.text);
}

/// Loads what was written, and compares.
void expectSame(const Problem& problem, const std::string& written, const std::string& file,
                const robots::Stop& stop) {
  ProblemOptions options;
  options.load.stop = stop;
  options.load.cache = problem.robot.model->cache;
  std::string difference;
  try {
    difference = problemDifference(problem, loadProblem(written, options));
  } catch (const InputError& error) {
    throw InputError(
        file, 0, fmt::format("is not written, because it would not be accepted: {}", error.what()));
  }
  if (!difference.empty())
    throw InputError(file, 0,
                     fmt::format("is not written, because {} would come back as another one; files "
                                 "cannot say all that programs can (problems/README.md)",
                                 difference));
}

}  // namespace

void saveProblem(const Problem& problem, const std::string& file, const robots::Stop& stop) {
  if (const std::string ending = robots::endingOf(file); ending != ".yaml" && ending != ".yml")
    throw InputError(file, 0,
                     fmt::format("has the ending '{}'; .yaml or .yml is expected", ending));
  validate(problem);
  problem.robot.model->expectMeshes();
  const fs::path path = fs::absolute(file).lexically_normal(), folder = path.parent_path();
  if (std::error_code error; !fs::is_directory(folder, error))
    throw InputError(file, 0, "is in a folder that does not exist; an existing one is expected");
  const std::string files_folder = path.stem().string() + ".files";
  const auto textOf = [&](const fs::path& in) {
    const auto nameOf = [&](const std::string& named) { return nameIn(in, named); };
    try {
      return problemText(problem, files_folder, nameOf, stop);
    } catch (const InputError& error) {
      if (!error.file().empty()) throw;
      throw InputError(file, 0, fmt::format("is not written: {}", error.what()));
    }
  };
  {
    const TemporaryFolder trial(folder);
    writeAll(trial.path(), path.filename().string(), textOf(trial.path()), files_folder);
    expectSame(problem, (trial.path() / path.filename()).string(), file, stop);
  }
  writeAll(folder, path.filename().string(), textOf(folder), files_folder);
}

}  // namespace leeway::planner
