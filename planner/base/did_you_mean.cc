#include "planner/base/did_you_mean.h"

#include "leeway/robots/text.h"

namespace leeway::planner {

std::string didYouMean(std::string_view name, const std::vector<std::string>& known) {
  if (known.empty()) return "; there is none";
  if (const std::string* nearest = robots::nearestName(name, known))
    return "; did you mean '" + *nearest + "'?";
  std::string list = "; known: ";
  for (std::size_t i = 0; i < known.size() && i < 12; ++i) list += (i > 0 ? ", " : "") + known[i];
  return known.size() > 12 ? list + ", ..." : list;
}

std::string didYouMean(const robots::RobotDescription& robot, std::string_view kind,
                       std::string_view name, const std::vector<std::string>& known) {
  const std::string why = robot.whyLeftOut(kind, name);
  return why.empty() ? didYouMean(name, known) : why;
}

}  // namespace leeway::planner
