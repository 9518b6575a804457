#pragma once

#include <memory>
#include <string>
#include <vector>

#include "leeway/robots/input_error.h"
#include "leeway/robots/kinematics.h"
#include "leeway/robots/model.h"
#include "tests/fuzz/both_ways.h"
#include "tests/fuzz/shapes.h"

namespace leeway::fuzz {

/// Fails unless links and geometries have finite poses at the default configuration, names of links
/// are unique, and groups, states and pairs are of things that the model has.
inline void checkModel(const robots::Model& model) {
  const std::vector<double> q = model.defaultConfiguration();
  std::vector<robots::Pose> X_WL(model.links.size());
  robots::forwardKinematics(model, q, X_WL);
  const auto isFinite = [](const robots::Pose& X) {
    return X.rotation.allFinite() && X.translation.allFinite();
  };
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    const robots::Link& link = model.links[i];
    if (!isFinite(X_WL[i])) fail("link '%s' has no finite pose", link.name.c_str());
    if (model.findLink(link.name) != static_cast<int>(i)) fail("two links '%s'", link.name.c_str());
    for (const robots::Geometry& geometry : link.geometries)
      if (!isFinite(geometry.X_BG))
        fail("a geometry of '%s' has no finite pose", link.name.c_str());
  }
  const auto isIndex = [](int index, std::size_t count) {
    return index >= 0 && static_cast<std::size_t>(index) < count;
  };
  for (const robots::Group& group : model.groups) {
    for (const int v : group.variables)
      if (!isIndex(v, q.size())) fail("group '%s' plans variable %d", group.name.c_str(), v);
    for (const int l : group.links)
      if (!isIndex(l, X_WL.size())) fail("group '%s' has link %d", group.name.c_str(), l);
  }
  for (const robots::GroupState& state : model.group_states)
    for (const auto& [variable, value] : state.values)
      if (!isIndex(variable, q.size()) || !(value - value == 0))
        fail("state '%s' sets variable %d to %g", state.name.c_str(), variable, value);
  for (const robots::DisabledPair& pair : model.disabled_pairs)
    if (pair.link_a < 0 || !isIndex(pair.link_b, X_WL.size()) || pair.link_a >= pair.link_b)
      fail("disabled pair %d %d", pair.link_a, pair.link_b);
}

/// Loads a robot both ways (loadBothWays). Fails unless the result is a model that checkModel()
/// accepts, or an InputError with a message.
inline void checkRobot(const std::string& urdf, const std::string& srdf = "") {
  try {
    checkModel(*loadBothWays([&](robots::InputErrors* errors) {
      robots::LoadOptions options;
      options.errors = errors;
      return robots::loadModel(urdf, srdf, options);
    }));
  } catch (const robots::InputError& error) {
    if (error.what()[0] == '\0') fail("an error without a message");
  }
}

}  // namespace leeway::fuzz
