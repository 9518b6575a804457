#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "tools/view/document.h"

namespace leeway::tools::view {

/// The options --view, --open and --visual of a verb.
struct PageChoice {
  std::string file;  ///< empty: no page
  bool open = false;
  bool visual = false;  ///< see PageOptions::visual
};
void addPageOptions(CLI::App& app, PageChoice& choice);
/// Only --visual.
CLI::Option* addVisual(CLI::App& app, bool& visual);

/// As expectPage() of the file, if there is one.
inline void expectPage(const PageChoice& choice) {
  if (!choice.file.empty()) expectPage(choice.file);
}
/// Writes the page as a whole. If `open`, also shows it in the user's browser. If `visual`, prints
/// warnings about visual shapes that are left out.
void writePage(const PageChoice& choice, const Subject& subject, const Subject* compared = nullptr);

}  // namespace leeway::tools::view
