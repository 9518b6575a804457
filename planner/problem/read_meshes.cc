#include "planner/problem/read_meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "planner/base/did_you_mean.h"
#include "planner/validate/checks.h"
#include "planner/validate/format_keys.h"
#include "robots/mesh/mesh_treatment.h"

namespace leeway::planner {
namespace {

using robots::MeshTreatment;

MeshTreatment readTreatment(const YamlReader& entry) {
  entry.expectKeys(keysOf("mesh_treatment"));
  MeshTreatment treatment;
  if (const auto solid = entry.find("solid")) {
    const std::string word = solid->text();
    if (word == "hull")
      treatment.solid = MeshTreatment::Solid::kHull;
    else if (word == "surface")
      treatment.solid = MeshTreatment::Solid::kSurface;
    else if (word != "auto")
      solid->fail(
          fmt::format("{} is '{}'; auto, hull or surface is expected", solid->where(), word));
  }
  if (const auto weld = entry.find("weld")) {
    treatment.weld = weld->sizeNumber();
    if (treatment.solid != MeshTreatment::Solid::kAuto)
      weld->fail(fmt::format("{} stands beside solid: {}; it goes with auto only", weld->where(),
                             entry.find("solid")->text()));
  }
  return treatment;
}

/// The names of links and objects with meshes.
std::vector<std::string> ownersOfMeshes(const Problem& problem) {
  std::vector<std::string> owners;
  const auto add = [&](const std::string& owner, const std::vector<robots::Geometry>& of) {
    if (std::any_of(of.begin(), of.end(),
                    [](const robots::Geometry& g) { return g.shape.mesh() != nullptr; }))
      owners.push_back(owner);
  };
  for (const robots::Link& link : problem.robot.model->links) add(link.name, link.geometries);
  for (const Object& object : problem.world.objects) add(object.name, object.geometries);
  for (const Attachment& held : problem.robot.attachments)
    add(held.object.name, held.object.geometries);
  for (const DeformingObstacle& o : problem.world.deforming) owners.push_back(o.object.name);
  return owners;
}

std::string unknownMesh(const std::string& name, const Problem& problem) {
  return fmt::format("no link, object or file with a mesh is named '{}'{}", name,
                     didYouMean(name, ownersOfMeshes(problem)));
}

}  // namespace

void readMeshes(const YamlReader& meshes, robots::LoadOptions& load) {
  meshes.eachEntry([&](const std::string& name, const YamlReader& entry) {
    load.meshes[name] = readTreatment(entry);
  });
}

void expectMeshesFound(const YamlReader& meshes, const std::set<std::string>& found,
                       const Problem& problem) {
  meshes.eachEntry([&](const std::string& name, const YamlReader& entry) {
    if (found.count(name) == 0) entry.fail(unknownMesh(name, problem));
  });
}

void expectMeshesFound(const robots::LoadOptions& load, const std::set<std::string>& found,
                       const std::string& file, const Problem& problem) {
  const robots::Model& model = *problem.robot.model;
  for (const auto& [name, treatment] : load.meshes) {
    const int link = model.findLink(name);
    if (found.count(name) == 0 &&
        (link < 0 || model.links[static_cast<std::size_t>(link)].geometries.empty()))
      throw robots::InputError(file, 0, "meshes: " + unknownMesh(name, problem));
  }
}

void warnOfOpenMeshes(const std::string& file, Problem& problem) {
  if (const std::string text = openMeshes(problem, false); !text.empty())
    problem.warnings.push_back(file + ": " + text);
}

}  // namespace leeway::planner
