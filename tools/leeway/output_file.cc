#include "tools/leeway/output_file.h"

#include "leeway/planner/path_io.h"

namespace leeway::tools {

void writeWhole(const std::string& path, std::string_view text) {
  planner::writeFileWhole(path, std::string(text));
}

}  // namespace leeway::tools
