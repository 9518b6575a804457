#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// The numbers that a setting accepts. NaN is always refused.
struct NumberRange {
  double lower = -std::numeric_limits<double>::max();
  double upper = std::numeric_limits<double>::max();
  /// For messages, before "is expected". May hold {}, for `lower`, and a second one, for `upper`.
  /// Empty: the range depends on other settings, and the check has code of its own.
  std::string_view expected = "a finite number";
  bool above = false;               ///< `lower` itself is not accepted
  std::optional<double> none = {};  ///< the value that means: not asked for
};

/// Where a value stands in a problem; null where the problem's objective has no such value. The
/// value's type is that of the setting.
template <class T>
using SettingPlace = T* (*)(Problem&);

/// A setting that is one of several words.
struct WordSetting {
  struct Word {
    std::string_view text;
    int value;
  };
  std::span<const Word> words;
  /// Returns the value of the problem's word; a number that is not in `words` if it has no such
  /// word, below 0 if its objective has no such setting.
  int (*get)(const Problem&);
  /// Takes the value of a word. Without effect where the problem's objective has no such value.
  void (*set)(Problem&, int);
  /// Files and Python programs may give a map in place of a word.
  bool or_map = false;
};

/// A setting of its own on the command line, elsewhere a parameter of the planner by this name.
struct PlannerParameterSetting {
  std::string_view parameter;
};

/// A key of problem files, with the same setting's name in other interfaces. Readers of problem
/// files, the command's options, Python's keywords and attributes, the JSON Schema and the tables
/// of the pages are made from these.
struct Setting {
  /// The keyword and attribute in Python, which parameters of planners do not have there. Empty:
  /// only files have the key.
  std::string_view name;
  /// The place in problem files: "limits.time". Empty: only programs have the setting.
  std::string_view key;
  /// The option of the command: "--time", or "--no-push" to switch something off. Empty: none.
  std::string_view option = {};
  /// "m", "s"; empty: none.
  std::string_view unit = {};
  /// monostate: files and programs have code of their own for it.
  std::variant<std::monostate, SettingPlace<bool>, SettingPlace<double>, SettingPlace<std::int64_t>,
               SettingPlace<std::uint64_t>, SettingPlace<std::string>,
               SettingPlace<std::map<std::string, std::string>>,
               SettingPlace<std::map<std::string, double>>,  // by variable, or one for all
               WordSetting, PlannerParameterSetting>
      value = {};
  /// For numbers, also those by variable. Whole numbers need a lower end.
  NumberRange range = {};
  /// Explains the setting in sentences, the last one without its period.
  std::string_view help = {};
  /// The name in messages about a program's problem. Empty: `key`.
  std::string_view member = {};

  /// The objective that has it, "clearance"; empty: every one.
  std::string_view objective() const;
  /// Whether a problem may go without a value of it.
  bool isOptional() const;
};

/// All settings. Each comes after those that it depends on: parameters after their planner, a
/// clearance to keep after the objective.
std::span<const Setting> settings();

/// The setting of a name; null: there is none. O(settings).
const Setting* findSetting(std::string_view name);

/// The value of a setting; null where the problem's objective has none.
template <class T>
const T* settingValue(const Problem& problem, SettingPlace<T> place) {
  return place(const_cast<Problem&>(problem));  // nothing is written there
}

/// A setting's default, as text: "0.05", "true", "Connect". Empty: there is none, or `help`
/// explains it.
std::string settingDefault(const Setting& setting);

}  // namespace leeway::planner
