#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace leeway::tools {

// All texts are made from the definitions that parse the command line, so that they are never out
// of date. `app`: the command with its verbs.

/// The page leeway(1) in roff's man macros: every verb with its options and examples.
std::string manPage(const CLI::App& app, const std::string& version);

// Completion of verbs, options, and those values that have names or are files.
std::string bashCompletion(const CLI::App& app);
std::string zshCompletion(const CLI::App& app);
std::string fishCompletion(const CLI::App& app);

/// The kind of value that an option or positional argument expects.
struct ValueKind {
  bool takes_value = false;          ///< false: a flag
  bool file = false;                 ///< a file or folder
  std::vector<std::string> choices;  ///< the only words allowed; empty: any
  std::string name;                  ///< shown to people: "FILE", "length|clearance"
};
ValueKind valueKind(const CLI::Option& option);

/// The options of a verb that have a long name, in the order of its help, and its positional
/// arguments.
std::vector<const CLI::Option*> longOptions(const CLI::App& verb);
std::vector<const CLI::Option*> positionals(const CLI::App& verb);

}  // namespace leeway::tools
