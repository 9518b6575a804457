#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tools/lab/base/engine.h"
#include "tools/lab/base/ik_engine.h"
#include "tools/lab/base/mesh_engine.h"
#include "tools/lab/base/motion_engine.h"
#include "tools/lab/base/state_engine.h"

namespace leeway::tools::report {

/// The engines that one library's module provides.
struct Rivals {
  std::vector<std::unique_ptr<PairEngine>> pairs;       ///< for `report accuracy`
  std::vector<std::unique_ptr<MeshEngine>> meshes;      ///< for `report deform`
  std::vector<std::unique_ptr<ContactEngine>> motions;  ///< for `report motion`
  std::vector<std::unique_ptr<IkEngine>> kinematics;    ///< for `report ik`
  std::vector<std::unique_ptr<StateEngine>> states;     ///< for `report planning`, growth, sensed
};

/// Each rival is a module loaded at run time, so that no other target links its library. A module
/// exports one function of this name and type.
using MakeRivals = Rivals* (*)();
inline constexpr const char* kMakeRivals = "leewayMakeRivals5";

/// A module, and the reason if it is missing.
struct RivalModule {
  std::string library;             ///< "FCL", "Bullet", ...
  std::string problem;             ///< why it could not be loaded; empty if it was loaded
  std::unique_ptr<Rivals> rivals;  ///< null if there is a problem
};

/// ../lib/leeway relative to the running program's folder: the modules, and the script that draws.
std::filesystem::path moduleFolder();

/// Loads all known modules from moduleFolder(). Sets `problem` if a module or its library is
/// missing. Modules stay loaded until the process ends.
std::vector<RivalModule> loadRivals();

}  // namespace leeway::tools::report
