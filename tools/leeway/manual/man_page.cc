#include <fmt/format.h>

#include <sstream>

#include "tools/leeway/manual/manual.h"

namespace leeway::tools {
namespace {

/// Escapes a text for roff, so that backslashes, hyphens and leading dots are printed as they are.
std::string escaped(const std::string& text) {
  std::string result;
  bool line_start = true;
  for (const char c : text) {
    if (line_start && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    line_start = c == '\n';
  }
  return result;
}

/// Formats a footer: prose, and examples that are indented by two blanks.
std::string footer(const std::string& text) {
  std::string page;
  std::istringstream in(text);
  bool example = false;
  for (std::string line; std::getline(in, line);) {
    const bool indented = line.starts_with("  ");
    if (indented && !example) page += ".PP\n.nf\n";
    if (!indented && example) page += ".fi\n";
    example = indented;
    if (line.empty()) continue;
    if (!indented) page += ".PP\n";
    page += escaped(line) + "\n";
  }
  return page + (example ? ".fi\n" : "");
}

std::string synopsis(const CLI::App& verb) {
  std::string text = fmt::format("\\fBleeway {}\\fR [options]", verb.get_name());
  for (const CLI::Option* option : positionals(verb)) {
    const std::string name = fmt::format("\\fI{}\\fR", escaped(valueKind(*option).name));
    text += option->get_required() ? " " + name : " [" + name + "]";
  }
  return text;
}

std::string optionEntry(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : option.get_snames()) names += fmt::format("\\fB\\-{}\\fR, ", name);
  names += fmt::format("\\fB\\-\\-{}\\fR", escaped(option.get_lnames().front()));
  const ValueKind kind = valueKind(option);
  if (kind.takes_value) names += fmt::format(" \\fI{}\\fR", escaped(kind.name));
  std::string text = escaped(option.get_description());
  if (!option.get_default_str().empty()) {
    text += fmt::format(" (default: {})", escaped(option.get_default_str()));
  }
  return fmt::format(".TP\n{}\n{}\n", names, text);
}

}  // namespace

std::string manPage(const CLI::App& app, const std::string& version) {
  std::string page = fmt::format(
      ".\\\" Made by `leeway manual man` from the definitions of the command line.\n"
      ".TH LEEWAY 1 \"\" \"leeway {}\" \"User Commands\"\n"
      ".SH NAME\nleeway \\- plans motions of robots and proves how much room they leave\n"
      ".SH SYNOPSIS\n\\fBleeway\\fR \\fIVERB\\fR [\\fIARGUMENTS\\fR]\n"
      ".SH DESCRIPTION\n",
      escaped(version));
  page += footer(app.get_description());
  page += ".SH VERBS\n";
  for (const CLI::App* verb : app.get_subcommands({})) {
    page += fmt::format(".SS {}\n{}\n.PP\n{}\n", escaped(verb->get_name()), synopsis(*verb),
                        escaped(verb->get_description()));
    for (const CLI::Option* option : positionals(*verb)) {
      page += fmt::format(".TP\n\\fI{}\\fR\n{}\n", escaped(valueKind(*option).name),
                          escaped(option->get_description()));
    }
    for (const CLI::Option* option : longOptions(*verb)) page += optionEntry(*option);
    page += footer(verb->get_footer());
  }
  page += footer(app.get_footer());
  page +=
      ".SH EXIT STATUS\n"
      ".TP\n0\nyes: solved, valid, certified\n"
      ".TP\n1\nno: no path within the limits, start or goal invalid, not certified\n"
      ".TP\n2\nbad usage or input; one line on standard error tells what would be accepted\n"
      ".TP\n70\na fault of the program\n"
      ".SH ENVIRONMENT\n"
      ".TP\n.B LEEWAY_CACHE_DIR\nfolder for meshes and robots that were prepared before; empty: "
      "none\n"
      ".TP\n.B ROS_PACKAGE_PATH\nwhere package:// addresses of meshes are looked for\n";
  return page;
}

}  // namespace leeway::tools
