#include "tools/leeway/support/command_line.h"

#include <execinfo.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "leeway/robots/input_error.h"
#include "leeway/robots/stopped.h"
#include "leeway/robots/text.h"
#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/json_result.h"
#include "tools/leeway/support/terminal.h"

namespace leeway::tools {
namespace {

constexpr const char* kDescription = R"(Plans motions of robots and proves how much room they leave.

  leeway plan problems/shelf/reach.yaml --output path.json
  leeway verify problems/shelf/reach.yaml path.json

Exit status: 0 yes (solved, valid, certified), 1 no, 2 bad usage or input, 70 a fault of this program.)";

/// Returns the verb or option that is nearest to an unexpected word, as a clause; empty if none is
/// near.
std::string suggestion(const CLI::App& app, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::App* verb : app.get_subcommands({})) known.push_back(verb->get_name());
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string* nearest = robots::nearestName(word.substr(0, word.find('=')), known);
  return nearest == nullptr ? "" : fmt::format(" (did you mean {}?)", *nearest);
}

/// Whether a verb, or what was chosen below it (the family of a report), has an option.
bool hasOption(const CLI::App& verb, const std::string& name) {
  const auto chosen = verb.get_subcommands();
  return verb.get_option_no_throw(name) != nullptr ||
         std::any_of(chosen.begin(), chosen.end(),
                     [&](const CLI::App* below) { return hasOption(*below, name); });
}

/// The first unexpected word: a word in the place of the verb that is not a verb, or an option that
/// the verb does not have. Empty if there is neither.
std::string unexpectedWord(const CLI::App* verb, const std::vector<std::string>& words) {
  if (verb == nullptr) return words.empty() ? "" : words.front();
  for (const std::string& word : words) {
    if (word == "--") return {};  // the words behind it are values
    if (word.starts_with("--") && !hasOption(*verb, word.substr(0, word.find('=')))) return word;
  }
  return {};
}

/// What is wrong where --upright has a minus before its axis, which CLI11 takes for an option; else
/// empty.
std::string wrongAxis(const std::vector<std::string>& words) {
  const auto option = std::find(words.begin(), words.end(), "--upright");
  if (words.end() - option < 3) return {};
  const std::string &frame = option[1], &axis = option[2];
  if (axis != "-x" && axis != "-y" && axis != "-z") return {};
  return fmt::format(
      "--upright {} {}: '{}' is no axis; x, y, z, or the opposite nx, ny, nz, is "
      "expected, here n{}",
      frame, axis, axis, axis[1]);
}

/// Prints one line on stderr. With --json, also prints a document with the error as the answer.
void reportError(const std::string& message, bool json, const char* status = "error") {
  printMessage(message);
  if (json) printJson({{"status", status}, {"error", message}});
}

int reportUsage(const CLI::App& app, const CLI::ParseError& error,
                const std::vector<std::string>& words, bool json) {
  // Help and version are answers; CLI11 throws them too.
  if (error.get_exit_code() == 0) {
    return app.exit(error) == 0 ? kYes : kInternal;
  }
  const auto chosen = app.get_subcommands();
  const CLI::App* verb = chosen.empty() ? nullptr : chosen.front();
  const std::string where = verb == nullptr ? "leeway" : "leeway " + verb->get_name();
  std::string what = error.what();
  const std::string word = unexpectedWord(verb, words);
  if (words.empty()) what = "a verb is needed, as plan or check";
  if (const std::string axis = wrongAxis(words); !axis.empty()) what = axis;
  if (!word.empty()) {
    // CLI11 may report what the unknown option has caused: more files than the verb takes.
    what = verb == nullptr ? fmt::format("there is no verb '{}'", word)
                           : fmt::format("there is no option '{}'", word.substr(0, word.find('=')));
    what += suggestion(verb == nullptr ? app : *verb, word);
  }
  reportError(fmt::format("{}: {}; `{} --help` shows what is accepted", where, what, where), json);
  return kBadInput;
}

/// Refuses empty values. A script's unset variable leaves one, and it differs from a missing
/// option.
void refuseEmptyValues(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_type_size() > 0) {
      option->check([](const std::string& text) {
        return text.empty() ? std::string("is empty; a value is expected") : std::string();
      });
    }
  }
  for (CLI::App* verb : app.get_subcommands({})) {
    refuseEmptyValues(*verb);
  }
}

bool hasVerb(const CLI::App& app, const std::string& name) {
  const auto verbs = app.get_subcommands({});
  return std::any_of(verbs.begin(), verbs.end(),
                     [&](const CLI::App* verb) { return verb->get_name() == name; });
}

/// Adds --quiet to every verb.
void addQuiet(CLI::App& app) {
  for (CLI::App* verb : app.get_subcommands({})) {
    verb->add_flag_callback("--quiet", setQuiet,
                            "print only errors on stderr, no warnings or progress");
    addQuiet(*verb);
  }
}

/// Turns `help`, `help VERB` and `help report VERB` into `VERB --help`.
std::vector<std::string> wordsOf(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (!words.empty() && words.front() == kHelp) {
    std::rotate(words.begin(), words.begin() + 1, words.end());
    words.back() = "--help";
  }
  return words;
}

/// Help that fits the terminal.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    return wrappedHelp(CLI::Formatter::make_help(app, std::move(name), mode));
  }
  /// "[files...]", where CLI11 has "[files(0x)]".
  std::string make_option_usage(const CLI::Option* option) const override {
    if (option->get_expected_max() < 2) return CLI::Formatter::make_option_usage(option);
    const std::string name = make_option_name(option, true) + "...";
    return option->get_required() ? name : "[" + name + "]";
  }
};

using AddVerbs = std::function<std::vector<Verb>(CLI::App&)>;

int run(std::vector<std::string> words, bool json, const AddVerbs& add_verbs) {
  CLI::App app(kDescription, "leeway");
  app.formatter(std::make_shared<HelpFormatter>());  // verbs inherit it
  app.set_version_flag("--version", std::string("leeway ") + LEEWAY_VERSION);
  app.require_subcommand(1);
  const std::vector<Verb> verbs = add_verbs(app);
  CLI::App* help = app.add_subcommand(kHelp, "show the options of a verb, as `leeway VERB --help`");
  help->add_option("verb", "whose help")->type_name("VERB");
  help->footer("Example:\n  leeway help plan");
  refuseEmptyValues(app);
  addQuiet(app);
  try {
    // CLI11 would show the command's own help.
    if (words.size() > 1 && words.back() == "--help" && !words.front().starts_with("-") &&
        !hasVerb(app, words.front()))
      throw CLI::ExtrasError({words.front()});
    // CLI11 takes the words from the end.
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& error) {
    return reportUsage(app, error, words, json);
  }
  for (const Verb& verb : verbs) {
    if (verb.app->parsed()) {
      return verb.run();
    }
  }
  return kInternal;
}

/// Ends the program with a message and a status where no handler is left, such as in a destructor
/// or in a thread of a library. Does not allocate.
[[noreturn]] void onTerminate() {
  constexpr std::string_view kMessage =
      "leeway: a fault of this program, for which memory may lack\n";
  static_cast<void>(!::write(STDERR_FILENO, kMessage.data(), kMessage.size()));
  std::_Exit(kInternal);
}

int runGuarded(int argc, char** argv, const AddVerbs& add_verbs) {
  const std::vector<std::string> words = wordsOf(argc, argv);
  const bool json = std::find(words.begin(), words.end(), "--json") != words.end();
  const auto fault = [json](const std::string& message) {
    if (std::ferror(stdout) != 0) {
      return kYes;  // fmt throws where stdout takes no more; answerIsWritten() reports it
    }
    reportError("leeway: a fault of this program" + message, json);
    return kInternal;
  };
  try {
    return run(words, json, add_verbs);
  } catch (const robots::InputError& error) {
    reportError(error.what(), json);
    return kBadInput;
  } catch (const robots::Stopped& stopped) {
    const bool is_late = !interrupted();
    reportError(
        fmt::format("{}{}; nothing was done", stopped.what(), is_late ? "" : ": interrupted"), json,
        is_late ? "not_compiled" : "error");
    return kNo;
  } catch (const std::filesystem::filesystem_error& error) {
    reportError(fmt::format("{}: cannot be read: {}; a path that can be followed is expected",
                            error.path1().string(), error.code().message()),
                json);
    return kBadInput;
  } catch (const std::bad_alloc&) {
    // A longer message would need memory and fail again.
    std::fputs("leeway: out of memory\n", stderr);
    return kInternal;
  } catch (const std::exception& error) {
    return fault(std::string(": ") + error.what());
  } catch (...) {
    return fault("");
  }
}

/// Whether the whole answer was written; otherwise its status does not count. A full disk may be
/// reported only when the buffers are flushed.
bool answerIsWritten() {
  const bool failed_before = std::ferror(stdout) != 0;
  if (std::fflush(stdout) == 0 && !failed_before) {
    return true;
  }
  printMessage(fmt::format("standard output: cannot be written: {}; a writable place is expected",
                           std::strerror(errno)));
  return false;
}

}  // namespace

int runCommandLine(int argc, char** argv, const AddVerbs& add_verbs) {
  // glibc loads its unwinder when an exception first leaves one of its own frames, such as those of
  // std::call_once. If memory has run out by then, it ends the process. So load it now.
  void* frame = nullptr;
  static_cast<void>(::backtrace(&frame, 1));
  std::set_terminate(onTerminate);
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit cannot be written
  const int status = runGuarded(argc, argv, add_verbs);
  return answerIsWritten() || status >= kBadInput ? status : kBadInput;
}

}  // namespace leeway::tools
