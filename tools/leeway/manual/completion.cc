#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/leeway/manual/manual.h"

namespace leeway::tools {
namespace {

std::vector<std::string> verbNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
  return names;
}

/// Quotes a text for a shell with single quotes.
std::string shellQuoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      result += c;
    }
  }
  return result + "'";
}

/// Escapes words of _arguments and _describe, where brackets and colons have a meaning.
std::string zshText(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
    result += c;
  }
  return result;
}

std::string zshAction(const ValueKind& kind) {
  if (!kind.choices.empty()) return fmt::format("({})", fmt::join(kind.choices, " "));
  return kind.file ? "_files" : " ";
}

}  // namespace

std::string bashCompletion(const CLI::App& app) {
  std::string values;
  std::string options;
  for (const CLI::App* verb : app.get_subcommands({})) {
    std::vector<std::string> names;
    const std::string& verb_name = verb->get_name();
    for (const CLI::Option* option : longOptions(*verb)) {
      names.push_back("--" + option->get_lnames().front());
      const ValueKind kind = valueKind(*option);
      if (!kind.takes_value) continue;
      const char* action = kind.file ? "_leeway_files" : "_leeway_words";
      values += fmt::format(
          "    {}) {} {}; return ;;\n", shellQuoted(verb_name + " " + names.back()), action,
          kind.file ? "" : shellQuoted(fmt::format("{}", fmt::join(kind.choices, " "))));
    }
    std::vector<std::string> words;
    for (const CLI::Option* option : positionals(*verb)) {
      const ValueKind kind = valueKind(*option);
      words.insert(words.end(), kind.choices.begin(), kind.choices.end());
    }
    options += fmt::format("    {}) options={} words={} ;;\n", verb_name,
                           shellQuoted(fmt::format("{}", fmt::join(names, " "))),
                           shellQuoted(fmt::format("{}", fmt::join(words, " "))));
  }
  const std::string verbs = shellQuoted(fmt::format("{}", fmt::join(verbNames(app), " ")));
  return fmt::format(R"(# bash completion of leeway, made by `leeway manual bash`.
_leeway_words() {{ mapfile -t COMPREPLY < <(compgen -W "$1" -- "${{COMP_WORDS[COMP_CWORD]}}"); }}
_leeway_files() {{
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -f -- "${{COMP_WORDS[COMP_CWORD]}}")
}}
_leeway() {{
  local verbs={} options= words=
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    _leeway_words "$verbs --help --version"
    return
  fi
  case "${{COMP_WORDS[1]}} ${{COMP_WORDS[COMP_CWORD-1]}}" in
    'help help') _leeway_words "$verbs"; return ;;
{}  esac
  case "${{COMP_WORDS[1]}}" in
{}  esac
  if [[ ${{COMP_WORDS[COMP_CWORD]}} == -* ]]; then
    _leeway_words "$options"
  elif [[ -n $words ]]; then
    _leeway_words "$words"
  else
    _leeway_files
  fi
}}
complete -F _leeway leeway
)",
                     verbs, values, options);
}

std::string zshCompletion(const CLI::App& app) {
  std::string verbs;
  std::string cases;
  for (const CLI::App* verb : app.get_subcommands({})) {
    verbs += fmt::format("    {}\n",
                         shellQuoted(verb->get_name() + ":" + zshText(verb->get_description())));
    cases += fmt::format("    {})\n      _arguments", verb->get_name());
    for (const CLI::Option* option : longOptions(*verb)) {
      const ValueKind kind = valueKind(*option);
      std::string entry = fmt::format("*--{}[{}]", option->get_lnames().front(),
                                      zshText(option->get_description()));
      if (kind.takes_value) {
        entry += fmt::format(":{}:{}", zshText(kind.name), zshAction(kind));
      }
      cases += " \\\n        " + shellQuoted(entry);
    }
    const auto arguments = positionals(*verb);
    if (verb->get_name() == "help") {
      cases +=
          " \\\n        " + shellQuoted(fmt::format("*:verb:({})", fmt::join(verbNames(app), " ")));
    } else if (!arguments.empty()) {
      cases += " \\\n        " +
               shellQuoted(fmt::format("*:{}:{}", zshText(valueKind(*arguments.front()).name),
                                       zshAction(valueKind(*arguments.front()))));
    }
    cases += "\n      ;;\n";
  }
  return fmt::format(R"(#compdef leeway
# zsh completion of leeway, made by `leeway manual zsh`.
_leeway() {{
  local -a verbs
  verbs=(
{}  )
  if ((CURRENT == 2)); then
    _describe verb verbs
    return
  fi
  shift words
  ((CURRENT--))
  case $words[1] in
{}  esac
}}
_leeway "$@"
)",
                     verbs, cases);
}

std::string fishCompletion(const CLI::App& app) {
  std::string script = "# fish completion of leeway, made by `leeway manual fish`.\n";
  for (const CLI::App* verb : app.get_subcommands({})) {
    script += fmt::format("complete -c leeway -f -n __fish_use_subcommand -a {} -d {}\n",
                          verb->get_name(), shellQuoted(verb->get_description()));
  }
  for (const CLI::App* verb : app.get_subcommands({})) {
    const std::string seen =
        fmt::format("complete -c leeway -n '__fish_seen_subcommand_from {}'", verb->get_name());
    if (verb->get_name() == "help") {
      script += fmt::format("{} -f -a '{}'\n", seen, fmt::join(verbNames(app), " "));
    }
    for (const CLI::Option* option : positionals(*verb)) {
      const ValueKind kind = valueKind(*option);
      if (!kind.choices.empty())
        script += fmt::format("{} -f -a '{}'\n", seen, fmt::join(kind.choices, " "));
    }
    for (const CLI::Option* option : longOptions(*verb)) {
      const ValueKind kind = valueKind(*option);
      std::string value;
      if (!kind.choices.empty()) {
        value = fmt::format(" -x -a '{}'", fmt::join(kind.choices, " "));
      } else if (kind.file) {
        value = " -r -F";
      } else if (kind.takes_value) {
        value = " -x";
      }
      script += fmt::format("{} -l {}{} -d {}\n", seen, option->get_lnames().front(), value,
                            shellQuoted(option->get_description()));
    }
  }
  return script;
}

}  // namespace leeway::tools
