#include "tools/leeway/view/page_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <system_error>

#include "leeway/planner/path_io.h"
#include "leeway/robots/input_error.h"
#include "robots/load/visual_shapes.h"
#include "tools/leeway/support/terminal.h"
#include "tools/view/base/figures.h"
#include "tools/view/base/scene_names.h"
#include "tools/view/document.h"
#include "tools/view/picture.h"

namespace leeway::tools::view {
namespace {

// Sorts the rows. The policy below allows this script alone, by its hash: after a change
//   printf %s "$SCRIPT" | openssl dgst -sha256 -binary | base64
constexpr const char* kSort =
    R"js(document.querySelectorAll("th button").forEach((button, column) => button.addEventListener("click", () => {
  const head = button.parentElement, body = document.querySelector("tbody");
  const down = head.getAttribute("aria-sort") === "ascending";
  document.querySelectorAll("th").forEach((other) => other.removeAttribute("aria-sort"));
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  const key = (row) => { const { v } = row.cells[column].dataset; return v === undefined ? row.cells[column].textContent : v === "" ? Infinity : +v; };
  const order = (a, b) => (typeof a === "number" ? a - b || 0 : a.localeCompare(b, undefined, { numeric: true }));
  const sign = down ? -1 : 1;
  body.append(...[...body.rows].sort((a, b) => sign * order(key(a), key(b))));
}));)js";

constexpr const char* kIndexHead = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src 'self' file:; script-src 'sha256-lkFrXcXiU9I07P9psXTPhHhe0ADVQc8gKEfISAgOPEo='; base-uri 'none'; form-action 'none'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>@TITLE@</title>
<style>
:root { color-scheme: light dark; --line: #d5d8de; --soft: #5b606b; --good: #00704f; --bad: #b3261e; --accent: #0072b2 }
body { font: 14px/1.4 system-ui, "DejaVu Sans", sans-serif; margin: 14px; background: #fff; color: #1c1e24 }
h1 { font-size: 20px; margin: 0 0 4px } p { margin: 0 0 12px; color: var(--soft) }
table { border-collapse: collapse; width: 100% }
th, td { border-bottom: 1px solid var(--line); padding: 4px 8px; text-align: left; vertical-align: middle; overflow-wrap: break-word }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
th { position: sticky; top: 0; background: #fff; white-space: nowrap }
th button { font: inherit; font-weight: 600; border: 0; background: none; color: inherit; padding: 4px 0; cursor: pointer }
th[aria-sort=ascending] button::after { content: " \25b2" } th[aria-sort=descending] button::after { content: " \25bc" }
a { color: var(--accent) }
.place { white-space: normal; color: var(--soft) }
td img { width: 220px; height: 74px; object-fit: contain; display: block; border-radius: 4px }
.soft { color: var(--soft) } .good { color: var(--good) } .bad { color: var(--bad) }
@media (max-width: 760px) { body { margin: 8px } th, td { padding: 4px } .picture, .total { display: none } }
@media (max-width: 480px) { .plan { display: none } td.number { white-space: normal } }
@media (prefers-color-scheme: dark) { :root { --line: #3a3e47; --soft: #a3a9b5; --good: #2fc79a; --bad: #ff8a80; --accent: #56b4e9 } body, th { background: #15171b; color: #eceef2 } }
</style>
</head>
<body>
)";

/// The last two parts of a file's name, without its ending: "shelf/reach". The index may be sent to
/// others, so it does not say where the file is on this machine.
std::string titleOf(const std::string& problem) {
  const std::filesystem::path path = std::filesystem::path(problem).lexically_normal();
  const std::string folder = path.parent_path().filename().string();
  return folder.empty() ? path.stem().string() : folder + "/" + path.stem().string();
}

/// The sum of a plan's times [s]: from compiling to its proof.
double totalOf(const nlohmann::ordered_json& time) {
  double total = 0;
  for (const char* stage : {"compile", "plan", "simplify", "improve", "push", "certify"})
    total += time.value(stage, 0.0);
  return total;
}

/// Escaped text with places for breaks behind the signs that part its words.
std::string breakable(const std::string& text) {
  std::string result;
  for (const char c : text) {
    result += c;
    if (std::string_view("/_-.").find(c) != std::string_view::npos) result += "<wbr>";
  }
  return result;
}

std::string replaced(std::string text, std::string_view word, const std::string& with) {
  return text.replace(text.find(word), word.size(), with);
}

}  // namespace

PageFolder::PageFolder(const std::string& folder) : folder_(folder) {
  if (folder_.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (!std::filesystem::is_directory(folder_))
    throw robots::InputError(folder_, 0, "cannot be made; a folder for pages is expected");
  expectPage(folder_ + "/index.html");
}

FolderPage folderPage(const Subject& subject, bool visual, std::vector<std::string>& warnings) {
  std::optional<robots::VisualShapes> visuals;
  if (visual) {
    visuals = robots::loadVisualShapes(*subject.problem.robot.model);
    warnings.insert(warnings.end(), visuals->left_out.begin(), visuals->left_out.end());
  }
  FolderPage folder_page;
  folder_page.html = page(subject, nullptr, visuals ? &*visuals : nullptr);
  folder_page.svg = pictureSvg(subject, true);
  folder_page.name = subject.problem.name;
  folder_page.verdict = subject.verdict;
  folder_page.good = subject.good;
  // Without the "; " before it.
  if (const std::string moment = obstaclesText(subject.problem);
      subject.decisions.empty() && !moment.empty())
    folder_page.moment = moment.substr(2);
  const auto& [least, world, self] = subject.least;
  if (least.closest_segment >= 0) {
    const Timeline& timeline = subject.timeline;
    const int moment =
        self.clearance.upper < world.clearance.upper ? timeline.least_self : timeline.least_world;
    folder_page.clearance = clearanceText(least.clearance);
    folder_page.clearance_m = least.clearance.lower;
    folder_page.nearest = least.closest_a + " and " + least.closest_b;
    folder_page.time = timeline.moments.at(static_cast<std::size_t>(moment)).time;
  }
  return folder_page;
}

void PageFolder::add(const std::string& problem, const nlohmann::ordered_json& line,
                     const FolderPage& page) {
  if (folder_.empty()) return;
  const std::string title = escaped(titleOf(problem));
  std::string name = breakable(title), picture;
  if (!page.html.empty()) {
    const std::string file = fmt::format("{:04}", ++count_);
    planner::writeFileWhole(fmt::format("{}/{}.html", folder_, file), page.html);
    planner::writeFileWhole(fmt::format("{}/{}.svg", folder_, file), page.svg);
    name = fmt::format("<a href=\"{}.html\">{}</a>", file, breakable(title));
    picture = fmt::format(
        "<a href=\"{0}.html\"><img src=\"{0}.svg\" alt=\"{1}\" loading=\"lazy\"></a>", file, title);
  }
  if (!page.name.empty() && page.name != std::filesystem::path(problem).stem().string())
    name += fmt::format("<br><span class=\"soft\">{}</span>", escaped(page.name));
  ++rows_count_;
  good_ += page.good ? 1 : 0;
  const auto milliseconds = [](double seconds) {
    return fmt::format("data-v=\"{}\">{:.3g} ms", seconds, seconds * 1e3);
  };
  std::string plan = "data-v=\"\">", total = "data-v=\"\">";
  if (line.contains("time_s") && line["time_s"].is_object()) {
    plan_s_ += line["time_s"].value("plan", 0.0);
    total_s_ += totalOf(line["time_s"]);
    plan = milliseconds(line["time_s"].value("plan", 0.0));
    total = milliseconds(totalOf(line["time_s"]));
  }
  std::string verdict =
      escaped(page.html.empty() ? line.value("status", std::string("error")) : page.verdict);
  if (page.good && !page.moment.empty())
    verdict += fmt::format("<div class=\"place\">{}</div>", escaped(page.moment));
  const std::string clearance =
      page.clearance.empty()
          ? "data-v=\"\">"
          : fmt::format(
                "data-v=\"{}\">{}<div class=\"place\">{},<br><a href=\"{:04}.html#t={}\">"
                "at {:.2f} s</a></div>",
                page.clearance_m, escaped(page.clearance), escaped(page.nearest), count_, page.time,
                page.time);
  rows_ += fmt::format(
      "<tr><td>{}</td><td class=\"{}\">{}</td><td class=\"number\" {}</td>"
      "<td class=\"number plan\" {}</td><td class=\"number total\" {}</td>"
      "<td class=\"picture\">{}</td></tr>\n",
      name, page.good ? "good" : "bad", verdict, clearance, plan, total, picture);
}

void PageFolder::finish() const {
  if (folder_.empty()) return;
  const std::string plans = counted(static_cast<std::size_t>(rows_count_), "plan");
  const std::string head = replaced(kIndexHead, "@TITLE@", "Leeway: " + plans);
  planner::writeFileWhole(
      folder_ + "/index.html",
      head +
          fmt::format(
              "<h1>Plans of leeway batch</h1>\n"
              "<p>{}, {} certified, {} not; {:.3g} s of planning, {:.3g} s in all. A click on a "
              "heading sorts.</p>\n<main>\n<table>\n<thead><tr><th><button>Problem</button></th>"
              "<th><button>Result</button></th><th class=\"number\"><button>Clearance</button></th>"
              "<th class=\"number plan\"><button>Plan</button></th>"
              "<th class=\"number total\"><button>In all</button></th>"
              "<th class=\"picture\"></th></tr></thead>\n<tbody>\n",
              plans, good_, rows_count_ - good_, plan_s_, total_s_) +
          rows_ + "</tbody>\n</table>\n</main>\n<script>" + kSort +
          "</script>\n</body>\n</html>\n");
}

}  // namespace leeway::tools::view
