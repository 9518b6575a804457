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

/// Each rival is a module that a report loads at run time, so that nothing else links or needs its
/// library. A module exports one function of this name and type.
using MakeRivals = Rivals* (*)();
inline constexpr const char* kMakeRivals = "leewayMakeRivals3";

/// A module and whether it could be loaded.
struct RivalModule {
  std::string library;             ///< "FCL", "Bullet", ...
  std::string problem;             ///< why it is not there; empty: it is
  std::unique_ptr<Rivals> rivals;  ///< null when there is a problem
};

/// Loads every known module from ../lib/leeway, seen from the folder of the running program. Sets
/// `problem` where a module or its library is missing. Modules stay loaded until the process ends.
std::vector<RivalModule> loadRivals();

}  // namespace leeway::tools::report
