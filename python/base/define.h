#pragma once

// Definition of functions, methods and properties, with signatures that Python reads and one-line
// errors.

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "leeway/planner/settings.h"
#include "python/base/arrays.h"

namespace leeway::python {

namespace py = pybind11;

/// Calls of `function` with arguments that do not fit raise a one-line TypeError instead of
/// pybind11's, which lists C++ types over several lines. The message shows `signature`.
void shortenErrors(py::handle function, const std::string& signature);

/// Whether a setting is a keyword of calls and an attribute of problems. A planner's parameter is
/// not: it is one of `parameters`.
bool isKeyword(const planner::Setting& setting);

/// The docstring that CPython splits into a signature for inspect.signature() and a text.
/// "**settings" in `signature` stands for the keywords of all settings that it does not list.
std::string withSignature(const std::string& name, const std::string& signature,
                          const std::string& doc);

/// scope.def() of a function or method. `signature` in Python's notation, "(self, q)".
template <typename Scope, typename Function, typename... Extra>
void define(Scope& scope, const char* name, const std::string& signature, const std::string& doc,
            Function&& function, const Extra&... extra) {
  const std::string text = withSignature(name, signature, doc);
  scope.def(name, std::forward<Function>(function), extra..., text.c_str());
  shortenErrors(scope.attr(name), name + signature);
}

/// A constructor. `signature` is that of the class, without self; the docstring of the class
/// explains it.
template <typename Class, typename Factory, typename... Extra>
void defineInit(Class& scope, const std::string& signature, Factory factory,
                const Extra&... extra) {
  const std::string own = signature == "()" ? "(self)" : "(self, " + signature.substr(1);
  const std::string text = withSignature("__init__", own, "See the class.");
  scope.def(py::init(std::move(factory)), extra..., text.c_str());
  const auto name = scope.attr("__name__").template cast<std::string>();
  shortenErrors(scope.attr("__init__"), name + signature);
}

template <typename Class, typename Function, typename... Extra>
void defineStatic(Class& scope, const char* name, const std::string& signature,
                  const std::string& doc, Function&& function, const Extra&... extra) {
  const std::string text = withSignature(name, signature, doc);
  scope.def_static(name, std::forward<Function>(function), extra..., text.c_str());
  shortenErrors(scope.attr(name), name + signature);
}

/// copy.copy() and copy.deepcopy(). `copy(self)`: an independent object with the same content.
template <typename Class, typename Copy>
void defineCopies(Class& scope, Copy copy) {
  scope.def("__copy__", copy);
  scope.def("__deepcopy__",
            [copy](typename Class::type& self, const py::object&) { return copy(self); });
}
/// The same for objects that never change: copies are the object itself.
template <typename Class>
void defineCopiesOfConstant(Class& scope) {
  scope.def("__copy__", [](const py::object& self) { return self; });
  scope.def("__deepcopy__", [](const py::object& self, const py::object&) { return self; });
}

/// A property that cannot be set. Its value cannot be changed either, see constant(), because a
/// change of a copy would be lost.
template <typename Class, typename Getter>
void defineConstant(Class& scope, const char* name, Getter&& getter, const char* doc) {
  const py::cpp_function get(std::forward<Getter>(getter), py::is_method(scope));
  scope.def_property_readonly(
      name, [get](const py::object& self) { return constant(get(self)); }, doc);
}

/// A property that can be set.
template <typename Class, typename Getter, typename Setter>
void defineProperty(Class& scope, const char* name, const char* doc, Getter&& getter,
                    Setter&& setter) {
  const py::cpp_function set(std::forward<Setter>(setter), py::is_method(scope));
  shortenErrors(set, name);
  scope.def_property(name, py::cpp_function(std::forward<Getter>(getter), py::is_method(scope)),
                     set, doc);
}

}  // namespace leeway::python
