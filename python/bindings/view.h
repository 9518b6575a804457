#pragma once

#include <string>
#include <utility>

#include "leeway/view/page.h"
#include "python/base/arrays.h"
#include "python/base/released.h"

namespace leeway::python {

/// Calls `write(file, options)`, which writes a page, without the interpreter's lock. A signal and
/// `stop` may end it.
template <typename Write>
void writeView(const py::object& file, const py::object& stop, view::PageOptions options,
               Write&& write) {
  const std::string path = fileName(file, "file");
  Interrupt interrupt(stop);
  options.stop = interrupt.callback();
  interrupt.released([&] { write(path, options); });
}

/// The end of the docstring of every view().
inline constexpr char kViewDoc[] =
    "The file's ending chooses: .html, a page that needs no network; .svg, a picture with three "
    "views. Whole or not at all. `stop()` is asked now and then and ends it with True: "
    "RuntimeError. Raises InputError where the file cannot be written.";

/// result.view() and view().
void defineView(py::module_& module);

}  // namespace leeway::python
