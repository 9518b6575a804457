#include "python/base/define.h"

#include <pybind11/eval.h>

#include <algorithm>
#include <stdexcept>
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

Parameters::Parameters(const std::string& signature) {
  if (signature.find("**") != std::string::npos) return;
  std::size_t depth = 0, begin = 1;
  for (std::size_t end = 1; end < signature.size(); ++end) {
    const char c = signature[end];
    depth += c == '(' || c == '[' ? 1 : 0;
    const bool is_end = depth == 0 && (c == ',' || c == ')');
    depth -= depth > 0 && (c == ')' || c == ']') ? 1 : 0;
    if (!is_end) continue;
    const std::string text = signature.substr(begin, end - begin);
    begin = std::min(signature.size(), end + 2);  // after ", "
    const std::size_t equals = std::min(text.find('='), text.size());
    const std::string name = text.substr(0, equals), value = text.substr(equals);
    if (name == "*") positional_ = all_.size();
    if (name.empty() || name == "self" || name == "*") continue;
    all_.push_back({name, {}});
    if (value == "=None")
      all_.back().value = py::none();
    else if (!value.empty())
      all_.back().value = py::eval(value.substr(1), py::dict());
  }
  if (signature.find("*, ") == std::string::npos) positional_ = all_.size();
}

void Parameters::addTo(py::detail::function_record& record) const {
  if (all_.empty()) return;
  if (record.is_method && record.args.empty())
    record.args.emplace_back("self", nullptr, py::handle(), true, false);
  if (record.args.size() + all_.size() != record.nargs_pos)
    throw std::logic_error("a signature with " + std::to_string(all_.size()) +
                           " parameters, from " + all_.front().name + " on, for a function of " +
                           std::to_string(record.nargs_pos) + " arguments");
  record.nargs_pos = static_cast<std::uint16_t>(record.args.size() + positional_);
  for (const Parameter& parameter : all_)
    record.args.emplace_back(parameter.name.c_str(), nullptr, parameter.value.inc_ref(), true,
                             true);
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
