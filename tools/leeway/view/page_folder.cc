#include "tools/leeway/view/page_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools::view {
namespace {

// Pictures are drawings in the document itself. The page forbids scripts.
constexpr const char* kIndexHead = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Leeway: plans</title>
<style>
:root { color-scheme: light dark }
body { font: 14px/1.4 system-ui, "DejaVu Sans", sans-serif; margin: 14px; background: #fff; color: #1c1e24 }
h1 { font-size: 18px; margin: 0 0 12px }
main { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 420px), 1fr)); gap: 14px }
a { color: inherit; text-decoration: none; border: 1px solid #8886; border-radius: 8px; padding: 8px; display: block; overflow: hidden; overflow-wrap: anywhere }
a:hover, a:focus-visible { outline: 2px solid #0072b2 }
a > svg { width: 100%; height: auto; display: block }
.good { color: #00704f } .bad { color: #b3261e }
@media (prefers-color-scheme: dark) { body { background: #15171b; color: #eceef2 } .good { color: #2fc79a } .bad { color: #ff8a80 } }
</style>
</head>
<body>
)";

}  // namespace

PageFolder::PageFolder(const std::string& folder) : folder_(folder) {
  if (folder_.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (!std::filesystem::is_directory(folder_))
    throw robots::InputError(folder_, 0, "cannot be made; a folder for pages is expected");
  expectPage(folder_ + "/index.html");
}

FolderPage folderPage(const Subject& subject) {
  return {page(subject),
          fmt::format(
              "<b>{}</b> <span class=\"{}\">{}</span>{}<br>{}{}", escaped(subject.problem.name),
              subject.good ? "good" : "bad", escaped(subject.verdict),
              subject.least.all.closest_segment < 0 ? "" : ", " + escaped(leastText(subject.least)),
              escaped(subject.source), pictureSvg(subject, true)),
          subject.good};
}

void PageFolder::add(const FolderPage& page) {
  if (folder_.empty() || page.html.empty()) return;
  const std::string name = fmt::format("{:04}.html", ++count_);
  planner::writeFileWhole(folder_ + "/" + name, page.html);
  good_ += page.good ? 1 : 0;
  entries_ += fmt::format("<a href=\"{}\">{}</a>\n", name, page.entry);
}

void PageFolder::finish() const {
  if (folder_.empty()) return;
  planner::writeFileWhole(
      folder_ + "/index.html",
      kIndexHead +
          fmt::format("<h1>{}, {} certified</h1>\n<main>\n",
                      counted(static_cast<std::size_t>(count_), "plan"), good_) +
          entries_ + "</main>\n</body>\n</html>\n");
}

}  // namespace leeway::tools::view
