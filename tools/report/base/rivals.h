#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/report/base/engine.h"
#include "tools/report/base/mesh_engine.h"
#include "tools/report/base/motion_engine.h"

namespace leeway::tools::report {

/// What the module of one library brings to the reports.
struct Rivals {
  std::vector<std::unique_ptr<PairEngine>> pairs;       ///< for `report accuracy`
  std::vector<std::unique_ptr<MeshEngine>> meshes;      ///< for `report deform`
  std::vector<std::unique_ptr<ContactEngine>> motions;  ///< for `report motion`
};

/// Rivals live in modules of their own, loaded when a report asks for them: the command neither
/// links nor needs their libraries. Each module exports one function of this name and type.
using MakeRivals = Rivals* (*)();
inline constexpr const char* kMakeRivals = "leewayMakeRivals3";

/// A module, its library and what became of it.
struct RivalModule {
  std::string library;             ///< "FCL", "Bullet", ...
  std::string problem;             ///< why it is not there; empty: it is
  std::unique_ptr<Rivals> rivals;  ///< null when there is a problem
};

/// Loads all modules that this version knows, from ../lib/leeway beside the folder of the running
/// program. A module that is not there, or whose library is not installed, is told in `problem`.
/// What is loaded stays until the process ends.
std::vector<RivalModule> loadRivals();

}  // namespace leeway::tools::report
