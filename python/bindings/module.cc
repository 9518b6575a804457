// The module leeway._leeway, from which the package leeway takes all names.

#include "leeway/robots/input_error.h"
#include "python/base/define.h"
#include "python/base/released.h"
#include "python/bindings/deforming.h"
#include "python/bindings/plan.h"
#include "python/bindings/problem.h"
#include "python/bindings/robot.h"
#include "python/bindings/scene.h"
#include "python/bindings/settings.h"
#include "python/bindings/shapes.h"
#include "python/bindings/world.h"

namespace leeway::python {

void defineReplanner(py::module_& module);
void defineGuard(py::module_& module);
void defineMonitor(py::module_& module);
void definePlanWhere(py::module_& module);
void defineInverse(py::module_& module);
void defineView(py::module_& module);

namespace {

/// InputError: a ValueError with `file` and `line`.
void defineErrors(py::module_& module) {
  static PyObject* const input_error = PyErr_NewExceptionWithDoc(
      "leeway.InputError",
      "Bad input: FILE:LINE: what is wrong, with the value; what would be accepted. Nothing is "
      "half-loaded. `file` is '' and `line` 0 where there is none.",
      PyExc_ValueError, nullptr);
  module.attr("InputError") = py::handle(input_error);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const robots::InputError& error) {
      const py::object value = py::handle(input_error)(py::str(error.what()));
      value.attr("file") = error.file();
      value.attr("line") = error.line();
      PyErr_SetObject(input_error, value.ptr());
    }
  });
}

/// Makes __new__() raise. An object that it alone makes holds nothing, and its methods would read
/// that. CPython refuses __new__() of a base, here pybind11's, for a class with another tp_new.
void refuseNewAlone(const py::module_& module) {
  for (const auto& [name, value] : py::reinterpret_borrow<py::dict>(module.attr("__dict__"))) {
    if (Py_TYPE(value.ptr()) != py::detail::get_internals().default_metaclass) continue;
    reinterpret_cast<PyTypeObject*>(value.ptr())->tp_new = [](PyTypeObject* type, PyObject* args,
                                                              PyObject* kwargs) {
      return py::detail::pybind11_object_new(type, args, kwargs);
    };
  }
}

}  // namespace
}  // namespace leeway::python

PYBIND11_MODULE(_leeway, module) {
  using namespace leeway::python;
  py::options options;
  options.disable_function_signatures();  // define() writes them
  const py::object name = module.attr("__name__");
  module.attr("__name__") = "leeway";  // where users find these names
  module.attr("__version__") = LEEWAY_VERSION;
  defineErrors(module);
  defineShapes(module);
  defineDistances(module);
  defineDeforming(module);
  defineRobot(module);
  defineInverse(module);
  defineWorld(module);
  defineGoals(module);
  defineTasks(module);
  defineProblem(module);
  defineResult(module);
  defineTrajectory(module);
  definePlan(module);
  definePlanWhere(module);
  defineView(module);
  defineScene(module);
  defineReplanner(module);
  defineGuard(module);
  defineMonitor(module);
  refuseNewAlone(module);
  module.attr("__name__") = name;
  defineLifetime(module);
}
