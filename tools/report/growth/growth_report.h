#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/report/base/plot.h"
#include "tools/report/base/state_engine.h"

namespace leeway::tools::report {

struct GrowthRow;

struct GrowthReportOptions {
  std::map<std::string, std::vector<std::int64_t>> counts;  ///< by family, ascending
  std::uint64_t seed = 1;
  int edges = 200;   ///< that planning asks for, at most
  int rounds = 5;    ///< over the edges, of which the median counts
  double time = 30;  ///< limit of one plan [s]
  std::function<void(const std::string&)> progress;
  /// Called with the rows of each problem when they are there.
  std::function<void(const std::vector<GrowthRow>&)> on_rows;
};

/// One engine in one world.
struct GrowthRow {
  std::string family;
  std::int64_t count = 0;
  std::string engine;
  std::string status = {};  ///< ours as toString(PlanStatus); a rival's "measured" or "left out"
  /// From the world in memory to what answers: of meshes with all that they keep. Wall clock [s].
  double make_s = 0;
  /// Of boxes, ours: one moves, to what answers in that world. Median of the rounds. Wall clock
  /// [s].
  double change_s = 0;
  double bytes = 0;  ///< that it takes on the heap; 0 where the C library does not tell
  /// Of the edges that planning asks for in the first world of the family (of joints, in each), one
  /// in the mean [us]: ours certified, a rival's in steps of 1/32 rad. CPU time.
  int edges = 0;
  double edge_us = 0;
  double plan_s = 0;  ///< ours: plan, simplify, push and certify. Wall clock [s]
};

/// Ours and, over the same worlds, the rivals' scenes.
std::vector<GrowthRow> measureGrowth(const std::vector<const StateEngine*>& rivals,
                                     const GrowthReportOptions& options);

std::string growthCsv(const std::vector<GrowthRow>& rows);
std::string growthTable(const std::vector<GrowthRow>& rows);
/// A row of panels for each family: making, memory, an edge, planning.
Figure growthFigure(const std::vector<GrowthRow>& rows, const std::string& note);

}  // namespace leeway::tools::report
