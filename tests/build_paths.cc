#include "tests/build_paths.h"

namespace leeway {

std::string sourceFolder() { return LEEWAY_SOURCE_DIR; }

std::string commandFile() { return LEEWAY_COMMAND; }

}  // namespace leeway
