#pragma once

// Private to robots/sdf: the tree of models.

#include <string>
#include <vector>

#include "robots/sdf/sdf_frames.h"

namespace leeway::robots {

/// The one model of an SDF, with the models in it.
struct SdfModels {
  std::string name;
  SdfFrames frames;
  std::vector<int> links, joints;  ///< frames, in the order of the file
};

/// Reads names and poses. References between them are not followed yet. Throws InputError.
SdfModels readModels(SdfFiles& files);

}  // namespace leeway::robots
