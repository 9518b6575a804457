#pragma once

namespace leeway::tools {

/// What the command tells its caller. Fixed: scripts rely on it.
enum ExitStatus : int {
  kYes = 0,  ///< solved, valid, certified
  kNo = 1,   ///< no path within the limits, start or goal invalid, not certified
  kBadInput =
      2,  ///< usage, a file that cannot be read or holds nonsense, an output that cannot be written
  kInternal = 70,  ///< our own fault
};

}  // namespace leeway::tools
