// Warnings about a problem, whether it was loaded or made by a program.

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "planner/validate/checks.h"
#include "robots/mesh/mesh_treatment.h"

namespace leeway::planner {

namespace {

constexpr std::string_view kNotClosed = "not closed: ";

/// Whether a warning about meshes that are not closed names this owner of one.
bool namesOpen(const std::string& warning, const std::string& owner) {
  return warning.find(kNotClosed) != std::string::npos &&
         (warning.find(": " + owner + " (") != std::string::npos ||
          warning.find(", " + owner + " (") != std::string::npos);
}

/// Returns the warning about the meshes that are not closed and whose owners count; empty: none.
template <typename Counts>
std::string openOf(const Problem& problem, const Counts& counts, bool of_program) {
  robots::OpenMeshes open;
  const auto add = [&](const std::string& owner, const std::vector<robots::Geometry>& of) {
    if (counts(owner)) open.add(owner, of);
  };
  for (const robots::Link& link : problem.robot.model->links) add(link.name, link.geometries);
  for (const Object& object : problem.world.objects) add(object.name, object.geometries);
  for (const Attachment& held : problem.robot.attachments)
    add(held.object.name, held.object.geometries);
  for (const DeformingObstacle& o : problem.world.deforming)
    add(o.object.name, o.object.geometries);
  return open.text(of_program);
}

}  // namespace

std::string openMeshes(const Problem& problem, bool of_program) {
  const auto isNew = [&](const std::string& owner) {
    const auto namesIt = [&](const std::string& warning) { return namesOpen(warning, owner); };
    const std::vector<std::string>& of_robot = problem.robot.model->warnings;
    return std::none_of(of_robot.begin(), of_robot.end(), namesIt) &&
           std::none_of(problem.warnings.begin(), problem.warnings.end(), namesIt);
  };
  return openOf(problem, isNew, of_program);
}

std::vector<std::string> problemWarnings(const Problem& problem) {
  std::vector<std::string> warnings = problem.robot.model->warnings;
  for (const std::string& warning : problem.warnings) {
    // A loader's may name what has left the world since.
    const std::size_t at =
        std::min(warning.find("a mesh is not closed: "), warning.find("meshes are not closed: "));
    const auto isNamed = [&](const std::string& owner) { return namesOpen(warning, owner); };
    const std::string now = at < warning.size() ? openOf(problem, isNamed, false) : std::string();
    if (at >= warning.size())
      warnings.push_back(warning);
    else if (!now.empty())
      warnings.push_back(warning.substr(0, at) + now);
  }
  for (std::size_t v = 0; v < problem.start.size(); ++v) {
    const auto off = passiveWarning(problem, static_cast<int>(v));
    const auto is_it = [&](const std::string& w) { return w.ends_with(*off); };  // with its line
    if (off && std::none_of(warnings.begin(), warnings.end(), is_it))
      warnings.push_back("start has " + *off);
  }
  if (std::string open = openMeshes(problem, true); !open.empty())
    warnings.push_back(std::move(open));
  return warnings;
}

}  // namespace leeway::planner
