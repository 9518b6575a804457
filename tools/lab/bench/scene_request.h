#pragma once

#include <stdexcept>
#include <string>

namespace leeway::bench {

/// The MoveIt request for a scene: for .../sceneNNNN.yaml, .../requestNNNN.yaml. Throws
/// std::runtime_error for other names.
inline std::string requestOf(std::string scene) {
  const std::size_t at = scene.rfind("scene");
  if (at == std::string::npos)
    throw std::runtime_error(scene + ": a file named sceneNNNN.yaml is expected");
  return scene.replace(at, 5, "request");
}

}  // namespace leeway::bench
