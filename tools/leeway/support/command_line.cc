#include "tools/leeway/support/command_line.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

#include "leeway/robots/input_error.h"
#include "tools/leeway/support/exit_status.h"

namespace leeway::tools {
namespace {

constexpr const char* kDescription = R"(Plans motions of robots and proves how much room they leave.

Exit status: 0 yes (solved, valid, certified), 1 no, 2 bad usage or input, 70 a fault of this program.)";

int reportUsage(const CLI::App& app, const CLI::ParseError& error) {
  // Help and version are answers; CLI11 throws them too.
  if (error.get_exit_code() == 0) {
    return app.exit(error) == 0 ? kYes : kInternal;
  }
  std::string where = "leeway";
  const auto chosen = app.get_subcommands();
  if (!chosen.empty()) {
    where += " " + chosen.front()->get_name();
  }
  fmt::print(stderr, "{}: {}; `{} --help` shows what is accepted\n", where, error.what(), where);
  return kBadInput;
}

/// An empty value, as a script's variable that was never set leaves it, is not an option left out.
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

using AddVerbs = std::function<std::vector<Verb>(CLI::App&)>;

int run(int argc, char** argv, const AddVerbs& add_verbs) {
  CLI::App app(kDescription, "leeway");
  app.set_version_flag("--version", std::string("leeway ") + LEEWAY_VERSION);
  app.require_subcommand(1);
  const std::vector<Verb> verbs = add_verbs(app);
  refuseEmptyValues(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return reportUsage(app, error);
  }
  for (const Verb& verb : verbs) {
    if (verb.app->parsed()) {
      return verb.run();
    }
  }
  return kInternal;
}

int runGuarded(int argc, char** argv, const AddVerbs& add_verbs) {
  try {
    return run(argc, argv, add_verbs);
  } catch (const robots::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return kBadInput;
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) {
      return kYes;  // fmt throws where stdout takes no more; answerIsWritten() reports it
    }
    fmt::print(stderr, "leeway: a fault of this program: {}\n", error.what());
    return kInternal;
  } catch (...) {
    fmt::print(stderr, "leeway: a fault of this program\n");
    return kInternal;
  }
}

/// An answer that could not be written is none, whatever it said. A full disk may show only when
/// the buffers are emptied.
bool answerIsWritten() {
  const bool failed_before = std::ferror(stdout) != 0;
  if (std::fflush(stdout) == 0 && !failed_before) {
    return true;
  }
  fmt::print(stderr, "standard output: cannot be written: {}; a writable place is expected\n",
             std::strerror(errno));
  return false;
}

}  // namespace

int runCommandLine(int argc, char** argv, const AddVerbs& add_verbs) {
  const int status = runGuarded(argc, argv, add_verbs);
  return answerIsWritten() || status >= kBadInput ? status : kBadInput;
}

}  // namespace leeway::tools
