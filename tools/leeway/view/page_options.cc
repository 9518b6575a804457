#include "tools/leeway/view/page_options.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <optional>

#include "leeway/planner/path_io.h"
#include "robots/load/visual_shapes.h"
#include "tools/leeway/support/problem_source.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools::view {
namespace {

/// Shows a file in the desktop's browser. Does not use a shell, because the name may contain
/// anything.
void openFile(const std::string& file) {
  std::string program = "xdg-open", name = std::filesystem::absolute(file).string();
  char* arguments[] = {program.data(), name.data(), nullptr};
  pid_t child = 0;
  int status = 0;
  const bool started =
      ::posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments, environ) == 0;
  if (!started || ::waitpid(child, &status, 0) < 0 || status != 0)
    printMessage(file + ": could not be opened with xdg-open; open it in a browser");
}

}  // namespace

void addPageOptions(CLI::App& app, PageChoice& choice) {
  CLI::Option* view =
      app.add_option("--view", choice.file, "also write a page to look at")->type_name("FILE.html");
  app.add_flag("--open", choice.open, "show the page in the browser")->needs(view);
  addVisual(app, choice.visual)->needs(view);
}

CLI::Option* addVisual(CLI::App& app, bool& visual) {
  return app.add_flag("--visual", visual,
                      "the page also draws the robot's visual shapes, which are not checked");
}

void writePage(const PageChoice& choice, const Subject& subject, const Subject* compared) {
  std::optional<robots::VisualShapes> visuals;
  if (choice.visual) {
    visuals = robots::loadVisualShapes(*subject.problem.robot.model);
    printWarnings(visuals->left_out);
  }
  planner::writeFileWhole(choice.file, page(subject, compared, visuals ? &*visuals : nullptr));
  if (choice.open) openFile(choice.file);
}

}  // namespace leeway::tools::view
