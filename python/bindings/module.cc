// The module leeway._leeway, from which the package leeway takes all names.

#include <cctype>
#include <string>

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
#ifdef Py_TPFLAGS_IMMUTABLETYPE
  reinterpret_cast<PyTypeObject*>(input_error)->tp_flags |= Py_TPFLAGS_IMMUTABLETYPE;
#endif
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

/// Refuses changes of a class. `leeway.Problem.margin = 0.1` would replace the property, and all
/// problems would report a margin that nothing checks.
int refuseChange(PyObject* of, PyObject* name, PyObject* value) {
  auto* const type = reinterpret_cast<PyTypeObject*>(of);
  std::string object = type->tp_name;
  object.erase(0, object.rfind('.') + 1);
  object[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(object[0])));
  PyObject* const member = _PyType_Lookup(type, name);
  PyObject* const setter =
      member != nullptr ? PyObject_GetAttrString(member, "fset") : nullptr;  // of a property
  PyErr_Clear();
  if (value != nullptr && setter != nullptr && setter != Py_None)
    PyErr_Format(PyExc_TypeError,
                 "'%U' is set on the class %s; an object of it is expected, as in %s.%U = ...",
                 name, type->tp_name, object.c_str(), name);
  else
    PyErr_Format(PyExc_TypeError, "'%U' of the class %s cannot be set or deleted; it is fixed",
                 name, type->tp_name);
  Py_XDECREF(setter);
  return -1;
}

/// Closes the classes of the module. They cannot be changed, and cannot be bases, because
/// attributes of a derived class would shadow settings. __new__() raises: an object that it alone
/// makes holds nothing, and its methods would read that. CPython refuses __new__() of a base, here
/// pybind11's, for a class with another tp_new.
void closeClasses(const py::module_& module) {
  PyTypeObject* const open = py::detail::get_internals().default_metaclass;
  py::dict members;
  members["__slots__"] = py::tuple();
  members["__module__"] = module.attr("__name__");
  const py::object closed = py::handle(reinterpret_cast<PyObject*>(&PyType_Type))(
      "closed_class", py::make_tuple(py::handle(reinterpret_cast<PyObject*>(open))), members);
  auto* const metaclass = reinterpret_cast<PyTypeObject*>(closed.ptr());
  metaclass->tp_setattro = refuseChange;
  for (const auto& [name, value] : py::reinterpret_borrow<py::dict>(module.attr("__dict__"))) {
    if (Py_TYPE(value.ptr()) != open) continue;
    auto* const type = reinterpret_cast<PyTypeObject*>(value.ptr());
    type->tp_new = [](PyTypeObject* of, PyObject* args, PyObject* kwargs) {
      return py::detail::pybind11_object_new(of, args, kwargs);
    };
    type->tp_flags &= ~static_cast<unsigned long>(Py_TPFLAGS_BASETYPE);
    closed.inc_ref();
    Py_SET_TYPE(value.ptr(), metaclass);
    Py_DECREF(reinterpret_cast<PyObject*>(open));
    PyType_Modified(type);
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
  closeClasses(module);
  module.attr("__name__") = name;
  defineLifetime(module);
}
