#pragma once

namespace leeway::tools {

/// The exit status of the command. Scripts rely on these numbers, so they never change.
enum ExitStatus : int {
  kYes = 0,  ///< solved, valid, certified
  /// No path within the limits, start or goal invalid, not certified; or reading was interrupted or
  /// took too long.
  kNo = 1,
  kBadInput =
      2,  ///< usage, a file that cannot be read or holds nonsense, an output that cannot be written
  kInternal = 70,  ///< our own fault
};

}  // namespace leeway::tools
