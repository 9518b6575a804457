#include "tests/support/build_paths.h"

#include <cstdlib>

namespace leeway {

std::string sourceFolder() { return LEEWAY_SOURCE_DIR; }

std::string dataFolder() {
  const char* chosen = std::getenv("LEEWAY_DATA");
  return chosen != nullptr ? chosen : sourceFolder() + "/../shared/data";
}
std::string commandFile() { return LEEWAY_COMMAND; }

}  // namespace leeway
