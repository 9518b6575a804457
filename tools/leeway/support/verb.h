#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace leeway::tools {

/// A verb of the command: its arguments, declared on `app`, and the function that runs it.
struct Verb {
  CLI::App* app = nullptr;
  std::function<int()> run;  ///< returns an ExitStatus; throws robots::InputError for bad input
};

// Each has its own file with the verb's name.
Verb addPlan(CLI::App& command);
Verb addCheck(CLI::App& command);
Verb addVerify(CLI::App& command);
Verb addClearance(CLI::App& command);
Verb addReplan(CLI::App& command);
Verb addGuard(CLI::App& command);
Verb addBatch(CLI::App& command);
Verb addInfo(CLI::App& command);
Verb addIk(CLI::App& command);
Verb addFk(CLI::App& command);
Verb addView(CLI::App& command);
Verb addLint(CLI::App& command);
Verb addSrdf(CLI::App& command);
Verb addManual(CLI::App& command);

}  // namespace leeway::tools
