#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>

namespace leeway::bench {

/// Parses the options and calls `run`. Returns its exit status; 2, with a message on stderr, if it
/// throws or if an option is wrong.
template <class Run>
int runProgram(const char* name, CLI::App& app, int argc, char** argv, const Run& run) {
  try {
    app.parse(argc, argv);
    return run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 2;
  }
}

}  // namespace leeway::bench
