#pragma once

#include <string>
#include <utility>
#include <vector>

#include "leeway/view/page.h"
#include "python/base/arrays.h"
#include "python/base/released.h"
#include "python/base/warn.h"

namespace leeway::python {

/// Calls `write(file, options)`, which writes a page, without the interpreter's lock. A signal and
/// `stop` may end it. Visual shapes that are left out become warnings.
template <typename Write>
void writeView(const py::object& file, const py::object& stop, view::PageOptions options,
               Write&& write) {
  const std::string path = fileName(file, "file");
  Interrupt interrupt(stop);
  options.stop = interrupt.callback();
  std::vector<std::string> warnings;
  options.warnings = &warnings;
  interrupt.released([&] { write(path, options); });
  for (const std::string& warning : warnings) warn(warning);
}

/// The end of the docstring of every view().
inline constexpr char kViewDoc[] =
    "The file's ending chooses: .html, a page that needs no network; .svg, a picture with three "
    "views. Whole or not at all. `visual`: the page also draws the visual shapes of the robot's "
    "file, which are not what is proven; those that cannot be read are left out with a "
    "UserWarning. `stop()` is asked now and then and ends it with True: "
    "RuntimeError. Raises InputError where the file cannot be written.";

/// result.view() and view().
void defineView(py::module_& module);

}  // namespace leeway::python
