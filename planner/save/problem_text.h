#pragma once

// Private to planner/: a problem as the text of a problem file.

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// The text of a problem file, and the files that it names.
struct ProblemText {
  std::string text;
  std::vector<std::pair<std::string, std::string>> files;  ///< names, and what is in them
};

/// Returns the text. `files_folder`: where ProblemText::files will be, as the text names it.
/// `nameOf(path)` returns how the text names a file that exists. Throws robots::InputError without
/// a file for what a problem file cannot say, and as loadModel(). O(problem).
ProblemText problemText(const Problem& problem, const std::string& files_folder,
                        const std::function<std::string(const std::string&)>& nameOf,
                        const robots::Stop& stop);

/// Whether a goal's name is "goal", or as "goal 2": files give such names to goals by their places.
bool isGivenByPlace(const std::string& name);

/// Returns the first member of the problem that another one has otherwise: "world.objects[2].X_WO";
/// empty: both ask the same. Names of wishes and by isGivenByPlace(), filters of clouds, texts of
/// warnings, and frames that `other` has besides, are not compared; rotations are to 1e-14.
std::string problemDifference(const Problem& problem, const Problem& other);

}  // namespace leeway::planner
