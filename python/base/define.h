#pragma once

// Definition of functions, methods and properties, with signatures that Python reads and one-line
// errors.

#include <pybind11/pybind11.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

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

/// The parameters of a function as its signature names them, with the defaults that stand there:
/// pybind11 takes them from here. Empty for a signature with **, whose function reads its arguments
/// itself. Must outlive the definition of the function.
class Parameters {
 public:
  explicit Parameters(const std::string& signature);
  /// Adds them to the record of a function. Throws std::logic_error if it takes another
  /// number of arguments.
  void addTo(py::detail::function_record& record) const;

 private:
  struct Parameter {
    std::string name;
    py::object value;  ///< null: none
  };
  std::vector<Parameter> all_;
  std::size_t positional_ = 0;  ///< those before "*"
};

}  // namespace leeway::python

namespace pybind11::detail {
template <>
struct process_attribute<leeway::python::Parameters>
    : process_attribute_default<leeway::python::Parameters> {
  static void init(const leeway::python::Parameters& parameters, function_record* record) {
    parameters.addTo(*record);
  }
};
}  // namespace pybind11::detail

namespace leeway::python {

/// scope.def() of a function or method. `signature` in Python's notation, "(self, q=None)".
template <typename Scope, typename Function, typename... Extra>
void define(Scope& scope, const char* name, const std::string& signature, const std::string& doc,
            Function&& function, const Extra&... extra) {
  const std::string text = withSignature(name, signature, doc);
  scope.def(name, std::forward<Function>(function), Parameters(signature), extra..., text.c_str());
  shortenErrors(scope.attr(name), name + signature);
}

/// A constructor. `signature` is that of the class, without self; the docstring of the class
/// explains it.
template <typename Class, typename Factory>
void defineInit(Class& scope, const std::string& signature, Factory factory) {
  const std::string own = signature == "()" ? "(self)" : "(self, " + signature.substr(1);
  const std::string text = withSignature("__init__", own, "See the class.");
  scope.def(py::init(std::move(factory)), Parameters(signature), text.c_str());
  const auto name = scope.attr("__name__").template cast<std::string>();
  shortenErrors(scope.attr("__init__"), name + signature);
}

/// A class whose constructor is `factory`.
template <typename Class>
Class defineClass(py::module_& module, const char* name, const std::string& signature,
                  const std::string& doc, auto factory) {
  Class made(module, name, withSignature(name, signature, doc).c_str());
  defineInit(made, signature, std::move(factory));
  return made;
}

template <typename Class, typename Function>
void defineStatic(Class& scope, const char* name, const std::string& signature,
                  const std::string& doc, Function&& function) {
  const std::string text = withSignature(name, signature, doc);
  scope.def_static(name, std::forward<Function>(function), Parameters(signature), text.c_str());
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
/// change of a copy would be lost. `getter`: a function, or a member.
template <typename Class, typename Getter>
void defineConstant(Class& scope, const char* name, Getter getter, const char* doc) {
  if constexpr (std::is_member_object_pointer_v<Getter>) {
    defineConstant(
        scope, name, [getter](const typename Class::type& self) { return self.*getter; }, doc);
  } else {
    const py::cpp_function get(std::move(getter), py::is_method(scope));
    scope.def_property_readonly(
        name, [get](const py::object& self) { return constant(get(self)); }, doc);
  }
}

/// Defines constants of what a class holds: the function that it returns takes their name, a member
/// or a function of what is held, and the docstring.
template <typename Class, typename Held>
auto constantsOf(Class& scope, Held Class::type::*held) {
  return [&scope, held](const char* name, auto get, const char* doc) {
    defineConstant(
        scope, name,
        [held, get](const typename Class::type& self) { return std::invoke(get, self.*held); },
        doc);
  };
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
