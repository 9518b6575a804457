#include "python/base/define.h"

#include <string>
#include <unordered_map>
#include <variant>

namespace leeway::python {
namespace {

/// pybind11's own entry point, which all functions share.
PyCFunctionWithKeywords dispatcher = nullptr;

/// The signature that errors show for a function, by the object that CPython passes to its entry
/// point. Never freed, because functions outlive static objects.
std::unordered_map<const PyObject*, std::string>& signatures() {
  static auto* const map = new std::unordered_map<const PyObject*, std::string>;
  return *map;
}

/// The types of the arguments: "int, time=str".
std::string given(PyObject* args, PyObject* kwargs) {
  std::string text;
  const auto add = [&](const std::string& name, PyObject* value) {
    text += (text.empty() ? "" : ", ") + name + Py_TYPE(value)->tp_name;
  };
  for (Py_ssize_t i = 0; i < PyTuple_GET_SIZE(args); ++i) add("", PyTuple_GET_ITEM(args, i));
  PyObject *key = nullptr, *value = nullptr;
  for (Py_ssize_t at = 0; kwargs != nullptr && PyDict_Next(kwargs, &at, &key, &value) != 0;)
    add(py::str(key).cast<std::string>() + "=", value);
  return text;
}

PyObject* dispatch(PyObject* self, PyObject* args, PyObject* kwargs) {
  PyObject* const result = dispatcher(self, args, kwargs);
  if (result != nullptr || PyErr_ExceptionMatches(PyExc_TypeError) == 0) return result;
  PyObject *type = nullptr, *value = nullptr, *trace = nullptr;
  PyErr_Fetch(&type, &value, &trace);
  const std::string text = value != nullptr ? py::str(value).cast<std::string>() : "";
  if (text.find("incompatible function arguments") == std::string::npos &&
      text.find("incompatible constructor arguments") == std::string::npos) {
    PyErr_Restore(type, value, trace);
    return nullptr;
  }
  Py_XDECREF(type);
  Py_XDECREF(value);
  Py_XDECREF(trace);
  const auto found = signatures().find(self);
  PyErr_Format(PyExc_TypeError, "%s is expected; given: %s",
               found != signatures().end() ? found->second.c_str() : "another call",
               given(args, kwargs).c_str());
  return nullptr;
}

}  // namespace

bool isKeyword(const planner::Setting& setting) {
  return !setting.name.empty() &&
         !std::holds_alternative<planner::PlannerParameterSetting>(setting.value);
}

std::string withSignature(const std::string& name, const std::string& signature,
                          const std::string& doc) {
  static const std::string kAll = "**settings";
  std::string whole = signature;
  if (const std::size_t at = whole.find(kAll); at != std::string::npos) {
    std::string keywords;
    for (const planner::Setting& setting : planner::settings()) {
      const std::string keyword = std::string(setting.name) + "=";
      if (isKeyword(setting) && signature.find(" " + keyword) == std::string::npos)
        keywords += (keywords.empty() ? "" : ", ") + keyword + "...";
    }
    const bool has_star = signature.find("*, ") < at;
    whole.replace(at, kAll.size(), (has_star ? "" : "*, ") + keywords);
  }
  return name + whole + "\n--\n\n" + doc;
}

void shortenErrors(py::handle function, const std::string& signature) {
  PyObject* const plain = PyInstanceMethod_Check(function.ptr())
                              ? reinterpret_cast<PyInstanceMethodObject*>(function.ptr())->func
                              : function.ptr();
  auto* const entry = reinterpret_cast<PyCFunctionObject*>(plain);
  signatures()[entry->m_self] = signature;
  void* const current = reinterpret_cast<void*>(entry->m_ml->ml_meth);
  if (current == reinterpret_cast<void*>(&dispatch)) return;
  dispatcher = reinterpret_cast<PyCFunctionWithKeywords>(current);
  entry->m_ml->ml_meth = reinterpret_cast<PyCFunction>(reinterpret_cast<void*>(&dispatch));
}

}  // namespace leeway::python
