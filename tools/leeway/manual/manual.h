#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace leeway::tools {

// All made from the definitions that parse the command line, so that none of them can be out of
// date. `app`: the command with its verbs.

/// The page leeway(1) in roff's man macros: every verb with its options and examples.
std::string manPage(const CLI::App& app, const std::string& version);

// Completion of verbs, options, and those values that have names or are files.
std::string bashCompletion(const CLI::App& app);
std::string zshCompletion(const CLI::App& app);
std::string fishCompletion(const CLI::App& app);

/// What can stand where an option or positional argument expects its value.
struct ValueKind {
  bool takes_value = false;          ///< false: a flag
  bool file = false;                 ///< a file or folder
  std::vector<std::string> choices;  ///< words; empty: any
  std::string name;                  ///< for people's eyes: "FILE", "length|clearance"
};
ValueKind valueKind(const CLI::Option& option);

/// The options of a verb that have a long name, in the order of its help; positional ones apart.
std::vector<const CLI::Option*> longOptions(const CLI::App& verb);
std::vector<const CLI::Option*> positionals(const CLI::App& verb);

}  // namespace leeway::tools
