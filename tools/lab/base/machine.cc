#include "tools/lab/base/machine.h"

#include <sched.h>

#include <fstream>

namespace leeway::tools::report {

std::string machineName() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const std::size_t colon = line.find(':');
    if (colon != std::string::npos && colon + 2 < line.size()) return line.substr(colon + 2);
  }
  return "unknown processor";
}

int pinToOneProcessor() {
  const int processor = sched_getcpu();
  if (processor < 0) return -1;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(processor), &set);
  return sched_setaffinity(0, sizeof set, &set) == 0 ? processor : -1;
}

}  // namespace leeway::tools::report
