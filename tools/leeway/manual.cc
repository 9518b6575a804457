#include "tools/leeway/manual/manual.h"

#include <fmt/format.h>

#include <memory>

#include "tools/leeway/support/exit_status.h"
#include "tools/leeway/support/verb.h"

namespace leeway::tools {
namespace {

int runManual(const CLI::App& command, const std::string& form) {
  if (form == "man") {
    fmt::print("{}", manPage(command, LEEWAY_VERSION));
  } else if (form == "bash") {
    fmt::print("{}", bashCompletion(command));
  } else if (form == "zsh") {
    fmt::print("{}", zshCompletion(command));
  } else {
    fmt::print("{}", fishCompletion(command));
  }
  return kYes;
}

}  // namespace

Verb addManual(CLI::App& command) {
  auto form = std::make_shared<std::string>();
  CLI::App* app =
      command.add_subcommand("manual", "the man page, or the completion of a shell, on stdout");
  app->add_option("form", *form, "man page, or completion script")
      ->check(CLI::IsMember({"man", "bash", "zsh", "fish"}))
      ->required();
  app->footer(
      "`cmake --install` puts all of them where they are looked for.\n\n"
      "Example:\n"
      "  leeway manual bash");
  return {app, [form, &command] { return runManual(command, *form); }};
}

}  // namespace leeway::tools
