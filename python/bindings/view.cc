#include "python/bindings/view.h"

#include <filesystem>

#include "python/base/define.h"
#include "python/bindings/plan.h"

namespace leeway::python {

namespace {

/// Adds the path to compare, if there is one.
void compareWith(const Problem& problem, const py::object& compare, bool shortest,
                 view::PageOptions& options) {
  if (compare.is_none()) return;
  options.compared = pathOf(problem, compare, shortest);
  if (py::isinstance<py::str>(compare) || py::hasattr(compare, "__fspath__"))
    options.compared_label =
        std::filesystem::path(fileName(compare, "compare")).filename().string();
}

void viewResult(const Result& self, const py::object& file, const py::object& compare, bool visual,
                const py::object& stop) {
  view::PageOptions options;
  options.visual = visual;
  compareWith(Problem(self.problem, true), compare, false, options);
  const Result held = self;
  writeView(file, stop, std::move(options),
            [&](const std::string& path, const view::PageOptions& chosen) {
              view::writePage(path, *held.problem, held.value, chosen);
            });
}

void viewPath(const Problem& problem, const py::object& path, const py::object& file,
              const py::object& compare, bool shortest, bool visual, const py::object& stop) {
  const planner::Path given = pathOf(problem, path, shortest);
  view::PageOptions options;
  options.visual = visual;
  compareWith(problem, compare, shortest, options);
  const std::shared_ptr<const planner::Problem> value = problem.value();
  writeView(file, stop, std::move(options),
            [&](const std::string& name, const view::PageOptions& chosen) {
              view::writePage(name, *value, given, chosen);
            });
}

}  // namespace

void defineView(py::module_& module) {
  auto result = py::reinterpret_borrow<py::class_<Result>>(module.attr("Result"));
  define(result, "view", "(self, file, *, compare=None, visual=False, stop=None)",
         std::string("Writes what `leeway view` shows of this result: the motion and its "
                     "clearance, or why there is no path. `compare`: a second path of the same "
                     "problem, shown beside this one; a Result, an array (n, joints) or a file. ") +
             kViewDoc,
         viewResult);
  define(module, "view",
         "(problem, path, file, *, compare=None, shortest=False, visual=False, stop=None)",
         std::string("Writes what `leeway view` shows of any path. `path`, `compare` and "
                     "`shortest` as for verify(). ") +
             kViewDoc,
         viewPath);
}

}  // namespace leeway::python
